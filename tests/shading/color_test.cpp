#include "halflight/shading/color.h"

#include <gtest/gtest.h>

namespace halflight::shading::color_test {
namespace {

TEST(Color, SrgbKnownValues)
{
    // IEC 61966-2-1: middle grey 0.214041 encodes to 0.5.
    EXPECT_NEAR(srgbFromLinear(0.2140411f), 0.5f, 1e-5f);
    EXPECT_NEAR(srgbFromLinear(0.5f), 0.7353570f, 1e-5f);
    EXPECT_EQ(srgbFromLinear(0.0f), 0.0f);
    EXPECT_NEAR(srgbFromLinear(1.0f), 1.0f, 1e-6f);
    EXPECT_NEAR(srgbFromLinear(0.002f), 0.02584f, 1e-6f);
}

TEST(Color, SrgbRoundTrip)
{
    for (int i = 0; i <= 255; ++i) {
        const float encoded = float(i) / 255.0f;
        EXPECT_EQ(int(std::lround(255.0f * srgbFromLinear(linearFromSrgb(encoded)))), i);
    }
    for (float x = 0.0f; x <= 1.0f; x += 0.001f) EXPECT_NEAR(linearFromSrgb(srgbFromLinear(x)), x, 1e-5f);
}

TEST(Color, SrgbIsContinuousAtItsKnee)
{
    EXPECT_NEAR(srgbFromLinear(0.0031307f), srgbFromLinear(0.0031309f), 1e-5f);
    EXPECT_NEAR(linearFromSrgb(0.040449f), linearFromSrgb(0.040451f), 1e-5f);
}

TEST(Color, ExposureHalvesPerStep)
{
    EXPECT_FLOAT_EQ(exposureFactor(0.0f), 1.0f);
    EXPECT_FLOAT_EQ(exposureFactor(1.0f), 0.5f);
    EXPECT_FLOAT_EQ(exposureFactor(-3.0f), 8.0f);
}

} // namespace
} // namespace halflight::shading::color_test
