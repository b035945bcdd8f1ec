#pragma once
// The radiosity passes on the processor and on a device, compared.

#include "bake/test_scene.h"
#include "bake_cpu/trace/embree_kernels.h"
#include "bake_gpu/kernels.h"
#include "transport/radiosity/build.h"
#include "transport/radiosity/device_passes.h"
#include "transport/radiosity/form_factors.h"
#include "transport/radiosity/split_patches.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <numeric>
#include <span>
#include <vector>

namespace halflight::test {

/// What of both differs.
struct Differences {
    std::size_t occluded = 0; ///< patches and elements that an occluder crosses
    std::size_t otherOccluded = 0;
    std::size_t links = 0;
    std::size_t otherLinks = 0;
    std::size_t tints = 0; ///< links through coloured glass
    std::size_t otherTints = 0;
    std::size_t samples = 0; ///< sums of light, by entry of FormFactorRange::samples
    std::size_t otherSamples = 0;
    std::size_t parts = 0; ///< the same of components
    std::size_t otherParts = 0;
    double light = 0.0; ///< of all samples
    double lightDifference = 0.0;
    uint64_t raysOfCpu = 0;
    uint64_t raysOfGpu = 0;
};

/// Whether two sums of one sample differ by more than rounding does.
inline bool isOther(vec3 a, vec3 b, float near = 1.0e-3f)
{
    return glm::distance(a, b) > near * (glm::length(a) + 1.0e-4f);
}
inline bool isOther(const LobeMoments& a, const LobeMoments& b)
{
    // A sampled direction of a lobe that falls below the surface counts as none.
    return isOther(a.albedo, b.albedo) || isOther(a.exitance, b.exitance) || isOther(a.normal, b.normal) ||
           isOther(vec3(a.evenLight, a.evenCosine, a.sampledExitance),
                   vec3(b.evenLight, b.evenCosine, b.sampledExitance), 5.0e-3f) ||
           isOther(a.sampledMoment, b.sampledMoment, 5.0e-3f);
}

inline bool isOther(const ComponentSamples& a, const ComponentSamples& b)
{
    return isOther(a.gathered, b.gathered) || isOther(a.direct, b.direct) || isOther(a.exitance, b.exitance) ||
           isOther(vec3(a.sampledExitance), vec3(b.sampledExitance), 5.0e-3f) ||
           isOther(a.sampledMoment, b.sampledMoment, 5.0e-3f);
}

/// The passes of a scene, one after another, on both. Patches go on as the processor finds them.
class BothPasses {
public:
    BothPasses(Scene scene, int page, const IntegrationSettings& settings, const std::shared_ptr<BakeDevice>& device)
        : settings_(settings), bench_(std::move(scene), MixedLightingMode::Shadowmask, page, settings),
          pattern_(settings.seed), cpu_(bench_.scene, bench_.geometry, LightUse::Bake, bouncesOf(settings),
                                        embreeKernels(), settings.components),
          gpu_(
              bench_.scene, bench_.geometry, LightUse::Bake, bouncesOf(settings),
              [&](const RayScene& of) { return std::make_unique<GpuKernels>(device, of, embreeKernels()(of)); },
              settings.components),
          patches_(cpu_.surfaces(), bench_.map), onCpu_{cpu_, bench_.map, pattern_, settings_}, onGpu_{gpu_, bench_.map,
                                                                                                       pattern_,
                                                                                                       settings_}
    {
        auto made = gpu_.surfaces().kernels().prepareRadiosity(onGpu_, patches_.layout);
        EXPECT_TRUE(made);
        if (made) device_ = std::move(*made);
    }

    void run(std::size_t mostItems)
    {
        ASSERT_NE(device_, nullptr);
        std::vector<uint32_t> texels(std::min(mostItems, bench_.map.texels.size()));
        std::iota(texels.begin(), texels.end(), 0u);
        const auto some = [&](std::vector<uint32_t> items) {
            items.resize(std::min(items.size(), mostItems));
            return items;
        };
        const auto isOccluded = [](PatchState s) { return s.occluded; };
        findOccluded(PassKind::Fronts, texels);
        patches_.split(0, isOccluded);
        findOccluded(PassKind::Elements, some(patches_.texelsIn(bench_.map, 0, isOccluded)));
        gather(PassKind::Fronts, texels);
        patches_.split(0, [](PatchState s) { return s.hitNear; });
        const PatchId backs = patches_.layout.chartPatches;
        const std::vector<uint32_t> hitBacks =
            some(patches_.texelsIn(bench_.map, backs, [](PatchState s) { return s.hit; }));
        std::vector<uint32_t> triangles;
        for (uint32_t i = 0; i < 2 * patches_.triangles.size() && triangles.size() < mostItems; ++i) {
            if (patches_.state[2 * backs + i].hit) triangles.push_back(i);
        }
        findOccluded(PassKind::Backs, hitBacks);
        patches_.split(backs, isOccluded);
        const std::vector<uint32_t> elements = some(patches_.texelsIn(bench_.map, backs, isOccluded));
        findOccluded(PassKind::BackElements, elements);
        gather(PassKind::Backs, hitBacks);
        gather(PassKind::BackElements, elements);
        gather(PassKind::Triangles, triangles);
        gather(PassKind::Elements,
               some(patches_.texelsIn(bench_.map, 0, [](PatchState s) { return s.occluded || s.hitNear; })));
    }

    [[nodiscard]] const Differences& differences() const { return found_; }
    [[nodiscard]] std::size_t itemsOf(PassKind kind) const { return items_[std::size_t(kind)]; }
    /// Bits of all that the device has brought.
    [[nodiscard]] const std::vector<std::byte>& bytes() const { return bytes_; }

private:
    static Bounces bouncesOf(const IntegrationSettings& settings)
    {
        return settings.glossyBounces ? Bounces::Glossy : Bounces::Diffuse;
    }

    void findOccluded(PassKind kind, std::span<const uint32_t> items)
    {
        const PatchPass cpu(kind, patches_, onCpu_);
        const PatchPass gpu(kind, patches_, onGpu_);
        std::vector<PatchId> a;
        for (std::size_t first = 0; first < items.size(); first += kRangeItems) {
            OccluderSearch search(cpu);
            search.search(items.subspan(first, std::min(kRangeItems, items.size() - first)));
            a.insert(a.end(), search.occluded().begin(), search.occluded().end());
            found_.raysOfCpu += search.rays();
        }
        std::vector<PatchId> b;
        std::atomic<uint64_t> rays = 0;
        ASSERT_TRUE(findOccludedOn(*device_, gpu, items, b, {}, rays));
        found_.raysOfGpu += rays;
        keep(b);
        for (std::vector<PatchId>* list : {&a, &b}) {
            std::ranges::sort(*list);
            list->erase(std::ranges::unique(*list).begin(), list->end());
        }
        std::vector<PatchId> other;
        std::ranges::set_symmetric_difference(a, b, std::back_inserter(other));
        found_.occluded += a.size();
        found_.otherOccluded += other.size();
        for (const PatchId patch : a) patches_.state[patch].occluded = true;
    }

    void gather(PassKind kind, std::span<const uint32_t> items)
    {
        items_[std::size_t(kind)] = items.size();
        const PatchPass cpu(kind, patches_, onCpu_);
        const PatchPass gpu(kind, patches_, onGpu_);
        FormFactors b((items.size() + kRangeItems - 1) / kRangeItems);
        std::atomic<uint64_t> rays = 0;
        ASSERT_TRUE(gatherOn(*device_, gpu, items, b, {}, rays));
        found_.raysOfGpu += rays;
        FormFactors a(b.size());
        for (std::size_t r = 0; r < a.size(); ++r) {
            FormFactorSampler sampler(cpu, a[r]);
            sampler.gather(items.subspan(r * kRangeItems, std::min(kRangeItems, items.size() - r * kRangeItems)));
            found_.raysOfCpu += sampler.rays();
            compare(a[r], b[r]);
            keep(b[r].links);
            keep(b[r].samples);
            keep(b[r].components);
        }
        for (const FormFactorRange& range : a) {
            for (const PatchId patch : range.links) patches_.state[patch].hit = true;
            for (const PatchId patch : range.hitNear) patches_.state[patch].hitNear = true;
        }
    }

    void compareTints(const FormFactorRange& a, const FormFactorRange& b)
    {
        found_.tints += a.tinted.size();
        if (a.tinted.size() != b.tinted.size()) found_.otherTints += a.tinted.size();
        for (std::size_t i = 0; i < std::min(a.tinted.size(), b.tinted.size()); ++i)
            found_.otherTints +=
                a.tinted[i].link != b.tinted[i].link || isOther(a.tinted[i].tint, b.tinted[i].tint) ? 1 : 0;
    }

    void compare(const FormFactorRange& a, const FormFactorRange& b)
    {
        compareTints(a, b);
        found_.links += a.links.size();
        found_.samples += a.samples.size();
        std::vector<PatchId> far;
        std::ranges::set_symmetric_difference(sorted(a.hitNear), sorted(b.hitNear), std::back_inserter(far));
        found_.otherLinks += far.size();
        if (a.samples.size() != b.samples.size()) {
            found_.otherLinks += a.links.size();
            found_.otherSamples += a.samples.size();
            return;
        }
        std::size_t linkOfA = 0;
        std::size_t linkOfB = 0;
        for (std::size_t i = 0; i < a.samples.size(); ++i) {
            const PatchSamples& s = a.samples[i];
            const PatchSamples& t = b.samples[i];
            for (uint32_t n = 0; n < std::min(s.linkCount, t.linkCount); ++n)
                found_.otherLinks += a.links[linkOfA + n] != b.links[linkOfB + n] ? 1 : 0;
            found_.otherLinks += s.linkCount > t.linkCount ? s.linkCount - t.linkCount : t.linkCount - s.linkCount;
            linkOfA += s.linkCount;
            linkOfB += t.linkCount;
            EXPECT_EQ(s.patch, t.patch);
            EXPECT_EQ(s.rayCount, t.rayCount);
            EXPECT_EQ(s.directCount, t.directCount);
            EXPECT_NEAR(s.minDistance, t.minDistance, 1.0e-5f * s.minDistance);
            found_.otherSamples += isOther(s.gathered, t.gathered) || isOther(s.direct, t.direct) ||
                                           isOther(s.albedo, t.albedo) || isOther(s.lobes, t.lobes)
                                       ? 1
                                       : 0;
            const auto count = std::size_t(settings_.components.count);
            for (std::size_t c = i * count; c < (i + 1) * count; ++c) {
                const ComponentSamples none;
                const ComponentSamples& ofA = c < a.components.size() ? a.components[c] : none;
                const ComponentSamples& ofB = c < b.components.size() ? b.components[c] : none;
                found_.parts += isOther(ofA, none) ? 1 : 0;
                found_.otherParts += isOther(ofA, ofB) ? 1 : 0;
            }
            const auto light = [](const PatchSamples& of) { return double(luminance(of.gathered + of.direct)); };
            found_.light += light(s);
            found_.lightDifference += light(t) - light(s);
        }
    }

    static std::vector<PatchId> sorted(std::vector<PatchId> list)
    {
        std::ranges::sort(list);
        return list;
    }
    template<typename T> void keep(const std::vector<T>& list)
    {
        const auto bytes = std::as_bytes(std::span(list));
        bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    }

    IntegrationSettings settings_;
    Bench bench_;
    StratifiedPattern pattern_;
    PathTracer cpu_;
    PathTracer gpu_;
    Patches patches_;
    RadiosityInput onCpu_;
    RadiosityInput onGpu_;
    std::unique_ptr<DeviceRadiosity> device_;
    Differences found_;
    std::array<std::size_t, 5> items_{};
    std::vector<std::byte> bytes_;
};

} // namespace halflight::test
