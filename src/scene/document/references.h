#pragma once
// Where a document refers to accessors and buffer views.

#include "halflight/base/function_ref.h"

#include "scene/document/document.h"

namespace halflight {

/// Members of the record of probes that are accessors: attenuation by mask layer, and all.
inline constexpr const char* kOcclusionAccessors[] = {"occlusion", "occlusion1", "occlusion2", "occlusion3"};
inline constexpr const char* kProbeAccessors[] = {"positions",  "radiance",    "occlusion", "occlusion1",
                                                  "occlusion2", "occlusion3",  "valid",     "tetrahedra",
                                                  "neighbors",  "sightRanges", "sight"};

/// Calls visit(index) on every reference to an accessor or buffer view in the parts of glTF that this program knows;
/// visit may change the index.
void visitAccessors(Json& document, FunctionRef<void(Json&)> visit);
void visitViews(Json& document, FunctionRef<void(Json&)> visit);

/// The member of an object; null where there is none, or where it is no object.
Json* find(Json& object, const char* key);
/// The items of an array or object; of null, and of others, there are none.
void each(Json* list, FunctionRef<void(Json&)> visit);
/// Calls visit(primitive) on those of all meshes.
void eachPrimitive(Json& document, FunctionRef<void(Json&)> visit);

} // namespace halflight
