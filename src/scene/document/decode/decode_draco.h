#pragma once
// Primitives that were compressed with Draco, made plain.

#include "scene/document/decode/decoded_buffer.h"
#include "scene/document/decode/draco_mesh.h"

#include <map>
#include <tuple>

namespace halflight {

/// Primitives that name the same data share what it decodes to.
class DracoDecoder {
public:
    explicit DracoDecoder(DecodedBuffer& buffer) : buffer_(buffer) {}

    /// Decodes a primitive that has the extension. A build without Draco leaves it as it is: its accessors hold the
    /// data then.
    Status decode(Json& primitive, const std::string& primitivePath);

private:
    Result<const DracoMesh*> meshOf(uint64_t viewIndex, const std::string& path);
    /// The accessor that holds the decoded attribute: the one that the primitive names where it has no data yet, else a
    /// new one.
    Result<std::size_t> attribute(const DracoMesh& mesh, uint64_t view, uint64_t id, const Json& reference,
                                  const std::string& path);
    Status indices(const DracoMesh& mesh, uint64_t view, Json& primitive, const std::string& path);

    DecodedBuffer& buffer_;
    std::map<uint64_t, DracoMesh> meshes_;                                      ///< by buffer view
    std::map<std::tuple<uint64_t, uint64_t, std::size_t>, std::size_t> placed_; ///< view, attribute, accessor
};

} // namespace halflight
