#include "scene/format/limits.h"

#include "scene/document/bake_ranges.h"
#include "scene/model/gltf_error.h"

#include "halflight/base/finite.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace halflight {

namespace {

constexpr const char* kTooBright = " is brighter than 1e12, the limit that keeps a bake's sums within floats";

bool tooBright(vec3 light)
{
    return !(light.x <= kBrightest && light.y <= kBrightest && light.z <= kBrightest);
}

constexpr Range ofBake(const char* member)
{
    for (const Range& range : kBakeRanges) {
        if (range.path.ends_with(member)) return range;
    }
    for (const Range& range : kBakeValueRanges) {
        if (range.path.ends_with(member)) return range;
    }
    return {member, 0, 0}; // no number is right
}

constexpr Range kLightmapUnit = ofBake("HALFLIGHT_mixed_lighting/lightmapUnitLux");
constexpr Range kWeight = ofBake("groups/*/weight");
constexpr Range kShadowColor = ofBake("HALFLIGHT_mixed_lighting/subtractiveShadowColor");
constexpr Range kPosition = ofBake("probes/positions");
constexpr Range kRadiance = ofBake("probes/radiance");
constexpr Range kOcclusion = ofBake("probes/occlusion");
constexpr Range kSightRange = ofBake("probes/sightRanges");
constexpr Range kGridOrigin = ofBake("probes/grid/origin");
constexpr Range kGridSpacing = ofBake("probes/grid/spacing");
constexpr Range kReflectionUnit = ofBake("reflectionProbes/unitNits");
constexpr Range kFade = ofBake("probes/*/fade");
constexpr Range kBox = ofBake("probes/*/box");
constexpr Range kPlace = ofBake("HALFLIGHT_node/lightmap/scale");

/// The limits themselves are within, though the nearest floats lie beyond some of them.
bool within(float value, Range range)
{
    range.least = double(float(range.least));
    range.most = double(float(range.most));
    return isWithin(double(value), range);
}

template<glm::length_t N> bool within(const glm::vec<N, float>& values, const Range& range)
{
    for (glm::length_t i = 0; i < N; ++i) {
        if (!within(values[i], range)) return false;
    }
    return true;
}

// A grid says again where its probes are; what works with its numbers instead of theirs must find the same places.
bool isInGrid(const ProbeSet& set, std::size_t i)
{
    const auto x = std::size_t(set.size.x);
    const auto y = std::size_t(set.size.y);
    const dvec3 place = dvec3(set.origin) + dvec3(set.spacingMeters) * dvec3(i % x, i / x % y, i / x / y);
    const dvec3 off = glm::abs(place - dvec3(set.probes[i].position));
    constexpr double kShare = 0.01; // of the spacing
    constexpr double kRounding = 4.0 * double(std::numeric_limits<float>::epsilon());
    const dvec3 most = kShare * dvec3(set.spacingMeters) + kRounding * (glm::abs(place) + glm::abs(dvec3(set.origin)));
    return off.x <= most.x && off.y <= most.y && off.z <= most.z;
}

Status checkProbes(const ProbeSet& set, const std::string& path)
{
    for (std::size_t i = 0; i < set.probes.size(); ++i) {
        const Probe& probe = set.probes[i];
        const std::string name = "probe " + std::to_string(i);
        if (!within(probe.position, kPosition))
            return invalid(path, name + " has a position that is not three numbers " + textOf(kPosition));
        if (!std::all_of(probe.radiance.begin(), probe.radiance.end(),
                         [](const vec3& c) { return within(c, kRadiance); }))
            return invalid(path, name + " has radiance that is not " + textOf(kRadiance) + " cd/m2");
        if (!std::all_of(probe.occlusion.layers.begin(), probe.occlusion.layers.end(),
                         [](const vec4& layer) { return within(layer, kOcclusion); }))
            return invalid(path, name + " has occlusion that is not " + textOf(kOcclusion));
    }
    for (const float range : set.sight.rangeMeters) {
        if (!within(range, kSightRange)) return invalid(path, "a sightRange is not a number " + textOf(kSightRange));
    }
    if (set.size == ivec3(0)) return {};
    if (!within(set.origin, kGridOrigin))
        return invalid(path + "/grid/origin", "is not three numbers " + textOf(kGridOrigin));
    if (!within(set.spacingMeters, kGridSpacing))
        return invalid(path + "/grid/spacing", "is not three numbers " + textOf(kGridSpacing));
    for (std::size_t i = 0; i < set.probes.size(); ++i) {
        if (!isInGrid(set, i))
            return invalid(path + "/grid", "probe " + std::to_string(i) + " is not at its place in it");
    }
    return {};
}

Status checkGroups(const std::vector<BakedGroup>& groups, const std::string& path)
{
    for (std::size_t g = 0; g < groups.size(); ++g) {
        const std::string place = path + "/" + std::to_string(g);
        if (!within(groups[g].weight, kWeight)) return invalid(place, "weight is not three numbers " + textOf(kWeight));
        if (!within(groups[g].unitLux, kLightmapUnit))
            return invalid(place, "lightmapUnitLux is not a number " + textOf(kLightmapUnit));
        if (!within(groups[g].shadowColor, kShadowColor))
            return invalid(place, "shadowColor is not three numbers " + textOf(kShadowColor));
        if (!within(groups[g].reflections.unitNits, kReflectionUnit))
            return invalid(place + "/reflections/unitNits", "is not a number " + textOf(kReflectionUnit));
        for (const SphericalHarmonicsL2& probe : groups[g].radiance)
            if (!std::all_of(probe.begin(), probe.end(), [](const vec3& c) { return within(c, kRadiance); }))
                return invalid(place, "has radiance that is not " + textOf(kRadiance) + " cd/m2");
    }
    return {};
}

Status checkReflections(const ReflectionSet& set, const std::string& path)
{
    if (set.probes.empty()) return {};
    if (!within(set.unitNits, kReflectionUnit))
        return invalid(path + "/unitNits", "is not a number " + textOf(kReflectionUnit));
    for (std::size_t i = 0; i < set.probes.size(); ++i) {
        const ReflectionProbe& probe = set.probes[i];
        const std::string place = path + "/probes/" + std::to_string(i);
        if (!within(probe.fadeMeters, kFade)) return invalid(place + "/fade", "is not a number " + textOf(kFade));
        if (!within(probe.position, kBox)) return invalid(place + "/position", "is not three numbers " + textOf(kBox));
        for (int column = 0; column < 4; ++column) {
            if (!within(probe.worldFromBox[column], kBox))
                return invalid(place + "/box", "is not 16 numbers " + textOf(kBox));
        }
    }
    return {};
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

Status checkBakedValues(const BakedScene& baked)
{
    const std::string root = "/extensions/HALFLIGHT_mixed_lighting";
    if (Status s = checkProbes(baked.probes, root + "/probes"); !s) return s;
    if (!within(baked.lightmapUnitLux, kLightmapUnit))
        return invalid(root + "/lightmapUnitLux", "is not a number " + textOf(kLightmapUnit));
    for (const MaskChannel& channel : baked.maskChannels) {
        if (!std::isfinite(channel.rangeTexels) || !std::isfinite(channel.penumbraTexels))
            return invalid(root + "/shadowmaskChannels", "is not finite");
    }
    if (!within(baked.defaultShadowColor, kShadowColor))
        return invalid(root + "/subtractiveShadowColor", "is not a colour " + textOf(kShadowColor));
    if (Status s = checkGroups(baked.groups, root + "/groups"); !s) return s;
    if (Status s = checkReflections(baked.reflections, root + "/reflectionProbes"); !s) return s;
    for (const Object& object : baked.scene.objects) {
        const std::string path = pathOf("nodes", std::size_t(std::max(0, object.sourceNode)));
        if (!within(object.lightmap.scale, kPlace) || !within(object.lightmap.offset, kPlace))
            return invalid(path + "/extensions/HALFLIGHT_node/lightmap",
                           "scale or offset is not a number " + textOf(kPlace));
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
