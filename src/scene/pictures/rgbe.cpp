#include "scene/pictures/rgbe.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <glm/gtc/packing.hpp>
#include <locale>
#include <sstream>
#include <string>

namespace halflight {

namespace {

using Rgbe = std::array<uint8_t, 4>;

vec3 colorOf(const Rgbe& texel)
{
    if (texel[3] == 0) return vec3(0.0f);
    return vec3(texel[0], texel[1], texel[2]) * std::ldexp(1.0f, int(texel[3]) - 136);
}

class RgbeReader {
public:
    RgbeReader(std::span<const std::byte> bytes, int64_t mostTexels, std::vector<std::string>* warnings)
        : bytes_(bytes), mostTexels_(mostTexels), warnings_(warnings)
    {}

    Result<ImageRgb32f> read()
    {
        if (Status s = readHeader(); !s) return s.error();
        ImageRgb32f image(size_.x, size_.y);
        std::vector<Rgbe> row(std::size_t(size_.x));
        for (int y = 0; y < size_.y; ++y) {
            if (!(startsWithRuns() ? readRuns(row) : readTexels(row)))
                return Error{ErrorCode::FileInvalid, "ends before its last texel, or has a run that is too long"};
            for (int x = 0; x < size_.x; ++x) image(x, y) = vec3(glm::dvec3(colorOf(row[std::size_t(x)])) / factor_);
        }
        return image;
    }

private:
    std::string line()
    {
        std::string text;
        while (!bytes_.empty() && bytes_[0] != std::byte('\n')) text += char(take());
        if (!bytes_.empty()) take();
        return text;
    }
    uint8_t take()
    {
        const auto byte = uint8_t(bytes_[0]);
        bytes_ = bytes_.subspan(1);
        return byte;
    }

    Status readHeader()
    {
        const std::size_t byteCount = bytes_.size();
        const bool isRadiance = byteCount > 2 && bytes_[0] == std::byte('#') && bytes_[1] == std::byte('?');
        if (!isRadiance) return Error{ErrorCode::FileInvalid, "is neither a Radiance picture (.hdr) nor OpenEXR"};
        bool isRgbe = true; // where no line says otherwise
        for (std::string text = line(); !text.empty() && !bytes_.empty(); text = line()) {
            if (text.starts_with("FORMAT=")) isRgbe = text.starts_with("FORMAT=32-bit_rle_rgbe");
            readFactor(text);
        }
        if (!isRgbe) return Error{ErrorCode::Unsupported, "holds other colours than RGB"};
        const std::string text = line();
        if (std::sscanf(text.c_str(), "-Y %9d +X %9d", &size_.y, &size_.x) != 2 || size_.x < 1 || size_.y < 1)
            return Error{ErrorCode::Unsupported, "does not have its rows from the top and its columns from the left"};
        const int64_t texels = int64_t(size_.x) * size_.y;
        if (texels > mostTexels_)
            return Error{ErrorCode::FileInvalid, "has more than " + std::to_string(mostTexels_) + " texels"};
        // Long runs pack no better than deflate does; small pictures need no proof.
        if (texels > std::max<int64_t>(1 << 24, int64_t(byteCount) * 1032))
            return Error{ErrorCode::FileInvalid, "claims more texels than its bytes can hold"};
        return {};
    }

    static bool isNearSrgb(const std::string& primaries)
    {
        constexpr std::array<double, 6> kSrgb = {0.64, 0.33, 0.30, 0.60, 0.15, 0.06}; // Radiance's own: green at 0.29
        constexpr double kNear = 0.02;
        std::istringstream numbers(primaries.substr(primaries.find('=') + 1));
        numbers.imbue(std::locale::classic());
        return std::all_of(kSrgb.begin(), kSrgb.end(), [&](double expected) {
            double read = 0.0;
            return bool(numbers >> read) && std::abs(read - expected) <= kNear;
        });
    }
    // Lines of either kind count together (Radiance 5.3, "Radiance File Formats"): values are radiance times all of
    // them.
    void readFactor(const std::string& text)
    {
        const bool isExposure = text.starts_with("EXPOSURE=");
        if (!isExposure && !text.starts_with("COLORCORR=")) {
            if (text.starts_with("PRIMARIES=") && !isNearSrgb(text))
                warn("its PRIMARIES are not followed: its colours are read as sRGB's");
            return;
        }
        std::istringstream numbers(text.substr(text.find('=') + 1));
        numbers.imbue(std::locale::classic());
        glm::dvec3 factor(0.0);
        numbers >> factor.x;
        factor.y = factor.z = factor.x;
        if (!isExposure) numbers >> factor.y >> factor.z;
        const bool good = !numbers.fail() && factor.x > 0.0 && factor.y > 0.0 && factor.z > 0.0;
        const glm::dvec3 product = factor_ * factor;
        if (good && std::isfinite(product.x + product.y + product.z) && product.x * product.y * product.z > 0.0) {
            factor_ = product;
        } else {
            warn(isExposure ? "an EXPOSURE that is not a number above 0 is not followed"
                            : "a COLORCORR that is not three numbers above 0 is not followed");
        }
    }
    void warn(const char* text)
    {
        if (warnings_ != nullptr) warnings_->emplace_back(text);
    }

    [[nodiscard]] bool startsWithRuns() const
    {
        return size_.x >= 8 && size_.x < 32768 && bytes_.size() >= 4 && bytes_[0] == std::byte(2) &&
               bytes_[1] == std::byte(2) && int(bytes_[2]) * 256 + int(bytes_[3]) == size_.x;
    }
    /// Channel after channel.
    bool readRuns(std::vector<Rgbe>& row)
    {
        bytes_ = bytes_.subspan(4);
        for (std::size_t c = 0; c < 4; ++c) {
            for (std::size_t x = 0; x < row.size();) {
                if (bytes_.empty()) return false;
                std::size_t count = take();
                const bool isRun = count > 128;
                if (isRun) count -= 128;
                if (count == 0 || count > row.size() - x || bytes_.size() < (isRun ? 1 : count)) return false;
                const uint8_t value = isRun ? take() : uint8_t(0);
                for (; count > 0; --count) row[x++][c] = isRun ? value : take();
            }
        }
        return true;
    }
    /// Texel after texel. Mantissas of 1 repeat the texel before, as older programs wrote it.
    bool readTexels(std::vector<Rgbe>& row)
    {
        int shift = 0;
        for (std::size_t x = 0; x < row.size();) {
            if (bytes_.size() < 4) return false;
            Rgbe texel;
            for (uint8_t& byte : texel) byte = take();
            if (texel[0] != 1 || texel[1] != 1 || texel[2] != 1) {
                row[x++] = texel;
                shift = 0;
                continue;
            }
            const std::size_t count = std::size_t(texel[3]) << shift;
            if (x == 0 || shift > 16 || count > row.size() - x) return false;
            std::fill_n(row.begin() + std::ptrdiff_t(x), count, row[x - 1]);
            x += count;
            shift += 8;
        }
        return true;
    }

    std::span<const std::byte> bytes_;
    int64_t mostTexels_;
    std::vector<std::string>* warnings_;
    ivec2 size_{0};
    glm::dvec3 factor_{1.0}; // that radiance was multiplied by
};

} // namespace

Result<ImageRgb32f> decodeRgbe(std::span<const std::byte> bytes, int64_t mostTexels, std::vector<std::string>* warnings)
{
    return RgbeReader(bytes, mostTexels, warnings).read();
}

} // namespace halflight
