#pragma once
// Whether two sides of a line on a surface are visible from one another, or another surface hides them.

#include "bake/stages.h"
#include "halflight/unwrap/unwrap.h"

namespace halflight {

/// The test by which unwrap() chooses cuts: rays of an integrator for the scene as it is. The scene is flattened once
/// more for it, only where surfaces cross at all.
CrossingTest hiddenSidesTest(const IntegratorFactory& factory, const IntegrationSettings& settings);

/// Takes away seam samples whose sides a surface hides from one another, so that nothing mixes their light.
void dropHiddenSeams(const Integrator& integrator, std::vector<SeamSample>& seams);

} // namespace halflight
