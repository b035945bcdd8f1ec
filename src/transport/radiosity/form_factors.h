#pragma once
// Sampled form factors: which patches the rays of each patch hit, and the light of sky and lights that it receives.

#include "transport/radiosity/lobe_moments.h"
#include "transport/radiosity/patch_pass.h"
#include "transport/texels/ray_bundle.h"

#include <algorithm>

namespace halflight {

/// Sums of the samples of one patch in a range of items.
struct PatchSamples {
    PatchId patch = 0;
    uint32_t linkCount = 0;
    uint32_t rayCount = 0;
    uint32_t directCount = 0;
    vec3 gathered{0.0f};      ///< radiance of sky and emitters along rays
    vec3 direct{0.0f};        ///< irradiance from sampled lights
    vec3 albedo{0.0f};        ///< of the diffuse part
    LobeMoments lobes;        ///< of the specular part; zero where bounces are diffuse
    float minDistance = 0.0f; ///< as PatchRadiance::minDistance
};

/// Of PatchSamples, the light of one component.
struct ComponentSamples {
    vec3 gathered{0.0f};
    vec3 direct{0.0f};
    vec3 exitance{0.0f}; ///< of lobes, as LobeMoments
    float sampledExitance = 0.0f;
    vec3 sampledMoment{0.0f};

    void addLobes(const LobeMoments& lobes)
    {
        exitance += lobes.exitance;
        sampledExitance += lobes.sampledExitance;
        sampledMoment += lobes.sampledMoment;
    }
};

/// Samples of a range of items. A link is a ray from a patch to a patch. The share of a patch's rays that link it to
/// another estimates their form factor (Goral, Torrance, Greenberg and Battaile 1984, "Modeling the Interaction of
/// Light Between Diffuse Surfaces").
struct FormFactorRange {
    std::vector<PatchSamples> samples;
    std::vector<PatchId> links; ///< of all samples in turn
    /// Radiance that a ray receives by way of surfaces without patches.
    struct LateRadiance {
        PatchId patch = 0;
        uint32_t reflections = 0;
        vec3 radiance{0.0f};
    };
    std::vector<LateRadiance> late;
    bool hasComponents = false;               ///< known before archives are read; false where light is estimated as one
    std::vector<ComponentSamples> components; ///< by entry of `samples` and component
    std::vector<uint8_t> lateComponents;      ///< by entry of `late`
    /// A link through glass that has a colour. In the order of `links`.
    struct TintedLink {
        uint32_t link = 0; ///< index into `links`
        vec3 tint{1.0f};   ///< RayHit::tint
    };
    std::vector<TintedLink> tinted;
    std::vector<PatchId> hitNear; ///< patches hit from less than half their width

    template<typename Archive> void archive(Archive& a)
    {
        a(samples, links, late, tinted, hitNear);
        if (hasComponents) a(components, lateComponents);
    }
    /// Gives back memory that is not needed once all samples are there.
    void shrink()
    {
        samples.shrink_to_fit();
        links.shrink_to_fit();
        components.shrink_to_fit();
    }
    /// The light of the components of an entry of `samples`.
    std::span<ComponentSamples> componentsOf(const PatchSamples& of, int count)
    {
        const auto first = std::size_t(&of - samples.data()) * std::size_t(count);
        if (components.size() < samples.size() * std::size_t(count))
            components.resize(samples.size() * std::size_t(count));
        return std::span(components).subspan(first, std::size_t(count));
    }
    /// Samples of a patch that are among the last 64; for sums without links.
    PatchSamples& recent(PatchId patch)
    {
        constexpr std::size_t kFew = 8 * kLanes;
        const std::size_t end = samples.size();
        for (std::size_t i = end; i > 0 && i + kFew > end; --i) {
            if (samples[i - 1].patch == patch) return samples[i - 1];
        }
        return last(patch);
    }
    /// The last samples, if they are of this patch; else new ones.
    PatchSamples& last(PatchId patch)
    {
        if (samples.empty() || samples.back().patch != patch) samples.push_back({patch});
        return samples.back();
    }
    /// Calls body(samples, links) for all samples of a range, which may be const.
    template<typename Range, typename Body> static void forSamples(Range& range, const Body& body)
    {
        std::size_t link = 0;
        for (auto& s : range.samples) {
            body(s, std::span(range.links).subspan(link, s.linkCount));
            link += s.linkCount;
        }
    }
};
using FormFactors = std::vector<FormFactorRange>;

/// Samples of one texel, and the share of texels that take any.
struct FormFactorEffort {
    int rays;
    int direct;    ///< samples of lights
    int every = 1; ///< of large patches that texels cover nearly fully, one texel in so many is gathered

    /// A texel's rays are so many strata of each of so many blocks of the pattern.
    [[nodiscard]] int blocks() const { return std::max(1, rays / StratifiedPattern::kBlock); }
    [[nodiscard]] int strata() const { return 4 * std::min(rays / 4, 4); }
    /// Number of a group of eight texels, by the first one: it decides which strata (shading::factorStratum()).
    [[nodiscard]] uint32_t groupOf(uint32_t texel) const { return texel / (kLanes * uint32_t(every)); }
};
/// Whether texels of so many samples ask for form factors by twice as many rays.
constexpr bool takesManySamples(int samples)
{
    return samples >= 96;
}
FormFactorEffort effortOf(const IntegrationSettings& settings, PassKind kind, int patchShift);
FormFactorEffort effortOf(const PatchPass& pass);
/// Seed of a pass's rays; its light samples have the complement.
uint32_t seedOfFactors(const PatchPass& pass);

/// Samples the form factors of a range of items.
class FormFactorSampler {
public:
    FormFactorSampler(const PatchPass& pass, FormFactorRange& out);

    void gather(std::span<const uint32_t> items);
    /// One ray of a group of one, which was counted when a device traced it.
    void traceAgain(const GatherGroup& group, int block, uint8_t stratum);
    [[nodiscard]] uint64_t rays() const { return rays_; }

private:
    using Strata = std::array<uint8_t, StratifiedPattern::kBlock>;
    std::size_t strataOf(uint32_t group, Strata& strata) const;
    void gatherGroup(const GatherGroup& group);
    void sortByElement(const GatherGroup& group, int lane, int block, std::span<uint8_t> strata) const;
    void addRay(const GatherGroup& group, int lane, int block, int stratum);
    void addPath(const GatherGroup& group, int lane, int block, int stratum, PatchId source);
    void findNear(PatchId source, PatchId target, const RayHit& hit);
    void addDirect(const TexelGroup& group, int sample);
    /// A sample of punctual lights.
    struct LampSample {
        const PunctualLight* light = nullptr;
        vec3 irradiance{0.0f};
        vec2 disc{0.0f};
    };
    void addDirectLight(PatchId source, const SurfacePoint& point, Sampler& sampler, std::span<const LampSample> lamps);
    void addGathered(PatchSamples& samples, int component, vec3 radiance);
    [[nodiscard]] int components() const { return paths_.light().components(); }

    const PatchPass& pass_;
    const PathTracer& paths_;
    const RayTracer& tracer_;
    FormFactorRange& out_;
    uint32_t seed_;
    FormFactorEffort effort_;
    RayBundle bundle_;
    std::vector<vec3> byBounce_; ///< radiance of the current path by number of reflections
    PathLights lights_;          ///< the same by component
    uint64_t rays_ = 0;
};

} // namespace halflight
