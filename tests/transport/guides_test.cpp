// Samples that guides aim at secondary light sources (spec S6).

#include "bake/seeds.h"
#include "bake/test_scene.h"
#include "transport/sample/lights.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace halflight::test::guides_test {
namespace {

constexpr int kPage = 64;

/// A dark room, four metres wide, in which lamps light two spots on the floor. Its ceiling and walls receive only the
/// light that the spots reflect.
struct LitSpots {
    static constexpr float kWidth = 4.0f;
    static constexpr float kHeight = 3.0f;
    static constexpr float kAlbedo = 0.8f;
    /// Holes in the floor, above a black void: none, one half, or every other square of a fine pattern.
    enum class Holes { None, Half, Pattern };
    Scene scene;
    Holes holes;

    /// `glows`: the floor emits a little light. `sunlit`: the walls are black, and lit much brighter than by the floor.
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
            // Soft rims: few texels would show a sharp rim roughly.
            lamp.innerConeRadians = 0.0f;
            lamp.outerConeRadians = 0.2f;
            scene.lights.push_back(lamp);
        }
    }

    /// Irradiance from the floor after one reflection, as a sum over the floor.
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
    /// By texel; zero on the floor.
    [[nodiscard]] std::vector<double> illuminances(const Bench& bench) const
    {
        std::vector<double> found;
        for (const Texel& texel : bench.map.texels) {
            const TexelFragment& first = bench.map.fragments[texel.firstFragment];
            const vec3 normal = surfacePoint(bench.geometry, first.triangle, first.barycentric).normal;
            found.push_back(normal.y > 0.5f ? 0.0 : illuminance(bench.positionOf(texel), normal));
        }
        return found;
    }
};

/// Where one ray in a hundred hits a bright spot, 32 rays have an error above 100 %. With samples of the spot the error
/// is small, the MIS weights add up to one, and holes give no light.
TEST(GuidesS6, LitSpotsAreNoNoise)
{
    struct Case {
        LitSpots::Holes holes;
        bool glows;
        bool sunlit;
        double resolved;
        double noise;
    };
    // Samples on holes are lost, which costs variance. Few texels show a spot roughly, which takes half a per cent.
    for (const auto& [holes, glows, sunlit, resolved, mostNoise] :
         {Case{LitSpots::Holes::None, false, false, 0.01, 0.12},
          {LitSpots::Holes::None, true, false, 0.01, 0.12},
          {LitSpots::Holes::None, false, true, 0.01, 0.12},
          {LitSpots::Holes::Half, false, false, 0.01, 0.35},
          {LitSpots::Holes::Pattern, false, false, 0.04, 0.9}}) {
        SCOPED_TRACE(testing::Message() << "holes " << int(holes) << (glows ? ", glows" : "")
                                        << (sunlit ? ", sunlit" : ""));
        IntegrationSettings settings;
        settings.samples = 32;
        settings.shadowSamples = 8;
        settings.bounces = 1;
        const LitSpots spots(holes, glows, sunlit);
        std::vector<double> truth; // of ceiling and walls, by texel
        double squares = 0.0;
        double sum = 0.0;
        int count = 0;
        const SeedMean share = overSeeds([&](uint32_t seed) {
            settings.seed = seed;
            Bench bench(spots.scene, MixedLightingMode::Shadowmask, kPage, settings);
            const auto estimates = bench.irradiance();
            if (truth.empty()) truth = spots.illuminances(bench);
            double found = 0.0;
            double expected = 0.0;
            for (std::size_t i = 0; i < estimates.size(); ++i) {
                if (truth[i] == 0.0 || !estimates[i].valid) continue;
                const double error = double(estimates[i].irradiance.y) - truth[i];
                squares += error * error;
                found += double(estimates[i].irradiance.y);
                expected += truth[i];
                ++count;
            }
            sum += expected;
            return found / expected;
        });
        ASSERT_GT(count, 2000);
        expectMean(share, 1.0, {.resolved = resolved, .bias = 0.005});
        EXPECT_LT(std::sqrt(squares / count), mostNoise * sum / count);
    }
}

/// A small sunlit board at the end of a wide black floor, before a large wall that may reflect a little.
class BoardFromAfar {
public:
    explicit BoardFromAfar(float wallAlbedo, int divisions = 1, int meters = 16)
        : wallAlbedo_(wallAlbedo), divisions_(divisions), meters_(meters)
    {}

    /// Light of the floor eight metres from the board and more, relative to the truth.
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

    /// Irradiance of a point of the floor from a rectangle of radiance one (Lambert 1760, "Photometria": a sum over its
    /// edges).
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
        // The board occludes a part of the wall.
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

/// Far away one ray in ten thousand hits the board. The hits of a wider region put the whole board into the guides of
/// all its receivers.
TEST(GuidesS6, SmallThingsAreSeenFromAfar)
{
    const BoardFromAfar::Errors errors = BoardFromAfar(0.0f).errors();
    EXPECT_LT(std::abs(errors.bias), 0.02);
    EXPECT_LT(errors.noise, 0.3);
    EXPECT_LT(errors.dark, 0.001);
}

/// So far away that no ray within twenty metres hits the board: the guide comes from a still wider region.
TEST(GuidesS6, SmallThingsAreSeenFromFarther)
{
    const BoardFromAfar::Errors errors = BoardFromAfar(0.0f, 1, 100).errors();
    EXPECT_LT(std::abs(errors.bias), 0.02);
    EXPECT_LT(errors.noise, 0.3);
    EXPECT_LT(errors.dark, 0.001);
}

/// The same for a board of many small triangles, as cloth has them: all of them are sampled.
TEST(GuidesS6, FineMeshesAreAimedAtWhole)
{
    const BoardFromAfar::Errors errors = BoardFromAfar(0.0f, 80).errors();
    EXPECT_LT(std::abs(errors.bias), 0.02);
    EXPECT_LT(errors.noise, 0.3);
}

/// The same beside a wall that gives most of the light: guides with many local hits have the board in their shared
/// list.
TEST(GuidesS6, SmallThingsAreSeenBesideLargeOnes)
{
    const BoardFromAfar::Errors errors = BoardFromAfar(0.005f).errors();
    EXPECT_LT(std::abs(errors.bias), 0.02);
    EXPECT_LT(errors.noise, 0.3);
}

} // namespace
} // namespace halflight::test::guides_test
