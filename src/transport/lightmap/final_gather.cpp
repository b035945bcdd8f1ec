#include "transport/lightmap/final_gather.h"

#include <algorithm>

namespace halflight {

void FinalGather::add(const GatherGroup& group, int firstBlock, int blockCount, const Estimates& estimates,
                      uint64_t& rays)
{
    const bool emitters = paths_.light().samplesEmission();
    if (emitters) next_.prepareEmitters(group);
    next_.prepareSources(group);
    for (int b = firstBlock; b < firstBlock + blockCount; ++b) {
        block_.sums.begin();
        block_.components.begin();
        gatherBlock(group, b, rays);
        if (next_.samplesSources()) next_.sampleSources(group, b, block_, rays);
        for (int lane = 0; lane < group.lanes(); ++lane) {
            TexelEstimate& estimate = estimates.texels[std::size_t(lane)];
            if (!group.active(lane)) continue;
            block_.sums.end(lane, estimate, estimate.gathered);
            block_.components.end(std::size_t(lane), estimates.components, &ComponentEstimate::gathered);
        }
        if (emitters) sampleEmitters(group, b, estimates, rays);
    }
}

void FinalGather::sampleEmitters(const GatherGroup& group, int number, const Estimates& estimates, uint64_t& rays)
{
    next_.sampleEmitters(group, number, block_, estimates.texels, estimates.components, rays);
    for (int lane = 0; lane < group.lanes(); ++lane) {
        TexelEstimate& estimate = estimates.texels[std::size_t(lane)];
        if (!next_.sampledEmitters(lane)) continue;
        block_.sums.end(lane, estimate, estimate.emitted);
        block_.components.end(std::size_t(lane), estimates.components, &ComponentEstimate::emitted);
    }
}

// The estimator of irradiance is pi times the radiance of a cosine-distributed ray (pdf cos / pi).
void FinalGather::gatherBlock(const GatherGroup& group, int number, uint64_t& rays)
{
    rays += uint64_t(block_.bundle.trace(paths_, pattern_, group, settings_.seed, number, kAllStrata));
    block_.hits.lookUp(block_.bundle);
    Radiances radiance;
    weightHits(group, number, radiance, rays);
    // A loop of its own: vector loads right after scalar stores to the same memory would stall.
    for (std::size_t stratum = 0; stratum < radiance.size(); ++stratum) {
        Vec3Lanes& r = radiance[stratum];
        for (std::size_t l = 0; l < kLanes; ++l) {
            block_.sums.addDistance(l, block_.bundle.hits[stratum][l].distance);
            r.x[l] *= kPi;
            r.y[l] *= kPi;
            r.z[l] *= kPi;
        }
        block_.sums.add(stratum, r, block_.bundle.rays[stratum]);
    }
}

/// Radiance along all rays: of the sky, of patches with MIS weights, or of continuation paths.
void FinalGather::weightHits(const GatherGroup& group, int number, Radiances& radiance, uint64_t& rays)
{
    const SkyLight& sky = paths_.light().sky();
    const bool black = sky.black();
    SampleList continued;
    SampleList sources;
    SampleList emissive;
    for (int stratum = 0; stratum < StratifiedPattern::kBlock; ++stratum) {
        Vec3Lanes& r = radiance[std::size_t(stratum)];
        for (int lane = 0; lane < kLanes; ++lane) {
            const auto l = std::size_t(lane);
            const std::size_t sample = sampleOf(stratum, lane);
            if (block_.hits.missed(sample) || !group.active(lane)) {
                r.set(l, black ? vec3(0.0f) : sky.dimRadiance(block_.bundle.direction(stratum, lane)));
                continue;
            }
            const PatchRadiance* cached = block_.hits.radiance(sample);
            if (cached == nullptr) {
                continued.add(sample);
                continue;
            }
            r.set(l, cached->along(block_.bundle.direction(stratum, lane)));
            if (block_.hits.emissive(sample)) emissive.add(sample);
            if (next_.samplesSources(l) && next_.isSource(block_.hits.patch(sample))) sources.add(sample);
        }
    }
    const auto radianceOf = [&](std::size_t s) { return radiance[stratumOf(s)][std::size_t(laneOf(s))]; };
    const auto set = [&](std::size_t s, vec3 r) { radiance[stratumOf(s)].set(std::size_t(laneOf(s)), r); };
    if (hasComponents()) weights_.fill(1.0f);
    for (const std::size_t s : sources.samples()) {
        const PatchId patch = block_.hits.patch(s);
        weights_[s] = next_.misWeightOfHit(block_.bundle, int(stratumOf(s)), laneOf(s), patch);
        set(s, radianceOf(s) * weights_[s]);
    }
    if (hasComponents()) addComponents(group);
    for (const std::size_t s : emissive.samples()) {
        const vec3 emitted = emission(rayOf(group, laneOf(s), number, int(stratumOf(s))));
        set(s, radianceOf(s) + emitted);
        if (hasComponents()) addEmission(s, emitted);
    }
    if (paths_.surfaces().anyTinted()) tint(radiance);
    for (const std::size_t s : continued.samples())
        set(s, continuation(rayOf(group, laneOf(s), number, int(stratumOf(s))), rays));
}

/// Takes the colour of the glass that rays have passed.
void FinalGather::tint(Radiances& radiance) const
{
    for (std::size_t stratum = 0; stratum < radiance.size(); ++stratum)
        for (std::size_t lane = 0; lane < kLanes; ++lane)
            radiance[stratum].set(lane, radiance[stratum][lane] * block_.bundle.hits[stratum][lane].tint);
}

FinalGather::RayFrom FinalGather::rayOf(const GatherGroup& group, int lane, int number, int stratum) const
{
    return {next_.receiverOf(group, lane, number, stratum), block_.bundle.direction(stratum, lane),
            block_.bundle.hit(stratum, lane), group.id(lane), uint32_t(number * StratifiedPattern::kBlock + stratum)};
}

/// Emission at the end of a ray with its MIS weight.
vec3 FinalGather::emission(const RayFrom& ray) const
{
    return paths_.direct().weightedEmission(paths_.surfaces().surfaceAt(ray.hit), ray.direction, ray.receiver,
                                            gatherPdf(ray.receiver.normal, ray.direction));
}

/// Radiance of the continuation path of a ray that hits no patch, or one too near.
vec3 FinalGather::continuation(const RayFrom& ray, uint64_t& rays)
{
    Sampler sampler(settings_.seed, ray.texelId, ray.sample);
    const RadianceLookup lookup = cache_ != nullptr ? cache_->lookup() : RadianceLookup{};
    const float pdf = gatherPdf(ray.receiver.normal, ray.direction);
    if (!hasComponents())
        return paths_.pathRadiance(ray.hit, ray.direction, ray.receiver, pdf, settings_.bounces, sampler, rays, lookup);
    lights_.clear();
    const vec3 all = paths_.pathRadiance(ray.hit, ray.direction, ray.receiver, pdf, settings_.bounces, sampler, rays,
                                         lookup, nullptr, &lights_);
    const std::size_t stratum = ray.sample % StratifiedPattern::kBlock;
    for (const PathLight& light : lights_)
        block_.components.add(stratum, ray.receiver.lane, light.component, kPi * light.radiance, ray.direction);
    return all;
}

/// Adds what a ray receives of the emitter that it hits to the emitter's component.
void FinalGather::addEmission(std::size_t sample, vec3 radiance)
{
    const auto stratum = int(stratumOf(sample));
    const RayHit& hit = block_.bundle.hit(stratum, laneOf(sample));
    const int component = paths_.light().emissionComponent(paths_.surfaces().triangleAt(hit.face.hitIndex));
    block_.components.add(stratumOf(sample), std::size_t(laneOf(sample)), component, kPi * hit.tint * radiance,
                          block_.bundle.direction(stratum, laneOf(sample)));
}

/// Adds the components of the sky and of patches, as weightHits() finds them. Emission and continuation paths add their
/// own.
void FinalGather::addComponents(const GatherGroup& group)
{
    const SceneLight& light = paths_.light();
    for (int stratum = 0; stratum < StratifiedPattern::kBlock; ++stratum) {
        for (int lane = 0; lane < group.lanes(); ++lane) {
            if (!group.active(lane)) continue;
            const auto s = std::size_t(stratum);
            const auto l = std::size_t(lane);
            const std::size_t sample = sampleOf(stratum, lane);
            const vec3 direction = block_.bundle.direction(stratum, lane);
            const vec3 scale = kPi * block_.bundle.hit(stratum, lane).tint;
            if (block_.hits.missed(sample)) {
                light.splitSky(direction, light.sky().dimRadiance(direction), [&](int component, vec3 part) {
                    block_.components.add(s, l, component, scale * part, direction);
                });
                continue;
            }
            const PatchRadiance* cached = block_.hits.radiance(sample);
            if (cached == nullptr) continue;
            const std::span<const ComponentRadiance> components = cache_->componentsOf(*cached);
            for (std::size_t c = 0; c < components.size(); ++c)
                block_.components.add(s, l, int(c), scale * (weights_[sample] * components[c].along(direction)),
                                      direction);
        }
    }
}

} // namespace halflight
