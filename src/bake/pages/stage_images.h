#pragma once
// Files of BakeSettings::imagesDirectory. Without a directory the functions do nothing.

#include "halflight/bake/bake.h"
#include "halflight/base/file_group.h"
#include "halflight/base/image.h"

#include <string>
#include <vector>

namespace halflight {

/// Adds pages as PREFIX_0.exr, PREFIX_1.exr, …
Status dumpPages(const BakeSettings& settings, const std::string& prefix, const std::vector<ImageRgb32f>& pages,
                 FileGroup& files);

/// Adds masks and directions as PNG, and probes as JSON.
Status dumpResult(const BakeSettings& settings, const BakedScene& baked, FileGroup& files);

} // namespace halflight
