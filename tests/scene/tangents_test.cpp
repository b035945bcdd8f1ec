// Tangents that the reader makes: against the formula where there is one, and against MikkTSpace itself (the npm
// package) on shared scenes and on meshes with mirrored and degenerate triangles.

#include "fixtures.h"
#include "validator.h"

#include <cmath>
#include <gmock/gmock.h>
#include <sstream>

namespace halflight::tangents_test {
namespace {

using namespace test;

/// A file with one mesh, normal-mapped, from its vertices and triangles.
struct Shape {
    std::vector<float> positions, normals, uv;
    std::vector<uint32_t> indices;
    void vertex(vec3 p, vec3 n, vec2 t)
    {
        n = glm::normalize(n);
        positions.insert(positions.end(), {p.x, p.y, p.z});
        normals.insert(normals.end(), {n.x, n.y, n.z});
        uv.insert(uv.end(), {t.x, t.y});
    }
};

std::filesystem::path write(const Shape& shape, const TemporaryFolder& folder, const Json& transform = {})
{
    GltfBuilder file;
    EXPECT_TRUE(writePng(folder / "n.png", ImageRgba8(1, 1, u8vec4(128, 128, 255, 255))));
    file.json["images"] = {{{"uri", "n.png"}}};
    file.json["textures"] = {{{"source", 0}}};
    file.json["materials"] = {{{"normalTexture", {{"index", 0}}}}};
    if (!transform.is_null())
        file.json["materials"][0]["normalTexture"]["extensions"]["KHR_texture_transform"] = transform;
    file.json["meshes"] = {{{"primitives",
                             {{{"attributes",
                                {{"POSITION", file.floats(shape.positions, "VEC3", 3)},
                                 {"NORMAL", file.floats(shape.normals, "VEC3", 3)},
                                 {"TEXCOORD_0", file.floats(shape.uv, "VEC2", 2)}}},
                               {"indices", file.accessor<uint32_t>(shape.indices, 5125, "SCALAR", 1)},
                               {"material", 0}}}}}};
    file.json["nodes"] = {{{"mesh", 0}}};
    return file.write(folder);
}

/// A sphere whose u runs round the y axis `turns` times and whose v runs down, welded but for its seam.
Shape sphere(int columns, int rows, float turns)
{
    Shape shape;
    for (int y = 0; y <= rows; ++y) {
        for (int x = 0; x <= columns; ++x) {
            const float phi = 2.0f * kPi * float(x) / float(columns);
            const float theta = kPi * float(y) / float(rows);
            const vec3 p(std::sin(theta) * std::sin(phi), std::cos(theta), std::sin(theta) * std::cos(phi));
            shape.vertex(p, p, {turns * float(x) / float(columns), float(y) / float(rows)});
        }
    }
    const auto at = [&](int x, int y) { return uint32_t(y * (columns + 1) + x); };
    for (int y = 0; y < rows; ++y) {
        for (int x = 0; x < columns; ++x) {
            for (const uint32_t i :
                 {at(x, y), at(x, y + 1), at(x + 1, y + 1), at(x, y), at(x + 1, y + 1), at(x + 1, y)})
                shape.indices.push_back(i);
        }
    }
    return shape;
}

TEST(Tangents, OfASphereRunAlongItsParallels)
{
    const TemporaryFolder folder;
    for (const float turns : {1.0f, -2.0f}) {
        const auto scene = readScene(write(sphere(48, 24, turns), folder));
        ASSERT_TRUE(scene) << scene.error().text();
        const MeshPart& part = scene->meshes.at(0).parts.at(0);
        ASSERT_EQ(part.tangents.size(), part.positions.size());
        for (std::size_t v = 0; v < part.tangents.size(); ++v) {
            const vec3 n = part.normals[v];
            if (std::abs(n.y) > 0.97f) continue; // near the poles triangles are far from the surface
            const vec3 along = glm::normalize(vec3(n.z, 0, -n.x)) * (turns > 0.0f ? 1.0f : -1.0f);
            // A vertex of the seam has triangles on one side alone: half a column of 7.5 degrees.
            EXPECT_GT(glm::dot(vec3(part.tangents[v]), along), std::cos(glm::radians(3.8f))) << v;
            // cross(normal, tangent) * w is up where the picture's v runs down (glTF's green).
            EXPECT_EQ(part.tangents[v].w, turns > 0.0f ? 1.0f : -1.0f) << v;
        }
    }
}

TEST(Tangents, HaveTheSignOfAuthoredOnes)
{
    const auto path = std::filesystem::path(HALFLIGHT_SHARED_DIR) / "scenes" / "negative_scale_zoo.glb";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "no shared scenes beside this checkout";
    const auto authored = readScene(path, {.decodeTextures = false});
    ASSERT_TRUE(authored) << authored.error().text();
    // The same file without its tangents.
    std::ifstream stream(path, std::ios::binary);
    std::string bytes((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
    for (std::size_t at = 0; (at = bytes.find("\"TANGENT\"", at)) != std::string::npos;)
        bytes.replace(at, 9, "\"_TANGEN\"");
    const TemporaryFolder folder;
    writeText(folder / "without.glb", bytes);
    const auto made = readScene(folder / "without.glb", {.decodeTextures = false});
    ASSERT_TRUE(made) << made.error().text();
    int compared = 0;
    for (std::size_t m = 0; m < authored->meshes.size(); ++m) {
        for (std::size_t p = 0; p < authored->meshes[m].parts.size(); ++p) {
            const MeshPart& a = authored->meshes[m].parts[p];
            const MeshPart& b = made->meshes[m].parts[p];
            for (std::size_t c = 0; c < a.indices.size() && !a.tangents.empty(); ++c) {
                const vec4 t = a.tangents[a.indices[c]];
                const vec4 u = b.tangents[b.indices[c]];
                EXPECT_EQ(t.w, u.w);
                EXPECT_GT(glm::dot(vec3(t), vec3(u)), 0.9f);
                ++compared;
            }
        }
    }
    EXPECT_GT(compared, 0);
}

vec2 mapped(const TextureRef& ref, vec2 uv)
{
    const float c = std::cos(ref.rotationRadians);
    const float s = std::sin(ref.rotationRadians);
    const vec2 t = uv * ref.scale;
    return vec2(c * t.x + s * t.y, -s * t.x + c * t.y);
}

/// What a part asks of MikkTSpace, and what its corners have.
struct Question {
    std::string name;
    std::vector<float> corners;
    std::vector<vec4> tangents;
};

/// The parts of the scene whose tangents were made.
void addQuestions(const Scene& scene, const Json& source, const std::string& name, std::vector<Question>& questions)
{
    for (const Mesh& mesh : scene.meshes) {
        for (const MeshPart& part : mesh.parts) {
            const Json& attributes = source["meshes"][std::size_t(mesh.sourceMesh)]["primitives"]
                                           [std::size_t(part.sourcePrimitive)]["attributes"];
            if (part.tangents.empty() || attributes.contains("TANGENT")) continue;
            const TextureRef& ref = materialOf(scene, part).normalTexture;
            Question question{name + " " + mesh.name, {}, {}};
            for (const uint32_t i : part.indices) {
                const vec3 p = part.positions[i];
                const vec3 n = part.normals[i];
                const vec2 t = mapped(ref, part.uv[std::size_t(ref.texCoord)][i]);
                question.corners.insert(question.corners.end(), {p.x, p.y, p.z, n.x, n.y, n.z, t.x, t.y});
                question.tangents.push_back(part.tangents[i]);
            }
            questions.push_back(std::move(question));
        }
    }
}

/// Whether MikkTSpace has an answer for the corner's triangle: it has area in the world and in the picture.
bool isProper(const std::vector<float>& corners, std::size_t corner)
{
    const float* a = &corners[corner / 3 * 24];
    const auto p = [&](int k) { return glm::dvec3(a[8 * k], a[8 * k + 1], a[8 * k + 2]); };
    const auto t = [&](int k) { return glm::dvec2(a[8 * k + 6], a[8 * k + 7]); };
    const glm::dvec3 e1 = p(1) - p(0);
    const glm::dvec3 e2 = p(2) - p(0);
    const glm::dvec2 d1 = t(1) - t(0);
    const glm::dvec2 d2 = t(2) - t(0);
    return glm::length(glm::cross(e1, e2)) > 1e-6 * (glm::dot(e1, e1) + glm::dot(e2, e2)) &&
           std::abs(d1.x * d2.y - d1.y * d2.x) > 1e-6 * (glm::dot(d1, d1) + glm::dot(d2, d2));
}

/// `mayDiffer`: this share of the corners, where what degenerates beside them leaves several answers.
void compareWithMikkTSpace(const std::vector<Question>& questions, const TemporaryFolder& folder, double mayDiffer)
{
    std::string output;
    if (test::run("node --version 2>/dev/null", output) != 0) GTEST_SKIP() << "node is not installed";
    std::string command = std::string("node '") + HALFLIGHT_SOURCE_DIR + "/tests/scene/mikktspace.js'";
    for (std::size_t q = 0; q < questions.size(); ++q) {
        const auto& corners = questions[q].corners;
        const auto path = folder / ("part" + std::to_string(q));
        writeText(path, std::string(reinterpret_cast<const char*>(corners.data()), corners.size() * sizeof(float)));
        command += " '" + path.string() + "'";
    }
    output.clear();
    const int exitCode = test::run(command + " 2>&1", output);
    if (exitCode == 3) GTEST_SKIP() << output;
    ASSERT_EQ(exitCode, 0) << output;
    std::size_t proper = 0;
    std::size_t differ = 0;
    std::ostringstream first;
    for (std::size_t q = 0; q < questions.size(); ++q) {
        const Question& question = questions[q];
        std::ifstream stream(folder / ("part" + std::to_string(q) + ".tangents"), std::ios::binary);
        std::vector<vec4> expected(question.tangents.size());
        stream.read(reinterpret_cast<char*>(expected.data()), std::streamsize(expected.size() * sizeof(vec4)));
        ASSERT_TRUE(stream) << question.name;
        for (std::size_t c = 0; c < expected.size(); ++c) {
            if (!isProper(question.corners, c)) continue;
            ++proper;
            const bool same = glm::dot(vec3(expected[c]), vec3(question.tangents[c])) > std::cos(glm::radians(0.5f)) &&
                              -expected[c].w == question.tangents[c].w; // glTF's v points down
            if (!same && ++differ <= 5) {
                const vec4 e = expected[c];
                const vec4 t = question.tangents[c];
                first << question.name << " corner " << c << ": " << t.x << ' ' << t.y << ' ' << t.z << ' ' << t.w
                      << ", not " << e.x << ' ' << e.y << ' ' << e.z << ' ' << -e.w << '\n';
            }
        }
    }
    std::printf("%zu of %zu corners agree with MikkTSpace\n", proper - differ, proper);
    EXPECT_GT(proper, 100u);
    EXPECT_LE(double(differ), mayDiffer * double(proper)) << first.str();
}

TEST(Tangents, AreMikkTSpacesOnSharedScenes)
{
    const TemporaryFolder folder;
    std::vector<Question> questions;
    for (const char* name : {"mixed_lighting_chair.glb", "primitive_zoo.glb", "alpha_blend_mode_test.glb",
                             "negative_scale_zoo.glb", "sponza_crytek.glb"}) {
        const auto path = std::filesystem::path(HALFLIGHT_SHARED_DIR) / "scenes" / name;
        if (!std::filesystem::exists(path)) GTEST_SKIP() << "no shared scenes beside this checkout";
        const auto scene = readScene(path, {.decodeTextures = false});
        ASSERT_TRUE(scene) << scene.error().text();
        addQuestions(*scene, jsonOfGlb(path), name, questions);
    }
    compareWithMikkTSpace(questions, folder, 0.0);
}

TEST(Tangents, AreMikkTSpacesOnMirroredSharedAndDegenerateTriangles)
{
    const TemporaryFolder folder;
    std::vector<Question> questions;
    const auto add = [&](const Shape& shape, const std::string& name, const Json& transform = {}) {
        const auto path = write(shape, folder, transform);
        const auto scene = readScene(path);
        ASSERT_TRUE(scene) << scene.error().text();
        std::ifstream stream(path);
        addQuestions(*scene, Json::parse(stream), name, questions);
    };
    add(sphere(16, 8, 1.0f), "sphere");
    add(sphere(16, 8, -3.0f), "mirrored sphere");
    add(sphere(12, 6, 1.0f), "turned sphere", {{"rotation", 0.7}, {"scale", {2.0, -0.5}}});
    const auto random = [](uint32_t i, uint32_t k) { return unitFloat(hashCombine(i, k)); };
    for (uint32_t seed = 0; seed < 20; ++seed) {
        // A wavy grid with shared vertices: halves mirror the picture, some texels are stretched to a line or a point,
        // some vertices are in one place.
        Shape shape;
        const int n = 9;
        for (int y = 0; y < n; ++y) {
            for (int x = 0; x < n; ++x) {
                const auto i = uint32_t(y * n + x);
                vec3 p(x, random(i, seed), y);
                vec2 t(std::abs(float(x) - 4.0f), float(y) + 0.3f * random(i, seed + 100));
                if (random(i, seed + 200) < 0.05f) t = vec2(0.5f);
                if (random(i, seed + 300) < 0.05f) p = vec3(3, 0, 3);
                shape.vertex(p, vec3(random(i, seed + 400) - 0.5f, 1, random(i, seed + 500) - 0.5f), t);
            }
        }
        for (int y = 0; y + 1 < n; ++y) {
            for (int x = 0; x + 1 < n; ++x) {
                const auto a = uint32_t(y * n + x);
                for (const uint32_t i : {a, a + n, a + n + 1, a, a + n + 1, a + 1}) shape.indices.push_back(i);
            }
        }
        add(shape, "grid " + std::to_string(seed));
    }
    compareWithMikkTSpace(questions, folder, 0.001);
}

} // namespace
} // namespace halflight::tangents_test
