#pragma once
// What the scenes of assets/quality/ show, as figures: each scene is baked and its result compared with what is known
// of it. bench_quality prints the figures, tests/quality asks that each keeps its limit.

#include "halflight/bake/bake.h"

#include <filesystem>
#include <string>
#include <vector>

namespace halflight::quality {

struct Figure {
    std::string item;  ///< leaks, edges, …
    std::string scene; ///< file in assets/
    std::string what;
    double value = 0.0;
    double limit = 0.0; ///< what the value has to stay at or below
    std::string unit;   ///< "%" or ""
    [[nodiscard]] bool met() const { return value <= limit; }
};
using Figures = std::vector<Figure>;

/// The figure that says that there is none.
Figures failed(const std::string& item, const std::string& scene, const Error& error);
/// The value that `share` of them, 0…1, do not exceed. It orders the values anew.
double percentile(std::vector<double>& values, double share);
BakeSettings settingsFor(MixedLightingMode mode, float texelsPerMeter, int samples, int bounces);
double luminanceOf(vec3 light);

/// Folders: `assets` holds quality/ and tests/. Errors are thrown away as figures without a limit kept: a scene that
/// cannot be read or baked gives one figure that is infinite.
Figures measureLeaks(const std::filesystem::path& assets);
Figures measureEdges(const std::filesystem::path& assets);
Figures measureSeams(const std::filesystem::path& assets);
Figures measureTiles(const std::filesystem::path& assets);
Figures measureMaskEdges(const std::filesystem::path& assets);
Figures measurePenumbra(const std::filesystem::path& assets);
Figures measureTerminator(const std::filesystem::path& assets);
Figures measureContact(const std::filesystem::path& assets, int truthSamples);
Figures measureProbes(const std::filesystem::path& assets);

} // namespace halflight::quality
