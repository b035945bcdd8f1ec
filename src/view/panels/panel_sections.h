#pragma once
// Sections of the panels that are in a file of their own, and what sections have in common.

#include "view/state/requests.h"
#include "view/state/shown.h"

#include <imgui.h>

#include <string>

namespace halflight::view {

inline void say(const std::string& text)
{
    ImGui::TextUnformatted(text.c_str());
}

template<typename T, typename Values, typename Name>
bool choice(const char* label, T& value, const Values& values, const Name& name)
{
    bool changed = false;
    if (!ImGui::BeginCombo(label, std::string(name(value)).c_str())) return false;
    for (const T& each : values) {
        if (!ImGui::Selectable(std::string(name(each)).c_str(), each == value)) continue;
        changed = each != value;
        value = each;
    }
    ImGui::EndCombo();
    return changed;
}

/// A number that is dragged or typed stays within its limits.
inline bool drag(const char* label, float& value, float speed, float least, float most, const char* format)
{
    return ImGui::DragFloat(label, &value, speed, least, most, format, ImGuiSliderFlags_AlwaysClamp);
}

/// As Dear ImGui shows it: "##" in a name of the file would hide what follows.
std::string shownName(std::string name);

/// Names are those of nameOf().
template<typename T, typename Values> bool choice(const char* label, T& value, const Values& values)
{
    return choice(label, value, values, [](const T& each) { return nameOf(each); });
}

/// What is in the scene: panels_scene.cpp.
void groupSection(const Shown& shown, Answer& answer);
void lightSection(const Shown& shown, Answer& answer);
void objectSection(const Shown& shown, Answer& answer);
void warningSection(const Shown& shown, Answer& answer);

/// What a frame takes, and sizes: panels_frame.cpp.
void frameSection(const Shown& shown, Answer& answer);
void statisticsSection(const SceneReport& report);

} // namespace halflight::view
