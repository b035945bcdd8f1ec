#include "view/panels.h"

#include <SDL_keycode.h>
#include <imgui.h>
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cfloat>

namespace halflight::view {
namespace {

const char* unitOf(LightType type)
{
    return type == LightType::Directional ? "lux" : isAreaLight(type) ? "cd/m2" : "candela";
}

constexpr std::array kViews = {DebugView::Lit,      DebugView::Shadowmask, DebugView::Lightmap, DebugView::Probes,
                               DebugView::Cascades, DebugView::Fade,       DebugView::Overlap};

void say(const std::string& text)
{
    ImGui::TextUnformatted(text.c_str());
}

template<typename T, typename Values, typename Name>
bool choice(const char* label, T& value, const Values& values, const Name& name)
{
    bool changed = false;
    if (!ImGui::BeginCombo(label, name(value))) return false;
    for (const T& each : values) {
        if (!ImGui::Selectable(name(each), each == value)) continue;
        changed = each != value;
        value = each;
    }
    ImGui::EndCombo();
    return changed;
}

void viewSection(ViewState& state, const Scene& scene)
{
    if (!ImGui::CollapsingHeader("View", ImGuiTreeNodeFlags_DefaultOpen)) return;
    RenderSettings& settings = state.settings;
    choice("mode", settings.mode, state.modes, [](RunMode mode) { return nameOf(mode); });
    choice("path", settings.path, std::array{RenderPath::Forward, RenderPath::Deferred},
           [](RenderPath path) { return path == RenderPath::Forward ? "forward" : "deferred"; });
    choice("shows", settings.view, kViews, [](DebugView view) { return nameOf(view); });
    if (settings.view != DebugView::Lit) ImGui::TextWrapped("%s", legendOf(settings.view));
    ImGui::DragFloat("exposure EV", &state.exposureEv, 0.05f, -20.0f, 30.0f, "%.2f");
    if (ImGui::Button("expose for this view")) state.requests.expose = true;
    choice("antialiasing", settings.supersampling, std::array{1, 2, 3, 4}, [](int side) {
        constexpr const char* kNames[] = {"1 sample", "4 samples", "9 samples", "16 samples"};
        return kNames[side - 1];
    });
    ImGui::Checkbox("reflection probes", &settings.reflectionProbes);
    ImGui::Checkbox("specular", &settings.specular);
    ImGui::Checkbox("directional lightmaps", &settings.directionalLightmaps);
    ImGui::Checkbox("proxy volumes", &settings.proxyVolumes);
    ImGui::Checkbox("compare with another mode", &state.compares);
    if (state.compares) {
        choice("right of the line", state.otherMode, state.modes, [](RunMode mode) { return nameOf(mode); });
        ImGui::SliderFloat("line", &state.split, 0.0f, 1.0f, "%.2f");
    }
    ImGui::Checkbox("vsync", &state.vsync);
    ImGui::DragFloat("flying m/s", &state.speed, 0.05f, 0.01f, 1000.0f, "%.2f", ImGuiSliderFlags_Logarithmic);
    for (std::size_t i = 0; i < scene.cameras.size(); ++i) {
        ImGui::PushID(int(i));
        if (ImGui::SmallButton(("camera " + scene.cameras[i].name).c_str())) state.requests.camera = int(i);
        ImGui::PopID();
    }
    if (ImGui::Button("screenshot")) state.requests.screenshot = true;
    ImGui::SameLine();
    if (ImGui::Button("copy command line")) state.requests.copyCommand = true;
    if (ImGui::Button("reload the file")) state.requests.reload = true;
}

void shadowSection(ViewState& state)
{
    if (!ImGui::CollapsingHeader("Realtime shadows")) return;
    ShadowSettings& shadows = state.settings.shadows;
    ImGui::Checkbox("reach all that is in view", &state.followsShadowDistance);
    if (state.followsShadowDistance)
        say(fmt::format("distance {:.4g} m", state.shadowDistanceMeters));
    else
        ImGui::DragFloat("distance m", &shadows.distanceMeters, 0.1f, 0.01f, 100000.0f, "%.2f");
    ImGui::DragFloat("fade range m", &shadows.fadeRangeMeters, 0.05f, 0.01f, 100000.0f, "%.2f");
    ImGui::SliderInt("cascades", &shadows.cascades, 1, 4);
    choice("cascades blend", shadows.cascadeBlend,
           std::array{CascadeBlend::Hard, CascadeBlend::Dithered, CascadeBlend::Soft}, [](CascadeBlend blend) {
               constexpr const char* kNames[] = {"hard", "dithered", "soft"};
               return kNames[int(blend)];
           });
    choice("filter", shadows.filter, std::array{ShadowFilter::Hard, ShadowFilter::Pcf, ShadowFilter::Soft},
           [](ShadowFilter filter) {
               constexpr const char* kNames[] = {"hard", "pcf", "soft"};
               return kNames[int(filter)];
           });
    const auto sizes = std::array{256, 512, 1024, 2048, 4096, 8192};
    static thread_local std::string text;
    const auto nameOfSize = [](int size) {
        text = fmt::format("{} texels", size);
        return text.c_str();
    };
    choice("cascade size", shadows.directionalMapSize, sizes, nameOfSize);
    choice("atlas size", shadows.atlasSize, sizes, nameOfSize);
    ImGui::Checkbox("shadows of point lights", &shadows.pointShadows);
}

/// A change that needs a new bake before it shows in full.
void markForBake(bool bakes)
{
    if (!bakes) return;
    ImGui::SameLine();
    ImGui::TextDisabled("(bake)");
}

void lightEditor(ViewState& state, const Light& light)
{
    Light changed = light;
    bool any = choice("light mode", changed.mode, std::array{LightMode::Realtime, LightMode::Mixed, LightMode::Baked},
                      [](LightMode mode) { return nameOf(mode); });
    markForBake(true);
    if (light.baking.occlusionMaskChannel >= 0) say(fmt::format("mask channel {}", light.baking.occlusionMaskChannel));
    const bool baked = light.mode != LightMode::Realtime;
    any |= ImGui::ColorEdit3("colour", &changed.color.x, ImGuiColorEditFlags_Float | ImGuiColorEditFlags_HDR);
    markForBake(baked);
    any |= ImGui::DragFloat(unitOf(light.type), &changed.intensity, 0.01f * std::max(light.intensity, 0.01f), 0.0f,
                            FLT_MAX, "%.4g");
    markForBake(baked);
    any |= ImGui::SliderFloat("shadow strength", &changed.shadowStrength, 0.0f, 1.0f);
    if (light.type == LightType::Directional) {
        float degrees = glm::degrees(2.0f * changed.angularRadiusRadians);
        if (ImGui::DragFloat("angular diameter", &degrees, 0.01f, 0.0f, 90.0f, "%.2f deg")) {
            changed.angularRadiusRadians = glm::radians(0.5f * degrees);
            any = true;
        }
    } else {
        any |= ImGui::DragFloat("radius m", &changed.radiusMeters, 0.005f, 0.0f, 100.0f, "%.3f");
    }
    markForBake(true);
    any |= ImGui::DragFloat("bounced light", &changed.indirectMultiplier, 0.01f, 0.0f, 100.0f, "x %.2f");
    markForBake(true);
    any |= ImGui::Checkbox("casts shadows", &changed.castShadows);
    if (any) state.requests.light = {state.selectedLight, changed};
}

void lightSection(ViewState& state, const Scene& scene)
{
    if (!ImGui::CollapsingHeader(fmt::format("Lights ({})###Lights", scene.lights.size()).c_str())) return;
    if (ImGui::BeginListBox("##lights", ImVec2(-FLT_MIN, 6.0f * ImGui::GetTextLineHeightWithSpacing()))) {
        for (std::size_t i = 0; i < scene.lights.size(); ++i) {
            const Light& light = scene.lights[i];
            const std::string line =
                fmt::format("{}  {} {}##{}", light.name, nameOf(light.mode), nameOf(light.type), i);
            if (ImGui::Selectable(line.c_str(), state.selectedLight == int(i))) state.selectedLight = int(i);
        }
        ImGui::EndListBox();
    }
    if (state.selectedLight >= 0 && std::size_t(state.selectedLight) < scene.lights.size())
        lightEditor(state, scene.lights[std::size_t(state.selectedLight)]);
}

void objectEditor(ViewState& state, const Object& object)
{
    say(fmt::format("{}: {}", object.name, object.isStatic ? "static, baked" : "dynamic, lit by probes"));
    bool casts = object.castShadows;
    bool receives = object.receiveShadows;
    bool changed = ImGui::Checkbox("casts", &casts);
    markForBake(object.isStatic);
    changed |= ImGui::Checkbox("receives", &receives);
    markForBake(object.isStatic);
    if (changed) state.requests.switches = {state.selectedObject, casts, receives};
    mat4 moved = object.worldFromObject;
    if (ImGui::DragFloat3("position m", &moved[3].x, 0.01f, -FLT_MAX, FLT_MAX, "%.2f"))
        state.requests.move = {state.selectedObject, moved};
    markForBake(object.isStatic);
    if (ImGui::Button("look at it (F)")) state.requests.frameSelection = true;
}

void objectSection(ViewState& state, const Scene& scene)
{
    if (!ImGui::CollapsingHeader(fmt::format("Objects ({})###Objects", scene.objects.size()).c_str())) return;
    if (ImGui::BeginListBox("##objects", ImVec2(-FLT_MIN, 8.0f * ImGui::GetTextLineHeightWithSpacing()))) {
        ImGuiListClipper clipper;
        clipper.Begin(int(scene.objects.size()));
        while (clipper.Step()) {
            for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) {
                const Object& object = scene.objects[std::size_t(i)];
                const std::string line = fmt::format("{}{}##{}", object.name, object.isStatic ? "" : "  dynamic", i);
                if (ImGui::Selectable(line.c_str(), state.selectedObject == i)) state.selectedObject = i;
            }
        }
        ImGui::EndListBox();
    }
    if (state.selectedObject >= 0 && std::size_t(state.selectedObject) < scene.objects.size())
        objectEditor(state, scene.objects[std::size_t(state.selectedObject)]);
}

void bakeSection(ViewState& state)
{
    if (!ImGui::CollapsingHeader("Bake", ImGuiTreeNodeFlags_DefaultOpen)) return;
    const BakeStatus& status = state.bakeStatus;
    if (status.running) {
        const BakeSessionState& session = status.session;
        ImGui::ProgressBar(float(session.fraction), ImVec2(-FLT_MIN, 0.0f), session.stage.c_str());
        std::string line = fmt::format("{:.0f} s", session.seconds);
        if (session.stageSecondsLeft >= 0.0)
            line += fmt::format(", this stage {:.0f} s more", session.stageSecondsLeft);
        say(line);
        if (status.firstLight) say("shown: the first, coarse light");
        if (ImGui::Button("cancel the bake")) state.requests.cancelBake = true;
        return;
    }
    choice("baked mode", state.bake.mode,
           std::array{MixedLightingMode::BakedIndirect, MixedLightingMode::Shadowmask, MixedLightingMode::Subtractive},
           [](MixedLightingMode mode) { return halflight::nameOf(mode); });
    choice("quality", state.bake.quality, std::array{Quality::Preview, Quality::Medium, Quality::High, Quality::Ultra},
           [](Quality quality) {
               constexpr const char* kNames[] = {"preview", "medium", "high", "ultra"};
               return kNames[int(quality)];
           });
    ImGui::Checkbox("bakes directions", &state.bake.directional);
    ImGui::Checkbox("bakes reflection probes", &state.bake.reflectionProbes);
    if (ImGui::Button("bake (B)")) state.requests.bake = true;
    if (status.outOfDate) ImGui::TextWrapped("Lights or objects changed since the bake that is shown.");
    if (!status.outcome.empty()) ImGui::TextWrapped("%s", status.outcome.c_str());
    std::array<char, 1024> path{};
    std::copy_n(state.bakeOutput.begin(), std::min(state.bakeOutput.size(), path.size() - 1), path.begin());
    if (ImGui::InputText("file", path.data(), path.size())) state.bakeOutput = path.data();
    if (status.hasResult && ImGui::Button("save the baked file")) state.requests.save = true;
    if (ImGui::Button("write changes as a settings file")) state.requests.writeSettings = true;
}

void frameSection(ViewState& state)
{
    if (!ImGui::CollapsingHeader("Frame")) return;
    const std::vector<float>& times = state.frameMilliseconds;
    if (!times.empty()) {
        const float mean = [&] {
            float sum = 0.0f;
            for (const float time : times) sum += time;
            return sum / float(times.size());
        }();
        const std::string label = fmt::format("{:.1f} ms, {:.0f} frames a second", mean, 1000.0f / mean);
        ImGui::PlotLines("##times", times.data(), int(times.size()), 0, label.c_str(), 0.0f, 3.0f * mean,
                         ImVec2(-FLT_MIN, 60.0f));
    }
    ImGui::Checkbox("measure passes", &state.settings.timings);
    if (state.settings.timings && !state.timed && !state.passes.empty()) say("the device has no timestamps");
    if (ImGui::BeginTable("passes", 3, ImGuiTableFlags_RowBg)) {
        for (const PassReport& pass : state.passes) {
            ImGui::TableNextRow();
            ImGui::TableNextColumn();
            say(pass.name);
            ImGui::TableNextColumn();
            say(state.timed ? fmt::format("{:.3f} ms", pass.milliseconds) : "-");
            ImGui::TableNextColumn();
            say(fmt::format("{} draws", pass.draws));
        }
        ImGui::EndTable();
    }
    say(state.device);
}

void statisticsSection(const ViewState& state)
{
    if (!ImGui::CollapsingHeader("Statistics")) return;
    const Statistics& s = state.statistics;
    say(fmt::format("{} objects, {} triangles", s.objects, s.triangles));
    say(fmt::format("{} lightmap pages of {} x {}", s.lightmapPages, s.pageSize.x, s.pageSize.y));
    say(fmt::format("{:.1f} MB of lightmaps and masks", s.lightmapMegabytes));
    say(fmt::format("{} light probes, {} reflection probes", s.probes, s.reflectionProbes));
}

void warningSection(const ViewState& state)
{
    const std::string title = fmt::format("Warnings ({})###Warnings", state.warnings.size());
    if (!ImGui::CollapsingHeader(title.c_str())) return;
    for (const std::string& warning : state.warnings) {
        ImGui::Bullet();
        ImGui::TextWrapped("%s", warning.c_str());
    }
}

} // namespace

const std::vector<std::string>& keyHelp()
{
    static const std::vector<std::string> lines = {
        "1 … 5         lighting mode: realtime, baked indirect, shadowmask, distance, subtractive",
        "P, V          forward or deferred; next view (shadowmask, lightmap, …)",
        "left drag     orbit; right drag: look; middle or shift drag: pan; wheel: nearer",
        "W A S D Q E   fly; shift: four times as fast",
        "F             look at what is selected, or at all; click selects",
        "B, X, Ctrl-S  bake; expose for this view; save the baked file",
        "C             compare two modes",
        "F5, F11, F12  reload the file; full screen; screenshot",
        "Tab, Escape   panels; cancel a bake, or quit"};
    return lines;
}

void drawPanels(ViewState& state, const Scene& scene)
{
    if (!state.panels) return;
    const ImGuiIO& io = ImGui::GetIO();
    const float width = std::min(24.0f * ImGui::GetFontSize(), 0.9f * io.DisplaySize.x);
    ImGui::SetNextWindowPos(ImVec2(0.0f, 0.0f));
    ImGui::SetNextWindowSize(ImVec2(width, io.DisplaySize.y));
    constexpr ImGuiWindowFlags kFixed =
        ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse;
    if (ImGui::Begin((state.title + "###panels").c_str(), nullptr, kFixed)) {
        ImGui::PushItemWidth(11.0f * ImGui::GetFontSize());
        viewSection(state, scene);
        bakeSection(state);
        shadowSection(state);
        lightSection(state, scene);
        objectSection(state, scene);
        frameSection(state);
        statisticsSection(state);
        warningSection(state);
        if (ImGui::CollapsingHeader("Keys"))
            for (const std::string& line : keyHelp()) ImGui::TextWrapped("%s", line.c_str());
        ImGui::PopItemWidth();
    }
    ImGui::End();
}

void handleKey(ViewState& state, int key, bool control)
{
    if (control) {
        if (key == SDLK_s) state.requests.save = true;
        return;
    }
    Requests& requests = state.requests;
    if (key >= SDLK_1 && key <= SDLK_5) {
        const auto mode = RunMode(key - SDLK_1);
        if (std::find(state.modes.begin(), state.modes.end(), mode) != state.modes.end()) state.settings.mode = mode;
        return;
    }
    switch (key) {
    case SDLK_p:
        state.settings.path = state.settings.path == RenderPath::Forward ? RenderPath::Deferred : RenderPath::Forward;
        break;
    case SDLK_v:
        state.settings.view = kViews[(std::size_t(state.settings.view) + 1) % kViews.size()];
        break;
    case SDLK_f:
        requests.frameSelection = true;
        break;
    case SDLK_b:
        requests.bake = !state.bakeStatus.running;
        break;
    case SDLK_x:
        requests.expose = true;
        break;
    case SDLK_c:
        state.compares = !state.compares;
        break;
    case SDLK_F5:
        requests.reload = true;
        break;
    case SDLK_F11:
        requests.toggleFullScreen = true;
        break;
    case SDLK_F12:
        requests.screenshot = true;
        break;
    case SDLK_TAB:
        state.panels = !state.panels;
        break;
    case SDLK_ESCAPE:
        (state.bakeStatus.running ? requests.cancelBake : requests.quit) = true;
        break;
    default:
        break;
    }
}

} // namespace halflight::view
