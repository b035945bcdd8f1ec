// Makes light agree along the seams that seam_edges.cpp finds.
#include "bake/stages.h"

#include "halflight/base/memory.h"
#include "halflight/base/parallel.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

namespace halflight {
namespace {

constexpr uint32_t kNoUnknown = ~0u;
/// Pull of a texel towards its own value, against 1 for a seam as long as a texel: of one that surface covers, and of
/// padding. Padding is read at edges alone, and what is good there is its only purpose: with it free to give way the
/// sides agree without the covered texels' light being moved along the seam, which in narrow charts is all they have.
constexpr double kKeepCovered = 0.002;
constexpr double kKeepPadding = 2.0e-5;
/// Seam samples whose sides differ by more than this lose their weight, so fast that beyond 0.8 little is stitched.
constexpr float kAlike = 0.5f;
constexpr float kFalloff = 64.0f;

/// Number of a texel among those of all pages.
uint64_t numberOf(uint64_t page, int x, int y, int size)
{
    return (page * uint64_t(size) + uint64_t(y)) * uint64_t(size) + uint64_t(x);
}

/// The four texels that bilinear filtering at `place` reads, with weights; texels outside the page are clamped into it.
struct Footprint {
    std::array<uint64_t, 4> texel{}; ///< numbers
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
        out.texel[std::size_t(i)] = numberOf(uint64_t(page), x, y, size);
        out.weight[std::size_t(i)] = ((i & 1) ? f.x : 1.0f - f.x) * ((i >> 1) ? f.y : 1.0f - f.y);
    }
    return out;
}

template<typename T> T filtered(const std::vector<Image<T>>& pages, const Footprint& f)
{
    const std::size_t perPage = pages[0].texelCount();
    T sum(0.0f);
    for (std::size_t i = 0; i < 4; ++i) sum += f.weight[i] * pages[f.texel[i] / perPage].data()[f.texel[i] % perPage];
    return sum;
}

/// Of masks: what part of a light.
float difference(vec4 a, vec4 b, float)
{
    const vec4 d = glm::abs(a - b);
    return std::max({d.x, d.y, d.z, d.w});
}
/// Of light: over the darker side.
float difference(vec3 a, vec3 b, float dark)
{
    const float la = luminance(a);
    const float lb = luminance(b);
    return std::abs(la - lb) / (std::min(la, lb) + dark);
}

} // namespace

// Where light changes at once, at the hem of a curtain between sun and shade or where a wall stands on the seam, the
// texels of both sides straddle the change, and would carry light to the dark side: there they are right to differ.
template<typename T>
std::vector<float> seamWeights(const std::vector<SeamSample>& seams, const std::vector<Image<T>>& pages)
{
    constexpr float kDark = 1.0e-3f; ///< of the mean along the seams: differences below are none
    std::vector<float> weights(seams.size(), 0.0f);
    if (seams.empty() || pages.empty()) return weights;
    const int size = pages[0].width();
    std::vector<std::pair<T, T>> sides;
    sides.reserve(seams.size());
    double sum = 0.0;
    for (const SeamSample& seam : seams) {
        sides.emplace_back(filtered(pages, footprintAt(seam.pageA, seam.texelA, size)),
                           filtered(pages, footprintAt(seam.pageB, seam.texelB, size)));
        sum += double(luminance(vec3(sides.back().first) + vec3(sides.back().second)));
    }
    const float dark = kDark * float(0.5 * sum / double(seams.size()));
    for (std::size_t i = 0; i < seams.size(); ++i) {
        const float excess = difference(sides[i].first, sides[i].second, std::max(dark, 1.0e-20f)) - kAlike;
        weights[i] = excess > 0.0f ? std::exp(-kFalloff * excess * excess) : 1.0f;
    }
    return weights;
}

// Least squares over the texels that seams read: each sample along a seam asks both sides' bilinear values to be equal,
// each texel asks to stay what it is (Iwanicki 2013, "Lighting Technology of The Last of Us").
template<typename T> void stitchSeams(const TexelMap& map, const std::vector<SeamSample>& seams,
                                      std::span<const float> weights, std::vector<Image<T>>& pages)
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
    using Matrix = Eigen::SparseMatrix<double>;
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(seams.size() * 8);
    for (std::size_t row = 0; row < seams.size(); ++row) {
        const Footprint a = footprintAt(seams[row].pageA, seams[row].texelA, size);
        const Footprint b = footprintAt(seams[row].pageB, seams[row].texelB, size);
        const double weight = std::sqrt(double(weights[row] * seams[row].texels)); // of the square
        for (std::size_t i = 0; i < 4; ++i) {
            entries.emplace_back(int(row), int(unknown(a.texel[i])), weight * double(a.weight[i]));
            entries.emplace_back(int(row), int(unknown(b.texel[i])), -weight * double(b.weight[i]));
        }
    }
    const auto count = Eigen::Index(texels.size());
    Matrix normal;
    {
        Matrix constraints(Eigen::Index(seams.size()), count);
        constraints.setFromTriplets(entries.begin(), entries.end());
        release(entries);
        normal = constraints.transpose() * constraints;
    }
    Eigen::VectorXd keep = Eigen::VectorXd::Constant(count, kKeepPadding);
    for (const Texel& t : map.texels) {
        const uint32_t u = unknownOf[numberOf(t.page, t.x, t.y, size)];
        if (u != kNoUnknown) keep[Eigen::Index(u)] = kKeepCovered;
    }
    release(unknownOf);
    normal.diagonal() += keep;
    // Seams are lines, beside which unknowns lie in a few rows: factors have hardly more entries than the matrix.
    const Eigen::SimplicialLDLT<Matrix> factors(normal);
    if (factors.info() != Eigen::Success) return; // of light that is no number

    const auto texelAt = [&](uint64_t texel) -> T& {
        const std::size_t perPage = std::size_t(size) * std::size_t(size);
        return pages[texel / perPage].data()[texel % perPage];
    };
    constexpr int kComponents = T::length();
    std::array<Eigen::VectorXd, std::size_t(kComponents)> solution;
    parallelFor(std::size_t(kComponents), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = begin; c < end; ++c) {
            Eigen::VectorXd right(count);
            for (Eigen::Index i = 0; i < count; ++i)
                right[i] = keep[i] * double(texelAt(texels[std::size_t(i)])[int(c)]);
            solution[c] = factors.solve(right);
        }
    });
    for (Eigen::Index i = 0; i < count; ++i) {
        T& texel = texelAt(texels[std::size_t(i)]);
        for (int c = 0; c < kComponents; ++c) {
            // Never outside what is physical; a value that did not come out finite stays as it was.
            const auto value = float(solution[std::size_t(c)][i]);
            if (std::isfinite(value)) texel[c] = std::max(value, 0.0f);
        }
    }
}

template std::vector<float> seamWeights(const std::vector<SeamSample>&, const std::vector<Image<vec3>>&);
template std::vector<float> seamWeights(const std::vector<SeamSample>&, const std::vector<Image<vec4>>&);
template void stitchSeams(const TexelMap&, const std::vector<SeamSample>&, std::span<const float>,
                          std::vector<Image<vec3>>&);
template void stitchSeams(const TexelMap&, const std::vector<SeamSample>&, std::span<const float>,
                          std::vector<Image<vec4>>&);

} // namespace halflight
