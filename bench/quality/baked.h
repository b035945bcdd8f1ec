#pragma once
// A baked scene as a renderer reads it: encoded pages decoded again, filtered at points of surfaces.

#include "halflight/bake/bake.h"

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace halflight::quality {

struct Baked {
    BakeResult result;
    BakeGeometry geometry;
    int pageSize = 0;
    std::vector<ImageRgb32f> lightmaps; ///< lux
    std::vector<ImageRgba32f> masks;    ///< 0…1

    /// Values at a place in texels, as a sampler that clamps to the edge gives them.
    [[nodiscard]] vec3 light(int page, vec2 texel) const;
    [[nodiscard]] vec3 lightBicubic(int page, vec2 texel) const;
    /// Attenuation, decoded for a picture much finer than the texels.
    [[nodiscard]] float mask(int page, vec2 texel, int channel) const;
};

Result<Baked> bakeFile(const std::filesystem::path& file, const BakeSettings& settings);

/// A point of a lightmapped surface.
struct SurfaceSample {
    uint32_t triangle = 0;
    int object = 0;
    int page = 0;
    vec2 texel{0.0f};
    vec3 position{0.0f};
    vec3 normal{0.0f}; ///< interpolated
    vec3 geometricNormal{0.0f};
};

/// Calls visit for points spread over every lightmapped triangle, some eight to a texel, its corners and edges among
/// them.
void forSurface(const Baked& baked, const std::function<void(const SurfaceSample&)>& visit);

} // namespace halflight::quality
