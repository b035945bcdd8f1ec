#include "bake/stages.h"

#include "halflight/base/parallel.h"
#include "halflight/base/random.h"
#include "halflight/shading/sampling.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace halflight {
namespace {

/// Which way surfaces without thickness look is told by rays from both of their sides, patch by patch (Takayama et al.
/// 2014, "A Simple Method for Correcting Facet Orientations in Polygon Meshes Based on Ray Casting").
class Hollows {
public:
    Hollows(const Scene& scene, const BakeGeometry& geometry, const Integrator& integrator)
        : geometry_(geometry), integrator_(integrator), places_(lightsAndLookers(scene))
    {
        Bounds bounds;
        for (const vec3 position : geometry.positions) bounds.extend(position);
        const float diagonal = bounds.empty() ? 0.0f : glm::length(bounds.size());
        far_ = diagonal;
        widest_ = std::min(kWidestMeters, kWidestShare * diagonal);
        lift_ = kLift * diagonal;
    }

    /// Whether a patch's front faces a narrow, empty hollow that is closed but for a little, and its back the open.
    [[nodiscard]] bool facedBy(std::span<const uint32_t> patch) const
    {
        // A few rays tell of nearly all that it is not so; many, of the others, how wide its openings are.
        std::vector<float> front;
        if (!staysWithin(patch, kManyRays / kFewRays, 2 * kStrayRays * kFewRays / kManyRays, front)) return false;
        if (!staysWithin(patch, 1, kStrayRays, front)) return false;
        std::vector<float> back;
        for (int ray = 0; ray < kManyRays; ray += kManyRays / kBackRays) {
            const Start s = startOf(patch, ray);
            back.push_back(freeWay(s.position - lift_ * s.normal, -s.direction));
        }
        const auto isFar = [&](float length) { return !(length <= widest_); };
        const auto strays = float(std::count_if(front.begin(), front.end(), isFar)) / float(front.size());
        const auto open = float(std::count_if(back.begin(), back.end(), isFar)) / float(back.size());
        return open >= std::max(kLeastOpen, kMoreOpen * strays) &&
               quantile(back, 3, 4) >= kMoreSpace * quantile(front, 1, 2) && isEmpty(patch);
    }

private:
    static constexpr float kWidestMeters = 1.0f; ///< narrower than rooms
    static constexpr float kWidestShare = 0.1f;  ///< of the scene
    static constexpr float kLift = 1.0e-5f;      ///< of the scene: past faces in the same place
    static constexpr int kFewRays = 32;
    static constexpr int kBackRays = 128;
    static constexpr int kManyRays = 1024;
    static constexpr int kStrayRays = 50;        ///< at most, that get out where faces are missing or do not quite meet
    static constexpr float kLeastOpen = 0.0625f; ///< share of the back's rays that get out
    static constexpr float kMoreOpen = 8.0f;     ///< so many times as many as the front's
    static constexpr float kMoreSpace = 4.0f;
    static constexpr uint32_t kSeed = 0x5eed0021u;

    struct Start {
        vec3 position;
        vec3 normal;
        vec3 direction; ///< cosine-distributed
    };
    /// All patches have the same rays, so that what is told of one does not depend on how many others there are.
    [[nodiscard]] Start startOf(std::span<const uint32_t> patch, int ray) const
    {
        const uint32_t triangle = patch[std::size_t(ray) * patch.size() / kManyRays];
        const vec2 b = shading::sampleTriangle(r2Point(int(hashCombine(kSeed, uint32_t(ray)) >> 8)));
        const SurfacePoint point = surfacePoint(geometry_, triangle, b);
        Start s;
        s.position = point.position;
        s.normal = point.geometricNormal;
        vec3 tangent;
        vec3 bitangent;
        shading::orthonormalBasis(s.normal, tangent, bitangent);
        const vec3 local = shading::sampleCosineHemisphere(r2Point(ray));
        s.direction = local.x * tangent + local.y * bitangent + local.z * s.normal;
        return s;
    }
    [[nodiscard]] float freeWay(vec3 from, vec3 direction) const
    {
        const std::optional<vec2> met = integrator_.surfacesBetween(from, from + far_ * direction);
        return met ? met->x : kInfinity;
    }
    /// Adds the lengths of every n-th ray from the front; false where more than `stray` of them go too far.
    [[nodiscard]] bool staysWithin(std::span<const uint32_t> patch, int every, int stray,
                                   std::vector<float>& lengths) const
    {
        for (int ray = 0; ray < kManyRays; ray += every) {
            const Start s = startOf(patch, ray);
            lengths.push_back(freeWay(s.position + lift_ * s.normal, s.direction));
            if (!(lengths.back() <= widest_) && --stray < 0) return false;
        }
        return true;
    }
    static float quantile(std::vector<float>& values, std::size_t times, std::size_t over)
    {
        const auto at = values.begin() + std::ptrdiff_t(values.size() * times / over);
        std::nth_element(values.begin(), at, values.end());
        return *at;
    }
    /// Whether no light is in front of a patch, close by and in sight, and nothing that looks or moves.
    [[nodiscard]] bool isEmpty(std::span<const uint32_t> patch) const
    {
        return std::none_of(places_.begin(), places_.end(), [&](vec3 place) {
            for (int ray = 0; ray < kManyRays; ray += kManyRays / kFewRays) {
                const Start s = startOf(patch, ray);
                const vec3 from = s.position + lift_ * s.normal;
                if (glm::dot(place - from, s.normal) <= 0.0f || glm::distance(from, place) > widest_) continue;
                if (!integrator_.surfacesBetween(from, place)) return true;
            }
            return false;
        });
    }

    const BakeGeometry& geometry_;
    const Integrator& integrator_;
    std::vector<vec3> places_; ///< of lights and lookers
    float far_ = 0.0f;
    float widest_ = 0.0f;
    float lift_ = 0.0f;
};

/// Triangles that may be turned, object by object: seen from both sides, without light of their own, and not known to
/// be a solid's.
std::vector<std::vector<uint32_t>> candidates(const Scene& scene, const BakeGeometry& geometry)
{
    std::vector<std::vector<uint32_t>> objects;
    int last = -1; // parts of an object follow one another
    for (const BakeGeometry::Part& part : geometry.parts) {
        if (part.material < 0 || part.page < 0) continue;
        const Material& m = scene.materials[std::size_t(part.material)];
        if (!m.doubleSided || m.emissiveNits != vec3(0.0f)) continue;
        if (part.object != last) objects.emplace_back();
        last = part.object;
        for (uint32_t t = part.firstTriangle; t < part.firstTriangle + part.triangleCount; ++t) {
            if (geometry.solid[t] == 0 && geometry.geometricNormal(t) != vec3(0.0f)) objects.back().push_back(t);
        }
    }
    return objects;
}

/// Whether there were any.
bool turnHollows(const Scene& scene, BakeGeometry& geometry, const Integrator& integrator)
{
    const std::vector<std::vector<uint32_t>> objects = candidates(scene, geometry);
    std::vector<std::vector<std::vector<uint32_t>>> patchesOf(objects.size());
    parallelFor(objects.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t o = begin; o < end; ++o) patchesOf[o] = facingPatches(geometry, objects[o]);
    });
    std::vector<std::span<const uint32_t>> patches;
    for (const auto& ofObject : patchesOf) patches.insert(patches.end(), ofObject.begin(), ofObject.end());
    const Hollows hollows(scene, geometry, integrator);
    std::vector<uint8_t> turns(patches.size(), 0);
    parallelFor(patches.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) turns[i] = hollows.facedBy(patches[i]) ? 1 : 0;
    });
    for (std::size_t i = 0; i < patches.size(); ++i) {
        if (turns[i] != 0) turnAround(geometry, patches[i]);
    }
    return std::find(turns.begin(), turns.end(), uint8_t(1)) != turns.end();
}

} // namespace

Result<std::unique_ptr<Integrator>> turnHollows(const IntegratorFactory& factory, const Scene& scene,
                                                BakeGeometry& geometry, const IntegrationSettings& settings)
{
    Result<std::unique_ptr<Integrator>> integrator = factory(scene, geometry, settings);
    if (!integrator || !turnHollows(scene, geometry, **integrator)) return integrator;
    return factory(scene, geometry, settings);
}

} // namespace halflight
