// Sections of the panels: times of frames and passes, statistics.
#include "view/panels/panel_sections.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

namespace halflight::view {
namespace {

constexpr float kGraphHeight = 60.0f; // pixels

void frameGraph(const std::vector<float>& times)
{
    if (times.empty()) return;
    const float mean = std::accumulate(times.begin(), times.end(), 0.0f) / float(times.size());
    const std::string label = fmt::format("{:.1f} ms, {:.0f} frames a second", mean, 1000.0f / mean);
    // Its own width: Dear ImGui 1.86 takes none below 0 here.
    ImGui::PlotLines("##times", times.data(), int(times.size()), 0, label.c_str(), 0.0f, 3.0f * mean,
                     ImVec2(ImGui::GetContentRegionAvail().x, kGraphHeight));
}

/// Of the pass of that place among the passes: hues a golden section apart, which differ for neighbours.
ImU32 colorOf(std::size_t pass)
{
    constexpr float kGolden = 0.618034f;
    const float turns = kGolden * float(pass);
    ImVec4 color(0.0f, 0.0f, 0.0f, 1.0f);
    ImGui::ColorConvertHSVtoRGB(turns - std::floor(turns), 0.6f, 0.9f, color.x, color.y, color.z);
    return ImGui::ColorConvertFloat4ToU32(color);
}

double sumOf(const std::vector<PassReport>& passes)
{
    return std::accumulate(passes.begin(), passes.end(), 0.0,
                           [](double sum, const PassReport& pass) { return sum + pass.milliseconds; });
}

/// A column for each frame, the oldest at the left: its passes' times on one another, the first one lowest.
void passGraph(const std::vector<std::vector<PassReport>>& frames)
{
    if (frames.empty()) return;
    double most = 0.0;
    for (const std::vector<PassReport>& passes : frames) most = std::max(most, sumOf(passes));
    say(fmt::format("{:.2f} ms on the device, {:.2f} at most", sumOf(frames.back()), most));
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    const float width = ImGui::GetContentRegionAvail().x;
    ImGui::Dummy(ImVec2(width, kGraphHeight));
    if (!(most > 0.0)) return;
    const float column = width / float(kShownFrames);
    for (std::size_t i = 0; i < frames.size(); ++i) {
        const float left = corner.x + column * float(i);
        float foot = corner.y + kGraphHeight;
        for (std::size_t pass = 0; pass < frames[i].size(); ++pass) {
            const float head = foot - kGraphHeight * float(frames[i][pass].milliseconds / most);
            ImGui::GetWindowDrawList()->AddRectFilled(ImVec2(left, head), ImVec2(left + column, foot), colorOf(pass));
            foot = head;
        }
    }
}

void passTable(const PictureReport& picture)
{
    if (!ImGui::BeginTable("passes", 3, ImGuiTableFlags_RowBg | ImGuiTableFlags_SizingStretchProp)) return;
    for (std::size_t i = 0; i < picture.passes.size(); ++i) {
        const PassReport& pass = picture.passes[i];
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        if (picture.timed)
            ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(colorOf(i)), "%s", pass.name.c_str());
        else
            say(pass.name);
        ImGui::TableNextColumn();
        say(picture.timed ? fmt::format("{:.3f} ms", pass.milliseconds) : "-");
        ImGui::TableNextColumn();
        say(fmt::format("{} draws", pass.draws));
    }
    ImGui::EndTable();
}

} // namespace

void frameSection(const Shown& shown, Answer& answer)
{
    if (!ImGui::CollapsingHeader("Frame")) return;
    bool& timings = answer.choices.settings.timings;
    const PictureReport& picture = shown.picture;
    frameGraph(shown.window.frameMilliseconds);
    ImGui::Checkbox("measure passes", &timings);
    if (timings && !picture.timed && !picture.passes.empty()) say("the device has no timestamps");
    if (timings) {
        passGraph(picture.passesOfFrames);
        passTable(picture);
    }
    say(shown.window.device);
}

void statisticsSection(const SceneReport& s)
{
    if (!ImGui::CollapsingHeader("Statistics")) return;
    say(fmt::format("{} objects, {} triangles", s.objects, s.triangles));
    say(fmt::format("{} lightmap pages of {} x {}", s.lightmapPages, s.pageSize.x, s.pageSize.y));
    say(fmt::format("{:.1f} MB of lightmaps and masks", s.lightmapMegabytes));
    say(fmt::format("{} light probes, {} reflection probes", s.probes, s.reflectionProbes));
}

} // namespace halflight::view
