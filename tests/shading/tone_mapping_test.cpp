// That each mapper is three.js's own: web/tests/browser/tone.mjs.
#include "halflight/shading/tone_mapping.h"

#include <gtest/gtest.h>

namespace halflight::shading::tone_mapping_test {
namespace {

// The specification's curve: continuous, monotone, within [0, 1], and below the knee only the 0.04 offset of its foot.
TEST(ToneMapping, NeutralOfGreys)
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

TEST(ToneMapping, NeutralOfColours)
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

// Greys stay grey, brighter ones are no darker, black is black and the brightest is white.
TEST(ToneMapping, AcesAndAgxOfGreys)
{
    for (const int mapper : {kToneMapAces, kToneMapAgx}) {
        EXPECT_NEAR(toneMapped(vec3(0.0f), mapper).x, 0.0f, 1e-3f);
        float before = -1.0f;
        for (float x = 1e-4f; x < 100.0f; x *= 1.01f) {
            const vec3 mapped = toneMapped(vec3(x), mapper);
            EXPECT_NEAR(mapped.x, mapped.y, 2e-3f) << x; // matrices have five digits
            EXPECT_NEAR(mapped.x, mapped.z, 2e-3f) << x;
            EXPECT_GE(mapped.x, before - 1e-4f) << x;
            before = mapped.x;
        }
        EXPECT_NEAR(before, 1.0f, 0.04f);
        EXPECT_NEAR(toneMapped(vec3(0.18f), mapper).x, 0.18f, 0.05f) << "middle grey";
    }
}

TEST(ToneMapping, AgxLosesSaturationAndNoneKeepsAll)
{
    const vec3 red(8.0f, 0.5f, 0.5f);
    const vec3 agx = toneMapped(red, kToneMapAgx);
    EXPECT_GT(agx.y / agx.x, 3.0f * red.y / red.x);
    EXPECT_EQ(toneMapped(red, kToneMapNone), red);
}

} // namespace
} // namespace halflight::shading::tone_mapping_test
