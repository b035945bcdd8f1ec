#include "probe_sets.h"

#include <gtest/gtest.h>

#include <cmath>

namespace halflight::proxy_volume_test {
namespace {

using namespace test;

/// All of it inside the probes: the box [-2, 2.5] x [1, 5] x [5, 8].
const Bounds kBox{{-1.5f, 1.2f, 5.5f}, {2.0f, 4.0f, 7.7f}};

/// World position of a texel's centre.
vec3 texelCenter(const ProxyVolume& volume, ivec3 texel)
{
    const glm::dvec3 coordinate = (glm::dvec3(texel) + 0.5) / glm::dvec3(volume.resolution);
    return vec3(glm::inverse(glm::dmat4(volume.volumeFromWorld)) * glm::dvec4(coordinate, 1.0));
}

void expectNear(const ProbeSample& a, const ProbeSample& b, float tolerance)
{
    for (std::size_t i = 0; i < 9; ++i) {
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(a.radiance[i][c], b.radiance[i][c], tolerance) << i;
    }
    for (int c = 0; c < 4; ++c) EXPECT_NEAR(a.occlusion[c], b.occlusion[c], tolerance);
}

TEST(ProxyVolumeS16, LinearFieldsAreReproducedInTheWholeBox)
{
    const BakedScene baked = probeGrid({4, 3, 5}, linear);
    const ProbeInterpolator probes = rawProbes(baked);
    for (const ivec3 resolution : {ivec3(0), ivec3(2), ivec3(5, 3, 9)}) {
        const ProxyVolume volume = makeProxyVolume(probes, kBox, {resolution});
        Random random(1);
        for (int n = 0; n < 200; ++n) {
            const vec3 p = random.in(kBox.min, kBox.max);
            expectSample(sampleProxyVolume(volume, p), linear(p), 2.0e-5f);
            // Outside: the box's nearest point, as a texture clamped to its edge gives it.
            const vec3 outside = random.in(vec3(-20), vec3(20));
            expectSample(sampleProxyVolume(volume, outside), linear(glm::clamp(outside, kBox.min, kBox.max)), 2.0e-5f);
        }
    }
}

TEST(ProxyVolumeS16, TexelsHoldTheInterpolatedProbesAndOcclusion)
{
    BakedScene baked = probeGrid({4, 3, 5}, rough);
    Random random(2);
    for (Probe& probe : baked.probes.probes) {
        for (vec3& c : probe.radiance) c = random.in(vec3(-1), vec3(1));
        probe.radiance[0] = random.in(vec3(1), vec3(4));
        for (int c = 0; c < 4; ++c) probe.occlusion[c] = random.unit();
    }
    const ProbeInterpolator probes(baked); // as objects see them, without ringing
    const ProxyVolume volume = makeProxyVolume(probes, kBox, {{6, 4, 5}});
    ASSERT_EQ(volume.resolution, ivec3(6, 4, 5));
    for (const auto& texture : volume.textures) ASSERT_EQ(texture.size(), 120u);
    for (int z = 0; z < 5; ++z) {
        for (int y = 0; y < 4; ++y) {
            for (int x = 0; x < 6; ++x) {
                const vec3 center = texelCenter(volume, {x, y, z});
                const ProbeSample truth = probes.sample(center);
                expectNear(sampleProxyVolume(volume, center), truth, 1.0e-4f);
                // The packing that shaders rely on.
                const std::size_t at = std::size_t((z * 4 + y) * 6 + x);
                for (int c = 0; c < 3; ++c) {
                    for (int i = 0; i < 4; ++i) {
                        EXPECT_NEAR(volume.textures[std::size_t(c)][at][i], truth.radiance[std::size_t(i)][c], 1e-4f);
                        EXPECT_NEAR(volume.textures[std::size_t(4 + c)][at][i], truth.radiance[std::size_t(4 + i)][c],
                                    1e-4f);
                    }
                    EXPECT_NEAR(volume.textures[7][at][c], truth.radiance[8][c], 1e-4f);
                }
                for (int c = 0; c < 4; ++c) EXPECT_NEAR(volume.textures[3][at][c], truth.occlusion[c], 1e-4f);
            }
        }
    }
    // The corners of the box are texel centres.
    EXPECT_LT(glm::distance(texelCenter(volume, {0, 0, 0}), kBox.min), 1.0e-5f);
    EXPECT_LT(glm::distance(texelCenter(volume, {5, 3, 4}), kBox.max), 1.0e-5f);
}

// Between texels: trilinear, computed here from neighbouring texels' own samples.
TEST(ProxyVolumeS16, FilteringIsTrilinear)
{
    const BakedScene baked = probeGrid({4, 3, 5}, rough);
    const ProbeInterpolator probes = rawProbes(baked);
    const ProxyVolume volume = makeProxyVolume(probes, kBox, {{4, 4, 4}});
    Random random(3);
    for (int n = 0; n < 100; ++n) {
        const ivec3 low(random.in(vec3(0), vec3(2.99f)));
        const vec3 part = random.in(vec3(0), vec3(1));
        float expected = 0.0f;
        for (int k = 0; k < 8; ++k) {
            const ivec3 side(k & 1, k >> 1 & 1, k >> 2 & 1);
            const vec3 share = glm::mix(1.0f - part, part, vec3(side));
            expected += share.x * share.y * share.z * probes.sample(texelCenter(volume, low + side)).occlusion[0];
        }
        const vec3 p = glm::mix(texelCenter(volume, low), texelCenter(volume, low + 1), part);
        EXPECT_NEAR(sampleProxyVolume(volume, p).occlusion[0], expected, 1.0e-4f);
    }
}

TEST(ProxyVolumeS16, FollowsTheObjectsTransform)
{
    const BakedScene baked = probeGrid({8, 8, 8}, rough);
    const ProbeInterpolator probes = rawProbes(baked);
    const Bounds box{{-1, -2, -0.5f}, {1, 1, 0.5f}};
    mat4 sheared = pose({3, 8, 7}, {1, -2, 0.4f}) *
                   mat4(vec4(-1.3f, 0, 0, 0), vec4(0.4f, 0.8f, 0, 0), vec4(0, 0, 2, 0), vec4(0, 0, 0, 1));
    for (const mat4& worldFromObject : {pose({2, 9, 8}, {1, 0.3f, -0.4f}), pose({5, 6, 7}, {0, -1, 0.1f}), sheared}) {
        const ProxyVolume volume = makeProxyVolume(probes, box, worldFromObject, {{5, 7, 4}});
        for (int z = 0; z < 4; ++z) {
            for (int y = 0; y < 7; ++y) {
                for (int x = 0; x < 5; ++x) {
                    const vec3 local = glm::mix(box.min, box.max, vec3(x, y, z) / vec3(4, 6, 3));
                    const vec3 world = vec3(worldFromObject * vec4(local, 1));
                    expectNear(sampleProxyVolume(volume, world), probes.sample(world), 2.0e-3f);
                    const vec3 coordinate = vec3(volume.volumeFromWorld * vec4(world, 1));
                    EXPECT_LT(glm::distance(coordinate, (vec3(x, y, z) + 0.5f) / vec3(5, 7, 4)), 1.0e-5f);
                }
            }
        }
    }
}

TEST(ProxyVolumeS16, ResolutionOption)
{
    const BakedScene baked = probeGrid({20, 9, 80}, linear);
    const ProbeInterpolator probes = rawProbes(baked);
    // As the caller says, up to a limit; as the probes are spaced (1.5, 2, 0.75) where he says nothing.
    EXPECT_EQ(makeProxyVolume(probes, kBox, {{3, 1, 1000}}).resolution, ivec3(3, 1, kMaxProxyResolution));
    const Bounds box{{0, 0, 0}, {6, 6.1f, 0.1f}};
    EXPECT_EQ(makeProxyVolume(probes, box).resolution, ivec3(5, 5, 2));
    EXPECT_EQ(makeProxyVolume(probes, box, {{0, 9, 0}}).resolution, ivec3(5, 9, 2));
    EXPECT_EQ(makeProxyVolume(probes, {{0, 0, 0}, {6, 6, 600}}).resolution, ivec3(5, 4, 32));
    // The object's own axes count: turned, its long side runs along the dense axis.
    const mat4 turned(vec4(0, 0, -1, 0), vec4(0, 1, 0, 0), vec4(1, 0, 0, 0), vec4(0, 0, 0, 1));
    EXPECT_EQ(makeProxyVolume(probes, box, turned).resolution, ivec3(9, 5, 2));
    // A single texel stands for the whole box, by its centre.
    const ProxyVolume single = makeProxyVolume(probes, kBox, {{1, 1, 1}});
    expectSample(sampleProxyVolume(single, kBox.min), linear(kBox.center()));
    expectSample(sampleProxyVolume(single, kBox.max), linear(kBox.center()));
}

// More texels come closer to per-point interpolation.
TEST(ProxyVolumeS16, FinerVolumesComeCloser)
{
    const BakedScene baked = probeGrid({4, 3, 5}, rough);
    const ProbeInterpolator probes = rawProbes(baked);
    const auto error = [&](int resolution) {
        const ProxyVolume volume = makeProxyVolume(probes, kBox, {ivec3(resolution)});
        Random random(4);
        float sum = 0.0f;
        for (int n = 0; n < 500; ++n) {
            const vec3 p = random.in(kBox.min, kBox.max);
            sum += std::abs(sampleProxyVolume(volume, p).occlusion[0] - probes.sample(p).occlusion[0]);
        }
        return sum / 500.0f;
    };
    EXPECT_LT(error(8), 0.7f * error(3));
    EXPECT_LT(error(48), 0.2f * error(8));
}

TEST(ProxyVolumeS16, FlatAndEmptyBoxesWork)
{
    const BakedScene baked = probeGrid({4, 3, 5}, linear);
    const ProbeInterpolator probes = rawProbes(baked);
    const auto expectAt = [&](const ProxyVolume& volume, vec3 p, float tolerance) {
        for (int column = 0; column < 4; ++column) {
            for (int row = 0; row < 4; ++row) EXPECT_TRUE(std::isfinite(volume.volumeFromWorld[column][row]));
        }
        expectSample(sampleProxyVolume(volume, p), linear(p), tolerance);
    };
    expectAt(makeProxyVolume(probes, {{-1, 2, 6}, {1, 2, 7}}), {0.3f, 2, 6.4f}, 1.0e-4f);
    expectAt(makeProxyVolume(probes, {{1, 2, 6}, {1, 2, 6}}), {1, 2, 6}, 1.0e-4f);
    mat4 place(1.0f);
    place[3] = vec4(1, 3, 7, 1);
    expectAt(makeProxyVolume(probes, Bounds{}, place), {1, 3, 7}, 1.0e-4f);
    mat4 flattened = place;
    flattened[1] = vec4(0);
    expectAt(makeProxyVolume(probes, {{-1, -1, -1}, {1, 1, 1}}, flattened), {1.5f, 3, 6.5f}, 1.0e-4f);
    expectAt(
        makeProxyVolume(probes, {{-1, -1, -1}, {1, 1, 1}}, place * mat4(vec4(0), vec4(0), vec4(0), vec4(0, 0, 0, 1))),
        {1, 3, 7}, 1.0e-4f);
}

// A group of instances in one volume: each point of each instance is lit by its place, not by its instance's anchor.
TEST(ProxyVolumeS17, OneVolumeForAGroupOfInstances)
{
    const BakedScene baked = probeGrid({8, 8, 8}, linear);
    const ProbeInterpolator probes = rawProbes(baked);
    const std::vector<vec3> places = randomPoints(5, 100, {0, 3, 6}, {6, 12, 9});
    Bounds group;
    for (const vec3 p : places) {
        group.extend(p - 0.4f);
        group.extend(p + 0.4f);
    }
    const ProxyVolume volume = makeProxyVolume(probes, group);
    const std::vector<ProbeSample> own = sampleProbes(probes, places);
    Random random(6);
    for (std::size_t i = 0; i < places.size(); ++i) {
        expectNear(sampleProxyVolume(volume, places[i]), own[i], 2.0e-4f);
        const vec3 onSphere = places[i] + 0.4f * random.direction();
        expectSample(sampleProxyVolume(volume, onSphere), linear(onSphere), 2.0e-5f);
    }
}

TEST(ProxyVolumeS16, WithoutProbesTheSky)
{
    BakedScene baked = emptyScene();
    baked.scene.sky = {{2, 3, 8}, {4, 4, 4}, {3, 2, 1}};
    const ProbeInterpolator probes(baked);
    const ProxyVolume volume = makeProxyVolume(probes, kBox);
    EXPECT_EQ(volume.resolution, ivec3(2));
    expectNear(sampleProxyVolume(volume, kBox.center()), skyProbe(baked.scene.sky), 1.0e-4f);
}

// Who gets a volume by itself, who by wish, who shares.
TEST(ProxyVolumePlanS16, VolumesForLargeStaticObjectsAndOnDemand)
{
    BakedScene baked = probeGrid({4, 3, 5}, linear); // probes 1.5, 2 and 0.75 m apart
    enum { LargeStatic, SmallStatic, Lightmapped, LargeDynamic, AskedFor, RefusedByItsAuthor, NoMesh, kCount };
    for (int i = 0; i < kCount; ++i) {
        const bool small = i == SmallStatic || i == AskedFor;
        addBox(baked, vec3(0, 3, 6), vec3(small ? 0.3f : 2.0f), i != LargeDynamic && i != AskedFor);
    }
    std::vector<Object>& objects = baked.scene.objects;
    objects[AskedFor].probeLighting = ProbeLighting::Volume;
    objects[AskedFor].probeResolution = {4, 65, 1};
    objects[RefusedByItsAuthor].probeLighting = ProbeLighting::Single;
    objects[NoMesh].mesh = -1;
    std::vector<bool> lightmapped(kCount, false);
    lightmapped[Lightmapped] = true;
    const std::vector<Bounds> meshes{{vec3(-1), vec3(1)}};
    const ProbeInterpolator probes = rawProbes(baked);

    const ProxyVolumePlan plan = planProxyVolumes(baked.scene, meshes, lightmapped, probes);
    ASSERT_EQ(plan.volumes.size(), 2u);
    EXPECT_EQ(plan.volumeOf, (std::vector<int>{1, -1, -1, -1, 0, -1, -1}));
    EXPECT_EQ(plan.volumes[0].resolution, ivec3(4, kMaxProxyResolution, 1));
    EXPECT_EQ(plan.volumes[1].resolution, ivec3(4, 3, 7)); // 4 m: texels no farther apart than probes
    const ProxyVolume volume = makeProxyVolume(probes, baked.scene, meshes, plan.volumes[1]);
    EXPECT_EQ(volume.resolution, ivec3(4, 3, 7));
    expectSample(sampleProxyVolume(volume, vec3(-1, 2, 7)), linear(vec3(-1, 2, 7)), 2.0e-5f);

    const BakedScene dark = emptyScene(); // no probes
    EXPECT_TRUE(planProxyVolumes(baked.scene, meshes, lightmapped, rawProbes(dark)).volumes.empty());
}

TEST(ProxyVolumePlanS17, AGroupSharesTheBoxOfItsMembers)
{
    BakedScene baked = probeGrid({4, 3, 5}, linear);
    for (int i = 0; i < 6; ++i) {
        addBox(baked, vec3(0.4f * float(i) - 1, 2 + 0.3f * float(i), 6), vec3(0.1f), false);
        Object& object = baked.scene.objects.back();
        object.probeGroup = i % 2 == 0 ? 7 : 3;
        object.probeLighting = i < 4 ? ProbeLighting::Volume : ProbeLighting::Automatic;
        object.probeResolution = {3, 4, 2};
    }
    const std::vector<Bounds> meshes{{vec3(-1), vec3(1)}};
    const ProbeInterpolator probes = rawProbes(baked);
    const ProxyVolumePlan plan =
        planProxyVolumes(baked.scene, meshes, std::vector<bool>(baked.scene.objects.size(), false), probes);
    ASSERT_EQ(plan.volumes.size(), 2u);
    EXPECT_EQ(plan.volumeOf, (std::vector<int>{1, 0, 1, 0, -1, -1}));
    const ProxyVolume volume = makeProxyVolume(probes, baked.scene, meshes, plan.volumes[1]);
    EXPECT_EQ(volume.resolution, ivec3(3, 4, 2));
    // From the first member's lower corner to the last one's upper one.
    const vec3 low(-1.1f, 1.9f, 5.9f);
    const vec3 high(-0.1f, 2.7f, 6.1f);
    for (const vec3 corner : {low, high}) {
        expectSample(sampleProxyVolume(volume, corner), linear(corner), 2.0e-5f);
        const vec3 beyond = corner + (corner - 0.5f * (low + high));
        expectSample(sampleProxyVolume(volume, beyond), linear(corner), 2.0e-5f);
    }
}

TEST(ProxyVolumePlanS16, TooManyTexelsMakeVolumesCoarser)
{
    BakedScene baked = probeGrid({4, 3, 5}, linear);
    for (int i = 0; i < 50; ++i) {
        addBox(baked, vec3(0, 3, 6), vec3(0.5f), false);
        baked.scene.objects.back().probeLighting = ProbeLighting::Volume;
        baked.scene.objects.back().probeResolution = ivec3(i == 0 ? 8 : 64);
    }
    const std::vector<Bounds> meshes{{vec3(-1), vec3(1)}};
    const ProxyVolumePlan plan = planProxyVolumes(baked.scene, meshes, std::vector<bool>(50, false), rawProbes(baked));
    EXPECT_EQ(plan.volumes[0].resolution, ivec3(8));
    for (std::size_t i = 1; i < 50; ++i) EXPECT_EQ(plan.volumes[i].resolution, ivec3(32));
}

} // namespace
} // namespace halflight::proxy_volume_test
