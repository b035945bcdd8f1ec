#include "scene/write/write_reflections.h"

namespace halflight {

Json numbersOf(const mat4& matrix)
{
    Json json = Json::array();
    for (int i = 0; i < 16; ++i) json.push_back(matrix[i / 4][i % 4]);
    return json;
}

Json reflectionsJson(const ReflectionSet& set, Json picture)
{
    Json json = {{"picture", std::move(picture)}, {"unitNits", set.unitNits}, {"size", set.size}};
    for (const ReflectionProbe& probe : set.probes)
        json["probes"].push_back({{"position", numbers(probe.position)},
                                  {"box", numbersOf(probe.worldFromBox)},
                                  {"fade", probe.fadeMeters}});
    return json;
}

} // namespace halflight
