// What `halflight bake` checks of its paths before it begins.

#include "bake_options.h"
#include "console.h"

#include "halflight/base/file.h"
#include "halflight/scene/gltf.h"

namespace halflight::cli {

FilesInUse filesOfBake(const BakeOptions& options, const Scene* scene)
{
    FilesInUse files;
    addReadFiles(files, options.scene, options.settingsFile);
    for (const auto& [name, file] : options.alsoRead) files.reads(name, file);
    if (scene != nullptr) addExternalFiles(files, externalFiles(*scene));
    addBakedFiles(files, "--output", options.output);
    files.writes("--report", options.reportFile);
    const std::vector<FileNames> both = {
        {"lightmap_", true, ".exr"}, {"lightmap_direction_", true, ".png"}, {"shadowmask_", true, ".png"}};
    if (const auto& folder = options.bake.imagesDirectory; !folder.empty()) {
        files.writesIn("--write-images", folder, both);
        files.writesIn("--write-images", folder, {{"lightmap_raw_", true, ".exr"}, {"probes.json", false, ""}});
    }
    if (const auto& folder = options.sidecarDirectory; !folder.empty()) {
        files.writesIn("--sidecar", folder, both);
        files.writesIn("--sidecar", folder, {{"lightmap_", true, ".ktx2"}, {"lightmap_", true, ".webp"}});
        files.writesIn("--sidecar", folder, {{"bake.json", false, ""}, {"sky.exr", false, ""}});
    }
    return files;
}

Status checkBakePaths(const BakeOptions& options, std::filesystem::path& culprit)
{
    if (Status status = filesOfBake(options, nullptr).check(culprit); !status) return status;
    for (const std::filesystem::path& output : {options.output, options.reportFile}) {
        culprit = output;
        if (output.empty()) continue;
        if (Status status = checkOutput(output); !status) return status;
    }
    const std::filesystem::path& images = options.bake.imagesDirectory;
    const std::filesystem::path& sidecar = options.sidecarDirectory;
    std::error_code ec;
    if (!sidecar.empty() && !images.empty() &&
        std::filesystem::weakly_canonical(sidecar, ec) == std::filesystem::weakly_canonical(images, ec)) {
        culprit = sidecar;
        return Error{ErrorCode::InvalidArgument, "is the folder of --write-images too; choose another for --sidecar"};
    }
    return {};
}

OutputFolders::~OutputFolders()
{
    std::error_code ec;
    for (auto folder = made_.rbegin(); folder != made_.rend(); ++folder)
        std::filesystem::remove(*folder, ec); // if empty
}

Status OutputFolders::make(const std::filesystem::path& folder)
{
    if (folder.empty()) return {};
    std::error_code ec;
    const std::filesystem::path whole = std::filesystem::absolute(folder, ec);
    std::filesystem::path step = whole.root_path(); // with a drive, on Windows
    for (const std::filesystem::path& name : whole.relative_path()) {
        step /= name;
        if (std::filesystem::is_directory(step, ec)) continue;
        if (std::filesystem::create_directory(step, ec)) made_.push_back(step);
        if (ec) return Error{ErrorCode::WriteFailed, "cannot be made into a folder (" + ec.message() + ")"};
    }
    return tryWriting(folder);
}

} // namespace halflight::cli
