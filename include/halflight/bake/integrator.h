#pragma once
// The one virtual interface of the project: what traces the bake's rays. src/bake_cpu implements it with Embree.

#include "halflight/base/progress.h"
#include "halflight/base/result.h"
#include "halflight/scene/baked_scene.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace halflight {

/// World-space triangles of all static objects that the bake sees, flattened: what rays hit and texels lie on.
struct BakeGeometry {
    /// One static object's part: its triangles are [firstTriangle, firstTriangle + triangleCount).
    struct Part {
        int object = -1; ///< index into Scene::objects
        int mesh = -1;
        int part = -1;
        int material = -1; ///< index into Scene::materials, -1 = default
        uint32_t firstTriangle = 0;
        uint32_t triangleCount = 0;
        uint32_t firstVertex = 0;
        bool castShadows = true;
        bool flipped = false; ///< mirrored by its transform: front faces wind clockwise
    };
    std::vector<Part> parts;
    std::vector<uint32_t> partOfTriangle;
    std::vector<uvec3> triangles; ///< vertex indices, wound counter-clockwise seen from the front (mirroring undone)
    std::vector<vec3> positions;  ///< world space
    std::vector<vec3> normals;    ///< world space, unit
    std::vector<vec2> uv[2];      ///< zero where the part has none
    std::vector<vec2> lightmapUv; ///< in texels of the object's page; NaN for parts without lightmap

    [[nodiscard]] vec3 geometricNormal(uint32_t triangle) const; ///< unit, or zero for a degenerate triangle
};

/// Where a light sample of a texel starts: a point on a surface.
struct SurfacePoint {
    vec3 position{0.0f};        ///< world space
    vec3 normal{0.0f};          ///< interpolated shading normal, unit
    vec3 geometricNormal{0.0f}; ///< unit
};

/// One texel's sample sites. Samples spread over the sites (a texel may hold several triangles of a chart).
struct TexelSites {
    uint32_t first = 0; ///< into TexelMap::sites
    uint32_t count = 0;
};

/// What the lightmap holds of a light's contribution; see spec S6.
struct IntegrationSettings {
    int samples = 64;
    int shadowSamples = 16;
    int bounces = 4; ///< indirect bounces; 0 = direct only
    int probeSamples = 256;
    uint32_t seed = 1;
};

/// Lightmap value of one texel with the statistics the denoiser wants.
struct IrradianceEstimate {
    vec3 irradiance{0.0f};      ///< lux
    float varianceOfMean = 0.0f; ///< of the luminance of `irradiance`
    float backfaceFraction = 0.0f; ///< share of first hits on back faces of single-sided surfaces: > 0.5 = inside geometry
};

/// A texel to integrate: points on the surface it covers, one per sample, cycled when there are fewer than samples.
struct TexelQuery {
    uint32_t id = 0; ///< seeds the texel's random numbers: the same on every run, thread count and tiling
    std::span<const SurfacePoint> points;
};

struct ProbeEstimate {
    SphericalHarmonicsL2 radiance{};
    vec4 occlusion{1.0f};
    float backfaceFraction = 0.0f;
};

class Integrator {
public:
    virtual ~Integrator() = default;

    /// One line for reports: device, library, threads.
    [[nodiscard]] virtual std::string description() const = 0;

    /// Irradiance at each texel by path tracing: everything that is baked there.
    /// Direct light of a punctual light is counted when its baking output says Baked; bounced light for Mixed and Baked.
    virtual bool irradiance(std::span<const TexelQuery> texels, std::span<IrradianceEstimate> out, const Progress& progress) = 0;

    /// Attenuation of static casters for the lights that have each channel; channels without a light in reach are 1.
    virtual bool shadowmask(std::span<const TexelQuery> texels, std::span<vec4> out, const Progress& progress) = 0;

    virtual bool probes(std::span<const vec3> positions, std::span<ProbeEstimate> out, const Progress& progress) = 0;

    /// Path-traced picture of the static and dynamic diffuse scene from a camera: linear radiance. The reference for the
    /// renderer. All lights count fully, whatever their mode.
    virtual bool picture(const Camera& camera, int samplesPerPixel, ImageRgb32f& out, const Progress& progress) = 0;

    [[nodiscard]] virtual uint64_t raysTraced() const = 0;
};

/// Makes an integrator for a scene whose lights have their baking output assigned. `geometry` and `scene` outlive it.
using IntegratorFactory = std::function<Result<std::unique_ptr<Integrator>>(const Scene& scene, const BakeGeometry& geometry,
                                                                           const IntegrationSettings& settings)>;

} // namespace halflight
