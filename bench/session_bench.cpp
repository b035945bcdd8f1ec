// A bake in the background against bake(): when the first light is there, and what the whole costs. Usage:
//
//   bench_session SCENE.glb [QUALITY preview|medium|high] [LIGHTMAP_SIZE]
//
// Prints seconds until the first light, its distance to the finished probes, the session's and bake()'s seconds, in
// turn, and their ratio. Wall time: use a quiet machine.
#include "halflight/bake/bake_session.h"
#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/scene/gltf.h"

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string_view>
#include <thread>

using namespace halflight;

namespace {

using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point start)
{
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Mean radiance of the valid probes.
double brightness(const BakedScene& baked)
{
    double sum = 0.0;
    int count = 0;
    for (const Probe& probe : baked.probes.probes) {
        if (!probe.valid) continue;
        sum += double(luminance(probe.radiance[0]));
        ++count;
    }
    return count > 0 ? sum / count : 0.0;
}

int run(const char* file, const BakeSettings& settings)
{
    const Result<Scene> scene = readScene(file);
    if (!scene) {
        std::fprintf(stderr, "%s\n", scene.error().text().c_str());
        return 1;
    }
    constexpr int kRounds = 2; // in turn, so that a change of the machine's pace shows
    double plainSeconds = 0.0;
    double sessionSeconds = 0.0;
    for (int round = 0; round < kRounds; ++round) {
        Clock::time_point start = Clock::now();
        const Result<BakeResult> plain = bake(*scene, settings, makeEmbreeIntegrator);
        if (!plain) return 1;
        plainSeconds += secondsSince(start);

        start = Clock::now();
        BakeSession session(*scene, settings, makeEmbreeIntegrator);
        std::optional<BakedScene> light;
        double lightSeconds = 0.0;
        while (!session.state().finished) {
            if (!light && (light = session.takeLight())) lightSeconds = secondsSince(start);
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        const Result<BakeResult> baked = session.takeResult();
        if (!baked || !light) return 1;
        sessionSeconds += secondsSince(start);
        std::printf("first light %.2f s, %+.1f %% of the finished probes' mean radiance\n", lightSeconds,
                    100.0 * (brightness(*light) / brightness(baked->baked) - 1.0));
    }
    std::printf("session %.2f s, bake() %.2f s, ratio %.3f\n", sessionSeconds / kRounds, plainSeconds / kRounds,
                sessionSeconds / plainSeconds);
    return 0;
}

} // namespace

int main(int count, char** arguments)
{
    if (count < 2) {
        std::fprintf(stderr, "usage: bench_session SCENE.glb [preview|medium|high] [LIGHTMAP_SIZE]\n");
        return 2;
    }
    BakeSettings settings;
    const std::string_view quality = count > 2 ? arguments[2] : "preview";
    settings.quality = quality == "high" ? Quality::High : quality == "medium" ? Quality::Medium : Quality::Preview;
    if (count > 3) settings.lightmapSize = std::atoi(arguments[3]);
    return run(arguments[1], settings);
}
