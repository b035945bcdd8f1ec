#pragma once
// Smaller files for the web, the bake kept: geometry quantized and compressed with meshoptimizer, textures as WebP, the
// bake's masks as lossless WebP, lightmap texels with fewer bits.

#include "halflight/base/result.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace halflight {

struct OptimizeOptions {
    bool geometry = true;    ///< EXT_meshopt_compression
    int textureQuality = 85; ///< of lossy WebP, 1…100; 0 leaves textures as they are
    /// Webp: 8 bits a channel by a curve, lossless. Rgb9e5: KTX2 as the bake wrote it, with mantissas of
    /// `lightmapBits`.
    enum class LightmapFormat { Webp, Rgb9e5 };
    LightmapFormat lightmapFormat = LightmapFormat::Webp;
    int lightmapBits = 7;             ///< 4…9; 9 leaves texels as they are
    std::function<bool()> mayReplace; ///< as WriteOptions::mayReplace
    /// Called with the files that the document names, when they are read; an error ends the run. Empty = no check.
    std::function<Status(const std::vector<std::filesystem::path>& externalFiles)> checkFiles;
};

struct OptimizeReport {
    struct Part {
        uint64_t before = 0; ///< bytes
        uint64_t after = 0;
    };
    Part file, geometry, textures, lightmaps, masks, probes;
    /// Of the channel that errs most, in texels that are not black, relative to the texel's brightest channel or to
    /// 1/4096 of the page's brightest.
    double lightmapError = 0.0; ///< mean
    double lightmapErrorMost = 0.0;
    std::vector<std::string> warnings;
};

/// Whether this build has the libraries: meshoptimizer and libwebp.
bool canOptimizeGeometry();
bool canOptimizeTextures();

/// Reads a glTF file, baked or not, and writes it smaller as one GLB. Textures that get no smaller stay as they are,
/// and so do data that only unknown extensions refer to. Errors: as readScene(); Unsupported for bakes of an old
/// version.
Status optimizeFile(const std::filesystem::path& in, const std::filesystem::path& out, const OptimizeOptions& options,
                    OptimizeReport& report);

} // namespace halflight
