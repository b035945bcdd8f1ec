// S34. Lights that turn: bounced light between the directions of a bake against bakes for these directions, and files.

#include "bake/lights/group_states.h"
#include "scene/model/pose.h"

#include "halflight/scene/turning_lights.h"

#include <gmock/gmock.h>

#include <cstdio>
#include <filesystem>
#include <memory>

namespace halflight::test::turning_bake_test {
namespace {

/// The sun of a day in spring at 50 degrees north, by its hour angle in degrees: along which it shines.
vec3 sunlight(float hour)
{
    const float h = glm::radians(hour);
    const float declination = glm::radians(10.0f);
    const float latitude = glm::radians(50.0f);
    return vec3(std::cos(declination) * std::sin(h),
                -std::sin(latitude) * std::sin(declination) - std::cos(latitude) * std::cos(declination) * std::cos(h),
                std::cos(latitude) * std::sin(declination) - std::sin(latitude) * std::cos(declination) * std::cos(h));
}

Light sunAt(float hour)
{
    Light sun = makeLight(LightType::Directional, vec3(0), sunlight(hour), 80000.0f, LightMode::Mixed);
    sun.name = "Sun";
    return sun;
}

void addDay(Scene& scene)
{
    scene.lights.push_back(sunAt(0.0f));
    scene.sky = Sky{vec3(3000, 4000, 6000), vec3(4000), vec3(0)}; // 13,000 lux on open ground
}

/// Houses on open ground.
Scene village()
{
    Scene scene;
    const int ground = addMaterial(scene, vec3(0.3f, 0.32f, 0.2f));
    const int plaster = addMaterial(scene, vec3(0.7f, 0.6f, 0.5f));
    addRectangle(scene, {vec3(-12, 0, 12), vec3(24, 0, 0), vec3(0, 0, -24)}, ground, 0, {}, 4);
    addBox(scene, vec3(-6, 0, -4), vec3(-2, 4, 1), plaster, false);
    addBox(scene, vec3(2, 0, -6), vec3(6, 3, -2), plaster, false);
    addBox(scene, vec3(1, 0, 2), vec3(4, 5, 5), plaster, false);
    addDay(scene);
    return scene;
}

/// A court between walls, open above.
Scene court()
{
    Scene scene;
    const int plaster = addMaterial(scene, vec3(0.6f, 0.55f, 0.5f));
    const int brick = addMaterial(scene, vec3(0.5f, 0.25f, 0.2f));
    addRectangle(scene, {vec3(-3, 0, 3), vec3(6, 0, 0), vec3(0, 0, -6)}, plaster, 0);
    addBox(scene, vec3(-4, 0, -4), vec3(-3, 4, 4), brick, false);
    addBox(scene, vec3(3, 0, -4), vec3(4, 4, 4), plaster, false);
    addBox(scene, vec3(-3, 0, -4), vec3(3, 4, -3), plaster, false);
    addBox(scene, vec3(-3, 0, 3), vec3(3, 4, 4), plaster, false);
    addBox(scene, vec3(-1, 0, -1), vec3(0, 1, 0), plaster, false);
    addDay(scene);
    return scene;
}

BakeSettings settingsOf(uint32_t seed = 1)
{
    BakeSettings settings;
    settings.samples = 64;
    settings.lightmapSize = 128;
    settings.probeLayout = ProbeLayout::Grid;
    settings.probeSpacingMeters = 4.0f;
    settings.reflectionProbes = false;
    settings.directional = false;
    settings.seed = seed;
    return settings;
}

/// Differences of two bakes of one layout over the mean of the second.
struct Difference {
    double mean = 0.0;
    double worst = 0.0; ///< of 99.9 % of the texels
};

Difference differenceOf(const std::vector<ImageRgb32f>& pages, const std::vector<ImageRgb32f>& truth)
{
    std::vector<double> off;
    for (std::size_t p = 0; p < pages.size(); ++p)
        for (std::size_t i = 0; i < pages[p].texelCount(); ++i)
            if (luminance(truth[p].data()[i]) > 0.0f)
                off.push_back(std::abs(double(luminance(pages[p].data()[i]) - luminance(truth[p].data()[i]))));
    std::ranges::sort(off);
    double sum = 0.0;
    for (const double x : off) sum += x;
    const double all = meanOf(truth);
    return {sum / double(off.size()) / all, off[off.size() - 1 - off.size() / 1000] / all};
}

/// The state of a bake with the sun along `direction`.
BakedScene turnedTo(BakedScene baked, vec3 direction)
{
    Light& sun = baked.scene.lights.at(0);
    sun.worldFromLight = poseLookingAlong(sun.position(), direction);
    return stateOf(std::move(baked), {});
}

/// A bake for one hour.
std::vector<ImageRgb32f> ownBake(const Scene& scene, float hour, uint32_t seed = 1)
{
    Scene own = scene;
    own.lights[0].directions.clear();
    own.lights[0].worldFromLight = poseLookingAlong(vec3(0), sunlight(hour));
    return pagesOf(bakeOf(std::move(own), settingsOf(seed)).baked);
}

void expectADay(Scene scene, float stepDegrees, const char* name)
{
    // An hour angle of a degree is a cosine of the declination, 0.985, of a degree of the sky.
    const float step = stepDegrees / std::cos(glm::radians(10.0f));
    for (int i = -2; i <= 3; ++i) scene.lights[0].directions.push_back(sunlight(step * float(i)));
    EXPECT_NEAR(glm::degrees(largestStep(scene.lights[0].directions)), stepDegrees, 0.2f);
    const BakeResult baked = bakeOf(scene, settingsOf());
    for (const std::string& warning : baked.report.warnings)
        EXPECT_EQ(warning.find("degrees apart"), std::string::npos);
    const double skyAlone = meanOf(pagesOf(stateOf(baked.baked, {{"Sun", vec3(0)}})));
    const float hours[] = {-1.5f * step, -0.6f * step, 0.5f * step, 1.3f * step, 2.5f * step};
    for (const float hour : hours) {
        const std::vector<ImageRgb32f> truth = ownBake(scene, hour);
        const Difference off = differenceOf(pagesOf(turnedTo(baked.baked, sunlight(hour))), truth);
        const double bounced = 1.0 - skyAlone / meanOf(truth);
        std::printf(
            "%s, hour angle %5.1f: mean %.2f %% of all baked light, worst place %.0f %%; %.1f %% of the sun's\n", name,
            double(hour), 100.0 * off.mean, 100.0 * off.worst, 100.0 * off.mean / bounced);
        EXPECT_LE(off.mean, 0.06) << hour;
    }
    // At a direction of the bake nothing is left but noise: that of two bakes for it.
    const std::vector<ImageRgb32f> truth = ownBake(scene, step);
    const double noise = differenceOf(ownBake(scene, step, 2), truth).mean;
    const Difference there = differenceOf(pagesOf(turnedTo(baked.baked, sunlight(step))), truth);
    std::printf("%s, a direction of the bake: mean %.2f %%, two bakes differ by %.2f %%\n", name, 100.0 * there.mean,
                100.0 * noise);
    EXPECT_LE(there.mean, 1.5 * noise + 0.002);
}

TEST(TurningBakeS34, HoursBetweenTheDirectionsInTheOpen)
{
    expectADay(village(), 20.0f, "village, 20 degrees");
}

TEST(TurningBakeS34, HoursBetweenTheDirectionsInACourt)
{
    expectADay(court(), 15.0f, "court, 15 degrees");
}

/// A small bake of two directions, and the noon that the light has in the scene.
class TurningFileS34 : public testing::Test {
protected:
    static void SetUpTestSuite()
    {
        Scene scene = court();
        scene.lights[0].directions = {sunlight(-7.5f), sunlight(7.5f)};
        BakeSettings settings = settingsOf();
        settings.samples = 16;
        settings.lightmapSize = 64;
        result_ = std::make_unique<BakeResult>(bakeOf(scene, settings));
    }
    static void TearDownTestSuite() { result_.reset(); }
    static std::unique_ptr<BakeResult> result_;
};
std::unique_ptr<BakeResult> TurningFileS34::result_;

TEST_F(TurningFileS34, TheLightIsOneAgainAndHasNoMask)
{
    const BakedScene& baked = result_->baked;
    ASSERT_EQ(baked.scene.lights.size(), 1u);
    const Light& sun = baked.scene.lights[0];
    EXPECT_LT(glm::distance(sun.direction(), sunlight(0.0f)), 1e-6f);
    EXPECT_EQ(sun.baking.occlusionMaskChannel, -1);
    EXPECT_TRUE(baked.shadowmasks.empty()) << "its shadows are of run time";
    EXPECT_EQ(sun.baking.bakeType, LightMode::Mixed);
    EXPECT_FALSE(movedSinceBake(sun));
    EXPECT_EQ(result_->report.lights.size(), 1u);
    ASSERT_EQ(baked.groups.size(), 2u);
    for (const BakedGroup& group : baked.groups) {
        EXPECT_FALSE(group.direct) << "only what surfaces reflect";
        EXPECT_GT(group.peakLux, 0.0f);
        EXPECT_NEAR(group.weight.x, 0.5f / std::cos(glm::radians(0.5f * 15.0f * 0.985f)), 0.002f) << "noon is between";
    }
}

TEST_F(TurningFileS34, AFileKeepsThem)
{
    const std::filesystem::path file = std::filesystem::temp_directory_path() / "halflight_turning_test.glb";
    ASSERT_TRUE(writeBakedScene(file, result_->baked));
    const Result<BakedScene> read = readBakedScene(file);
    ASSERT_TRUE(read) << read.error().text();
    const Light& sun = read->scene.lights.at(0);
    EXPECT_EQ(sun.directions.size(), 2u) << "for the next bake";
    EXPECT_EQ(sun.baking.turning.group, 0);
    EXPECT_EQ(sun.baking.turning.directions, result_->baked.scene.lights[0].baking.turning.directions);
    for (const float hour : {-7.5f, 2.0f}) {
        // WebP by a curve of its own: docs/format.md.
        EXPECT_LT(errorOf(pagesOf(turnedTo(*read, sunlight(hour))), pagesOf(turnedTo(result_->baked, sunlight(hour)))),
                  0.02);
    }
    const BakedScene state = turnedTo(*read, sunlight(2.0f));
    ASSERT_TRUE(writeBakedScene(file, state));
    const Result<BakedScene> composed = readBakedScene(file);
    ASSERT_TRUE(composed) << composed.error().text();
    EXPECT_TRUE(composed->groups.empty());
    EXPECT_LT(glm::distance(composed->scene.lights.at(0).direction(), sunlight(2.0f)), 1e-5f) << "its node is turned";
    EXPECT_FALSE(movedSinceBake(composed->scene.lights[0]));
    EXPECT_FALSE(turns(composed->scene.lights[0]));
    std::filesystem::remove(file);
}

TEST_F(TurningFileS34, TheLightsNameSetsAllDirections)
{
    const BakedScene& baked = result_->baked;
    const auto weights = groupWeights(baked, {{"Sun", vec3(1, 0.5f, 0)}});
    ASSERT_TRUE(weights);
    const std::vector<float> shares =
        weightsOfDirections(baked.scene.lights[0].baking.turning.directions, sunlight(0.0f));
    for (std::size_t d = 0; d < 2; ++d) EXPECT_LT(glm::distance((*weights)[d], shares[d] * vec3(1, 0.5f, 0)), 1e-4f);
    const std::vector<GroupWeight> settable = settableWeights(baked, *weights);
    ASSERT_EQ(settable.size(), 1u);
    EXPECT_EQ(settable[0].name, "Sun");
    EXPECT_LT(glm::distance(settable[0].weight, vec3(1, 0.5f, 0)), 1e-4f);
    const BakedScene state = stateOf(baked, {{"Sun", vec3(1, 0.5f, 0)}});
    const Light& sun = state.scene.lights[0];
    EXPECT_LT(glm::distance(sun.color * sun.intensity, vec3(80000, 40000, 0)), 8.0f) << "its direct light follows";
    EXPECT_NEAR(meanOf(pagesOf(stateOf(baked, {{"Sun", vec3(0)}}))) / meanOf(pagesOf(stateOf(baked, {}))), 0.6, 0.35);
    const auto single = groupWeights(baked, {{"Sun.2", vec3(1)}});
    ASSERT_FALSE(single);
    EXPECT_EQ(single.error().message, "light group \"Sun.2\" is of one direction of light \"Sun\" and follows it: turn "
                                      "the light, or set \"Sun\"");
}

TEST_F(TurningFileS34, AwayFromAllDirectionsIsAWarning)
{
    Light sun = result_->baked.scene.lights[0];
    EXPECT_TRUE(changesSinceBake(sun, "the sun", false).empty());
    sun.worldFromLight = poseLookingAlong(vec3(0), sunlight(50.0f));
    EXPECT_THAT(changesSinceBake(sun, "the sun", false),
                testing::ElementsAre(testing::HasSubstr("the sun shines 41.")));
}

} // namespace
} // namespace halflight::test::turning_bake_test
