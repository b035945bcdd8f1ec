#include "bake/probes/probe_rooms.h"

#include "bake/geometry/indices.h"
#include "bake/geometry/surfaces_along.h"

#include "halflight/shading/color.h"
#include "halflight/shading/sh.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace halflight {
namespace {

/// Columns of rays: each costs little beside the paths of a probe.
constexpr double kMostColumns = 8.0 * double(kMostProbes);
/// Segments that are traced at once: some megabytes.
constexpr std::size_t kAtOnce = 1 << 17;

/// Light over that of another corner below which linear interpolation between both may be wrong: where light falls by
/// this share over a cell, it may be off by 10 % in the middle.
constexpr float kSteep = (1.0f - kDisagrees) * (1.0f - kDisagrees);

/// Error of interpolated light, over the larger of both, from which on a steep cell in a room is halved.
constexpr float kOff = 0.15f;
/// Shortest sides of cells that are halved where light changes, over the smallest room in them. Objects that move in a
/// room average finer changes.
constexpr float kRoomShare = 0.0625f;

/// Over all directions, lux.
float meanIrradiance(const SphericalHarmonicsL2& radiance)
{
    return luminance(radiance[0]) * shading::shIrradianceWeight(0, vec3(0, 1, 0));
}

/// Of a corner of a cell of the given sides, at a place in it or beside it; never 0.
float trilinearWeight(vec3 place, vec3 corner, vec3 sides)
{
    const vec3 share = glm::max(1.0f - glm::abs(place - corner) / sides, vec3(0.01f));
    return share.x * share.y * share.z;
}

/// Room around a place without which no object fits in, over its reach.
float clearance(float reachMeters)
{
    return 0.25f * reachMeters;
}

/// A ray of a column: from a surface, or from the rim of the box.
struct Ray {
    vec3 from{0.0f};
    bool leavesSurface = false;
};

/// Places between two surfaces, or a surface and the rim of the box.
void addPlaces(const Ray& ray, int axis, float length, bool endsAtSurface, float reachMeters,
               std::vector<Place>& places)
{
    if (length < reachMeters) return;
    const float off = std::min(reachMeters, 0.5f * length);
    const auto add = [&](float along) {
        Place place{ray.from, ray.leavesSurface && endsAtSurface ? length : kInfinity};
        place.position[axis] += along;
        places.push_back(place);
    };
    if (ray.leavesSurface) add(off);
    if (endsAtSurface && (!ray.leavesSurface || length > 2.0f * off)) add(length - off);
}

} // namespace

Result<std::vector<Place>> placesBesideSurfaces(const Bounds& box, float reachMeters, const Integrator& integrator)
{
    std::vector<Place> places;
    const vec3 size = box.size();
    const float longest = std::max({size.x, size.y, size.z});
    const double area =
        double(size.x) * double(size.y) + double(size.y) * double(size.z) + double(size.z) * double(size.x);
    const float spacing = std::max(2.0f * reachMeters, float(std::sqrt(area / kMostColumns)));
    const float step = 1.0e-5f * longest; // off a surface, however floats round
    for (int axis = 0; axis < 3; ++axis) {
        const int u = (axis + 1) % 3;
        const int v = (axis + 2) % 3;
        const ivec2 count = glm::max(ivec2(vec2(size[u], size[v]) / spacing), 1);
        std::vector<Ray> rays;
        for (int i = 0; i < count.x * count.y; ++i) {
            Ray ray{box.min};
            ray.from[axis] -= step;
            ray.from[u] += size[u] * (float(i % count.x) + 0.5f) / float(count.x);
            ray.from[v] += size[v] * (float(i / count.x) + 0.5f) / float(count.y);
            rays.push_back(ray);
        }
        const float end = box.max[axis] + step;
        for (int crossing = 0; crossing < 64 && !rays.empty(); ++crossing) {
            std::vector<Segment> segments;
            for (const Ray& ray : rays) {
                segments.push_back({ray.from, ray.from});
                segments.back().to[axis] = end;
            }
            const Result<SurfacesAlong> surfaces = surfacesAlong(integrator, segments);
            if (!surfaces) return surfaces.error();
            std::vector<Ray> next;
            for (std::size_t i = 0; i < rays.size(); ++i) {
                const std::optional<vec2>& surface = (*surfaces)[i];
                const float left = end - rays[i].from[axis];
                addPlaces(rays[i], axis, surface ? surface->x : left, surface.has_value(), reachMeters, places);
                if (!surface || surface->x + 2.0f * step > left) continue;
                Ray beyond{rays[i].from, true};
                beyond.from[axis] += surface->x + step;
                next.push_back(beyond);
            }
            rays = std::move(next);
        }
    }
    // The last bit of open air may end at the box, above all that is there.
    std::erase_if(places, [&](const Place& p) {
        return glm::any(glm::greaterThan(glm::abs(p.position - box.center()), 0.5f * size));
    });
    return places;
}

std::vector<Place> checkPlaces(const std::vector<Place>& places, std::size_t probeCount)
{
    const std::size_t most = std::min(kMostProbes / 80, probeCount / 32);
    if (places.size() <= most) return places;
    std::vector<Place> some;
    for (std::size_t i = 0; i < most; ++i) some.push_back(places[i * places.size() / most]);
    return some;
}

bool isUnlit(const Place& place, const SphericalHarmonicsL2& radiance, float dark)
{
    return place.roomMeters == kInfinity && meanIrradiance(radiance) < dark;
}

std::vector<RoomCell> RoomSearch::gridCells() const
{
    std::vector<RoomCell> rooms;
    for (const ProbeTree::Cell& cell : tree_.gridCells()) rooms.push_back({cell, {}});
    for (uint32_t i = 0; i < places_.size(); ++i) rooms[tree_.gridCellAt(place(i))].places.push_back(i);
    return rooms;
}

std::vector<RoomCell> RoomSearch::halvesOf(const RoomCell& room) const
{
    std::vector<RoomCell> parts;
    const vec3 middle = tree_.positionOf(room.cell.low + room.cell.size / 2);
    for (ProbeTree::Cell& part : tree_.halves(room.cell)) {
        part.sides = tree_.sidesOf(part);
        RoomCell& half = parts.emplace_back(RoomCell{part, {}});
        for (const uint32_t i : room.places) {
            bool isIn = true;
            for (int axis = 0; axis < 3; ++axis) {
                if (part.size[axis] == room.cell.size[axis]) continue;
                isIn &= (place(i)[axis] >= middle[axis]) == (part.low[axis] > room.cell.low[axis]);
            }
            if (isIn) half.places.push_back(i);
        }
    }
    return parts;
}

Result<std::vector<RoomSearch::Sight>> RoomSearch::sightOf(std::span<const RoomCell> cells,
                                                           std::span<const Probe> probes, float dark) const
{
    std::vector<Sight> sights(cells.size());
    std::vector<Segment> segments;
    std::vector<std::size_t> seen;
    const auto finish = [&](std::size_t begin, std::size_t end) -> Status {
        const Result<SurfacesAlong> surfaces = surfacesAlong(integrator_, segments);
        if (!surfaces) return surfaces.error();
        std::size_t at = 0;
        for (std::size_t i = begin; i < end; ++i) {
            Sight& sight = sights[i];
            std::size_t fewest = sight.corners.size();
            const vec3 sizes = tree_.sidesOf(cells[i].cell);
            for (const uint32_t place : cells[i].places) {
                std::size_t count = 0;
                float least = kInfinity;
                float largest = 0.0f;
                vec2 sum(0.0f); // of weighted light, and of weights
                for (const uint32_t corner : sight.corners) {
                    if ((*surfaces)[at++]) continue;
                    const float light = std::max(meanIrradiance(probes[corner].radiance), dark);
                    least = std::min(least, light);
                    largest = std::max(largest, light);
                    sum += trilinearWeight(places_[place].position, probes[corner].position, sizes) * vec2(light, 1.0f);
                    ++count;
                }
                if (count == 1) sight.isLonely = true;
                if (count > 1 && least < sight.evenness * largest) {
                    sight.evenness = least / largest;
                    sight.steepest = place;
                    sight.interpolated = sum.x / sum.y;
                }
                if (count == 0) sight.unseen.push_back(place);
                if (count == 0 || count >= fewest) continue;
                fewest = count;
                sight.hidden = place;
            }
        }
        segments.clear();
        return {};
    };
    std::size_t begin = 0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
        sights[i].corners = tree_.validCorners(cells[i].cell);
        for (const uint32_t place : cells[i].places)
            for (const uint32_t corner : sights[i].corners)
                segments.push_back({probes[corner].position, places_[place].position});
        if (segments.size() < kAtOnce && i + 1 < cells.size()) continue;
        if (Status s = finish(begin, i + 1); !s) return s.error();
        begin = i + 1;
    }
    return sights;
}

/// 1 where nothing is within the clearance, along the axes.
Result<std::vector<uint8_t>> RoomSearch::clearOf(std::span<const uint32_t> places) const
{
    std::vector<Segment> segments;
    for (const uint32_t i : places) {
        for (int axis = 0; axis < 3; ++axis) {
            vec3 way(0.0f);
            way[axis] = clearance(reach_);
            segments.push_back({place(i) - way, place(i) + way});
        }
    }
    const Result<SurfacesAlong> surfaces = surfacesAlong(integrator_, segments);
    if (!surfaces) return surfaces.error();
    std::vector<uint8_t> clear(places.size());
    for (std::size_t i = 0; i < places.size(); ++i) {
        const std::optional<vec2>* alongAxes = &(*surfaces)[3 * i];
        clear[i] = !alongAxes[0] && !alongAxes[1] && !alongAxes[2] ? 1 : 0;
    }
    return clear;
}

Status RoomSearch::trace(std::span<const uint32_t> places, int paths, std::vector<ProbeEstimate>& out,
                         const Progress& progress) const
{
    std::vector<vec3> positions;
    for (const uint32_t i : places) positions.push_back(place(i));
    out.resize(places.size());
    return integrator_.probes(positions, allIndices(positions.size()), paths, out, Progress{{}, progress.cancel});
}

/// Places in gaps that are too narrow count as inside, and so do unlit ones.
Status RoomSearch::findOutside(std::vector<uint32_t> places, float dark, const Progress& progress)
{
    const Result<std::vector<uint8_t>> clear = clearOf(places);
    if (!clear) return clear.error();
    std::vector<uint32_t> open;
    for (std::size_t i = 0; i < places.size(); ++i) {
        known_[places[i]] = kInside;
        if ((*clear)[i] != 0) open.push_back(places[i]);
    }
    std::vector<ProbeEstimate> tests;
    if (Status s = trace(open, kTestPaths, tests, progress); !s) return s;
    std::vector<uint32_t> dim;
    for (std::size_t i = 0; i < open.size(); ++i) {
        if (!tests[i].valid) continue;
        known_[open[i]] = kOutside;
        if (isUnlit(places_[open[i]], tests[i].radiance, dark)) dim.push_back(open[i]);
    }
    if (Status s = trace(dim, 4 * kTestPaths, tests, progress); !s) return s; // few paths may miss light
    for (std::size_t i = 0; i < dim.size(); ++i)
        if (isUnlit(places_[dim[i]], tests[i].radiance, dark)) known_[dim[i]] = kInside;
    return {};
}

/// The smallest in a cell, in metres; kInfinity in the open.
float RoomSearch::roomIn(const RoomCell& cell) const
{
    float room = kInfinity;
    for (const uint32_t i : cell.places)
        if (known_[i] != kInside) room = std::min(room, places_[i].roomMeters);
    return room;
}

/// Sides to which cells are halved for light alone, by the smallest room in them.
float RoomSearch::finestIn(float room)
{
    return room < kInfinity ? std::max(kFinestMeters, kRoomShare * room) : kFinestMeters;
}

/// Distance of a place from the cell, along the axis where it is largest.
float RoomSearch::beyondMeters(const ProbeTree::Cell& cell, uint32_t i) const
{
    const vec3 low = tree_.positionOf(cell.low);
    const vec3 high = tree_.positionOf(cell.low + cell.size);
    const vec3 off = glm::abs(place(i) - glm::clamp(place(i), low, high));
    return std::max({off.x, off.y, off.z});
}

/// Cells whose corners see a place in very different light: halved in the open, where one place says little of the
/// others; in a room, where their interpolation is wrong at that place. No half of a cell at the rim of the grid has
/// corners at places beyond it; one of these gets a probe.
Status RoomSearch::checkSteep(std::span<const RoomCell> cells, std::span<const Sight> sights, float dark,
                              std::vector<Verdict>& verdicts, const Progress& progress) const
{
    std::vector<std::size_t> steep;
    std::vector<uint32_t> places;
    for (std::size_t i = 0; i < cells.size(); ++i) {
        if (verdicts[i].halve || verdicts[i].unseen || sights[i].evenness >= kSteep) continue;
        const float beyond = beyondMeters(cells[i].cell, *sights[i].steepest);
        if (beyond > 0.0f) verdicts[i].unseen = sights[i].steepest;
        const float room = roomIn(cells[i]);
        if (!tree_.canHalve(cells[i].cell, std::max(finestIn(room), beyond))) continue;
        verdicts[i].halve = room == kInfinity;
        if (verdicts[i].halve) continue;
        steep.push_back(i);
        places.push_back(*sights[i].steepest);
    }
    std::vector<ProbeEstimate> tests;
    if (Status s = trace(places, 0, tests, progress); !s) return s;
    for (std::size_t k = 0; k < steep.size(); ++k) {
        const float here = std::max(meanIrradiance(tests[k].radiance), dark);
        const float there = sights[steep[k]].interpolated;
        const float noise = std::sqrt(tests[k].variance) * shading::shIrradianceWeight(0, vec3(0, 1, 0));
        const float off = std::abs(here - there) - noise;
        verdicts[steep[k]].halve = tests[k].valid && off > kOff * std::max(here, there);
    }
    return {};
}

/// Cells with places that some corners do not see, by their light.
Status RoomSearch::compareLight(std::span<const RoomCell> cells, std::span<const Sight> sights,
                                std::span<const Probe> probes, float dark, std::vector<Verdict>& verdicts,
                                const Progress& progress) const
{
    std::vector<std::size_t> even;
    std::vector<uint32_t> places;
    for (std::size_t i = 0; i < cells.size(); ++i) {
        if (verdicts[i].halve || !sights[i].hidden ||
            !tree_.canHalve(cells[i].cell, std::max(2.0f * kFinestMeters, finestIn(roomIn(cells[i])))))
            continue;
        std::vector<const Probe*> corners;
        for (const uint32_t corner : sights[i].corners) corners.push_back(&probes[corner]);
        verdicts[i].halve = disagreement(corners, dark) >= 1.0f;
        if (verdicts[i].halve) continue;
        even.push_back(i);
        places.push_back(*sights[i].hidden);
    }
    std::vector<ProbeEstimate> tests;
    if (Status s = trace(places, 4 * kTestPaths, tests, progress); !s) return s;
    for (std::size_t k = 0; k < even.size(); ++k) {
        float least = kInfinity;
        float largest = dark;
        for (const uint32_t corner : sights[even[k]].corners) {
            const float there = meanIrradiance(probes[corner].radiance);
            least = std::min(least, std::max(there, dark));
            largest = std::max(largest, there);
        }
        const float here = meanIrradiance(tests[k].radiance);
        const float noise = 2.0f * std::sqrt(tests[k].variance) *
                            shading::shIrradianceWeight(0, vec3(0, 1, 0)); // two standard deviations
        const bool darker = std::max(here + noise, dark) < (1.0f - kDisagrees) * least;
        const bool brighter = largest < (1.0f - kDisagrees) * (here - noise);
        verdicts[even[k]].halve = tests[k].valid && (darker || brighter);
    }
    return {};
}

Result<std::vector<RoomSearch::Verdict>> RoomSearch::judge(std::span<const RoomCell> cells,
                                                           std::span<const Probe> probes, const Progress& progress)
{
    const float dark = darkIrradiance(probes).value_or(0.0f);
    const Result<std::vector<Sight>> found = sightOf(cells, probes, dark);
    if (!found) return found.error();
    const std::vector<Sight>& sights = *found;
    std::vector<uint32_t> unknown;
    for (const Sight& sight : sights)
        for (const uint32_t place : sight.unseen)
            if (known_[place] == kUnknown) unknown.push_back(place);
    if (Status s = findOutside(std::move(unknown), dark, progress); !s) return s.error();
    std::vector<Verdict> verdicts(cells.size());
    for (std::size_t i = 0; i < cells.size(); ++i) {
        for (const uint32_t place : sights[i].unseen)
            if (known_[place] == kOutside && !verdicts[i].unseen) verdicts[i].unseen = place;
        bool halve = verdicts[i].unseen || sights[i].isLonely;
        verdicts[i].error = verdicts[i].unseen ? 1.0f : 1.0f - sights[i].evenness;
        for (const uint32_t place : cells[i].places)
            halve |= known_[place] != kInside &&
                     tree_.canHalve(cells[i].cell, std::max(places_[place].roomMeters, 2.0f * kFinestMeters));
        verdicts[i].halve = halve && tree_.canHalve(cells[i].cell, kFinestMeters);
    }
    if (Status s = checkSteep(cells, sights, dark, verdicts, progress); !s) return s.error();
    if (Status s = compareLight(cells, sights, probes, dark, verdicts, progress); !s) return s.error();
    return verdicts;
}

} // namespace halflight
