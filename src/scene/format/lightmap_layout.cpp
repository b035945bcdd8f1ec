#include "scene/format/lightmap_layout.h"

#include "scene/document/texture_coordinates.h"

#include <algorithm>

namespace halflight {

vec2 FileLayout::coordinate(vec2 uv) const
{
    return scale == vec2(1.0f) && offset == vec2(0.0f) ? uv : glm::clamp(scale * uv + offset, 0.0f, 1.0f);
}

// So that binding(b).scale * coordinate(uv) + binding(b).offset = b.scale * uv + b.offset.
LightmapBinding FileLayout::binding(LightmapBinding binding) const
{
    binding.scale /= scale;
    binding.offset -= binding.scale * offset;
    return binding;
}

namespace {

struct MeshUse {
    std::size_t objects = 0;
    const Object* only = nullptr;
};

bool texturesReadIt(const Scene& scene, const Mesh& mesh, const SourceDocument& source)
{
    return std::any_of(mesh.parts.begin(), mesh.parts.end(), [&](const MeshPart& part) {
        return readsTexCoord(element(source.json, "materials", sourceMaterialOf(scene, part)), part.lightmapTexCoord);
    });
}

FileLayout layoutOf(const Mesh& mesh, const MeshUse& use)
{
    vec2 low(kInfinity);
    vec2 high(-kInfinity);
    for (const MeshPart& part : mesh.parts) {
        if (part.lightmapUv.size() != part.positions.size()) return {}; // the writer refuses it
        for (const uint32_t index : part.indices) {                     // vertices of no triangle may be anywhere
            low = glm::min(low, part.lightmapUv[index]);
            high = glm::max(high, part.lightmapUv[index]);
        }
    }
    FileLayout layout;
    if (!glm::all(glm::lessThan(low, high))) return layout;
    if (use.objects == 1 && use.only->sourceInstance < 0) {
        const LightmapBinding& binding = use.only->lightmap;
        const vec2 first = binding.scale * low + binding.offset;
        const vec2 last = binding.scale * high + binding.offset;
        const bool onPage = glm::all(glm::greaterThan(binding.scale, vec2(0.0f))) &&
                            glm::all(glm::greaterThanEqual(first, vec2(0.0f))) &&
                            glm::all(glm::lessThanEqual(last, vec2(1.0f)));
        return onPage ? FileLayout{binding.scale, binding.offset} : layout;
    }
    layout.scale = 1.0f / (high - low);
    layout.offset = -low * layout.scale;
    return layout;
}

} // namespace

std::vector<FileLayout> fileLayouts(const Scene& scene, const SourceDocument& source)
{
    std::vector<MeshUse> uses(scene.meshes.size());
    for (const Object& object : scene.objects) {
        if (object.mesh < 0 || object.lightmap.page < 0) continue;
        MeshUse& use = uses[std::size_t(object.mesh)];
        ++use.objects;
        use.only = &object;
    }
    std::vector<FileLayout> layouts(scene.meshes.size());
    for (std::size_t m = 0; m < layouts.size(); ++m) {
        if (uses[m].objects > 0 && !texturesReadIt(scene, scene.meshes[m], source))
            layouts[m] = layoutOf(scene.meshes[m], uses[m]);
    }
    return layouts;
}

namespace {

// Scale of the node's rectangles, which all have one shape; zero where there is none.
vec2 rectangleScale(const SourceDocument& document, const Json& node)
{
    const Json& lightmap = member(extensionOf(node, "HALFLIGHT_node"), "lightmap");
    if (const Json& scale = member(lightmap, "scale"); scale.is_array() && scale.size() == 2) {
        if (scale[0].is_number() && scale[1].is_number()) return {scale[0].get<float>(), scale[1].get<float>()};
    }
    const Json& attributes = member(extensionOf(node, "EXT_mesh_gpu_instancing"), "attributes");
    const Json& accessor = member(attributes, "_HALFLIGHT_LIGHTMAP_ST");
    if (lightmap.is_null() || !isIndexInto(document.json, "accessors", accessor)) return vec2(0.0f);
    const auto rectangles = readVectors<4>(document, accessor.get<int>());
    if (!rectangles) return vec2(0.0f);
    for (const vec4& rectangle : *rectangles) {
        if (rectangle.x > 0.0f && rectangle.y > 0.0f) return vec2(rectangle);
    }
    return vec2(0.0f);
}

} // namespace

std::map<int, vec2> stretchedLayouts(const SourceDocument& document)
{
    std::map<int, vec2> texels;
    for (const Json& node : member(document.json, "nodes")) {
        const Json& mesh = member(node, "mesh");
        if (!mesh.is_number_unsigned()) continue;
        const vec2 scale = rectangleScale(document, node);
        if (scale.x > 0.0f && scale.y > 0.0f && scale.x != scale.y)
            texels[mesh.get<int>()] = scale / std::max(scale.x, scale.y);
    }
    return texels;
}

} // namespace halflight
