#include "view/scene/edited_scene.h"

#include "halflight/base/file.h"
#include "halflight/render/frame.h"

#include <spdlog/fmt/fmt.h>

#include <variant>

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

void EditedScene::change(const SceneChange& change, Renderer& renderer, Notices& notices)
{
    lastChange_ = Clock::now();
    std::visit([&](const auto& made) { make(made, renderer, notices); }, change);
    snapshot_.reset();
}

void EditedScene::make(const ChangeLight& change, Renderer& renderer, Notices& notices)
{
    scene_.lights[std::size_t(change.light)] = change.value;
    changedLights_[change.light] = lastChange_;
    if (Status status = renderer.setLight(change.light, change.value); !status)
        notices.addWarning(Notices::About::Frame, status.error().text());
}

void EditedScene::make(const ChangeSwitches& change, Renderer& renderer, Notices& /*notices*/)
{
    Object& object = scene_.objects[std::size_t(change.object)];
    object.isStatic = change.isStatic;
    object.castShadows = change.castShadows;
    object.receiveShadows = change.receiveShadows;
    changedObjects_[change.object] = lastChange_;
    (void)renderer.setObjectShadows(change.object, object.castShadows, object.receiveShadows);
}

void EditedScene::make(const MoveObject& change, Renderer& renderer, Notices& /*notices*/)
{
    if (!renderer.setObjectTransform(change.object, change.worldFromObject)) return;
    const auto index = std::size_t(change.object);
    Object& object = scene_.objects[index];
    object.worldFromObject = change.worldFromObject;
    changedObjects_[change.object] = lastChange_;
    if (object.mesh < 0) return;
    bounds_[index] = {};
    for (const MeshPart& part : scene_.meshes[std::size_t(object.mesh)].parts)
        for (const vec3& position : part.positions)
            bounds_[index].extend(vec3(change.worldFromObject * vec4(position, 1.0f)));
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

std::string EditedScene::writeSettings(const ViewText& changes, const std::filesystem::path& before,
                                       const std::filesystem::path& sceneFile)
{
    std::string outcome = "nothing was changed";
    if (!changes.text.empty()) {
        const std::filesystem::path stem = before.empty() ? sceneFile.stem() : before.parent_path() / before.stem();
        const Status written = writeChanges(changes.text, before, stem);
        outcome = written ? "wrote " + settingsFile_.string() : written.error().text();
    }
    if (!changes.leftOut.empty()) outcome += "; settings files cannot hold " + changes.leftOut;
    return outcome;
}

std::shared_ptr<const Scene> EditedScene::snapshot()
{
    if (!snapshot_) snapshot_ = std::make_shared<const Scene>(scene_);
    return snapshot_;
}

} // namespace halflight::view
