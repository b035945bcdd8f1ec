#include "unwrap/charts/arap.h"

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>
#include <cmath>

namespace halflight::charts {
namespace {

constexpr int kRelaxations = 4;
/// Vertices of a chart up to which its matrix is factored: factors grow faster than charts do. A larger chart needs a
/// guess that is right in the large. Its details are put right in so many rounds of so many steps.
constexpr std::size_t kMostFactored = 100000;
constexpr int kRelaxationsOfLarge = 2;
constexpr int kSteps = 16;

/// Turns `v` by the smallest rotation that takes the unit vector `from` to `to`.
dvec3 turned(dvec3 v, dvec3 from, dvec3 to)
{
    const double cosine = glm::dot(from, to);
    if (cosine < -0.999999) return v - 2.0 * glm::dot(v, to) * to;
    const dvec3 axis = glm::cross(from, to);
    return cosine * v + glm::cross(axis, v) + axis * (glm::dot(axis, v) / (1.0 + cosine));
}

/// What stays the same in all rounds.
struct ArapSystem {
    std::vector<dvec2> edges;    ///< 3 per triangle: edge k runs from corner k to the next, flattened
    std::vector<double> weights; ///< of the edges: the cotangent of the opposite angle, kept positive
    Eigen::SparseMatrix<double> laplacian;
};

/// Row of a vertex in the matrix; none for vertex 0, which stays at the origin.
int rowOf(uint32_t vertex)
{
    return int(vertex) - 1;
}

ArapSystem arapSystem(const Piece& piece)
{
    const std::size_t triangleCount = piece.triangles.size();
    const Basis basis = basisOf(piece.meanNormal);
    ArapSystem system;
    system.edges.resize(3 * triangleCount);
    system.weights.resize(3 * triangleCount);
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(9 * triangleCount);
    for (std::size_t t = 0; t < triangleCount; ++t) {
        const dvec3 normal = piece.surface.normals[piece.triangles[t]];
        const double doubleArea = 2.0 * piece.surface.areas[piece.triangles[t]];
        for (std::size_t k = 0; k < 3; ++k) {
            const uint32_t a = piece.corners[3 * t + k], b = piece.corners[3 * t + (k + 1) % 3];
            const dvec3 pa = piece.positions[a], pb = piece.positions[b];
            const dvec3 pc = piece.positions[piece.corners[3 * t + (k + 2) % 3]];
            const dvec3 edge = turned(pb - pa, normal, piece.meanNormal);
            system.edges[3 * t + k] = {glm::dot(edge, basis.x), glm::dot(edge, basis.y)};
            const double weight = std::clamp(glm::dot(pa - pc, pb - pc) / doubleArea, 0.02, 50.0);
            system.weights[3 * t + k] = weight;
            const int i = rowOf(a), j = rowOf(b);
            if (i >= 0) entries.emplace_back(i, i, weight);
            if (j >= 0) entries.emplace_back(j, j, weight);
            if (i >= 0 && j >= 0) {
                entries.emplace_back(i, j, -weight);
                entries.emplace_back(j, i, -weight);
            }
        }
    }
    const auto n = Eigen::Index(piece.positions.size()) - 1;
    system.laplacian.resize(n, n);
    system.laplacian.setFromTriplets(entries.begin(), entries.end());
    return system;
}

class Solver {
public:
    /// Keeps a reference to the matrix.
    Solver(const Eigen::SparseMatrix<double>& laplacian, bool direct) : direct_(direct)
    {
        if (direct) {
            factors_.compute(laplacian);
            return;
        }
        stepper_.setMaxIterations(kSteps);
        stepper_.setTolerance(1e-6);
        stepper_.compute(laplacian);
    }

    [[nodiscard]] bool isReady() const { return !direct_ || factors_.info() == Eigen::Success; }

    /// `uv`: by vertex; what it holds is where steps begin.
    void solve(const Eigen::MatrixX2d& right, std::vector<dvec2>& uv) const
    {
        Eigen::MatrixX2d solution;
        if (direct_) {
            solution = factors_.solve(right);
        } else {
            Eigen::MatrixX2d guess(right.rows(), 2);
            for (std::size_t v = 1; v < uv.size(); ++v)
                guess.row(Eigen::Index(v) - 1) = Eigen::RowVector2d(uv[v].x - uv[0].x, uv[v].y - uv[0].y);
            solution = stepper_.solveWithGuess(right, guess);
        }
        uv[0] = dvec2(0.0);
        for (std::size_t v = 1; v < uv.size(); ++v)
            uv[v] = {solution(Eigen::Index(v) - 1, 0), solution(Eigen::Index(v) - 1, 1)};
    }

private:
    bool direct_;
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors_;
    Eigen::ConjugateGradient<Eigen::SparseMatrix<double>, Eigen::Lower | Eigen::Upper> stepper_;
};

/// The local step: each triangle's rotation that fits `uv` best. Returns the largest change of one.
double fitRotations(const Piece& piece, const ArapSystem& system, const std::vector<dvec2>& uv,
                    std::vector<dvec2>& rotations)
{
    double change = 0.0;
    for (std::size_t t = 0; t < rotations.size(); ++t) {
        dvec2 fit(0.0);
        for (std::size_t k = 0; k < 3; ++k) {
            const dvec2 e = system.edges[3 * t + k];
            const dvec2 u = uv[piece.corners[3 * t + (k + 1) % 3]] - uv[piece.corners[3 * t + k]];
            fit += system.weights[3 * t + k] * dvec2(glm::dot(e, u), e.x * u.y - e.y * u.x);
        }
        const double length = glm::length(fit);
        if (!(length > 0.0)) continue;
        change = std::max(change, glm::length(fit / length - rotations[t]));
        rotations[t] = fit / length;
    }
    return change;
}

/// The global step: vertices whose edges are as near as can be to the rotated ones.
void improve(const Piece& piece, const ArapSystem& system, const Solver& solver, const std::vector<dvec2>& rotations,
             std::vector<dvec2>& uv)
{
    Eigen::MatrixX2d right = Eigen::MatrixX2d::Zero(system.laplacian.rows(), 2);
    for (std::size_t t = 0; t < rotations.size(); ++t) {
        const dvec2 r = rotations[t];
        for (std::size_t k = 0; k < 3; ++k) {
            const dvec2 e = system.edges[3 * t + k];
            const dvec2 wanted = system.weights[3 * t + k] * dvec2(r.x * e.x - r.y * e.y, r.y * e.x + r.x * e.y);
            const int a = rowOf(piece.corners[3 * t + k]), b = rowOf(piece.corners[3 * t + (k + 1) % 3]);
            if (b >= 0) right.row(b) += Eigen::RowVector2d(wanted.x, wanted.y);
            if (a >= 0) right.row(a) -= Eigen::RowVector2d(wanted.x, wanted.y);
        }
    }
    solver.solve(right, uv);
}

} // namespace

std::vector<dvec2> startingPoint(const Piece& piece, std::span<const dvec2> ofCorner)
{
    std::vector<dvec2> uv(piece.positions.size(), dvec2(0.0));
    std::vector<double> corners(uv.size(), 0.0);
    for (std::size_t c = 0; c < piece.corners.size(); ++c) {
        uv[piece.corners[c]] += ofCorner[c];
        corners[piece.corners[c]] += 1.0;
    }
    for (std::size_t v = 0; v < uv.size(); ++v) uv[v] /= corners[v];
    return uv;
}

std::vector<dvec2> relax(const Piece& piece, std::span<const dvec2> guess)
{
    const ArapSystem system = arapSystem(piece);
    const bool direct = piece.positions.size() <= kMostFactored || guess.empty();
    const Solver solver(system.laplacian, direct);
    if (!solver.isReady()) return project(piece);
    std::vector<dvec2> uv(piece.positions.size(), dvec2(0.0));
    std::vector<dvec2> rotations(piece.triangles.size(), dvec2(1.0, 0.0));
    if (!guess.empty()) {
        uv = startingPoint(piece, guess);
        fitRotations(piece, system, uv, rotations);
    }
    for (int round = 0; round <= (direct ? kRelaxations : kRelaxationsOfLarge); ++round) {
        improve(piece, system, solver, rotations, uv);
        if (fitRotations(piece, system, uv, rotations) < 1e-3) break;
    }
    return uv;
}

} // namespace halflight::charts
