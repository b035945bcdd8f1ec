// What the maps of distances say: is a point in the sight of a probe?
#include "halflight/shading/sight.h"
#include "render/frame/probes_mesh.h"

#include <algorithm>
#include <cmath>

namespace halflight {

ProbeSightMaps::ProbeSightMaps(const ProbeSight& sight, std::span<const uint32_t> sources) : size_(sight.size)
{
    if (size_ <= 0 || sight.rangeMeters.empty()) return;
    const std::size_t corners = std::size_t(size_) * std::size_t(size_);
    std::vector<std::size_t> first;
    std::size_t next = 0;
    for (const float range : sight.rangeMeters) {
        first.push_back(next);
        if (range > 0.0f) next += corners;
    }
    if (next != sight.corners.size()) return;
    for (const uint32_t source : sources) maps_.push_back({sight.rangeMeters[source], first[source]});
    for (const ProbeSight::Corner& corner : sight.corners) {
        const float nearness = 65535.0f / float(std::max<uint16_t>(corner.distance, 1));
        const float deviation = nearness * float(corner.deviation) / 65535.0f;
        moments_.emplace_back(nearness, deviation * deviation);
    }
}

float ProbeSightMaps::weight(uint32_t place, vec3 offset) const
{
    if (maps_.empty() || !(maps_[place].rangeMeters > 0.0f)) return 1.0f;
    const float meters = std::abs(offset.x) + std::abs(offset.y) + std::abs(offset.z);
    if (!(meters > 0.0f)) return 1.0f;

    const vec2 square(shading::octahedralX(offset), shading::octahedralY(offset));
    const int cells = size_ - 1;
    const vec2 at = (square * 0.5f + 0.5f) * float(cells);
    const ivec2 cell = glm::clamp(ivec2(at), 0, cells - 1);
    const vec2 part = at - vec2(cell);
    const bool mirrored = (2 * cell.x < cells) != (2 * cell.y < cells);
    vec2 moments(0.0f);
    for (int corner = 0; corner < 4; ++corner) {
        const int x = corner & 1;
        const int y = corner >> 1;
        moments += shading::octahedralShare(x, y, part.x, part.y, mirrored) *
                   moments_[maps_[place].first + std::size_t((cell.y + y) * size_ + cell.x + x)];
    }
    return shading::probeSight(moments.x, moments.y, std::max(maps_[place].rangeMeters / meters, 1.0f));
}

} // namespace halflight
