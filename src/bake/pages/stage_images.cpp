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
    for (const auto& [prefix, pages] :
         {std::pair{"shadowmask", &baked.shadowmasks}, std::pair{"lightmap_direction", &baked.lightmapDirections}}) {
        for (std::size_t i = 0; i < pages->size(); ++i) {
            const auto path = settings.imagesDirectory / (prefix + ("_" + std::to_string(i) + ".png"));
            const auto write = [&](const std::filesystem::path& temporary) { return writePng(temporary, (*pages)[i]); };
            if (Status status = files.add(path, write); !status) return status;
        }
    }
    nlohmann::json probes = nlohmann::json::array();
    for (const Probe& probe : baked.probes.probes) {
        nlohmann::json coefficients = nlohmann::json::array();
        for (const vec3 c : probe.radiance) coefficients.push_back({c.x, c.y, c.z});
        const dvec3 position = baked.scene.originMeters + dvec3(probe.position);
        probes.push_back({{"position", {position.x, position.y, position.z}},
                          {"valid", probe.valid},
                          {"occlusion", {probe.occlusion.x, probe.occlusion.y, probe.occlusion.z, probe.occlusion.w}},
                          {"radiance", std::move(coefficients)}});
    }
    const auto path = settings.imagesDirectory / "probes.json";
    return files.add(path, nlohmann::json{{"probes", std::move(probes)}}.dump(1));
}

} // namespace halflight
