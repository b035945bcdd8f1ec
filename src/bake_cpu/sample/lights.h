#pragma once
// The scene's light sources, ready for sampling.

#include "bake_cpu/sample/light_tree.h"
#include "bake_cpu/sample/sampler.h"
#include "bake_cpu/trace/ray_tracer.h"

#include "halflight/scene/scene.h"
#include "halflight/shading/light.h"
#include "halflight/shading/sampling.h"

#include <vector>

namespace halflight {

/// Irradiance of a surface with a normal, of what an unoccluded light brings to its place.
inline vec3 irradianceOn(vec3 normal, const shading::LightSample& light)
{
    return light.illuminance * std::max(glm::dot(normal, light.direction), 0.0f);
}

/// A punctual light with its constants worked out.
struct PunctualLight {
    int type = shading::kLightPoint;
    vec3 colorIntensity{0.0f};
    vec3 position{0.0f};
    vec3 axis{0.0f};
    vec3 tangent{0.0f}; ///< with bitangent and axis an orthonormal basis
    vec3 bitangent{0.0f};
    float range = 0.0f;
    float reach = 0.0f; ///< metres up to which its mask holds its shadow; 0 = unlimited
    vec2 spotConstants{0.0f};
    float cosOuterCone = -1.0f;
    float radius = 0.0f;           ///< metres; point and spot
    float tanAngularRadius = 0.0f; ///< directional
    bool castShadows = true;
    float shadowStrength = 1.0f;
    float indirectMultiplier = 1.0f;
    bool directAtTexels = false; ///< its direct light is in the lightmap
    bool directAtProbes = false; ///< its direct light is in the probes
    bool bounces = false;        ///< its bounced light is baked
    int channel = -1;
    /// Its mask says what of the light that a texel would have arrives, and its direct light in the lightmap is made of
    /// the mask later (subtractive's main light).
    bool maskOfLight = false;

    /// What an unoccluded surface point receives.
    [[nodiscard]] shading::LightSample at(vec3 point) const
    {
        return shading::sampleLight(type, colorIntensity, position, axis, range, spotConstants, point);
    }
    /// Irradiance of an unoccluded point with a normal.
    [[nodiscard]] vec3 irradianceAt(vec3 point, vec3 normal) const { return irradianceOn(normal, at(point)); }
    /// Whether a point is within range, reach and cone. A light that is switched off in the file still reaches: it may
    /// be switched on at run time (spec S29), and its mask must be there then.
    [[nodiscard]] bool reaches(vec3 point) const
    {
        const shading::LightSample light =
            shading::sampleLight(type, vec3(1.0f), position, axis, range, spotConstants, point);
        return light.illuminance.x > 0.0f && (reach <= 0.0f || light.distance <= reach);
    }
};

enum class LightUse {
    Bake,      ///< by each light's baking output
    Reference, ///< every light, fully
};
std::vector<PunctualLight> punctualLights(const Scene& scene, LightUse use);

/// Ray towards a point of the disc that the light's sphere (or the sun) shows to `origin`; `disc` is in the unit disc.
struct LightRay {
    vec3 direction{0.0f};
    float distance = 0.0f;
};
LightRay sampleLightRay(const PunctualLight& light, vec3 origin, vec2 disc);

/// Who asks for light: a place, its shading normal (zero in space: light from all sides counts), and the cut of the
/// emitters' tree to begin from (null: the root).
struct Receiver {
    vec3 position{0.0f};
    vec3 normal{0.0f};
    const LightTree::Cut* cut = nullptr;
    std::size_t lane = 0; ///< of the cut
};

/// The way from a receiver to a point on an emitter.
struct NextEventContribution {
    vec3 direction{0.0f};
    float distance = 0.0f; ///< 0: nothing arrives
    float share = 0.0f;    ///< irradiance without shadows over the emitter's radiance; 1 / (pdf per steradian) is in it
};

/// Veach and Guibas 1995, "Optimally Combining Sampling Techniques for Monte Carlo Rendering": area samples of emitters
/// against cosine-distributed directions, where rays can hit the emitter. pdfs per steradian; the cosine-distributed
/// one is cos / pi. Without branches: loops over many receivers work on several at once.
inline NextEventContribution nextEventContribution(vec3 position, vec3 normal, vec3 geometricNormal,
                                                   vec3 emitterPosition, vec3 emitterNormal, float pdfArea,
                                                   bool doubleSided, bool rayVisible)
{
    const vec3 way = emitterPosition - position;
    const float distance2 = glm::dot(way, way);
    const float distance = std::sqrt(distance2);
    const vec3 direction = way * (1.0f / distance);
    const float cosine = glm::dot(normal, direction);
    const float front = -glm::dot(emitterNormal, direction);
    const float emitterCosine = doubleSided ? std::abs(front) : front;
    const float inversePdf = emitterCosine / (pdfArea * distance2);
    const float weight = rayVisible ? shading::powerHeuristic(1.0f, cosine / kPi * inversePdf) : 1.0f;
    const bool arrives = pdfArea > 0.0f && distance2 > 0.0f && cosine > 0.0f && emitterCosine > 0.0f &&
                         glm::dot(direction, geometricNormal) > 0.0f;
    return {direction, arrives ? distance : 0.0f, arrives ? cosine * inversePdf * weight : 0.0f};
}

/// What a ray that hit a sampled surface counts beside the samples of it (same source). directionPdf: per steradian;
/// pdfArea: of the samples at the hit, per square metre; cosine: at the hit.
inline float misWeightOfRay(float directionPdf, float pdfArea, float distance, float cosine)
{
    return shading::powerHeuristic(directionPdf, pdfArea * distance * distance / cosine);
}

/// A point on an emissive triangle.
struct EmitterSample {
    vec3 position{0.0f};
    vec3 normal{0.0f}; ///< geometric
    vec3 radiance{0.0f};
    bool doubleSided = false;
    bool rayVisible = true; ///< rays can hit it too: false when its object casts no shadow
    float pdfArea = 0.0f;   ///< per square metre; 0: there is no sample

    [[nodiscard]] NextEventContribution from(vec3 receiver, vec3 receiverNormal, vec3 geometricNormal) const
    {
        return nextEventContribution(receiver, receiverNormal, geometricNormal, position, normal, pdfArea, doubleSided,
                                     rayVisible);
    }
};

/// The same for eight receivers, side by side.
struct EmitterLanes {
    static constexpr std::size_t kLanes = LightTree::Cut::kLanes;
    Vec3Lanes<kLanes> position;
    Vec3Lanes<kLanes> normal;
    Vec3Lanes<kLanes> radiance;
    std::array<float, kLanes> pdfArea;
    std::array<int32_t, kLanes> doubleSided;
    std::array<int32_t, kLanes> rayVisible;
    std::array<float, kLanes> times; ///< how many samples each stands for

    void set(std::size_t lane, const EmitterSample& s)
    {
        position.set(lane, s.position);
        normal.set(lane, s.normal);
        radiance.set(lane, s.radiance);
        pdfArea[lane] = s.radiance != vec3(0.0f) ? s.pdfArea : 0.0f; // nothing to look at
        doubleSided[lane] = s.doubleSided ? 1 : 0;
        rayVisible[lane] = s.rayVisible ? 1 : 0;
    }
    [[nodiscard]] NextEventContribution from(std::size_t lane, vec3 receiver, vec3 receiverNormal,
                                             vec3 geometricNormal) const
    {
        return nextEventContribution(receiver, receiverNormal, geometricNormal, position[lane], normal[lane],
                                     pdfArea[lane], doubleSided[lane] != 0, rayVisible[lane] != 0);
    }
};

/// All emissive triangles in a tree of lights; uniform on the chosen triangle.
class Emitters {
public:
    explicit Emitters(const RayTracer& tracer);
    [[nodiscard]] bool empty() const { return triangles_.empty(); }
    [[nodiscard]] LightTree::Cut cut(const LightTree::Points& positions, const LightTree::Points& normals) const
    {
        return tree_.cut(positions, normals);
    }
    /// About what all of them together give a point without shadows, in lux.
    [[nodiscard]] float unshadowed(vec3 position, vec3 normal) const { return tree_.total(position, normal); }
    [[nodiscard]] EmitterSample sample(vec3 position, vec3 normal, vec2 u) const;
    /// The same for those lanes of a cut that are wanted; no sample in the others.
    void sample(const LightTree::Cut& cut, const LightTree::Points& positions, const LightTree::Points& normals,
                const LightTree::Cut::Lanes<bool>& wanted, const Vec2Lanes<LightTree::Cut::kLanes>& u,
                EmitterLanes& samples) const;
    /// Density, per square metre, with which sample() chooses points of a triangle; 0 when it is no emitter.
    [[nodiscard]] float pdfArea(const Receiver& receiver, uint32_t triangle) const;

private:
    /// What a sample needs of its triangle, side by side.
    struct Emissive {
        vec3 origin{0.0f};
        vec3 edge1{0.0f};
        vec3 edge2{0.0f};
        vec3 normal{0.0f};
        vec3 radiance{0.0f}; ///< where it is the same all over
        float inverseArea = 0.0f;
        uint32_t triangle = 0;
        bool uniform = true;
        bool doubleSided = false;
        bool rayVisible = true;
    };
    /// On the chosen triangle.
    [[nodiscard]] inline EmitterSample at(const LightTree::Choice& choice, float v) const;

    const RayTracer& tracer_;
    std::vector<Emissive> triangles_;
    std::vector<uint32_t> itemOfTriangle_; ///< ~0 = none; empty without emitters
    LightTree tree_;
};

/// Tree over the point and spot lights that bounce; `itemLights` returns the light of each item.
LightTree punctualTree(const std::vector<PunctualLight>& lights, std::vector<uint32_t>& itemLights);

} // namespace halflight
