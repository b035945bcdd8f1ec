#pragma once

#include "halflight/base/math.h"

#include <algorithm>
#include <cstdint>

namespace halflight {

/// Mean irradiance, mean first moment, and variance of the mean of a stream of samples.
struct RunningMoments {
    vec3 sum{0.0f};       ///< of irradiance
    vec3 moment{0.0f};    ///< sum of first moments
    float squares = 0.0f; ///< squared deviations of luminance from its mean (Welford 1962)
    uint32_t count = 0;

    void add(vec3 irradiance, vec3 firstMoment)
    {
        const float before = count > 0 ? luminance(sum) / float(count) : 0.0f;
        const float value = luminance(irradiance);
        sum += irradiance;
        moment += firstMoment;
        ++count;
        squares += (value - before) * (value - luminance(sum) / float(count));
    }
    [[nodiscard]] vec3 mean() const { return count > 0 ? sum / float(count) : vec3(0.0f); }
    [[nodiscard]] vec3 meanMoment() const { return count > 0 ? moment / float(count) : vec3(0.0f); }
    [[nodiscard]] float varianceOfMean() const
    {
        return count > 1 ? std::max(squares, 0.0f) / (float(count) * float(count - 1)) : 0.0f;
    }
};

} // namespace halflight
