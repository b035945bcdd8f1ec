#include "scene/write_reflections.h"

#include "scene/ktx2.h"

namespace halflight {

Json numbersOf(const mat4& matrix)
{
    Json json = Json::array();
    for (int i = 0; i < 16; ++i) json.push_back(matrix[i / 4][i % 4]);
    return json;
}

Result<Json> writeReflections(PictureWriter& pictures, const ReflectionSet& set, uint64_t& bytes)
{
    if (set.probes.empty()) return Json();
    auto encoded = encodeKtx2(set.picture);
    if (!encoded) return encoded.error();
    bytes = encoded->size();
    Json json = {{"picture", pictures.add("reflection probes", std::move(*encoded))},
                 {"unitNits", set.unitNits},
                 {"size", set.size}};
    for (const ReflectionProbe& probe : set.probes)
        json["probes"].push_back({{"position", numbers(probe.position)},
                                  {"box", numbersOf(probe.worldFromBox)},
                                  {"fade", probe.fadeMeters}});
    return json;
}

} // namespace halflight
