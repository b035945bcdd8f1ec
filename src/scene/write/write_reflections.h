#pragma once
// The reflection probes of a baked file.

#include "halflight/scene/baked_scene.h"
#include "scene/write/write_pictures.h"

namespace halflight {

/// `reflectionProbes` of the root extension, or `reflections` of a light group; `picture` refers to their picture.
Json reflectionsJson(const ReflectionSet& set, Json picture);

/// A transform's 16 numbers, column by column.
Json numbersOf(const mat4& matrix);

} // namespace halflight
