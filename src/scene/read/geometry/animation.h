#pragma once
// What a file's animations change: through glTF's own targets and through KHR_animation_pointer.

#include "scene/document/document.h"

#include <map>
#include <set>

namespace halflight {

struct AnimatedThings {
    std::vector<bool> movedNodes;   ///< by node: translation, rotation, scale or visibility
    std::vector<bool> morphedNodes; ///< by node: weights, its own or its mesh's
    /// By index in the file: the members of lights and materials, such as "intensity" or "emissiveFactor".
    std::map<int, std::set<std::string>> lights;     ///< of KHR_lights_punctual
    std::map<int, std::set<std::string>> areaLights; ///< of EXT_lights_area
    std::map<int, std::set<std::string>> materials;
};

AnimatedThings animatedThings(const SourceDocument& document);

} // namespace halflight
