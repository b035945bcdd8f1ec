#pragma once

#include "halflight/base/math.h"

#include <cmath>

namespace halflight {

/// Whether no component is infinite or NaN.
template<glm::length_t N, typename T> bool isFinite(const glm::vec<N, T>& v)
{
    for (glm::length_t i = 0; i < N; ++i) {
        if (!std::isfinite(v[i])) return false;
    }
    return true;
}

template<glm::length_t C, glm::length_t R, typename T> bool isFinite(const glm::mat<C, R, T>& m)
{
    for (glm::length_t c = 0; c < C; ++c) {
        if (!isFinite(m[c])) return false;
    }
    return true;
}

} // namespace halflight
