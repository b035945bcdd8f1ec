#pragma once
// Which sides of double-sided sheets can be seen, and whether their light differs.

#include "bake/geometry/source_tree.h"
#include "halflight/unwrap/unwrap.h"

namespace halflight {

/// The test by which unwrap() chooses sheets with texels for each side. The scene's lights have their baking output.
/// `mode`: of objects that do not say it themselves. `tree` and `progress` outlive the test.
SheetTest sheetSidesTest(SourceTree& tree, TwoSided mode, const Progress& progress);

} // namespace halflight
