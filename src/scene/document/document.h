#pragma once
// A glTF document in memory: its JSON as it was written (what the writer patches), and the bytes of its buffers.
// Everything a document refers to has been checked when loadDocument() succeeds: indices, ranges, the node hierarchy.

#include "halflight/base/result.h"
#include "halflight/scene/scene.h"
#include "scene/document/enumerators.h"
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
    std::vector<std::vector<std::byte>> buffers; ///< resolved and decompressed, as many as the JSON has
    std::filesystem::path directory;             ///< what relative URIs are relative to
    std::vector<std::string> bufferUris;         ///< of the file's buffers that are files of their own
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
/// Whether `index` is the index of an element of a top-level array.
bool isIndexInto(const Json& document, const char* array, const Json& index);

// Members whose types checkTypes() has seen.

/// An index or another integer from 0 to 2^31 - 1; `absent` where there is none.
int integerOf(const Json& object, const char* key, int absent = -1);
/// A number of bytes or elements; 0 where there is none.
std::size_t bytesIn(const Json& object, const char* key);
/// A name or the like; empty where there is none.
std::string stringOf(const Json& object, const char* key);

/// A mesh's primitive. Both indices exist, as do those of the functions below.
const Json& primitiveOf(const SourceDocument& document, int mesh, int primitive);
/// The accessor of a primitive's attribute, or -1.
int attributeOf(const Json& primitive, const std::string& name);
/// The number of an accessor's elements.
std::size_t elementCount(const SourceDocument& document, int accessor);
/// The scene that is shown: the default one, or the first.
int activeSceneIndex(const SourceDocument& document);
/// Of all buffers together.
uint64_t bufferBytes(const SourceDocument& document);

/// Bytes per component of an accessor; 0 for types that glTF does not have.
int componentBytes(int componentType);
/// Components of an element, and its bytes: columns of small matrices are padded to 4 bytes. 0 for unknown types.
struct ElementSize {
    int components = 0;
    std::size_t bytes = 0;
};
ElementSize elementSize(const Json& accessor);

/// Bytes from one element of a buffer view to the next: its byteStride, or an element's bytes where it has none.
std::size_t strideIn(const Json& view, std::size_t elementBytes);
/// The bytes of a buffer view.
std::span<const std::byte> viewBytes(const SourceDocument& document, int view);

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
