// Neighbours of texels across seams, and the denoiser's use of them (spec S6).

#include "bake/denoise/denoise.h"
#include "bake/geometry/flatten.h"
#include "bake/seams/patchwork_floor.h"
#include "bake/seams/seams.h"
#include "bake/seams/surface_grid.h"
#include "bake/texels/rasterize.h"
#include "bake/texels/texel_places.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace halflight::test::surface_grid_test {
namespace {

constexpr int kPage = 96;
constexpr float kTexel = 0.1f; ///< metres

struct Kit {
    Kit()
    {
        const int grey = addMaterial(scene, vec3(0.5f));
        addPatchworkFloor(scene, grey, kPage);
        geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
        map = rasterizeTexels(geometry, kPage, 1);
        seams = findSeams(geometry, kPage);
        grid.emplace(map, seams);
    }
    [[nodiscard]] TexelPlace place(uint32_t texel) const { return placeOf(geometry, map, map.texels[texel]); }
    /// Whether the place of a texel is its centre.
    [[nodiscard]] bool isWhole(uint32_t texel) const
    {
        return map.texels[texel].fragmentCount == 1 && coveredArea(map, map.texels[texel]) > 0.999f;
    }

    Scene scene;
    BakeGeometry geometry;
    TexelMap map;
    std::vector<SeamSample> seams;
    std::optional<SurfaceGrid> grid;
};

/// Every offset from a texel of the left piece leads to the texel at that offset in the world, over one seam or two,
/// and nowhere where the floor has ended.
TEST(SurfaceGridS6, OffsetsLeadAcrossSeamsToTheSamePlaceInTheWorld)
{
    const Kit kit;
    int across = 0;
    for (uint32_t i = 0; i < kit.map.texels.size(); ++i) {
        const TexelPlace from = kit.place(i);
        if (from.position.x > 1.9f || !kit.isWhole(i)) continue;
        for (const ivec2 offset :
             {ivec2(1, 0), ivec2(8, 0), ivec2(16, 0), ivec2(16, 16), ivec2(12, -7), ivec2(-16, 4)}) {
            const vec3 to = from.position + kTexel * vec3(offset.x, 0, -offset.y);
            const uint32_t found = shading::texelOnSurface(*kit.grid, i, offset);
            const vec2 beyond = glm::max(vec2(-to.x, -to.z), vec2(to.x - 6.0f, to.z - 4.0f));
            if (std::max(beyond.x, beyond.y) > kTexel) {
                EXPECT_EQ(found, kNoTexel) << to.x << ", " << to.z;
            } else if (std::max(beyond.x, beyond.y) < -kTexel) {
                ASSERT_NE(found, kNoTexel) << to.x << ", " << to.z;
                EXPECT_LT(glm::distance(kit.place(found).position, to), 0.71f * 1.26f * kTexel);
                across += to.x > 2.0f ? 1 : 0;
            }
        }
    }
    EXPECT_GT(across, 500);
}

/// Beyond seams, weighted means of light that changes evenly are exact: no side is darker for how its texels lie.
TEST(SurfaceGridS6, FootprintsReproduceEvenSlopes)
{
    const Kit kit;
    int across = 0;
    for (uint32_t i = 0; i < kit.map.texels.size(); ++i) {
        const TexelPlace from = kit.place(i);
        if (from.position.x > 1.9f || !kit.isWhole(i)) continue;
        if (shading::texelOnChart(*kit.grid, i, ivec2(8, 0)) != kNoTexel || std::abs(from.position.z - 2.0f) > 1.6f)
            continue;
        const shading::Footprint footprint = shading::footprintBeyond(*kit.grid, i, ivec2(8, 0));
        vec3 mean(0.0f);
        float weight = 0.0f;
        bool whole = footprint.count == 4;
        for (std::size_t n = 0; n < footprint.count; ++n) {
            const uint32_t j = footprint.texels[n];
            whole = whole && kit.isWhole(j);
            mean += footprint.weights[n] * kit.place(j).position;
            weight += footprint.weights[n];
        }
        if (!whole) continue;
        EXPECT_NEAR(weight, 1.0f, 1.0e-4f);
        EXPECT_LT(glm::distance(mean, from.position + vec3(8.0f * kTexel, 0, 0)), 0.002f);
        ++across;
    }
    EXPECT_GT(across, 50);
}

/// A wall that stands on a seam is a corner: the floor goes on, the wall has neighbours of its own alone.
TEST(SurfaceGridS6, CornersAreNotCrossed)
{
    Scene scene;
    const int grey = addMaterial(scene, vec3(0.5f));
    addRectangle(scene, {vec3(0, 0, 1), vec3(1, 0, 0), vec3(0, 0, -1)}, grey, kPage, {vec2(4), vec2(14)});
    addRectangle(scene, {vec3(0, 0, 0), vec3(1, 0, 0), vec3(0, 1, 0)}, grey, kPage, {vec2(24, 4), vec2(34, 14)});
    const BakeGeometry geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
    const TexelMap map = rasterizeTexels(geometry, kPage, 1);
    const SurfaceGrid grid(map, findSeams(geometry, kPage));
    for (uint32_t i = 0; i < map.texels.size(); ++i) {
        for (int k = 0; k < 25 * 25; ++k) {
            const uint32_t j = shading::texelOnSurface(grid, i, ivec2(k % 25 - 12, k / 25 - 12));
            if (j != kNoTexel) ASSERT_EQ(map.texels[j].chart, map.texels[i].chart);
        }
    }
}

/// Root mean square of the errors of denoised light within 30 cm of the strip, where no texel has a full neighbourhood
/// on its own chart; relative to the noise.
double errorAlongTheStrip(const Kit& kit, std::span<const SeamSample> seams)
{
    constexpr float kSigma = 0.1f;
    std::mt19937 random(3);
    std::normal_distribution<float> noise(0.0f, kSigma);
    const auto lightAt = [](vec3 p) { return 2.0f + 0.5f * std::sin(1.5f * p.x) + 0.3f * std::cos(2.0f * p.z); };
    std::vector<IrradianceEstimate> estimates(kit.map.texels.size());
    for (uint32_t i = 0; i < estimates.size(); ++i) {
        estimates[i].irradiance = vec3(lightAt(kit.place(i).position) + noise(random));
        estimates[i].varianceOfMean = kSigma * kSigma;
        estimates[i].samples = 64;
    }
    denoise(kit.geometry, kit.map, seams, estimates, false);
    double squares = 0.0;
    int count = 0;
    for (uint32_t i = 0; i < estimates.size(); ++i) {
        const vec3 p = kit.place(i).position;
        if (p.x < 1.7f || p.x > 2.6f || p.z < 0.5f || p.z > 3.5f) continue;
        squares += std::pow(double(estimates[i].irradiance.x - lightAt(p)), 2.0);
        ++count;
    }
    return std::sqrt(squares / double(count)) / double(kSigma);
}

/// Along seams the denoiser has the neighbours of all sides.
TEST(SurfaceGridS6, NoiseGoesAlongSeamsAsElsewhere)
{
    const Kit kit;
    EXPECT_LT(errorAlongTheStrip(kit, kit.seams), 0.25);
    EXPECT_GT(errorAlongTheStrip(kit, {}), 0.3); // so that the limit says something
}

} // namespace
} // namespace halflight::test::surface_grid_test
