#pragma once
// When two bakes have the same bytes.

#include "halflight/scene/baked_scene.h"

#include <gtest/gtest.h>

#include <cstddef>

namespace halflight::test {

/// Lightmaps, masks, light probes, light groups and reflection probes.
inline void expectSameBakes(const BakedScene& a, const BakedScene& b)
{
    ASSERT_EQ(a.lightmaps.size(), b.lightmaps.size());
    for (std::size_t i = 0; i < a.lightmaps.size(); ++i) EXPECT_EQ(a.lightmaps[i].texels(), b.lightmaps[i].texels());
    ASSERT_EQ(a.shadowmasks.size(), b.shadowmasks.size());
    for (std::size_t i = 0; i < a.shadowmasks.size(); ++i)
        EXPECT_EQ(a.shadowmasks[i].texels(), b.shadowmasks[i].texels());
    ASSERT_EQ(a.probes.probes.size(), b.probes.probes.size());
    for (std::size_t i = 0; i < a.probes.probes.size(); ++i) {
        EXPECT_EQ(a.probes.probes[i].radiance, b.probes.probes[i].radiance);
        EXPECT_EQ(a.probes.probes[i].occlusion, b.probes.probes[i].occlusion);
    }
    ASSERT_EQ(a.groups.size(), b.groups.size());
    for (std::size_t g = 0; g < a.groups.size(); ++g) {
        EXPECT_EQ(a.groups[g].unitLux, b.groups[g].unitLux);
        ASSERT_EQ(a.groups[g].lightmaps.size(), b.groups[g].lightmaps.size());
        for (std::size_t i = 0; i < a.groups[g].lightmaps.size(); ++i)
            EXPECT_EQ(a.groups[g].lightmaps[i].texels(), b.groups[g].lightmaps[i].texels());
        ASSERT_EQ(a.groups[g].directions.size(), b.groups[g].directions.size());
        for (std::size_t i = 0; i < a.groups[g].directions.size(); ++i)
            EXPECT_EQ(a.groups[g].directions[i].texels(), b.groups[g].directions[i].texels());
        EXPECT_EQ(a.groups[g].radiance, b.groups[g].radiance);
    }
    EXPECT_EQ(a.reflections.probes.size(), b.reflections.probes.size());
    EXPECT_EQ(a.reflections.picture.texels(), b.reflections.picture.texels());
}

} // namespace halflight::test
