#pragma once
// Which sides of double-sided sheets can be seen, and whether their light differs.

#include "bake/stages.h"
#include "halflight/unwrap/unwrap.h"

namespace halflight {

/// The test by which unwrap() chooses sheets with texels for each side: rays of an integrator for the scene as it is,
/// whose lights have their baking output. The scene is flattened once more for it, only where it has sheets at all.
/// `mode`: of objects that do not say it themselves.
SheetTest sheetSidesTest(const IntegratorFactory& factory, const IntegrationSettings& settings, TwoSided mode,
                         const Progress& progress);

} // namespace halflight
