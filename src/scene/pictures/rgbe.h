#pragma once
// Radiance pictures (.hdr): Ward 1991, "Real Pixels", with the run-length encoding of Radiance 2.0 and later.

#include "halflight/base/image.h"

#include <span>
#include <string>
#include <vector>

namespace halflight {

/// Reads a Radiance picture of at most `mostTexels`: RGBE, rows from the top, with either run-length encoding or none.
/// Its header's EXPOSURE and COLORCORR are factors that the values were multiplied by, and are taken out of them;
/// values may be infinite then. What of the header is not followed is added to `warnings`, where that is given.
Result<ImageRgb32f> decodeRgbe(std::span<const std::byte> bytes, int64_t mostTexels,
                               std::vector<std::string>* warnings = nullptr);

} // namespace halflight
