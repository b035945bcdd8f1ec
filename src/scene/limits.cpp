#include "scene/limits.h"

#include "scene/document.h"

#include "halflight/base/finite.h"

#include <algorithm>
#include <cmath>

namespace halflight {

namespace {

constexpr const char* kTooBright = " is brighter than 1e12, the limit that keeps a bake's sums within floats";

bool tooBright(vec3 light)
{
    return !(light.x <= kBrightest && light.y <= kBrightest && light.z <= kBrightest);
}

} // namespace

Status checkBrightness(const Scene& scene)
{
    for (const Material& material : scene.materials) {
        if (tooBright(material.emissiveNits))
            return invalid(pathOf("materials", std::size_t(std::max(0, material.sourceMaterial))),
                           std::string("its emission") + kTooBright);
    }
    for (const Light& light : scene.lights) {
        const std::string path = light.sourceNode >= 0 ? pathOf("nodes", std::size_t(light.sourceNode)) : "add_light";
        if (tooBright(light.color * light.intensity * std::max(1.0f, light.indirectMultiplier)))
            return invalid(path, "light \"" + light.name + "\"" + kTooBright);
    }
    const Sky& sky = scene.sky;
    const bool pictureTooBright =
        sky.picture && std::any_of(sky.picture->texels().begin(), sky.picture->texels().end(), tooBright);
    if (pictureTooBright || tooBright(sky.zenith) || tooBright(sky.horizon) || tooBright(sky.ground))
        return invalid("/scenes/0", std::string("its sky") + kTooBright);
    if (tooBright(scene.subtractiveShadowColor.value_or(vec3(0.0f))))
        return invalid("/scenes/0", std::string("its subtractive shadow colour") + kTooBright);
    return {};
}

Status checkFinite(const BakedScene& baked)
{
    for (std::size_t i = 0; i < baked.probes.probes.size(); ++i) {
        const Probe& probe = baked.probes.probes[i];
        const bool good =
            isFinite(probe.position) && isFinite(probe.occlusion) &&
            std::all_of(probe.radiance.begin(), probe.radiance.end(), [](const vec3& c) { return isFinite(c); });
        if (!good)
            return invalid("/extensions/HALFLIGHT_mixed_lighting/probes",
                           "probe " + std::to_string(i) + " is not finite");
    }
    if (!isFinite(baked.probes.origin) || !isFinite(baked.probes.spacingMeters))
        return invalid("/extensions/HALFLIGHT_mixed_lighting/probes/grid", "is not finite");
    if (!std::isfinite(baked.lightmapUnitLux) || !(baked.lightmapUnitLux > 0.0f))
        return invalid("/extensions/HALFLIGHT_mixed_lighting/lightmapUnitLux", "is not a number above 0");
    for (const MaskChannel& channel : baked.maskChannels) {
        if (!std::isfinite(channel.rangeTexels) || !std::isfinite(channel.penumbraTexels))
            return invalid("/extensions/HALFLIGHT_mixed_lighting/shadowmaskChannels", "is not finite");
    }
    for (const Object& object : baked.scene.objects) {
        const std::string path = pathOf("nodes", std::size_t(std::max(0, object.sourceNode)));
        if (!isFinite(object.lightmap.scale) || !isFinite(object.lightmap.offset))
            return invalid(path + "/extensions/HALFLIGHT_node/lightmap", "scale or offset is not finite");
    }
    for (std::size_t m = 0; m < baked.scene.meshes.size(); ++m) {
        const Mesh& mesh = baked.scene.meshes[m];
        for (const MeshPart& part : mesh.parts) {
            if (!std::all_of(part.lightmapUv.begin(), part.lightmapUv.end(), [](vec2 uv) { return isFinite(uv); }))
                return invalid(pathOf("meshes", std::size_t(std::max(0, mesh.sourceMesh))),
                               "a lightmap coordinate of \"" + mesh.name + "\" is not finite");
        }
    }
    return {};
}

} // namespace halflight
