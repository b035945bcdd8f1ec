// A bake in the background against bake(): when light is seen, how good it is, and what the whole costs. Usage:
//
//   bench_session SCENE.glb [QUALITY preview|medium|high] [LIGHTMAP_SIZE] [ROUNDS]
//
// Prints the quality by time, the seconds until the first light and until 90 % of the final quality, and the session's
// and bake()'s seconds, in turn, with their ratio and those of their stages. Quality is 1 less the root mean square
// error of the light of texels that charts cover against the finished pages, relative to that light's own root mean
// square. The session is asked for its tiles every 0.3 s, as the window does; times of the comparison are not counted.
// Wall time: use a quiet machine.
#include "bake/geometry/flatten.h"
#include "bake/texels/rasterize.h"
#include "session_arguments.h"

#include "halflight/bake/bake_session.h"
#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/base/rgb9e5.h"
#include "halflight/scene/gltf.h"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

using namespace halflight;
using namespace halflight::bench;

namespace {

/// What the window shows from a moment on.
struct Step {
    double seconds = 0.0;
    std::vector<LightTile> tiles;
};

struct Run {
    double seconds = 0.0;
    double probeSeconds = 0.0; ///< until the light of probes, which the window shows first
    double lightSeconds = 0.0;
    std::optional<BakedScene> light;
    std::vector<Step> steps;
    std::optional<BakeResult> result;
};

std::optional<Run> runSession(const Scene& scene, const BakeSettings& settings)
{
    Run run;
    const Clock::time_point start = Clock::now();
    Clock::time_point last = start;
    BakeSession session(scene, settings, embreeIntegrators());
    if (!scene.cameras.empty()) session.setView(scene.cameras.front(), 16.0f / 9.0f);
    while (!session.state().finished) {
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
        if (run.probeSeconds == 0.0 && session.takeProbeLight()) run.probeSeconds = secondsSince(start);
        if (!run.light) {
            if ((run.light = session.takeLight())) run.lightSeconds = secondsSince(start);
        } else if (secondsSince(last) > 0.3) {
            last = Clock::now();
            std::vector<LightTile> tiles = session.takeTiles();
            if (!tiles.empty()) run.steps.push_back({secondsSince(start), std::move(tiles)});
        }
    }
    Result<BakeResult> baked = session.takeResult();
    run.seconds = secondsSince(start);
    if (!baked || !run.light) return std::nullopt;
    run.result = std::move(*baked);
    return run;
}

/// 1 where charts cover the page. Elsewhere is padding, of which finished pages have more than unfinished ones.
std::vector<Image<uint8_t>> coverage(const BakedScene& baked)
{
    const int size = baked.lightmaps.at(0).width();
    const int count = int(baked.lightmaps.size());
    std::vector<Image<uint8_t>> covered(std::size_t(count), Image<uint8_t>(size, size, uint8_t(0)));
    const TexelMap map = rasterizeTexels(flattenGeometry(baked.scene, size, GeometryFilter::Static), size, count);
    for (const Texel& texel : map.texels) covered[texel.page](texel.x, texel.y) = 1;
    return covered;
}

/// Squared difference of a rectangle of light to the finished page, where it is covered.
double squaredError(const Image<uint32_t>& texels, ivec2 offset, float unitLux, const ImageRgb32f& page,
                    const Image<uint8_t>& covered)
{
    const ImageRgb32f light = decodeRgb9e5(texels, unitLux);
    double sum = 0.0;
    for (int y = 0; y < light.height(); ++y) {
        for (int x = 0; x < light.width(); ++x) {
            if (covered(offset.x + x, offset.y + y) == 0) continue;
            const vec3 difference = light(x, y) - page(offset.x + x, offset.y + y);
            sum += double(glm::dot(difference, difference));
        }
    }
    return sum;
}

/// Seconds until 90 % of the final quality; the session's if tiles do not reach it.
double secondsToQuality(Run& run)
{
    constexpr double kQuality = 0.9;
    const std::vector<ImageRgb32f>& pages = run.result->irradiance;
    std::vector<Image<uint32_t>>& shown = run.light->lightmaps;
    const float unit = run.light->lightmapUnitLux;
    const std::vector<Image<uint8_t>> covered = coverage(run.result->baked);
    double all = 0.0;
    double error = 0.0;
    for (std::size_t p = 0; p < pages.size(); ++p) {
        for (std::size_t i = 0; i < pages[p].texelCount(); ++i)
            if (covered[p].texels()[i] != 0) all += double(glm::dot(pages[p].texels()[i], pages[p].texels()[i]));
        error += squaredError(shown[p], ivec2(0), unit, pages[p], covered[p]);
    }
    const auto quality = [&] { return 1.0 - std::sqrt(std::max(error, 0.0) / all); };
    std::printf("light of probes after %.2f s, first light after %.2f s: quality %.3f\n", run.probeSeconds,
                run.lightSeconds, quality());
    double reached = quality() >= kQuality ? run.lightSeconds : run.seconds;
    for (const Step& step : run.steps) {
        for (const LightTile& tile : step.tiles) {
            const auto p = std::size_t(tile.page);
            Image<uint32_t> before(tile.texels.width(), tile.texels.height());
            for (int y = 0; y < before.height(); ++y) {
                for (int x = 0; x < before.width(); ++x) {
                    uint32_t& texel = shown[p](tile.offset.x + x, tile.offset.y + y);
                    before(x, y) = std::exchange(texel, tile.texels(x, y));
                }
            }
            error += squaredError(tile.texels, tile.offset, unit, pages[p], covered[p]) -
                     squaredError(before, tile.offset, unit, pages[p], covered[p]);
        }
        if (quality() >= kQuality) reached = std::min(reached, step.seconds);
        std::printf("  %.1f s: %.3f", step.seconds, quality());
    }
    std::printf("\n");
    return reached;
}

/// Seconds of each stage, the session's after bake()'s.
void printStages(const BakeReport& plain, const BakeReport& session)
{
    for (std::size_t i = 0; i < plain.stages.size() && i < session.stages.size(); ++i)
        std::printf("  %s %.2f %.2f", plain.stages[i].name.c_str(), plain.stages[i].seconds, session.stages[i].seconds);
    std::printf("\n");
}

int run(const char* file, const BakeSettings& settings, int rounds)
{
    const Result<Scene> scene = readScene(file);
    if (!scene) {
        std::fprintf(stderr, "%s\n", scene.error().text().c_str());
        return 1;
    }
    double plainSeconds = 0.0;
    double sessionSeconds = 0.0;
    for (int round = 0; round < rounds; ++round) { // in turn, so that a change of the machine's pace shows
        const Clock::time_point start = Clock::now();
        const Result<BakeResult> plain = bake(*scene, settings, embreeIntegrators());
        if (!plain) return 1;
        const double seconds = secondsSince(start);
        std::optional<Run> session = runSession(*scene, settings);
        if (!session) return 1;
        std::printf("90 %% of the quality after %.2f s; session %.2f s, bake() %.2f s\n", secondsToQuality(*session),
                    session->seconds, seconds);
        printStages(plain->report, session->result->report);
        plainSeconds += seconds;
        sessionSeconds += session->seconds;
    }
    std::printf("session / bake() %.3f\n", sessionSeconds / plainSeconds);
    return 0;
}

} // namespace

int main(int count, char** arguments)
{
    if (count < 2) {
        std::fprintf(stderr, "usage: bench_session SCENE.glb [preview|medium|high] [LIGHTMAP_SIZE] [ROUNDS]\n");
        return 2;
    }
    return run(arguments[1], settingsOf(count, arguments), count > 4 ? std::atoi(arguments[4]) : 2);
}
