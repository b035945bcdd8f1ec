#include "halflight/render/renderer.h"

namespace halflight {

const char* nameOf(ToneMapping toneMapping)
{
    constexpr const char* kNames[] = {"neutral", "aces", "agx", "none"};
    return kNames[int(toneMapping)];
}

const char* nameOf(DebugView view)
{
    constexpr const char* kNames[] = {"lit",      "shadowmask", "lightmap", "probes",
                                      "cascades", "fade",       "overlap",  "texels"};
    return kNames[int(view)];
}

const char* nameOf(RenderPath path)
{
    return path == RenderPath::Forward ? "forward" : "deferred";
}

} // namespace halflight
