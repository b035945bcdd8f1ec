// What a warning names.
#include "view/state/view_state.h"

#include <gtest/gtest.h>

namespace halflight::view::view_state_test {
namespace {

TEST(SubjectOf, IsTheFirstNameInTheText)
{
    Scene scene;
    scene.lights.emplace_back().name = "sun";
    for (const char* name : {"Door", "Door frame", "D", ""}) scene.objects.emplace_back().name = name;
    EXPECT_EQ(subjectOf("the light sun overlaps four others", scene).light, 0);
    EXPECT_EQ(subjectOf("the Door is closed", scene).object, 0);
    EXPECT_EQ(subjectOf("'Door frame' has no texels", scene).object, 1) << "the longest there";
    EXPECT_EQ(subjectOf("the light sun overlaps Door frame and D", scene).light, 0);
    EXPECT_EQ(subjectOf("D and Door frame overlap", scene).object, 2);
    EXPECT_EQ(subjectOf("Doors and sunshine", scene).object, -1) << "no whole word";
    EXPECT_EQ(subjectOf("Doors and sunshine", scene).light, -1);
}

} // namespace
} // namespace halflight::view::view_state_test
