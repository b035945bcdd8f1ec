// The bake's stages on their own: texels, channels (S9, S10), dilation, determinism.

#include "bake/test_scene.h"

#include "halflight/base/parallel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

namespace halflight::test {
namespace {

constexpr int kPage = 64;

Light pointAt(const std::string& name, vec3 position, float range, float intensity = 10.0f)
{
    Light light = makeLight(LightType::Point, position, vec3(0, -1, 0), intensity, LightMode::Mixed);
    light.name = name;
    light.rangeMeters = range;
    return light;
}

/// Whether two lights of the scene reach a common point, by sampling space.
bool reachCommonPoint(const Light& a, const Light& b, std::mt19937& random)
{
    std::uniform_real_distribution<float> u(-12.0f, 12.0f);
    const auto reaches = [](const Light& light, vec3 p) {
        if (light.type == LightType::Directional) return true;
        const vec3 offset = p - light.position();
        const float distance = glm::length(offset);
        if (light.rangeMeters > 0.0f && distance >= light.rangeMeters) return false;
        return light.type != LightType::Spot ||
               glm::dot(offset / distance, light.direction()) > std::cos(light.outerConeRadians);
    };
    for (int i = 0; i < 4000; ++i) {
        const vec3 p(u(random), u(random), u(random));
        if (reaches(a, p) && reaches(b, p)) return true;
    }
    return false;
}

TEST(ChannelsS9, LightsThatOverlapNeverShareAndOthersDo)
{
    std::mt19937 random(7);
    std::uniform_real_distribution<float> u(-10.0f, 10.0f);
    for (int trial = 0; trial < 30; ++trial) {
        Scene scene;
        for (int i = 0; i < 12; ++i) {
            Light light = pointAt("p" + std::to_string(i), vec3(u(random), u(random), u(random)),
                                  2.0f + 0.3f * float(i), float(i + 1));
            if (i % 3 == 0) {
                light.type = LightType::Spot;
                light.outerConeRadians = 0.2f + 0.1f * float(i);
                light.worldFromLight = lightPose(light.position(), vec3(u(random), u(random), u(random)));
            }
            scene.lights.push_back(light);
        }
        if (trial % 2)
            scene.lights.push_back(makeLight(LightType::Directional, vec3(0), vec3(0, -1, 0), 1.0f, LightMode::Mixed));
        assignShadowmaskChannels(scene, MixedLightingMode::Shadowmask);
        for (std::size_t i = 0; i < scene.lights.size(); ++i) {
            const BakingOutput& a = scene.lights[i].baking;
            EXPECT_EQ(a.occlusionMaskChannel >= 0, a.bakeType == LightMode::Mixed);
            EXPECT_LT(a.occlusionMaskChannel, 4);
            for (std::size_t j = i + 1; j < scene.lights.size(); ++j) {
                const BakingOutput& b = scene.lights[j].baking;
                if (a.occlusionMaskChannel < 0 || a.occlusionMaskChannel != b.occlusionMaskChannel) continue;
                EXPECT_FALSE(reachCommonPoint(scene.lights[i], scene.lights[j], random))
                    << scene.lights[i].name << " and " << scene.lights[j].name;
            }
        }
    }
    Scene apart;
    for (int i = 0; i < 20; ++i)
        apart.lights.push_back(pointAt("p" + std::to_string(i), vec3(float(i) * 10.0f, 0, 0), 4.9f));
    assignShadowmaskChannels(apart, MixedLightingMode::Shadowmask);
    for (const Light& light : apart.lights) EXPECT_EQ(light.baking.occlusionMaskChannel, 0);
}

TEST(ChannelsS9, OrderOfLightsDoesNotMatter)
{
    std::vector<Light> lights;
    for (int i = 0; i < 9; ++i)
        lights.push_back(pointAt("p" + std::to_string(i), vec3(float(i) * 2.0f, 0, 0), 3.5f, float(10 + i)));
    std::map<std::string, int> expected;
    std::mt19937 random(3);
    for (int trial = 0; trial < 20; ++trial) {
        Scene scene;
        scene.lights = lights;
        assignShadowmaskChannels(scene, MixedLightingMode::Shadowmask);
        for (const Light& light : scene.lights) {
            const auto [found, fresh] = expected.emplace(light.name, light.baking.occlusionMaskChannel);
            EXPECT_EQ(found->second, light.baking.occlusionMaskChannel) << light.name;
        }
        std::shuffle(lights.begin(), lights.end(), random);
    }
}

TEST(ChannelsS10, TheFifthOverlappingLightIsBakedAndNamed)
{
    Scene scene;
    for (int i = 0; i < 5; ++i)
        scene.lights.push_back(pointAt("lamp " + std::to_string(i), vec3(float(i), 0, 0), 20.0f, float(50 - i)));
    assignShadowmaskChannels(scene, MixedLightingMode::Shadowmask);
    std::set<int> channels;
    for (int i = 0; i < 4; ++i) {
        EXPECT_EQ(scene.lights[std::size_t(i)].baking.bakeType, LightMode::Mixed);
        channels.insert(scene.lights[std::size_t(i)].baking.occlusionMaskChannel);
    }
    EXPECT_EQ(channels, (std::set<int>{0, 1, 2, 3}));
    const BakingOutput& fifth = scene.lights[4].baking;
    EXPECT_EQ(fifth.bakeType, LightMode::Baked);
    EXPECT_EQ(fifth.occlusionMaskChannel, -1);
    EXPECT_NE(fifth.reason.find("lamp 0"), std::string::npos) << fifth.reason;
}

/// The overflowing light's direct light is in the lightmap: nothing is dropped.
TEST(ChannelsS10, OverflowIsRightInTheLightmap)
{
    Scene scene;
    addRectangle(scene, {vec3(-1, 0, 1), vec3(2, 0, 0), vec3(0, 0, -2)}, addMaterial(scene, vec3(0)), kPage,
                 {vec2(1), vec2(63)});
    for (int i = 0; i < 5; ++i)
        scene.lights.push_back(
            pointAt("lamp " + std::to_string(i), vec3(0.3f * float(i), 1.5f, 0), 20.0f, float(50 - i)));
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, {});
    const auto estimates = bench.irradiance();
    for (std::size_t i = 0; i < estimates.size(); i += 17) {
        const vec3 toLight = bench.scene.lights[4].position() - bench.positionOf(bench.map.texels[i]);
        const float d = glm::length(toLight);
        const float window = 1.0f - std::pow(d / 20.0f, 4.0f);
        const float expected = 46.0f * window / (d * d) * toLight.y / d;
        EXPECT_NEAR(estimates[i].irradiance.x, expected, 3e-3f * expected);
    }
}

/// A street of a thousand lamps, each overlapping a handful: nearly all keep a channel, and nobody waits.
TEST(ChannelsS9, AThousandLights)
{
    Scene scene;
    for (int i = 0; i < 1000; ++i) {
        scene.lights.push_back(
            pointAt("lamp " + std::to_string(i), vec3(float(i % 40) * 3.0f, 0, float(i / 40) * 3.0f), 2.2f, 10.0f));
    }
    assignShadowmaskChannels(scene, MixedLightingMode::Shadowmask);
    int mixed = 0;
    for (const Light& light : scene.lights) mixed += light.baking.occlusionMaskChannel >= 0 ? 1 : 0;
    EXPECT_GT(mixed, 900);
}

TEST(ChannelsS9, LightsWithoutShadowsNeedNoChannel)
{
    Scene scene;
    for (int i = 0; i < 6; ++i) scene.lights.push_back(pointAt("p" + std::to_string(i), vec3(0), 5.0f));
    scene.lights[1].castShadows = false;
    scene.lights[2].shadowStrength = 0.0f;
    assignShadowmaskChannels(scene, MixedLightingMode::Shadowmask);
    for (const Light& light : scene.lights) EXPECT_EQ(light.baking.bakeType, LightMode::Mixed) << light.name;
    EXPECT_EQ(scene.lights[1].baking.occlusionMaskChannel, -1);
    EXPECT_EQ(scene.lights[2].baking.occlusionMaskChannel, -1);
}

TEST(ChannelsS25, SubtractiveGivesChannelZeroToTheBrightestSun)
{
    Scene scene;
    scene.lights = {makeLight(LightType::Directional, vec3(0), vec3(0, -1, 0), 1.0f, LightMode::Mixed),
                    makeLight(LightType::Directional, vec3(0), vec3(0, -1, 0), 3.0f, LightMode::Mixed),
                    makeLight(LightType::Directional, vec3(0), vec3(0, -1, 0), 9.0f, LightMode::Realtime),
                    pointAt("p", vec3(0), 3.0f)};
    assignShadowmaskChannels(scene, MixedLightingMode::Subtractive);
    EXPECT_EQ(scene.lights[0].baking.occlusionMaskChannel, -1);
    EXPECT_EQ(scene.lights[1].baking.occlusionMaskChannel, 0);
    EXPECT_EQ(scene.lights[2].baking.occlusionMaskChannel, -1);
    EXPECT_EQ(scene.lights[3].baking.occlusionMaskChannel, -1);
    EXPECT_FALSE(scene.lights[2].baking.isBaked);
}

/// Any point of any triangle lies in a texel of the map: nothing the renderer can sample is missing.
TEST(TexelsS6, RasterizationIsConservative)
{
    std::mt19937 random(11);
    std::uniform_real_distribution<float> u(0.0f, 1.0f);
    Scene scene;
    const int grey = addMaterial(scene, vec3(0.5f));
    MeshPart part;
    for (int t = 0; t < 200; ++t) {
        const vec2 base(u(random) * 60.0f, u(random) * 60.0f);
        const float size = t % 2 ? 4.0f : 0.3f;
        for (int i = 0; i < 3; ++i) {
            const vec2 p = base + size * vec2(u(random), u(random));
            part.positions.push_back(vec3(p, float(t)));
            part.normals.push_back(vec3(0, 0, 1));
            part.lightmapUv.push_back(p / float(kPage));
            part.indices.push_back(uint32_t(part.indices.size()));
        }
    }
    part.material = grey;
    addObject(scene, std::move(part));
    const BakeGeometry geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
    const TexelMap map = rasterizeTexels(geometry, kPage, 1);
    std::set<std::pair<int, int>> covered;
    for (const Texel& texel : map.texels) {
        EXPECT_TRUE(covered.emplace(texel.x, texel.y).second) << "a texel listed twice";
        float area = 0.0f;
        for (uint32_t f = 0; f < texel.fragmentCount; ++f) area += map.fragments[texel.firstFragment + f].area;
        EXPECT_GT(area, 0.0f);
        std::array<SurfacePoint, kMaxTexelPoints> points;
        EXPECT_GE(texelPoints(geometry, map, texel, points), 1);
    }
    for (std::size_t t = 0; t < geometry.triangles.size(); ++t) {
        const uvec3 v = geometry.triangles[t];
        const vec2 a = geometry.lightmapTexel[v.x];
        const vec2 b = geometry.lightmapTexel[v.y];
        const vec2 c = geometry.lightmapTexel[v.z];
        if (std::abs((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)) < 1e-4f) continue;
        for (int s = 0; s < 50; ++s) {
            float x = u(random);
            float y = u(random);
            if (x + y > 1.0f) {
                x = 1.0f - x;
                y = 1.0f - y;
            }
            const vec2 p = a + x * (b - a) + y * (c - a);
            EXPECT_TRUE(covered.count({int(p.x), int(p.y)})) << p.x << " " << p.y;
        }
    }
}

/// A texel that its surface covers in part has points enough to stand for that part: their mean is near its centroid,
/// and the points of more batches close in on it.
TEST(TexelsS6, TexelsCoveredInPartHavePointsEnough)
{
    Scene scene;
    addRectangle(scene, {vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4)}, addMaterial(scene, vec3(0.5f)), kPage,
                 {vec2(10.3f, 10.8f), vec2(40.4f, 40.15f)});
    const BakeGeometry geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
    const TexelMap map = rasterizeTexels(geometry, kPage, 1);
    int partly = 0;
    for (const Texel& texel : map.texels) {
        float area = 0.0f;
        vec3 centroid(0.0f);
        for (uint32_t f = 0; f < texel.fragmentCount; ++f) {
            const TexelFragment& fragment = map.fragments[texel.firstFragment + f];
            area += fragment.area;
            centroid += fragment.area * surfacePoint(geometry, fragment.triangle, fragment.barycentric).position;
        }
        if (area > 0.9f || area < 0.05f) continue;
        ++partly;
        vec3 sum(0.0f);
        int count = 0;
        for (int batch = 0; batch < 4; ++batch) {
            std::array<SurfacePoint, kMaxTexelPoints> points;
            const int some = texelPoints(geometry, map, texel, points, batch);
            EXPECT_GE(some, 9) << "of " << area << " at " << texel.x << ", " << texel.y;
            for (int i = 0; i < some; ++i) sum += points[std::size_t(i)].position;
            count += some;
        }
        const float texelMeters = 4.0f / 30.0f;
        EXPECT_LT(glm::distance(sum / float(count), centroid / area), 0.06f * texelMeters)
            << texel.x << ", " << texel.y;
    }
    EXPECT_GT(partly, 100);
}

TEST(TexelsS6, AreasOfAFullTexelSumToOneAndCentroidsLieInside)
{
    Scene scene;
    addRectangle(scene, {}, addMaterial(scene, vec3(0.5f)), kPage, {vec2(3.25f), vec2(20.75f)});
    const BakeGeometry geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
    const TexelMap map = rasterizeTexels(geometry, kPage, 1);
    EXPECT_EQ(map.texels.size(), 18u * 18u);
    EXPECT_EQ(map.chartCount, 1u);
    double total = 0.0;
    for (const Texel& texel : map.texels) {
        for (uint32_t f = 0; f < texel.fragmentCount; ++f) {
            const TexelFragment& fragment = map.fragments[texel.firstFragment + f];
            total += fragment.area;
            const uvec3 v = geometry.triangles[fragment.triangle];
            const vec2 p = (1.0f - fragment.barycentric.x - fragment.barycentric.y) * geometry.lightmapTexel[v.x] +
                           fragment.barycentric.x * geometry.lightmapTexel[v.y] +
                           fragment.barycentric.y * geometry.lightmapTexel[v.z];
            EXPECT_GE(p.x, float(texel.x) - 1e-3f);
            EXPECT_LE(p.x, float(texel.x) + 1.001f);
            EXPECT_GE(p.y, float(texel.y) - 1e-3f);
            EXPECT_LE(p.y, float(texel.y) + 1.001f);
        }
    }
    EXPECT_NEAR(total, 17.5 * 17.5, 1e-2);
}

/// Two charts three texels apart: each grows two rings of its own value, and none of the other's.
TEST(DilateS6, NeverCrossesCharts)
{
    Scene scene;
    const int grey = addMaterial(scene, vec3(0.5f));
    addRectangle(scene, {}, grey, kPage, {vec2(4), vec2(12)});
    addRectangle(scene, {vec3(5, 0, 0)}, grey, kPage, {vec2(15, 4), vec2(23, 12)});
    const BakeGeometry geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
    const TexelMap map = rasterizeTexels(geometry, kPage, 1);
    ASSERT_EQ(map.chartCount, 2u);
    std::vector<vec3> values(map.texels.size());
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = map.texels[i].x < 13 ? vec3(1, 0, 0) : vec3(0, 1, 0);
    const Image<vec3> page = dilate(map, values, 2)[0];
    for (int y = 4; y < 12; ++y) {
        EXPECT_EQ(page(12, y), vec3(1, 0, 0));
        EXPECT_EQ(page(14, y), vec3(0, 1, 0));
        EXPECT_TRUE(page(13, y) == vec3(1, 0, 0) || page(13, y) == vec3(0, 1, 0));
        EXPECT_EQ(page(2, y), vec3(1, 0, 0));
        EXPECT_EQ(page(1, y), vec3(0));
    }
}

TEST(DilateS6, InvalidTexelsTakeTheirOwnChartsValues)
{
    Scene scene;
    const int grey = addMaterial(scene, vec3(0.5f));
    addRectangle(scene, {}, grey, kPage, {vec2(4), vec2(12)});
    addRectangle(scene, {vec3(5, 0, 0)}, grey, kPage, {vec2(12, 4), vec2(20, 12)});
    const BakeGeometry geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
    const TexelMap map = rasterizeTexels(geometry, kPage, 1);
    std::vector<vec3> values(map.texels.size());
    std::vector<uint8_t> valid(map.texels.size(), 1);
    for (std::size_t i = 0; i < values.size(); ++i) {
        values[i] = map.texels[i].x < 12 ? vec3(1, 0, 0) : vec3(0, 1, 0);
        if (map.texels[i].x >= 9 && map.texels[i].x < 12) {
            values[i] = vec3(0);
            valid[i] = 0;
        }
    }
    fillInvalid(geometry, map, valid, values);
    for (std::size_t i = 0; i < values.size(); ++i)
        EXPECT_EQ(values[i], map.texels[i].x < 12 ? vec3(1, 0, 0) : vec3(0, 1, 0));
}

/// A chart without a valid texel takes the light of what lies beside it in the world and faces the same way.
TEST(DilateS6, ChartsInsideGeometryTakeTheirSurroundingsValues)
{
    Scene scene;
    const int grey = addMaterial(scene, vec3(0.5f));
    addRectangle(scene, {}, grey, kPage, {vec2(4), vec2(20)});
    addRectangle(scene, {vec3(1, 0, 0), vec3(0.05f, 0, 0), vec3(0, 0, -1)}, grey, kPage, {vec2(40, 4), vec2(41, 20)});
    addRectangle(scene, {vec3(1, -0.1f, -1), vec3(0, 0, 1), vec3(0, -1, 0)}, grey, kPage, {vec2(30, 30), vec2(46, 46)});
    const BakeGeometry geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
    const TexelMap map = rasterizeTexels(geometry, kPage, 1);
    std::vector<vec3> values(map.texels.size());
    std::vector<uint8_t> valid(map.texels.size(), 1);
    for (std::size_t i = 0; i < values.size(); ++i) {
        const bool sliver = map.texels[i].x >= 39 && map.texels[i].y < 22;
        values[i] = sliver ? vec3(0) : map.texels[i].x < 22 ? vec3(1, 0, 0) : vec3(0, 1, 0);
        valid[i] = sliver ? 0 : 1;
    }
    fillInvalid(geometry, map, valid, values);
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (!valid[i]) EXPECT_LT(glm::distance(values[i], vec3(1, 0, 0)), 1e-4f);
    }
}

TEST(EncodeS6, Rgb9e5KeepsColoursWithinItsPrecision)
{
    std::mt19937 random(5);
    std::uniform_real_distribution<float> exponent(-8.0f, 15.99f);
    ImageRgb32f page(64, 64);
    for (vec3& texel : page.texels()) {
        texel = vec3(std::exp2(exponent(random)), std::exp2(exponent(random)), std::exp2(exponent(random)));
    }
    page(0, 0) = vec3(0);
    page(1, 0) = vec3(-1, 2, 3);
    const ImageRgb32f decoded = decodeLightmap(encodeLightmap({page}, 1.0f)[0], 1.0f);
    EXPECT_EQ(decoded(0, 0), vec3(0));
    EXPECT_EQ(decoded(1, 0).x, 0.0f);
    ImageRgb32f extreme(2, 1, vec3(1e9f, 65408.0f, std::nanf("")));
    EXPECT_EQ(decodeLightmap(encodeLightmap({extreme}, 1.0f)[0], 1.0f)(0, 0), vec3(65408.0f, 65408.0f, 0.0f));
    for (std::size_t i = 2; i < page.texelCount(); ++i) {
        const vec3 a = page.data()[i];
        const float step = std::max({a.x, a.y, a.z}) / 256.0f;
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(decoded.data()[i][c], a[c], 0.51f * step);
    }
}

/// What is brighter than the format holds gets a larger unit, a power of two, so that nothing is cut and nothing loses
/// a bit; what is not keeps 1.
TEST(EncodeS6, DaylightIsNotCut)
{
    EXPECT_EQ(lightmapUnitFor({ImageRgb32f(2, 2, vec3(65408.0f))}), 1.0f);
    EXPECT_EQ(lightmapUnitFor({}), 1.0f);
    ImageRgb32f bright(3, 1, vec3(120000.0f, 100000.0f, 0.25f));
    bright(1, 0) = vec3(300000.0f);
    bright(2, 0) = vec3(kInfinity);
    const float unit = lightmapUnitFor({bright});
    EXPECT_EQ(unit, 8.0f);
    const ImageRgb32f decoded = decodeLightmap(encodeLightmap({bright}, unit)[0], unit);
    EXPECT_NEAR(decoded(0, 0).x, 120000.0f, 120000.0f / 512.0f);
    EXPECT_NEAR(decoded(0, 0).y, 100000.0f, 120000.0f / 512.0f);
    EXPECT_NEAR(decoded(1, 0).x, 300000.0f, 300000.0f / 512.0f);
    for (const float value : {3.0f, 0.01f, 12345.0f}) {
        const ImageRgb32f page(1, 1, vec3(value));
        EXPECT_EQ(decodeLightmap(encodeLightmap({page}, 4.0f)[0], 4.0f)(0, 0),
                  decodeLightmap(encodeLightmap({page}, 1.0f)[0], 1.0f)(0, 0));
    }
}

/// Texels' exact shares of light beside a straight edge become distances that are right to a tenth of a texel, at any
/// angle; a wide penumbra stays attenuation.
TEST(MaskFieldS8, HardEdgesBecomeDistancesAndSoftOnesStay)
{
    Scene scene;
    addRectangle(scene, {}, addMaterial(scene, vec3(0.5f)), kPage, {vec2(0), vec2(64)});
    const BakeGeometry geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
    const TexelMap map = rasterizeTexels(geometry, kPage, 1);
    for (const float degrees : {0.0f, 7.0f, 31.0f, 45.0f, 80.0f, 200.0f}) {
        const vec2 n(std::cos(glm::radians(degrees)), std::sin(glm::radians(degrees)));
        const auto distanceAt = [&](vec2 p) { return glm::dot(p - vec2(32.3f, 31.8f), n); };
        std::vector<vec4> mask(map.texels.size(), vec4(1.0f));
        for (std::size_t i = 0; i < mask.size(); ++i) {
            const vec2 corner(map.texels[i].x, map.texels[i].y);
            mask[i].x = 0.0f;
            for (int s = 0; s < 1024; ++s) {
                const vec2 p = corner + (vec2(s % 32, s / 32) + 0.5f) / 32.0f;
                if (distanceAt(p) > 0.0f) mask[i].x += 1.0f / 1024.0f;
            }
            mask[i].y = glm::clamp(0.5f + distanceAt(corner + 0.5f) / 12.0f, 0.0f, 1.0f);
        }
        const std::vector<vec4> before = mask;
        const auto channels = maskToDistances(map, mask);
        ASSERT_GT(channels[0].rangeTexels, 0.0f);
        EXPECT_LT(channels[0].penumbraTexels, 0.2f);
        EXPECT_EQ(channels[1].rangeTexels, 0.0f);
        EXPECT_EQ(channels[2].rangeTexels, 0.0f);
        for (std::size_t i = 0; i < mask.size(); ++i) {
            EXPECT_EQ(vec3(mask[i].y, mask[i].z, mask[i].w), vec3(before[i].y, before[i].z, before[i].w));
            const Texel& t = map.texels[i];
            if (std::min({t.x, t.y}) < 6 || std::max({t.x, t.y}) > 57) continue; // the edge goes on beyond the chart
            const float range = channels[0].rangeTexels;
            const float truth = glm::clamp(distanceAt(vec2(t.x, t.y) + 0.5f), -range, range);
            EXPECT_NEAR((2.0f * mask[i].x - 1.0f) * range, truth, 0.1f) << degrees << "° at " << t.x << ' ' << t.y;
        }
    }
}

/// Distances go on straight into the padding, so that edges do not bend at a chart's border.
TEST(DilateS8, DistancesAreExtrapolated)
{
    Scene scene;
    addRectangle(scene, {}, addMaterial(scene, vec3(0.5f)), kPage, {vec2(10), vec2(30)});
    const BakeGeometry geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
    const TexelMap map = rasterizeTexels(geometry, kPage, 1);
    std::vector<vec4> values;
    const auto plane = [](int x, int y) { return 0.5f + 0.03f * float(x - 20) - 0.02f * float(y - 20); };
    for (const Texel& t : map.texels) values.emplace_back(plane(t.x, t.y));
    const Image<vec4> page = dilate(map, values, 2, true)[0];
    for (int y = 11; y < 29; ++y) {
        for (const int x : {8, 9, 30, 31}) EXPECT_NEAR(page(x, y).x, plane(x, y), 1e-4f) << x << ' ' << y;
    }
}

/// One chart on a page: a rectangle between two corners, in texels.
struct OneChart {
    explicit OneChart(vec2 low, vec2 high)
    {
        Scene scene;
        addRectangle(scene, {}, addMaterial(scene, vec3(0.5f)), kPage, {low, high});
        geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
        map = rasterizeTexels(geometry, kPage, 1);
    }
    /// Denoises what estimateOf(texel) tells of each texel.
    template<typename EstimateOf>
    [[nodiscard]] std::vector<IrradianceEstimate> denoised(const EstimateOf& estimateOf, bool directions = false) const
    {
        std::vector<IrradianceEstimate> estimates;
        for (const Texel& texel : map.texels) estimates.push_back(estimateOf(texel));
        denoise(geometry, map, estimates, directions);
        return estimates;
    }
    void expectEven(const std::vector<IrradianceEstimate>& estimates) const ///< light of 1 everywhere
    {
        for (std::size_t i = 0; i < estimates.size(); ++i)
            EXPECT_NEAR(estimates[i].irradiance.x, 1.0f, 0.02f) << map.texels[i].x << ", " << map.texels[i].y;
    }
    [[nodiscard]] std::size_t at(int x, int y) const ///< number of a texel
    {
        const auto isThere = [&](const Texel& t) { return t.x == x && t.y == y; };
        return std::size_t(std::find_if(map.texels.begin(), map.texels.end(), isThere) - map.texels.begin());
    }
    BakeGeometry geometry;
    TexelMap map;
};

/// A page of noisy estimates of light that is known, before and after denoising.
struct NoisyPage {
    template<typename Truth> NoisyPage(const Truth& truth, float sigma, float variance)
        : NoisyPage(
              truth, [](const Texel&) { return 0.0f; }, sigma, variance)
    {}
    /// `direct`: light of baked lights beside it, without noise.
    template<typename Truth, typename Direct>
    NoisyPage(const Truth& truth, const Direct& direct, float sigma, float variance)
    {
        const auto [geometry, map] = OneChart(vec2(0), vec2(64));
        std::mt19937 random(9);
        std::normal_distribution<float> noise(0.0f, sigma);
        estimates.resize(map.texels.size());
        for (std::size_t i = 0; i < estimates.size(); ++i) {
            estimates[i].direct = vec3(direct(map.texels[i]));
            expected.push_back(truth(map.texels[i]) + estimates[i].direct.x);
            estimates[i].irradiance = vec3(expected[i] + noise(random));
            estimates[i].varianceOfMean = variance;
            estimates[i].samples = 64;
        }
        before = squares();
        denoise(geometry, map, estimates);
        after = squares();
    }
    [[nodiscard]] double squares() const
    {
        double sum = 0.0;
        for (std::size_t i = 0; i < estimates.size(); ++i)
            sum += std::pow(estimates[i].irradiance.x - expected[i], 2.0);
        return sum;
    }
    std::vector<IrradianceEstimate> estimates;
    std::vector<float> expected;
    double before = 0.0; ///< squared errors, summed
    double after = 0.0;
};

/// Noise goes, edges stay: a step in light survives the denoiser while noise around it shrinks.
TEST(DenoiseS6, SmoothsNoiseAndKeepsEdges)
{
    const NoisyPage page([](const Texel& t) { return t.x < 32 ? 1.0f : 3.0f; }, 0.1f, 0.01f);
    EXPECT_LT(page.after, page.before / 20.0);
    for (std::size_t i = 0; i < page.estimates.size(); ++i)
        EXPECT_NEAR(page.estimates[i].irradiance.x, page.expected[i], 0.2f);
}

/// Even light comes out even: no blotches of the size of the first levels' kernels stay.
TEST(DenoiseS6, LeavesNoBlotchesOnEvenLight)
{
    const NoisyPage page([](const Texel&) { return 1.0f; }, 0.1f, 0.01f);
    EXPECT_LT(std::sqrt(page.after / double(page.estimates.size())), 0.01);
}

/// Light that falls off across a wall is smoothed across its slope too, not along lines of equal light alone (which
/// leaves 0.048).
TEST(DenoiseS6, SlopesAreSmoothedAcross)
{
    const auto slope = [](const Texel& t) { return 1.0f + 0.04f * float(t.x) + 0.02f * float(t.y); };
    const NoisyPage page(slope, 0.1f, 0.01f);
    EXPECT_LT(std::sqrt(page.after / double(page.estimates.size())), 0.036);
}

/// Single sunlit texels among unlit ones are no outliers, and the noise of other light beside them goes.
TEST(DenoiseS6, SunlightIsNoNoise)
{
    const auto sun = [](const Texel& t) { return t.x % 5 == 0 && t.y % 3 == 0 ? 0.4f : 0.0f; };
    const NoisyPage page([](const Texel&) { return 1.0f; }, sun, 0.1f, 0.01f);
    EXPECT_LT(page.after, page.before / 50.0);
    for (std::size_t i = 0; i < page.estimates.size(); ++i)
        EXPECT_NEAR(page.estimates[i].irradiance.x, page.expected[i], 0.2f);
}

/// A texel at the rim of a surface that is brighter than all others, and whose blocks agree, stays; one whose blocks do
/// not agree does not.
TEST(DenoiseS6, BrightRimsAreNoOutliers)
{
    const OneChart chart(vec2(4.0f, 4.7f), vec2(60));
    for (const bool agree : {true, false}) {
        const auto estimates = chart.denoised([&](const Texel& t) {
            const bool bright = t.y == 4 && t.x == 30;
            IrradianceEstimate e;
            e.irradiance = vec3(bright ? 2.0f : 1.0f);
            e.varianceOfMean = bright && !agree ? 0.9f : 0.0004f;
            e.samples = 64;
            return e;
        });
        EXPECT_NEAR(estimates[chart.at(30, 4)].irradiance.x, agree ? 2.0f : 1.0f, 0.1f);
    }
}

/// Where only every other texel is traced, those between have a share of what a lucky path brought the one beside them.
TEST(DenoiseS6, OutliersGoFromTexelsBetween)
{
    const OneChart chart(vec2(4), vec2(60));
    const auto lightAt = [](int x, int y) { return (x == 30 || x == 32) && y == 30 ? 20.0f : 1.0f; };
    chart.expectEven(chart.denoised([&](const Texel& t) {
        const int x = t.x;
        const int y = t.y;
        const bool odd = x == 41 && y == 41; // traced for some reason, without others around
        const bool isTraced = odd || (x % 2 == 0 && y % 2 == 0);
        // The mean of two or four.
        const float shared = 0.25f * (lightAt(x & ~1, y & ~1) + lightAt((x + 1) & ~1, y & ~1) +
                                      lightAt(x & ~1, (y + 1) & ~1) + lightAt((x + 1) & ~1, (y + 1) & ~1));
        const float mean = odd ? 20.0f : shared;
        const float excess = mean - 1.0f;
        IrradianceEstimate e;
        e.irradiance = vec3(mean);
        e.varianceOfMean = excess * excess + 0.0004f;
        e.samples = isTraced ? 256 : 0;
        return e;
    }));
}

/// Rows of traced texels with rows between: of 5 x 5, too few are traced to tell two dots from light.
TEST(DenoiseS6, OutliersGoWhereHalfLieBetween)
{
    const OneChart chart(vec2(4), vec2(60));
    const auto lightAt = [](int x, int y) { return (x == 30 || x == 32) && y == 30 ? 2.0f : 1.0f; };
    chart.expectEven(chart.denoised([&](const Texel& t) {
        const bool isTraced = t.y % 2 == 0;
        const float shared = 0.5f * (lightAt(t.x, t.y - 1) + lightAt(t.x, t.y + 1));
        IrradianceEstimate e;
        e.irradiance = vec3(isTraced ? lightAt(t.x, t.y) : shared);
        e.varianceOfMean = 0.0004f;
        e.samples = isTraced ? 32 : 0;
        return e;
    }));
}

/// Texels that differ from all around though their blocks agree: some side by side, from (30, 30) on.
struct OddTexels {
    int width;
    int height;
    float light; ///< all others have 1
    uint32_t samples;
    float expected;

    [[nodiscard]] IrradianceEstimate estimateOf(const Texel& t) const
    {
        const bool odd = t.x >= 30 && t.x < 30 + width && t.y >= 30 && t.y < 30 + height;
        const vec3 color(0.5f, 1.0f, 2.0f);
        IrradianceEstimate e;
        e.irradiance = color * ((odd ? light : 1.0f) / luminance(color));
        e.moment = vec3(0.0f, 0.5f, 0.0f) * (odd ? light : 1.0f);
        e.varianceOfMean = 0.0004f;
        e.samples = samples;
        return e;
    }
    void check(const OneChart& chart, float tolerance) const
    {
        SCOPED_TRACE(testing::Message() << width << " x " << height << " of " << light << ", " << samples
                                        << " samples");
        const auto estimates = chart.denoised([&](const Texel& t) { return estimateOf(t); }, true);
        const IrradianceEstimate& e = estimates[chart.at(30 + width / 2, 30 + height / 2)];
        EXPECT_NEAR(luminance(e.irradiance), expected, tolerance);
        EXPECT_NEAR(e.irradiance.x / e.irradiance.z, 0.25f, 0.01f);
        EXPECT_NEAR(e.moment.y, 0.5f * expected, tolerance);
    }
};

/// A texel, or two side by side, brighter than all around though its blocks agree: that is luck when these are few, and
/// light when they are many or when more texels have it.
TEST(DenoiseS6, FewBlocksAgreeByChance)
{
    const OneChart chart(vec2(4), vec2(60));
    for (const OddTexels& bright :
         {OddTexels{1, 1, 2.0f, 32, 1.0f}, {2, 1, 2.0f, 32, 1.0f}, {2, 2, 2.0f, 32, 2.0f}, {1, 1, 2.0f, 256, 2.0f}})
        bright.check(chart, 0.1f);
}

/// The same of one that is darker.
TEST(DenoiseS6, DarkSpecksGoAndShadowsStay)
{
    const OneChart chart(vec2(4), vec2(60));
    for (const OddTexels& dark : {OddTexels{1, 1, 0.5f, 32, 1.0f},
                                  {1, 1, 0.0f, 32, 1.0f},
                                  {2, 2, 0.5f, 32, 0.5f},
                                  {8, 1, 0.5f, 32, 0.5f},
                                  {1, 1, 0.5f, 256, 0.5f}})
        dark.check(chart, 0.05f);
}

/// Few rays of many texels meet something bright: texels in which one did, and whose variance says so, do not stay
/// brighter than the others, be they one in fifty or every other one.
TEST(DenoiseS6, SpreadsDotsThatAreMany)
{
    const auto [geometry, map] = OneChart(vec2(4), vec2(60));
    constexpr int kParts = 8; // of a texel's samples, which tell of its variance
    constexpr float kHit = 4.0f;
    for (const float share : {0.02f, 0.05f, 0.1f, 0.15f, 0.2f, 0.3f, 0.5f}) {
        SCOPED_TRACE(testing::Message() << share << " of the texels");
        std::mt19937 random(11);
        std::uniform_real_distribution<float> unit;
        std::normal_distribution<float> noise(0.0f, 0.05f);
        std::vector<IrradianceEstimate> estimates(map.texels.size());
        for (IrradianceEstimate& e : estimates) {
            float sum = 0.0f;
            float squares = 0.0f;
            for (int part = 0; part < kParts; ++part) {
                const float value = 1.0f + noise(random) + (unit(random) < share / float(kParts) ? kHit : 0.0f);
                sum += value;
                squares += value * value;
            }
            const float mean = sum / float(kParts);
            e.irradiance = vec3(mean);
            e.varianceOfMean = (squares / float(kParts) - mean * mean) / float(kParts - 1);
            e.samples = 256;
        }
        denoise(geometry, map, estimates);
        // Away from the rim, where fewer are around.
        int dots = 0;
        for (std::size_t i = 0; i < estimates.size(); ++i) {
            const Texel& t = map.texels[i];
            if (t.x < 8 || t.x >= 56 || t.y < 8 || t.y >= 56) continue;
            const float expected = 1.0f + share * kHit / float(kParts);
            dots += estimates[i].irradiance.x > expected + 0.4f * kHit / float(kParts) ? 1 : 0;
        }
        EXPECT_LE(dots, 2);
    }
}

/// First moments are denoised where a directional lightmap needs them, as their light is; light is the same either way.
TEST(DenoiseS6, DirectionsAreDenoisedWhereAskedFor)
{
    const auto [geometry, map] = OneChart(vec2(0), vec2(64));
    std::mt19937 random(5);
    constexpr float kSigma = 0.1f;
    std::normal_distribution<float> noise(0.0f, kSigma);
    std::vector<IrradianceEstimate> noisy(map.texels.size());
    for (IrradianceEstimate& e : noisy) {
        e.irradiance = vec3(1.0f + noise(random));
        e.moment = vec3(noise(random), 0.5f + noise(random), noise(random));
        e.varianceOfMean = kSigma * kSigma;
        e.samples = 64;
    }
    std::vector<IrradianceEstimate> with = noisy;
    std::vector<IrradianceEstimate> without = noisy;
    denoise(geometry, map, with, true);
    denoise(geometry, map, without, false);
    const auto squares = [&](const std::vector<IrradianceEstimate>& estimates) {
        double sum = 0.0;
        for (const IrradianceEstimate& e : estimates)
            sum += double(glm::dot(e.moment - vec3(0, 0.5f, 0), e.moment - vec3(0, 0.5f, 0)));
        return sum;
    };
    EXPECT_LT(squares(with), 0.1 * squares(noisy));
    for (std::size_t i = 0; i < noisy.size(); ++i) {
        ASSERT_EQ(with[i].irradiance, without[i].irradiance);
        ASSERT_EQ(with[i].varianceOfMean, without[i].varianceOfMean);
    }
    EXPECT_GT(squares(without), 0.5 * squares(noisy));
}

/// A contact shadow, steep at the foot: where texels state far more variance than their noise has, as well-spread
/// samples do, what their neighbours show counts, and the shadow stays.
TEST(DenoiseS6, TrustsNeighboursMoreThanStatedVariance)
{
    const auto truth = [](const Texel& t) {
        const float texels = std::abs(float(t.x) - 20.0f);
        return 1.0f - 0.15f * std::exp(-texels);
    };
    for (const float stated : {1.0f, 9.0f}) {
        const NoisyPage page(truth, 0.02f, 0.02f * 0.02f * stated);
        EXPECT_LT(page.after, 0.12 * page.before) << "variance stated " << stated << " times too high";
    }
}

namespace {

/// A plane cut into two charts, as wide in texels as told, each of which holds light of its own: lightAt(left, texels
/// up from the foot of the cut).
struct CutPlane {
    static constexpr vec2 kLeft{4.3f, 4.6f};
    static constexpr vec2 kRight{30.8f, 30.1f};
    template<typename LightAt> CutPlane(float texels, const LightAt& lightAt)
    {
        const int grey = addMaterial(scene, vec3(0.5f));
        const vec2 size(texels, 16.0f);
        const vec3 across(texels / 16.0f, 0, 0);
        addRectangle(scene, {vec3(0, 0, 0), across, vec3(0, 0, -1)}, grey, kPage, {kLeft, kLeft + size});
        addRectangle(scene, {across, across, vec3(0, 0, -1)}, grey, kPage, {kRight, kRight + size});
        const BakeGeometry geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
        map = rasterizeTexels(geometry, kPage, 1);
        std::vector<vec3> values;
        for (const Texel& t : map.texels) {
            const bool left = t.x < 25;
            values.push_back(lightAt(left, float(t.y) + 0.5f - (left ? kLeft.y : kRight.y)));
        }
        pages = dilate(map, values, 2);
        before = pages[0];
        seams = findSeams(geometry, kPage);
        stitchSeams(map, seams, seamWeights(seams, pages), pages);
    }
    CutPlane(vec3 left, vec3 right) : CutPlane(16.0f, [&](bool isLeft, float) { return isLeft ? left : right; }) {}
    [[nodiscard]] vec3 bilinear(vec2 place) const
    {
        const vec2 p = place - 0.5f;
        const ivec2 b(glm::floor(p));
        const vec2 f = p - vec2(b);
        return glm::mix(glm::mix(pages[0](b.x, b.y), pages[0](b.x + 1, b.y), f.x),
                        glm::mix(pages[0](b.x, b.y + 1), pages[0](b.x + 1, b.y + 1), f.x), f.y);
    }

    Scene scene;
    TexelMap map;
    std::vector<SeamSample> seams;
    std::vector<Image<vec3>> pages;
    Image<vec3> before;
};

} // namespace

/// Light that both sides of a cut hold with an offset: after stitching the bilinear values on both sides agree to a
/// hundredth, and texels away from it are untouched.
TEST(SeamsS6, BothSidesAgree)
{
    const CutPlane plane(vec3(2.1f, 1.0f, 0.4f), vec3(1.9f, 1.0f, 0.6f));
    ASSERT_GE(plane.seams.size(), 16u);
    for (const SeamSample& seam : plane.seams) {
        const vec3 a = plane.bilinear(seam.texelA);
        const vec3 b = plane.bilinear(seam.texelB);
        EXPECT_NEAR(a.x, b.x, 0.01f * 2.0f);
        EXPECT_NEAR(a.x, 2.0f, 0.06f);
        EXPECT_NEAR(a.z, b.z, 0.01f);
    }
    for (int y = 6; y < 19; ++y) EXPECT_EQ(plane.pages[0](10, y), plane.before(10, y));
}

/// Both sides of a cut have the same shadow across it, and nearly agree; but their texels lie differently along the
/// cut, so that bilinear light can only be the same on both where it runs straight. Charts of a few texels must not
/// lose their shadow for that: padding gives way, and the light of what is covered stays.
TEST(SeamsS6, NarrowChartsKeepTheirLight)
{
    for (const float texels : {2.0f, 3.0f, 5.0f}) {
        SCOPED_TRACE(testing::Message() << texels << " texels wide");
        const CutPlane plane(texels,
                             [](bool, float up) { return vec3(1.0f - 0.6f * glm::smoothstep(6.0f, 9.0f, up)); });
        double steps = 0.0;
        for (const SeamSample& seam : plane.seams)
            steps += double(std::abs(plane.bilinear(seam.texelA).x - plane.bilinear(seam.texelB).x));
        EXPECT_LT(steps / double(plane.seams.size()), 0.01);
        double squares = 0.0;
        for (const Texel& t : plane.map.texels) {
            const double change = double(plane.pages[0](t.x, t.y).x - plane.before(t.x, t.y).x);
            EXPECT_LT(std::abs(change), 0.1) << t.x << ", " << t.y;
            squares += change * change;
        }
        EXPECT_LT(std::sqrt(squares / double(plane.map.texels.size())), 0.02);
    }
}

/// Where one side lies in the sun and the other in the shade, something must stand on the cut: no light comes over.
TEST(SeamsS6, SunIsNotStitchedToShade)
{
    for (const float shade : {0.0f, 0.001f, 0.3f}) {
        const CutPlane plane(vec3(1.0f), vec3(shade));
        for (const SeamSample& seam : plane.seams) {
            EXPECT_NEAR(plane.bilinear(seam.texelA).x, 1.0f, 0.02f);
            EXPECT_NEAR(plane.bilinear(seam.texelB).x, shade, 0.02f);
        }
    }
}

/// The two sides of a curtain meet in a hem whose normals are as smooth as a bend's. The bend is a seam, the hem is
/// not.
TEST(SeamsS6, HemsAreCorners)
{
    for (const float degrees : {20.0f, 60.0f, 150.0f, 180.0f}) {
        const float angle = glm::radians(degrees);
        Scene scene;
        const int grey = addMaterial(scene, vec3(0.5f));
        const vec3 normal(std::sin(0.5f * angle), 0, std::cos(0.5f * angle));
        const auto bend = [&] {
            MeshPart& part = scene.meshes.back().parts[0];
            for (std::size_t v = 0; v < part.positions.size(); ++v) {
                if (part.positions[v].x == 1.0f && part.positions[v].z == 0.0f) part.normals[v] = normal;
            }
        };
        addRectangle(scene, {vec3(0), vec3(1, 0, 0), vec3(0, 1, 0)}, grey, kPage, {vec2(4), vec2(20)});
        bend();
        addRectangle(scene, {vec3(1, 0, 0), vec3(std::cos(angle), 0, -std::sin(angle)), vec3(0, 1, 0)}, grey, kPage,
                     {vec2(30), vec2(46)});
        bend();
        const BakeGeometry geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
        EXPECT_EQ(findSeams(geometry, kPage).empty(), degrees > 90.0f) << degrees;
    }
}

/// Neighbours that are cut differently, and one that is not quite where it should be: every place along the common line
/// has its sample, and both its sides are the same place in the world.
TEST(SeamsS6, EdgesThatShareOnlyAStretchAreFound)
{
    Scene scene;
    const int grey = addMaterial(scene, vec3(0.5f));
    addRectangle(scene, {vec3(0, 0, 0), vec3(3, 0, 0), vec3(0, 0, -1)}, grey, kPage, {vec2(2), vec2(32, 12)});
    const float ends[] = {0.5f, 1.25f, 2.0f, 3.5f}; // the last one stands out
    for (int i = 0; i < 3; ++i) {
        const vec3 origin(ends[i], i == 1 ? 0.0005f : 0.0f, 1.0f);
        addRectangle(scene, {origin, vec3(ends[i + 1] - ends[i], 0, 0), vec3(0, 0, -1)}, grey, kPage,
                     {vec2(2 + 16 * i, 20), vec2(2 + 16 * i + 10 * (ends[i + 1] - ends[i]), 30)});
    }
    // A wall on the same line is a corner, a shelf above it another line.
    addRectangle(scene, {vec3(0, 0, 0), vec3(2, 0, 0), vec3(0, 1, 0)}, grey, kPage, {vec2(2, 40), vec2(22, 50)});
    addRectangle(scene, {vec3(0, 0.1f, 0), vec3(2, 0, 0), vec3(0, 0, 1)}, grey, kPage, {vec2(30, 40), vec2(50, 50)});
    const std::vector<SeamSample> seams = findSeams(flattenGeometry(scene, kPage, GeometryFilter::Static), kPage);
    std::vector<float> places;
    for (const SeamSample& seam : seams) {
        const bool first = seam.texelA.y < 15.0f;
        const vec2 wide = first ? seam.texelA : seam.texelB;
        const vec2 cut = first ? seam.texelB : seam.texelA;
        const int piece = int((cut.x - 2.0f) / 16.0f);
        if (wide.y > 15.0f && wide.y < 35.0f && cut.y < 35.0f) continue; // between the three
        ASSERT_LT(wide.y, 15.0f);
        ASSERT_LT(cut.y, 35.0f) << "floor only";
        const float x = (wide.x - 2.0f) / 10.0f;
        EXPECT_NEAR(x, ends[piece] + (cut.x - 2.0f - 16.0f * float(piece)) / 10.0f, 1.0e-3f);
        places.push_back(x);
    }
    std::sort(places.begin(), places.end());
    ASSERT_FALSE(places.empty());
    EXPECT_NEAR(places.front(), 0.5f, 0.06f);
    EXPECT_NEAR(places.back(), 3.0f, 0.06f);
    for (std::size_t i = 1; i < places.size(); ++i) EXPECT_LT(places[i] - places[i - 1], 0.1f);
}

/// A box's edges are corners, not seams: its faces keep their own light.
TEST(SeamsS6, HardEdgesAreLeftAlone)
{
    Scene scene;
    addBox(scene, vec3(-1), vec3(1), addMaterial(scene, vec3(0.5f)), false, kPage);
    EXPECT_TRUE(findSeams(flattenGeometry(scene, kPage, GeometryFilter::Static), kPage).empty());
}

TEST(DeterminismS6, ThreadCountChangesNoBit)
{
    std::vector<IrradianceEstimate> reference;
    std::vector<vec4> referenceMask;
    for (const int threads : {1, 2, 5}) {
        const ThreadLimit limit(threads);
        Scene scene;
        scene.sky = {vec3(1), vec3(0.5f), vec3(0.1f)};
        addBox(scene, vec3(-1), vec3(1), addMaterial(scene, vec3(0.5f), vec3(0.1f)), true, kPage);
        addBox(scene, vec3(-0.3f), vec3(0.3f), addMaterial(scene, vec3(0.5f)), false);
        scene.lights.push_back(pointAt("p", vec3(0.7f), 5.0f));
        Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, {});
        const auto estimates = bench.irradiance();
        const auto mask = bench.shadowmask();
        if (reference.empty()) {
            reference = estimates;
            referenceMask = mask;
        }
        for (std::size_t i = 0; i < estimates.size(); ++i) {
            ASSERT_EQ(estimates[i].irradiance, reference[i].irradiance);
            ASSERT_EQ(mask[i], referenceMask[i]);
        }
    }
}

/// Closed outward boxes are solids, rooms (inward) and boxes without a lid are not.
TEST(GeometryS6, SolidsAreClosedAndFaceOutward)
{
    const auto solids = [](bool inward, bool lid) {
        Scene scene;
        addBox(scene, vec3(-1, -2, -3), vec3(1, 2, 3), addMaterial(scene, vec3(0.5f), vec3(0), true), inward);
        // One mesh of all faces, as a modeller would have it.
        for (std::size_t i = 1; i < scene.meshes.size(); ++i) {
            if (i == 3 && !lid) continue;
            scene.meshes[0].parts.push_back(scene.meshes[i].parts[0]);
        }
        scene.objects.resize(1);
        return flattenGeometry(scene, kPage, GeometryFilter::Static).solid;
    };
    EXPECT_EQ(solids(false, true), std::vector<uint8_t>(12, 1));
    EXPECT_EQ(solids(true, true), std::vector<uint8_t>(12, 0));
    EXPECT_EQ(solids(false, false), std::vector<uint8_t>(10, 0));

    // A box whose six faces are objects of their own is closed all the same.
    Scene scene;
    addBox(scene, vec3(-1, -2, -3), vec3(1, 2, 3), addMaterial(scene, vec3(0.5f), vec3(0), true), false);
    EXPECT_EQ(flattenGeometry(scene, kPage, GeometryFilter::Static).solid, std::vector<uint8_t>(12, 1));
}

// A hollow body is two closed surfaces; the inner one belongs to the solid, a room that faces inward in no solid does
// not.
TEST(GeometryS6, CavitiesBelongToTheirSolid)
{
    const auto solids = [](vec3 innerCenter) {
        Scene scene;
        const int grey = addMaterial(scene, vec3(0.5f));
        addBox(scene, vec3(-3), vec3(3), grey, false);
        addBox(scene, innerCenter - vec3(2), innerCenter + vec3(2), grey, true);
        joinObjects(scene, 0);
        return flattenGeometry(scene, kPage, GeometryFilter::Static).solid;
    };
    EXPECT_EQ(solids(vec3(0)), std::vector<uint8_t>(24, 1));
    std::vector<uint8_t> beside(24, 0);
    std::fill(beside.begin(), beside.begin() + 12, uint8_t(1));
    EXPECT_EQ(solids(vec3(20, 0, 0)), beside);
    EXPECT_EQ(solids(vec3(2, 2, 2)), beside) << "reaches out of the solid";
}

/// A closed box whose faces look inward, with nothing and no light inside, is a modeller's slip where its material has
/// two sides: it has its light where it is seen from. A room is not.
TEST(GeometryS6, ThingsThatAreInsideOutAreTurned)
{
    struct Case {
        const char* what;
        bool doubleSided = true;
        bool alone = false;
        bool boxInside = false;
        bool onePart = false;
        bool lightInside = false;
        bool cameraInside = false;
        bool glows = false;
        bool turned = false;
    };
    const Case cases[] = {
        {.what = "empty", .turned = true},
        {.what = "one-sided", .doubleSided = false},
        {.what = "the whole scene", .alone = true},
        {.what = "furnished", .boxInside = true},
        {.what = "lit", .lightInside = true},
        {.what = "looked at from inside", .cameraInside = true},
        {.what = "glowing", .glows = true},
        {.what = "furnished, of one part", .boxInside = true, .onePart = true},
    };
    for (const Case& c : cases) {
        SCOPED_TRACE(c.what);
        Scene scene;
        scene.sky = {vec3(1), vec3(1), vec3(1)};
        const int grey = addMaterial(scene, vec3(0.0f), vec3(c.glows ? 1.0f : 0.0f), c.doubleSided);
        addBox(scene, vec3(-1), vec3(1), grey, true, kPage);
        if (!c.alone) addBox(scene, vec3(50, -1, -1), vec3(52, 1, 1), grey, false);
        if (c.boxInside) addBox(scene, vec3(-0.5f), vec3(0.5f), grey, false);
        // The box is one mesh, as a modeller would have it; of one part with what is inside, or of one for each face.
        const std::size_t joined = c.onePart ? scene.meshes.size() : 6;
        for (std::size_t i = 1; i < joined; ++i) {
            const MeshPart& from = scene.meshes[i].parts[0];
            MeshPart& to = scene.meshes[0].parts[0];
            if (!c.onePart) {
                scene.meshes[0].parts.push_back(from);
                continue;
            }
            const auto first = uint32_t(to.positions.size());
            for (const uint32_t index : from.indices) to.indices.push_back(first + index);
            to.positions.insert(to.positions.end(), from.positions.begin(), from.positions.end());
            to.normals.insert(to.normals.end(), from.normals.begin(), from.normals.end());
            to.uv[0].insert(to.uv[0].end(), from.uv[0].begin(), from.uv[0].end());
            to.lightmapUv.insert(to.lightmapUv.end(), from.lightmapUv.begin(), from.lightmapUv.end());
            to.lightmapUv.resize(to.positions.size()); // none where it has none
        }
        scene.objects.erase(scene.objects.begin() + 1, scene.objects.begin() + std::ptrdiff_t(joined));
        if (c.lightInside) scene.lights.push_back(pointAt("p", vec3(0.5f), 1.0f));
        if (c.cameraInside) scene.cameras.push_back({.name = "c"});
        Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, {.samples = 16, .bounces = 0});
        const std::vector<uint8_t>& turned = bench.geometry.turned;
        EXPECT_EQ(std::count(turned.begin(), turned.end(), 1), c.turned ? 12 : 0);
        EXPECT_EQ(bench.geometry.solid[0] != 0, c.turned);
        EXPECT_GT(glm::dot(bench.geometry.normals[0], bench.geometry.geometricNormal(0)), 0.99f);
        EXPECT_EQ(glm::dot(bench.geometry.geometricNormal(0), bench.geometry.centroid(0)) > 0.0f, c.turned);
        if (c.lightInside || c.glows) continue;
        const std::vector<IrradianceEstimate> estimates = bench.irradiance();
        EXPECT_TRUE(std::any_of(estimates.begin(), estimates.end(), [](const auto& e) { return e.valid; }));
        for (const IrradianceEstimate& e : estimates) {
            if (e.valid) EXPECT_NEAR(e.irradiance.x, c.turned ? kPi : 0.0f, 0.1f);
        }
    }
}

TEST(GeometryS6, MirroredAndShearedObjectsKeepOutwardNormals)
{
    Scene scene;
    addBox(scene, vec3(-1), vec3(1), addMaterial(scene, vec3(0.5f)), false);
    mat4 transform(1.0f);
    transform[0] = vec4(-2, 0, 0.5f, 0);
    transform[1] = vec4(0.3f, 1, 0, 0);
    transform[2] = vec4(0, 0.2f, 0.5f, 0);
    for (Object& object : scene.objects) object.worldFromObject = transform;
    const BakeGeometry geometry = flattenGeometry(scene, kPage, GeometryFilter::Static);
    for (uint32_t t = 0; t < geometry.triangles.size(); ++t) {
        const SurfacePoint p = surfacePoint(geometry, t, vec2(1.0f / 3.0f));
        EXPECT_GT(glm::dot(p.geometricNormal, p.position), 0.0f);
        EXPECT_NEAR(glm::dot(p.geometricNormal, p.normal), 1.0f, 1e-5f);
    }
}

} // namespace
} // namespace halflight::test
