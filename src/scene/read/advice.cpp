#include "scene/read/advice.h"

#include "halflight/base/text.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace halflight {

namespace {

/// World-space size of each object.
std::vector<vec3> objectSizes(const Scene& scene)
{
    std::vector<Bounds> ofMesh;
    for (const Mesh& mesh : scene.meshes) {
        Bounds bounds;
        for (const MeshPart& part : mesh.parts) {
            for (const vec3& p : part.positions) bounds.extend(p);
        }
        ofMesh.push_back(bounds);
    }
    std::vector<vec3> sizes;
    for (const Object& object : scene.objects) {
        const mat3 m(object.worldFromObject);
        const Bounds& bounds = ofMesh[std::size_t(object.mesh)];
        const vec3 size = bounds.max - bounds.min;
        sizes.push_back(glm::abs(m[0]) * size.x + glm::abs(m[1]) * size.y + glm::abs(m[2]) * size.z);
    }
    return sizes;
}

std::string meters(float length)
{
    return std::to_string(int(std::lround(length))) + " m";
}

// A room of 5 x 3 x 4 metres and its furniture (0.2 to 2 m), a hundred times as large: tall for its width, as
// landscapes and towns are not, and without the small things (doors, lamps, railings) that large buildings in metres
// have.
std::string adviceOnScale(const Scene& scene)
{
    constexpr float kWide = 150.0f;    // of a room of 1.5 m
    constexpr float kWidest = 5000.0f; // of a hall of 50 m
    constexpr float kTall = 0.15f;     // height by width: a hall of 20 m under a ceiling of 3 m
    constexpr float kSmall = 15.0f;    // a quarter of all objects is smaller than this in a building in metres
    if (scene.objects.size() < 3) return {};
    const Bounds bounds = scene.bounds();
    const vec3 size = bounds.max - bounds.min;
    const float width = std::max(size.x, size.z);
    if (!(width >= kWide && width <= kWidest && size.y >= kTall * width)) return {};
    std::vector<float> lengths;
    for (const vec3& s : objectSizes(scene)) lengths.push_back(std::max({s.x, s.y, s.z}));
    const auto quarter = lengths.begin() + std::ptrdiff_t(lengths.size() / 4);
    std::nth_element(lengths.begin(), quarter, lengths.end());
    if (*quarter < kSmall) return {};
    return "the scene is " + meters(width) + " wide and " + meters(size.y) +
           " high, and three quarters of its objects are longer than " + meters(*quarter) +
           ": if it is a room in centimetres, give its root a scale of 0.01 (glTF is in metres), as light " +
           "falls off with metres";
}

} // namespace

std::vector<std::string> adviceFor(const Scene& scene, const Json& document, bool skyAuthored)
{
    std::vector<std::string> advice;
    const bool isBlenders = stringOf(member(document, "asset"), "generator").find("Blender") != std::string::npos;
    if (isBlenders && scene.lights.empty() && !skyAuthored) {
        advice.emplace_back(
            "Blender wrote this file without lights: in its glTF export, under Include > Data, tick Punctual "
            "Lights (for the lamps) and Custom Properties (for halflight_ settings); a world background is "
            "not exported, halflight_sky on the scene stands for it");
    }
    if (std::string scale = adviceOnScale(scene); !scale.empty()) advice.push_back(std::move(scale));
    return advice;
}

void warnAnimatedMaterials(const AnimatedThings& animated, Scene& scene)
{
    std::set<int> ofStatic;
    for (const Object& object : scene.objects) {
        if (!object.isStatic) continue;
        for (const MeshPart& part : scene.meshes[std::size_t(object.mesh)].parts)
            ofStatic.insert(sourceMaterialOf(scene, part));
    }
    std::vector<std::string> names;
    for (const auto& [index, members] : animated.materials) {
        if (index < 0 || std::size_t(index) >= scene.materials.size() || ofStatic.count(index) == 0) continue;
        const std::string& name = scene.materials[std::size_t(index)].name;
        names.push_back(name.empty() ? "material " + std::to_string(index) : name);
    }
    if (!names.empty()) {
        scene.warnings.push_back("animated materials of static objects: " + listOf(names) +
                                 "; the bake has the light they give and reflect at rest");
    }
}

} // namespace halflight
