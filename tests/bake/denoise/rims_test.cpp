// Rims of charts: what the denoiser makes of light that falls off steeply towards a concave corner, and what padding
// holds after seams are stitched. Truth is analytic: black walls that are long beside their height hide a known part of
// an even sky.
#include "bake/denoise/denoise.h"
#include "bake/geometry/flatten.h"
#include "bake/pages/dilate.h"
#include "bake/seams/seams.h"
#include "bake/test_scene.h"
#include "bake/texels/rasterize.h"
#include "bake/texels/texel_places.h"

#include "halflight/shading/color.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

namespace halflight::rims_test {
namespace {

using namespace test;

constexpr int kPage = 128;
constexpr float kLong = 400.0f; ///< metres: ends that nobody sees

/// A floor from x = 0 on of a given width, with black walls of a height at x = 0 and, if wanted, at its other end.
/// Texels are a metre wide.
struct Trench {
    float width;
    float height;
    bool bothWalls;
    const char* name;

    /// Share of an even sky that a point sees: of an endless wall that ends at an angle t above the horizon,
    /// (1 - cos t) / 2 of the sky's irradiance is hidden.
    [[nodiscard]] double sky(double x) const
    {
        const double h = double(height);
        const double left = x / std::sqrt(x * x + h * h);
        const double y = double(width) - x;
        const double right = bothWalls ? y / std::sqrt(y * y + h * h) : 1.0;
        return 0.5 * (left + right);
    }
    /// On average over the texels of column i.
    [[nodiscard]] double column(int i) const
    {
        double sum = 0.0;
        for (int k = 0; k < 64; ++k) sum += sky(double(i) + (k + 0.5) / 64.0) / 64.0;
        return sum;
    }
    [[nodiscard]] Scene scene() const
    {
        Scene s;
        const int black = addMaterial(s, vec3(0.0f));
        addRectangle(s, {vec3(0, 0, 32), vec3(width, 0, 0), vec3(0, 0, -64)}, black, kPage,
                     {vec2(8), vec2(8.0f + width, 72.0f)});
        addRectangle(s, {vec3(0, 0, kLong), vec3(0, 0, -2 * kLong), vec3(0, height, 0)}, black, kPage);
        if (bothWalls)
            addRectangle(s, {vec3(width, 0, -kLong), vec3(0, 0, 2 * kLong), vec3(0, height, 0)}, black, kPage);
        s.sky = {vec3(1.0f), vec3(1.0f), vec3(1.0f)};
        return s;
    }
};

class CornersS6 : public testing::TestWithParam<Trench> {};

/// Each column of texels along the wall has the light it should, the last one too. Without a slope at the rim the
/// denoiser took it from the lighter side alone.
TEST_P(CornersS6, LastRowsOfTexelsStayDark)
{
    const Trench& trench = GetParam();
    std::vector<double> before(std::size_t(trench.width), 0.0);
    std::vector<double> after(before.size(), 0.0);
    std::vector<int> count(before.size(), 0);
    for (uint32_t seed = 1; seed <= 16; ++seed) {
        IntegrationSettings settings;
        settings.samples = 32;
        settings.bounces = 0;
        settings.seed = seed;
        Bench bench(trench.scene(), MixedLightingMode::Shadowmask, kPage, settings);
        std::vector<IrradianceEstimate> estimates = bench.irradiance();
        const std::vector<IrradianceEstimate> raw = estimates;
        denoise(bench.geometry, bench.map, {}, estimates, false);
        for (std::size_t i = 0; i < estimates.size(); ++i) {
            const Texel& t = bench.map.texels[i];
            if (t.y < 12 || t.y >= 68) continue; // ends of the chart
            before[std::size_t(t.x) - 8] += double(raw[i].irradiance.x) / double(kPi);
            after[std::size_t(t.x) - 8] += double(estimates[i].irradiance.x) / double(kPi);
            ++count[std::size_t(t.x) - 8];
        }
    }
    for (const std::size_t i : {std::size_t(0), before.size() - 1}) {
        ASSERT_GT(count[i], 600);
        const double truth = trench.column(int(i));
        // The points of a texel from which its rays leave do not have their mean at its very middle.
        EXPECT_NEAR(before[i] / count[i], truth, 0.035 * truth) << "not denoised, column " << i;
        EXPECT_NEAR(after[i] / count[i], before[i] / count[i], 0.01 * truth) << "column " << i;
    }
}

INSTANTIATE_TEST_SUITE_P(Steep, CornersS6,
                         testing::Values(Trench{48, 2.0f, false, "LowWall"}, Trench{48, 6.0f, false, "Wall"},
                                         Trench{12, 8.0f, true, "Trench"}, Trench{5, 3.0f, true, "Slot"}),
                         [](const auto& info) { return info.param.name; });

/// A plane cut in two along x = 0, each half a chart of its own, at odd places of the page.
struct TwoCharts {
    explicit TwoCharts(const std::function<vec3(const Texel&, vec3)>& lightAt)
    {
        Scene scene;
        const int grey = addMaterial(scene, vec3(0.5f));
        addRectangle(scene, {vec3(-20, 0, 0), vec3(20, 0, 0), vec3(0, 0, -40)}, grey, kPage,
                     {vec2(4.3f, 4.6f), vec2(24.3f, 44.6f)});
        addRectangle(scene, {vec3(0), vec3(20, 0, 0), vec3(0, 0, -40)}, grey, kPage,
                     {vec2(60.8f, 50.1f), vec2(80.8f, 90.1f)});
        geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
        map = rasterizeTexels(geometry, kPage, 1);
        std::vector<vec3> values;
        for (const Texel& t : map.texels) values.push_back(lightAt(t, placeOf(geometry, map, t).position));
        pages = dilate(map, values, kDilationRings);
        const std::vector<SeamSample> seams = findSeams(geometry, kPage);
        EXPECT_GE(seams.size(), 40u);
        stitchSeams(map, seams, lightSeamWeights(seams, pages, noLight(pages)), pages);
    }
    /// Padding of the first and second ring that leaves the range of the covered texels next to it.
    [[nodiscard]] int outOfBounds() const
    {
        Image<uint8_t> covered(kPage, kPage, uint8_t(0));
        for (const Texel& t : map.texels) covered(t.x, t.y) = 1;
        int count = 0;
        for (int y = 2; y < kPage - 2; ++y) {
            for (int x = 2; x < kPage - 2; ++x) {
                if (covered(x, y)) continue;
                vec3 least(kInfinity);
                vec3 most(-kInfinity);
                for (int ring = 1; ring <= 2 && least.x > most.x; ++ring) {
                    for (int dy = -ring; dy <= ring; ++dy) {
                        for (int dx = -ring; dx <= ring; ++dx) {
                            if (!covered(x + dx, y + dy)) continue;
                            least = glm::min(least, pages[0](x + dx, y + dy));
                            most = glm::max(most, pages[0](x + dx, y + dy));
                        }
                    }
                }
                if (least.x > most.x) continue;
                const vec3 value = pages[0](x, y);
                for (int c = 0; c < 3; ++c)
                    count += value[c] < 0.9999f * least[c] || value[c] > 1.0001f * most[c] ? 1 : 0;
            }
        }
        return count;
    }
    BakeGeometry geometry;
    TexelMap map;
    std::vector<Image<vec3>> pages;
};

TEST(PaddingS6, NoTexelIsBrighterOrDarkerThanTheCoveredOnesNextToIt)
{
    std::mt19937 random(3);
    std::normal_distribution<float> noise(0.0f, 0.1f);
    // Noise that differs from side to side; a shadow's edge that crosses the seam at a slant; a spot beside it.
    const TwoCharts noisy([&](const Texel&, vec3) { return vec3(1.0f + noise(random), 1.0f + noise(random), 1.0f); });
    EXPECT_EQ(noisy.outOfBounds(), 0);
    const TwoCharts shadow([](const Texel&, vec3 p) { return vec3(p.x - 2.0f * p.z > 40.0f ? 4.0f : 0.2f); });
    EXPECT_EQ(shadow.outOfBounds(), 0);
    const TwoCharts spot([](const Texel&, vec3 p) {
        return vec3(1.0f + 3.0f * std::exp(-0.2f * glm::dot(p - vec3(0.5f, 0, -20), p - vec3(0.5f, 0, -20))));
    });
    EXPECT_EQ(spot.outOfBounds(), 0);
}

} // namespace
} // namespace halflight::rims_test
