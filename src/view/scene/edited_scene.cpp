#include "view/scene/edited_scene.h"

#include "halflight/base/file.h"
#include "halflight/render/frame.h"
#include "view/state/changes.h"

#include <spdlog/fmt/fmt.h>

#include <utility>

namespace halflight::view {

void EditedScene::beginFile(const Scene& scene)
{
    scene_ = scene;
    bounds_ = objectBounds(scene);
    atLoad_ = {};
    atLoad_.lights = scene.lights;
    atLoad_.objects = scene.objects;
    changedLights_.clear();
    changedObjects_.clear();
    settingsFile_.clear();
    snapshot_.reset();
}

bool EditedScene::change(Requests& requests, Renderer& renderer, Notices& notices)
{
    const auto light = std::exchange(requests.light, std::nullopt);
    const auto switches = std::exchange(requests.switches, std::nullopt);
    const auto moved = std::exchange(requests.move, std::nullopt);
    if (!light && !switches && !moved) return false;
    lastChange_ = Clock::now();
    if (light) {
        const auto& [index, changed] = *light;
        scene_.lights[std::size_t(index)] = changed;
        changedLights_[index] = lastChange_;
        if (Status status = renderer.setLight(index, changed); !status)
            notices.addWarning(Notices::About::Frame, status.error().text());
    }
    if (switches) {
        Object& object = scene_.objects[std::size_t(switches->object)];
        object.isStatic = switches->isStatic;
        object.castShadows = switches->castShadows;
        object.receiveShadows = switches->receiveShadows;
        changedObjects_[switches->object] = lastChange_;
        (void)renderer.setObjectShadows(switches->object, object.castShadows, object.receiveShadows);
    }
    if (moved) {
        const auto& [index, place] = *moved;
        if (renderer.setObjectTransform(index, place)) {
            move(std::size_t(index), place);
            changedObjects_[index] = lastChange_;
        }
    }
    snapshot_.reset();
    return true;
}

bool EditedScene::repeat(Clock::time_point since, Renderer& renderer) const
{
    bool some = false;
    for (const auto& [index, time] : changedLights_) {
        if (time < since) continue;
        (void)renderer.setLight(index, scene_.lights[std::size_t(index)]); // what is wrong with it was said before
        some = true;
    }
    for (const auto& [index, time] : changedObjects_) {
        if (time < since) continue;
        const Object& object = scene_.objects[std::size_t(index)];
        (void)renderer.setObjectShadows(index, object.castShadows, object.receiveShadows);
        (void)renderer.setObjectTransform(index, object.worldFromObject); // not of static ones, which do not move
        some = true;
    }
    return some;
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

/// Relative paths in `before` stay right beside it.
Status EditedScene::writeChanges(const std::string& changes, const std::filesystem::path& before,
                                 const std::filesystem::path& stem)
{
    std::string text = changes;
    if (!before.empty()) {
        const auto rules = readFile(before);
        if (!rules) return rules.error();
        text = std::string(reinterpret_cast<const char*>(rules->data()), rules->size()) + "\n" + changes;
    }
    for (int i = 1; settingsFile_.empty(); ++i) {
        const std::filesystem::path file = stem.string() + (i == 1 ? "" : fmt::format("_{}", i)) + ".toml";
        if (!std::filesystem::exists(file)) settingsFile_ = file;
    }
    return writeFileAtomically(settingsFile_, text);
}

std::string EditedScene::writeSettings(const std::filesystem::path& before, const std::filesystem::path& sceneFile)
{
    const std::string changes = settingsFile(scene_, atLoad_);
    const std::string leftOut = leftOutOfSettings(scene_, atLoad_);
    std::string outcome = "nothing was changed";
    if (!changes.empty()) {
        const std::filesystem::path stem = before.empty() ? sceneFile.stem() : before.parent_path() / before.stem();
        const Status written = writeChanges(changes, before, stem);
        outcome = written ? "wrote " + settingsFile_.string() : written.error().text();
    }
    if (!leftOut.empty()) outcome += "; settings files cannot hold " + leftOut;
    return outcome;
}

std::shared_ptr<const Scene> EditedScene::snapshot()
{
    if (!snapshot_) snapshot_ = std::make_shared<const Scene>(scene_);
    return snapshot_;
}

} // namespace halflight::view
