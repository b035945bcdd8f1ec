// What `halflight bake` prints when it is done.

#include "bake_options.h"
#include "console.h"
#include "terminal.h"

#include "halflight/base/system.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

namespace halflight::cli {

namespace {

void printLights(const BakeReport& report)
{
    if (report.lights.empty()) return;
    std::size_t width = 5;
    for (const LightReport& light : report.lights) width = std::max(width, printable(light.name).size());
    print("\n{:<{}}  {:<11}  {:<8}  {:<8}  {:<7}  {}\n", "light", width, "type", "mode", "baked as", "channel",
          "reason");
    for (const LightReport& light : report.lights) {
        const std::string line = fmt::format("{:<{}}  {:<11}  {:<8}  {:<8}  {:<7}  {}", printable(light.name), width,
                                             nameOf(light.type), nameOf(light.authoredMode), nameOf(light.bakedAs),
                                             channelName(light.channel, light.coloredMask), printable(light.reason));
        print("{}\n", line.substr(0, line.find_last_not_of(' ') + 1));
    }
}

std::string_view densityReason(DensityFrom from)
{
    constexpr const char* kNames[] = {"as asked", "what fits one page",
                                      "by the scene's size (--texels-per-meter sets it)"};
    return kNames[int(from)];
}

void printBytes(const BakeReport& report)
{
    const WrittenBytes& bytes = report.written;
    const auto mb = [](double count) { return fmt::format("{:.2f} MB", count * 1e-6); };
    const double pages = std::max(report.pageCount, 1);
    print("file       {}: lightmap {} a page", mb(double(bytes.file)), mb(double(bytes.lightmaps) / pages));
    if (bytes.lightmapDirections > 0) print(", directions {} a page", mb(double(bytes.lightmapDirections) / pages));
    if (bytes.shadowmasks > 0) print(", mask {} a page", mb(double(bytes.shadowmasks) / pages));
    if (bytes.sky > 0) print(", sky {}", mb(double(bytes.sky)));
    if (bytes.reflections > 0) print(", reflections {}", mb(double(bytes.reflections)));
    print(", probes {}\n", mb(double(bytes.probes)));
    for (std::size_t i = 0; i < bytes.lightmapPages.size(); ++i) {
        const WrittenLightmap& page = bytes.lightmapPages[i];
        const std::string name = bytes.lightmapPages.size() > 1 ? fmt::format(" page {}", i) : std::string();
        print("           lightmap{} as {}: {}, error {:.3f} % on average, {:.2f} % at most\n", name,
              nameOf(bytes.lightmapFormat), mb(double(page.bytes)), 100.0 * page.meanError, 100.0 * page.mostError);
    }
}

void printProbes(const BakeReport& report)
{
    print("probes     {}", grouped(uint64_t(report.probeCount)));
    if (report.validProbeCount < report.probeCount)
        print(", {} of them inside geometry", grouped(uint64_t(report.probeCount - report.validProbeCount)));
    if (report.written.probes > 0) print(", {:.2f} MB", double(report.written.probes) * 1e-6);
    print("\n");
    if (const ProbeCheck& check = report.probeCheck; check.places > 0)
        print("           light between them is off by {:.0f} % on average, {:.0f} % at most, at {} places\n",
              100.0 * double(check.meanError), 100.0 * double(check.mostError), check.places);
}

} // namespace

std::vector<std::string> lightWarnings(const BakeReport& report)
{
    std::vector<std::string> warnings;
    for (const LightReport& light : report.lights) {
        if (light.bakedAs == light.authoredMode) continue;
        const auto namesLight = [&](const std::string& warning) {
            return warning.find("'" + light.name + "'") != std::string::npos ||
                   warning.find('"' + light.name + '"') != std::string::npos;
        };
        if (std::any_of(report.warnings.begin(), report.warnings.end(), namesLight)) continue;
        warnings.push_back(fmt::format("{} light '{}' was {} baked: {}", nameOf(light.authoredMode), light.name,
                                       light.bakedAs == LightMode::Baked ? "fully" : "not fully", light.reason));
    }
    return warnings;
}

void printBakeSummary(const BakeOptions& options, const BakeReport& report)
{
    const std::string onDevice =
        report.peakDeviceBytes > 0 ? fmt::format(" and {} of the GPU's", megabytes(report.peakDeviceBytes)) : "";
    print("{}: {} in {}, peak memory {}{}, {}\n", options.output.string(),
          options.exportStyle ? nameOf(*options.exportStyle) : nameOf(options.bake.mode), clockTime(report.seconds),
          megabytes(report.peakMemoryBytes), onDevice, report.integrator);
    printLights(report);

    print("\nlightmap   {} page{} of {} x {}, {:.0f} % filled\n", report.pageCount, report.pageCount == 1 ? "" : "s",
          report.pageSize, report.pageSize, 100.0 * double(report.atlasCoverage));
    print("           {:.4g} texels/m, {}\n", report.texelsPerMeter, densityReason(report.densityFrom));
    print("           {} charts, {} texels, {} of them inside geometry\n", grouped(uint64_t(report.chartCount)),
          grouped(report.coveredTexels), grouped(report.invalidTexels));
    if (report.cuts > 0) print("           {} cuts where surfaces cross\n", grouped(uint64_t(report.cuts)));
    if (report.cache.tiles > 0) {
        const std::size_t baked = report.cache.tiles - report.cache.same - report.cache.unchanged - report.cache.kept;
        print("cache      {} of {} tiles baked, {} taken as they were, {} not reached by what changed{}\n",
              grouped(baked), grouped(report.cache.tiles), grouped(report.cache.same), grouped(report.cache.unchanged),
              report.cache.kept > 0 ? ", " + grouped(report.cache.kept) + " of other objects kept" : "");
    }
    print("geometry   {} static triangles\n", grouped(report.triangleCount));
    print("identity   {}\n", report.identity);
    if (const auto& main = report.mainLight) {
        const vec3 color = main->shadowColor;
        print("subtracted {}, {} mask, down to {:.3g}, {:.3g}, {:.3g} lux{}\n", printable(main->name),
              main->mask ? "with its own" : "without a", color.r, color.g, color.b,
              main->colorByBake ? " (chosen by the bake)" : "");
    }
    printProbes(report);
    if (report.reflectionProbeCount > 0)
        print("           {} for reflections, of {} texels\n", report.reflectionProbeCount,
              report.quality.reflectionSize);
    if (report.written.file > 0) printBytes(report);
    print("samples    {:.0f} per texel, {} per masked light, at most {} bounces, {} per probe\n",
          report.samplesPerTexel, report.quality.shadowSamples, report.quality.bounces, report.quality.probeSamples);
    if (options.bake.seconds > 0.0) {
        // By the samples, auto may choose another device.
        const char* device = report.peakDeviceBytes > 0 ? ", with --device gpu" : ", with --device cpu";
        print("           --samples {} in place of --time gives the same bytes{}\n", report.quality.samples,
              options.device.device == "auto" ? device : "");
    }
    print("noise      {:.1f} % before denoising", 100.0 * double(report.noiseReached));
    if (report.quality.noiseTarget > 0.0f) {
        print(", target {:.1f} %; {} texels stopped at {} samples", 100.0 * double(report.quality.noiseTarget),
              grouped(report.texelsAtCap), report.quality.samples);
    }
    print("\n\n");

    // Browsers do not tell CPU seconds.
    const bool knowsCores = processCpuSeconds() > 0.0;
    print("{:<16} {:>9} {:>6} {:>10} {:>10}\n", "stage", "seconds", knowsCores ? "cores" : "", "rays", "rays/s");
    for (const StageReport& stage : report.stages) {
        const bool rate = stage.rays > 0 && stage.seconds > 0.0;
        const double cores = stage.cpuSeconds / std::max(stage.seconds, 1.0e-6);
        const std::string line = fmt::format("{:<16} {:>9.2f} {:>6} {:>10} {:>10}", stage.name, stage.seconds,
                                             knowsCores ? fmt::format("{:.1f}", cores) : "",
                                             stage.rays > 0 ? withUnit(double(stage.rays)) : "",
                                             rate ? withUnit(double(stage.rays) / stage.seconds) : "");
        print("{}\n", line.substr(0, line.find_last_not_of(' ') + 1));
    }
}

} // namespace halflight::cli
