#pragma once
// Shadow rays of eight surface points.

#include "transport/sample/path_tracer.h"
#include "transport/trace/lanes.h"

namespace halflight {

/// DirectLight::lightVisibility() for one light and point in each lane.
class ShadowPacket {
public:
    explicit ShadowPacket(const PathTracer& paths) : paths_(paths) {}

    void add(int lane, const PunctualLight& light, const SurfacePoint& point, vec2 disc, uint64_t& rays)
    {
        if (!paths_.direct().shadowsFall(light, point)) return;
        rays_[std::size_t(lane)] = paths_.direct().shadowRay(light, point, disc, rays);
        any_ = true;
    }
    /// Transmittance of each lane; 1 for lanes without a ray.
    std::array<vec3, kLanes> trace()
    {
        std::array<vec3, kLanes> result;
        result.fill(vec3(1.0f));
        if (any_) paths_.surfaces().transmittance(rays_, result);
        return result;
    }

private:
    const PathTracer& paths_;
    std::array<Ray, kLanes> rays_;
    bool any_ = false;
};

} // namespace halflight
