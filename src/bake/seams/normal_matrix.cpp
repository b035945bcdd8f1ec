#include "bake/seams/normal_matrix.h"

#include <algorithm>
#include <array>
#include <vector>

namespace halflight {
namespace {

/// The unknowns of a term, each but once: tied ones may be equal.
struct Row {
    std::array<uint32_t, 8> unknown{};
    std::array<double, 8> weight{};
    std::size_t count = 0;

    void add(uint32_t u, double w)
    {
        std::size_t i = 0;
        while (i < count && unknown[i] != u) ++i;
        if (i == count) unknown[count++] = u;
        weight[i] += w;
    }
    [[nodiscard]] double weightOf(uint32_t u) const
    {
        std::size_t i = 0;
        while (unknown[i] != u) ++i;
        return weight[i];
    }
};

} // namespace

Eigen::SparseMatrix<double> normalMatrix(const SeamParts::Part& part, std::span<const uint32_t> placeOf,
                                         std::span<const SeamTerm> terms, const Eigen::VectorXd& keep)
{
    const std::size_t count = part.unknowns.size();
    std::vector<Row> rows(part.terms.size());
    std::vector<std::size_t> firstOf(count + 1, 0); // of an unknown's rows in the next list
    for (std::size_t r = 0; r < rows.size(); ++r) {
        const SeamTerm& term = terms[part.terms[r]];
        for (std::size_t i = 0; i < term.unknown.size(); ++i) rows[r].add(placeOf[term.unknown[i]], term.weight[i]);
        for (std::size_t i = 0; i < rows[r].count; ++i) ++firstOf[rows[r].unknown[i] + 1];
    }
    for (std::size_t u = 0; u < count; ++u) firstOf[u + 1] += firstOf[u];
    std::vector<uint32_t> rowsOf(firstOf[count]);
    std::vector<std::size_t> next(firstOf.begin(), firstOf.end() - 1);
    for (uint32_t r = 0; r < rows.size(); ++r) {
        for (std::size_t i = 0; i < rows[r].count; ++i) rowsOf[next[rows[r].unknown[i]]++] = r;
    }
    Eigen::SparseMatrix<double> matrix{Eigen::Index(count), Eigen::Index(count)};
    matrix.reserve(Eigen::Index(2 * rowsOf.size()));
    std::vector<double> sums(count);
    std::vector<uint32_t> columnOf(count, ~0u); // in which an unknown's sum was begun
    std::vector<uint32_t> begun;
    for (uint32_t u = 0; u < count; ++u) {
        begun.assign(1, u);
        sums[u] = 0.0;
        columnOf[u] = u;
        for (std::size_t i = firstOf[u]; i < firstOf[u + 1]; ++i) {
            const Row& row = rows[rowsOf[i]];
            const double own = row.weightOf(u);
            for (std::size_t k = 0; k < row.count; ++k) {
                const uint32_t other = row.unknown[k];
                if (other < u) continue;
                if (columnOf[other] != u) {
                    columnOf[other] = u;
                    sums[other] = 0.0;
                    begun.push_back(other);
                }
                sums[other] += row.weight[k] * own;
            }
        }
        std::sort(begun.begin(), begun.end());
        matrix.startVec(Eigen::Index(u));
        for (const uint32_t other : begun)
            matrix.insertBack(Eigen::Index(other), Eigen::Index(u)) = sums[other] + (other == u ? keep[u] : 0.0);
    }
    matrix.finalize();
    return matrix;
}

} // namespace halflight
