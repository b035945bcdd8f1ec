#pragma once
// Samples and late light of form factors, sorted by who gathers them.

#include "transport/radiosity/form_factors.h"

#include "halflight/base/atomic_ref.h"
#include "halflight/base/parallel.h"

#include <algorithm>
#include <numeric>
#include <span>
#include <tuple>
#include <vector>

namespace halflight {

/// Compressed rows. A row has its terms in the order of the ranges, samples before late light. So sums by row do not
/// depend on threads.
class FactorRows {
public:
    struct Term {
        static constexpr uint32_t kLate = ~0u;
        uint32_t range = 0;
        uint32_t index = 0;     ///< into FormFactorRange::samples, or late
        uint32_t firstLink = 0; ///< of a sample
        uint32_t linkCount = 0; ///< kLate for late light
        [[nodiscard]] bool isLate() const { return linkCount == kLate; }
    };

    FactorRows() = default;
    /// `rowOf(patch)`: row of samples or late light of that patch; from `rows` on, they are in none.
    template<typename RowOf> FactorRows(const FormFactors& factors, std::size_t rows, const RowOf& rowOf)
    {
        std::vector<uint32_t> next(rows + 1, 0); // number of terms, then the place of the next one
        forTerms(factors, rows, rowOf, [&](std::size_t row, const Term&) {
            AtomicRef<uint32_t>(next[row]).fetch_add(1, std::memory_order_relaxed);
        });
        std::exclusive_scan(next.begin(), next.end(), next.begin(), 0u);
        first_ = next;
        terms_.resize(first_.back());
        forTerms(factors, rows, rowOf, [&](std::size_t row, const Term& term) {
            terms_[AtomicRef<uint32_t>(next[row]).fetch_add(1, std::memory_order_relaxed)] = term;
        });
        forEachIndex(rows, [&](std::size_t row) {
            std::sort(terms_.begin() + first_[row], terms_.begin() + first_[row + 1],
                      [](const Term& a, const Term& b) { return key(a) < key(b); });
        });
    }

    [[nodiscard]] std::span<const Term> of(std::size_t row) const
    {
        return std::span(terms_).subspan(first_[row], first_[row + 1] - first_[row]);
    }

private:
    static auto key(const Term& t) { return std::tuple(t.range, t.isLate(), t.index); }

    /// Calls visit(row, term) for all terms, on all threads.
    template<typename RowOf, typename Visit>
    static void forTerms(const FormFactors& factors, std::size_t rows, const RowOf& rowOf, const Visit& visit)
    {
        const auto inRow = [&](PatchId patch, const Term& term) {
            const std::size_t row = rowOf(patch);
            if (row < rows) visit(row, term);
        };
        parallelFor(factors.size(), 16, [&](std::size_t begin, std::size_t end) {
            for (std::size_t r = begin; r < end; ++r) {
                const FormFactorRange& range = factors[r];
                uint32_t link = 0;
                for (uint32_t i = 0; i < range.samples.size(); ++i) {
                    inRow(range.samples[i].patch, {uint32_t(r), i, link, range.samples[i].linkCount});
                    link += range.samples[i].linkCount;
                }
                for (uint32_t i = 0; i < range.late.size(); ++i)
                    inRow(range.late[i].patch, {uint32_t(r), i, 0, Term::kLate});
            }
        });
    }

    std::vector<uint32_t> first_; ///< by row; then the number of terms
    std::vector<Term> terms_;
};

} // namespace halflight
