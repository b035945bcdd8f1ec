// The fast integrator against the unbiased one, its light sampling against sums over all lights, and its adaptive
// sampling against its target (spec S6, S8).

#include "bake/gather.h"
#include "bake/test_scene.h"

#include "bake_cpu/sample/stratified_pattern.h"
#include "bake_cpu/sample/light_tree.h"
#include "bake_cpu/sample/path_tracer.h"

#include "halflight/base/parallel.h"
#include "halflight/base/random.h"
#include "halflight/shading/sh.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <map>

namespace halflight::test {
namespace {

constexpr int kPage = 64;

/// A room with a block, a lamp under the ceiling, a sun through a missing wall, and a sky.
Scene room(bool lamp, bool sun, bool sky)
{
    Scene scene;
    const int white = addMaterial(scene, vec3(0.7f));
    const int red = addMaterial(scene, vec3(0.6f, 0.1f, 0.1f));
    addRectangle(scene, {vec3(-1, 0, 1), vec3(2, 0, 0), vec3(0, 0, -2)}, white, kPage, {vec2(1), vec2(21)});
    addRectangle(scene, {vec3(-1, 2, -1), vec3(2, 0, 0), vec3(0, 0, 2)}, white, kPage, {vec2(24, 1), vec2(44, 21)});
    addRectangle(scene, {vec3(-1, 0, -1), vec3(2, 0, 0), vec3(0, 2, 0)}, white, kPage, {vec2(1, 24), vec2(21, 44)});
    addRectangle(scene, {vec3(-1, 0, 1), vec3(0, 0, -2), vec3(0, 2, 0)}, red, kPage, {vec2(24, 24), vec2(44, 44)});
    addBox(scene, vec3(-0.2f, 0.0f, -0.4f), vec3(0.4f, 0.9f, 0.1f), white, false);
    // The box's faces have texels of their own but for one, where paths find no cache.
    for (int i = 0; i < 5; ++i) {
        Object& face = scene.objects[scene.objects.size() - 6 + std::size_t(i)];
        MeshPart& part = scene.meshes[std::size_t(face.mesh)].parts[0];
        const vec2 a(46.0f / kPage, (1.0f + 12.0f * float(i)) / kPage);
        const vec2 b = a + 10.0f / kPage;
        part.lightmapUv = {a, {b.x, a.y}, b, {a.x, b.y}};
        face.lightmap.page = 0;
    }
    if (lamp) {
        const int glow = addMaterial(scene, vec3(0.0f), vec3(12.0f));
        addRectangle(scene, {vec3(-0.3f, 1.95f, -0.3f), vec3(0.6f, 0, 0), vec3(0, 0, 0.6f)}, glow, kPage);
    }
    if (sun) {
        scene.lights.push_back(
            makeLight(LightType::Directional, vec3(0), vec3(-0.6f, -0.8f, -0.5f), 8.0f, LightMode::Mixed));
        scene.lights.push_back(
            makeLight(LightType::Point, vec3(0.6f, 1.2f, 0.5f), vec3(0, -1, 0), 1.0f, LightMode::Baked));
        scene.lights.back().radiusMeters = 0.1f;
    }
    if (sky) scene.sky = {vec3(1.0f), vec3(0.6f), vec3(0.2f)};
    return scene;
}

std::vector<IrradianceEstimate> bakeWith(Scene scene, IntegratorKind kind, int samples, int bounces, float noise = 0.0f)
{
    IntegrationSettings settings;
    settings.integrator = kind;
    settings.samples = samples;
    settings.shadowSamples = 64;
    settings.bounces = bounces;
    settings.noiseTarget = noise;
    settings.seed = kind == IntegratorKind::Path ? 7 : 1;
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
    return bench.irradiance();
}

struct Difference {
    double bias = 0.0; ///< of the mean
    double rmse = 0.0; ///< over the mean
    double momentBias = 0.0;
};

Difference difference(const std::vector<IrradianceEstimate>& a, const std::vector<IrradianceEstimate>& reference)
{
    Difference d;
    double mean = 0.0;
    double moment = 0.0;
    for (std::size_t i = 0; i < reference.size(); ++i) {
        if (!reference[i].valid || !a[i].valid) continue;
        const double l = double(luminance(a[i].irradiance)) - double(luminance(reference[i].irradiance));
        d.bias += l;
        d.rmse += l * l;
        mean += double(luminance(reference[i].irradiance));
        d.momentBias += double(glm::length(a[i].moment)) - double(glm::length(reference[i].moment));
        moment += double(glm::length(reference[i].moment));
    }
    const auto n = double(reference.size());
    return {d.bias / mean, std::sqrt(d.rmse / n) / (mean / n), d.momentBias / moment};
}

/// Noisy probes, denoised, against ones of many paths at the same places: less error, in light and in the direction it
/// comes from, and no light from where there is none.
TEST(ProbesS14, DenoisingComesCloserInLightAndDirection)
{
    const auto probesOf = [&](int samples, bool denoise) {
        IntegrationSettings settings;
        settings.integrator = IntegratorKind::Path;
        settings.probeSamples = samples;
        settings.bounces = 3;
        Bench bench(room(true, true, false), MixedLightingMode::Shadowmask, kPage, settings);
        std::vector<std::string> warnings;
        const Gather gather{*bench.integrator, bench.geometry, bench.map, settings};
        std::map<std::array<float, 3>, Probe> byPlace; // refinement depends on noise, the first grid does not
        const auto set = bakeProbes(bench.scene, 0.3f, denoise, gather, warnings, {});
        for (const Probe& probe : set.value().probes)
            byPlace[{probe.position.x, probe.position.y, probe.position.z}] = probe;
        return byPlace;
    };
    const auto truth = probesOf(4096, false);
    struct Errors {
        double light = 0.0;     ///< sum of squares over all coefficients
        double direction = 0.0; ///< sum of 1 - cosine between mean directions
        double negative = 0.0;  ///< sum of the lowest irradiance of any direction where that is below 0
    };
    const auto errorsOf = [&](const auto& probes) {
        Errors errors;
        int compared = 0;
        for (const auto& [place, probe] : probes) {
            const auto found = truth.find(place);
            if (found == truth.end()) continue;
            ++compared;
            const auto directionOf = [](const Probe& p) { // of the linear band
                return vec3(luminance(p.radiance[3]), luminance(p.radiance[1]), luminance(p.radiance[2]));
            };
            for (std::size_t k = 0; k < 9; ++k) {
                const vec3 d = probe.radiance[k] - found->second.radiance[k];
                errors.light += double(glm::dot(d, d));
            }
            errors.direction +=
                1.0 - double(glm::dot(glm::normalize(directionOf(probe)), glm::normalize(directionOf(found->second))));
            for (int i = 0; i < 64; ++i) {
                const float z = 1.0f - 2.0f * (float(i) + 0.5f) / 64.0f;
                const float phi = 2.39996323f * float(i); // golden angle
                const vec3 n(std::sqrt(1.0f - z * z) * vec2(std::cos(phi), std::sin(phi)), z);
                vec3 irradiance(0.0f);
                for (int k = 0; k < 9; ++k)
                    irradiance += probe.radiance[std::size_t(k)] * shading::shIrradianceWeight(k, n);
                errors.negative += std::min(0.0, double(luminance(irradiance)));
            }
        }
        EXPECT_GT(compared, 200);
        return errors;
    };
    const Errors raw = errorsOf(probesOf(64, false));
    const Errors denoised = errorsOf(probesOf(64, true));
    EXPECT_LT(denoised.light, 0.7 * raw.light);
    EXPECT_LT(denoised.direction, 0.6 * raw.direction);
    EXPECT_GE(denoised.negative, raw.negative);
}

/// The mean within 1 % of path tracing's, and no texel-sized errors beyond the noise of both.
TEST(RadianceCacheS6, AgreesWithPathTracing)
{
    for (const auto& [lamp, sun, sky, bounces] : {std::array{1, 0, 0, 4}, {0, 1, 0, 1}, {0, 0, 1, 2}, {1, 1, 1, 4}}) {
        const auto reference = bakeWith(room(lamp, sun, sky), IntegratorKind::Path, 192, bounces);
        const auto cached = bakeWith(room(lamp, sun, sky), IntegratorKind::Cache, 256, bounces);
        const Difference d = difference(cached, reference);
        SCOPED_TRACE(testing::Message() << "lamp " << lamp << " sun " << sun << " sky " << sky << " bounces "
                                        << bounces);
        EXPECT_LT(std::abs(d.bias), 0.01);
        EXPECT_LT(d.rmse, 0.07);
        EXPECT_LT(std::abs(d.momentBias), 0.02);
    }
}

/// A dark room, four metres wide, in which lamps light two spots on the floor. Its ceiling and walls receive light from
/// there alone.
struct LitSpots {
    static constexpr float kWidth = 4.0f;
    static constexpr float kHeight = 3.0f;
    static constexpr float kAlbedo = 0.8f;
    /// Of the floor, above nothing but black: none, all of one half, or every other square of a fine pattern.
    enum class Holes { None, Half, Pattern };
    Scene scene;
    Holes holes;

    /// `glows`: the floor is a light source, though a faint one. `sunlit`: walls are black, and lit far brighter than
    /// the floor lights them.
    explicit LitSpots(Holes floorHoles, bool glows = false, bool sunlit = false) : holes(floorHoles)
    {
        const int white = addMaterial(scene, vec3(kAlbedo));
        const int black = addMaterial(scene, vec3(0.0f));
        const int wall = sunlit ? black : white;
        int floor = glows ? addMaterial(scene, vec3(kAlbedo), vec3(1.0e-6f)) : white;
        if (holes != Holes::None) {
            const int size = holes == Holes::Half ? 2 : 128;
            ImageRgba8 pixels(size, size, u8vec4(255));
            for (int y = 0; y < size; ++y) {
                for (int x = holes == Holes::Half ? 1 : y % 2; x < size; x += 2) pixels(x, y).w = 0;
            }
            floor = addMaterialWithHoles(scene, vec3(kAlbedo), std::move(pixels), true);
        }
        const vec3 x(kWidth, 0, 0);
        const vec3 y(0, kHeight, 0);
        const vec3 z(0, 0, kWidth);
        // The floor's u goes along x: its first half has no holes.
        addRectangle(scene, {z, x, -z}, floor, kPage, {vec2(1), vec2(29)});
        addRectangle(scene, {vec3(0, -1, 0) + z, x, -z}, black, kPage);
        addRectangle(scene, {y, x, z}, wall, kPage, {vec2(31, 1), vec2(45, 15)});
        addRectangle(scene, {vec3(0), x, y}, wall, kPage, {vec2(47, 1), vec2(61, 15)});
        addRectangle(scene, {z + x, -x, y}, wall, kPage, {vec2(31, 17), vec2(45, 31)});
        addRectangle(scene, {z, -z, y}, wall, kPage, {vec2(47, 17), vec2(61, 31)});
        addRectangle(scene, {x, z, y}, wall, kPage, {vec2(1, 31), vec2(15, 45)});
        if (sunlit) {
            for (const vec3 direction : {vec3(1, 0, 1), vec3(-1, 0, -1)}) {
                Light sun =
                    makeLight(LightType::Directional, vec3(0), glm::normalize(direction), 10000.0f, LightMode::Mixed);
                sun.castShadows = false;
                scene.lights.push_back(sun);
            }
        }
        for (const float at : {0.25f, 0.75f}) {
            Light lamp = makeLight(LightType::Spot, vec3(at * kWidth, kHeight - 0.2f, 0.5f * kWidth), vec3(0, -1, 0),
                                   1000.0f, LightMode::Mixed);
            // Without a sharp rim, which few texels would show roughly.
            lamp.innerConeRadians = 0.0f;
            lamp.outerConeRadians = 0.2f;
            scene.lights.push_back(lamp);
        }
    }

    /// What a place receives from the floor after one reflection, summed over the floor.
    [[nodiscard]] double illuminance(vec3 position, vec3 normal) const
    {
        constexpr int kSteps = 100;
        constexpr float kRadius = 0.6f;
        double sum = 0.0;
        for (const PunctualLight& lamp : punctualLights(scene, LightUse::Bake)) {
            if (lamp.type == shading::kLightDirectional) continue; // along the floor
            if (holes == Holes::Half && lamp.position.x > 0.5f * kWidth) continue;
            for (int i = 0; i < kSteps * kSteps; ++i) {
                const vec2 u((float(i % kSteps) + 0.5f) / float(kSteps), (float(i / kSteps) + 0.5f) / float(kSteps));
                const vec2 at = vec2(lamp.position.x, lamp.position.z) + kRadius * (2.0f * u - 1.0f);
                const vec3 p(at.x, 0.0f, at.y);
                const shading::LightSample s = lamp.at(p);
                const vec3 way = position - p;
                const float d2 = glm::dot(way, way);
                const float cosines = std::max(way.y, 0.0f) * std::max(-glm::dot(way, normal), 0.0f) / d2;
                sum += double(s.illuminance.y * s.direction.y * kAlbedo / kPi * cosines / d2);
            }
        }
        const double share = holes == Holes::Pattern ? 0.5 : 1.0;
        return share * sum * double(4.0f * kRadius * kRadius) / double(kSteps * kSteps);
    }
};

/// Where one ray in a hundred meets what is bright, 32 rays would be off by more than 100 %: the gather looks there
/// with little noise, and counts nothing twice. Light comes from where there is no hole.
TEST(GuidesS6, LitSpotsAreNoNoise)
{
    struct Case {
        LitSpots::Holes holes;
        bool glows;
        bool sunlit;
        double bias;
        double noise;
    };
    // Samples that are lost on holes cost some noise.
    for (const auto& [holes, glows, sunlit, mostBias, mostNoise] :
         {Case{LitSpots::Holes::None, false, false, 0.015, 0.12},
          {LitSpots::Holes::None, true, false, 0.015, 0.12},
          {LitSpots::Holes::None, false, true, 0.015, 0.12},
          {LitSpots::Holes::Half, false, false, 0.015, 0.35},
          {LitSpots::Holes::Pattern, false, false, 0.04, 0.9}}) {
        SCOPED_TRACE(testing::Message() << "holes " << int(holes) << (glows ? ", glows" : "")
                                        << (sunlit ? ", sunlit" : ""));
        IntegrationSettings settings;
        settings.samples = 32;
        settings.shadowSamples = 8;
        settings.bounces = 1;
        double bias = 0.0;
        double squares = 0.0;
        double sum = 0.0;
        int count = 0;
        for (const uint32_t seed : {1u, 2u, 3u, 4u}) {
            settings.seed = seed;
            LitSpots spots(holes, glows, sunlit);
            Bench bench(spots.scene, MixedLightingMode::Shadowmask, kPage, settings);
            const auto estimates = bench.irradiance();
            for (std::size_t i = 0; i < estimates.size(); ++i) {
                const Texel& texel = bench.map.texels[i];
                const SurfacePoint point =
                    surfacePoint(bench.geometry, bench.map.fragments[texel.firstFragment].triangle,
                                 bench.map.fragments[texel.firstFragment].barycentric);
                if (point.normal.y > 0.5f || !estimates[i].valid) continue;
                const double truth = spots.illuminance(bench.positionOf(texel), point.normal);
                const double error = double(estimates[i].irradiance.y) - truth;
                bias += error;
                squares += error * error;
                sum += truth;
                ++count;
            }
        }
        ASSERT_GT(count, 2000);
        EXPECT_LT(std::abs(bias), mostBias * sum);
        EXPECT_LT(std::sqrt(squares / count), mostNoise * sum / count);
    }
}

/// A small sunlit board at the end of a wide black floor, before a large wall that may reflect a little.
class BoardFromAfar {
public:
    explicit BoardFromAfar(float wallAlbedo, int divisions = 1, int meters = 16)
        : wallAlbedo_(wallAlbedo), divisions_(divisions), meters_(meters)
    {}

    /// Of the floor's light eight metres from the board and more, over the truth.
    struct Errors {
        double bias = 0.0;
        double noise = 0.0; ///< root mean square
        double dark = 0.0;  ///< share of the texels that are all but black
    };
    [[nodiscard]] Errors errors() const
    {
        const int size = meters_ > 16 ? 1024 : 256;
        const auto length = float(meters_);
        Scene scene;
        const int black = addMaterial(scene, vec3(0.0f));
        addRectangle(scene, {vec3(-8, 0, length - 8), vec3(16, 0, 0), vec3(0, 0, -length)}, black, size,
                     {vec2(1), vec2(161, 1 + 10 * meters_)});
        addRectangle(scene, board_, addMaterial(scene, vec3(kAlbedo)), size, {vec2(170, 1), vec2(234, 65)}, divisions_);
        if (wallAlbedo_ > 0.0f) {
            addRectangle(scene, wall_, addMaterial(scene, vec3(wallAlbedo_)), size, {vec2(1, 165), vec2(41, 205)});
        }
        scene.lights.push_back(makeLight(LightType::Directional, vec3(0), -toSun_, kLux, LightMode::Mixed));
        IntegrationSettings settings;
        settings.samples = 32;
        settings.bounces = 1;
        Bench bench(std::move(scene), MixedLightingMode::Shadowmask, size, settings);
        const auto estimates = bench.irradiance();
        Errors errors;
        int count = 0;
        for (std::size_t i = 0; i < estimates.size(); ++i) {
            const vec3 point = bench.positionOf(bench.map.texels[i]);
            if (point.y > 0.0f || point.z < 0.0f) continue;
            const double error = double(estimates[i].irradiance.y) / truthAt(point) - 1.0;
            errors.dark += error < -0.9 ? 1.0 : 0.0;
            errors.bias += error;
            errors.noise += error * error;
            ++count;
        }
        EXPECT_GT(count, 10000);
        return {errors.bias / count, std::sqrt(errors.noise / count), errors.dark / count};
    }

private:
    static constexpr float kAlbedo = 0.8f;
    static constexpr float kLux = 10.0f;

    /// What a rectangle of radiance one brings to a point of the floor. Lambert 1760, "Photometria": a polygon's
    /// irradiance is a sum over its edges.
    static double from(const Rectangle& r, vec3 point)
    {
        const std::array<vec3, 4> corners = {r.origin, r.origin + r.edgeU, r.origin + r.edgeU + r.edgeV,
                                             r.origin + r.edgeV};
        double sum = 0.0;
        for (std::size_t i = 0; i < 4; ++i) {
            const auto a = glm::normalize(glm::dvec3(corners[i] - point));
            const auto b = glm::normalize(glm::dvec3(corners[(i + 1) % 4] - point));
            sum += std::acos(glm::dot(a, b)) * glm::normalize(glm::cross(a, b)).y;
        }
        return 0.5 * std::abs(sum);
    }
    [[nodiscard]] double truthAt(vec3 point) const
    {
        const double radiosity = double(kLux) * double(toSun_.z);
        // The board hides some of the wall.
        return radiosity / double(kPi) *
               (double(wallAlbedo_) * from(wall_, point) + double(kAlbedo - wallAlbedo_) * from(board_, point));
    }

    float wallAlbedo_;
    int divisions_; ///< of the board
    int meters_;    ///< that the floor is long; a texel is 0.1 wide
    vec3 toSun_ = glm::normalize(vec3(0, 1, 1));
    Rectangle board_{vec3(-0.5f, 0, -8), vec3(1, 0, 0), vec3(0, 1, 0)};
    Rectangle wall_{vec3(-30, 0, -14), vec3(60, 0, 0), vec3(0, 60, 0)};
};

/// From afar one ray in some ten thousand meets the board. That few of the rays around do is enough to aim at it, the
/// whole of it and from everywhere.
TEST(GuidesS6, SmallThingsAreSeenFromAfar)
{
    const BoardFromAfar::Errors errors = BoardFromAfar(0.0f).errors();
    EXPECT_LT(std::abs(errors.bias), 0.02);
    EXPECT_LT(errors.noise, 0.3);
    EXPECT_LT(errors.dark, 0.001);
}

/// From so far away that none of the rays of all that is within twenty metres meets the board: those beyond tell.
TEST(GuidesS6, SmallThingsAreSeenFromFarther)
{
    const BoardFromAfar::Errors errors = BoardFromAfar(0.0f, 1, 100).errors();
    EXPECT_LT(std::abs(errors.bias), 0.02);
    EXPECT_LT(errors.noise, 0.3);
    EXPECT_LT(errors.dark, 0.001);
}

/// The same of a board of many small triangles, as cloth has them: all of it is aimed at.
TEST(GuidesS6, FineMeshesAreAimedAtWhole)
{
    const BoardFromAfar::Errors errors = BoardFromAfar(0.0f, 80).errors();
    EXPECT_LT(std::abs(errors.bias), 0.02);
    EXPECT_LT(errors.noise, 0.3);
}

/// The same where a wall that everybody sees brings most of the light: who has much to aim at still hears of the board.
TEST(GuidesS6, SmallThingsAreSeenBesideLargeOnes)
{
    const BoardFromAfar::Errors errors = BoardFromAfar(0.005f).errors();
    EXPECT_LT(std::abs(errors.bias), 0.02);
    EXPECT_LT(errors.noise, 0.3);
}

/// A floor that runs on under a thin wall from daylight into a closed, dark room: no cell of the cache carries light
/// through.
TEST(RadianceCacheS6, NoLightUnderThinWalls)
{
    Scene scene;
    scene.sky = {vec3(1000), vec3(1000), vec3(1000)};
    const int white = addMaterial(scene, vec3(0.8f), vec3(0.0f), true);
    addRectangle(scene, {vec3(-4, 0, 4), vec3(8, 0, 0), vec3(0, 0, -8)}, white, kPage, {vec2(1), vec2(32)});
    // Walls and a lid of zero thickness, set into the floor where no texel's edge is.
    const vec3 lower(-1.03f, -0.1f, -1.07f);
    const vec3 upper(1.09f, 1.5f, 1.01f);
    const vec3 s = upper - lower;
    addRectangle(scene, {lower, vec3(s.x, 0, 0), vec3(0, s.y, 0)}, white, kPage, {vec2(34, 1), vec2(48, 15)});
    addRectangle(scene, {lower + vec3(0, 0, s.z), vec3(s.x, 0, 0), vec3(0, s.y, 0)}, white, kPage,
                 {vec2(34, 17), vec2(48, 31)});
    addRectangle(scene, {lower, vec3(0, 0, s.z), vec3(0, s.y, 0)}, white, kPage, {vec2(34, 33), vec2(48, 47)});
    addRectangle(scene, {lower + vec3(s.x, 0, 0), vec3(0, 0, s.z), vec3(0, s.y, 0)}, white, kPage,
                 {vec2(49, 1), vec2(63, 15)});
    addRectangle(scene, {lower + vec3(0, s.y, 0), vec3(s.x, 0, 0), vec3(0, 0, s.z)}, white, kPage,
                 {vec2(49, 17), vec2(63, 31)});
    IntegrationSettings settings;
    settings.samples = 128;
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
    const auto estimates = bench.irradiance();
    double inside = 0.0;
    int count = 0;
    for (std::size_t i = 0; i < estimates.size(); ++i) {
        const vec3 p = bench.positionOf(bench.map.texels[i]);
        if (p.y != 0.0f || glm::max(std::abs(p.x), std::abs(p.z)) > 0.8f) continue;
        inside += double(estimates[i].irradiance.y);
        ++count;
    }
    ASSERT_GT(count, 20);
    EXPECT_LT(inside / count, 0.001 * 1000.0 * kPi);
}

/// Rays end in the cache wherever they go: on the back of a cloth, on leaves without a lightmap, beside the foot of a
/// thin wall. The light is right, and few rays go on as paths.
TEST(RadianceCacheS6, KnowsBacksLeavesAndBothSidesOfAWall)
{
    Scene scene;
    scene.sky = {vec3(1.0f), vec3(0.6f), vec3(0.2f)};
    scene.lights.push_back(
        makeLight(LightType::Directional, vec3(0), vec3(-0.6f, -0.8f, -0.3f), 6.0f, LightMode::Mixed));
    const int white = addMaterial(scene, vec3(0.8f), vec3(0.0f), true);
    const int red = addMaterial(scene, vec3(0.7f, 0.2f, 0.1f), vec3(0.0f), true);
    const int green = addMaterial(scene, vec3(0.2f, 0.6f, 0.1f), vec3(0.0f), true);
    addRectangle(scene, {vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4)}, white, kPage, {vec2(1), vec2(33)});
    // The cloth's texels are on top; the floor sees its back.
    addRectangle(scene, {vec3(-1.9f, 1.2f, 1.9f), vec3(1.6f, 0, 0), vec3(0, 0.3f, -3.8f)}, red, kPage,
                 {vec2(35, 1), vec2(49, 31)});
    addRectangle(scene, {vec3(0.07f, -0.1f, -1.5f), vec3(0, 0, 3.0f), vec3(0, 0.9f, 0)}, white, kPage,
                 {vec2(1, 35), vec2(25, 43)});
    for (int i = 0; i < 150; ++i) {
        const auto random = [&](int k) { return unitFloat(hashCombine(uint32_t(i), uint32_t(k))); };
        const vec3 corner(0.6f + random(0), 0.1f + 0.8f * random(1), -0.8f + 1.6f * random(2));
        const vec3 along = 0.12f * glm::normalize(vec3(random(3), random(4), random(5)) - 0.5f);
        const vec3 across = 0.12f * glm::normalize(glm::cross(along, vec3(random(6), random(7), random(8))));
        addRectangle(scene, {corner, along, across}, green, kPage);
    }
    IntegrationSettings settings;
    settings.bounces = 3;
    settings.samples = 128;
    settings.shadowSamples = 16;
    Bench bench(scene, MixedLightingMode::Shadowmask, kPage, settings);
    const auto cached = bench.irradiance();
    const uint64_t first = bench.integrator->raysTraced();
    bench.irradiance(); // with the cache as it is
    const double perSample =
        double(bench.integrator->raysTraced() - first) / (double(cached.size()) * double(settings.samples));
    EXPECT_LT(perSample, 1.1);
    const auto reference = bakeWith(scene, IntegratorKind::Path, 512, settings.bounces);
    const Difference d = difference(cached, reference);
    EXPECT_LT(std::abs(d.bias), 0.01);
    EXPECT_LT(d.rmse, 0.06);
}

/// A floor with boxes sunk into it, each with a board inside, just above the floor, that hides the box's faces from
/// there.
Bench solidsOnFloor(int page, Place place, std::span<const Bounds> boxes, IntegratorKind kind)
{
    Scene scene;
    scene.sky = {vec3(1), vec3(1), vec3(1)};
    const int white = addMaterial(scene, vec3(0.8f), vec3(0.0f), true);
    addRectangle(scene, {vec3(-4, 0, 4), vec3(8, 0, 0), vec3(0, 0, -8)}, white, page, place);
    for (const Bounds& box : boxes) {
        addBox(scene, box.min, box.max, white, false);
        const vec3 s = 0.98f * box.size();
        addRectangle(scene,
                     {vec3(box.min.x + 0.01f * s.x, 0.01f, box.min.z + 0.01f * s.z), vec3(s.x, 0, 0), vec3(0, 0, s.z)},
                     white, page);
    }
    IntegrationSettings settings;
    settings.samples = kind == IntegratorKind::Cache ? 32 : 1;
    settings.integrator = kind;
    return {std::move(scene), MixedLightingMode::Shadowmask, page, settings};
}

/// Points of a texel that lie inside a solid are left out, even where something in there hides the solid's faces.
TEST(RadianceCacheS6, LeavesOutPointsInsideSolidsThatAreNotEmpty)
{
    const Bounds box{vec3(-1.03f, -0.5f, -1.07f), vec3(1.09f, 1.5f, 1.01f)};
    Bench bench = solidsOnFloor(kPage, {vec2(1), vec2(33)}, std::span(&box, 1), IntegratorKind::Cache);
    const auto estimates = bench.irradiance();
    int across = 0;
    for (std::size_t i = 0; i < estimates.size(); ++i) {
        std::array<SurfacePoint, kMaxTexelPoints> points;
        const int count = texelPoints(bench.geometry, bench.map, bench.map.texels[i], points);
        uint32_t outside = 0;
        for (int p = 0; p < count; ++p) {
            const vec3 at = points[std::size_t(p)].position;
            const bool inside = at.x > box.min.x && at.x < box.max.x && at.z > box.min.z && at.z < box.max.z;
            outside |= inside ? 0u : 1u << p;
        }
        const int left = std::popcount(outside);
        if (left == count || left * 8 < count) continue;
        ++across;
        EXPECT_EQ(estimates[i].outsidePoints, outside) << "texel " << i;
    }
    EXPECT_GT(across, 12);
}

/// In texels that a surface covers in part too, few rays for each: the cache finds what path tracing finds, which looks
/// at all points of all texels.
TEST(RadianceCacheS6, LeavesOutPointsInsideSolidsAtTheRim)
{
    // Thin posts at the floor's rim, each somewhere else in its texel.
    constexpr float kTexel = 8.0f / 330.2f;
    std::vector<Bounds> boxes;
    for (int i = 0; i < 200; ++i) {
        const vec2 at(1.4f * float(i) + 10.0f, 330.2f - 0.6f + 0.04f * float(i % 11));
        const vec3 low(-4.0f + at.x * kTexel, -0.5f, -4.0f + at.y * kTexel);
        boxes.push_back({low, low + vec3(0.3f * kTexel, 2.0f, 0.3f * kTexel)});
    }
    constexpr Place kPlace{vec2(1.4f), vec2(331.6f)};
    const auto cached = solidsOnFloor(512, kPlace, boxes, IntegratorKind::Cache).irradiance();
    const auto paths = solidsOnFloor(512, kPlace, boxes, IntegratorKind::Path).irradiance();
    int across = 0;
    for (std::size_t i = 0; i < paths.size(); ++i) {
        if (paths[i].outsidePoints == 0xffff) continue;
        ++across;
        EXPECT_EQ(cached[i].outsidePoints, paths[i].outsidePoints) << "texel " << i;
    }
    EXPECT_GT(across, 100);
}

/// So are points inside shells, be it one of a texel: thin posts without a bottom, that nothing but their backs tells
/// of.
TEST(RadianceCacheS6, LeavesOutSinglePointsInsideShells)
{
    const auto bakeOver = [](IntegratorKind kind) {
        Scene scene;
        scene.sky = {vec3(1), vec3(1), vec3(1)};
        const int white = addMaterial(scene, vec3(0.8f));
        addRectangle(scene, {vec3(-4, 0, 4), vec3(8, 0, 0), vec3(0, 0, -8)}, white, 512, {vec2(4), vec2(340)});
        constexpr float kTexel = 8.0f / 336.0f;
        constexpr float kWidth = 0.3f * kTexel;
        for (int i = 0; i < 200; ++i) {
            const vec2 at(8.0f + 16.0f * float(i % 15) + 0.05f * float(i % 13), 8.0f + 16.0f * float(i / 15));
            const vec3 corner(-4.0f + at.x * kTexel, -0.1f, -4.0f + (at.y + 0.05f * float(i % 11)) * kTexel);
            const vec3 x(kWidth, 0, 0);
            const vec3 y(0, 1, 0);
            const vec3 z(0, 0, kWidth);
            for (const Rectangle& face : {Rectangle{corner, y, x}, Rectangle{corner + z, x, y}, Rectangle{corner, z, y},
                                          Rectangle{corner + x, y, z}, Rectangle{corner + y, z, x}}) {
                addRectangle(scene, face, white, 512);
            }
        }
        IntegrationSettings settings;
        settings.samples = kind == IntegratorKind::Cache ? 32 : 1;
        settings.integrator = kind;
        return Bench(std::move(scene), MixedLightingMode::Shadowmask, 512, settings).irradiance();
    };
    const auto cached = bakeOver(IntegratorKind::Cache);
    const auto paths = bakeOver(IntegratorKind::Path);
    int few = 0;
    int different = 0;
    for (std::size_t i = 0; i < paths.size(); ++i) {
        few += paths[i].outsidePoints != 0xffff && std::popcount(paths[i].outsidePoints) >= kMaxTexelPoints - 2 ? 1 : 0;
        different += cached[i].outsidePoints != paths[i].outsidePoints ? 1 : 0;
    }
    EXPECT_GT(few, 100);
    EXPECT_EQ(different, 0);
}

TEST(RadianceCacheS6, LargeCellsTellAsMuchByFewerTexels)
{
    // A floor of so many texels that cells are 4 x 4 of them, of which every second one gathers; a block stands in it,
    // and a wall beside it sees its light.
    constexpr int kSize = 704;
    Scene scene;
    scene.sky = {vec3(1), vec3(1), vec3(1)};
    const int grey = addMaterial(scene, vec3(0.5f));
    addRectangle(scene, {vec3(-5, 0, 5), vec3(10, 0, 0), vec3(0, 0, -10)}, grey, kSize, {vec2(2), vec2(662)});
    addRectangle(scene, {vec3(-5, 0, -5), vec3(10, 0, 0), vec3(0, 0.5f, 0)}, grey, kSize,
                 {vec2(2, 666), vec2(662, 699)});
    const std::size_t block = scene.meshes.size();
    addBox(scene, vec3(-2, -1, -2), vec3(1, 1, 2), grey, false);
    joinObjects(scene, block);
    IntegrationSettings settings;
    settings.samples = 16;
    settings.shadowSamples = 8;
    settings.texelStep = 1;
    Bench bench(scene, MixedLightingMode::Shadowmask, kSize, settings);
    const std::vector<IrradianceEstimate> estimates = bench.irradiance();
    settings.integrator = IntegratorKind::Path;
    settings.samples = 512;
    Bench truth(scene, MixedLightingMode::Shadowmask, kSize, settings);

    // 28.7 if all texels gathered for their cells, and more if none did.
    EXPECT_LT(double(bench.integrator->raysTraced()), 27.5 * double(estimates.size()));
    std::vector<uint32_t> chosen; // on the wall
    for (uint32_t i = 0; i < uint32_t(estimates.size()); ++i) {
        const vec3 at = bench.positionOf(bench.map.texels[i]);
        if (at.y > 0.01f && i % 64 == 0) chosen.push_back(i);
        // A texel is 15 mm wide.
        const float depth = std::min(1.5f - std::abs(at.x + 0.5f), 2.0f - std::abs(at.z));
        if (at.y > 0.01f || std::abs(depth) < 0.02f) continue;
        ASSERT_EQ(estimates[i].valid, depth < 0.0f) << at.x << ", " << at.z;
    }
    ASSERT_GT(chosen.size(), 200u);
    std::vector<IrradianceEstimate> traced(chosen.size());
    truth.integrator->irradiance(truth.map, {chosen}, traced, {});
    double sum = 0.0;
    double expected = 0.0;
    for (std::size_t i = 0; i < chosen.size(); ++i) {
        sum += double(estimates[chosen[i]].irradiance.y);
        expected += double(traced[i].irradiance.y);
    }
    EXPECT_NEAR(sum, expected, 0.01 * expected);
}

/// Old processors, and what virtual machines make of new ones, have no instructions for eight rays at once: lanes that
/// are not in use must not be traced there, whatever is in them, and the others meet what they meet elsewhere.
TEST(RaysS6, LanesOutOfUseAreLeftAloneOnAllProcessors)
{
    const Scene scene = room(true, true, true);
    const Bench bench(scene, MixedLightingMode::Shadowmask, kPage, {});
    const RayTracer tracer(bench.scene, bench.geometry);
    const RayTracer old(bench.scene, bench.geometry, "isa=sse2");
    ASSERT_TRUE(tracer.ok() && old.ok());
    int hits = 0;
    int blocked = 0;
    for (uint32_t packet = 0; packet < 64; ++packet) {
        RTCRayHit8 rays;
        std::memset(&rays, 0xff, sizeof(rays)); // no numbers
        embree::LaneMask valid;
        RayTracer::clear(rays.ray);
        for (int lane = 0; lane < embree::kPacket; ++lane) {
            Sampler sampler(1, packet, uint32_t(lane));
            valid.lane[lane] = sampler.next1() < 0.6f ? -1 : 0;
            if (valid.lane[lane] == 0) continue;
            embree::setRay(rays.ray, lane, bench.positionOf(bench.map.texels[packet * 7]) + vec3(0, 0.5f, 0),
                           shading::sampleSphere(sampler.next2()));
        }
        RTCRayHit8 same = rays;
        tracer.intersect(valid, rays);
        old.intersect(valid, same);
        RTCRay8 shadows = rays.ray;
        for (float& tfar : shadows.tfar) tfar *= 1.5f;
        RTCRay8 sameShadows = shadows;
        tracer.occluded(valid, shadows);
        old.occluded(valid, sameShadows);
        for (int lane = 0; lane < embree::kPacket; ++lane) {
            if (valid.lane[lane] == 0) continue;
            ASSERT_EQ(rays.hit.geomID[lane], same.hit.geomID[lane]);
            EXPECT_EQ(shadows.tfar[lane] < 0.0f, sameShadows.tfar[lane] < 0.0f);
            blocked += shadows.tfar[lane] < 0.0f ? 1 : 0;
            if (rays.hit.geomID[lane] == RTC_INVALID_GEOMETRY_ID) continue;
            ++hits;
            EXPECT_EQ(rays.hit.primID[lane], same.hit.primID[lane]);
            EXPECT_NEAR(rays.ray.tfar[lane], same.ray.tfar[lane], 1.0e-4f);
        }
    }
    EXPECT_GT(hits, 100);
    EXPECT_GT(blocked, 100);
}

TEST(RadianceCacheS6, ThreadsChangeNoBit)
{
    std::vector<IrradianceEstimate> first;
    for (const int threads : {1, 2, 5}) {
        const ThreadLimit limit(threads);
        const auto estimates = bakeWith(room(true, true, true), IntegratorKind::Cache, 64, 3, 0.05f);
        if (first.empty()) first = estimates;
        for (std::size_t i = 0; i < first.size(); ++i) {
            ASSERT_EQ(std::memcmp(&first[i].irradiance, &estimates[i].irradiance, sizeof(vec3)), 0) << i;
            ASSERT_EQ(first[i].samples, estimates[i].samples);
        }
    }
}

/// Texels stop when they are good enough: the error is near the target, a lower target takes more samples, and smooth
/// places get fewer than others.
TEST(AdaptiveSamplingS6, ReachesItsTarget)
{
    const auto reference = bakeWith(room(true, false, true), IntegratorKind::Cache, 2048, 3);
    double before = 0.0;
    for (const float target : {0.08f, 0.04f, 0.02f}) {
        const auto estimates = bakeWith(room(true, false, true), IntegratorKind::Cache, 4096, 3, target);
        std::vector<double> errors;
        double samples = 0.0;
        uint32_t fewest = ~0u;
        uint32_t most = 0;
        for (std::size_t i = 0; i < estimates.size(); ++i) {
            if (!estimates[i].valid) continue;
            const float l = luminance(reference[i].irradiance);
            errors.push_back(std::pow(double(luminance(estimates[i].irradiance) - l) / double(l), 2.0));
            samples += double(estimates[i].samples);
            fewest = std::min(fewest, estimates[i].samples);
            most = std::max(most, estimates[i].samples);
        }
        double sum = 0.0;
        for (const double e : errors) sum += e;
        const double rms = std::sqrt(sum / double(errors.size()));
        EXPECT_LT(rms, 1.1 * double(target)) << "target " << target;
        EXPECT_GT(rms, 0.2 * double(target)) << "target " << target;
        EXPECT_GT(samples, 1.5 * before) << "target " << target;
        EXPECT_LT(2 * fewest, most) << "target " << target;
        before = samples;
    }
}

/// Shadow rays are left out where a few decide, and the mask is what all of them would have given.
TEST(ShadowmaskS8, DecidedTexelsAreRight)
{
    Scene scene;
    const int black = addMaterial(scene, vec3(0), vec3(0), true);
    addRectangle(scene, {vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4)}, black, kPage, {vec2(1), vec2(63)});
    addBox(scene, vec3(-0.5f, 0.3f, -0.5f), vec3(0.5f, 1.1f, 0.5f), black, false);
    // A pole half a texel thick.
    addBox(scene, vec3(1.0f, 0.2f, 0.5f), vec3(1.032f, 1.5f, 0.532f), black, false);
    scene.lights.push_back(makeLight(LightType::Point, vec3(0.3f, 3, 0), vec3(0, -1, 0), 1.0f, LightMode::Mixed));
    scene.lights[0].radiusMeters = 0.05f;
    IntegrationSettings settings;
    settings.shadowSamples = 256;
    settings.bounces = 0;
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
    const uint64_t before = bench.integrator->raysTraced();
    const auto mask = bench.shadowmask();
    const auto perTexel = double(bench.integrator->raysTraced() - before) / double(mask.size());
    EXPECT_LT(perTexel, 0.5 * 256);
    const PathTracer paths(bench.scene, bench.geometry, LightUse::Bake);
    double squares = 0.0;
    for (std::size_t i = 0; i < mask.size(); ++i) {
        std::array<SurfacePoint, kMaxTexelPoints> points;
        const int count = texelPoints(bench.geometry, bench.map, bench.map.texels[i], points);
        double sum = 0.0;
        uint64_t rays = 0;
        constexpr int kSamples = 512;
        for (int s = 0; s < kSamples; ++s) {
            Sampler sampler(99, uint32_t(i), uint32_t(s));
            sum += double(paths.lightVisibility(paths.lights()[0], points[std::size_t(s % count)],
                                                shading::sampleDisc(sampler.next2()), rays));
        }
        squares += std::pow(sum / kSamples - double(mask[i].x), 2.0);
    }
    EXPECT_LT(std::sqrt(squares / double(mask.size())), 0.02);
}

/// A scene under a light from straight above that has a mask and no size.
Bench benchUnderSun(Scene scene, int shadowSamples)
{
    scene.lights.push_back(makeLight(LightType::Directional, vec3(0), vec3(0, -1, 0), 1.0f, LightMode::Mixed));
    IntegrationSettings settings;
    settings.shadowSamples = shadowSamples;
    settings.bounces = 0;
    return {std::move(scene), MixedLightingMode::Shadowmask, kPage, settings};
}

/// On a chart of four texels few rays agree by chance: all of them are traced.
TEST(ShadowmaskS8, SmallChartsGetAllTheirRays)
{
    constexpr int kCharts = 24;
    Scene scene;
    const int black = addMaterial(scene, vec3(0), vec3(0), true);
    const auto litShare = [](int i) { return (float(i) + 0.5f) / float(kCharts); };
    for (int i = 0; i < kCharts; ++i) {
        const vec3 corner(float(i), 0, 0);
        const vec2 place(2.0f + 8.0f * float(i % 7), 2.0f + 8.0f * float(i / 7));
        addRectangle(scene, {corner, vec3(0.2f, 0, 0), vec3(0, 0, -0.2f)}, black, kPage, {place, place + 2.0f});
        addRectangle(scene, {corner + vec3(0.2f * litShare(i), 1.0f, 0.1f), vec3(0.5f, 0, 0), vec3(0, 0, -0.4f)}, black,
                     kPage);
    }
    Bench bench = benchUnderSun(std::move(scene), 256);
    const auto mask = bench.shadowmask();
    std::array<float, kCharts> sum{};
    std::array<int, kCharts> count{};
    for (std::size_t i = 0; i < mask.size(); ++i) {
        const auto chart = std::size_t(bench.positionOf(bench.map.texels[i]).x);
        sum[chart] += mask[i].x;
        ++count[chart];
    }
    for (int i = 0; i < kCharts; ++i) {
        ASSERT_EQ(count[std::size_t(i)], 4);
        EXPECT_NEAR(sum[std::size_t(i)] / 4.0f, litShare(i), 0.03f) << "chart " << i;
    }
}

/// Texels on a shadow's edge get more rays than are asked for: at 16, no texel of a slanting edge without penumbra is
/// off by more than three of its 32, and most by hardly more than one.
TEST(ShadowmaskS8, EdgesGetMoreRays)
{
    struct Case {
        int samples;
        int texels; ///< across the floor
        float tolerance;
        float meanSquare; ///< its root
        int leastOnEdge;
    };
    // The most that can be asked for must not be more than what counts them can hold.
    for (const Case& c : {Case{16, 60, 3.1f / 32.0f, 0.042f, 50}, {65536, 12, 0.005f, 0.003f, 10}}) {
        Scene scene;
        const int black = addMaterial(scene, vec3(0), vec3(0), true);
        addRectangle(scene, {vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4)}, black, kPage,
                     {vec2(2), vec2(2 + c.texels)});
        // Its edge runs through the origin at a slope of a third.
        addRectangle(scene, {vec3(-9, 1, 3), vec3(18, 0, -6), vec3(0, 0, -9)}, black, kPage);
        Bench bench = benchUnderSun(std::move(scene), c.samples);
        const auto mask = bench.shadowmask();
        int onEdge = 0;
        float squares = 0.0f;
        for (std::size_t i = 0; i < mask.size(); ++i) {
            const Texel& texel = bench.map.texels[i];
            int lit = 0;
            constexpr int kSide = 64;
            for (int s = 0; s < kSide * kSide; ++s) {
                const vec2 at = (vec2(s % kSide, s / kSide) + 0.5f) / float(kSide);
                const vec2 p =
                    (vec2(texel.x, texel.y) + at - 2.0f) * (4.0f / float(c.texels)) - 2.0f; // z runs down the page
                lit += -p.y > -p.x / 3.0f ? 1 : 0;
            }
            const float truth = float(lit) / float(kSide * kSide);
            onEdge += lit > 0 && lit < kSide * kSide ? 1 : 0;
            squares += (mask[i].x - truth) * (mask[i].x - truth);
            EXPECT_NEAR(mask[i].x, truth, c.tolerance) << c.samples << " samples, " << texel.x << ", " << texel.y;
        }
        EXPECT_GT(onEdge, c.leastOnEdge);
        EXPECT_LT(std::sqrt(squares / float(onEdge)), c.meanSquare);
    }
}

/// A shadow that covers a small part of a row of texels at the rim of a chart, along it, is found wherever between the
/// points of one texel its edge lies; so is one that nearly covers the row.
TEST(ShadowmaskS8, EdgesAlongRowsOfTexelsAreFound)
{
    constexpr int kTexels = 40;
    constexpr float kTexel = 4.0f / float(kTexels);
    for (const float dark : {0.07f, 0.1f, 0.2f, 0.8f, 0.9f, 0.93f}) {
        Scene scene;
        const int black = addMaterial(scene, vec3(0), vec3(0), true);
        addRectangle(scene, {vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4)}, black, kPage,
                     {vec2(2), vec2(2 + kTexels)});
        // The sun is overhead. The roof's edge is so far from the floor's rim, and the roof beyond the rim, or over all
        // else.
        const bool most = dark > 0.5f;
        const float edge = -2.0f + (most ? 1.0f - dark : dark) * kTexel;
        const float begin = most ? 9.0f : edge;
        const float end = most ? edge : -11.0f;
        addRectangle(scene, {vec3(-9, 1, begin), vec3(18, 0, 0), vec3(0, 0, end - begin)}, black, kPage);
        Bench bench = benchUnderSun(std::move(scene), 64);
        const auto mask = bench.shadowmask();
        double sum = 0.0;
        int count = 0;
        for (std::size_t i = 0; i < mask.size(); ++i) {
            if (bench.positionOf(bench.map.texels[i]).z > -2.0f + kTexel) continue;
            sum += double(mask[i].x);
            ++count;
        }
        EXPECT_EQ(count, kTexels);
        EXPECT_NEAR(sum / count, 1.0 - double(dark), 0.015) << dark;
    }
}

/// Texels with few others around them, which no denoiser can draw on, get more samples.
TEST(RadianceCacheS6, TexelsThatStandAloneGetMoreSamples)
{
    Scene scene;
    scene.sky = {vec3(1), vec3(1), vec3(1)};
    const int white = addMaterial(scene, vec3(0.8f), vec3(0.0f), true);
    addRectangle(scene, {vec3(-4, 0, 4), vec3(8, 0, 0), vec3(0, 0, -8)}, white, kPage, {vec2(1), vec2(33)});
    addRectangle(scene, {vec3(-1, 1, 1), vec3(1, 0, 0), vec3(0, 0, -1)}, white, kPage, {vec2(40), vec2(42)});
    IntegrationSettings settings;
    settings.samples = 32;
    Bench bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
    const auto estimates = bench.irradiance();
    double middle = 0.0;
    int middleCount = 0;
    double alone = 0.0;
    int aloneCount = 0;
    for (std::size_t i = 0; i < estimates.size(); ++i) {
        const Texel& t = bench.map.texels[i];
        const bool inTheMiddle = t.x > 3 && t.x < 30 && t.y > 3 && t.y < 30;
        if (t.x >= 40) alone += double(estimates[i].samples);
        if (t.x >= 40) ++aloneCount;
        if (inTheMiddle) middle += double(estimates[i].samples);
        if (inTheMiddle) ++middleCount;
    }
    EXPECT_GE(alone / aloneCount, 4.0 * middle / middleCount);
    EXPECT_LE(middle / middleCount, 32.0);
}

/// A floor under a black roof with a hole in every so many squares of a fine pattern, and the sky above it; another
/// floor far away in the open.
Bench underHoles(int every, float height = 0.3f, bool denoised = true)
{
    Scene scene;
    scene.sky = {vec3(1000), vec3(0), vec3(0)}; // none comes in below the roof's edges
    ImageRgba8 pixels(256, 256, u8vec4(255));
    for (int y = 0; y < 256; y += every) {
        for (int x = 0; x < 256; x += every) pixels(x, y).w = 0;
    }
    const int white = addMaterial(scene, vec3(0.8f), vec3(0.0f), true);
    const int black = addMaterialWithHoles(scene, vec3(0.0f), std::move(pixels), true);
    addRectangle(scene, {vec3(-1, 0, 1), vec3(2, 0, 0), vec3(0, 0, -2)}, white, kPage, {vec2(1), vec2(33)});
    addRectangle(scene, {vec3(-4, height, -4), vec3(8, 0, 0), vec3(0, 0, 8)}, black, kPage);
    addRectangle(scene, {vec3(49, 0, 1), vec3(2, 0, 0), vec3(0, 0, -2)}, white, kPage, {vec2(35, 1), vec2(63, 29)});
    IntegrationSettings settings;
    settings.samples = 32;
    settings.denoised = denoised;
    return Bench(std::move(scene), MixedLightingMode::Shadowmask, kPage, settings);
}

/// How many times the samples of a texel in the open, of the middle of each floor, one under the roof gets on average.
double timesUnderTheRoof(Bench& bench)
{
    const auto estimates = bench.irradiance();
    double sum[2] = {0.0, 0.0};
    int count[2] = {0, 0};
    for (std::size_t i = 0; i < estimates.size(); ++i) {
        const Texel& t = bench.map.texels[i];
        const bool open = t.x > 33;
        const int left = open ? 38 : 4;
        if (t.x < left || t.x > left + 21 || t.y < 4 || t.y > 25) continue;
        EXPECT_GE(estimates[i].samples, 16u);
        EXPECT_LE(estimates[i].samples, 32u * 32u);
        sum[open ? 1 : 0] += double(estimates[i].samples);
        ++count[open ? 1 : 0];
    }
    EXPECT_GT(count[0], 400);
    EXPECT_GT(count[1], 400);
    return sum[0] / count[0] * count[1] / sum[1];
}

/// Where all around are noisy, texels get more samples; not where a few rays in a thousand meet light, which leaves
/// dots that a denoiser can take out.
TEST(NoiseS6, MoreSamplesWhereMostAreNoisy)
{
    Bench often = underHoles(4);
    EXPECT_GT(timesUnderTheRoof(often), 1.6);
    Bench seldom = underHoles(32);
    EXPECT_LT(timesUnderTheRoof(seldom), 1.3);
}

/// A denoiser draws on neighbours where what they see is many texels away, and can not where it is near: samples go
/// there, if there is to be one.
TEST(NoiseS6, MoreSamplesWhereNeighboursTellLittle)
{
    const auto timesOf = [](float height, bool denoised) {
        Bench bench = underHoles(4, height, denoised);
        return timesUnderTheRoof(bench);
    };
    EXPECT_GT(timesOf(0.05f, true), 1.1 * timesOf(0.05f, false));
    EXPECT_LT(timesOf(1.0f, true), 0.9 * timesOf(1.0f, false));
}

/// A budget is a budget: on average over the traced texels as many samples as asked for, wherever noise sends them.
TEST(NoiseS6, SamplesAreAsManyAsAskedForOnAverage)
{
    for (const bool denoised : {true, false}) {
        for (const int step : {1, 2}) {
            for (const int samples : {16, 24, 32, 100, 1024}) {
                if (samples > 100 && (step == 2 || denoised)) continue; // takes long
                Bench made = underHoles(4, 0.3f, denoised);
                IntegrationSettings settings;
                settings.samples = samples;
                settings.denoised = denoised;
                settings.texelStep = step;
                Bench bench(std::move(made.scene), MixedLightingMode::Shadowmask, kPage, settings);
                double sum = 0.0;
                int traced = 0;
                for (const IrradianceEstimate& e : bench.irradiance()) {
                    sum += double(e.samples);
                    traced += e.samples > 0 ? 1 : 0;
                }
                EXPECT_NEAR(sum / traced, double(samples), 0.1 * samples)
                    << "step " << step << (denoised ? ", denoised" : "");
            }
        }
    }
}

/// Variance falls as the samples grow: of four times as many, a quarter at most of the squared differences from the
/// truth.
TEST(NoiseS6, FourTimesTheSamplesAQuarterOfTheVariance)
{
    const auto estimatesOf = [](int samples, uint32_t seed) {
        Bench made = underHoles(4, 0.3f, false);
        IntegrationSettings settings;
        settings.samples = samples;
        settings.denoised = false;
        settings.seed = seed;
        Bench bench(std::move(made.scene), MixedLightingMode::Shadowmask, kPage, settings);
        return bench.irradiance();
    };
    const auto truth = estimatesOf(2048, 2);
    double before = 0.0;
    for (const int samples : {16, 64, 256}) {
        const auto estimates = estimatesOf(samples, 1);
        double squares = 0.0;
        for (std::size_t i = 0; i < truth.size(); ++i)
            squares += std::pow(double(estimates[i].irradiance.x - truth[i].irradiance.x), 2.0);
        if (samples > 16) EXPECT_LT(squares, 0.3 * before) << samples;
        before = squares;
    }
}

std::vector<LightItem> randomItems(int count, bool directed)
{
    std::vector<LightItem> items;
    uint32_t seed = 12345;
    const auto random = [&] { return unitFloat(seed = hashPcg(seed)); };
    for (int i = 0; i < count; ++i) {
        LightItem item;
        const vec3 place(10.0f * random(), 10.0f * random(), 10.0f * random());
        item.bounds.extend(place);
        item.bounds.extend(place + 0.3f * vec3(random(), random(), random()));
        item.axis = glm::normalize(vec3(random(), random(), random()) - 0.5f);
        item.cosSpread = directed ? 1.0f : -1.0f;
        item.twoSided = i % 3 == 0;
        item.power = 0.1f + 10.0f * random() * random();
        items.push_back(item);
    }
    return items;
}

/// Every item has a share, the shares add up to one, and sample() takes items as often as probability() says.
TEST(LightTreeS6, ProbabilitiesAddUpAndMatchSamples)
{
    for (const int count : {1, 2, 3, 17, 400}) {
        const std::vector<LightItem> items = randomItems(count, true);
        const LightTree tree(items);
        for (const vec3 position : {vec3(0), vec3(5), vec3(20, -3, 4)}) {
            const vec3 normal = glm::normalize(vec3(0.3f, 1.0f, -0.2f));
            // A cut for several points, this one and some beside it.
            LightTree::Points positions;
            LightTree::Points normals;
            constexpr std::size_t kLane = 5;
            for (std::size_t lane = 0; lane < LightTree::Cut::kLanes; ++lane) {
                positions.set(lane, position + 0.3f * (float(lane) - float(kLane)) * vec3(1.0f, 0.1f, 0.0f));
                normals.set(lane, normal);
            }
            const LightTree::Cut cut = tree.cut(positions, normals);
            LightTree::Cut::Lanes<bool> onlyOne{};
            onlyOne[kLane] = true;
            LightTree::Cut::Lanes<LightTree::Choice> choices;
            double sum = 0.0;
            double cutSum = 0.0;
            std::vector<float> expected;
            for (int i = 0; i < count; ++i) {
                const float p = tree.probability(uint32_t(i), position, normal);
                EXPECT_GT(p, 0.0f);
                expected.push_back(p);
                sum += double(p);
                cutSum += double(tree.probability(cut, kLane, uint32_t(i), position, normal));
            }
            EXPECT_NEAR(sum, 1.0, 1e-3);
            EXPECT_NEAR(cutSum, 1.0, 1e-3);
            constexpr int kSamples = 20000;
            std::vector<double> seen(std::size_t(count), 0.0);
            std::vector<double> seenByCut(std::size_t(count), 0.0);
            for (int s = 0; s < kSamples; ++s) {
                const float u = (float(s) + 0.5f) / float(kSamples);
                const LightTree::Choice choice = tree.sample(position, normal, u);
                ASSERT_LT(choice.item, uint32_t(count));
                EXPECT_NEAR(choice.probability, expected[choice.item], 1e-4f + 1e-2f * expected[choice.item]);
                EXPECT_TRUE(choice.u >= 0.0f && choice.u < 1.0f);
                seen[choice.item] += 1.0 / kSamples;
                tree.sample(cut, positions, normals, onlyOne, {u, u, u, u, u, u, u, u}, choices);
                const LightTree::Choice byCut = choices[kLane];
                const float p = tree.probability(cut, kLane, byCut.item, position, normal);
                EXPECT_NEAR(byCut.probability, p, 1e-4f + 1e-2f * p);
                EXPECT_TRUE(byCut.u >= 0.0f && byCut.u < 1.0f);
                seenByCut[byCut.item] += 1.0 / kSamples;
            }
            for (uint32_t i = 0; i < uint32_t(count); ++i) {
                EXPECT_NEAR(seen[i], expected[i], 2e-3) << i;
                EXPECT_NEAR(seenByCut[i], tree.probability(cut, kLane, i, position, normal), 2e-3) << i;
            }
        }
    }
}

/// Lights out of range are never chosen.
TEST(LightTreeS6, RangeIsKept)
{
    std::vector<LightItem> items = randomItems(64, false);
    for (LightItem& item : items) item.range = 4.0f;
    const LightTree tree(items);
    const vec3 position(3, 4, 5);
    bool any = false;
    for (uint32_t i = 0; i < items.size(); ++i) {
        const float distance = glm::distance(items[i].bounds.center(), position);
        const float p = tree.probability(i, position, vec3(0));
        if (distance > 4.5f) EXPECT_EQ(p, 0.0f);
        any = any || p > 0.0f;
    }
    EXPECT_TRUE(any);
    EXPECT_EQ(tree.sample(vec3(100), vec3(0), 0.5f).probability, 0.0f);
}

/// Many lamps and many point lights: the estimate's mean is the sum over all of them.
TEST(LightTreeS6, ManyLightsSumToTheirTotal)
{
    Scene scene;
    const int white = addMaterial(scene, vec3(0.5f));
    const int glow = addMaterial(scene, vec3(0.0f), vec3(3.0f));
    addRectangle(scene, {vec3(-0.05f, 0, 0.05f), vec3(0.1f, 0, 0), vec3(0, 0, -0.1f)}, white, kPage,
                 {vec2(1), vec2(9)});
    addRectangle(scene, {vec3(-50, 9, 50), vec3(100, 0, 0), vec3(0, 0, -100)}, white, kPage);
    scene.objects.back().castShadows = false;
    double expected = 0.0;
    for (int i = 0; i < 60; ++i) {
        const vec2 place = glm::fract(vec2(0.5f) + float(i) * vec2(0.7548776662f, 0.5698402910f)) * 6.0f - 3.0f;
        const float height = 1.0f + 2.0f * glm::fract(float(i) * 0.618f);
        addRectangle(scene, {vec3(place.x, height, place.y), vec3(0.05f, 0, 0), vec3(0, 0, 0.05f)}, glow, kPage);
        const vec3 to(place.x + 0.025f, height, place.y + 0.025f);
        const double d2 = double(glm::dot(to, to));
        expected += 3.0 * 0.05 * 0.05 * double(height) * double(height) / (d2 * d2);
    }
    for (const IntegratorKind kind : {IntegratorKind::Path, IntegratorKind::Cache}) {
        double mean = 0.0;
        const auto estimates = bakeWith(scene, kind, 1024, 0);
        for (const IrradianceEstimate& e : estimates) mean += double(e.irradiance.y) / double(estimates.size());
        EXPECT_NEAR(mean, expected, 0.015 * expected);
    }

    // Point lights, seen by their bounce off a floor that the receiver looks down on.
    Scene lit;
    const int grey = addMaterial(lit, vec3(0.4f));
    addRectangle(lit, {vec3(-0.05f, 1, -0.05f), vec3(0.1f, 0, 0), vec3(0, 0, 0.1f)}, grey, kPage, {vec2(1), vec2(9)});
    lit.objects.back().castShadows = false;
    addRectangle(lit, {vec3(-50, 0, 50), vec3(100, 0, 0), vec3(0, 0, -100)}, grey, kPage);
    std::vector<Light> lights;
    for (int i = 0; i < 20; ++i) {
        const vec2 place = glm::fract(vec2(0.5f) + float(i) * vec2(0.7548776662f, 0.5698402910f)) * 6.0f - 3.0f;
        lights.push_back(makeLight(i % 2 == 0 ? LightType::Point : LightType::Spot, vec3(place.x, 2.0f, place.y),
                                   vec3(0, -1, 0), 1.0f + float(i % 5), LightMode::Mixed));
    }
    double alone = 0.0;
    for (const Light& light : lights) {
        Scene one = lit;
        one.lights = {light};
        for (const IrradianceEstimate& e : bakeWith(one, IntegratorKind::Path, 256, 1)) alone += double(e.irradiance.y);
    }
    lit.lights = lights;
    double together = 0.0;
    for (const IrradianceEstimate& e : bakeWith(lit, IntegratorKind::Path, 2048, 1)) together += double(e.irradiance.y);
    EXPECT_NEAR(together, alone, 0.02 * alone);
}

/// Where a few cells stand for a block, they are spread over it: the two of lowest rank in the two halves that tell of
/// noise, four in all rows and all columns; four blocks have other fours, which are all cells together.
TEST(StratifiedPatternS6, FewCellsOfABlockAreSpread)
{
    constexpr int kBlock = StratifiedPattern::kBlock;
    for (const int first : {0, 1, 5}) {
        std::array<int, kBlock> times{};
        for (int block = first; block < first + 4; ++block) {
            std::array<int, kBlock> cellOfRank;
            cellOfRank.fill(-1);
            for (int cell = 0; cell < kBlock; ++cell) {
                const auto rank = std::size_t(StratifiedPattern::strataOrder(cell, block));
                ASSERT_LT(rank, std::size_t(kBlock));
                EXPECT_EQ(cellOfRank[rank], -1);
                cellOfRank[rank] = cell;
            }
            const auto half = [&](std::size_t rank) { return (cellOfRank[rank] >> 2 ^ cellOfRank[rank] >> 1) & 1; };
            unsigned rows = 0;
            unsigned columns = 0;
            for (std::size_t rank = 0; rank < 4; ++rank) {
                rows |= 1u << (cellOfRank[rank] >> 2);
                columns |= 1u << (cellOfRank[rank] & 3);
                ++times[std::size_t(cellOfRank[rank])];
                EXPECT_NE(half(rank), half(rank ^ 1u));
            }
            EXPECT_EQ(rows, 15u);
            EXPECT_EQ(columns, 15u);
        }
        for (const int n : times) EXPECT_EQ(n, 1);
    }
}

/// Each block has one point in each cell, at the place of the cell, and all blocks together fill the square evenly.
TEST(StratifiedPatternS6, BlocksAreStratified)
{
    const StratifiedPattern pattern(3);
    for (uint32_t texel = 0; texel < 50; ++texel) {
        std::vector<int> rows(64, 0);
        for (int b = 0; b < 4; ++b) {
            const StratifiedPattern::Block block = pattern.block(hashPcg(texel), b);
            for (int cell = 0; cell < StratifiedPattern::kBlock; ++cell) {
                const vec2 u = block.unit(cell);
                EXPECT_EQ(int(u.x * 4.0f) * 4 + int(u.y * 4.0f), cell);
                ++rows[std::size_t(u.x * 64.0f)];
            }
        }
        for (const int r : rows) EXPECT_EQ(r, 1);
    }
}

} // namespace
} // namespace halflight::test
