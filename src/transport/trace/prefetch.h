#pragma once

namespace halflight {

/// Asks for memory that is read soon; nothing where the compiler has no such function of its own (MSVC).
inline void prefetch([[maybe_unused]] const void* address)
{
#ifdef __GNUC__
    __builtin_prefetch(address);
#endif
}

} // namespace halflight
