#pragma once
// The court under glass of all kinds that give light a colour.

#include "bake_gpu/court.h"
#include "transport/glass_scene.h"

namespace halflight::test {

/// Glass that all rays pass, and take its colour: what alpha leaves open is all of it. Other glass is passed by chance,
/// by a hash of the ray, whose last bits differ between processor and device.
inline int addClearGlass(Scene& scene, const TextureRef& texture = {})
{
    const int material = glass::addGlassMaterial(scene, glass::Glass::Quad);
    scene.materials.back().baseColor.w = 0.0f;
    scene.materials.back().baseColorTexture = texture;
    return material;
}

/// The court under such glass, with and without a picture and colours of vertices.
inline Scene clearCourt()
{
    Scene scene = court();
    const int picture = addClearGlass(scene, {.texture = 1, .offset = vec2(0.2f), .rotationRadians = 0.7f});
    addRectangle(scene, {vec3(-2, 2.6f, 2), vec3(2, 0, 0), vec3(0, 0, -4)}, picture, kCourtPage, {}, 3);
    const int plain = addClearGlass(scene);
    addRectangle(scene, {vec3(0, 2.5f, 0), vec3(2, 0, 0), vec3(0, 0.3f, -2)}, plain, kCourtPage);
    MeshPart& part = scene.meshes.back().parts[0];
    for (std::size_t i = 0; i < part.positions.size(); ++i)
        part.colors.emplace_back(0.2f + 0.25f * float(i), 1.0f - 0.2f * float(i), 0.7f, 1.0f);
    addRectangle(scene, {vec3(-1.3f, 0, 0.2f), vec3(1, 0, 0.7f), vec3(0, 1.4f, 0)}, plain, kCourtPage);
    return scene;
}

/// Glass of a material with two textures, and colours of its vertices.
inline void addPaintedPane(Scene& scene)
{
    const int painted = glass::addGlassMaterial(scene, glass::Glass::Pane);
    Material& m = scene.materials.back();
    m.metallic = 0.4f;
    m.metallicRoughnessTexture = {.texture = 1};
    m.transmissionTexture = {.texture = 0, .scale = vec2(2.0f), .rotationRadians = 0.3f};
    addRectangle(scene, {vec3(0, 2.5f, 0), vec3(2, 0, 0), vec3(0, 0.3f, -2)}, painted, kCourtPage);
    MeshPart& part = scene.meshes.back().parts[0];
    for (std::size_t i = 0; i < part.positions.size(); ++i)
        part.colors.emplace_back(0.2f + 0.25f * float(i), 1.0f - 0.2f * float(i), 0.7f, 1.0f);
}

/// Above the court: a picture that alpha leaves open, a painted pane, a box of glass, and glass with a thickness. A
/// second box is above the floor: in the floor, chance would decide for all seeds alike which points are inside it.
inline Scene glassCourt()
{
    Scene scene = court();
    const int picture = glass::addGlassMaterial(scene, glass::Glass::Quad);
    scene.materials.back().baseColorTexture = {.texture = 1, .offset = vec2(0.2f), .rotationRadians = 0.7f};
    addRectangle(scene, {vec3(-2, 2.6f, 0), vec3(2, 0, 0), vec3(0, 0, -2)}, picture, kCourtPage, {}, 3);
    addPaintedPane(scene);
    for (const bool low : {false, true}) {
        const int volume = glass::addGlassMaterial(scene, glass::Glass::Box);
        const std::size_t first = scene.objects.size();
        if (low)
            addBox(scene, vec3(-1.3f, 0.05f, 0.6f), vec3(-0.8f, 1.2f, 1.1f), volume, false);
        else
            addBox(scene, vec3(-2, 2.2f, 0), vec3(0, 2.4f, 2), volume, false);
        joinObjects(scene, first);
    }
    const int thin = glass::addGlassMaterial(scene, glass::Glass::Thin);
    scene.materials.back().thicknessTexture = {.texture = 0};
    addRectangle(scene, {vec3(0, 1.2f, 2), vec3(2, 0.2f, 0), vec3(0, 0, -2)}, thin, kCourtPage);
    scene.objects.back().worldFromObject = glm::scale(mat4(1.0f), vec3(1, 2, 1));
    return scene;
}

/// Glass in place of the balls' skin: of solids, or of open shells with a thickness.
inline Scene withGlassSkin(Scene scene, bool open)
{
    Material& skin = scene.materials[1];
    skin.transmission = 0.8f;
    skin.baseColor = vec4(0.9f, 0.5f, 0.3f, 1.0f);
    skin.thickness = 0.1f;
    skin.attenuationColor = vec3(0.3f, 0.8f, 0.6f);
    skin.attenuationMeters = 0.5f;
    skin.metallic = 0.0f;
    if (open) {
        std::vector<uint32_t>& indices = scene.meshes.back().parts[0].indices;
        indices.resize(indices.size() - 60);
    }
    return scene;
}

} // namespace halflight::test
