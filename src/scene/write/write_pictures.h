#pragma once
// The bake's pictures in a document: glTF textures and images like any other.

#include "scene/document/patcher.h"
#include "scene/format/picture_references.h"

#include <string>
#include <string_view>
#include <vector>

namespace halflight {

class PictureWriter {
public:
    /// Textures and images of an earlier bake in `source` give their places to the new ones, as no index may shift.
    PictureWriter(DocumentPatcher& patcher, const SourceDocument& source);

    enum class Wrap { Clamp, RepeatAcross };
    /// Adds an encoded KTX2, PNG or WebP image and its texture; the result is a reference {index} to the texture.
    Json add(const std::string& name, std::vector<std::byte> bytes, Wrap wrap = Wrap::Clamp);
    /// Takes out places of an earlier bake that are left: to be called once, after the last add().
    void finish();

    /// Extensions that the pictures use.
    [[nodiscard]] const std::set<std::string>& extensions() const { return extensions_; }

private:
    int place(const char* array, std::vector<int>& free, Json object);
    int placeholder();
    int sampler(Wrap wrap);
    void removeLast(const char* array, std::vector<int>& free);

    DocumentPatcher& patcher_;
    std::vector<int> freeTextures_; ///< descending
    std::vector<int> freeImages_;
    std::set<std::string> extensions_;
    int placeholder_ = -1;
};

} // namespace halflight
