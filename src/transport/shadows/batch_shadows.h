#pragma once
// Feeds a DeviceShadows with the half-batches of a list of texels.

#include "transport/shadows/device_shadows.h"

#include "halflight/base/parallel.h"
#include "halflight/base/progress.h"

#include <algorithm>
#include <atomic>
#include <span>
#include <utility>
#include <vector>

namespace halflight {

class BatchShadows {
public:
    /// `colored`: sums by colour are needed too.
    BatchShadows(const DeviceShadows& device, const TexelMap& map, std::span<const ShadowSource> sources, bool colored)
        : device_(device), map_(map), sources_(sources), colored_(colored)
    {}

    /// Of a texel's items, in their order.
    struct Sums {
        std::span<const LitSum> lit;
        std::span<const vec3> colors; ///< ShadowRays::Sums::colors; empty unless they are needed
    };

    /// Traces the items of `texels`. countOf(i) is their number for texel i of the list, fill(i, items) writes them but
    /// for Item::texel, use(i, sums) takes their sums in the same order. All three are called on all threads.
    template<typename CountOf, typename Fill, typename Use>
    Status trace(std::span<const uint32_t> texels, const CountOf& countOf, const Fill& fill, const Use& use,
                 const Progress& progress, const char* stage, std::atomic<uint64_t>& rays)
    {
        const std::size_t count = texels.size();
        for (std::size_t begin = 0; begin < count;) {
            if (progress.cancelled()) return cancelledError();
            const std::size_t some = plan(begin, count, countOf);
            const auto part = [&](auto& list, std::size_t i) {
                return std::span(list).subspan(firsts_[i], firsts_[i + 1] - firsts_[i]);
            };
            items_.resize(firsts_[some]);
            sums_.resize(firsts_[some]);
            if (colored_) colors_.resize(firsts_[some]);
            forEachIndex(some, [&](std::size_t i) {
                const std::span<DeviceShadows::Item> items = part(items_, i);
                fill(begin + i, items);
                for (DeviceShadows::Item& item : items) item.texel = uint32_t(i);
            });
            uint64_t traced = 0;
            if (Status s = device_.trace(map_, {sources_, texels.subspan(begin, some), items_}, sums_, colors_, traced);
                !s)
                return s;
            rays += traced;
            forEachIndex(some, [&](std::size_t i) {
                const std::span<const vec3> colors =
                    colored_ ? part(std::as_const(colors_), i) : std::span<const vec3>();
                use(begin + i, Sums{part(std::as_const(sums_), i), colors});
            });
            begin += some;
            progress(stage, double(begin) / double(count));
        }
        return {};
    }

private:
    /// Finds where the items of the next texels begin, and returns how many texels have as many items as the device
    /// takes at once: one texel at least.
    template<typename CountOf> std::size_t plan(std::size_t begin, std::size_t count, const CountOf& countOf)
    {
        const std::size_t most = std::min(count - begin, DeviceShadows::kItemsAtOnce);
        firsts_.resize(most + 1);
        forEachIndex(most, [&](std::size_t i) { firsts_[i + 1] = countOf(begin + i); });
        firsts_[0] = 0;
        std::size_t texels = 0;
        for (; texels < most; ++texels) {
            firsts_[texels + 1] += firsts_[texels];
            if (texels > 0 && firsts_[texels + 1] > DeviceShadows::kItemsAtOnce) break;
        }
        return texels;
    }

    const DeviceShadows& device_;
    const TexelMap& map_;
    std::span<const ShadowSource> sources_;
    std::vector<std::size_t> firsts_; ///< by texel, its first item; then their number
    std::vector<DeviceShadows::Item> items_;
    std::vector<LitSum> sums_;
    bool colored_;
    std::vector<vec3> colors_; ///< empty unless they are needed
};

} // namespace halflight
