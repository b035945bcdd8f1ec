#include "bake_gpu/glass_lists.h"

namespace halflight {

void GlassLists::addTriangle(const RayScene& scene, uint32_t triangle, uint32_t masked,
                             const TransportMaterial& material)
{
    if (!scene.anyTinted()) return;
    numbers.resize(masked + 1, shading::kNone);
    if (!material.tints) return;
    numbers[masked] = uint32_t(triangles.size());
    const BakeGeometry& geometry = scene.geometry();
    const BakeGeometry::Stored stored = geometry.storedOf(triangle);
    const uvec3 corners = geometry.verticesOf(triangle);
    shading::GpuGlassTriangle pane{};
    for (int c = 0; c < 3; ++c)
        pane.colors[c] = geometry.colors.empty() ? vec3(1.0f) : vec3(geometry.colors[corners[c]]);
    pane.normal = geometry.frames[stored.index].normal;
    pane.scale = stored.instance != nullptr ? 1.0f : scene.materials().metersOfThickness(triangle);
    triangles.push_back(pane);
}

shading::GpuGlass glassOf(const TransportMaterial& material)
{
    const Material& source = *material.source;
    shading::GpuGlass glass{};
    glass.base = material.baseColorFactor;
    glass.attenuation = material.attenuation;
    glass.thickness = source.thickness;
    glass.tinted = source.tinted && source.alphaMode == Material::AlphaMode::Blend ? 1u : 0u;
    return glass;
}

} // namespace halflight
