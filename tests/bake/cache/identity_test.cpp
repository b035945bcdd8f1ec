// What depends on the processor that bakes: nothing that lays out texels, and no result is mixed with another's unless
// a farm asks for it (docs/architecture.md, rule 7).

#include "bake/test_scene.h"
#include "bake_cpu/trace/embree_kernels.h"
#include "base/temp_folder.h"
#include "transport/trace/ray_tracer.h"

#include "halflight/bake/farm.h"
#include "halflight/base/system.h"
#include "halflight/shading/random.h"
#include "halflight/shading/sampling.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace halflight::test::identity_test {
namespace {

std::vector<InstructionSet> setsOfThisProcessor()
{
    std::vector<InstructionSet> sets;
    for (const InstructionSet set : {InstructionSet::Sse2, InstructionSet::Avx2, InstructionSet::Avx512})
        if (embreeIntegrators().identity(set)) sets.push_back(set);
    return sets;
}

TEST(Identity, IsAFilesNameThatRepeatsAndTellsInstructionSetsApart)
{
    const IntegratorFactory factory = embreeIntegrators();
    std::set<std::string> names;
    for (const InstructionSet set : setsOfThisProcessor()) {
        const std::string name = *factory.identity(set);
        EXPECT_EQ(name, *factory.identity(set));
        EXPECT_TRUE(name.starts_with("cpu-embree-")) << name;
        EXPECT_EQ(name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789.-"), std::string::npos) << name;
        EXPECT_TRUE(names.insert(name).second) << name;
    }
    ASSERT_FALSE(names.empty());
    EXPECT_TRUE(names.contains(*factory.identity(InstructionSet::Automatic)));
}

/// Each start of the program computes it, so it must be quick. Other programs use the processor's caches: the best of a
/// few rounds counts. Some systems' clocks count in steps of 16 ms, so a round has many. With sanitizers all takes
/// longer.
TEST(Identity, TakesAtMostTwentyMilliseconds)
{
#ifdef __SANITIZE_ADDRESS__
    GTEST_SKIP() << "sanitizers take their time";
#endif
    constexpr int kTimes = 8;
    const IntegratorFactory factory = embreeIntegrators();
    for (const InstructionSet set : setsOfThisProcessor()) {
        double least = kInfinity;
        for (int round = 0; round < 3; ++round) {
            const double begin = processCpuSeconds();
            for (int i = 0; i < kTimes; ++i) ASSERT_TRUE(factory.identity(set));
            least = std::min(least, processCpuSeconds() - begin);
        }
        EXPECT_LE(least, 0.02 * kTimes) << nameOf(set);
    }
}

/// A stack of boxes that share faces. The rays of a point inside leave one solid more than they enter in whatever order
/// coincident faces are met; those of a point outside as many.
TEST(SolidsS6, CountWhereSolidsShareAFace)
{
    Scene scene;
    const int material = addMaterial(scene, vec3(0.5f));
    constexpr float kSide = 0.7f; // metres; no power of two, so that faces are rounded
    for (int i = 0; i < 4; ++i) {
        const std::size_t first = scene.objects.size();
        addBox(scene, vec3(0, kSide * float(i), 0), vec3(kSide, kSide * float(i + 1), kSide), material, false);
        joinObjects(scene, first);
    }
    const BakeGeometry geometry = flattenGeometry(scene, 64, GeometryFilter::Static);
    for (const InstructionSet set : setsOfThisProcessor()) {
        const RayTracer tracer(scene, geometry, embreeKernels(set));
        ASSERT_TRUE(tracer.ok());
        int wrong = 0;
        constexpr uint32_t kRays = 2000;
        for (uint32_t i = 0; i < kRays; ++i) {
            const vec2 u = r2Point(int(i));
            const vec3 direction = shading::sampleSphere(u);
            const vec3 inside(0.3f, kSide * (float(i % 4) + 0.4f), 0.2f);
            const std::array<Ray, 2> rays = {
                {{inside, 0.0f, direction, kInfinity}, {inside + vec3(kSide, 0, 0), 0.0f, direction, kInfinity}}};
            std::array<int, 2> left{};
            ASSERT_TRUE(tracer.kernels().crossings(rays, left));
            wrong += (left[0] != 1 ? 1 : 0) + (left[1] != 0 ? 1 : 0);
        }
        // A ray may slip between two triangles.
        EXPECT_LE(wrong, 2) << nameOf(set);
    }
}

/// Two rooms share a wall of two single-sided faces in one place, back to back. From both rooms, rays hit the face
/// whose front they see. Where rounding decides, half of the rays hit the other one
TEST(SolidsS6, RaysSeeTheFrontOfFacesBackToBack)
{
    Scene scene;
    const int material = addMaterial(scene, vec3(0.5f));
    const vec3 across = glm::normalize(vec3(1.0f, 0.3f, -0.2f));
    const vec3 up = glm::normalize(glm::cross(across, vec3(0, 0, 1)));
    const Rectangle wall{vec3(0.1f, -0.3f, 0.2f) - 2.0f * (across + up), 4.0f * across, 4.0f * up};
    addRectangle(scene, wall, material, 64);
    addRectangle(scene, {wall.origin, wall.edgeV, wall.edgeU}, material, 64);
    const vec3 normal = glm::normalize(glm::cross(across, up));
    const BakeGeometry geometry = flattenGeometry(scene, 64, GeometryFilter::Static);
    for (const InstructionSet set : setsOfThisProcessor()) {
        const RayTracer tracer(scene, geometry, embreeKernels(set));
        ASSERT_TRUE(tracer.ok());
        ASSERT_TRUE(tracer.materials().backIsHidden(0));
        for (uint32_t packet = 0; packet < 100; ++packet) {
            std::array<Ray, 8> rays;
            std::array<RayHit, 8> hits;
            for (int lane = 0; lane < 8; ++lane) {
                const vec2 u = r2Point(int(packet) * 8 + lane) - 0.5f;
                const vec2 v = r2Point(7919 + int(packet) * 8 + lane) - 0.5f;
                const float side = lane % 2 == 0 ? 1.0f : -1.0f;
                const vec3 from = wall.origin + 2.0f * (across + up) + 2.0f * (u.x * across + u.y * up) + side * normal;
                const vec3 direction = glm::normalize(v.x * across + v.y * up - side * normal);
                const RayHit hit = tracer.nearest(from, direction, 0.0f, kInfinity);
                EXPECT_TRUE(hit.found() && hit.face.back == 0) << nameOf(set);
                rays[std::size_t(lane)] = {from, 0.0f, direction, kInfinity};
            }
            ASSERT_TRUE(tracer.kernels().nearest(rays, hits));
            for (const RayHit& hit : hits) EXPECT_TRUE(hit.found() && hit.face.back == 0) << nameOf(set);
        }
    }
}

struct OtherMachines : testing::Test {
    OtherMachines()
    {
        const int walls = addMaterial(scene, vec3(0.6f));
        addBox(scene, vec3(-2, 0, -2), vec3(2, 3, 2), walls, true);
        scene.lights.push_back(pointAt("lamp", vec3(1, 2, 0), 5.0f));
        settings.samples = 16;
        settings.lightmapSize = 64;
        settings.bounces = 1;
        settings.probeSpacingMeters = 3.0f;
        settings.reflectionProbes = false;
        settings.cacheDirectory = folder / "cache";
    }
    static IntegratorFactory machine(const std::string& identity)
    {
        IntegratorFactory factory = embreeIntegrators();
        factory.identity = [identity](InstructionSet) -> Result<std::string> { return identity; };
        return factory;
    }
    BakeReport bakeOn(const std::string& identity)
    {
        Result<BakeResult> result = bake(scene, settings, machine(identity));
        EXPECT_TRUE(result);
        return result ? result->report : BakeReport{};
    }

    Scene scene;
    TempFolder folder;
    BakeSettings settings;
};

TEST_F(OtherMachines, ResultsAreNeitherTakenNorRemovedAndOneSentenceSaysSo)
{
    const std::vector<std::string> alone = bakeOn("cpu-one").warnings;
    const BakeReport other = bakeOn("cpu-two");
    EXPECT_EQ(other.identity, "cpu-two");
    EXPECT_GT(other.cache.tiles, 0u);
    EXPECT_EQ(other.cache.same + other.cache.unchanged, 0u);
    ASSERT_EQ(other.warnings.size(), alone.size() + 1);
    for (const char* word : {"cpu-one", "cpu-two", "not used"})
        EXPECT_NE(other.warnings.back().find(word), std::string::npos) << other.warnings.back();
    const BakeReport again = bakeOn("cpu-one");
    EXPECT_EQ(again.cache.same, again.cache.tiles);
}

TEST_F(OtherMachines, MayNotWorkOnAPlanUnlessItIsMixed)
{
    for (const bool mixed : {false, true}) {
        settings.mixedIdentities = mixed;
        const Result<FarmBake> planned = planFarm(scene, settings, machine("cpu-one"));
        ASSERT_TRUE(planned);
        const FarmWork work = farmWork({*planned}, {0, 1}).front();
        const Result<BakeReport> report = workOnFarm(scene, settings, *planned, work, false, machine("cpu-two"));
        ASSERT_EQ(bool(report), mixed);
        if (mixed) {
            EXPECT_TRUE(missingFarmTiles(settings.cacheDirectory, *planned, true).empty());
            const BakeReport joined = bakeOn("cpu-three");
            EXPECT_EQ(joined.cache.same, joined.cache.tiles);
            continue;
        }
        EXPECT_EQ(missingFarmTiles(settings.cacheDirectory, *planned, true).size(), planned->tiles);
        for (const char* word : {"cpu-one", "cpu-two", "--isa sse2", "--mixed"})
            EXPECT_NE(report.error().message.find(word), std::string::npos) << report.error().message;
    }
}

} // namespace
} // namespace halflight::test::identity_test
