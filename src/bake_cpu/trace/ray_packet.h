#pragma once
// Access to the lanes of Embree's packets of eight rays.

#include "bake_cpu/trace/embree.h"
#include "transport/trace/ray.h"

#include <span>

namespace halflight::embree {

/// Fills a packet with up to eight rays. The lanes of rays that meet nothing, and those without a ray, are not traced.
inline LaneMask fill(RTCRay8& packet, std::span<const Ray> rays)
{
    LaneMask valid{};
    for (std::size_t i = 0; i < kPacket; ++i) {
        const Ray& ray = rays[i < rays.size() ? i : 0];
        packet.org_x[i] = ray.origin.x;
        packet.org_y[i] = ray.origin.y;
        packet.org_z[i] = ray.origin.z;
        packet.dir_x[i] = ray.direction.x;
        packet.dir_y[i] = ray.direction.y;
        packet.dir_z[i] = ray.direction.z;
        packet.tnear[i] = ray.tMin;
        packet.tfar[i] = ray.tMax;
        packet.time[i] = 0.0f;
        packet.mask[i] = ~0u;
        packet.id[i] = 0u;
        packet.flags[i] = 0u;
        valid.lane[i] = i < rays.size() && !ray.meetsNothing() ? -1 : 0;
    }
    return valid;
}

} // namespace halflight::embree
