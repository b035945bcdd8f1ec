#include "bake/stages.h"

#include "halflight/base/parallel.h"

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <unordered_map>

namespace halflight {
namespace {

constexpr uint32_t kNoUnknown = ~0u;
constexpr float kSmoothCosine = 0.95f; ///< edges whose normals differ more are corners: light may differ there
constexpr double kKeepWeight = 0.001;  ///< pull of a texel towards its own value, against 1 for each seam sample

/// One side of a seam: where an edge of a triangle lies in the lightmap.
struct EdgeSide {
    int object = 0;
    int page = 0;
    vec2 from{0.0f}; ///< texels, at the edge's lower end (by key)
    vec2 to{0.0f};
    vec3 normalFrom{0.0f};
    vec3 normalTo{0.0f};
};

struct EdgeKey {
    std::array<uint32_t, 6> bits{}; ///< of both end positions, lower one first

    bool operator==(const EdgeKey& other) const { return bits == other.bits; }
};

struct EdgeKeyHash {
    std::size_t operator()(const EdgeKey& key) const
    {
        std::size_t h = 0xcbf29ce484222325u;
        for (const uint32_t b : key.bits) h = (h ^ b) * 0x100000001b3u;
        return h ^ (h >> 29);
    }
};

std::array<uint32_t, 3> positionBits(vec3 p)
{
    p += vec3(0.0f); // -0 becomes +0
    std::array<uint32_t, 3> bits{};
    std::memcpy(bits.data(), &p, sizeof(p));
    return bits;
}

/// The four texels that bilinear filtering at `place` reads, with weights; texels outside the page are clamped into it.
struct Footprint {
    std::array<uint64_t, 4> texel{}; ///< (page * size + y) * size + x
    std::array<float, 4> weight{};
};

Footprint footprintAt(int page, vec2 place, int size)
{
    const vec2 p = place - 0.5f;
    const ivec2 base(glm::floor(p));
    const vec2 f = p - vec2(base);
    Footprint out;
    for (int i = 0; i < 4; ++i) {
        const int x = std::clamp(base.x + (i & 1), 0, size - 1);
        const int y = std::clamp(base.y + (i >> 1), 0, size - 1);
        out.texel[std::size_t(i)] = (uint64_t(page) * uint64_t(size) + uint64_t(y)) * uint64_t(size) + uint64_t(x);
        out.weight[std::size_t(i)] = ((i & 1) ? f.x : 1.0f - f.x) * ((i >> 1) ? f.y : 1.0f - f.y);
    }
    return out;
}

using EdgeMap = std::unordered_map<EdgeKey, std::vector<EdgeSide>, EdgeKeyHash>;

EdgeMap collectEdges(const BakeGeometry& geometry)
{
    EdgeMap edges;
    for (const BakeGeometry::Part& part : geometry.parts) {
        if (part.page < 0) continue;
        for (uint32_t t = part.firstTriangle; t < part.firstTriangle + part.triangleCount; ++t) {
            const uvec3 v = geometry.triangles[t];
            for (int e = 0; e < 3; ++e) {
                uint32_t a = v[e];
                uint32_t b = v[(e + 1) % 3];
                auto bitsA = positionBits(geometry.positions[a]);
                auto bitsB = positionBits(geometry.positions[b]);
                if (bitsA == bitsB) continue;
                if (bitsB < bitsA) {
                    std::swap(a, b);
                    std::swap(bitsA, bitsB);
                }
                EdgeKey key;
                std::copy(bitsA.begin(), bitsA.end(), key.bits.begin());
                std::copy(bitsB.begin(), bitsB.end(), key.bits.begin() + 3);
                edges[key].push_back({part.object, part.page, geometry.lightmapTexel[a], geometry.lightmapTexel[b],
                                      geometry.normals[a], geometry.normals[b]});
            }
        }
    }
    return edges;
}

bool isSeam(const EdgeSide& a, const EdgeSide& b)
{
    const bool samePlace =
        a.page == b.page && glm::distance(a.from, b.from) < 1.0e-3f && glm::distance(a.to, b.to) < 1.0e-3f;
    return !samePlace && glm::dot(a.normalFrom, b.normalFrom) > kSmoothCosine &&
           glm::dot(a.normalTo, b.normalTo) > kSmoothCosine;
}

} // namespace

std::vector<SeamSample> findSeams(const BakeGeometry& geometry, int pageSize)
{
    std::vector<SeamSample> samples;
    const EdgeMap edges = collectEdges(geometry);
    // The map's order depends on the library: sort what comes out of it.
    std::vector<const EdgeMap::value_type*> ordered;
    for (const auto& entry : edges) {
        if (entry.second.size() > 1) ordered.push_back(&entry);
    }
    std::sort(ordered.begin(), ordered.end(),
              [](const auto* a, const auto* b) { return a->first.bits < b->first.bits; });
    for (const auto* entry : ordered) {
        const std::vector<EdgeSide>& sides = entry->second;
        if (sides.size() > 4) continue; // a bush of triangles on one edge has no two sides
        for (std::size_t i = 0; i < sides.size(); ++i) {
            for (std::size_t j = i + 1; j < sides.size(); ++j) {
                const EdgeSide& a = sides[i];
                const EdgeSide& b = sides[j];
                if (!isSeam(a, b)) continue;
                const float length = std::max(glm::distance(a.from, a.to), glm::distance(b.from, b.to));
                const int count = std::clamp(int(std::ceil(2.0f * length)), 1, 4 * pageSize);
                for (int s = 0; s < count; ++s) {
                    const float t = (float(s) + 0.5f) / float(count);
                    samples.push_back({a.object, a.page, b.page, glm::mix(a.from, a.to, t), glm::mix(b.from, b.to, t)});
                }
            }
        }
    }
    return samples;
}

// Least squares over the texels that seams read: each sample along a seam asks both sides' bilinear values to be equal,
// each texel asks to stay what it is (Iwanicki 2013, "Lighting Technology of The Last of Us").
template<typename T> void stitchSeams(const std::vector<SeamSample>& seams, std::vector<Image<T>>& pages)
{
    if (seams.empty() || pages.empty()) return;
    const int size = pages[0].width();
    std::vector<uint32_t> unknownOf(pages.size() * std::size_t(size) * std::size_t(size), kNoUnknown);
    std::vector<uint64_t> texels;
    const auto unknown = [&](uint64_t texel) {
        uint32_t& u = unknownOf[texel];
        if (u == kNoUnknown) {
            u = uint32_t(texels.size());
            texels.push_back(texel);
        }
        return u;
    };
    std::vector<Eigen::Triplet<float>> entries;
    entries.reserve(seams.size() * 8);
    for (std::size_t row = 0; row < seams.size(); ++row) {
        const Footprint a = footprintAt(seams[row].pageA, seams[row].texelA, size);
        const Footprint b = footprintAt(seams[row].pageB, seams[row].texelB, size);
        for (std::size_t i = 0; i < 4; ++i) {
            entries.emplace_back(int(row), int(unknown(a.texel[i])), a.weight[i]);
            entries.emplace_back(int(row), int(unknown(b.texel[i])), -b.weight[i]);
        }
    }
    const auto count = Eigen::Index(texels.size());
    Eigen::SparseMatrix<float> constraints(Eigen::Index(seams.size()), count);
    constraints.setFromTriplets(entries.begin(), entries.end());
    std::vector<Eigen::Triplet<float>>().swap(entries);
    Eigen::SparseMatrix<float> normal = constraints.transpose() * constraints;
    Eigen::SparseMatrix<float> identity(count, count);
    identity.setIdentity();
    normal += identity * float(kKeepWeight);

    const auto texelAt = [&](uint64_t texel) -> T& {
        const std::size_t perPage = std::size_t(size) * std::size_t(size);
        return pages[texel / perPage].data()[texel % perPage];
    };
    constexpr int kComponents = T::length();
    std::array<Eigen::VectorXf, std::size_t(kComponents)> solution;
    Eigen::ConjugateGradient<Eigen::SparseMatrix<float>, Eigen::Lower | Eigen::Upper> solver;
    solver.setMaxIterations(400);
    solver.setTolerance(1.0e-5f);
    solver.compute(normal);
    parallelFor(std::size_t(kComponents), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = begin; c < end; ++c) {
            Eigen::VectorXf before(count);
            for (Eigen::Index i = 0; i < count; ++i) before[i] = texelAt(texels[std::size_t(i)])[int(c)];
            const Eigen::VectorXf right = before * float(kKeepWeight);
            solution[c] = solver.solveWithGuess(right, before);
        }
    });
    for (Eigen::Index i = 0; i < count; ++i) {
        T& texel = texelAt(texels[std::size_t(i)]);
        for (int c = 0; c < kComponents; ++c) {
            // Never outside what is physical; a value that did not come out finite stays as it was.
            const float value = solution[std::size_t(c)][i];
            if (std::isfinite(value)) texel[c] = std::max(value, 0.0f);
        }
    }
}

template void stitchSeams(const std::vector<SeamSample>&, std::vector<Image<vec3>>&);
template void stitchSeams(const std::vector<SeamSample>&, std::vector<Image<vec4>>&);

} // namespace halflight
