#include "bake_cpu/texels/valid_points.h"

#include "bake_cpu/texels/texel_validity.h"

#include "halflight/bake/texel_grid.h"
#include "halflight/base/parallel.h"

namespace halflight {

bool findValidPoints(const PathTracer& paths, TexelMap& map, const Progress& progress, std::atomic<uint64_t>& rays)
{
    constexpr std::size_t kGrain = 256;
    const TexelValidity validity(paths);
    const BakeGeometry& geometry = paths.surfaces().geometry();
    std::vector<uint8_t> doubtful(map.texels.size());
    const auto findDoubtful = [&](std::size_t begin, std::size_t end) {
        uint64_t traced = 0;
        TexelPoints points;
        for (std::size_t i = begin; i < end && !progress.cancelled(); ++i) {
            const Texel& texel = map.texels[i];
            const int count = texelPoints(geometry, map, texel, points);
            doubtful[i] = validity.mayHaveInvalidPoints(points, count, texelId(map, texel), traced) ? 1 : 0;
        }
        rays += traced;
    };
    if (!parallelFor(map.texels.size(), kGrain, partOf(progress, 0.0, 0.5), "validity", findDoubtful)) return false;
    const TexelGrid grid(map);
    const auto test = [&](std::size_t begin, std::size_t end) {
        uint64_t traced = 0;
        TexelPoints points;
        for (std::size_t i = begin; i < end && !progress.cancelled(); ++i) {
            Texel& texel = map.texels[i];
            texel.validPoints = kAllPoints;
            bool any = false;
            grid.around(uint32_t(i), 1, [&](uint32_t other) { any = any || doubtful[other] != 0; });
            if (!any) continue;
            const int count = texelPoints(geometry, map, texel, points);
            texel.validPoints = validity.validPoints(points, count, texelId(map, texel), traced);
        }
        rays += traced;
    };
    return parallelFor(map.texels.size(), kGrain, partOf(progress, 0.5, 1.0), "validity", test);
}

} // namespace halflight
