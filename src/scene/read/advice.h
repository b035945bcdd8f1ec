#pragma once
// What makes files disappoint though nothing in them is wrong, with the cure.

#include "scene/document/document.h"
#include "scene/read/geometry/animation.h"

namespace halflight {

/// Warnings about a scene as read: a file of Blender's without lights, a room that seems to be in centimetres.
/// `skyAuthored`: the file or its settings give a sky.
std::vector<std::string> adviceFor(const Scene& scene, const Json& document, bool skyAuthored);

/// Warns of materials that an animation changes and that static objects have: their light in the bake does not change.
void warnAnimatedMaterials(const AnimatedThings& animated, Scene& scene);

} // namespace halflight
