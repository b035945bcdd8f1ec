#include "halflight/bake/bake.h"

#include <nlohmann/json.hpp>

namespace halflight {

const char* nameOf(Quality quality)
{
    constexpr const char* kNames[] = {"preview", "medium", "high", "ultra"};
    return kNames[int(quality)];
}

const char* nameOf(InstructionSet set)
{
    constexpr const char* kNames[] = {"auto", "sse2", "avx2", "avx512"};
    return kNames[int(set)];
}

const char* nameOf(DensityFrom from)
{
    switch (from) {
    case DensityFrom::Asked:
        return "asked";
    case DensityFrom::Page:
        return "page";
    case DensityFrom::Scene:
        return "scene";
    }
    return "";
}

std::string reportJson(const BakeReport& report)
{
    using nlohmann::json;
    json lights = json::array();
    for (const LightReport& light : report.lights) {
        lights.push_back({{"name", light.name},
                          {"type", nameOf(light.type)},
                          {"mode", nameOf(light.authoredMode)},
                          {"bakedAs", nameOf(light.bakedAs)},
                          {"channel", light.channel},
                          {"reach", light.reachMeters},
                          {"maskEncoding", light.distanceMask ? "distance" : "attenuation"},
                          {"reason", light.reason}});
    }
    json stages = json::array();
    for (const StageReport& stage : report.stages) {
        stages.push_back({{"name", stage.name},
                          {"start", stage.start},
                          {"seconds", stage.seconds},
                          {"cpuSeconds", stage.cpuSeconds},
                          {"rays", stage.rays}});
    }
    json meshes = json::array();
    for (const MeshUnwrapReport& mesh : report.meshes) {
        meshes.push_back({{"mesh", mesh.mesh},
                          {"kept", mesh.kept},
                          {"reason", mesh.reason},
                          {"charts", mesh.charts},
                          {"areaStretch", mesh.areaStretch}});
    }
    json twoSided = json::array();
    for (const TwoSidedReport& object : report.twoSided)
        twoSided.push_back({{"object", object.object}, {"triangles", object.triangles}, {"texels", object.texels}});
    json written = json::array();
    for (const WrittenLightmap& page : report.written.lightmapPages)
        written.push_back({{"bytes", page.bytes}, {"meanError", page.meanError}, {"mostError", page.mostError}});
    json root = {
        {"integrator", report.integrator},
        {"identity", report.identity},
        {"seconds", report.seconds},
        {"peakMemoryBytes", report.peakMemoryBytes},
        {"samplesPerTexel", report.samplesPerTexel},
        {"noise", report.noiseReached},
        {"interpolatedTexels", report.interpolatedTexels},
        {"texelsAtSampleLimit", report.texelsAtCap},
        {"quality",
         {{"samples", report.quality.samples},
          {"noiseTarget", report.quality.noiseTarget},
          {"shadowSamples", report.quality.shadowSamples},
          {"bounces", report.quality.bounces},
          {"lightmapSize", report.quality.lightmapSize},
          {"probeSamples", report.quality.probeSamples}}},
        {"lightmap",
         {{"pages", report.pageCount},
          {"size", report.pageSize},
          {"charts", report.chartCount},
          {"cuts", report.cuts},
          {"coveredTexels", report.coveredTexels},
          {"invalidTexels", report.invalidTexels},
          {"texelsPerMeter", report.texelsPerMeter},
          {"densityFrom", nameOf(report.densityFrom)},
          {"coverage", report.atlasCoverage},
          {"format", nameOf(report.written.lightmapFormat)},
          {"written", std::move(written)}}},
        {"cache",
         {{"tiles", report.cache.tiles},
          {"same", report.cache.same},
          {"unchanged", report.cache.unchanged},
          {"kept", report.cache.kept}}},
        {"probes",
         {{"count", report.probeCount},
          {"valid", report.validProbeCount},
          {"check",
           {{"places", report.probeCheck.places},
            {"off", report.probeCheck.off},
            {"meanError", report.probeCheck.meanError},
            {"mostError", report.probeCheck.mostError}}}}},
        {"reflectionProbes", {{"count", report.reflectionProbeCount}, {"size", report.quality.reflectionSize}}},
        {"bytes",
         {{"file", report.written.file},
          {"lightmaps", report.written.lightmaps},
          {"lightmapDirections", report.written.lightmapDirections},
          {"shadowmasks", report.written.shadowmasks},
          {"sky", report.written.sky},
          {"reflectionProbes", report.written.reflections},
          {"probes", report.written.probes}}},
        {"triangles", report.triangleCount},
        {"lights", std::move(lights)},
        {"stages", std::move(stages)},
        {"meshes", std::move(meshes)},
        {"twoSided", std::move(twoSided)},
        {"warnings", report.warnings},
    };
    if (const auto& main = report.mainLight) {
        const vec3 color = main->shadowColor;
        root["mainLight"] = {{"name", main->name},
                             {"mask", main->mask},
                             {"shadowColor", {color.r, color.g, color.b}},
                             {"shadowColorFromBake", main->colorByBake}};
    }
    return root.dump(2, ' ', false, json::error_handler_t::replace);
}

} // namespace halflight
