#pragma once
// Entries of the bake's report and its warnings.

#include "bake/lights/main_light.h"

#include "halflight/bake/bake.h"
#include "halflight/base/system.h"

#include <chrono>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

namespace halflight {

/// Adds a stage to the report when it ends.
class StageTimer {
public:
    using Clock = std::chrono::steady_clock;

    StageTimer(BakeReport& report, std::string name)
        : report_(report), name_(std::move(name)), start_(Clock::now()), cpuStart_(processCpuSeconds())
    {}
    void finish(uint64_t rays = 0)
    {
        report_.stages.push_back({name_, std::chrono::duration<double>(start_ - report_.began).count(),
                                  std::chrono::duration<double>(Clock::now() - start_).count(),
                                  processCpuSeconds() - cpuStart_, rays});
    }

private:
    BakeReport& report_;
    std::string name_;
    Clock::time_point start_;
    double cpuStart_;
};

/// Rows of the lights, with warnings for those that are not baked as authored.
void reportLights(const Scene& scene, BakeReport& report);

/// Static materials that give light that passes a colour.
std::set<std::string> coloringGlassOf(const Scene& scene);

/// Channels of the lights' rows anew, with a warning for lights whose masks lack their colour (S35).
void reportColoredMasks(const Scene& scene, const std::vector<std::string>& leftGray, int mostLayers,
                        BakeReport& report);

/// Noise and sample counts of the estimates before denoising. `main`: direct light that is not in the estimates.
void reportNoise(std::span<const IrradianceEstimate> estimates, const std::optional<MainLight>& main,
                 BakeReport& report);

/// A warning with the names of objects that have flipped triangles.
void reportFlipped(const Scene& scene, const BakeGeometry& geometry, BakeReport& report);

/// Objects with sheets whose sides have texels of their own.
void reportTwoSided(const Scene& scene, const BakeGeometry& geometry, const TexelMap& map, BakeReport& report);

/// Of a subtractive bake.
void reportMainLight(const BakedScene& baked, const MainLight& main, const BakeSettings& settings, BakeReport& report);

} // namespace halflight
