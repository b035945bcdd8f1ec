#include "halflight/scene/sky_picture.h"

#include "halflight/base/file.h"
#include "halflight/base/mathematics.h"
#include "halflight/base/parallel.h"
#include "halflight/scene/scene.h"
#include "scene/pictures/rgbe.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace halflight {

namespace {

// What a texel of a reduced picture covers along one axis: texels of the picture, and their weights.
struct Span {
    int first = 0;
    std::vector<double> weights; // sum 1
};

template<typename Weight> std::vector<Span> spansOf(int from, int to, const Weight& weight)
{
    std::vector<Span> spans(static_cast<std::size_t>(to));
    for (int i = 0; i < to; ++i) {
        Span& span = spans[std::size_t(i)];
        const double low = double(i) * from / to;
        const double high = double(i + 1) * from / to;
        span.first = int(low);
        double sum = 0.0;
        for (int k = span.first; k < from && double(k) < high; ++k) {
            span.weights.push_back(weight(std::max(low, double(k)) / from, std::min(high, double(k + 1)) / from));
            sum += span.weights.back();
        }
        for (double& w : span.weights) w /= sum;
    }
    return spans;
}

// Negative values come from filters that overshoot and from colour transforms, infinities from half floats that
// overflowed, and not-a-number from a division of them. One of them must not keep a picture from being used.
void clampValues(ImageRgb32f& picture, std::vector<std::string>& warnings)
{
    constexpr float kLargestHalf = 65504.0f;
    float brightest = kLargestHalf;
    for (const vec3& texel : picture.texels()) {
        for (int c = 0; c < 3; ++c) {
            if (std::isfinite(texel[c])) brightest = std::max(brightest, texel[c]);
        }
    }
    std::size_t negative = 0;
    std::size_t infinite = 0;
    std::size_t notNumbers = 0;
    for (vec3& texel : picture.texels()) {
        negative += texel.x < 0.0f || texel.y < 0.0f || texel.z < 0.0f;
        infinite += texel.x == kInfinity || texel.y == kInfinity || texel.z == kInfinity;
        notNumbers += std::isnan(texel.x) || std::isnan(texel.y) || std::isnan(texel.z);
        for (int c = 0; c < 3; ++c) texel[c] = texel[c] > 0.0f ? std::min(texel[c], brightest) : 0.0f;
    }
    const auto warn = [&](std::size_t count, const std::string& what) {
        if (count > 0)
            warnings.push_back(std::to_string(count) + (count == 1 ? " texel has " : " texels have ") + what);
    };
    warn(negative, "a negative value, which is read as 0");
    warn(notNumbers, "a value that is not a number, which is read as 0");
    warn(infinite, "an infinite value, which is read as the brightest finite one, or as 65504 where all are darker");
}

Result<ImageRgb32f> readAsFloats(const std::filesystem::path& path, std::vector<std::string>& warnings)
{
    constexpr std::array<unsigned char, 4> kExrMagic = {0x76, 0x2f, 0x31, 0x01};
    const auto start = readFile(path, kExrMagic.size());
    if (!start) return start.error();
    const bool isExr = std::equal(start->begin(), start->end(), kExrMagic.begin(), kExrMagic.end(),
                                  [](std::byte a, unsigned char b) { return a == std::byte(b); });
    if (!isExr) {
        const auto bytes = readFile(path);
        if (!bytes) return bytes.error();
        return decodeRgbe(*bytes, kMostSkyPictureTexels, &warnings);
    }
    const auto image = readExr(path, kMostSkyPictureTexels);
    if (!image) return image.error();
    ImageRgb32f picture(image->width(), image->height());
    std::copy(image->texels().begin(), image->texels().end(), picture.texels().begin());
    return picture;
}

} // namespace

double skyShareBetween(double v0, double v1)
{
    return 0.5 * (math::cos(v0 * double(kPi)) - math::cos(v1 * double(kPi)));
}

Result<ImageRgb32f> readSkyPicture(const std::filesystem::path& path, std::vector<std::string>* warnings)
{
    const std::string name = "sky picture " + path.string() + ": ";
    std::vector<std::string> found;
    Result<ImageRgb32f> picture = readAsFloats(path, found);
    if (!picture) return Error{picture.error().code, name + picture.error().message, ""};
    if (picture->empty()) return Error{ErrorCode::FileInvalid, name + "has no texels", ""};
    clampValues(*picture, found);
    for (const std::string& warning : found) {
        if (warnings != nullptr) warnings->push_back(name + warning);
    }
    return picture->width() > kMostSkyTexels ? reducedSkyPicture(*picture, kMostSkyTexels) : std::move(*picture);
}

ImageRgb32f reducedSkyPicture(const ImageRgb32f& picture, int width)
{
    if (picture.width() <= width) return picture;
    const int height =
        std::max(1, int(std::lround(double(picture.height()) * double(width) / double(picture.width()))));
    return reducedSkyPicture(picture, ivec2(width, height));
}

ImageRgb32f reducedSkyPicture(const ImageRgb32f& picture, ivec2 size)
{
    const std::vector<Span> columns = spansOf(picture.width(), size.x, [](double a, double b) { return b - a; });
    const std::vector<Span> rows = spansOf(picture.height(), size.y, skyShareBetween);
    ImageRgb32f reduced(size.x, size.y);
    parallelFor(std::size_t(size.y), 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t y = begin; y < end; ++y) {
            for (int x = 0; x < size.x; ++x) {
                const Span& across = columns[std::size_t(x)];
                glm::dvec3 sum(0.0);
                for (std::size_t j = 0; j < rows[y].weights.size(); ++j) {
                    for (std::size_t i = 0; i < across.weights.size(); ++i)
                        sum += rows[y].weights[j] * across.weights[i] *
                               glm::dvec3(picture(across.first + int(i), rows[y].first + int(j)));
                }
                reduced(x, int(y)) = vec3(sum);
            }
        }
    });
    return reduced;
}

// The least squares over the sphere of horizon (1 - |y|) + zenith max(y, 0) + ground max(-y, 0). The mean squares of
// the three functions are 1/3, 1/6 and 1/6, the means of products with the first 1/12, and the other one 0.
void Sky::setPicture(std::shared_ptr<const ImageRgb32f> radiance, float rotation)
{
    picture = std::move(radiance);
    rotationRadians = rotation;
    glm::dvec3 flat(0.0);
    glm::dvec3 up(0.0);
    glm::dvec3 down(0.0);
    const double height = picture->height();
    for (int row = 0; row < picture->height(); ++row) {
        glm::dvec3 mean(0.0);
        for (int x = 0; x < picture->width(); ++x) mean += glm::dvec3((*picture)(x, row));
        mean /= picture->width();
        // Integrals of the functions over the row, whose y runs from `high` to `low`; shares of the sphere are dy / 2.
        const double high = math::cos(row / height * double(kPi));
        const double low = math::cos((row + 1) / height * double(kPi));
        const auto square = [](double y) { return y * y; };
        const double above = 0.25 * (square(std::max(high, 0.0)) - square(std::max(low, 0.0)));
        const double below = 0.25 * (square(std::min(low, 0.0)) - square(std::min(high, 0.0)));
        flat += mean * (0.5 * (high - low) - above - below);
        up += mean * above;
        down += mean * below;
    }
    const glm::dvec3 h = 4.0 * flat - 2.0 * (up + down); // 1/3 - 2 (1/12)^2 6 = 1/4 remains of the horizon's row
    horizon = glm::max(vec3(h), vec3(0.0f));
    zenith = glm::max(vec3(6.0 * up - 0.5 * h), vec3(0.0f));
    ground = glm::max(vec3(6.0 * down - 0.5 * h), vec3(0.0f));
}

} // namespace halflight
