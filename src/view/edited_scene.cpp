#include "view/edited_scene.h"

#include "halflight/render/frame.h"

#include <utility>

namespace halflight::view {

void EditedScene::beginFile(const Scene& scene)
{
    scene_ = scene;
    bounds_ = objectBounds(scene);
    atLoad_ = {};
    atLoad_.lights = scene.lights;
    atLoad_.objects = scene.objects;
    snapshot_.reset();
}

bool EditedScene::change(Requests& requests, Renderer& renderer, Notices& notices)
{
    const auto light = std::exchange(requests.light, std::nullopt);
    const auto switches = std::exchange(requests.switches, std::nullopt);
    const auto moved = std::exchange(requests.move, std::nullopt);
    if (!light && !switches && !moved) return false;
    if (light) {
        const auto& [index, changed] = *light;
        scene_.lights[std::size_t(index)] = changed;
        if (Status status = renderer.setLight(index, changed); !status)
            notices.addWarning(Notices::About::Frame, status.error().text());
    }
    if (switches) {
        Object& object = scene_.objects[std::size_t(switches->object)];
        object.castShadows = switches->castShadows;
        object.receiveShadows = switches->receiveShadows;
        (void)renderer.setObjectShadows(switches->object, object.castShadows, object.receiveShadows);
    }
    if (moved) {
        const auto& [index, place] = *moved;
        if (renderer.setObjectTransform(index, place)) move(std::size_t(index), place);
    }
    snapshot_.reset();
    lastChange_ = Clock::now();
    return true;
}

void EditedScene::move(std::size_t index, const mat4& place)
{
    Object& object = scene_.objects[index];
    object.worldFromObject = place;
    if (object.mesh < 0) return;
    bounds_[index] = {};
    for (const MeshPart& part : scene_.meshes[std::size_t(object.mesh)].parts)
        for (const vec3& position : part.positions) bounds_[index].extend(vec3(place * vec4(position, 1.0f)));
}

Bounds EditedScene::boundsOf(int object) const
{
    Bounds all;
    for (std::size_t i = 0; i < bounds_.size(); ++i) {
        if (bounds_[i].empty() || (object >= 0 && std::size_t(object) != i)) continue;
        all.extend(bounds_[i].min);
        all.extend(bounds_[i].max);
    }
    return all;
}

std::shared_ptr<const Scene> EditedScene::snapshot()
{
    if (!snapshot_) snapshot_ = std::make_shared<const Scene>(scene_);
    return snapshot_;
}

} // namespace halflight::view
