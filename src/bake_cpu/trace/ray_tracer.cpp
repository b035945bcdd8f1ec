#include "bake_cpu/trace/ray_tracer.h"

#include "bake_cpu/trace/embree_device.h"

#include "halflight/base/random.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace halflight {
RayTracer::RayTracer(const Scene& scene, const BakeGeometry& geometry, InstructionSet isa, RTCBuildQuality tree)
    : geometry_(geometry), materials_(scene, geometry), meshTrees_(geometry, materials_)
{
    sortTriangles();
    device_ = embree::openDevice(isa);
    if (device_ == nullptr) return;
    embreeBytes_.watch(device_);
    packets_ = embree::takesPackets(device_);
    RTCScene embreeScene = rtcNewScene(device_);
    if (build(embreeScene, tree)) {
        scene_ = embreeScene;
    } else {
        rtcReleaseScene(embreeScene);
    }
}

RayTracer::~RayTracer()
{
    if (scene_ != nullptr) rtcReleaseScene(scene_);
    for (const MeshTree& tree : meshTrees_.trees) {
        if (tree.scene != nullptr) rtcReleaseScene(tree.scene);
    }
    if (device_ != nullptr) rtcReleaseDevice(device_);
}

uint32_t RayTracer::treeTriangleCount() const
{
    std::size_t count = 0;
    for (const auto& list : trianglesOfKind_) count += list.size();
    for (const MeshTree& tree : meshTrees_.trees) count += tree.triangles.size();
    return uint32_t(count);
}

std::size_t RayTracer::peakBytes() const
{
    std::size_t bytes = embreeBytes_.most() + meshTrees_.byteCount();
    for (const auto& list : trianglesOfKind_) bytes += list.capacity() * sizeof(uint32_t);
    return bytes + firstHit_.capacity() * sizeof(uint32_t);
}

float RayTracer::epsilonAt(vec3 position) const
{
    const float magnitude = std::max({std::abs(position.x), std::abs(position.y), std::abs(position.z)});
    return std::max(8.0e-7f * magnitude, 2.0e-6f * sceneScale_);
}

bool RayTracer::passes(uint32_t triangle, vec2 barycentric, const float* rayBits) const
{
    const float coverage = materials_.coverageAt(triangle, barycentric);
    if (coverage >= 1.0f) return false;
    if (coverage <= 0.0f) return true;
    // A ray passes with probability 1 - coverage. The random number is a hash of the ray, so the filter needs no state.
    uint32_t bits = triangle;
    for (int i = 0; i < 6; ++i) bits = hashCombine(bits, std::bit_cast<uint32_t>(rayBits[i]));
    return unitFloat(bits) >= coverage;
}

/// Multiplies a ray's transmittance by a blended surface. False where the surface is not blended, or the ray has too
/// many.
bool RayTracer::passesBlended(uint32_t triangle, vec2 barycentric, embree::BlendedTransmittance& ray) const
{
    if (!materials_.of(triangle).blended) return false;
    // Embree may report a triangle that RTC_BUILD_QUALITY_HIGH splits more than once.
    const auto end = ray.triangle.begin() + ray.count;
    if (std::find(ray.triangle.begin(), end, triangle) != end) return true;
    const float coverage = materials_.coverageAt(triangle, barycentric);
    if (coverage >= 1.0f || end == ray.triangle.end()) return false;
    ray.triangle[std::size_t(ray.count++)] = triangle;
    ray.transmittance *= 1.0f - coverage;
    return true;
}

void RayTracer::filter(const RTCFilterFunctionNArguments* arguments)
{
    const auto* user = static_cast<const GeometryUser*>(arguments->geometryUserPtr);
    const auto* context = reinterpret_cast<const embree::RayContext*>(arguments->context);
    const unsigned count = arguments->N;
    for (unsigned i = 0; i < count; ++i) {
        if (arguments->valid[i] != -1) continue;
        if (!user->castShadows && !context->camera) {
            arguments->valid[i] = 0;
            continue;
        }
        const BakeGeometry::Instance* place = nullptr;
        const uint32_t triangle = user->triangle(RTCHitN_instID(arguments->hit, count, i, 0),
                                                 RTCHitN_primID(arguments->hit, count, i), place);
        vec2 barycentric(RTCHitN_u(arguments->hit, count, i), RTCHitN_v(arguments->hit, count, i));
        if (place != nullptr && place->mirrored) std::swap(barycentric.x, barycentric.y);
        if (context->blended != nullptr &&
            user->tracer->passesBlended(triangle, barycentric,
                                        context->blended[RTCRayN_id(arguments->ray, count, i)])) {
            arguments->valid[i] = 0;
            continue;
        }
        const float ray[6] = {RTCRayN_org_x(arguments->ray, count, i), RTCRayN_org_y(arguments->ray, count, i),
                              RTCRayN_org_z(arguments->ray, count, i), RTCRayN_dir_x(arguments->ray, count, i),
                              RTCRayN_dir_y(arguments->ray, count, i), RTCRayN_dir_z(arguments->ray, count, i)};
        if (user->tracer->passes(triangle, barycentric, ray)) arguments->valid[i] = 0;
    }
}

static RTCRayHit rayHit(vec3 origin, vec3 direction, float tMin, float tMax)
{
    RTCRayHit ray{};
    ray.ray.org_x = origin.x;
    ray.ray.org_y = origin.y;
    ray.ray.org_z = origin.z;
    ray.ray.dir_x = direction.x;
    ray.ray.dir_y = direction.y;
    ray.ray.dir_z = direction.z;
    ray.ray.tnear = tMin;
    ray.ray.tfar = tMax;
    ray.ray.mask = ~0u;
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    return ray;
}

RayHit RayTracer::nearest(vec3 origin, vec3 direction, float tMin, float tMax, bool cameraRay) const
{
    embree::RayContext context(cameraRay);
    // Camera rays continue behind backs of single-sided surfaces. The limit ends loops on damaged geometry.
    for (int layer = 0; layer < 256; ++layer) {
        RTCRayHit ray = rayHit(origin, direction, tMin, tMax);
        intersect(context, ray);
        if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};

        const bool back = ray.hit.Ng_x * direction.x + ray.hit.Ng_y * direction.y + ray.hit.Ng_z * direction.z > 0.0f;
        if (cameraRay && back && !materials_.of(triangleOf(ray.hit.geomID, ray.hit.primID)).doubleSided) {
            tMin = ray.ray.tfar * (1.0f + 1.0e-6f) + epsilonAt(origin);
            continue;
        }
        return {true, back, ray.hit.geomID, ray.hit.primID, vec2(ray.hit.u, ray.hit.v), ray.ray.tfar};
    }
    return {};
}

SurfaceHit RayTracer::surfaceAt(const RayHit& at) const
{
    const uint32_t triangle = triangleOf(at.geomID, at.primID);
    SurfaceHit hit{at.distance, &materials_.of(triangle), surfacePoint(geometry_, triangle, at.barycentric)};
    if (at.back) {
        hit.point.normal = -hit.point.normal;
        hit.point.geometricNormal = -hit.point.geometricNormal;
    }
    hit.reflectance = materials_.reflectanceAt(triangle, at.barycentric);
    if (!hitHiddenBack(at)) hit.emission = materials_.emissionAt(triangle, at.barycentric);
    return hit;
}

uint32_t RayTracer::triangleAt(uint32_t hitIndex) const
{
    const auto next = std::upper_bound(firstHit_.begin(), firstHit_.end(), hitIndex);
    const auto geomID = uint32_t(next - firstHit_.begin()) - 1;
    return triangleOf(geomID, hitIndex - firstHit_[geomID]);
}

void RayTracer::toWorld(RTCHit& hit) const
{
    if (hit.instID[0] == RTC_INVALID_GEOMETRY_ID) return;
    const MeshTrees::Instance& instance = meshTrees_.instances[hit.instID[0] - KindCount];
    hit.primID += meshTrees_.treeOf(instance).firstOfKind[hit.geomID];
    hit.geomID = hit.instID[0];
    if (instance.place->mirrored) std::swap(hit.u, hit.v);
    const vec3 normal = instance.place->worldFromNormal * vec3(hit.Ng_x, hit.Ng_y, hit.Ng_z);
    hit.Ng_x = normal.x;
    hit.Ng_y = normal.y;
    hit.Ng_z = normal.z;
}

/// A front in the place of a hidden back, if there is one: where two surfaces lie back to back, rounding would decide
/// which of them a ray hits.
void RayTracer::preferFront(vec3 origin, vec3 direction, RTCHit& hit, float& distance) const
{
    if (hit.Ng_x * direction.x + hit.Ng_y * direction.y + hit.Ng_z * direction.z <= 0.0f) return;
    if (!materials_.backIsHidden(triangleOf(hit.geomID, hit.primID))) return;
    const float near = distance * 1.0e-6f + epsilonAt(origin + direction * distance);
    embree::RayContext context(false);
    RTCRayHit ray = rayHit(origin, direction, std::max(distance - near, 0.0f), distance + near);
    embree::intersect(scene_, context, ray, passHiddenBacks);
    if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return;
    toWorld(ray.hit);
    hit = ray.hit;
    distance = ray.ray.tfar;
}

void RayTracer::intersect(embree::RayContext& context, RTCRayHit& ray) const
{
    embree::intersect(scene_, context, ray);
    if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return;
    toWorld(ray.hit);
    if (!context.camera)
        preferFront({ray.ray.org_x, ray.ray.org_y, ray.ray.org_z}, {ray.ray.dir_x, ray.ray.dir_y, ray.ray.dir_z},
                    ray.hit, ray.ray.tfar);
}

void RayTracer::intersect(const embree::LaneMask& valid, RTCRayHit8& rays) const
{
    embree::RayContext context(false);
    for (int i = 0; i < embree::kPacket; ++i) {
        rays.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
        rays.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
    embree::intersect8(scene_, context, valid, rays, packets_);
    auto* const hits = reinterpret_cast<RTCHitN*>(&rays.hit);
    for (unsigned i = 0; i < embree::kPacket; ++i) {
        if (valid.lane[i] == 0 || rays.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
        const bool inInstance = rays.hit.instID[0][i] != RTC_INVALID_GEOMETRY_ID;
        if (!inInstance && !embree::hitBack(rays, int(i))) continue;
        RTCHit hit = rtcGetHitFromHitN(hits, embree::kPacket, i);
        toWorld(hit);
        preferFront({rays.ray.org_x[i], rays.ray.org_y[i], rays.ray.org_z[i]}, embree::directionOf(rays.ray, int(i)),
                    hit, rays.ray.tfar[i]);
        rtcCopyHitToHitN(hits, &hit, embree::kPacket, i);
    }
}

void RayTracer::occluded(const embree::LaneMask& valid, RTCRay8& rays) const
{
    embree::RayContext context(false);
    occluded(context, valid, rays);
}

void RayTracer::occluded(embree::RayContext& context, const embree::LaneMask& valid, RTCRay8& rays) const
{
    embree::occluded8(scene_, context, valid, rays, packets_);
}

std::array<float, embree::kPacket> RayTracer::transmittance(const embree::LaneMask& valid, RTCRay8& rays) const
{
    std::array<embree::BlendedTransmittance, embree::kPacket> blended;
    embree::RayContext context(false);
    if (anyBlended_) context.blended = blended.data();
    for (unsigned i = 0; i < embree::kPacket; ++i) rays.id[i] = i;
    occluded(context, valid, rays);
    std::array<float, embree::kPacket> result;
    for (std::size_t i = 0; i < embree::kPacket; ++i) {
        result[i] = rays.tfar[i] < 0.0f ? 0.0f : blended[i].transmittance;
    }
    return result;
}

void RayTracer::countSolids(const RTCFilterFunctionNArguments* arguments)
{
    const auto* user = static_cast<const GeometryUser*>(arguments->geometryUserPtr);
    embree::SolidsPassed& solids = *reinterpret_cast<const embree::RayContext*>(arguments->context)->solids;
    const unsigned count = arguments->N;
    for (unsigned i = 0; i < count; ++i) {
        if (arguments->valid[i] != -1) continue;
        arguments->valid[i] = 0; // the ray goes on
        bool back = false;
        const uint32_t triangle = user->triangle(arguments, i, back);
        if (!user->tracer->geometry_.isSolid(triangle)) continue;
        // Embree may report a triangle that RTC_BUILD_QUALITY_HIGH splits more than once.
        const auto end = solids.triangles.begin() + solids.count;
        if (std::find(solids.triangles.begin(), end, triangle) != end) continue;
        if (end == solids.triangles.end()) {
            solids.left = 0;
            arguments->valid[i] = -1; // ends the ray
            return;
        }
        solids.triangles[std::size_t(solids.count++)] = triangle;
        solids.left += back ? 1 : -1;
    }
}

void RayTracer::passHiddenBacks(const RTCFilterFunctionNArguments* arguments)
{
    const auto* user = static_cast<const GeometryUser*>(arguments->geometryUserPtr);
    const unsigned count = arguments->N;
    for (unsigned i = 0; i < count; ++i) {
        if (arguments->valid[i] != -1) continue;
        bool back = false;
        const uint32_t triangle = user->triangle(arguments, i, back);
        if (back && user->tracer->materials_.backIsHidden(triangle)) arguments->valid[i] = 0;
    }
}

int RayTracer::solidsLeft(vec3 origin, vec3 direction) const
{
    embree::SolidsPassed solids;
    embree::RayContext context(false);
    context.solids = &solids;
    RTCRay ray = rayHit(origin, direction, 0.0f, kInfinity).ray;
    embree::occluded(scene_, context, ray, countSolids);
    return solids.left;
}

bool RayTracer::occluded(vec3 origin, vec3 direction, float tMin, float tMax) const
{
    embree::RayContext context(false);
    return occluded(context, origin, direction, tMin, tMax);
}

float RayTracer::transmittance(vec3 origin, vec3 direction, float tMin, float tMax) const
{
    embree::BlendedTransmittance blended;
    embree::RayContext context(false);
    if (anyBlended_) context.blended = &blended;
    return occluded(context, origin, direction, tMin, tMax) ? 0.0f : blended.transmittance;
}

bool RayTracer::occluded(embree::RayContext& context, vec3 origin, vec3 direction, float tMin, float tMax) const
{
    RTCRay ray = rayHit(origin, direction, tMin, tMax).ray;
    embree::occluded(scene_, context, ray);
    return ray.tfar < 0.0f;
}

} // namespace halflight
