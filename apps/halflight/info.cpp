// halflight info: what a glTF file, plain or baked, holds.

#include "console.h"
#include "json_values.h"
#include "terminal.h"

#include "halflight/scene/gltf.h"
#include "halflight/scene/group_bytes.h"
#include "halflight/scene/turning_lights.h"

#include <spdlog/fmt/fmt.h>

#include <memory>

namespace halflight::cli {

namespace {

struct InfoOptions {
    std::filesystem::path file;
    std::filesystem::path settingsFile;
    bool json = false;
};

struct Counts {
    uint64_t storedTriangles = 0;
    uint64_t drawnTriangles = 0;
    uint64_t staticObjects = 0;
    uint64_t lightmappedObjects = 0;
    uint64_t parts = 0;
    uint64_t validProbes = 0;
    uint64_t texturePixels = 0;
};

Counts countScene(const BakedScene& baked)
{
    Counts counts;
    std::vector<uint64_t> trianglesOfMesh;
    for (const Mesh& mesh : baked.scene.meshes) {
        counts.storedTriangles += trianglesOfMesh.emplace_back(mesh.triangleCount());
        counts.parts += mesh.parts.size();
    }
    for (const Object& object : baked.scene.objects) {
        if (object.mesh >= 0) counts.drawnTriangles += trianglesOfMesh[std::size_t(object.mesh)];
        counts.staticObjects += object.isStatic;
        counts.lightmappedObjects += object.lightmap.page >= 0;
    }
    for (const Texture& texture : baked.scene.textures) counts.texturePixels += texture.pixels.texelCount();
    for (const Probe& probe : baked.probes.probes) counts.validProbes += probe.valid;
    return counts;
}

std::size_t countAlphaMode(const Scene& scene, Material::AlphaMode mode)
{
    std::size_t count = 0;
    for (const Material& material : scene.materials)
        count += mode == (material.isBlended() ? Material::AlphaMode::Blend : material.alphaMode);
    return count;
}

/// Of Light::intensity. `candela`: the word for it.
const char* unitOf(LightType type, const char* candela)
{
    return type == LightType::Directional ? "lux" : isAreaLight(type) ? "cd/m2" : candela;
}

Json jsonOf(const Light& light)
{
    Json json = {{"name", light.name},
                 {"type", nameOf(light.type)},
                 {"mode", nameOf(light.mode)},
                 {"intensity", light.intensity},
                 {"unit", unitOf(light.type, "candela")},
                 {"color", jsonArray(light.color)},
                 {"castShadows", light.castShadows},
                 {"shadowStrength", light.shadowStrength},
                 {"indirectMultiplier", light.indirectMultiplier}};
    if (isAreaLight(light.type))
        json["size"] = Json::array({2.0f * glm::length(light.halfWidth()), 2.0f * glm::length(light.halfHeight())});
    if (light.baking.isBaked) {
        json["bakedAs"] = nameOf(light.baking.bakeType);
        json["channel"] = light.baking.occlusionMaskChannel;
        if (light.baking.coloredMask) json["coloredMask"] = true;
        if (!light.baking.reason.empty()) json["reason"] = light.baking.reason;
    }
    return json;
}

/// Light groups with their members.
Json groupsJson(const BakedScene& baked)
{
    Json groups = Json::array();
    const std::vector<uint64_t> bytes = bytesOfGroups(baked.scene);
    for (std::size_t g = 0; g < baked.groups.size(); ++g) {
        const BakedGroup& group = baked.groups[g];
        Json lights = Json::array();
        Json materials = Json::array();
        Json direction;
        for (const Light& light : baked.scene.lights) {
            const TurningLight& turning = light.baking.turning;
            const auto own = std::ptrdiff_t(g) - turning.group;
            const bool isDirection = turns(light) && own >= 0 && own < std::ssize(turning.directions);
            if (light.baking.group == int(g) || isDirection) lights.push_back(light.name);
            if (isDirection) direction = jsonArray(turning.directions[std::size_t(own)]);
        }
        for (const Material& material : baked.scene.materials)
            if (material.bakedGroup == int(g)) materials.push_back(material.name);
        const auto lit = std::ranges::count_if(group.lightmaps, [](const auto& page) { return !page.empty(); });
        groups.push_back({{"name", group.name},
                          {"weight", jsonArray(group.weight)},
                          {"peakLux", group.peakLux},
                          {"pages", lit},
                          {"bytes", bytes.at(g)},
                          {"lights", lights},
                          {"materials", materials},
                          {"sky", group.sky}});
        if (!direction.is_null()) groups.back()["direction"] = direction;
    }
    return groups;
}

void printGroups(const BakedScene& baked)
{
    if (baked.groups.empty()) return;
    std::size_t width = 11;
    for (const BakedGroup& group : baked.groups) width = std::max(width, printable(group.name).size());
    print("\n{:<{}}  {:<18}  {:<9}  {:>8}  {}\n", "light group", width, "weight", "peak", "bytes", "members");
    const Json groups = groupsJson(baked);
    for (std::size_t g = 0; g < groups.size(); ++g) {
        const BakedGroup& group = baked.groups[g];
        std::string members;
        for (const char* kind : {"lights", "materials"})
            for (const Json& name : groups[g][kind])
                members += (members.empty() ? "" : ", ") + printable(name.get<std::string>());
        if (group.sky) members += members.empty() ? "the sky" : ", the sky";
        if (const Json& d = groups[g].value("direction", Json()); !d.is_null())
            members +=
                fmt::format(" along {:.3g}, {:.3g}, {:.3g}", d[0].get<float>(), d[1].get<float>(), d[2].get<float>());
        const std::string weight =
            fmt::format("{:.3g}, {:.3g}, {:.3g}", group.weight.x, group.weight.y, group.weight.z);
        print("{:<{}}  {:<18}  {:<9}  {:>8}  {}\n", printable(group.name), width, weight,
              fmt::format("{:.3g} lx", group.peakLux), withUnit(double(groups[g]["bytes"].get<uint64_t>())), members);
    }
}

Json infoJson(const InfoOptions& options, const BakedScene& baked)
{
    const Scene& scene = baked.scene;
    const Counts counts = countScene(baked);
    Json json;
    json["file"] = options.file.string();
    json["baked"] = baked.isBaked;
    if (baked.isBaked) json["mode"] = nameOf(baked.mode);
    json["meshes"] = scene.meshes.size();
    json["primitives"] = counts.parts;
    json["triangles"] = {{"stored", counts.storedTriangles}, {"drawn", counts.drawnTriangles}};
    json["objects"] = {{"total", scene.objects.size()},
                       {"static", counts.staticObjects},
                       {"dynamic", scene.objects.size() - counts.staticObjects},
                       {"lightmapped", counts.lightmappedObjects}};
    json["materials"] = {{"total", scene.materials.size()},
                         {"opaque", countAlphaMode(scene, Material::AlphaMode::Opaque)},
                         {"mask", countAlphaMode(scene, Material::AlphaMode::Mask)},
                         {"blend", countAlphaMode(scene, Material::AlphaMode::Blend)}};
    json["textures"] = {{"total", scene.textures.size()}, {"pixels", counts.texturePixels}};
    json["lights"] = Json::array();
    for (const Light& light : scene.lights) json["lights"].push_back(jsonOf(light));
    json["cameras"] = Json::array();
    for (const Camera& camera : scene.cameras) json["cameras"].push_back(camera.name);
    json["sky"] = {{"zenith", jsonArray(scene.sky.zenith)},
                   {"horizon", jsonArray(scene.sky.horizon)},
                   {"ground", jsonArray(scene.sky.ground)}};
    if (const auto& picture = scene.sky.picture)
        json["sky"]["picture"] = {{"size", Json::array({picture->width(), picture->height()})},
                                  {"rotation", scene.sky.rotationRadians}};
    json["origin"] = jsonArray(scene.originMeters);
    const Bounds bounds = scene.bounds();
    if (bounds.empty()) {
        json["bounds"] = nullptr;
    } else {
        json["bounds"] = {{"min", jsonArray(scene.originMeters + dvec3(bounds.min))},
                          {"max", jsonArray(scene.originMeters + dvec3(bounds.max))}};
    }
    json["lightmap"] = {{"pages", baked.lightmaps.size()},
                        {"size", baked.lightmaps.empty() ? 0 : baked.lightmaps.front().width()},
                        {"directional", !baked.lightmapDirections.empty()}};
    json["shadowmask"] = {{"pages", baked.shadowmasks.size() / std::size_t(baked.maskLayers)},
                          {"layers", baked.maskLayers},
                          {"size", maskPageSize(baked).x}};
    if (baked.mode == MixedLightingMode::Subtractive) {
        json["subtractive"] = {{"mask", !baked.shadowmasks.empty()},
                               {"shadowColor", jsonArray(subtractiveShadowColor(baked))},
                               {"shadowColorFromBake", !scene.subtractiveShadowColor.has_value()}};
    }
    json["probes"] = {{"total", baked.probes.probes.size()},
                      {"valid", counts.validProbes},
                      {"grid", Json::array({baked.probes.size.x, baked.probes.size.y, baked.probes.size.z})},
                      {"spacingMeters", jsonArray(baked.probes.spacingMeters)}};
    if (!baked.groups.empty()) json["groups"] = groupsJson(baked);
    json["lost"] = baked.lost;
    json["warnings"] = scene.warnings;
    return json;
}

void printLights(const std::vector<Light>& lights)
{
    std::size_t width = 5;
    for (const Light& light : lights) width = std::max(width, printable(light.name).size());
    print("\n{:<{}}  {:<11}  {:<8}  {:<8}  {:<7}  {}\n", "light", width, "type", "mode", "baked as", "channel",
          "intensity");
    for (const Light& light : lights) {
        const BakingOutput& baking = light.baking;
        print("{:<{}}  {:<11}  {:<8}  {:<8}  {:<7}  {:g} {}{}\n", printable(light.name), width, nameOf(light.type),
              nameOf(light.mode), baking.isBaked ? nameOf(baking.bakeType) : "-",
              channelName(baking.occlusionMaskChannel, baking.coloredMask), light.intensity, unitOf(light.type, "cd"),
              baking.reason.empty() ? "" : "  (" + printable(baking.reason) + ")");
    }
}

void printInfo(const InfoOptions& options, const BakedScene& baked)
{
    const Scene& scene = baked.scene;
    const Counts counts = countScene(baked);
    if (baked.isBaked) {
        print("{}: baked, {}\n\n", options.file.string(), nameOf(baked.mode));
    } else {
        print("{}: not baked\n\n", options.file.string());
    }
    print("objects     {} ({} static, {} dynamic)\n", grouped(scene.objects.size()), grouped(counts.staticObjects),
          grouped(scene.objects.size() - counts.staticObjects));
    print("meshes      {} with {} primitives\n", grouped(scene.meshes.size()), grouped(counts.parts));
    print("triangles   {} stored, {} drawn\n", grouped(counts.storedTriangles), grouped(counts.drawnTriangles));
    print("materials   {} ({} opaque, {} mask, {} blend)\n", scene.materials.size(),
          countAlphaMode(scene, Material::AlphaMode::Opaque), countAlphaMode(scene, Material::AlphaMode::Mask),
          countAlphaMode(scene, Material::AlphaMode::Blend));
    print("textures    {} with {} pixels\n", scene.textures.size(), withUnit(double(counts.texturePixels)));
    const Bounds bounds = scene.bounds();
    const vec3 size = bounds.size();
    if (bounds.empty()) {
        print("bounds      empty\n");
    } else {
        const dvec3 corner = scene.originMeters + dvec3(bounds.min);
        const int digits = scene.originMeters == dvec3(0.0) ? 4 : 9;
        print("bounds      {:.4g} x {:.4g} x {:.4g} m, from ({:.{}g}, {:.{}g}, {:.{}g})\n", size.x, size.y, size.z,
              corner.x, digits, corner.y, digits, corner.z, digits);
    }
    if (scene.originMeters != dvec3(0.0)) {
        print("origin      ({}, {}, {}): far from the world's, so that positions are relative to it\n",
              scene.originMeters.x, scene.originMeters.y, scene.originMeters.z);
    }
    if (const auto& picture = scene.sky.picture) {
        print("sky         picture of {} x {}, turned by {:.3g} degrees\n", picture->width(), picture->height(),
              glm::degrees(scene.sky.rotationRadians));
    }
    std::string cameras;
    for (const Camera& camera : scene.cameras) cameras += (cameras.empty() ? "" : ", ") + printable(camera.name);
    print("cameras     {}{}{}\n", scene.cameras.size(), cameras.empty() ? "" : ": ", cameras);
    if (baked.isBaked) {
        const int lightmapSize = baked.lightmaps.empty() ? 0 : baked.lightmaps.front().width();
        const int maskSize = maskPageSize(baked).x;
        print("lightmap    {} of {} x {}{}, for {} objects\n", baked.lightmaps.size(), lightmapSize, lightmapSize,
              baked.lightmapDirections.empty() ? "" : ", directional", grouped(counts.lightmappedObjects));
        print("shadowmask  {} of {} x {}{}\n", baked.shadowmasks.size() / std::size_t(baked.maskLayers), maskSize,
              maskSize, baked.maskLayers > 1 ? fmt::format(", {} layers", baked.maskLayers) : "");
        if (baked.mode == MixedLightingMode::Subtractive) {
            const vec3 color = subtractiveShadowColor(baked);
            print("subtracted  {} main light's mask, down to {:.3g}, {:.3g}, {:.3g} lux{}\n",
                  baked.shadowmasks.empty() ? "without the" : "with the", color.r, color.g, color.b,
                  scene.subtractiveShadowColor ? "" : " (chosen by the bake)");
        }
        const ivec3 grid = baked.probes.size;
        print("probes      {} ({} valid)", grouped(baked.probes.probes.size()), grouped(counts.validProbes));
        if (grid.x > 0) print(", grid {} x {} x {}", grid.x, grid.y, grid.z);
        print("\n");
    }
    if (!scene.lights.empty()) printLights(scene.lights);
    printGroups(baked);
}

int runInfo(const InfoOptions& options)
{
    // Textures are decoded too: `info` is how one finds out whether a file is sound.
    ReadOptions readOptions;
    readOptions.settingsFile = options.settingsFile;
    Result<BakedScene> baked = readBakedScene(options.file, readOptions);
    if (!baked) return fail(options.file, baked.error());
    if (options.json) {
        // Names come from the file and may hold any bytes: what is not UTF-8 becomes U+FFFD instead of an exception.
        printJson(infoJson(options, *baked).dump(2, ' ', false, Json::error_handler_t::replace));
        return kOk;
    }
    printInfo(options, *baked);
    for (const std::string& warning : baked->scene.warnings) warn(options.file, warning);
    return kOk;
}

} // namespace

Command addInfoCommand(CLI::App& parent)
{
    auto options = std::make_shared<InfoOptions>();
    CLI::App& app = *parent.add_subcommand("info", "Tell what a glTF file, plain or baked, holds");
    app.add_option("FILE", options->file, "the file, .glb or .gltf")->required()->type_name(" ");
    app.add_option("--settings", options->settingsFile, "light and object settings by name pattern")
        ->type_name("FILE.toml");
    app.add_flag("--json", options->json, "print JSON");
    return {&app, [options] { return runInfo(*options); }};
}

} // namespace halflight::cli
