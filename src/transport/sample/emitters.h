#pragma once
// Emissive triangles as light sources.

#include "transport/sample/light_tree.h"
#include "transport/sample/mis.h"
#include "transport/trace/ray_scene.h"

#include <cmath>
#include <vector>

namespace halflight {

/// A point that receives light. Its shading normal is zero for probes, which receive from all directions. Its samples
/// use a lane of a cut through the light tree (null = the root).
struct Receiver {
    vec3 position{0.0f};
    vec3 normal{0.0f};
    const LightTree::Cut* cut = nullptr;
    std::size_t lane = 0; ///< of the cut
};

/// A sampled point of an emissive surface.
struct EmitterSample {
    vec3 position{0.0f};
    vec3 normal{0.0f}; ///< geometric
    vec3 radiance{0.0f};
    bool doubleSided = false;
    bool rayVisible = true; ///< false = its object casts no shadow, so rays do not hit it
    float pdfArea = 0.0f;   ///< per square metre; 0 = no sample
    uint32_t triangle = 0;  ///< of the geometry
    vec2 barycentric{0.0f};
    int component = 0; ///< LightComponents

    [[nodiscard]] shading::SeenEmitter seenFrom(vec3 from) const
    {
        return shading::emitterSeenFrom(from, position, normal, pdfArea, doubleSided);
    }
    /// What nextEventContribution() makes of it at a surface.
    [[nodiscard]] NextEventContribution from(vec3 receiver, vec3 receiverNormal, vec3 geometricNormal) const
    {
        return nextEventContribution(receiver, receiverNormal, geometricNormal, position, normal, pdfArea, doubleSided,
                                     rayVisible);
    }
};

/// Emitter samples of eight receivers, by lane.
struct EmitterLanes {
    Vec3Lanes position;
    Vec3Lanes normal;
    Vec3Lanes radiance;
    std::array<float, kLanes> pdfArea;
    std::array<int32_t, kLanes> doubleSided;
    std::array<int32_t, kLanes> rayVisible;
    std::array<float, kLanes> weight; ///< 1 / probability that the sample is taken
    std::array<int32_t, kLanes> component;

    void set(std::size_t lane, const EmitterSample& s)
    {
        position.set(lane, s.position);
        normal.set(lane, s.normal);
        radiance.set(lane, s.radiance);
        pdfArea[lane] = s.radiance != vec3(0.0f) ? s.pdfArea : 0.0f; // black samples need no ray
        doubleSided[lane] = s.doubleSided ? 1 : 0;
        rayVisible[lane] = s.rayVisible ? 1 : 0;
        component[lane] = s.component;
    }
    [[nodiscard]] NextEventContribution from(std::size_t lane, vec3 receiver, vec3 receiverNormal,
                                             vec3 geometricNormal) const
    {
        return nextEventContribution(receiver, receiverNormal, geometricNormal, position[lane], normal[lane],
                                     pdfArea[lane], doubleSided[lane] != 0, rayVisible[lane] != 0);
    }
};

/// All emissive triangles, chosen by a light tree; points are uniform on the chosen triangle.
class Emitters {
public:
    Emitters(const RayScene& scene, const LightComponents& components);
    [[nodiscard]] bool empty() const { return triangles_.empty(); }
    [[nodiscard]] LightTree::Cut cut(const LightTree::Points& positions, const LightTree::Points& normals) const
    {
        return tree_.cut(positions, normals);
    }
    /// Estimate of the illuminance from all emitters without shadows, in lux.
    [[nodiscard]] float unshadowed(vec3 position, vec3 normal) const { return tree_.total(position, normal); }
    [[nodiscard]] EmitterSample sample(vec3 position, vec3 normal, vec2 u) const;
    /// Samples of the lanes in `wanted`; the other lanes have none.
    void sample(const LightTree::Cut& cut, const LightTree::Points& positions, const LightTree::Points& normals,
                const LightTree::Cut::Lanes<bool>& wanted, const Vec2Lanes& u, EmitterLanes& samples) const;
    /// Density of sample() on a triangle, per square metre; 0 for triangles that do not emit.
    [[nodiscard]] float pdfArea(const Receiver& receiver, uint32_t triangle) const;

    /// An emissive triangle with everything that a sample reads.
    struct Emissive {
        vec3 origin{0.0f};
        vec3 edge1{0.0f};
        vec3 edge2{0.0f};
        vec3 normal{0.0f};
        vec3 radiance{0.0f}; ///< if uniform
        float inverseArea = 0.0f;
        uint32_t triangle = 0;
        bool uniform = true;
        bool doubleSided = false;
        bool rayVisible = true;
        int component = 0;
    };
    [[nodiscard]] std::span<const Emissive> all() const { return triangles_; }
    [[nodiscard]] const LightTree& tree() const { return tree_; } ///< its items are those of all()
    static constexpr uint32_t kNone = ~0u;
    /// Index into all(), or kNone.
    [[nodiscard]] uint32_t itemOf(uint32_t triangle) const;

private:
    void shareAmongComponents(std::vector<LightItem>& items, int count) const;
    [[nodiscard]] float meanEmission(const TransportMaterial& material, uint32_t triangle) const;
    [[nodiscard]] inline EmitterSample at(const LightTree::Choice& choice, float v) const;

    const RayScene& scene_;
    std::vector<Emissive> triangles_;
    std::vector<uint32_t> firstOfPart_;    ///< by part, index into itemOfTriangle_; kNone = it emits nothing
    std::vector<uint32_t> itemOfTriangle_; ///< of parts that emit, by triangle; kNone = no item
    LightTree tree_;
};

} // namespace halflight
