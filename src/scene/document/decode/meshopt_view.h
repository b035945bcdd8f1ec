#pragma once
// A buffer view that was compressed with meshoptimizer (EXT_meshopt_compression, KHR_meshopt_compression). The only
// code that includes the library.

#include "halflight/base/result.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace halflight {

struct MeshoptView {
    enum class Mode { Attributes, Triangles, Indices };
    enum class Filter { None, Octahedral, Quaternion, Exponential };

    /// Whether this build was made with the library.
    static bool isSupported();

    Mode mode = Mode::Attributes;
    Filter filter = Filter::None;
    uint64_t count = 0;       ///< elements
    uint64_t strideBytes = 0; ///< of an element

    [[nodiscard]] uint64_t decodedBytes() const { return count * strideBytes; }
    /// Whether the numbers keep the extension's rules, and `byteCount` bytes can hold so many elements. To be asked
    /// before memory is taken for them.
    [[nodiscard]] Status check(uint64_t byteCount) const;
    /// Decodes to decodedBytes() bytes. Errors have no glTF path.
    [[nodiscard]] Result<std::vector<std::byte>> decode(std::span<const std::byte> bytes) const;
};

} // namespace halflight
