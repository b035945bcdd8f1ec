#pragma once

#include "halflight/base/progress.h"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <string_view>
#include <vector>

namespace halflight {

/// Sets how many threads parallelFor uses from now on (0 = all cores) until the object goes out of scope. No result of
/// this project depends on the number.
class ThreadLimit {
public:
    explicit ThreadLimit(int threads);
    ~ThreadLimit();
    ThreadLimit(const ThreadLimit&) = delete;
    ThreadLimit& operator=(const ThreadLimit&) = delete;

private:
    void* control_;
};

/// Number of threads parallelFor uses now.
int threadCount();

/// Calls body(begin, end) on disjoint ranges that cover [0, count), `grain` items each at most, on all threads.
void parallelFor(std::size_t count, std::size_t grain,
                 const std::function<void(std::size_t begin, std::size_t end)>& body);

/// The same, reporting progress under `stage` as ranges finish. Returns false when it was cancelled: ranges not yet
/// begun are then skipped.
bool parallelFor(std::size_t count, std::size_t grain, const Progress& progress, std::string_view stage,
                 const std::function<void(std::size_t begin, std::size_t end)>& body);

/// std::sort() on all threads, for a strict total order: sorts blocks, then merges them in pairs. Blocks and merges
/// follow from the number of items, so that any order without equal items gives one result.
template<typename T, typename Less> void parallelSort(std::vector<T>& items, const Less& less)
{
    constexpr std::size_t kBlock = std::size_t(1) << 16;
    const auto at = [&](std::size_t i) { return items.begin() + std::ptrdiff_t(std::min(i, items.size())); };
    const std::size_t blocks = (items.size() + kBlock - 1) / kBlock;
    parallelFor(blocks, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) std::sort(at(b * kBlock), at((b + 1) * kBlock), less);
    });
    std::vector<T> merged(items.size());
    for (std::size_t width = kBlock; width < items.size(); width *= 2) {
        parallelFor((items.size() + 2 * width - 1) / (2 * width), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t p = begin; p < end; ++p) {
                const std::size_t first = 2 * width * p;
                std::merge(at(first), at(first + width), at(first + width), at(first + 2 * width),
                           merged.begin() + std::ptrdiff_t(first), less);
            }
        });
        items.swap(merged);
    }
}

} // namespace halflight
