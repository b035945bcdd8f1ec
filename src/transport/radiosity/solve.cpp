#include "transport/radiosity/solve.h"

#include "transport/radiosity/factor_rows.h"
#include "transport/radiosity/unknown.h"

#include "halflight/base/memory.h"
#include "halflight/base/parallel.h"
#include "halflight/shading/brdf.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace halflight {
namespace {

class RadiositySolver {
public:
    RadiositySolver(Patches& patches, FormFactors factors, int bounces, int components)
        : patches_(patches), factors_(std::move(factors)), bounces_(bounces), components_(components)
    {
        countRays();
    }

    RadiositySolution solve()
    {
        numberUnknowns();
        numberLinks();
        rows_ = FactorRows(factors_, unknownCount_, [](PatchId unknown) { return std::size_t(unknown); });
        sumSamples();
        iterate();
        RadiositySolution solution;
        findIlluminance(solution.illuminance);
        ComponentCache components = solveComponents(solution.ofComponents);
        fillPatches();
        findOwners(solution.patchOfUnknown);
        solution.cache = {std::move(patches_.layout), std::move(radiance_), std::move(levels_), bounces_, converged_};
        solution.cache.setComponents(std::move(components));
        solution.factors = std::move(factors_);
        return solution;
    }

private:
    /// Sweeps end where further ones would change radiance by less than this share in the mean over the unknowns.
    static constexpr double kConverged = 0.002;
    /// Sweeps before changes can be taken for a geometric series.
    static constexpr int kLeastSweeps = 3;

    /// Rays of each patch and element; 0 for occluded ones and for those without light samples.
    void countRays()
    {
        const std::size_t count = patches_.state.size();
        rayCount_.resize(count);
        std::vector<uint32_t> directCount(count);
        parallelFor(factors_.size(), 16, [&](std::size_t begin, std::size_t end) {
            for (std::size_t r = begin; r < end; ++r) {
                for (const PatchSamples& s : factors_[r].samples) {
                    AtomicRef<uint32_t>(rayCount_[s.patch]).fetch_add(s.rayCount, std::memory_order_relaxed);
                    AtomicRef<uint32_t>(directCount[s.patch]).fetch_add(s.directCount, std::memory_order_relaxed);
                }
            }
        });
        forEachIndex(count, [&](std::size_t i) {
            if (directCount[i] == 0 || patches_.state[i].occluded) rayCount_[i] = 0;
        });
    }

    void numberUnknowns()
    {
        unknown_.assign(rayCount_.size(), kNoPatch);
        for (std::size_t i = 0; i < rayCount_.size(); ++i) {
            if (rayCount_[i] > 0) unknown_[i] = unknownCount_++;
        }
    }

    /// Replaces patches by unknowns in the form factors. Links to occluded patches are left out.
    void numberLinks()
    {
        const auto unknownAt = [&](PatchId patch) {
            return patches_.state[patch].occluded ? kNoPatch : unknown_[patch];
        };
        parallelFor(factors_.size(), 16, [&](std::size_t begin, std::size_t end) {
            for (std::size_t r = begin; r < end; ++r) {
                for (PatchId& target : factors_[r].links) target = unknownAt(target);
                for (PatchSamples& s : factors_[r].samples) s.patch = unknown_[s.patch];
                for (FormFactorRange::LateRadiance& late : factors_[r].late) late.patch = unknown_[late.patch];
                factors_[r].components.resize(factors_[r].samples.size() * std::size_t(components_));
            }
        });
    }

    /// Links of a sample.
    [[nodiscard]] std::span<const PatchId> linksOf(const FactorRows::Term& term) const
    {
        return std::span(factors_[term.range].links).subspan(term.firstLink, term.linkCount);
    }

    /// Sums the samples of each unknown.
    void sumSamples()
    {
        unknowns_ = largeVector<Unknown>(unknownCount_);
        forEachIndex(unknownCount_, [&](std::size_t i) {
            Unknown& u = unknowns_[i];
            for (const FactorRows::Term& term : rows_.of(i)) {
                if (term.isLate()) continue;
                const PatchSamples& s = factors_[term.range].samples[term.index];
                const std::span<const PatchId> links = linksOf(term);
                const auto lost = std::count(links.begin(), links.end(), kNoPatch);
                u.gathered += kPi * s.gathered;
                u.direct += s.direct;
                u.albedo += s.albedo;
                u.lobes.add(s.lobes);
                u.directCount += float(s.directCount);
                u.rays += float(s.rayCount - uint32_t(lost));
                u.minDistance = std::max(u.minDistance, s.minDistance);
            }
            u.rays = std::max(u.rays, 1.0f);
            u.gathered /= u.rays;
            u.direct /= u.directCount;
            u.albedo /= u.directCount;
            u.lobes.albedo = glm::min(u.lobes.albedo / u.directCount, 1.0f - u.albedo);
            u.lobes.exitance /= u.directCount;
        });
    }

    /// Unknowns of a component, with the surfaces and counts of the sum's.
    std::vector<Unknown> unknownsOf(int component, const std::vector<Unknown>& all)
    {
        std::vector<Unknown> unknowns(unknownCount_);
        forEachIndex(unknownCount_, [&](std::size_t i) {
            Unknown& u = unknowns[i];
            for (const FactorRows::Term& term : rows_.of(i)) {
                if (term.isLate()) continue;
                FormFactorRange& range = factors_[term.range];
                const ComponentSamples& s =
                    range.componentsOf(range.samples[term.index], components_)[std::size_t(component)];
                u.gathered += kPi * s.gathered;
                u.direct += s.direct;
                u.lobes.exitance += s.exitance;
                u.lobes.sampledExitance += s.sampledExitance;
                u.lobes.sampledMoment += s.sampledMoment;
            }
            u.completeFrom(all[i]);
        });
        return unknowns;
    }

    /// Radiance of each component, by sweeps of its own. Where the sum has not converged, all take as many.
    ComponentCache solveComponents(std::vector<float>& illuminance)
    {
        ComponentCache cache;
        if (components_ == 0) return cache;
        cache.count = std::size_t(components_);
        cache.patches = largeVector<ComponentRadiance>(rayCount_.size() * cache.count);
        std::vector<Unknown> all = std::move(unknowns_);
        std::vector<vec3> reflected = std::move(reflected_);
        std::vector<float> diffuse = std::move(diffuse_);
        RadianceCache::Levels levels = std::move(levels_);
        const bool converged = converged_;
        for (component_ = 0; component_ < components_; ++component_) {
            unknowns_ = unknownsOf(component_, all);
            levels_ = {};
            iterate(converged);
            keepComponent(cache);
            std::vector<float> own;
            findIlluminance(own);
            illuminance.resize(own.size() * cache.count);
            for (std::size_t i = 0; i < own.size(); ++i)
                illuminance[i * cache.count + std::size_t(component_)] = own[i];
        }
        component_ = -1;
        for (FormFactorRange& range : factors_) release(range.components);
        unknowns_ = std::move(all);
        reflected_ = std::move(reflected);
        diffuse_ = std::move(diffuse);
        levels_ = std::move(levels);
        converged_ = converged;
        return cache;
    }

    void keepComponent(ComponentCache& cache) const
    {
        const auto c = std::size_t(component_);
        forEachIndex(rayCount_.size(), [&](std::size_t i) {
            if (unknown_[i] == kNoPatch) return;
            const uint32_t u = unknown_[i];
            const PatchRadiance light = unknowns_[u].radianceOf(reflected_[u], diffuse_[u]);
            cache.patches[i * cache.count + c] = {light.radiance, light.tilt};
        });
        for (std::size_t l = 0; l < levels_.size(); ++l) {
            if (levels_[l].empty()) continue;
            cache.levels[l].resize(levels_[l].size() * cache.count);
            for (std::size_t i = 0; i < levels_[l].size(); ++i) cache.levels[l][i * cache.count + c] = levels_[l][i];
        }
    }

    /// `mayConverge`: sweeps may end early.
    void iterate(bool mayConverge = true)
    {
        reflected_.assign(unknownCount_, vec3(0.0f));
        diffuse_.assign(unknownCount_, 0.0f);
        std::vector<vec3> gathered(unknownCount_);
        double lastChange = 0.0;
        for (int b = 1; b <= bounces_; ++b) {
            std::fill(gathered.begin(), gathered.end(), vec3(0.0f));
            if (b > 1) sweep(b, gathered);
            const double change = reflect(gathered);
            // Changes fall as a geometric series in the end: c, c r, c r^2, … with the sum c r / (1 - r) after c.
            const double ratio = lastChange > 0.0 ? change / lastChange : 1.0;
            converged_ = mayConverge && b > kLeastSweeps && ratio < 1.0 && change * ratio / (1.0 - ratio) < kConverged;
            // A component without light changes by nothing.
            converged_ = converged_ || (mayConverge && component_ >= 0 && b > kLeastSweeps && change == 0.0);
            lastChange = change;
            if (converged_) break;
            keepLevel(bounces_ - b);
        }
        if (converged_) levels_ = {};
    }

    /// Computes what each unknown reflects, and returns by how much that grew: the mean of the relative changes.
    double reflect(std::span<const vec3> gathered)
    {
        constexpr float kDark = -1.0f;
        std::vector<float> changes(unknownCount_, kDark);
        forEachIndex(unknownCount_, [&](std::size_t i) {
            const Unknown& u = unknowns_[i];
            const vec3 even = u.gathered + gathered[i] * (kPi / u.rays);
            const vec3 diffuse = u.albedo * (even + u.direct);
            const vec3 radiance = (diffuse + u.lobes.albedo * even + u.lobes.exitance) / kPi;
            const float after = luminance(radiance);
            if (after > 0.0f) changes[i] = std::abs(after - luminance(reflected_[i])) / after;
            reflected_[i] = radiance;
            diffuse_[i] = luminance(diffuse);
        });
        double sum = 0.0;
        std::size_t lit = 0;
        for (const float change : changes) {
            if (change == kDark) continue;
            sum += double(change);
            ++lit;
        }
        return lit > 0 ? sum / double(lit) : 0.0;
    }

    /// Keeps the radiance of the last few sweeps by patch. `remaining`: number of sweeps that follow.
    void keepLevel(int remaining)
    {
        if (remaining < 1 || remaining > RadianceCache::kLevels) return;
        auto& level = levels_[std::size_t(remaining - 1)];
        level.resize(patches_.layout.patchCount());
        for (std::size_t i = 0; i < level.size(); ++i) {
            level[i] = unknown_[i] != kNoPatch ? reflected_[unknown_[i]] : vec3(0.0f);
        }
    }

    [[nodiscard]] vec3 gatheredBy(const FactorRows::Term& term, int bounce) const
    {
        const FormFactorRange& range = factors_[term.range];
        vec3 sum(0.0f);
        if (term.isLate()) {
            const FormFactorRange::LateRadiance& late = range.late[term.index];
            const bool ofOther = component_ >= 0 && int(range.lateComponents[term.index]) != component_;
            return late.reflections < uint32_t(bounce) && !ofOther ? late.radiance : sum;
        }
        if (!range.tinted.empty()) return tintedLinks(range, term);
        for (const PatchId target : linksOf(term)) {
            if (target != kNoPatch) sum += reflected_[target];
        }
        return sum;
    }

    /// The same for links some of which go through glass that has a colour.
    [[nodiscard]] vec3 tintedLinks(const FormFactorRange& range, const FactorRows::Term& term) const
    {
        auto tinted = std::lower_bound(range.tinted.begin(), range.tinted.end(), term.firstLink,
                                       [](const auto& t, uint32_t link) { return t.link < link; });
        vec3 sum(0.0f);
        for (uint32_t link = term.firstLink; link < term.firstLink + term.linkCount; ++link) {
            const bool isTinted = tinted != range.tinted.end() && tinted->link == link;
            const vec3 tint = isTinted ? (tinted++)->tint : vec3(1.0f);
            if (range.links[link] != kNoPatch) sum += tint * reflected_[range.links[link]];
        }
        return sum;
    }

    /// Sums for each unknown the radiance at the ends of its links, and radiance by way of surfaces without patches.
    void sweep(int bounce, std::vector<vec3>& gathered) const
    {
        forEachIndex(unknownCount_, [&](std::size_t unknown) {
            for (const FactorRows::Term& term : rows_.of(unknown)) gathered[unknown] += gatheredBy(term, bounce);
        });
    }

    void findIlluminance(std::vector<float>& illuminance) const
    {
        illuminance.resize(patches_.layout.chartPatches);
        for (std::size_t i = 0; i < illuminance.size(); ++i) {
            if (unknown_[i] != kNoPatch) illuminance[i] = luminance(unknowns_[unknown_[i]].gathered);
        }
    }

    void fillPatches()
    {
        auto ofUnknown = largeVector<PatchRadiance>(unknownCount_);
        forEachIndex(unknowns_.size(),
                     [&](std::size_t i) { ofUnknown[i] = unknowns_[i].radianceOf(reflected_[i], diffuse_[i]); });
        release(reflected_);
        release(diffuse_);
        rows_ = {};
        release(unknowns_);
        radiance_ = largeVector<PatchRadiance>(rayCount_.size());
        forEachIndex(radiance_.size(), [&](std::size_t i) {
            if (unknown_[i] == kNoPatch) return;
            radiance_[i] = ofUnknown[unknown_[i]];
            if (patches_.state[i].occluded) radiance_[i].minDistance = kInfinity;
        });
    }

    void findOwners(std::vector<PatchId>& owner) const
    {
        const PatchLayout& layout = patches_.layout;
        owner.assign(unknownCount_, kNoPatch);
        forEachIndex(layout.patchCount(), [&](std::size_t i) {
            const auto patch = PatchId(i);
            if (unknown_[patch] != kNoPatch) owner[unknown_[patch]] = patch;
            if (layout.elements[patch].split == 0) return;
            const PatchId first = layout.elements[patch].first;
            for (PatchId e = first; e < first + layout.elementCount(patch); ++e) {
                if (unknown_[e] != kNoPatch) owner[unknown_[e]] = patch;
            }
        });
    }

    Patches& patches_;
    FormFactors factors_;
    int bounces_;
    int components_;
    int component_ = -1; ///< that is solved; -1 = the sum
    bool converged_ = false;
    std::vector<uint32_t> rayCount_; ///< by patch and element
    std::vector<uint32_t> unknown_;  ///< number of the unknown, or kNoPatch
    uint32_t unknownCount_ = 0;
    std::vector<Unknown> unknowns_;
    std::vector<vec3> reflected_; ///< by unknown: exitance / pi
    std::vector<float> diffuse_;  ///< luminance of the diffuse part of the exitance, lux
    FactorRows rows_;             ///< by unknown
    RadianceCache::Levels levels_;
    std::vector<PatchRadiance> radiance_;
};

} // namespace

RadiositySolution solveRadiosity(Patches& patches, FormFactors factors, int bounces, int components)
{
    return RadiositySolver(patches, std::move(factors), bounces, components).solve();
}

} // namespace halflight
