#pragma once
// The sky of a baked file.

#include "scene/document/document.h"
#include "scene/write/write_pictures.h"

namespace halflight {

struct WrittenSky {
    Json record; ///< of the root extension
    Json atBake; ///< colours, and a hash of the picture as a file has it
    uint64_t bytes = 0;
};
/// Adds the sky's picture to `pictures`, at most `width` texels a row.
Result<WrittenSky> writeSky(PictureWriter& pictures, const Sky& sky, int width);

} // namespace halflight
