#include "unwrap/objects/objects.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <utility>

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

/// Objects that cannot but share a layout: the instances of a node, or one object.
struct Unit {
    std::vector<int> objects;
    std::vector<Eigen::Matrix3d> metrics;
    std::size_t largest = 0; ///< place in the lists above
    dmat3 map{1.0};          ///< of the largest
};

bool joins(const Unit& unit, const Eigen::Matrix3d& metric)
{
    return std::all_of(unit.metrics.begin(), unit.metrics.end(),
                       [&](const Eigen::Matrix3d& own) { return similar(own, metric); });
}

std::vector<Unit> findUnits(const Scene& scene, std::vector<std::string>& warnings)
{
    std::vector<Unit> units;
    std::map<std::pair<int, int>, std::size_t> unitOfNode; // by node and mesh, of instances
    for (std::size_t o = 0; o < scene.objects.size(); ++o) {
        const Object& object = scene.objects[o];
        if (!object.isStatic || !(object.lightmapScale > 0.0f) || object.mesh < 0) continue;
        assert(std::size_t(object.mesh) < scene.meshes.size());
        bool anyTriangle = false;
        for (const MeshPart& part : scene.meshes[std::size_t(object.mesh)].parts)
            anyTriangle |= part.indices.size() >= 3;
        if (!anyTriangle) continue;
        const dmat3 map = dmat3(object.worldFromObject) * double(object.lightmapScale);
        const Eigen::Matrix3d metric = metricOf(map);
        if (!metric.allFinite() || metric.trace() > 1e60) {
            warnings.push_back(
                fmt::format("object \"{}\" is not lightmapped: its transform is not finite", object.name));
            continue;
        }
        std::size_t place = units.size();
        if (object.sourceInstance >= 0) {
            place = unitOfNode.try_emplace({object.sourceNode, object.mesh}, place).first->second;
        }
        if (place == units.size()) units.emplace_back();
        Unit& unit = units[place];
        if (unit.objects.empty() || metric.trace() > unit.metrics[unit.largest].trace()) {
            unit.largest = unit.objects.size();
            unit.map = map;
        }
        unit.objects.push_back(int(o));
        unit.metrics.push_back(metric);
    }
    return units;
}

} // namespace

std::vector<LayoutGroup> groupObjects(const Scene& scene, std::vector<std::string>& warnings)
{
    std::vector<LayoutGroup> groups;
    std::vector<Eigen::Matrix3d> metrics;
    std::vector<std::vector<std::size_t>> groupsOfMesh(scene.meshes.size());
    for (const Unit& unit : findUnits(scene, warnings)) {
        const int mesh = scene.objects[std::size_t(unit.objects[0])].mesh;
        std::vector<std::size_t>& candidates = groupsOfMesh[std::size_t(mesh)];
        const auto found = std::find_if(candidates.begin(), candidates.end(),
                                        [&](std::size_t candidate) { return joins(unit, metrics[candidate]); });
        if (found != candidates.end()) {
            std::vector<int>& objects = groups[*found].objects;
            objects.insert(objects.end(), unit.objects.begin(), unit.objects.end());
            continue;
        }
        candidates.push_back(groups.size());
        groups.push_back({mesh, unit.objects, unit.map});
        metrics.push_back(unit.metrics[unit.largest]);
    }
    for (LayoutGroup& group : groups) std::sort(group.objects.begin(), group.objects.end());
    return groups;
}

} // namespace halflight::charts
