#include "transport/lightmap/next_event.h"

#include <algorithm>
#include <cmath>

namespace halflight {

int sourceSamplesOf(const Guide& guide, bool hasComponents)
{
    constexpr int kAll = StratifiedPattern::kBlock;
    const int most = hasComponents ? 3 * kAll / 4 : kAll;
    if (guide.local.count + guide.shared.count == 0) return 0;
    const float deviation = std::sqrt(guide.relativeVariance);
    return deviation >= 2.0f ? most : deviation >= 1.0f ? kAll / 2 : kAll / 4;
}

void NextEvent::prepareEmitters(const GatherGroup& group)
{
    LightTree::Points positions;
    LightTree::Points normals;
    const int any = group.firstActive();
    if (any == group.lanes() || paths_.light().emitters().empty()) return;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const GatherGroup::Origin& s = group.origin(group.active(int(lane)) ? int(lane) : any, 0);
        positions.set(lane, s.position);
        normals.set(lane, s.normal);
    }
    cut_ = paths_.light().emitters().cut(positions, normals);
}

void NextEvent::prepareSources(const GatherGroup& group)
{
    sourceSamples_.fill(0);
    if (guides_ == nullptr || guides_->empty()) return;
    for (int i = 0; i < group.lanes(); ++i) {
        if (!group.active(i)) continue;
        const auto lane = std::size_t(i);
        const Guide guide = guides_->guideAt(cache_->layout(), group.point(i, 0));
        guide_[lane] = guide;
        sourceSamples_[lane] = sourceSamplesOf(guide, cache_->componentCount() > 0);
    }
}

bool NextEvent::samplesSources() const
{
    return std::any_of(sourceSamples_.begin(), sourceSamples_.end(), [](int n) { return n > 0; });
}

float NextEvent::misWeightOfHit(const RayBundle& bundle, int stratum, int lane, PatchId patch) const
{
    const RayHit& hit = bundle.hit(stratum, lane);
    const auto l = std::size_t(lane);
    const vec3 direction = bundle.direction(stratum, lane);
    const RayTracer& surfaces = paths_.surfaces();
    const vec3 normal = surfaces.geometry().geometricNormal(surfaces.triangleAt(hit.face.hitIndex));
    const vec3 receiverNormal = bundle.frame(std::size_t(stratum)).normal[l];
    const float pdfArea = sourceFraction(l) * guides_->pdfArea(guide_[l], patch);
    const float cosine = std::max(std::abs(glm::dot(normal, direction)), 1.0e-6f);
    return misWeightOfRay(gatherPdf(receiverNormal, direction), pdfArea, hit.distance, cosine);
}

/// Makes the samples of the lanes in `sky` points of the sky.
void NextEvent::setSky(const GatherBlock& block, std::size_t stratum, const LightTree::Cut::Lanes<bool>& sky,
                       const Vec2Lanes& u, EmitterLanes& lanes) const
{
    using shading::kSkyMeters;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        if (!sky[lane]) continue;
        const SkyLight::Sample s = paths_.light().sky().sample(vec2(u.x[lane], u.y[lane]));
        EmitterSample e;
        e.position = block.bundle.origin(stratum, int(lane)) + s.direction * kSkyMeters;
        e.normal = -s.direction;
        e.radiance = s.radiance;
        e.rayVisible = false;
        e.pdfArea = s.pdf / (kSkyMeters * kSkyMeters);
        e.component = paths_.light().skyComponent();
        lanes.set(lane, e);
    }
}

/// Chooses points of sources for all samples.
void NextEvent::chooseSources(const GatherGroup& group, int number, std::span<const uint8_t> strata)
{
    for (int i = 0; i < kLanes; ++i) {
        const auto lane = std::size_t(i);
        for (const uint8_t stratum : strata) points_[sampleOf(stratum, i)].pdfArea = 0.0f;
        if (sourceSamples_[lane] == 0) continue;
        const StratifiedPattern::Block points =
            pattern_.block(hashCombine(settings_.seed ^ kSourceSeed, group.id(i)), number);
        const int shuffle = sourceSamples_[lane] < StratifiedPattern::kBlock ? shading::strataShuffle(group.id(i)) : 0;
        for (const uint8_t stratum : strata) {
            if (samplesSource(lane, number, stratum))
                points_[sampleOf(stratum, i)] = guides_->choosePoint(guide_[lane], points.unit(stratum ^ shuffle));
        }
    }
}

/// Turns a sample of a source into an emitter sample, if the cache has the radiance of its point.
void NextEvent::setSource(std::size_t sample, const GatherBlock& block, EmitterLanes& lanes)
{
    const auto lane = std::size_t(laneOf(sample));
    const SourcePoint& point = points_[sample];
    lanes.pdfArea[lane] = 0.0f;
    lanes.weight[lane] = 1.0f;
    if (point.pdfArea <= 0.0f) return;
    const vec3 origin = block.bundle.origin(stratumOf(sample), laneOf(sample));
    const vec3 way = point.position - origin;
    const PatchRadiance* cached = cache_->find({point.face, point.barycentric, {}, glm::length(way)}, point.patch);
    if (cached == nullptr) return;
    EmitterSample e;
    e.position = point.position;
    e.normal = point.normal;
    // A ray passes through the uncovered part.
    const float coverage = paths_.surfaces().coverageOfHit(point.face.hitIndex, point.barycentric);
    e.radiance = cached->along(glm::normalize(way)) * coverage;
    sourceRadiance_[lane] = cached;
    e.pdfArea = point.pdfArea * sourceFraction(lane);
    lanes.set(lane, e);
}

void NextEvent::sampleSources(const GatherGroup& group, int number, GatherBlock& block, uint64_t& rays)
{
    std::array<uint8_t, StratifiedPattern::kBlock> all;
    std::size_t count = 0;
    for (int stratum = 0; stratum < StratifiedPattern::kBlock; ++stratum) {
        bool any = false;
        for (std::size_t lane = 0; lane < kLanes; ++lane) any = any || samplesSource(lane, number, stratum);
        if (any) all[count++] = uint8_t(stratum);
    }
    const std::span<const uint8_t> strata(all.data(), count);
    ofSources_ = true;
    chooseSources(group, number, strata);
    addSamples(
        strata,
        [&](std::size_t stratum, EmitterLanes& lanes) {
            for (int lane = 0; lane < int(kLanes); ++lane) setSource(sampleOf(int(stratum), lane), block, lanes);
        },
        block, rays);
}

/// Illuminance that light of emitters is added to. Among components: the least that one with emitters has of itself,
/// because beside others' light, that of a dim one would be noise.
float NextEvent::besideEmitters(const TexelEstimate& estimate, std::span<const ComponentEstimate> components) const
{
    if (components.empty()) return luminance(estimate.gathered.mean());
    float least = kInfinity;
    for (const int c : paths_.light().emittingComponents())
        least = std::min(least, luminance(components[std::size_t(c)].gathered.mean()));
    return least;
}

void NextEvent::sampleEmitters(const GatherGroup& group, int number, GatherBlock& block,
                               std::span<const TexelEstimate> estimates, std::span<const ComponentEstimate> components,
                               uint64_t& rays)
{
    constexpr int kBlock = StratifiedPattern::kBlock;
    ofSources_ = false;
    block.sums.begin();
    block.components.begin();
    emitterLanes_.fill(false);
    std::array<int, kLanes> sampled{}; ///< strata of the block
    std::array<StratifiedPattern::Block, kLanes> points;
    std::array<int, kLanes> shuffle{};
    std::array<float, kLanes> skyShare{}; ///< of the samples
    const float skyIlluminance = paths_.light().sky().brightIlluminance();
    for (int i = 0; i < group.lanes(); ++i) {
        const auto lane = std::size_t(i);
        emitterLanes_[lane] = group.active(i) && int(estimates[lane].blocks()) > number;
        if (!emitterLanes_[lane]) continue;
        const auto count = std::size_t(block.components.count());
        const float gathered = besideEmitters(estimates[lane], components.subspan(lane * count, count));
        const float expected = cut_.total[lane] + skyIlluminance;
        const float survival = shading::rouletteSurvival(expected, gathered);
        if (skyIlluminance > 0.0f)
            skyShare[lane] = paths_.light().emitters().empty() ? 1.0f : skyIlluminance / expected;
        const uint32_t roulette = hashCombine(settings_.seed ^ kRouletteSeed ^ group.id(i), uint32_t(number));
        sampled[lane] = shading::strataOfShare(survival, roulette);
        if (sampled[lane] < kBlock) shuffle[lane] = shading::strataShuffle(group.id(i));
        points[lane] = pattern_.block(hashCombine(settings_.seed ^ kEmitterSeed, group.id(i)), number);
    }
    addSamples(
        kAllStrata,
        [&](std::size_t stratum, EmitterLanes& lanes) {
            LightTree::Points positions;
            LightTree::Cut::Lanes<bool> wanted;
            LightTree::Cut::Lanes<bool> sky{};
            Vec2Lanes u{};
            const int order = shading::patternOrder(int(stratum), number);
            for (std::size_t lane = 0; lane < kLanes; ++lane) {
                positions.set(lane, block.bundle.origin(stratum, int(lane)));
                wanted[lane] = order < sampled[lane];
                lanes.weight[lane] = float(kBlock) / float(std::max(sampled[lane], 1));
                if (!wanted[lane]) continue;
                vec2 at = points[lane].unit(int(stratum) ^ shuffle[lane]);
                // Either the sky or an emitter; the number that chose is used again.
                sky[lane] = shading::selectsOwn(skyShare[lane], at.x);
                wanted[lane] = !sky[lane];
                lanes.weight[lane] /= sky[lane] ? skyShare[lane] : 1.0f - skyShare[lane];
                u.set(lane, at);
            }
            lanes.pdfArea.fill(0.0f);
            if (!paths_.light().emitters().empty())
                paths_.light().emitters().sample(cut_, positions, block.bundle.frame(stratum).normal, wanted, u, lanes);
            setSky(block, stratum, sky, u, lanes);
        },
        block, rays);
}

/// Adds the light of the samples that choose(stratum, lanes) returns for the given strata.
template<typename Choose>
void NextEvent::addSamples(std::span<const uint8_t> strata, const Choose& choose, GatherBlock& block, uint64_t& rays)
{
    EmitterLanes lanes{};
    for (const uint8_t stratum : strata) {
        choose(std::size_t(stratum), lanes);
        addSamples(stratum, lanes, block, rays);
    }
}

void NextEvent::addSamples(std::size_t stratum, const EmitterLanes& lanes, GatherBlock& block, uint64_t& rays)
{
    if (std::none_of(lanes.pdfArea.begin(), lanes.pdfArea.end(), [](float pdf) { return pdf > 0.0f; })) return;
    const RayBundle::Frames& frame = block.bundle.frame(stratum);
    RayBundle::OfStratum<Ray> batch;
    std::array<float, kLanes> unshadowed; ///< irradiance per radiance
    std::size_t traced = 0;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const vec3 position = block.bundle.origin(stratum, int(lane));
        const NextEventContribution next = lanes.from(lane, position, frame.normal[lane], frame.geometricNormal[lane]);
        unshadowed[lane] = next.factor * lanes.weight[lane];
        // Directions of lanes without a sample may be NaN.
        if (!(next.distance > 0.0f)) continue;
        batch[lane] = {position, 0.0f, next.direction, next.distance * kShortOfSurface};
        ++traced;
    }
    if (traced == 0) return;
    rays += traced;
    std::array<vec3, kLanes> transmittance;
    paths_.surfaces().transmittance(batch, transmittance);
    Vec3Lanes irradiance;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const bool lit = !batch[lane].meetsNothing() && transmittance[lane] != vec3(0.0f);
        irradiance.set(lane, lit ? lanes.radiance[lane] * (unshadowed[lane] * transmittance[lane]) : vec3(0.0f));
        if (lit && block.components.count() > 0)
            addComponents(stratum, lane, lanes, unshadowed[lane] * transmittance[lane], batch[lane].direction, block);
    }
    block.sums.add(stratum, irradiance, batch);
}

/// `share`: irradiance per radiance.
void NextEvent::addComponents(std::size_t stratum, std::size_t lane, const EmitterLanes& lanes, vec3 share,
                              vec3 direction, GatherBlock& block) const
{
    if (!ofSources_) {
        block.components.add(stratum, lane, lanes.component[lane], lanes.radiance[lane] * share, direction);
        return;
    }
    const PatchRadiance& cached = *sourceRadiance_[lane];
    const float all = luminance(cached.along(direction));
    const float coverage = all > 0.0f ? luminance(lanes.radiance[lane]) / all : 0.0f;
    const std::span<const ComponentRadiance> light = cache_->componentsOf(cached);
    for (std::size_t c = 0; c < light.size(); ++c)
        block.components.add(stratum, lane, int(c), light[c].along(direction) * (share * coverage), direction);
}

} // namespace halflight
