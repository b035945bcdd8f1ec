#pragma once
// Objects by name.

#include "halflight/scene/scene.h"

#include <cstddef>
#include <string_view>
#include <vector>

namespace halflight {

/// Indices of the objects with a name. A node with instances stands for all of them ("Tree" for "Tree #0", "Tree #1",
/// …), a node without a mesh for the objects below it.
std::vector<std::size_t> objectsNamed(const Scene& scene, std::string_view name);

} // namespace halflight
