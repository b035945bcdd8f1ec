// The readers' entry points over the seed corpus and deterministic mutations of it.

#include "fuzz/entry_points.h"
#include "halflight/shading/random.h"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <string>
#include <vector>

namespace halflight::test {

namespace {

struct Seed {
    std::string name;
    std::string bytes;
};

// An entry point has the files of its own folder; those of glTF are
// all small .glb files of assets/tests.
std::vector<Seed> seedsOf(const std::string& entry)
{
    const std::filesystem::path tests = std::filesystem::path(HALFLIGHT_SOURCE_DIR) / "assets/tests";
    std::vector<std::filesystem::path> files;
    const auto collect = [&](const std::filesystem::path& folder, const char* suffix) {
        for (const auto& file : std::filesystem::directory_iterator(folder)) {
            constexpr uintmax_t kMaxBytes = 32768; // parsing again and again takes its time
            if (file.is_regular_file() && file.file_size() <= kMaxBytes && file.path().string().ends_with(suffix))
                files.push_back(file.path());
        }
    };
    collect(tests / "fuzz" / entry, "");
    if (entry == "gltf") collect(tests / "compressed", ".glb");
    std::sort(files.begin(), files.end());
    std::vector<Seed> seeds;
    for (const auto& file : files) {
        std::ifstream stream(file, std::ios::binary);
        seeds.push_back(
            {file.filename().string(), {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()}});
    }
    return seeds;
}

// A change of the kind that libFuzzer makes: a bit, a byte, a number, a piece left out, doubled or cut off.
std::string mutated(std::string bytes, uint32_t seed)
{
    uint32_t state = hashCombine(seed, 0x9e3779b9u);
    const auto next = [&](std::size_t limit) {
        state = hashCombine(state, 1u);
        return limit == 0 ? 0 : std::size_t(state) % limit;
    };
    const std::size_t changes = 1 + next(4);
    for (std::size_t i = 0; i < changes && !bytes.empty(); ++i) {
        const std::size_t at = next(bytes.size());
        const std::size_t length = std::min(bytes.size() - at, 1 + next(16));
        switch (next(6)) {
        case 0:
            bytes[at] = char(bytes[at] ^ char(1u << next(8)));
            break;
        case 1:
            bytes[at] = char(next(256));
            break;
        case 2: { // a digit of a number, as in JSON
            const std::size_t digit = bytes.find_first_of("0123456789", at);
            if (digit != std::string::npos) bytes[digit] = "0123456789-.e\"[{"[next(16)];
            break;
        }
        case 3:
            bytes.erase(at, length);
            break;
        case 4:
            bytes.insert(at, bytes.substr(at, length));
            break;
        default:
            if (next(4) == 0) bytes.resize(at);
            break;
        }
    }
    return bytes;
}

class FuzzCorpus : public testing::TestWithParam<fuzz::EntryPoint> {};

// Seeds are read (or they would not lead anywhere); mutations end in a value or an error. Crashes and broken promises
// stop the program.
TEST_P(FuzzCorpus, SeedsAreReadAndMutationsEnd)
{
    const std::vector<Seed> seeds = seedsOf(std::string(GetParam().name));
    ASSERT_FALSE(seeds.empty());
    const auto run = [&](const std::string& bytes) {
        return GetParam().run(std::as_bytes(std::span(bytes.data(), bytes.size())));
    };
    const std::size_t rounds = 1500 / seeds.size();
    std::size_t good = 0;
    for (const Seed& seed : seeds) {
        good += run(seed.bytes) ? 1 : 0;
        for (uint32_t i = 0; i < rounds; ++i) run(mutated(seed.bytes, i));
    }
    EXPECT_GE(good, (seeds.size() + 1) / 2);
}

INSTANTIATE_TEST_SUITE_P(EntryPoints, FuzzCorpus, testing::ValuesIn(fuzz::kEntryPoints),
                         [](const auto& info) { return std::string(info.param.name); });

} // namespace

} // namespace halflight::test
