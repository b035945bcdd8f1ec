#include "bake/some_objects.h"

#include "halflight/base/bytes.h"
#include "halflight/scene/object_names.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <string_view>

namespace halflight {
namespace {

constexpr const char* kOwners = "owners";
constexpr const char* kBakeAll = ": bake the whole scene once with this cache";

int objectOf(const BakeGeometry& geometry, const TexelMap& map, const Texel& texel)
{
    const uint32_t triangle = map.fragments[texel.firstFragment].triangle;
    return geometry.parts[geometry.partOfTriangle[triangle]].object;
}

Error noObject(std::string_view name)
{
    return {ErrorCode::InvalidArgument, "no object or node with objects is called '" + std::string(name) + "'"};
}

} // namespace

Result<std::vector<uint8_t>> chosenObjects(const Scene& scene, const std::vector<std::string>& only)
{
    std::vector<uint8_t> chosen(scene.objects.size(), 0);
    const auto choose = [&](std::string_view name) {
        const std::vector<std::size_t> found = objectsNamed(scene, name);
        for (const std::size_t i : found) chosen[i] = 1;
        return !found.empty();
    };
    for (const std::string& entry : only) {
        if (choose(entry)) continue;
        std::string_view rest = entry;
        if (rest.find(',') == std::string_view::npos) return noObject(rest);
        while (!rest.empty()) {
            const std::string_view name = rest.substr(0, rest.find(','));
            rest.remove_prefix(std::min(rest.size(), name.size() + 1));
            if (!choose(name)) return noObject(name);
        }
    }
    return chosen;
}

Result<std::vector<uint8_t>> chosenTexels(const BakeGeometry& geometry, const TexelMap& map,
                                          const std::vector<uint8_t>& objects)
{
    std::vector<uint8_t> chosen(map.texels.size(), 0);
    for (std::size_t i = 0; i < chosen.size(); ++i)
        chosen[i] = objects[std::size_t(objectOf(geometry, map, map.texels[i]))];
    if (std::find(chosen.begin(), chosen.end(), uint8_t(1)) == chosen.end())
        return Error{ErrorCode::InvalidArgument, "none of the objects to bake has lightmap texels"};
    return chosen;
}

TexelOwners::TexelOwners(const Scene& scene, const BakeGeometry& geometry, const TexelMap& map)
{
    std::map<int, Hasher> hashers;
    for (const Texel& texel : map.texels)
        hashers[objectOf(geometry, map, texel)].add(texel.x).add(texel.y).add(texel.page);
    for (auto& [object, hasher] : hashers) owners_.emplace_back(scene.objects[std::size_t(object)].name, hasher.hash());
    for (const Light& light : scene.lights) {
        const int channel = light.baking.occlusionMaskChannel;
        if (channel >= 0) masks_.emplace_back(light.name, channel);
    }
    std::sort(owners_.begin(), owners_.end());
    std::sort(masks_.begin(), masks_.end());
}

void TexelOwners::keepIn(PartFolder& folder) const
{
    ByteWriter writer;
    writer.add(uint64_t(owners_.size()));
    for (const auto& [object, texels] : owners_) writer(object, texels);
    writer.add(uint64_t(masks_.size()));
    for (const auto& [light, channel] : masks_) writer(light, channel);
    folder.write(kOwners, writer.take());
}

Result<TexelOwners> TexelOwners::readFrom(const PartFolder& folder)
{
    const Error missing{ErrorCode::Unsupported,
                        "the last bake in the cache has no list of its objects" + std::string(kBakeAll)};
    const std::optional<std::vector<std::byte>> bytes = folder.read(kOwners);
    if (!bytes) return missing;
    TexelOwners last;
    ByteReader reader(*bytes);
    const auto readAll = [&](auto& list) {
        uint64_t count = 0;
        reader.read(count);
        for (uint64_t i = 0; i < count && reader.ok(); ++i) {
            auto& [name, value] = list.emplace_back();
            reader(name, value);
        }
    };
    readAll(last.owners_);
    readAll(last.masks_);
    if (!reader.complete()) return missing;
    return last;
}

Status TexelOwners::compareWith(const PartFolder& folder) const
{
    const Result<TexelOwners> last = readFrom(folder);
    if (!last) return last.error();
    const auto lacks = [](const auto& all) {
        return [&all](const auto& one) { return !std::binary_search(all.begin(), all.end(), one); };
    };
    const auto owner = std::find_if(owners_.begin(), owners_.end(), lacks(last->owners_));
    if (owner != owners_.end()) {
        return Error{ErrorCode::Unsupported,
                     "the last bake in the cache has no object '" + owner->first + "' at the same texels" + kBakeAll};
    }
    const auto mask = std::find_if(masks_.begin(), masks_.end(), lacks(last->masks_));
    if (mask != masks_.end()) {
        return Error{ErrorCode::Unsupported, "the last bake in the cache has no mask of the light '" + mask->first +
                                                 "' in the same channel" + kBakeAll};
    }
    return {};
}

} // namespace halflight
