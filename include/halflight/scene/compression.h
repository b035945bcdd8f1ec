#pragma once

#include <string>
#include <vector>

namespace halflight {

/// The extensions of compressed geometry and images that this build reads, by name; which ones depends on the libraries
/// it was made with (libdraco, meshoptimizer, libwebp).
std::vector<std::string> readableCompression();

} // namespace halflight
