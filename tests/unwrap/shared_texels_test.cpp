// No two objects share a texel, whatever mix of kept and new layouts a scene asks for.

#include "atlas_check.h"
#include "shapes.h"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>
#include <limits>
#include <map>
#include <random>

namespace halflight::shared_texels_test {
namespace {

/// Lays each quad of a mesh of quads (4 vertices, 2 triangles) into a cell of its own in the rectangle.
void layQuads(MeshPart& part, vec2 from, vec2 to, float gap)
{
    part.uv[1].assign(part.positions.size(), vec2(0.0f));
    const std::size_t quads = part.positions.size() / 4;
    constexpr std::array<vec2, 4> kCorners = {vec2(0, 0), vec2(1, 0), vec2(1, 1), vec2(0, 1)};
    for (std::size_t q = 0; q < quads; ++q) {
        const vec2 cell(float(q % 3), float(q / 3));
        for (std::size_t k = 0; k < 4; ++k) {
            const vec2 inCell = glm::mix(vec2(gap), vec2(1.0f - gap), kCorners[k]);
            part.uv[1][4 * q + k] = glm::mix(from, to, (cell + inCell) / vec2(3.0f, 2.0f));
        }
    }
}

/// A box whose TEXCOORD_1 takes a rectangle of the uv square.
Mesh boxWithUv(vec2 from = vec2(0.0f), vec2 to = vec2(1.0f), float gap = 0.1f)
{
    Mesh mesh = shapes::box();
    layQuads(mesh.parts[0], from, to, gap);
    return mesh;
}

/// A triangle without area whose TEXCOORD_1 crosses the whole uv square.
void addDegenerateTriangle(MeshPart& part)
{
    for (int k = 0; k < 3; ++k) {
        part.positions.push_back(part.positions[0]);
        part.normals.push_back(part.normals[0]);
        if (!part.uv[1].empty()) part.uv[1].push_back(vec2(k == 1, k == 2));
        part.indices.push_back(uint32_t(part.positions.size()) - 1);
    }
}

/// A made-up scene and how it is unwrapped.
class RandomScene {
public:
    explicit RandomScene(uint32_t seed) : random_(seed)
    {
        settings.uvMode = pick(std::array{UvMode::Auto, UvMode::Auto, UvMode::Keep, UvMode::Unwrap});
        settings.pageSize = pick(std::array{64, 128, 200, 256});
        settings.paddingTexels = pick(std::array{1, 2, 2, 3});
        settings.texelsPerMeter = pick(std::array{0.0f, 0.0f, 4.0f, 11.0f, 30.0f});
        mayFail_ = settings.uvMode == UvMode::Keep && chance(0.2);
        const int meshes = int(below(3)) + 1;
        for (int m = 0; m < meshes; ++m) {
            scene.meshes.push_back(mesh());
            scene.meshes.back().sourceMesh = m;
        }
        const int nodes = int(below(6)) + 2;
        for (int node = 0; node < nodes; ++node) addNode(node);
    }

    Scene scene;
    UnwrapSettings settings;

private:
    uint32_t below(uint32_t n) { return random_() % n; }
    bool chance(double p) { return double(random_()) < p * 4294967296.0; }
    float number(float low, float high) { return low + (high - low) * float(random_() / 4294967296.0); }
    template<typename List> typename List::value_type pick(const List& list)
    {
        return list[below(uint32_t(list.size()))];
    }

    Mesh mesh()
    {
        Mesh mesh;
        switch (below(4)) {
        case 0:
            mesh = shapes::plane(1.0f, number(0.3f, 2.0f));
            break;
        case 1:
            mesh = shapes::cylinder(0.5f, 1.0f, 6);
            break;
        default:
            mesh = shapes::box(vec3(1.0f, number(0.2f, 2.0f), 1.0f));
            break;
        }
        MeshPart& part = mesh.parts[0];
        const bool quads = part.indices.size() == 6 * (part.positions.size() / 4) && part.positions.size() % 4 == 0;
        if (quads && chance(0.9)) addUv(part);
        if (chance(0.15)) mesh = shapes::together(mesh, chance(0.5) ? boxWithUv() : shapes::plane());
        if (chance(0.25)) addDegenerateTriangle(mesh.parts[0]);
        return mesh;
    }

    void addUv(MeshPart& part)
    {
        const float gap = pick(std::array{0.0f, 0.05f, 0.1f, 0.2f, 0.3f});
        switch (below(mayFail_ || settings.uvMode != UvMode::Keep ? 6 : 3)) {
        case 0:
            layQuads(part, vec2(0.0f), vec2(1.0f), gap);
            break;
        case 1: // a place in an atlas, which others may have too
        case 2: {
            const vec2 from(0.5f * float(below(2)), 0.5f * float(below(2)));
            layQuads(part, from, from + vec2(0.5f), gap);
            break;
        }
        case 3:
            layQuads(part, vec2(0.4f), vec2(0.4f) + number(1e-6f, 1e-3f), gap);
            break; // tiny
        case 4:    // not valid: leaves [0,1], or all quads in one place
            layQuads(part, vec2(0.0f), vec2(1.5f), gap);
            break;
        default:
            layQuads(part, vec2(0.0f), vec2(1.0f), gap);
            for (std::size_t v = 4; v < part.uv[1].size(); ++v) part.uv[1][v] = part.uv[1][v % 4];
            break;
        }
    }

    mat4 transform()
    {
        mat4 m = glm::translate(mat4(1.0f), vec3(number(-5, 5), number(-5, 5), number(-5, 5)));
        if (chance(0.5)) m = glm::rotate(m, number(0.0f, 6.0f), glm::normalize(vec3(1.0f, 2.0f, number(-1, 1))));
        switch (below(6)) {
        case 0:
            return glm::scale(m, vec3(1.0f, 2.0f, -1.0f));
        case 1:
            return glm::scale(m, vec3(-1.0f, 1.0f, 1.0f));
        case 2:
            return glm::scale(m, vec3(number(0.2f, 3.0f)));
        case 3:
            return glm::scale(m, vec3(number(0.97f, 1.03f)));
        case 4:
            return glm::scale(m, vec3(number(0.2f, 3.0f), number(0.2f, 3.0f), number(0.2f, 3.0f)));
        default:
            return m;
        }
    }

    void addNode(int node)
    {
        const int mesh = int(below(uint32_t(scene.meshes.size())));
        const bool instanced = chance(0.3);
        const uint32_t count = instanced ? below(4) + 1 : 1;
        const float scale = pick(std::array{1.0f, 1.0f, 0.3f, 0.1f, 2.0f, 0.0f});
        const bool isStatic = chance(0.9);
        for (uint32_t i = 0; i < count; ++i) {
            shapes::add(scene, mesh, transform());
            Object& object = scene.objects.back();
            object.name = fmt::format("node {} instance {}", node, i);
            object.sourceNode = node;
            object.sourceInstance = instanced ? int(i) : -1;
            object.lightmapScale = scale;
            object.isStatic = isStatic;
            if (instanced && chance(0.1)) object.worldFromObject[0][0] = std::numeric_limits<float>::infinity();
        }
    }

    std::mt19937 random_;
    bool mayFail_ = false;
};

/// A node has one mesh, whatever its instances are given.
std::string findSplitNode(const Scene& scene)
{
    std::map<int, int> meshOfNode;
    for (const Object& object : scene.objects) {
        const auto [found, isNew] = meshOfNode.try_emplace(object.sourceNode, object.mesh);
        if (found->second != object.mesh) return fmt::format("instances of node {} differ in mesh", object.sourceNode);
    }
    return {};
}

TEST(UnwrapSharedTexels, NoTwoObjectsShareOneInTwoHundredRandomScenes)
{
    int kept = 0, unwrapped = 0, mixed = 0, refused = 0;
    for (uint32_t seed = 0; seed < 200; ++seed) {
        const RandomScene random(seed);
        const Result<UnwrappedScene> result = unwrap(random.scene, random.settings);
        if (!result) {
            // What cannot be kept, and what fits no page.
            EXPECT_NE(result.error().code, ErrorCode::Unsupported) << seed << ": " << result.error().text();
            ++refused;
            continue;
        }
        EXPECT_EQ(findSharedTexel(*result), "") << "seed " << seed;
        EXPECT_EQ(checkMeshes(random.scene, *result), "") << "seed " << seed;
        EXPECT_EQ(findSplitNode(result->scene), "") << "seed " << seed;
        std::map<int, int> layouts; // by source: 1 kept, 2 unwrapped, 3 both
        for (const MeshUnwrapReport& report : result->meshes) {
            (report.kept ? kept : unwrapped) += 1;
            layouts[result->scene.meshes[std::size_t(report.mesh)].sourceMesh] |= report.kept ? 1 : 2;
        }
        for (const auto& [source, kinds] : layouts) mixed += kinds == 3;
    }
    // The scenes are of all kinds.
    EXPECT_GT(kept, 50);
    EXPECT_GT(unwrapped, 100);
    EXPECT_GT(mixed, 4);
    EXPECT_LT(refused, 40);
}

/// The one box at scales 1, 2 and ½: at a density at which TEXCOORD_1 holds for the large ones alone.
Scene boxesOfThreeScales()
{
    Scene scene = shapes::scene(boxWithUv(vec2(0.0f), vec2(1.0f), 0.05f));
    for (const float scale : {2.0f, 0.5f}) {
        shapes::add(scene, 0, glm::scale(mat4(1.0f), vec3(scale)));
        scene.objects.back().name = fmt::format("box {}", scale);
    }
    return scene;
}

TEST(UnwrapSharedTexels, KeptAndNewLayoutsOfOneMeshHaveCoordinatesOfTheirOwn)
{
    UnwrapSettings settings;
    settings.pageSize = 256;
    settings.texelsPerMeter = 20.0f;
    for (const bool reversed : {false, true}) {
        Scene scene = boxesOfThreeScales();
        if (reversed) std::reverse(scene.objects.begin(), scene.objects.end());
        const Result<UnwrappedScene> result = unwrap(scene, settings);
        ASSERT_TRUE(result) << result.error().text();
        EXPECT_EQ(findSharedTexel(*result), "");
        int kept = 0;
        for (const MeshUnwrapReport& report : result->meshes) {
            kept += report.kept;
            const MeshPart& part = result->scene.meshes[std::size_t(report.mesh)].parts[0];
            EXPECT_EQ(part.lightmapUv == part.uv[1], report.kept);
        }
        EXPECT_GT(kept, 0);
        EXPECT_LT(kept, 3);
    }
}

TEST(UnwrapSharedTexels, LayoutsKeptAtSeveralScalesShareTheMesh)
{
    UnwrapSettings settings;
    settings.uvMode = UvMode::Keep;
    settings.pageSize = 256;
    settings.texelsPerMeter = 20.0f;
    const Result<UnwrappedScene> result = unwrap(boxesOfThreeScales(), settings);
    ASSERT_TRUE(result) << result.error().text();
    EXPECT_EQ(result->scene.meshes.size(), 1u);
    EXPECT_EQ(findSharedTexel(*result), "");
}

TEST(UnwrapSharedTexels, AtlasWhoseObjectsMeetInATexelIsTakenApart)
{
    // Side by side in one uv square: the border between them is a texel of both.
    Scene scene = shapes::scene(boxWithUv(vec2(0.0f), vec2(0.5f, 1.0f), 0.0f));
    scene.meshes.push_back(boxWithUv(vec2(0.5f, 0.0f), vec2(1.0f), 0.0f));
    shapes::add(scene, 1, mat4(1.0f));
    UnwrapSettings settings;
    settings.uvMode = UvMode::Keep;
    settings.pageSize = 125; // the border is the middle of a texel
    const Result<UnwrappedScene> result = unwrap(scene, settings);
    ASSERT_TRUE(result) << result.error().text();
    EXPECT_EQ(findSharedTexel(*result), "");
    for (const MeshUnwrapReport& report : result->meshes) EXPECT_TRUE(report.kept);
    EXPECT_NE(result->scene.objects[0].lightmap.offset, result->scene.objects[1].lightmap.offset);
}

TEST(UnwrapSharedTexels, NoTexelOfADegenerateTriangleIsAnotherObjects)
{
    // In the file's atlas the boxes keep apart, but for a triangle without area.
    Scene scene = shapes::scene(boxWithUv(vec2(0.0f), vec2(0.4f), 0.1f));
    addDegenerateTriangle(scene.meshes[0].parts[0]);
    scene.meshes.push_back(boxWithUv(vec2(0.5f), vec2(0.9f), 0.1f));
    shapes::add(scene, 1, mat4(1.0f));
    UnwrapSettings settings;
    settings.uvMode = UvMode::Keep;
    settings.pageSize = 512;
    const Result<UnwrappedScene> result = unwrap(scene, settings);
    ASSERT_TRUE(result) << result.error().text();
    EXPECT_EQ(findSharedTexel(*result), "");
}

TEST(UnwrapSharedTexels, LayoutThatFloatsCannotPlaceIsNotKept)
{
    // A ten-thousandth of the uv square for boxes that are to have hundreds of texels.
    Scene scene = shapes::scene(boxWithUv(vec2(0.7f), vec2(0.7001f), 0.1f));
    shapes::add(scene, 0, mat4(1.0f));
    UnwrapSettings settings;
    settings.pageSize = 512;
    settings.texelsPerMeter = 100.0f;
    const Result<UnwrappedScene> result = unwrap(scene, settings);
    ASSERT_TRUE(result) << result.error().text();
    EXPECT_EQ(findSharedTexel(*result), "");
    ASSERT_EQ(result->meshes.size(), 1u);
    EXPECT_FALSE(result->meshes[0].kept);
    settings.uvMode = UvMode::Keep;
    const Result<UnwrappedScene> kept = unwrap(scene, settings);
    ASSERT_FALSE(kept);
    EXPECT_EQ(kept.error().code, ErrorCode::FileInvalid);
}

TEST(UnwrapSharedTexels, InstancesOfANodeKeepOneMeshBesideNodesOfOtherScale)
{
    // A single box of another scale, and a node of instances in its group: one instance has no texels.
    Scene scene = shapes::scene(boxWithUv());
    scene.objects[0].sourceNode = 0;
    for (int node = 1; node < 3; ++node) {
        for (int i = 0; i < 3; ++i) {
            shapes::add(scene, 0, glm::scale(mat4(1.0f), vec3(3.0f)));
            scene.objects.back().sourceNode = node;
            scene.objects.back().sourceInstance = node == 1 ? -1 : i;
            if (node == 1) break;
        }
    }
    scene.objects.back().lightmapScale = 0.0f;
    UnwrapSettings settings;
    settings.uvMode = UvMode::Unwrap;
    const Result<UnwrappedScene> result = unwrap(scene, settings);
    ASSERT_TRUE(result) << result.error().text();
    EXPECT_EQ(findSplitNode(result->scene), "");
    EXPECT_EQ(findSharedTexel(*result), "");
}

} // namespace
} // namespace halflight::shared_texels_test
