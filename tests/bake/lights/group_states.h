#pragma once
// Bakes with light groups and their states, in tests.

#include "bake/test_scene.h"

#include "halflight/bake/bake.h"
#include "halflight/base/rgb9e5.h"
#include "halflight/render/compose.h"
#include "halflight/scene/gltf.h"
#include "halflight/shading/color.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace halflight::test {

inline BakeResult bakeOf(Scene scene, const BakeSettings& settings)
{
    Result<BakeResult> result = bake(std::move(scene), settings, embreeIntegrators());
    EXPECT_TRUE(result) << (result ? "" : result.error().text());
    return std::move(*result);
}

inline std::size_t groupNamed(const BakedScene& baked, const std::string& name)
{
    for (std::size_t g = 0; g < baked.groups.size(); ++g)
        if (baked.groups[g].name == name) return g;
    ADD_FAILURE() << "no group " << name;
    return 0;
}

/// Pages of a bake without groups, lux.
inline std::vector<ImageRgb32f> pagesOf(const BakedScene& baked)
{
    std::vector<ImageRgb32f> pages;
    for (const Image<uint32_t>& page : baked.lightmaps) pages.push_back(decodeRgb9e5(page, baked.lightmapUnitLux));
    return pages;
}

inline double meanOf(const std::vector<ImageRgb32f>& pages)
{
    double sum = 0.0;
    double count = 0.0;
    for (const ImageRgb32f& page : pages) {
        for (const vec3 texel : page.texels()) {
            sum += double(luminance(texel));
            count += luminance(texel) > 0.0f ? 1.0 : 0.0;
        }
    }
    return sum / count;
}

/// Root mean square difference over the mean of `truth`.
inline double errorOf(const std::vector<ImageRgb32f>& pages, const std::vector<ImageRgb32f>& truth)
{
    double squares = 0.0;
    double count = 0.0;
    for (std::size_t p = 0; p < pages.size(); ++p) {
        for (std::size_t i = 0; i < pages[p].texelCount(); ++i) {
            const double off = double(luminance(pages[p].data()[i]) - luminance(truth[p].data()[i]));
            squares += off * off;
            count += luminance(truth[p].data()[i]) > 0.0f ? 1.0 : 0.0;
        }
    }
    return std::sqrt(squares / count) / meanOf(truth);
}

/// A state of a bake: its changes by name.
inline BakedScene stateOf(BakedScene baked, const std::vector<GroupWeight>& changes)
{
    const Result<std::vector<vec3>> weights = groupWeights(baked, changes);
    EXPECT_TRUE(weights);
    composeGroups(baked, *weights);
    return baked;
}

} // namespace halflight::test
