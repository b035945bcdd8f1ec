// Levels of textures against the mean of the texels beneath them, computed in doubles.
#include "halflight/shading/color.h"
#include "halflight/shading/random.h"
#include "render/scene/mipmaps.h"

#include <gtest/gtest.h>

#include <cmath>

namespace halflight::test::mipmaps_test {
namespace {

double decoded(uint8_t value, bool srgb)
{
    const double x = value / 255.0;
    if (!srgb) return x;
    return x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
}

double encoded(double x, bool srgb)
{
    if (!srgb) return 255.0 * x;
    return 255.0 * (x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055);
}

/// Mean over a texel's share of the picture of the level above.
double meanOf(const ImageRgba8& above, ivec2 size, ivec2 p, int channel, bool srgb)
{
    const glm::dvec2 step = glm::dvec2(above.size()) / glm::dvec2(size);
    const glm::dvec2 low = glm::dvec2(p) * step;
    const glm::dvec2 high = low + step;
    double sum = 0.0;
    for (int y = int(low.y); y < std::min(int(std::ceil(high.y)), above.height()); ++y) {
        for (int x = int(low.x); x < std::min(int(std::ceil(high.x)), above.width()); ++x) {
            const double width = std::min(high.x, x + 1.0) - std::max(low.x, double(x));
            const double height = std::min(high.y, y + 1.0) - std::max(low.y, double(y));
            sum += width * height * decoded(above(x, y)[channel], srgb && channel < 3);
        }
    }
    return sum / (step.x * step.y);
}

TEST(Mipmaps, AreMeansOfLight)
{
    for (const ivec2 size : {ivec2(64, 64), ivec2(37, 20), ivec2(1, 9)}) {
        for (const bool srgb : {false, true}) {
            ImageRgba8 image(size.x, size.y);
            for (std::size_t i = 0; i < image.texelCount(); ++i) {
                const uint32_t bits = hashPcg(uint32_t(i));
                image.texels()[i] = u8vec4(bits & 255u, bits >> 8 & 255u, (bits >> 16 & 255u) / 8, bits >> 24);
            }
            const std::vector<ImageRgba8> levels = mipLevels(image, srgb);
            const ImageRgba8* above = &image;
            for (const ImageRgba8& level : levels) {
                ASSERT_EQ(level.size(), glm::max(above->size() / 2, ivec2(1)));
                for (int y = 0; y < level.height(); ++y)
                    for (int x = 0; x < level.width(); ++x)
                        for (int c = 0; c < 4; ++c) {
                            const double mean = meanOf(*above, level.size(), ivec2(x, y), c, srgb);
                            EXPECT_NEAR(level(x, y)[c], encoded(mean, srgb && c < 3), 0.501) << size.x << " " << srgb;
                        }
                above = &level;
            }
            EXPECT_EQ(above->size(), ivec2(1));
        }
    }
}

/// Of two equal texels the mean is that texel: no code is lost by the encoder without a power.
TEST(Mipmaps, EveryCodeStays)
{
    ImageRgba8 image(512, 2);
    for (int x = 0; x < 512; ++x)
        for (int y = 0; y < 2; ++y) image(x, y) = u8vec4(uint8_t(x / 2));
    const std::vector<ImageRgba8> levels = mipLevels(image, true);
    for (int x = 0; x < 256; ++x) EXPECT_EQ(levels[0](x, 0), u8vec4(uint8_t(x)));
}

} // namespace
} // namespace halflight::test::mipmaps_test
