// Compressed glTF: KHR_draco_mesh_compression, EXT_meshopt_compression, KHR_meshopt_compression, EXT_texture_webp.
// assets/tests/compressed/ holds one scene as plain glTF and as independent encoders wrote it
// (scripts/make_compressed_scenes.mjs).

#include "fixtures.h"
#include "halflight/base/encoded_image.h"
#include "scene/document/decode/draco_mesh.h"
#include "scene/document/decode/meshopt_view.h"
#include "validator.h"

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>

namespace halflight::test::compressed_test {

namespace {

using testing::HasSubstr;

std::filesystem::path asset(const std::string& name)
{
    return std::filesystem::path(HALFLIGHT_SOURCE_DIR) / "assets/tests/compressed" / name;
}

struct Triangle {
    vec3 middle{0.0f};
    std::array<vec3, 3> corners;
    std::array<vec3, 3> normals;
    std::array<vec2, 3> uv; ///< of the base colour texture, transformed; 0 without one
    std::array<vec4, 3> colors;
};

// All triangles of a scene in world space, whatever its nodes and its order of vertices.
std::vector<Triangle> trianglesOf(const Scene& scene)
{
    std::vector<Triangle> triangles;
    for (const Object& object : scene.objects) {
        const mat3 normalMatrix = glm::transpose(glm::inverse(mat3(object.worldFromObject)));
        for (const MeshPart& part : scene.meshes[std::size_t(object.mesh)].parts) {
            const TextureRef texture =
                part.material >= 0 ? scene.materials[std::size_t(part.material)].baseColorTexture : TextureRef();
            for (std::size_t i = 0; i < part.indices.size(); i += 3) {
                Triangle triangle;
                for (std::size_t k = 0; k < 3; ++k) {
                    const uint32_t v = part.indices[i + k];
                    triangle.corners[k] = vec3(object.worldFromObject * vec4(part.positions[v], 1.0f));
                    triangle.normals[k] = glm::normalize(normalMatrix * part.normals[v]);
                    triangle.uv[k] = texture ? texture.offset + texture.scale * part.uv[0][v] : vec2(0.0f);
                    triangle.colors[k] = part.colors.empty() ? vec4(1.0f) : part.colors[v];
                    triangle.middle += triangle.corners[k] / 3.0f;
                }
                triangles.push_back(triangle);
            }
        }
    }
    return triangles;
}

// Each triangle of `a` is one of `b`, and each of `b` one of `a`: positions to 3 mm (14 bits of a mesh 2 m wide are
// 0.12 mm; gltfpack's rotations of instances have 12 bits, 2 mm at its rim), normals to 2 degrees (8 bits), texture
// coordinates to 1/500, colours to 1/128.
void expectSameTriangles(const Scene& a, const Scene& b)
{
    const std::vector<Triangle> expected = trianglesOf(a);
    const std::vector<Triangle> actual = trianglesOf(b);
    ASSERT_EQ(actual.size(), expected.size());
    std::vector<bool> taken(expected.size(), false);
    for (const Triangle& triangle : actual) {
        std::size_t best = 0;
        for (std::size_t i = 1; i < expected.size(); ++i) {
            if (glm::distance(expected[i].middle, triangle.middle) <
                glm::distance(expected[best].middle, triangle.middle))
                best = i;
        }
        EXPECT_FALSE(taken[best]) << "two triangles for one";
        taken[best] = true;
        const Triangle& match = expected[best];
        std::size_t turn = 0; // which corner of the match is the first
        for (std::size_t k = 1; k < 3; ++k) {
            if (glm::distance(match.corners[k], triangle.corners[0]) <
                glm::distance(match.corners[turn], triangle.corners[0]))
                turn = k;
        }
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t m = (k + turn) % 3;
            EXPECT_LT(glm::distance(match.corners[m], triangle.corners[k]), 3.0e-3f);
            EXPECT_GT(glm::dot(match.normals[m], triangle.normals[k]), std::cos(glm::radians(2.0f)));
            EXPECT_LT(glm::distance(match.uv[m], triangle.uv[k]), 1.0f / 500.0f);
            EXPECT_LT(glm::distance(match.colors[m], triangle.colors[k]), 1.0f / 128.0f);
        }
    }
}

class CompressedFiles : public testing::TestWithParam<const char*> {
protected:
    void SetUp() override
    {
        const std::string name = GetParam();
        if (name.starts_with("draco") ? !DracoMesh::isSupported() : !MeshoptView::isSupported())
            GTEST_SKIP() << "built without the library that decodes " << name;
    }
};

TEST_P(CompressedFiles, HaveThePlainFilesTriangles)
{
    const auto plain = readScene(asset("plain.glb"));
    ASSERT_TRUE(plain) << plain.error().text();
    const auto compressed = readScene(asset(GetParam()));
    ASSERT_TRUE(compressed) << compressed.error().text();
    expectSameTriangles(*plain, *compressed);
}

// What is written is a plain file that the validator takes, with the same triangles and without the extensions.
TEST_P(CompressedFiles, AreWrittenPlain)
{
    const TemporaryFolder folder;
    const auto compressed = readScene(asset(GetParam()));
    ASSERT_TRUE(compressed) << compressed.error().text();
    const std::filesystem::path file = folder / "baked.glb";
    const Status written = writeBakedScene(file, pretendToBake(*compressed, false));
    ASSERT_TRUE(written) << written.error().text();
    const std::string text = jsonOfGlb(file).dump();
    EXPECT_THAT(text, testing::Not(HasSubstr("_compression")));
    const auto again = readScene(file);
    ASSERT_TRUE(again) << again.error().text();
    expectSameTriangles(*compressed, *again);
    // The validator warns of gltfpack's skinned nodes below others, which are kept as they are.
    if (std::string(GetParam()).starts_with("gltfpack")) return;
    if (const std::string why = validateIfPossible({file}); !why.empty()) GTEST_SKIP() << why;
}

INSTANTIATE_TEST_SUITE_P(Encoders, CompressedFiles,
                         testing::Values("draco_edgebreaker.glb", "draco_sequential.glb", "meshopt_medium.glb",
                                         "meshopt_high.glb", "gltfpack_ext.glb", "gltfpack_filters.glb"),
                         [](const auto& info) {
                             const std::string name = info.param;
                             return name.substr(0, name.find('.'));
                         });

TEST(Compressed, ANewerStreamNamesTheCommandThatHelps)
{
    if (!MeshoptView::isSupported()) GTEST_SKIP() << "built without meshoptimizer";
    const auto scene = readScene(asset("gltfpack_khr.glb"));
    if (scene) GTEST_SKIP() << "this meshoptimizer reads version 1";
    EXPECT_THAT(scene.error().text(), HasSubstr("/bufferViews/"));
    EXPECT_THAT(scene.error().text(), HasSubstr("npx gltfpack -i IN.glb -o OUT.glb -noq"));
}

TEST(Compressed, WebpIsPreferredToItsFallback)
{
    if (!decodesWebp()) GTEST_SKIP() << "built without libwebp";
    const auto scene = readScene(asset("webp.glb"));
    ASSERT_TRUE(scene) << scene.error().text();
    ASSERT_EQ(scene->textures.size(), 1u);
    EXPECT_EQ(scene->textures[0].pixels.size(), ivec2(4));
    EXPECT_EQ(scene->textures[0].pixels(1, 2), u8vec4(40, 200, 40, 255)); // the PNG is (200, 40, 40)
}

// A buffer view of a document with one compressed mesh, to be spoiled.
Json documentOf(const std::string& name, std::vector<char>& binary)
{
    return jsonOfGlb(asset(name), &binary);
}

std::string errorOf(const TemporaryFolder& folder, Json json, const std::vector<char>& binary)
{
    writeText(folder / "data.bin", std::string(binary.begin(), binary.end()));
    for (Json& buffer : json["buffers"]) {
        if (!buffer.contains("extensions")) buffer["uri"] = "data.bin";
    }
    writeText(folder / "scene.gltf", json.dump());
    const auto scene = readScene(folder / "scene.gltf");
    return scene ? "loaded" : scene.error().text();
}

TEST(Compressed, BrokenMeshoptIsOneSentence)
{
    if (!MeshoptView::isSupported()) GTEST_SKIP() << "built without meshoptimizer";
    const TemporaryFolder folder;
    std::vector<char> binary;
    const Json good = documentOf("meshopt_high.glb", binary);
    const auto errorWith = [&](const std::string& key, const Json& value) {
        Json json = good;
        json["bufferViews"][1]["extensions"]["EXT_meshopt_compression"][key] = value;
        return errorOf(folder, json, binary);
    };
    EXPECT_EQ(errorOf(folder, good, binary), "loaded");
    const std::string path = "/bufferViews/1/extensions/EXT_meshopt_compression: ";
    EXPECT_THAT(
        errorWith("count", 4000000000u),
        HasSubstr(
            path +
            std::to_string(good["bufferViews"][1]["extensions"]["EXT_meshopt_compression"]["byteLength"].get<int>()) +
            " bytes of meshopt data cannot hold"));
    EXPECT_THAT(errorWith("count", 0), HasSubstr(path + "count is 0"));
    EXPECT_THAT(errorWith("count", -1), HasSubstr(path + "count is not an unsigned integer"));
    EXPECT_THAT(errorWith("byteStride", 0), HasSubstr(path + "byteStride"));
    EXPECT_THAT(errorWith("byteStride", 6), HasSubstr(path + "byteStride"));
    EXPECT_THAT(errorWith("mode", "SPIRALS"), HasSubstr(path + "mode is not"));
    EXPECT_THAT(errorWith("filter", "OCTAHEDRAL"), HasSubstr(path + "byteStride is not 4 or 8")); // it is 12
    EXPECT_THAT(errorWith("filter", "BLUR"), HasSubstr(path + "its filter"));
    EXPECT_THAT(errorWith("buffer", 9), HasSubstr(path + "refers to a buffer that does not exist"));
    EXPECT_THAT(errorWith("byteLength", 99999999), HasSubstr(path + "reaches past the end of buffer 0"));
    EXPECT_THAT(errorWith("byteLength", 7), HasSubstr(path));
    EXPECT_THAT(errorWith("mode", "INDICES"), HasSubstr(path));
    Json uncompressed = good; // a view of the buffer that has no data
    uncompressed["bufferViews"][1].erase("extensions");
    EXPECT_THAT(errorOf(folder, uncompressed, binary), HasSubstr("/bufferViews/1: refers to a buffer without data"));
}

TEST(Compressed, BrokenDracoIsOneSentence)
{
    if (!DracoMesh::isSupported()) GTEST_SKIP() << "built without Draco";
    const TemporaryFolder folder;
    std::vector<char> binary;
    const Json good = documentOf("draco_edgebreaker.glb", binary);
    EXPECT_EQ(errorOf(folder, good, binary), "loaded");
    const std::string path = "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression";
    const auto errorWith = [&](const std::function<void(Json & primitive, Json & extension, Json & json)>& spoil) {
        Json json = good;
        Json& primitive = json["meshes"][0]["primitives"][0];
        spoil(primitive, primitive["extensions"]["KHR_draco_mesh_compression"], json);
        return errorOf(folder, json, binary);
    };
    EXPECT_THAT(errorWith([](Json&, Json& e, Json&) { e["bufferView"] = 99; }), HasSubstr(path + ": refers to"));
    EXPECT_THAT(errorWith([](Json&, Json& e, Json&) { e["bufferView"] = "x"; }), HasSubstr(path + "/bufferView: "));
    EXPECT_THAT(errorWith([](Json&, Json& e, Json&) { e["bufferView"] = 0; }), HasSubstr("no Draco header"));
    EXPECT_THAT(errorWith([](Json&, Json& e, Json&) { e.erase("attributes"); }), HasSubstr("has no attributes"));
    EXPECT_THAT(errorWith([](Json&, Json& e, Json&) { e["attributes"]["NORMAL"] = 77; }),
                HasSubstr(path + "/attributes/NORMAL: the Draco data is damaged (it has no attribute 77)"));
    EXPECT_THAT(errorWith([](Json& p, Json&, Json& j) { j["accessors"][p["indices"].get<int>()]["count"] = 3; }),
                HasSubstr("indices, their accessor another count"));
    EXPECT_THAT(
        errorWith([](Json& p, Json&, Json& j) { j["accessors"][p["attributes"]["NORMAL"].get<int>()]["count"] = 3; }),
        HasSubstr(path + "/attributes/NORMAL"));
    EXPECT_THAT(errorWith([](Json& p, Json&, Json&) { p["mode"] = 1; }), HasSubstr("is of triangles"));
}

std::vector<std::byte> bytesOf(std::initializer_list<int> values)
{
    std::vector<std::byte> bytes;
    for (const int value : values) bytes.push_back(std::byte(value));
    return bytes;
}

// 20 bytes that claim 2^28 faces: refused by the claim, before any memory is taken.
TEST(Compressed, DracoClaimsAreCheckedBeforeAllocation)
{
    if (!DracoMesh::isSupported()) GTEST_SKIP() << "built without Draco";
    const std::vector<std::byte> sequential =
        bytesOf({'D', 'R', 'A', 'C', 'O', 2, 2, 1, 0, 0, 0, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff, 0x7f, 0});
    const std::vector<std::byte> edgebreaker =
        bytesOf({'D', 'R', 'A', 'C', 'O', 2, 2, 1, 1, 0, 0, 0, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff, 0x7f, 1, 1});
    for (const auto& bytes : {sequential, edgebreaker}) {
        const auto mesh = DracoMesh::decode(bytes, 1 << 20);
        ASSERT_FALSE(mesh);
        EXPECT_THAT(mesh.error().message, HasSubstr("claim more geometry than the limit of 1048576 bytes"));
    }
    const auto old = DracoMesh::decode(bytesOf({'D', 'R', 'A', 'C', 'O', 1, 1, 1, 0, 0, 0, 0}), 1 << 20);
    ASSERT_FALSE(old);
    EXPECT_THAT(old.error().message, HasSubstr("bitstream version 1.1"));
}

// Single bytes changed and cut at all lengths: an error or a mesh, never a crash (meant for AddressSanitizer).
TEST(Compressed, DamagedStreamsNeverCrash)
{
    const TemporaryFolder folder;
    for (const char* name : {"draco_edgebreaker.glb", "draco_sequential.glb", "gltfpack_filters.glb", "webp.glb"}) {
        std::ifstream stream(asset(name), std::ios::binary);
        const std::string good((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
        uint32_t jsonLength = 0;
        std::memcpy(&jsonLength, &good[12], 4);
        for (uint32_t i = 0; i < 300; ++i) {
            std::string bytes = good;
            const uint32_t random = hashCombine(i, 7u);
            bytes[28 + jsonLength + random % (good.size() - 28 - jsonLength)] ^= char(1u << (random >> 28 & 7));
            writeText(folder / "damaged.glb", bytes);
            if (const auto scene = readScene(folder / "damaged.glb"); !scene) EXPECT_NE(scene.error().object, "");
        }
    }
}

} // namespace

} // namespace halflight::test::compressed_test
