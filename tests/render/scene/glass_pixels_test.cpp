// What one sees through coloured glass.
#include "render/render_test.h"

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <cmath>

namespace halflight::test::glass_pixels_test {
namespace {

constexpr ivec2 kSize{96, 54};

class GlassPixels : public BothPaths {};
INSTANTIATE_TEST_SUITE_P(, GlassPixels, kBothPaths, pathNameOf);

/// A white wall in the plane z = 0 under a sun, and a pane half a metre before it.
struct Pane {
    BakedScene baked;
    Light sun = directionalLight(vec3(0, 0.2f, 1), 2.0f);
    int material = 0;

    explicit Pane(vec4 color)
    {
        Scene& scene = baked.scene;
        const mat4 upright = glm::rotate(mat4(1.0f), kPi / 2.0f, vec3(1, 0, 0));
        addObject(scene, makeRectangle(4, 4, addMaterial(scene, vec4(1.0f))), upright, true);
        material = addMaterial(scene, color);
        addObject(scene, makeRectangle(3, 3, material), glm::translate(mat4(1.0f), vec3(0, 0, 0.5f)) * upright, false);
        scene.objects.back().castShadows = false; // what is seen through it, not what it keeps back
        scene.lights.push_back(sun);
    }
    Material& pane() { return baked.scene.materials[std::size_t(material)]; }

    /// The wall through the pane, and over it the light of what the pane stops.
    [[nodiscard]] vec3 expected(const Camera& camera) const
    {
        const Material& pane = baked.scene.materials[std::size_t(material)];
        const Ray ray = pixelRay(camera, kSize, kSize / 2);
        ShadedPoint point{ray.origin - ray.direction * (ray.origin.z / ray.direction.z), vec3(0, 0, 1), -ray.direction,
                          vec3(1.0f)};
        const vec3 behind = directRadiance(point, sun, 1.0f);
        point.baseColor = vec3(pane.baseColor);
        return behind * pane.passed(pane.baseColor, 0.0f, 1.0f, vec3(1.0f)) +
               directRadiance(point, sun, 1.0f) * pane.coverage(pane.baseColor.w, 0.0f, 1.0f);
    }
};

TEST_P(GlassPixels, TransmissionAndTintColorWhatIsBehindS35)
{
    const Camera camera = lookAt(vec3(0.3f, 0.2f, 3.0f), vec3(0.3f, 0.2f, 0));
    RenderSettings settings;
    settings.path = GetParam();
    settings.size = kSize;
    settings.shadows.directionalMapSize = 1024;
    const auto seen = [&](const Pane& pane) {
        return vec3(render(pane.baked, camera, settings).radiance(kSize.x / 2, kSize.y / 2));
    };
    Pane glass(vec4(0.9f, 0.25f, 0.1f, 1.0f));
    glass.pane().transmission = 0.7f;
    EXPECT_TRUE(near(seen(glass), glass.expected(camera)));
    Pane tinted(vec4(0.1f, 0.4f, 0.9f, 0.4f));
    tinted.pane().alphaMode = Material::AlphaMode::Blend;
    tinted.pane().tinted = true;
    EXPECT_TRUE(near(seen(tinted), tinted.expected(camera)));
}

/// A block of a metre with vertices of their own on each face, so that corners at one place have to be found.
Mesh makeBlock(int material)
{
    Mesh mesh;
    MeshPart& part = mesh.parts.emplace_back();
    part.material = material;
    for (int axis = 0; axis < 3; ++axis)
        for (const float side : {-1.0f, 1.0f}) {
            vec3 normal(0.0f);
            normal[axis] = side;
            vec3 across(0.0f);
            across[(axis + 1) % 3] = 1.0f;
            const vec3 up = glm::cross(normal, across);
            const auto first = uint32_t(part.positions.size());
            for (const vec2 corner : {vec2(-1, -1), vec2(1, -1), vec2(1, 1), vec2(-1, 1)}) {
                part.positions.push_back(0.5f * (normal + corner.x * across + corner.y * up));
                part.normals.push_back(normal);
            }
            for (const uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) part.indices.push_back(first + i);
        }
    return mesh;
}

/// Metres of a ray within a box, between the camera and the plane z = 0.
float wayThrough(const Ray& ray, vec3 low, vec3 high)
{
    float begin = 0.0f;
    float end = -ray.origin.z / ray.direction.z;
    for (int axis = 0; axis < 3; ++axis) {
        const float a = (low[axis] - ray.origin[axis]) / ray.direction[axis];
        const float b = (high[axis] - ray.origin[axis]) / ray.direction[axis];
        begin = std::max(begin, std::min(a, b));
        end = std::min(end, std::max(a, b));
    }
    return std::max(end - begin, 0.0f);
}

/// A white wall in the plane z = 0, which shines by itself, and glass in front of it that reflects nothing.
struct Volume {
    static constexpr vec3 kLeft{0.2f, 0.7f, 0.95f}; ///< of white light after kDistance
    static constexpr float kDistance = 0.3f;        ///< metres
    BakedScene baked;
    vec3 nits{3.0f, 2.0f, 1.0f};
    int glass = 0;

    Volume()
    {
        const mat4 upright = glm::rotate(mat4(1.0f), kPi / 2.0f, vec3(1, 0, 0));
        const int wall = addMaterial(baked.scene, vec4(1.0f));
        baked.scene.materials[std::size_t(wall)].emissiveNits = nits;
        addObject(baked.scene, makeRectangle(40, 40, wall), upright, true);
        glass = addMaterial(baked.scene, vec4(0.5f, 0.6f, 0.7f, 1.0f));
        Material& material = baked.scene.materials[std::size_t(glass)];
        material.transmission = 1.0f;
        material.thickness = 1.0f;
        material.attenuationColor = kLeft;
        material.attenuationMeters = kDistance;
    }
    /// The wall through so many metres of glass, behind so many faces that are seen.
    [[nodiscard]] vec3 through(float meters, int faces) const
    {
        const vec3 face = kGlassTransmittance * vec3(0.5f, 0.6f, 0.7f);
        return nits * glm::pow(kLeft, vec3(meters / kDistance)) * glm::pow(face, vec3(float(faces)));
    }
};

class GlassVolumes : public GlassPixels {
protected:
    vec3 seen(const Volume& volume, const Camera& camera)
    {
        RenderSettings settings;
        settings.path = GetParam();
        settings.size = kSize;
        return vec3(render(volume.baked, camera, settings).radiance(kSize.x / 2, kSize.y / 2));
    }
};
INSTANTIATE_TEST_SUITE_P(, GlassVolumes, kBothPaths, pathNameOf);

TEST_P(GlassVolumes, ClosedGlassTakesLightByTheWayThroughItS35)
{
    const Camera camera = lookAt(vec3(2.0f, 1.1f, 4.0f), vec3(0.1f, 0.05f, 0.4f));
    const Ray ray = pixelRay(camera, kSize, kSize / 2);
    const vec3 half(0.35f, 0.45f, 0.3f);
    const auto blockAt = [&](vec3 center) {
        Volume volume;
        const mat4 place = glm::scale(glm::translate(mat4(1.0f), center), 2.0f * half);
        addObject(volume.baked.scene, makeBlock(volume.glass), place, false);
        return volume;
    };
    const vec3 before(0.1f, 0.05f, 0.5f);
    const float meters = wayThrough(ray, before - half, before + half);
    ASSERT_GT(meters, 0.4f);
    EXPECT_TRUE(near(seen(blockAt(before), camera), Volume().through(meters, 1)));
    // Sunk into the wall: the ray ends inside.
    const vec3 sunk(0.1f, 0.05f, 0.1f);
    const float shorter = wayThrough(ray, sunk - half, sunk + half);
    ASSERT_LT(shorter, meters - 0.1f);
    EXPECT_TRUE(near(seen(blockAt(sunk), camera), Volume().through(shorter, 1)));
    // Behind the wall: nothing of it is seen.
    EXPECT_TRUE(near(seen(blockAt(vec3(0.1f, 0.05f, -1.0f)), camera), Volume().through(0.0f, 0)));
    // Around the camera: the ray begins inside, and no face is before it.
    const Camera inside = lookAt(before, vec3(0.0f, 0.1f, 0.0f));
    const float way = wayThrough(pixelRay(inside, kSize, kSize / 2), before - half, before + half);
    EXPECT_TRUE(near(seen(blockAt(before), inside), Volume().through(way, 0)));
    // Two blocks, one of them mirrored, add up.
    Volume two = blockAt(before);
    const vec3 nearer(0.6f, 0.3f, 1.5f);
    const mat4 mirrored = glm::scale(glm::translate(mat4(1.0f), nearer), vec3(-2.0f, 2.0f, 2.0f) * half);
    addObject(two.baked.scene, makeBlock(two.glass), mirrored, false);
    const float both = meters + wayThrough(ray, nearer - half, nearer + half);
    ASSERT_GT(both, meters + 0.2f);
    EXPECT_TRUE(near(seen(two, camera), two.through(both, 2)));
}

TEST_P(GlassVolumes, OpenGlassTakesLightByItsThicknessS35)
{
    // A pane, three times as thick in the world as in its mesh, seen at a slant.
    const Camera camera = lookAt(vec3(2.0f, 1.1f, 4.0f), vec3(0.1f, 0.05f, 0.4f));
    const Ray ray = pixelRay(camera, kSize, kSize / 2);
    Volume volume;
    volume.baked.scene.materials[std::size_t(volume.glass)].thickness = 0.05f;
    const mat4 upright = glm::rotate(mat4(1.0f), kPi / 2.0f, vec3(1, 0, 0));
    const mat4 place = glm::scale(glm::translate(mat4(1.0f), vec3(0, 0, 0.5f)) * upright, vec3(1.0f, 3.0f, 1.0f));
    addObject(volume.baked.scene, makeRectangle(3, 3, volume.glass), place, false);
    const float meters = 3.0f * 0.05f / std::abs(glm::normalize(ray.direction).z);
    EXPECT_TRUE(near(seen(volume, camera), volume.through(meters, 1)));
}

} // namespace
} // namespace halflight::test::glass_pixels_test
