// The light tree against sums over all lights, and the strata of sample blocks (spec S6).

#include "bake/seeds.h"
#include "bake/test_room.h"
#include "transport/random/stratified_pattern.h"
#include "transport/sample/light_tree.h"

#include "halflight/shading/random.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace halflight::test::light_sampling_test {
namespace {

constexpr int kPage = 64;

std::vector<LightItem> randomItems(int count, bool directed)
{
    std::vector<LightItem> items;
    uint32_t seed = 12345;
    const auto random = [&] { return unitFloat(seed = hashPcg(seed)); };
    for (int i = 0; i < count; ++i) {
        LightItem item;
        const vec3 place(10.0f * random(), 10.0f * random(), 10.0f * random());
        item.bounds.extend(place);
        item.bounds.extend(place + 0.3f * vec3(random(), random(), random()));
        item.axis = glm::normalize(vec3(random(), random(), random()) - 0.5f);
        item.cosSpread = directed ? 1.0f : -1.0f;
        item.twoSided = i % 3 == 0;
        item.power = 0.1f + 10.0f * random() * random();
        items.push_back(item);
    }
    return items;
}

/// Every item has a share, the shares add up to one, and sample() takes items as often as probability() says.
TEST(LightTreeS6, ProbabilitiesAddUpAndMatchSamples)
{
    for (const int count : {1, 2, 3, 17, 400}) {
        const std::vector<LightItem> items = randomItems(count, true);
        const LightTree tree(items);
        for (const vec3 position : {vec3(0), vec3(5), vec3(20, -3, 4)}) {
            const vec3 normal = glm::normalize(vec3(0.3f, 1.0f, -0.2f));
            // A cut for several points, this one and some beside it.
            LightTree::Points positions;
            LightTree::Points normals;
            constexpr std::size_t kLane = 5;
            for (std::size_t lane = 0; lane < kLanes; ++lane) {
                positions.set(lane, position + 0.3f * (float(lane) - float(kLane)) * vec3(1.0f, 0.1f, 0.0f));
                normals.set(lane, normal);
            }
            const LightTree::Cut cut = tree.cut(positions, normals);
            LightTree::Cut::Lanes<bool> onlyOne{};
            onlyOne[kLane] = true;
            LightTree::Cut::Lanes<LightTree::Choice> choices;
            double sum = 0.0;
            double cutSum = 0.0;
            std::vector<float> expected;
            for (int i = 0; i < count; ++i) {
                const float p = tree.probability(uint32_t(i), position, normal);
                EXPECT_GT(p, 0.0f);
                expected.push_back(p);
                sum += double(p);
                cutSum += double(tree.probability(cut, kLane, uint32_t(i), position, normal));
            }
            EXPECT_NEAR(sum, 1.0, 1e-3);
            EXPECT_NEAR(cutSum, 1.0, 1e-3);
            constexpr int kSamples = 20000;
            std::vector<double> seen(std::size_t(count), 0.0);
            std::vector<double> seenByCut(std::size_t(count), 0.0);
            for (int s = 0; s < kSamples; ++s) {
                const float u = (float(s) + 0.5f) / float(kSamples);
                const LightTree::Choice choice = tree.sample(position, normal, u);
                ASSERT_LT(choice.item, uint32_t(count));
                EXPECT_NEAR(choice.probability, expected[choice.item], 1e-4f + 1e-2f * expected[choice.item]);
                EXPECT_TRUE(choice.u >= 0.0f && choice.u < 1.0f);
                seen[choice.item] += 1.0 / kSamples;
                tree.sample(cut, positions, normals, onlyOne, {u, u, u, u, u, u, u, u}, choices);
                const LightTree::Choice byCut = choices[kLane];
                const float p = tree.probability(cut, kLane, byCut.item, position, normal);
                EXPECT_NEAR(byCut.probability, p, 1e-4f + 1e-2f * p);
                EXPECT_TRUE(byCut.u >= 0.0f && byCut.u < 1.0f);
                seenByCut[byCut.item] += 1.0 / kSamples;
            }
            for (uint32_t i = 0; i < uint32_t(count); ++i) {
                EXPECT_NEAR(seen[i], expected[i], 2e-3) << i;
                EXPECT_NEAR(seenByCut[i], tree.probability(cut, kLane, i, position, normal), 2e-3) << i;
            }
        }
    }
}

/// Lights out of range are never chosen.
TEST(LightTreeS6, RangeIsKept)
{
    std::vector<LightItem> items = randomItems(64, false);
    for (LightItem& item : items) item.range = 4.0f;
    const LightTree tree(items);
    const vec3 position(3, 4, 5);
    bool any = false;
    for (uint32_t i = 0; i < items.size(); ++i) {
        const float distance = glm::distance(items[i].bounds.center(), position);
        const float p = tree.probability(i, position, vec3(0));
        if (distance > 4.5f) EXPECT_EQ(p, 0.0f);
        any = any || p > 0.0f;
    }
    EXPECT_TRUE(any);
    EXPECT_EQ(tree.sample(vec3(100), vec3(0), 0.5f).probability, 0.0f);
}

/// Many lamps and many point lights: the estimate's mean is the sum over all of them.
TEST(LightTreeS6, ManyLightsSumToTheirTotal)
{
    Scene scene;
    const int white = addMaterial(scene, vec3(0.5f));
    const int glow = addMaterial(scene, vec3(0.0f), vec3(3.0f));
    addRectangle(scene, {vec3(-0.05f, 0, 0.05f), vec3(0.1f, 0, 0), vec3(0, 0, -0.1f)}, white, kPage,
                 {vec2(1), vec2(9)});
    addRectangle(scene, {vec3(-50, 9, 50), vec3(100, 0, 0), vec3(0, 0, -100)}, white, kPage);
    scene.objects.back().castShadows = false;
    double expected = 0.0;
    for (int i = 0; i < 60; ++i) {
        const vec2 place = glm::fract(vec2(0.5f) + float(i) * vec2(0.7548776662f, 0.5698402910f)) * 6.0f - 3.0f;
        const float height = 1.0f + 2.0f * glm::fract(float(i) * 0.618f);
        addRectangle(scene, {vec3(place.x, height, place.y), vec3(0.05f, 0, 0), vec3(0, 0, 0.05f)}, glow, kPage);
        // Mean over the receiver's area.
        constexpr int kSide = 16;
        for (int k = 0; k < kSide * kSide; ++k) {
            const vec2 at = 0.1f * ((vec2(k % kSide, k / kSide) + 0.5f) / float(kSide) - 0.5f);
            const vec3 to(place.x + 0.025f - at.x, height, place.y + 0.025f - at.y);
            const double d2 = double(glm::dot(to, to));
            expected += 3.0 * 0.05 * 0.05 * double(height) * double(height) / (d2 * d2) / (kSide * kSide);
        }
    }
    IntegrationSettings settings;
    for (const IntegratorKind kind : {IntegratorKind::Path, IntegratorKind::Cache}) {
        settings.integrator = kind;
        settings.samples = 128;
        settings.bounces = 0;
        expectMean(meanIrradiance(bakedBySeeds({scene, settings})), expected, {.resolved = 0.015});
    }

    // Point lights, seen by their bounce off a floor that the receiver looks down on.
    Scene lit;
    const int grey = addMaterial(lit, vec3(0.4f));
    addRectangle(lit, {vec3(-0.05f, 1, -0.05f), vec3(0.1f, 0, 0), vec3(0, 0, 0.1f)}, grey, kPage, {vec2(1), vec2(9)});
    lit.objects.back().castShadows = false;
    addRectangle(lit, {vec3(-50, 0, 50), vec3(100, 0, 0), vec3(0, 0, -100)}, grey, kPage);
    std::vector<Light> lights;
    for (int i = 0; i < 20; ++i) {
        const vec2 place = glm::fract(vec2(0.5f) + float(i) * vec2(0.7548776662f, 0.5698402910f)) * 6.0f - 3.0f;
        lights.push_back(makeLight(i % 2 == 0 ? LightType::Point : LightType::Spot, vec3(place.x, 2.0f, place.y),
                                   vec3(0, -1, 0), 1.0f + float(i % 5), LightMode::Mixed));
    }
    settings.integrator = IntegratorKind::Path;
    settings.bounces = 1;
    const SeedMean alone = overSeeds([&](uint32_t seed) {
        settings.seed = seed;
        settings.samples = 32;
        double sum = 0.0;
        for (const Light& light : lights) {
            Scene one = lit;
            one.lights = {light};
            sum += meanIrradiance(Bench(one, MixedLightingMode::Shadowmask, kPage, settings).irradiance());
        }
        return sum;
    });
    lit.lights = lights;
    settings.samples = 256;
    expectSameMean(meanIrradiance(bakedBySeeds({lit, settings})), alone, {.resolved = 0.02});
}

/// The first strata in the order of a block are spread evenly: each pair has one stratum in each half of the block, the
/// first four are in all rows and columns, and over four blocks the first four of each are all strata.
TEST(StratifiedPatternS6, FewStrataOfABlockAreSpread)
{
    constexpr int kBlock = StratifiedPattern::kBlock;
    for (const int first : {0, 1, 5}) {
        std::array<int, kBlock> times{};
        for (int block = first; block < first + 4; ++block) {
            std::array<int, kBlock> stratumAt;
            stratumAt.fill(-1);
            for (int stratum = 0; stratum < kBlock; ++stratum) {
                const auto order = std::size_t(shading::patternOrder(stratum, block));
                ASSERT_LT(order, std::size_t(kBlock));
                EXPECT_EQ(stratumAt[order], -1);
                stratumAt[order] = stratum;
            }
            const auto half = [&](std::size_t order) { return (stratumAt[order] >> 2 ^ stratumAt[order] >> 1) & 1; };
            unsigned rows = 0;
            unsigned columns = 0;
            for (std::size_t order = 0; order < 4; ++order) {
                rows |= 1u << (stratumAt[order] >> 2);
                columns |= 1u << (stratumAt[order] & 3);
                ++times[std::size_t(stratumAt[order])];
                EXPECT_NE(half(order), half(order ^ 1u));
            }
            EXPECT_EQ(rows, 15u);
            EXPECT_EQ(columns, 15u);
        }
        for (const int n : times) EXPECT_EQ(n, 1);
    }
}

/// Each block has one point in each stratum, in the order of the strata, and all blocks together are stratified.
TEST(StratifiedPatternS6, BlocksAreStratified)
{
    const StratifiedPattern pattern(3);
    for (uint32_t texel = 0; texel < 50; ++texel) {
        std::vector<int> rows(64, 0);
        for (int b = 0; b < 4; ++b) {
            const StratifiedPattern::Block block = pattern.block(hashPcg(texel), b);
            for (int stratum = 0; stratum < StratifiedPattern::kBlock; ++stratum) {
                const vec2 u = block.unit(stratum);
                EXPECT_EQ(int(u.x * 4.0f) * 4 + int(u.y * 4.0f), stratum);
                ++rows[std::size_t(u.x * 64.0f)];
            }
        }
        for (const int r : rows) EXPECT_EQ(r, 1);
    }
}

} // namespace
} // namespace halflight::test::light_sampling_test
