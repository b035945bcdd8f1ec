// The tetrahedra's hull and starting cells. Then finding a point.
#include "render/frame/probes_mesh.h"

#include "halflight/base/finite.h"
#include "halflight/base/mathematics.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace halflight {

using glm::dvec3;

ProbeMesh::ProbeMesh(const BakedScene& baked) : sky_(skyProbe(baked.scene.sky)), mesh_(probeCells(baked.probes))
{
    if (mesh_.cells.empty()) return;
    sources_.assign(mesh_.probeOf.begin(), mesh_.probeOf.begin() + std::ptrdiff_t(mesh_.probeCount));
    for (const uint32_t source : sources_) probes_.push_back(baked.probes.probes[source]);
    sight_ = ProbeSightMaps(baked.probes.sight, sources_);
    buildHull();
    buildStarts();
}

void ProbeMesh::buildHull()
{
    std::vector<HullFaces::Face> faces;
    for (const Tetrahedron& cell : mesh_.cells) {
        for (std::size_t i = 0; i < 4; ++i) {
            if (cell.neighbor[i] != kOutside) continue;
            HullFaces::Face face{{cell.vertex[(i + 1) % 4], cell.vertex[(i + 2) % 4], cell.vertex[(i + 3) % 4]}};
            std::sort(face.vertex.begin(), face.vertex.end());
            faces.push_back(face);
        }
    }
    hull_.build(std::move(faces), mesh_.vertices);
}

// About one starting cell per probe, so that a walk is a few steps long.
void ProbeMesh::buildStarts()
{
    low_ = high_ = mesh_.vertices[0];
    for (const dvec3& v : mesh_.vertices) {
        low_ = glm::min(low_, v);
        high_ = glm::max(high_, v);
    }
    const dvec3 size = high_ - low_;
    const double edge = math::cbrt(size.x * size.y * size.z / double(mesh_.vertices.size()));
    for (int axis = 0; axis < 3; ++axis) startSize_[axis] = int(glm::clamp(std::ceil(size[axis] / edge), 1.0, 128.0));
    starts_.reserve(std::size_t(startSize_.x) * std::size_t(startSize_.y) * std::size_t(startSize_.z));
    uint32_t from = 0;
    for (int z = 0; z < startSize_.z; ++z) {
        for (int y = 0; y < startSize_.y; ++y) {
            for (int x = 0; x < startSize_.x; ++x) {
                from = walk(from, low_ + (dvec3(x, y, z) + 0.5) / dvec3(startSize_) * size).cell;
                starts_.push_back(from);
            }
        }
    }
}

std::size_t ProbeMesh::startCellOf(dvec3 point) const
{
    const dvec3 at = (point - low_) / (high_ - low_) * dvec3(startSize_);
    const ivec3 place(glm::clamp(at, dvec3(0.0), dvec3(startSize_ - 1)));
    return (std::size_t(place.z) * std::size_t(startSize_.y) + std::size_t(place.y)) * std::size_t(startSize_.x) +
           std::size_t(place.x);
}

/// Barycentric coordinates times six volumes.
std::array<double, 4> ProbeMesh::weightsIn(const Tetrahedron& cell, dvec3 point) const
{
    const dvec3 a = mesh_.vertices[cell.vertex[0]] - point;
    const dvec3 b = mesh_.vertices[cell.vertex[1]] - point;
    const dvec3 c = mesh_.vertices[cell.vertex[2]] - point;
    const dvec3 d = mesh_.vertices[cell.vertex[3]] - point;
    const dvec3 cd = glm::cross(c, d);
    const dvec3 ab = glm::cross(a, b);
    return {glm::dot(b, cd), -glm::dot(a, cd), glm::dot(ab, d), -glm::dot(ab, c)};
}

/// Towards the point, through the face that it is farthest behind. A step back, or very many, mean that the point is on
/// a face as far as doubles can tell.
ProbeMesh::Where ProbeMesh::walk(uint32_t start, dvec3 point) const
{
    Where where{start};
    uint32_t from = kOutside;
    for (int step = 0; step < 100000; ++step) {
        const Tetrahedron& cell = mesh_.cells[where.cell];
        where.weights = weightsIn(cell, point);
        std::size_t least = 0;
        double size = 0.0;
        for (std::size_t i = 0; i < 4; ++i) {
            if (where.weights[i] < where.weights[least]) least = i;
            size += std::abs(where.weights[i]);
        }
        const uint32_t next = cell.neighbor[least];
        if (!(where.weights[least] < -1.0e-14 * size)) break;
        if (next == kOutside) {
            where.outside = true;
            break;
        }
        if (next == from) break;
        from = std::exchange(where.cell, next);
    }
    return where;
}

// Each share times how well its probe sees the point that the shares are those of. Where a probe's share is 0 it stays
// 0, so the result is continuous from cell to cell.
void ProbeMesh::weighBySight(Shares& shares) const
{
    dvec3 point(0.0);
    double total = 0.0;
    for (const auto& [place, share] : shares) {
        point += share * mesh_.vertices[place];
        total += share;
    }
    if (!(total > 0.0)) return;
    point /= total;
    for (auto& [place, share] : shares) {
        if (share > 0.0) share *= double(sight_.weight(place, vec3(mesh_.frame * (point - mesh_.vertices[place]))));
    }
}

ProbeWeights ProbeMesh::weights(vec3 position) const
{
    ProbeWeights result;
    if (empty()) return result;
    if (!isFinite(position)) position = vec3(mesh_.origin);
    dvec3 point = (dvec3(position) - mesh_.origin) * mesh_.frame; // transpose(frame) * v
    for (int axis = 0; axis < 3; ++axis) {
        if (mesh_.flat[axis]) point[axis] = 0.0;
    }

    Shares shares;
    const Where where = walk(starts_[startCellOf(point)], point);
    if (where.outside) {
        const HullFaces::Nearest nearest = hull_.nearest(point, mesh_.vertices);
        for (std::size_t i = 0; i < 3; ++i)
            shares[i] = {placeOf(hull_.face(nearest.face).vertex[i]), nearest.weights[i]};
        shares[3] = {shares[0].first, 0.0};
    } else {
        for (std::size_t i = 0; i < 4; ++i)
            shares[i] = {placeOf(mesh_.cells[where.cell].vertex[i]), std::max(where.weights[i], 0.0)};
    }

    weighBySight(shares);

    // Copies of a probe count as one. In the order of probes, so that a sum does not depend on the cell's.
    std::sort(shares.begin(), shares.end());
    double total = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
        total += shares[i].second;
        if (i > 0 && shares[i].first == shares[i - 1].first) {
            shares[i].second += std::exchange(shares[i - 1].second, 0.0);
        }
    }
    for (std::size_t i = 0; i < 4; ++i) {
        result.probes[i] = shares[i].first;
        result.weights[i] = total > 0.0 ? float(shares[i].second / total) : i == 3 ? 1.0f : 0.0f;
    }
    return result;
}

} // namespace halflight
