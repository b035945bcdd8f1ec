#pragma once

#include "halflight/base/function_ref.h"
#include "halflight/base/progress.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
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
void parallelFor(std::size_t count, std::size_t grain, FunctionRef<void(std::size_t begin, std::size_t end)> body);

/// The same, reporting progress under `stage` as ranges finish. Returns false when it was cancelled: ranges not yet
/// begun are then skipped.
bool parallelFor(std::size_t count, std::size_t grain, const Progress& progress, std::string_view stage,
                 FunctionRef<void(std::size_t begin, std::size_t end)> body);

/// Calls body(i) for each i below `count`, on all threads. For short bodies: a thread takes 4096 at a time.
template<typename Body> void forEachIndex(std::size_t count, const Body& body)
{
    parallelFor(count, 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) body(i);
    });
}

/// All i below `count` for which wanted(i), ascending. Calls wanted(i) twice.
template<typename Wanted> std::vector<uint32_t> indicesWhere(std::size_t count, const Wanted& wanted)
{
    constexpr std::size_t kBlock = std::size_t(1) << 16;
    const auto endOf = [&](std::size_t block) { return std::min((block + 1) * kBlock, count); };
    std::vector<std::size_t> firstOf((count + kBlock - 1) / kBlock + 1, 0); // place of a block's first in the result
    parallelFor(firstOf.size() - 1, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
            for (std::size_t i = b * kBlock; i < endOf(b); ++i) firstOf[b + 1] += wanted(i) ? 1 : 0;
        }
    });
    for (std::size_t b = 1; b < firstOf.size(); ++b) firstOf[b] += firstOf[b - 1];
    std::vector<uint32_t> indices(firstOf.back());
    parallelFor(firstOf.size() - 1, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
            std::size_t place = firstOf[b];
            for (std::size_t i = b * kBlock; i < endOf(b); ++i) {
                if (wanted(i)) indices[place++] = uint32_t(i);
            }
        }
    });
    return indices;
}

/// Calls body(); while a parallelFor() in it waits for other threads, the calling thread takes up work of this body
/// alone. For large items of an outer parallelFor(), of which a thread would otherwise begin one within another.
void inIsolation(FunctionRef<void()> body);

/// Functions that another thread runs, one after another, while the caller goes on; run() runs them where there is one
/// thread. For long work of one thread beside stages that keep all others busy. The caller goes on inIsolation():
/// otherwise it would take up a function itself while it waits within a parallelFor().
class Background {
public:
    Background();
    /// Waits.
    ~Background();
    Background(const Background&) = delete;
    Background& operator=(const Background&) = delete;

    void run(std::function<void()> body);
    /// Returns when all functions have. Throws what one of them has thrown; those after it are dropped.
    void wait();

private:
    class Queue;
    std::unique_ptr<Queue> queue_;
};

/// std::sort() on all threads: sorts blocks, then merges runs in pairs. For orders in which items that are neither
/// before nor after one another are the same, so that there is one result.
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
        // A thread merges a block of the first run with what lies between the block's ends in the second.
        parallelFor(blocks, 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t b = begin; b < end; ++b) {
                const std::size_t first = b * kBlock / (2 * width) * (2 * width);
                const auto middle = at(first + width);
                const auto last = at(first + 2 * width);
                if (b * kBlock >= first + width) continue; // of a second run
                const auto from = at(b * kBlock);
                const auto to = std::min(at((b + 1) * kBlock), middle);
                const bool isLast = to == middle;
                const auto otherFrom = b * kBlock == first ? middle : std::lower_bound(middle, last, *from, less);
                const auto otherTo = isLast ? last : std::lower_bound(middle, last, *to, less);
                std::merge(from, to, otherFrom, otherTo, merged.begin() + (from - items.begin()) + (otherFrom - middle),
                           less);
            }
        });
        items.swap(merged);
    }
}

} // namespace halflight
