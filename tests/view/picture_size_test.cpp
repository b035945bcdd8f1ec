// Which resolution a frame is drawn at.
#include "view/state/picture_size.h"

#include <gtest/gtest.h>

namespace halflight::view::picture_size_test {
namespace {

constexpr ivec2 kWindow(1280, 720);
constexpr auto kCoarse = PictureDetail::Coarse;
constexpr auto kHalf = PictureDetail::Half;
constexpr auto kFull = PictureDetail::Full;
constexpr auto kMoves = Motion::Moves;
constexpr auto kPauses = Motion::Pauses;
constexpr auto kRests = Motion::Rests;

/// Draws a frame that takes so long for each detail.
PictureDetail draw(PictureDetails& details, Motion motion, PictureDetail finest, double coarse, double half,
                   double full)
{
    const PictureDetail detail = details.next(kWindow, motion, finest);
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
    const auto slow = [&](Motion motion, PictureDetail finest) { return draw(details, motion, finest, 0.2, 0.6, 2.0); };
    EXPECT_EQ(slow(kRests, kFull), kCoarse) << "the first";
    EXPECT_EQ(slow(kRests, kFull), kHalf);
    EXPECT_EQ(slow(kRests, kFull), kFull);
    EXPECT_EQ(slow(kRests, kFull), kFull);
    EXPECT_EQ(slow(kMoves, kFull), kCoarse) << "the view moves";
    EXPECT_EQ(slow(kMoves, kFull), kCoarse);
    EXPECT_EQ(slow(kPauses, kFull), kCoarse) << "between two keys";
    for (int i = 0; i < 3; ++i) EXPECT_EQ(slow(kRests, kHalf), kHalf) << "a bake needs the processor";
    EXPECT_EQ(slow(kRests, kFull), kFull) << "it has ended";
    details.forget();
    EXPECT_EQ(slow(kRests, kFull), kCoarse) << "another scene";
}

TEST(PictureDetails, MovesAtTheFinestDetailThatIsNotSlow)
{
    PictureDetails details;
    for (int i = 0; i < 3; ++i) (void)draw(details, kRests, kFull, 0.05, 0.2, 0.7);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(draw(details, kMoves, kFull, 0.05, 0.2, 0.7), kHalf);
    EXPECT_EQ(draw(details, kPauses, kFull, 0.05, 0.2, 0.7), kHalf);
    EXPECT_EQ(draw(details, kRests, kFull, 0.05, 0.2, 0.7), kFull);
    EXPECT_EQ(draw(details, kPauses, kFull, 0.05, 0.2, 0.7), kFull) << "it is there";
}

TEST(PictureDetails, AreFullOnAFastDeviceButForTheFirst)
{
    PictureDetails details;
    EXPECT_TRUE(details.wantsTime());
    EXPECT_EQ(draw(details, kRests, kHalf, 0.002, 0.004, 0.01), kCoarse);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(draw(details, i > 0 ? kMoves : kRests, kHalf, 0.002, 0.004, 0.01), kFull);
    EXPECT_FALSE(details.wantsTime()) << "frames overlap";
}

TEST(PictureDetails, AFirstPictureDrawnBeforeCounts)
{
    PictureDetails details;
    details.drew(0.2); // on the thread that opens a file; the first frame shows that picture
    EXPECT_EQ(details.next(kWindow, kRests, kHalf), kCoarse);
    EXPECT_EQ(details.next(kWindow, kRests, kHalf), kHalf) << "a full one would take seconds";
}

} // namespace
} // namespace halflight::view::picture_size_test
