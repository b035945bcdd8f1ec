#pragma once

#include <cstdlib>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace halflight {

/// Gives memory that was freed back to the system, where the allocator would keep it: after a stage that used millions
/// of small pieces, before one that needs as much in others.
inline void releaseFreeMemory()
{
#if defined(__GLIBC__)
    malloc_trim(0);
#endif
}

} // namespace halflight
