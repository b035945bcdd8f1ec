#include "halflight/render/frame.h"

namespace halflight {

const char* nameOf(RunMode mode)
{
    constexpr const char* kNames[] = {"realtime", "baked-indirect", "shadowmask", "distance-shadowmask", "subtractive"};
    return kNames[int(mode)];
}

const char* nameOf(ShadowFilter filter)
{
    constexpr const char* kNames[] = {"hard", "pcf", "soft"};
    return kNames[int(filter)];
}

const char* nameOf(CascadeBlend blend)
{
    constexpr const char* kNames[] = {"hard", "dithered", "soft"};
    return kNames[int(blend)];
}

} // namespace halflight
