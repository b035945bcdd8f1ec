#include "scene/write/write_pictures.h"

#include "halflight/base/image.h"

#include <algorithm>

namespace halflight {

namespace {

// All images that a texture names.
std::vector<int> imagesOf(const Json& texture)
{
    std::vector<int> images;
    const auto add = [&](const Json& holder) {
        const Json& source = member(holder, "source");
        if (source.is_number_unsigned()) images.push_back(source.get<int>());
    };
    add(texture);
    for (const Json& extension : member(texture, "extensions")) add(extension);
    return images;
}

} // namespace

PictureWriter::PictureWriter(DocumentPatcher& patcher, const SourceDocument& source) : patcher_(patcher)
{
    const Json& root = extensionOf(source.json, "HALFLIGHT_mixed_lighting");
    const Json& textures = member(source.json, "textures");
    std::set<int> ofBake;
    for (const Json& reference : pictureReferences(root)) {
        const Json& index = member(reference, "index");
        if (isIndexInto(source.json, "textures", index)) ofBake.insert(index.get<int>());
    }
    std::set<int> images;
    std::set<int> othersImages;
    for (std::size_t i = 0; i < textures.size(); ++i) {
        const std::vector<int> named = imagesOf(textures[i]);
        (ofBake.contains(int(i)) ? images : othersImages).insert(named.begin(), named.end());
    }
    freeTextures_.assign(ofBake.rbegin(), ofBake.rend());
    std::set_difference(images.rbegin(), images.rend(), othersImages.rbegin(), othersImages.rend(),
                        std::back_inserter(freeImages_), std::greater<>());
}

int PictureWriter::place(const char* array, std::vector<int>& free, Json object)
{
    if (free.empty()) return patcher_.append(array, std::move(object));
    const int index = free.back();
    free.pop_back();
    patcher_.json[array][std::size_t(index)] = std::move(object);
    return index;
}

// A grey texel, the source of textures whose picture only an extension may name: loaders that load all textures, and
// libraries that require a source, read this.
int PictureWriter::placeholder()
{
    if (placeholder_ < 0) {
        auto png = encodePng(ImageRgba8(1, 1, u8vec4(128, 128, 128, 255)));
        if (!png) return -1;
        placeholder_ = place("images", freeImages_,
                             {{"name", "Halflight placeholder"},
                              {"mimeType", "image/png"},
                              {"bufferView", patcher_.addView({std::move(*png), 0, 0})}});
    }
    return placeholder_;
}

int PictureWriter::sampler(Wrap wrap)
{
    const Json wanted = {{"magFilter", gltf::kLinear},
                         {"minFilter", gltf::kLinear},
                         {"wrapS", wrap == Wrap::Clamp ? gltf::kClampToEdge : gltf::kRepeat},
                         {"wrapT", gltf::kClampToEdge}};
    const Json& samplers = member(patcher_.json, "samplers");
    const auto same = std::find(samplers.begin(), samplers.end(), wanted);
    return same != samplers.end() ? int(same - samplers.begin()) : patcher_.append("samplers", wanted);
}

Json PictureWriter::add(const std::string& name, std::vector<std::byte> bytes, Wrap wrap)
{
    const std::string mime = mimeTypeOf(bytes);
    const int image = place("images", freeImages_,
                            {{"name", "Halflight " + name},
                             {"mimeType", mime},
                             {"bufferView", patcher_.addView({std::move(bytes), 0, 0})}});
    Json texture = {{"name", "Halflight " + name}, {"sampler", sampler(wrap)}};
    if (mime == "image/png") {
        texture["source"] = image;
    } else {
        const char* extension = mime == "image/webp" ? "EXT_texture_webp" : kKtx2Extension;
        texture["extensions"][extension] = {{"source", image}};
        extensions_.insert(extension);
        if (const int source = placeholder(); source >= 0) texture["source"] = source;
    }
    return {{"index", place("textures", freeTextures_, std::move(texture))}};
}

void PictureWriter::removeLast(const char* array, std::vector<int>& free)
{
    Json& list = patcher_.json[array];
    while (!free.empty() && std::size_t(free.front()) + 1 == list.size()) {
        list.erase(list.size() - 1);
        free.erase(free.begin());
    }
    if (list.empty()) patcher_.json.erase(array);
}

void PictureWriter::finish()
{
    removeLast("textures", freeTextures_);
    removeLast("images", freeImages_);
    while (!freeTextures_.empty()) {
        const int source = placeholder();
        place("textures", freeTextures_, source >= 0 ? Json{{"source", source}} : Json::object());
    }
    while (!freeImages_.empty()) {
        const Json same = patcher_.json["images"][std::size_t(std::max(placeholder(), 0))];
        place("images", freeImages_, same);
    }
}

} // namespace halflight
