#pragma once

#include <cstdlib>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace halflight {

/// Empties a container and frees its memory: assigning `{}` to a vector keeps that.
template<typename Container> void release(Container& container)
{
    Container().swap(container);
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
