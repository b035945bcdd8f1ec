#include "base/temp_folder.h"
#include "halflight/base/file.h"
#include "halflight/base/files_in_use.h"

#include <filesystem>
#include <gtest/gtest.h>

namespace halflight::files_in_use_test {
namespace {

namespace fs = std::filesystem;
using test::TempFolder;

std::string answer(const FilesInUse& files)
{
    fs::path culprit;
    const Status status = files.check(culprit);
    return status ? "" : culprit.filename().string() + ": " + status.error().message;
}

TEST(FilesInUse, OneFileHasManyNames)
{
    const TempFolder folder;
    ASSERT_TRUE(writeFileAtomically(folder / "read", "text"));
    fs::create_symlink("read", folder / "link");
    fs::create_hard_link(folder / "read", folder / "hard");
    fs::create_directory(folder / "sub");
    fs::create_directory_symlink(folder / "sub" / "..", folder / "around");
    for (const fs::path& name :
         {fs::path("read"), fs::path("link"), fs::path("hard"), fs::path("sub/../read"), fs::path("around/link")}) {
        FilesInUse files;
        files.reads("the scene", folder / "read");
        files.writes("--report", folder / name);
        EXPECT_EQ(answer(files), name.filename().string() + ": --report would replace the scene") << name;
    }
    FilesInUse files;
    files.reads("the scene", folder / "read");
    files.writes("--report", folder / "new");
    EXPECT_EQ(answer(files), "");
}

TEST(FilesInUse, FilesThatAreYetToBeMade)
{
    const TempFolder folder;
    fs::create_symlink("later", folder / "link");
    FilesInUse files;
    files.writes("--output", folder / "later");
    files.writes("--report", folder / "link");
    EXPECT_EQ(answer(files), "link: --report would replace --output");
}

TEST(FilesInUse, NumberedNames)
{
    const TempFolder folder;
    const std::vector<FileNames> names = {{"out_", true, ".exr"}, {"out_image_", true, {}}, {"list.json", false, ""}};
    for (const auto& [name, counts] : {std::pair{"out_0.exr", true},
                                       {"out_12.exr", true},
                                       {"out_.exr", false},
                                       {"out_1b.exr", false},
                                       {"out_1.png", false},
                                       {"out_image_7.jpg", true},
                                       {"out_image_7", false},
                                       {"out_image_7.old.png", false},
                                       {"list.json", true},
                                       {"list.json.bak", false},
                                       {"my_out_0.exr", false}}) {
        ASSERT_TRUE(writeFileAtomically(folder / name, name));
        FilesInUse files;
        files.reads("the sky", folder / name);
        files.writesIn("--images", folder / ".", names);
        EXPECT_EQ(answer(files), counts ? std::string(name) + ": --images would replace the sky" : "") << name;
        FilesInUse outputs;
        fs::remove(folder / name);
        outputs.writes("--report", folder / name);
        outputs.writesIn("--images", folder / ".", names);
        EXPECT_EQ(answer(outputs), counts ? std::string(name) + ": --images would replace --report" : "") << name;
    }
}

TEST(FilesInUse, NamesInAnotherCaseAreOthersWhereTheSystemSaysSo)
{
    const TempFolder folder;
    ASSERT_TRUE(writeFileAtomically(folder / "OUT_0.EXR", "text"));
    FilesInUse files;
    files.reads("the sky", folder / "OUT_0.EXR");
    files.writesIn("--images", folder / ".", {{"out_", true, ".exr"}});
    const bool isOne = fs::exists(folder / "out_0.exr");
    EXPECT_EQ(answer(files), isOne ? "out_0.exr: --images would replace the sky" : "");
}

} // namespace
} // namespace halflight::files_in_use_test
