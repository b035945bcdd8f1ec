// Whole bakes on a device have the light of the processor's (spec S6): lightmap, masks and probes of whole files, with
// the same seeds on both. HALFLIGHT_TEST_SCENES names other files, between colons; scripts/gpu_check.sh bakes them all.

#include "bake/seeds.h"
#include "bake_gpu/test_device.h"

#include "halflight/bake/bake.h"
#include "halflight/scene/gltf.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <sstream>
#include <tuple>

namespace halflight::test::whole_bakes_test {
namespace {

constexpr int kBlock = 8; // texels along a side

std::vector<std::string> scenes()
{
    std::vector<std::string> files;
    if (const char* named = std::getenv("HALFLIGHT_TEST_SCENES")) {
        std::istringstream list(named);
        for (std::string file; std::getline(list, file, ':');) files.push_back(file);
        return files;
    }
    for (const char* name : {"two_rooms.glb", "area_lights.glb"})
        files.push_back((std::filesystem::path(HALFLIGHT_SOURCE_DIR) / "assets/tests" / name).string());
    return files;
}

/// A file, and what its light is gathered by.
using FileAndKind = std::tuple<std::string, IntegratorKind>;

std::string nameOf(const testing::TestParamInfo<FileAndKind>& info)
{
    const auto& [file, kind] = info.param;
    std::string name = std::filesystem::path(file).stem().string();
    std::ranges::replace_if(
        name, [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; }, '_');
    return name + (kind == IntegratorKind::Path ? "_path" : "");
}

BakeSettings settingsOf(uint32_t seed, int lightmapSize, IntegratorKind kind)
{
    BakeSettings settings;
    settings.integrator = kind;
    settings.samples = 32;
    settings.shadowSamples = 16;
    settings.lightmapSize = lightmapSize;
    settings.probeLayout = ProbeLayout::Grid;
    settings.reflectionProbes = false;
    settings.seed = seed;
    return settings;
}

/// What is compared of a bake: means of blocks of the pages, and probes.
struct Values {
    std::vector<double> light;  ///< lux
    std::vector<double> groups; ///< the same of light groups
    std::vector<double> masks;  ///< 0 to 1
    std::vector<double> probes; ///< mean radiance, nits
};

template<typename Image, typename Value>
void addBlocks(const Image& page, const Value& value, std::vector<double>& blocks)
{
    for (int y = 0; y < page.height(); y += kBlock) {
        for (int x = 0; x < page.width(); x += kBlock) {
            const int right = std::min(x + kBlock, page.width());
            const int bottom = std::min(y + kBlock, page.height());
            double sum = 0.0;
            for (int v = y; v < bottom; ++v)
                for (int u = x; u < right; ++u) sum += double(value(page(u, v)));
            blocks.push_back(sum / double((right - x) * (bottom - y)));
        }
    }
}

Values valuesOf(const BakeResult& result)
{
    Values values;
    for (const ImageRgb32f& page : result.irradiance)
        addBlocks(
            page, [](vec3 texel) { return luminance(texel); }, values.light);
    for (const std::vector<ImageRgb32f>& group : result.groupIrradiance)
        for (const ImageRgb32f& page : group)
            addBlocks(
                page, [](vec3 texel) { return luminance(texel); }, values.groups);
    for (const ImageRgba8& page : result.baked.shadowmasks)
        for (int channel = 0; channel < 4; ++channel)
            addBlocks(
                page, [&](u8vec4 texel) { return double(texel[channel]) / 255.0; }, values.masks);
    for (const Probe& probe : result.baked.probes.probes)
        if (probe.valid) values.probes.push_back(double(luminance(probe.radiance[0])));
    return values;
}

/// Probability of a |t| at least as large by chance, with the 7 degrees of freedom of eight pairs (Student 1908;
/// Abramowitz and Stegun 1964, 26.7.3).
double chanceOf(double t)
{
    static_assert(kSeeds == 8);
    const double angle = std::atan(t / std::sqrt(7.0));
    const double c = std::cos(angle);
    const double within = angle + std::sin(angle) * (c + 2.0 / 3.0 * std::pow(c, 3.0) + 8.0 / 15.0 * std::pow(c, 5.0));
    return 1.0 - within * 2.0 / double(kPi);
}

/// By block: what both have, for each seed.
struct Pairs {
    std::string name;
    std::vector<std::vector<double>> differences; ///< GPU less processor, by block and seed
    std::vector<double> means;                    ///< over the blocks, of the processor, by seed

    void add(const std::vector<double>& cpu, const std::vector<double>& gpu)
    {
        ASSERT_EQ(cpu.size(), gpu.size()) << name;
        differences.resize(cpu.size());
        for (std::size_t i = 0; i < cpu.size(); ++i) differences[i].push_back(gpu[i] - cpu[i]);
        means.push_back(meanOf(cpu).mean);
    }

    /// `least`: a difference that rounding, or a ray along an edge, explains; over the mean.
    void check(double least) const
    {
        const double mean = std::max(meanOf(means).mean, 1.0e-9);
        std::vector<double> ofSeeds(kSeeds); // differences of the mean over all blocks
        double worst = 0.0;
        for (const std::vector<double>& block : differences) {
            const SeedMean d = meanOf(block);
            for (std::size_t s = 0; s < block.size(); ++s) ofSeeds[s] += block[s] / double(differences.size());
            worst = std::max(worst, (std::abs(d.mean) - least * mean) / std::max(d.error, 1.0e-12));
        }
        const SeedMean all = meanOf(ofSeeds);
        std::cout << "    " << name << ": " << differences.size() << " blocks, mean differs by "
                  << 100.0 * all.mean / mean << " %, standard error " << 100.0 * all.error / mean << " %, largest t "
                  << std::max(worst, 0.0) << "\n";
        EXPECT_LE(std::abs(all.mean), 0.001 * mean + 4.0 * all.error) << name;
        // The largest of many blocks: once in a thousand runs by chance.
        const auto count = double(std::max(differences.size(), std::size_t(1)));
        EXPECT_GE(chanceOf(std::max(worst, 0.0)), 0.001 / count) << name << ": t " << worst;
    }
};

class WholeBakesS6 : public BakeDeviceTest, public testing::WithParamInterface<FileAndKind> {};

TEST_P(WholeBakesS6, HaveTheProcessorsLight)
{
    const auto& [file, kind] = GetParam();
    const Result<Scene> scene = readScene(file);
    ASSERT_TRUE(scene) << scene.error().text();
    Pairs light{"light"};
    Pairs groups{"groups"};
    Pairs masks{"masks"};
    Pairs probes{"probes"};
    int size = kind == IntegratorKind::Path ? 64 : 128; // of pages; a path takes four times as long as a sample
    for (uint32_t seed = 1; seed <= kSeeds; ++seed) {
        Result<BakeResult> cpu = bake(*scene, settingsOf(seed, size, kind), embreeIntegrators());
        for (int larger = 2; !cpu && seed == 1 && larger <= 4; larger *= 2) { // small pages have no room for all charts
            size *= 2;
            cpu = bake(*scene, settingsOf(seed, size, kind), embreeIntegrators());
        }
        const Result<BakeResult> gpu = bake(*scene, settingsOf(seed, size, kind), gpuIntegrators(device));
        ASSERT_TRUE(cpu) << cpu.error().text();
        ASSERT_TRUE(gpu) << gpu.error().text();
        ASSERT_TRUE(gpu->report.identity.starts_with("gpu-")) << gpu->report.identity;
        const Values a = valuesOf(*cpu);
        const Values b = valuesOf(*gpu);
        light.add(a.light, b.light);
        groups.add(a.groups, b.groups);
        masks.add(a.masks, b.masks);
        probes.add(a.probes, b.probes);
    }
    std::cout << nameOf({GetParam(), 0}) << "\n";
    constexpr double kRoundedLight = 1.0e-3;
    light.check(kRoundedLight);
    if (!groups.differences.empty()) groups.check(kRoundedLight);
    // A ray along an edge may pass on one side alone, in one texel of a block, whatever the seed.
    masks.check(1.0 / double(kBlock * kBlock));
    probes.check(kRoundedLight);
}

INSTANTIATE_TEST_SUITE_P(Scenes, WholeBakesS6,
                         testing::Combine(testing::ValuesIn(scenes()),
                                          testing::Values(IntegratorKind::Cache, IntegratorKind::Path)),
                         nameOf);

} // namespace
} // namespace halflight::test::whole_bakes_test
