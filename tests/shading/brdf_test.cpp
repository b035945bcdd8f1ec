#include "halflight/shading/brdf.h"
#include "halflight/shading/sampling.h"

#include <gtest/gtest.h>

namespace halflight::shading::brdf_test {
namespace {

const vec3 kNormal(0, 0, 1);

vec3 viewAt(float cosine)
{
    return {std::sqrt(1.0f - cosine * cosine), 0.0f, cosine};
}

/// Directional albedo: what is reflected to v from surroundings of radiance 1. Stratified, from an even mixture of the
/// cosine and the GGX half-vector distributions.
vec3 directionalAlbedo(vec3 baseColor, float metallic, float roughness, vec3 v)
{
    constexpr int kSide = 256;
    const float alpha = square(std::max(roughness, 0.045f));
    glm::dvec3 sum(0.0);
    for (int i = 0; i < kSide; ++i) {
        for (int j = 0; j < kSide; ++j) {
            const vec2 u((float(i) + 0.5f) / kSide, (float(j) + 0.5f) / kSide);
            for (const bool specular : {false, true}) {
                vec3 l;
                if (specular) {
                    // Walter et al. 2007, eq. 35-36.
                    const float cosine = std::sqrt((1.0f - u.x) / (1.0f + (alpha * alpha - 1.0f) * u.x));
                    const float sine = std::sqrt(std::max(0.0f, 1.0f - cosine * cosine));
                    const float phi = 2.0f * kShadingPi * u.y;
                    const vec3 h(sine * std::cos(phi), sine * std::sin(phi), cosine);
                    l = 2.0f * dot(v, h) * h - v;
                } else {
                    l = sampleCosineHemisphere(u);
                }
                if (l.z <= 0.0f) continue;
                const vec3 h = normalize(l + v);
                const float pdfSpecular = distributionGgx(h.z, alpha) * h.z / (4.0f * std::max(dot(v, h), 1e-6f));
                const float pdf = 0.5f * (l.z / kShadingPi + pdfSpecular);
                sum += glm::dvec3(reflectLight(baseColor, metallic, roughness, 1.0f, kNormal, v, l, vec3(1.0f)) / pdf);
            }
        }
    }
    return vec3(sum / (2.0 * kSide * kSide));
}

// White furnace: the specular lobe reflects no more than it receives, from any side.
TEST(Brdf, WhiteFurnaceOfMetals)
{
    for (const float roughness : {0.0f, 0.2f, 0.5f, 0.8f, 1.0f}) {
        for (const float cosine : {0.1f, 0.3f, 0.6f, 0.95f}) {
            const float albedo = directionalAlbedo(vec3(1.0f), 1.0f, roughness, viewAt(cosine)).x;
            EXPECT_LE(albedo, 1.0f + 2e-3f) << "roughness " << roughness << " cosine " << cosine;
            EXPECT_GE(albedo, 0.3f) << "single scattering loses energy, but not this much";
            if (roughness <= 0.2f && cosine >= 0.3f) EXPECT_GE(albedo, 0.97f) << "a mirror reflects all";
        }
    }
    // At alpha = 1 and normal view D = 1 / pi and V = 1 / (2 (1 + N.l)), so the albedo is the integral of x / (1 + x).
    EXPECT_NEAR(directionalAlbedo(vec3(1.0f), 1.0f, 1.0f, viewAt(1.0f)).x, 1.0f - std::log(2.0f), 1e-3f);
}

// White dielectrics, diffuse and specular together. glTF weighs the diffuse part by 1 - F(v.h), which is less than the
// specular lobe takes when the view grazes a smooth surface: the model itself gains energy there (bounded below). From
// 60 degrees down to the normal it does not.
TEST(Brdf, WhiteFurnaceOfDielectrics)
{
    for (const float roughness : {0.0f, 0.2f, 0.5f, 0.8f, 1.0f}) {
        for (const float cosine : {0.6f, 0.8f, 0.95f}) {
            const float albedo = directionalAlbedo(vec3(1.0f), 0.0f, roughness, viewAt(cosine)).x;
            EXPECT_LE(albedo, 1.01f) << "roughness " << roughness << " cosine " << cosine;
            EXPECT_GE(albedo, 0.93f) << "roughness " << roughness << " cosine " << cosine;
        }
        EXPECT_LE(directionalAlbedo(vec3(1.0f), 0.0f, roughness, viewAt(0.3f)).x, 1.16f);
        EXPECT_LE(directionalAlbedo(vec3(1.0f), 0.0f, roughness, viewAt(0.1f)).x, 1.56f);
    }
}

TEST(Brdf, BlackReflectsOnlyFresnel)
{
    EXPECT_NEAR(directionalAlbedo(vec3(0.0f), 0.0f, 0.1f, viewAt(0.999f)).x, 0.04f, 0.002f);
    EXPECT_LT(directionalAlbedo(vec3(0.0f), 1.0f, 0.5f, viewAt(0.999f)).x, 1e-4f);
}

TEST(Brdf, Reciprocal)
{
    uint32_t state = 1;
    const auto unit = [&] {
        state = state * 1664525u + 1013904223u;
        return float(state >> 8) * 0x1.0p-24f;
    };
    for (int n = 0; n < 2000; ++n) {
        const vec3 a = sampleCosineHemisphere({unit(), unit()});
        const vec3 b = sampleCosineHemisphere({unit(), unit()});
        if (a.z < 0.01f || b.z < 0.01f) continue;
        const vec3 color(unit(), unit(), unit());
        const float metallic = unit();
        const float roughness = unit();
        const vec3 ab = reflectLight(color, metallic, roughness, 1.0f, kNormal, a, b, vec3(1.0f)) / b.z;
        const vec3 ba = reflectLight(color, metallic, roughness, 1.0f, kNormal, b, a, vec3(1.0f)) / a.z;
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(ab[c], ba[c], 1e-5f + 2e-3f * std::abs(ab[c]));
    }
}

TEST(Brdf, NothingFromBelow)
{
    EXPECT_EQ(reflectLight(vec3(1), 0, 0.5f, 1.0f, kNormal, viewAt(0.5f), normalize(vec3(0.1f, 0, -1)), vec3(1)),
              vec3(0));
}

// The density of microfacet normals, projected, is 1: Walter et al. 2007, eq. 4.
TEST(Brdf, GgxIsNormalized)
{
    for (const float alpha : {0.05f, 0.25f, 1.0f}) {
        double sum = 0.0;
        const int steps = 200000;
        for (int i = 0; i < steps; ++i) {
            // In s = tan(theta), evenly in atan(s / alpha), where the integrand is smooth.
            const double x = (i + 0.5) / steps * (0.5 * double(kPi));
            const double tangent = double(alpha) * std::tan(x);
            const double cosine = 1.0 / std::sqrt(1.0 + tangent * tangent);
            const double dTheta =
                cosine * cosine * double(alpha) / (std::cos(x) * std::cos(x)) * (0.5 * double(kPi) / steps);
            const double sine = tangent * cosine;
            sum += double(distributionGgx(float(cosine), alpha)) * cosine * 2.0 * double(kPi) * sine * dTheta;
        }
        EXPECT_NEAR(sum, 1.0, 5e-3) << alpha;
    }
}

TEST(Brdf, FresnelEnds)
{
    EXPECT_EQ(fresnelSchlick(vec3(0.04f), 1.0f, 1.0f), vec3(0.04f));
    EXPECT_EQ(fresnelSchlick(vec3(0.04f), 1.0f, 0.0f), vec3(1.0f));
}

// "The division by pi is stated once": a white diffuse surface under irradiance E has radiance E / pi.
TEST(Brdf, DiffuseRadianceOfIrradiance)
{
    EXPECT_NEAR(diffuseRadiance(vec3(0.5f), vec3(2.0f * kShadingPi)).x, 1.0f, 1e-6f);
}

TEST(Brdf, EnvironmentFitFollowsIntegration)
{
    for (const float roughness : {0.0f, 0.1f, 0.3f, 0.5f, 0.7f, 0.9f, 1.0f}) {
        for (const float cosine : {0.1f, 0.2f, 0.35f, 0.5f, 0.7f, 0.9f, 1.0f}) {
            for (const float f0 : {0.04f, 0.5f, 0.9f, 1.0f}) {
                const float truth = directionalAlbedo(vec3(f0), 1.0f, roughness, viewAt(cosine)).x;
                EXPECT_NEAR(environmentSpecular(vec3(f0), 1.0f, roughness, cosine).x / truth, 1.0f,
                            cosine < 0.15f ? 0.1f : 0.06f)
                    << roughness << " " << cosine << " " << f0;
            }
        }
    }
}

// Diffuse and specular together: what a dull dielectric sends to the view of uniform light, to half a percent.
TEST(Brdf, DullDielectricInUniformLightFollowsIntegration)
{
    for (const float cosine : {0.1f, 0.3f, 0.6f, 0.9f, 1.0f}) {
        for (const float color : {0.2f, 0.8f, 1.0f}) {
            const vec3 f0 = specularF0Of(vec3(color), 0.0f, 1.0f);
            const float sum = color * diffuseShare(f0, 1.0f, cosine).x + environmentSpecular(f0, 1.0f, 1.0f, cosine).x;
            EXPECT_NEAR(sum, directionalAlbedo(vec3(color), 0.0f, 1.0f, viewAt(cosine)).x, 0.005f)
                << cosine << " " << color;
        }
    }
}

TEST(Brdf, AverageSpecularFollowsIntegration)
{
    constexpr int kViews = 12;
    for (const float roughness : {0.0f, 0.25f, 0.5f, 0.75f, 1.0f}) {
        for (const float f0 : {0.0f, 0.04f, 0.5f, 1.0f}) {
            double truth = 0.0;
            for (int i = 0; i < kViews; ++i) { // evenly in cosine squared: each view counts by its cosine
                const float cosine = std::sqrt((float(i) + 0.5f) / kViews);
                truth += double(directionalAlbedo(vec3(f0), 1.0f, roughness, viewAt(cosine)).x) / kViews;
            }
            // White rooms reflect light tens of times: an error of a dielectric's share is as much of their light.
            const double tolerance = f0 < 0.1f && roughness >= 0.5f ? 0.001 : 0.01;
            EXPECT_NEAR(averageSpecular(vec3(f0), 1.0f, roughness).x, truth, tolerance) << roughness << " " << f0;
        }
    }
}

TEST(Brdf, PartsAddUpToTheWhole)
{
    const vec3 n(0, 1, 0);
    const vec3 v = viewAt(0.4f);
    for (const float metallic : {0.0f, 0.6f, 1.0f}) {
        for (const vec3 l :
             {glm::normalize(vec3(0.3f, 0.5f, -0.2f)), glm::normalize(vec3(-1, 0.2f, 0)), vec3(0, 1, 0)}) {
            const vec3 color(0.7f, 0.3f, 0.5f);
            const vec3 f0 = specularF0Of(color, metallic, 0.8f);
            const float f90 = specularF90Of(metallic, 0.8f);
            const vec3 f = fresnelSchlick(f0, f90, glm::dot(v, glm::normalize(l + v)));
            const vec3 light(2.0f);
            const vec3 diffuse = (1.0f - f) * diffuseAlbedoOf(color, metallic) * light * (glm::dot(n, l) / kShadingPi);
            const vec3 sum = diffuse + reflectSpecular(f0, f90, 0.25f, n, v, l, light);
            const vec3 whole = reflectLight(color, metallic, 0.5f, 0.8f, n, v, l, light);
            for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c], whole[c], 1.0e-5f * whole[c]);
        }
    }
}

TEST(Brdf, AverageDiffuseShareIsTheMeanOverViews)
{
    constexpr int kViews = 1000;
    for (const float f0 : {0.0f, 0.04f, 0.5f}) {
        double truth = 0.0;
        for (int i = 0; i < kViews; ++i) { // evenly in cosine squared: each view counts by its cosine
            truth += double(diffuseShare(vec3(f0), 1.0f, std::sqrt((float(i) + 0.5f) / kViews)).x) / kViews;
        }
        EXPECT_NEAR(averageDiffuseShare(vec3(f0), 1.0f).x, truth, 2.0e-5) << f0;
    }
}

TEST(Brdf, TransportAlbedoIsThatOfTheDielectricOrTheMetal)
{
    const vec3 color(0.9f, 0.5f, 0.1f);
    EXPECT_EQ(transportAlbedo(color, 0.0f, 0.3f), color);
    EXPECT_EQ(transportAlbedo(color, 1.0f, 0.3f), averageSpecular(color, 1.0f, 0.3f));
    for (int i = 0; i <= 100; ++i) EXPECT_LE(transportAlbedo(vec3(1.0f), 1.0f, float(i) * 0.01f).x, 1.0f);
}

} // namespace
} // namespace halflight::shading::brdf_test
