#include "halflight/scene/fingerprint.h"

#include "halflight/base/parallel.h"
#include "scene/document/document.h"

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
    if (isAreaLight(light.type)) hasher.add(light.sizeMeters);
    return hasher.hash();
}

Hash128 hashOf(const Material& material, const std::vector<Hash128>& pixels)
{
    Hasher hasher;
    hasher.add(material.baseColor).add(material.metallic).add(material.roughness).add(material.emissiveNits);
    hasher.add(int(material.alphaMode)).add(material.alphaMode == Material::AlphaMode::Mask ? material.alphaCutoff : 0);
    hasher.add(int(material.doubleSided)).add(int(material.unlit)).add(int(material.castShadows));
    hasher.add(int(material.receiveShadows));
    hasher.add(material.transmission);
    addTexture(hasher, material.transmissionTexture, pixels);
    hasher.add(int(material.tinted));
    if (material.attenuates()) {
        hasher.add(material.attenuationColor).add(material.attenuationMeters).add(material.thickness);
        addTexture(hasher, material.thicknessTexture, pixels);
    }
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

void addSky(Hasher& hasher, const Sky& sky)
{
    hasher.add(sky.zenith).add(sky.horizon).add(sky.ground);
    if (sky.picture) hasher.add(sky.picture->size()).add(sky.picture->texels()).add(sky.rotationRadians);
}

Hash128 surfacesHash(const Scene& scene)
{
    Hasher hasher;
    hasher.add(materialHashes(scene));
    for (const Mesh& mesh : scene.meshes) {
        for (const MeshPart& part : mesh.parts) {
            hasher.add(part.positions).add(part.normals).add(part.tangents);
            for (const std::vector<vec2>& set : part.uv) hasher.add(set);
            hasher.add(part.colors).add(part.indices).add(part.material).add(int(part.side));
        }
    }
    for (const Object& object : scene.objects) {
        hasher.add(std::string_view(object.name)).add(object.mesh).add(object.worldFromObject);
        hasher.add(object.lightmapScale).add(int(object.twoSided));
        hasher.add(int(object.isStatic)).add(int(object.castShadows)).add(int(object.receiveShadows));
        hasher.add(int(object.probeLighting)).add(object.probeResolution);
    }
    return hasher.hash();
}

Hash128 contentHash(const Scene& scene)
{
    Hasher hasher;
    if (scene.source) {
        hasher.add(std::string_view(scene.source->json.dump()));
        for (const auto& buffer : scene.source->buffers) hasher.add(buffer);
    }
    hasher.add(textureHashes(scene)).add(surfacesHash(scene));
    for (const Light& light : scene.lights) {
        hasher.add(std::string_view(light.name)).add(lightHash(light));
        for (const std::optional<float>& bias :
             {light.shadowBias.depthTexels, light.shadowBias.slope, light.shadowBias.normalTexels})
            hasher.add(int(bias.has_value())).add(bias.value_or(0.0f));
    }
    addSky(hasher, scene.sky);
    for (const Light& light : scene.lights) hasher.add(std::string_view(light.group));
    for (const Material& material : scene.materials) hasher.add(std::string_view(material.group));
    hasher.add(std::string_view(scene.sky.group));
    if (scene.sky.changes) hasher.add(1);
    for (const Light& light : scene.lights)
        for (const vec3 direction : light.directions) hasher.add(std::string_view(light.name)).add(direction);
    hasher.add(scene.originMeters);
    hasher.add(int(scene.subtractiveShadowColor.has_value())).add(scene.subtractiveShadowColor.value_or(vec3(0.0f)));
    return hasher.add(scene.probePositions).add(scene.reflectionBoxes).hash();
}

} // namespace halflight
