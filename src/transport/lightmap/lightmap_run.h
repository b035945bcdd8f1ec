#pragma once
// Irradiance of some texels of a map whose radiance cache is built.

#include "transport/lightmap/batch_gather.h"
#include "transport/lightmap/final_gather.h"
#include "transport/lightmap/sample_plan.h"

#include <atomic>
#include <optional>

namespace halflight {

/// Everything that a map's texels have in common.
struct LightmapState {
    LightmapState(const TexelMap& map, bool hasComponents) : grouped(hasComponents), grid(map) {}
    template<typename Archive> void archive(Archive& a)
    {
        cache.archive(a, grouped);
        guides.archive(a);
        a(mean);
    }
    bool grouped; ///< light is kept by component
    TexelGrid grid;
    RadianceCache cache;
    Guides guides;
    std::unique_ptr<DeviceGather> device; ///< gathers in place of the processor; null = none
    float mean = 0.0f;                    ///< luminance of the map, rounded to a power of two
    /// Factor of all texels' demands (SamplePlan); 0 = not computed yet.
    float scale = 0.0f;
    std::optional<TexelStates> firstPass; ///< first samples from which `scale` was computed
};

struct LightmapInput {
    const PathTracer& paths;
    const StratifiedPattern& pattern;
    const IntegrationSettings& settings;
    const TexelMap& map;
    const LightmapState& state;

    [[nodiscard]] FinalGather makeGather() const
    {
        const bool bounces = settings.bounces > 0;
        return {paths, pattern, bounces ? &state.cache : nullptr, bounces ? &state.guides : nullptr, settings};
    }
};

/// Computes the texels of a request and the neighbours that the plan reads.
class LightmapRun {
public:
    /// `scale`: as SamplePlan has it.
    LightmapRun(const LightmapInput& input, std::span<const uint32_t> texels, int samples, float scale,
                const Progress& progress, std::atomic<uint64_t>& rays);

    /// All passes.
    Status run()
    {
        if (Status s = firstPass(); !s) return s;
        return laterPasses();
    }
    /// First samples of all texels.
    Status firstPass();
    /// Demands of the texels that may take more than the first samples.
    [[nodiscard]] std::vector<TexelDemand> demands() const { return plan_.demands(*wanted_, texels_); }
    [[nodiscard]] float scaleOf(std::span<const TexelDemand> demands) const { return plan_.scaleOf(demands); }
    [[nodiscard]] TexelStates takeStates() { return std::move(texels_); }
    [[nodiscard]] IrradianceEstimate estimateOf(uint32_t texel) const;
    /// Of each component, one after another. Sums `all` of them too.
    void componentsOf(uint32_t texel, IrradianceEstimate& all, std::span<IrradianceEstimate> out) const;

private:
    Status laterPasses();
    Status extendOnDevice(std::span<const uint32_t> places, std::span<const int> blocks, int firstBlock);
    bool takeFirstPass(uint32_t place);
    [[nodiscard]] std::size_t componentCount() const { return std::size_t(input_.paths.light().components()); }
    /// The components of the texel at a place.
    [[nodiscard]] std::span<ComponentEstimate> componentsAt(std::size_t place)
    {
        return std::span(texels_.components).subspan(place * componentCount(), componentCount());
    }
    template<typename Add> Status extend(const std::vector<uint32_t>& places, const Add& add);
    template<typename Add> void extendSome(std::span<const uint32_t> places, FinalGather& gather, const Add& add);
    [[nodiscard]] bool stopped() const { return progress_.cancelled() || input_.paths.surfaces().failed(); }
    [[nodiscard]] std::size_t size() const { return texels_.texels.size(); }
    [[nodiscard]] uint32_t texelAt(std::size_t place) const { return texels_.texels[place]; }
    [[nodiscard]] TexelState& stateAt(std::size_t place) { return texels_.states[place]; }

    const LightmapInput& input_;
    float scale_;
    const Progress& progress_;
    std::atomic<uint64_t>& rays_;
    SamplePlan plan_;
    TexelStates texels_;
    std::optional<TexelSet> wanted_; ///< texels that may take more than the first samples
};

} // namespace halflight
