#include "frame_scenes.h"

#include "halflight/shading/random.h"

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/packing.hpp>

#include <algorithm>
#include <cmath>

namespace halflight::bench {
namespace {

constexpr int kPageSize = 1024;
constexpr float kFieldMeters = 64.0f;

void addQuad(MeshPart& part, vec3 corner, vec3 u, vec3 v)
{
    const auto first = uint32_t(part.positions.size());
    for (const vec2 t : {vec2(0, 0), vec2(1, 0), vec2(1, 1), vec2(0, 1)}) {
        part.positions.push_back(corner + t.x * u + t.y * v);
        part.normals.push_back(glm::normalize(glm::cross(u, v)));
        part.uv[0].push_back(t);
    }
    for (const uint32_t i : {0, 1, 2, 0, 2, 3}) part.indices.push_back(first + i);
}

Mesh boxMesh(vec3 half, int material)
{
    MeshPart part;
    for (int axis = 0; axis < 3; ++axis) {
        for (const float side : {-1.0f, 1.0f}) {
            vec3 n(0), u(0), v(0);
            n[axis] = side * half[axis];
            u[(axis + 1) % 3] = 2.0f * half[(axis + 1) % 3];
            v[(axis + 2) % 3] = side * 2.0f * half[(axis + 2) % 3];
            addQuad(part, n - 0.5f * u - 0.5f * v, u, v);
        }
    }
    part.material = material;
    Mesh mesh;
    mesh.parts.push_back(std::move(part));
    return mesh;
}

Mesh sphereMesh(float radius, int rings, int material)
{
    MeshPart part;
    const int columns = 2 * rings;
    for (int y = 0; y <= rings; ++y) {
        for (int x = 0; x <= columns; ++x) {
            const float theta = kPi * float(y) / float(rings);
            const float phi = 2.0f * kPi * float(x) / float(columns);
            const vec3 n(std::sin(theta) * std::cos(phi), std::cos(theta), -std::sin(theta) * std::sin(phi));
            part.positions.push_back(radius * n);
            part.normals.push_back(n);
            part.uv[0].emplace_back(float(x) / float(columns), float(y) / float(rings));
        }
    }
    for (int y = 0; y < rings; ++y) {
        for (int x = 0; x < columns; ++x) {
            const auto a = uint32_t(y * (columns + 1) + x);
            const uint32_t below = a + uint32_t(columns) + 1;
            for (const uint32_t i : {a, below, a + 1, a + 1, below, below + 1}) part.indices.push_back(i);
        }
    }
    part.material = material;
    Mesh mesh;
    mesh.parts.push_back(std::move(part));
    return mesh;
}

int addMaterial(Scene& scene, vec3 color)
{
    Material material;
    material.baseColor = vec4(color, 1.0f);
    material.metallic = 0.0f;
    material.roughness = 0.7f;
    scene.materials.push_back(material);
    return int(scene.materials.size()) - 1;
}

Object& addObject(Scene& scene, int mesh, const mat4& worldFromObject, bool isStatic)
{
    Object object;
    object.name = "object " + std::to_string(scene.objects.size());
    object.mesh = mesh;
    object.worldFromObject = worldFromObject;
    object.isStatic = isStatic;
    scene.objects.push_back(object);
    return scene.objects.back();
}

int addMesh(Scene& scene, Mesh mesh)
{
    scene.meshes.push_back(std::move(mesh));
    return int(scene.meshes.size()) - 1;
}

mat4 poseAt(vec3 position, vec3 forward)
{
    const vec3 z = -glm::normalize(forward);
    const vec3 x = glm::normalize(glm::cross(std::abs(z.y) < 0.95f ? vec3(0, 1, 0) : vec3(1, 0, 0), z));
    return mat4(vec4(x, 0), vec4(glm::cross(z, x), 0), vec4(z, 0), vec4(position, 1));
}

Light makeLight(LightType type, vec3 position, vec3 direction, float intensity, float range)
{
    Light light;
    light.type = type;
    light.worldFromLight = poseAt(position, direction);
    light.intensity = intensity;
    light.rangeMeters = range;
    light.innerConeRadians = 0.5f;
    light.outerConeRadians = 0.7f;
    return light;
}

} // namespace

BakedScene withStandInBake(Scene scene, MixedLightingMode mode)
{
    BakedScene baked;
    baked.isBaked = true;
    baked.mode = mode;
    for (Mesh& mesh : scene.meshes) {
        for (MeshPart& part : mesh.parts) {
            part.lightmapUv = part.uv[0];
            part.lightmapUv.resize(part.positions.size(), vec2(0.5f));
            for (vec2& uv : part.lightmapUv) uv = glm::fract(uv);
        }
    }
    for (Object& object : scene.objects) {
        if (object.isStatic && object.lightmapScale > 0.0f) object.lightmap.page = 0;
    }
    int channel = 0;
    for (Light& light : scene.lights) {
        light.baking.isBaked = light.mode != LightMode::Realtime;
        light.baking.bakeType = light.mode;
        light.baking.mixedMode = mode;
        light.baking.worldFromLight = light.worldFromLight;
        const bool wanted = light.mode == LightMode::Mixed && light.castShadows &&
                            (mode == MixedLightingMode::Shadowmask ||
                             (mode == MixedLightingMode::Subtractive && light.type == LightType::Directional));
        const int channels = mode == MixedLightingMode::Subtractive ? 1 : kMostMaskLayers * kLayerChannels;
        light.baking.occlusionMaskChannel = wanted && channel < channels ? channel++ : -1;
    }
    Image<uint32_t> lightmap(kPageSize, kPageSize);
    ImageRgba8 mask(kPageSize, kPageSize);
    for (int y = 0; y < kPageSize; ++y) {
        for (int x = 0; x < kPageSize; ++x) {
            const auto wave = [&](float fx, float fy) {
                return 0.5f + 0.5f * std::sin(fx * float(x) * 0.01f + fy * float(y) * 0.01f);
            };
            lightmap(x, y) = glm::packF3x9_E1x5(vec3(0.6f + wave(1, 2), 0.6f + wave(2, 1), 0.5f + wave(3, 3)));
            const auto lit = [&](float fx, float fy) {
                return uint8_t(glm::clamp(3.0f * wave(fx, fy) - 1.0f, 0.0f, 1.0f) * 255.0f);
            };
            mask(x, y) = u8vec4(lit(1, 3), lit(4, 1), lit(2, 5), lit(5, 2));
        }
    }
    baked.lightmaps.push_back(std::move(lightmap));
    baked.maskLayers = maskLayersOf(scene);
    if (mode == MixedLightingMode::Shadowmask) baked.shadowmasks.assign(std::size_t(baked.maskLayers), mask);

    const Bounds bounds = scene.bounds();
    baked.probes.size = ivec3(6, 4, 6);
    baked.probes.origin = bounds.min;
    baked.probes.spacingMeters = (bounds.max - bounds.min) / vec3(5, 3, 5);
    for (int z = 0; z < 6; ++z) {
        for (int y = 0; y < 4; ++y) {
            for (int x = 0; x < 6; ++x) {
                Probe probe;
                probe.position = baked.probes.origin + baked.probes.spacingMeters * vec3(x, y, z);
                probe.radiance[0] = vec3(0.7f + 0.1f * float(y), 0.8f, 0.7f + 0.05f * float(x));
                probe.radiance[1] = vec3(0.2f);
                probe.occlusion.layers[0] = vec4(float((x + y) % 3) / 2.0f, float(z % 2), 1.0f, 0.5f);
                baked.probes.probes.push_back(probe);
            }
        }
    }
    baked.scene = std::move(scene);
    return baked;
}

void addDynamicSpheres(Scene& scene, const Camera& camera, int count)
{
    const int material = addMaterial(scene, vec3(0.8f, 0.3f, 0.2f));
    const int mesh = addMesh(scene, sphereMesh(0.4f, 16, material));
    for (int i = 0; i < count; ++i) {
        const float across = 1.2f * (float(i) - 0.5f * float(count - 1));
        const vec4 place = camera.worldFromCamera * vec4(across, -0.6f, -4.0f - float(i % 3), 1.0f);
        addObject(scene, mesh, glm::translate(mat4(1.0f), vec3(place)), false);
    }
}

Camera cameraOf(const Scene& scene)
{
    if (!scene.cameras.empty()) return scene.cameras.front();
    const Bounds bounds = scene.bounds();
    const vec3 size = bounds.max - bounds.min;
    const bool alongX = size.x > size.z;
    const vec3 along = alongX ? vec3(1, 0, 0) : vec3(0, 0, 1);
    const vec3 target = bounds.center() + vec3(0, -0.3f * size.y, 0);
    Camera camera;
    camera.worldFromCamera = poseAt(target - along * (0.4f * (alongX ? size.x : size.z)), along);
    return camera;
}

void ensureSun(Scene& scene)
{
    if (std::any_of(scene.lights.begin(), scene.lights.end(),
                    [](const Light& light) { return light.type == LightType::Directional; }))
        return;
    scene.lights.push_back(makeLight(LightType::Directional, vec3(0), vec3(-0.3f, -1, -0.25f), 8.0f, 0.0f));
}

Scene thousandObjects()
{
    Scene scene;
    scene.sky = {vec3(0.4f, 0.5f, 0.8f), vec3(0.6f), vec3(0.2f)};
    std::vector<int> meshes;
    for (int i = 0; i < 6; ++i) {
        const int material = addMaterial(scene, vec3(0.3f + 0.1f * float(i), 0.5f, 0.8f - 0.1f * float(i)));
        meshes.push_back(addMesh(scene, boxMesh(vec3(0.3f, 0.3f + 0.15f * float(i), 0.3f), material)));
        meshes.push_back(addMesh(scene, sphereMesh(0.25f + 0.05f * float(i), 24, material)));
    }
    const int ground = addMesh(scene, boxMesh(vec3(40, 0.1f, 40), addMaterial(scene, vec3(0.5f))));
    addObject(scene, ground, glm::translate(mat4(1.0f), vec3(0, -0.1f, 0)), true);
    for (int i = 0; i < 999; ++i) {
        const auto random = [&](uint32_t salt) { return unitFloat(hashCombine(uint32_t(i), salt)); };
        const vec3 place(float(i % 32) * 2.0f - 31.0f + random(1), 0.5f, float(i / 32) * 2.0f - 31.0f + random(2));
        const mat4 transform = glm::rotate(glm::translate(mat4(1.0f), place), 6.0f * random(3), vec3(0, 1, 0));
        addObject(scene, meshes[std::size_t(i) % meshes.size()], transform, i % 20 != 7);
    }
    scene.lights.push_back(makeLight(LightType::Directional, vec3(0), vec3(-0.4f, -1, -0.3f), 6.0f, 0.0f));
    for (int i = 0; i < 4; ++i)
        scene.lights.push_back(
            makeLight(LightType::Spot, vec3(8 * i - 12, 6, 4), vec3(0.2f, -1, -0.1f), 120.0f, 14.0f));
    for (int i = 0; i < 2; ++i)
        scene.lights.push_back(makeLight(LightType::Point, vec3(16 * i - 8, 3, 12), vec3(0, -1, 0), 40.0f, 10.0f));
    Camera camera;
    camera.worldFromCamera = poseAt(vec3(0, 7, 34), vec3(0, -0.22f, -1));
    scene.cameras.push_back(camera);
    return scene;
}

Scene lightField(int n, float reach)
{
    Scene scene;
    const int ground =
        addMesh(scene, boxMesh(vec3(0.5f * kFieldMeters, 0.1f, 0.5f * kFieldMeters), addMaterial(scene, vec3(0.6f))));
    addObject(scene, ground, glm::translate(mat4(1.0f), vec3(0, -0.1f, 0)), true);
    const float pitch = kFieldMeters / float(n);
    for (int i = 0; i < n * n; ++i) {
        const vec2 place = (vec2(i % n, i / n) + 0.5f) * pitch - 0.5f * kFieldMeters;
        Light light = makeLight(LightType::Point, vec3(place.x, 0.25f * pitch, place.y), vec3(0, -1, 0), pitch * pitch,
                                reach * pitch);
        light.mode = LightMode::Realtime;
        light.castShadows = false;
        scene.lights.push_back(light);
    }
    Camera camera;
    camera.worldFromCamera = poseAt(vec3(0, 48, 0.01f), vec3(0, -1, 0));
    camera.verticalFovRadians = 1.0f;
    scene.cameras.push_back(camera);
    return scene;
}

Scene overlappingLamps(int count)
{
    Scene scene = lightField(1, 2.0f);
    const Light lamp = scene.lights[0];
    scene.lights.clear();
    for (int i = 0; i < count; ++i) {
        const float angle = float(i) * 2.0f * kPi / float(count);
        Light& light = scene.lights.emplace_back(lamp);
        light.worldFromLight[3] += vec4(8.0f * std::cos(angle), 0.0f, 8.0f * std::sin(angle), 0.0f);
        light.intensity /= float(count);
        light.mode = LightMode::Mixed;
        light.castShadows = true;
    }
    return scene;
}

double lightsPerPoint(const Scene& scene)
{
    constexpr int kSteps = 200;
    double count = 0.0;
    for (int y = 0; y < kSteps; ++y) {
        for (int x = 0; x < kSteps; ++x) {
            const vec2 t = (vec2(x, y) + 0.5f) / float(kSteps) - 0.5f;
            const vec3 p(t.x * kFieldMeters, 0.0f, t.y * kFieldMeters);
            for (const Light& light : scene.lights) count += glm::distance(light.position(), p) < light.rangeMeters;
        }
    }
    return count / (kSteps * kSteps);
}

} // namespace halflight::bench
