#include "halflight/shading/color.h"

#include <gtest/gtest.h>

namespace halflight::shading {
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

// The specification's curve: continuous, monotone, within [0, 1], and below the knee only the 0.04 offset of its foot.
TEST(Color, NeutralToneMapOfGreys)
{
    float before = toneMapNeutral(vec3(0.0f)).x;
    EXPECT_EQ(before, 0.0f);
    for (int i = 1; i <= 200000; ++i) {
        const float x = 1e-4f * float(i);
        const vec3 mapped = toneMapNeutral(vec3(x));
        EXPECT_FLOAT_EQ(mapped.x, mapped.y);
        ASSERT_GE(mapped.x, before - 1e-6f) << x;
        ASSERT_LT(mapped.x - before, 2.5e-4f) << "a jump at " << x; // the foot's slope is at most 1 above 0.08
        ASSERT_LE(mapped.x, 1.0f);
        before = mapped.x;
    }
    EXPECT_NEAR(toneMapNeutral(vec3(0.5f)).x, 0.46f, 1e-6f);
    EXPECT_NEAR(toneMapNeutral(vec3(0.8f)).x, 0.76f, 1e-6f);
    EXPECT_NEAR(toneMapNeutral(vec3(0.04f)).x, 6.25f * 0.04f * 0.04f, 1e-6f);
    EXPECT_GT(toneMapNeutral(vec3(1e4f)).x, 0.999f);
}

TEST(Color, NeutralToneMapOfColours)
{
    // Below the knee hue and saturation stay: channel differences are kept.
    const vec3 mapped = toneMapNeutral({0.6f, 0.3f, 0.1f});
    EXPECT_NEAR(mapped.x - mapped.y, 0.3f, 1e-6f);
    EXPECT_NEAR(mapped.y - mapped.z, 0.2f, 1e-6f);
    // Bright colours go to white, never past it.
    const vec3 bright = toneMapNeutral({1000.0f, 10.0f, 0.0f});
    for (int c = 0; c < 3; ++c) {
        EXPECT_GE(bright[c], 0.9f);
        EXPECT_LE(bright[c], 1.0f);
    }
    // Continuous across the knee for a saturated colour.
    const vec3 below = toneMapNeutral({0.7599f, 0.2f, 0.0f});
    const vec3 above = toneMapNeutral({0.7601f, 0.2f, 0.0f});
    EXPECT_LT(length(above - below), 1e-3f);
}

} // namespace
} // namespace halflight::shading
