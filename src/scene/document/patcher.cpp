#include "scene/document/patcher.h"

#include "scene/document/references.h"
#include "scene/document/uri.h"

#include <algorithm>
#include <cstring>
#include <string_view>

namespace halflight {

namespace {
// Indices of things that have no place yet.
constexpr int kNewBase = 1 << 30;

// Indices set by this program are signed integers to nlohmann's JSON, those of a file unsigned ones.
bool isNew(const Json& index)
{
    return index.is_number_integer() && index.get<int64_t>() >= kNewBase;
}
bool isOld(const Json& index)
{
    return index.is_number_integer() && index.get<int64_t>() >= 0 && index.get<int64_t>() < kNewBase;
}

// Unsigned integers inside extensions that this program does not know: any of them may be a reference.
void collectUnknown(const Json& json, bool unknown, std::set<int>& integers)
{
    constexpr std::string_view kKnown[] = {"KHR_lights_punctual", "EXT_lights_area",         "KHR_texture_transform",
                                           "KHR_node_visibility", "EXT_mesh_gpu_instancing", "KHR_mesh_quantization",
                                           "KHR_xmp_json_ld",     "EXT_texture_webp"};
    if (unknown && isOld(json)) integers.insert(json.get<int>());
    if (json.is_array()) {
        for (const Json& item : json) collectUnknown(item, unknown, integers);
    } else if (json.is_object()) {
        for (const auto& [key, value] : json.items()) {
            if (key == "extras") continue;
            if (key != "extensions" || !value.is_object()) {
                collectUnknown(value, unknown, integers);
                continue;
            }
            for (const auto& [name, extension] : value.items()) {
                const std::string_view n = name;
                const bool known = std::find(std::begin(kKnown), std::end(kKnown), n) != std::end(kKnown) ||
                                   n.starts_with("HALFLIGHT_") || n.starts_with("MOZ_") ||
                                   n.starts_with("KHR_materials_");
                collectUnknown(extension, unknown || !known, integers);
            }
        }
    }
}

} // namespace

DocumentPatcher::DocumentPatcher(const SourceDocument& source) : json(source.json), source_(source)
{
    collectReferences(json, accessorsBefore_, viewsBefore_);
}

void DocumentPatcher::collectReferences(const Json& document, std::set<int>& accessors, std::set<int>& views) const
{
    auto& mutableDocument = const_cast<Json&>(document); // the visitors below only read
    visitAccessors(mutableDocument, [&](Json& index) {
        if (isOld(index)) accessors.insert(index.get<int>());
    });
    visitViews(mutableDocument, [&](Json& index) {
        if (isOld(index)) views.insert(index.get<int>());
    });
}

int DocumentPatcher::addView(NewView view)
{
    newViews_.push_back(std::move(view));
    return kNewBase + int(newViews_.size()) - 1;
}

int DocumentPatcher::addAccessor(Json accessor, NewView view)
{
    accessor["bufferView"] = addView(std::move(view));
    newAccessors_.push_back(std::move(accessor));
    return kNewBase + int(newAccessors_.size()) - 1;
}

int DocumentPatcher::append(const char* array, Json object)
{
    Json& list = json[array];
    if (!list.is_array()) list = Json::array();
    list.push_back(std::move(object));
    return int(list.size()) - 1;
}

void DocumentPatcher::embedImages()
{
    Json* images = find(json, "images");
    if (images == nullptr) return;
    std::map<std::string, int> viewOfUri; // images may share a file
    for (std::size_t i = 0; i < images->size(); ++i) {
        Json& image = (*images)[i];
        if (!image.contains("uri") || i >= member(source_.json, "images").size()) continue;
        const std::string uri = member(image, "uri").dump();
        auto bytes = imageBytes(source_, int(i));
        if (!bytes) continue; // an image that no material uses may be missing: it stays as it is
        std::string mime = mimeTypeOf(*bytes);
        if (mime.empty()) continue;
        image.erase("uri");
        image["mimeType"] = mime;
        const auto [view, isNew] = viewOfUri.try_emplace(uri, 0);
        if (isNew) view->second = addView({std::move(*bytes), 0, 0});
        image["bufferView"] = view->second;
    }
}

std::vector<FinishedDocument::File> DocumentPatcher::takeOutImages(const std::string& prefix)
{
    std::vector<FinishedDocument::File> files;
    std::map<std::string, std::string> nameOf; // by the image's place in the source: images may share it
    Json* images = find(json, "images");
    const std::size_t sourceImages = member(source_.json, "images").size();
    for (std::size_t i = 0; images != nullptr && i < std::min(images->size(), sourceImages); ++i) {
        if (isNew(member((*images)[i], "bufferView"))) continue; // the bake's own, in a place of an earlier bake
        auto bytes = imageBytes(source_, int(i));
        if (!bytes) continue; // an image that no material uses may be missing: it stays as it is
        const std::string mime = mimeTypeOf(*bytes);
        if (mime.empty()) continue;
        const std::string extension = mime == "image/jpeg" ? "jpg" : mime.substr(mime.find('/') + 1);
        Json& image = (*images)[i];
        const std::string place = member(image, "bufferView").dump() + member(image, "uri").dump();
        const auto [it, isNew] = nameOf.try_emplace(place, prefix + "_" + std::to_string(i) + "." + extension);
        const std::string name = it->second;
        image.erase("bufferView");
        image.erase("mimeType");
        image["uri"] = percentEncoded(name);
        if (isNew) files.push_back({name, std::move(*bytes)});
    }
    return files;
}

// Gives every new accessor and view a place: first those that fell vacant, then new ones at the end.
void DocumentPatcher::place()
{
    std::set<int> unknown;
    collectUnknown(json, false, unknown);
    const auto vacant = [&](const std::set<int>& before, const std::set<int>& now) {
        std::vector<int> free;
        for (const int index : before) {
            if (now.count(index) == 0 && unknown.count(index) == 0) free.push_back(index);
        }
        return free;
    };
    // Fills `free` and then the end of json[array]; vacant places that are left become `empty`, or go where they are
    // last.
    const auto fill = [&](const char* array, std::vector<int> free, std::size_t count, const auto& objectAt,
                          const Json& empty) {
        std::vector<int> places;
        Json& list = json[array];
        if (!list.is_array()) list = Json::array();
        free.erase(std::remove_if(free.begin(), free.end(), [&](int i) { return std::size_t(i) >= list.size(); }),
                   free.end());
        for (std::size_t i = 0; i < count; ++i) {
            if (i < free.size()) {
                list[std::size_t(free[i])] = objectAt(i);
                places.push_back(free[i]);
            } else {
                places.push_back(int(list.size()));
                list.push_back(objectAt(i));
            }
        }
        for (std::size_t i = free.size(); i-- > count;) {
            if (std::size_t(free[i]) + 1 == list.size()) {
                list.erase(list.size() - 1);
            } else {
                list[std::size_t(free[i])] = empty;
            }
        }
        if (list.empty()) json.erase(array);
        return places;
    };

    std::set<int> accessorsNow;
    std::set<int> ignored;
    collectReferences(json, accessorsNow, ignored);
    // An accessor without data is all zeros.
    const Json emptyAccessor = {{"componentType", gltf::kUnsignedByte}, {"count", 1}, {"type", "SCALAR"}};
    const auto accessorPlaces = fill(
        "accessors", vacant(accessorsBefore_, accessorsNow), newAccessors_.size(),
        [&](std::size_t i) { return newAccessors_[i]; }, emptyAccessor);
    visitAccessors(json, [&](Json& index) {
        if (isNew(index)) index = accessorPlaces[index.get<std::size_t>() - std::size_t(kNewBase)];
    });

    std::set<int> viewsNow;
    collectReferences(json, ignored, viewsNow);
    const auto viewObject = [&](std::size_t i) {
        Json view = {{"buffer", 0}, {"byteLength", newViews_[i].bytes.size()}};
        if (newViews_[i].strideBytes > 0) view["byteStride"] = newViews_[i].strideBytes;
        if (newViews_[i].target > 0) view["target"] = newViews_[i].target;
        return view;
    };
    const Json emptyView = {{"buffer", 0}, {"byteLength", 1}, {"byteOffset", 0}};
    const auto viewPlaces =
        fill("bufferViews", vacant(viewsBefore_, viewsNow), newViews_.size(), viewObject, emptyView);
    visitViews(json, [&](Json& index) {
        if (isNew(index)) index = viewPlaces[index.get<std::size_t>() - std::size_t(kNewBase)];
    });
    for (std::size_t i = 0; i < viewPlaces.size(); ++i) viewOf_[viewPlaces[i]] = i;
}

// One binary chunk of what the views refer to. Source views that overlap (interleaved attributes, say) stay together.
std::vector<std::byte> DocumentPatcher::assemble()
{
    constexpr std::size_t kAlignment = 16;
    std::vector<std::byte> binary;
    const auto alignTo = [&](std::size_t remainder) {
        while (binary.size() % kAlignment != remainder) binary.push_back(std::byte(0));
    };
    Json* views = find(json, "bufferViews");
    if (views == nullptr) return binary;

    struct Range {
        int buffer;
        std::size_t begin, end;
        std::vector<std::size_t> views;
    };
    std::vector<Range> ranges;
    const std::size_t sourceViews = member(source_.json, "bufferViews").size();
    for (std::size_t i = 0; i < views->size(); ++i) {
        if (viewOf_.count(int(i)) != 0 || i >= sourceViews) continue;
        const Json& view = (*views)[i];
        const auto begin = view.value("byteOffset", std::size_t(0));
        ranges.push_back({view.value("buffer", 0), begin, begin + view["byteLength"].get<std::size_t>(), {i}});
    }
    std::stable_sort(ranges.begin(), ranges.end(), [](const Range& a, const Range& b) {
        return a.buffer != b.buffer ? a.buffer < b.buffer : a.begin < b.begin;
    });
    std::vector<Range> merged;
    for (Range& range : ranges) {
        if (!merged.empty() && merged.back().buffer == range.buffer && range.begin < merged.back().end) {
            merged.back().end = std::max(merged.back().end, range.end);
            merged.back().views.push_back(range.views[0]);
        } else {
            merged.push_back(std::move(range));
        }
    }
    for (const Range& range : merged) {
        const std::byte* bytes = source_.buffers[std::size_t(range.buffer)].data();
        alignTo(range.begin % kAlignment);
        const std::size_t start = binary.size();
        binary.insert(binary.end(), bytes + range.begin, bytes + range.end);
        for (const std::size_t view : range.views) {
            Json& object = (*views)[view];
            object["byteOffset"] = start + (object.value("byteOffset", std::size_t(0)) - range.begin);
            object["buffer"] = 0;
        }
    }
    for (const auto& [view, index] : viewOf_) {
        alignTo(0);
        (*views)[std::size_t(view)]["byteOffset"] = binary.size();
        binary.insert(binary.end(), newViews_[index].bytes.begin(), newViews_[index].bytes.end());
    }
    return binary;
}

FinishedDocument DocumentPatcher::finish(const std::string& imagePrefix)
{
    FinishedDocument document;
    if (imagePrefix.empty()) {
        embedImages();
    } else {
        document.images = takeOutImages(imagePrefix);
    }
    place();
    document.binary = assemble();
    if (document.binary.empty()) {
        json.erase("buffers");
    } else {
        json["buffers"] = Json::array({{{"byteLength", document.binary.size()}}});
    }
    document.json = std::move(json);
    return document;
}

std::string textOf(const Json& json)
{
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Result<std::vector<std::byte>> makeGlb(const Json& json, std::span<const std::byte> binary)
{
    std::string text = textOf(json);
    while (text.size() % 4 != 0) text += ' ';
    const std::size_t binaryBytes = (binary.size() + 3) / 4 * 4;
    const std::size_t total = 12 + 8 + text.size() + (binary.empty() ? 0 : 8 + binaryBytes);
    if (total > std::numeric_limits<uint32_t>::max()) {
        return Error{ErrorCode::WriteFailed, "the file would be larger than the 4 GiB that GLB allows"};
    }
    std::vector<std::byte> glb;
    glb.reserve(total);
    const auto u32 = [&](std::size_t value) {
        for (int i = 0; i < 4; ++i) glb.push_back(std::byte(value >> (8 * i) & 0xff));
    };
    u32(0x46546C67);
    u32(2);
    u32(total);
    u32(text.size());
    u32(0x4E4F534A);
    const auto* characters = reinterpret_cast<const std::byte*>(text.data());
    glb.insert(glb.end(), characters, characters + text.size());
    if (!binary.empty()) {
        u32(binaryBytes);
        u32(0x004E4942);
        glb.insert(glb.end(), binary.begin(), binary.end());
        glb.resize(total);
    }
    return glb;
}

std::string mimeTypeOf(std::span<const std::byte> image)
{
    const auto startsWith = [&](std::string_view magic, std::size_t offset = 0) {
        return image.size() >= offset + magic.size() &&
               std::memcmp(image.data() + offset, magic.data(), magic.size()) == 0;
    };
    if (startsWith("\x89PNG")) return "image/png";
    if (startsWith("\xFF\xD8\xFF")) return "image/jpeg";
    if (startsWith("RIFF") && startsWith("WEBP", 8)) return "image/webp";
    if (startsWith("KTX 20", 1)) return "image/ktx2";
    return "";
}

} // namespace halflight
