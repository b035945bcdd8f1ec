// Bakes that end at a time: the samples that they choose, by a clock of the test's own (BakeSettings::seconds).
#include "bake/test_room.h"

#include "halflight/bake/bake.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace halflight::time_limit_test {
namespace {

using namespace test;

/// Time passes with the rays of the bake's integrator, the last that is made: a million a second.
struct RayClock {
    const Integrator* integrator = nullptr;

    [[nodiscard]] double seconds() const
    {
        return integrator != nullptr ? 1.0e-6 * double(integrator->raysTraced()) : 0.0;
    }
    [[nodiscard]] IntegratorFactory factory()
    {
        IntegratorFactory made = embreeIntegrators();
        made.make = [this, make = made.make](const Scene& scene, const BakeGeometry& geometry,
                                             const IntegrationSettings& settings) {
            auto result = make(scene, geometry, settings);
            if (result) integrator = result->get();
            return result;
        };
        return made;
    }
};

double secondsOf(const BakeResult& result)
{
    double rays = 0.0;
    for (const StageReport& stage : result.report.stages) rays += double(stage.rays);
    return 1.0e-6 * rays;
}

BakeSettings settingsOf()
{
    BakeSettings settings;
    settings.quality = Quality::Preview;
    settings.lightmapSize = 128;
    settings.uvMode = UvMode::Unwrap;
    settings.reflectionProbes = false;
    return settings;
}

BakeResult bakeWithin(double seconds, RayClock& clock)
{
    BakeSettings settings = settingsOf();
    settings.seconds = seconds;
    settings.clock = [&clock] { return clock.seconds(); };
    Result<BakeResult> result = bake(room(true, true, true), settings, clock.factory());
    EXPECT_TRUE(result) << (result ? "" : result.error().message);
    return result ? std::move(*result) : BakeResult{};
}

TEST(TimeLimit, ALongerTimeHasMoreSamplesAndIsKept)
{
    int last = 32;
    for (const double seconds : {6.5, 10.0}) {
        RayClock clock;
        const BakeResult result = bakeWithin(seconds, clock);
        EXPECT_GT(result.report.quality.samples, last) << seconds;
        last = result.report.quality.samples;
        EXPECT_NEAR(secondsOf(result), seconds, 0.2 * seconds);
    }
}

TEST(TimeLimit, TheSamplesGiveTheSameLight)
{
    RayClock clock;
    const BakeResult timed = bakeWithin(6.5, clock);
    BakeSettings settings = settingsOf();
    settings.samples = timed.report.quality.samples;
    const auto plain = bake(room(true, true, true), settings, embreeIntegrators());
    ASSERT_TRUE(plain);
    ASSERT_EQ(timed.irradiance.size(), plain->irradiance.size());
    for (std::size_t page = 0; page < plain->irradiance.size(); ++page) {
        const ImageRgb32f& a = timed.irradiance[page];
        const ImageRgb32f& b = plain->irradiance[page];
        ASSERT_EQ(ivec2(a.width(), a.height()), ivec2(b.width(), b.height()));
        EXPECT_TRUE(std::equal(a.data(), a.data() + a.width() * a.height(), b.data())) << page;
    }
    EXPECT_EQ(timed.baked.shadowmasks.size(), plain->baked.shadowmasks.size());
    EXPECT_EQ(timed.report.probeCount, plain->report.probeCount);
}

TEST(TimeLimit, TooLittleTimeIsAPreviewWithASentence)
{
    RayClock clock;
    const BakeResult result = bakeWithin(0.1, clock);
    EXPECT_EQ(result.report.quality.samples, 32);
    ASSERT_FALSE(result.report.warnings.empty());
    EXPECT_NE(result.report.warnings.back().find("too few for this bake"), std::string::npos);
}

} // namespace
} // namespace halflight::time_limit_test
