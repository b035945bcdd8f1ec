#include "halflight/scene/fingerprint.h"

#include "halflight/base/parallel.h"
#include "scene/document.h"

#include <algorithm>

namespace halflight {

namespace {

void addTexture(Hasher& hasher, const TextureRef& ref, const std::vector<Hash128>& pixels)
{
    hasher.add(ref ? pixels[std::size_t(ref.texture)] : Hash128{});
    if (ref) hasher.add(ref.texCoord).add(ref.offset).add(ref.scale).add(ref.rotationRadians);
}

std::vector<Hash128> textureHashes(const Scene& scene)
{
    std::vector<Hash128> hashes(scene.textures.size());
    parallelFor(hashes.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Texture& texture = scene.textures[i];
            Hasher hasher;
            hasher.add(texture.pixels.size()).add(int(texture.wrapU)).add(int(texture.wrapV));
            hashes[i] = hasher.add(texture.pixels.texels()).hash();
        }
    });
    return hashes;
}

/// Shape and size of a light: neither its pose nor its colour.
Hash128 lightShapeHash(const Light& light)
{
    Hasher hasher;
    hasher.add(int(light.type)).add(light.rangeMeters).add(light.innerConeRadians).add(light.outerConeRadians);
    hasher.add(int(light.castShadows)).add(light.radiusMeters).add(light.angularRadiusRadians);
    return hasher.hash();
}

Hash128 hashOf(const Material& material, const std::vector<Hash128>& pixels)
{
    Hasher hasher;
    hasher.add(material.baseColor).add(material.metallic).add(material.roughness).add(material.emissiveNits);
    hasher.add(int(material.alphaMode)).add(material.alphaMode == Material::AlphaMode::Mask ? material.alphaCutoff : 0);
    hasher.add(int(material.doubleSided)).add(int(material.unlit)).add(int(material.castShadows));
    if (!material.receiveShadows) hasher.add(int(material.receiveShadows)); // files of before hash what they did
    addTexture(hasher, material.baseColorTexture, pixels);
    addTexture(hasher, material.metallicRoughnessTexture, pixels);
    addTexture(hasher, material.emissiveTexture, pixels);
    return hasher.hash();
}

} // namespace

std::vector<Hash128> materialHashes(const Scene& scene)
{
    const std::vector<Hash128> pixels = textureHashes(scene);
    std::vector<Hash128> hashes;
    for (const Material& material : scene.materials) hashes.push_back(hashOf(material, pixels));
    hashes.push_back(hashOf(defaultMaterial(), pixels));
    return hashes;
}

const Hash128& materialHash(std::span<const Hash128> hashes, int material)
{
    return material >= 0 ? hashes[std::size_t(material)] : hashes.back();
}

Hash128 lightHash(const Light& light)
{
    Hasher hasher;
    hasher.add(lightShapeHash(light)).add(int(light.mode)).add(light.shadowStrength).add(light.worldFromLight);
    return hasher.add(light.color).add(light.intensity).add(light.indirectMultiplier).hash();
}

Hash128 contentHash(const Scene& scene)
{
    Hasher hasher;
    if (scene.source) {
        hasher.add(std::string_view(scene.source->json.dump()));
        for (const tinygltf::Buffer& buffer : scene.source->model.buffers) hasher.add(buffer.data);
    }
    hasher.add(textureHashes(scene)).add(materialHashes(scene));
    for (const Mesh& mesh : scene.meshes) {
        for (const MeshPart& part : mesh.parts) {
            hasher.add(part.positions).add(part.normals).add(part.tangents).add(part.uv[0]).add(part.uv[1]);
            hasher.add(part.colors).add(part.indices).add(part.material);
        }
    }
    for (const Object& object : scene.objects) {
        hasher.add(std::string_view(object.name)).add(object.mesh).add(object.worldFromObject);
        hasher.add(object.lightmapScale);
        hasher.add(int(object.isStatic)).add(int(object.castShadows)).add(int(object.receiveShadows));
        hasher.add(int(object.probeLighting)).add(object.probeResolution);
    }
    for (const Light& light : scene.lights) {
        hasher.add(std::string_view(light.name)).add(lightHash(light));
        for (const std::optional<float>& bias :
             {light.shadowBias.depthTexels, light.shadowBias.slope, light.shadowBias.normalTexels})
            hasher.add(int(bias.has_value())).add(bias.value_or(0.0f));
    }
    hasher.add(scene.sky.zenith).add(scene.sky.horizon).add(scene.sky.ground);
    hasher.add(scene.originMeters);
    hasher.add(int(scene.subtractiveShadowColor.has_value())).add(scene.subtractiveShadowColor.value_or(vec3(0.0f)));
    return hasher.add(scene.probePositions).hash();
}

SceneFingerprints::SceneFingerprints(const Scene& scene)
    : scene_(scene), complete_(std::none_of(scene.textures.begin(), scene.textures.end(),
                                            [](const Texture& texture) { return texture.pixels.empty(); })),
      materials_(materialHashes(scene))
{}

std::string SceneFingerprints::ofObjects(std::span<const Object* const> objects) const
{
    Hasher hasher;
    bool any = false;
    for (const Object* object : objects) {
        if (!object->isStatic || object->mesh < 0) continue;
        any = true;
        hasher.add(object->worldFromObject).add(int(object->castShadows)).add(object->sourceInstance);
        if (!object->receiveShadows) hasher.add(int(object->receiveShadows));
        for (const MeshPart& part : scene_.meshes[std::size_t(object->mesh)].parts) {
            hasher.add(materialHash(materials_, part.material));
            const auto vertices = [&](const auto& values) {
                if (values.empty()) return;
                for (const uint32_t index : part.indices) hasher.add(values[index]);
            };
            hasher.add(uint64_t(part.indices.size()));
            vertices(part.positions);
            vertices(part.uv[0]);
            vertices(part.colors);
        }
    }
    return any ? hasher.hash().hex() : std::string();
}

std::string SceneFingerprints::ofLight(const Light& light) const
{
    if (!light.baking.isBaked || light.baking.bakeType == LightMode::Realtime) return {};
    Hasher hasher;
    hasher.add(lightShapeHash(light));
    // A subtractive lightmap holds direct light of mixed lights, too; fingerprints of versions that kept no LightAtBake
    // do not say so.
    const bool known = light.baking.bakeType == LightMode::Baked || light.baking.atBake.known;
    if (directLightIsBaked(light) && known) hasher.add(light.color).add(light.intensity);
    return hasher.hash().hex();
}

std::string SceneFingerprints::ofScene() const
{
    const auto isStatic = [](const Object& object) { return object.isStatic && object.mesh >= 0; };
    const auto isBaked = [](const Light& light) {
        return light.baking.isBaked && light.baking.bakeType != LightMode::Realtime;
    };
    Hasher hasher;
    hasher.add(scene_.sky.zenith).add(scene_.sky.horizon).add(scene_.sky.ground);
    hasher.add(int64_t(std::count_if(scene_.objects.begin(), scene_.objects.end(), isStatic)));
    hasher.add(int64_t(std::count_if(scene_.lights.begin(), scene_.lights.end(), isBaked)));
    return hasher.hash().hex();
}

} // namespace halflight
