#include "unwrap/result/assign.h"

#include "halflight/base/parallel.h"
#include "unwrap/surface/split.h"

#include <algorithm>
#include <set>
#include <span>

namespace halflight::charts {
namespace {

/// Page or layout coordinates of every corner of the group's triangles; `places` are those of its charts, on a
/// rectangle of the given size.
std::vector<vec2> cornerCoordinates(const GroupLayout& group, const GroupRaster& raster, const Surface& surface,
                                    const std::vector<Placement>& places, double size)
{
    const auto toUv = [&](std::size_t chart, dvec2 metres) {
        const Footprint& footprint = raster.charts[chart];
        const dvec2 inside = raster.chartOrigin[chart] + metres * raster.texelsPerUnit;
        const dvec2 laid = oriented(inside, {footprint.width(), footprint.height()}, places[chart].orientation);
        return vec2((laid + dvec2(places[chart].at)) / size);
    };
    std::vector<vec2> uv(3 * surface.triangleCount());
    std::vector<vec2> pointOfVertex(surface.positions.size(), vec2(-1.0f));
    for (std::size_t c = 0; c < group.layout.charts.size(); ++c) {
        const Chart& chart = group.layout.charts[c];
        for (std::size_t i = 0; i < chart.corners.size(); ++i) {
            const uint32_t triangle = chart.triangles[i / 3];
            const vec2 point = toUv(c, chart.uv[chart.corners[i]]);
            uv[3 * triangle + i % 3] = point;
            vec2& known = pointOfVertex[surface.triangles[triangle][int(i % 3)]];
            if (known.x < 0.0f) known = point;
        }
    }
    // Triangles without area shrink to a point of a chart they touch, or of any chart.
    const vec2 anywhere = toUv(0, group.layout.charts.empty() ? dvec2(0.0) : group.layout.charts[0].uv[0]);
    for (std::size_t t = 0; t < surface.triangleCount(); ++t) {
        if (!surface.degenerate(t)) continue;
        vec2 point = anywhere;
        for (int k = 2; k >= 0; --k) {
            const vec2 known = pointOfVertex[surface.triangles[t][k]];
            if (known.x >= 0.0f) point = known;
        }
        for (std::size_t k = 0; k < 3; ++k) uv[3 * t + k] = point;
    }
    return uv;
}

void assignMesh(Mesh& mesh, const std::vector<vec2>& cornerUv)
{
    std::size_t first = 0;
    for (MeshPart& part : mesh.parts) {
        assignLightmapUv(part, std::span(cornerUv).subspan(first, part.indices.size()));
        first += part.indices.size();
    }
}

/// Lets a group's objects have a copy of their mesh. A node has one mesh, so its instances without texels come along.
void moveObjects(Scene& scene, const LayoutGroup& group, std::size_t mesh)
{
    std::set<int> instancedNodes;
    for (const int o : group.objects) {
        Object& object = scene.objects[std::size_t(o)];
        object.mesh = int(mesh);
        if (object.sourceInstance >= 0) instancedNodes.insert(object.sourceNode);
    }
    if (instancedNodes.empty()) return;
    for (Object& object : scene.objects) {
        if (object.sourceInstance >= 0 && object.mesh == group.mesh && instancedNodes.contains(object.sourceNode))
            object.mesh = int(mesh);
    }
}

/// The mesh whose coordinates are each group's. Copies are made here, before any mesh is changed.
std::vector<std::size_t> ownMeshes(Scene& scene, const std::vector<GroupLayout>& groups)
{
    constexpr std::size_t kNoMesh = ~std::size_t(0);
    std::vector<std::size_t> keptMesh(scene.meshes.size(), kNoMesh); // by source mesh
    std::vector<char> taken(scene.meshes.size(), 0);
    std::vector<std::size_t> own(groups.size());
    for (std::size_t g = 0; g < groups.size(); ++g) {
        const auto source = std::size_t(groups[g].group.mesh);
        const bool kept = groups[g].authored != nullptr;
        if (kept && keptMesh[source] != kNoMesh) {
            own[g] = keptMesh[source];
        } else if (taken[source] == 0) {
            own[g] = source;
        } else {
            own[g] = scene.meshes.size();
            scene.meshes.push_back(Mesh(scene.meshes[source]));
        }
        taken[source] = 1;
        if (kept) keptMesh[source] = own[g];
        if (own[g] != source) moveObjects(scene, groups[g].group, own[g]);
    }
    return own;
}

} // namespace

void writeGroups(UnwrappedScene& result, const std::vector<GroupLayout>& groups, const std::vector<Surface>& surfaces,
                 const Pages& pages)
{
    Scene& scene = result.scene;
    const std::vector<std::size_t> ownMesh = ownMeshes(scene, groups);
    parallelFor(groups.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t g = begin; g < end; ++g) {
            if (groups[g].authored) continue;
            const bool loose = groups[g].loose();
            const GroupRaster& raster = pages.rasters[g];
            const std::vector<Placement>& places = loose ? pages.placements[g] : raster.block.placements;
            const double size = loose ? result.pageSize : std::max(raster.block.size.x, raster.block.size.y);
            assignMesh(scene.meshes[ownMesh[g]], cornerCoordinates(groups[g], raster, surfaces[g], places, size));
        }
    });
    for (std::size_t g = 0; g < groups.size(); ++g) {
        const GroupLayout& group = groups[g];
        const GroupRaster& raster = pages.rasters[g];
        Mesh& mesh = scene.meshes[ownMesh[g]];
        const int texCoord = group.authored ? 1 : freeTexCoord(scene, mesh);
        for (MeshPart& part : mesh.parts) {
            if (group.authored) part.lightmapUv = part.uv[1];
            part.lightmapUv.resize(part.positions.size()); // parts without triangles may come without TEXCOORD_1
            part.lightmapTexCoord = texCoord;
        }
        for (std::size_t i = 0; i < group.group.objects.size(); ++i) {
            LightmapBinding& binding = scene.objects[std::size_t(group.group.objects[i])].lightmap;
            const Placement& place = pages.placements[g][group.loose() ? 0 : i];
            binding.page = place.page;
            if (group.loose()) continue;
            if (group.authored) {
                binding.scale = vec2(float(raster.texelsPerUnit / result.pageSize));
                binding.offset = vec2(dvec2(place.at - raster.authoredCorner) / double(result.pageSize));
            } else {
                binding.scale =
                    vec2(float(double(std::max(raster.block.size.x, raster.block.size.y)) / result.pageSize));
                binding.offset = vec2(dvec2(place.at) / double(result.pageSize));
            }
        }
        MeshUnwrapReport report;
        report.mesh = int(ownMesh[g]);
        report.kept = group.authored != nullptr;
        report.reason = group.reason;
        report.charts = group.authored ? int(group.authored->chartCount)
                                       : int(std::max<std::size_t>(group.layout.charts.size(), 1));
        report.areaStretch = float(group.authored ? group.authored->stretch : group.layout.stretch());
        result.chartCount += report.charts * int(group.group.objects.size());
        result.meshes.push_back(std::move(report));
    }
}

} // namespace halflight::charts
