#pragma once
// Rays towards punctual lights, in bundles: for shadowmasks and for direct light that is baked.

#include "bake_cpu/texel_group.h"

#include <array>

namespace halflight {

/// Samples come in halves of eight: the first half's points are spread over the texel, the second half's lie between
/// them, later ones use the same points with other points of the light.
class ShadowRays {
public:
    static constexpr int kHalf = 8;

    ShadowRays(const PathTracer& paths, const GatherPattern& pattern, uint32_t seed)
        : paths_(paths), pattern_(pattern), seed_(seed)
    {}

    /// Halves that `samples` rays for each texel come to. A light without extent is seen whole or not at all from each
    /// of a texel's points: more rays than points would repeat themselves.
    static int halvesOf(int samples, const PunctualLight& light)
    {
        const int halves = std::max(1, (samples + kHalf - 1) / kHalf);
        const bool extended = light.radius > 0.0f || light.tanAngularRadius > 0.0f;
        return extended ? halves : std::min(halves, kMaxTexelPoints / kHalf);
    }

    /// One half for all active lanes that `wanted` names (a bit each). lightAt(lane, point) gives the light to look at,
    /// null for none; result(lane, point, light, visible) is called for each sample with a light.
    template<typename LightAt, typename Result> void trace(const TexelGroup& group, uint32_t wanted, int half,
                                                           const LightAt& lightAt, const Result& result,
                                                           uint64_t& rays) const
    {
        RTCRay8 packet;
        alignas(32) embree::LaneMask valid;
        std::array<const PunctualLight*, TexelGroup::kLanes> lights;
        std::array<const SurfacePoint*, TexelGroup::kLanes> points;
        for (int i = 0; i < kHalf; ++i) {
            SurfaceTracer::clear(packet);
            bool any = false;
            for (int lane = 0; lane < TexelGroup::kLanes; ++lane) {
                const auto l = std::size_t(lane);
                valid.lane[lane] = 0;
                lights[l] = nullptr;
                if (!group.active(lane) || ((wanted >> lane) & 1u) == 0) continue;
                points[l] = &group.pointOfSlot(lane, (half & 1) * kHalf + i);
                lights[l] = lightAt(lane, *points[l]);
                if (lights[l] == nullptr || !lights[l]->castShadows) continue;
                const LightRay ray = sample(group.id(lane), half, i, *lights[l], *points[l], packet, lane, rays);
                packet.tfar[lane] = ray.distance * (1.0f - 1.0e-4f);
                valid.lane[lane] = -1;
                any = true;
                ++rays;
            }
            if (any) paths_.surfaces().occluded(valid, packet);
            for (int lane = 0; lane < TexelGroup::kLanes; ++lane) {
                const auto l = std::size_t(lane);
                if (lights[l] == nullptr) continue;
                result(lane, *points[l], *lights[l], valid.lane[lane] == 0 || packet.tfar[lane] >= 0.0f);
            }
        }
    }

private:
    LightRay sample(uint32_t id, int half, int i, const PunctualLight& light, const SurfacePoint& point,
                    RTCRay8& packet, int lane, uint64_t& rays) const
    {
        // Two diagonals of the pattern's 4 x 4 cells in each half; which point gets which cell differs by texel.
        const uint32_t hash = hashCombine(seed_, id);
        const uint32_t place = uint32_t(i) ^ (hash & 7u);
        const uint32_t x = place & 3u;
        const uint32_t cell = (x << 2) | (x ^ (place >> 2 << 1) ^ uint32_t(half & 1));
        const vec2 u = pattern_.block(hash, half / 2).unit(int(cell));
        const float epsilon = paths_.surfaces().epsilonAt(point.position);
        const vec3 origin = paths_.shadowOrigin(point, rays);
        const LightRay ray = sampleLightRay(light, origin, u);
        packet.org_x[lane] = origin.x;
        packet.org_y[lane] = origin.y;
        packet.org_z[lane] = origin.z;
        packet.dir_x[lane] = ray.direction.x;
        packet.dir_y[lane] = ray.direction.y;
        packet.dir_z[lane] = ray.direction.z;
        packet.tnear[lane] = epsilon;
        return ray;
    }

    const PathTracer& paths_;
    const GatherPattern& pattern_;
    uint32_t seed_;
};

} // namespace halflight
