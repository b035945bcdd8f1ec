// The scenes of assets/quality/ keep the limits of docs/quality.md (bench_quality prints the same figures).

#include "quality/measures.h"

#include <gtest/gtest.h>

namespace halflight::quality::quality_test {
namespace {

const std::filesystem::path kAssets = std::filesystem::path(HALFLIGHT_SOURCE_DIR) / "assets";

void expectMet(const Figures& figures)
{
    ASSERT_FALSE(figures.empty());
    for (const Figure& f : figures) {
        EXPECT_LE(f.value, f.limit) << f.scene << ": " << f.what;
    }
}

TEST(QualityS6, ClosedRoomsStayDark)
{
    expectMet(measureLeaks(kAssets));
}

TEST(QualityS6, NoRimsWhateverTheFilter)
{
    expectMet(measureEdges(kAssets));
}

TEST(QualityS6, SeamsAreNotSeen)
{
    expectMet(measureSeams(kAssets));
}

TEST(QualityS6, JointsOfTilesAreNotSeen)
{
    expectMet(measureTiles(kAssets));
}

TEST(QualityS8, PenumbraIsTheAnalyticOne)
{
    expectMet(measurePenumbra(kAssets));
}

TEST(QualityS8, HardEdgesAreSharp)
{
    expectMet(measureMaskEdges(kAssets));
}

TEST(QualityS8, NothingShadowsItself)
{
    expectMet(measureTerminator(kAssets));
}

TEST(QualityS6, DenoisingKeepsContactShadows)
{
    expectMet(measureContact(kAssets, 512));
}

TEST(QualityS14, ProbesDoNotSeeThroughWalls)
{
    expectMet(measureProbes(kAssets));
}

} // namespace
} // namespace halflight::quality::quality_test
