#pragma once
// Lights of a file before any setting: KHR_lights_punctual, EXT_lights_area, and nodes that settings make an area
// light.

#include "scene/read/geometry/nodes.h"

namespace halflight {

struct FileLight {
    Light light;
    const Json* json = nullptr; ///< the extension's light, whose extras count; null where the node alone has the light
    std::string path;           ///< of `json`
    int index = -1;             ///< in the extension's list
};

/// The light on a node; nothing where it has none, or one that cannot shine (with a warning).
Result<std::optional<FileLight>> lightOfNode(const SourceDocument& document, const NodeState& state,
                                             std::vector<std::string>& warnings);

/// Light::sizeMeters of a light of EXT_lights_area, whose numbers have been checked.
vec2 areaLightSize(const Json& light, float sourceScale);

/// A number of a light's JSON, if it is there; an error where it is none or out of range.
Status readNumber(const Json& object, const char* key, float low, float high, const std::string& path, float& out);

} // namespace halflight
