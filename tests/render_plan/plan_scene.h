#pragma once
// Small scenes for tests of frame planning.

#include "halflight/render/frame.h"

#include <random>
#include <string>

namespace halflight::test {

/// Numbers that are the same with every standard library.
class Random {
public:
    explicit Random(uint32_t seed) : generator_(seed) {}
    float unit() { return float(generator_() >> 8) * 0x1.0p-24f; }
    float in(float low, float high) { return low + (high - low) * unit(); }
    vec3 in(vec3 low, vec3 high)
    {
        const float x = in(low.x, high.x);
        const float y = in(low.y, high.y);
        return {x, y, in(low.z, high.z)};
    }
    vec3 direction()
    {
        const float z = in(-1.0f, 1.0f);
        const float phi = in(0.0f, 2.0f * kPi);
        const float r = std::sqrt(std::max(0.0f, 1.0f - z * z));
        return {r * std::cos(phi), r * std::sin(phi), z};
    }
    std::mt19937& generator() { return generator_; }

private:
    std::mt19937 generator_;
};

/// Pose at `position` whose local -Z points along `forward`.
inline mat4 pose(vec3 position, vec3 forward)
{
    const vec3 z = -glm::normalize(forward);
    const vec3 x = glm::normalize(glm::cross(std::abs(z.y) < 0.9f ? vec3(0, 1, 0) : vec3(1, 0, 0), z));
    const vec3 y = glm::cross(z, x);
    return mat4(vec4(x, 0), vec4(y, 0), vec4(z, 0), vec4(position, 1));
}

/// A scene whose mesh 0 is the cube [-1, 1]^3.
inline BakedScene emptyScene(MixedLightingMode mode = MixedLightingMode::Shadowmask)
{
    BakedScene baked;
    baked.isBaked = true;
    baked.mode = mode;
    Mesh cube;
    MeshPart part;
    for (int i = 0; i < 8; ++i) part.positions.emplace_back(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    cube.parts.push_back(part);
    baked.scene.meshes.push_back(cube);
    return baked;
}

inline void addBox(BakedScene& baked, vec3 center, vec3 half, bool isStatic)
{
    Object object;
    object.name = isStatic ? "static" : "dynamic";
    object.mesh = 0;
    object.isStatic = isStatic;
    object.worldFromObject = mat4(vec4(half.x, 0, 0, 0), vec4(0, half.y, 0, 0), vec4(0, 0, half.z, 0), vec4(center, 1));
    baked.scene.objects.push_back(object);
}

/// A light as the bake leaves it.
inline Light bakedLight(const std::string& name, LightType type, vec3 position, vec3 direction, LightMode bakeType,
                        int channel)
{
    Light light;
    light.name = name;
    light.type = type;
    light.intensity = 100.0f;
    light.worldFromLight = pose(position, direction);
    light.mode = bakeType;
    light.baking.isBaked = bakeType != LightMode::Realtime;
    light.baking.bakeType = bakeType;
    light.baking.occlusionMaskChannel = channel;
    light.baking.worldFromLight = light.worldFromLight;
    return light;
}

inline FrameView lookFrom(vec3 eye, vec3 forward, ivec2 size = {1280, 720})
{
    FrameView view;
    view.camera.worldFromCamera = pose(eye, forward);
    view.size = size;
    return view;
}

inline FramePlan plan(const BakedScene& baked, const FrameView& view, RunMode mode, const ShadowSettings& shadows = {})
{
    return planFrame(baked, objectBounds(baked.scene), view, mode, shadows);
}

/// The frame's record of the light with this name; null when it is not in the frame.
inline const FrameLight* find(const BakedScene& baked, const FramePlan& plan, const std::string& name)
{
    for (const FrameLight& light : plan.lights) {
        if (baked.scene.lights[std::size_t(light.light)].name == name) return &light;
    }
    return nullptr;
}

inline bool anyWarning(const FramePlan& plan, const std::string& part)
{
    for (const std::string& warning : plan.warnings) {
        if (warning.find(part) != std::string::npos) return true;
    }
    return false;
}

/// World position of a point of the picture: uv from the top left, at a depth along the camera's axis.
inline vec3 pointInView(const FrameView& view, vec2 uv, float depth)
{
    const Camera& camera = view.camera;
    const float halfY = camera.orthographic ? 0.5f * camera.orthographicHeightMeters
                                            : depth * std::tan(0.5f * camera.verticalFovRadians);
    const float halfX = halfY * float(view.size.x) / float(view.size.y);
    return vec3(camera.worldFromCamera *
                vec4((2.0f * uv.x - 1.0f) * halfX, (1.0f - 2.0f * uv.y) * halfY, -depth, 1.0f));
}

/// A floor, a dynamic box above it, and a camera that sees both.
inline BakedScene stage(MixedLightingMode mode = MixedLightingMode::Shadowmask)
{
    BakedScene baked = emptyScene(mode);
    addBox(baked, {0, -0.5f, 0}, {20, 0.5f, 20}, true);
    addBox(baked, {0, 1, 0}, {0.5f, 0.5f, 0.5f}, false);
    return baked;
}
inline FrameView stageView()
{
    return lookFrom({0, 4, 12}, {0, -0.3f, -1});
}

} // namespace halflight::test
