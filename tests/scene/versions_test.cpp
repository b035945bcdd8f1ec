// Files of other versions of the format are refused, each with its cure.
#include "fixtures.h"

#include <gmock/gmock.h>

namespace halflight::versions_test {
namespace {

using namespace test;

Error errorOfVersion(const Json& version)
{
    const TemporaryFolder folder;
    EXPECT_TRUE(writeBakedScene(folder / "baked.glb", pretendToBake(engineScene(), false)));
    std::vector<char> binary;
    Json json = jsonOfGlb(folder / "baked.glb", &binary);
    json["extensions"]["HALFLIGHT_mixed_lighting"]["version"] = version;
    json["buffers"][0]["uri"] = "binary.bin";
    writeText(folder / "binary.bin", std::string(binary.begin(), binary.end()));
    writeText(folder / "other.gltf", json.dump());
    const Result<BakedScene> read = readBakedScene(folder / "other.gltf");
    return read ? Error{} : read.error();
}

TEST(Versions, OldFilesAreRefusedWithTheirCure)
{
    // A bake of assets/tests/penumbra.glb by the last program that wrote version 1.
    const auto read = readBakedScene(std::filesystem::path(HALFLIGHT_SOURCE_DIR) / "assets/tests/format_v1.glb");
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error().code, ErrorCode::Unsupported);
    EXPECT_THAT(read.error().message, testing::HasSubstr("was written by an old version of this program: bake again"));
    EXPECT_THAT(errorOfVersion(1).message, testing::HasSubstr("bake again"));
}

TEST(Versions, NewerFilesAreRefused)
{
    const Error error = errorOfVersion(4);
    EXPECT_EQ(error.code, ErrorCode::Unsupported);
    EXPECT_THAT(error.message, testing::HasSubstr("newer version"));
}

} // namespace
} // namespace halflight::versions_test
