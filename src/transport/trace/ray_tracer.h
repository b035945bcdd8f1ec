#pragma once
// Rays against the scene, the surface at a hit, and the error of a lost device.

#include "transport/trace/ray_kernels.h"

#include <algorithm>
#include <atomic>
#include <mutex>

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

    /// RayKernels' verbs, for code that goes on without their error: rays of a lost device meet nothing, and outcome()
    /// says so at the end.
    void nearest(std::span<const Ray> rays, std::span<RayHit> out, RayUse use = RayUse::Light) const
    {
        if (Status status = kernels_->nearest(rays, out, use); !status) fail(status.error(), out, RayHit{});
    }
    void occluded(std::span<const Ray> rays, std::span<bool> out) const
    {
        if (Status status = kernels_->occluded(rays, out); !status) fail(status.error(), out, false);
    }
    void transmittance(std::span<const Ray> rays, std::span<vec3> out) const
    {
        if (Status status = kernels_->transmittance(rays, out); !status) fail(status.error(), out, vec3(1.0f));
    }
    void crossings(std::span<const Ray> rays, std::span<int> out) const
    {
        if (Status status = kernels_->crossings(rays, out); !status) fail(status.error(), out, 0);
    }

    /// The same for one ray.
    [[nodiscard]] RayHit nearest(vec3 origin, vec3 direction, float tMin, float tMax, RayUse use = RayUse::Light) const
    {
        const Ray ray{origin, tMin, direction, tMax};
        RayHit hit;
        nearest({&ray, 1}, {&hit, 1}, use);
        return hit;
    }
    [[nodiscard]] bool occluded(vec3 origin, vec3 direction, float tMin, float tMax) const
    {
        const Ray ray{origin, tMin, direction, tMax};
        bool hit = false;
        occluded({&ray, 1}, {&hit, 1});
        return hit;
    }
    [[nodiscard]] vec3 transmittance(vec3 origin, vec3 direction, float tMin, float tMax) const
    {
        const Ray ray{origin, tMin, direction, tMax};
        vec3 share(1.0f);
        transmittance({&ray, 1}, {&share, 1});
        return share;
    }

    /// For what a device does besides these verbs: its rays meet nothing from then on, and outcome() says why. The
    /// first error is kept.
    void keep(const Error& error) const;
    /// Whether the device is lost: then no result counts.
    [[nodiscard]] bool failed() const { return failed_.load(std::memory_order_relaxed); }
    /// What a loop over rays returns: the error of a lost device, whichever thread met it first; else whether it was
    /// `finished` or cancelled.
    [[nodiscard]] Status outcome(bool finished) const;

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
    template<typename Out> void fail(const Error& error, std::span<Out> out, Out nothing) const
    {
        std::fill(out.begin(), out.end(), nothing);
        keep(error);
    }

    std::unique_ptr<RayKernels> kernels_;
    mutable std::mutex mutex_; ///< guards error_
    mutable Error error_;
    mutable std::atomic<bool> failed_ = false; ///< set after error_
};

} // namespace halflight
