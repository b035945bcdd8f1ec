// Where reflection probes are taken, and the boxes around them.

#include "bake/geometry/hash_grid.h"
#include "bake/geometry/surfaces_along.h"
#include "bake/reflections/reflections.h"
#include "halflight/base/mathematics.h"
#include "halflight/base/parallel.h"
#include "halflight/shading/reflection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace halflight {
namespace {

/// Most places that are compared; light probes are thinned out to this number.
constexpr std::size_t kMostPlaces = 400;
/// Most places whose own surroundings are proposed, whatever they serve.
constexpr std::size_t kMostProposed = kMostPlaces / 4;
/// Boxes of these end at this many times the mean distance of what is around, where nothing is nearer.
constexpr float kLocalShare = 2.5f;
/// Rays that measure a place's surroundings.
constexpr int kSurveyRays = 256;
/// Surroundings beyond this many sizes of the scene count as infinitely far.
constexpr float kFarShare = 4.0f;
/// A place counts where this share of its surroundings is not infinitely far: on open ground it is a half.
constexpr float kLeastSurrounded = 0.4f;
/// Things nearer than this share of the surroundings' mean distance cover too much of the picture.
constexpr float kClearance = 0.25f;
/// Boxes turned about the vertical are tried in steps of 5 degrees.
constexpr int kTurns = 18;
/// A turned box must predict distances better by this share.
constexpr float kTurnGain = 0.1f;

/// Directions spread evenly over the sphere (a Fibonacci lattice).
std::vector<vec3> evenDirections()
{
    std::vector<vec3> result;
    for (int i = 0; i < kSurveyRays; ++i) {
        const float y = 1.0f - (2.0f * float(i) + 1.0f) / float(kSurveyRays);
        const float r = std::sqrt(1.0f - y * y);
        const float phi = 2.0f * kPi * float(i) / std::numbers::phi_v<float>;
        result.emplace_back(r * math::cos(phi), y, r * math::sin(phi));
    }
    return result;
}

/// Positions of valid light probes, thinned out on a grid that grows until there are at most `most`.
std::vector<vec3> placesOf(std::span<const Probe> lightProbes, float sceneSizeMeters, std::size_t most)
{
    std::vector<vec3> all;
    for (const Probe& probe : lightProbes)
        if (probe.valid) all.push_back(probe.position);
    std::vector<vec3> places = all;
    for (float cell = sceneSizeMeters / 100.0f; places.size() > most; cell *= 1.25f) {
        DistinctPoints distinct(cell);
        places.clear();
        for (const vec3 place : all)
            if (distinct.insert(place)) places.push_back(place);
    }
    return places;
}

/// Distances to the surroundings of every place, in each direction; `far` where there is nothing.
Result<std::vector<std::vector<float>>> distancesAround(std::span<const vec3> places, std::span<const vec3> directions,
                                                        const Integrator& integrator, float far)
{
    std::vector<Segment> segments;
    for (const vec3 place : places)
        for (const vec3 direction : directions) segments.push_back({place, place + direction * far});
    const Result<SurfacesAlong> hits = surfacesAlong(integrator, segments);
    if (!hits) return hits.error();
    std::vector<std::vector<float>> result(places.size());
    for (std::size_t i = 0; i < segments.size(); ++i)
        result[i / directions.size()].push_back((*hits)[i] ? (*hits)[i]->x : far);
    return result;
}

/// Drops places with little around them: outside of rooms that stand alone, or above all there is.
void keepSurrounded(std::vector<vec3>& places, std::vector<std::vector<float>>& distances, float far)
{
    std::size_t kept = 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
        const auto hits = std::count_if(distances[i].begin(), distances[i].end(), [&](float d) { return d < far; });
        if (float(hits) < kLeastSurrounded * float(distances[i].size())) continue;
        places[kept] = places[i];
        if (kept != i) distances[kept] = std::move(distances[i]);
        ++kept;
    }
    places.resize(kept);
    distances.resize(kept);
}

/// Mean of what is not infinitely far.
float meanDistance(std::span<const float> distances, float far)
{
    float sum = 0.0f;
    int count = 0;
    for (const float distance : distances) {
        if (distance >= far) continue;
        sum += distance;
        ++count;
    }
    return count > 0 ? sum / float(count) : far;
}

/// A box about a place, turned about the vertical.
struct Box {
    float turn = 0.0f;           ///< radians
    std::array<float, 6> face{}; ///< metres from the place to the faces at -x, +x, -y, +y, -z, +z
};

vec3 turned(vec3 v, float radians)
{
    const float c = math::cos(radians);
    const float s = math::sin(radians);
    return {c * v.x - s * v.z, v.y, s * v.x + c * v.z};
}

/// How far a predicted distance is off, relative to the larger of both: 0…1.
float misfit(float predicted, float distance)
{
    return std::abs(predicted - distance) / std::max(predicted, distance);
}

/// The rays of a place in the axes of a turned box.
struct TurnedRays {
    std::array<std::array<float, kSurveyRays>, 3> perAxis{}; ///< 1 / |direction| along each axis
    std::array<std::array<bool, kSurveyRays>, 3> upper{}; ///< a ray goes towards the axis's second face, else its first
    std::array<std::vector<float>, 6> ends; ///< per face: sorted metres along its axis to the ends of rays towards it
};

TurnedRays turnedRays(float turn, std::span<const vec3> directions, std::span<const float> distances)
{
    TurnedRays rays;
    for (std::size_t i = 0; i < directions.size(); ++i) {
        const vec3 local = turned(directions[i], -turn);
        const vec3 size = glm::abs(local);
        for (int axis = 0; axis < 3; ++axis) {
            rays.perAxis[std::size_t(axis)][i] = std::min(1.0f / size[axis], std::numeric_limits<float>::max());
            rays.upper[std::size_t(axis)][i] = local[axis] > 0.0f;
        }
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        rays.ends[std::size_t(2 * axis + (local[axis] > 0.0f ? 1 : 0))].push_back(distances[i] * size[axis]);
    }
    for (std::vector<float>& ends : rays.ends) std::sort(ends.begin(), ends.end());
    return rays;
}

/// A ray towards the face that is being moved.
struct FaceRay {
    float perAxis = 0.0f;    ///< 1 / |direction| along the face's axis
    float otherFaces = 0.0f; ///< metres along the ray to the nearest other face
    float distance = 0.0f;   ///< metres to its surroundings
};

/// The position of a face with the least misfit of the rays towards it: the present one, or one of where rays end.
float fitFace(float present, std::span<const float> ends, std::span<const FaceRay> rays)
{
    const auto misfitOf = [&](float position) {
        float sum = 0.0f;
        for (const FaceRay& ray : rays) sum += misfit(std::min(position * ray.perAxis, ray.otherFaces), ray.distance);
        return sum;
    };
    constexpr std::size_t kTries = 16; // quantiles of the ends of rays: 256 rays have 43 on a face
    float best = present;
    float least = misfitOf(present);
    for (std::size_t k = 0; k < kTries; ++k) {
        const float position = ends[(2 * k + 1) * ends.size() / (2 * kTries)];
        const float tried = misfitOf(position);
        if (tried >= least) continue;
        least = tried;
        best = position;
    }
    return best;
}

/// The box of one turn with the least misfit. Each face moves, in turn, to where rays ended that left through it.
/// `error`: mean over all rays.
Box fitBox(float turn, std::span<const vec3> directions, std::span<const float> distances, float& error)
{
    const TurnedRays rays = turnedRays(turn, directions, distances);
    Box box{turn, {}};
    for (std::size_t f = 0; f < 6; ++f) box.face[f] = rays.ends[f][rays.ends[f].size() / 2];
    const auto predicted = [&](std::size_t axis, std::size_t i) {
        return box.face[2 * axis + (rays.upper[axis][i] ? 1 : 0)] * rays.perAxis[axis][i];
    };
    constexpr int kSweeps = 2; // over the faces, because each depends on the others
    std::vector<FaceRay> towards;
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
        for (std::size_t f = 0; f < 6; ++f) {
            const std::size_t axis = f / 2;
            towards.clear();
            for (std::size_t i = 0; i < distances.size(); ++i) {
                if (rays.upper[axis][i] != (f % 2 == 1)) continue;
                const float otherFaces = std::min(predicted((axis + 1) % 3, i), predicted((axis + 2) % 3, i));
                towards.push_back({rays.perAxis[axis][i], otherFaces, distances[i]});
            }
            box.face[f] = fitFace(box.face[f], rays.ends[f], towards);
        }
    }
    error = 0.0f;
    for (std::size_t i = 0; i < distances.size(); ++i)
        error +=
            misfit(std::min({predicted(0, i), predicted(1, i), predicted(2, i)}), distances[i]) / float(kSurveyRays);
    return box;
}

/// The best box of all turns.
Box fitBox(std::span<const vec3> directions, std::span<const float> distances)
{
    float error = 0.0f;
    Box box = fitBox(0.0f, directions, distances, error);
    float limit = (1.0f - kTurnGain) * error;
    for (int i = 1; i < kTurns; ++i) {
        float turnedError = 0.0f;
        const Box tried = fitBox(0.5f * kPi * float(i) / float(kTurns), directions, distances, turnedError);
        if (turnedError >= limit) continue;
        error = limit = turnedError;
        box = tried;
    }
    return box;
}

ReflectionProbe probeAt(vec3 place, const Box& box, float sceneSizeMeters)
{
    const vec3 low(-box.face[0], -box.face[2], -box.face[4]);
    const vec3 high(box.face[1], box.face[3], box.face[5]);
    const vec3 half = 0.5f * (high - low);
    ReflectionProbe probe{place, mat4(1.0f), 0.0f};
    for (int axis = 0; axis < 3; ++axis) {
        vec3 unit(0.0f);
        unit[axis] = half[axis];
        probe.worldFromBox[axis] = vec4(turned(unit, box.turn), 0.0f);
    }
    probe.worldFromBox[3] = vec4(place + turned(0.5f * (low + high), box.turn), 1.0f);
    probe.fadeMeters = reflectionFade(probe.worldFromBox, sceneSizeMeters);
    return probe;
}

/// A place with its surroundings, and the box that fits them.
struct Candidate {
    std::vector<float> distances; ///< by direction
    ReflectionProbe probe;
    float quality = 0.0f; ///< 0…1: more where the place is central, less where something is close
    float weight = 0.0f;  ///< share of its surroundings that is not infinitely far
};

/// 1 in the middle of a box, 0 at its faces; along axes on which the box ends within the scene.
float centrality(const ReflectionProbe& probe, float sceneSizeMeters)
{
    const vec3 inBox(glm::inverse(probe.worldFromBox) * vec4(probe.position, 1.0f));
    float result = 1.0f;
    for (int axis = 0; axis < 3; ++axis)
        if (glm::length(vec3(probe.worldFromBox[axis])) < sceneSizeMeters) result *= 1.0f - inBox[axis] * inBox[axis];
    return std::max(result, 0.0f);
}

Candidate candidateAt(vec3 place, std::span<const vec3> directions, std::vector<float> distances, float sceneSizeMeters)
{
    const float far = kFarShare * sceneSizeMeters;
    Candidate candidate;
    candidate.probe = probeAt(place, fitBox(directions, distances), sceneSizeMeters);
    const auto hits = std::count_if(distances.begin(), distances.end(), [&](float d) { return d < far; });
    candidate.weight = float(hits) / float(distances.size());
    const float clearance = *std::min_element(distances.begin(), distances.end()) / meanDistance(distances, far);
    candidate.quality =
        (0.5f + 0.5f * centrality(candidate.probe, sceneSizeMeters)) * std::min(clearance / kClearance, 1.0f);
    candidate.distances = std::move(distances);
    return candidate;
}

/// Mean of how far a box's prediction of distances from a place is off, relative to the larger of both: 0…1. `place`
/// and `directions` in the axes of the box, which is a cube there.
float misfitAt(vec3 place, std::span<const vec3> directions, std::span<const float> distances)
{
    float sum = 0.0f;
    for (std::size_t i = 0; i < directions.size(); ++i)
        sum += misfit(shading::distanceToCube(place, directions[i]), distances[i]);
    return sum / float(directions.size());
}

/// How well a probe at each place serves each other one, 0…1: as far as its box predicts what surrounds that place, and
/// by its quality; 0 where it does not see it.
Result<std::vector<std::vector<float>>> usesBetween(std::span<const Candidate> candidates,
                                                    std::span<const vec3> directions, const Integrator& integrator)
{
    const std::size_t count = candidates.size();
    std::vector<Segment> segments;
    for (const Candidate& from : candidates)
        for (const Candidate& to : candidates) segments.push_back({from.probe.position, to.probe.position});
    const Result<SurfacesAlong> hits = surfacesAlong(integrator, segments);
    if (!hits) return hits.error();
    std::vector<std::vector<float>> uses(count, std::vector<float>(count, 0.0f));
    parallelFor(count, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const mat4 boxFromWorld = glm::inverse(candidates[i].probe.worldFromBox);
            std::vector<vec3> inBox;
            for (const vec3 direction : directions) inBox.push_back(mat3(boxFromWorld) * direction);
            for (std::size_t k = 0; k < count; ++k) {
                if ((*hits)[i * count + k]) continue;
                const Candidate& to = candidates[k];
                const vec3 place(boxFromWorld * vec4(to.probe.position, 1.0f));
                const float error = misfitAt(place, inBox, to.distances);
                uses[i][k] = to.weight * candidates[i].quality * (1.0f - error);
            }
        }
    });
    return uses;
}

} // namespace

Result<std::vector<ReflectionProbe>> proposeReflections(std::span<const Probe> lightProbes,
                                                        const Integrator& integrator, float sceneSizeMeters)
{
    std::vector<vec3> places = placesOf(lightProbes, sceneSizeMeters, kMostProposed);
    const float far = kFarShare * sceneSizeMeters;
    const std::vector<vec3> directions = evenDirections();
    Result<std::vector<std::vector<float>>> around = distancesAround(places, directions, integrator, far);
    if (!around) return around.error();
    std::vector<std::vector<float>>& distances = *around;
    keepSurrounded(places, distances, far);
    std::vector<ReflectionProbe> probes(places.size());
    parallelFor(places.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const float local = kLocalShare * meanDistance(distances[i], far);
            for (float& distance : distances[i]) distance = std::min(distance, local);
            probes[i] = probeAt(places[i], fitBox(directions, distances[i]), sceneSizeMeters);
        }
    });
    return probes;
}

Result<std::vector<ReflectionProbe>> placeReflections(std::span<const Probe> lightProbes, const Integrator& integrator,
                                                      float sceneSizeMeters)
{
    std::vector<vec3> places = placesOf(lightProbes, sceneSizeMeters, kMostPlaces);
    if (places.empty()) return std::vector<ReflectionProbe>();
    const float far = kFarShare * sceneSizeMeters;
    const std::vector<vec3> directions = evenDirections();
    Result<std::vector<std::vector<float>>> around = distancesAround(places, directions, integrator, far);
    if (!around) return around.error();
    std::vector<std::vector<float>>& distances = *around;
    keepSurrounded(places, distances, far);
    std::vector<Candidate> candidates(places.size());
    parallelFor(places.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            candidates[i] = candidateAt(places[i], directions, std::move(distances[i]), sceneSizeMeters);
    });
    std::vector<ReflectionProbe> all;
    for (const Candidate& candidate : candidates) all.push_back(candidate.probe);
    std::vector<ReflectionProbe> probes;
    Result<std::vector<std::vector<float>>> uses = usesBetween(candidates, directions, integrator);
    if (!uses) return uses.error();
    for (const std::size_t i : chooseReflections(all, std::move(*uses))) probes.push_back(all[i]);
    return probes;
}

} // namespace halflight
