#include "plan_scene.h"
#include "render/frame/frame_internal.h"

#include <bit>
#include <gtest/gtest.h>

namespace halflight::tiles_test {
namespace {

using namespace test;

struct Square {
    ivec2 offset;
    int size;
};

void expectDisjointInside(const std::vector<Square>& squares, int side)
{
    for (std::size_t i = 0; i < squares.size(); ++i) {
        const Square& a = squares[i];
        EXPECT_GE(std::min(a.offset.x, a.offset.y), 0);
        EXPECT_LE(std::max(a.offset.x, a.offset.y) + a.size, side);
        for (std::size_t j = 0; j < i; ++j) {
            const Square& b = squares[j];
            const bool apart = a.offset.x + a.size <= b.offset.x || b.offset.x + b.size <= a.offset.x ||
                               a.offset.y + a.size <= b.offset.y || b.offset.y + b.size <= a.offset.y;
            ASSERT_TRUE(apart) << "tiles " << i << " and " << j;
        }
    }
}

TEST(AtlasS3, TilesNeverOverlap)
{
    Random random(1);
    for (int n = 0; n < 200; ++n) {
        const int side = 256 << random.generator()() % 5;
        std::vector<AtlasRequest> requests(random.generator()() % 60);
        for (AtlasRequest& request : requests) {
            request = {random.generator()() % 2 ? 6 : 1, 64 << random.generator()() % 6};
        }
        const AtlasPlacement placement = placeTiles(requests, side);
        std::vector<Square> squares;
        for (std::size_t i = 0; i < requests.size(); ++i) {
            const int size = placement.sizes[i];
            ASSERT_EQ(placement.offsets[i].size(), size > 0 ? std::size_t(requests[i].count) : 0u)
                << "all tiles of a light or none";
            if (size > 0) {
                EXPECT_TRUE(std::has_single_bit(unsigned(size)));
                EXPECT_GE(size, kMinTileSize);
                EXPECT_LE(size, std::max(requests[i].size, kMinTileSize));
            }
            for (const ivec2 offset : placement.offsets[i]) squares.push_back({offset, size});
        }
        expectDisjointInside(squares, side);
    }
}

TEST(AtlasS3, FullAtlasIsUsedToTheLastTexel)
{
    // Four quarters fill it exactly: nothing is halved.
    const std::vector<AtlasRequest> four(4, {1, 512});
    EXPECT_EQ(placeTiles(four, 1024).sizes, std::vector<int>(4, 512));
    // A fifth makes room at the cost of the least important.
    const std::vector<AtlasRequest> five(5, {1, 512});
    const AtlasPlacement placement = placeTiles(five, 1024);
    EXPECT_EQ(placement.sizes, (std::vector<int>{512, 512, 512, 256, 256}));
    // A map that is no power of two is used up to the one below.
    EXPECT_EQ(placeTiles(four, 1900).sizes, std::vector<int>(4, 512));
}

TEST(AtlasS3, LeastImportantGoWithoutWhenFull)
{
    const std::vector<AtlasRequest> requests(20, {1, 256}); // 16 smallest tiles fit in 256 x 256
    const AtlasPlacement placement = placeTiles(requests, 256);
    for (std::size_t i = 0; i < 20; ++i) EXPECT_EQ(placement.sizes[i], i < 16 ? 64 : 0) << i;
}

BakedScene room()
{
    BakedScene baked = emptyScene();
    addBox(baked, {0, -1, 0}, {30, 1, 30}, true);
    addBox(baked, {0, 1, 0}, {0.5f, 1, 0.5f}, false);
    return baked;
}
FrameView roomView()
{
    return lookFrom({0, 5, 14}, {0, -0.3f, -1});
}

TEST(AtlasS3, LightsThatGetNoTileAreNamed)
{
    BakedScene baked = room();
    for (int i = 0; i < 40; ++i) {
        Light spot = bakedLight("spot " + std::to_string(i), LightType::Spot, {0.01f * float(i), 6, 0}, {0, -1, 0},
                                LightMode::Mixed, 0);
        spot.intensity = float(100 - i);
        baked.scene.lights.push_back(spot);
    }
    ShadowSettings settings;
    settings.atlasSize = 256;
    const FramePlan frame = plan(baked, roomView(), RunMode::Shadowmask, settings);
    int without = 0;
    for (const FrameLight& light : frame.lights) {
        const std::string name =
            "light \"" + baked.scene.lights[std::size_t(light.light)].name + "\" gets no realtime shadow";
        EXPECT_EQ(anyWarning(frame, name), !light.hasRealtimeShadow);
        EXPECT_TRUE(light.hasBaked);
        without += light.hasRealtimeShadow ? 0 : 1;
    }
    EXPECT_EQ(without, 40 - 16);
    EXPECT_TRUE(frame.lights[0].hasRealtimeShadow) << "the most important keeps its";
    std::vector<Square> squares;
    for (const ShadowTile& tile : frame.tiles) squares.push_back({tile.atlasOffset, tile.size});
    expectDisjointInside(squares, 256);
}

TEST(AtlasS3, NearLightsGetMoreTexels)
{
    BakedScene baked = room();
    addBox(baked, {0, 1, -26}, {0.5f, 1, 0.5f}, false);
    Light near = bakedLight("near", LightType::Spot, {0, 4, 0}, {0, -1, 0}, LightMode::Realtime, -1);
    near.rangeMeters = 5;
    Light far = near;
    far.name = "far";
    far.worldFromLight = pose({0, 4, -26}, {0, -1, 0});
    baked.scene.lights = {far, near};
    const FramePlan frame = plan(baked, roomView(), RunMode::Realtime);
    const FrameLight* nearLight = find(baked, frame, "near");
    const FrameLight* farLight = find(baked, frame, "far");
    ASSERT_TRUE(nearLight->hasRealtimeShadow && farLight->hasRealtimeShadow);
    EXPECT_GT(frame.tiles[std::size_t(nearLight->firstTile)].size, frame.tiles[std::size_t(farLight->firstTile)].size);
}

/// Texel coordinates and depth of a point in a tile; w <= 0 gives a negative depth.
vec3 texelOf(const ShadowTile& tile, vec3 world)
{
    const vec4 clip = tile.clipFromWorld * vec4(world, 1.0f);
    if (clip.w <= 0.0f) return vec3(-1.0f);
    return {(0.5f * clip.x / clip.w + 0.5f) * float(tile.size), (0.5f * clip.y / clip.w + 0.5f) * float(tile.size),
            clip.z / clip.w};
}

int faceOf(vec3 d)
{
    const vec3 a = glm::abs(d);
    if (a.x >= a.y && a.x >= a.z) return d.x >= 0 ? 0 : 1;
    if (a.y >= a.z) return d.y >= 0 ? 2 : 3;
    return d.z >= 0 ? 4 : 5;
}

// Brute force: every lit point is in the tile it looks up, away from the border by the filter's reach.
TEST(LocalTilesS3, HoldEveryPointTheLightReaches)
{
    Random random(2);
    for (int n = 0; n < 300; ++n) {
        Light light = bakedLight("l", n % 3 == 0 ? LightType::Point : LightType::Spot, random.in(vec3(-5), vec3(5)),
                                 random.direction(), LightMode::Realtime, -1);
        light.rangeMeters = random.in(1.0f, 20.0f);
        light.outerConeRadians = random.in(0.02f, kPi / 2);
        ShadowSettings settings;
        settings.filter = ShadowFilter(n % 3);
        const int size = 64 << n % 4;
        Bounds scene;
        scene.extend(vec3(-40));
        scene.extend(vec3(40));
        std::vector<ShadowTile> tiles;
        for (int face = 0; face < localTileCount(light); ++face) {
            tiles.push_back(fitLocalTile(light, face, size, settings, scene));
        }
        const auto border = float(filterReachTexels(settings.filter));
        for (int i = 0; i < 300; ++i) {
            const vec3 d = random.direction();
            if (light.type == LightType::Spot && glm::dot(d, light.direction()) < std::cos(light.outerConeRadians))
                continue;
            const float distance = random.in(0.05f, light.rangeMeters);
            const vec3 p = light.position() + d * distance;
            const vec3 t = texelOf(tiles.size() == 6 ? tiles[std::size_t(faceOf(d))] : tiles[0], p);
            ASSERT_GE(std::min(t.x, t.y), border - 0.01f) << n;
            ASSERT_LE(std::max(t.x, t.y), float(size) - border + 0.01f) << n;
            ASSERT_LE(t.z, 1.0f + 1e-5f);
            if (glm::dot(d, tiles.size() == 6 ? glm::normalize(d) : light.direction()) * distance > 0.1f) {
                ASSERT_GE(t.z, -1e-4f);
            }
        }
    }
}

TEST(LocalTilesS3, TexelMetersAndDepthRange)
{
    Light light = bakedLight("l", LightType::Spot, {1, 2, 3}, {0, -1, 0}, LightMode::Realtime, -1);
    light.rangeMeters = 8;
    light.outerConeRadians = 0.6f;
    Bounds scene;
    scene.extend(vec3(-10));
    scene.extend(vec3(10));
    const ShadowTile tile = fitLocalTile(light, 0, 256, {}, scene);
    const float moved = glm::length(vec2(texelOf(tile, {1.1f, 1, 3})) - vec2(texelOf(tile, {1, 1, 3})));
    EXPECT_NEAR(moved * tile.texelMeters, 0.1f, 1e-4f);
    EXPECT_NEAR(texelOf(tile, {1, 2 - tile.nearMeters, 3}).z, 0.0f, 1e-4f);
    EXPECT_NEAR(texelOf(tile, {1, 2 - tile.farMeters, 3}).z, 1.0f, 1e-4f);
    EXPECT_NEAR(tile.farMeters, 8.0f, 1e-5f);
    // A lamp's own shell, within the source's radius, casts no shadow.
    light.radiusMeters = 0.2f;
    EXPECT_GE(fitLocalTile(light, 0, 256, {}, scene).nearMeters, 0.2f);
}

// Brute force: an object with a lit point inside a tile is in its list.
TEST(CastersS12, NoObjectIsMissed)
{
    Random random(9);
    int listed = 0;
    int tested = 0;
    for (int n = 0; n < 30; ++n) {
        BakedScene baked = emptyScene();
        for (int i = 0; i < 40; ++i) {
            addBox(baked, random.in(vec3(-12), vec3(12)), random.in(vec3(0.1f), vec3(1.0f)), false);
        }
        Light light = bakedLight("l", n % 2 ? LightType::Spot : LightType::Point, random.in(vec3(-3), vec3(3)),
                                 random.direction(), LightMode::Realtime, -1);
        light.rangeMeters = 10.0f;
        light.outerConeRadians = random.in(0.1f, 1.5f);
        baked.scene.lights = {light};
        const std::vector<Bounds> bounds = objectBounds(baked.scene);
        const FramePlan frame = plan(baked, lookFrom({0, 0, 30}, {0, 0, -1}), RunMode::Realtime);
        ASSERT_EQ(frame.tileCasterBegin.size(), frame.tiles.size() + 1);
        for (std::size_t tile = 0; tile < frame.tiles.size(); ++tile) {
            const auto casters = frame.castersOf(int(tile));
            EXPECT_TRUE(std::is_sorted(casters.begin(), casters.end()));
            listed += int(casters.size());
            tested += int(bounds.size());
            for (std::size_t object = 0; object < bounds.size(); ++object) {
                if (std::binary_search(casters.begin(), casters.end(), uint32_t(object))) continue;
                for (int i = 0; i < 200; ++i) {
                    const vec3 p = random.in(bounds[object].min, bounds[object].max);
                    const vec3 d = p - light.position();
                    const bool lit =
                        glm::length(d) < light.rangeMeters &&
                        (light.type == LightType::Point ||
                         glm::dot(d, light.direction()) > glm::length(d) * std::cos(light.outerConeRadians));
                    const vec3 t = texelOf(frame.tiles[tile], p);
                    const auto size = float(frame.tiles[tile].size);
                    ASSERT_FALSE(lit && t.x >= 0 && t.x <= size && t.y >= 0 && t.y <= size && t.z >= 0 && t.z <= 1)
                        << "object " << object << " tile " << tile;
                }
            }
        }
    }
    EXPECT_LT(listed, tested / 2) << "most objects are outside a given tile";
}

TEST(ObjectBounds, FollowTheTransform)
{
    BakedScene baked = emptyScene();
    addBox(baked, {1, 2, 3}, {1, 1, 1}, true);
    mat4& m = baked.scene.objects[0].worldFromObject;
    // Mirrored, sheared and turned: compare with all eight corners.
    m = mat4(vec4(-2, 0.5f, 0, 0), vec4(0.3f, 1, -0.7f, 0), vec4(0, 0.2f, 3, 0), vec4(1, 2, 3, 1));
    Bounds truth;
    for (const vec3& p : baked.scene.meshes[0].parts[0].positions) truth.extend(vec3(m * vec4(p, 1)));
    Object nothing;
    baked.scene.objects.push_back(nothing);
    const std::vector<Bounds> bounds = objectBounds(baked.scene);
    EXPECT_LT(glm::length(bounds[0].min - truth.min) + glm::length(bounds[0].max - truth.max), 1e-5f);
    EXPECT_TRUE(bounds[1].empty()) << "no mesh";
}

} // namespace
} // namespace halflight::tiles_test
