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

void FinalGather::add(const TexelGroup& group, int firstBlock, int blockCount, std::span<TexelSum> sums, uint64_t& rays)
{
    const bool emitters = !paths_.emitters().empty();
    for (int lane = 0; emitters && lane < group.lanes(); ++lane) {
        if (!group.active(lane)) continue;
        const TexelGroup::Slot& s = group.slot(lane, 0);
        cuts_[std::size_t(lane)] = paths_.emitters().cut(s.origin, s.normal);
    }
    for (int b = firstBlock; b < firstBlock + blockCount; ++b) {
        irradiance_.fill(vec3(0.0f));
        moment_.fill(vec3(0.0f));
        backFaces_.fill(0);
        gatherBlock(group, b, rays);
        if (emitters) sampleEmitters(group, b, rays);
        constexpr float kShare = 1.0f / float(GatherPattern::kBlock);
        for (int lane = 0; lane < group.lanes(); ++lane) {
            if (!group.active(lane)) continue;
            // Lights of extreme size or strength can leave the range of floats.
            const vec3 irradiance = irradiance_[std::size_t(lane)] * kShare;
            const bool finite = isFinite(irradiance) && isFinite(moment_[std::size_t(lane)]);
            sums[std::size_t(lane)].add(finite ? irradiance : vec3(0.0f),
                                        finite ? moment_[std::size_t(lane)] * kShare : vec3(0.0f));
            sums[std::size_t(lane)].backFaces =
                uint16_t(sums[std::size_t(lane)].backFaces + backFaces_[std::size_t(lane)]);
        }
    }
}

// Irradiance is pi times the mean of cosine-distributed radiance (pdf cos / pi). Most rays are over with one look into
// the cache: they are handled in three sweeps, so that each sweep's memory is on its way while others are worked on.
void FinalGather::gatherBlock(const TexelGroup& group, int block, uint64_t& rays)
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
            w = tracer.hitIndex(hit.geomID[lane], hit.primID[lane]);
            if (cache_ != nullptr) __builtin_prefetch(&cache_->surface(w));
        }
    }
    for (int cell = 0; cache_ != nullptr && cell < GatherPattern::kBlock; ++cell) {
        const RTCRayHit8& packet = bundle_.rays[std::size_t(cell)];
        for (int lane = 0; lane < TexelGroup::kLanes; ++lane) {
            uint32_t& w = where[std::size_t(cell * TexelGroup::kLanes + lane)];
            if (w == kMissed) continue;
            const RadianceCache::Surface& surface = cache_->surface(w);
            w = kOther;
            if (bundle_.behind(cell, lane)) {
                if ((surface.firstCell & RadianceCache::kHiddenBack) != 0) ++backFaces_[std::size_t(lane)];
                continue;
            }
            if ((surface.firstCell & RadianceCache::kSlow) != 0) continue;
            w = cache_->cellIndex(surface, packet.hit.u[lane], packet.hit.v[lane]);
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
            vec3 radiance;
            if (w == kMissed) {
                radiance = shading::skyRadiance(sky.zenith, sky.horizon, sky.ground, direction);
            } else if (cache_ != nullptr && w != kOther && packet.ray.tfar[lane] >= cache_->cells()[w].nearest) {
                radiance = cache_->cells()[w].radiance;
            } else {
                radiance = slowRadiance(group, lane, block, cell, rays);
            }
            count(lane, kPi * radiance, direction);
        }
    }
}

vec3 FinalGather::slowRadiance(const TexelGroup& group, int lane, int block, int cell, uint64_t& rays)
{
    const TexelGroup::Slot& s = group.slot(lane, group.slotOf(lane, block, cell));
    const SurfaceHit hit = bundle_.surface(paths_, cell, lane);
    if (cache_ == nullptr && hit.backFace) ++backFaces_[std::size_t(lane)];
    const vec3 direction = bundle_.direction(cell, lane);
    const float pdf = std::max(glm::dot(direction, s.normal), 1.0e-4f) / kPi;
    const Receiver receiver{s.origin, s.normal, &cuts_[std::size_t(lane)]};
    Sampler sampler(settings_.seed, group.id(lane), uint32_t(block * GatherPattern::kBlock + cell));
    return paths_.follow(hit, direction, receiver, pdf, settings_.bounces, sampler, rays, cache_);
}

// Where emitters give little beside what the gathered rays brought, only some samples look at them, and count for the
// others (Russian roulette: Arvo and Kirk 1990, "Particle Transport and Image Synthesis").
void FinalGather::sampleEmitters(const TexelGroup& group, int block, uint64_t& rays)
{
    constexpr float kLittle = 0.1f;
    std::array<float, TexelGroup::kLanes> chance;
    for (int lane = 0; lane < group.lanes(); ++lane) {
        const float gathered = luminance(irradiance_[std::size_t(lane)]) / float(GatherPattern::kBlock);
        const float share = cuts_[std::size_t(lane)].total / (kLittle * gathered);
        chance[std::size_t(lane)] = gathered > 0.0f ? std::clamp(share, 1.0f / 8.0f, 1.0f) : 1.0f;
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
            if (!group.active(lane)) continue;
            const float q = chance[std::size_t(lane)];
            if (q < 1.0f) {
                const uint32_t sample = uint32_t(block * GatherPattern::kBlock + cell);
                if (unitFloat(hashCombine(settings_.seed ^ kRouletteSeed ^ group.id(lane), sample)) >= q) continue;
            }
            const TexelGroup::Slot& s = group.slot(lane, group.slotOf(lane, block, cell));
            PathTracer::EmitterCandidate& c = candidates[std::size_t(lane)];
            c = paths_.emitterCandidate({s.origin, s.normal, &cuts_[std::size_t(lane)]}, s.geometricNormal,
                                        blocks[std::size_t(lane)].unit(cell));
            if (c.distance <= 0.0f) continue;
            valid.lane[lane] = -1;
            any = true;
            ++rays;
            packet.org_x[lane] = s.origin.x;
            packet.org_y[lane] = s.origin.y;
            packet.org_z[lane] = s.origin.z;
            packet.dir_x[lane] = c.direction.x;
            packet.dir_y[lane] = c.direction.y;
            packet.dir_z[lane] = c.direction.z;
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
}

} // namespace halflight
