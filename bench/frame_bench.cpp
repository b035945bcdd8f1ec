// Times the passes of frames by GPU timestamps: medians by mode and path, and what the modes must hold against one
// another, all measured in this run. Frames of all modes take turns, so that a machine that slows down slows all.
//
//   bench_frame [--size WxH] [--frames N] [--cpu] [--only modes|lights|layers|features] [FILE.glb…]
//
// Files are plain glTF; they get a stand-in bake (frame_scenes.h). Besides them: a scene of 1,000 objects made here,
// and fields of lights. With `--only features` files are baked ones, and what antialiasing, reflection probes and
// penumbrae cost is measured. Exit code 1 when a demand is not met.

#include "frame_scenes.h"

#include "halflight/render/renderer.h"
#include "halflight/scene/gltf.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <string>
#include <vector>

using namespace halflight;

namespace {

struct Options {
    ivec2 size{1280, 720};
    int frames = 15;
    bool preferCpu = false;
    std::string only;
    std::vector<std::string> files;
};

constexpr int kWarmUpFrames = 2;

struct ModeRow {
    const char* name;
    RunMode mode;
};
constexpr ModeRow kModes[] = {{"realtime", RunMode::Realtime},
                              {"baked indirect", RunMode::BakedIndirect},
                              {"shadowmask", RunMode::Shadowmask},
                              {"distance shadowmask", RunMode::DistanceShadowmask},
                              {"subtractive", RunMode::Subtractive}};

/// Frames of one mode and path: milliseconds of each pass, frame by frame, and what the last frame drew.
struct Series {
    std::map<std::string, std::vector<double>> milliseconds;
    std::vector<double> totals; ///< all passes but the copy to the host
    std::vector<PassReport> passes;
    int lights = 0;

    void add(const RenderedFrame& frame)
    {
        double total = 0.0;
        for (const PassReport& pass : frame.passes) {
            milliseconds[pass.name].push_back(pass.milliseconds);
            if (pass.name != "readback") total += pass.milliseconds;
        }
        totals.push_back(total);
        passes = frame.passes;
        lights = int(frame.plan.lights.size());
    }
};

double median(std::vector<double> values)
{
    if (values.empty()) return 0.0;
    std::sort(values.begin(), values.end());
    return 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
}

double timeOf(const Series& series, const std::string& pass)
{
    const auto it = series.milliseconds.find(pass);
    return it == series.milliseconds.end() ? 0.0 : median(it->second);
}

double shadowTime(const Series& series)
{
    return timeOf(series, "directional shadows") + timeOf(series, "spot shadows") + timeOf(series, "point shadows");
}

PassReport shadowDraws(const Series& series)
{
    PassReport sum;
    for (const PassReport& pass : series.passes) {
        if (pass.name.find("shadows") == std::string::npos) continue;
        sum.draws += pass.draws;
        sum.triangles += pass.triangles;
    }
    return sum;
}

std::unique_ptr<Renderer> makeRenderer(const Options& options, const BakedScene& baked)
{
    auto renderer = Renderer::create({.preferCpu = options.preferCpu});
    if (!renderer) {
        std::fprintf(stderr, "%s\n", renderer.error().text().c_str());
        std::exit(2);
    }
    if (Status status = (*renderer)->load(baked); !status) {
        std::fprintf(stderr, "%s\n", status.error().text().c_str());
        std::exit(2);
    }
    return std::move(*renderer);
}

void renderInto(Renderer& renderer, const Camera& camera, const RenderSettings& settings, Series* series)
{
    const Result<RenderedFrame> frame = renderer.render(camera, settings);
    if (!frame || !frame->timed) {
        std::fprintf(stderr, "%s\n", frame ? "the device has no timestamps" : frame.error().text().c_str());
        std::exit(2);
    }
    if (series) series->add(*frame);
}

/// What is measured against other rows; path, size and timings are set by measured().
struct Row {
    Renderer* renderer = nullptr;
    Camera camera;
    RenderSettings settings;
};
constexpr RenderPath kPaths[] = {RenderPath::Forward, RenderPath::Deferred};

/// By path as in kPaths, then by row. Frames of all rows take turns.
std::array<std::vector<Series>, 2> measured(const Options& options, const std::vector<Row>& rows)
{
    std::array<std::vector<Series>, 2> all;
    all.fill(std::vector<Series>(rows.size()));
    for (int frame = -kWarmUpFrames; frame < options.frames; ++frame) {
        for (std::size_t path = 0; path < all.size(); ++path) {
            for (std::size_t i = 0; i < rows.size(); ++i) {
                RenderSettings settings = rows[i].settings;
                settings.path = kPaths[path];
                settings.size = options.size;
                settings.timings = true;
                renderInto(*rows[i].renderer, rows[i].camera, settings, frame < 0 ? nullptr : &all[path][i]);
            }
        }
    }
    return all;
}

bool demand(bool met, const char* text)
{
    std::printf("  %s  %s\n", met ? "met     " : "NOT MET ", text);
    return met;
}

/// The modes on one scene. That shadowmask draws its shadow maps in a third of the time is asked where few objects are
/// dynamic: with fewer casters left out there is less to gain.
bool benchModes(const Options& options, const std::string& name, const Scene& plain)
{
    const auto dynamic = std::count_if(plain.objects.begin(), plain.objects.end(),
                                       [](const Object& object) { return !object.isStatic; });
    const bool fewDynamic = double(dynamic) < 0.02 * double(plain.objects.size());
    const Camera camera = bench::cameraOf(plain);
    const auto masked = makeRenderer(options, bench::withStandInBake(plain, MixedLightingMode::Shadowmask));
    const auto subtractive = makeRenderer(options, bench::withStandInBake(plain, MixedLightingMode::Subtractive));
    std::vector<Row> rows;
    for (const ModeRow& row : kModes)
        rows.push_back(
            {row.mode == RunMode::Subtractive ? subtractive.get() : masked.get(), camera, {.mode = row.mode}});
    const auto all = measured(options, rows);

    std::printf("\n%s, %d x %d, %zu objects, medians of %d frames, milliseconds\n\n", name.c_str(), options.size.x,
                options.size.y, plain.objects.size(), options.frames);
    std::printf(
        "| path | mode | directional | spot | point | depth | G-buffer | light | forward | sky | blended | all | "
        "shadow draws | shadow triangles |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
    for (std::size_t path = 0; path < 2; ++path) {
        for (std::size_t i = 0; i < std::size(kModes); ++i) {
            const Series& s = all[path][i];
            std::printf("| %s | %s |", path == 0 ? "forward" : "deferred", kModes[i].name);
            for (const char* pass : {"directional shadows", "spot shadows", "point shadows", "depth", "g-buffer",
                                     "deferred light", "forward", "sky", "blended"})
                std::printf(s.milliseconds.count(pass) ? " %.3f |" : " – |", timeOf(s, pass));
            const PassReport shadows = shadowDraws(s);
            std::printf(" %.3f | %d | %lld |\n", median(s.totals), shadows.draws, (long long)(shadows.triangles));
        }
    }

    std::printf("\n");
    bool met = true;
    for (std::size_t path = 0; path < 2; ++path) {
        const auto series = [&](RunMode mode) -> const Series& {
            const auto row = std::find_if(std::begin(kModes), std::end(kModes),
                                          [&](const ModeRow& each) { return each.mode == mode; });
            return all[path][std::size_t(row - std::begin(kModes))];
        };
        const Series& indirect = series(RunMode::BakedIndirect);
        const double shadowRatio = shadowTime(series(RunMode::Shadowmask)) / shadowTime(indirect);
        const double distanceRatio = median(series(RunMode::DistanceShadowmask).totals) / median(indirect.totals);
        double cheapestOther = median(indirect.totals);
        for (const RunMode mode : {RunMode::Shadowmask, RunMode::DistanceShadowmask})
            cheapestOther = std::min(cheapestOther, median(series(mode).totals));
        const double subtractiveRatio = median(series(RunMode::Subtractive).totals) / cheapestOther;
        std::printf("%s: shadow maps, shadowmask / baked indirect %.3f (triangles %.3f); frame, distance shadowmask / "
                    "baked indirect %.3f; frame, subtractive / cheapest other %.3f\n",
                    path == 0 ? "forward " : "deferred", shadowRatio,
                    double(shadowDraws(series(RunMode::Shadowmask)).triangles) /
                        double(std::max<int64_t>(shadowDraws(indirect).triangles, 1)),
                    distanceRatio, subtractiveRatio);
        if (fewDynamic)
            met = demand(shadowRatio <= 1.0 / 3.0,
                         "shadowmask draws its shadow maps in a third of baked indirect's time") &&
                  met;
        met = demand(distanceRatio <= 1.1, "distance shadowmask takes at most 10 % longer than baked indirect") && met;
        met = demand(subtractiveRatio <= 1.0, "subtractive is the cheapest") && met;
    }
    return met;
}

struct Feature {
    const char* name;
    void (*change)(RenderSettings&);
};
constexpr Feature kFeatures[] = {
    {"as users see it", [](RenderSettings&) {}},
    {"without penumbrae", [](RenderSettings& s) { s.shadows.penumbrae = false; }},
    {"without reflection probes", [](RenderSettings& s) { s.reflectionProbes = false; }},
    {"without antialiasing", [](RenderSettings& s) { s.supersampling = 1; }},
};

/// What each feature adds to a frame of a baked file in distance shadowmask mode.
void benchFeatures(const Options& options, const std::string& name, const BakedScene& baked)
{
    const Camera camera = bench::cameraOf(baked.scene);
    const auto renderer = makeRenderer(options, baked);
    std::vector<Row> rows;
    for (const Feature& feature : kFeatures) {
        Row& row = rows.emplace_back(Row{renderer.get(), camera, {.mode = RunMode::DistanceShadowmask}});
        row.settings.supersampling = 2; // what `halflight render` has
        feature.change(row.settings);
    }
    const auto all = measured(options, rows);
    std::printf("\n%s, %d x %d, distance shadowmask, medians of %d frames\n\n| path | frame | all, ms | of all |\n"
                "|---|---|---|---|\n",
                name.c_str(), options.size.x, options.size.y, options.frames);
    for (std::size_t path = 0; path < 2; ++path) {
        for (std::size_t i = 0; i < std::size(kFeatures); ++i) {
            const double ms = median(all[path][i].totals);
            std::printf("| %s | %s | %.2f | %.0f %% |\n", path == 0 ? "forward" : "deferred", kFeatures[i].name, ms,
                        100.0 * ms / median(all[path][0].totals));
        }
    }
}

/// Cost grows with the lights that reach a pixel, not with those in the scene.
bool benchLights(const Options& options)
{
    struct Field {
        const char* name;
        int n;
        float reach;
    };
    const Field fields[] = {
        {"16 lights", 4, 0.8f}, {"256 lights, same overlap", 16, 0.8f}, {"256 lights, all overlap", 16, 24.0f}};
    std::vector<std::unique_ptr<Renderer>> renderers;
    std::vector<Scene> scenes;
    std::vector<double> reaching;
    for (const Field& field : fields) {
        scenes.push_back(bench::lightField(field.n, field.reach));
        reaching.push_back(bench::lightsPerPoint(scenes.back()));
        renderers.push_back(
            makeRenderer(options, bench::withStandInBake(scenes.back(), MixedLightingMode::Shadowmask)));
    }
    std::vector<Row> rows;
    for (std::size_t i = 0; i < scenes.size(); ++i)
        rows.push_back({renderers[i].get(), scenes[i].cameras[0], {.mode = RunMode::Shadowmask}});
    const auto all = measured(options, rows);
    std::printf("\n256 lights in view, %d x %d, medians of %d frames\n\n| path | scene | lights in view | reaching a "
                "point, mean | lit pass, ms | ns per pixel | against 16 lights |\n|---|---|---|---|---|---|---|\n",
                options.size.x, options.size.y, options.frames);
    bool met = true;
    for (std::size_t path = 0; path < 2; ++path) {
        const char* pass = path == 0 ? "forward" : "deferred light";
        const double first = timeOf(all[path][0], pass);
        for (std::size_t i = 0; i < scenes.size(); ++i) {
            const double ms = timeOf(all[path][i], pass);
            std::printf("| %s | %s | %d | %.2f | %.3f | %.2f | %.2f |\n", path == 0 ? "forward" : "deferred",
                        fields[i].name, all[path][i].lights, reaching[i], ms,
                        ms * 1.0e6 / (double(options.size.x) * options.size.y), ms / first);
        }
    }
    std::printf("\n");
    for (std::size_t path = 0; path < 2; ++path) {
        const char* pass = path == 0 ? "forward" : "deferred light";
        const double first = timeOf(all[path][0], pass);
        const double same = timeOf(all[path][1], pass) / first;
        const double overlap = timeOf(all[path][2], pass) / first;
        met =
            demand(
                same <= 2.0 && overlap > 2.0 * same,
                "sixteen times the lights in the scene cost less than twice, where they reach no pixel in addition") &&
            met;
    }
    return met;
}

/// What more than four masked lights at a point cost: lights, and a mask layer for each four of them (S36).
void benchLayers(const Options& options)
{
    constexpr int kLamps[] = {1, 4, 8, 16};
    std::vector<std::unique_ptr<Renderer>> renderers;
    std::vector<Row> rows;
    for (const int lamps : kLamps) {
        const Scene scene = bench::overlappingLamps(lamps);
        renderers.push_back(makeRenderer(options, bench::withStandInBake(scene, MixedLightingMode::Shadowmask)));
        Row row{renderers.back().get(), scene.cameras[0], {.mode = RunMode::Shadowmask}};
        row.settings.shadows.distanceMeters = 0.5f; // baked shadows alone
        rows.push_back(row);
    }
    const auto all = measured(options, rows);
    std::printf("\nOverlapping masked lights, %d x %d, medians of %d frames\n\n| path | lights | mask layers | all "
                "passes, ms | against 4 lights |\n|---|---|---|---|---|\n",
                options.size.x, options.size.y, options.frames);
    for (std::size_t path = 0; path < 2; ++path) {
        for (std::size_t i = 0; i < rows.size(); ++i)
            std::printf("| %s | %d | %d | %.3f | %.2f |\n", path == 0 ? "forward" : "deferred", kLamps[i],
                        (kLamps[i] + 3) / 4, median(all[path][i].totals),
                        median(all[path][i].totals) / median(all[path][1].totals));
    }
}

} // namespace

int main(int argc, char** argv)
{
    std::setvbuf(stdout, nullptr, _IOLBF, 0);
    Options options;
    for (int i = 1; i < argc; ++i) {
        const auto option = [&](const char* name) { return std::strcmp(argv[i], name) == 0 && i + 1 < argc; };
        if (option("--size")) {
            if (std::sscanf(argv[++i], "%5dx%5d", &options.size.x, &options.size.y) != 2) return 2;
        } else if (option("--frames"))
            options.frames = std::max(1, std::atoi(argv[++i]));
        else if (option("--only"))
            options.only = argv[++i];
        else if (std::strcmp(argv[i], "--cpu") == 0)
            options.preferCpu = true;
        else
            options.files.emplace_back(argv[i]);
    }
    {
        const auto renderer = makeRenderer(options, {});
        std::printf("device: %s, driver: %s\n", renderer->deviceName().c_str(), renderer->driver().c_str());
    }
    bool met = true;
    if (options.only == "features") {
        for (const std::string& file : options.files) {
            const Result<BakedScene> baked = readBakedScene(file);
            if (!baked || !baked->isBaked) {
                std::fprintf(stderr, "%s: %s\n", file.c_str(), baked ? "not baked" : baked.error().text().c_str());
                return 2;
            }
            benchFeatures(options, file.substr(file.find_last_of('/') + 1), *baked);
        }
        return 0;
    }
    if (options.only == "layers") {
        benchLayers(options);
        return 0;
    }
    if (options.only != "lights") {
        for (const std::string& file : options.files) {
            Result<Scene> scene = readScene(file);
            if (!scene) {
                std::fprintf(stderr, "%s: %s\n", file.c_str(), scene.error().text().c_str());
                return 2;
            }
            bench::ensureSun(*scene);
            bench::addDynamicSpheres(*scene, bench::cameraOf(*scene), 5);
            met = benchModes(options, file.substr(file.find_last_of('/') + 1), *scene) && met;
        }
        met = benchModes(options, "1,000 objects", bench::thousandObjects()) && met;
    }
    if (options.only != "modes") met = benchLights(options) && met;
    return met ? 0 : 1;
}
