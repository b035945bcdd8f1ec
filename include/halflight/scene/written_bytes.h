#pragma once

#include <cstdint>
#include <vector>

namespace halflight {

/// How a file holds the texels of lightmaps. Rgb9e5, Half: KTX2 of RGB9E5 or of half floats. Webp: 8 bits a channel by
/// a curve (LightmapCurve) in lossless WebP.
enum class LightmapFormat { Rgb9e5, Half, Webp };
/// "rgb9e5", "half", "webp".
const char* nameOf(LightmapFormat format);

/// One page as it was written. Errors are of each texel's channel that errs most, relative to the texel's brightest, or
/// to 1/4096 of the page's brightest where that is more.
struct WrittenLightmap {
    uint64_t bytes = 0;
    double meanError = 0.0; ///< over texels that are not black
    double mostError = 0.0;
};

/// What the parts of a written file take, in bytes.
struct WrittenBytes {
    uint64_t lightmaps = 0; ///< all pages
    uint64_t lightmapDirections = 0;
    uint64_t shadowmasks = 0;
    uint64_t probes = 0;
    uint64_t sky = 0;             ///< its picture
    uint64_t reflections = 0;     ///< picture of the reflection probes
    std::vector<uint64_t> groups; ///< of each light group: pages, directions and probes
    uint64_t file = 0;            ///< all of it, the scene's own data included
    LightmapFormat lightmapFormat = LightmapFormat::Rgb9e5;
    std::vector<WrittenLightmap> lightmapPages;
};

} // namespace halflight
