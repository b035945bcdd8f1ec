#include "base/temp_folder.h"
#include "halflight/base/file.h"
#include "halflight/base/image.h"

#include <cstring>
#include <gtest/gtest.h>
#include <sys/stat.h>

namespace halflight::file_test {
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
    std::filesystem::create_directories(folder / "taken");
    ASSERT_TRUE(writeFileAtomically((folder / "taken") / "inside", "kept"));
    const Status status = writeFileAtomically(folder / "taken", "new");
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, ErrorCode::WriteFailed);
    EXPECT_EQ(textOf((folder / "taken") / "inside"), "kept");
    EXPECT_EQ(folder.fileCount(), 1u) << "no temporary file stays";
}

TEST(File, WriterThatFailsLeavesTheOldFile)
{
    const TempFolder folder;
    ASSERT_TRUE(writeFileAtomically(folder / "a", "kept"));
    const Status status = replaceAtomically(folder / "a", [](const std::filesystem::path& temporary) -> Status {
        EXPECT_TRUE(writeFileAtomically(temporary, "half of"));
        return Error{ErrorCode::WriteFailed, "ran out"};
    });
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().message, "ran out");
    EXPECT_EQ(textOf(folder / "a"), "kept");
    EXPECT_EQ(folder.fileCount(), 1u) << "no temporary file stays";
}

TEST(File, OnlyRegularFilesAreReplaced)
{
    const TempFolder folder;
    const std::filesystem::path pipe = folder / "pipe";
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    std::filesystem::create_symlink("pipe", folder / "link.exr");
    const Status statuses[] = {writeFileAtomically(pipe, "x"), writeFileAtomically(folder / "link.exr", "x"),
                               writeExr(pipe, ImageRgb32f(2, 2)), writeExr(folder / "link.exr", ImageRgba32f(2, 2)),
                               writePng(pipe, ImageRgba8(2, 2))};
    for (const Status& status : statuses) {
        ASSERT_FALSE(status);
        EXPECT_EQ(status.error().code, ErrorCode::WriteFailed);
        EXPECT_NE(status.error().message.find("pipe"), std::string::npos) << status.error().message;
    }
    EXPECT_TRUE(std::filesystem::is_fifo(std::filesystem::symlink_status(pipe)));
    EXPECT_TRUE(std::filesystem::is_symlink(folder / "link.exr"));
    EXPECT_EQ(folder.fileCount(), 2u) << "no temporary file stays";
}

TEST(File, SymbolicLinksStayAndTheirTargetsAreReplaced)
{
    const TempFolder folder;
    std::filesystem::create_directories(folder / "sub");
    const std::filesystem::path target = (folder / "sub") / "target";
    ASSERT_TRUE(writeFileAtomically(target, "old"));
    std::filesystem::create_symlink("sub/target", folder / "relative");
    std::filesystem::create_symlink(folder / "relative", folder / "absolute"); // a link to a link
    for (const char* link : {"relative", "absolute"}) {
        ASSERT_TRUE(writeFileAtomically(folder / link, std::string("by ") + link));
        EXPECT_TRUE(std::filesystem::is_symlink(folder / link));
        EXPECT_EQ(textOf(target), std::string("by ") + link);
    }
    ASSERT_TRUE(writeExr(folder / "relative", ImageRgb32f(3, 2)));
    EXPECT_TRUE(std::filesystem::is_symlink(folder / "relative"));
    const auto image = readExr(target);
    ASSERT_TRUE(image) << image.error().message;
    EXPECT_EQ(image->size(), ivec2(3, 2));

    std::filesystem::create_symlink("sub/new", folder / "dangling");
    ASSERT_TRUE(writeFileAtomically(folder / "dangling", "made"));
    EXPECT_TRUE(std::filesystem::is_symlink(folder / "dangling"));
    EXPECT_EQ(textOf((folder / "sub") / "new"), "made");

    std::filesystem::create_symlink("loop", folder / "loop");
    const Status loop = writeFileAtomically(folder / "loop", "x");
    ASSERT_FALSE(loop);
    EXPECT_NE(loop.error().message.find("symbolic link"), std::string::npos) << loop.error().message;
    EXPECT_EQ(folder.fileCount(), 5u) << "no temporary file stays";
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

TEST(File, PipesAreNotWaitedFor)
{
    const TempFolder folder;
    ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
    const auto pipe = readFile(folder / "pipe"); // opening it would wait for a writer
    ASSERT_FALSE(pipe);
    EXPECT_NE(pipe.error().message.find("pipe"), std::string::npos) << pipe.error().message;
}

TEST(Error, TextNamesTheObject)
{
    EXPECT_EQ((Error{ErrorCode::FileInvalid, "is odd", "/meshes/3"}).text(), "/meshes/3: is odd");
    EXPECT_EQ((Error{ErrorCode::FileInvalid, "is odd", ""}).text(), "is odd");
}

} // namespace
} // namespace halflight::file_test
