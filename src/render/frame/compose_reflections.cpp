// Reflection probes of a state of light groups (spec S33).
#include "halflight/base/image_filter.h"
#include "halflight/base/parallel.h"
#include "halflight/base/rgb9e5.h"
#include "halflight/render/compose.h"
#include "halflight/shading/reflection.h"

namespace halflight {
namespace {

/// Adds one level's map of a tile that may be narrower. `top`: of the tiles, rows of their pictures.
void addLevel(const ImageRgb32f& from, int fromSize, int fromTop, vec3 weight, int level, int toSize, int toTop,
              ImageRgb32f& to)
{
    const int width = shading::reflectionLevelSize(toSize, level);
    const ivec2 toCorner = ivec2(shading::reflectionLevelOffset(toSize, level)) + ivec2(0, toTop);
    const vec2 fromCorner = shading::reflectionLevelOffset(fromSize, level) + vec2(0.0f, float(fromTop)) + 1.0f;
    const float scale = float(shading::reflectionLevelSize(fromSize, level) - 2) / float(width - 2);
    for (int y = 0; y < width; ++y) {
        for (int x = 0; x < width; ++x) {
            // Both maps have a border of one texel, whatever their size.
            const vec2 inner = vec2(float(x), float(y)) - 0.5f;
            to(toCorner.x + x, toCorner.y + y) += weight * bilinear(from, fromCorner + inner * scale);
        }
    }
}

} // namespace

ReflectionSet composedReflections(const BakedScene& baked, std::span<const vec3> weights)
{
    ReflectionSet set = baked.reflections;
    if (set.probes.empty()) return set;
    ImageRgb32f picture = decodeRgb9e5(set.picture, set.unitNits);
    for (std::size_t g = 0; g < baked.groups.size(); ++g) {
        const ReflectionSet& own = baked.groups[g].reflections;
        if (own.size == 0 || weights[g] == vec3(0.0f)) continue;
        const ImageRgb32f light = decodeRgb9e5(own.picture, own.unitNits);
        parallelFor(set.probes.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (auto probe = int(begin); probe < int(end); ++probe)
                for (int level = 0; level < shading::kReflectionLevels; ++level)
                    addLevel(light, own.size, probe * shading::reflectionTileHeight(own.size), weights[g], level,
                             set.size, probe * shading::reflectionTileHeight(set.size), picture);
        });
    }
    set.unitNits = rgb9e5Unit(picture);
    set.picture = encodeRgb9e5(picture, set.unitNits);
    return set;
}

std::vector<std::string> groupsKeptByReflections(const BakedScene& baked, std::span<const vec3> weights)
{
    std::vector<std::string> names;
    if (baked.reflections.probes.empty()) return names;
    for (std::size_t g = 0; g < baked.groups.size(); ++g)
        if (baked.groups[g].reflections.size == 0 && weights[g] != baked.groups[g].weight)
            names.push_back(baked.groups[g].name);
    return names;
}

std::vector<std::string> oldReflections(const BakedScene& baked, std::span<const vec3> weights)
{
    std::vector<std::string> warnings;
    for (const std::string& name : groupsKeptByReflections(baked, weights))
        warnings.push_back("the light group " + name +
                           " has less than 1 % of what reflection probes show: glossy surfaces reflect it as it was in "
                           "the bake");
    return warnings;
}

} // namespace halflight
