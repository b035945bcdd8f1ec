#include "bake/reflections/reflections.h"

#include "bake/reflections/reflection_gain.h"
#include "halflight/bake/integrator.h"
#include "halflight/base/rgb9e5.h"
#include "halflight/shading/reflection.h"

#include <algorithm>
#include <cmath>
#include <iterator>

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

/// Rays per texel of finished pictures: edges are antialiased, and soft shadows of mixed lights have 17 steps.
constexpr int kManyRays = 16;
constexpr int kFewRays = kManyRays / 4;
/// Texels across a candidate's picture, with few rays each: rough lobes are looked up in it, and there are a hundred.
constexpr int kSmallTile = 48;

/// Boxes with a longer diagonal, in sizes of the scene, are of open places. Where roofs are their floor, walls below it
/// would show the whole picture within a thin line.
constexpr float kLargestBox = 2.0f;

/// Metres.
float diagonalOf(const mat4& worldFromBox)
{
    const mat3 axes(worldFromBox);
    return 2.0f * std::sqrt(glm::dot(axes[0], axes[0]) + glm::dot(axes[1], axes[1]) + glm::dot(axes[2], axes[2]));
}

class ReflectionStage {
public:
    ReflectionStage(BakedScene& baked, const CachedIntegrator& cached, std::span<const ImageRgb32f> lightmap,
                    const Progress& progress)
        : baked_(baked), cached_(cached), lightmap_(lightmap), progress_(progress),
          sceneSize_(glm::length(baked.scene.bounds(true).size()))
    {}

    Status run(int size, std::vector<std::string>& warnings)
    {
        auto points = specularPoints(cached_, {lightmap_, baked_.lightmapDirections}, sceneSize_, progress_);
        if (!points) return points.error();
        std::vector<ReflectionProbe> probes = authoredProbes(baked_.scene, warnings);
        for (ReflectionProbe& probe : probes) probe.fadeMeters = reflectionFade(probe.worldFromBox, sceneSize_);
        if (probes.empty())
            if (Status s = place(*points, probes); !s) return s;
        if (probes.empty()) return {};
        ReflectionSet set;
        set.size = tileSize(size, probes.size());
        std::vector<ImageRgb32f> tiles;
        if (Status s = takePictures(probes, set.size, kManyRays, tiles); !s) return s;
        const int height = shading::reflectionTileHeight(set.size);
        ImageRgb32f picture(set.size, height * int(probes.size()));
        for (std::size_t i = 0; i < tiles.size(); ++i)
            std::copy(tiles[i].texels().begin(), tiles[i].texels().end(),
                      picture.texels().begin() + std::ptrdiff_t(i * tiles[i].texelCount()));
        putTrust(cached_, trustOf(*points, picturesOf(probes, tiles)), points->size(), baked_.lightmapDirections);
        set.unitNits = rgb9e5Unit(picture);
        set.picture = encodeRgb9e5(picture, set.unitNits);
        set.probes = std::move(probes);
        baked_.reflections = std::move(set);
        return {};
    }

private:
    /// As many texels in all as half of the most tiles have at this size, where there are more.
    static int tileSize(int size, std::size_t count)
    {
        const std::size_t whole = ReflectionSet::kMost / 2;
        if (count <= whole) return size;
        return std::max(int(float(size) * std::sqrt(float(whole) / float(count))) / 16 * 16, 32);
    }
    static std::vector<ReflectionPicture> picturesOf(std::span<const ReflectionProbe> probes,
                                                     std::span<const ImageRgb32f> tiles)
    {
        std::vector<ReflectionPicture> pictures;
        for (std::size_t i = 0; i < probes.size(); ++i) pictures.push_back({probes[i], &tiles[i]});
        return pictures;
    }
    /// Where probes change nothing on lightmapped surfaces, or would make none of them better, geometry alone places
    /// them, for what moves among those; but not where they are worse off with them.
    Status place(std::span<const SpecularPoint> points, std::vector<ReflectionProbe>& probes)
    {
        Result<std::vector<ReflectionProbe>> placed =
            placeReflections(baked_.probes.probes, cached_.integrator, sceneSize_);
        if (!placed) return placed.error();
        if (std::none_of(points.begin(), points.end(), [](const SpecularPoint& p) { return p.reflectsProbes(); })) {
            probes = std::move(*placed);
            return {};
        }
        std::vector<ReflectionProbe> candidates = *placed;
        const Result<std::vector<ReflectionProbe>> local =
            proposeReflections(baked_.probes.probes, cached_.integrator, sceneSize_);
        if (!local) return local.error();
        candidates.insert(candidates.end(), local->begin(), local->end());
        std::vector<ImageRgb32f> tiles;
        if (Status s = takePictures(candidates, kSmallTile, kFewRays, tiles); !s) return s;
        const std::vector<ReflectionPicture> all = picturesOf(candidates, tiles);
        std::vector<ReflectionPicture> bounded;
        std::copy_if(all.begin(), all.end(), std::back_inserter(bounded), [&](const ReflectionPicture& picture) {
            return diagonalOf(picture.probe.worldFromBox) <= kLargestBox * sceneSize_;
        });
        const bool trusting = !baked_.lightmapDirections.empty();
        probes = chooseByGain(points, bounded, trusting);
        if (probes.empty() && !areWorseWith(points, std::span(all).first(placed->size()), trusting))
            probes = std::move(*placed);
        return {};
    }
    Status takePictures(std::span<const ReflectionProbe> probes, int size, int rays, std::vector<ImageRgb32f>& tiles)
    {
        for (const ReflectionProbe& probe : probes) {
            ImageRgb32f around(size - 2, size - 2);
            if (Status s = cached_.integrator.radianceAround(probe.position, lightmap_, rays, around, progress_); !s)
                return s;
            tiles.push_back(reflectionTile(around));
            progress_("reflection probes", double(tiles.size()) / double(probes.size()));
        }
        return {};
    }

    BakedScene& baked_;
    const CachedIntegrator& cached_;
    std::span<const ImageRgb32f> lightmap_;
    const Progress& progress_;
    float sceneSize_;
};

} // namespace

float reflectionFade(const mat4& worldFromBox, float sceneSizeMeters)
{
    constexpr float kFadeShare = 0.02f; // of the diagonal: 16 cm in a room of 8 m
    return kFadeShare * std::min(diagonalOf(worldFromBox), sceneSizeMeters);
}

Status bakeReflections(BakedScene& baked, const CachedIntegrator& cached, std::span<const ImageRgb32f> lightmap,
                       int size, std::vector<std::string>& warnings, const Progress& progress)
{
    progress("reflection probes", 0.0);
    return ReflectionStage(baked, cached, lightmap, progress).run(size, warnings);
}

} // namespace halflight
