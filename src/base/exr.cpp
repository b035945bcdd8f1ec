#include "halflight/base/file.h"
#include "halflight/base/image.h"

#if HALFLIGHT_OPENEXR
#include <ImathBox.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#endif

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <exception>
#include <string>
#include <vector>

namespace halflight {

#if HALFLIGHT_OPENEXR

namespace {

constexpr const char* kChannelNames[] = {"R", "G", "B", "A"};

/// The library writes its last bytes when it closes a file, and says nothing where the disk is full then. So it writes
/// into memory.
class MemoryStream : public Imf::OStream {
public:
    MemoryStream() : Imf::OStream("memory") {}
    void write(const char bytes[], int count) override
    {
        if (bytes_.size() < at_ + std::size_t(count)) bytes_.resize(at_ + std::size_t(count));
        std::memcpy(&bytes_[at_], bytes, std::size_t(count));
        at_ += std::size_t(count);
    }
    uint64_t tellp() override { return at_; }
    void seekp(uint64_t at) override { at_ = std::size_t(at); }
    [[nodiscard]] const std::vector<char>& bytes() const { return bytes_; }

private:
    std::vector<char> bytes_;
    std::size_t at_ = 0;
};

/// Writes `channels` interleaved floats per texel.
Status writeExrChannels(const std::filesystem::path& path, const float* texels, ivec2 size, int channels)
{
    MemoryStream stream;
    try {
        Imf::Header header(size.x, size.y);
        header.compression() = Imf::ZIP_COMPRESSION;
        Imf::FrameBuffer buffer;
        const std::size_t xStride = sizeof(float) * std::size_t(channels);
        for (int c = 0; c < channels; ++c) {
            header.channels().insert(kChannelNames[c], Imf::Channel(Imf::FLOAT));
            char* base = reinterpret_cast<char*>(const_cast<float*>(texels + c));
            buffer.insert(kChannelNames[c], Imf::Slice(Imf::FLOAT, base, xStride, xStride * std::size_t(size.x)));
        }
        Imf::OutputFile file(stream, header);
        file.setFrameBuffer(buffer);
        file.writePixels(size.y);
    } catch (const std::exception& exception) {
        return Error{ErrorCode::WriteFailed, std::string("cannot be written (") + exception.what() + ")"};
    }
    return writeFileAtomically(path, stream.bytes().data(), stream.bytes().size());
}

} // namespace

Status writeExr(const std::filesystem::path& path, const ImageRgb32f& image)
{
    return writeExrChannels(path, &image.data()->x, image.size(), 3);
}

Status writeExr(const std::filesystem::path& path, const ImageRgba32f& image)
{
    return writeExrChannels(path, &image.data()->x, image.size(), 4);
}

Result<ImageRgba32f> readExr(const std::filesystem::path& path, int64_t mostTexels)
{
    try {
        Imf::InputFile file(path.string().c_str());
        const Imath::Box2i window = file.header().dataWindow();
        const int64_t width = int64_t(window.max.x) - window.min.x + 1;
        const int64_t height = int64_t(window.max.y) - window.min.y + 1;
        // A forged size is refused before it is allocated: no more texels than deflate's 1032:1 could have packed.
        constexpr int64_t kMaxSide = 1 << 20;
        const auto byteCount = int64_t(std::filesystem::file_size(path));
        if (width > kMaxSide || height > kMaxSide || width * height > std::max<int64_t>(1 << 24, byteCount * 1032)) {
            return Error{ErrorCode::FileInvalid, "image claims more texels than its bytes can hold"};
        }
        if (width * height > mostTexels)
            return Error{ErrorCode::FileInvalid, "has more than " + std::to_string(mostTexels) + " texels"};
        const Imf::ChannelList& channels = file.header().channels();
        if (std::none_of(kChannelNames, kChannelNames + 3,
                         [&](const char* name) { return channels.findChannel(name) != nullptr; }))
            return Error{ErrorCode::FileInvalid, "has no channel R, G or B"};
        const ivec2 size{int(width), int(height)};
        ImageRgba32f image(size.x, size.y, vec4(0, 0, 0, 1));
        Imf::FrameBuffer buffer;
        const std::size_t xStride = sizeof(vec4);
        const std::size_t yStride = xStride * std::size_t(size.x);
        for (int c = 0; c < 4; ++c) {
            char* base = reinterpret_cast<char*>(&image.data()->x + c) -
                         std::ptrdiff_t(window.min.x) * std::ptrdiff_t(xStride) -
                         std::ptrdiff_t(window.min.y) * std::ptrdiff_t(yStride);
            buffer.insert(kChannelNames[c], Imf::Slice(Imf::FLOAT, base, xStride, yStride, 1, 1, c == 3 ? 1.0 : 0.0));
        }
        file.setFrameBuffer(buffer);
        file.readPixels(window.min.y, window.max.y);
        return image;
    } catch (const std::exception& exception) {
        return Error{ErrorCode::FileInvalid, std::string("cannot be read as OpenEXR (") + exception.what() + ")"};
    }
}

#else

namespace {

Error noExr(ErrorCode code)
{
    return {code, "is OpenEXR, which this build of Halflight is without"};
}

} // namespace

Status writeExr(const std::filesystem::path&, const ImageRgb32f&)
{
    return noExr(ErrorCode::WriteFailed);
}

Status writeExr(const std::filesystem::path&, const ImageRgba32f&)
{
    return noExr(ErrorCode::WriteFailed);
}

Result<ImageRgba32f> readExr(const std::filesystem::path&, int64_t)
{
    return noExr(ErrorCode::Unsupported);
}

#endif

} // namespace halflight
