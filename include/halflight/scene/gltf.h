#pragma once
// glTF 2.0 in and out: the only code that knows the format. docs/format.md documents the extensions written.

#include "halflight/base/progress.h"
#include "halflight/base/result.h"
#include "halflight/scene/baked_scene.h"
#include "halflight/scene/written_bytes.h"

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace halflight {

class FilesInUse;

struct ReadOptions {
    std::filesystem::path settingsFile; ///< TOML with per-node and per-light settings by name pattern; empty = none
    /// Of a file that does not say itself, in place of what its settings file says; empty = that, or nits.
    std::optional<EmissionUnit> emissionUnit;
    bool decodeTextures = true;                ///< false: Texture::pixels stay empty (for `info`)
    const std::atomic<bool>* cancel = nullptr; ///< reading ends with Cancelled soon after it is set
};

/// Reads .glb or .gltf. Settings come from, weakest first: defaults, `extras`, the settings file.
/// Errors: FileNotFound, FileInvalid (also: geometry more than 1e7 m from the origin), Unsupported (an unknown required
/// extension, by name); never throws or aborts.
Result<Scene> readScene(const std::filesystem::path& path, const ReadOptions& options = {});

/// Reads a file written by writeBakedScene; a plain glTF gives a BakedScene with isBaked = false.
Result<BakedScene> readBakedScene(const std::filesystem::path& path, const ReadOptions& options = {});

struct WriteOptions {
    /// Webp needs a build with libwebp (decodesWebp()); without it: Unsupported.
    LightmapFormat lightmapFormat = LightmapFormat::Rgb9e5;
    /// The lightmaps before they became RGB9E5, lux (BakeResult::irradiance): what half floats are made of, and what
    /// errors are measured against. Empty: BakedScene::lightmaps.
    std::span<const ImageRgb32f> irradiance;
    std::span<const std::vector<ImageRgb32f>> groupIrradiance; ///< the same of groups (BakeResult::groupIrradiance)
    int skyWidth = 512; ///< texels in a row of the sky's picture; no more than it has
    std::string generator = "Halflight";
    WrittenBytes* written = nullptr; ///< receives the sizes of what was written; may be null
    Progress progress;               ///< its cancel flag ends writing between pages (ErrorCode::Cancelled)
    /// Called once, right before the first file takes its name (of a GLB, when all bytes are in its temporary file).
    /// False leaves none: Cancelled. Empty = always.
    std::function<bool()> mayReplace;
};

/// Writes the source document with lightmap coordinates and Halflight's extensions added (a document made from the
/// Scene when it has no source). A path that ends in .gltf gets its files beside it: STEM.bin and STEM_image_N.png,
/// .jpg and so on. Any other path is one GLB. All files are whole, or none is written.
Status writeBakedScene(const std::filesystem::path& path, const BakedScene& baked, const WriteOptions& options = {});

/// The files that a settings file names: the sky's picture.
Result<std::vector<std::filesystem::path>> filesOfSettings(const std::filesystem::path& settingsFile);

/// The files that a scene's document names: external buffers and images, the sky's picture. No output may replace one.
std::vector<std::filesystem::path> externalFiles(const Scene& scene);

/// Adds what readScene() reads before it knows what the scene's document names (externalFiles()).
void addReadFiles(FilesInUse& files, const std::filesystem::path& scene, const std::filesystem::path& settingsFile);
void addExternalFiles(FilesInUse& files, const std::vector<std::filesystem::path>& externalFiles);
/// Adds what writeBakedScene() may write.
void addBakedFiles(FilesInUse& files, const std::string& option, const std::filesystem::path& output);

} // namespace halflight
