// The law of mixing (docs/conventions.md), line by line. Expected numbers are worked out by hand from the law's text,
// not by calling the functions under test.
#include "halflight/shading/law.h"

#include <gtest/gtest.h>

#include <cmath>

namespace halflight::shading::law_test {
namespace {

constexpr int kModes[] = {kModeRealtime, kModeBakedIndirect, kModeShadowmask, kModeDistanceShadowmask,
                          kModeSubtractive};
constexpr bool kBaked = true;
constexpr bool kNoBaked = false;
constexpr bool kMap = true;
constexpr bool kNoMap = false;
/// What a shader may leave in a value that must not be read.
constexpr float kPoison = 12345.0f;

// "t = saturate((c - s)/r + 1), computed as one multiply-add c (1/r) + (1 - s/r) from two precomputed constants".
TEST(LawS1, FadeIsOneMultiplyAdd)
{
    const struct {
        float s, r, c, t;
    } table[] = {
        {60, 1, 0, 0},     {60, 1, 59, 0},     {60, 1, 59.25f, 0.25f}, {60, 1, 59.5f, 0.5f}, {60, 1, 60, 1},
        {60, 1, 61, 1},    {60, 1, 1e6f, 1},   {100, 20, 80, 0},       {100, 20, 85, 0.25f}, {100, 20, 95, 0.75f},
        {100, 20, 100, 1}, {50, 0.01f, 49, 0}, {50, 0.01f, 50, 1},     {8, 16, 0, 0.5f}, // range wider than the
                                                                                         // distance
    };
    for (const auto& row : table) {
        const vec2 constants = fadeConstants(row.s, row.r);
        EXPECT_FLOAT_EQ(constants.x, 1.0f / row.r);
        EXPECT_FLOAT_EQ(constants.y, 1.0f - row.s / row.r);
        EXPECT_NEAR(shadowFade(row.c, constants), row.t, 1e-3f) << "s " << row.s << " r " << row.r << " c " << row.c;
    }
}

// "Beyond the reach a light had at its bake (range, cone) B is 1".
TEST(LawS9, BakedShadowsEndAtTheReachAndConeOfTheBake)
{
    const float cone = std::cos(0.5f);
    for (const float baked : {0.0f, 0.3f, 1.0f}) {
        EXPECT_EQ(bakedWithinReach(baked, 1.0e6f, 0.0f, -1.0f, -1.0f), baked) << "no reach, no cone";
        EXPECT_EQ(bakedWithinReach(baked, 7.99f, 8.0f, -1.0f, -1.0f), baked);
        EXPECT_EQ(bakedWithinReach(baked, 8.01f, 8.0f, -1.0f, -1.0f), 1.0f);
        EXPECT_EQ(bakedWithinReach(baked, 3.0f, 8.0f, std::cos(0.49f), cone), baked);
        EXPECT_EQ(bakedWithinReach(baked, 3.0f, 8.0f, std::cos(0.51f), cone), 1.0f);
        EXPECT_EQ(bakedWithinReach(baked, 9.0f, 0.0f, std::cos(0.51f), cone), 1.0f);
    }
}

// "t = 0 near, 1 from the shadow distance on": monotone, continuous, and without steps.
TEST(LawS1, FadeIsSmooth)
{
    const vec2 constants = fadeConstants(60.0f, 5.0f);
    float before = shadowFade(0.0f, constants);
    for (int i = 1; i <= 7000; ++i) {
        const float t = shadowFade(0.01f * float(i), constants);
        EXPECT_GE(t, before);
        EXPECT_LE(t - before, 0.01f / 5.0f + 1e-5f);
        before = t;
    }
    EXPECT_EQ(before, 1.0f);
}

// "where t = 1 no realtime shadow map is sampled": and there no value of R changes anything, in any mode.
TEST(LawS1, NothingIsSampledFromTheShadowDistanceOn)
{
    EXPECT_TRUE(readsShadowMap(kMap, 0.0f));
    EXPECT_TRUE(readsShadowMap(kMap, 0.999f));
    EXPECT_FALSE(readsShadowMap(kMap, 1.0f));
    EXPECT_FALSE(readsShadowMap(kNoMap, 0.0f));
    EXPECT_FALSE(readsShadowMap(kNoMap, 1.0f));
    EXPECT_FALSE(readsShadowMap(kMap, shadowFade(60.0f, fadeConstants(60.0f, 1.0f))));
    EXPECT_FALSE(readsShadowMap(kMap, shadowFade(1.0e6f, fadeConstants(60.0f, 10.0f))));
    EXPECT_TRUE(readsShadowMap(kMap, shadowFade(59.9f, fadeConstants(60.0f, 1.0f))));
    for (const int mode : kModes)
        for (const bool hasBaked : {kBaked, kNoBaked})
            EXPECT_EQ(mixShadows(mode, hasBaked, 0.5f, kMap, 0.0f, 1.0f, 0.7f),
                      mixShadows(mode, hasBaked, 0.5f, kMap, 1.0f, 1.0f, 0.7f));
}

// "F = lerp(R, 1, t)"; "saturate(R + t) is equal wherever R is 0 or 1".
TEST(LawS1, FadedRealtime)
{
    EXPECT_FLOAT_EQ(fadeRealtimeShadow(0.2f, 0.0f), 0.2f);
    EXPECT_FLOAT_EQ(fadeRealtimeShadow(0.2f, 1.0f), 1.0f);
    EXPECT_FLOAT_EQ(fadeRealtimeShadow(0.2f, 0.5f), 0.6f);
    EXPECT_FLOAT_EQ(fadeRealtimeShadow(0.75f, 0.2f), 0.8f);
    for (const float r : {0.0f, 1.0f}) {
        for (const float t : {0.0f, 0.1f, 0.5f, 0.9f, 1.0f})
            EXPECT_NEAR(fadeRealtimeShadow(r, t), saturate(r + t), 1e-6f);
    }
}

struct Row {
    const char* line; // of the law
    int mode;
    bool hasBaked;
    float baked;
    bool hasRealtime;
    float realtime;
    float fade;
    float strength;
    float expected;
};

// R = 0.25 and B = 0.5 unless the line is about something else. F(0.25, 0.5) = 0.625, F(0.25, 0.8) = 0.85.
const Row kRows[] = {
    // No baked shadow for this light: A = F, in every mode.
    {"no baked: A = F", kModeRealtime, kNoBaked, kPoison, kMap, 0.25f, 0.5f, 1, 0.625f},
    {"no baked: A = F", kModeBakedIndirect, kNoBaked, kPoison, kMap, 0.25f, 0.5f, 1, 0.625f},
    {"no baked: A = F", kModeShadowmask, kNoBaked, kPoison, kMap, 0.25f, 0.5f, 1, 0.625f},
    {"no baked: A = F", kModeDistanceShadowmask, kNoBaked, kPoison, kMap, 0.25f, 0.5f, 1, 0.625f},
    {"no baked: A = F", kModeSubtractive, kNoBaked, kPoison, kMap, 0.25f, 0.5f, 1, 0.625f},
    {"no baked, near", kModeShadowmask, kNoBaked, kPoison, kMap, 0.25f, 0, 1, 0.25f},
    {"no baked, beyond", kModeShadowmask, kNoBaked, kPoison, kMap, 0, 1, 1, 1},
    {"no baked and no map: lit", kModeShadowmask, kNoBaked, kPoison, kNoMap, kPoison, 0, 1, 1},
    {"no baked and no map: lit", kModeRealtime, kNoBaked, kPoison, kNoMap, kPoison, 0.5f, 1, 1},
    // Baked indirect: as 'no baked shadow', whatever the light's channel. So is realtime mode.
    {"S7 baked indirect", kModeBakedIndirect, kBaked, 0, kMap, 0.25f, 0.5f, 1, 0.625f},
    {"S7 baked indirect, no map", kModeBakedIndirect, kBaked, 0, kNoMap, kPoison, 0.5f, 1, 1},
    {"realtime mode", kModeRealtime, kBaked, 0, kMap, 0.25f, 0.5f, 1, 0.625f},
    {"realtime mode, no map", kModeRealtime, kBaked, 0, kNoMap, kPoison, 0.5f, 1, 1},
    // Shadowmask: A = min(F, B).
    {"S12 min, near: R < B", kModeShadowmask, kBaked, 0.5f, kMap, 0.25f, 0, 1, 0.25f},
    {"S12 min, near: B < R", kModeShadowmask, kBaked, 0.5f, kMap, 0.75f, 0, 1, 0.5f},
    {"S12 min, fading: B < F", kModeShadowmask, kBaked, 0.5f, kMap, 0.25f, 0.5f, 1, 0.5f},
    {"S12 min, fading: F < B", kModeShadowmask, kBaked, 0.9f, kMap, 0.25f, 0.8f, 1, 0.85f},
    {"S12 beyond: B", kModeShadowmask, kBaked, 0.5f, kMap, 0, 1, 1, 0.5f},
    {"S12 not a product", kModeShadowmask, kBaked, 0.5f, kMap, 0.5f, 0, 1, 0.5f},
    // Distance shadowmask: A = lerp(R, B, t).
    {"S13 near: R", kModeDistanceShadowmask, kBaked, 0.5f, kMap, 0.25f, 0, 1, 0.25f},
    {"S13 near: R alone, not min", kModeDistanceShadowmask, kBaked, 0, kMap, 1, 0, 1, 1},
    {"S13 fading", kModeDistanceShadowmask, kBaked, 0.5f, kMap, 0.25f, 0.5f, 1, 0.375f},
    {"S13 fading", kModeDistanceShadowmask, kBaked, 0, kMap, 1, 0.75f, 1, 0.25f},
    {"S13 beyond: B", kModeDistanceShadowmask, kBaked, 0.5f, kMap, 0, 1, 1, 0.5f},
    // A light that has no realtime shadow uses A = B at every distance.
    {"S4 no map, near", kModeDistanceShadowmask, kBaked, 0.5f, kNoMap, kPoison, 0, 1, 0.5f},
    {"S4 no map, fading", kModeDistanceShadowmask, kBaked, 0.5f, kNoMap, kPoison, 0.5f, 1, 0.5f},
    {"S4 no map, beyond", kModeDistanceShadowmask, kBaked, 0.5f, kNoMap, kPoison, 1, 1, 0.5f},
    // No realtime shadow map at all, in any mode with a mask: A = B.
    {"S19 shadowmask", kModeShadowmask, kBaked, 0.5f, kNoMap, kPoison, 0, 1, 0.5f},
    {"S19 shadowmask, fading", kModeShadowmask, kBaked, 0.5f, kNoMap, kPoison, 0.5f, 1, 0.5f},
    {"S19 shadowmask, beyond", kModeShadowmask, kBaked, 0, kNoMap, kPoison, 1, 1, 0},
    {"S19 subtractive", kModeSubtractive, kBaked, 0.5f, kNoMap, kPoison, 0, 1, 0.5f},
    {"S19 subtractive, beyond", kModeSubtractive, kBaked, 0.5f, kNoMap, kPoison, 1, 1, 0.5f},
    // Subtractive, dynamic receiver, main light: A = min(F, B).
    {"S25 near: R < B", kModeSubtractive, kBaked, 0.5f, kMap, 0.25f, 0, 1, 0.25f},
    {"S25 near: B < R", kModeSubtractive, kBaked, 0.5f, kMap, 0.75f, 0, 1, 0.5f},
    {"S25 fading", kModeSubtractive, kBaked, 0.9f, kMap, 0.25f, 0.8f, 1, 0.85f},
    {"S25 beyond: B", kModeSubtractive, kBaked, 0.5f, kMap, 0, 1, 1, 0.5f},
    // Strength, last: A' = lerp(1, A, k).
    {"S20 k = 0: lit", kModeShadowmask, kBaked, 0, kMap, 0, 0, 0, 1},
    {"S20 k = 0.5 on min", kModeShadowmask, kBaked, 0.5f, kMap, 0.25f, 0, 0.5f, 0.625f},
    {"S20 k once, not twice", kModeShadowmask, kBaked, 0, kMap, 0, 0, 0.5f, 0.5f},
    {"S20 k on distance", kModeDistanceShadowmask, kBaked, 0.5f, kMap, 0.25f, 0.5f, 0.8f, 0.5f},
    {"S20 k on only-baked", kModeDistanceShadowmask, kBaked, 0.5f, kNoMap, kPoison, 0, 0.25f, 0.875f},
    {"S20 k on only-realtime", kModeRealtime, kNoBaked, kPoison, kMap, 0.25f, 0.5f, 0.8f, 0.7f},
    {"S20 k on subtractive", kModeSubtractive, kBaked, 0.5f, kMap, 1, 0, 0.5f, 0.75f},
    {"S20 k on nothing", kModeBakedIndirect, kNoBaked, kPoison, kNoMap, kPoison, 0, 0.5f, 1},
};

TEST(Law, EveryLine)
{
    for (const Row& row : kRows) {
        const float a =
            mixShadows(row.mode, row.hasBaked, row.baked, row.hasRealtime, row.realtime, row.fade, row.strength);
        EXPECT_NEAR(a, row.expected, 1e-6f) << row.line << " (mode " << row.mode << ")";
    }
}

// What is said not to exist is not read: NaN there changes nothing.
TEST(Law, UnusedValuesAreNotRead)
{
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (const int mode : kModes) {
        for (const float t : {0.0f, 0.3f, 1.0f}) {
            EXPECT_EQ(mixShadows(mode, kNoBaked, nan, kMap, 0.5f, t, 0.7f),
                      mixShadows(mode, kNoBaked, 0, kMap, 0.5f, t, 0.7f));
            EXPECT_EQ(mixShadows(mode, kBaked, 0.5f, kNoMap, nan, t, 0.7f),
                      mixShadows(mode, kBaked, 0.5f, kNoMap, 0, t, 0.7f));
        }
    }
}

// For all inputs: never outside [0, 1], never brighter where anything gets darker, full strength = without strength.
TEST(Law, BoundedAndMonotone)
{
    const float steps[] = {0.0f, 0.125f, 0.25f, 0.5f, 0.75f, 1.0f};
    for (const int mode : kModes) {
        for (const bool hasBaked : {false, true}) {
            for (const bool hasMap : {false, true}) {
                for (const float b : steps) {
                    for (const float r : steps) {
                        for (const float t : steps) {
                            const float full = mixShadowsFullStrength(mode, hasBaked, b, hasMap, r, t);
                            EXPECT_EQ(mixShadows(mode, hasBaked, b, hasMap, r, t, 1.0f), full);
                            for (const float k : steps) {
                                const float a = mixShadows(mode, hasBaked, b, hasMap, r, t, k);
                                EXPECT_GE(a, 0.0f);
                                EXPECT_LE(a, 1.0f);
                                EXPECT_LE(mixShadows(mode, hasBaked, 0.5f * b, hasMap, r, t, k), a);
                                EXPECT_LE(mixShadows(mode, hasBaked, b, hasMap, 0.5f * r, t, k), a);
                                EXPECT_GE(a, full - 1e-6f);
                            }
                        }
                    }
                }
            }
        }
    }
}

// S13: no jump where shadows end: the last sampled value meets the value beyond.
TEST(LawS13, ContinuousThroughTheShadowDistance)
{
    const vec2 constants = fadeConstants(60.0f, 2.0f);
    for (const int mode : {kModeShadowmask, kModeDistanceShadowmask, kModeSubtractive}) {
        float before = mixShadows(mode, kBaked, 0.4f, kMap, 0.1f, shadowFade(57.0f, constants), 0.9f);
        for (float c = 57.0f; c < 61.0f; c += 0.01f) {
            const float a = mixShadows(mode, kBaked, 0.4f, kMap, 0.1f, shadowFade(c, constants), 0.9f);
            EXPECT_NEAR(a, before, 0.006f) << "mode " << mode << " at " << c;
            before = a;
        }
        EXPECT_NEAR(before, mixShadows(mode, kBaked, 0.4f, kNoMap, 0, 1, 0.9f), 1e-5f);
    }
}

// Subtractive, static receiver. guess = L saturate(N.l) (B - min(B, F)), B and F without strength, B = 1 without the
// main light's mask; S = max(G - guess, shadowColour); result = min(G, lerp(G, S, k)).
TEST(LawS22, SubtractiveStaticReceiver)
{
    const struct {
        const char* line;
        float lightmap, mainIrradiance, faded, shadowColor, strength, expected;
        float baked = 1.0f;
    } table[] = {
        {"lit: G unchanged", 10, 8, 1, 0, 1, 10},
        {"S22 full shadow removes the main light", 10, 8, 0, 0, 1, 2},
        {"S22 half", 10, 8, 0.5f, 0, 1, 6},
        {"S22 fading: R 0 at t 0.75", 10, 8, 0.75f, 0, 1, 8},
        {"S23 not below the shadow colour", 10, 8, 0, 3, 1, 3},
        {"S23 nor below zero by a wrong guess", 5, 8, 0, 0, 1, 0},
        {"S23 never brighter: G already below the shadow colour", 2, 8, 0, 3, 1, 2},
        {"S23 never brighter, at any strength", 2, 8, 0, 3, 0.5f, 2},
        {"S24 strength after the colour", 10, 8, 0, 3, 0.5f, 6.5f},
        {"S24 strength 0: no shadow", 10, 8, 0, 3, 0, 10},
        {"S24 strength once", 10, 8, 0, 0, 0.5f, 6},
        {"unlit side: N.l = 0", 10, 0, 0, 0, 1, 10},
        {"already in baked shadow: the guess is too large", 1, 8, 0, 0.5f, 1, 0.5f},
        {"mask 1: as without", 10, 8, 0, 0, 1, 2, 1},
        {"mask: in baked shadow nothing is left to take", 2, 8, 0, 0, 1, 2, 0},
        {"mask: nor is the shadow colour above it of any use", 2, 8, 0, 3, 1, 2, 0},
        {"mask: penumbra, full dynamic shadow takes what arrives", 4, 8, 0, 0, 1, 2, 0.25f},
        {"mask: dynamic shadow lighter than the baked one takes nothing", 4, 8, 0.5f, 0, 1, 4, 0.25f},
        {"mask: dynamic shadow darker than the baked one takes the rest", 6, 8, 0.25f, 0, 1, 4, 0.5f},
        {"mask: strength 0.5 of a lightmap baked with it: 2 + 8 (0.5 + 0.5 min(0.5, 0.25))", 8, 8, 0.25f, 0, 0.5f, 7,
         0.5f},
        {"mask: the shadow colour limits as ever", 6, 8, 0, 3, 1, 3, 0.5f},
    };
    for (const auto& row : table) {
        const vec3 result = subtractiveIrradiance(vec3(row.lightmap), vec3(row.mainIrradiance), row.baked, row.faded,
                                                  vec3(row.shadowColor), row.strength);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(result[c], row.expected, 1e-5f) << row.line;
    }
}

TEST(LawS23, ChannelsAreIndependent)
{
    const vec3 result = subtractiveIrradiance({10, 5, 1}, {8, 8, 8}, 1.0f, 0.25f, {0, 2, 3}, 1.0f);
    EXPECT_NEAR(result.x, 4.0f, 1e-5f); // 10 - 6
    EXPECT_NEAR(result.y, 2.0f, 1e-5f); // limited by the colour
    EXPECT_NEAR(result.z, 1.0f, 1e-5f); // darker than the colour already
}

TEST(LawS22, NeverBrighterThanTheLightmap)
{
    for (const float g : {0.0f, 0.3f, 2.0f, 50.0f}) {
        for (const float e : {0.0f, 1.0f, 30.0f}) {
            for (const float f : {0.0f, 0.4f, 1.0f}) {
                for (const float colour : {0.0f, 1.0f, 100.0f}) {
                    for (const float k : {0.0f, 0.5f, 1.0f}) {
                        for (const float b : {0.0f, 0.3f, 1.0f}) {
                            const float s = subtractiveIrradiance(vec3(g), vec3(e), b, f, vec3(colour), k).x;
                            EXPECT_LE(s, g);
                            EXPECT_GE(s, std::min(g, colour) - 1e-6f);
                        }
                    }
                }
            }
        }
    }
}

// Casters: shadowmask and subtractive draw dynamic objects only for lights that have a channel (or are fully baked for
// static receivers); distance shadowmask, baked indirect and realtime lights draw all.
// Spec section 4: B is 1 beyond the reach of the bake, by distance or by angle, and as baked within.
TEST(LawS29, BakedShadowsEndAtTheReachOfTheBake)
{
    constexpr float kB = 0.25f;
    const float cone = std::cos(0.5f);
    for (const float distance : {0.0f, 3.0f, 5.0f, 5.001f, 80.0f}) {
        for (const float angle : {0.0f, 0.4f, 0.499f, 0.501f, 2.0f}) {
            const float cosine = std::cos(angle);
            EXPECT_EQ(bakedWithinReach(kB, distance, 0.0f, cosine, -2.0f), kB) << "unlimited";
            EXPECT_EQ(bakedWithinReach(kB, distance, 5.0f, cosine, -2.0f), distance <= 5.0f ? kB : 1.0f);
            EXPECT_EQ(bakedWithinReach(kB, distance, 0.0f, cosine, cone), angle < 0.5f ? kB : 1.0f);
            EXPECT_EQ(bakedWithinReach(kB, distance, 5.0f, cosine, cone), distance <= 5.0f && angle < 0.5f ? kB : 1.0f);
        }
    }
}

TEST(LawS12, StaticCasters)
{
    EXPECT_FALSE(staticCastersInShadowMap(kModeShadowmask, true));
    EXPECT_FALSE(staticCastersInShadowMap(kModeSubtractive, true));
    EXPECT_TRUE(staticCastersInShadowMap(kModeDistanceShadowmask, true));
    EXPECT_TRUE(staticCastersInShadowMap(kModeBakedIndirect, true));
    EXPECT_TRUE(staticCastersInShadowMap(kModeRealtime, true));
    for (const int mode : kModes)
        EXPECT_TRUE(staticCastersInShadowMap(mode, false)) << "realtime light in mode " << mode;
}

TEST(Law, ModesThatReadBakedShadows)
{
    EXPECT_FALSE(modeUsesBakedShadows(kModeRealtime));
    EXPECT_FALSE(modeUsesBakedShadows(kModeBakedIndirect));
    EXPECT_TRUE(modeUsesBakedShadows(kModeShadowmask));
    EXPECT_TRUE(modeUsesBakedShadows(kModeDistanceShadowmask));
    EXPECT_TRUE(modeUsesBakedShadows(kModeSubtractive));
}

/// The law by colour channel: each is what a grey light of that B gives.
TEST(LawS35, ColorsAreMixedChannelByChannel)
{
    const vec3 baked(0.9f, 0.3f, 0.0f);
    for (const int mode : kModes)
        for (const bool hasBaked : {false, true})
            for (const bool hasMap : {false, true})
                for (const float t : {0.0f, 0.4f, 1.0f}) {
                    const vec3 mixed = mixShadowsByColor(mode, hasBaked, baked, hasMap, 0.5f, t, 0.8f);
                    for (int c = 0; c < 3; ++c)
                        EXPECT_EQ(mixed[c], mixShadows(mode, hasBaked, baked[c], hasMap, 0.5f, t, 0.8f));
                }
    // By hand, beyond the shadow distance: 1 - k (1 - B).
    const vec3 far = mixShadowsByColor(kModeDistanceShadowmask, true, baked, true, 0.1f, 1.0f, 0.5f);
    EXPECT_FLOAT_EQ(far.x, 0.95f);
    EXPECT_FLOAT_EQ(far.y, 0.65f);
    EXPECT_FLOAT_EQ(far.z, 0.5f);
    // By hand: guess 8 (B - F) where B > F, subtracted down to the colour.
    const vec3 dark = subtractiveIrradianceByColor({10, 5, 2}, {8, 8, 8}, {1.0f, 0.5f, 0.2f}, 0.25f, {0, 4, 0}, 1.0f);
    EXPECT_FLOAT_EQ(dark.x, 4.0f);
    EXPECT_FLOAT_EQ(dark.y, 4.0f);
    EXPECT_FLOAT_EQ(dark.z, 2.0f);
}

} // namespace
} // namespace halflight::shading::law_test
