#pragma once
// What makes files disappoint though nothing in them is wrong, with the cure.

#include "scene/document/document.h"

namespace halflight {

/// Warnings about a scene as read: a file of Blender's without lights, a room that seems to be in centimetres.
/// `skyAuthored`: the file or its settings give a sky.
std::vector<std::string> adviceFor(const Scene& scene, const Json& document, bool skyAuthored);

} // namespace halflight
