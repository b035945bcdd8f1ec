#pragma once
// Tests that hold for both integrators, and means over a whole map.

#include "bake/test_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace halflight::test {

/// Spread of a whole-map mean is far below a texel's; both are checked.
struct Statistics {
    double mean = 0.0;
    double worst = 0.0; ///< largest relative difference of a texel from `expected`
};

inline Statistics compare(const std::vector<IrradianceEstimate>& estimates, double expected)
{
    Statistics s;
    for (const IrradianceEstimate& e : estimates) {
        s.mean += e.irradiance.y / double(estimates.size());
        s.worst = std::max(s.worst, std::abs(e.irradiance.y - expected) / expected);
    }
    return s;
}

/// What holds for light holds whichever way it is transported.
class BothIntegrators : public testing::TestWithParam<IntegratorKind> {
protected:
    static IntegrationSettings transport()
    {
        IntegrationSettings settings;
        settings.integrator = GetParam();
        return settings;
    }
};
inline const auto kBoth = testing::Values(IntegratorKind::Cache, IntegratorKind::Path);
inline std::string integratorName(const testing::TestParamInfo<IntegratorKind>& info)
{
    return info.param == IntegratorKind::Cache ? "Cache" : "Path";
}

} // namespace halflight::test
