#pragma once
// glTF 2.0, section 3.6.2.1: accessors hold no NaN and no infinity.

#include "scene/document/document.h"

namespace halflight {

/// Error with accessor and element where a value is not finite. Of tangents alone, which any reader can make anew, the
/// attribute goes instead, with a warning in `document.warnings`. Accessors are checked already.
Status checkFiniteAccessors(SourceDocument& document);

} // namespace halflight
