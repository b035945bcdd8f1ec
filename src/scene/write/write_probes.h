#pragma once
#include "scene/document/patcher.h"

#include "halflight/scene/baked_scene.h"

namespace halflight {

/// `probes` of the root extension, its accessors added to the document; null without probes. `bytes` receives
/// their size.
Json probesJson(DocumentPatcher& patcher, const ProbeSet& set, int maskLayers, uint64_t& bytes);

/// `grid` of probes on a regular one whose first probe is at `origin`; null of a list.
Json gridJson(const ProbeSet& set, dvec3 origin);

} // namespace halflight
