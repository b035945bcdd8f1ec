#include "unwrap/cuts/crossings.h"

#include "halflight/base/parallel.h"
#include "unwrap/surface/triangle_tree.h"

#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <map>
#include <optional>

namespace halflight::charts {
namespace {

constexpr double kLeastSine = 0.34;      ///< of the angle between both surfaces: 20 degrees
constexpr double kGapTexels = 0.25;      ///< a surface that ends so near to another one counts as touching it
constexpr double kOnPlaneTexels = 0.02;  ///< an edge so near to a plane lies on it
constexpr double kSamplesPerTexel = 0.5; ///< of a crossing
constexpr double kFewestTexels = 4.0;    ///< of a crossing, and of what lies beyond it along the surface: half of that
/// Crossings nearer to one another than this, of nearly parallel planes, are one: the two sides of a board.
constexpr double kTogetherTexels = 1.25;
constexpr double kParallelCosine = 0.9976; ///< 4 degrees
/// Crossings of one piece that are told apart, those with the longest stretches first: bounds the search where grass
/// stands on a ground.
constexpr std::size_t kMostOfPiece = 256;
/// Padding and rounding: texels that a cut adds per texel of its length.
constexpr double kTexelsPerTexelOfCut = 3.0;
constexpr double kMostAdded = 0.04;            ///< of all texels
constexpr double kAlwaysAdded = 128.0 * 128.0; ///< texels

struct Triangle {
    Corners corners;
    dvec3 normal{0.0};

    explicit Triangle(const Corners& c) : corners(c)
    {
        const dvec3 cross = glm::cross(c[1] - c[0], c[2] - c[0]);
        const double length = glm::length(cross);
        if (length > 0.0) normal = cross / length;
    }
    [[nodiscard]] double offset() const { return glm::dot(normal, corners[0]); }
};

struct Interval {
    double from = 1e300, to = -1e300;
    void extend(double s)
    {
        from = std::min(from, s);
        to = std::max(to, s);
    }
};

/// Extent along `direction` of the part of a triangle whose distance to a plane is at most `width`.
Interval extentNear(const Triangle& triangle, dvec3 normal, double offset, double width, dvec3 direction)
{
    Interval interval;
    for (std::size_t k = 0; k < 3; ++k) {
        const dvec3 a = triangle.corners[k], b = triangle.corners[(k + 1) % 3];
        const double da = glm::dot(normal, a) - offset, db = glm::dot(normal, b) - offset;
        if (std::abs(da) <= width) interval.extend(glm::dot(direction, a));
        for (const double bound : {-width, width}) {
            if ((da - bound) * (db - bound) < 0.0)
                interval.extend(glm::dot(direction, a + (bound - da) / (db - da) * (b - a)));
        }
    }
    return interval;
}

/// A stretch of a triangle along which another one stands on it.
struct Stretch {
    uint32_t candidate = 0;
    uint32_t triangle = 0;
    uint32_t piece = 0;
    dvec3 normal{0.0};   ///< of the triangle
    dvec3 crossing{0.0}; ///< normal of the other one
    double offset = 0.0; ///< of the other one's plane
    dvec3 from{0.0}, to{0.0};

    [[nodiscard]] double length() const { return glm::distance(from, to); }
    [[nodiscard]] dvec3 middle() const { return 0.5 * (from + to); }
};

std::optional<Stretch> crossingOf(const Triangle& on, const Triangle& other, double texel)
{
    const dvec3 line = glm::cross(on.normal, other.normal);
    const double sine = glm::length(line);
    if (sine < kLeastSine) return std::nullopt;
    double least = 1e300, most = -1e300;
    for (const dvec3& corner : other.corners) {
        const double height = glm::dot(on.normal, corner) - on.offset();
        least = std::min(least, height);
        most = std::max(most, height);
    }
    const double gap = kGapTexels * texel;
    if (most < gap || least > gap) return std::nullopt;
    const dvec3 direction = line / sine;
    const Interval a = extentNear(on, other.normal, other.offset(), kOnPlaneTexels * texel, direction);
    const Interval b = extentNear(other, on.normal, on.offset(), gap, direction);
    const double from = std::max(a.from, b.from), to = std::min(a.to, b.to);
    if (!(to - from > 0.05 * texel)) return std::nullopt;
    const dvec3 base =
        (on.offset() * glm::cross(other.normal, line) + other.offset() * glm::cross(line, on.normal)) / (sine * sine);
    Stretch stretch;
    stretch.normal = on.normal;
    stretch.crossing = other.normal;
    stretch.offset = other.offset();
    stretch.from = base + from * direction;
    stretch.to = base + to * direction;
    return stretch;
}

/// Triangles of an object in the world, seen from their front.
void addTriangles(const Scene& scene, const Object& object, bool castersOnly, std::vector<Corners>& triangles)
{
    const glm::dmat4 map(object.worldFromObject);
    const bool mirrored = glm::determinant(dmat3(map)) < 0.0;
    for (const MeshPart& part : scene.meshes[std::size_t(object.mesh)].parts) {
        const Material& material = materialOf(scene, part);
        if (castersOnly && (!material.castShadows || !material.isOpaque())) continue;
        for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
            Corners& corners = triangles.emplace_back();
            for (std::size_t k = 0; k < 3; ++k)
                corners[k] = dvec3(map * glm::dvec4(dvec3(part.positions[part.indices[i + k]]), 1.0));
            if (mirrored) std::swap(corners[1], corners[2]);
        }
    }
}

/// Stretches of one plane on one piece.
struct Crossing {
    std::vector<Stretch> stretches; ///< the longest first
    double hidden = 0.0;            ///< length along which the two sides have light of their own
    double cutLength = 0.0;         ///< of the whole piece along the plane
    PlaneCut cut;
};

class CutFinder {
public:
    CutFinder(const Scene& scene, std::vector<CutCandidate>& candidates) : scene_(scene), candidates_(candidates) {}

    void find(const CrossingTest& test, double totalTexels, std::vector<std::string>& warnings)
    {
        findStretches();
        joinStretches();
        measurePieces();
        if (crossings_.empty()) return;
        testCrossings(test);
        choose(totalTexels, warnings);
    }

private:
    void findStretches()
    {
        std::vector<Corners> casters;
        const std::vector<uint8_t> copyable = copyableMeshes(scene_);
        for (const Object& object : scene_.objects) {
            if (object.isStatic && object.castShadows && object.mesh >= 0 && copyable[std::size_t(object.mesh)] != 0)
                addTriangles(scene_, object, true, casters);
        }
        const TriangleTree tree(casters);
        triangles_.resize(candidates_.size());
        std::vector<std::vector<std::vector<Stretch>>> found(candidates_.size()); // by triangle of a candidate
        parallelFor(candidates_.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t c = begin; c < end; ++c) found[c] = stretchesOf(uint32_t(c), tree, casters);
        });
        std::size_t count = 0;
        for (const auto& ofCandidate : found)
            for (const std::vector<Stretch>& some : ofCandidate) count += some.size();
        stretches_.reserve(count);
        for (const auto& ofCandidate : found)
            for (const std::vector<Stretch>& some : ofCandidate)
                stretches_.insert(stretches_.end(), some.begin(), some.end());
    }

    /// By triangle of a candidate.
    std::vector<std::vector<Stretch>> stretchesOf(uint32_t c, const TriangleTree& tree,
                                                  const std::vector<Corners>& casters)
    {
        const CutCandidate& candidate = candidates_[c];
        std::vector<Corners>& own = triangles_[c];
        addTriangles(scene_, scene_.objects[std::size_t(candidate.object)], false, own);
        const std::vector<uint8_t> wide = widePieces(candidate, own);
        std::vector<std::vector<Stretch>> found(own.size());
        parallelFor(own.size(), 256, [&](std::size_t begin, std::size_t end) {
            for (std::size_t t = begin; t < end; ++t) {
                if (candidate.pieces[t] == kNone || wide[candidate.pieces[t]] == 0) continue;
                const Triangle on(own[t]);
                Box box = boundsOf(own[t]);
                box.low -= kGapTexels * candidate.texelMeters;
                box.high += kGapTexels * candidate.texelMeters;
                tree.forOverlapping(box, [&](uint32_t other) {
                    std::optional<Stretch> stretch = crossingOf(on, Triangle(casters[other]), candidate.texelMeters);
                    if (!stretch) return;
                    stretch->candidate = c;
                    stretch->triangle = uint32_t(t);
                    stretch->piece = candidate.pieces[t];
                    found[t].push_back(*stretch);
                });
            }
        });
        return found;
    }

    /// By piece: whether a crossing that is long enough fits it.
    static std::vector<uint8_t> widePieces(const CutCandidate& candidate, const std::vector<Corners>& triangles)
    {
        std::vector<Box> boxes;
        for (std::size_t t = 0; t < triangles.size(); ++t) {
            const uint32_t piece = candidate.pieces[t];
            if (piece == kNone) continue;
            if (piece >= boxes.size()) boxes.resize(piece + 1);
            for (const dvec3& corner : triangles[t]) boxes[piece].extend(corner);
        }
        std::vector<uint8_t> wide;
        for (const Box& box : boxes)
            wide.push_back(glm::length(box.high - box.low) >= kFewestTexels * candidate.texelMeters ? 1 : 0);
        return wide;
    }

    void joinStretches()
    {
        std::vector<std::pair<double, std::size_t>> order; // less the length: the longest come first
        for (const Stretch& stretch : stretches_) order.emplace_back(-stretch.length(), order.size());
        parallelSort(order, std::less<>());
        std::map<std::pair<uint32_t, uint32_t>, std::vector<std::size_t>> ofPiece;
        for (const auto& [less, number] : order) {
            const Stretch& stretch = stretches_[number];
            const double near = kTogetherTexels * candidates_[stretch.candidate].texelMeters;
            std::vector<std::size_t>& own = ofPiece[{stretch.candidate, stretch.piece}];
            const auto joins = [&](std::size_t crossing) {
                const Stretch& first = crossings_[crossing].stretches.front();
                return std::abs(glm::dot(first.crossing, stretch.crossing)) > kParallelCosine &&
                       std::abs(glm::dot(first.crossing, stretch.middle()) - first.offset) < near;
            };
            auto found = std::find_if(own.begin(), own.end(), joins);
            if (found == own.end()) {
                const bool isLong = stretch.length() >= kFewestTexels * candidates_[stretch.candidate].texelMeters;
                if (own.size() >= kMostOfPiece) {
                    uncut_ += isLong ? 1 : 0;
                    continue;
                }
                found = own.insert(found, crossings_.size());
                crossings_.emplace_back();
            }
            crossings_[*found].stretches.push_back(stretch);
        }
    }

    /// Leaves out crossings that are short, or at the rim of their piece.
    void measurePieces()
    {
        std::map<std::pair<uint32_t, uint32_t>, std::vector<uint32_t>> trianglesOf;
        for (const Crossing& crossing : crossings_)
            trianglesOf[{crossing.stretches[0].candidate, crossing.stretches[0].piece}];
        for (uint32_t c = 0; c < candidates_.size(); ++c) {
            for (uint32_t t = 0; t < candidates_[c].pieces.size(); ++t) {
                const auto found = trianglesOf.find({c, candidates_[c].pieces[t]});
                if (found != trianglesOf.end()) found->second.push_back(t);
            }
        }
        parallelFor(crossings_.size(), 4, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const Stretch& first = crossings_[i].stretches[0];
                measure(crossings_[i], trianglesOf.at({first.candidate, first.piece}));
            }
        });
        std::erase_if(crossings_, [](const Crossing& crossing) { return !(crossing.cutLength > 0.0); });
    }

    void measure(Crossing& crossing, const std::vector<uint32_t>& piece) const
    {
        const Stretch& first = crossing.stretches[0];
        const double texel = candidates_[first.candidate].texelMeters;
        double length = 0.0;
        for (const Stretch& stretch : crossing.stretches) length += stretch.length();
        if (length < kFewestTexels * texel) return;
        double least = 0.0, most = 0.0, cut = 0.0;
        for (const uint32_t t : piece) {
            const Triangle triangle(triangles_[first.candidate][t]);
            const dvec3 line = glm::cross(triangle.normal, first.crossing);
            const double sine = glm::length(line);
            for (const dvec3& corner : triangle.corners) {
                const double distance = glm::dot(first.crossing, corner) - first.offset;
                least = std::min(least, distance);
                most = std::max(most, distance);
            }
            if (sine < 1e-6) continue;
            const Interval extent = extentNear(triangle, first.crossing, first.offset, 0.0, line / sine);
            if (extent.to > extent.from) cut += extent.to - extent.from;
        }
        const double beyond = 0.5 * texel; // less is no more than a rim of texels of the other side
        if (std::min(-least, most) < beyond) return;
        crossing.cutLength = std::max(cut, texel);
    }

    void testCrossings(const CrossingTest& test)
    {
        std::vector<CrossingPoint> points;
        std::vector<std::pair<std::size_t, double>> ofPoint; // crossing and length
        for (std::size_t i = 0; i < crossings_.size(); ++i) {
            for (const Stretch& stretch : crossings_[i].stretches) {
                const CutCandidate& candidate = candidates_[stretch.candidate];
                const int count =
                    std::max(1, int(std::lround(kSamplesPerTexel * stretch.length() / candidate.texelMeters)));
                const dvec3 across =
                    glm::normalize(stretch.crossing - glm::dot(stretch.crossing, stretch.normal) * stretch.normal);
                const dvec3 rise =
                    glm::normalize(stretch.normal - glm::dot(stretch.normal, stretch.crossing) * stretch.crossing);
                for (int s = 0; s < count; ++s) {
                    const dvec3 at = glm::mix(stretch.from, stretch.to, (double(s) + 0.5) / double(count));
                    points.push_back({candidate.object, stretch.triangle, vec3(at), vec3(stretch.normal), vec3(across),
                                      vec3(rise), float(candidate.texelMeters)});
                    ofPoint.emplace_back(i, stretch.length() / double(count));
                }
            }
        }
        const std::vector<uint8_t> hidden = test(scene_, points);
        for (std::size_t i = 0; i < points.size() && i < hidden.size(); ++i) {
            if (hidden[i] == 0) continue;
            Crossing& crossing = crossings_[ofPoint[i].first];
            crossing.hidden += ofPoint[i].second;
            crossing.cut.points.emplace_back(points[i].position);
        }
        std::erase_if(crossings_, [&](const Crossing& crossing) {
            return crossing.hidden < kFewestTexels * candidates_[crossing.stretches[0].candidate].texelMeters;
        });
    }

    void choose(double totalTexels, std::vector<std::string>& warnings)
    {
        std::stable_sort(crossings_.begin(), crossings_.end(), [](const Crossing& a, const Crossing& b) {
            return a.hidden / a.cutLength > b.hidden / b.cutLength;
        });
        double left = std::max(kMostAdded * totalTexels, kAlwaysAdded);
        for (Crossing& crossing : crossings_) {
            const Stretch& first = crossing.stretches[0];
            const double added = kTexelsPerTexelOfCut * crossing.cutLength / candidates_[first.candidate].texelMeters;
            left -= added;
            if (left < 0.0) {
                ++uncut_;
                continue;
            }
            crossing.cut.piece = first.piece;
            crossing.cut.normal = first.crossing;
            crossing.cut.offset = first.offset;
            candidates_[first.candidate].cuts.push_back(std::move(crossing.cut));
        }
        if (uncut_ == 0) return;
        warnings.push_back(fmt::format("{} crossings of surfaces stay uncut, because cuts would add more than {:.0f} % "
                                       "of texels: light may leak from one side of them to the other",
                                       uncut_, 100.0 * kMostAdded));
    }

    const Scene& scene_;
    std::vector<CutCandidate>& candidates_;
    std::vector<std::vector<Corners>> triangles_; ///< by candidate
    std::vector<Stretch> stretches_;
    std::vector<Crossing> crossings_;
    int uncut_ = 0; ///< crossings that are too many
};

} // namespace

std::vector<uint8_t> copyableMeshes(const Scene& scene)
{
    constexpr std::size_t kMostCopied = 32768; // triangles
    std::vector<std::size_t> users(scene.meshes.size(), 0);
    for (const Object& object : scene.objects) {
        if (object.mesh >= 0) users[std::size_t(object.mesh)] += 1;
    }
    std::vector<uint8_t> copyable;
    for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
        const std::size_t copied = users[m] < 2 ? 0 : (users[m] - 1) * scene.meshes[m].triangleCount();
        copyable.push_back(copied < kMostCopied ? 1 : 0);
    }
    return copyable;
}

void findCuts(const Scene& scene, std::vector<CutCandidate>& candidates, double totalTexels, const CrossingTest& test,
              std::vector<std::string>& warnings)
{
    CutFinder(scene, candidates).find(test, totalTexels, warnings);
}

} // namespace halflight::charts
