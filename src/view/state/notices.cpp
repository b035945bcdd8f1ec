#include "view/state/notices.h"

#include <imgui.h>

#include <algorithm>

namespace halflight::view {

void Notices::say(const std::string& line) const
{
    if (say_) say_(line);
}

void Notices::note(const std::string& line)
{
    note_ = line;
    noteTime_ = Clock::now();
}

void Notices::tell(const std::string& line)
{
    say(line);
    note(line);
}

std::string Notices::currentNote() const
{
    constexpr std::chrono::seconds kShown(4);
    return Clock::now() - noteTime_ < kShown ? note_ : "";
}

void Notices::setWarnings(About about, std::vector<std::string> warnings)
{
    warnings_[std::size_t(about)] = std::move(warnings);
}

void Notices::addWarning(About about, const std::string& warning)
{
    warnings_[std::size_t(about)].push_back(warning);
}

std::vector<std::string> Notices::warnings() const
{
    std::vector<std::string> all;
    for (const std::vector<std::string>& some : warnings_) all.insert(all.end(), some.begin(), some.end());
    return all;
}

void drawAtBottom(const std::string& text)
{
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    const float gap = 0.5f * ImGui::GetFontSize();
    const float width = std::max(size.x - 4.0f * gap, ImGui::GetFontSize());
    const ImVec2 extent = ImGui::CalcTextSize(text.c_str(), nullptr, false, width);
    const ImVec2 at(0.5f * (size.x - extent.x), size.y - extent.y - 4.0f * gap - ImGui::GetFontSize());
    ImDrawList* list = ImGui::GetForegroundDrawList();
    list->AddRectFilled(ImVec2(at.x - gap, at.y - gap), ImVec2(at.x + extent.x + gap, at.y + extent.y + gap),
                        IM_COL32(0, 0, 0, 200), gap);
    list->AddText(nullptr, 0.0f, at, IM_COL32_WHITE, text.c_str(), nullptr, width);
}

} // namespace halflight::view
