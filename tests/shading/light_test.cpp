#include "halflight/shading/light.h"

#include <gtest/gtest.h>

namespace halflight::shading::light_test {
namespace {

TEST(Light, InverseSquareLaw)
{
    EXPECT_FLOAT_EQ(distanceAttenuation(1.0f, 0.0f), 1.0f);
    EXPECT_FLOAT_EQ(distanceAttenuation(2.0f, 0.0f), 0.25f);
    EXPECT_FLOAT_EQ(distanceAttenuation(10.0f, 0.0f), 0.01f);
    EXPECT_FLOAT_EQ(distanceAttenuation(1e-9f, 0.0f), 1e6f) << "finite on the light itself";
}

// KHR_lights_punctual: attenuation = max(min(1 - (d / range)^4, 1), 0) / d^2.
TEST(Light, RangeWindow)
{
    const float range = 7.5f;
    for (const float d : {0.1f, 1.0f, 3.0f, 5.0f, 7.0f, 7.4999f, 7.5f, 7.6f, 100.0f}) {
        const double truth =
            std::max(std::min(1.0 - std::pow(double(d) / double(range), 4.0), 1.0), 0.0) / (double(d) * double(d));
        EXPECT_NEAR(distanceAttenuation(d, range), truth, 1e-6 + 1e-5 * truth) << d;
    }
    EXPECT_EQ(distanceAttenuation(7.5f, range), 0.0f) << "exactly 0 from the range on";
    EXPECT_EQ(distanceAttenuation(1000.0f, range), 0.0f);
}

TEST(Light, ConeIsOneInsideZeroOutside)
{
    const float inner = 0.3f;
    const float outer = 0.7f;
    const vec2 constants = spotConstants(inner, outer);
    EXPECT_FLOAT_EQ(spotAttenuation(1.0f, constants), 1.0f);
    EXPECT_NEAR(spotAttenuation(std::cos(inner), constants), 1.0f, 1e-5f);
    EXPECT_NEAR(spotAttenuation(std::cos(outer), constants), 0.0f, 1e-6f);
    EXPECT_EQ(spotAttenuation(-1.0f, constants), 0.0f);
    // Linear in the cosine, then squared: a quarter midway.
    EXPECT_NEAR(spotAttenuation(0.5f * (std::cos(inner) + std::cos(outer)), constants), 0.25f, 1e-5f);
    float before = 1.0f;
    for (float angle = 0.0f; angle < 1.0f; angle += 0.01f) {
        const float a = spotAttenuation(std::cos(angle), constants);
        EXPECT_LE(a, before + 1e-6f);
        before = a;
    }
}

TEST(Light, EqualConeAnglesAreFinite)
{
    const vec2 constants = spotConstants(0.5f, 0.5f);
    EXPECT_TRUE(std::isfinite(constants.x) && std::isfinite(constants.y));
    EXPECT_EQ(spotAttenuation(std::cos(0.51f), constants), 0.0f);
    EXPECT_EQ(spotAttenuation(std::cos(0.49f), constants), 1.0f);
}

TEST(Light, SampledIlluminance)
{
    const vec3 power(100, 50, 25);
    const LightSample sun =
        sampleLight(kLightDirectional, power, vec3(0), vec3(0, -1, 0), 5.0f, vec2(0), vec3(9, 9, 9));
    EXPECT_EQ(sun.illuminance, power) << "position and range play no part";
    EXPECT_EQ(sun.direction, vec3(0, 1, 0));

    const LightSample bulb = sampleLight(kLightPoint, power, vec3(0, 3, 4), vec3(0, -1, 0), 0.0f, vec2(0), vec3(0));
    EXPECT_FLOAT_EQ(bulb.distance, 5.0f);
    EXPECT_LT(length(bulb.direction - vec3(0, 0.6f, 0.8f)), 1e-6f);
    EXPECT_LT(length(bulb.illuminance - power / 25.0f), 1e-5f);

    const vec2 cone = spotConstants(0.2f, 0.4f);
    const vec3 axis(0, -1, 0);
    const LightSample below = sampleLight(kLightSpot, power, vec3(0, 2, 0), axis, 0.0f, cone, vec3(0));
    EXPECT_LT(length(below.illuminance - power / 4.0f), 1e-5f);
    const LightSample aside = sampleLight(kLightSpot, power, vec3(0, 2, 0), axis, 0.0f, cone, vec3(2, 0, 0));
    EXPECT_EQ(aside.illuminance, vec3(0)) << "45 degrees off the axis";
    const LightSample onTop = sampleLight(kLightPoint, power, vec3(1), axis, 0.0f, cone, vec3(1));
    EXPECT_TRUE(std::isfinite(onTop.illuminance.x)) << "on the light itself";
}

// A lamp of intensity I lights a closed sphere about it with 4 pi I lumens, whatever its radius.
TEST(Light, FluxIsConserved)
{
    for (const float radius : {0.5f, 2.0f, 10.0f}) {
        const LightSample s =
            sampleLight(kLightPoint, vec3(10), vec3(0), vec3(0, -1, 0), 0.0f, vec2(0), vec3(radius, 0, 0));
        EXPECT_NEAR(s.illuminance.x * 4.0f * kShadingPi * radius * radius, 4.0f * kShadingPi * 10.0f, 0.01f);
    }
}

} // namespace
} // namespace halflight::shading::light_test
