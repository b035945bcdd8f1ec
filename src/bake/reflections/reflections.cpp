#include "bake/reflections/reflections.h"

#include "bake/reflections/reflection_gain.h"
#include "halflight/bake/integrator.h"
#include "halflight/base/rgb9e5.h"
#include "halflight/shading/reflection.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

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
/// Share of the pictures' light below which a light group has none of its own.
constexpr double kLeastShare = 0.01;

/// Boxes with a longer diagonal, in sizes of the scene, are of open places. Where roofs are their floor, walls below it
/// would show the whole picture within a thin line.
constexpr float kLargestBox = 2.0f;

/// Metres.
float diagonalOf(const mat4& worldFromBox)
{
    const mat3 axes(worldFromBox);
    return 2.0f * std::sqrt(glm::dot(axes[0], axes[0]) + glm::dot(axes[1], axes[1]) + glm::dot(axes[2], axes[2]));
}

/// One below the other, as RGB9E5. The tiles are of one size, and at least one.
void encodeTiles(std::span<const ImageRgb32f> tiles, ReflectionSet& set)
{
    set.size = tiles[0].width();
    ImageRgb32f picture(set.size, tiles[0].height() * int(tiles.size()));
    for (std::size_t i = 0; i < tiles.size(); ++i)
        std::ranges::copy(tiles[i].texels(), picture.texels().begin() + std::ptrdiff_t(i * tiles[i].texelCount()));
    set.unitNits = rgb9e5Unit(picture);
    set.picture = encodeRgb9e5(picture, set.unitNits);
}

/// Of a light group's tiles: half as wide, where a tile may be.
int groupTileSize(int size)
{
    return std::max(size / 2 / 16 * 16, 32);
}

/// A square picture `size` texels across, by the means over their squares; of the width that it has or less.
ImageRgb32f shrunk(const ImageRgb32f& map, int size)
{
    const float scale = float(map.width()) / float(size);
    const auto last = [&](int to) { return std::min(int(std::ceil(float(to + 1) * scale)), map.width()) - 1; };
    // Share of texel `to` along an axis that texel `from` covers.
    const auto share = [&](int from, int to) {
        const float begin = std::max(float(from), float(to) * scale);
        const float end = std::min(float(from + 1), float(to + 1) * scale);
        return std::max(end - begin, 0.0f) / scale;
    };
    ImageRgb32f result(size, size);
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
            for (int v = int(float(y) * scale); v <= last(y); ++v)
                for (int u = int(float(x) * scale); u <= last(x); ++u)
                    result(x, y) += share(u, x) * share(v, y) * map(u, v);
    return result;
}

void addTimes(vec3 weight, const ImageRgb32f& from, ImageRgb32f& to)
{
    for (std::size_t i = 0; i < to.texelCount(); ++i) to.data()[i] += weight * from.data()[i];
}

class ReflectionStage {
public:
    ReflectionStage(BakedScene& baked, const CachedIntegrator& cached, const LightmapPages& lightmap,
                    const ComponentLight& components, const Progress& progress)
        : baked_(baked), cached_(cached), lightmap_(lightmap), components_(components), progress_(progress),
          sceneSize_(glm::length(baked.scene.bounds(true).size()))
    {}

    Status run(int size, std::vector<std::string>& warnings)
    {
        auto points = specularPoints(cached_, lightmap_, sceneSize_, progress_);
        if (!points) return points.error();
        std::vector<ReflectionProbe> probes = authoredProbes(baked_.scene, warnings);
        for (ReflectionProbe& probe : probes) probe.fadeMeters = reflectionFade(probe.worldFromBox, sceneSize_);
        if (probes.empty())
            if (Status s = place(*points, probes); !s) return s;
        if (probes.empty()) return {};
        ReflectionSet set;
        set.size = tileSize(size, probes.size());
        std::vector<ImageRgb32f> tiles;
        const Status taken = components_.lightmaps.empty() ? takePictures(probes, set.size, kManyRays, tiles)
                                                           : takeByComponent(probes, tiles, set);
        if (!taken) return taken;
        if (components_.lightmaps.empty()) encodeTiles(tiles, set);
        putTrust(cached_, trustOf(*points, picturesOf(probes, tiles)), points->size(), baked_.lightmapDirections);
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
    /// The light of each component around each probe, `size` texels across.
    Status mapsByComponent(std::span<const ReflectionProbe> probes, int size,
                           std::vector<std::vector<ImageRgb32f>>& maps) const
    {
        for (const ReflectionProbe& probe : probes) {
            std::vector<ImageRgb32f>& around = maps.emplace_back(components_.lightmaps.size(), ImageRgb32f(size, size));
            if (Status s = cached_.integrator.radianceAroundByComponent(probe.position, components_.lightmaps,
                                                                        kManyRays, around, progress_);
                !s)
                return s;
            progress_("reflection probes", double(maps.size()) / double(probes.size()));
        }
        return {};
    }
    /// Pictures of light groups. What is left goes into the bake's: the rest, and dim groups at their weights. `all`
    /// receives tiles of all light.
    Status takeByComponent(std::span<const ReflectionProbe> probes, std::vector<ImageRgb32f>& all, ReflectionSet& set)
    {
        std::vector<std::vector<ImageRgb32f>> maps;
        if (Status s = mapsByComponent(probes, set.size - 2, maps); !s) return s;
        const std::size_t count = components_.lightmaps.size();
        std::vector<double> light(count, 0.0);
        for (const std::vector<ImageRgb32f>& around : maps)
            for (std::size_t c = 0; c < count; ++c)
                for (const vec3 texel : around[c].texels()) light[c] += double(luminance(texel));
        const double sum = std::accumulate(light.begin(), light.end(), 0.0);
        std::vector<vec3> weights(count, vec3(0.0f)); // in the bake's own picture
        weights[0] = vec3(1.0f);
        for (std::size_t c = 1; c < count; ++c) {
            BakedGroup& group = baked_.groups[c - 1];
            if (light[c] < kLeastShare * sum || light[c] == 0.0) {
                weights[c] = group.weight;
                continue;
            }
            std::vector<ImageRgb32f> tiles;
            for (const std::vector<ImageRgb32f>& around : maps)
                tiles.push_back(reflectionTile(shrunk(around[c], groupTileSize(set.size) - 2)));
            encodeTiles(tiles, group.reflections);
        }
        std::vector<ImageRgb32f> own;
        for (const std::vector<ImageRgb32f>& around : maps) {
            ImageRgb32f whole(set.size - 2, set.size - 2);
            ImageRgb32f left = whole;
            for (std::size_t c = 0; c < count; ++c) {
                addTimes(vec3(1.0f), around[c], whole);
                addTimes(weights[c], around[c], left);
            }
            all.push_back(reflectionTile(whole));
            own.push_back(reflectionTile(left));
        }
        encodeTiles(own, set);
        return {};
    }
    Status takePictures(std::span<const ReflectionProbe> probes, int size, int rays, std::vector<ImageRgb32f>& tiles)
    {
        for (const ReflectionProbe& probe : probes) {
            ImageRgb32f around(size - 2, size - 2);
            if (Status s =
                    cached_.integrator.radianceAround(probe.position, lightmap_.irradiance, rays, around, progress_);
                !s)
                return s;
            tiles.push_back(reflectionTile(around));
            progress_("reflection probes", double(tiles.size()) / double(probes.size()));
        }
        return {};
    }

    BakedScene& baked_;
    const CachedIntegrator& cached_;
    const LightmapPages& lightmap_; ///< of all light
    const ComponentLight& components_;
    const Progress& progress_;
    float sceneSize_;
};

} // namespace

float reflectionFade(const mat4& worldFromBox, float sceneSizeMeters)
{
    constexpr float kFadeShare = 0.02f; // of the diagonal: 16 cm in a room of 8 m
    return kFadeShare * std::min(diagonalOf(worldFromBox), sceneSizeMeters);
}

Status bakeReflections(BakedScene& baked, const CachedIntegrator& cached, const LightmapPages& lightmap,
                       const ComponentLight& components, int size, std::vector<std::string>& warnings,
                       const Progress& progress)
{
    progress("reflection probes", 0.0);
    return ReflectionStage(baked, cached, lightmap, components, progress).run(size, warnings);
}

} // namespace halflight
