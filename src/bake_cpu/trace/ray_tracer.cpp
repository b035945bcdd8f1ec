#include "bake_cpu/trace/ray_tracer.h"

#include "shading/srgb_table.h"

#include "halflight/base/parallel.h"
#include "halflight/base/random.h"
#include "halflight/shading/brdf.h"
#include "halflight/shading/color.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <memory>

namespace halflight {
namespace {

constexpr int kSmallTextureSide = 256;

vec3 linearOf(u8vec4 texel)
{
    return {shading::kLinearFromSrgb8[texel.x], shading::kLinearFromSrgb8[texel.y], shading::kLinearFromSrgb8[texel.z]};
}

/// Averages blocks of texels in linear light; data textures (not sRGB) go through the same curve and back, which
/// changes a mean of metallic and roughness values a little and nothing else.
ImageRgba8 shrink(const ImageRgba8& image)
{
    const int factor =
        std::max(1, (std::max(image.width(), image.height()) + kSmallTextureSide - 1) / kSmallTextureSide);
    if (factor == 1) return image;
    ImageRgba8 out(std::max(1, image.width() / factor), std::max(1, image.height() / factor));
    for (int y = 0; y < out.height(); ++y) {
        const int endY = std::min((y + 1) * factor, image.height());
        for (int x = 0; x < out.width(); ++x) {
            const int beginX = x * factor;
            const int endX = std::min(beginX + factor, image.width());
            vec3 sum(0.0f);
            int alpha = 0;
            for (int py = y * factor; py < endY; ++py) {
                const u8vec4* row = &image(beginX, py);
                for (int i = 0; i < endX - beginX; ++i) {
                    sum += linearOf(row[i]);
                    alpha += row[i].w;
                }
            }
            const int count = (endY - y * factor) * (endX - beginX);
            const vec3 mean = shading::srgbFromLinear(sum / float(count)) * 255.0f + 0.5f;
            out(x, y) = u8vec4(u8vec4::value_type(mean.x), u8vec4::value_type(mean.y), u8vec4::value_type(mean.z),
                               u8vec4::value_type(float(alpha) / float(count) + 0.5f));
        }
    }
    return out;
}

int wrap(int i, int size, Texture::Wrap mode)
{
    if (unsigned(i) < unsigned(size)) return i;
    switch (mode) {
    case Texture::Wrap::ClampToEdge:
        return std::clamp(i, 0, size - 1);
    case Texture::Wrap::MirroredRepeat: {
        const int period = 2 * size;
        const int m = ((i % period) + period) % period;
        return m < size ? m : period - 1 - m;
    }
    default:
        return (size & (size - 1)) == 0 ? i & (size - 1) : ((i % size) + size) % size;
    }
}

/// A coordinate to a texel number, safe for any float.
int texelNumber(float coordinate, int size)
{
    const float t = coordinate * float(size);
    return std::isfinite(t) ? int(std::floor(std::clamp(t, -1.0e9f, 1.0e9f))) : 0;
}

u8vec4 nearestTexel(const Texture& texture, const ImageRgba8& pixels, vec2 uv)
{
    return pixels(wrap(texelNumber(uv.x, pixels.width()), pixels.width(), texture.wrapU),
                  wrap(texelNumber(uv.y, pixels.height()), pixels.height(), texture.wrapV));
}

float bilinearAlpha(const Texture& texture, vec2 uv)
{
    const ImageRgba8& pixels = texture.pixels;
    if (texture.nearest) return float(nearestTexel(texture, pixels, uv).w) / 255.0f;
    const vec2 place = uv * vec2(pixels.size()) - 0.5f;
    const int x = texelNumber(place.x / float(pixels.width()), pixels.width());
    const int y = texelNumber(place.y / float(pixels.height()), pixels.height());
    const vec2 f = glm::clamp(place - vec2(float(x), float(y)), 0.0f, 1.0f);
    const int x0 = wrap(x, pixels.width(), texture.wrapU);
    const int x1 = wrap(x + 1, pixels.width(), texture.wrapU);
    const int y0 = wrap(y, pixels.height(), texture.wrapV);
    const int y1 = wrap(y + 1, pixels.height(), texture.wrapV);
    const float top = glm::mix(float(pixels(x0, y0).w), float(pixels(x1, y0).w), f.x);
    const float bottom = glm::mix(float(pixels(x0, y1).w), float(pixels(x1, y1).w), f.x);
    return glm::mix(top, bottom, f.y) / 255.0f;
}

TransportMaterial transportMaterial(const Scene& scene, const Material& m)
{
    // A reference to a texture that was not decoded counts as none.
    const auto usable = [&](TextureRef ref) {
        if (ref && scene.textures[std::size_t(ref.texture)].pixels.empty()) ref.texture = -1;
        return ref;
    };
    TransportMaterial t;
    t.baseColor = usable(m.baseColorTexture);
    t.metallicRoughness = usable(m.metallicRoughnessTexture);
    t.emissive = usable(m.emissiveTexture);
    // Unlit surfaces show their colour whatever the light; they reflect it as a diffuse surface would.
    t.metallicFactor = m.unlit ? 0.0f : m.metallic;
    t.roughnessFactor = m.roughness;
    t.specular = m.specular;
    t.baseColorFactor = vec3(m.baseColor);
    t.opacity = m.baseColor.w;
    t.emission = m.emissiveNits;
    t.alphaMode = m.alphaMode;
    t.alphaCutoff = m.alphaCutoff;
    t.doubleSided = m.doubleSided;
    t.unlit = m.unlit;
    return t;
}

} // namespace

struct RayTracer::GeometryUser {
    const RayTracer* tracer = nullptr;
    const std::vector<uint32_t>* triangles = nullptr;
    bool castShadows = true;
};

RayTracer::RayTracer(const Scene& scene, const BakeGeometry& geometry, const char* device, RTCBuildQuality tree)
    : geometry_(geometry), sceneData_(scene)
{
    for (const Material& material : scene.materials) materials_.push_back(transportMaterial(scene, material));
    materials_.push_back(transportMaterial(scene, defaultMaterial()));
    std::vector<uint8_t> used(scene.textures.size(), 0);
    for (const TransportMaterial& m : materials_) {
        for (const TextureRef& ref : {m.baseColor, m.emissive, m.metallicRoughness}) {
            if (ref) used[std::size_t(ref.texture)] = 1;
        }
    }
    smallTextures_.resize(scene.textures.size());
    parallelFor(scene.textures.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (used[i] != 0) smallTextures_[i] = shrink(scene.textures[i].pixels);
        }
    });

    // Three geometries: solid triangles without a filter function, triangles with holes, and triangles that only
    // cameras see.
    enum { Solid, Holes, NoShadow, Count };
    trianglesOfGeometry_.resize(Count);
    Bounds bounds;
    for (const BakeGeometry::Part& part : geometry.parts) {
        if (part.triangleCount == 0) continue;
        const TransportMaterial& material = materialOfTriangle(part.firstTriangle);
        const int kind = !part.castShadows                                   ? NoShadow
                         : material.alphaMode != Material::AlphaMode::Opaque ? Holes
                                                                             : Solid;
        anyBlended_ = anyBlended_ || material.alphaMode == Material::AlphaMode::Blend;
        for (uint32_t t = part.firstTriangle; t < part.firstTriangle + part.triangleCount; ++t) {
            trianglesOfGeometry_[std::size_t(kind)].push_back(t);
            bounds.extend(geometry.boundsOf(t));
        }
    }
    firstHit_.assign(1, 0u);
    for (const auto& list : trianglesOfGeometry_) firstHit_.push_back(firstHit_.back() + uint32_t(list.size()));
    sceneScale_ = bounds.empty() ? 1.0f : glm::length(bounds.size());

    device_ = rtcNewDevice(device);
    if (device_ == nullptr) return;
    packets_ = embree::takesPackets(device_);
    RTCScene embreeScene = rtcNewScene(device_);
    rtcSetSceneBuildQuality(embreeScene, tree);
    for (int kind = 0; kind < Count; ++kind) {
        const std::vector<uint32_t>& list = trianglesOfGeometry_[std::size_t(kind)];
        if (list.empty()) continue;
        RTCGeometry mesh = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
        auto* vertices = static_cast<vec3*>(rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                                    sizeof(vec3), geometry.positions.size()));
        auto* indices = static_cast<uvec3*>(
            rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(uvec3), list.size()));
        if (vertices == nullptr || indices == nullptr) {
            rtcReleaseGeometry(mesh);
            rtcReleaseScene(embreeScene);
            return;
        }
        std::copy(geometry.positions.begin(), geometry.positions.end(), vertices);
        for (std::size_t i = 0; i < list.size(); ++i) indices[i] = geometry.triangles[list[i]];
        users_.push_back(std::make_unique<GeometryUser>(GeometryUser{this, &list, kind != NoShadow}));
        rtcSetGeometryUserData(mesh, users_.back().get());
        if (kind != Solid) {
            rtcSetGeometryIntersectFilterFunction(mesh, filter);
            rtcSetGeometryOccludedFilterFunction(mesh, filter);
        }
        rtcCommitGeometry(mesh);
        rtcAttachGeometryByID(embreeScene, mesh, unsigned(kind));
        rtcReleaseGeometry(mesh);
    }
    rtcCommitScene(embreeScene);
    scene_ = embreeScene;
}

RayTracer::~RayTracer()
{
    if (scene_ != nullptr) rtcReleaseScene(scene_);
    if (device_ != nullptr) rtcReleaseDevice(device_);
}

const TransportMaterial& RayTracer::materialOfTriangle(uint32_t triangle) const
{
    if (triangle >= geometry_.partOfTriangle.size()) return materials_.back();
    const int material = geometry_.parts[geometry_.partOfTriangle[triangle]].material;
    return material < 0 ? materials_.back() : materials_[std::size_t(material)];
}

float RayTracer::epsilonAt(vec3 position) const
{
    const float magnitude = std::max({std::abs(position.x), std::abs(position.y), std::abs(position.z)});
    return std::max(8.0e-7f * magnitude, 2.0e-6f * sceneScale_);
}

vec2 RayTracer::textureCoordinate(uint32_t triangle, vec2 barycentric, const TextureRef& ref) const
{
    const uvec3 t = geometry_.triangles[triangle];
    const std::vector<vec2>& uv = geometry_.uv[ref.texCoord == 1 ? 1 : 0];
    const vec2 raw =
        (1.0f - barycentric.x - barycentric.y) * uv[t.x] + barycentric.x * uv[t.y] + barycentric.y * uv[t.z];
    // KHR_texture_transform: translation * rotation * scale.
    const vec2 scaled = raw * ref.scale;
    if (ref.rotationRadians == 0.0f) return ref.offset + scaled;
    const float c = std::cos(ref.rotationRadians);
    const float s = std::sin(ref.rotationRadians);
    return ref.offset + vec2(c * scaled.x + s * scaled.y, -s * scaled.x + c * scaled.y);
}

float RayTracer::alphaAt(uint32_t triangle, vec2 barycentric, const TransportMaterial& material) const
{
    float alpha = material.opacity;
    if (material.baseColor) {
        alpha *= bilinearAlpha(sceneData_.textures[std::size_t(material.baseColor.texture)],
                               textureCoordinate(triangle, barycentric, material.baseColor));
    }
    if (!geometry_.colors.empty()) {
        const uvec3 t = geometry_.triangles[triangle];
        alpha *= (1.0f - barycentric.x - barycentric.y) * geometry_.colors[t.x].w +
                 barycentric.x * geometry_.colors[t.y].w + barycentric.y * geometry_.colors[t.z].w;
    }
    return alpha;
}

float RayTracer::coverageAt(uint32_t triangle, vec2 barycentric) const
{
    const TransportMaterial& material = materialOfTriangle(triangle);
    if (material.alphaMode == Material::AlphaMode::Opaque) return 1.0f;
    const float alpha = alphaAt(triangle, barycentric, material);
    if (material.alphaMode == Material::AlphaMode::Mask) return alpha < material.alphaCutoff ? 0.0f : 1.0f;
    return glm::clamp(alpha, 0.0f, 1.0f);
}

bool RayTracer::passes(uint32_t triangle, vec2 barycentric, const float* rayBits) const
{
    const float coverage = coverageAt(triangle, barycentric);
    if (coverage >= 1.0f) return false;
    if (coverage <= 0.0f) return true;
    // A ray passes with probability 1 - coverage. The decision hashes the ray itself, so it needs no state.
    uint32_t bits = triangle;
    for (int i = 0; i < 6; ++i) bits = hashCombine(bits, std::bit_cast<uint32_t>(rayBits[i]));
    return unitFloat(bits) >= coverage;
}

/// Whether a ray goes on behind a blended surface, dimmed by it.
bool RayTracer::passesBlended(uint32_t triangle, vec2 barycentric, embree::BlendedTransmittance& ray) const
{
    if (materialOfTriangle(triangle).alphaMode != Material::AlphaMode::Blend) return false;
    // Where triangles are split, Embree may bring one more than once (RTC_BUILD_QUALITY_HIGH).
    const auto end = ray.triangle.begin() + ray.count;
    if (std::find(ray.triangle.begin(), end, triangle) != end) return true;
    const float coverage = coverageAt(triangle, barycentric);
    if (coverage >= 1.0f || end == ray.triangle.end()) return false;
    ray.triangle[std::size_t(ray.count++)] = triangle;
    ray.share *= 1.0f - coverage;
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
        const uint32_t triangle = (*user->triangles)[RTCHitN_primID(arguments->hit, count, i)];
        const vec2 barycentric(RTCHitN_u(arguments->hit, count, i), RTCHitN_v(arguments->hit, count, i));
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

vec3 RayTracer::emissionAt(uint32_t triangle, vec2 barycentric) const
{
    const TransportMaterial& material = materialOfTriangle(triangle);
    vec3 emission = material.emission;
    if (material.emissive && emission != vec3(0.0f)) {
        const auto index = std::size_t(material.emissive.texture);
        emission *= linearOf(nearestTexel(sceneData_.textures[index], smallTextures_[index],
                                          textureCoordinate(triangle, barycentric, material.emissive)));
    }
    return emission;
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
    // Camera rays go on behind back faces they do not see. The bound is against endless loops on damaged geometry.
    for (int layer = 0; layer < 256; ++layer) {
        RTCRayHit ray = rayHit(origin, direction, tMin, tMax);
        embree::intersect(scene_, context, ray);
        if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};

        const bool behind = ray.hit.Ng_x * direction.x + ray.hit.Ng_y * direction.y + ray.hit.Ng_z * direction.z > 0.0f;
        if (cameraRay && behind && !materialOfTriangle(triangleOf(ray.hit.geomID, ray.hit.primID)).doubleSided) {
            tMin = ray.ray.tfar * (1.0f + 1.0e-6f) + epsilonAt(origin);
            continue;
        }
        return {true, behind, ray.hit.geomID, ray.hit.primID, vec2(ray.hit.u, ray.hit.v), ray.ray.tfar};
    }
    return {};
}

SurfaceHit RayTracer::surfaceAt(const RayHit& at) const
{
    const uint32_t triangle = triangleOf(at.geomID, at.primID);
    const TransportMaterial& material = materialOfTriangle(triangle);
    SurfaceHit hit{at.distance, &material, surfacePoint(geometry_, triangle, at.barycentric)};
    if (at.behind) {
        hit.point.normal = -hit.point.normal;
        hit.point.geometricNormal = -hit.point.geometricNormal;
    }
    hit.albedo = albedoAt(triangle, at.barycentric);
    if (!metHiddenBack(at)) hit.emission = emissionAt(triangle, at.barycentric);
    return hit;
}

uint32_t RayTracer::triangleAt(uint32_t hitIndex) const
{
    std::size_t geometry = 0;
    while (hitIndex >= firstHit_[geometry + 1]) ++geometry;
    return trianglesOfGeometry_[geometry][hitIndex - firstHit_[geometry]];
}

SurfaceReflectance RayTracer::reflectanceAt(uint32_t triangle, vec2 barycentric) const
{
    const TransportMaterial& material = materialOfTriangle(triangle);
    vec3 base = material.baseColorFactor;
    if (material.baseColor) {
        const auto index = std::size_t(material.baseColor.texture);
        base *= linearOf(nearestTexel(sceneData_.textures[index], smallTextures_[index],
                                      textureCoordinate(triangle, barycentric, material.baseColor)));
    }
    if (!geometry_.colors.empty()) {
        const uvec3 t = geometry_.triangles[triangle];
        base *= vec3((1.0f - barycentric.x - barycentric.y) * geometry_.colors[t.x] +
                     barycentric.x * geometry_.colors[t.y] + barycentric.y * geometry_.colors[t.z]);
    }
    float metallic = material.metallicFactor;
    float roughness = material.roughnessFactor;
    if (material.metallicRoughness) {
        const auto index = std::size_t(material.metallicRoughness.texture);
        const u8vec4 texel = nearestTexel(sceneData_.textures[index], smallTextures_[index],
                                          textureCoordinate(triangle, barycentric, material.metallicRoughness));
        metallic *= float(texel.z) / 255.0f;
        roughness *= float(texel.y) / 255.0f;
    }
    return {glm::clamp(base, 0.0f, 1.0f), metallic, roughness, material.specular};
}

vec3 RayTracer::albedoAt(uint32_t triangle, vec2 barycentric) const
{
    const SurfaceReflectance r = reflectanceAt(triangle, barycentric);
    return r.metallic > 0.0f ? shading::transportAlbedo(r.baseColor, r.metallic, r.roughness) : r.baseColor;
}

void RayTracer::clear(RTCRay8& rays)
{
    for (int i = 0; i < embree::kPacket; ++i) {
        rays.tnear[i] = 0.0f;
        rays.tfar[i] = kInfinity;
        rays.time[i] = 0.0f;
        rays.mask[i] = ~0u;
        rays.id[i] = 0u;
        rays.flags[i] = 0u;
    }
}

void RayTracer::intersect(const embree::LaneMask& valid, RTCRayHit8& rays) const
{
    embree::RayContext context(false);
    for (int i = 0; i < embree::kPacket; ++i) {
        rays.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
        rays.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
    embree::intersect8(scene_, context, valid, rays, packets_);
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
    std::array<float, embree::kPacket> shares;
    for (std::size_t i = 0; i < embree::kPacket; ++i) shares[i] = rays.tfar[i] < 0.0f ? 0.0f : blended[i].share;
    return shares;
}

RayTracer::Crossings RayTracer::crossings(vec3 origin, vec3 direction) const
{
    constexpr int kMaxCrossings = 64;
    embree::RayContext context(false);
    Crossings result;
    float tMin = 0.0f;
    while (result.rays < kMaxCrossings) {
        RTCRayHit ray = rayHit(origin, direction, tMin, kInfinity);
        embree::intersect(scene_, context, ray);
        ++result.rays;
        if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) break;
        const uint32_t triangle = trianglesOfGeometry_[ray.hit.geomID][ray.hit.primID];
        const bool behind = glm::dot(vec3(ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z), direction) > 0.0f;
        const bool solid = geometry_.solid[triangle] != 0;
        if (result.rays == 1 && behind && solid) {
            // Whatever else the ray enters it leaves again: the origin is inside.
            result.solidsLeft = 1;
            break;
        }
        if (solid) result.solidsLeft += behind ? 1 : -1;
        tMin = ray.ray.tfar * (1.0f + 1.0e-6f) + epsilonAt(origin + direction * ray.ray.tfar);
    }
    return result;
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
    return occluded(context, origin, direction, tMin, tMax) ? 0.0f : blended.share;
}

bool RayTracer::occluded(embree::RayContext& context, vec3 origin, vec3 direction, float tMin, float tMax) const
{
    RTCRay ray = rayHit(origin, direction, tMin, tMax).ray;
    embree::occluded(scene_, context, ray);
    return ray.tfar < 0.0f;
}

} // namespace halflight
