#pragma once
// Helpers of the scene module's tests: small glTF files built in memory, and a stand-in for a bake.

#include "scene/model/geometry.h"

#include "halflight/scene/gltf.h"
#include "halflight/shading/random.h"

#include <cstring>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <string>
#include <unistd.h>
#include <vector>

namespace halflight::test {

using Json = nlohmann::json;

/// A folder of its own for each test, removed at the end.
class TemporaryFolder {
public:
    TemporaryFolder()
    {
        const auto* info = testing::UnitTest::GetInstance()->current_test_info();
        std::string name = std::string("halflight_") + info->test_suite_name() + "_" + info->name();
        for (char& c : name) c = c == '/' ? '_' : c;
        path_ = std::filesystem::temp_directory_path() / (name + "_" + std::to_string(::getpid()));
        std::filesystem::remove_all(path_);
        std::filesystem::create_directories(path_);
    }
    ~TemporaryFolder()
    {
        std::error_code ec;
        std::filesystem::remove_all(path_, ec);
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    std::filesystem::path operator/(const std::filesystem::path& name) const { return path_ / name; }
    [[nodiscard]] const std::filesystem::path& path() const { return path_; }

private:
    std::filesystem::path path_;
};

inline void writeText(const std::filesystem::path& path, const std::string& text)
{
    std::ofstream(path, std::ios::binary) << text;
}

/// Builds a .gltf with one external buffer: data(), accessor(), then write().
class GltfBuilder {
public:
    Json json = {{"asset", {{"version", "2.0"}}}, {"scene", 0}, {"scenes", {{{"nodes", {0}}}}}};

    template<typename T> int view(const std::vector<T>& values, int stride = 0)
    {
        while (bytes_.size() % 4 != 0) bytes_.push_back(0);
        Json view = {{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", values.size() * sizeof(T)}};
        if (stride > 0) view["byteStride"] = stride;
        const auto* first = reinterpret_cast<const char*>(values.data());
        bytes_.insert(bytes_.end(), first, first + values.size() * sizeof(T));
        json["bufferViews"].push_back(view);
        return int(json["bufferViews"].size()) - 1;
    }
    template<typename T> int accessor(const std::vector<T>& values, int componentType, const char* type,
                                      std::size_t components, bool normalized = false)
    {
        Json accessor = {{"bufferView", view(values)},
                         {"componentType", componentType},
                         {"type", type},
                         {"count", values.size() / components}};
        if (normalized) accessor["normalized"] = true;
        return add(accessor);
    }
    int floats(const std::vector<float>& values, const char* type, std::size_t components)
    {
        return accessor(values, 5126, type, components);
    }
    int add(const Json& accessor)
    {
        json["accessors"].push_back(accessor);
        return int(json["accessors"].size()) - 1;
    }
    /// One triangle (0,0,0) (1,0,0) (0,1,0) as mesh 0 on node 0.
    void triangle()
    {
        json["meshes"] = {
            {{"primitives", {{{"attributes", {{"POSITION", floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3", 3)}}}}}}}};
        json["nodes"] = {{{"mesh", 0}, {"name", "triangle"}}};
    }
    std::filesystem::path write(const TemporaryFolder& folder, const std::string& name = "scene.gltf")
    {
        if (!bytes_.empty()) {
            json["buffers"] = {{{"byteLength", bytes_.size()}, {"uri", "the%20data.bin"}}};
            writeText(folder / "the data.bin", std::string(bytes_.begin(), bytes_.end()));
        }
        writeText(folder / name, json.dump(1));
        return folder / name;
    }

private:
    std::vector<char> bytes_;
};

/// JSON chunk of a GLB.
inline Json jsonOfGlb(const std::filesystem::path& path, std::vector<char>* binary = nullptr)
{
    std::ifstream stream(path, std::ios::binary);
    const std::vector<char> bytes((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
    uint32_t length = 0;
    if (bytes.size() < 20) return {};
    std::memcpy(&length, &bytes[12], 4);
    if (binary != nullptr && bytes.size() > 28 + length) binary->assign(bytes.begin() + 28 + length, bytes.end());
    return Json::parse(bytes.begin() + 20, bytes.begin() + 20 + length);
}

/// A scene as an engine would fill it: no source document.
inline Scene engineScene()
{
    Scene scene;
    scene.name = "engine";
    Texture texture;
    texture.name = "checker";
    texture.pixels = ImageRgba8(4, 4, u8vec4(200, 100, 50, 255));
    texture.pixels.edit()(1, 2) = u8vec4(1, 2, 3, 4);
    texture.wrapU = Texture::Wrap::ClampToEdge;
    scene.textures.push_back(texture);
    Material material;
    material.name = "painted";
    material.baseColor = {0.5f, 0.6f, 0.7f, 1.0f};
    material.baseColorTexture.texture = 0;
    material.baseColorTexture.scale = {2.0f, 3.0f};
    material.baseColorTexture.offset = {0.25f, 0.5f};
    material.roughness = 0.3f;
    material.metallic = 0.1f;
    material.emissiveNits = {0.0f, 5.0f, 2.0f};
    material.alphaMode = Material::AlphaMode::Mask;
    material.alphaCutoff = 0.25f;
    material.doubleSided = true;
    material.receiveShadows = false;
    scene.materials.push_back(material);
    Mesh mesh;
    mesh.name = "quad";
    MeshPart part;
    part.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    part.normals.assign(4, vec3(0, 0, 1));
    part.uv[0] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    part.indices = {0, 1, 2, 0, 2, 3};
    part.material = 0;
    mesh.parts.push_back(part);
    part.material = -1;
    part.uv[0].clear();
    mesh.parts.push_back(part);
    scene.meshes.push_back(mesh);
    for (int i = 0; i < 3; ++i) {
        Object object;
        object.name = "quad " + std::to_string(i);
        object.mesh = 0;
        object.worldFromObject[3] = vec4(float(i), 2.0f, 0.0f, 1.0f);
        if (i == 1) object.worldFromObject[0].x = -2.0f;
        object.isStatic = i != 2;
        object.castShadows = i != 1;
        object.lightmapScale = i == 0 ? 2.5f : 1.0f;
        if (i == 1) object.probeLighting = ProbeLighting::Single;
        if (i == 2) object.probeLighting = ProbeLighting::Volume;
        if (i == 2) object.probeResolution = {3, 4, 5};
        scene.objects.push_back(object);
    }
    for (const LightType type :
         {LightType::Directional, LightType::Point, LightType::Spot, LightType::Rectangle, LightType::Disk}) {
        Light light;
        light.name = "light " + std::to_string(int(type));
        light.type = type;
        light.color = {1.0f, 0.9f, 0.8f};
        light.intensity = 12.3f;
        if (type == LightType::Spot) light.innerConeRadians = 0.2f;
        if (type != LightType::Directional) light.rangeMeters = 7.5f;
        if (isAreaLight(type)) light.sizeMeters = type == LightType::Disk ? vec2(0.6f) : vec2(1.5f, 0.25f);
        light.worldFromLight[3] = vec4(1, 2, 3, 1);
        scene.lights.push_back(light);
    }
    Camera camera;
    camera.name = "eye";
    camera.worldFromCamera[3] = vec4(0, 1, 5, 1);
    scene.cameras.push_back(camera);
    scene.sky.zenith = {0.1f, 0.2f, 0.3f};
    scene.subtractiveShadowColor = {0.01f, 0.02f, 0.03f};
    scene.probePositions = {{1, 2, 3}, {4, 5, 6}};
    scene.reflectionBoxes = {mat4(2.0f)};
    scene.reflectionBoxes[0][3] = {1.0f, 1.5f, 2.0f, 1.0f};
    return scene;
}

/// Each vertex of both objects has its texel at the same place of the same page, to float rounding.
inline void expectSameTexels(const Scene& a, const Object& x, const Scene& b, const Object& y)
{
    EXPECT_EQ(x.lightmap.page, y.lightmap.page);
    if (x.lightmap.page < 0 || y.lightmap.page < 0) return;
    const Mesh& m = a.meshes[std::size_t(x.mesh)];
    const Mesh& n = b.meshes[std::size_t(y.mesh)];
    ASSERT_EQ(m.parts.size(), n.parts.size());
    float farthest = 0.0f;
    for (std::size_t p = 0; p < m.parts.size(); ++p) {
        ASSERT_EQ(m.parts[p].lightmapUv.size(), n.parts[p].lightmapUv.size());
        for (const uint32_t v : m.parts[p].indices) {
            const vec2 first = x.lightmap.scale * m.parts[p].lightmapUv[v] + x.lightmap.offset;
            const vec2 second = y.lightmap.scale * n.parts[p].lightmapUv[v] + y.lightmap.offset;
            farthest = std::max(farthest, glm::distance(first, second));
        }
    }
    EXPECT_LT(farthest, 1.0e-6f) << x.name;
}

inline float pretended(std::size_t i, uint32_t salt)
{
    return unitFloat(hashCombine(uint32_t(i), salt));
}

/// One corner of every triangle gets a vertex of its own.
inline void splitVerticesOf(MeshPart& part)
{
    std::vector<uint32_t> kept(part.positions.size());
    for (std::size_t i = 0; i < kept.size(); ++i) kept[i] = uint32_t(i);
    for (std::size_t c = 0; c < part.indices.size(); c += 3) {
        kept.push_back(part.indices[c]);
        part.indices[c] = uint32_t(kept.size() - 1);
    }
    selectVertices(part, kept);
}

inline void pretendLightmapped(Scene& scene, bool splitVertices)
{
    for (Mesh& mesh : scene.meshes) {
        for (MeshPart& part : mesh.parts) {
            if (splitVertices) splitVerticesOf(part);
            part.lightmapUv.resize(part.positions.size());
            for (std::size_t i = 0; i < part.lightmapUv.size(); ++i)
                part.lightmapUv[i] = {pretended(i, 1), pretended(i, 2)};
        }
    }
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        Object& object = scene.objects[i];
        if (!object.isStatic) continue;
        object.lightmap.page = int(i % 2);
        object.lightmap.scale = {0.1f + 0.3f * pretended(i, 3), 0.25f};
        object.lightmap.offset = {0.5f * pretended(i, 4), 0.5f * pretended(i, 5)};
    }
}

inline void pretendPages(BakedScene& baked)
{
    baked.maskChannels[2] = {4.0f, 0.75f};
    for (int page = 0; page < 2; ++page) {
        Image<uint32_t> lightmap(33, 17);
        ImageRgba8 mask(33, 17);
        for (std::size_t i = 0; i < lightmap.texelCount(); ++i) {
            lightmap.texels()[i] = hashCombine(uint32_t(i), uint32_t(page));
            const uint32_t h = hashPcg(uint32_t(i) + 7u);
            mask.texels()[i] = u8vec4(h & 255, h >> 8 & 255, h >> 16 & 255, h >> 24);
        }
        baked.lightmaps.push_back(std::move(lightmap));
        ImageRgba8 directions(33, 17, u8vec4(10, 200, 128, 255));
        directions(page, 3) = u8vec4(255, 0, uint8_t(page), 255);
        baked.lightmapDirections.push_back(std::move(directions));
        baked.shadowmasks.push_back(std::move(mask));
    }
}

inline void pretendLights(Scene& scene)
{
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        Light& light = scene.lights[i];
        light.shadowStrength = 0.1f + 0.05f * float(i);
        light.indirectMultiplier = 1.7f;
        if (light.type == LightType::Directional) light.angularRadiusRadians = 0.00465f;
        if (light.type != LightType::Directional) light.radiusMeters = 0.07f;
        light.baking.isBaked = true;
        light.baking.bakeType = i == 4 ? LightMode::Baked : light.mode;
        light.baking.mixedMode = MixedLightingMode::Shadowmask;
        light.baking.occlusionMaskChannel = i < 4 ? int(i) : -1;
        light.baking.reason = i == 4 ? "more than four overlap" : "";
        light.baking.worldFromLight = light.worldFromLight;
    }
}

inline void pretendProbes(BakedScene& baked)
{
    baked.probes.origin = {0.1f, 0.2f, 0.3f};
    baked.probes.spacingMeters = {1.1f, 2.2f, 3.3f};
    baked.probes.size = {3, 2, 2};
    for (std::size_t i = 0; i < 12; ++i) {
        Probe probe;
        probe.position =
            baked.probes.origin + baked.probes.spacingMeters * vec3(float(i % 3), float(i / 3 % 2), float(i / 6));
        for (std::size_t k = 0; k < 9; ++k)
            probe.radiance[k] = vec3(pretended(i, uint32_t(20 + k)) - 0.5f, 0.1f, pretended(k, uint32_t(i)));
        probe.occlusion.layers[0] = {pretended(i, 9), 1.0f, 0.0f, pretended(i, 10)};
        probe.valid = i != 5;
        baked.probes.probes.push_back(probe);
    }
}

inline void pretendReflections(BakedScene& baked)
{
    baked.reflections.size = 32;
    baked.reflections.unitNits = 8.0f;
    baked.reflections.picture = Image<uint32_t>(32, 2 * 48);
    for (std::size_t i = 0; i < baked.reflections.picture.texelCount(); ++i)
        baked.reflections.picture.texels()[i] = hashCombine(uint32_t(i), 77u);
    for (std::size_t i = 0; i < 2; ++i) {
        ReflectionProbe probe{vec3(pretended(i, 30), 1.5f, pretended(i, 31)), mat4(1.0f), 0.125f + float(i)};
        probe.worldFromBox[0] = {1.5f, 0.0f, 0.5f, 0.0f};
        probe.worldFromBox[1].y = 2.5f;
        probe.worldFromBox[3] = {float(i), 2.0f, -3.0f, 1.0f};
        baked.reflections.probes.push_back(probe);
    }
}

/// What a bake would do to a scene, with made-up values: vertices split wherever a hash says so, lightmap coordinates,
/// bindings, lightmaps, masks, probes, and a light of each baking output.
inline BakedScene pretendToBake(Scene scene, bool splitVertices = true)
{
    BakedScene baked;
    baked.isBaked = true;
    baked.mode = MixedLightingMode::Shadowmask;
    baked.lightmapUnitLux = 4.0f;
    baked.defaultShadowColor = {0.5f, 0.25f, 0.125f};
    pretendLightmapped(scene, splitVertices);
    pretendPages(baked);
    pretendLights(scene);
    pretendProbes(baked);
    pretendReflections(baked);
    baked.scene = std::move(scene);
    return baked;
}

} // namespace halflight::test
