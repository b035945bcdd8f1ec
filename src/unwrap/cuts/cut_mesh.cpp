#include "unwrap/cuts/cut_mesh.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>

namespace halflight::charts {
namespace {

constexpr double kSmoothCosine = 0.866; // 30 degrees

/// One side of a plane.
struct Half {
    dvec3 normal{0.0};
    double offset = 0.0;
    [[nodiscard]] bool holds(dvec3 p) const { return glm::dot(normal, p) >= offset; }
};

/// What is left of a smooth piece after some cuts.
struct Portion {
    uint32_t piece = 0;
    std::vector<Half> halves;
    std::vector<uint32_t> triangles;
};

struct Cut {
    uint32_t from = 0, to = 0; ///< welded vertices
    float share = 0.0f;
    uint32_t vertex = 0; ///< welded
};

class Cutting {
public:
    Cutting(Mesh& mesh, const Surface& surface, std::span<const uint32_t> pieces, const glm::dmat4& worldFromObject)
        : mesh_(mesh), worldFromObject_(worldFromObject)
    {
        uint32_t t = 0;
        for (uint32_t p = 0; p < mesh.parts.size(); ++p) {
            const MeshPart& part = mesh.parts[p];
            for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3, ++t) {
                const uvec3 corners(part.indices[i], part.indices[i + 1], part.indices[i + 2]);
                triangles_.push_back({p, kNone, corners, surface.triangles[t]});
                for (int k = 0; k < 3; ++k) {
                    const uint32_t welded = surface.triangles[t][k];
                    if (welded >= local_.size()) local_.resize(welded + 1);
                    local_[welded] = part.positions[corners[k]] + vec3(0.0f);
                }
                if (pieces[t] == kNone) continue;
                if (pieces[t] >= portions_.size()) portions_.resize(pieces[t] + 1);
                portions_[pieces[t]].piece = pieces[t];
                portions_[pieces[t]].triangles.push_back(t);
                triangles_.back().portion = pieces[t];
            }
        }
        for (const vec3& p : local_) world_.push_back(toWorld(p));
    }

    /// Whether the plane cut anything.
    bool cut(const PlaneCut& plane, double tolerance)
    {
        bool any = false;
        const std::size_t count = portions_.size();
        for (uint32_t p = 0; p < count; ++p) {
            if (portions_[p].piece != plane.piece) continue;
            const auto inPortion = [&](dvec3 point) {
                return std::all_of(portions_[p].halves.begin(), portions_[p].halves.end(),
                                   [&](const Half& half) { return half.holds(point); });
            };
            if (std::any_of(plane.points.begin(), plane.points.end(), inPortion))
                any = cutPortion(p, plane, tolerance) || any;
        }
        return any;
    }

    /// Writes the triangles into the mesh's parts. Returns the number of each one's portion.
    std::vector<uint32_t> write()
    {
        std::vector<uint32_t> numbers;
        for (MeshPart& part : mesh_.parts) part.indices.clear();
        std::vector<std::vector<uint32_t>> ofPart(mesh_.parts.size());
        for (const Triangle& t : triangles_) {
            for (int k = 0; k < 3; ++k) mesh_.parts[t.part].indices.push_back(t.corners[k]);
            const bool wasCut = t.portion != kNone && !portions_[t.portion].halves.empty();
            ofPart[t.part].push_back(wasCut ? t.portion + 1 : 0);
        }
        for (const std::vector<uint32_t>& some : ofPart) numbers.insert(numbers.end(), some.begin(), some.end());
        return numbers;
    }

private:
    struct Triangle {
        uint32_t part = 0;
        uint32_t portion = kNone;
        uvec3 corners{0}; ///< vertices of the part
        uvec3 welded{0};
    };

    [[nodiscard]] dvec3 toWorld(vec3 local) const { return dvec3(worldFromObject_ * glm::dvec4(dvec3(local), 1.0)); }

    bool cutPortion(uint32_t p, const PlaneCut& plane, double tolerance)
    {
        distance_.resize(world_.size());
        bool above = false, below = false;
        for (const uint32_t t : portions_[p].triangles) {
            for (int k = 0; k < 3; ++k) {
                const uint32_t v = triangles_[t].welded[k];
                const double d = glm::dot(plane.normal, world_[v]) - plane.offset;
                distance_[v] = std::abs(d) < tolerance ? 0.0 : d;
                above = above || distance_[v] > 0.0;
                below = below || distance_[v] < 0.0;
            }
        }
        if (!above || !below) return false;
        findDividedEdges(p);
        divideTriangles();
        // Two portions instead of one.
        Portion upper = portions_[p];
        upper.triangles.clear();
        Portion lower = upper;
        upper.halves.push_back({plane.normal, plane.offset});
        lower.halves.push_back({-plane.normal, -plane.offset});
        const auto upperNumber = uint32_t(portions_.size());
        for (const uint32_t t : portions_[p].triangles) {
            const uvec3 v = triangles_[t].welded;
            const bool isLower = std::min({distance_[v.x], distance_[v.y], distance_[v.z]}) < 0.0;
            (isLower ? lower : upper).triangles.push_back(t);
            triangles_[t].portion = isLower ? p : upperNumber;
        }
        portions_[p] = std::move(lower);
        portions_.push_back(std::move(upper));
        return true;
    }

    void findDividedEdges(uint32_t portion)
    {
        divided_.clear();
        isEnd_.assign(world_.size(), 0);
        for (const uint32_t t : portions_[portion].triangles) {
            for (int k = 0; k < 3; ++k) {
                uint32_t from = triangles_[t].welded[k], to = triangles_[t].welded[(k + 1) % 3];
                if (!(distance_[from] * distance_[to] < 0.0)) continue;
                const std::pair<uint32_t, uint32_t> key = std::minmax(from, to); // a copy: the ends may swap
                if (divided_.contains(key)) continue;
                // The same order of the ends in every part, so that all parts round alike.
                const vec3 a = local_[from], b = local_[to];
                if (std::tie(b.x, b.y, b.z) < std::tie(a.x, a.y, a.z)) std::swap(from, to);
                const Cut cut{from, to, float(distance_[from] / (distance_[from] - distance_[to])),
                              uint32_t(world_.size())};
                const CutVertex between{0, 0, cut.share};
                vec3 place(0.0f);
                for (int c = 0; c < 3; ++c) place[c] = between.between(local_[from][c], local_[to][c]);
                local_.push_back(place);
                world_.push_back(toWorld(place));
                distance_.push_back(0.0);
                isEnd_[from] = isEnd_[to] = 1;
                divided_[key] = cut;
            }
        }
    }

    /// Divides all triangles with a divided edge, of any portion.
    void divideTriangles()
    {
        isEnd_.resize(world_.size(), 0);
        const std::size_t count = divided_.empty() ? 0 : triangles_.size();
        for (uint32_t t = 0; t < count; ++t) {
            const uvec3 v = triangles_[t].welded;
            if (isEnd_[v.x] + isEnd_[v.y] + isEnd_[v.z] < 2) continue;
            std::array<const Cut*, 3> cuts{};
            int number = 0;
            for (int k = 0; k < 3; ++k) {
                const auto found = divided_.find(std::minmax(v[k], v[(k + 1) % 3]));
                if (found == divided_.end()) continue;
                cuts[std::size_t(k)] = &found->second;
                ++number;
            }
            if (number == 0) continue;
            // Edge 0 is divided, and edge 1 where two are.
            int first = 0;
            while (cuts[std::size_t(first)] == nullptr ||
                   (number == 2 && cuts[std::size_t((first + 1) % 3)] == nullptr))
                ++first;
            divide(t, first, *cuts[std::size_t(first)], number == 2 ? cuts[std::size_t((first + 1) % 3)] : nullptr);
        }
    }

    void divide(uint32_t t, int first, const Cut& cut, const Cut* next)
    {
        const Triangle old = triangles_[t];
        const auto corner = [&](int k) {
            const int i = (first + k) % 3;
            return std::pair(old.corners[i], old.welded[i]);
        };
        const auto a = corner(0), b = corner(1), c = corner(2);
        const auto onEdge = [&](const Cut& on, std::pair<uint32_t, uint32_t> p, std::pair<uint32_t, uint32_t> q) {
            if (p.second != on.from) std::swap(p, q);
            return std::pair(vertexBetween(old.part, p.first, q.first, on.share), on.vertex);
        };
        const auto add = [&](bool replaces, auto x, auto y, auto z) {
            const Triangle made{old.part, old.portion, uvec3(x.first, y.first, z.first),
                                uvec3(x.second, y.second, z.second)};
            if (replaces) {
                triangles_[t] = made;
                return;
            }
            if (old.portion != kNone) portions_[old.portion].triangles.push_back(uint32_t(triangles_.size()));
            triangles_.push_back(made);
        };
        const auto ab = onEdge(cut, a, b);
        if (next == nullptr) {
            add(true, a, ab, c);
            add(false, ab, b, c);
            return;
        }
        const auto bc = onEdge(*next, b, c);
        add(true, ab, b, bc);
        if (glm::distance(world_[a.second], world_[bc.second]) < glm::distance(world_[ab.second], world_[c.second])) {
            add(false, a, ab, bc);
            add(false, a, bc, c);
        } else {
            add(false, a, ab, c);
            add(false, ab, bc, c);
        }
    }

    /// The vertex of a part between two others, made if there is none.
    uint32_t vertexBetween(uint32_t partNumber, uint32_t from, uint32_t to, float share)
    {
        MeshPart& part = mesh_.parts[partNumber];
        const auto number = uint32_t(part.positions.size());
        const auto [entry, isNew] = vertices_.try_emplace({partNumber, from, to, share}, number);
        if (!isNew) return entry->second;
        if (part.sourceVertex.empty()) {
            part.sourceVertex.resize(number);
            std::iota(part.sourceVertex.begin(), part.sourceVertex.end(), 0u);
        }
        const CutVertex cut{part.sourceVertex[from], part.sourceVertex[to], share};
        const auto mixed = [&](const auto& values) {
            auto value = values[from];
            for (int c = 0; c < value.length(); ++c) value[c] = cut.between(values[from][c], values[to][c]);
            return value;
        };
        const auto unit = [](vec3 v, vec3 fallback) {
            const float length = glm::length(v);
            return length > 0.0f ? v / length : fallback;
        };
        part.positions.push_back(mixed(part.positions));
        if (!part.normals.empty()) part.normals.push_back(unit(mixed(part.normals), part.normals[from]));
        if (!part.tangents.empty()) {
            const vec4 nearer = part.tangents[share < 0.5f ? from : to];
            part.tangents.push_back(vec4(unit(vec3(mixed(part.tangents)), vec3(nearer)), nearer.w));
        }
        for (auto& uv : part.uv) {
            if (!uv.empty()) uv.push_back(mixed(uv));
        }
        if (!part.colors.empty()) part.colors.push_back(mixed(part.colors));
        part.sourceVertex.push_back(kCutVertex | uint32_t(part.cutVertices.size()));
        part.cutVertices.push_back(cut);
        return number;
    }

    Mesh& mesh_;
    glm::dmat4 worldFromObject_;
    std::vector<Triangle> triangles_;
    std::vector<vec3> local_; ///< by welded vertex
    std::vector<dvec3> world_;
    std::vector<Portion> portions_;
    std::vector<double> distance_; ///< from the plane at hand, by welded vertex of the portion at hand
    std::vector<uint8_t> isEnd_;   ///< of a divided edge, by welded vertex
    std::map<std::pair<uint32_t, uint32_t>, Cut> divided_;
    std::map<std::tuple<uint32_t, uint32_t, uint32_t, float>, uint32_t> vertices_; ///< by part, ends and share
};

} // namespace

std::vector<uint32_t> smoothPieces(const Surface& surface)
{
    std::vector<uint32_t> pieces(surface.triangleCount(), kNone);
    std::vector<uint32_t> waiting;
    uint32_t count = 0;
    for (uint32_t start = 0; start < surface.triangleCount(); ++start) {
        if (surface.degenerate(start) || pieces[start] != kNone) continue;
        pieces[start] = count;
        waiting.push_back(start);
        while (!waiting.empty()) {
            const uint32_t t = waiting.back();
            waiting.pop_back();
            for (uint32_t k = 0; k < 3; ++k) {
                const uint32_t half = surface.neighbors[3 * t + k];
                if (half == kNone || pieces[half / 3] != kNone) continue;
                if (glm::dot(surface.normals[t], surface.normals[half / 3]) < kSmoothCosine) continue;
                pieces[half / 3] = count;
                waiting.push_back(half / 3);
            }
        }
        ++count;
    }
    return pieces;
}

std::vector<uint32_t> cutMesh(Mesh& mesh, const Surface& surface, std::span<const uint32_t> pieces,
                              const glm::dmat4& worldFromObject, const std::vector<PlaneCut>& planes, double tolerance,
                              int& cuts)
{
    Cutting cutting(mesh, surface, pieces, worldFromObject);
    int made = 0;
    for (const PlaneCut& plane : planes) made += cutting.cut(plane, tolerance) ? 1 : 0;
    cuts += made;
    return made > 0 ? cutting.write() : std::vector<uint32_t>();
}

} // namespace halflight::charts
