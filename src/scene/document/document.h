#pragma once
// A glTF document in memory: its JSON as it was written (what the writer patches) and tinygltf's typed view of it.
// Everything a document refers to has been checked when loadDocument() succeeds: indices, ranges, the node hierarchy.

#include "halflight/base/result.h"
#include "halflight/scene/scene.h"
#include "scene/document/tinygltf.h"
#include "scene/model/gltf_error.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

namespace halflight {

using Json = nlohmann::json;

struct SourceDocument {
    Json json;
    tinygltf::Model model;               ///< buffers resolved and decompressed; images not decoded
    std::filesystem::path directory;     ///< what relative URIs are relative to
    std::vector<std::string> bufferUris; ///< of the file's buffers that are files of their own
    /// By mesh, what takes TEXCOORD_1 back to the shape it had before a bake stretched it: see lightmap_layout.h.
    std::map<int, vec2> stretchedLayouts;
    std::vector<std::string> warnings; ///< of what reading left out
};

/// The member, or null when the object has none (or is not an object).
const Json& member(const Json& object, const char* key);
/// object.extensions[name], or null.
const Json& extensionOf(const Json& object, const char* name);
/// Element of a top-level array, or null.
const Json& element(const Json& document, const char* array, int index);

/// Components per element and bytes per component and element of an accessor (columns of small matrices padded to 4
/// bytes).
int accessorComponents(int tinygltfType);
int componentBytes(int componentType);
std::size_t elementBytes(int componentType, int tinygltfType);

/// An accessor's elements, sparse substitution done.
struct AccessorView {
    const std::byte* data = nullptr;
    std::size_t strideBytes = 0;
    std::size_t count = 0;
    int componentType = 0;
    int components = 0;
    std::size_t bytesPerElement = 0;
    bool normalized = false;
    std::vector<std::byte> owned; ///< where data points when the file holds no plain copy

    [[nodiscard]] const std::byte* at(std::size_t i) const { return data + i * strideBytes; }
    /// Component c of element i as a float; normalized integers become [0,1] or [-1,1].
    [[nodiscard]] float number(std::size_t i, int c) const;
    [[nodiscard]] uint32_t integer(std::size_t i, int c = 0) const;
};
Result<AccessorView> viewAccessor(const SourceDocument& document, int accessor);

/// Elements as float vectors of N components (fewer in the file: error).
template<int N> Result<std::vector<glm::vec<N, float>>> readVectors(const SourceDocument& document, int accessor);
Result<std::vector<uint32_t>> readIntegers(const SourceDocument& document, int accessor);

/// The encoded bytes of an image (PNG, JPEG, …), wherever they are stored.
Result<std::vector<std::byte>> imageBytes(const SourceDocument& document, int image);

} // namespace halflight
