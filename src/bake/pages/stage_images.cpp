// Files of BakeSettings::imagesDirectory.
#include "bake/pages/stage_images.h"

#include "halflight/base/file.h"
#include "halflight/base/image.h"

#include <nlohmann/json.hpp>
#include <utility>

namespace halflight {

Status dumpPages(const BakeSettings& settings, const std::string& prefix, const std::vector<ImageRgb32f>& pages,
                 FileGroup& files)
{
    if (settings.imagesDirectory.empty()) return {};
    for (std::size_t i = 0; i < pages.size(); ++i) {
        const auto path = settings.imagesDirectory / (prefix + "_" + std::to_string(i) + ".exr");
        const auto write = [&](const std::filesystem::path& temporary) { return writeExr(temporary, pages[i]); };
        if (Status status = files.add(path, write); !status) return status;
    }
    return {};
}

Status dumpResult(const BakeSettings& settings, const BakedScene& baked, FileGroup& files)
{
    if (settings.imagesDirectory.empty()) return {};
    const auto add = [&](const std::string& name, const ImageRgba8& page) {
        const auto write = [&](const std::filesystem::path& temporary) { return writePng(temporary, page); };
        return files.add(settings.imagesDirectory / (name + ".png"), write);
    };
    for (std::size_t i = 0; i < baked.shadowmasks.size(); ++i) {
        if (baked.shadowmasks[i].texelCount() == 0) continue;
        if (Status status = add("shadowmask_" + std::to_string(i), baked.shadowmasks[i]); !status) return status;
    }
    for (std::size_t i = 0; i < baked.lightmapDirections.size(); ++i) {
        const std::string name = "lightmap_direction_" + std::to_string(i);
        if (Status status = add(name, baked.lightmapDirections[i]); !status) return status;
    }
    nlohmann::json probes = nlohmann::json::array();
    for (const Probe& probe : baked.probes.probes) {
        nlohmann::json coefficients = nlohmann::json::array();
        for (const vec3 c : probe.radiance) coefficients.push_back({c.x, c.y, c.z});
        nlohmann::json occlusion = nlohmann::json::array();
        for (int c = 0; c < baked.maskLayers * kLayerChannels; ++c) occlusion.push_back(probe.occlusion[c]);
        const dvec3 position = baked.scene.originMeters + dvec3(probe.position);
        probes.push_back({{"position", {position.x, position.y, position.z}},
                          {"valid", probe.valid},
                          {"occlusion", occlusion},
                          {"radiance", std::move(coefficients)}});
    }
    const auto path = settings.imagesDirectory / "probes.json";
    return files.add(path, nlohmann::json{{"probes", std::move(probes)}}.dump(1));
}

} // namespace halflight
