#pragma once
// Options of `halflight render`.

#include "camera.h"
#include "console.h"
#include "group_option.h"
#include "light_override.h"

#include "halflight/bake/integrator.h"
#include "halflight/render/renderer.h"

#include <filesystem>
#include <optional>
#include <vector>

namespace halflight::cli {

struct RenderOptions {
    std::filesystem::path file;
    std::filesystem::path output;
    std::filesystem::path settingsFile;
    std::optional<EmissionUnit> emissionUnit;
    std::optional<RunMode> mode; ///< empty = auto
    RenderSettings render;
    int samples = 0; ///< of a pixel: 0 = not given
    RendererOptions device;
    std::vector<LightOverride> lights;
    std::vector<GroupWeight> groups;
    bool shadowDistanceGiven = false; ///< else it follows from the view
    int cascades = 0;                 ///< 0 = not given
    std::vector<float> cascadeSplits; ///< empty = not given
    CameraChoice camera;
    dvec3 eye{0.0};
    bool eyeGiven = false;
    vec3 shadowColor{0.0f}; ///< counts when settings have one
    float fovDegrees = 0.0f;
    std::optional<float> exposureEv; ///< empty = auto
    ToneMapping toneMapping = ToneMapping::Neutral;
    bool toneMappingGiven = false;
    bool exposureGiven = false;
    int referenceSamples = 0;
    bool referenceDiffuse = false; ///< diffuse transport behind the surfaces that the camera sees
    float referenceClamp = 0.0f;   ///< nits, 0 = none
    int bounces = kAllBounces;
    uint32_t seed = 1;
    int threads = 0;
    bool quiet = false;
    bool json = false;
};

/// Options and arguments of the command, written into `options`, which outlives the parser.
void addRenderOptions(CLI::App& app, RenderOptions& options);
/// Camera and settings from what several options say together.
void applyRenderOptions(RenderOptions& options);
/// Those that `halflight view` has as well.
void addViewOptions(CLI::App& app, RenderOptions& options);

} // namespace halflight::cli
