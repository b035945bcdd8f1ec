#include "scene/format/material_sides.h"

namespace halflight {
namespace {

/// Whether a material can be marked.
bool hasPlaceForMark(const Json& material)
{
    return !material.contains("extras") || material["extras"].is_object();
}

/// The material of a sheet's both sides, or of one.
Json sided(Json material, SurfaceSide side)
{
    if (markedSide(material) != SurfaceSide::Both) {
        material["extras"].erase(kSideMark);
        if (material["extras"].empty()) material.erase("extras");
        material["doubleSided"] = true;
    }
    if (side == SurfaceSide::Both) return material;
    material.erase("doubleSided");
    if (hasPlaceForMark(material)) material["extras"][kSideMark] = side == SurfaceSide::Front ? "front" : "back";
    return material;
}

} // namespace

SurfaceSide markedSide(const Json& material)
{
    const Json& mark = member(member(material, "extras"), kSideMark);
    if (!mark.is_string()) return SurfaceSide::Both;
    return mark == "front" ? SurfaceSide::Front : mark == "back" ? SurfaceSide::Back : SurfaceSide::Both;
}

int MaterialSides::of(int material, SurfaceSide side)
{
    if (material < 0) return material;
    const auto [entry, isNew] = found_.try_emplace({material, side}, material);
    if (!isNew) return entry->second;
    const Json& materials = patcher_.json["materials"];
    Json wanted = sided(materials[std::size_t(material)], side);
    if (wanted == materials[std::size_t(material)]) return material;
    for (std::size_t i = 0; i < materials.size(); ++i)
        if (materials[i] == wanted) return entry->second = int(i);
    return entry->second = patcher_.append("materials", std::move(wanted));
}

void MaterialSides::setIn(Json& primitive, SurfaceSide side)
{
    if (primitive.contains("material")) primitive["material"] = of(primitive["material"].get<int>(), side);
    if (!member(member(member(primitive, "extensions"), "KHR_materials_variants"), "mappings").is_array()) return;
    for (Json& mapping : primitive["extensions"]["KHR_materials_variants"]["mappings"]) {
        if (const Json& material = member(mapping, "material"); material.is_number_integer())
            mapping["material"] = of(material.get<int>(), side);
    }
}

} // namespace halflight
