// S33. Light by component: components add up to the sum, and each alone is as good as a bake of its lights alone.

#include "bake/test_scene.h"

#include "halflight/shading/color.h"

#include <gtest/gtest.h>

#include <cmath>

namespace halflight::test::components_test {
namespace {

constexpr int kPage = 64;
constexpr int kComponents = 5;

/// A room open to one side: a bright lamp, a dim baked lamp, a panel that emits, a sky, and a lamp of no group.
Scene room()
{
    Scene scene;
    const int grey = addMaterial(scene, vec3(0.6f, 0.55f, 0.5f));
    addBox(scene, vec3(-2, 0, -2), vec3(2, 3, 2), grey, true, kPage);
    scene.objects.erase(scene.objects.begin() + 3); // an opening
    const int post = addMaterial(scene, vec3(0.3f), vec3(0.0f), true);
    addRectangle(scene, {vec3(-0.3f, 0, 0), vec3(0.6f, 0, 0), vec3(0, 2, 0)}, post, kPage);
    const int panel = addMaterial(scene, vec3(0.5f), vec3(20, 10, 5));
    addRectangle(scene, {vec3(-1, 1, -1.99f), vec3(0.5f, 0, 0), vec3(0, 0.5f, 0)}, panel, kPage);
    scene.lights.push_back(pointAt("bright", vec3(1, 2.5f, 1), 0.0f, 500.0f));
    scene.lights.push_back(pointAt("dim", vec3(-1.5f, 0.5f, 1.5f), 0.0f, 5.0f));
    scene.lights.back().mode = LightMode::Baked;
    scene.lights.push_back(pointAt("rest", vec3(1.5f, 0.5f, -1.5f), 0.0f, 50.0f));
    scene.sky = {vec3(5, 6, 8), vec3(4), vec3(1)};
    return scene;
}

LightComponents componentsOf(const Scene& scene)
{
    LightComponents components{kComponents, {1, 2, 0}, std::vector<int>(scene.materials.size(), 0), {4, 4, 4}};
    components.ofMaterial[2] = 3;
    return components;
}

/// The scene with the light of one component alone.
Scene only(int component)
{
    Scene scene = room();
    const LightComponents components = componentsOf(scene);
    for (std::size_t i = 0; i < scene.lights.size(); ++i)
        if (components.ofLight[i] != component) scene.lights[i].intensity = 0.0f;
    for (std::size_t i = 0; i < scene.materials.size(); ++i)
        if (components.ofMaterial[i] != component) scene.materials[i].emissiveNits = vec3(0.0f);
    if (components.ofSky[0] != component) scene.sky = {};
    return scene;
}

IntegrationSettings settingsOf(IntegratorKind kind, int samples)
{
    IntegrationSettings settings;
    settings.integrator = kind;
    settings.samples = samples;
    settings.shadowSamples = 16;
    settings.bounces = 8;
    return settings;
}

struct Estimates {
    std::vector<IrradianceEstimate> all;
    std::vector<IrradianceEstimate> components;

    [[nodiscard]] std::vector<vec3> of(int component) const
    {
        std::vector<vec3> light;
        for (std::size_t i = 0; i < all.size(); ++i)
            light.push_back(components[i * kComponents + std::size_t(component)].irradiance);
        return light;
    }
};

Estimates bakeComponents(IntegrationSettings settings)
{
    settings.components = componentsOf(room());
    Bench bench(room(), MixedLightingMode::Shadowmask, kPage, settings);
    const std::size_t count = bench.map.texels.size();
    Estimates estimates{std::vector<IrradianceEstimate>(count), std::vector<IrradianceEstimate>(count * kComponents)};
    bench.lightmap = bench.integrator->prepare(bench.map, nullptr);
    EXPECT_TRUE(bench.lightmap->irradianceByComponent({allIndices(count)}, estimates.all, estimates.components, {}));
    return estimates;
}

std::vector<vec3> bakeAlone(Scene scene, const IntegrationSettings& settings)
{
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
    std::vector<vec3> light;
    for (const IrradianceEstimate& e : bench.irradiance()) light.push_back(e.irradiance);
    return light;
}

double meanOf(const std::vector<vec3>& light)
{
    double sum = 0.0;
    for (const vec3 texel : light) sum += double(luminance(texel)) / double(light.size());
    return sum;
}

/// Root mean square difference over the mean of the truth.
double errorOf(const std::vector<vec3>& light, const std::vector<vec3>& truth)
{
    double squares = 0.0;
    for (std::size_t i = 0; i < light.size(); ++i) {
        const double off = double(luminance(light[i])) - double(luminance(truth[i]));
        squares += off * off / double(light.size());
    }
    return std::sqrt(squares) / meanOf(truth);
}

class ComponentsS33 : public testing::TestWithParam<IntegratorKind> {};
INSTANTIATE_TEST_SUITE_P(Transport, ComponentsS33, testing::Values(IntegratorKind::Cache, IntegratorKind::Path),
                         [](const auto& info) { return info.param == IntegratorKind::Cache ? "Cache" : "Path"; });

TEST_P(ComponentsS33, AddUpToTheSum)
{
    const int samples = GetParam() == IntegratorKind::Path ? 1024 : 64; // of whole paths, whose mean is noisy
    const Estimates estimates = bakeComponents(settingsOf(GetParam(), samples));
    double mean = 0.0;
    for (std::size_t i = 0; i < estimates.all.size(); ++i) {
        vec3 sum(0.0f);
        vec3 moment(0.0f);
        for (std::size_t c = 0; c < kComponents; ++c) {
            sum += estimates.components[i * kComponents + c].irradiance;
            moment += estimates.components[i * kComponents + c].moment;
        }
        const IrradianceEstimate& all = estimates.all[i];
        const float light = luminance(all.irradiance);
        ASSERT_LE(glm::length(sum - all.irradiance), 1.0e-5f * light) << "texel " << i;
        ASSERT_LE(glm::length(moment - all.moment), 1.0e-4f * light) << "texel " << i;
        mean += double(light) / double(estimates.all.size());
    }
    const double whole = meanOf(bakeAlone(room(), settingsOf(GetParam(), samples)));
    EXPECT_NEAR(mean / whole, 1.0, 0.003);
}

TEST_P(ComponentsS33, EachAloneIsAsGoodAsItsOwnBake)
{
    const IntegrationSettings settings = settingsOf(GetParam(), 64);
    const Estimates estimates = bakeComponents(settings);
    double all = 0.0;
    for (int c = 0; c < kComponents; ++c) all += meanOf(estimates.of(c));
    for (int c = 0; c < kComponents; ++c) {
        IntegrationSettings fine = settingsOf(IntegratorKind::Cache, 2048);
        fine.seed = 77;
        const std::vector<vec3> truth = bakeAlone(only(c), fine);
        const double own = errorOf(bakeAlone(only(c), settings), truth);
        const double inSum = errorOf(estimates.of(c), truth);
        const double share = meanOf(truth) / all;
        EXPECT_NEAR(meanOf(estimates.of(c)) / meanOf(truth), 1.0, 0.02) << "component " << c;
        EXPECT_LE(inSum, (share >= 0.05 ? 2.0 : 3.0) * own) << "component " << c;
    }
}

TEST(ComponentsOfProbesS33, AddUpToTheSum)
{
    IntegrationSettings settings = settingsOf(IntegratorKind::Cache, 16);
    settings.components = componentsOf(room());
    Bench bench(room(), MixedLightingMode::Shadowmask, kPage, settings);
    const std::vector<vec3> places = {vec3(0, 1, 1), vec3(-1, 2, -1), vec3(1, 0.5f, 0.5f)};
    const std::vector<uint32_t> which = {2, 0, 1};
    std::vector<ProbeEstimate> out(places.size());
    std::vector<SphericalHarmonicsL2> components(places.size() * kComponents);
    ASSERT_TRUE(bench.integrator->probesByComponent(places, which, 1024, out, components, {}));
    for (std::size_t p = 0; p < places.size(); ++p) {
        for (std::size_t i = 0; i < 9; ++i) {
            vec3 sum(0.0f);
            for (std::size_t c = 0; c < kComponents; ++c) sum += components[p * kComponents + c][i];
            EXPECT_LE(glm::length(sum - out[p].radiance[i]), 1.0e-4f * luminance(out[p].radiance[0]));
        }
        for (std::size_t c = 0; c < kComponents; ++c) EXPECT_GT(luminance(components[p * kComponents + c][0]), 0.0f);
    }
    // Choices of lights differ from those without components, means do not.
    Bench whole(room(), MixedLightingMode::Shadowmask, kPage, settingsOf(IntegratorKind::Cache, 16));
    std::vector<ProbeEstimate> expected(places.size());
    constexpr int kPaths = 65536;
    ASSERT_TRUE(whole.integrator->probes(places, which, kPaths, expected, {}));
    ASSERT_TRUE(bench.integrator->probesByComponent(places, which, kPaths, out, components, {}));
    for (std::size_t p = 0; p < places.size(); ++p)
        EXPECT_NEAR(luminance(out[p].radiance[0]) / luminance(expected[p].radiance[0]), 1.0, 0.01);
}

} // namespace
} // namespace halflight::test::components_test
