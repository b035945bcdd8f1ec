#include "halflight/scene/sidecar.h"

#include "halflight/base/file_group.h"
#include "halflight/base/rgb9e5.h"
#include "halflight/scene/probe_cells.h"
#include "halflight/scene/sky_picture.h"
#include "scene/document/document.h"
#include "scene/document/patcher.h"
#include "scene/load/load_document.h"
#include "scene/read/geometry/nodes.h"
#include "scene/write/write_bake_pictures.h"
#include "scene/write/write_probes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace halflight {

namespace {

constexpr int kSidecarVersion = 1;
constexpr int kGroupedVersion = 2; ///< with light groups: lightmaps and probes hold the rest alone
constexpr std::size_t kNamesInWarning = 4;

class SidecarWriter {
public:
    SidecarWriter(const std::filesystem::path& folder, const SourceDocument& document, const BakedScene& baked,
                  const SidecarOptions& options)
        : folder_(folder), document_(document), baked_(baked), options_(options)
    {}

    Status write(const std::string& file, std::vector<std::string>& warnings)
    {
        const Json& root = extensionOf(document_.json, "HALFLIGHT_mixed_lighting");
        const int version = baked_.groups.empty() ? kSidecarVersion : kGroupedVersion;
        json_ = {{"version", version}, {"generator", options_.write.generator}, {"file", file}};
        for (const char* key : {"mode", "sky", "subtractiveShadowColor", "shadowmaskLayers", "shadowmaskChannels"}) {
            if (root.contains(key)) json_[key] = root[key];
        }
        if (Status s = sky(); !s) return s;
        if (!baked_.lightmaps.empty()) {
            auto pages = lightmaps({baked_.lightmaps, baked_.lightmapUnitLux, options_.write.irradiance}, "lightmap_");
            if (!pages) return pages.error();
            json_["lightmaps"] = std::move(*pages);
        }
        if (Status s = pictures("lightmapDirections", "lightmap_direction_", baked_.lightmapDirections, json_); !s)
            return s;
        if (Status s = pictures("shadowmasks", "shadowmask_", baked_.shadowmasks, json_); !s) return s;
        if (Status s = groups(); !s) return s;
        findPaths();
        json_["objects"] = bindings("HALFLIGHT_node");
        json_["lights"] = bindings("HALFLIGHT_light");
        if (Status s = instances(); !s) return s;
        probes();
        warnAboutNames(warnings);
        if (Status s = writeNamed("bake.json", textOf(json_)); !s) return s;
        return files_.commit();
    }

private:
    Status writeNamed(const std::string& name, std::span<const std::byte> bytes)
    {
        return files_.add(folder_ / name, bytes.data(), bytes.size());
    }
    Status writeNamed(const std::string& name, const std::string& text)
    {
        return writeNamed(name, std::as_bytes(std::span(text)));
    }
    template<typename Picture> Status writeExrNamed(const std::string& name, const Picture& picture)
    {
        return files_.add(folder_ / name,
                          [&](const std::filesystem::path& temporary) { return writeExr(temporary, picture); });
    }

    Status sky()
    {
        const Sky& sky = baked_.scene.sky;
        if (sky.picture == nullptr) return {};
        const std::string name = "sky.exr";
        json_["sky"]["picture"] = {{"file", name}, {"rotation", sky.rotationRadians}};
        return writeExrNamed(name, reducedSkyPicture(*sky.picture, options_.write.skyWidth));
    }

    struct LightPages {
        const std::vector<Image<uint32_t>>& texels; ///< in units of `unitLux`
        float unitLux = 1.0f;
        std::span<const ImageRgb32f> irradiance; ///< lux: the same, or none
    };
    // Pages without texels are null.
    Result<Json> lightmaps(const LightPages& light, const std::string& prefix)
    {
        const auto nameOfPage = [&](std::size_t page, const char* extension) {
            return prefix + std::to_string(page) + extension;
        };
        if (!options_.format) {
            Json json = {{"format", "exr"}, {"unitLux", 1}};
            for (std::size_t i = 0; i < light.texels.size(); ++i) {
                json["pages"].push_back(nullptr);
                if (light.texels[i].empty()) continue;
                const std::string name = nameOfPage(i, ".exr");
                const bool inFloats = light.irradiance.size() == light.texels.size();
                const Status written = inFloats ? writeExrNamed(name, light.irradiance[i])
                                                : writeExrNamed(name, decodeRgb9e5(light.texels[i], light.unitLux));
                if (!written) return written.error();
                json["pages"].back() = name;
            }
            return json;
        }
        WriteOptions write = options_.write;
        write.lightmapFormat = *options_.format;
        const auto encoded = encodePages(light.texels, light.unitLux, light.irradiance, write);
        if (!encoded) return encoded.error();
        Json json = {{"format", nameOf(*options_.format)}, {"unitLux", light.unitLux}};
        if (!encoded->encoding.is_null()) json["encoding"] = encoded->encoding;
        for (std::size_t i = 0; i < encoded->pages.size(); ++i) {
            json["pages"].push_back(nullptr);
            if (encoded->pages[i].empty()) continue;
            const std::string name = nameOfPage(i, *options_.format == LightmapFormat::Webp ? ".webp" : ".ktx2");
            if (Status s = writeNamed(name, encoded->pages[i]); !s) return s.error();
            json["pages"].back() = name;
        }
        return json;
    }

    Status pictures(const char* key, const std::string& prefix, const std::vector<ImageRgba8>& pages, Json& json)
    {
        for (std::size_t i = 0; i < pages.size(); ++i) {
            json[key].push_back(nullptr); // a page whose lights light every texel, or none
            if (pages[i].empty()) continue;
            const std::string name = prefix + std::to_string(i) + ".png";
            const auto write = [&](const std::filesystem::path& temporary) { return writePng(temporary, pages[i]); };
            if (Status s = files_.add(folder_ / name, write); !s) return s;
            json[key].back() = name;
        }
        return {};
    }

    // A group's name as part of a file's: letters, digits, '-' and '_' stay. No two groups have the same.
    static std::string fileNameOf(const std::string& group, std::set<std::string>& taken)
    {
        std::string name = group;
        for (char& c : name)
            if (!(c >= '0' && c <= '9') && !(c >= 'a' && c <= 'z') && !(c >= 'A' && c <= 'Z') && c != '-') c = '_';
        std::string free = name;
        // File names of some systems do not tell capitals apart.
        const auto lower = [](std::string text) {
            for (char& c : text)
                if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
            return text;
        };
        for (int n = 2; !taken.insert(lower(free)).second; ++n) free = name + "-" + std::to_string(n);
        return free;
    }

    Status groups()
    {
        std::set<std::string> taken;
        for (std::size_t g = 0; g < baked_.groups.size(); ++g) {
            const BakedGroup& group = baked_.groups[g];
            const std::string name = fileNameOf(group.name, taken);
            const bool known = options_.write.groupIrradiance.size() == baked_.groups.size();
            const auto irradiance = known ? std::span<const ImageRgb32f>(options_.write.groupIrradiance[g])
                                          : std::span<const ImageRgb32f>();
            Json json = {{"name", group.name}, {"weight", numbers(group.weight)}, {"materials", Json::array()}};
            if (group.sky) json["sky"] = true;
            for (const Material& material : baked_.scene.materials)
                if (material.bakedGroup == int(g)) json["materials"].push_back(material.name);
            if (group.shadowColor != vec3(0.0f)) json["shadowColor"] = numbers(group.shadowColor);
            auto pages = lightmaps({group.lightmaps, group.unitLux, irradiance}, "lightmap_" + name + "_");
            if (!pages) return pages.error();
            json["lightmaps"] = std::move(*pages);
            const std::string directions = "lightmap_direction_" + name + "_";
            if (Status s = pictures("lightmapDirections", directions, group.directions, json); !s) return s;
            for (const SphericalHarmonicsL2& probe : group.radiance) json["radiance"].push_back(coefficientsOf(probe));
            json_["groups"].push_back(std::move(json));
        }
        return {};
    }

    static Json coefficientsOf(const SphericalHarmonicsL2& radiance)
    {
        Json coefficients = Json::array();
        for (const vec3& c : radiance) coefficients.insert(coefficients.end(), {c.x, c.y, c.z});
        return coefficients;
    }

    // The way to each node: places among the scene's nodes, then among children.
    void findPaths()
    {
        const Json& scene = activeScene(document_);
        visit(member(scene, "nodes"), {});
    }
    void visit(const Json& list, const std::vector<int>& above)
    {
        for (std::size_t i = 0; i < list.size(); ++i) {
            std::vector<int> path = above;
            path.push_back(int(i));
            const int node = list[i].get<int>();
            paths_[node] = path;
            visit(member(element(document_.json, "nodes", node), "children"), path);
        }
    }

    // The records of an extension, with what tells their nodes.
    Json bindings(const char* extension)
    {
        Json list = Json::array();
        for (const auto& [node, path] : paths_) {
            const Json& json = element(document_.json, "nodes", node);
            const Json& record = extensionOf(json, extension);
            if (!record.is_object()) continue;
            Json binding = record;
            binding.erase("atBake"); // of the file's own check
            if (binding.contains("baking")) binding["baking"].erase("atBake");
            const std::string name = json.value("name", "");
            binding["node"] = name;
            binding["path"] = path;
            ++uses_[extension + name];
            list.push_back(std::move(binding));
            nodes_.push_back(node);
        }
        return list;
    }

    // Rectangles of instances, which the file has in vertex-like attributes.
    Status instances()
    {
        for (std::size_t i = 0; i < json_["objects"].size(); ++i) {
            if (!member(member(json_["objects"][i], "lightmap"), "perInstance").is_boolean()) continue;
            Json& lightmap = json_["objects"][i]["lightmap"];
            const Json& node = element(document_.json, "nodes", nodes_[i]);
            const Json& attributes = member(extensionOf(node, "EXT_mesh_gpu_instancing"), "attributes");
            const auto pages = viewAccessor(document_, attributes["_HALFLIGHT_LIGHTMAP_PAGE"].get<int>());
            const auto places = viewAccessor(document_, attributes["_HALFLIGHT_LIGHTMAP_ST"].get<int>());
            if (!pages) return pages.error();
            if (!places) return places.error();
            for (std::size_t k = 0; k < pages->count; ++k) {
                lightmap["instances"].push_back({{"page", std::lround(pages->number(k, 0))},
                                                 {"scale", {places->number(k, 0), places->number(k, 1)}},
                                                 {"offset", {places->number(k, 2), places->number(k, 3)}}});
            }
        }
        return {};
    }

    void probes()
    {
        const ProbeSet& set = baked_.probes;
        if (set.probes.empty()) return;
        Json& json = json_["probes"];
        json = {{"positions", Json::array()}, {"radiance", Json::array()}, {"occlusion", Json::array()}};
        for (const Probe& probe : set.probes) {
            json["positions"].push_back(numbers(baked_.scene.originMeters + dvec3(probe.position)));
            json["radiance"].push_back(coefficientsOf(probe.radiance));
            Json occlusion = Json::array();
            for (int c = 0; c < baked_.maskLayers * kLayerChannels; ++c) occlusion.push_back(probe.occlusion[c]);
            json["occlusion"].push_back(std::move(occlusion));
            json["valid"].push_back(probe.valid);
        }
        if (Json grid = gridJson(set, baked_.scene.originMeters + dvec3(set.origin)); !grid.is_null())
            json["grid"] = std::move(grid);
        for (const Tetrahedron& cell : fileTetrahedra(probeCells(set))) json["tetrahedra"].push_back(cell.vertex);
    }

    void warnAboutNames(std::vector<std::string>& warnings) const
    {
        for (const auto& [list, extension, what] :
             {std::tuple("objects", "HALFLIGHT_node", "object"), {"lights", "HALFLIGHT_light", "light"}}) {
            std::size_t count = 0;
            std::set<std::string> names;
            for (const Json& binding : json_[list]) {
                const auto name = binding["node"].get<std::string>();
                if (!name.empty() && uses_.at(extension + name) == 1) continue;
                ++count;
                names.insert(name.empty() ? "(no name)" : "'" + name + "'");
            }
            if (count == 0) continue;
            const bool one = count == 1;
            std::string text =
                std::to_string(count) + " " + what + (one ? " has no name of its own" : "s have no name of their own") +
                ", so that the sidecar tells " + (one ? "it" : "them") +
                " by place in the hierarchy alone, which other tools may change; give each its own name: ";
            std::size_t shown = 0;
            for (const std::string& name : names) {
                if (shown == kNamesInWarning) {
                    text += " and others";
                    break;
                }
                text += (shown++ > 0 ? ", " : "") + name;
            }
            warnings.push_back(text);
        }
    }

    const std::filesystem::path& folder_;
    const SourceDocument& document_;
    const BakedScene& baked_;
    const SidecarOptions& options_;
    FileGroup files_;
    Json json_;
    std::map<int, std::vector<int>> paths_;   // by node
    std::map<std::string, std::size_t> uses_; // of a name among an extension's nodes
    std::vector<int> nodes_;                  // of the objects, then of the lights
};

} // namespace

Status writeSidecar(const std::filesystem::path& folder, const std::filesystem::path& bakedFile,
                    const BakedScene& baked, const SidecarOptions& options, std::vector<std::string>& warnings)
{
    const auto document = loadDocument(bakedFile);
    if (!document) return document.error();
    return SidecarWriter(folder, **document, baked, options).write(bakedFile.filename().string(), warnings);
}

} // namespace halflight
