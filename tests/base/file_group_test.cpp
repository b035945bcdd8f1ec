#include "base/temp_folder.h"
#include "halflight/base/file.h"
#include "halflight/base/file_group.h"
#include "halflight/base/image.h"

#include <filesystem>
#include <gtest/gtest.h>

namespace halflight::file_group_test {
namespace {

namespace fs = std::filesystem;
using test::TempFolder;

std::string textOf(const fs::path& path)
{
    const auto bytes = readFile(path);
    return bytes ? std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size()) : "(none)";
}

TEST(FileGroup, AllFilesAtOnce)
{
    const TempFolder folder;
    ASSERT_TRUE(writeFileAtomically(folder / "a", "old"));
    {
        FileGroup group;
        ASSERT_TRUE(group.add(folder / "a", "new"));
        ASSERT_TRUE(group.add(folder / "b", "new too"));
        EXPECT_EQ(textOf(folder / "a"), "old");
        EXPECT_EQ(textOf(folder / "b"), "(none)");
        ASSERT_TRUE(group.commit());
    }
    EXPECT_EQ(textOf(folder / "a"), "new");
    EXPECT_EQ(textOf(folder / "b"), "new too");
    EXPECT_EQ(folder.fileCount(), 2u);
}

TEST(FileGroup, OneThatFailsLeavesAllAsTheyWere)
{
    const TempFolder folder;
    ASSERT_TRUE(writeFileAtomically(folder / "a", "old"));
    fs::create_directory(folder / "taken");
    {
        FileGroup group;
        ASSERT_TRUE(group.add(folder / "a", "new"));
        const Status status = group.add(folder / "taken", "new");
        ASSERT_FALSE(status);
        EXPECT_NE(status.error().message.find("taken is a folder"), std::string::npos) << status.error().message;
        EXPECT_FALSE(group.add(folder / "c", "after an error nothing is written"));
        EXPECT_FALSE(group.commit());
    }
    EXPECT_EQ(textOf(folder / "a"), "old");
    EXPECT_EQ(folder.fileCount(), 2u);
}

// The last one cannot take its name: a folder has come there since.
TEST(FileGroup, OneThatCannotBeRenamedLeavesNone)
{
    const TempFolder folder;
    {
        FileGroup group;
        ASSERT_TRUE(group.add(folder / "a", "new"));
        ASSERT_TRUE(group.add(folder / "b", "new"));
        fs::create_directory(folder / "b");
        EXPECT_FALSE(group.commit());
    }
    EXPECT_EQ(textOf(folder / "a"), "(none)");
    EXPECT_EQ(folder.fileCount(), 1u);
}

// Without a commit: a bake that was cancelled.
TEST(FileGroup, NothingStays)
{
    const TempFolder folder;
    {
        FileGroup group;
        ASSERT_TRUE(group.add(folder / "a.exr", [](const fs::path& temporary) {
            return writeExr(temporary, ImageRgb32f(4, 4, vec3(1.0f)));
        }));
    }
    EXPECT_EQ(folder.fileCount(), 0u);
}

} // namespace
} // namespace halflight::file_group_test
