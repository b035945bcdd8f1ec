// Which resolution a frame is drawn at.
#include "view/picture_size.h"

#include <gtest/gtest.h>

namespace halflight::view {
namespace {

constexpr ivec2 kWindow(1280, 720);
constexpr auto kCoarse = PictureDetail::Coarse;
constexpr auto kHalf = PictureDetail::Half;
constexpr auto kFull = PictureDetail::Full;

/// Draws a frame that takes so long for each detail.
PictureDetail draw(PictureDetails& details, bool moves, PictureDetail finest, double coarse, double half, double full)
{
    const PictureDetail detail = details.next(kWindow, moves, finest);
    details.drew(detail == kCoarse ? coarse : detail == kHalf ? half : full);
    return detail;
}

TEST(PictureSize, IsAShareOfTheWindow)
{
    EXPECT_EQ(pictureSize(kWindow, kFull), kWindow);
    EXPECT_EQ(pictureSize(kWindow, kHalf), ivec2(640, 360));
    EXPECT_EQ(pictureSize(kWindow, kCoarse), ivec2(320, 180));
    EXPECT_EQ(pictureSize(ivec2(200, 300), kCoarse), ivec2(200, 300)) << "small windows";
    EXPECT_EQ(pictureSize(ivec2(5000, 1), kCoarse), ivec2(320, 1));
}

TEST(PictureDetails, GetFinerWhileTheViewRestsOnASlowDevice)
{
    PictureDetails details;
    const auto slow = [&](bool moves, PictureDetail finest) { return draw(details, moves, finest, 0.2, 0.6, 2.0); };
    EXPECT_EQ(slow(false, kFull), kCoarse) << "the first";
    EXPECT_EQ(slow(false, kFull), kHalf);
    EXPECT_EQ(slow(false, kFull), kFull);
    EXPECT_EQ(slow(false, kFull), kFull);
    EXPECT_EQ(slow(true, kFull), kCoarse) << "the view moves";
    EXPECT_EQ(slow(true, kFull), kCoarse);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(slow(false, kHalf), kHalf) << "a bake needs the processor";
    EXPECT_EQ(slow(false, kFull), kFull) << "it has ended";
    details.forget();
    EXPECT_EQ(slow(false, kFull), kCoarse) << "another scene";
}

TEST(PictureDetails, MovesAtTheFinestDetailThatIsNotSlow)
{
    PictureDetails details;
    for (int i = 0; i < 3; ++i) (void)draw(details, false, kFull, 0.05, 0.2, 0.7);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(draw(details, true, kFull, 0.05, 0.2, 0.7), kHalf);
    EXPECT_EQ(draw(details, false, kFull, 0.05, 0.2, 0.7), kFull);
}

TEST(PictureDetails, AreFullOnAFastDeviceButForTheFirst)
{
    PictureDetails details;
    EXPECT_TRUE(details.wantsTime());
    EXPECT_EQ(draw(details, false, kHalf, 0.002, 0.004, 0.01), kCoarse);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(draw(details, i > 0, kHalf, 0.002, 0.004, 0.01), kFull);
    EXPECT_FALSE(details.wantsTime()) << "frames overlap";
}

TEST(PictureDetails, AFirstPictureDrawnBeforeCounts)
{
    PictureDetails details;
    details.drew(0.2); // on the thread that opens a file; the first frame shows that picture
    EXPECT_EQ(details.next(kWindow, false, kHalf), kCoarse);
    EXPECT_EQ(details.next(kWindow, false, kHalf), kHalf) << "a full one would take seconds";
}

} // namespace
} // namespace halflight::view
