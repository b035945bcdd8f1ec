#pragma once
// The reflection probes of a baked file.

#include "halflight/scene/baked_scene.h"
#include "scene/write_pictures.h"

namespace halflight {

/// `reflectionProbes` of the root extension, its picture added to `pictures`; null without probes. `bytes`: of the
/// picture.
Result<Json> writeReflections(PictureWriter& pictures, const ReflectionSet& set, uint64_t& bytes);

/// A transform's 16 numbers, column by column.
Json numbersOf(const mat4& matrix);

} // namespace halflight
