// What is seen of the joints of a modular kit in steep and noisy light.

#include "bake/seams/seams.h"
#include "quality/baked.h"
#include "quality/measures.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace halflight::quality {
namespace {

constexpr const char* kScene = "quality/tiles.glb";

/// Mean of |values|, each with its length along joints.
struct Mean {
    double sum = 0.0;
    double length = 0.0;
    void add(double value, double texels)
    {
        sum += texels * std::abs(value);
        length += texels;
    }
    [[nodiscard]] double percent() const
    {
        return length > 0.0 ? 100.0 * sum / length : std::numeric_limits<double>::infinity();
    }
};

} // namespace

// The step is the difference of what a renderer filters on both sides, of the mean of both. Noise that differs from
// tile to tile shows as a step farther off: the errors a texel off the joint on both sides differ by more than those of
// places two texels apart on one tile. Errors are against many samples.
Figures measureTiles(const std::filesystem::path& assets)
{
    BakeSettings settings;
    settings.quality = Quality::Preview;
    settings.lightmapSize = 512;
    settings.texelsPerMeter = 8.0f;
    settings.probeSpacingMeters = 1.0e3f; // a handful
    const auto baked = bakeFile(assets / kScene, settings);
    settings.samples = 1024;
    settings.denoiser = Denoiser::Off;
    settings.seed = 99;
    const auto truth = bakeFile(assets / kScene, settings);
    if (!baked || !truth) {
        const Error& error = baked ? truth.error() : baked.error();
        return {{"tiles", kScene, error.text(), std::numeric_limits<double>::infinity(), 0.0, ""}};
    }
    const auto errorAt = [&](int page, vec2 place) {
        const double right = luminanceOf(truth->light(page, place));
        return luminanceOf(baked->light(page, place)) / right - 1.0;
    };
    Mean steps;
    Mean across;
    Mean within;
    for (const SeamSample& seam : findSeams(baked->geometry, baked->pageSize)) {
        const double texels = double(seam.texels);
        const double a = luminanceOf(baked->light(seam.pageA, seam.texelA));
        const double b = luminanceOf(baked->light(seam.pageB, seam.texelB));
        steps.add((a - b) / (0.5 * (a + b)), texels);
        const vec2 intoB = seam.acrossFromA * seam.outwardA;
        across.add(errorAt(seam.pageA, seam.texelA - seam.outwardA) - errorAt(seam.pageB, seam.texelB + intoB), texels);
        for (const float off : {3.0f, 5.0f}) { // texels from the joint
            within.add(errorAt(seam.pageA, seam.texelA - off * seam.outwardA) -
                           errorAt(seam.pageA, seam.texelA - (off + 2.0f) * seam.outwardA),
                       texels);
        }
    }
    return {{"tiles", kScene, "mean step at joints of tiles, preview", steps.percent(), 0.5, "%"},
            {"tiles", kScene, "errors two texels apart, mean difference, on a tile", within.percent(), 100.0, "%"},
            {"tiles", kScene, "… across a joint", across.percent(), 1.15 * within.percent(), "%"}};
}

} // namespace halflight::quality
