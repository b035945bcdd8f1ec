#pragma once
// Numbers as JSON, for what commands print.

#include "halflight/base/math.h"

#include <nlohmann/json.hpp>

namespace halflight::cli {

using Json = nlohmann::ordered_json; // members stay in the order they are written in

inline Json jsonArray(const dvec3& v)
{
    return Json::array({v.x, v.y, v.z});
}

inline Json jsonArray(vec3 v)
{
    return Json::array({v.x, v.y, v.z});
}

} // namespace halflight::cli
