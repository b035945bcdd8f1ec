#include "fuzz/entry_points.h"

#include "halflight/base/image.h"
#include "scene/document/decode/draco_mesh.h"
#include "scene/document/decode/meshopt_view.h"
#include "scene/document/document.h"
#include "scene/load/load_document.h"
#include "scene/pictures/ktx2.h"
#include "scene/pictures/rgbe.h"
#include "scene/read/read_baked.h"
#include "scene/read/read_scene.h"
#include "scene/settings/settings.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace halflight::fuzz {

namespace {

// The reader's promises to the bake and the renderer (scene.h).
void require(bool promise, const char* what)
{
    if (promise) return;
    std::fprintf(stderr, "broken promise: %s\n", what);
    std::abort();
}

void checkPart(const MeshPart& part, std::size_t materialCount)
{
    const std::size_t count = part.positions.size();
    require(part.indices.size() % 3 == 0, "indices are of whole triangles");
    for (const uint32_t index : part.indices) require(index < count, "indices are below the vertex count");
    require(part.normals.size() == count, "normals are present");
    for (const std::size_t size :
         {part.tangents.size(), part.uv[0].size(), part.uv[1].size(), part.colors.size(), part.lightmapUv.size()}) {
        require(size == 0 || size == count, "vertex arrays have one length");
    }
    for (const vec3& p : part.positions)
        require(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z), "positions are finite");
    require(part.material >= -1 && part.material < int(materialCount), "materials exist");
}

void checkScene(const Scene& scene)
{
    for (const Mesh& mesh : scene.meshes) {
        for (const MeshPart& part : mesh.parts) checkPart(part, scene.materials.size());
    }
    for (const Object& object : scene.objects) {
        require(object.mesh >= -1 && object.mesh < int(scene.meshes.size()), "meshes exist");
        for (int i = 0; i < 16; ++i) require(std::isfinite(object.worldFromObject[i / 4][i % 4]), "poses are finite");
    }
    for (const Material& material : scene.materials) {
        for (const TextureRef& ref : {material.baseColorTexture, material.metallicRoughnessTexture,
                                      material.normalTexture, material.occlusionTexture, material.emissiveTexture}) {
            require(ref.texture < int(scene.textures.size()), "textures exist");
            require(ref.texCoord == 0 || ref.texCoord == 1, "texture coordinates are 0 or 1");
        }
    }
}

void checkError(const Error& error)
{
    require(!error.message.empty(), "an error has a sentence");
}

} // namespace

bool readGltf(std::span<const std::byte> bytes)
{
    auto document = parseDocument(bytes, "/nowhere");
    if (!document) return checkError(document.error()), false;
    const auto scene = sceneFromDocument(*document, {});
    if (!scene) return checkError(scene.error()), false;
    checkScene(*scene);
    return true;
}

bool readBaked(std::span<const std::byte> bytes)
{
    auto document = parseDocument(bytes, "/nowhere");
    if (!document) return checkError(document.error()), false;
    const auto baked = bakedFromDocument(*document, {});
    if (!baked) return checkError(baked.error()), false;
    checkScene(baked->scene);
    for (const Object& object : baked->scene.objects) {
        require(object.lightmap.page < int(baked->lightmaps.size()), "lightmap pages exist");
    }
    return true;
}

bool readSettings(std::span<const std::byte> bytes)
{
    const auto settings = parseSettings({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    if (!settings) checkError(settings.error());
    return bool(settings);
}

bool decode(std::span<const std::byte> bytes)
{
    if (bytes.empty()) return false;
    const auto kind = unsigned(bytes[0]);
    bytes = bytes.subspan(1);
    constexpr uint64_t kLimitBytes = 1 << 24;
    switch (kind % 5) {
    case 0:
        return bool(decodeImage(bytes.data(), bytes.size()));
    case 1:
        return bool(decodeKtx2(bytes));
    case 4:
        return bool(decodeRgbe(bytes, int64_t(kLimitBytes / 16)));
    case 2: {
        const auto mesh = DracoMesh::decode(bytes, kLimitBytes);
        if (!mesh) return checkError(mesh.error()), false;
        for (const uint32_t index : mesh->indices()) require(index < mesh->pointCount(), "Draco indices are valid");
        for (uint64_t id = 0; id < 4; ++id) {
            for (const int componentType : {5120, 5121, 5122, 5123, 5125, 5126}) {
                const auto values = mesh->attribute(id, componentType, 4, 16);
                require(!values || values->size() == mesh->pointCount() * 16, "Draco attributes are complete");
            }
        }
        return true;
    }
    default: {
        if (bytes.size() < 4) return false;
        MeshoptView view;
        view.mode = MeshoptView::Mode(unsigned(bytes[0]) % 3);
        view.filter = MeshoptView::Filter(unsigned(bytes[1]) % 4);
        view.strideBytes = unsigned(bytes[2]);
        view.count = unsigned(bytes[3]) * 3;
        bytes = bytes.subspan(4);
        if (Status s = view.check(bytes.size()); !s) return checkError(s.error()), false;
        if (view.decodedBytes() > kLimitBytes) return false;
        const auto decoded = view.decode(bytes);
        require(!decoded || decoded->size() == view.decodedBytes(), "meshopt data is complete");
        return bool(decoded);
    }
    }
}

} // namespace halflight::fuzz
