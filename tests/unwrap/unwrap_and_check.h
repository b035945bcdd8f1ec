#pragma once
// Unwraps a scene and judges the result by brute force.

#include "atlas_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

namespace halflight::unwrap_test {

inline UnwrappedScene unwrapAndCheck(const Scene& scene, const UnwrapSettings& settings = {})
{
    Result<UnwrappedScene> result = unwrap(scene, settings);
    EXPECT_TRUE(result) << (result ? "" : result.error().text());
    if (!result) return {};
    const AtlasCheck check = checkAtlas(*result, settings.paddingTexels);
    EXPECT_EQ(check.fault, "");
    EXPECT_EQ(checkMeshes(scene, *result), "");
    return std::move(*result);
}

/// Texels of an object's triangles, in float as a renderer has them.
inline double texelAreaOf(const UnwrappedScene& result, std::size_t object)
{
    const Object& o = result.scene.objects[object];
    double sum = 0.0;
    for (const MeshPart& part : result.scene.meshes[std::size_t(o.mesh)].parts) {
        for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
            glm::dvec2 c[3];
            for (std::size_t k = 0; k < 3; ++k) {
                c[k] = glm::dvec2(o.lightmap.scale * part.lightmapUv[part.indices[i + k]] + o.lightmap.offset) *
                       double(result.pageSize);
            }
            sum += 0.5 * std::abs((c[1].x - c[0].x) * (c[2].y - c[0].y) - (c[1].y - c[0].y) * (c[2].x - c[0].x));
        }
    }
    return sum;
}

} // namespace halflight::unwrap_test
