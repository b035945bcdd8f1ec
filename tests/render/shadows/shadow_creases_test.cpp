// S2, S3. Shadow maps where a caster stands on its receiver: no light behind the foot of a thin wall, no dark line in
// the corners of a lit room, however coarse the map.
#include "render/render_test.h"

#include <glm/gtc/matrix_transform.hpp>

#include <cmath>

namespace halflight::test::shadow_creases_test {
namespace {

constexpr ivec2 kSize{320, 180};
const vec3 kAlbedo(0.5f);

/// The six faces of a box of this size around the origin of its own space.
void addBox(Scene& scene, vec3 size, const mat4& pose, int material)
{
    for (int axis = 0; axis < 3; ++axis) {
        for (const float side : {-1.0f, 1.0f}) {
            vec3 normal(0.0f);
            normal[axis] = side;
            const vec3 u(axis == 0 ? vec3(0, 0, 1) : vec3(1, 0, 0));
            const vec3 v = glm::cross(u, normal);
            const mat4 face(vec4(u, 0), vec4(normal, 0), vec4(v, 0), vec4(0.5f * size * normal, 1));
            const int w = axis == 0 ? 2 : 0;
            const int d = axis == 1 ? 2 : 1;
            addObject(scene, makeRectangle(size[w], size[d], material), pose * face, true);
        }
    }
}

/// By how much of the light a pixel of a plane is off; `truth` is 0 or 1.
float errorOf(const RenderedFrame& frame, ivec2 pixel, const ShadedPoint& point, const Light& light, float truth)
{
    return std::abs(frame.radiance(pixel.x, pixel.y).x / directRadiance(point, light, 1.0f).x - truth);
}

class CreasesS2 : public BothPaths {};
INSTANTIATE_TEST_SUITE_P(, CreasesS2, kBothPaths, pathNameOf);

/// Walls of 2 cm under a sun whose cascades reach a kilometre: pixels of the floor that lie behind a wall, in the
/// middle of its shadow, and those before it, up to its foot.
TEST_P(CreasesS2, NoLightBehindThinWalls)
{
    constexpr float kThickness = 0.02f;
    constexpr float kHeight = 2.5f;
    for (const float turn : {0.0f, 0.5f, 1.1f}) {
        for (const float elevation : {20.0f, 45.0f, 65.0f}) {
            for (const float eyeDistance : {4.0f, 14.0f, 40.0f}) {
                BakedScene baked;
                Scene& scene = baked.scene;
                const int material = addMaterial(scene, vec4(kAlbedo, 1.0f));
                addObject(scene, makeRectangle(400, 400, material), mat4(1.0f), true);
                const mat4 pose = glm::rotate(mat4(1.0f), turn, vec3(0, 1, 0));
                addBox(scene, vec3(kThickness, kHeight, 8.0f),
                       pose * glm::translate(mat4(1.0f), vec3(0.5f * kThickness, 0.5f * kHeight, 0)), material);
                const float e = glm::radians(elevation);
                // In the wall's space the light comes from -x, and the wall is 0 to 2 cm.
                const vec3 toSun = mat3(pose) * glm::normalize(vec3(-std::cos(e), std::sin(e), 0.3f * std::cos(e)));
                scene.lights.push_back(directionalLight(toSun, 3.0f));
                const mat4 wallFromWorld = glm::inverse(pose);
                for (const float side : {1.0f, -1.0f}) { // behind, and before
                    const Camera camera =
                        lookAt(mat3(pose) * vec3(side * eyeDistance, 0.35f * eyeDistance, 0.1f * eyeDistance), vec3(0),
                               6.0f / eyeDistance);
                    RenderSettings settings;
                    settings.path = GetParam();
                    settings.size = kSize;
                    settings.shadows = shadowsReaching(1000.0f, settings.shadows);
                    const RenderedFrame frame = render(baked, camera, settings);
                    ASSERT_TRUE(frame.plan.lights[0].hasRealtimeShadow);
                    int checked = 0;
                    int wrong = 0;
                    float worst = 0.0f;
                    for (int y = 0; y < kSize.y; ++y) {
                        for (int x = 0; x < kSize.x; ++x) {
                            const Ray ray = pixelRay(camera, kSize, {x, y});
                            if (ray.direction.y > -1.0e-3f) continue;
                            const vec3 world = onPlane(ray, 0.0f);
                            const vec3 p(wallFromWorld * vec4(world, 1.0f));
                            const float from = side > 0.0f ? p.x - kThickness : -p.x; // of the wall's face
                            if (from < 1.0e-3f || from > 0.5f || std::abs(p.z) > 1.5f) continue;
                            const ShadedPoint point{world, vec3(0, 1, 0), -ray.direction, kAlbedo};
                            const float off = errorOf(frame, {x, y}, point, scene.lights[0], side > 0.0f ? 0.0f : 1.0f);
                            ++checked;
                            wrong += off > 0.01f ? 1 : 0;
                            worst = std::max(worst, off);
                        }
                    }
                    EXPECT_EQ(wrong, 0) << "of " << checked << ", worst " << worst << ": turn " << turn << " elevation "
                                        << elevation << " eye " << eyeDistance << " side " << side;
                    EXPECT_GT(checked, 30);
                }
            }
        }
    }
}

/// A room with a lamp in it, whose faces have few texels: every pixel of floor, ceiling and walls is lit.
TEST_P(CreasesS2, NoDarkLinesInCorners)
{
    const vec3 half(2.0f, 1.25f, 1.5f);
    for (const int atlas : {512, 1024, 4096}) {
        for (const vec3 lamp : {vec3(0, 0.9f, 0), vec3(-1.2f, 0.2f, 0.7f)}) {
            BakedScene baked;
            Scene& scene = baked.scene;
            const int material = addMaterial(scene, vec4(kAlbedo, 1.0f));
            for (int axis = 0; axis < 3; ++axis) {
                for (const float side : {-1.0f, 1.0f}) {
                    vec3 normal(0.0f); // inward
                    normal[axis] = -side;
                    const vec3 u(axis == 0 ? vec3(0, 0, 1) : vec3(1, 0, 0));
                    const mat4 face(vec4(u, 0), vec4(normal, 0), vec4(glm::cross(u, normal), 0),
                                    vec4(-half * normal, 1));
                    addObject(scene,
                              makeRectangle(2.0f * half[axis == 0 ? 2 : 0], 2.0f * half[axis == 1 ? 2 : 1], material),
                              face, true);
                }
            }
            Light light;
            light.type = LightType::Point;
            light.worldFromLight = lightPose(lamp, vec3(0, -1, 0));
            light.intensity = 100.0f;
            scene.lights.push_back(light);
            const Camera camera = lookAt(vec3(1.8f, 0.8f, 1.3f), vec3(-2, -0.8f, -1.5f), 1.2f);
            RenderSettings settings;
            settings.path = GetParam();
            settings.size = kSize;
            settings.shadows.atlasSize = atlas;
            const RenderedFrame frame = render(baked, camera, settings);
            ASSERT_TRUE(frame.plan.lights[0].hasRealtimeShadow);
            int wrong = 0;
            float worst = 0.0f;
            for (int y = 0; y < kSize.y; ++y) {
                for (int x = 0; x < kSize.x; ++x) {
                    const Ray ray = pixelRay(camera, kSize, {x, y});
                    float reach = kInfinity;
                    vec3 normal(0.0f);
                    for (int axis = 0; axis < 3; ++axis) {
                        const float side = ray.direction[axis] > 0.0f ? 1.0f : -1.0f;
                        const float t = (side * half[axis] - ray.origin[axis]) / ray.direction[axis];
                        if (t >= reach) continue;
                        reach = t;
                        normal = vec3(0.0f);
                        normal[axis] = -side;
                    }
                    const ShadedPoint point{ray.origin + reach * ray.direction, normal, -ray.direction, kAlbedo};
                    const float off = errorOf(frame, {x, y}, point, light, 1.0f);
                    wrong += off > 0.01f ? 1 : 0;
                    worst = std::max(worst, off);
                }
            }
            EXPECT_EQ(wrong, 0) << "worst " << worst << ", atlas " << atlas << ", lamp at y " << lamp.y;
        }
    }
}

} // namespace
} // namespace halflight::test::shadow_creases_test
