#include "bake_cpu/texels/valid_points.h"

#include "bake_cpu/texels/texel_set.h"
#include "bake_cpu/texels/texel_validity.h"

#include "halflight/bake/part_folder.h"
#include "halflight/bake/texel_grid.h"
#include "halflight/base/bytes.h"
#include "halflight/base/parallel.h"

#include <algorithm>
#include <numeric>
#include <optional>

namespace halflight {
namespace {

constexpr const char* kStage = "validity";
constexpr std::size_t kGrain = 256;
/// Texels of a part that processes share: a few hundredths of a second.
constexpr std::size_t kPartTexels = 16384;

class ValidPoints {
public:
    ValidPoints(const PathTracer& paths, const TexelMap& map, const Progress& progress, std::atomic<uint64_t>& rays)
        : paths_(paths), map_(map), progress_(progress), rays_(rays), validity_(paths), grid_(map)
    {}

    /// Masks of the texels [begin, end). Nothing when cancelled.
    std::optional<std::vector<PointMask>> find(std::size_t begin, std::size_t end) const
    {
        std::vector<uint32_t> texels(end - begin);
        std::iota(texels.begin(), texels.end(), uint32_t(begin));
        TexelSet around(map_, texels);
        around.extend([&](uint32_t texel, const auto& add) { grid_.around(texel, 1, add); });
        std::vector<uint8_t> doubtful(around.size());
        const auto findDoubtful = [&](std::size_t i, const TexelPoints& points, int count, uint64_t& traced) {
            doubtful[i] = validity_.mayHaveInvalidPoints(points, count, idOf(around[i]), traced) ? 1 : 0;
        };
        if (!forTexels(
                around.size(), 0.0, 0.5, [&](std::size_t i) { return around[i]; }, findDoubtful))
            return std::nullopt;
        std::vector<PointMask> masks(texels.size(), kAllPoints);
        const auto test = [&](std::size_t i, const TexelPoints& points, int count, uint64_t& traced) {
            bool any = false;
            grid_.around(texels[i], 1, [&](uint32_t other) { any = any || doubtful[around.find(other)] != 0; });
            if (any) masks[i] = validity_.validPoints(points, count, idOf(texels[i]), traced);
        };
        if (!forTexels(
                texels.size(), 0.5, 1.0, [&](std::size_t i) { return texels[i]; }, test))
            return std::nullopt;
        return masks;
    }

private:
    [[nodiscard]] uint32_t idOf(uint32_t texel) const { return texelId(map_, map_.texels[texel]); }

    template<typename TexelAt, typename Body>
    bool forTexels(std::size_t count, double from, double to, const TexelAt& texelAt, const Body& body) const
    {
        const BakeGeometry& geometry = paths_.surfaces().geometry();
        const Progress part = partOf(progress_, from, to);
        return parallelFor(count, kGrain, part, kStage, [&](std::size_t begin, std::size_t end) {
            uint64_t traced = 0;
            TexelPoints points;
            for (std::size_t i = begin; i < end && !progress_.cancelled(); ++i) {
                const int pointCount = texelPoints(geometry, map_, map_.texels[texelAt(i)], points);
                body(i, points, pointCount, traced);
            }
            rays_ += traced;
        });
    }

    const PathTracer& paths_;
    const TexelMap& map_;
    const Progress& progress_;
    std::atomic<uint64_t>& rays_;
    TexelValidity validity_;
    TexelGrid grid_;
};

std::optional<std::vector<PointMask>> findTogether(const ValidPoints& points, std::size_t texels, PartFolder& parts)
{
    const auto compute = [&](std::size_t part) -> std::optional<std::vector<std::byte>> {
        const std::size_t begin = part * kPartTexels;
        const auto masks = points.find(begin, std::min(begin + kPartTexels, texels));
        return masks ? std::optional(ByteWriter().add(*masks).take()) : std::nullopt;
    };
    const auto bytes = parts.complete(kStage, (texels + kPartTexels - 1) / kPartTexels, compute);
    if (!bytes) return std::nullopt;
    std::vector<PointMask> all;
    for (const std::vector<std::byte>& part : *bytes) {
        std::vector<PointMask> masks;
        ByteReader(part).read(masks);
        all.insert(all.end(), masks.begin(), masks.end());
    }
    return all.size() == texels ? std::optional(std::move(all)) : std::nullopt;
}

} // namespace

bool findValidPoints(const PathTracer& paths, TexelMap& map, PartFolder* parts, const Progress& progress,
                     std::atomic<uint64_t>& rays)
{
    std::vector<PointMask> kept;
    if (const auto bytes = parts != nullptr ? parts->read(kStage) : std::nullopt) ByteReader(*bytes).read(kept);
    if (kept.size() != map.texels.size()) {
        const ValidPoints points(paths, map, progress, rays);
        const bool shared = parts != nullptr && parts->isShared();
        auto found = shared ? findTogether(points, map.texels.size(), *parts) : points.find(0, map.texels.size());
        if (!found) return false;
        kept = std::move(*found);
        if (parts != nullptr) parts->write(kStage, ByteWriter().add(kept).take());
    }
    forEachIndex(kept.size(), [&](std::size_t i) { map.texels[i].validPoints = kept[i]; });
    return true;
}

} // namespace halflight
