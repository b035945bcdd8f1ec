#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace halflight {

/// 0, 1, … count - 1: all texels or probes.
std::vector<uint32_t> allIndices(std::size_t count);

} // namespace halflight
