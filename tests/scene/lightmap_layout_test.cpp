// Lightmap coordinates of a file lie in 0...1, final where one object has a mesh, and survive 16-bit fractions.

#include "fixtures.h"

#include "scene/document/document.h"
#include "scene/format/lightmap_layout.h"

namespace halflight::lightmap_layout_test {
namespace {

using namespace test;

const Json& lightmapOf(const Json& document, const std::string& node)
{
    for (const Json& json : document["nodes"]) {
        if (json.value("name", "") == node) return json["extensions"]["HALFLIGHT_node"]["lightmap"];
    }
    static const Json kNone;
    return kNone;
}

/// A bake whose mesh has a layout twice as wide as high, a source's own, in part of 0...1.
BakedScene withWideLayout(std::size_t objects)
{
    Scene scene = engineScene();
    scene.objects.resize(2);
    scene.objects[1].isStatic = objects > 1;
    BakedScene baked = pretendToBake(std::move(scene), false);
    for (MeshPart& part : baked.scene.meshes[0].parts)
        part.lightmapUv = {{0.2f, 0.5f}, {0.6f, 0.5f}, {0.6f, 0.7f}, {0.2f, 0.7f}};
    for (std::size_t i = 0; i < objects; ++i) {
        LightmapBinding& binding = baked.scene.objects[i].lightmap;
        binding = {0, vec2(0.9f), vec2(-0.15f + 0.3f * float(i), -0.4f)}; // a rectangle that reaches beyond the page
    }
    return baked;
}

TEST(LightmapLayout, OneObjectHasItsFinalCoordinates)
{
    const TemporaryFolder folder;
    const BakedScene baked = withWideLayout(1);
    ASSERT_TRUE(writeBakedScene(folder / "baked.glb", baked));
    const Json lightmap = lightmapOf(jsonOfGlb(folder / "baked.glb"), "quad 0");
    EXPECT_EQ(lightmap["scale"], Json::array({1.0, 1.0}));
    EXPECT_EQ(lightmap["offset"], Json::array({0.0, 0.0}));
    const auto read = readBakedScene(folder / "baked.glb");
    ASSERT_TRUE(read) << read.error().text();
    expectSameTexels(baked.scene, baked.scene.objects[0], read->scene, read->scene.objects[0]);
}

TEST(LightmapLayout, RectanglesOfASharedMeshLieOnThePage)
{
    const TemporaryFolder folder;
    const BakedScene baked = withWideLayout(2);
    ASSERT_TRUE(writeBakedScene(folder / "baked.glb", baked));
    const Json json = jsonOfGlb(folder / "baked.glb");
    for (const char* name : {"quad 0", "quad 1"}) {
        const Json lightmap = lightmapOf(json, name);
        for (std::size_t axis = 0; axis < 2; ++axis) {
            EXPECT_GE(lightmap["offset"][axis].get<float>(), 0.0f);
            EXPECT_LE(lightmap["offset"][axis].get<float>() + lightmap["scale"][axis].get<float>(), 1.0f);
        }
    }
    const auto read = readBakedScene(folder / "baked.glb");
    ASSERT_TRUE(read) << read.error().text();
    for (std::size_t i = 0; i < 2; ++i)
        expectSameTexels(baked.scene, baked.scene.objects[i], read->scene, read->scene.objects[i]);
    // As 16-bit fractions a texel of a page of 4096 is missed by less than a sixteenth.
    for (const vec2 uv : read->scene.meshes[0].parts[0].lightmapUv) {
        const vec2 stored = glm::round(uv * 65535.0f) / 65535.0f;
        const vec2 missed = 4096.0f * read->scene.objects[0].lightmap.scale * glm::abs(stored - uv);
        EXPECT_LT(std::max(missed.x, missed.y), 1.0f / 16.0f);
    }
}

// Another bake takes TEXCOORD_1 for the author's layout: it must see it unstretched, or texels would not be square.
TEST(LightmapLayout, TheNextBakeSeesTheShapeOfBefore)
{
    const TemporaryFolder folder;
    ASSERT_TRUE(writeBakedScene(folder / "baked.glb", withWideLayout(2)));
    const auto scene = readScene(folder / "baked.glb");
    ASSERT_TRUE(scene) << scene.error().text();
    const std::vector<vec2>& uv = scene->meshes.at(0).parts.at(0).uv[1];
    ASSERT_EQ(uv.size(), 4u);
    const vec2 size = uv[2] - uv[0];
    EXPECT_NEAR(size.x / size.y, 2.0f, 1.0e-4f);
    EXPECT_LE(std::max(uv[2].x, uv[2].y), 1.0f);
}

TEST(LightmapLayout, CoordinatesAndRectanglesMakeUpForEachOther)
{
    const FileLayout layout{{2.0f, 4.0f}, {-0.4f, -2.0f}};
    const LightmapBinding before{1, {0.3f, 0.2f}, {0.1f, 0.6f}};
    const LightmapBinding after = layout.binding(before);
    const vec2 uv(0.35f, 0.6f);
    const vec2 first = before.scale * uv + before.offset;
    const vec2 second = after.scale * layout.coordinate(uv) + after.offset;
    EXPECT_NEAR(first.x, second.x, 1.0e-6f);
    EXPECT_NEAR(first.y, second.y, 1.0e-6f);
    EXPECT_EQ(after.page, 1);
}

} // namespace
} // namespace halflight::lightmap_layout_test
