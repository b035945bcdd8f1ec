#pragma once
// A primitive that was compressed with Draco (KHR_draco_mesh_compression). The only code that includes the library.

#include "halflight/base/result.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace halflight {

class DracoMesh {
public:
    /// Whether this build was made with the library.
    static bool isSupported();

    /// Decodes a mesh. Data that claims more than `limitBytes` of decoded indices or attributes is refused before
    /// memory is taken for them. Errors have no glTF path.
    static Result<DracoMesh> decode(std::span<const std::byte> bytes, uint64_t limitBytes);

    [[nodiscard]] uint64_t pointCount() const;
    /// 3 per triangle, each below pointCount().
    [[nodiscard]] const std::vector<uint32_t>& indices() const { return indices_; }

    /// All points' values of the attribute with this unique id, one every `strideBytes`: `components` (1 to 4) values
    /// of glTF's `componentType` each, little-endian. Gaps are zero.
    [[nodiscard]] Result<std::vector<std::byte>> attribute(uint64_t uniqueId, int componentType, int components,
                                                           std::size_t strideBytes) const;

private:
    struct Decoded;
    std::shared_ptr<const Decoded> decoded_;
    std::vector<uint32_t> indices_;
};

} // namespace halflight
