#pragma once
#include "scene/document/document.h"

namespace halflight {

/// Whether a texture of the material, those of extensions included, reads TEXCOORD_n.
bool readsTexCoord(const Json& material, int n);

} // namespace halflight
