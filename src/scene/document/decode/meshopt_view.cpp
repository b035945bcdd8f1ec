#include "scene/document/decode/meshopt_view.h"

#include <string>

#if HALFLIGHT_MESHOPT
#include <meshoptimizer.h>
#endif

namespace halflight {

Status MeshoptView::check(uint64_t byteCount) const
{
    const auto broken = [](const char* reason) { return Error{ErrorCode::FileInvalid, reason}; };
    if (mode == Mode::Attributes) {
        if (strideBytes == 0 || strideBytes % 4 != 0 || strideBytes > 256)
            return broken("byteStride of compressed attributes is not a multiple of 4 up to 256");
        if (filter == Filter::Octahedral && strideBytes != 4 && strideBytes != 8)
            return broken("byteStride is not 4 or 8, as the filter OCTAHEDRAL wants");
        if (filter == Filter::Quaternion && strideBytes != 8)
            return broken("byteStride is not 8, as the filter QUATERNION wants");
    } else {
        if (strideBytes != 2 && strideBytes != 4) return broken("byteStride of compressed indices is not 2 or 4");
        if (filter != Filter::None) return broken("a filter applies to attributes only");
        if (mode == Mode::Triangles && count % 3 != 0) return broken("count is not a multiple of 3");
    }
    if (count == 0) return broken("count is 0");
    // At best 4 columns of 256 vertices take one byte (version 1; 64:1 in version 0), a triangle's indices one byte, an
    // index of a sequence one byte.
    const uint64_t mostElements = mode == Mode::Attributes  ? byteCount * 1024 / strideBytes
                                  : mode == Mode::Triangles ? byteCount * 3
                                                            : byteCount;
    if (count > mostElements) {
        return Error{ErrorCode::FileInvalid, std::to_string(byteCount) + " bytes of meshopt data cannot hold " +
                                                 std::to_string(count) + " elements"};
    }
    return {};
}

#if HALFLIGHT_MESHOPT

bool MeshoptView::isSupported()
{
    return true;
}

Result<std::vector<std::byte>> MeshoptView::decode(std::span<const std::byte> bytes) const
{
    if (Status s = check(bytes.size()); !s) return s.error();
    // The first byte: the kind of stream, and its version in the lower half. Debian 12's library reads vertex version
    // 0; 1 came with meshoptimizer 0.23.
    const auto head = unsigned(bytes[0]);
    const unsigned kind = mode == Mode::Attributes ? 0xa0 : mode == Mode::Triangles ? 0xe0 : 0xd0;
    const unsigned newest = mode == Mode::Attributes ? (MESHOPTIMIZER_VERSION >= 230 ? 1 : 0) : 1;
    if ((head & 0xf0) != kind)
        return Error{ErrorCode::FileInvalid, "the meshopt data is damaged (it is of another mode)"};
    if ((head & 0x0f) > newest) {
        return Error{ErrorCode::Unsupported, "the meshopt data has version " + std::to_string(head & 0x0f) +
                                                 ", newer than this build's meshoptimizer reads"};
    }
    std::vector<std::byte> decoded(decodedBytes());
    const auto* source = reinterpret_cast<const unsigned char*>(bytes.data());
    const int status = mode == Mode::Attributes
                           ? meshopt_decodeVertexBuffer(decoded.data(), count, strideBytes, source, bytes.size())
                       : mode == Mode::Triangles
                           ? meshopt_decodeIndexBuffer(decoded.data(), count, strideBytes, source, bytes.size())
                           : meshopt_decodeIndexSequence(decoded.data(), count, strideBytes, source, bytes.size());
    if (status != 0) return Error{ErrorCode::FileInvalid, "the meshopt data is damaged"};
    if (filter == Filter::Octahedral) meshopt_decodeFilterOct(decoded.data(), count, strideBytes);
    if (filter == Filter::Quaternion) meshopt_decodeFilterQuat(decoded.data(), count, strideBytes);
    if (filter == Filter::Exponential) meshopt_decodeFilterExp(decoded.data(), count, strideBytes);
    return decoded;
}

#else // without the library

bool MeshoptView::isSupported()
{
    return false;
}

Result<std::vector<std::byte>> MeshoptView::decode(std::span<const std::byte>) const
{
    return Error{ErrorCode::Unsupported, "this build has no meshoptimizer library"};
}

#endif

} // namespace halflight
