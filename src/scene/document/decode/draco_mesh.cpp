#include "scene/document/decode/draco_mesh.h"

#include "scene/document/enumerators.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <type_traits>

#if HALFLIGHT_DRACO
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/varint_decoding.h>
#endif

namespace halflight {

#if HALFLIGHT_DRACO

struct DracoMesh::Decoded {
    draco::Mesh mesh;
};

namespace {

Error damaged(const std::string& reason)
{
    return Error{ErrorCode::FileInvalid, "the Draco data is damaged (" + reason + ")"};
}

// Draco's decoders check little before they allocate. This one compares what the data claims with a limit first: the
// counts of its connectivity, then the attributes, once their number and types are known.
template<typename Base> class LimitedDecoder : public Base {
public:
    explicit LimitedDecoder(uint64_t limitBytes) : limitBytes_(limitBytes) {}

    [[nodiscard]] bool claimsTooMuch() const { return claimsTooMuch_; }

protected:
    bool DecodeConnectivity() override
    {
        // Bitstream 2.2: edgebreaker data begins with the numbers of vertices and faces, sequential data with those of
        // faces and points.
        draco::DecoderBuffer ahead = *this->buffer();
        uint32_t first = 0;
        uint32_t second = 0;
        if (!draco::DecodeVarint(&first, &ahead) || !draco::DecodeVarint(&second, &ahead)) return false;
        const uint64_t faces = std::is_same_v<Base, draco::MeshSequentialDecoder> ? first : second;
        const uint64_t points = std::is_same_v<Base, draco::MeshSequentialDecoder> ? second : first;
        constexpr uint64_t kBytesPerFace = 3 * sizeof(uint32_t);
        claimsTooMuch_ = faces * kBytesPerFace > limitBytes_ || points * sizeof(uint32_t) > limitBytes_;
        return !claimsTooMuch_ && Base::DecodeConnectivity();
    }

    bool DecodeAllAttributes() override
    {
        const draco::PointCloud& points = *this->point_cloud();
        uint64_t bytesPerPoint = 0;
        for (int i = 0; i < points.num_attributes(); ++i) bytesPerPoint += uint64_t(points.attribute(i)->byte_stride());
        claimsTooMuch_ = bytesPerPoint * points.num_points() > limitBytes_;
        return !claimsTooMuch_ && Base::DecodeAllAttributes();
    }

private:
    uint64_t limitBytes_;
    bool claimsTooMuch_ = false;
};

template<typename Base> Status decodeWith(std::span<const std::byte> bytes, uint64_t limitBytes, draco::Mesh& mesh)
{
    LimitedDecoder<Base> decoder(limitBytes);
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const draco::DecoderOptions options;
    const draco::Status status = decoder.Decode(options, &buffer, &mesh);
    if (decoder.claimsTooMuch()) {
        return Error{ErrorCode::FileInvalid, std::to_string(bytes.size()) +
                                                 " bytes of Draco data claim more geometry than the limit of " +
                                                 std::to_string(limitBytes) + " bytes"};
    }
    return status.ok() ? Status() : Status(damaged(status.error_msg_string()));
}

Status decodeMesh(std::span<const std::byte> bytes, uint64_t limitBytes, draco::Mesh& mesh)
{
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    draco::DracoHeader header;
    if (!draco::PointCloudDecoder::DecodeHeader(&buffer, &header).ok()) return damaged("it has no Draco header");
    if (header.encoder_type != draco::TRIANGULAR_MESH) return damaged("it is not a triangle mesh");
    if (header.version_major != 2 || header.version_minor != 2) {
        return Error{ErrorCode::Unsupported, "the Draco data has bitstream version " +
                                                 std::to_string(header.version_major) + "." +
                                                 std::to_string(header.version_minor) + ", not 2.2 as glTF wants"};
    }
    switch (header.encoder_method) {
    case draco::MESH_EDGEBREAKER_ENCODING:
        return decodeWith<draco::MeshEdgebreakerDecoder>(bytes, limitBytes, mesh);
    case draco::MESH_SEQUENTIAL_ENCODING:
        return decodeWith<draco::MeshSequentialDecoder>(bytes, limitBytes, mesh);
    default:
        return damaged("its encoding method is unknown");
    }
}

template<typename T> bool convertAll(const draco::PointAttribute& attribute, uint32_t pointCount, int components,
                                     std::size_t strideBytes, std::vector<std::byte>& bytes)
{
    T values[4] = {};
    for (uint32_t p = 0; p < pointCount; ++p) {
        const draco::AttributeValueIndex value = attribute.mapped_index(draco::PointIndex(p));
        if (value.value() >= attribute.size()) return false;
        if (!attribute.ConvertValue<T>(value, int8_t(components), values)) return false;
        std::memcpy(bytes.data() + p * strideBytes, values, sizeof(T) * std::size_t(components));
    }
    return true;
}

} // namespace

bool DracoMesh::isSupported()
{
    return true;
}

Result<DracoMesh> DracoMesh::decode(std::span<const std::byte> bytes, uint64_t limitBytes)
{
    auto decoded = std::make_shared<Decoded>();
    try {
        if (Status s = decodeMesh(bytes, limitBytes, decoded->mesh); !s) return s.error();
    } catch (const std::exception& e) { // out of memory
        return damaged(e.what());
    }
    DracoMesh result;
    const draco::Mesh& mesh = decoded->mesh;
    result.indices_.reserve(std::size_t(mesh.num_faces()) * 3);
    for (uint32_t f = 0; f < mesh.num_faces(); ++f) {
        for (const draco::PointIndex& point : mesh.face(draco::FaceIndex(f))) {
            if (point.value() >= mesh.num_points()) return damaged("a face has a point that does not exist");
            result.indices_.push_back(point.value());
        }
    }
    result.decoded_ = std::move(decoded);
    return result;
}

uint64_t DracoMesh::pointCount() const
{
    return decoded_->mesh.num_points();
}

Result<std::vector<std::byte>> DracoMesh::attribute(uint64_t uniqueId, int componentType, int components,
                                                    std::size_t strideBytes) const
{
    const draco::Mesh& mesh = decoded_->mesh;
    const draco::PointAttribute* attribute =
        uniqueId <= 0xffffffffu ? mesh.GetAttributeByUniqueId(uint32_t(uniqueId)) : nullptr;
    if (attribute == nullptr) return damaged("it has no attribute " + std::to_string(uniqueId));
    std::vector<std::byte> bytes(mesh.num_points() * strideBytes);
    const auto convert = [&]<typename T>(T) {
        return convertAll<T>(*attribute, mesh.num_points(), components, strideBytes, bytes);
    };
    bool good = false;
    switch (componentType) {
    case gltf::kByte:
        good = convert(int8_t{});
        break;
    case gltf::kUnsignedByte:
        good = convert(uint8_t{});
        break;
    case gltf::kShort:
        good = convert(int16_t{});
        break;
    case gltf::kUnsignedShort:
        good = convert(uint16_t{});
        break;
    case gltf::kUnsignedInt:
        good = convert(uint32_t{});
        break;
    case gltf::kFloat:
        good = convert(float{});
        break;
    default:
        break;
    }
    if (!good) return damaged("attribute " + std::to_string(uniqueId) + " does not fit its accessor's type");
    return bytes;
}

#else // without the library

struct DracoMesh::Decoded {};

bool DracoMesh::isSupported()
{
    return false;
}

Result<DracoMesh> DracoMesh::decode(std::span<const std::byte>, uint64_t)
{
    return Error{ErrorCode::Unsupported, "this build has no Draco library"};
}

uint64_t DracoMesh::pointCount() const
{
    return 0;
}

Result<std::vector<std::byte>> DracoMesh::attribute(uint64_t, int, int, std::size_t) const
{
    return Error{ErrorCode::Unsupported, "this build has no Draco library"};
}

#endif

} // namespace halflight
