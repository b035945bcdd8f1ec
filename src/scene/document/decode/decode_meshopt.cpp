#include "scene/document/decode/decode_meshopt.h"

#include "scene/document/decode/compression.h"
#include "scene/document/decode/meshopt_view.h"
#include "scene/document/erase_extension.h"
#include "scene/document/fallback_buffers.h"

namespace halflight {
namespace {

/// What the extension says of its data.
Result<MeshoptView> describe(const Json& extension, const std::string& path)
{
    const auto stride = integerMember(extension, "byteStride", path);
    if (!stride) return stride.error();
    const auto count = integerMember(extension, "count", path);
    if (!count) return count.error();
    MeshoptView encoded;
    encoded.count = *count;
    encoded.strideBytes = *stride;
    const Json& mode = member(extension, "mode");
    const Json& filter = member(extension, "filter");
    if (mode == "TRIANGLES") {
        encoded.mode = MeshoptView::Mode::Triangles;
    } else if (mode == "INDICES") {
        encoded.mode = MeshoptView::Mode::Indices;
    } else if (mode != "ATTRIBUTES") {
        return invalid(path, "mode is not ATTRIBUTES, TRIANGLES or INDICES");
    }
    if (filter == "OCTAHEDRAL") {
        encoded.filter = MeshoptView::Filter::Octahedral;
    } else if (filter == "QUATERNION") {
        encoded.filter = MeshoptView::Filter::Quaternion;
    } else if (filter == "EXPONENTIAL") {
        encoded.filter = MeshoptView::Filter::Exponential;
    } else if (!filter.is_null() && filter != "NONE") {
        return Error{ErrorCode::Unsupported, "its filter is not one this build's meshoptimizer decodes", path};
    }
    return encoded;
}

} // namespace

Status decodeMeshoptView(DecodedBuffer& buffer, Json& view, const char* name, const std::string& path)
{
    const Json extension = view["extensions"][name];
    if (!MeshoptView::isSupported()) { // the fallback's data serves, if there is any
        if (isFallbackBuffer(element(buffer.json(), "buffers", view["buffer"].get<int>())))
            return Error{ErrorCode::Unsupported, std::string("is compressed") + conversionHint(name), path};
        eraseExtension(view, name);
        return {};
    }
    const auto bytes = buffer.bytesOf(extension, path);
    if (!bytes) return bytes.error();
    auto described = describe(extension, path);
    if (!described) return described.error();
    const MeshoptView& encoded = *described;
    if (Status s = encoded.check(bytes->size()); !s) return Error{s.error().code, s.error().message, path};
    if (Status s = buffer.hasRoomFor(encoded.decodedBytes(), path); !s) return s;
    const auto decoded = encoded.decode(*bytes);
    if (!decoded) {
        const bool newer = decoded.error().code == ErrorCode::Unsupported;
        return Error{decoded.error().code, decoded.error().message + (newer ? conversionHint(name) : ""), path};
    }
    view["buffer"] = buffer.index();
    view["byteOffset"] = buffer.append(*decoded);
    view["byteLength"] = decoded->size();
    eraseExtension(view, name);
    return {};
}

} // namespace halflight
