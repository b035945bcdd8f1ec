#include "view/state/view_state.h"

#include <cctype>

namespace halflight::view {
namespace {

/// Where a name is in a text, with no letter or digit beside it; npos: nowhere.
std::size_t placeOf(const std::string& name, const std::string& text)
{
    const auto isWord = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; };
    if (name.empty()) return std::string::npos;
    for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name, at + 1)) {
        const std::size_t end = at + name.size();
        if ((at == 0 || !isWord(text[at - 1])) && (end == text.size() || !isWord(text[end]))) return at;
    }
    return std::string::npos;
}

} // namespace

Subject subjectOf(const std::string& text, const Scene& scene)
{
    Subject subject;
    std::size_t first = std::string::npos;
    std::size_t longest = 0;
    const auto consider = [&](const std::string& name, const Subject& named) {
        const std::size_t place = placeOf(name, text);
        if (place == std::string::npos || place > first || (place == first && name.size() <= longest)) return;
        first = place;
        longest = name.size();
        subject = named;
    };
    for (std::size_t i = 0; i < scene.objects.size(); ++i) consider(scene.objects[i].name, {int(i), -1});
    for (std::size_t i = 0; i < scene.lights.size(); ++i) consider(scene.lights[i].name, {-1, int(i)});
    return subject;
}

const char* legendOf(DebugView view)
{
    constexpr const char* kLegends[] = {
        "The picture.",
        "Baked attenuation of channels 0, 1, 2 as red, green, blue: bright is lit. "
        "Half as bright where channel 3 is in shadow.",
        "Irradiance of the lightmap, as a white wall would show it.",
        "Light of the probes on every surface.",
        "Cascades of directional lights: the nearest is red, then green, blue, yellow.",
        "Where realtime shadows end: black within the shadow distance, white beyond.",
        "Lights with a mask channel, or for which none was left: none black, 1 blue, 2 green, 3 yellow, 4 red, "
        "more white.",
        "A square is a lightmap texel. Texels per metre: 1 or fewer blue, 4 cyan, 16 green, 64 yellow, "
        "256 or more red; black: no lightmap."};
    return kLegends[int(view)];
}

RenderSettings settingsOfFrame(const ViewState& state, const std::vector<Bounds>& bounds, ivec2 size)
{
    RenderSettings settings = state.settings;
    settings.size = size;
    if (state.followsShadowDistance)
        settings.shadows = shadowsReaching(farthestInView({state.navigator.camera(), size}, bounds), settings.shadows);
    return settings;
}

} // namespace halflight::view
