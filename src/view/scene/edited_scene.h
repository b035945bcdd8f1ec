#pragma once
// The scene as the user has changed it.

#include "halflight/view/view.h"
#include "view/state/notices.h"
#include "view/state/requests.h"
#include "view/state/shown.h"

#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace halflight::view {

/// What the next bake bakes: the file's scene with the user's changes to lights and objects. Its indices are those of
/// the scene that is shown.
class EditedScene {
public:
    using Clock = std::chrono::steady_clock;

    /// A file's, before any change.
    void beginFile(const Scene& scene);
    /// Another scene of the same objects is shown, which was made at `since`: its light groups, at the weights that the
    /// user gave them since.
    void showGroups(const BakedScene& shown, Clock::time_point since);
    /// Makes a change here and in what the renderer draws.
    void change(const SceneChange& change, Renderer& renderer, Notices& notices);

    /// Makes those changes once more that were made since `since`, in what the renderer draws: a scene that was made
    /// then. Whether there are some.
    bool repeat(Clock::time_point since, Renderer& renderer) const;

    [[nodiscard]] const Scene& scene() const { return scene_; }
    /// Lights, objects, materials and sky of the file, without vertices and pixels.
    [[nodiscard]] const Scene& atLoad() const { return atLoad_; }
    /// The same with the light of the groups' weights now: what was changed besides is what differs from it.
    [[nodiscard]] Scene atLoadWithWeights() const;
    /// Of the scene that is shown; a light that turns is one.
    [[nodiscard]] const std::vector<GroupReport>& groups() const { return groups_; }
    [[nodiscard]] const std::vector<Bounds>& bounds() const { return bounds_; } ///< of each object
    [[nodiscard]] Bounds boundsOf(int object) const;                            ///< of all for -1
    [[nodiscard]] Clock::time_point lastChange() const { return lastChange_; }
    /// Writes a settings file: `before`, the one in use, and the changes after it, which win; beside it, or here, named
    /// as the scene's file. A file that another session wrote stays. What was done, for people.
    std::string writeSettings(const ViewText& changes, const std::filesystem::path& before,
                              const std::filesystem::path& sceneFile);
    /// A copy, the same one until the next change.
    std::shared_ptr<const Scene> snapshot();

private:
    void make(const ChangeLight& change, Renderer& renderer, Notices& notices);
    void make(const ChangeSwitches& change, Renderer& renderer, Notices& notices);
    void make(const MoveObject& change, Renderer& renderer, Notices& notices);
    void make(const ChangeGroup& change, Renderer& renderer, Notices& notices);
    void reportWeights();
    Status writeChanges(const std::string& changes, const std::filesystem::path& before,
                        const std::filesystem::path& stem);

    Scene scene_;
    std::vector<Bounds> bounds_;
    Scene atLoad_;
    std::map<int, Clock::time_point> changedLights_; ///< when they changed last
    std::map<int, Clock::time_point> changedObjects_;
    struct Weight {
        vec3 weight{1.0f};
        Clock::time_point time;
    };
    std::map<std::string, Weight> changedGroups_;
    BakedScene shown_;          ///< groups of the scene that is shown, without light, and lights as they are in scene_
    std::vector<vec3> weights_; ///< of these groups
    Scene shownLight_;          ///< its lights, materials and sky, at the groups' saved weights
    std::vector<GroupReport> groups_;
    std::filesystem::path settingsFile_; ///< that writeSettings() wrote; empty: none yet
    Clock::time_point lastChange_;
    std::shared_ptr<const Scene> snapshot_; ///< null where scene_ has changed since
};

} // namespace halflight::view
