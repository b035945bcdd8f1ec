// Every shared scene through the chain of a real bake but for the light: read, unwrap, write, read back.

#include "scene/fixtures.h"
#include "scene/validator.h"

#include "halflight/unwrap/unwrap.h"

#include <algorithm>

namespace halflight::written_scenes_test {
namespace {

using namespace test;
const std::filesystem::path kScenes = std::filesystem::path(HALFLIGHT_SHARED_DIR) / "scenes";

/// Pages whose texels can be told apart, smaller than the layout's: coordinates are relative.
BakedScene withMadeUpLight(const UnwrappedScene& unwrapped)
{
    BakedScene baked;
    baked.isBaked = true;
    baked.scene = unwrapped.scene;
    for (int page = 0; page < unwrapped.pageCount; ++page) {
        Image<uint32_t> lightmap(16, 16);
        ImageRgba8 mask(16, 16, u8vec4(255));
        for (std::size_t i = 0; i < lightmap.texelCount(); ++i)
            lightmap.texels()[i] = hashCombine(uint32_t(i), uint32_t(page));
        baked.lightmaps.push_back(std::move(lightmap));
        baked.shadowmasks.push_back(std::move(mask));
    }
    return baked;
}

bool texturesReadIt(const Scene& scene, const Mesh& mesh)
{
    return std::any_of(mesh.parts.begin(), mesh.parts.end(), [&](const MeshPart& part) {
        const Material& m = materialOf(scene, part);
        const auto reads = [&](const TextureRef& ref) { return ref && ref.texCoord == part.lightmapTexCoord; };
        return reads(m.baseColorTexture) || reads(m.metallicRoughnessTexture) || reads(m.normalTexture) ||
               reads(m.occlusionTexture) || reads(m.emissiveTexture);
    });
}

/// Every corner of every object is where it was, on the surface and on its page.
void expectSamePlaces(const Scene& written, const Scene& read)
{
    ASSERT_EQ(read.objects.size(), written.objects.size());
    for (std::size_t i = 0; i < read.objects.size(); ++i) {
        const Object &a = written.objects[i], &b = read.objects[i];
        ASSERT_EQ(a.name, b.name);
        ASSERT_EQ(a.lightmap.page, b.lightmap.page) << a.name;
        ASSERT_EQ(a.worldFromObject, b.worldFromObject) << a.name;
        if (a.lightmap.page < 0) continue;
        const bool isTextures = texturesReadIt(read, read.meshes[std::size_t(b.mesh)]); // stays as the source has it
        for (int axis = 0; axis < 2 && !isTextures; ++axis) { // the rectangle lies on its page
            ASSERT_GE(b.lightmap.offset[axis], -1.0e-6f) << a.name;
            ASSERT_LE(b.lightmap.offset[axis] + b.lightmap.scale[axis], 1.0f + 1.0e-6f) << a.name;
        }
        if (i > 0 && a.mesh == written.objects[i - 1].mesh && b.mesh == read.objects[i - 1].mesh) continue;
        const Mesh &meshA = written.meshes[std::size_t(a.mesh)], &meshB = read.meshes[std::size_t(b.mesh)];
        ASSERT_EQ(meshA.parts.size(), meshB.parts.size()) << a.name;
        for (std::size_t p = 0; p < meshA.parts.size(); ++p) {
            const MeshPart &partA = meshA.parts[p], &partB = meshB.parts[p];
            ASSERT_EQ(partA.indices.size(), partB.indices.size()) << a.name;
            ASSERT_EQ(partB.lightmapUv.size(), partB.positions.size()) << a.name;
            ASSERT_EQ(partA.lightmapTexCoord, partB.lightmapTexCoord) << a.name;
            for (std::size_t k = 0; k < partA.indices.size(); ++k) {
                const uint32_t u = partA.indices[k], v = partB.indices[k];
                ASSERT_EQ(partA.positions[u], partB.positions[v]) << a.name;
                const vec2 placeA = a.lightmap.scale * partA.lightmapUv[u] + a.lightmap.offset;
                const vec2 placeB = b.lightmap.scale * partB.lightmapUv[v] + b.lightmap.offset;
                ASSERT_LT(glm::distance(placeA, placeB), 1.0e-6f) << a.name;
            }
        }
    }
}

/// The scene as the written file gives it back, without decoded textures.
Result<BakedScene> writtenAndRead(const BakedScene& baked, const std::filesystem::path& file)
{
    if (const Status written = writeBakedScene(file, baked); !written) return written.error();
    return readBakedScene(file, {.decodeTextures = false});
}

class WrittenSharedScenes : public testing::TestWithParam<std::string> {};

TEST_P(WrittenSharedScenes, ComeBackWithTheirCoordinates)
{
    const std::filesystem::path path = kScenes / GetParam();
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "no shared scenes beside this checkout";
    const Result<Scene> scene = readScene(path, {.decodeTextures = false});
    ASSERT_TRUE(scene) << scene.error().text();
    const Result<UnwrappedScene> unwrapped = unwrap(*scene, {});
    ASSERT_TRUE(unwrapped) << unwrapped.error().text();
    const BakedScene baked = withMadeUpLight(*unwrapped);
    const TemporaryFolder folder;
    const Result<BakedScene> read = writtenAndRead(baked, folder / "baked.glb");
    ASSERT_TRUE(read) << read.error().text();
    EXPECT_TRUE(read->isBaked);
    ASSERT_EQ(read->lightmaps.size(), baked.lightmaps.size());
    for (std::size_t i = 0; i < baked.lightmaps.size(); ++i)
        EXPECT_EQ(read->lightmaps[i].texels(), baked.lightmaps[i].texels());
    EXPECT_EQ(read->shadowmasks.size(), baked.shadowmasks.size());
    expectSamePlaces(baked.scene, read->scene);
    if (HasFailure()) return;
    RecordProperty("no_validator", validateIfPossible({folder / "baked.glb"}));
}

/// Vertices that cuts added are in the file, where the scene has them.
TEST(WrittenCutsS6, ComeBackWithTheirVertices)
{
    const std::filesystem::path path = std::filesystem::path(HALFLIGHT_SOURCE_DIR) / "assets/quality/cellars.glb";
    const Result<Scene> scene = readScene(path, {.decodeTextures = false});
    ASSERT_TRUE(scene) << scene.error().text();
    UnwrapSettings settings;
    settings.texelsPerMeter = 20.0f;
    const auto all = [](const Scene&, std::span<const CrossingPoint> points) {
        return std::vector<uint8_t>(points.size(), 1);
    };
    const Result<UnwrappedScene> unwrapped = unwrap(*scene, settings, {}, all);
    ASSERT_TRUE(unwrapped) << unwrapped.error().text();
    ASSERT_GT(unwrapped->cuts, 8);
    const BakedScene baked = withMadeUpLight(*unwrapped);
    const TemporaryFolder folder;
    const Result<BakedScene> read = writtenAndRead(baked, folder / "baked.glb");
    ASSERT_TRUE(read) << read.error().text();
    expectSamePlaces(baked.scene, read->scene);
    RecordProperty("no_validator", validateIfPossible({folder / "baked.glb"}));
}

TEST(UnwrapDensityOfSponza, TooManyPagesAreRefusedBeforePacking)
{
    const std::filesystem::path path = kScenes / "sponza_crytek.glb";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "no shared scenes beside this checkout";
    Result<Scene> scene = readScene(path, {.decodeTextures = false});
    ASSERT_TRUE(scene) << scene.error().text();
    UnwrapSettings settings;
    settings.texelsPerMeter = 1000.0f;
    const Result<UnwrappedScene> result = unwrap(std::move(*scene), settings);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::InvalidArgument);
    EXPECT_NE(result.error().message.find("would fit"), std::string::npos) << result.error().message;
    RecordProperty("sentence", result.error().message);
}

std::vector<std::string> sceneNames()
{
    std::vector<std::string> names;
    std::error_code ec;
    for (const auto& entry : std::filesystem::directory_iterator(kScenes, ec)) {
        const auto extension = entry.path().extension();
        if (extension == ".glb" || extension == ".gltf") names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin(), names.end());
    if (names.empty()) names.emplace_back("no_shared_scenes.glb"); // skipped, with a message
    return names;
}

INSTANTIATE_TEST_SUITE_P(All, WrittenSharedScenes, testing::ValuesIn(sceneNames()), [](const auto& info) {
    std::string name = info.param.substr(0, info.param.find('.'));
    for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
    return name;
});

} // namespace
} // namespace halflight::written_scenes_test
