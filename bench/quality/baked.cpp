#include "quality/baked.h"
#include "bake/geometry/flatten.h"

#include "halflight/bake_cpu/embree_integrator.h"
#include "halflight/base/image_filter.h"
#include "halflight/base/rgb9e5.h"
#include "halflight/scene/gltf.h"
#include "halflight/shading/mask.h"

#include <algorithm>
#include <cmath>

namespace halflight::quality {
namespace {

/// Weights of the four texels around a place between the second and the third: the uniform cubic B-spline, what games
/// filter lightmaps with (Sigg and Hadwiger 2005, "Fast Third-Order Texture Filtering").
std::array<float, 4> splineWeights(float t)
{
    const float s = 1.0f - t;
    return {s * s * s / 6.0f, (4.0f - 6.0f * t * t + 3.0f * t * t * t) / 6.0f,
            (4.0f - 6.0f * s * s + 3.0f * s * s * s) / 6.0f, t * t * t / 6.0f};
}

} // namespace

vec3 Baked::light(int page, vec2 texel) const
{
    return bilinear(lightmaps[std::size_t(page)], texel);
}

vec3 Baked::lightBicubic(int page, vec2 texel) const
{
    const ImageRgb32f& image = lightmaps[std::size_t(page)];
    const vec2 p = texel - 0.5f;
    const ivec2 b(glm::floor(p));
    const auto wx = splineWeights(p.x - float(b.x));
    const auto wy = splineWeights(p.y - float(b.y));
    vec3 sum(0.0f);
    for (int y = 0; y < 4; ++y) {
        for (int x = 0; x < 4; ++x) {
            const ivec2 at = glm::clamp(b + ivec2(x - 1, y - 1), ivec2(0), image.size() - 1);
            sum += wx[std::size_t(x)] * wy[std::size_t(y)] * image(at.x, at.y);
        }
    }
    return sum;
}

float Baked::mask(int page, vec2 texel, int channel) const
{
    const MaskChannel& how = result.baked.maskChannels[std::size_t(channel)];
    return shading::decodeMask(bilinear(masks[std::size_t(page)], texel)[channel], how.rangeTexels, how.penumbraTexels,
                               0.05f);
}

Result<Baked> bakeFile(const std::filesystem::path& file, const BakeSettings& settings)
{
    auto scene = readScene(file);
    if (!scene) return scene.error();
    auto result = bake(std::move(*scene), settings, embreeIntegrators());
    if (!result) return result.error();
    Baked baked;
    baked.result = std::move(*result);
    const BakedScene& s = baked.result.baked;
    baked.pageSize = baked.result.report.pageSize;
    baked.geometry = flattenGeometry(s.scene, baked.pageSize, GeometryFilter::Static);
    for (const auto& page : s.lightmaps) baked.lightmaps.push_back(decodeRgb9e5(page, s.lightmapUnitLux));
    for (const ImageRgba8& page : s.shadowmasks) {
        ImageRgba32f& mask = baked.masks.emplace_back(page.width(), page.height());
        for (std::size_t i = 0; i < page.texelCount(); ++i) mask.data()[i] = vec4(page.data()[i]) / 255.0f;
    }
    return baked;
}

void forSurface(const Baked& baked, const std::function<void(const SurfaceSample&)>& visit)
{
    const BakeGeometry& g = baked.geometry;
    for (const BakeGeometry::Part& part : g.parts) {
        if (part.page < 0) continue;
        for (uint32_t t = part.firstTriangle; t < part.firstTriangle + part.triangleCount; ++t) {
            const std::array<vec2, 3> v = g.texelsOf(t);
            const vec2 a = v[0];
            const vec2 ab = v[1] - a;
            const vec2 ac = v[2] - a;
            const float area = 0.5f * std::abs(ab.x * ac.y - ab.y * ac.x);
            if (g.geometricNormal(t) == vec3(0.0f)) continue;
            const auto at = [&](vec2 barycentric) {
                const SurfacePoint p = surfacePoint(g, t, barycentric);
                visit({t, part.object, part.page, a + barycentric.x * ab + barycentric.y * ac, p.position, p.normal,
                       p.geometricNormal});
            };
            const int inner = std::clamp(int(8.0f * area), 4, 200000);
            for (int i = 0; i < inner; ++i) {
                vec2 u = glm::fract(vec2(0.5f) + float(i) * vec2(0.7548776662f, 0.5698402910f));
                if (u.x + u.y > 1.0f) u = 1.0f - u;
                at(u);
            }
            const int along = std::clamp(int(4.0f * std::sqrt(area)), 2, 2000);
            for (int i = 0; i <= along; ++i) {
                const float s = float(i) / float(along);
                at({s, 0.0f});
                at({0.0f, s});
                at({s, 1.0f - s});
            }
        }
    }
}

} // namespace halflight::quality
