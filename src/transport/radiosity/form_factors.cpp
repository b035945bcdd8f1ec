#include "transport/radiosity/form_factors.h"

#include "transport/sample/shadow_packet.h"

#include "halflight/shading/form_factors.h"

#include <algorithm>

namespace halflight {

using shading::kNearestInElements;
using shading::kNearestInPatches;

namespace {

constexpr uint32_t kCacheSeed = 0x5eed0005u;
/// Rays of a patch; half as many of an element or a triangle patch, and half as many light samples as rays. Twice as
/// many where texels take many samples, because the patches' variance would be visible beside that of the texels.
constexpr int kRays = 16;
/// Least rays of a texel: one in each row and column of the pattern of strata.
constexpr int kFewestRays = StratifiedPattern::kBlock / 4;

} // namespace

/// The texels of a patch share its rays. Where each takes the least, some take none.
FormFactorEffort effortOf(const IntegrationSettings& settings, PassKind kind, int patchShift)
{
    const int times = takesManySamples(settings.samples) ? 2 : 1;
    const int all = times * kRays;
    if (kind != PassKind::Fronts && kind != PassKind::Backs) return {all / 2, all / 4};
    const int rays = all >> (2 * patchShift);
    return {std::max(rays, kFewestRays), std::max(rays / 2, 1), std::max((1 << patchShift) / (2 * times), 1)};
}

FormFactorEffort effortOf(const PatchPass& pass)
{
    return effortOf(pass.input().settings, pass.kind(), pass.layout().patchShift);
}

uint32_t seedOfFactors(const PatchPass& pass)
{
    return pass.input().settings.seed ^ (kCacheSeed + (uint32_t(pass.kind()) << 16));
}

FormFactorSampler::FormFactorSampler(const PatchPass& pass, FormFactorRange& out)
    : pass_(pass), paths_(pass.input().paths), tracer_(paths_.surfaces()), out_(out), seed_(seedOfFactors(pass)),
      effort_(effortOf(pass))
{}

void FormFactorSampler::gather(std::span<const uint32_t> items)
{
    pass_.forGroups(items, [&](const TexelGroup& group) { gatherGroup(GatherGroup(paths_, group)); });
}

/// Strata of the rays of one texel. Returns their number.
std::size_t FormFactorSampler::strataOf(uint32_t group, Strata& strata) const
{
    const int count = effort_.strata();
    for (int i = 0; i < count; ++i) strata[std::size_t(i)] = uint8_t(shading::factorStratum(i, count / 4, group));
    return std::size_t(count);
}

void FormFactorSampler::traceAgain(const GatherGroup& group, int block, uint8_t stratum)
{
    bundle_.trace(paths_, pass_.input().pattern, group, seed_, block, {&stratum, 1});
    if (group.active(0)) addRay(group, 0, block, stratum);
}

void FormFactorSampler::gatherGroup(const GatherGroup& group)
{
    Strata all;
    const std::size_t count = strataOf(effort_.groupOf(group.texel(0)), all);
    const std::span<uint8_t> strata(all.data(), count);
    for (int b = 0; b < effort_.blocks(); ++b) {
        rays_ += uint64_t(bundle_.trace(paths_, pass_.input().pattern, group, seed_, b, strata));
        for (int lane = 0; lane < group.lanes(); ++lane) {
            if (!group.active(lane)) continue;
            sortByElement(group, lane, b, strata);
            for (const uint8_t stratum : strata) addRay(group, lane, b, stratum);
        }
    }
    for (int s = 0; s < effort_.direct; ++s) addDirect(group, s);
}

/// Sorts strata by the element that their rays start from, so that each element has one entry of samples.
void FormFactorSampler::sortByElement(const GatherGroup& group, int lane, int block, std::span<uint8_t> strata) const
{
    if (!pass_.ofElements()) return;
    std::array<PatchId, StratifiedPattern::kBlock> elements{};
    for (const uint8_t stratum : strata) {
        const SurfacePoint& point = group.point(lane, group.pointOf(lane, block, stratum));
        elements[stratum] = pass_.sourceOf(group, lane, point);
    }
    std::sort(strata.begin(), strata.end(),
              [&](uint8_t a, uint8_t b) { return elements[a] != elements[b] ? elements[a] < elements[b] : a < b; });
}

void FormFactorSampler::addRay(const GatherGroup& group, int lane, int block, int stratum)
{
    const int number = group.pointOf(lane, block, stratum);
    const SurfacePoint& point = group.points(lane)[std::size_t(number)];
    const PatchId source = pass_.sourceOf(group, lane, point);
    if (source == kNoPatch) return;
    PatchSamples& samples = out_.last(source);
    ++samples.rayCount;
    const vec3 direction = bundle_.direction(stratum, lane);
    const RayHit& hit = bundle_.hit(stratum, lane);
    if (!hit.found()) {
        paths_.light().splitSky(direction, paths_.light().sky().dimRadiance(direction),
                                [&](int component, vec3 part) { addGathered(samples, component, hit.tint * part); });
        return;
    }
    const PatchId target = pass_.targetOf(hit.face, hit.barycentric);
    if (target == kNoPatch) {
        addPath(group, lane, block, stratum, source);
        return;
    }
    if (hit.tint != vec3(1.0f)) out_.tinted.push_back({uint32_t(out_.links.size()), hit.tint});
    out_.links.push_back(target);
    ++samples.linkCount;
    if (pass_.kind() == PassKind::Fronts) findNear(source, target, hit);
    if (!pass_.layout().emissive(hit.face)) return;
    const GatherGroup::Origin& s = group.origin(lane, number);
    const SurfaceHit surface = tracer_.surfaceAt(hit);
    addGathered(samples, paths_.light().emissionComponent(surface.point.triangle),
                hit.tint * paths_.direct().weightedEmission(surface, direction, {s.position, s.normal},
                                                            gatherPdf(s.normal, direction)));
}

/// Adds radiance of sky or emitters along a ray.
void FormFactorSampler::addGathered(PatchSamples& samples, int component, vec3 radiance)
{
    samples.gathered += radiance;
    if (components() > 0) out_.componentsOf(samples, components())[std::size_t(component)].gathered += radiance;
}

/// Continues a ray that hits no patch as a path. Its radiance is split by the number of reflections.
void FormFactorSampler::addPath(const GatherGroup& group, int lane, int block, int stratum, PatchId source)
{
    const GatherGroup::Origin& s = group.origin(lane, group.pointOf(lane, block, stratum));
    const vec3 direction = bundle_.direction(stratum, lane);
    byBounce_.assign(1, vec3(0.0f));
    Sampler sampler(seed_, group.id(lane), uint32_t(block * StratifiedPattern::kBlock + stratum));
    lights_.clear();
    paths_.pathRadiance(bundle_.hit(stratum, lane), direction, {s.position, s.normal}, gatherPdf(s.normal, direction),
                        pass_.input().settings.bounces - 1, sampler, rays_, {}, &byBounce_,
                        components() > 0 ? &lights_ : nullptr);
    if (components() > 0) {
        for (const PathLight& light : lights_) {
            if (light.reflections == 0) {
                addGathered(out_.last(source), light.component, light.radiance);
            } else {
                out_.late.push_back({source, uint32_t(light.reflections), light.radiance});
                out_.lateComponents.push_back(uint8_t(light.component));
            }
        }
        return;
    }
    out_.last(source).gathered += byBounce_[0];
    for (uint32_t r = 1; r < byBounce_.size(); ++r) {
        if (byBounce_[r] != vec3(0.0f)) out_.late.push_back({source, r, byBounce_[r]});
    }
}

/// Marks both ends of a short ray: later rays will hit them from as near.
void FormFactorSampler::findNear(PatchId source, PatchId target, const RayHit& hit)
{
    if (target >= pass_.layout().chartPatches) return;
    const uint32_t triangle = tracer_.triangleAt(hit.face.hitIndex);
    if (!(hit.distance < kNearestInPatches * pass_.widthOf(target, triangle))) return;
    out_.hitNear.push_back(target);
    if (source < pass_.layout().chartPatches) out_.hitNear.push_back(source);
}

/// One sample of the lights for each active lane; of the lights of each component where there are some.
void FormFactorSampler::addDirect(const TexelGroup& group, int sample)
{
    struct LaneSample {
        PatchId source = kNoPatch;
        const SurfacePoint* point = nullptr;
        Sampler sampler{0, 0, 0};
    };
    std::array<LaneSample, kLanes> samples;
    for (int lane = 0; lane < kLanes; ++lane) {
        LaneSample& s = samples[std::size_t(lane)];
        if (!group.active(lane)) continue;
        s.point = &group.point(lane, group.pointOf(lane, 0, sample & (kMaxTexelPoints - 1)));
        s.source = pass_.sourceOf(group, lane, *s.point);
        if (s.source != kNoPatch) s.sampler = Sampler(~seed_, group.id(lane), uint32_t(sample));
    }
    const std::size_t choosers = paths_.light().choosers();
    std::array<std::array<LampSample, kMostLightGroups + 1>, kLanes> lamps;
    for (std::size_t c = 0; c < choosers; ++c) {
        std::array<SceneLight::LightChoice, kLanes> choices;
        ShadowPacket packet(paths_);
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
            LaneSample& s = samples[lane];
            if (s.source == kNoPatch) continue;
            choices[lane] = paths_.light().choosePunctualFrom(c, *s.point, s.sampler);
            if (choices[lane].light == nullptr) continue;
            packet.add(int(lane), *choices[lane].light, *s.point, choices[lane].disc, rays_);
        }
        const std::array<vec3, kLanes> transmittance = packet.trace();
        for (std::size_t lane = 0; lane < kLanes; ++lane)
            lamps[lane][c] = {choices[lane].light, choices[lane].irradiance(transmittance[lane]), choices[lane].disc};
    }
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        LaneSample& s = samples[lane];
        if (s.source != kNoPatch) addDirectLight(s.source, *s.point, s.sampler, std::span(lamps[lane]).first(choosers));
    }
}

/// Adds light that reaches a point of a patch: of lamps, of one emitter and of the sky.
void FormFactorSampler::addDirectLight(PatchId source, const SurfacePoint& point, Sampler& sampler,
                                       std::span<const LampSample> lamps)
{
    PatchSamples& sums = out_.recent(source);
    const std::span<ComponentSamples> components =
        this->components() > 0 ? out_.componentsOf(sums, this->components()) : std::span<ComponentSamples>();
    const bool glossy = paths_.glossy();
    const SurfaceReflectance surface = tracer_.materials().reflectanceAt(point.triangle, point.barycentric);
    // Components have no roulette: beside others' light, that of a dim one would be noise.
    const float other = components.empty() && !lamps.empty() ? luminance(lamps[0].irradiance) : 0.0f;
    const auto emitter = paths_.direct().emitterIrradiance(point, other, sampler, rays_);
    const auto sky = paths_.direct().skyIrradiance(point, other, sampler, rays_);
    sums.albedo += paths_.albedoOf(surface);
    if (glossy) sums.lobes.addSurface(surface, point, sampler);
    const auto add = [&](vec3 direction, vec3 irradiance, int component) {
        sums.direct += irradiance;
        if (components.empty()) {
            if (glossy) sums.lobes.addLight(surface, point, direction, irradiance, sampler);
            return;
        }
        ComponentSamples& own = components[std::size_t(component)];
        own.direct += irradiance;
        if (!glossy) return;
        LobeMoments lobes;
        lobes.addLight(surface, point, direction, irradiance, sampler);
        sums.lobes.add(lobes);
        own.addLobes(lobes);
    };
    for (const LampSample& lamp : lamps) {
        if (lamp.light == nullptr) continue;
        add(sampleLightRay(*lamp.light, point.position, lamp.disc).direction, lamp.irradiance, lamp.light->component);
    }
    add(emitter.direction, emitter.irradiance, emitter.component);
    add(sky.direction, sky.irradiance, sky.component);
    ++sums.directCount;
    const float widths = source < pass_.layout().patchCount() ? kNearestInPatches : kNearestInElements;
    sums.minDistance = std::max(sums.minDistance, widths * pass_.widthOf(source, point.triangle));
}

} // namespace halflight
