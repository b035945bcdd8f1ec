#include "transport/trace/ray_tracer.h"

#include "transport/trace/device_paths.h"

namespace halflight {

void RayTracer::keep(const Error& error) const
{
    const std::lock_guard lock(mutex_);
    if (failed()) return;
    error_ = error;
    failed_ = true;
}

Status RayTracer::outcome(bool finished) const
{
    if (!failed()) return finished ? Status() : cancelledError();
    const std::lock_guard lock(mutex_);
    return error_;
}

SurfaceHit RayTracer::surfaceAt(const RayHit& at) const
{
    const uint32_t triangle = triangleAt(at.face.hitIndex);
    SurfaceHit hit{at.distance, &materials().of(triangle), surfacePoint(geometry(), triangle, at.barycentric)};
    const bool back = at.face.back != 0;
    if (back) {
        hit.point.normal = -hit.point.normal;
        hit.point.geometricNormal = -hit.point.geometricNormal;
    }
    hit.reflectance = materials().reflectanceAt(triangle, at.barycentric);
    if (!back || !materials().backIsHidden(triangle)) hit.emission = materials().emissionAt(triangle, at.barycentric);
    return hit;
}

/// Kernels without a device.
Result<std::unique_ptr<DevicePaths>> RayKernels::preparePaths(const PathTracer& /*paths*/, int /*bounces*/) const
{
    return std::unique_ptr<DevicePaths>();
}

} // namespace halflight
