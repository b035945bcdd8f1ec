// S2, S3. Penumbrae of realtime shadows have the width that the light's size gives them: a straight edge has the
// profile that the bake's rays find (ShadowmaskS8.PenumbraOfAHalfPlaneIsTheVisibleSegmentOfTheSun), so shadows do not
// change their softness where realtime ends and the mask begins.
#include "render/render_test.h"

#include "halflight/shading/penumbra.h"

#include <glm/gtc/matrix_transform.hpp>

#include <cmath>

namespace halflight::test::penumbra_test {
namespace {

constexpr ivec2 kSize{320, 180};
constexpr float kEdge = 0.1131f; // on no line of a shadow map's texels
constexpr float kSlab = 2.0f;    // height of the slab
constexpr float kLight = 4.0f;   // height of local lights

/// A floor, and a slab 2 m above it that covers all x > kEdge. The camera is below the slab.
struct HalfCovered {
    BakedScene baked;
    Camera camera = lookAt(vec3(-1.2f, 1.2f, 1.5f), vec3(0.1f, 0, 0), 0.9f);

    explicit HalfCovered(const Light& light)
    {
        Scene& scene = baked.scene;
        const int material = addMaterial(scene, vec4(vec3(0.5f), 1.0f));
        addObject(scene, makeRectangle(20, 20, material), mat4(1.0f), true);
        addObject(scene, makeRectangle(8, 20, material), glm::translate(mat4(1.0f), vec3(kEdge + 4, kSlab, 0)), true);
        scene.lights.push_back(light);
    }
};

Light sun(float angularRadius)
{
    Light light = directionalLight(vec3(0, 1, 0), 3.0f);
    light.angularRadiusRadians = angularRadius;
    return light;
}

/// Straight above the edge and twice as high, so that the penumbra is as wide as the source.
Light above(LightType type)
{
    Light light;
    light.type = type;
    light.worldFromLight = lightPose(vec3(kEdge, kLight, 0), vec3(0, -1, 0));
    light.intensity = 100.0f;
    light.outerConeRadians = 0.9f;
    return light;
}

struct Profile {
    double squares = 0.0;
    float worst = 0.0f;
    int pixels = 0;  ///< of the floor around the edge
    int partial = 0; ///< within the penumbra
    [[nodiscard]] float rms() const { return float(std::sqrt(squares / std::max(pixels, 1))); }
};

class PenumbraeS2 : public BothPaths {
protected:
    /// R at the pixels of the floor against a profile over the distance from the edge, in half-widths.
    template<typename Expected>
    Profile measure(const Light& light, const RenderSettings& settings, float halfWidth, const Expected& expected)
    {
        const HalfCovered scene(light);
        HalfCovered unshadowed(light);
        unshadowed.baked.scene.lights[0].castShadows = false;
        const RenderedFrame frame = render(scene.baked, scene.camera, settings);
        EXPECT_TRUE(frame.plan.lights[0].hasRealtimeShadow);
        const RenderedFrame full = render(unshadowed.baked, unshadowed.camera, settings);
        Profile profile;
        for (int y = 0; y < kSize.y; ++y)
            for (int x = 0; x < kSize.x; ++x) {
                const Ray ray = pixelRay(scene.camera, kSize, {x, y});
                if (ray.direction.y > -0.1f) continue;
                const vec3 point = onPlane(ray, 0.0f);
                const float distance = (point.x - kEdge) / halfWidth;
                if (std::abs(point.z) > 1.0f || std::abs(distance) > 2.0f) continue;
                const float difference = frame.radiance(x, y).x / full.radiance(x, y).x - expected(distance);
                profile.squares += double(difference * difference);
                profile.worst = std::max(profile.worst, std::abs(difference));
                ++profile.pixels;
                profile.partial += std::abs(distance) < 0.9f ? 1 : 0;
            }
        return profile;
    }

    [[nodiscard]] RenderSettings settings() const
    {
        RenderSettings result;
        result.mode = RunMode::Realtime;
        result.path = GetParam();
        result.size = kSize;
        result.shadows.distanceMeters = 12.0f;
        return result;
    }
};
INSTANTIATE_TEST_SUITE_P(, PenumbraeS2, kBothPaths, pathNameOf);

float ofDisk(float distance)
{
    return shading::diskBeyond(distance);
}
float ofRectangle(float distance)
{
    return glm::clamp(0.5f - 0.5f * distance, 0.0f, 1.0f);
}

// Widths from 1.5 texels of the first cascade to more than a cascade's border: then the next ones take over.
TEST_P(PenumbraeS2, TheSunsEdgeIsTheVisibleSegmentOfItsDisk)
{
    for (const float halfWidth : {0.02f, 0.05f, 0.1f, 0.3f}) {
        const Light light = sun(std::atan(halfWidth / kSlab));
        const Profile profile = measure(light, settings(), halfWidth, ofDisk);
        RecordProperty("rms_" + std::to_string(int(1000 * halfWidth)), std::to_string(profile.rms()));
        EXPECT_GT(profile.partial, 100) << halfWidth;
        EXPECT_LE(profile.rms(), 0.025f) << halfWidth;
        EXPECT_LE(profile.worst, 0.09f) << halfWidth;
        if (halfWidth < 0.05f) continue;
        RenderSettings without = settings();
        without.shadows.penumbrae = false;
        EXPECT_GT(measure(light, without, halfWidth, ofDisk).rms(), 0.06f) << halfWidth;
    }
}

TEST_P(PenumbraeS2, PointAndSpotLightsOfASize)
{
    for (const LightType type : {LightType::Point, LightType::Spot}) {
        Light light = above(type);
        light.radiusMeters = 0.1f;
        const Profile profile = measure(light, settings(), light.radiusMeters, ofDisk);
        EXPECT_GT(profile.partial, 500) << int(type);
        EXPECT_LE(profile.rms(), 0.03f) << int(type);
        EXPECT_LE(profile.worst, 0.12f) << int(type);
    }
}

TEST_P(PenumbraeS2, AreaLightsHaveTheirShape)
{
    Light disk = above(LightType::Disk);
    disk.sizeMeters = vec2(0.2f);
    const Profile ofDisks = measure(disk, settings(), 0.1f, ofDisk);
    EXPECT_LE(ofDisks.rms(), 0.03f);
    Light rectangle = above(LightType::Rectangle);
    rectangle.sizeMeters = vec2(0.4f, 0.2f);
    const vec3 halfWidth = rectangle.halfWidth();
    const float acrossEdge = std::max(std::abs(halfWidth.x), std::abs(rectangle.halfHeight().x));
    const Profile ofRectangles = measure(rectangle, settings(), acrossEdge, ofRectangle);
    EXPECT_LE(ofRectangles.rms(), 0.03f) << acrossEdge;
}

// Points and lights whose penumbrae are narrower than the filter's kernel have the pixels they had.
TEST_P(PenumbraeS2, WithoutASizeNothingChanges)
{
    RenderSettings without = settings();
    without.shadows.penumbrae = false;
    for (const Light& light : {sun(0.0f), above(LightType::Point)}) {
        const HalfCovered scene(light);
        const RenderedFrame a = render(scene.baked, scene.camera, settings());
        const RenderedFrame b = render(scene.baked, scene.camera, without);
        EXPECT_EQ(a.radiance.texels(), b.radiance.texels());
    }
}

// A post on the floor: its shadow is sharp at its foot and wide at its end.
TEST_P(PenumbraeS2, ShadowsAreSharpAtTheFootAndSoftAtTheEnd)
{
    Light light = directionalLight(glm::normalize(vec3(-1, 1, 0)), 3.0f);
    light.angularRadiusRadians = 0.03f;
    BakedScene baked;
    const int material = addMaterial(baked.scene, vec4(vec3(0.5f), 1.0f));
    baked.scene.materials[std::size_t(material)].doubleSided = true;
    addObject(baked.scene, makeRectangle(20, 20, material), mat4(1.0f), true);
    const mat4 upright = glm::translate(mat4(1.0f), vec3(0, 1, 0)) * glm::rotate(mat4(1.0f), kPi / 2.0f, vec3(0, 0, 1));
    addObject(baked.scene, makeRectangle(2, 1, material), upright, true); // x = 0, 2 m high, z from -0.5 to 0.5
    baked.scene.lights.push_back(light);
    const Camera camera = lookAt(vec3(1.0f, 3.0f, 0.01f), vec3(1.0f, 0, 0), 0.9f);
    const RenderedFrame frame = render(baked, camera, settings());
    // Width along z from 20 % to 80 % of the light, beside the shadow's side at z = 0.5.
    const auto radianceAt = [&](float x, float z) {
        const ivec2 pixel = pixelOf(camera, kSize, {x, 0, z});
        return frame.radiance(pixel.x, pixel.y).x;
    };
    const auto widthAt = [&](float x) {
        float lit = 0.0f;
        for (float z = 0.4f; z < 0.6f; z += 0.001f) lit = std::max(lit, radianceAt(x, z));
        float from = 0.0f;
        float to = 0.0f;
        for (float z = 0.4f; z < 0.6f; z += 0.001f) {
            const float part = radianceAt(x, z) / lit;
            if (part < 0.2f) from = z;
            if (part < 0.8f) to = z;
        }
        return to - from;
    };
    EXPECT_LT(widthAt(0.2f), 0.03f);
    // The caster of the shadow at x is x sqrt(2) away: a disk's profile goes from 20 % to 80 % over 0.98 half-widths.
    EXPECT_NEAR(widthAt(1.6f), 0.98f * 0.03f * 1.6f * std::sqrt(2.0f), 0.02f);
}

} // namespace
} // namespace halflight::test::penumbra_test
