#include "bake_cpu/lightmap/final_gather.h"

#include "halflight/base/finite.h"
#include "halflight/shading/sky.h"

#include <cmath>

namespace halflight {
namespace {

constexpr std::size_t kLanes = TexelGroup::kLanes;
constexpr uint32_t kEmitterSeed = 0x5eed0006u;
constexpr uint32_t kRouletteSeed = 0x5eed0007u;
constexpr uint32_t kBrightSeed = 0x5eed0008u;
constexpr uint32_t kTurnSeed = 0x5eed0011u;

/// Where some cells of a block stand for all of them, which part of the unit square each of them looks at is a texel's
/// own: a number that changes places of cells, so that rows, columns and neighbourhoods stay such.
int cellTurn(uint32_t texelId)
{
    return int(hashCombine(kTurnSeed, texelId) & (StratifiedPattern::kBlock - 1));
}

/// Noise that bright cells bring, as their guides have it, from which on a quarter of a block's samples look at them:
/// below it, other noise shows more. Half of them do, or all, where there is much noise and the rays that bring it are
/// neither so few that little light is at stake nor so many that they do without.
constexpr float kLittleNoise = 0.1f;
constexpr float kMuchNoise = 1.0f;
constexpr float kSomeShare = 0.01f;
constexpr float kLargeShare = 0.04f;
constexpr float kOftenEnough = 0.1f;

} // namespace

void FinalGather::beginBlock()
{
    halves_ = {};
    inverseSquares_.fill(0.0f);
    backFaces_.fill({});
}

void FinalGather::endBlock(int lane, TexelLight& light, TexelSum& sum)
{
    constexpr float kShare = 2.0f / float(StratifiedPattern::kBlock);
    const auto l = std::size_t(lane);
    for (const Half& half : halves_) {
        // Lights of extreme size or strength can leave the range of floats.
        const vec3 irradiance = half.irradiance[l] * kShare;
        const vec3 moment = half.moment[l] * kShare;
        const bool finite = isFinite(irradiance) && isFinite(moment);
        sum.add(finite ? irradiance : vec3(0.0f), finite ? moment : vec3(0.0f));
    }
    light.inverseSquares += inverseSquares_[l];
    light.backFaces.add(backFaces_[l]);
}

void FinalGather::cutEmitters(const GatherGroup& group)
{
    static_assert(kLanes == LightTree::Cut::kLanes);
    LightTree::Points positions;
    LightTree::Points normals;
    const int any = group.firstActive();
    if (any == group.lanes()) return;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const GatherGroup::Origin& s = group.origin(group.active(int(lane)) ? int(lane) : any, 0);
        positions.set(lane, s.position);
        normals.set(lane, s.normal);
    }
    cut_ = paths_.emitters().cut(positions, normals);
}

void FinalGather::prepareBright(const GatherGroup& group)
{
    brightSamples_.fill(0);
    if (cache_ == nullptr || cache_->bright().empty()) return;
    for (int i = 0; i < group.lanes(); ++i) {
        if (!group.active(i)) continue;
        const auto lane = std::size_t(i);
        const BrightCells::Guide guide = cache_->guide(group.point(i, 0));
        guides_[lane] = guide;
        constexpr int kAll = StratifiedPattern::kBlock;
        const bool much = guide.noise >= kMuchNoise && guide.share < kOftenEnough;
        brightSamples_[lane] = guide.noise < kLittleNoise           ? 0
                               : much && guide.share >= kLargeShare ? kAll
                               : much && guide.share >= kSomeShare  ? kAll / 2
                                                                    : kAll / 4;
    }
}

void FinalGather::add(const GatherGroup& group, int firstBlock, int blockCount, std::span<TexelLight> lights,
                      uint64_t& rays)
{
    const bool emitters = !paths_.emitters().empty();
    if (emitters) cutEmitters(group);
    prepareBright(group);
    const bool bright = std::any_of(brightSamples_.begin(), brightSamples_.end(), [](int n) { return n > 0; });
    for (int b = firstBlock; b < firstBlock + blockCount; ++b) {
        beginBlock();
        gatherBlock(group, b, rays);
        if (bright) sampleBright(group, b, rays);
        for (int lane = 0; lane < group.lanes(); ++lane) {
            TexelLight& light = lights[std::size_t(lane)];
            if (group.active(lane)) endBlock(lane, light, light.gathered);
        }
        if (emitters) sampleEmitters(group, b, lights, rays);
    }
}

void FinalGather::addEmitters(const GatherGroup& group, std::span<TexelLight> lights, uint64_t& rays)
{
    int blocks = 0;
    for (int lane = 0; lane < group.lanes(); ++lane)
        blocks = std::max(blocks, int(lights[std::size_t(lane)].gathered.blocks()));
    cutEmitters(group);
    for (int b = 0; b < blocks; ++b) {
        bundle_.place(group, b, kAllCells);
        sampleEmitters(group, b, lights, rays);
    }
}

// Irradiance is pi times the mean of cosine-distributed radiance (pdf cos / pi). Most rays are over with one look into
// the cache: they are handled in sweeps, so that each sweep's memory is on its way while others are worked on.
void FinalGather::gatherBlock(const GatherGroup& group, int block, uint64_t& rays)
{
    rays += uint64_t(bundle_.trace(paths_, pattern_, group, settings_.seed, block, kAllCells));
    const RayTracer& tracer = paths_.surfaces();
    constexpr uint32_t kMissed = ~0u;
    constexpr uint32_t kOther = ~0u - 1u;
    std::array<uint32_t, kSamples> where; // record of the triangle, then cell
    for (int cell = 0; cell < StratifiedPattern::kBlock; ++cell) {
        const RTCHit8& hit = bundle_.rays[std::size_t(cell)].hit;
        for (int lane = 0; lane < TexelGroup::kLanes; ++lane) {
            uint32_t& w = where[sampleOf(cell, lane)];
            w = kMissed;
            if (hit.geomID[lane] == RTC_INVALID_GEOMETRY_ID) continue;
            w = RadianceCache::recordOf(tracer, bundle_.rays[std::size_t(cell)], lane);
            if (cache_ != nullptr) __builtin_prefetch(&cache_->surface(w));
        }
    }
    SampleList inCells;
    for (int cell = 0; cache_ != nullptr && cell < StratifiedPattern::kBlock; ++cell) {
        const RTCRayHit8& packet = bundle_.rays[std::size_t(cell)];
        for (int lane = 0; lane < TexelGroup::kLanes; ++lane) {
            const std::size_t sample = sampleOf(cell, lane);
            uint32_t& w = where[sample];
            if (w == kMissed) continue;
            if (cache_->hiddenBack(w)) countBack(lane, cell, tracer.triangleAt(w / 2));
            if (!cache_->hasCells(w)) {
                w = kOther;
                continue;
            }
            const uint32_t glows = cache_->surface(w).firstCell & RadianceCache::kEmissive;
            const uint32_t square = cache_->cellIndex(w, {packet.hit.u[lane], packet.hit.v[lane]});
            __builtin_prefetch(cache_->cells() + square);
            w = square | glows;
            knowing_[sample] = square;
            inCells.add(sample);
        }
    }
    findKnowing(
        inCells.samples(), [&](std::size_t sample) { return packetOf(sample).ray.tfar[laneOf(sample)]; },
        [&](std::size_t sample) {
            const RTCRayHit8& packet = packetOf(sample);
            const int lane = laneOf(sample);
            return SidePlace{RadianceCache::recordOf(tracer, packet, lane), {packet.hit.u[lane], packet.hit.v[lane]}};
        });
    const Sky& sky = paths_.sky();
    const bool black = sky.black();
    std::array<Vec3Lanes<kLanes>, StratifiedPattern::kBlock> radiance;
    SampleList slow;
    SampleList bright;
    SampleList glowing;
    for (int cell = 0; cell < StratifiedPattern::kBlock; ++cell) {
        Vec3Lanes<kLanes>& r = radiance[std::size_t(cell)];
        for (int lane = 0; lane < int(kLanes); ++lane) {
            const auto l = std::size_t(lane);
            const std::size_t sample = sampleOf(cell, lane);
            const uint32_t w = where[sample];
            if (w == kMissed || !group.active(lane)) {
                r.set(l,
                      black ? vec3(0.0f)
                            : shading::skyRadiance(sky.zenith, sky.horizon, sky.ground, bundle_.direction(cell, lane)));
                continue;
            }
            if (cache_ == nullptr || w == kOther || knowing_[sample] == RadianceCache::kNoCells) {
                slow.add(sample);
                continue;
            }
            const uint32_t square = w & RadianceCache::kCellMask;
            r.set(l, cache_->cells()[knowing_[sample]].radiance);
            if ((w & RadianceCache::kEmissive) != 0) glowing.add(sample);
            bright.addIf(brightSamples_[l] > 0 && cache_->cells()[square].bright(), sample);
        }
    }
    const auto radianceOf = [&](std::size_t sample) { return radiance[cellOf(sample)][std::size_t(laneOf(sample))]; };
    const auto setRadiance = [&](std::size_t sample, vec3 r) {
        radiance[cellOf(sample)].set(std::size_t(laneOf(sample)), r);
    };
    for (const std::size_t sample : bright.samples()) {
        const uint32_t square = where[sample] & RadianceCache::kCellMask;
        setRadiance(sample, radianceOf(sample) * brightWeight(int(cellOf(sample)), laneOf(sample), square));
    }
    for (const std::size_t sample : glowing.samples())
        setRadiance(sample, radianceOf(sample) + emission(group, laneOf(sample), block, int(cellOf(sample))));
    for (const std::size_t sample : slow.samples())
        setRadiance(sample, slowRadiance(group, laneOf(sample), block, int(cellOf(sample)), rays));
    // What was written number by number is read as vectors only now: right away, the processor would wait for it.
    for (std::size_t cell = 0; cell < radiance.size(); ++cell) {
        const RTCRay8& packet = bundle_.rays[cell].ray;
        Vec3Lanes<kLanes>& r = radiance[cell];
        for (std::size_t l = 0; l < kLanes; ++l) {
            const float distance = packet.tfar[l];
            inverseSquares_[l] += 1.0f / (distance * distance); // 0 where the ray missed
            r.x[l] *= kPi;
            r.y[l] *= kPi;
            r.z[l] *= kPi;
        }
        count(cell, r, packet);
    }
}

template<typename DistanceOf, typename PlaceOf>
void FinalGather::findKnowing(std::span<const uint8_t> samples, const DistanceOf& distanceOf, const PlaceOf& placeOf)
{
    if (samples.empty()) return;
    const RadianceCache::Cell* cells = cache_->cells();
    SampleList parts;
    for (const std::size_t sample : samples) {
        if (cells[knowing_[sample]].answers(distanceOf(sample))) continue;
        parts.add(sample);
        cache_->prefetchParts(knowing_[sample]);
    }
    for (const std::size_t sample : parts.samples()) {
        const SidePlace place = placeOf(sample);
        knowing_[sample] = cache_->partIndex(place.record, place.barycentric, knowing_[sample]);
        if (knowing_[sample] != RadianceCache::kNoCells) __builtin_prefetch(cells + knowing_[sample]);
    }
    for (const std::size_t sample : parts.samples()) {
        uint32_t& part = knowing_[sample];
        if (part != RadianceCache::kNoCells && !cells[part].answers(distanceOf(sample))) part = RadianceCache::kNoCells;
    }
}

float FinalGather::brightWeight(int cell, int lane, uint32_t square) const
{
    const RTCRayHit8& packet = bundle_.rays[std::size_t(cell)];
    const auto l = std::size_t(lane);
    const vec3 direction = bundle_.direction(cell, lane);
    const vec3 normal = glm::normalize(vec3(packet.hit.Ng_x[lane], packet.hit.Ng_y[lane], packet.hit.Ng_z[lane]));
    const vec3 receiverNormal = bundle_.frame(std::size_t(cell)).normal[l];
    const float pdfArea = brightShare(l) * cache_->bright().pdfArea(guides_[l], square);
    const float cosine = std::max(std::abs(glm::dot(normal, direction)), 1.0e-6f);
    return misWeightOfRay(PathTracer::gatherPdf(receiverNormal, direction), pdfArea, packet.ray.tfar[lane], cosine);
}

void FinalGather::sampleBright(const GatherGroup& group, int block, uint64_t& rays)
{
    // In sweeps, so that each sweep's memory is on its way while others are worked on.
    const BrightCells& bright = cache_->bright();
    std::array<uint8_t, StratifiedPattern::kBlock> cells;
    std::size_t cellCount = 0;
    for (int cell = 0; cell < StratifiedPattern::kBlock; ++cell) {
        bool any = false;
        for (std::size_t lane = 0; lane < kLanes; ++lane) any = any || looksAtBright(lane, block, cell);
        if (any) cells[cellCount++] = uint8_t(cell);
    }
    const std::span<const uint8_t> used(cells.data(), cellCount);
    SampleList chosen;
    for (int i = 0; i < int(kLanes); ++i) {
        const auto lane = std::size_t(i);
        if (brightSamples_[lane] == 0) continue;
        const StratifiedPattern::Block points =
            pattern_.block(hashCombine(settings_.seed ^ kBrightSeed, group.id(i)), block);
        const int turn = brightSamples_[lane] < StratifiedPattern::kBlock ? cellTurn(group.id(i)) : 0;
        for (const uint8_t cell : used) {
            if (!looksAtBright(lane, block, cell)) continue;
            const std::size_t sample = sampleOf(cell, i);
            choices_[sample] = bright.choosePatch(guides_[lane], points.unit(cell ^ turn));
            chosen.addIf(choices_[sample].number != BrightCells::Choice::kNone, sample);
        }
    }
    for (const std::size_t sample : chosen.samples()) bright.chooseColumn(choices_[sample]);
    for (const std::size_t sample : chosen.samples()) {
        if (choices_[sample].number != BrightCells::Choice::kNone) bright.choosePiece(choices_[sample]);
    }
    for (const uint8_t cell : used) {
        for (std::size_t lane = 0; lane < kLanes; ++lane) places_[sampleOf(cell, int(lane))].pdfArea = 0.0f;
    }
    SampleList placed;
    for (const std::size_t sample : chosen.samples()) {
        const BrightCells::Choice& choice = choices_[sample];
        if (choice.number == BrightCells::Choice::kNone) continue;
        BrightCells::Place& place = places_[sample];
        bright.place(choice, place);
        if (place.pdfArea <= 0.0f) continue;
        placed.add(sample);
        knowing_[sample] = place.cell;
        __builtin_prefetch(cache_->cells() + place.cell);
        __builtin_prefetch(&cache_->surface(place.record));
    }
    findKnowing(
        placed.samples(),
        [&](std::size_t sample) {
            return glm::distance(bundle_.origin(cellOf(sample), laneOf(sample)), places_[sample].position);
        },
        [&](std::size_t sample) {
            return SidePlace{places_[sample].record, places_[sample].barycentric};
        });
    const RayTracer& tracer = paths_.surfaces();
    countLights(
        used,
        [&](std::size_t cell, EmitterLanes& lanes) {
            for (std::size_t lane = 0; lane < kLanes; ++lane) {
                const std::size_t sample = sampleOf(int(cell), int(lane));
                const BrightCells::Place& place = places_[sample];
                lanes.pdfArea[lane] = 0.0f;
                lanes.times[lane] = 1.0f;
                if (place.pdfArea <= 0.0f || knowing_[sample] == RadianceCache::kNoCells) continue;
                EmitterSample e;
                e.position = place.position;
                e.normal = place.normal;
                // Through holes light from elsewhere comes.
                const float coverage = tracer.coverageOfHit(place.record / 2, place.barycentric);
                e.radiance = cache_->cells()[knowing_[sample]].radiance * coverage;
                e.pdfArea = place.pdfArea * brightShare(lane);
                lanes.set(lane, e);
            }
        },
        rays);
}

vec3 FinalGather::emission(const GatherGroup& group, int lane, int block, int cell) const
{
    const Receiver receiver = receiverOf(group, lane, block, cell);
    const vec3 direction = bundle_.direction(cell, lane);
    return paths_.weightedEmission(paths_.surfaces().surfaceAt(bundle_.at(cell, lane)), direction, receiver,
                                   PathTracer::gatherPdf(receiver.normal, direction));
}

vec3 FinalGather::slowRadiance(const GatherGroup& group, int lane, int block, int cell, uint64_t& rays)
{
    const Receiver receiver = receiverOf(group, lane, block, cell);
    const RayHit at = bundle_.at(cell, lane);
    if (cache_ == nullptr && paths_.surfaces().metHiddenBack(at))
        countBack(lane, cell, paths_.surfaces().triangleOf(at.geomID, at.primID));
    const vec3 direction = bundle_.direction(cell, lane);
    const float pdf = PathTracer::gatherPdf(receiver.normal, direction);
    Sampler sampler(settings_.seed, group.id(lane), uint32_t(block * StratifiedPattern::kBlock + cell));
    return paths_.follow(at, direction, receiver, pdf, settings_.bounces, sampler, rays, cache_);
}

template<typename Choose>
void FinalGather::countLights(std::span<const uint8_t> cells, const Choose& choose, uint64_t& rays)
{
    // Points are chosen one cell ahead: what was written number by number is read as vectors later.
    std::array<EmitterLanes, 2> lanes{};
    for (std::size_t i = 0; i <= cells.size(); ++i) {
        if (i < cells.size()) choose(std::size_t(cells[i]), lanes[i % 2]);
        if (i > 0) countLights(cells[i - 1], lanes[(i - 1) % 2], rays);
    }
}

void FinalGather::countLights(std::size_t cell, const EmitterLanes& lanes, uint64_t& rays)
{
    if (std::none_of(lanes.pdfArea.begin(), lanes.pdfArea.end(), [](float pdf) { return pdf > 0.0f; })) return;
    const RayBundle::Frames& frame = bundle_.frame(cell);
    RTCRay8 packet;
    alignas(32) embree::LaneMask valid;
    std::array<float, kLanes> unshadowed; ///< as NextEventContribution has it
    RayTracer::clear(packet);
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const vec3 position = bundle_.origin(cell, int(lane));
        const NextEventContribution way = lanes.from(lane, position, frame.normal[lane], frame.geometricNormal[lane]);
        unshadowed[lane] = way.share * lanes.times[lane];
        valid.lane[lane] = way.distance > 0.0f ? -1 : 0;
        embree::setRay(packet, int(lane), position, way.direction);
        packet.tfar[lane] = way.distance * (1.0f - 1.0e-4f);
    }
    const auto traced = std::count(valid.lane, valid.lane + kLanes, -1);
    if (traced == 0) return;
    rays += uint64_t(traced);
    const std::array<float, kLanes> shares = paths_.surfaces().transmittance(valid, packet);
    Vec3Lanes<kLanes> irradiance;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const bool arrives = valid.lane[lane] != 0 && shares[lane] > 0.0f;
        irradiance.set(lane, arrives ? lanes.radiance[lane] * (unshadowed[lane] * shares[lane]) : vec3(0.0f));
        // Of lanes that nothing was sampled for, directions may be no numbers.
        packet.dir_x[lane] = arrives ? packet.dir_x[lane] : 0.0f;
        packet.dir_y[lane] = arrives ? packet.dir_y[lane] : 0.0f;
        packet.dir_z[lane] = arrives ? packet.dir_z[lane] : 0.0f;
    }
    count(cell, irradiance, packet);
}

// Where emitters give little beside what the gathered rays brought, only some samples look at them: as many of each
// block, those of the same cells for all texels, so that their rays fill packets.
void FinalGather::sampleEmitters(const GatherGroup& group, int block, std::span<TexelLight> lights, uint64_t& rays)
{
    constexpr int kBlock = StratifiedPattern::kBlock;
    beginBlock();
    std::array<bool, kLanes> use{};
    std::array<int, kLanes> looking{}; ///< samples of the block
    std::array<StratifiedPattern::Block, kLanes> points;
    std::array<int, kLanes> turn{};
    for (int i = 0; i < group.lanes(); ++i) {
        const auto lane = std::size_t(i);
        const TexelSum& gathered = lights[lane].gathered;
        use[lane] = group.active(i) && int(gathered.blocks()) > block;
        if (!use[lane]) continue;
        const float chance = PathTracer::rouletteSurvival(cut_.total[lane], luminance(gathered.mean()));
        const uint32_t roulette = hashCombine(settings_.seed ^ kRouletteSeed ^ group.id(i), uint32_t(block));
        looking[lane] = std::min(int(chance * float(kBlock) + unitFloat(roulette)), kBlock);
        if (looking[lane] < kBlock) turn[lane] = cellTurn(group.id(i));
        points[lane] = pattern_.block(hashCombine(settings_.seed ^ kEmitterSeed, group.id(i)), block);
    }
    countLights(
        kAllCells,
        [&](std::size_t cell, EmitterLanes& lanes) {
            LightTree::Points positions;
            LightTree::Cut::Lanes<bool> looks;
            Vec2Lanes<kLanes> u{};
            const int rank = StratifiedPattern::strataOrder(int(cell), block);
            for (std::size_t lane = 0; lane < kLanes; ++lane) {
                positions.set(lane, bundle_.origin(cell, int(lane)));
                looks[lane] = rank < looking[lane];
                if (looks[lane]) u.set(lane, points[lane].unit(int(cell) ^ turn[lane]));
            }
            paths_.emitters().sample(cut_, positions, bundle_.frame(cell).normal, looks, u, lanes);
            for (std::size_t lane = 0; lane < kLanes; ++lane)
                lanes.times[lane] = float(kBlock) / float(std::max(looking[lane], 1));
        },
        rays);
    for (int lane = 0; lane < group.lanes(); ++lane) {
        TexelLight& light = lights[std::size_t(lane)];
        if (use[std::size_t(lane)]) endBlock(lane, light, light.emitted);
    }
}

} // namespace halflight
