// What `halflight bake` checks of its paths before it begins.

#include "bake_options.h"
#include "console.h"

#include "halflight/base/file.h"

#include <algorithm>
#include <string_view>
#include <utility>

namespace halflight::cli {

namespace {

// Whether a bake with --write-images or --sidecar may write a file of this name: PREFIX_N, the probes, the bindings.
bool isImageName(const std::string& name)
{
    if (name == "probes.json" || name == "bake.json") return true;
    for (const auto& [prefix, extension] : {std::pair<std::string_view, std::string_view>{"lightmap_raw_", ".exr"},
                                            {"lightmap_", ".exr"},
                                            {"lightmap_", ".ktx2"},
                                            {"lightmap_", ".webp"},
                                            {"lightmap_direction_", ".png"},
                                            {"shadowmask_", ".png"}}) {
        if (!name.starts_with(prefix) || !name.ends_with(extension)) continue;
        if (name.size() <= prefix.size() + extension.size()) continue;
        const std::string page = name.substr(prefix.size(), name.size() - prefix.size() - extension.size());
        if (page.find_first_not_of("0123456789") == std::string::npos) return true;
    }
    return false;
}

// The images' number is known only after unwrapping, so all their names count: those that are links to `files`, and
// those of `files` that lie in the folder under such a name.
Status checkImages(const NamedFile& option, const std::vector<NamedFile>& files, std::filesystem::path& culprit)
{
    const std::filesystem::path& folder = option.path;
    if (folder.empty()) return {};
    std::vector<std::filesystem::path> images;
    for (const NamedFile& file : files) {
        if (isImageName(file.path.filename().string())) images.push_back(folder / file.path.filename());
        const Result<std::filesystem::path> target = replacedFile(file.path);
        if (target && isImageName(target->filename().string())) images.push_back(folder / target->filename());
    }
    std::error_code ec;
    for (std::filesystem::directory_iterator entry(folder, ec), end; !ec && entry != end; entry.increment(ec)) {
        if (isImageName(entry->path().filename().string())) images.push_back(entry->path());
    }
    std::sort(images.begin(), images.end()); // a folder has no order of its own
    for (const std::filesystem::path& image : images) {
        culprit = image;
        if (Status status = checkReplacesNone({option.name, image}, files); !status) return status;
    }
    return {};
}

} // namespace

Status checkBakePaths(const BakeOptions& options, std::filesystem::path& culprit)
{
    std::vector<NamedFile> files = {{"the scene", options.scene}, {"the settings file", options.settingsFile}};
    for (const NamedFile& output : {NamedFile{"--output", options.output}, NamedFile{"--report", options.reportFile}}) {
        if (output.path.empty()) continue;
        culprit = output.path;
        if (Status status = checkReplacesNone(output, files); !status) return status;
        if (Status status = checkOutput(output.path); !status) return status;
        files.push_back(output);
    }
    const std::filesystem::path& images = options.bake.imagesDirectory;
    const std::filesystem::path& sidecar = options.sidecarDirectory;
    std::error_code ec;
    if (!sidecar.empty() && !images.empty() &&
        std::filesystem::weakly_canonical(sidecar, ec) == std::filesystem::weakly_canonical(images, ec)) {
        culprit = sidecar;
        return Error{ErrorCode::InvalidArgument, "is the folder of --write-images too; choose another for --sidecar"};
    }
    if (Status status = checkImages({"--write-images", images}, files, culprit); !status) return status;
    return checkImages({"--sidecar", sidecar}, files, culprit);
}

Status checkFilesBeside(const BakeOptions& options, const Scene& scene)
{
    if (lowerExtension(options.output) != ".gltf") return {};
    const std::string stem = options.output.stem().string();
    for (const std::filesystem::path& file : externalFiles(scene)) {
        const std::string name = file.filename().string();
        const bool takenName = name == stem + ".bin" || name.starts_with(stem + "_image_");
        if (!takenName || !sameFile(file, options.output.parent_path() / name)) continue;
        return Error{ErrorCode::InvalidArgument,
                     "its file " + name + " would replace one of the scene's; choose another name for the output"};
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
    std::filesystem::path step;
    for (const std::filesystem::path& name : std::filesystem::absolute(folder, ec)) {
        step /= name;
        if (std::filesystem::is_directory(step, ec)) continue;
        if (std::filesystem::create_directory(step, ec)) made_.push_back(step);
        if (ec) return Error{ErrorCode::WriteFailed, "cannot be made into a folder (" + ec.message() + ")"};
    }
    return tryWriting(folder);
}

} // namespace halflight::cli
