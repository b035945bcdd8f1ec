#pragma once

#include "halflight/base/parallel.h"

#include <cstddef>
#include <cstdlib>
#include <vector>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace halflight {

/// Empties a container and frees its memory: assigning `{}` to a vector keeps that.
template<typename Container> void release(Container& container)
{
    Container().swap(container);
}

/// A vector of `count` equal values. All threads take its memory from the system at one time, which gives pages one by
/// one as they are first written.
template<typename T> std::vector<T> largeVector(std::size_t count, const T& value = T())
{
    std::vector<T> values;
    values.reserve(count);
    constexpr std::size_t kPage = 4096;        // bytes
    constexpr std::size_t kPagesAtOnce = 1024; // 4 MiB: smaller vectors are left to one thread
    auto* const bytes = reinterpret_cast<unsigned char*>(values.data());
    const std::size_t pages = count * sizeof(T) / kPage;
    parallelFor(pages < 2 * kPagesAtOnce ? 0 : pages, kPagesAtOnce, [&](std::size_t begin, std::size_t end) {
        for (std::size_t p = begin; p < end; ++p) bytes[p * kPage] = 0;
    });
    values.resize(count, value);
    return values;
}

/// Gives memory that was freed back to the system, where the allocator would keep it: after a stage that used millions
/// of small pieces, before one that needs as much in others.
inline void releaseFreeMemory()
{
#if defined(__GLIBC__)
    malloc_trim(0);
#endif
}

} // namespace halflight
