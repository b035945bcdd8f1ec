// Stitches light along the seams that seam_edges.cpp finds.
#include "bake/seams/seams.h"
#include "bake/seams/normal_matrix.h"
#include "bake/seams/seam_parts.h"
#include "bake/texels/texel_places.h"

#include "halflight/base/mathematics.h"
#include "halflight/base/parallel.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <span>
#include <utility>

namespace halflight {
namespace {

constexpr uint32_t kNoUnknown = ~0u;
/// Weight of the term that keeps a texel's value, over that of a seam one texel long, for covered texels and for
/// padding. Padding is read at edges alone, so its weight is 1/100: the sides agree with little change of covered
/// texels, which in narrow charts all lie at seams.
constexpr double kKeepCovered = 0.002;
constexpr double kKeepPadding = kKeepCovered / 100.0;
/// A seam sample whose sides differ by d > kAlike has the weight exp(-kFalloff (d - kAlike)²), which is 0.003 at 0.8.
/// Gathered light at bends is always stitched: it differs because gather directions below a triangle are reflected out
/// of it, and these directions differ on both sides (by a factor of up to 6 in Sponza's mouldings of 45° to 60°).
constexpr float kAlike = 0.5f;
constexpr float kFalloff = 64.0f;

/// Index of a texel over all pages.
uint64_t numberOf(uint64_t page, int x, int y, int size)
{
    return (page * uint64_t(size) + uint64_t(y)) * uint64_t(size) + uint64_t(x);
}

/// The four texels that bilinear filtering at `place` reads, with weights; texels outside the page are clamped into it.
struct Footprint {
    std::array<uint64_t, 4> texel{}; ///< indices, see numberOf()
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

/// Difference of masks, 0…1.
float difference(vec4 a, vec4 b)
{
    const vec4 d = glm::abs(a - b);
    return std::max({d.x, d.y, d.z, d.w});
}
/// Difference of luminance over that of the darker side. `dark`: luminance that is added to it.
float difference(vec3 a, vec3 b, float dark)
{
    const float la = luminance(a);
    const float lb = luminance(b);
    return std::abs(la - lb) / (std::min(la, lb) + dark);
}

/// Eigen's order of elimination for a matrix with both halves. Its own takes the sum with the transpose first, a third
/// of a solution's time.
struct SymmetricOrdering {
    using PermutationType = Eigen::AMDOrdering<int>::PermutationType;
    void operator()(const Eigen::SparseMatrix<double>& matrix, PermutationType& permutation) const
    {
        Eigen::AMDOrdering<int>()(matrix.selfadjointView<Eigen::Lower>(), permutation);
    }
};

/// The least-squares problem over the texels that seams read.
template<typename T> class Stitcher {
public:
    Stitcher(const TexelMap& map, const std::vector<SeamSample>& seams, std::span<const float> weights,
             std::vector<Image<T>>& pages)
        : seams_(seams), weights_(weights), pages_(pages), size_(pages[0].width()),
          unknownOf_(pages.size() * pages[0].texelCount(), kNoUnknown), covered_(unknownOf_.size(), 0)
    {
        forEachIndex(map.texels.size(), [&](std::size_t i) {
            const Texel& t = map.texels[i];
            covered_[numberOf(t.page, t.x, t.y, size_)] = 1;
        });
    }

    /// False if the matrix cannot be factored (light that is not finite).
    bool solve();
    /// Ties padding outside the range of its adjacent covered texels to the one with the nearest value: both become one
    /// unknown. True if there was any.
    bool tiePadding();
    void write(bool bounded);

private:
    std::vector<SeamTerm> makeTerms();
    bool solvePart(const SeamParts::Part& part, std::span<const uint32_t> placeOf, std::span<const SeamTerm> terms);

    struct Range {
        T least = T(kInfinity);
        T most = T(-kInfinity);
        uint64_t nearest = 0; ///< index of the texel with the nearest value
        [[nodiscard]] bool empty() const { return least[0] > most[0]; }
    };

    T& texelAt(uint64_t texel)
    {
        const std::size_t perPage = pages_[0].texelCount();
        return pages_[texel / perPage].data()[texel % perPage];
    }
    uint32_t unknown(uint64_t texel)
    {
        uint32_t& u = unknownOf_[texel];
        if (u == kNoUnknown) {
            u = uint32_t(texels_.size());
            texels_.push_back(texel);
            tied_.push_back(u);
        }
        return u;
    }
    /// A texel's solution, clamped to 0; its own value where the solution is not finite or there is none.
    T valueOf(uint64_t texel)
    {
        T value = texelAt(texel);
        const uint32_t u = unknownOf_[texel];
        if (u == kNoUnknown || Eigen::Index(tied_[u]) >= solution_[0].size()) return value;
        for (int c = 0; c < T::length(); ++c) {
            const auto solved = float(solution_[std::size_t(c)][Eigen::Index(tied_[u])]);
            if (std::isfinite(solved)) value[c] = std::max(solved, 0.0f);
        }
        return value;
    }
    /// Calls body(texel) for the texels up to so many rings around one, and for itself.
    template<typename Body> void forAround(uint64_t texel, int rings, const Body& body) const
    {
        const std::size_t perPage = pages_[0].texelCount();
        const auto place = int(texel % perPage);
        const ivec2 center(place % size_, place / size_);
        for (int y = std::max(center.y - rings, 0); y <= std::min(center.y + rings, size_ - 1); ++y) {
            for (int x = std::max(center.x - rings, 0); x <= std::min(center.x + rings, size_ - 1); ++x)
                body(numberOf(texel / perPage, x, y, size_));
        }
    }
    /// Range of the covered texels in the first ring around a texel that has any, of two.
    Range coveredAround(uint64_t texel, T value);

    const std::vector<SeamSample>& seams_;
    std::span<const float> weights_;
    std::vector<Image<T>>& pages_;
    int size_;
    std::vector<uint32_t> unknownOf_;
    std::vector<uint8_t> covered_;
    std::vector<uint64_t> texels_; ///< by unknown
    std::vector<uint32_t> tied_;   ///< by unknown: the unknown that holds its value, mostly itself
    std::array<Eigen::VectorXd, std::size_t(T::length())> solution_;
};

template<typename T> std::vector<SeamTerm> Stitcher<T>::makeTerms()
{
    std::vector<SeamTerm> terms;
    terms.reserve(seams_.size());
    for (std::size_t row = 0; row < seams_.size(); ++row) {
        const Footprint a = footprintAt(seams_[row].pageA, seams_[row].texelA, size_);
        const Footprint b = footprintAt(seams_[row].pageB, seams_[row].texelB, size_);
        const double weight = std::sqrt(double(weights_[row] * seams_[row].texels)); // of the square
        SeamTerm term;
        for (std::size_t i = 0; i < 4; ++i) {
            term.unknown[2 * i] = tied_[unknown(a.texel[i])];
            term.unknown[2 * i + 1] = tied_[unknown(b.texel[i])];
            term.weight[2 * i] = weight * double(a.weight[i]);
            term.weight[2 * i + 1] = -weight * double(b.weight[i]);
        }
        if (weight > 0.0) terms.push_back(term);
    }
    return terms;
}

template<typename T> bool Stitcher<T>::solve()
{
    const std::vector<SeamTerm> terms = makeTerms();
    const SeamParts split = partsOf(terms, texels_.size());
    for (Eigen::VectorXd& component : solution_) component.resize(Eigen::Index(texels_.size()));
    std::atomic<bool> solved = true;
    parallelFor(split.parts.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t p = begin; p < end; ++p) {
            if (!solvePart(split.parts[p], split.placeOf, terms)) solved = false;
        }
    });
    return solved;
}

template<typename T> bool Stitcher<T>::solvePart(const SeamParts::Part& part, std::span<const uint32_t> placeOf,
                                                 std::span<const SeamTerm> terms)
{
    const auto count = Eigen::Index(part.unknowns.size());
    Eigen::VectorXd keep(count); // also of tied unknowns, which no term has
    for (Eigen::Index i = 0; i < count; ++i)
        keep[i] = covered_[texels_[part.unknowns[std::size_t(i)]]] != 0 ? kKeepCovered : kKeepPadding;
    // Unknowns lie in a few rows along seams, so that factors have hardly more entries than the matrix.
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower, SymmetricOrdering> factors(
        normalMatrix(part, placeOf, terms, keep));
    if (factors.info() != Eigen::Success) return false;
    parallelFor(solution_.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = begin; c < end; ++c) {
            Eigen::VectorXd right(count);
            for (Eigen::Index i = 0; i < count; ++i)
                right[i] = keep[i] * double(texelAt(texels_[part.unknowns[std::size_t(i)]])[int(c)]);
            const Eigen::VectorXd values = factors.solve(right);
            for (Eigen::Index i = 0; i < count; ++i)
                solution_[c][Eigen::Index(part.unknowns[std::size_t(i)])] = values[i];
        }
    });
    return true;
}

template<typename T> typename Stitcher<T>::Range Stitcher<T>::coveredAround(uint64_t texel, T value)
{
    Range range;
    float nearest = kInfinity;
    for (int rings = 1; rings <= 2 && range.empty(); ++rings) {
        forAround(texel, rings, [&](uint64_t other) {
            if (covered_[other] == 0) return;
            const T v = valueOf(other);
            range.least = glm::min(range.least, v);
            range.most = glm::max(range.most, v);
            const float distance = glm::dot(v - value, v - value);
            if (distance >= nearest) return;
            nearest = distance;
            range.nearest = other;
        });
    }
    return range;
}

template<typename T> bool Stitcher<T>::tiePadding()
{
    constexpr uint64_t kNone = ~uint64_t(0);
    std::vector<uint64_t> tie(texels_.size(), kNone); // covered texel, by unknown
    forEachIndex(texels_.size(), [&](std::size_t u) {
        if (covered_[texels_[u]] != 0) return;
        const T value = valueOf(texels_[u]);
        const Range range = coveredAround(texels_[u], value);
        if (range.empty()) return;
        for (int c = 0; c < T::length(); ++c)
            if (value[c] > range.most[c] || value[c] < range.least[c]) tie[u] = range.nearest;
    });
    bool any = false;
    for (std::size_t u = 0; u < tie.size(); ++u) {
        if (tie[u] == kNone) continue;
        tied_[u] = unknown(tie[u]);
        any = true;
    }
    return any;
}

template<typename T> void Stitcher<T>::write(bool bounded)
{
    std::vector<T> values(texels_.size());
    forEachIndex(texels_.size(), [&](std::size_t i) { values[i] = valueOf(texels_[i]); });
    forEachIndex(texels_.size(), [&](std::size_t i) { texelAt(texels_[i]) = values[i]; });
    for (Eigen::VectorXd& component : solution_) component.resize(0); // the pages hold the values now
    if (!bounded) return;
    // All padding around changed covered texels, also where no seam reads it.
    std::vector<uint8_t> beside(covered_.size(), 0);
    for (const uint64_t texel : texels_) {
        if (covered_[texel] != 0) forAround(texel, 2, [&](uint64_t other) { beside[other] = covered_[other] == 0; });
    }
    forEachIndex(beside.size(), [&](std::size_t texel) {
        if (beside[texel] == 0) return;
        const Range range = coveredAround(texel, texelAt(texel));
        if (!range.empty()) texelAt(texel) = glm::clamp(texelAt(texel), range.least, range.most);
    });
}

} // namespace

namespace {

template<typename T> std::pair<T, T> sidesOf(const std::vector<Image<T>>& pages, const SeamSample& seam)
{
    const int size = pages[0].width();
    return {filtered(pages, footprintAt(seam.pageA, seam.texelA, size)),
            filtered(pages, footprintAt(seam.pageB, seam.texelB, size))};
}

/// Luminance that a difference relative to the darker side adds to it: a thousandth of the mean along the seams.
float darkOf(const std::vector<SeamSample>& seams, const std::vector<ImageRgb32f>& pages)
{
    constexpr double kDark = 1.0e-3; // of the mean: keeps ratios of black texels finite
    std::vector<float> both(seams.size());
    forEachIndex(seams.size(), [&](std::size_t i) {
        const auto [a, b] = sidesOf(pages, seams[i]);
        both[i] = luminance(a + b);
    });
    double sum = 0.0;
    for (const float luminances : both) sum += 0.5 * double(luminances);
    return std::max(float(kDark * sum / double(seams.size())), 1.0e-20f);
}

/// `excess`: by how much a difference exceeds the limit of similar sides.
float weightOf(float excess)
{
    return excess > 0.0f ? math::exp(-kFalloff * excess * excess) : 1.0f;
}

} // namespace

// Light can be discontinuous across a seam: at the hem of a curtain between sun and shade, or where a wall stands on
// the seam. Texels of both sides straddle the discontinuity there, and stitching would move light to the dark side.
// Gathered light at bends is continuous, as the shading normals are, whatever the estimates of both sides.
std::vector<float> lightSeamWeights(const std::vector<SeamSample>& seams, const std::vector<ImageRgb32f>& light,
                                    const std::vector<ImageRgb32f>& direct)
{
    std::vector<float> weights(seams.size(), 0.0f);
    if (seams.empty() || light.empty()) return weights;
    const float dark = darkOf(seams, light);
    forEachIndex(seams.size(), [&](std::size_t i) {
        const auto [a, b] = sidesOf(light, seams[i]);
        float excess = difference(a, b, dark) - kAlike;
        if (seams[i].bent && direct.empty()) {
            excess = 0.0f;
        } else if (seams[i].bent) {
            const auto [directA, directB] = sidesOf(direct, seams[i]);
            const float ofDirect =
                std::abs(luminance(directA - directB)) / (std::min(luminance(a), luminance(b)) + dark);
            excess = ofDirect - kAlike;
        }
        weights[i] = weightOf(excess);
    });
    return weights;
}

std::vector<float> maskSeamWeights(const std::vector<SeamSample>& seams, const std::vector<ImageRgba32f>& masks)
{
    std::vector<float> weights(seams.size(), 0.0f);
    if (seams.empty() || masks.empty()) return weights;
    forEachIndex(seams.size(), [&](std::size_t i) {
        const auto [a, b] = sidesOf(masks, seams[i]);
        weights[i] = weightOf(difference(a, b) - kAlike);
    });
    return weights;
}

// Least squares over the texels that seams read (Iwanicki 2013, "Lighting Technology of The Last of Us"): one term per
// seam sample for the difference of both sides' bilinear values, one per texel for the change of its value. Padding
// outside the range of its adjacent covered texels would be visible as a rim. It is tied to one of these, and a second
// solution changes the covered texels instead.
template<typename T> void stitchSeams(const TexelMap& map, const std::vector<SeamSample>& seams,
                                      std::span<const float> weights, std::vector<Image<T>>& pages, bool bounded)
{
    if (seams.empty() || pages.empty()) return;
    Stitcher<T> stitcher(map, seams, weights, pages);
    if (!stitcher.solve()) return;
    if (bounded && stitcher.tiePadding() && !stitcher.solve()) return;
    stitcher.write(bounded);
}

template void stitchSeams(const TexelMap&, const std::vector<SeamSample>&, std::span<const float>,
                          std::vector<Image<vec3>>&, bool);
template void stitchSeams(const TexelMap&, const std::vector<SeamSample>&, std::span<const float>,
                          std::vector<Image<vec4>>&, bool);

} // namespace halflight
