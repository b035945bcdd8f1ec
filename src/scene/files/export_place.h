#pragma once
// Where an exported surface has its texels.

#include "halflight/base/math.h"

#include <compare>
#include <tuple>

namespace halflight {

struct ExportPlace {
    int page = 0;
    int texCoord = 1;
    vec2 scale{1.0f};
    vec2 offset{0.0f};
    bool skinned = false;

    auto operator<=>(const ExportPlace& o) const { return key() <=> o.key(); }
    bool operator==(const ExportPlace& o) const { return key() == o.key(); }

private:
    [[nodiscard]] std::tuple<int, int, float, float, float, float, bool> key() const
    {
        return {page, texCoord, scale.x, scale.y, offset.x, offset.y, skinned};
    }
};

} // namespace halflight
