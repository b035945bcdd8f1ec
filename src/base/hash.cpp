#include "halflight/base/hash.h"

#define XXH_STATIC_LINKING_ONLY // the state on the stack, not a pointer to it
#include <xxhash.h>

#include <cstdio>

namespace halflight {

struct Hasher::State {
    XXH3_state_t xxh;
};

std::string Hash128::hex() const
{
    char text[33];
    std::snprintf(text, sizeof(text), "%016llx%016llx", static_cast<unsigned long long>(high),
                  static_cast<unsigned long long>(low));
    return text;
}

Hasher::Hasher() : state_(std::make_unique<State>())
{
    XXH3_INITSTATE(&state_->xxh);
    XXH3_128bits_reset(&state_->xxh);
}

Hasher::~Hasher() = default;

Hasher& Hasher::bytes(const void* data, std::size_t count)
{
    if (count > 0) XXH3_128bits_update(&state_->xxh, data, count);
    return *this;
}

Hash128 Hasher::hash() const
{
    const XXH128_hash_t h = XXH3_128bits_digest(&state_->xxh);
    return {h.low64, h.high64};
}

} // namespace halflight
