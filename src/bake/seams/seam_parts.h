#pragma once
// The least squares of seam stitching, divided into parts that do not depend on one another.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace halflight {

/// A term of the least squares: the difference of both sides' bilinear values at a seam sample.
struct SeamTerm {
    std::array<uint32_t, 8> unknown{};
    std::array<double, 8> weight{};
};

/// Parts of the problem without a common unknown. Each is factored on its own.
struct SeamParts {
    struct Part {
        std::vector<uint32_t> unknowns;
        std::vector<uint32_t> terms;
    };
    std::vector<Part> parts;
    std::vector<uint32_t> placeOf; ///< by unknown: its place among those of its part
};

/// Networks of seams (terms connected by common unknowns) in the order of their first unknowns, small ones together.
SeamParts partsOf(std::span<const SeamTerm> terms, std::size_t unknowns);

} // namespace halflight
