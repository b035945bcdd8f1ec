#include "bake_cpu/final_gather.h"

#include "halflight/shading/sky.h"

#include <cmath>

namespace halflight {
namespace {

constexpr uint32_t kEmitterSeed = 0x5eed0006u;
constexpr uint32_t kRouletteSeed = 0x5eed0007u;

bool isFinite(vec3 v)
{
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

} // namespace

void FinalGather::beginBlock()
{
    irradiance_.fill(vec3(0.0f));
    moment_.fill(vec3(0.0f));
    inverseSquares_.fill(0.0f);
    backFaces_.fill(0);
}

void FinalGather::endBlock(int lane, TexelLight& light, TexelSum& sum)
{
    constexpr float kShare = 1.0f / float(GatherPattern::kBlock);
    const auto l = std::size_t(lane);
    // Lights of extreme size or strength can leave the range of floats.
    const vec3 irradiance = irradiance_[l] * kShare;
    const bool finite = isFinite(irradiance) && isFinite(moment_[l]);
    sum.add(finite ? irradiance : vec3(0.0f), finite ? moment_[l] * kShare : vec3(0.0f));
    light.inverseSquares += inverseSquares_[l];
    light.backFaces = uint16_t(light.backFaces + backFaces_[l]);
}

void FinalGather::cutEmitters(const GatherGroup& group)
{
    for (int lane = 0; lane < group.lanes(); ++lane) {
        if (!group.active(lane)) continue;
        const GatherGroup::Origin& s = group.origin(lane, 0);
        cuts_[std::size_t(lane)] = paths_.emitters().cut(s.position, s.normal);
    }
}

void FinalGather::add(const GatherGroup& group, int firstBlock, int blockCount, std::span<TexelLight> lights,
                      uint64_t& rays)
{
    const bool emitters = !paths_.emitters().empty();
    if (emitters) cutEmitters(group);
    for (int b = firstBlock; b < firstBlock + blockCount; ++b) {
        beginBlock();
        gatherBlock(group, b, rays);
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
        blocks = std::max(blocks, int(lights[std::size_t(lane)].gathered.blocks));
    cutEmitters(group);
    for (int b = 0; b < blocks; ++b) sampleEmitters(group, b, lights, rays);
}

// Irradiance is pi times the mean of cosine-distributed radiance (pdf cos / pi). Most rays are over with one look into
// the cache: they are handled in three sweeps, so that each sweep's memory is on its way while others are worked on.
void FinalGather::gatherBlock(const GatherGroup& group, int block, uint64_t& rays)
{
    rays += uint64_t(bundle_.trace(paths_, pattern_, group, settings_.seed, block, kAllCells));
    const SurfaceTracer& tracer = paths_.surfaces();
    constexpr std::size_t kRays = std::size_t(GatherPattern::kBlock) * TexelGroup::kLanes;
    constexpr uint32_t kMissed = ~0u;
    constexpr uint32_t kOther = ~0u - 1u;
    std::array<uint32_t, kRays> where; // record of the triangle, then cell
    for (int cell = 0; cell < GatherPattern::kBlock; ++cell) {
        const RTCHit8& hit = bundle_.rays[std::size_t(cell)].hit;
        for (int lane = 0; lane < TexelGroup::kLanes; ++lane) {
            uint32_t& w = where[std::size_t(cell * TexelGroup::kLanes + lane)];
            w = kMissed;
            if (hit.geomID[lane] == RTC_INVALID_GEOMETRY_ID) continue;
            w = RadianceCache::recordOf(tracer, bundle_.rays[std::size_t(cell)], lane);
            if (cache_ != nullptr) __builtin_prefetch(&cache_->surface(w));
        }
    }
    for (int cell = 0; cache_ != nullptr && cell < GatherPattern::kBlock; ++cell) {
        const RTCRayHit8& packet = bundle_.rays[std::size_t(cell)];
        for (int lane = 0; lane < TexelGroup::kLanes; ++lane) {
            uint32_t& w = where[std::size_t(cell * TexelGroup::kLanes + lane)];
            if (w == kMissed) continue;
            if (cache_->hiddenBack(w)) ++backFaces_[std::size_t(lane)];
            const bool slow = (cache_->surface(w).firstCell & RadianceCache::kSlow) != 0;
            w = slow ? kOther : cache_->cellIndex(w, {packet.hit.u[lane], packet.hit.v[lane]});
            if (slow) continue;
            __builtin_prefetch(cache_->cells() + w);
        }
    }
    const Sky& sky = paths_.sky();
    const bool black = sky.black();
    for (int cell = 0; cell < GatherPattern::kBlock; ++cell) {
        const RTCRayHit8& packet = bundle_.rays[std::size_t(cell)];
        for (int lane = 0; lane < TexelGroup::kLanes; ++lane) {
            const uint32_t w = where[std::size_t(cell * TexelGroup::kLanes + lane)];
            if (!group.active(lane) || (w == kMissed && black)) continue;
            const vec3 direction = bundle_.direction(cell, lane);
            if (w != kMissed) {
                const float distance = packet.ray.tfar[lane];
                inverseSquares_[std::size_t(lane)] += 1.0f / (distance * distance);
            }
            vec3 radiance;
            if (w == kMissed) {
                radiance = shading::skyRadiance(sky.zenith, sky.horizon, sky.ground, direction);
            } else if (const vec3* known = cache_ != nullptr && w != kOther ? knownRadiance(cell, lane, w) : nullptr) {
                radiance = *known;
            } else {
                radiance = slowRadiance(group, lane, block, cell, rays);
            }
            count(lane, kPi * radiance, direction);
        }
    }
}

const vec3* FinalGather::knownRadiance(int cell, int lane, uint32_t square) const
{
    const RTCRayHit8& packet = bundle_.rays[std::size_t(cell)];
    const RadianceCache::Cell* c = cache_->cells() + square;
    if (packet.ray.tfar[lane] >= c->nearest) return &c->radiance;
    const uint32_t record = RadianceCache::recordOf(paths_.surfaces(), packet, lane);
    const uint32_t part = cache_->partIndex(record, {packet.hit.u[lane], packet.hit.v[lane]}, square);
    if (part == RadianceCache::kNoCells) return nullptr;
    c = cache_->cells() + part;
    return packet.ray.tfar[lane] >= c->nearest ? &c->radiance : nullptr;
}

vec3 FinalGather::slowRadiance(const GatherGroup& group, int lane, int block, int cell, uint64_t& rays)
{
    const GatherGroup::Origin& s = group.origin(lane, group.pointOf(lane, block, cell));
    const RayHit at = bundle_.at(cell, lane);
    if (cache_ == nullptr && paths_.surfaces().metHiddenBack(at)) ++backFaces_[std::size_t(lane)];
    const vec3 direction = bundle_.direction(cell, lane);
    const float pdf = std::max(glm::dot(direction, s.normal), 1.0e-4f) / kPi;
    const Receiver receiver{s.position, s.normal, &cuts_[std::size_t(lane)]};
    Sampler sampler(settings_.seed, group.id(lane), uint32_t(block * GatherPattern::kBlock + cell));
    return paths_.follow(at, direction, receiver, pdf, settings_.bounces, sampler, rays, cache_);
}

// Where emitters give little beside what the gathered rays brought, only some samples look at them.
void FinalGather::sampleEmitters(const GatherGroup& group, int block, std::span<TexelLight> lights, uint64_t& rays)
{
    beginBlock();
    std::array<bool, TexelGroup::kLanes> use{};
    std::array<float, TexelGroup::kLanes> chance;
    for (int lane = 0; lane < group.lanes(); ++lane) {
        const TexelSum& gathered = lights[std::size_t(lane)].gathered;
        use[std::size_t(lane)] = group.active(lane) && int(gathered.blocks) > block;
        chance[std::size_t(lane)] =
            PathTracer::emitterChance(cuts_[std::size_t(lane)].total, luminance(gathered.mean()));
    }
    std::array<GatherPattern::Block, TexelGroup::kLanes> blocks;
    for (int lane = 0; lane < group.lanes(); ++lane) {
        blocks[std::size_t(lane)] = pattern_.block(hashCombine(settings_.seed ^ kEmitterSeed, group.id(lane)), block);
    }
    RTCRay8 packet;
    alignas(32) embree::LaneMask valid;
    std::array<PathTracer::EmitterCandidate, TexelGroup::kLanes> candidates;
    for (int cell = 0; cell < GatherPattern::kBlock; ++cell) {
        SurfaceTracer::clear(packet);
        bool any = false;
        for (int lane = 0; lane < TexelGroup::kLanes; ++lane) {
            valid.lane[lane] = 0;
            if (!use[std::size_t(lane)]) continue;
            const float q = chance[std::size_t(lane)];
            if (q < 1.0f) {
                const uint32_t sample = uint32_t(block * GatherPattern::kBlock + cell);
                if (unitFloat(hashCombine(settings_.seed ^ kRouletteSeed ^ group.id(lane), sample)) >= q) continue;
            }
            const GatherGroup::Origin& s = group.origin(lane, group.pointOf(lane, block, cell));
            PathTracer::EmitterCandidate& c = candidates[std::size_t(lane)];
            c = paths_.emitterCandidate({s.position, s.normal, &cuts_[std::size_t(lane)]}, s.geometricNormal,
                                        blocks[std::size_t(lane)].unit(cell));
            if (c.distance <= 0.0f) continue;
            valid.lane[lane] = -1;
            any = true;
            ++rays;
            embree::setRay(packet, lane, s.position, c.direction);
            packet.tfar[lane] = c.distance * (1.0f - 1.0e-4f);
        }
        if (!any) continue;
        paths_.surfaces().occluded(valid, packet);
        for (int lane = 0; lane < TexelGroup::kLanes; ++lane) {
            if (valid.lane[lane] == 0 || packet.tfar[lane] < 0.0f) continue;
            count(lane, candidates[std::size_t(lane)].irradiance / chance[std::size_t(lane)],
                  candidates[std::size_t(lane)].direction);
        }
    }
    for (int lane = 0; lane < group.lanes(); ++lane) {
        TexelLight& light = lights[std::size_t(lane)];
        if (use[std::size_t(lane)]) endBlock(lane, light, light.emitted);
    }
}

} // namespace halflight
