#include "scene/format/recorded_origin.h"

#include "scene/model/origin.h"

namespace halflight {

Result<glm::dvec3> recordedOrigin(const SourceDocument& document)
{
    const Json& json = member(extensionOf(document.json, "HALFLIGHT_mixed_lighting"), "origin");
    glm::dvec3 origin(0.0);
    if (json.is_null()) return origin;
    bool good = json.is_array() && json.size() == 3;
    for (std::size_t c = 0; good && c < 3; ++c) {
        good = json[c].is_number();
        if (good) origin[int(c)] = json[c].get<double>();
    }
    if (!good || tooFar(origin, 2.0 * kFarthestFromWorldMeters))
        return invalid("/extensions/HALFLIGHT_mixed_lighting", "origin is not three numbers within 33554 km");
    return origin;
}

} // namespace halflight
