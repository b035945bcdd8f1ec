#pragma once
// Shadow rays of eight surface points.

#include "bake_cpu/sample/path_tracer.h"

namespace halflight {

/// PathTracer::lightVisibility() for one light and point in each lane.
class ShadowPacket {
public:
    explicit ShadowPacket(const PathTracer& paths) : paths_(paths) { embree::clear(packet_); }

    void add(int lane, const PunctualLight& light, const SurfacePoint& point, vec2 disc, uint64_t& rays)
    {
        if (!paths_.shadowsFall(light, point)) return;
        const PathTracer::ShadowRay ray = paths_.shadowRay(light, point, disc, rays);
        embree::setRay(packet_, lane, ray.origin, ray.direction);
        packet_.tnear[lane] = ray.tMin;
        packet_.tfar[lane] = ray.tMax;
        valid_.lane[lane] = -1;
        any_ = true;
    }
    /// Transmittance of each lane; 1 for lanes without a ray.
    std::array<float, embree::kPacket> trace()
    {
        std::array<float, embree::kPacket> result;
        result.fill(1.0f);
        if (!any_) return result;
        const std::array<float, embree::kPacket> transmittance = paths_.surfaces().transmittance(valid_, packet_);
        for (std::size_t lane = 0; lane < result.size(); ++lane) {
            if (valid_.lane[lane] != 0) result[lane] = transmittance[lane];
        }
        return result;
    }

private:
    const PathTracer& paths_;
    RTCRay8 packet_;
    alignas(32) embree::LaneMask valid_{};
    bool any_ = false;
};

} // namespace halflight
