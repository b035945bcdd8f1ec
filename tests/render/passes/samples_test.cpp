// Single samples of sky between surfaces: cracks of meshes.
#include "render/passes/samples.h"
#include "render/render_test.h"

#include <glm/gtc/matrix_transform.hpp>

namespace halflight::test::samples_test {
namespace {

const vec4 kWall(0.4f, 0.3f, 0.2f, 1.0f);
const vec4 kSky(0.0f);

TEST(Cracks, OneSampleOfSkyInAWallIsFilledAndSlitsStay)
{
    ImageRgba32f samples(9, 9, kWall);
    samples(4, 4) = kSky;
    samples(0, 4) = kSky; // nothing is known beyond the picture's rim
    EXPECT_LT(glm::distance(withoutCracks(samples)(4, 4), kWall), 1.0e-6f);
    EXPECT_EQ(withoutCracks(samples)(0, 4), vec4(0, 0, 0, 1));

    samples(5, 5) = kSky; // a slit, or the sky's own edge
    EXPECT_EQ(withoutCracks(samples)(4, 4), vec4(0, 0, 0, 1));
    samples(5, 5) = kWall * 3.0f; // leaves, lit and in shadow: the hole is one
    EXPECT_EQ(withoutCracks(samples)(4, 4), vec4(0, 0, 0, 1));
    const ImageRgba32f result = withoutCracks(samples);
    for (const vec4& sample : result.texels()) EXPECT_EQ(sample.w, 1.0f);
}

class CrackPixels : public BothPaths {};
INSTANTIATE_TEST_SUITE_P(, CrackPixels, kBothPaths, pathNameOf);

/// Two rectangles whose common edge has a vertex on one side alone, turned so that no edge is along the pixels. The sky
/// is black: whatever is darker than half a wall inside of them is a hole.
TEST_P(CrackPixels, TJunctionsShowNoSky)
{
    BakedScene baked;
    Scene& scene = baked.scene;
    const int white = addMaterial(scene, vec4(0.5f, 0.5f, 0.5f, 1.0f));
    scene.materials[std::size_t(white)].emissiveNits = vec3(1.0f);
    Mesh mesh;
    MeshPart& part = mesh.parts.emplace_back();
    part.material = white;
    constexpr int kPieces = 61; // along the edge, on one side
    part.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 0, 0}, {-1, 0, 0}};
    part.indices = {0, 1, 2, 0, 2, 3};
    for (int i = 0; i <= kPieces; ++i) {
        const float x = -1.0f + 2.0f * float(i) / kPieces;
        part.positions.emplace_back(x, 0, 0);
        part.positions.emplace_back(x, 1, 0);
        if (i == 0) continue;
        const auto next = uint32_t(part.positions.size());
        part.indices.insert(part.indices.end(), {next - 4, next - 2, next - 1, next - 4, next - 1, next - 3});
    }
    part.normals.assign(part.positions.size(), vec3(0, 0, 1));
    RenderSettings settings;
    settings.path = GetParam();
    settings.size = {400, 400};
    const Camera camera = lookAt(vec3(0.7f, 0.4f, 3), vec3(0));
    int holes = 0;
    for (int turn = 0; turn < 12; ++turn) {
        scene.meshes.clear();
        scene.objects.clear();
        addObject(scene, mesh, glm::rotate(mat4(1.0f), 0.1f + 0.37f * float(turn), vec3(0, 0, 1)), false);
        const RenderedFrame frame = render(baked, camera, settings);
        for (int y = 140; y < 260; ++y)
            for (int x = 140; x < 260; ++x) holes += frame.radiance(x, y).x < 0.5f ? 1 : 0;
    }
    EXPECT_EQ(holes, 0);
}

} // namespace
} // namespace halflight::test::samples_test
