#include "halflight/unwrap/unwrap.h"

#include "halflight/base/parallel.h"
#include "unwrap/cuts/cut_scene.h"
#include "unwrap/cuts/sheets.h"
#include "unwrap/pack/pages.h"
#include "unwrap/result/assign.h"
#include "unwrap/result/shared_texels.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <optional>

namespace halflight {
namespace {

using namespace charts;

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
    if (!(settings.mostTexelsPerMeter >= 0.0f) || !std::isfinite(settings.mostTexelsPerMeter)) {
        return fail("the most texels per metre must be positive, or 0 for no limit");
    }
    return {};
}

/// Surfaces of all groups, and TEXCOORD_1 where it may stay.
Status measureGroups(const Scene& scene, const UnwrapSettings& settings, const SceneCuts& cuts,
                     std::vector<GroupLayout>& groups, std::vector<Surface>& surfaces, const Progress& progress)
{
    surfaces.resize(groups.size());
    const bool complete = parallelFor(groups.size(), 1, progress, "measure", [&](std::size_t begin, std::size_t end) {
        for (std::size_t g = begin; g < end; ++g) {
            const Mesh& mesh = scene.meshes[std::size_t(groups[g].group.mesh)];
            surfaces[g] = buildSurface(mesh, groups[g].group.worldFromObject, cuts.of(groups[g].group.mesh),
                                       cuts.texelWidthsOf(groups[g].group.mesh));
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

/// The texel's size to come, as if charts filled two thirds of the page, and not smaller than the limit.
double texelMetersToCome(const std::vector<GroupLayout>& groups, const std::vector<Surface>& surfaces,
                         const UnwrapSettings& settings)
{
    if (settings.texelsPerMeter > 0.0f) return 1.0 / double(settings.texelsPerMeter);
    double area = 0.0;
    for (std::size_t g = 0; g < groups.size(); ++g) {
        double own = 0.0;
        for (const double a : surfaces[g].areas) own += a;
        area += own * double(groups[g].group.objects.size());
    }
    const double texelMeters = std::sqrt(area / 0.66) / double(settings.pageSize);
    return settings.mostTexelsPerMeter > 0.0f ? std::max(texelMeters, 1.0 / double(settings.mostTexelsPerMeter))
                                              : texelMeters;
}

/// By mesh, 1 where a group keeps the file's TEXCOORD_1.
std::vector<uint8_t> keptMeshes(const Scene& scene, const std::vector<GroupLayout>& groups)
{
    std::vector<uint8_t> kept(scene.meshes.size(), 0);
    for (const GroupLayout& group : groups) kept[std::size_t(group.group.mesh)] |= group.authored ? 1 : 0;
    return kept;
}

/// Groups of the scene's objects, with their surfaces; where tests are given, after meshes are cut and sheets doubled.
Status prepareGroups(UnwrappedScene& result, const UnwrapSettings& settings, const CrossingTest& crossingTest,
                     const SheetTest& sheetTest, std::vector<GroupLayout>& groups, std::vector<Surface>& surfaces,
                     const Progress& progress)
{
    SceneCuts cuts;
    std::vector<std::string> warnings;
    const auto measure = [&] {
        warnings.clear();
        groups.clear();
        for (LayoutGroup& group : groupObjects(result.scene, warnings)) groups.emplace_back().group = std::move(group);
        return measureGroups(result.scene, settings, cuts, groups, surfaces, progress);
    };
    if (const Status status = measure(); !status) return status;
    const double texelMeters = groups.empty() ? 0.0 : texelMetersToCome(groups, surfaces, settings);
    bool changed = false;
    if (crossingTest && texelMeters > 0.0) {
        cuts = cutScene(result.scene, groups, surfaces, texelMeters, crossingTest, result.warnings);
        result.cuts = cuts.count;
        changed = cuts.count > 0;
    }
    if (sheetTest && texelMeters > 0.0) {
        std::vector<uint8_t> kept = keptMeshes(result.scene, groups);
        kept.resize(result.scene.meshes.size(), 0); // meshes with cuts have new layouts
        changed |= doubleSheets(result.scene, sheetTest(result.scene, texelMeters), kept, cuts, result.warnings);
    }
    if (changed)
        if (const Status status = measure(); !status) return status;
    result.warnings.insert(result.warnings.end(), warnings.begin(), warnings.end());
    return {};
}

bool makeLayouts(std::vector<GroupLayout>& groups, const std::vector<Surface>& surfaces, const UnwrapSettings& settings,
                 const Progress& progress)
{
    const double texelMeters = texelMetersToCome(groups, surfaces, settings);
    return parallelFor(groups.size(), 1, progress, "charts", [&](std::size_t begin, std::size_t end) {
        for (std::size_t g = begin; g < end; ++g) {
            if (!groups[g].authored && groups[g].layout.charts.empty()) {
                groups[g].layout = makeLayout(surfaces[g], texelMeters, progress);
            }
        }
    });
}

std::string nameOf(const Scene& scene, const GroupLayout& group)
{
    const Mesh& mesh = scene.meshes[std::size_t(group.group.mesh)];
    return mesh.name.empty() ? fmt::format("mesh {}", group.group.mesh) : fmt::format("mesh \"{}\"", mesh.name);
}

/// The file's own atlas: when every object has a layout of its own in TEXCOORD_1 and no two share a texel, the uv
/// square is the page as it stands. Its size is pageSize, or what the asked density makes it.
std::optional<Pages> keepAtlas(const std::vector<GroupLayout>& groups, const UnwrapSettings& settings,
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
    const double texelsPerMeterOfPage = std::sqrt(uvArea / worldArea); // for a page of one texel
    const auto pageFor = [&](double density) { return roundedUpToBlocks(density / texelsPerMeterOfPage); };
    int size = settings.pageSize;
    DensityFrom from = DensityFrom::Page;
    if (settings.texelsPerMeter > 0.0f) {
        const double wanted = double(settings.texelsPerMeter) / texelsPerMeterOfPage;
        size = int(std::clamp(4.0 * std::ceil(wanted / 4.0), double(settings.cutPage ? kLeastCutPage : 64), 8192.0));
        from = DensityFrom::Asked;
        if (wanted > 8192.0)
            warnings.push_back("the file's lightmap atlas would need more than 8192 texels for the asked density");
    } else if (settings.cutPage && double(settings.mostTexelsPerMeter) > 0.0 &&
               double(settings.mostTexelsPerMeter) / texelsPerMeterOfPage < settings.pageSize - 4) {
        // The smallest page from there on that keeps the charts apart: authors leave gaps for the page they think of.
        size = std::max(pageFor(double(settings.mostTexelsPerMeter)), kLeastCutPage);
        from = DensityFrom::Scene;
        while (size < settings.pageSize && chartsTooClose(layouts, double(size), settings.paddingTexels))
            size = std::min(roundedUpToBlocks(1.25 * size), settings.pageSize);
    }
    if (layoutsShareTexel(layouts, size)) return std::nullopt;
    if (chartsTooClose(layouts, double(size), settings.paddingTexels)) {
        if (settings.uvMode == UvMode::Auto) return std::nullopt;
        warnings.push_back(
            fmt::format("charts of TEXCOORD_1 come closer than {} texels to one another on a page of {} texels",
                        settings.paddingTexels, size));
    }
    Pages pages;
    pages.densityFrom = from;
    pages.pageSize = size;
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

/// Texels per uv unit up to which float coordinates tell the places of texels apart: an error of 2^-23 of the unit is a
/// 256th of a texel then, and kRasterMargin is four of those.
constexpr double kMostTexelsPerUnit = 32768.0;

/// Why a layout cannot serve at the density reached; empty when it can.
std::string faultAtDensity(const AuthoredLayout& layout, double texelsPerUnit, double texelsPerMeter, int padding)
{
    if (texelsPerUnit > kMostTexelsPerUnit) {
        return fmt::format("TEXCOORD_1 takes so small a part of [0,1] that float coordinates do not tell its texels "
                           "apart at {:.4g} texels per metre",
                           texelsPerMeter);
    }
    const AuthoredLayout* const one = &layout;
    if (!chartsTooClose({&one, 1}, texelsPerUnit, padding)) return {};
    return fmt::format("charts of TEXCOORD_1 come closer than {} texels to one another at {:.4g} texels per metre",
                       padding, texelsPerMeter);
}

/// Takes TEXCOORD_1 away from groups whose layouts cannot serve at the density reached; only warns where the caller
/// insists on it and no other object suffers. Returns whether any lost it.
Result<bool> dropUnfitLayouts(const Scene& scene, std::vector<GroupLayout>& groups, const Pages& pages,
                              const UnwrapSettings& settings, std::vector<std::string>& warnings)
{
    bool dropped = false;
    for (std::size_t g = 0; g < groups.size(); ++g) {
        if (!groups[g].authored) continue;
        const double texelsPerUnit = pages.rasters[g].texelsPerUnit;
        const std::string fault =
            faultAtDensity(*groups[g].authored, texelsPerUnit, pages.texelsPerMeter, settings.paddingTexels);
        if (fault.empty()) continue;
        if (settings.uvMode == UvMode::Keep) {
            if (texelsPerUnit > kMostTexelsPerUnit) {
                return Error{ErrorCode::FileInvalid, "TEXCOORD_1 cannot be kept: " + fault,
                             fmt::format("/meshes/{}", scene.meshes[std::size_t(groups[g].group.mesh)].sourceMesh)};
            }
            warnings.push_back(fmt::format("{}: {}", nameOf(scene, groups[g]), fault));
            continue;
        }
        groups[g].reason = fault;
        groups[g].authored.reset();
        dropped = true;
    }
    return dropped;
}

} // namespace

float sceneDensity(const Scene& scene, int pageSize)
{
    constexpr float kPage = 2048.0f;
    constexpr float kTexelsPerMeter = 40.0f; // a texel of 25 mm: what an eye at 1.5 m sees under one degree
    constexpr float kTexelsAlongScene = 256.0f;
    Bounds bounds;
    for (const Object& object : scene.objects) {
        if (!object.isStatic || !(object.lightmapScale > 0.0f) || object.mesh < 0) continue;
        for (const MeshPart& part : scene.meshes[std::size_t(object.mesh)].parts) {
            for (const vec3 position : part.positions) {
                const vec3 world(object.worldFromObject * vec4(position, 1.0f));
                if (std::isfinite(world.x + world.y + world.z)) bounds.extend(world);
            }
        }
    }
    const float diagonal = bounds.empty() ? 0.0f : glm::length(bounds.size());
    if (!(diagonal > 0.0f)) return 0.0f;
    return std::max(kTexelsPerMeter, kTexelsAlongScene / diagonal) * float(pageSize) / kPage;
}

Result<UnwrappedScene> unwrap(Scene scene, const UnwrapSettings& settings, const Progress& progress,
                              const CrossingTest& crossingTest, const SheetTest& sheetTest)
{
    if (const Status status = checkSettings(settings); !status) return status.error();
    UnwrappedScene result;
    result.scene = std::move(scene);
    result.pageSize = settings.pageSize;
    for (Object& object : result.scene.objects) object.lightmap = {};
    joinSheets(result.scene);

    std::vector<GroupLayout> groups;
    std::vector<Surface> surfaces;
    if (const Status status = prepareGroups(result, settings, crossingTest, sheetTest, groups, surfaces, progress);
        !status)
        return status.error();
    if (groups.empty()) return result;
    const PageSettings pageSettings{settings.pageSize, settings.paddingTexels, double(settings.texelsPerMeter),
                                    double(settings.mostTexelsPerMeter), settings.cutPage};
    std::optional<Pages> pages = keepAtlas(groups, settings, result.warnings);
    while (!pages) {
        if (!makeLayouts(groups, surfaces, settings, progress)) return cancelledError();
        const std::size_t warningsBefore = result.warnings.size();
        Result<Pages> placed = placeOnPages(groups, pageSettings, result.warnings, progress);
        if (progress.cancelled()) return cancelledError();
        if (!placed) return placed.error();
        pages = std::move(*placed);
        const Result<bool> dropped = dropUnfitLayouts(result.scene, groups, *pages, settings, result.warnings);
        if (!dropped) return dropped.error();
        if (!*dropped) break;
        result.warnings.resize(warningsBefore);
        pages.reset();
    }
    result.pageSize = pages->pageSize;
    result.pageCount = pages->pageCount;
    result.densityFrom = pages->densityFrom;
    writeGroups(result, groups, surfaces, *pages);
    if (const Status status = checkSharedTexels(result, groups, progress); !status) return status.error();
    result.texelsPerMeter = float(pages->texelsPerMeter);
    const double texels = double(result.pageSize) * result.pageSize * pages->pageCount;
    result.coverage = float(double(pages->coveredTexels) / texels);
    result.coverageWithPadding = float(double(pages->reservedTexels) / texels);
    progress("pack", 1.0);
    return result;
}

} // namespace halflight
