#pragma once
// glTF 2.0 in and out: the only code that knows the format. docs/format.md documents the extensions written.

#include "halflight/base/result.h"
#include "halflight/scene/baked_scene.h"

#include <filesystem>
#include <string>

namespace halflight {

struct ReadOptions {
    std::filesystem::path settingsFile; ///< TOML with per-node and per-light settings by name pattern; empty = none
    bool decodeTextures = true;         ///< false: Texture::pixels stay empty (for `info`)
};

/// Reads .glb or .gltf. Settings come from, weakest first: defaults, `extras`, the settings file.
/// Errors: FileNotFound, FileInvalid (also: geometry more than 1e7 m from the origin), Unsupported (an unknown required
/// extension, by name); never throws or aborts.
Result<Scene> readScene(const std::filesystem::path& path, const ReadOptions& options = {});

/// Reads a file written by writeBakedScene; a plain glTF gives a BakedScene with isBaked = false.
Result<BakedScene> readBakedScene(const std::filesystem::path& path, const ReadOptions& options = {});

struct WriteOptions {
    bool mozLightmap = true; ///< also write material-level MOZ_lightmap (RGBE image), for existing loaders
    std::string generator = "Halflight";
};

/// Writes one .glb: the source document with lightmap coordinates and Halflight's extensions added (a document made
/// from the Scene when it has no source). Atomic: a failed write leaves no file.
Status writeBakedScene(const std::filesystem::path& path, const BakedScene& baked, const WriteOptions& options = {});

} // namespace halflight
