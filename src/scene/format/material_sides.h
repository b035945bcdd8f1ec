#pragma once
// Materials of the halves of double-sided sheets (SurfaceSide): single-sided copies of the sheets' materials, with a
// mark in their extras, which tools keep that drop unknown extensions.

#include "scene/document/patcher.h"

#include "halflight/scene/scene.h"

#include <map>
#include <string>
#include <utility>

namespace halflight {

/// Key of a material's extras: "front" or "back".
constexpr const char* kSideMark = "halflight_side";

/// The side that a material of a file is marked with; Both without a mark.
SurfaceSide markedSide(const Json& material);

/// Finds or adds the copies of a document's materials.
class MaterialSides {
public:
    explicit MaterialSides(DocumentPatcher& patcher) : patcher_(patcher) {}

    /// The material in place of `material`, marked or not, for a part of a side: itself where it serves, or a copy.
    int of(int material, SurfaceSide side);
    /// The same in a primitive, for all of its variants too.
    void setIn(Json& primitive, SurfaceSide side);

private:
    DocumentPatcher& patcher_;
    std::map<std::pair<int, SurfaceSide>, int> found_;
};

} // namespace halflight
