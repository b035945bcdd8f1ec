// Files of BakeSettings::imagesDirectory.
#include "bake/stage_images.h"

#include "halflight/base/file.h"
#include "halflight/base/image.h"

#include <nlohmann/json.hpp>
#include <utility>

namespace halflight {

Status dumpPages(const BakeSettings& settings, const std::string& prefix, const std::vector<ImageRgb32f>& pages)
{
    if (settings.imagesDirectory.empty()) return {};
    for (std::size_t i = 0; i < pages.size(); ++i) {
        const auto path = settings.imagesDirectory / (prefix + "_" + std::to_string(i) + ".exr");
        if (Status status = writeExr(path, pages[i]); !status) {
            return Error{status.error().code, path.string() + " " + status.error().message};
        }
    }
    return {};
}

Status dumpResult(const BakeSettings& settings, const BakedScene& baked)
{
    if (settings.imagesDirectory.empty()) return {};
    for (const auto& [prefix, pages] :
         {std::pair{"shadowmask", &baked.shadowmasks}, std::pair{"lightmap_direction", &baked.lightmapDirections}}) {
        for (std::size_t i = 0; i < pages->size(); ++i) {
            const auto path = settings.imagesDirectory / (prefix + ("_" + std::to_string(i) + ".png"));
            if (Status status = writePng(path, (*pages)[i]); !status) {
                return Error{status.error().code, path.string() + " " + status.error().message};
            }
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
    if (Status status = writeFileAtomically(path, nlohmann::json{{"probes", std::move(probes)}}.dump(1)); !status) {
        return Error{status.error().code, path.string() + " " + status.error().message};
    }
    return {};
}

} // namespace halflight
