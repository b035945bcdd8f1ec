// S33. The compose pass, texel by texel: against sums in doubles, and against what the processor composes.
#include "gpu/device.h"
#include "halflight/base/rgb9e5.h"
#include "halflight/render/compose.h"
#include "halflight/shading/directional.h"
#include "render/passes/compose_pass.h"

#include <glm/gtc/packing.hpp>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <memory>
#include <random>

namespace halflight::test::compose_pass_test {
namespace {

constexpr ivec2 kSize{37, 21}; // no multiple of the pass's groups of invocations
constexpr int kPages = 3;

/// Pages of a bake without a scene: three groups, the second has no directions, the third no light on page 1.
BakedScene pagesWithGroups(bool directional)
{
    std::mt19937 random(7);
    const auto light = [&](float least, float most) {
        std::uniform_real_distribution<float> exponent(std::log2(least), std::log2(most));
        Image<uint32_t> page(kSize.x, kSize.y);
        for (uint32_t& texel : page.texels())
            texel = packRgb9e5({std::exp2(exponent(random)), std::exp2(exponent(random)), std::exp2(exponent(random))});
        return page;
    };
    const auto directions = [&] {
        ImageRgba8 page(kSize.x, kSize.y);
        for (u8vec4& texel : page.texels()) texel = u8vec4(random(), random(), random(), random());
        return page;
    };
    BakedScene baked;
    baked.isBaked = true;
    baked.lightmapUnitLux = 4.0f;
    baked.groups.resize(3);
    for (int p = 0; p < kPages; ++p) {
        baked.lightmaps.push_back(light(1.0e-3f, 100.0f));
        if (directional) baked.lightmapDirections.push_back(directions());
        for (std::size_t g = 0; g < 3; ++g) {
            BakedGroup& group = baked.groups[g];
            group.unitLux = g == 0 ? 1024.0f : 1.0f;
            const bool left = g == 2 && p == 1;
            group.lightmaps.push_back(left ? Image<uint32_t>() : light(1.0e-2f, 3.0e4f));
            if (directional && g != 1) group.directions.push_back(left ? ImageRgba8() : directions());
        }
    }
    return baked;
}

struct Composed {
    std::vector<Image<uint32_t>> texels; ///< of RGB9E5
    std::vector<ImageRgb32f> light;      ///< lux
    std::vector<ImageRgba8> directions;
    float unitLux = 1.0f;
};

class ComposePassS33 : public testing::Test {
protected:
    static void SetUpTestSuite() { device = std::make_unique<gpu::Device>(gpu::DeviceOptions{.validation = true}); }
    static void TearDownTestSuite() { device.reset(); }
    void TearDown() override { EXPECT_EQ(device->validationMessages(), std::vector<std::string>{}); }

    static gpu::Buffer copyOf(VkCommandBuffer commands, const gpu::Image& image, uint32_t texelBytes)
    {
        const gpu::ImageInfo& info = image.info();
        gpu::Buffer buffer(*device, VkDeviceSize(info.width) * info.height * info.layers * texelBytes,
                           VK_BUFFER_USAGE_TRANSFER_DST_BIT, gpu::MemoryUse::Readback);
        gpu::transition(*device, commands, image, gpu::state::kFragmentRead, gpu::state::kTransferSource);
        const VkBufferImageCopy region{.imageSubresource = {info.aspect, 0, 0, info.layers},
                                       .imageExtent = {info.width, info.height, 1}};
        device->vk.CmdCopyImageToBuffer(commands, image.get(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, buffer.get(), 1,
                                        &region);
        gpu::transition(*device, commands, image, gpu::state::kTransferSource, gpu::state::kFragmentRead);
        return buffer;
    }

    /// Twice into the same images, the first time with other weights: nothing of that is left.
    static Composed compose(const BakedScene& baked, const std::vector<vec3>& weights, VkFormat format)
    {
        gpu::Uploader uploader(*device);
        const GroupPages groups(*device, uploader, baked);
        const gpu::UniqueSampler sampler =
            gpu::makeSampler(*device, {.magFilter = VK_FILTER_NEAREST, .minFilter = VK_FILTER_NEAREST});
        const ComposePipeline pipeline(*device, format);
        const gpu::Image light = groups.makeLight(*device, format);
        const gpu::Image directions = groups.makeDirections(*device);
        const bool half = format == VK_FORMAT_R16G16B16A16_SFLOAT;
        gpu::Buffer lightCopy;
        gpu::Buffer directionCopy;
        for (const std::vector<vec3>& now : {std::vector<vec3>(weights.size(), vec3(3.0f)), weights}) {
            const auto table = groups.sources(now);
            gpu::Buffer sources(*device, table.size() * sizeof(table[0]),
                                VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                                gpu::MemoryUse::Device);
            uploader.buffer(sources, table.data(), table.size() * sizeof(table[0]));
            uploader.finish();
            const gpu::DescriptorSet set = pipeline.makeSet(*device, groups, sources, light, directions, sampler.get());
            device->execute([&](VkCommandBuffer commands) {
                composePages(*device, commands, pipeline, set.get(), groups, light, directions);
                lightCopy = copyOf(commands, light, half ? 8 : 4);
                directionCopy = copyOf(commands, directions, 4);
            });
        }
        return unpacked(lightCopy, directionCopy, groups.unitLux(weights), half, groups.hasDirections());
    }

    static Composed unpacked(const gpu::Buffer& light, const gpu::Buffer& directions, float unit, bool half,
                             bool directional)
    {
        Composed result;
        result.unitLux = unit;
        const std::size_t count = std::size_t(kSize.x) * std::size_t(kSize.y);
        for (std::size_t p = 0; p < kPages; ++p) {
            ImageRgb32f& page = result.light.emplace_back(kSize.x, kSize.y);
            Image<uint32_t>& texels = result.texels.emplace_back(kSize.x, kSize.y);
            if (half) {
                std::vector<uint64_t> values(count);
                std::memcpy(values.data(), light.mapped() + p * count * 8, count * 8);
                for (std::size_t i = 0; i < count; ++i) page.data()[i] = unit * vec3(glm::unpackHalf4x16(values[i]));
            } else {
                std::memcpy(texels.data(), light.mapped() + p * count * 4, count * 4);
                page = decodeRgb9e5(texels, unit);
            }
            if (!directional) continue;
            ImageRgba8& mean = result.directions.emplace_back(kSize.x, kSize.y);
            std::memcpy(mean.data(), directions.mapped() + p * count * 4, count * 4);
        }
        return result;
    }

    inline static std::unique_ptr<gpu::Device> device;
};

/// In doubles, lux.
glm::dvec3 sumAt(const BakedScene& baked, const std::vector<vec3>& weights, std::size_t page, std::size_t texel)
{
    const auto at = [&](const Image<uint32_t>& texels, float unit) {
        return double(unit) * glm::dvec3(unpackRgb9e5(texels.data()[texel]));
    };
    glm::dvec3 sum = at(baked.lightmaps[page], baked.lightmapUnitLux);
    for (std::size_t g = 0; g < baked.groups.size(); ++g)
        if (!baked.groups[g].lightmaps[page].empty())
            sum += glm::dvec3(weights[g]) * at(baked.groups[g].lightmaps[page], baked.groups[g].unitLux);
    return sum;
}

const std::vector<std::vector<vec3>> kStates = {
    {vec3(1), vec3(1), vec3(1)},
    {vec3(0), vec3(10, 0.5f, 0), vec3(0.001f)},
    {vec3(0), vec3(0), vec3(0)},
    {vec3(1.0e12f), vec3(1.0e-6f), vec3(2, 1, 0)}, // far beyond what RGB9E5 holds without a unit
};

// Half of the last place of RGB9E5, which has 9 bits of the brightest channel. Devices may cut off what half floats do
// not hold, so that they are off by all of the last place: 11 bits of each channel.
TEST_F(ComposePassS33, AddsUpToRounding)
{
    for (const VkFormat format : {VK_FORMAT_E5B9G9R9_UFLOAT_PACK32, VK_FORMAT_R16G16B16A16_SFLOAT}) {
        if (format == VK_FORMAT_E5B9G9R9_UFLOAT_PACK32 && composedFormat(*device) != format) continue;
        for (const bool directional : {false, true}) {
            const BakedScene baked = pagesWithGroups(directional);
            for (const std::vector<vec3>& weights : kStates) {
                const Composed composed = compose(baked, weights, format);
                for (std::size_t p = 0; p < kPages; ++p) {
                    for (std::size_t i = 0; i < composed.light[p].texelCount(); ++i) {
                        const glm::dvec3 sum = sumAt(baked, weights, p, i);
                        const double most = std::max({sum.x, sum.y, sum.z});
                        for (int c = 0; c < 3; ++c) {
                            const double of = format == VK_FORMAT_R16G16B16A16_SFLOAT ? sum[c] : most;
                            const double step = std::exp2(std::floor(std::log2(of * 512.0 / 511.0)));
                            const double bits = format == VK_FORMAT_R16G16B16A16_SFLOAT ? 1024.0 : 512.0;
                            // Floats add some 1e-6; below 2^-14 of the unit half floats have fewer bits.
                            const double small = most * 1.0e-6 + std::exp2(-24.0) * double(composed.unitLux);
                            ASSERT_NEAR(composed.light[p].data()[i][c], sum[c], step / bits + small)
                                << p << " " << i << " " << directional;
                        }
                    }
                }
            }
        }
    }
}

// One group alone: the device packs what the processor packs, bit for bit.
TEST_F(ComposePassS33, PacksAsTheProcessor)
{
    if (composedFormat(*device) != VK_FORMAT_E5B9G9R9_UFLOAT_PACK32) GTEST_SKIP() << "half floats here";
    BakedScene baked = pagesWithGroups(false);
    for (Image<uint32_t>& page : baked.lightmaps) page = Image<uint32_t>(kSize.x, kSize.y);
    for (const float weight : {1.0f, 0.1f, 0.7317f, 9.99f}) {
        const std::vector<vec3> weights = {vec3(weight, 0.5f * weight, 1.0f), vec3(0), vec3(0)};
        gpu::Uploader uploader(*device);
        const vec3 factor(GroupPages(*device, uploader, baked).sources(weights)[1].weight);
        const Composed composed = compose(baked, weights, VK_FORMAT_E5B9G9R9_UFLOAT_PACK32);
        for (std::size_t p = 0; p < kPages; ++p)
            for (std::size_t i = 0; i < composed.texels[p].texelCount(); ++i)
                ASSERT_EQ(composed.texels[p].data()[i],
                          packRgb9e5(unpackRgb9e5(baked.groups[0].lightmaps[p].data()[i]) * factor))
                    << weight << " " << p << " " << i;
    }
}

TEST_F(ComposePassS33, IsTheStateOfCompose)
{
    const BakedScene baked = pagesWithGroups(true);
    for (const std::vector<vec3>& weights : kStates) {
        const Composed composed = compose(baked, weights, composedFormat(*device));
        BakedScene state = baked;
        composeGroups(state, weights);
        for (std::size_t p = 0; p < kPages; ++p) {
            const ImageRgb32f light = decodeRgb9e5(state.lightmaps[p], state.lightmapUnitLux);
            for (std::size_t i = 0; i < light.texelCount(); ++i) {
                const vec3 a = composed.light[p].data()[i];
                const vec3 b = light.data()[i];
                const float most = std::max({b.x, b.y, b.z});
                ASSERT_LE(glm::length(a - b), most / 256.0f) << p << " " << i;
                const ivec4 difference =
                    glm::abs(ivec4(composed.directions[p].data()[i]) - ivec4(state.lightmapDirections[p].data()[i]));
                ASSERT_LE(std::max({difference.x, difference.y, difference.z}), 1) << p << " " << i;
                ASSERT_EQ(difference.w, 0) << "trust in reflection probes is the rest's";
            }
        }
    }
}

// Two lights of equal luminance from +x and +y have the mean direction (1/2, 1/2, 0); with one of them off, the
// other's.
TEST_F(ComposePassS33, DirectionsAreMeansByLuminance)
{
    BakedScene baked = pagesWithGroups(true);
    for (Image<uint32_t>& page : baked.lightmaps) page = Image<uint32_t>(kSize.x, kSize.y);
    for (std::size_t g : {0u, 2u}) {
        baked.groups[g].unitLux = 1.0f;
        baked.groups[g].lightmaps.assign(kPages, Image<uint32_t>(kSize.x, kSize.y, packRgb9e5(vec3(8.0f))));
        const vec3 direction = shading::encodeMeanDirection(g == 0 ? vec3(1, 0, 0) : vec3(0, 1, 0)) * 255.0f;
        baked.groups[g].directions.assign(kPages, ImageRgba8(kSize.x, kSize.y, u8vec4(direction + 0.5f, 255)));
    }
    const auto directionAt = [&](vec3 first, vec3 last) {
        const Composed composed = compose(baked, {first, vec3(0), last}, composedFormat(*device));
        return shading::decodeMeanDirection(vec3(composed.directions[1](5, 5)) / 255.0f);
    };
    EXPECT_LT(glm::distance(directionAt(vec3(1), vec3(1)), vec3(0.5f, 0.5f, 0)), 0.02f);
    EXPECT_LT(glm::distance(directionAt(vec3(3), vec3(1)), vec3(0.75f, 0.25f, 0)), 0.02f);
    EXPECT_LT(glm::distance(directionAt(vec3(0), vec3(1)), vec3(0, 1, 0)), 0.02f);
    // By luminance, not by channel: red is 0.2126 of white.
    EXPECT_LT(glm::distance(directionAt(vec3(1, 0, 0), vec3(1)), vec3(0.1753f, 0.8247f, 0)), 0.02f);
}

} // namespace
} // namespace halflight::test::compose_pass_test
