#include "view/scene/edited_scene.h"

#include "halflight/base/file.h"
#include "halflight/render/compose.h"
#include "halflight/render/frame.h"
#include "halflight/scene/turning_lights.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <variant>

namespace halflight::view {

namespace {

void copyLight(const Scene& from, Scene& to)
{
    to.lights = from.lights;
    to.materials = from.materials;
    to.sky = from.sky;
}

} // namespace

void EditedScene::beginFile(const Scene& scene)
{
    scene_ = scene;
    bounds_ = objectBounds(scene);
    atLoad_ = {};
    copyLight(scene, atLoad_);
    atLoad_.objects = scene.objects;
    changedLights_.clear();
    changedObjects_.clear();
    changedGroups_.clear();
    shown_ = {};
    weights_.clear();
    groups_.clear();
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
    shown_.scene.lights = scene_.lights;
    if (weights_.empty()) return;
    if (turns(change.value)) {
        followTurningLights(scene_.lights, weights_);
        composeMembers(shownLight_, shown_.groups, weights_, scene_);
        reportWeights();
        return;
    }
    const auto group = std::size_t(change.value.baking.group);
    if (change.value.baking.group < 0 || group >= weights_.size()) return;
    const auto weight = weightOfLights(scene_, change.value.baking.group, weights_[group]);
    if (weight && *weight != weights_[group]) make(ChangeGroup{shown_.groups[group].name, *weight}, renderer, notices);
}

void EditedScene::showGroups(const BakedScene& shown, Clock::time_point since)
{
    copyLight(shown.scene, shownLight_);
    // Members are those of its bake.
    for (std::size_t i = 0; i < scene_.lights.size(); ++i) scene_.lights[i].baking = shown.scene.lights[i].baking;
    for (std::size_t i = 0; i < scene_.materials.size(); ++i) {
        scene_.materials[i].bakedGroup = shown.scene.materials[i].bakedGroup;
        scene_.materials[i].whiteNits = shown.scene.materials[i].whiteNits;
    }
    snapshot_.reset();
    shown_.groups.clear();
    for (const BakedGroup& group : shown.groups) {
        BakedGroup& own = shown_.groups.emplace_back();
        own.name = group.name;
        own.weight = group.weight;
        own.sky = group.sky;
    }
    shown_.scene.lights = shownLight_.lights;
    weights_ = savedWeights(shown_);
    groups_.clear();
    for (const GroupWeight& saved : settableWeights(shown_, weights_))
        groups_.push_back({saved.name, saved.weight, saved.weight, vec3(1.0f)});
    reportWeights();
    shown_.scene.lights = scene_.lights;
    for (const auto& [name, changed] : changedGroups_)
        if (changed.time >= since) // unless the scene has no such group
            (void)changeGroupWeight(shown_, {name, changed.weight}, weights_);
    if (!weights_.empty()) followTurningLights(scene_.lights, weights_);
    reportWeights();
}

/// To the rows of panels.
void EditedScene::reportWeights()
{
    const std::vector<GroupWeight> now = settableWeights(shown_, weights_);
    for (std::size_t i = 0; i < now.size(); ++i) {
        GroupReport& report = groups_[i];
        const vec3 weight = now[i].weight;
        const float most = std::max({weight.x, weight.y, weight.z});
        // A light that was turned has its weight but for rounding.
        const bool same = glm::distance(weight, report.saved) <= 1.0e-4f * std::max(most, glm::length(report.saved));
        report.weight = same ? report.saved : weight;
        if (most > 0.0f) report.color = weight / most;
    }
}

void EditedScene::make(const ChangeGroup& change, Renderer& renderer, Notices& notices)
{
    const auto group = std::find_if(groups_.begin(), groups_.end(),
                                    [&](const GroupReport& report) { return report.name == change.name; });
    if (group == groups_.end()) return;
    if (Status status = renderer.setLightGroup(change.name, change.weight); !status) {
        notices.addWarning(Notices::About::Frame, status.error().text());
        return;
    }
    changedGroups_[change.name] = {change.weight, lastChange_};
    (void)changeGroupWeight(shown_, {change.name, change.weight}, weights_); // which the renderer has taken
    composeMembers(shownLight_, shown_.groups, weights_, scene_);
    shown_.scene.lights = scene_.lights;
    reportWeights();
    Sky gradient = shownLight_.sky;
    gradient.picture.reset(); // snapshot() multiplies it
    gradient = composedSky(gradient, shown_.groups, weights_);
    gradient.picture = shownLight_.sky.picture;
    scene_.sky = gradient;
}

Scene EditedScene::atLoadWithWeights() const
{
    Scene scene = atLoad_;
    if (weights_.empty()) return scene;
    // Weights of a light that turns are of the direction that it has now.
    for (std::size_t i = 0; i < scene.lights.size(); ++i)
        scene.lights[i].worldFromLight = scene_.lights[i].worldFromLight;
    composeMembers(atLoad_, shown_.groups, weights_, scene);
    for (std::size_t i = 0; i < scene.lights.size(); ++i)
        scene.lights[i].worldFromLight = atLoad_.lights[i].worldFromLight;
    return scene;
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
    for (const auto& [name, changed] : changedGroups_) {
        if (changed.time < since) continue;
        (void)renderer.setLightGroup(name, changed.weight); // unless the scene has no such group
        some = true;
    }
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
    if (snapshot_) return snapshot_;
    auto scene = std::make_shared<Scene>(scene_);
    // Of a sky with a picture all texels change: here, and not for each move of a slider.
    if (scene->sky.picture) scene->sky = composedSky(shownLight_.sky, shown_.groups, weights_);
    snapshot_ = std::move(scene);
    return snapshot_;
}

} // namespace halflight::view
