#pragma once
// The one virtual interface of the project: what traces the bake's rays. src/bake_cpu implements it with Embree.

#include "halflight/base/progress.h"
#include "halflight/base/result.h"
#include "halflight/scene/baked_scene.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace halflight {

/// World-space triangles of the scene's objects, flattened: what rays hit and texels lie on.
struct BakeGeometry {
    /// One object's part: its triangles are [firstTriangle, firstTriangle + triangleCount).
    struct Part {
        int object = -1; ///< index into Scene::objects
        int mesh = -1;
        int part = -1;
        int material = -1; ///< index into Scene::materials, -1 = default
        uint32_t firstTriangle = 0;
        uint32_t triangleCount = 0;
        uint32_t firstVertex = 0;
        uint32_t vertexCount = 0;
        bool castShadows = true;
        bool receiveShadows = true; ///< false: lights reach it as if nothing stood in their way
        int page = -1;              ///< lightmap page, -1 = none
    };
    std::vector<Part> parts;
    std::vector<uint32_t> partOfTriangle;
    std::vector<uvec3> triangles; ///< vertex indices, counter-clockwise seen from the front (mirroring is undone)
    std::vector<vec3> positions;  ///< world space
    std::vector<vec3> normals;    ///< world space, unit
    std::vector<vec2> uv[2];      ///< zero where the part has none
    std::vector<vec4> colors;     ///< vertex colours; empty when no part has any
    std::vector<uint8_t> solid; ///< 1 for triangles of closed, outward-facing pieces and of the cavities in them: their
                                ///< back faces are inside a solid
    std::vector<uint8_t> turned; ///< 1 for triangles that the scene has the other way round: of closed, double-sided
                                 ///< pieces that face inward though nothing is inside
    std::vector<vec2> lightmapTexel; ///< lightmap coordinate in texels of the page; zero for parts without lightmap

    /// What follows from the above for each triangle; findFrames() works it out.
    struct Frame {
        vec3 normal{0.0f};
        float texelMeters = 0.0f;
    };
    std::vector<Frame> frames;
    void findFrames();

    /// Unit, or zero for a degenerate triangle.
    [[nodiscard]] vec3 geometricNormal(uint32_t triangle) const { return frames[triangle].normal; }
    /// Width of a lightmap texel on a triangle, in metres; 0 where its lightmap triangle has no area.
    [[nodiscard]] float texelMeters(uint32_t triangle) const { return frames[triangle].texelMeters; }
    [[nodiscard]] vec3 centroid(uint32_t triangle) const
    {
        const uvec3 t = triangles[triangle];
        return (positions[t.x] + positions[t.y] + positions[t.z]) / 3.0f;
    }
    [[nodiscard]] Bounds boundsOf(uint32_t triangle) const
    {
        Bounds bounds;
        for (int corner = 0; corner < 3; ++corner) bounds.extend(positions[triangles[triangle][corner]]);
        return bounds;
    }
};

/// The piece of a triangle that lies in one texel's square.
struct TexelFragment {
    uint32_t triangle = 0;
    vec2 barycentric{0.0f}; ///< weights of vertices 1 and 2 at the piece's centroid
    float area = 0.0f;      ///< of the texel's unit square, 0…1
};

/// A texel that at least one triangle touches.
struct Texel {
    uint16_t x = 0;
    uint16_t y = 0;
    uint32_t page = 0;
    uint32_t chart = 0;         ///< texels of one chart are one continuous piece of surface
    uint32_t firstFragment = 0; ///< the largest one
    uint32_t fragmentCount = 0;
};

/// All covered texels of all pages (conservative: any overlap counts), in an order that keeps neighbours together.
struct TexelMap {
    int pageSize = 0;
    int pageCount = 0;
    uint32_t chartCount = 0;
    std::vector<Texel> texels;
    std::vector<TexelFragment> fragments;
};

/// A point on a surface from which rays start.
struct SurfacePoint {
    vec3 position{0.0f};        ///< world space
    vec3 normal{0.0f};          ///< interpolated shading normal, unit
    vec3 geometricNormal{0.0f}; ///< unit
    uint32_t triangle = 0;
    vec2 barycentric{0.0f};
};

/// The point of a triangle at barycentric weights (of vertices 1 and 2).
SurfacePoint surfacePoint(const BakeGeometry& geometry, uint32_t triangle, vec2 barycentric);

/// Share of a texel's square that its triangles cover, 0…1; more where they overlap.
float coveredArea(const TexelMap& map, const Texel& texel);

constexpr int kMaxTexelPoints = 16;

/// Up to kMaxTexelPoints points spread evenly over the part of the texel that is covered; about as many wherever an
/// eighth is covered, at least one. Each batch has points of its own, and all batches together are spread evenly too.
int texelPoints(const BakeGeometry& geometry, const TexelMap& map, const Texel& texel,
                std::span<SurfacePoint, kMaxTexelPoints> out, int batch = 0);

/// How lightmap texels get their light. Path: each sample is a path traced to its end, without bias: the reference.
/// Cache: each sample is one ray that ends in light known at the surface it meets; many times faster, its mean within 1
/// %.
enum class IntegratorKind { Cache, Path };

struct IntegrationSettings {
    IntegratorKind integrator = IntegratorKind::Cache;
    /// Paths per texel. The cache takes whole blocks of 16: from half to 32 times as many, in proportion to the
    /// standard deviation of the noise (of what the denoiser leaves of it, see `denoised`), and at least twice as many
    /// where few texels of the same chart are around.
    int samples = 64;
    /// Rays per texel and light, for masks and for direct light that is baked. Texels on a shadow's edge get twice as
    /// many, those near one half, those far from one eight.
    int shadowSamples = 16;
    int bounces = 4;        ///< indirect bounces; 0 = direct light only
    int probeSamples = 256; ///< paths per probe
    /// With a target, a texel is done when the standard error of its luminance, estimated from the texels around it on
    /// its chart, is at most this share of their mean (of a fiftieth of the map's mean, where it is darker); `samples`
    /// is then the most it gets. 0 = none. Cache integrator only.
    float noiseTarget = 0.0f;
    /// Every how many texels are traced whatever is around them: 1, 2 or 4. Those in between take their neighbours'
    /// mean where the surface is smooth and nothing is near, else they are traced too; emitters are always sampled at
    /// each texel. Less noise for the time before denoising; a denoiser makes as much of all texels' rays, and
    /// smoother. 0: 2 in maps of more than 400,000 texels, which have more rays in the open than that takes, else 1.
    /// Cache integrator only.
    int texelStep = 0;
    /// Whether the lightmap is going to be denoised: without a noise target, samples then go where light changes from
    /// texel to texel, rather than where neighbours tell as much. Cache integrator only.
    bool denoised = true;
    uint32_t seed = 1;
};

/// Lightmap value of one texel with the statistics the denoiser wants.
struct IrradianceEstimate {
    vec3 irradiance{0.0f};       ///< lux
    vec3 moment{0.0f};           ///< lux, first moment: luminance of radiance times cosine times direction, integrated
    float varianceOfMean = 0.0f; ///< of the luminance of `irradiance`
    vec3 direct{0.0f};           ///< lux, what fully baked lights add to `irradiance` directly
    float varianceOfDirect = 0.0f;   ///< of its luminance; counted in varianceOfMean too
    uint32_t samples = 0;            ///< rays or paths it took
    bool valid = true;               ///< false: the texel lies inside geometry (its rays meet back faces)
    uint16_t outsidePoints = 0xffff; ///< bit i: point i of texelPoints() lies outside geometry; shadowmasks need it too
};

struct ProbeEstimate {
    SphericalHarmonicsL2 radiance{};
    vec4 occlusion{1.0f};
    float variance = 0.0f; ///< of the luminance of a coefficient, mean over the nine
    bool valid = true;
};

/// Which texels to work on, and how hard.
struct TexelRequest {
    std::span<const uint32_t> texels; ///< indices into TexelMap::texels
    int samples = 0;                  ///< paths per texel; 0 = as IntegrationSettings say
    int shadowSamples = 0;            ///< rays per texel and light; 0 = as IntegrationSettings say
};

/// Estimates light by tracing rays. All functions are deterministic: results depend on the scene, the settings and the
/// texel, never on threads. They return false when cancelled.
class Integrator {
public:
    virtual ~Integrator() = default;

    /// One line for reports: device, library, threads.
    [[nodiscard]] virtual std::string description() const = 0;

    /// What the lightmap holds (spec S6): emitters and sky, direct light of lights that are baked for static receivers,
    /// bounced light of mixed and baked lights; all but the direct light of subtractive's main light, which is made of
    /// its mask. One estimate per texel of the request; a texel's is the same whatever
    /// others are asked for.
    virtual bool irradiance(const TexelMap& map, const TexelRequest& request, std::span<IrradianceEstimate> out,
                            const Progress& progress) = 0;
    /// Frees what irradiance() keeps of a map from call to call; another call makes it anew.
    virtual void releaseIrradiance() {}

    /// Attenuation by static casters for each light that has a channel; 1 in channels without a light in reach. Of
    /// subtractive's main light: what share of the light that the texel would have arrives, 0 where it would have none.
    /// `estimates` are irradiance()'s of the request's texels, which know what lies inside geometry; empty = nothing
    /// does.
    virtual bool shadowmask(const TexelMap& map, const TexelRequest& request,
                            std::span<const IrradianceEstimate> estimates, std::span<vec4> out,
                            const Progress& progress) = 0;

    /// Light and occlusion at points in space: at positions[i] for each i of `which`, with `samples` paths (0 = as
    /// IntegrationSettings say).
    virtual bool probes(std::span<const vec3> positions, std::span<const uint32_t> which, int samples,
                        std::span<ProbeEstimate> out, const Progress& progress) = 0;

    /// How far from `from` the first and the last surface on the way to `to` are; nothing when the way is free.
    [[nodiscard]] virtual std::optional<vec2> surfacesBetween(vec3 from, vec3 to) const = 0;

    [[nodiscard]] virtual uint64_t raysTraced() const = 0;
};

/// Makes an integrator for a scene whose lights have their baking output assigned. `geometry` and `scene` outlive it.
using IntegratorFactory = std::function<Result<std::unique_ptr<Integrator>>(
    const Scene& scene, const BakeGeometry& geometry, const IntegrationSettings& settings)>;

} // namespace halflight
