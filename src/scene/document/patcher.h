#pragma once
// Changing a glTF document's JSON and binary data: new accessors and buffer views take the places of those that nothing
// refers to any more, and everything else keeps its index, so that extensions this program does not know stay right.

#include "scene/document/document.h"

#include <functional>
#include <map>
#include <set>
#include <span>
#include <vector>

namespace halflight {

/// New binary data of an accessor or an image.
struct NewView {
    std::vector<std::byte> bytes;
    int strideBytes = 0; ///< 0 = none written
    int target = 0;      ///< 34962 vertices, 34963 indices, 0 neither
};

/// A vector as a JSON array; a matrix as 16 numbers, columns first.
template<typename Vec> Json numbers(const Vec& v)
{
    Json list = Json::array();
    for (int i = 0; i < Vec::length(); ++i) list.push_back(v[i]);
    return list;
}
template<typename T> Json numbers(const glm::mat<4, 4, T>& m)
{
    Json list = Json::array();
    for (int i = 0; i < 16; ++i) list.push_back(m[i / 4][i % 4]);
    return list;
}

template<typename T> std::vector<std::byte> bytesOf(const std::vector<T>& values)
{
    const auto bytes = std::as_bytes(std::span(values));
    return {bytes.begin(), bytes.end()};
}

/// A finished document: one GLB, or JSON with its files beside it.
struct FinishedDocument {
    Json json;
    std::vector<std::byte> binary; ///< buffer 0
    struct File {
        std::string name; ///< also the image's uri
        std::vector<std::byte> bytes;
    };
    std::vector<File> images; ///< only where images were taken out
};

class DocumentPatcher {
public:
    explicit DocumentPatcher(const SourceDocument& source);

    Json json; ///< edit freely; indices of the functions below may be used wherever glTF wants one

    /// Adds binary data; the result is a buffer view's index, final only in the finished document.
    int addView(NewView view);
    int addAccessor(Json accessor, NewView view);
    /// Appends to a top-level array and returns the index.
    int append(const char* array, Json object);

    /// Replaces indices by final ones and drops what is no longer used. Images move into the binary chunk; with
    /// `imagePrefix` not empty, into files of their own, PREFIX_N.png and the like.
    FinishedDocument finish(const std::string& imagePrefix = {});

private:
    void collectReferences(const Json& document, std::set<int>& accessors, std::set<int>& views) const;
    void embedImages();
    std::vector<FinishedDocument::File> takeOutImages(const std::string& prefix);
    void place();
    std::vector<std::byte> assemble();

    const SourceDocument& source_;
    std::set<int> accessorsBefore_;
    std::set<int> viewsBefore_;
    std::vector<Json> newAccessors_;
    std::vector<NewView> newViews_;
    std::map<int, std::size_t> viewOf_; ///< final buffer view -> index into newViews_
};

/// JSON as files hold it; bytes of names that are not UTF-8 become U+FFFD.
std::string textOf(const Json& json);

/// A GLB from JSON and binary chunk; WriteFailed above the 4 GiB that the format allows.
Result<std::vector<std::byte>> makeGlb(const Json& json, std::span<const std::byte> binary);

/// "image/png" and the like from an encoded image's first bytes; empty when unknown.
std::string mimeTypeOf(std::span<const std::byte> image);

} // namespace halflight
