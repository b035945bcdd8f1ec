#include "render/scene/draw_list.h"

#include "render/frame/frame_internal.h"

#include <algorithm>
#include <tuple>

namespace halflight {

template<typename Filter> std::vector<Draw> DrawLists::drawsOf(std::span<const uint32_t> objects, const Filter& isDrawn)
{
    std::vector<uint32_t> sorted;
    for (const uint32_t object : objects)
        if (scene_.outline.scene.objects[object].mesh >= 0) sorted.push_back(object);
    auto key = [&](uint32_t object) {
        return std::tuple(scene_.outline.scene.objects[object].mesh, bool(scene_.mirrored[object]));
    };
    std::stable_sort(sorted.begin(), sorted.end(), [&](uint32_t a, uint32_t b) { return key(a) < key(b); });

    std::vector<Draw> draws;
    for (std::size_t begin = 0; begin < sorted.size();) {
        std::size_t end = begin + 1;
        while (end < sorted.size() && key(sorted[end]) == key(sorted[begin])) ++end;
        const auto [mesh, mirrored] = key(sorted[begin]);
        const auto firstInstance = uint32_t(instances_.size());
        bool used = false;
        for (const DrawPart& part : scene_.meshes[std::size_t(mesh)]) {
            if (!isDrawn(part)) continue;
            draws.push_back({&part, mirrored, firstInstance, uint32_t(end - begin)});
            used = true;
        }
        if (used)
            instances_.insert(instances_.end(), sorted.begin() + std::ptrdiff_t(begin),
                              sorted.begin() + std::ptrdiff_t(end));
        begin = end;
    }
    return draws;
}

std::vector<Draw> DrawLists::solid(std::span<const uint32_t> objects)
{
    return drawsOf(objects, [](const DrawPart& part) { return part.alphaMode != Material::AlphaMode::Blend; });
}

std::vector<Draw> DrawLists::volumes(std::span<const uint32_t> objects)
{
    return drawsOf(objects, [](const DrawPart& part) { return part.closedVolume; });
}

std::vector<Draw> DrawLists::casters(std::span<const uint32_t> objects)
{
    return drawsOf(objects, [](const DrawPart& part) { return part.castShadows; });
}

std::vector<Draw> DrawLists::blended(std::span<const uint32_t> objects, vec3 eye)
{
    struct Entry {
        Draw draw;
        float distance;
    };
    std::vector<Entry> entries;
    for (const uint32_t object : objects) {
        const Object& placed = scene_.outline.scene.objects[object];
        if (placed.mesh < 0) continue;
        for (const DrawPart& part : scene_.meshes[std::size_t(placed.mesh)]) {
            if (part.alphaMode != Material::AlphaMode::Blend) continue;
            const vec3 center(placed.worldFromObject * vec4(part.center, 1.0f));
            entries.push_back(
                {{&part, scene_.mirrored[object], uint32_t(instances_.size()), 1}, glm::distance(center, eye)});
            instances_.push_back(object);
        }
    }
    std::stable_sort(entries.begin(), entries.end(),
                     [](const Entry& a, const Entry& b) { return a.distance > b.distance; });
    std::vector<Draw> draws;
    for (const Entry& entry : entries) draws.push_back(entry.draw);
    return draws;
}

std::vector<uint32_t> objectsInView(std::span<const Bounds> bounds, const mat4& clipFromWorld)
{
    const Planes planes = planesOf(clipFromWorld);
    std::vector<uint32_t> objects;
    for (std::size_t i = 0; i < bounds.size(); ++i)
        if (meets(planes, bounds[i])) objects.push_back(uint32_t(i));
    return objects;
}

} // namespace halflight
