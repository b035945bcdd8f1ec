#pragma once
// The window: a scene to walk through, with panels for what can be changed, and bakes in the background.

#include "halflight/bake/bake.h"
#include "halflight/base/progress.h"
#include "halflight/base/result.h"
#include "halflight/render/renderer.h"

#include <atomic>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace halflight {

/// Reads a file that a user names, on a thread of its own, and chooses the view that its picture begins with.
struct ViewLoader {
    /// `cancel`: reading ends soon after it is set.
    std::function<Result<BakedScene>(const std::filesystem::path& file, const std::atomic<bool>& cancel)> read;
    /// `isFirst`: of ViewOptions::file, not of one that was dropped on the window.
    std::function<Result<Camera>(const Scene& scene, float aspect, bool isFirst)> camera;
};

/// The picture in the window, and what was changed of its scene.
struct ViewedPicture {
    std::string file;
    std::string settingsFile; ///< empty without
    Camera camera;
    vec3 ahead{0.0f}; ///< a metre before the camera
    RenderSettings render;
    float exposureEv = 0.0f;
    ToneMapping toneMapping = ToneMapping::Neutral;
    bool shadowDistanceGiven = false;
    std::vector<GroupWeight> groups; ///< light groups whose weight is not the file's
    const Scene& scene;              ///< as it is now
    const Scene& atLoad;             ///< as the files have it, with the weights of `groups`
};

struct ViewText {
    std::string text;
    std::string leftOut; ///< what it cannot say, for people; empty where it says all
};

struct ViewOptions {
    std::filesystem::path file;
    ViewLoader loader;
    std::filesystem::path settingsFile; ///< that the loader applies; empty without
    /// Lights of the first file that are changed at once, as in the panels, with their indices.
    std::function<Result<std::vector<std::pair<int, Light>>>(const Scene& scene)> changeLights;
    RendererOptions device;          ///< extensions of the window system are added
    RenderSettings render;           ///< its size is the window's at first, in pixels
    std::optional<RunMode> mode;     ///< empty: as baked
    std::optional<float> exposureEv; ///< empty: automaticExposure() of the first view
    ToneMapping toneMapping = ToneMapping::Neutral;
    bool shadowDistanceGiven = false; ///< else it follows from the view, as in `halflight render`
    BakeSettings bake;                ///< of the Bake button
    ChooseIntegrators integrators;    ///< of its bakes
    bool bakeAtStart = false;
    std::filesystem::path screenshots;         ///< folder of screenshots
    std::vector<int> loseDeviceAt;             ///< for tests: after so many frames the device counts as lost
    int frames = 0;                            ///< ends after so many, 0 = when the window is closed
    const std::atomic<bool>* cancel = nullptr; ///< ends when set
    /// The command line that renders the picture, for screenshots and the clipboard.
    std::function<ViewText(const ViewedPicture& picture)> commandLine;
    /// Changes of lights and objects as a settings file, those by light groups' weights among them; empty where there
    /// are none. `atLoad` has lights, objects, materials and sky.
    std::function<ViewText(const Scene& scene, const Scene& atLoad)> settingsText;
    /// A line for people, e.g. a screenshot's command line.
    std::function<void(const std::string& line)> say;
};

/// Opens a window and returns when it is closed. DeviceFailed without a display, without Vulkan, and when the
/// validation layer was on and had something to say.
Status viewScene(const ViewOptions& options);

} // namespace halflight
