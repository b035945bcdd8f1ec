#pragma once
// Attributes of the vertices that cutting a mesh added (MeshPart::cutVertices).

#include "scene/document/document.h"

#include <span>

namespace halflight {

/// How an attribute continues between two vertices. Linear: as stored, rounded where it is of integers. Direction:
/// linear, with x, y, z scaled to the length of the ends, the fourth component that of the nearer end. Nearest: that of
/// the nearer end.
enum class Between { Linear, Direction, Nearest };

/// NORMAL and TANGENT are directions. JOINTS_n are numbers of joints, and an attribute with an underscore can be
/// anything; both are those of the nearer end.
Between betweenOf(const std::string& attribute);

/// The elements of an accessor for the cut vertices of a part, bytesPerElement each.
std::vector<std::byte> cutElements(const AccessorView& view, std::span<const CutVertex> cut, Between between);

/// Negates an element of a signed component type; the least integer becomes the largest.
void negateElement(std::byte* element, int componentType, int components);

} // namespace halflight
