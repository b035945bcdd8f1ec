#include "bake/reflections.h"

#include "bake/stages.h"
#include "halflight/base/rgb9e5.h"
#include "halflight/shading/reflection.h"

#include <algorithm>
#include <cmath>

namespace halflight {
namespace {

std::vector<ReflectionProbe> authoredProbes(const Scene& scene, std::vector<std::string>& warnings)
{
    std::vector<ReflectionProbe> probes;
    for (const mat4& box : scene.reflectionBoxes) probes.push_back({vec3(box[3]), box, 0.0f});
    if (probes.size() > ReflectionSet::kMost) {
        warnings.push_back("reflection probes: the file asks for " + std::to_string(probes.size()) + ", the first " +
                           std::to_string(ReflectionSet::kMost) + " are baked, since a file holds no more");
        probes.resize(ReflectionSet::kMost);
    }
    return probes;
}

} // namespace

float reflectionFade(const mat4& worldFromBox)
{
    constexpr float kFadeShare = 0.02f; // of the diagonal: 16 cm in a room of 8 m
    const mat3 axes(worldFromBox);
    return kFadeShare * 2.0f *
           std::sqrt(glm::dot(axes[0], axes[0]) + glm::dot(axes[1], axes[1]) + glm::dot(axes[2], axes[2]));
}

std::optional<ReflectionSet> bakeReflections(const BakedScene& baked, Integrator& integrator,
                                             std::span<const ImageRgb32f> lightmap, int size,
                                             std::vector<std::string>& warnings, const Progress& progress)
{
    ReflectionSet set;
    set.size = size;
    progress("reflection probes", 0.0);
    set.probes = authoredProbes(baked.scene, warnings);
    if (set.probes.empty())
        set.probes = placeReflections(baked.probes.probes, integrator, glm::length(baked.scene.bounds(true).size()));
    if (set.probes.empty()) return ReflectionSet();
    ImageRgb32f picture(size, shading::reflectionTileHeight(size) * int(set.probes.size()));
    for (std::size_t i = 0; i < set.probes.size(); ++i) {
        ReflectionProbe& probe = set.probes[i];
        probe.fadeMeters = reflectionFade(probe.worldFromBox);
        ImageRgb32f around(size - 2, size - 2);
        if (!integrator.radianceAround(probe.position, lightmap, around, progress)) return std::nullopt;
        const ImageRgb32f tile = reflectionTile(around);
        std::copy(tile.texels().begin(), tile.texels().end(),
                  picture.texels().begin() + std::ptrdiff_t(i * tile.texelCount()));
        progress("reflection probes", double(i + 1) / double(set.probes.size()));
    }
    set.unitNits = rgb9e5Unit(picture);
    set.picture = encodeRgb9e5(picture, set.unitNits);
    return set;
}

} // namespace halflight
