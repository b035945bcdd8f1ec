#include "view/panels/panels.h"

#include "view/panels/panel_sections.h"

#include <SDL_keycode.h>
#include <imgui.h>
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>
#include <utility>
#include <vector>

namespace halflight::view {
namespace {

constexpr float kMostBakeSeconds = 36'000.0f;

constexpr std::array kViews = {DebugView::Lit,      DebugView::Shadowmask, DebugView::Lightmap, DebugView::Probes,
                               DebugView::Cascades, DebugView::Fade,       DebugView::Overlap,  DebugView::Texels};

void compareChoices(const Shown& shown, ViewState& state)
{
    ImGui::Checkbox("compare", &state.compares);
    if (!state.compares) return;
    std::vector<Compare> choices = {Compare::Mode, Compare::Reference};
    if (shown.comparison.hasEarlier) choices.push_back(Compare::BeforeBake);
    choice("right of the line", state.compareWith, choices, [](Compare with) {
        constexpr const char* kNames[] = {"another mode", "before the bake", "the reference"};
        return kNames[int(with)];
    });
    if (state.compareWith == Compare::Mode) choice("other mode", state.otherMode, shown.report.modes);
    if (state.compareWith == Compare::Reference) {
        const bool any = shown.comparison.referenceSamples > 0;
        say(any ? fmt::format("samples a pixel: {}", shown.comparison.referenceSamples)
                : "it begins when the camera rests");
    }
    ImGui::SliderFloat("line", &state.split, 0.0f, 1.0f, "%.2f", ImGuiSliderFlags_AlwaysClamp);
}

void viewSection(const Shown& shown, Answer& answer)
{
    if (!ImGui::CollapsingHeader("View", ImGuiTreeNodeFlags_DefaultOpen)) return;
    ViewState& state = answer.choices;
    RenderSettings& settings = state.settings;
    choice("mode", settings.mode, shown.report.modes);
    choice("path", settings.path, std::array{RenderPath::Forward, RenderPath::Deferred});
    choice("shows", settings.view, kViews);
    if (settings.view != DebugView::Lit) ImGui::TextWrapped("%s", legendOf(settings.view));
    drag("exposure EV", state.exposureEv, 0.05f, -40.0f, 40.0f, "%.2f");
    if (ImGui::Button("expose for this view")) answer.requests.emplace_back(Action::Expose);
    choice("tone mapping", state.toneMapping,
           std::array{ToneMapping::Neutral, ToneMapping::Aces, ToneMapping::Agx, ToneMapping::None});
    choice("antialiasing", settings.supersampling, std::array{1, 2, 3, 4}, [](int side) {
        constexpr const char* kNames[] = {"1 sample", "4 samples", "9 samples", "16 samples"};
        return kNames[side - 1];
    });
    ImGui::Checkbox("reflection probes", &settings.reflectionProbes);
    ImGui::Checkbox("specular", &settings.specular);
    ImGui::Checkbox("directional lightmaps", &settings.directionalLightmaps);
    ImGui::Checkbox("proxy volumes", &settings.proxyVolumes);
    compareChoices(shown, state);
    ImGui::Checkbox("vsync", &state.vsync);
    drag("flying m/s", state.speed, 0.05f, 0.01f, 1000.0f, "%.2f");
    for (std::size_t i = 0; i < shown.scene.cameras.size(); ++i) {
        ImGui::PushID(int(i));
        if (ImGui::SmallButton(shownName("camera " + shown.scene.cameras[i].name).c_str()))
            answer.requests.emplace_back(LookThrough{int(i)});
        ImGui::PopID();
    }
    if (ImGui::Button("screenshot")) answer.requests.emplace_back(Action::Screenshot);
    ImGui::SameLine();
    if (ImGui::Button("copy command line")) answer.requests.emplace_back(Action::CopyCommand);
    if (ImGui::Button("reload the file")) answer.requests.emplace_back(Action::Reload);
}

void shadowSection(const Shown& shown, Answer& answer)
{
    if (!ImGui::CollapsingHeader("Realtime shadows")) return;
    ViewState& state = answer.choices;
    ShadowSettings& shadows = state.settings.shadows;
    ImGui::Checkbox("reach all that is in view", &state.followsShadowDistance);
    if (state.followsShadowDistance)
        say(fmt::format("distance {:.4g} m", shown.picture.shadowDistanceMeters));
    else
        drag("distance m", shadows.distanceMeters, 0.1f, 0.01f, 100000.0f, "%.2f");
    drag("fade range m", shadows.fadeRangeMeters, 0.05f, 0.01f, 100000.0f, "%.2f");
    ImGui::SliderInt("cascades", &shadows.cascades, 1, 4, "%d", ImGuiSliderFlags_AlwaysClamp);
    choice("cascades blend", shadows.cascadeBlend,
           std::array{CascadeBlend::Hard, CascadeBlend::Dithered, CascadeBlend::Soft});
    choice("filter", shadows.filter, std::array{ShadowFilter::Hard, ShadowFilter::Pcf, ShadowFilter::Soft});
    ImGui::Checkbox("penumbrae by the light's size", &shadows.penumbrae);
    const auto sizes = std::array{256, 512, 1024, 2048, 4096, 8192};
    const auto nameOfSize = [](int size) { return fmt::format("{} texels", size); };
    choice("cascade size", shadows.directionalMapSize, sizes, nameOfSize);
    choice("atlas size", shadows.atlasSize, sizes, nameOfSize);
    ImGui::Checkbox("shadows of point lights", &shadows.pointShadows);
}

void bakeSection(const Shown& shown, Answer& answer)
{
    if (!ImGui::CollapsingHeader("Bake", ImGuiTreeNodeFlags_DefaultOpen)) return;
    ViewState& state = answer.choices;
    const BakeStatus& status = shown.bake;
    if (status.running) {
        const BakeSessionState& session = status.session;
        ImGui::ProgressBar(float(session.fraction), ImVec2(-FLT_MIN, 0.0f), session.stage.c_str());
        std::string line = fmt::format("{:.0f} s", session.seconds);
        if (session.stageSecondsLeft >= 0.0)
            line += fmt::format(", this stage {:.0f} s more", session.stageSecondsLeft);
        say(line);
        if (status.firstLight)
            ImGui::TextWrapped(
                "Light comes in as it is done, what is in view first; mixed lights' shadows are realtime "
                "until the end.");
        if (status.cancelled)
            ImGui::TextUnformatted("The bake ends.");
        else if (ImGui::Button("cancel the bake"))
            answer.requests.emplace_back(Action::CancelBake);
        return;
    }
    choice("baked mode", state.bake.mode,
           std::array{MixedLightingMode::BakedIndirect, MixedLightingMode::Shadowmask, MixedLightingMode::Subtractive});
    choice("quality", state.bake.quality, std::array{Quality::Preview, Quality::Medium, Quality::High, Quality::Ultra});
    if (state.bake.cacheDirectory.empty()) { // what it holds takes no time
        auto seconds = float(state.bake.seconds);
        if (drag("seconds", seconds, 1.0f, 0.0f, kMostBakeSeconds, seconds > 0.0f ? "%.0f" : "by quality"))
            state.bake.seconds = double(seconds);
    }
    bool directional = resolveQuality(state.bake).directional;
    if (ImGui::Checkbox("bakes directions", &directional)) state.bake.directional = directional;
    ImGui::Checkbox("glossy bounces", &state.bake.glossyBounces);
    ImGui::Checkbox("bakes reflection probes", &state.bake.reflectionProbes);
    if (ImGui::Button("bake (B)")) answer.requests.emplace_back(Action::Bake);
    if (status.outOfDate && shown.report.isBaked)
        ImGui::TextWrapped("Lights or objects changed since the bake that is shown.");
    if (!status.outcome.empty()) ImGui::TextWrapped("%s", status.outcome.c_str());
    std::array<char, 1024> path{};
    std::copy_n(state.bakeOutput.begin(), std::min(state.bakeOutput.size(), path.size() - 1), path.begin());
    if (ImGui::InputText("file", path.data(), path.size())) state.bakeOutput = path.data();
    if (status.hasResult && ImGui::Button("save the baked file")) answer.requests.emplace_back(Action::Save);
    if (ImGui::Button("write changes as a settings file")) answer.requests.emplace_back(Action::WriteSettings);
}

} // namespace

std::string shownName(std::string name)
{
    for (std::size_t at = name.find("##"); at != std::string::npos; at = name.find("##", at + 1))
        name.insert(at + 1, " ");
    return name;
}

float panelScale(float dotsPerInch)
{
    constexpr float kMost = 4.0f;
    if (!(dotsPerInch > kUsualDotsPerInch)) return 1.0f;
    return std::min(std::round(4.0f * dotsPerInch / kUsualDotsPerInch) / 4.0f, kMost);
}

const std::vector<std::string>& keyHelp()
{
    static const std::vector<std::string> lines = {
        "1 to 5        lighting mode: realtime, baked indirect, shadowmask, distance, subtractive",
        "P, V          forward or deferred; next view (shadowmask, lightmap and others)",
        "left drag     orbit; right drag: look; middle or shift drag: pan; wheel: nearer",
        "W A S D Q E   fly; shift: four times as fast",
        "F             look at what is selected, or at all; click selects",
        "arrows        of a dynamic object that is selected: drag it along an axis",
        "gamepad       left stick: fly; right stick: look; triggers: down and up",
        "B, X, Ctrl-S  bake; expose for this view; save the baked file",
        "C, R          compare: light before the bake, another mode, the reference; the reference at once",
        "F5, F11, F12  reload the file; full screen; screenshot",
        "Tab, Escape   panels; cancel a bake, or quit"};
    return lines;
}

namespace {

float panelWidth()
{
    const ImGuiIO& io = ImGui::GetIO();
    return std::min(26.0f * io.Fonts->Fonts[0]->FontSize, 0.9f * io.DisplaySize.x);
}

} // namespace

bool overPanels(const ViewState& state, vec2 place)
{
    if (ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopup)) return true;
    return state.panels && place.x < panelWidth();
}

Answer drawPanels(const Shown& shown)
{
    Answer answer{shown.choices, {}, {}};
    if (!shown.choices.panels) return answer;
    ImGui::SetNextWindowPos(ImVec2(0.0f, 0.0f));
    ImGui::SetNextWindowSize(ImVec2(panelWidth(), ImGui::GetIO().DisplaySize.y));
    constexpr ImGuiWindowFlags kFixed =
        ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse;
    if (ImGui::Begin((shownName(shown.window.title) + "###panels").c_str(), nullptr, kFixed)) {
        ImGui::PushItemWidth(11.0f * ImGui::GetFontSize());
        viewSection(shown, answer);
        groupSection(shown, answer);
        bakeSection(shown, answer);
        shadowSection(shown, answer);
        lightSection(shown, answer);
        objectSection(shown, answer);
        frameSection(shown, answer);
        statisticsSection(shown.report);
        warningSection(shown, answer);
        if (ImGui::CollapsingHeader("Keys"))
            for (const std::string& line : keyHelp()) ImGui::TextWrapped("%s", line.c_str());
        ImGui::PopItemWidth();
    }
    ImGui::End();
    return answer;
}

namespace {

constexpr std::pair<int, Action> kActions[] = {{SDLK_b, Action::Bake},           {SDLK_ESCAPE, Action::Leave},
                                               {SDLK_f, Action::FrameSelection}, {SDLK_x, Action::Expose},
                                               {SDLK_F5, Action::Reload},        {SDLK_F11, Action::ToggleFullScreen},
                                               {SDLK_F12, Action::Screenshot}};

/// Nothing, the light before the bake, another mode, the reference, in turn.
void compareNext(const Shown& shown, ViewState& state)
{
    std::vector<Compare> choices = {Compare::Reference};
    if (shown.report.modes.size() > 1) choices.insert(choices.begin(), Compare::Mode);
    if (shown.comparison.hasEarlier) choices.insert(choices.begin(), Compare::BeforeBake);
    const auto at = std::find(choices.begin(), choices.end(), state.compareWith);
    const bool last = at == choices.end() || at + 1 == choices.end();
    if (!state.compares)
        state.compareWith = choices.front();
    else if (!last)
        state.compareWith = *(at + 1);
    state.compares = !state.compares || !last;
}

} // namespace

Answer answerKey(const Shown& shown, int key, bool control)
{
    Answer answer{shown.choices, {}, {}};
    if (control) {
        if (key == SDLK_s) answer.requests.emplace_back(Action::Save);
        return answer;
    }
    for (const auto& [actionKey, action] : kActions)
        if (key == actionKey) answer.requests.emplace_back(action);
    ViewState& state = answer.choices;
    RenderSettings& settings = state.settings;
    switch (key) {
    case SDLK_1:
    case SDLK_2:
    case SDLK_3:
    case SDLK_4:
    case SDLK_5: {
        const auto mode = RunMode(key - SDLK_1);
        const std::vector<RunMode>& modes = shown.report.modes;
        if (std::find(modes.begin(), modes.end(), mode) != modes.end()) settings.mode = mode;
        break;
    }
    case SDLK_p:
        settings.path = settings.path == RenderPath::Forward ? RenderPath::Deferred : RenderPath::Forward;
        break;
    case SDLK_v:
        settings.view = kViews[(std::size_t(settings.view) + 1) % kViews.size()];
        break;
    case SDLK_c:
        compareNext(shown, state);
        break;
    case SDLK_r:
        state.compares = !(state.compares && state.compareWith == Compare::Reference);
        state.compareWith = Compare::Reference;
        break;
    case SDLK_TAB:
        state.panels = !state.panels;
        break;
    default:
        break;
    }
    return answer;
}

} // namespace halflight::view
