#pragma once
// BakeSettings::seconds: how many samples the lightmap takes in the time that is left.

#include "bake/first_stages.h"

namespace halflight {

/// Seconds by the bake's clock, from an arbitrary start.
double secondsNow(const BakeSettings& settings);

/// Measures some texels, and sets the samples of `lightmap` and of the report with which the bake ends at
/// BakeSettings::seconds. All stages that do not need the lightmap are done; `began`: when the bake began, by
/// secondsNow(). Where less time is left than preview's samples take, it sets these, and warns.
Status chooseSamples(const BakeRun& run, double began, const CachedIntegrator& cached, PreparedLightmap& lightmap);

} // namespace halflight
