// Filter functions: which surfaces a ray passes.
#include "bake_cpu/trace/embree_kernels.h"

#include "halflight/shading/random.h"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

namespace halflight {
namespace {

std::array<float, 6> originAndDirection(const RTCFilterFunctionNArguments* arguments, unsigned lane)
{
    RTCRayN* const rays = arguments->ray;
    const unsigned count = arguments->N;
    return {RTCRayN_org_x(rays, count, lane), RTCRayN_org_y(rays, count, lane), RTCRayN_org_z(rays, count, lane),
            RTCRayN_dir_x(rays, count, lane), RTCRayN_dir_y(rays, count, lane), RTCRayN_dir_z(rays, count, lane)};
}

} // namespace

bool EmbreeKernels::passes(uint32_t triangle, vec2 barycentric, const float* rayBits) const
{
    const float coverage = scene_.materials().coverageAt(triangle, barycentric);
    if (coverage >= 1.0f) return false;
    if (coverage <= 0.0f) return true;
    // A ray passes with probability 1 - coverage. The random number is a hash of the ray, so the filter needs no state.
    uint32_t bits = triangle;
    for (int i = 0; i < 6; ++i) bits = hashCombine(bits, std::bit_cast<uint32_t>(rayBits[i]));
    return unitFloat(bits) >= coverage;
}

/// Multiplies a ray's transmittance by a blended surface. False where the surface is not blended, or the ray has too
/// many.
bool EmbreeKernels::passesBlended(uint32_t triangle, vec2 barycentric, embree::BlendedTransmittance& ray) const
{
    if (!scene_.materials().of(triangle).blended) return false;
    // Embree may report a triangle that RTC_BUILD_QUALITY_HIGH splits more than once.
    const auto end = ray.triangle.begin() + ray.count;
    if (std::find(ray.triangle.begin(), end, triangle) != end) return true;
    const float coverage = scene_.materials().coverageAt(triangle, barycentric);
    if (coverage >= 1.0f || end == ray.triangle.end()) return false;
    ray.triangle[std::size_t(ray.count++)] = triangle;
    ray.transmittance *= 1.0f - coverage;
    return true;
}

/// Keeps the colour of a face of glass that a ray passes. False where it does not pass, or the face has no colour and
/// is passed by chance.
bool EmbreeKernels::passesGlass(const RTCFilterFunctionNArguments* arguments, unsigned lane, uint32_t triangle,
                                vec2 barycentric, const BakeGeometry::Instance* place)
{
    const auto* user = static_cast<const GeometryUser*>(arguments->geometryUserPtr);
    const auto* context = reinterpret_cast<const embree::RayContext*>(arguments->context);
    const EmbreeKernels& kernels = *user->kernels;
    const TransportMaterial& material = kernels.scene_.materials().of(triangle);
    if (!material.blended || (context->byChance && !material.tints)) return false;
    const unsigned count = arguments->N;
    embree::PassedGlass& passed = context->glass[RTCRayN_id(arguments->ray, count, lane)];
    if (passed.full()) return false;
    const std::array<float, 6> ray = originAndDirection(arguments, lane);
    const vec3 along(ray[3], ray[4], ray[5]);
    const vec3 direction = place != nullptr ? place->linear * along : along;
    const Materials::Glass glass = kernels.scene_.materials().glassAt(triangle, barycentric, direction);
    const bool back = glm::dot(kernels.scene_.geometry().geometricNormal(triangle), direction) > 0.0f;
    const vec3 leaving = back ? glass.attenuation : -glass.attenuation;
    embree::PassedGlass::Face face{triangle, RTCRayN_tfar(arguments->ray, count, lane), glass.passed, leaving};
    if (context->camera && back && !material.doubleSided) {
        face.passed = vec3(1.0f); // as if the back were not there
    } else if (context->byChance) {
        if (glass.coverage >= 1.0f || !kernels.passes(triangle, barycentric, ray.data())) return false;
        face.passed /= 1.0f - glass.coverage;
    } else if (glass.coverage >= 1.0f) {
        return false;
    }
    if (!passed.knows(face)) passed.add(face);
    return true;
}

void EmbreeKernels::filter(const RTCFilterFunctionNArguments* arguments)
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
        if (context->glass != nullptr && passesGlass(arguments, i, triangle, barycentric, place)) {
            arguments->valid[i] = 0;
            continue;
        }
        if (context->blended != nullptr &&
            user->kernels->passesBlended(triangle, barycentric,
                                         context->blended[RTCRayN_id(arguments->ray, count, i)])) {
            arguments->valid[i] = 0;
            continue;
        }
        if (user->kernels->passes(triangle, barycentric, originAndDirection(arguments, i).data()))
            arguments->valid[i] = 0;
    }
}

void EmbreeKernels::countSolids(const RTCFilterFunctionNArguments* arguments)
{
    const auto* user = static_cast<const GeometryUser*>(arguments->geometryUserPtr);
    embree::SolidsPassed& solids = *reinterpret_cast<const embree::RayContext*>(arguments->context)->solids;
    const unsigned count = arguments->N;
    for (unsigned i = 0; i < count; ++i) {
        if (arguments->valid[i] != -1) continue;
        arguments->valid[i] = 0; // the ray goes on
        bool back = false;
        const uint32_t triangle = user->triangle(arguments, i, back);
        if (!user->kernels->scene_.geometry().isSolid(triangle)) continue;
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

void EmbreeKernels::passHiddenBacks(const RTCFilterFunctionNArguments* arguments)
{
    const auto* user = static_cast<const GeometryUser*>(arguments->geometryUserPtr);
    const unsigned count = arguments->N;
    for (unsigned i = 0; i < count; ++i) {
        if (arguments->valid[i] != -1) continue;
        bool back = false;
        const uint32_t triangle = user->triangle(arguments, i, back);
        if (back && user->kernels->scene_.materials().backIsHidden(triangle)) arguments->valid[i] = 0;
    }
}

} // namespace halflight
