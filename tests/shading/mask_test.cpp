// Decoding of shadowmask texels; numbers by hand from docs/format.md.
#include "halflight/shading/mask.h"

#include <gtest/gtest.h>

namespace halflight::shading::mask_test {
namespace {

TEST(MaskS8, AttenuationIsItself)
{
    for (const float value : {0.0f, 0.3f, 1.0f}) EXPECT_EQ(decodeMask(value, 0.0f, 7.0f, 0.1f), value);
}

TEST(MaskS8, DistanceGivesAnEdgeOnePixelWide)
{
    // Range 4: 0.625 is 1 texel into the light. A pixel of 4 texels makes that a quarter beyond the half.
    EXPECT_FLOAT_EQ(decodeMask(0.625f, 4.0f, 0.0f, 4.0f), 0.75f);
    EXPECT_FLOAT_EQ(decodeMask(0.375f, 4.0f, 0.0f, 4.0f), 0.25f);
    EXPECT_FLOAT_EQ(decodeMask(0.625f, 4.0f, 0.0f, 0.1f), 1.0f);
    EXPECT_FLOAT_EQ(decodeMask(0.375f, 4.0f, 0.0f, 0.1f), 0.0f);
    EXPECT_FLOAT_EQ(decodeMask(0.5f, 4.0f, 0.0f, 0.0f), 0.5f);
}

TEST(MaskS8, PenumbraWidensTheEdge)
{
    EXPECT_FLOAT_EQ(decodeMask(0.5625f, 4.0f, 2.0f, 0.1f), 0.75f);  // half a texel into the light, of two
    EXPECT_FLOAT_EQ(decodeMask(0.5625f, 4.0f, 2.0f, 4.0f), 0.625f); // the pixel is wider
}

TEST(MaskS8, EncodingIsTheInverse)
{
    for (float d = -3.9f; d < 4.0f; d += 0.1f) {
        const float stored = encodeMaskDistance(d, 4.0f);
        EXPECT_NEAR((2.0f * stored - 1.0f) * 4.0f, d, 1e-5f);
    }
    EXPECT_EQ(encodeMaskDistance(99.0f, 4.0f), 1.0f);
    EXPECT_EQ(encodeMaskDistance(-99.0f, 4.0f), 0.0f);
}

} // namespace
} // namespace halflight::shading::mask_test
