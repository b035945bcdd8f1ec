// From points to texels: how far reflection probes are trusted.

#include "bake/geometry/hash_grid.h"
#include "bake/pages/dilate.h"
#include "bake/reflections/reflection_gain.h"
#include "halflight/base/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

namespace halflight {
namespace {

/// A texel takes what points say that are nearer than this many times their mean distance: about a dozen of them.
constexpr float kReachOfPoints = 2.0f;

class TrustField {
public:
    /// `areaOfPoint`: square metres of surface for each point.
    TrustField(std::span<const ReflectionTrust> trust, float areaOfPoint)
        : trust_(trust), reach_(kReachOfPoints * std::sqrt(areaOfPoint))
    {
        for (std::size_t i = 0; i < trust.size(); ++i) {
            cells_[gridKey(gridCell(trust[i].position, reach_))].push_back(i);
            along_ += trust[i].along / float(trust.size());
            total_ += trust[i].total / float(trust.size());
        }
    }

    [[nodiscard]] float at(vec3 position, vec3 normal) const
    {
        float along = along_;
        float total = total_;
        const ivec3 middle = gridCell(position, reach_);
        for (int n = 0; n < 27; ++n) {
            const auto cell = cells_.find(gridKey(middle + ivec3(n % 3, n / 3 % 3, n / 9) - 1));
            if (cell == cells_.end()) continue;
            for (const std::size_t i : cell->second) {
                const vec3 way = (trust_[i].position - position) / reach_;
                const float nearness = std::max(1.0f - glm::dot(way, way), 0.0f);
                const float facing = std::max(glm::dot(trust_[i].normal, normal), 0.0f);
                const float weight = nearness * nearness * facing * facing;
                along += weight * trust_[i].along;
                total += weight * trust_[i].total;
            }
        }
        return total > 0.0f ? std::clamp(along / total, 0.0f, 1.0f) : 0.0f;
    }

private:
    std::span<const ReflectionTrust> trust_;
    float reach_; ///< metres
    std::unordered_map<uint64_t, std::vector<std::size_t>> cells_;
    float along_ = 0.0f; ///< mean of all: it counts as one point more, wherever few say anything
    float total_ = 0.0f;
};

float lightmappedArea(const BakeGeometry& geometry)
{
    double area = 0.0;
    for (uint32_t i = 0; i < geometry.triangleCount(); ++i) {
        if (geometry.partOf(i).page < 0) continue;
        const std::array<vec3, 3> p = geometry.cornersOf(i);
        area += 0.5 * double(glm::length(glm::cross(p[1] - p[0], p[2] - p[0])));
    }
    return float(area);
}

} // namespace

void putTrust(const CachedIntegrator& cached, std::span<const ReflectionTrust> trust, std::size_t pointCount,
              std::vector<ImageRgba8>& directions)
{
    const TexelMap& map = cached.map;
    if (directions.empty() || trust.empty()) return;
    const TrustField field(trust, lightmappedArea(cached.geometry) / float(pointCount));
    std::vector<vec3> values(map.texels.size());
    parallelFor(values.size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const TexelFragment& fragment = map.fragments[map.texels[i].firstFragment];
            const SurfacePoint point = surfacePoint(cached.geometry, fragment.triangle, fragment.barycentric);
            values[i] = vec3(field.at(point.position, point.normal));
        }
    });
    const std::vector<ImageRgb32f> pages = dilate(map, values, kDilationRings);
    for (std::size_t p = 0; p < pages.size(); ++p)
        for (std::size_t i = 0; i < pages[p].texelCount(); ++i)
            directions[p].data()[i].a = uint8_t(std::clamp(pages[p].data()[i].x, 0.0f, 1.0f) * 255.0f + 0.5f);
}

} // namespace halflight
