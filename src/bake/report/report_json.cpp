#include "halflight/bake/bake.h"

#include <nlohmann/json.hpp>

#include <vector>

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

namespace {

using nlohmann::json;

json jsonOf(const LightReport& light)
{
    json result = {{"name", light.name},
                   {"type", nameOf(light.type)},
                   {"mode", nameOf(light.authoredMode)},
                   {"bakedAs", nameOf(light.bakedAs)},
                   {"channel", light.channel},
                   {"reach", light.reachMeters},
                   {"maskEncoding", light.distanceMask ? "distance" : "attenuation"},
                   {"reason", light.reason}};
    if (light.coloredMask) result["coloredMask"] = true;
    return result;
}

json jsonOf(const StageReport& stage)
{
    return {{"name", stage.name},
            {"start", stage.start},
            {"seconds", stage.seconds},
            {"cpuSeconds", stage.cpuSeconds},
            {"rays", stage.rays}};
}

json jsonOf(const MeshUnwrapReport& mesh)
{
    return {{"mesh", mesh.mesh},
            {"kept", mesh.kept},
            {"reason", mesh.reason},
            {"charts", mesh.charts},
            {"areaStretch", mesh.areaStretch}};
}

json jsonOf(const TwoSidedReport& object)
{
    return {{"object", object.object}, {"triangles", object.triangles}, {"texels", object.texels}};
}

json jsonOf(const WrittenLightmap& page)
{
    return {{"bytes", page.bytes}, {"meanError", page.meanError}, {"mostError", page.mostError}};
}

template<typename Record> json listOf(const std::vector<Record>& records)
{
    json list = json::array();
    for (const Record& record : records) list.push_back(jsonOf(record));
    return list;
}

json jsonOf(const MainLightReport& main)
{
    const vec3 color = main.shadowColor;
    return {{"name", main.name},
            {"mask", main.mask},
            {"shadowColor", {color.r, color.g, color.b}},
            {"shadowColorFromBake", main.colorByBake}};
}

json lightmapOf(const BakeReport& report)
{
    return {{"pages", report.pageCount},
            {"size", report.pageSize},
            {"charts", report.chartCount},
            {"cuts", report.cuts},
            {"coveredTexels", report.coveredTexels},
            {"invalidTexels", report.invalidTexels},
            {"texelsPerMeter", report.texelsPerMeter},
            {"densityFrom", nameOf(report.densityFrom)},
            {"coverage", report.atlasCoverage},
            {"format", nameOf(report.written.lightmapFormat)},
            {"written", listOf(report.written.lightmapPages)}};
}

json probesOf(const BakeReport& report)
{
    return {{"count", report.probeCount},
            {"valid", report.validProbeCount},
            {"check",
             {{"places", report.probeCheck.places},
              {"off", report.probeCheck.off},
              {"meanError", report.probeCheck.meanError},
              {"mostError", report.probeCheck.mostError}}}};
}

} // namespace

std::string reportJson(const BakeReport& report)
{
    json root = {
        {"integrator", report.integrator},
        {"identity", report.identity},
        {"seconds", report.seconds},
        {"peakMemoryBytes", report.peakMemoryBytes},
        {"peakDeviceBytes", report.peakDeviceBytes},
        {"samplesPerTexel", report.samplesPerTexel},
        {"noise", report.noiseReached},
        {"texelsAtSampleLimit", report.texelsAtCap},
        {"quality",
         {{"samples", report.quality.samples},
          {"noiseTarget", report.quality.noiseTarget},
          {"shadowSamples", report.quality.shadowSamples},
          {"bounces", report.quality.bounces},
          {"lightmapSize", report.quality.lightmapSize},
          {"probeSamples", report.quality.probeSamples}}},
        {"lightmap", lightmapOf(report)},
        {"cache",
         {{"tiles", report.cache.tiles},
          {"same", report.cache.same},
          {"unchanged", report.cache.unchanged},
          {"kept", report.cache.kept}}},
        {"probes", probesOf(report)},
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
        {"lights", listOf(report.lights)},
        {"stages", listOf(report.stages)},
        {"meshes", listOf(report.meshes)},
        {"twoSided", listOf(report.twoSided)},
        {"warnings", report.warnings},
    };
    if (report.mainLight) root["mainLight"] = jsonOf(*report.mainLight);
    return root.dump(2, ' ', false, json::error_handler_t::replace);
}

} // namespace halflight
