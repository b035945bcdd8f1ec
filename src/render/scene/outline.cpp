// What of a bake is kept beside its scene on the device.
#include "render/scene/gpu_scene.h"

namespace halflight {

BakedScene outlineOf(const BakedScene& baked)
{
    BakedScene outline;
    outline.mode = baked.mode;
    outline.isBaked = baked.isBaked;
    outline.lightmaps.resize(baked.lightmaps.size());
    outline.maskLayers = baked.maskLayers;
    outline.maskChannels = baked.maskChannels;
    outline.lightmapUnitLux = baked.lightmapUnitLux;
    outline.shadowmasks.resize(baked.shadowmasks.size());
    outline.lightmapDirections.resize(baked.lightmapDirections.size());
    outline.scene.objects = baked.scene.objects;
    for (const Mesh& mesh : baked.scene.meshes) {
        std::vector<MeshPart>& parts = outline.scene.meshes.emplace_back().parts;
        for (const MeshPart& part : mesh.parts) parts.emplace_back().material = part.material;
    }
    outline.scene.materials = baked.scene.materials;
    outline.scene.lights = baked.scene.lights;
    outline.scene.sky = baked.scene.sky;
    outline.scene.originMeters = baked.scene.originMeters;
    outline.scene.subtractiveShadowColor = baked.scene.subtractiveShadowColor;
    outline.defaultShadowColor = baked.defaultShadowColor;
    for (const BakedGroup& group : baked.groups) {
        BakedGroup& own = outline.groups.emplace_back();
        own.name = group.name;
        own.weight = group.weight;
        own.sky = group.sky;
        own.radiance = group.radiance;
        own.reflections = group.reflections;
        own.shadowColor = group.shadowColor;
    }
    if (!baked.groups.empty()) outline.probes.probes = baked.probes.probes;
    if (!baked.groups.empty()) outline.reflections = baked.reflections; // with the pictures, to add those of groups
    outline.reflections.probes = baked.reflections.probes;
    return outline;
}

} // namespace halflight
