#include "bake/report/bake_report.h"

#include "halflight/bake/integrator.h"

#include "halflight/base/text.h"
#include "halflight/scene/turning_lights.h"
#include "scene/model/tint.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <vector>

namespace halflight {

std::set<std::string> coloringGlassOf(const Scene& scene)
{
    std::set<std::string> glass;
    for (const Object& object : scene.objects) {
        if (!object.isStatic || !object.castShadows || object.mesh < 0) continue;
        for (const MeshPart& part : scene.meshes[std::size_t(object.mesh)].parts) {
            const Material& material = materialOf(scene, part);
            if (material.castShadows && colorsLight(material)) glass.insert(material.name);
        }
    }
    return glass;
}

void reportColoredMasks(const Scene& scene, const std::vector<std::string>& leftGray, int mostLayers,
                        BakeReport& report)
{
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        report.lights[i].channel = scene.lights[i].baking.occlusionMaskChannel;
        report.lights[i].coloredMask = scene.lights[i].baking.coloredMask;
    }
    if (leftGray.empty()) return;
    const std::set<std::string> glass = coloringGlassOf(scene);
    report.warnings.push_back(
        "the masks of the mixed lights " + listOf(leftGray) + " are grey behind the glass " +
        listOf({glass.begin(), glass.end()}) + ", as no mask layer has three channels free for each; " +
        (mostLayers < kMostMaskLayers ? "bake with --mask-layers auto" : "give the lights there shorter ranges") +
        ", or halflight_mode = \"baked\", which gives their direct light the colour");
}

constexpr std::size_t kOwnWarnings = 3; ///< fully baked lights that get a warning each

void reportLights(const Scene& scene, BakeReport& report)
{
    std::vector<std::string> ended;
    std::vector<std::string> overflowed;
    for (const Light& light : scene.lights) {
        if (turns(light) && light.baking.turning.directions.empty()) continue; // for the light's further directions
        report.lights.push_back({light.name, light.type, light.mode, light.baking.bakeType,
                                 light.baking.occlusionMaskChannel, light.baking.reason, light.baking.reachMeters});
        if (!light.baking.reason.empty()) overflowed.push_back(light.name);
        if (light.type != LightType::Directional && light.rangeMeters <= 0.0f && light.baking.reachMeters > 0.0f)
            ended.push_back(light.name);
    }
    // One sentence each fills a page where lights are many; the table and the report have each light's reason.
    if (overflowed.size() > kOwnWarnings) {
        report.warnings.push_back("lights " + listOf(overflowed) +
                                  " overlap more mixed lights than there are shadowmask channels, so they are fully "
                                  "baked; the report has the reason and the cure of each (lights, reason)");
    } else {
        for (const Light& light : scene.lights) {
            if (!light.baking.reason.empty())
                report.warnings.push_back("light \"" + light.name + "\" " + light.baking.reason);
        }
    }
    if (!ended.empty()) {
        report.warnings.push_back("lights " + listOf(ended) +
                                  " have no range, and there are not enough shadowmask channels for lights that reach "
                                  "everything: their baked shadows end where they add little light (reach in the "
                                  "report); give them a range to choose it yourself");
    }
}

void reportNoise(std::span<const IrradianceEstimate> estimates, const std::optional<MainLight>& main,
                 BakeReport& report)
{
    double variance = 0.0;
    double sum = 0.0;
    double samples = 0.0;
    uint64_t valid = 0;
    const auto most = uint32_t(report.quality.samples);
    for (std::size_t i = 0; i < estimates.size(); ++i) {
        const IrradianceEstimate& e = estimates[i];
        if (!e.valid) continue;
        ++valid;
        variance += double(e.varianceOfMean);
        sum += double(luminance(e.irradiance));
        if (main) sum += double(luminance(main->at(i)));
        samples += double(e.samples);
        if (report.quality.noiseTarget > 0.0f && e.samples >= most) ++report.texelsAtCap;
    }
    report.invalidTexels = estimates.size() - valid;
    if (valid == 0) return;
    report.samplesPerTexel = samples / double(valid);
    report.noiseReached = sum > 0.0 ? float(std::sqrt(variance * double(valid)) / sum) : 0.0f;
}

namespace {

/// The object, and which of its primitives where it has several: a whole room may be one object.
std::string nameOf(const Scene& scene, const BakeGeometry::Part& part)
{
    std::string name = scene.objects[std::size_t(part.object)].name;
    if (scene.meshes[std::size_t(part.mesh)].parts.size() < 2) return name;
    name += ", primitive " + std::to_string(part.part);
    return part.material < 0 ? name : name + " (" + scene.materials[std::size_t(part.material)].name + ")";
}

} // namespace

void reportFlipped(const Scene& scene, const BakeGeometry& geometry, BakeReport& report)
{
    std::vector<std::string> names;
    for (const BakeGeometry::Part& part : geometry.parts) {
        const auto begin = geometry.flipped.begin() + std::ptrdiff_t(part.firstStored);
        const auto end = begin + std::ptrdiff_t(part.triangleCount);
        if (std::find(begin, end, uint8_t(1)) != end) names.push_back(nameOf(scene, part));
    }
    if (names.empty()) return;
    report.warnings.push_back(
        listOf(names) +
        ": double-sided faces bound a closed, empty cavity; they are flipped, and baked as seen from outside");
}

void reportTwoSided(const Scene& scene, const BakeGeometry& geometry, const TexelMap& map, BakeReport& report)
{
    std::map<int, TwoSidedReport> byObject;
    for (const BakeGeometry::Part& part : geometry.parts)
        if (part.side == SurfaceSide::Back) byObject[part.object].triangles += part.triangleCount;
    if (byObject.empty()) return;
    for (const Texel& texel : map.texels) {
        const BakeGeometry::Part& part = geometry.partOf(map.fragments[texel.firstFragment].triangle);
        if (part.side == SurfaceSide::Back) ++byObject[part.object].texels;
    }
    for (auto& [object, own] : byObject) {
        own.object = scene.objects[std::size_t(object)].name;
        report.twoSided.push_back(std::move(own));
    }
}

void reportMainLight(const BakedScene& baked, const MainLight& main, const BakeSettings& settings, BakeReport& report)
{
    report.mainLight = {main.name, !baked.shadowmasks.empty(), subtractiveShadowColor(baked),
                        !baked.scene.subtractiveShadowColor.has_value()};
    if (settings.maskEncoding == MaskEncoding::Distance && report.mainLight->mask) {
        report.warnings.emplace_back("a subtractive bake's mask holds attenuation, as the lightmap does: distance "
                                     "fields are for shadowmask bakes");
    }
}

} // namespace halflight
