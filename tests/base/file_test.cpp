#include "base/temp_folder.h"
#include "halflight/base/file.h"

#include <cstring>
#include <gtest/gtest.h>

namespace halflight {
namespace {

using test::TempFolder;

std::string textOf(const std::filesystem::path& path)
{
    const auto bytes = readFile(path);
    return bytes ? std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size())
                 : "(" + bytes.error().message + ")";
}

TEST(File, RoundTripOfAnyBytes)
{
    const TempFolder folder;
    std::string bytes;
    for (int i = 0; i < 100000; ++i) bytes.push_back(char(i * 31));
    ASSERT_TRUE(writeFileAtomically(folder / "a.bin", bytes));
    EXPECT_EQ(textOf(folder / "a.bin"), bytes);
    ASSERT_TRUE(writeFileAtomically(folder / "empty", ""));
    EXPECT_EQ(textOf(folder / "empty"), "");
}

TEST(File, ReplacesWholeAndLeavesNothingBehind)
{
    const TempFolder folder;
    ASSERT_TRUE(writeFileAtomically(folder / "a", "a long first version"));
    ASSERT_TRUE(writeFileAtomically(folder / "a", "second"));
    EXPECT_EQ(textOf(folder / "a"), "second");
    EXPECT_EQ(folder.fileCount(), 1u) << "no temporary file stays";
}

TEST(File, FailedWriteLeavesTheOldFile)
{
    const TempFolder folder;
    // A folder in the target's place: the rename fails after the bytes were written.
    std::filesystem::create_directories(folder / "taken");
    ASSERT_TRUE(writeFileAtomically((folder / "taken") / "inside", "kept"));
    const Status status = writeFileAtomically(folder / "taken", "new");
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, ErrorCode::WriteFailed);
    EXPECT_EQ(textOf((folder / "taken") / "inside"), "kept");
    EXPECT_EQ(folder.fileCount(), 1u) << "no temporary file stays";
}

TEST(File, UnwritableFolderIsAnError)
{
    const TempFolder folder;
    const Status status = writeFileAtomically((folder / "missing") / "a", "x");
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, ErrorCode::WriteFailed);
    EXPECT_FALSE(status.error().message.empty());
}

TEST(File, MissingFileAndFolderAreErrors)
{
    const TempFolder folder;
    const auto missing = readFile(folder / "nothing");
    ASSERT_FALSE(missing);
    EXPECT_EQ(missing.error().code, ErrorCode::FileNotFound);
    std::filesystem::create_directories(folder / "sub");
    const auto isFolder = readFile(folder / "sub");
    ASSERT_FALSE(isFolder);
    EXPECT_EQ(isFolder.error().code, ErrorCode::FileNotFound);
}

TEST(Error, TextNamesTheObject)
{
    EXPECT_EQ((Error{ErrorCode::FileInvalid, "is odd", "/meshes/3"}).text(), "/meshes/3: is odd");
    EXPECT_EQ((Error{ErrorCode::FileInvalid, "is odd", ""}).text(), "is odd");
}

} // namespace
} // namespace halflight
