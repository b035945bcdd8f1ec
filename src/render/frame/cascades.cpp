// Shadow map matrices: cascades of directional lights, perspective tiles of spot and point lights.
#include "halflight/base/mathematics.h"
#include "halflight/shading/penumbra.h"
#include "halflight/shading/sampling.h"
#include "render/frame/frame_internal.h"

#include <algorithm>
#include <cmath>

namespace halflight {
namespace {

float aspectOf(const FrameView& view)
{
    return float(std::max(view.size.x, 1)) / float(std::max(view.size.y, 1));
}

/// Spot lights with a wider half angle get six tiles: one perspective would spend its texels on the rim.
constexpr float kWidestSpotTileRadians = 70.0f * kPi / 180.0f;

} // namespace

int borderTexels(const ShadowSettings& settings, int mapTexels)
{
    const auto filter = float(filterReachTexels(settings.filter));
    const float shift =
        shading::kEdgeOnShift * std::max(settings.normalBiasTexels, 0.0f) * std::max(0.5f * filter, 1.0f);
    constexpr float kBilinear = 1.0f; // texels that a comparison reaches beyond its place
    const float penumbra = settings.penumbrae ? shading::penumbraReach(float(mapTexels)) + kBilinear : 0.0f;
    return int(std::ceil(std::max(filter, penumbra) + shift));
}

// Split distances: Zhang et al. 2006, "Parallel-Split Shadow Maps for Large-Scale Virtual Environments", eq. 3, on
// radial distance, as the fragment measures it: a cascade then ends at the same distance in the picture's middle and in
// its corners, and turning the camera moves no point to another cascade.
//
// Each slice's sphere depends on the camera's lens alone and never on its pose, so a cascade keeps its size in texels
// (Valient 2008, "Stable Rendering of Cascaded Shadow Maps", ShaderX6).
CascadeSlices sliceView(const FrameView& view, const ShadowSettings& settings)
{
    const Camera& camera = view.camera;
    const float halfY =
        camera.orthographic ? 0.5f * camera.orthographicHeightMeters : math::tan(0.5f * camera.verticalFovRadians);
    const float halfX = halfY * aspectOf(view);
    const float cornerSquared = halfX * halfX + halfY * halfY; // square metres (orthographic), or squared tangent
    const float cosCorner = 1.0f / std::sqrt(1.0f + cornerSquared);

    // The farthest point in view, if that is nearer than the shadow distance.
    const float seen = camera.orthographic ? std::sqrt(camera.farMeters * camera.farMeters + cornerSquared)
                                           : camera.farMeters / cosCorner;
    const float farMeters = std::min(settings.distanceMeters, 1.0001f * seen);
    const float nearMeters = std::clamp(camera.nearMeters, 1.0e-3f * farMeters, 0.5f * farMeters);

    CascadeSlices slices;
    slices.count = settings.cascades;
    slices.farMeters.fill(farMeters);
    for (int i = 0; i + 1 < slices.count; ++i) {
        const float part = float(i + 1) / float(slices.count);
        const float logarithmic = nearMeters * math::pow(farMeters / nearMeters, part);
        const float uniform = nearMeters + (farMeters - nearMeters) * part;
        const float split = settings.cascadeSplits[std::size_t(i)];
        slices.farMeters[std::size_t(i)] = settings.cascadeSplits[0] != 0.0f
                                               ? std::min(split * settings.distanceMeters, farMeters)
                                               : glm::mix(uniform, logarithmic, settings.cascadeSplitLambda);
    }

    for (int i = 0; i < slices.count; ++i) {
        // From where the cascade before begins to blend into this one. The first starts at the camera.
        const float a = i == 0 ? 0.0f : slices.farMeters[std::size_t(i - 1)] * (1.0f - settings.cascadeBlendFraction);
        const float b = slices.farMeters[std::size_t(i)];
        float center = 0.0f;
        float radius = 0.0f;
        if (camera.orthographic) {
            // A box: depths from where the slice's inner sphere leaves the corners, half extents cut by its outer
            // sphere.
            const float zNear = std::sqrt(std::max(0.0f, a * a - cornerSquared));
            const float x = std::min(halfX, b);
            const float y = std::min(halfY, b);
            center = 0.5f * (zNear + b);
            radius = std::sqrt(x * x + y * y + 0.25f * (b - zNear) * (b - zNear));
        } else {
            // Points at distance r and angle phi <= theta from the axis lie r^2 - 2 r c cos(phi) + c^2 (squared) from
            // the axis' point at c: greatest at the corner angle theta, and at r = a or r = b. Of the two, b's is the
            // greater up to c = (a + b) / (2 cos theta), and is least at c = b cos theta.
            center = std::min(b * cosCorner, 0.5f * (a + b) / cosCorner);
            radius = std::sqrt(std::max(b * b - 2.0f * b * center * cosCorner + center * center, 0.0f));
        }
        slices.centerDepth[std::size_t(i)] = center;
        slices.radius[std::size_t(i)] = radius * 1.0001f;
    }
    return slices;
}

// A square around the slice's sphere, in a light frame that depends on the light's direction alone, its centre rounded
// to whole texels: a point of the world then keeps its place within its texel wherever the camera goes (Valient 2008).
ShadowTile fitCascade(const FrameView& view, const ShadowSettings& settings, const CascadeSlices& slices, int cascade,
                      vec3 lightDirection, const Bounds& sceneBounds)
{
    vec3 right(0.0f);
    vec3 up(0.0f);
    shading::orthonormalBasis(-lightDirection, right, up);

    const float radius = slices.radius[std::size_t(cascade)];
    const mat4& worldFromCamera = view.camera.worldFromCamera;
    const vec3 center =
        vec3(worldFromCamera[3]) - glm::normalize(vec3(worldFromCamera[2])) * slices.centerDepth[std::size_t(cascade)];

    // Rounding moves the centre by up to half a texel, so one more texel stays free.
    ShadowTile tile;
    tile.size = settings.directionalMapSize;
    tile.layer = cascade;
    const int inner = std::max(tile.size - 2 * borderTexels(settings, tile.size) - 1, 1);
    const double texel = 2.0 * double(radius) / double(inner);
    const double halfExtent = 0.5 * texel * double(tile.size);
    const double x = std::round(glm::dot(glm::dvec3(center), glm::dvec3(right)) / texel) * texel;
    const double y = std::round(glm::dot(glm::dvec3(center), glm::dvec3(up)) / texel) * texel;
    tile.texelMeters = float(texel);

    // Depth: from the scene's first caster on the way of the light to its last receiver in this slice.
    const float along = glm::dot(center, lightDirection);
    float nearMeters = along - radius;
    float farMeters = along + radius;
    if (!sceneBounds.empty()) {
        const float middle = glm::dot(sceneBounds.center(), lightDirection);
        const float reach = glm::dot(glm::abs(lightDirection), 0.5f * sceneBounds.size());
        const float slack = 1.0e-3f * reach + 1.0e-3f;
        nearMeters = std::min(nearMeters, middle - reach - slack);
        farMeters = std::min(farMeters, middle + reach + slack);
        if (!(nearMeters < farMeters)) farMeters = nearMeters + 1.0f; // the slice lies before the whole scene
    }
    tile.nearMeters = nearMeters;
    tile.farMeters = farMeters;

    // Like the camera's clip space, y points down, so triangles keep their winding.
    const auto row = [](vec3 axis, double scale, double offset) {
        return vec4(glm::vec4(glm::dvec4(glm::dvec3(axis) * scale, offset)));
    };
    const double depth = double(farMeters) - double(nearMeters);
    tile.clipFromWorld =
        glm::transpose(mat4(row(right, 1.0 / halfExtent, -x / halfExtent), //
                            row(up, -1.0 / halfExtent, y / halfExtent),
                            row(lightDirection, 1.0 / depth, -double(nearMeters) / depth), vec4(0, 0, 0, 1)));
    return tile;
}

int localTileCount(const Light& light)
{
    return light.type == LightType::Spot && light.outerConeRadians <= kWidestSpotTileRadians ? 1 : 6;
}

ShadowTile fitLocalTile(const Light& light, int face, int size, const ShadowSettings& settings,
                        const Bounds& sceneBounds)
{
    static constexpr vec3 kForward[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    const bool single = localTileCount(light) == 1;
    const vec3 forward = single ? light.direction() : kForward[face];
    vec3 right(0.0f);
    vec3 up(0.0f);
    shading::orthonormalBasis(-forward, right, up);

    // The border's texels lie outside the cone's square, or outside the 90 degrees of a face.
    const int inner = std::max(size - 2 * borderTexels(settings, size), 1);
    const float tanInner = single ? math::tan(std::max(light.outerConeRadians, 0.01f)) : 1.0f;
    const float tanHalf = tanInner * float(size) / float(inner);

    // Far: where light or scene ends. Near: outside the source itself, at which its lamp often is modelled.
    const vec3 position = light.position();
    float farMeters = 1.001f * farthestIn(sceneBounds, position) + 0.01f;
    if (light.rangeMeters > 0.0f) farMeters = std::min(farMeters, light.rangeMeters);
    const float nearMeters = std::min(std::max(0.01f, light.radiusMeters), 0.5f * farMeters);

    ShadowTile tile;
    tile.size = size;
    tile.texelMeters = 2.0f * tanHalf / float(size);
    tile.nearMeters = nearMeters;
    tile.farMeters = farMeters;
    const float zScale = farMeters / (farMeters - nearMeters);
    const auto row = [&](vec3 axis, float scale) { return scale * vec4(axis, -glm::dot(axis, position)); };
    vec4 depth = row(forward, zScale);
    depth.w -= nearMeters * zScale;
    tile.clipFromWorld =
        glm::transpose(mat4(row(right, 1.0f / tanHalf), row(up, -1.0f / tanHalf), depth, row(forward, 1.0f)));
    return tile;
}

} // namespace halflight
