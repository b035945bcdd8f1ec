#include "bake_cpu/guiding/guides.h"

#include "bake_cpu/radiosity/radiance_cache.h"

#include "halflight/base/disjoint_sets.h"
#include "halflight/base/memory.h"
#include "halflight/base/polygon.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <tuple>

namespace halflight {
namespace {

/// Bright cells have at least so many times the radiosity that would make all that rays bring their receivers.
constexpr float kBrighter = 3.0f;
/// Bright cells are put together to patches over so many texels, and receivers to guides. Receivers around tell one
/// another, each ray for so much of one.
constexpr float kPatchTexels = 32.0f;
constexpr float kGuideTexels = 8.0f;
/// Where more than this share of sightings are the only ones of a cell, cells around that are bright as this share of
/// the mean count as seen.
constexpr float kManyOnce = 0.2f;
constexpr float kAsBright = 0.5f;
constexpr float kNeighbourWeight = 0.5f;
/// Where so few of their rays met bright cells, receivers ask in cubes so many times as wide, and again. What they hear
/// is of use where it makes nearly all of the noise: it may be hidden from some of them.
constexpr float kEnoughSightings = 128.0f;
constexpr float kWider = 3.0f;
constexpr int kGuideLevels = 5;
constexpr float kNoiseFromAfar = 10.0f;
/// The others ask in cubes of this level for what they have not met, and send so many of their samples there where it
/// makes as much noise.
constexpr int kFarLevel = 3;
constexpr float kNoiseUnseen = 0.5f;
constexpr std::size_t kMostEntries = 64; ///< of a guide
/// Pieces take memory: there are so many at most, or one for so many of the lightmap's texels.
constexpr std::size_t kFewPieces = 81920;
constexpr std::size_t kTexelsForPiece = 6;

bool isBright(float radiance, float illuminance)
{
    const float radiosity = kPi * radiance;
    return radiosity > 0.0f && radiosity < kInfinity && radiosity >= kBrighter * illuminance;
}

/// Cubes of space, six of each for the directions that surfaces in them face, whatever charts these are on.
class Cubes {
public:
    explicit Cubes(float width) : width_(width) {}
    [[nodiscard]] uint64_t key(vec3 position, int direction) const
    {
        return pack(ivec3(glm::floor(position / width_)), direction);
    }
    /// Calls body(key) for a cube and those around it.
    template<typename Body> static void around(uint64_t key, const Body& body)
    {
        const ivec3 at(int(key >> 40 & kMask), int(key >> 20 & kMask), int(key & kMask));
        for (int i = 0; i < 27; ++i) body(pack(at + ivec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1), int(key >> 60)));
    }

private:
    static constexpr uint64_t kMask = (1u << 20) - 1u;
    static uint64_t pack(ivec3 at, int direction)
    {
        return uint64_t(direction) << 60 | (uint64_t(at.x) & kMask) << 40 | (uint64_t(at.y) & kMask) << 20 |
               (uint64_t(at.z) & kMask);
    }
    float width_;
};

/// Gives each key but `none` a number, and returns the keys in the order of their numbers.
std::vector<uint64_t> numberKeys(std::span<const uint64_t> keys, uint64_t none, std::vector<uint32_t>& numbers)
{
    std::vector<uint64_t> sorted;
    std::copy_if(keys.begin(), keys.end(), std::back_inserter(sorted), [&](uint64_t key) { return key != none; });
    std::sort(sorted.begin(), sorted.end());
    sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
    numbers.assign(keys.size(), ~0u);
    for (std::size_t i = 0; i < keys.size(); ++i) {
        if (keys[i] == none) continue;
        numbers[i] = uint32_t(std::lower_bound(sorted.begin(), sorted.end(), keys[i]) - sorted.begin());
    }
    return sorted;
}

/// Calls body(cell, x, y) for each cell of a front that the bounds of a triangle reach.
template<typename Body> void forCells(const RadianceCache::Surface& s, const Body& body)
{
    const vec2 low = s.origin + glm::min(vec2(0.0f), glm::min(s.edgeU, s.edgeV));
    const vec2 high = s.origin + glm::max(vec2(0.0f), glm::max(s.edgeU, s.edgeV));
    const ivec2 last(int(s.width) - 1, int(s.height) - 1);
    const ivec2 from = glm::clamp(ivec2(low), ivec2(0), last);
    const ivec2 to = glm::clamp(ivec2(high), ivec2(0), last);
    for (int y = from.y; y <= to.y; ++y) {
        for (int x = from.x; x <= to.x; ++x) {
            body((s.firstCell & RadianceCache::kCellMask) + uint32_t(y) * s.width + uint32_t(x), x, y);
        }
    }
}

/// What of a triangle lies in one of its cells, in barycentric weights. What lies beyond the rectangle of cells belongs
/// to those at its border, as in RadianceCache::cellIndex().
Polygon pieceIn(const RadianceCache::Surface& s, int x, int y)
{
    Polygon piece;
    piece.points = {{{0.0f, 0.0f}, {1.0f, 0.0f}, {0.0f, 1.0f}}};
    piece.count = 3;
    const auto between = [&](vec2 along, float origin, int i, int count) {
        if (i > 0) piece = clip(piece, along, float(i) - origin);
        if (i + 1 < count) piece = clip(piece, -along, origin - float(i + 1));
    };
    between({s.edgeU.y, s.edgeV.y}, s.origin.y, y, s.height);
    between({s.edgeU.x, s.edgeV.x}, s.origin.x, x, s.width);
    return piece;
}

/// The last of a range for which isBefore(i) holds, or the first one; it holds for none behind one for which it does
/// not. Without branches that nobody could foretell.
template<typename IsBefore> std::size_t lastBefore(std::size_t first, std::size_t count, const IsBefore& isBefore)
{
    while (count > 1) {
        const std::size_t half = count / 2;
        first += isBefore(first + half) ? half : 0;
        count -= half;
    }
    return first;
}

} // namespace

/// Rays that met a patch, and the luminance they brought.
struct BrightCells::Seen {
    uint32_t patch = 0;
    float rays = 0.0f;
    float light = 0.0f;
    float squares = 0.0f;

    /// Leaves one of each patch, in ascending order.
    static void join(std::vector<Seen>& all, std::size_t from = 0)
    {
        std::stable_sort(all.begin() + std::ptrdiff_t(from), all.end(),
                         [](const Seen& a, const Seen& b) { return a.patch < b.patch; });
        std::size_t end = from;
        for (std::size_t i = from; i < all.size(); ++i) {
            const Seen s = all[i];
            if (end == from || all[end - 1].patch != s.patch) {
                all[end++] = s;
                continue;
            }
            all[end - 1].rays += s.rays;
            all[end - 1].light += s.light;
            all[end - 1].squares += s.squares;
        }
        all.resize(end);
    }
    [[nodiscard]] Seen times(float weight) const { return {patch, weight * rays, weight * light, weight * squares}; }
};

/// Receivers by cubes of one width: what reaches them, and what their rays met.
struct BrightCells::Receivers {
    struct Cube {
        uint64_t key = 0;
        vec3 position{0.0f}; ///< of one of them
        int direction = 0;
        float cells = 0.0f;
        float rays = 0.0f;
        float illuminances = 0.0f; ///< their sum
        std::size_t firstSeen = 0;

        [[nodiscard]] float illuminance() const { return illuminances / std::max(cells, 1.0f); }
    };
    std::vector<Cube> cubes; ///< in ascending order of keys
    std::vector<Seen> seen;  ///< cube by cube

    [[nodiscard]] std::span<const Seen> seenFrom(std::size_t cube) const
    {
        const std::size_t end = cube + 1 < cubes.size() ? cubes[cube + 1].firstSeen : seen.size();
        return std::span(seen).subspan(cubes[cube].firstSeen, end - cubes[cube].firstSeen);
    }
    /// The same in wider cubes. Returns the one of each of the narrower.
    std::vector<uint32_t> widen(float width);
};

std::vector<uint32_t> BrightCells::Receivers::widen(float width)
{
    const Cubes wider(width);
    std::vector<uint64_t> keys;
    for (const Cube& c : cubes) keys.push_back(wider.key(c.position, c.direction));
    std::vector<uint32_t> parents;
    Receivers result;
    for (const uint64_t key : numberKeys(keys, ~uint64_t(0), parents)) result.cubes.push_back({.key = key});
    std::vector<uint32_t> order(cubes.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return parents[a] < parents[b]; });
    for (std::size_t i = 0; i < order.size();) {
        const uint32_t parent = parents[order[i]];
        Cube& to = result.cubes[parent];
        to.position = cubes[order[i]].position;
        to.direction = cubes[order[i]].direction;
        to.firstSeen = result.seen.size();
        for (; i < order.size() && parents[order[i]] == parent; ++i) {
            const Cube& from = cubes[order[i]];
            to.cells += from.cells;
            to.rays += from.rays;
            to.illuminances += from.illuminances;
            const auto own = seenFrom(order[i]);
            result.seen.insert(result.seen.end(), own.begin(), own.end());
        }
        Seen::join(result.seen, to.firstSeen);
    }
    *this = std::move(result);
    return parents;
}

/// Patches and receivers that belong together: a patch and those that have met it, whatever else these have met, and so
/// on. What is behind closed doors is apart.
class BrightCells::Company {
public:
    Company(const Receivers& receivers, std::size_t patches) : patches_(patches)
    {
        for (std::size_t cube = 0; cube < receivers.cubes.size(); ++cube) {
            const std::span<const Seen> seen = receivers.seenFrom(cube);
            for (const Seen& s : seen) patches_.join(s.patch, seen.front().patch);
            receivers_.push_back(seen.empty() ? ~0u : seen.front().patch);
        }
    }
    [[nodiscard]] uint32_t ofPatch(uint32_t patch) { return patches_.find(patch); }
    [[nodiscard]] uint32_t ofReceivers(uint32_t cube)
    {
        return receivers_[cube] != ~0u ? patches_.find(receivers_[cube]) : ~0u;
    }

private:
    DisjointSets patches_;
    std::vector<uint32_t> receivers_; ///< a patch of each, or ~0
};

BrightCells::BrightCells(const RadianceCache& cache, const RayTracer& tracer, std::span<const CellLight> cells,
                         float texelMeters, std::size_t texels, const Sightings& sightings)
{
    if (!(texelMeters > 0.0f)) return;
    members_.resize(cells.size());
    makeGuides(cells, texelMeters, sightings);
    keepPatches(cache, tracer, texels);
    findPieces(cache, tracer, cells);
}

/// Who sees what: neighbouring receivers' rays put together, of ever more around where few of them met bright cells.
/// All that a guide says follows from what those see, not from light elsewhere: what changes in one room must not
/// change another's random numbers.
void BrightCells::makeGuides(std::span<const CellLight> cells, float texelMeters, const Sightings& sightings)
{
    constexpr uint64_t kNone = ~uint64_t(0);
    float width = kGuideTexels * texelMeters;
    const Cubes guideCubes(width);
    std::vector<uint64_t> keys(cells.size(), kNone);
    for (std::size_t i = 0; i < cells.size(); ++i) {
        const CellLight& c = cells[i];
        if (c.receives && c.direction != CellLight::kNowhere) keys[i] = guideCubes.key(c.position, c.direction);
    }
    Receivers receivers;
    for (const uint64_t key : numberKeys(keys, kNone, guideOfCell_)) receivers.cubes.push_back({.key = key});
    for (std::size_t i = 0; i < cells.size(); ++i) {
        if (guideOfCell_[i] == ~0u) continue;
        Receivers::Cube& cube = receivers.cubes[guideOfCell_[i]];
        cube.position = cells[i].position;
        cube.direction = cells[i].direction;
        if (!(cells[i].rays > 0.0f)) continue;
        cube.rays += cells[i].rays;
        cube.illuminances += cells[i].illuminance;
        ++cube.cells;
    }

    struct Sighting {
        uint32_t guide;
        uint32_t cell;
    };
    std::vector<Sighting> own;
    sightings([&](uint32_t from, uint32_t cell) {
        const uint32_t guide = guideOfCell_[from];
        if (guide == ~0u || cells[cell].direction == CellLight::kNowhere) return;
        if (isBright(cells[cell].radiance, receivers.cubes[guide].illuminance())) own.push_back({guide, cell});
    });
    std::sort(own.begin(), own.end(), [](const Sighting& a, const Sighting& b) {
        return a.guide != b.guide ? a.guide < b.guide : a.cell < b.cell;
    });

    release(keys);
    std::vector<uint32_t> timesSeen(cells.size());
    for (const Sighting& s : own) ++timesSeen[s.cell];
    makePatches(cells, timesSeen, texelMeters);
    std::size_t next = 0;
    for (std::size_t g = 0; g < receivers.cubes.size(); ++g) {
        const std::size_t first = receivers.cubes[g].firstSeen = receivers.seen.size();
        for (; next < own.size() && own[next].guide == g; ++next) {
            const float radiance = cells[own[next].cell].radiance;
            receivers.seen.push_back({members_[own[next].cell].patch, 1.0f, radiance, radiance * radiance});
        }
        Seen::join(receivers.seen, first);
    }
    release(own);

    guides_.resize(receivers.cubes.size());
    std::vector<uint32_t> open(guides_.size());
    std::iota(open.begin(), open.end(), 0u);
    std::vector<uint32_t> cubeOfGuide = open;
    Company company(receivers, patches_.size());
    std::vector<float> illuminances;
    for (const Receivers::Cube& cube : receivers.cubes) illuminances.push_back(cube.illuminance());
    std::erase_if(open, [&](uint32_t g) { return addGuide(receivers, g, {}, guides_[g]) >= kEnoughSightings; });
    for (int level = 2; level <= kGuideLevels; ++level) {
        width *= kWider;
        const std::vector<uint32_t> parents = receivers.widen(width);
        for (uint32_t& cube : cubeOfGuide) cube = parents[cube];
        const Least least{level < kGuideLevels ? kEnoughSightings : 0.0f, kNoiseFromAfar};
        struct Asked {
            bool yet = false;
            float sightings = 0.0f;
            Guide guide;
        };
        std::vector<Asked> asked(receivers.cubes.size());
        std::erase_if(open, [&](uint32_t g) {
            Asked& cube = asked[cubeOfGuide[g]];
            if (!cube.yet) cube.sightings = addGuide(receivers, cubeOfGuide[g], least, cube.guide);
            cube.yet = true;
            if (cube.guide.own.count > 0) guides_[g] = cube.guide;
            return cube.sightings >= least.sightings;
        });
        if (level == kFarLevel) addFar(receivers, cubeOfGuide, illuminances, company);
    }
}

/// Patches of the cells that were seen, and of those as bright around them where many were seen only once: then there
/// are more that nobody happened to see (Good 1953, "The Population Frequencies of Species").
void BrightCells::makePatches(std::span<const CellLight> cells, std::span<const uint32_t> timesSeen, float texelMeters)
{
    constexpr uint64_t kNone = ~uint64_t(0);
    const Cubes patchCubes(kPatchTexels * texelMeters);
    std::vector<uint64_t> keys(cells.size(), kNone);
    for (std::size_t i = 0; i < cells.size(); ++i) {
        if (timesSeen[i] > 0) keys[i] = patchCubes.key(cells[i].position, cells[i].direction);
    }
    std::vector<uint32_t> patchOfSeen;
    const std::vector<uint64_t> patchKeys = numberKeys(keys, kNone, patchOfSeen);
    release(keys);
    struct Seeing {
        float cells = 0.0f;
        float once = 0.0f; ///< of these
        float times = 0.0f;
        float radiance = 0.0f; ///< sum over the cells
    };
    std::vector<Seeing> seeing(patchKeys.size());
    for (std::size_t i = 0; i < cells.size(); ++i) {
        if (timesSeen[i] == 0) continue;
        Seeing& s = seeing[patchOfSeen[i]];
        ++s.cells;
        s.once += timesSeen[i] == 1 ? 1.0f : 0.0f;
        s.times += float(timesSeen[i]);
        s.radiance += cells[i].radiance;
    }
    patches_.resize(patchKeys.size());
    for (std::size_t i = 0; i < cells.size(); ++i) {
        const CellLight& cell = cells[i];
        members_[i].patch = patchOfSeen[i];
        if (timesSeen[i] > 0 || cell.direction == CellLight::kNowhere || !(cell.radiance < kInfinity)) continue;
        const uint64_t key = patchCubes.key(cell.position, cell.direction);
        const auto found = std::lower_bound(patchKeys.begin(), patchKeys.end(), key);
        if (found == patchKeys.end() || *found != key) continue;
        const Seeing& s = seeing[std::size_t(found - patchKeys.begin())];
        if (s.once < kManyOnce * s.times || cell.radiance * s.cells < kAsBright * s.radiance) continue;
        members_[i].patch = uint32_t(found - patchKeys.begin());
    }
}

/// What the receivers in a cube and those around have met that is bright beside some light.
struct BrightCells::Sight {
    std::vector<Seen> seen; ///< in ascending order of patches
    float rays = 0.0f;
    float met = 0.0f;         ///< sightings of bright cells
    float illuminance = 0.0f; ///< of the cube's receivers; where no ray brought these anything, of those around them

    /// Of what is bright beside `light`, as isBright() has it.
    Sight(const Receivers& receivers, uint32_t cube, float light);
    /// Leaves no more than a guide may have, those of the highest rank.
    template<typename Rank> void cut(const Rank& rank)
    {
        if (seen.size() <= kMostEntries) return;
        std::stable_sort(seen.begin(), seen.end(), [&](const Seen& a, const Seen& b) { return rank(a) > rank(b); });
        seen.resize(kMostEntries);
        std::sort(seen.begin(), seen.end(), [](const Seen& a, const Seen& b) { return a.patch < b.patch; });
    }
    /// Noise that patches bring whose squares are so much, where others bring so much light.
    [[nodiscard]] float noise(double squares, float light) const
    {
        const double brought = double(kPi) / double(light);
        return float(brought * brought * squares / double(rays));
    }
};

BrightCells::Sight::Sight(const Receivers& receivers, uint32_t cube, float light)
{
    float cells = 0.0f;
    float illuminances = 0.0f;
    Cubes::around(receivers.cubes[cube].key, [&](uint64_t key) {
        const auto found = std::lower_bound(receivers.cubes.begin(), receivers.cubes.end(), key,
                                            [](const Receivers::Cube& c, uint64_t k) { return c.key < k; });
        if (found == receivers.cubes.end() || found->key != key) return;
        const auto other = std::size_t(found - receivers.cubes.begin());
        const float weight = other == cube ? 1.0f : kNeighbourWeight;
        rays += weight * found->rays;
        cells += weight * found->cells;
        illuminances += weight * found->illuminances;
        for (const Seen& s : receivers.seenFrom(other)) {
            if (!isBright(s.light / s.rays, light)) continue;
            seen.push_back(s.times(weight));
            met += s.rays;
        }
    });
    Seen::join(seen);
    illuminance = receivers.cubes[cube].illuminance();
    if (!(illuminance > 0.0f)) illuminance = illuminances / std::max(cells, 1.0f);
}

/// Patches with probabilities in proportion to their weights.
template<typename Weight> BrightCells::List BrightCells::addList(std::span<const Seen> seen, const Weight& weight)
{
    const List list{uint32_t(entries_.size()), uint32_t(seen.size())};
    double total = 0.0;
    for (const Seen& s : seen) total += double(weight(s));
    double sum = 0.0;
    for (const Seen& s : seen) {
        sum += double(weight(s));
        entries_.push_back({s.patch, float(double(weight(s)) / total)});
        entryEnds_.push_back(float(sum / total));
    }
    return list;
}

/// Makes the guide of the receivers in a cube, if they and those around have as many sightings of bright cells and as
/// much noise from them as it takes. Returns the number of sightings.
float BrightCells::addGuide(const Receivers& receivers, uint32_t cube, const Least& least, Guide& guide)
{
    Sight sight(receivers, cube, receivers.cubes[cube].illuminance());
    if (sight.met < least.sightings) return sight.met;
    const auto lightOf = [](const Seen& s) { return s.light; };
    sight.cut(lightOf);
    double light = 0.0;
    double squares = 0.0;
    for (const Seen& s : sight.seen) {
        light += double(s.light);
        squares += double(s.squares);
    }
    if (!(light > 0.0 && light < double(kInfinity) && sight.rays > 0.0f && sight.illuminance > 0.0f)) return sight.met;
    const float noise = sight.noise(squares, sight.illuminance);
    if (noise < least.noise) return sight.met;
    guide.own = addList(sight.seen, lightOf);
    guide.noise = noise;
    guide.share = float(light * light / (squares * double(sight.rays)));
    return sight.met;
}

/// Tells guides of what others farther around have met and their own receivers have not.
void BrightCells::addFar(const Receivers& receivers, std::span<const uint32_t> cubeOfGuide,
                         std::span<const float> illuminances, Company& company)
{
    struct Group {
        uint32_t cube;
        uint32_t company;
        uint32_t guide;
        [[nodiscard]] bool sameAs(const Group& g) const { return cube == g.cube && company == g.company; }
    };
    std::vector<Group> order;
    for (uint32_t g = 0; g < guides_.size(); ++g) {
        if (company.ofReceivers(g) != ~0u) order.push_back({cubeOfGuide[g], company.ofReceivers(g), g});
    }
    std::sort(order.begin(), order.end(), [](const Group& a, const Group& b) {
        return std::tie(a.cube, a.company, a.guide) < std::tie(b.cube, b.company, b.guide);
    });
    for (std::size_t i = 0; i < order.size();) {
        const Group group = order[i];
        Sight sight(receivers, group.cube, 0.0f);
        std::erase_if(sight.seen, [&](const Seen& s) { return company.ofPatch(s.patch) != group.company; });
        // By what they are to the noise: a few rays that bring much.
        const auto rank = [](const Seen& s) { return std::sqrt(s.squares); };
        sight.cut(rank);
        List list;
        for (; i < order.size() && order[i].sameAs(group); ++i) {
            Guide& guide = guides_[order[i].guide];
            double unseen = 0.0;
            for (const Seen& s : sight.seen) {
                if (probability(guide.own, s.patch) <= 0.0f) unseen += double(s.squares);
            }
            const float noise = sight.noise(unseen, illuminances[order[i].guide]);
            if (!(noise >= kNoiseUnseen && noise < kInfinity)) continue;
            if (list.count == 0) list = addList(sight.seen, rank);
            guide.far = list;
            guide.noise += noise;
        }
    }
}

/// Calls body(piece) for each triangle of what lies in the cells of patches.
template<typename Body>
void BrightCells::forPieces(const RadianceCache& cache, const RayTracer& tracer, const Body& body) const
{
    const BakeGeometry& geometry = tracer.geometry();
    for (uint32_t index = 0; index < tracer.hitTriangleCount(); ++index) {
        const uint32_t front = RadianceCache::recordOf(index, false);
        if (!cache.hasCells(front)) continue;
        const uint32_t triangle = tracer.triangleAt(index);
        // Rays do not meet what casts no shadow.
        if (!geometry.parts[geometry.partOfTriangle[triangle]].castShadows) continue;
        const uvec3 t = geometry.triangles[triangle];
        const vec3 origin = geometry.positions[t.x];
        const vec3 edge1 = geometry.positions[t.y] - origin;
        const vec3 edge2 = geometry.positions[t.z] - origin;
        const auto along = [&](vec2 b) { return b.x * edge1 + b.y * edge2; };
        Piece piece;
        forCells(cache.surface(front), [&](uint32_t cell, int x, int y) {
            for (const bool behind : {false, true}) {
                piece.cell = behind ? cache.backOf(cell) : cell;
                if (patchOf(piece.cell) == ~0u) continue;
                piece.record = RadianceCache::recordOf(index, behind);
                piece.normal = geometry.geometricNormal(triangle) * (behind ? -1.0f : 1.0f);
                const Polygon polygon = pieceIn(cache.surface(front), x, y);
                for (std::size_t i = 1; i + 1 < std::size_t(polygon.count); ++i) {
                    piece.corners = {polygon.points[0], polygon.points[i], polygon.points[i + 1]};
                    piece.origin = origin + along(piece.corners[0]);
                    piece.edge1 = along(piece.corners[1] - piece.corners[0]);
                    piece.edge2 = along(piece.corners[2] - piece.corners[0]);
                    if (piece.area() > 0.0f) body(piece);
                }
            }
        });
    }
}

/// Leaves out the patches that no guide names, and if pieces would be too many, those that bring least light for each;
/// the others get room for their pieces.
void BrightCells::keepPatches(const RadianceCache& cache, const RayTracer& tracer, std::size_t texels)
{
    std::vector<float> use(patches_.size());
    for (const Entry& e : entries_) use[e.patch] += e.probability;
    for (Member& m : members_) {
        if (m.patch != ~0u && use[m.patch] <= 0.0f) m.patch = ~0u;
    }
    std::vector<uint32_t> pieces(patches_.size());
    forPieces(cache, tracer, [&](const Piece& piece) { ++pieces[patchOf(piece.cell)]; });
    std::vector<uint32_t> order;
    for (uint32_t p = 0; p < patches_.size(); ++p) {
        if (pieces[p] > 0) order.push_back(p);
    }
    std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
        const float left = use[a] * float(pieces[b]);
        const float right = use[b] * float(pieces[a]);
        return left != right ? left > right : a < b;
    });
    const std::size_t most = std::max(kFewPieces, texels / kTexelsForPiece);
    std::size_t count = 0;
    for (const uint32_t p : order) {
        if (count + pieces[p] > most) break;
        patches_[p] = {uint32_t(count), pieces[p]};
        count += pieces[p];
    }
    for (Member& m : members_) {
        if (m.patch != ~0u && patches_[m.patch].pieceCount == 0) m.patch = ~0u;
    }
    pieces_.resize(count);
}

void BrightCells::findPieces(const RadianceCache& cache, const RayTracer& tracer, std::span<const CellLight> cells)
{
    std::vector<uint32_t> found(patches_.size());
    forPieces(cache, tracer, [&](const Piece& piece) {
        const uint32_t patch = patchOf(piece.cell);
        pieces_[patches_[patch].firstPiece + found[patch]++] = piece;
    });
    columns_.resize(pieces_.size());
    for (const Patch& patch : patches_) {
        const std::span<Piece> pieces = std::span(pieces_).subspan(patch.firstPiece, patch.pieceCount);
        std::vector<double> shares(pieces.size());
        double power = 0.0;
        for (std::size_t i = 0; i < pieces.size(); ++i) {
            shares[i] = double(pieces[i].area()) * double(cells[pieces[i].cell].radiance);
            power += shares[i];
        }
        for (std::size_t i = 0; i < pieces.size(); ++i) {
            shares[i] /= power;
            const float radiance = cells[pieces[i].cell].radiance;
            pieces[i].pdfArea = members_[pieces[i].cell].pdfArea = float(double(radiance) / power);
        }
        fillColumns(shares, std::span(columns_).subspan(patch.firstPiece, patch.pieceCount));
    }
}

// What is short of a column is filled from what another has too much.
void BrightCells::fillColumns(std::span<double> shares, std::span<Column> columns)
{
    const auto count = double(columns.size());
    std::vector<uint32_t> low;
    std::vector<uint32_t> high;
    for (uint32_t i = 0; i < columns.size(); ++i) {
        columns[i] = {1.0f, 0};
        shares[i] *= count;
        (shares[i] < 1.0 ? low : high).push_back(i);
    }
    while (!low.empty() && !high.empty()) {
        const uint32_t filled = low.back();
        const uint32_t from = high.back();
        low.pop_back();
        columns[filled] = {float(shares[filled]), from - filled};
        shares[from] -= 1.0 - shares[filled];
        if (shares[from] >= 1.0) continue;
        high.pop_back();
        low.push_back(from);
    }
}

float BrightCells::probability(const List& list, uint32_t patch) const
{
    if (list.count == 0) return 0.0f;
    const Entry& entry =
        entries_[lastBefore(list.first, list.count, [&](std::size_t i) { return entries_[i].patch <= patch; })];
    return entry.patch == patch ? entry.probability : 0.0f;
}

float BrightCells::probability(const Guide& guide, uint32_t patch) const
{
    const float own = probability(guide.own, patch);
    if (guide.far.count == 0) return own;
    return (1.0f - guide.farShare()) * own + guide.farShare() * probability(guide.far, patch);
}

float BrightCells::pdfArea(const Guide& guide, uint32_t cell) const
{
    const Member& m = members_[cell];
    return probability(guide, m.patch) * m.pdfArea;
}

BrightCells::Choice BrightCells::choosePatch(const Guide& guide, vec2 u) const
{
    const List* list = &guide.own;
    if (guide.far.count > 0) {
        // One of the two lists; the random number is stretched again over its share.
        const float farShare = guide.farShare();
        const bool far = u.x < farShare;
        if (far) list = &guide.far;
        u.x = std::min(far ? u.x / farShare : (u.x - farShare) / (1.0f - farShare), 0x1.fffffep-1f);
    }
    if (list->count == 0) return {};
    const std::size_t number =
        lastBefore(list->first, list->count, [&](std::size_t i) { return entryEnds_[i - 1] <= u.x; });
    const float begin = number == list->first ? 0.0f : entryEnds_[number - 1];
    u.x = std::clamp((u.x - begin) / std::max(entryEnds_[number] - begin, 1.0e-12f), 0.0f, 0x1.fffffep-1f);
    const Entry& entry = entries_[number];
    __builtin_prefetch(&patches_[entry.patch]);
    const float probability = guide.far.count > 0 ? this->probability(guide, entry.patch) : entry.probability;
    return {entry.patch, probability, u};
}

} // namespace halflight
