#pragma once
// Single rays against the scene, and the surface at a hit.

#include "transport/trace/ray_kernels.h"

namespace halflight {

/// The surface at a hit. Hidden backs (Materials::backIsHidden()) reflect like fronts and emit nothing.
struct SurfaceHit {
    float distance = 0.0f;
    const TransportMaterial* material = nullptr;
    SurfacePoint point; ///< normals face the ray's origin
    SurfaceReflectance reflectance;
    vec3 emission{0.0f};
};

/// A scene with the kernels that trace rays against it. Immutable after construction; all queries are thread-safe.
class RayTracer : public RayScene {
public:
    /// `geometry` and `scene` outlive the tracer.
    RayTracer(const Scene& scene, const BakeGeometry& geometry, const MakeKernels& makeKernels)
        : RayScene(scene, geometry), kernels_(makeKernels(*this))
    {}

    /// False where the kernels could not be made: no other function may be called then.
    [[nodiscard]] bool ok() const { return kernels_ != nullptr; }
    [[nodiscard]] const RayKernels& kernels() const { return *kernels_; }

    /// RayKernels' verbs for one ray.
    [[nodiscard]] RayHit nearest(vec3 origin, vec3 direction, float tMin, float tMax, RayUse use = RayUse::Light) const
    {
        const Ray ray{origin, tMin, direction, tMax};
        RayHit hit;
        kernels_->nearest({&ray, 1}, {&hit, 1}, use);
        return hit;
    }
    [[nodiscard]] bool occluded(vec3 origin, vec3 direction, float tMin, float tMax) const
    {
        const Ray ray{origin, tMin, direction, tMax};
        bool hit = false;
        kernels_->occluded({&ray, 1}, {&hit, 1});
        return hit;
    }
    [[nodiscard]] float transmittance(vec3 origin, vec3 direction, float tMin, float tMax) const
    {
        const Ray ray{origin, tMin, direction, tMax};
        float share = 1.0f;
        kernels_->transmittance({&ray, 1}, {&share, 1});
        return share;
    }

    /// `at.found()` is true.
    [[nodiscard]] SurfaceHit surfaceAt(const RayHit& at) const;
    [[nodiscard]] bool isHiddenBack(FaceId face) const
    {
        return face.back != 0 && materials().backIsHidden(triangleAt(face.hitIndex));
    }
    [[nodiscard]] bool hitHiddenBack(const RayHit& at) const { return at.found() && isHiddenBack(at.face); }

    /// Most bytes so far of the kernels' trees and of the scene's lists.
    [[nodiscard]] std::size_t peakBytes() const { return kernels_->peakBytes() + byteCount(); }

private:
    std::unique_ptr<RayKernels> kernels_;
};

} // namespace halflight
