#pragma once
// What the benchmarks of bakes in the background have in common.

#include "halflight/bake/bake.h"

#include <chrono>
#include <cstdlib>
#include <string_view>

namespace halflight::bench {

using Clock = std::chrono::steady_clock;

inline double secondsSince(Clock::time_point start)
{
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Of PROGRAM SCENE.glb [preview|medium|high] [LIGHTMAP_SIZE] ….
inline BakeSettings settingsOf(int count, char** arguments)
{
    BakeSettings settings;
    const std::string_view quality = count > 2 ? arguments[2] : "preview";
    settings.quality = quality == "high" ? Quality::High : quality == "medium" ? Quality::Medium : Quality::Preview;
    if (count > 3) settings.lightmapSize = std::atoi(arguments[3]);
    return settings;
}

} // namespace halflight::bench
