// Reflection probes: where they are, their boxes, what they show, and how it is blurred.
#include "bake/reflections/reflections.h"
#include "bake/test_scene.h"
#include "halflight/base/rgb9e5.h"
#include "halflight/shading/brdf.h"
#include "halflight/shading/reflection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace halflight::test::reflections_test {
namespace {

/// An inward box of one material without lightmap, turned about the vertical.
void addRoom(Scene& scene, vec3 center, vec3 halfSize, float turn, int material)
{
    const mat4 pose = glm::rotate(glm::translate(mat4(1.0f), center), turn, vec3(0, 1, 0));
    const auto at = [&](float x, float y, float z) { return vec3(pose * vec4(vec3(x, y, z) * halfSize, 1.0f)); };
    const auto wall = [&](vec3 a, vec3 b, vec3 c) { addRectangle(scene, {a, b - a, c - a}, material, 64); };
    wall(at(-1, -1, 1), at(1, -1, 1), at(-1, -1, -1));
    wall(at(-1, 1, -1), at(1, 1, -1), at(-1, 1, 1));
    wall(at(-1, -1, -1), at(1, -1, -1), at(-1, 1, -1));
    wall(at(1, -1, 1), at(-1, -1, 1), at(1, 1, 1));
    wall(at(-1, -1, 1), at(-1, -1, -1), at(-1, 1, 1));
    wall(at(1, -1, -1), at(1, -1, 1), at(1, 1, -1));
}

/// A grid of valid light probes through a box.
std::vector<Probe> probesIn(vec3 low, vec3 high, ivec3 count)
{
    std::vector<Probe> probes;
    for (int z = 0; z < count.z; ++z)
        for (int y = 0; y < count.y; ++y)
            for (int x = 0; x < count.x; ++x)
                probes.push_back({low + (high - low) * (vec3(x, y, z) + 0.5f) / vec3(count)});
    return probes;
}

struct Placed {
    std::vector<ReflectionProbe> probes;
    Placed(Scene scene, const std::vector<Probe>& lightProbes)
    {
        const float size = glm::length(scene.bounds().size());
        Bench bench(std::move(scene), MixedLightingMode::Shadowmask, 64, {});
        probes = *placeReflections(lightProbes, *bench.integrator, size);
    }
};

TEST(ReflectionPlacement, ARoomHasOneBoxThatIsTheRoom)
{
    for (const float turn : {0.0f, kPi / 6.0f}) {
        Scene scene;
        addRoom(scene, vec3(5, 1.5f, -3), vec3(3.0f, 1.5f, 2.0f), turn, addMaterial(scene, vec3(0.5f)));
        const Placed placed(std::move(scene), probesIn(vec3(3.5f, 0.2f, -4), vec3(6.5f, 2.8f, -2), ivec3(5, 3, 4)));
        ASSERT_EQ(placed.probes.size(), 1u) << turn;
        const ReflectionProbe& probe = placed.probes[0];
        EXPECT_LT(glm::distance(probe.position, vec3(5, 1.5f, -3)), 0.6f);
        EXPECT_LT(glm::distance(vec3(probe.worldFromBox[3]), vec3(5, 1.5f, -3)), 0.05f);
        // Its volume, and each corner of the room is a corner of the box.
        const mat4 boxFromWorld = glm::inverse(probe.worldFromBox);
        const mat4 pose = glm::rotate(glm::translate(mat4(1.0f), vec3(5, 1.5f, -3)), turn, vec3(0, 1, 0));
        for (int corner = 0; corner < 8; ++corner) {
            const vec3 local(corner & 1 ? 3.0f : -3.0f, corner & 2 ? 1.5f : -1.5f, corner & 4 ? 2.0f : -2.0f);
            const vec3 inBox = glm::abs(vec3(boxFromWorld * pose * vec4(local, 1.0f)));
            EXPECT_LT(glm::distance(inBox, vec3(1.0f)), 0.05f) << turn;
        }
    }
}

// Two rooms apart: each has its own, the smaller one first.
TEST(ReflectionPlacement, EachRoomHasItsOwn)
{
    Scene scene;
    const int material = addMaterial(scene, vec3(0.5f));
    addRoom(scene, vec3(0, 1.5f, 0), vec3(3.0f, 1.5f, 2.0f), 0.0f, material);
    addRoom(scene, vec3(6, 1.5f, 0), vec3(1.5f, 1.5f, 1.5f), 0.0f, material);
    std::vector<Probe> lightProbes = probesIn(vec3(-3, 0, -2), vec3(3, 3, 2), ivec3(5, 3, 4));
    const std::vector<Probe> others = probesIn(vec3(4.5f, 0, -1.5f), vec3(7.5f, 3, 1.5f), ivec3(4, 3, 4));
    lightProbes.insert(lightProbes.end(), others.begin(), others.end());
    const Placed placed(std::move(scene), lightProbes);
    ASSERT_EQ(placed.probes.size(), 2u);
    EXPECT_LT(glm::distance(placed.probes[0].position, vec3(6, 1.5f, 0)), 0.6f);
    EXPECT_LT(glm::distance(placed.probes[1].position, vec3(0, 1.5f, 0)), 0.9f);
}

// In the blend a small box hides the rest of a large one around it, whatever its probe shows.
TEST(ReflectionPlacement, AProbeIsLeftOutThatWouldHideABetterOne)
{
    const ReflectionProbe small{vec3(0.5f, 0, 0), glm::scale(mat4(1.0f), vec3(1.0f)), 0.1f};
    const ReflectionProbe large{vec3(-0.5f, 0, 0), glm::scale(mat4(1.0f), vec3(1.01f)), 0.1f};
    using Kept = std::vector<std::size_t>;
    // The small one serves itself a little better, and the other place badly.
    EXPECT_EQ(chooseReflections(std::array{small, large}, {{1.0f, 0.1f}, {0.8f, 1.0f}}), (Kept{1}));
    EXPECT_EQ(chooseReflections(std::array{small, large}, {{1.0f, 0.9f}, {0.1f, 1.0f}}), (Kept{0}));
    // Apart, both are kept.
    ReflectionProbe far = large;
    far.position.x = 10.0f;
    far.worldFromBox[3].x = 10.0f;
    EXPECT_EQ(chooseReflections(std::array{far, small}, {{1.0f, 0.0f}, {0.0f, 1.0f}}), (Kept{1, 0}));
}

TEST(ReflectionPlacement, NothingAroundMeansNoProbe)
{
    Scene scene;
    addRoom(scene, vec3(0, 1.5f, 0), vec3(1.0f), 0.0f, addMaterial(scene, vec3(0.5f)));
    EXPECT_TRUE(Placed(scene, {}).probes.empty());
    EXPECT_TRUE(Placed(scene, probesIn(vec3(10, 5, 10), vec3(12, 7, 12), ivec3(2))).probes.empty());
}

/// GGX prefiltering by the definition, with many directions spread evenly.
vec3 filteredByHand(vec3 n, float alpha, vec3 (*radiance)(vec3))
{
    constexpr int kCount = 200000;
    vec3 sum(0.0f);
    float weights = 0.0f;
    for (int i = 0; i < kCount; ++i) {
        const float y = 1.0f - (2.0f * float(i) + 1.0f) / float(kCount);
        const float phi = 2.399963f * float(i);
        const vec3 l(std::sqrt(1.0f - y * y) * std::cos(phi), y, std::sqrt(1.0f - y * y) * std::sin(phi));
        if (glm::dot(n, l) <= 0.0f) continue;
        const vec3 h = glm::normalize(n + l);
        const float weight = shading::distributionGgx(glm::dot(n, h), alpha) * glm::dot(n, l);
        sum += weight * radiance(l);
        weights += weight;
    }
    return sum / weights;
}

/// What a bilinear filter reads.
vec3 lookUp(const ImageRgb32f& tile, int size, int level, vec3 direction)
{
    const vec2 at = shading::reflectionTexel(size, level, direction) - 0.5f;
    const ivec2 low(glm::floor(at));
    const vec2 f = at - vec2(low);
    return glm::mix(glm::mix(tile(low.x, low.y), tile(low.x + 1, low.y), f.x),
                    glm::mix(tile(low.x, low.y + 1), tile(low.x + 1, low.y + 1), f.x), f.y);
}

ImageRgb32f mapOf(int size, vec3 (*radiance)(vec3))
{
    ImageRgb32f map(size, size);
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
            map(x, y) = radiance(shading::directionFromOctahedron((vec2(x, y) + 0.5f) / float(size)));
    return map;
}

TEST(ReflectionFilter, ConstantLightStaysConstant)
{
    const ImageRgb32f tile = reflectionTile(mapOf(62, [](vec3) { return vec3(3.0f, 2.0f, 1.0f); }));
    for (int level = 0; level < shading::kReflectionLevels; ++level)
        for (const vec3 d : {vec3(0, 1, 0), vec3(0.6f, -0.8f, 0), vec3(0, -1, 0), glm::normalize(vec3(-1, 0.01f, 2))})
            EXPECT_LT(glm::distance(lookUp(tile, 64, level, d), vec3(3.0f, 2.0f, 1.0f)), 1e-4f) << level;
}

// Half the sphere lit, from a slanted side: edges at every level are as wide as the lobe is.
TEST(ReflectionFilter, EachLevelHasTheLobeOfItsRoughness)
{
    const auto radiance = [](vec3 d) { return d.x + 0.3f * d.y + 0.2f * d.z > 0.1f ? vec3(1.0f) : vec3(0.0f); };
    const ImageRgb32f tile = reflectionTile(mapOf(126, radiance));
    for (int level = 1; level < shading::kReflectionLevels; ++level) {
        const float alpha = shading::square(shading::reflectionRoughness(level));
        for (const vec3 d :
             {vec3(1, 0, 0), vec3(-1, 0, 0), vec3(0, 0, 1), vec3(0.2f, 0.9f, -0.3f), vec3(0, -1, 0.1f)}) {
            const vec3 n = glm::normalize(d);
            EXPECT_NEAR(lookUp(tile, 128, level, n).x, filteredByHand(n, alpha, radiance).x, 0.03f) << level;
        }
    }
}

// No seam: just inside and just outside of the octahedron's edge, which is the lower half's outline.
TEST(ReflectionFilter, FilteringHasNoSeam)
{
    const ImageRgb32f tile = reflectionTile(mapOf(30, [](vec3 d) { return vec3(2.0f) + d; }));
    for (int level = 0; level < shading::kReflectionLevels; ++level) {
        for (int i = 0; i < 64; ++i) {
            const float phi = 2.0f * kPi * (float(i) + 0.3f) / 64.0f;
            const vec3 side(std::cos(phi), 0.0f, std::sin(phi));
            // Both edges of a fold: directions that differ by a hair, on either side of the lower half's diagonals.
            const vec3 a = glm::normalize(vec3(1e-4f, -1.0f, 0.0f) + 0.7f * side);
            const vec3 b = glm::normalize(vec3(-1e-4f, -1.0f, 0.0f) + 0.7f * side);
            EXPECT_LT(glm::distance(lookUp(tile, 32, level, a), lookUp(tile, 32, level, b)), 2e-3f) << level;
        }
    }
}

/// A white floor of 20 m with texels, under a glowing panel, a sun and a sky.
TEST(RadianceAround, IsWhatTheRendererDraws)
{
    Scene scene;
    const int white = addMaterial(scene, vec3(0.6f, 0.4f, 0.2f));
    addRectangle(scene, {vec3(-10, 0, 10), vec3(20, 0, 0), vec3(0, 0, -20)}, white, 64, {vec2(1), vec2(41)});
    const int glow = addMaterial(scene, vec3(0.0f), vec3(7.0f));
    addRectangle(scene, {vec3(-1, 3, -1), vec3(2, 0, 0), vec3(0, 0, 2)}, glow, 64);
    scene.lights.push_back(makeLight(LightType::Directional, vec3(0), vec3(0, -1, -1), 5.0f, LightMode::Mixed));
    scene.sky = {vec3(2.0f), vec3(1.0f), vec3(0.5f)};
    IntegrationSettings settings;
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, 64, settings);
    const std::vector<ImageRgb32f> lightmap = {ImageRgb32f(64, 64, vec3(3.0f, 4.0f, 5.0f))};
    ImageRgb32f map(62, 62);
    ASSERT_TRUE(bench.integrator->radianceAround(vec3(0, 1, 0), lightmap, 16, map, {}));
    const auto towards = [&](vec3 d) {
        const vec2 texel = shading::octahedronFromDirection(glm::normalize(d)) * 62.0f;
        return map(std::min(int(texel.x), 61), std::min(int(texel.y), 61));
    };
    EXPECT_LT(glm::distance(towards(vec3(0.02f, 1, 0.02f)), vec3(7.0f)), 1e-4f) << "the panel glows downwards";
    const vec3 up = glm::normalize(vec3(1.0f, 0.6f, 0.3f));
    EXPECT_LT(glm::distance(towards(up), glm::mix(vec3(1.0f), vec3(2.0f), up.y)), 0.05f) << "the sky";
    // The floor: lightmap, and the sun's light that the renderer adds. In the panel's shadow the lightmap alone.
    const vec3 albedo(0.6f, 0.4f, 0.2f);
    const vec3 lit = shading::diffuseRadiance(albedo, lightmap[0](0, 0) + vec3(5.0f * std::sqrt(0.5f)));
    EXPECT_LT(glm::distance(towards(vec3(3, -1, 2)), lit), 1e-3f * glm::length(lit));
    EXPECT_LT(glm::distance(towards(vec3(0, -1, -3)), shading::diffuseRadiance(albedo, lightmap[0](0, 0))), 1e-3f);
}

} // namespace
} // namespace halflight::test::reflections_test
