// Scenes far from the world's origin: the reader works relative to a place near their middle. Truth is the world
// position in double precision, which the same scene at the origin gives.

#include "fixtures.h"

#include <functional>
#include <gmock/gmock.h>

namespace halflight::origin_test {
namespace {

using namespace test;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

/// A rotation by 90 degrees about y, exact in doubles: (x, y, z) becomes (z, y, -x).
const Json kQuarterTurn = {0, 0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1};

/// A triangle, a second one, a spot light, a camera, a probe and an animated point light, about 4 m wide.
void addScene(GltfBuilder& file)
{
    file.triangle();
    file.json["nodes"] = {{{"mesh", 0}, {"name", "one"}, {"translation", {1.25, 0.5, 2}}},
                          {{"mesh", 0}, {"name", "two"}, {"translation", {-1, 0, 0.125}}, {"scale", {2, 2, 2}}},
                          {{"name", "lamp"},
                           {"translation", {0.1, 3, 0.7}},
                           {"rotation", {-0.6, 0, 0, 0.8}},
                           {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}},
                          {{"name", "eye"}, {"camera", 0}, {"translation", {0.3, 1.7, 4}}}};
    file.json["extensions"]["KHR_lights_punctual"]["lights"] = {
        {{"type", "spot"}, {"name", "lamp"}, {"spot", Json::object()}}};
    file.json["extensionsUsed"] = {"KHR_lights_punctual", "EXT_mesh_gpu_instancing"};
    file.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 0.1}}}}};
    file.json["scenes"][0]["nodes"] = {0, 1, 2, 3};
}

/// World positions of everything, in double precision.
std::vector<glm::dvec3> worldPositions(const Scene& scene)
{
    std::vector<glm::dvec3> points;
    for (const Object& object : scene.objects) {
        for (const vec3& p : scene.meshes[std::size_t(object.mesh)].parts[0].positions)
            points.push_back(scene.originMeters + glm::dvec3(object.worldFromObject * vec4(p, 1.0f)));
    }
    for (const Light& light : scene.lights) points.push_back(scene.originMeters + glm::dvec3(light.position()));
    for (const Camera& camera : scene.cameras)
        points.push_back(scene.originMeters + glm::dvec3(camera.worldFromCamera[3]));
    for (const vec3& p : scene.probePositions) points.push_back(scene.originMeters + glm::dvec3(p));
    return points;
}

void expectMoved(const std::vector<glm::dvec3>& there, const std::vector<glm::dvec3>& here,
                 const std::function<glm::dvec3(glm::dvec3)>& thereFromHere, double tolerance = 1.0e-6)
{
    ASSERT_EQ(there.size(), here.size());
    for (std::size_t i = 0; i < there.size(); ++i)
        EXPECT_LT(glm::distance(there[i], thereFromHere(here[i])), tolerance) << "point " << i;
}

const glm::dvec3 kOffsets[] = {{5.0e5, 0.0, -5.0e6}, {1.0e7, 0.0, 0.0}, {421337.123, 98.76, -5123456.789}};

Scene readFile(GltfBuilder& file, const TemporaryFolder& folder, const std::filesystem::path& settings = {})
{
    auto scene = readScene(file.write(folder), {.settingsFile = settings});
    EXPECT_TRUE(scene) << scene.error().text();
    return scene ? std::move(*scene) : Scene();
}

Scene atOrigin(const TemporaryFolder& folder)
{
    GltfBuilder file;
    addScene(file);
    return readFile(file, folder);
}

class Georeferenced : public testing::TestWithParam<int> {
protected:
    glm::dvec3 offset = kOffsets[GetParam()];
    TemporaryFolder folder;
    Json list() const { return {offset.x, offset.y, offset.z}; }
    glm::dvec3 moved(glm::dvec3 p) const { return p + offset; }

    /// Everything is where it should be, and near the local origin.
    void expectAll(const Scene& there, const std::function<glm::dvec3(glm::dvec3)>& thereFromHere) const
    {
        const Scene here = atOrigin(folder);
        EXPECT_EQ(here.originMeters, glm::dvec3(0.0));
        expectMoved(worldPositions(there), worldPositions(here), thereFromHere);
        EXPECT_LT(glm::length(there.bounds().center()), 20.0f);
        EXPECT_THAT(there.warnings, testing::ElementsAreArray(here.warnings));
    }
};
INSTANTIATE_TEST_SUITE_P(Offsets, Georeferenced, testing::Range(0, 3));

TEST_P(Georeferenced, RootNode)
{
    GltfBuilder file;
    addScene(file);
    file.json["nodes"].push_back({{"children", {0, 1, 2, 3}}, {"translation", list()}});
    file.json["scenes"][0]["nodes"] = {4};
    expectAll(readFile(file, folder), [&](glm::dvec3 p) { return moved(p); });
}

TEST_P(Georeferenced, EveryNode)
{
    GltfBuilder file;
    addScene(file);
    for (Json& node : file.json["nodes"]) {
        for (int c = 0; c < 3; ++c)
            node["translation"][std::size_t(c)] = node["translation"][std::size_t(c)].get<double>() + offset[c];
    }
    expectAll(readFile(file, folder), [&](glm::dvec3 p) { return moved(p); });
}

TEST_P(Georeferenced, MatrixBelowATurnedRoot)
{
    GltfBuilder file;
    addScene(file);
    Json matrix = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, offset.x, offset.y, offset.z, 1};
    file.json["nodes"].push_back({{"children", {0, 1, 2, 3}}, {"matrix", matrix}});
    file.json["nodes"].push_back({{"children", {4}}, {"matrix", kQuarterTurn}});
    file.json["scenes"][0]["nodes"] = {5};
    expectAll(readFile(file, folder), [&](glm::dvec3 p) {
        const glm::dvec3 q = p + offset;
        return glm::dvec3(q.z, q.y, -q.x);
    });
}

TEST_P(Georeferenced, Vertices)
{
    // Floats hold whole metres at all offsets here; what they hold must not be rounded again.
    const glm::dvec3 whole = glm::round(offset);
    const auto read = [&](const glm::dvec3& shift) {
        GltfBuilder file;
        file.triangle();
        std::vector<float> positions;
        for (const glm::dvec3 p : {glm::dvec3(0, 0, 0), glm::dvec3(8, 0, 1), glm::dvec3(0, 7, 3)}) {
            for (int c = 0; c < 3; ++c) positions.push_back(float(p[c] + shift[c]));
        }
        file.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = file.floats(positions, "VEC3", 3);
        file.json["nodes"] = {{{"mesh", 0}}, {{"mesh", 0}, {"translation", {0.25, 0.125, 0.3}}}};
        file.json["scenes"][0]["nodes"] = {0, 1};
        return readFile(file, folder);
    };
    const Scene here = read(glm::dvec3(0.0));
    const Scene there = read(whole);
    expectMoved(worldPositions(there), worldPositions(here), [&](glm::dvec3 p) { return p + whole; });
    for (const vec3& p : there.meshes[0].parts[0].positions) EXPECT_LT(glm::length(p), 40.0f);
    EXPECT_THAT(there.warnings, Contains(HasSubstr("put that distance into the node")));
    EXPECT_THAT(here.warnings, testing::Not(Contains(HasSubstr("distance"))));
    EXPECT_EQ(there.meshes[0].parts[0].normals, here.meshes[0].parts[0].normals);
}

TEST_P(Georeferenced, Instances)
{
    const auto read = [&](const Json& translation) {
        GltfBuilder file;
        addScene(file);
        Json& node = file.json["nodes"][0];
        node["translation"] = translation;
        const int places = file.floats({0, 0, 0, 1, 2, 3, -3, 0.1f, 0}, "VEC3", 3);
        node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {{"TRANSLATION", places}};
        file.json["scenes"][0]["nodes"] = {0};
        return readFile(file, folder);
    };
    const Scene here = read({0, 0, 0});
    const Scene there = read(list());
    expectMoved(worldPositions(there), worldPositions(here), [&](glm::dvec3 p) { return moved(p); });
    EXPECT_LT(glm::length(there.bounds().center()), 20.0f);
}

TEST_P(Georeferenced, SettingsAreInWorldCoordinates)
{
    GltfBuilder file;
    addScene(file);
    file.json["nodes"].push_back({{"children", {0, 1, 2, 3}}, {"translation", list()}});
    file.json["scenes"][0]["nodes"] = {4};
    char text[512];
    std::snprintf(text, sizeof(text),
                  "[[add_light]]\ntype = \"point\"\nposition = [%.6f, %.6f, %.6f]\n"
                  "[scene]\nprobes = [[%.6f, %.6f, %.6f]]\n",
                  offset.x + 0.5, offset.y + 2.25, offset.z - 1.125, offset.x - 0.3, offset.y + 0.7, offset.z + 0.9);
    writeText(folder / "settings.toml", text);
    const Scene scene = readFile(file, folder, folder / "settings.toml");
    ASSERT_EQ(scene.lights.size(), 2u);
    ASSERT_EQ(scene.probePositions.size(), 1u);
    const auto world = [&](vec3 p) { return scene.originMeters + glm::dvec3(p); };
    EXPECT_LT(glm::distance(world(scene.lights[1].position()), offset + glm::dvec3(0.5, 2.25, -1.125)), 2.0e-6);
    EXPECT_LT(glm::distance(world(scene.probePositions[0]), offset + glm::dvec3(-0.3, 0.7, 0.9)), 2.0e-6);
}

TEST_P(Georeferenced, TheBakedFileKeepsItsOrigin)
{
    GltfBuilder file;
    addScene(file);
    file.json["nodes"].push_back({{"children", {0, 1, 2, 3}}, {"translation", list()}});
    file.json["scenes"][0]["nodes"] = {4};
    const glm::dvec3 probe = offset + glm::dvec3(0.1, 0.7, 0.3);
    file.json["scenes"][0]["extras"]["halflight_probes"] = {{probe.x, probe.y, probe.z}};
    const BakedScene baked = pretendToBake(readFile(file, folder));
    const Status status = writeBakedScene(folder / "baked.glb", baked);
    ASSERT_TRUE(status) << status.error().text();

    const auto again = readBakedScene(folder / "baked.glb");
    ASSERT_TRUE(again) << again.error().text();
    EXPECT_EQ(again->scene.originMeters, baked.scene.originMeters);
    expectMoved(worldPositions(again->scene), worldPositions(baked.scene), [](glm::dvec3 p) { return p; });
    for (std::size_t i = 0; i < baked.probes.probes.size(); ++i)
        EXPECT_EQ(again->probes.probes[i].position, baked.probes.probes[i].position);
    EXPECT_EQ(again->probes.origin, baked.probes.origin);
    for (const Light& light : again->scene.lights) EXPECT_FALSE(movedSinceBake(light));
    EXPECT_THAT(again->scene.warnings, testing::Not(Contains(HasSubstr("stale"))));

    // What others read: positions in JSON are the world's, those in accessors are relative to `origin`.
    const Json json = jsonOfGlb(folder / "baked.glb");
    const Json& root = json["extensions"]["HALFLIGHT_mixed_lighting"];
    for (int c = 0; c < 3; ++c) {
        EXPECT_EQ(root["origin"][std::size_t(c)].get<double>(), baked.scene.originMeters[c]);
        EXPECT_NEAR(root["authoredProbes"][0][std::size_t(c)].get<double>(), probe[c], 1.0e-6);
        const Json& pose = json["nodes"][2]["extensions"]["HALFLIGHT_light"]["baking"]["worldFromLight"];
        EXPECT_NEAR(pose[std::size_t(12 + c)].get<double>(), offset[c] + glm::dvec3(0.1, 3, 0.7)[c], 1.0e-6);
    }

    // An edit that moves everything may move the origin: the probes stay where they were.
    std::vector<char> binary;
    Json edited = jsonOfGlb(folder / "baked.glb", &binary);
    edited["buffers"][0]["uri"] = "binary.bin";
    writeText(folder / "binary.bin", std::string(binary.begin(), binary.end()));
    edited["nodes"][0]["translation"] = {900, 0.5, 2};
    edited["nodes"][1]["translation"] = {900, 0.5, 9};
    writeText(folder / "edited.gltf", edited.dump());
    const auto after = readBakedScene(folder / "edited.gltf");
    ASSERT_TRUE(after) << after.error().text();
    for (std::size_t i = 0; i < baked.probes.probes.size(); ++i) {
        EXPECT_LT(glm::distance(after->scene.originMeters + glm::dvec3(after->probes.probes[i].position),
                                baked.scene.originMeters + glm::dvec3(baked.probes.probes[i].position)),
                  1.0e-3);
    }
}

TEST(LocalOrigin, ScenesNearTheWorldsOriginKeepIt)
{
    const TemporaryFolder folder;
    for (const double x : {0.0, 1.0, -20.0, 60.0}) {
        GltfBuilder file;
        addScene(file);
        file.json["nodes"].push_back({{"children", {0, 1, 2, 3}}, {"translation", {x, 0, 0}}});
        file.json["scenes"][0]["nodes"] = {4};
        EXPECT_EQ(readFile(file, folder).originMeters, glm::dvec3(0.0)) << x;
    }
}

// A stray object at the world's origin, as exports of maps have, must not keep the rest there.
TEST(LocalOrigin, IsWhereMostObjectsAreAndTheOthersAreNamed)
{
    const TemporaryFolder folder;
    GltfBuilder file;
    file.triangle();
    file.json["nodes"] = {{{"mesh", 0}, {"name", "stray"}},
                          {{"mesh", 0}, {"name", "house"}, {"translation", {5e5, 0, -5e6}}},
                          {{"mesh", 0}, {"name", "barn"}, {"translation", {500030, 0, -5000020}}}};
    file.json["scenes"][0]["nodes"] = {0, 1, 2};
    const Scene scene = readFile(file, folder);
    EXPECT_LT(glm::distance(scene.originMeters, glm::dvec3(5e5, 0, -5e6)), 200.0);
    EXPECT_THAT(scene.warnings, Contains(testing::AllOf(HasSubstr("\"stray\""), HasSubstr("5e+03 km"),
                                                        HasSubstr("file of their own"))));
    EXPECT_THAT(scene.warnings, testing::Not(Contains(HasSubstr("house"))));
}

TEST(LocalOrigin, OfTheCaseOfUtmCoordinates)
{
    const std::filesystem::path path =
        std::filesystem::path(HALFLIGHT_SHARED_DIR) / "cases" / "georeferenced" / "geo_utm.glb";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is absent";
    const auto scene = readScene(path);
    ASSERT_TRUE(scene) << scene.error().text();
    EXPECT_EQ(scene->originMeters, glm::dvec3(5e5, 0, -5e6));
    EXPECT_EQ(scene->bounds().min, vec3(-3, 0, -3));
    EXPECT_EQ(scene->bounds().max.y, 1.7f);
}

TEST(LocalOrigin, ARecordThatIsNoneIsAnError)
{
    const TemporaryFolder folder;
    for (const Json& origin :
         {Json("x"), Json(Json::array({1, 2})), Json(Json::array({1, "2", 3})), Json(Json::array({1e30, 0, 0}))}) {
        GltfBuilder file;
        file.triangle();
        file.json["extensions"]["HALFLIGHT_mixed_lighting"]["origin"] = origin;
        file.json["extensionsUsed"] = {"HALFLIGHT_mixed_lighting"};
        const auto scene = readScene(file.write(folder));
        ASSERT_FALSE(scene) << origin;
        EXPECT_TRUE(scene.error().object.starts_with("/extensions/HALFLIGHT_mixed_lighting")) << scene.error().text();
    }
}

TEST(LocalOrigin, RecenterMovesAnEnginesSceneAndItsVertices)
{
    const Scene before = engineScene();
    Scene scene = before;
    EXPECT_FALSE(recenter(scene)) << "nothing to do";
    const vec3 offset(4096.0f, 0.0f, -65536.0f); // floats hold the scene's eighths of metres here
    for (Object& object : scene.objects) object.worldFromObject[3] += vec4(offset, 0.0f);
    for (Light& light : scene.lights) light.worldFromLight[3] += vec4(offset, 0.0f);
    for (Camera& camera : scene.cameras) camera.worldFromCamera[3] += vec4(offset, 0.0f);
    for (vec3& p : scene.probePositions) p += offset;
    EXPECT_TRUE(farFromOrigin(scene));
    EXPECT_TRUE(recenter(scene));
    EXPECT_FALSE(farFromOrigin(scene));
    expectMoved(worldPositions(scene), worldPositions(before), [&](glm::dvec3 p) { return p + glm::dvec3(offset); });
    EXPECT_LT(glm::length(scene.bounds().center()), 20.0f);

    // Far vertices under objects at the origin: one mesh, transforms that scale and mirror.
    Scene far = before;
    for (MeshPart& part : far.meshes[0].parts) {
        for (vec3& p : part.positions) p += offset;
    }
    Scene centred = far;
    EXPECT_TRUE(recenter(centred));
    for (const vec3& p : centred.meshes[0].parts[0].positions) EXPECT_LT(glm::length(p), 4.0f);
    expectMoved(
        worldPositions(centred), worldPositions(far), [](glm::dvec3 p) { return p; }, 0.01);

    // An engine's scene far out is written with the world's coordinates and read back to the same place.
    const TemporaryFolder folder;
    ASSERT_TRUE(writeBakedScene(folder / "engine.glb", pretendToBake(scene, false)));
    const auto read = readBakedScene(folder / "engine.glb");
    ASSERT_TRUE(read) << read.error().text();
    EXPECT_EQ(read->scene.originMeters, scene.originMeters);
    Scene back = read->scene;
    std::sort(back.lights.begin(), back.lights.end(), [](const Light& a, const Light& b) { return a.name < b.name; });
    expectMoved(worldPositions(back), worldPositions(scene), [](glm::dvec3 p) { return p; });
}

} // namespace
} // namespace halflight::origin_test
