#pragma once
// One function per reader of bytes that a stranger may have made. Each takes any bytes, returns whether they were read,
// and stops the program where a promise of the reader is broken. corpus_test.cpp runs them over seeds and their
// mutations.

#include <cstddef>
#include <span>
#include <string_view>

namespace halflight::fuzz {

bool readGltf(std::span<const std::byte> bytes);     ///< GLB or JSON: the whole scene, images decoded
bool readBaked(std::span<const std::byte> bytes);    ///< the same with an earlier bake's lightmaps, masks and probes
bool readSettings(std::span<const std::byte> bytes); ///< a settings file
bool decode(
    std::span<const std::byte> bytes); ///< first byte: which decoder of images, KTX2, Draco, meshopt, .hdr; rest: data

struct EntryPoint {
    std::string_view name;
    bool (*run)(std::span<const std::byte>);
};
inline constexpr EntryPoint kEntryPoints[] = {
    {"gltf", &readGltf}, {"baked", &readBaked}, {"settings", &readSettings}, {"decoders", &decode}};

} // namespace halflight::fuzz
