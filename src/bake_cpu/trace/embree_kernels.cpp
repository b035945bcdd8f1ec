#include "bake_cpu/trace/embree_kernels.h"

#include "bake_cpu/trace/ray_packet.h"

#include <algorithm>
#include <utility>

namespace halflight {
namespace {

RTCRayHit embreeRay(const Ray& from)
{
    RTCRayHit ray{};
    ray.ray.org_x = from.origin.x;
    ray.ray.org_y = from.origin.y;
    ray.ray.org_z = from.origin.z;
    ray.ray.dir_x = from.direction.x;
    ray.ray.dir_y = from.direction.y;
    ray.ray.dir_z = from.direction.z;
    ray.ray.tnear = from.tMin;
    ray.ray.tfar = from.tMax;
    ray.ray.mask = ~0u;
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    return ray;
}

bool isBack(const RTCHit& hit, vec3 direction)
{
    return hit.Ng_x * direction.x + hit.Ng_y * direction.y + hit.Ng_z * direction.z > 0.0f;
}

/// What a ray that hits nothing has met: glass.
RayHit missOf(vec3 tint)
{
    RayHit miss;
    miss.tint = tint;
    return miss;
}

/// Calls body(first, count) for rays eight at a time.
template<typename Body> void forPackets(std::size_t rayCount, const Body& body)
{
    for (std::size_t i = 0; i < rayCount; i += embree::kPacket)
        body(i, std::min(rayCount - i, std::size_t(embree::kPacket)));
}

} // namespace

/// A hit of a triangle in the world.
RayHit EmbreeKernels::hitOf(const RTCHit& hit, vec3 direction, float distance) const
{
    RayHit at;
    at.face = {scene_.hitIndex(hit.geomID, hit.primID), isBack(hit, direction) ? 1u : 0u};
    at.barycentric = vec2(hit.u, hit.v);
    at.distance = distance;
    return at;
}

/// Makes a hit of an instance one of a triangle in the world, whose geomID and primID are RayScene's list and index.
void EmbreeKernels::toWorld(RTCHit& hit) const
{
    if (hit.instID[0] == RTC_INVALID_GEOMETRY_ID) return;
    const MeshTrees::Instance& instance = scene_.meshTrees().instances[hit.instID[0] - KindCount];
    hit.primID += scene_.meshTrees().treeOf(instance).firstOfKind[hit.geomID];
    hit.geomID = hit.instID[0];
    if (instance.place->mirrored) std::swap(hit.u, hit.v);
    const vec3 normal = instance.place->worldFromNormal * vec3(hit.Ng_x, hit.Ng_y, hit.Ng_z);
    hit.Ng_x = normal.x;
    hit.Ng_y = normal.y;
    hit.Ng_z = normal.z;
}

/// A front in the place of a hidden back, if there is one: where two surfaces lie back to back, rounding would decide
/// which of them a ray hits.
void EmbreeKernels::preferFront(vec3 origin, vec3 direction, RTCHit& hit, float& distance) const
{
    if (!isBack(hit, direction)) return;
    if (!scene_.materials().backIsHidden(scene_.triangleOf(hit.geomID, hit.primID))) return;
    const float near = distance * 1.0e-6f + scene_.epsilonAt(origin + direction * distance);
    embree::RayContext context(false);
    RTCRayHit ray = embreeRay({origin, std::max(distance - near, 0.0f), direction, distance + near});
    embree::intersect(tree_, context, ray, passHiddenBacks);
    if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return;
    toWorld(ray.hit);
    hit = ray.hit;
    distance = ray.ray.tfar;
}

RayHit EmbreeKernels::nearest(const Ray& from, RayUse use) const
{
    if (from.meetsNothing()) return {};
    const bool camera = use == RayUse::Camera;
    embree::RayContext context(camera);
    embree::PassedGlass glass;
    if (scene_.anyTinted()) context.glass = &glass;
    const auto tintUpTo = [&](float end) { return context.glass != nullptr ? glass.transmittance(end) : vec3(1.0f); };
    float tMin = from.tMin;
    // Camera rays continue behind backs of single-sided surfaces. The limit ends loops on damaged geometry.
    for (int layer = 0; layer < 256; ++layer) {
        RTCRayHit ray = embreeRay({from.origin, tMin, from.direction, from.tMax});
        embree::intersect(tree_, context, ray);
        if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return missOf(tintUpTo(from.tMax));
        toWorld(ray.hit);
        if (!camera) preferFront(from.origin, from.direction, ray.hit, ray.ray.tfar);
        RayHit hit = hitOf(ray.hit, from.direction, ray.ray.tfar);
        if (!camera || hit.face.back == 0 ||
            scene_.materials().of(scene_.triangleOf(ray.hit.geomID, ray.hit.primID)).doubleSided) {
            hit.tint = tintUpTo(hit.distance);
            return hit;
        }
        tMin = ray.ray.tfar * (1.0f + 1.0e-6f) + scene_.epsilonAt(from.origin);
    }
    return missOf(tintUpTo(from.tMax));
}

void EmbreeKernels::nearestOfPacket(std::span<const Ray> rays, std::span<RayHit> out) const
{
    RTCRayHit8 packet;
    const embree::LaneMask valid = embree::fill(packet.ray, rays);
    for (int i = 0; i < embree::kPacket; ++i) {
        packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
        packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
    embree::RayContext context(false);
    std::array<embree::PassedGlass, embree::kPacket> glass;
    if (scene_.anyTinted()) {
        context.glass = glass.data();
        for (unsigned i = 0; i < embree::kPacket; ++i) packet.ray.id[i] = i;
    }
    embree::intersect8(tree_, context, valid, packet, packets_);
    auto* const hits = reinterpret_cast<RTCHitN*>(&packet.hit);
    for (unsigned i = 0; i < rays.size(); ++i) {
        out[i] = {};
        if (valid.lane[i] == 0) continue;
        if (packet.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) {
            if (context.glass != nullptr) out[i].tint = glass[i].transmittance(rays[i].tMax);
            continue;
        }
        RTCHit hit = rtcGetHitFromHitN(hits, embree::kPacket, i);
        toWorld(hit);
        preferFront(rays[i].origin, rays[i].direction, hit, packet.ray.tfar[i]);
        out[i] = hitOf(hit, rays[i].direction, packet.ray.tfar[i]);
        if (context.glass != nullptr) out[i].tint = glass[i].transmittance(out[i].distance);
    }
}

Status EmbreeKernels::nearest(std::span<const Ray> rays, std::span<RayHit> out, RayUse use) const
{
    if (rays.size() == 1 || use == RayUse::Camera) {
        for (std::size_t i = 0; i < rays.size(); ++i) out[i] = nearest(rays[i], use);
        return {};
    }
    forPackets(rays.size(), [&](std::size_t first, std::size_t count) {
        nearestOfPacket(rays.subspan(first, count), out.subspan(first, count));
    });
    return {};
}

bool EmbreeKernels::occluded(const Ray& from, embree::RayContext& context) const
{
    if (from.meetsNothing()) return false;
    RTCRay ray = embreeRay(from).ray;
    embree::occluded(tree_, context, ray);
    return ray.tfar < 0.0f;
}

Status EmbreeKernels::occluded(std::span<const Ray> rays, std::span<bool> out) const
{
    embree::RayContext context(false);
    if (rays.size() == 1) {
        out[0] = occluded(rays[0], context);
        return {};
    }
    forPackets(rays.size(), [&](std::size_t first, std::size_t count) {
        RTCRay8 packet;
        const embree::LaneMask valid = embree::fill(packet, rays.subspan(first, count));
        embree::occluded8(tree_, context, valid, packet, packets_);
        for (std::size_t i = 0; i < count; ++i) out[first + i] = valid.lane[i] != 0 && packet.tfar[i] < 0.0f;
    });
    return {};
}

Status EmbreeKernels::transmittance(std::span<const Ray> rays, std::span<vec3> out) const
{
    if (scene_.anyTinted()) {
        forPackets(rays.size(), [&](std::size_t first, std::size_t count) {
            coloredTransmittance(rays.subspan(first, count), out.subspan(first, count));
        });
        return {};
    }
    if (rays.size() == 1) {
        embree::BlendedTransmittance blended;
        embree::RayContext context(false);
        if (scene_.anyBlended()) context.blended = &blended;
        out[0] = vec3(occluded(rays[0], context) ? 0.0f : blended.transmittance);
        return {};
    }
    forPackets(rays.size(), [&](std::size_t first, std::size_t count) {
        std::array<embree::BlendedTransmittance, embree::kPacket> blended;
        embree::RayContext context(false);
        if (scene_.anyBlended()) context.blended = blended.data();
        RTCRay8 packet;
        const embree::LaneMask valid = embree::fill(packet, rays.subspan(first, count));
        for (unsigned i = 0; i < embree::kPacket; ++i) packet.id[i] = i;
        embree::occluded8(tree_, context, valid, packet, packets_);
        for (std::size_t i = 0; i < count; ++i) {
            const bool hidden = valid.lane[i] != 0 && packet.tfar[i] < 0.0f;
            out[first + i] = vec3(hidden ? 0.0f : blended[i].transmittance);
        }
    });
    return {};
}

/// Of one packet, in a scene whose glass has a colour.
void EmbreeKernels::coloredTransmittance(std::span<const Ray> rays, std::span<vec3> out) const
{
    std::array<embree::PassedGlass, embree::kPacket> glass;
    embree::RayContext context(false);
    context.glass = glass.data();
    context.byChance = false;
    if (rays.size() == 1) {
        out[0] = occluded(rays[0], context) ? vec3(0.0f) : glass[0].transmittance(rays[0].tMax);
        return;
    }
    RTCRay8 packet;
    const embree::LaneMask valid = embree::fill(packet, rays);
    for (unsigned i = 0; i < embree::kPacket; ++i) packet.id[i] = i;
    embree::occluded8(tree_, context, valid, packet, packets_);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const bool hidden = valid.lane[i] != 0 && packet.tfar[i] < 0.0f;
        out[i] = hidden ? vec3(0.0f) : glass[i].transmittance(rays[i].tMax);
    }
}

Status EmbreeKernels::crossings(std::span<const Ray> rays, std::span<int> out) const
{
    for (std::size_t i = 0; i < rays.size(); ++i) {
        embree::SolidsPassed solids;
        embree::RayContext context(false);
        context.solids = &solids;
        RTCRay ray = embreeRay(rays[i]).ray;
        if (!rays[i].meetsNothing()) embree::occluded(tree_, context, ray, countSolids);
        out[i] = solids.left;
    }
    return {};
}

} // namespace halflight
