#pragma once
// Cutting smooth pieces of a mesh along planes.

#include "unwrap/surface/surface.h"

#include <span>

namespace halflight::charts {

/// By triangle of a surface, the number of its smooth piece: triangles connected by edges that bend by less than 30
/// degrees. kNone for degenerate triangles.
std::vector<uint32_t> smoothPieces(const Surface& surface);

/// A plane, and points of a smooth piece where it has to be cut. World space, metres.
struct PlaneCut {
    uint32_t piece = 0; ///< of smoothPieces()
    dvec3 normal{0.0};  ///< unit
    double offset = 0.0;
    std::vector<dvec3> points;
};

/// Cuts the mesh of an object, whose surface and pieces are given, along planes, one after the other. A plane cuts all
/// of a piece, or that part of it which earlier cuts have left and one of the points lies in. Vertices nearer to a
/// plane than `tolerance` metres count as on it. No edge ends inside another one: a triangle beyond the piece that
/// shares a divided edge is divided too. Attributes of new vertices are interpolated (MeshPart::cutVertices).
///
/// Returns, by triangle of the new mesh, the number of its part of the surface: triangles of different numbers must not
/// share a chart; 0 = never cut. Empty when nothing was cut. `cuts` counts the planes that cut.
std::vector<uint32_t> cutMesh(Mesh& mesh, const Surface& surface, std::span<const uint32_t> pieces,
                              const glm::dmat4& worldFromObject, const std::vector<PlaneCut>& planes, double tolerance,
                              int& cuts);

} // namespace halflight::charts
