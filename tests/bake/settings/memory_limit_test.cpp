// What a bake takes is said before it begins where a program cannot address so much (WebAssembly).

#include "bake/settings/memory_limit.h"

#include "halflight/scene/gltf.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace halflight::memory_limit_test {
namespace {

using testing::HasSubstr;

constexpr uint64_t kFourGigabytes = uint64_t(1) << 32;

TEST(MemoryLimit, TexelsThatDoNotFitAreRefusedWithADensityThatDoes)
{
    const BakeSize size{60'000'000, 200'000, 40.0};
    const Status status = checkMemory(size, kFourGigabytes);
    ASSERT_FALSE(status);
    EXPECT_THAT(status.error().message, HasSubstr("60000000 texels and 200000 triangles"));
    const std::string& text = status.error().message;
    const std::size_t at = text.find("--texels-per-meter ");
    ASSERT_NE(at, std::string::npos) << text;
    const double density = std::stod(text.substr(at + 19));
    EXPECT_GT(density, 5.0);
    const double shrink = density / 40.0;
    EXPECT_TRUE(checkMemory({uint64_t(60'000'000 * shrink * shrink), 200'000, density}, kFourGigabytes));
}

TEST(MemoryLimit, TrianglesThatDoNotFitAreRefusedBeforeTexelsAreKnown)
{
    const Status status = checkMemory({0, 20'000'000, 0.0}, kFourGigabytes);
    ASSERT_FALSE(status);
    EXPECT_THAT(status.error().message, Not(HasSubstr("--texels-per-meter")));
}

TEST(MemoryLimit, TheShowcaseFitsAndThisProgramHasNoLimit)
{
    EXPECT_TRUE(checkMemory({800'000, 202'000, 20.0}, kFourGigabytes));
    if (sizeof(void*) == 8) EXPECT_TRUE(checkMemory({uint64_t(1) << 40, 0, 1.0}));
}

TEST(MemoryLimit, TrianglesOfAMeshCountForEachObject)
{
    Scene scene;
    scene.meshes.resize(2);
    scene.meshes[0].parts.resize(2);
    scene.meshes[0].parts[0].indices.resize(6);
    scene.meshes[0].parts[1].indices.resize(3);
    scene.objects.resize(3);
    scene.objects[0].mesh = 0;
    scene.objects[1].mesh = 0;
    scene.objects[2].mesh = -1;
    EXPECT_EQ(trianglesOf(scene), 6u);
}

} // namespace
} // namespace halflight::memory_limit_test
