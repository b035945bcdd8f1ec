#include "unwrap/objects.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <fmt/format.h>

namespace halflight::charts {
namespace {

/// Lengths on objects of one group differ by less than this factor.
constexpr double kSameScale = 1.05;

/// Lengths after a linear map A are those of the metric A^T A.
Eigen::Matrix3d metricOf(const dmat3& map)
{
    const dmat3 metric = glm::transpose(map) * map;
    Eigen::Matrix3d result;
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) result(row, column) = metric[column][row];
    }
    // Flattened objects stay comparable: a direction that is lost counts as a millionth of the others.
    result.diagonal().array() += 1e-12 * result.trace() + 1e-280;
    return result;
}

/// The ratio of lengths in any direction lies within the square roots of the generalized eigenvalues.
bool similar(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b)
{
    constexpr double most = kSameScale * kSameScale;
    const double ratio = a.trace() / b.trace();
    if (!(ratio < most && ratio > 1.0 / most)) return false;
    if ((a - b).cwiseAbs().maxCoeff() < 1e-9 * b.trace()) return true;
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix3d> solver(a, b, Eigen::EigenvaluesOnly);
    return solver.info() == Eigen::Success && solver.eigenvalues()[0] > 1.0 / most && solver.eigenvalues()[2] < most;
}

} // namespace

std::vector<LayoutGroup> groupObjects(const Scene& scene, std::vector<std::string>& warnings)
{
    std::vector<LayoutGroup> groups;
    std::vector<Eigen::Matrix3d> metrics;
    std::vector<std::vector<std::size_t>> groupsOfMesh(scene.meshes.size());
    for (std::size_t o = 0; o < scene.objects.size(); ++o) {
        const Object& object = scene.objects[o];
        if (!object.isStatic || !(object.lightmapScale > 0.0f) || object.mesh < 0) continue;
        const auto mesh = std::size_t(object.mesh);
        assert(mesh < scene.meshes.size());
        bool anyTriangle = false;
        for (const MeshPart& part : scene.meshes[mesh].parts) anyTriangle |= part.indices.size() >= 3;
        if (!anyTriangle) continue;
        const dmat3 map = dmat3(object.worldFromObject) * double(object.lightmapScale);
        const Eigen::Matrix3d metric = metricOf(map);
        if (!metric.allFinite() || metric.trace() > 1e60) {
            warnings.push_back(
                fmt::format("object \"{}\" is not lightmapped: its transform is not finite", object.name));
            continue;
        }
        std::size_t group = groups.size();
        for (const std::size_t candidate : groupsOfMesh[mesh]) {
            if (similar(metric, metrics[candidate])) {
                group = candidate;
                break;
            }
        }
        if (group == groups.size()) {
            groups.push_back({object.mesh, {}, map});
            metrics.push_back(metric);
            groupsOfMesh[mesh].push_back(group);
        }
        groups[group].objects.push_back(int(o));
    }
    return groups;
}

} // namespace halflight::charts
