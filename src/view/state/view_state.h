#pragma once
// What a user changes in the window (ViewState) and sees there (Readings). The viewer reads both each frame.

#include "halflight/bake/bake_session.h"
#include "halflight/render/renderer.h"
#include "view/state/navigation.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace halflight::view {

/// What panels and keys ask the viewer to do after the frame.
struct Requests {
    bool quit = false;
    bool screenshot = false;
    bool expose = false; ///< automatic exposure of this view
    bool frameSelection = false;
    bool reload = false;
    bool copyCommand = false;
    bool bake = false;
    bool cancelBake = false;
    bool save = false; ///< if a bake has finished
    bool writeSettings = false;
    bool toggleFullScreen = false;
    std::optional<int> camera; ///< of the file's cameras
    std::optional<std::pair<int, Light>> light;
    struct ObjectSwitches {
        int object = -1;
        bool isStatic = true; ///< in the next bake
        bool castShadows = true;
        bool receiveShadows = true;
    };
    std::optional<ObjectSwitches> switches;
    std::optional<std::pair<int, mat4>> move;
    std::optional<std::size_t> warning; ///< shows what it names
};

/// What is right of the line.
enum class Compare { Mode, BeforeBake, Reference };

/// A bake in the background, as the panel shows it.
struct BakeStatus {
    bool running = false;
    bool cancelled = false;  ///< it was asked to end, and what was shown before it comes back
    bool firstLight = false; ///< the coarse light is shown
    std::size_t tiles = 0;   ///< rectangles of pages that were shown since
    BakeSessionState session;
    std::string outcome;    ///< of the last bake: how long it took, or why it failed
    bool hasResult = false; ///< a finished bake is shown and can be saved
    bool outOfDate = false; ///< lights or objects changed since
};

struct Statistics {
    std::size_t objects = 0;
    std::size_t triangles = 0; ///< of all objects, instances counted
    std::size_t lightmapPages = 0;
    ivec2 pageSize{0};
    double lightmapMegabytes = 0.0; ///< on the device: lightmaps, directions, masks
    std::size_t probes = 0;
    std::size_t reflectionProbes = 0;
};

/// Frames whose times panels show.
constexpr std::size_t kShownFrames = 120;

/// Adds what belongs to a frame; the oldest beyond kShownFrames goes.
template<typename T> void addFrame(std::vector<T>& frames, T added)
{
    if (frames.size() == kShownFrames) frames.erase(frames.begin());
    frames.push_back(std::move(added));
}

/// What the window shows of its parts' work. They write it, panels only read it.
struct Readings {
    bool isBaked = false;          ///< the scene that is shown
    std::vector<int> maskChannels; ///< of its lights; -1 none
    std::vector<RunMode> modes;    ///< those that the file has data for
    bool hasEarlier = false;       ///< light before the last bake is kept
    int referenceSamples = 0;      ///< per pixel, of the picture that is shown
    std::vector<PassReport> passes;
    bool timed = false;
    std::vector<float> frameMilliseconds;                ///< of the last frames, oldest first
    std::vector<std::vector<PassReport>> passesOfFrames; ///< of those that were timed, oldest first
    std::vector<std::string> warnings;                   ///< of the file, the bake and the frame
    Statistics statistics;
    BakeStatus bakeStatus;
    std::string device;
    std::string title;                 ///< file name
    float shadowDistanceMeters = 0.0f; ///< of the last frame
};

/// What the user chose.
struct ViewState {
    RenderSettings settings;           ///< its size is set for each frame
    bool followsShadowDistance = true; ///< shadows reach all that is in view
    float exposureEv = 0.0f;
    ToneMapping toneMapping = ToneMapping::Neutral;
    bool panels = true;
    bool vsync = true;
    bool compares = false; ///< right of `split`
    Compare compareWith = Compare::Mode;
    RunMode otherMode = RunMode::Realtime;
    float split = 0.5f; ///< share of the width
    float speed = 2.0f; ///< of flying, m/s
    int selectedLight = -1;
    int selectedObject = -1;
    BakeSettings bake;
    std::string bakeOutput; ///< the file that Save writes
    Navigator navigator;
    Requests requests;

    bool showsSelected = false; ///< an object was clicked: its section opens
};

/// The object or light that a text names first, as whole words; of names at one place the longest.
struct Subject {
    int object = -1;
    int light = -1;
};
Subject subjectOf(const std::string& text, const Scene& scene);
/// One sentence on what the view's colours mean.
const char* legendOf(DebugView view);

/// The state's settings for a picture of this size. `bounds`: of the scene's objects.
RenderSettings settingsOfFrame(const ViewState& state, const std::vector<Bounds>& bounds, ivec2 size);

} // namespace halflight::view
