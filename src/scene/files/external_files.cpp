#include "scene/files/external_files.h"

#include "halflight/base/files_in_use.h"
#include "halflight/scene/gltf.h"
#include "scene/document/uri.h"
#include "scene/read/geometry/nodes.h"
#include "scene/settings/settings.h"
#include "scene/write/write_baked.h"

namespace halflight {

std::vector<std::filesystem::path> externalFiles(const SourceDocument& document)
{
    std::vector<std::filesystem::path> files;
    std::vector<std::string> uris = document.bufferUris;
    for (const Json& image : member(document.json, "images")) uris.push_back(stringOf(image, "uri"));
    for (const std::string& uri : uris) {
        if (uri.empty() || isDataUri(uri)) continue;
        files.push_back(document.directory / percentDecoded(uri));
        const std::filesystem::path asItStands = document.directory / uri; // readUri() takes either name
        std::error_code ec;
        if (asItStands != files.back() && std::filesystem::exists(asItStands, ec)) files.push_back(asItStands);
    }
    const auto settings = sceneSettingsOf(member(activeScene(document), "extras"), "");
    if (settings && settings->skyImage) files.push_back(document.directory / *settings->skyImage);
    return files;
}

std::vector<std::filesystem::path> externalFiles(const Scene& scene)
{
    return scene.source ? externalFiles(*scene.source) : std::vector<std::filesystem::path>();
}

void addReadFiles(FilesInUse& files, const std::filesystem::path& scene, const std::filesystem::path& settingsFile)
{
    files.reads("the scene", scene);
    if (settingsFile.empty()) return;
    files.reads("the settings file", settingsFile);
    const auto named = filesOfSettings(settingsFile);
    if (!named) return; // reading the scene says why
    for (const std::filesystem::path& file : *named)
        files.reads("the settings file's " + file.filename().string(), file);
}

void addExternalFiles(FilesInUse& files, const std::vector<std::filesystem::path>& externalFiles)
{
    for (const std::filesystem::path& file : externalFiles)
        files.reads("the scene's " + file.filename().string(), file);
}

void addBakedFiles(FilesInUse& files, const std::string& option, const std::filesystem::path& output)
{
    files.writes(option, output);
    if (!isSeparate(output)) return;
    const std::string stem = output.stem().string();
    files.writesIn(option, output.parent_path(),
                   {{stem + ".bin", false, ""}, {stem + kImageInfix + "_", true, std::nullopt}});
}

} // namespace halflight
