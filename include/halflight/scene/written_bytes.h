#pragma once

#include <cstdint>

namespace halflight {

/// What the parts of a written file take, in bytes.
struct WrittenBytes {
    uint64_t lightmaps = 0; ///< all pages
    uint64_t lightmapDirections = 0;
    uint64_t shadowmasks = 0;
    uint64_t probes = 0;
    uint64_t file = 0; ///< all of it, the scene's own data included
};

} // namespace halflight
