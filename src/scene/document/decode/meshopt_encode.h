#pragma once
// The encoders of meshoptimizer: vertex attributes and triangles of a finished document.

#include "scene/document/patcher.h"

#include <span>
#include <vector>

namespace halflight {

/// Whether this build has meshoptimizer.
bool encodesMeshopt();

/// Triangles in an order that the vertex cache and the codec like, and for each vertex its new place; ~0 = not used.
struct VertexOrder {
    std::vector<uint32_t> indices;
    std::vector<uint32_t> remap;
    std::size_t vertexCount = 0;
};
VertexOrder orderForMeshopt(std::vector<uint32_t> indices, std::size_t vertexCount, bool moveVertices);

/// Floats that a decoder gets back from the filter with mantissas of so many bits, `components` sharing an exponent.
void roundToExponential(std::vector<float>& values, int components, int bits);

/// Member of a new accessor that compressDocument() takes out again: {filter, bits}.
constexpr const char* kMeshoptPlan = "halflightMeshopt";

/// Compresses what buffer views hold of accessors: what is alike becomes one view. By the accessors' members
/// kMeshoptPlan: EXPONENTIAL for floats, OCTAHEDRAL for normals and tangents that are still four floats each. Numbers
/// of buffer views change, so extensions that this program does not know must not refer to any.
void compressDocument(FinishedDocument& document);

} // namespace halflight
