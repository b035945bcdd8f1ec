#pragma once
// Whether two sides of a line on a surface are visible from one another, or another surface hides them.

#include "bake/geometry/source_tree.h"
#include "bake/seams/seams.h"
#include "halflight/unwrap/unwrap.h"

namespace halflight {

/// The test by which unwrap() chooses cuts. `tree` outlives it.
CrossingTest hiddenSidesTest(SourceTree& tree);

/// Takes away seam samples whose sides a surface hides from one another, so that nothing mixes their light.
Status dropHiddenSeams(const Integrator& integrator, std::vector<SeamSample>& seams);

} // namespace halflight
