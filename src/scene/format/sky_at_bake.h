#pragma once
// What a baked file keeps of the sky that it was baked with: colours, and a hash of the picture.

#include "halflight/scene/scene.h"
#include "scene/document/document.h"

namespace halflight {

/// Hash of a picture as a file holds it, in hexadecimal.
std::string pictureHash(const ImageRgb32f& picture, float rotationRadians);

/// Whether the sky of a file differs from the record. What the record does not hold does not count.
bool skyDiffersFrom(const Sky& skyOfFile, const Json& atBake);

} // namespace halflight
