#include "bake_cpu/final_gather.h"

#include "halflight/shading/sky.h"

#include <cmath>

namespace halflight {
namespace {

constexpr std::size_t kLanes = TexelGroup::kLanes;
constexpr uint32_t kEmitterSeed = 0x5eed0006u;
constexpr uint32_t kRouletteSeed = 0x5eed0007u;
constexpr uint32_t kBrightSeed = 0x5eed0008u;
constexpr uint32_t kTurnSeed = 0x5eed0011u;

bool isFinite(vec3 v)
{
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Where some cells of a block stand for all of them, which part of the unit square each of them looks at is a texel's
/// own: a number that changes places of cells, so that rows, columns and neighbourhoods stay such.
int cellTurn(uint32_t texelId)
{
    return int(hashCombine(kTurnSeed, texelId) & (GatherPattern::kBlock - 1));
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
    constexpr float kShare = 2.0f / float(GatherPattern::kBlock);
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
        constexpr int kAll = GatherPattern::kBlock;
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
// the cache: they are handled in three sweeps, so that each sweep's memory is on its way while others are worked on.
void FinalGather::gatherBlock(const GatherGroup& group, int block, uint64_t& rays)
{
    rays += uint64_t(bundle_.trace(paths_, pattern_, group, settings_.seed, block, kAllCells));
    const SurfaceTracer& tracer = paths_.surfaces();
    constexpr std::size_t kRays = std::size_t(GatherPattern::kBlock) * kLanes;
    constexpr uint32_t kMissed = ~0u;
    constexpr uint32_t kOther = ~0u - 1u;
    std::array<uint32_t, kRays> where; // record of the triangle, then cell
    for (int cell = 0; cell < GatherPattern::kBlock; ++cell) {
        const RTCHit8& hit = bundle_.rays[std::size_t(cell)].hit;
        for (int lane = 0; lane < TexelGroup::kLanes; ++lane) {
            uint32_t& w = where[std::size_t(cell) * kLanes + std::size_t(lane)];
            w = kMissed;
            if (hit.geomID[lane] == RTC_INVALID_GEOMETRY_ID) continue;
            w = RadianceCache::recordOf(tracer, bundle_.rays[std::size_t(cell)], lane);
            if (cache_ != nullptr) __builtin_prefetch(&cache_->surface(w));
        }
    }
    for (int cell = 0; cache_ != nullptr && cell < GatherPattern::kBlock; ++cell) {
        const RTCRayHit8& packet = bundle_.rays[std::size_t(cell)];
        for (int lane = 0; lane < TexelGroup::kLanes; ++lane) {
            uint32_t& w = where[std::size_t(cell) * kLanes + std::size_t(lane)];
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
        }
    }
    const Sky& sky = paths_.sky();
    const bool black = sky.black();
    for (int cell = 0; cell < GatherPattern::kBlock; ++cell) {
        const RTCRayHit8& packet = bundle_.rays[std::size_t(cell)];
        Vec3Lanes<kLanes> radiance;
        for (int lane = 0; lane < int(kLanes); ++lane) {
            const auto l = std::size_t(lane);
            const uint32_t w = where[std::size_t(cell) * kLanes + l];
            if (w == kMissed || !group.active(lane)) {
                radiance.set(l, black ? vec3(0.0f)
                                      : shading::skyRadiance(sky.zenith, sky.horizon, sky.ground,
                                                             bundle_.direction(cell, lane)));
                continue;
            }
            const uint32_t square = w & RadianceCache::kCellMask;
            const vec3* known = cache_ != nullptr && w != kOther ? knownRadiance(cell, lane, square) : nullptr;
            if (known != nullptr) {
                radiance.set(l, brightSamples_[l] > 0 && cache_->cells()[square].bright()
                                    ? *known * brightWeight(cell, lane, square)
                                    : *known);
                if ((w & RadianceCache::kEmissive) != 0)
                    radiance.set(l, radiance[l] + emission(group, lane, block, cell));
            } else {
                radiance.set(l, slowRadiance(group, lane, block, cell, rays));
            }
        }
        for (std::size_t l = 0; l < kLanes; ++l) {
            const float distance = packet.ray.tfar[l];
            inverseSquares_[l] += 1.0f / (distance * distance); // 0 where the ray missed
            radiance.x[l] *= kPi;
            radiance.y[l] *= kPi;
            radiance.z[l] *= kPi;
        }
        count(std::size_t(cell), radiance, packet.ray);
    }
}

const vec3* FinalGather::knownRadiance(int cell, int lane, uint32_t square) const
{
    const RTCRayHit8& packet = bundle_.rays[std::size_t(cell)];
    const RadianceCache::Cell* c = cache_->cells() + square;
    if (c->answers(packet.ray.tfar[lane])) return &c->radiance;
    const uint32_t record = RadianceCache::recordOf(paths_.surfaces(), packet, lane);
    return cache_->known(record, {packet.hit.u[lane], packet.hit.v[lane]}, square, packet.ray.tfar[lane]);
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
    return rayWeight(PathTracer::gatherPdf(receiverNormal, direction), pdfArea, packet.ray.tfar[lane], cosine);
}

void FinalGather::sampleBright(const GatherGroup& group, int block, uint64_t& rays)
{
    // In sweeps, so that each sweep's memory is on its way while others are worked on.
    const BrightCells& bright = cache_->bright();
    std::array<uint8_t, GatherPattern::kBlock> cells;
    std::size_t cellCount = 0;
    for (int cell = 0; cell < GatherPattern::kBlock; ++cell) {
        bool any = false;
        for (std::size_t lane = 0; lane < kLanes; ++lane) any = any || looksAtBright(lane, block, cell);
        if (any) cells[cellCount++] = uint8_t(cell);
    }
    const std::span<const uint8_t> used(cells.data(), cellCount);
    std::array<uint8_t, kSamples> chosen;
    std::size_t count = 0;
    for (int i = 0; i < int(kLanes); ++i) {
        const auto lane = std::size_t(i);
        if (brightSamples_[lane] == 0) continue;
        const GatherPattern::Block points =
            pattern_.block(hashCombine(settings_.seed ^ kBrightSeed, group.id(i)), block);
        const int turn = brightSamples_[lane] < GatherPattern::kBlock ? cellTurn(group.id(i)) : 0;
        for (const uint8_t cell : used) {
            if (!looksAtBright(lane, block, cell)) continue;
            const std::size_t sample = cell * kLanes + lane;
            choices_[sample] = bright.choosePatch(guides_[lane], points.unit(cell ^ turn));
            if (choices_[sample].number != BrightCells::Choice::kNone) chosen[count++] = uint8_t(sample);
        }
    }
    for (std::size_t i = 0; i < count; ++i) bright.chooseColumn(choices_[chosen[i]]);
    for (std::size_t i = 0; i < count; ++i) {
        if (choices_[chosen[i]].number != BrightCells::Choice::kNone) bright.choosePiece(choices_[chosen[i]]);
    }
    for (const uint8_t cell : used) {
        for (std::size_t lane = 0; lane < kLanes; ++lane) places_[cell * kLanes + lane].pdfArea = 0.0f;
    }
    for (std::size_t i = 0; i < count; ++i) {
        const BrightCells::Choice& choice = choices_[chosen[i]];
        if (choice.number == BrightCells::Choice::kNone) continue;
        const BrightCells::Place& place = places_[chosen[i]] = bright.place(choice);
        __builtin_prefetch(cache_->cells() + place.cell);
        __builtin_prefetch(&cache_->surface(place.record));
    }
    const SurfaceTracer& tracer = paths_.surfaces();
    countLights(
        used,
        [&](std::size_t cell, EmitterLanes& lanes) {
            for (std::size_t lane = 0; lane < kLanes; ++lane) {
                const BrightCells::Place& place = places_[cell * kLanes + lane];
                lanes.pdfArea[lane] = 0.0f;
                if (place.pdfArea <= 0.0f) continue;
                const float distance = glm::distance(bundle_.origin(cell, int(lane)), place.position);
                const vec3* known = cache_->known(place.record, place.barycentric, place.cell, distance);
                if (known == nullptr) continue;
                EmitterSample e;
                e.position = place.position;
                e.normal = place.normal;
                // Through holes light from elsewhere comes.
                e.radiance = *known * tracer.coverageOfHit(place.record / 2, place.barycentric);
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
    Sampler sampler(settings_.seed, group.id(lane), uint32_t(block * GatherPattern::kBlock + cell));
    return paths_.follow(at, direction, receiver, pdf, settings_.bounces, sampler, rays, cache_);
}

template<typename Choose>
void FinalGather::countLights(std::span<const uint8_t> cells, const Choose& choose, uint64_t& rays)
{
    RTCRay8 packet;
    alignas(32) embree::LaneMask valid;
    EmitterLanes lanes{};
    std::array<float, kLanes> unshadowed; ///< as EmitterWay has it
    for (const std::size_t cell : cells) {
        const RayBundle::Frames& frame = bundle_.frame(cell);
        choose(cell, lanes);
        if (std::none_of(lanes.pdfArea.begin(), lanes.pdfArea.end(), [](float pdf) { return pdf > 0.0f; })) continue;
        SurfaceTracer::clear(packet);
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
            const vec3 position = bundle_.origin(cell, int(lane));
            const EmitterWay way = lanes.from(lane, position, frame.normal[lane], frame.geometricNormal[lane]);
            unshadowed[lane] = way.share;
            valid.lane[lane] = way.distance > 0.0f ? -1 : 0;
            embree::setRay(packet, int(lane), position, way.direction);
            packet.tfar[lane] = way.distance * (1.0f - 1.0e-4f);
        }
        const auto traced = std::count(valid.lane, valid.lane + kLanes, -1);
        if (traced == 0) continue;
        rays += uint64_t(traced);
        const std::array<float, kLanes> shares = paths_.surfaces().arriving(valid, packet);
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
}

// Where emitters give little beside what the gathered rays brought, only some samples look at them: as many of each
// block, those of the same cells for all texels, so that their rays fill packets.
void FinalGather::sampleEmitters(const GatherGroup& group, int block, std::span<TexelLight> lights, uint64_t& rays)
{
    constexpr int kBlock = GatherPattern::kBlock;
    beginBlock();
    std::array<bool, kLanes> use{};
    std::array<int, kLanes> looking{}; ///< samples of the block
    std::array<GatherPattern::Block, kLanes> points;
    std::array<int, kLanes> turn{};
    for (int i = 0; i < group.lanes(); ++i) {
        const auto lane = std::size_t(i);
        const TexelSum& gathered = lights[lane].gathered;
        use[lane] = group.active(i) && int(gathered.blocks()) > block;
        if (!use[lane]) continue;
        const float chance = PathTracer::emitterChance(cut_.total[lane], luminance(gathered.mean()));
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
            LightTree::Cut::Lanes<vec2> u;
            const int rank = GatherPattern::rankOf(int(cell), block);
            for (std::size_t lane = 0; lane < kLanes; ++lane) {
                positions.set(lane, bundle_.origin(cell, int(lane)));
                looks[lane] = rank < looking[lane];
                if (looks[lane]) u[lane] = points[lane].unit(int(cell) ^ turn[lane]);
            }
            paths_.emitters().sample(cut_, positions, bundle_.frame(cell).normal, looks, u, lanes);
            for (std::size_t lane = 0; lane < kLanes; ++lane) {
                const float times = float(kBlock) / float(std::max(looking[lane], 1));
                lanes.radiance.x[lane] *= times;
                lanes.radiance.y[lane] *= times;
                lanes.radiance.z[lane] *= times;
            }
        },
        rays);
    for (int lane = 0; lane < group.lanes(); ++lane) {
        TexelLight& light = lights[std::size_t(lane)];
        if (use[std::size_t(lane)]) endBlock(lane, light, light.emitted);
    }
}

} // namespace halflight
