#pragma once
// What the panels show. Each part of the window keeps its own report; nothing else writes it.

#include "halflight/bake/bake_session.h"
#include "halflight/render/renderer.h"
#include "view/state/view_state.h"

#include <string>
#include <utility>
#include <vector>

namespace halflight::view {

/// Of the scene that is drawn.
struct SceneReport {
    bool isBaked = false;
    std::vector<int> maskChannels; ///< of its lights; -1 none
    std::vector<RunMode> modes;    ///< those that the file has data for
    std::size_t objects = 0;
    std::size_t triangles = 0; ///< of all objects, instances counted
    std::size_t lightmapPages = 0;
    ivec2 pageSize{0};
    double lightmapMegabytes = 0.0; ///< on the device: lightmaps, directions, masks
    std::size_t probes = 0;
    std::size_t reflectionProbes = 0;
};

/// Of a light group of the scene that is drawn.
struct GroupReport {
    std::string name;
    vec3 weight{1.0f};
    vec3 saved{1.0f}; ///< weight of the file
    vec3 color{1.0f}; ///< of the last weight that was not 0: its largest channel is 1
};

/// Of a bake in the background.
struct BakeStatus {
    bool running = false;
    bool cancelled = false;  ///< it was asked to end, and what was shown before it comes back
    bool firstLight = false; ///< the coarse light is shown
    BakeSessionState session;
    std::string outcome;    ///< of the last bake: how long it took, or why it failed
    bool hasResult = false; ///< a finished bake is shown and can be saved
    bool outOfDate = false; ///< lights or objects changed since
};

/// Frames whose times panels show.
constexpr std::size_t kShownFrames = 120;

/// Adds what belongs to a frame; the oldest beyond kShownFrames goes.
template<typename T> void addFrame(std::vector<T>& frames, T added)
{
    if (frames.size() == kShownFrames) frames.erase(frames.begin());
    frames.push_back(std::move(added));
}

/// Of the last picture.
struct PictureReport {
    std::vector<PassReport> passes;
    bool timed = false;
    std::vector<std::vector<PassReport>> passesOfFrames; ///< of those that were timed, oldest first
    float shadowDistanceMeters = 0.0f;
};

/// Of what is right of the window's line.
struct CompareReport {
    bool hasEarlier = false;  ///< light before the last bake is kept
    int referenceSamples = 0; ///< per pixel, of the picture that is shown
};

struct WindowReport {
    std::string device;
    std::string title;                    ///< file name
    std::vector<float> frameMilliseconds; ///< of the last frames, oldest first
    std::vector<std::string> warnings;    ///< of the file, the bake and the frame
};

struct Shown {
    const ViewState& choices;
    const Scene& scene; ///< as the user has changed it
    const SceneReport& report;
    const BakeStatus& bake;
    const PictureReport& picture;
    const CompareReport& comparison;
    const WindowReport& window;
    const std::vector<GroupReport>& groups;
};

} // namespace halflight::view
