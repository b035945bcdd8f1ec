#include "halflight/scene/optimize.h"

#include "halflight/base/encoded_image.h"
#include "halflight/base/file.h"
#include "scene/document/decode/meshopt_encode.h"
#include "scene/document/references.h"
#include "scene/files/external_files.h"
#include "scene/files/optimize_meshes.h"
#include "scene/files/optimize_pictures.h"
#include "scene/format/limits.h"
#include "scene/load/extensions.h"
#include "scene/load/load_document.h"
#include "scene/read/read_baked.h"
#include "scene/read/read_probes.h"
#include "scene/read/read_reflections.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace halflight {

namespace {

// Bytes of the buffer views that accessors refer to, by whether they are the bake's probes.
void countAccessors(const FinishedDocument& document, uint64_t& geometry, uint64_t& probes)
{
    const Json& json = document.json;
    std::set<std::size_t> ofProbes;
    const Json& record = member(extensionOf(json, "HALFLIGHT_mixed_lighting"), "probes");
    for (const char* name : kProbeAccessors) {
        const Json& accessor = member(record, name);
        if (accessor.is_number_integer()) ofProbes.insert(accessor.get<std::size_t>());
    }
    for (const Json& group : member(extensionOf(json, "HALFLIGHT_mixed_lighting"), "groups"))
        if (group.contains("radiance")) ofProbes.insert(group["radiance"].get<std::size_t>());
    std::set<std::size_t> seen;
    const Json& accessors = member(json, "accessors");
    for (std::size_t i = 0; i < accessors.size(); ++i) {
        const Json& index = member(accessors[i], "bufferView");
        if (!index.is_number_integer() || !seen.insert(index.get<std::size_t>()).second) continue;
        const Json& view = json["bufferViews"][index.get<std::size_t>()];
        const Json& compressed = extensionOf(view, "EXT_meshopt_compression");
        (ofProbes.contains(i) ? probes : geometry) +=
            (compressed.is_object() ? compressed : view)["byteLength"].get<uint64_t>();
    }
}

// Numbers that are floats, in as few digits as tell the float from its neighbours.
void shortenFloats(Json& json)
{
    if (json.is_structured()) {
        for (Json& item : json) shortenFloats(item);
    } else if (json.is_number_float()) {
        const auto value = json.get<double>();
        if (std::abs(value) < 1.0e9 && value == std::floor(value)) { // without ".0"
            json = int64_t(value);
            return;
        }
        if (double(float(value)) != value) return;
        std::array<char, 32> text{};
        for (int digits = 6; digits <= 9; ++digits) {
            std::snprintf(text.data(), text.size(), "%.*g", digits, value);
            if (std::strtof(text.data(), nullptr) == float(value)) break;
        }
        json = std::strtod(text.data(), nullptr);
    }
}

// A bake is copied as it is, so its numbers are checked as a reader of the copy will check them.
Status checkBake(const SourceDocument& document, const Json& bake)
{
    BakedScene baked;
    if (Status s = readProbes(document, member(bake, "probes"), glm::dvec3(0.0), baked.probes); !s) return s;
    auto reflections = readReflections(document, member(bake, "reflectionProbes"), glm::dvec3(0.0));
    if (!reflections) return reflections.error();
    baked.reflections = std::move(*reflections);
    return checkBakedValues(baked);
}

void makeUnique(Json& json, const char* list)
{
    const std::set<Json> names(json[list].begin(), json[list].end());
    json[list] = names;
    if (names.empty()) json.erase(list);
}

} // namespace

bool canOptimizeGeometry()
{
    return encodesMeshopt();
}

bool canOptimizeTextures()
{
    return decodesWebp();
}

Status optimizeFile(const std::filesystem::path& in, const std::filesystem::path& out, const OptimizeOptions& options,
                    OptimizeReport& report)
{
    const auto source = loadDocument(in);
    if (!source) return source.error();
    if (options.checkFiles) {
        if (Status s = options.checkFiles(externalFiles(**source)); !s) return s;
    }
    const Json& bake = extensionOf((*source)->json, "HALFLIGHT_mixed_lighting");
    if (bake.is_object() && !isFormatVersion(member(bake, "version"))) {
        return Error{ErrorCode::Unsupported,
                     "its bake is of another version of the format than this program writes: bake the scene again",
                     "/extensions/HALFLIGHT_mixed_lighting"};
    }
    if (Status s = bake.is_object() ? checkBake(**source, bake) : Status(); !s) return s;
    report.warnings.insert(report.warnings.end(), (*source)->warnings.begin(), (*source)->warnings.end());
    std::error_code ec;
    report.file.before = std::filesystem::file_size(in, ec);
    {
        DocumentPatcher unchanged(**source);
        countAccessors(unchanged.finish(), report.geometry.before, report.probes.before);
    }
    DocumentPatcher patcher(**source);
    if (Status s = optimizePictures(patcher, **source, options, report); !s) return s;
    const std::string unknown = unknownExtension((*source)->json);
    const bool geometry = options.geometry && encodesMeshopt() && unknown.empty();
    if (options.geometry && !unknown.empty())
        report.warnings.push_back(staysForExtension("geometry stays as it is", unknown));
    if (geometry) {
        if (Status s = optimizeMeshes(patcher, **source); !s) return s;
        for (const char* list : {"extensionsUsed", "extensionsRequired"})
            patcher.json[list].push_back("KHR_mesh_quantization");
    }
    FinishedDocument document = patcher.finish();
    if (geometry) compressDocument(document);
    shortenFloats(document.json);
    makeUnique(document.json, "extensionsUsed");
    makeUnique(document.json, "extensionsRequired");
    countAccessors(document, report.geometry.after, report.probes.after);
    const auto glb = makeGlb(document.json, document.binary);
    if (!glb) return glb.error();
    report.file.after = glb->size();
    return writeFileAtomically(out, glb->data(), glb->size(), options.mayReplace);
}

} // namespace halflight
