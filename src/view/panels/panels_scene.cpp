// Lights, objects and warnings.
#include "view/panels/light_direction.h"
#include "view/panels/panel_sections.h"

#include "halflight/scene/turning_lights.h"

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

/// A change that needs a new bake before it shows in full.
void markForBake(bool bakes)
{
    if (!bakes) return;
    ImGui::SameLine();
    ImGui::TextDisabled("(bake)");
}

constexpr float kMost = 1.0e9f;      // of intensities and colours, as options have it
constexpr float kLeastSide = 0.001f; // metres, of area lights
constexpr float kMostSide = 1.0e5f;

bool directionEditor(Light& light)
{
    LightSource source = sourceOf(light.direction());
    bool turned = drag("height", source.height, 0.2f, -90.0f, 90.0f, "%.1f deg");
    turned |= drag("bearing", source.bearing, 0.2f, -360.0f, 360.0f, "%.1f deg");
    if (turned) light.worldFromLight = poseFrom(source, light.position());
    return turned;
}

void lightEditor(const Shown& shown, Answer& answer, int selected)
{
    const Light& light = shown.scene.lights[std::size_t(selected)];
    Light changed = light;
    bool any = choice("light mode", changed.mode, std::array{LightMode::Realtime, LightMode::Mixed, LightMode::Baked});
    markForBake(true);
    const std::vector<int>& channels = shown.report.maskChannels;
    const auto index = std::size_t(selected);
    if (index < channels.size() && channels[index] >= 0) say(fmt::format("mask channel {}", channels[index]));
    const bool baked = light.mode != LightMode::Realtime;
    any |= ImGui::ColorEdit3("colour", &changed.color.x, ImGuiColorEditFlags_Float | ImGuiColorEditFlags_HDR);
    changed.color = glm::clamp(changed.color, vec3(0.0f), vec3(kMost)); // Dear ImGui limits it to 1 or not at all
    markForBake(baked);
    any |= drag(unitOf(light.type), changed.intensity, 0.01f * std::max(light.intensity, 0.01f), 0.0f, kMost, "%.4g");
    markForBake(baked);
    any |= ImGui::SliderFloat("shadow strength", &changed.shadowStrength, 0.0f, 1.0f, "%.3f",
                              ImGuiSliderFlags_AlwaysClamp);
    if (light.type == LightType::Directional) {
        float degrees = glm::degrees(2.0f * changed.angularRadiusRadians);
        if (drag("angular diameter", degrees, 0.01f, 0.0f, 90.0f, "%.2f deg")) {
            changed.angularRadiusRadians = glm::radians(0.5f * degrees);
            any = true;
        }
        if (turns(light)) any |= directionEditor(changed);
    } else if (light.type == LightType::Disk) {
        any |= drag("diameter m", changed.sizeMeters.x, 0.005f, kLeastSide, kMostSide, "%.3f");
    } else if (light.type == LightType::Rectangle) {
        any |= ImGui::DragFloat2("size m", &changed.sizeMeters.x, 0.005f, kLeastSide, kMostSide, "%.3f",
                                 ImGuiSliderFlags_AlwaysClamp);
    } else {
        any |= drag("radius m", changed.radiusMeters, 0.005f, 0.0f, 100.0f, "%.3f");
    }
    markForBake(true);
    any |= drag("bounced light", changed.indirectMultiplier, 0.01f, 0.0f, 100.0f, "x %.2f");
    markForBake(true);
    any |= ImGui::Checkbox("casts shadows", &changed.castShadows);
    if (any) answer.changes.emplace_back(ChangeLight{selected, changed});
}

void objectEditor(const Scene& scene, Answer& answer, int selected)
{
    const Object& object = scene.objects[std::size_t(selected)];
    say(fmt::format("{}: {}", object.name, object.isStatic ? "static, baked" : "dynamic, lit by probes"));
    ChangeSwitches switches{selected, object.isStatic, object.castShadows, object.receiveShadows};
    bool changed = ImGui::Checkbox("static", &switches.isStatic);
    markForBake(true);
    changed |= ImGui::Checkbox("casts shadows##object", &switches.castShadows);
    markForBake(object.isStatic);
    changed |= ImGui::Checkbox("receives shadows", &switches.receiveShadows);
    markForBake(object.isStatic);
    if (changed) answer.changes.emplace_back(switches);
    dvec3 place = scene.originMeters + dvec3(object.worldFromObject[3]); // as the file has it
    constexpr float kSpeed = 0.01f;                                      // metres a pixel
    if (ImGui::DragScalarN("position m", ImGuiDataType_Double, &place.x, 3, kSpeed, nullptr, nullptr, "%.2f")) {
        mat4 moved = object.worldFromObject;
        moved[3] = vec4(vec3(place - scene.originMeters), 1.0f);
        answer.changes.emplace_back(MoveObject{selected, moved});
    }
    markForBake(object.isStatic);
    if (ImGui::Button("look at it (F)")) answer.requests.emplace_back(Action::FrameSelection);
}

} // namespace

/// A slider and a colour, whose product is the weight. Its colour stays while a group is off.
void groupSection(const Shown& shown, Answer& answer)
{
    if (shown.groups.empty()) return;
    const std::string title = fmt::format("Light groups ({})###Groups", shown.groups.size());
    if (!ImGui::CollapsingHeader(title.c_str(), ImGuiTreeNodeFlags_DefaultOpen)) return;
    const auto set = [&](const GroupReport& group, vec3 weight) {
        answer.changes.emplace_back(ChangeGroup{group.name, weight});
    };
    for (std::size_t i = 0; i < shown.groups.size(); ++i) {
        const GroupReport& group = shown.groups[i];
        ImGui::PushID(int(i));
        say(shownName(group.name));
        if (group.weight != group.saved) {
            ImGui::SameLine();
            if (ImGui::SmallButton("as saved")) set(group, group.saved);
        }
        constexpr float kUsual = 2.0f; // twice the light of the weight 1; more is typed
        float brightness = std::max({group.weight.x, group.weight.y, group.weight.z});
        vec3 color = group.color;
        bool changed = ImGui::SliderFloat("weight", &brightness, 0.0f, kUsual, "%.3f");
        changed |= ImGui::ColorEdit3("colour", &color.x, ImGuiColorEditFlags_Float);
        if (changed) set(group, glm::clamp(color, 0.0f, 1.0f) * std::clamp(brightness, 0.0f, kMost));
        ImGui::PopID();
    }
    const auto differs = [](const GroupReport& group) { return group.weight != group.saved; };
    if (std::any_of(shown.groups.begin(), shown.groups.end(), differs) && ImGui::Button("all groups as saved"))
        for (const GroupReport& group : shown.groups) set(group, group.saved);
}

void lightSection(const Shown& shown, Answer& answer)
{
    const Scene& scene = shown.scene;
    int& selected = answer.choices.selectedLight;
    if (!ImGui::CollapsingHeader(fmt::format("Lights ({})###Lights", scene.lights.size()).c_str())) return;
    if (ImGui::BeginListBox("##lights", ImVec2(-FLT_MIN, 6.0f * ImGui::GetTextLineHeightWithSpacing()))) {
        for (std::size_t i = 0; i < scene.lights.size(); ++i) {
            const Light& light = scene.lights[i];
            const std::string line =
                fmt::format("{}  {} {}##{}", shownName(light.name), nameOf(light.mode), nameOf(light.type), i);
            if (ImGui::Selectable(line.c_str(), selected == int(i))) selected = int(i);
        }
        ImGui::EndListBox();
    }
    if (selected >= 0 && std::size_t(selected) < scene.lights.size()) lightEditor(shown, answer, selected);
}

void objectSection(const Shown& shown, Answer& answer)
{
    const Scene& scene = shown.scene;
    int& selected = answer.choices.selectedObject;
    if (std::exchange(answer.choices.showsSelected, false)) ImGui::SetNextItemOpen(true);
    if (!ImGui::CollapsingHeader(fmt::format("Objects ({})###Objects", scene.objects.size()).c_str())) return;
    if (ImGui::BeginListBox("##objects", ImVec2(-FLT_MIN, 8.0f * ImGui::GetTextLineHeightWithSpacing()))) {
        ImGuiListClipper clipper;
        clipper.Begin(int(scene.objects.size()));
        while (clipper.Step()) {
            for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) {
                const Object& object = scene.objects[std::size_t(i)];
                const std::string line =
                    fmt::format("{}{}##{}", shownName(object.name), object.isStatic ? "" : "  dynamic", i);
                if (ImGui::Selectable(line.c_str(), selected == i)) selected = i;
            }
        }
        ImGui::EndListBox();
    }
    if (selected >= 0 && std::size_t(selected) < scene.objects.size()) objectEditor(scene, answer, selected);
}

void warningSection(const Shown& shown, Answer& answer)
{
    const std::vector<std::string>& warnings = shown.window.warnings;
    const std::string title = fmt::format("Warnings ({})###Warnings", warnings.size());
    if (!ImGui::CollapsingHeader(title.c_str())) return;
    for (std::size_t i = 0; i < warnings.size(); ++i) {
        ImGui::PushID(int(i));
        ImGui::Bullet();
        const ImVec2 size = ImGui::CalcTextSize(warnings[i].c_str(), nullptr, false, ImGui::GetContentRegionAvail().x);
        const ImVec2 at = ImGui::GetCursorPos();
        if (ImGui::Selectable("##warning", false, 0, ImVec2(0.0f, size.y)))
            answer.requests.emplace_back(ShowSubject{i});
        ImGui::SetCursorPos(at);
        ImGui::TextWrapped("%s", warnings[i].c_str());
        ImGui::PopID();
    }
}

} // namespace halflight::view
