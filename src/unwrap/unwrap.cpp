#include "halflight/unwrap/unwrap.h"

#include "halflight/base/parallel.h"
#include "unwrap/pages.h"
#include "unwrap/split.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <optional>

namespace halflight {
namespace {

using namespace charts;

Error cancelledError()
{
    return {ErrorCode::Cancelled, "unwrapping was cancelled", ""};
}

Status checkSettings(const UnwrapSettings& settings)
{
    const auto fail = [](std::string message) { return Error{ErrorCode::InvalidArgument, std::move(message), ""}; };
    if (settings.pageSize < 64 || settings.pageSize > 8192) {
        return fail(fmt::format("a lightmap page has 64 to 8192 texels on a side, not {}", settings.pageSize));
    }
    if (settings.paddingTexels < 1 || settings.paddingTexels > 16) {
        return fail(fmt::format("padding is 1 to 16 texels, not {}", settings.paddingTexels));
    }
    if (!(settings.texelsPerMeter >= 0.0f) || !std::isfinite(settings.texelsPerMeter)) {
        return fail("texels per metre must be positive, or 0 to fit one page");
    }
    return {};
}

/// Surfaces of all groups, and TEXCOORD_1 where it may stay.
Status measureGroups(const Scene& scene, const UnwrapSettings& settings, std::vector<GroupLayout>& groups,
                     std::vector<Surface>& surfaces, const Progress& progress)
{
    surfaces.resize(groups.size());
    const bool complete = parallelFor(groups.size(), 1, progress, "measure", [&](std::size_t begin, std::size_t end) {
        for (std::size_t g = begin; g < end; ++g) {
            const Mesh& mesh = scene.meshes[std::size_t(groups[g].group.mesh)];
            surfaces[g] = buildSurface(mesh, groups[g].group.worldFromObject);
            groups[g].triangleCount = surfaces[g].triangleCount();
            if (settings.uvMode == UvMode::Unwrap || !hasAuthoredLayout(mesh)) continue;
            auto authored = std::make_unique<AuthoredLayout>(readAuthoredLayout(mesh, surfaces[g]));
            groups[g].reason = authored->fault;
            if (authored->fault.empty()) groups[g].authored = std::move(authored);
        }
    });
    if (!complete) return cancelledError();
    if (settings.uvMode == UvMode::Keep) {
        for (const GroupLayout& group : groups) {
            if (group.reason.empty()) continue;
            return Error{ErrorCode::FileInvalid, "TEXCOORD_1 cannot be kept: " + group.reason,
                         fmt::format("/meshes/{}", scene.meshes[std::size_t(group.group.mesh)].sourceMesh)};
        }
    }
    return {};
}

bool makeLayouts(std::vector<GroupLayout>& groups, const std::vector<Surface>& surfaces, const UnwrapSettings& settings,
                 const Progress& progress)
{
    // The texel's size to come, as if charts filled two thirds of the page.
    double texelMeters = 0.0;
    if (settings.texelsPerMeter > 0.0f) {
        texelMeters = 1.0 / double(settings.texelsPerMeter);
    } else {
        double area = 0.0;
        for (std::size_t g = 0; g < groups.size(); ++g) {
            double own = 0.0;
            for (const double a : surfaces[g].areas) own += a;
            area += own * double(groups[g].group.objects.size());
        }
        texelMeters = std::sqrt(area / 0.66) / double(settings.pageSize);
    }
    return parallelFor(groups.size(), 1, progress, "charts", [&](std::size_t begin, std::size_t end) {
        for (std::size_t g = begin; g < end; ++g) {
            if (!groups[g].authored && groups[g].layout.charts.empty()) {
                groups[g].layout = makeLayout(surfaces[g], texelMeters, progress);
            }
        }
    });
}

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

std::string nameOf(const Scene& scene, const GroupLayout& group)
{
    const Mesh& mesh = scene.meshes[std::size_t(group.group.mesh)];
    return mesh.name.empty() ? fmt::format("mesh {}", group.group.mesh) : fmt::format("mesh \"{}\"", mesh.name);
}

/// The file's own atlas: when every object has a layout of its own in TEXCOORD_1 and they do not overlap one another,
/// the uv square is the page as it stands. Its size is pageSize, or what the asked density makes it.
std::optional<Pages> keepAtlas(const std::vector<GroupLayout>& groups, const UnwrapSettings& settings, int& pageSize,
                               std::vector<std::string>& warnings)
{
    std::vector<const AuthoredLayout*> layouts;
    double worldArea = 0.0, uvArea = 0.0;
    for (const GroupLayout& group : groups) {
        if (!group.authored || group.group.objects.size() != 1) return std::nullopt;
        layouts.push_back(group.authored.get());
        worldArea += group.authored->worldArea;
        uvArea += group.authored->uvArea;
    }
    if (layoutsOverlap(layouts)) return std::nullopt;
    const double texelsPerMeterOfPage = std::sqrt(uvArea / worldArea); // for a page of one texel
    int size = settings.pageSize;
    if (settings.texelsPerMeter > 0.0f) {
        const double wanted = double(settings.texelsPerMeter) / texelsPerMeterOfPage;
        size = int(std::clamp(4.0 * std::ceil(wanted / 4.0), 64.0, 8192.0));
        if (wanted > 8192.0)
            warnings.push_back("the file's lightmap atlas would need more than 8192 texels for the asked density");
    }
    if (chartsTooClose(layouts, double(size), settings.paddingTexels)) {
        if (settings.uvMode == UvMode::Auto) return std::nullopt;
        warnings.push_back(
            fmt::format("charts of TEXCOORD_1 come closer than {} texels to one another on a page of {} texels",
                        settings.paddingTexels, size));
    }
    pageSize = size;
    Pages pages;
    pages.pageCount = 1;
    pages.texelsPerMeter = texelsPerMeterOfPage * double(size);
    for (const AuthoredLayout* layout : layouts) {
        GroupRaster& raster = pages.rasters.emplace_back();
        raster.texelsPerUnit = double(size);
        raster.whole = rasterizeLayout(*layout, double(size), ivec2(0), ivec2(size));
        pages.placements.emplace_back(1).front().page = 0;
        pages.coveredTexels += raster.whole.count();
        pages.reservedTexels += raster.whole.dilated(settings.paddingTexels / 2).count();
    }
    return pages;
}

/// Takes TEXCOORD_1 away from groups whose charts would come too close at the density reached; only warns where the
/// caller insists on it. Returns whether any lost it.
bool dropCrowdedLayouts(const Scene& scene, std::vector<GroupLayout>& groups, const Pages& pages,
                        const UnwrapSettings& settings, std::vector<std::string>& warnings)
{
    bool dropped = false;
    for (std::size_t g = 0; g < groups.size(); ++g) {
        if (!groups[g].authored) continue;
        const AuthoredLayout* const layout = groups[g].authored.get();
        if (!chartsTooClose({&layout, 1}, pages.rasters[g].texelsPerUnit, settings.paddingTexels)) continue;
        const std::string reason =
            fmt::format("charts of TEXCOORD_1 come closer than {} texels to one another at {:.4g} texels per metre",
                        settings.paddingTexels, pages.texelsPerMeter);
        if (settings.uvMode == UvMode::Keep) {
            warnings.push_back(fmt::format("{}: {}", nameOf(scene, groups[g]), reason));
            continue;
        }
        groups[g].reason = reason;
        groups[g].authored.reset();
        dropped = true;
    }
    return dropped;
}

/// Writes coordinates and bindings. A group that is not the first of its mesh gets a copy of it.
void writeGroups(UnwrappedScene& result, std::vector<GroupLayout>& groups, const std::vector<Surface>& surfaces,
                 const Pages& pages, int pageSize)
{
    Scene& scene = result.scene;
    std::vector<char> taken(scene.meshes.size(), 0);
    std::vector<std::size_t> ownMesh(groups.size());
    for (std::size_t g = 0; g < groups.size(); ++g) {
        const auto source = std::size_t(groups[g].group.mesh);
        ownMesh[g] = source;
        if (groups[g].authored) continue;
        if (taken[source] != 0) {
            ownMesh[g] = scene.meshes.size();
            scene.meshes.push_back(Mesh(scene.meshes[source]));
            for (const int object : groups[g].group.objects) scene.objects[std::size_t(object)].mesh = int(ownMesh[g]);
            // A node has one mesh, so instances without texels come along.
            const Object& first = scene.objects[std::size_t(groups[g].group.objects[0])];
            for (Object& object : scene.objects) {
                if (first.sourceInstance < 0) break;
                if (object.sourceNode == first.sourceNode && object.mesh == int(source)) object.mesh = int(ownMesh[g]);
            }
        }
        taken[source] = 1;
    }
    // Copies are made before any mesh is changed, so that all of them are of the source.
    parallelFor(groups.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t g = begin; g < end; ++g) {
            if (groups[g].authored) continue;
            const bool loose = groups[g].loose();
            const GroupRaster& raster = pages.rasters[g];
            const std::vector<Placement>& places = loose ? pages.placements[g] : raster.block.placements;
            const double size = loose ? pageSize : std::max(raster.block.size.x, raster.block.size.y);
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
            part.lightmapTexCoord = texCoord;
        }
        for (std::size_t i = 0; i < group.group.objects.size(); ++i) {
            LightmapBinding& binding = scene.objects[std::size_t(group.group.objects[i])].lightmap;
            const Placement& place = pages.placements[g][group.loose() ? 0 : i];
            binding.page = place.page;
            if (group.loose()) continue;
            if (group.authored) {
                binding.scale = vec2(float(raster.texelsPerUnit / pageSize));
                binding.offset = vec2(dvec2(place.at - raster.authoredCorner) / double(pageSize));
            } else {
                binding.scale = vec2(float(double(std::max(raster.block.size.x, raster.block.size.y)) / pageSize));
                binding.offset = vec2(dvec2(place.at) / double(pageSize));
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

} // namespace

Result<UnwrappedScene> unwrap(Scene scene, const UnwrapSettings& settings, const Progress& progress)
{
    if (const Status status = checkSettings(settings); !status) return status.error();
    UnwrappedScene result;
    result.scene = std::move(scene);
    result.pageSize = settings.pageSize;
    for (Object& object : result.scene.objects) object.lightmap = {};

    std::vector<GroupLayout> groups;
    for (LayoutGroup& group : groupObjects(result.scene, result.warnings))
        groups.emplace_back().group = std::move(group);
    if (groups.empty()) return result;
    std::vector<Surface> surfaces;
    if (const Status status = measureGroups(result.scene, settings, groups, surfaces, progress); !status)
        return status.error();
    const PageSettings pageSettings{settings.pageSize, settings.paddingTexels, double(settings.texelsPerMeter)};
    std::optional<Pages> pages = keepAtlas(groups, settings, result.pageSize, result.warnings);
    while (!pages) {
        if (!makeLayouts(groups, surfaces, settings, progress)) return cancelledError();
        const std::size_t warningsBefore = result.warnings.size();
        Result<Pages> placed = placeOnPages(groups, pageSettings, result.warnings, progress);
        if (progress.cancelled()) return cancelledError();
        if (!placed) return placed.error();
        pages = std::move(*placed);
        if (!dropCrowdedLayouts(result.scene, groups, *pages, settings, result.warnings)) break;
        result.warnings.resize(warningsBefore);
        pages.reset();
    }
    writeGroups(result, groups, surfaces, *pages, result.pageSize);
    result.pageCount = pages->pageCount;
    result.texelsPerMeter = float(pages->texelsPerMeter);
    const double texels = double(result.pageSize) * result.pageSize * pages->pageCount;
    result.coverage = float(double(pages->coveredTexels) / texels);
    result.coverageWithPadding = float(double(pages->reservedTexels) / texels);
    progress("pack", 1.0);
    return result;
}

} // namespace halflight
