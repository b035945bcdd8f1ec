#include "bake/some_objects.h"

#include "halflight/base/bytes.h"
#include "halflight/scene/object_names.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <set>
#include <string_view>
#include <tuple>

namespace halflight {
namespace {

constexpr const char* kOwners = "owners";
constexpr const char* kBakeAll = ": bake the whole scene once with this cache";

int objectOf(const BakeGeometry& geometry, const TexelMap& map, const Texel& texel)
{
    const uint32_t triangle = map.fragments[texel.firstFragment].triangle;
    return geometry.partOf(triangle).object;
}

/// Of what a renamed object keeps.
Hash128 shapeHash(const Mesh& mesh)
{
    Hasher hasher;
    for (const MeshPart& part : mesh.parts) hasher.add(part.positions).add(part.indices);
    return hasher.hash();
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
    for (auto& [index, hasher] : hashers) {
        const Object& object = scene.objects[std::size_t(index)];
        owners_.push_back({object.name, hasher.hash(), shapeHash(scene.meshes[std::size_t(object.mesh)]), index});
    }
    for (const Light& light : scene.lights) {
        const int channel = light.baking.occlusionMaskChannel;
        for (int c = 0; channel >= 0 && c < (light.baking.coloredMask ? 3 : 1); ++c)
            masks_.emplace_back(light.name, channel + c);
    }
    std::sort(owners_.begin(), owners_.end(),
              [](const Owner& a, const Owner& b) { return std::tie(a.name, a.texels) < std::tie(b.name, b.texels); });
    std::sort(masks_.begin(), masks_.end());
}

void TexelOwners::keepIn(PartFolder& folder) const
{
    ByteWriter writer;
    writer.add(uint64_t(owners_.size()));
    for (const Owner& owner : owners_) writer(owner.name, owner.texels, owner.shape);
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
    const auto readAll = [&](auto& list, const auto& readOne) {
        uint64_t count = 0;
        reader.read(count);
        for (uint64_t i = 0; i < count && reader.ok(); ++i) readOne(list.emplace_back());
    };
    readAll(last.owners_, [&](Owner& owner) { reader(owner.name, owner.texels, owner.shape); });
    readAll(last.masks_, [&](auto& mask) { reader(mask.first, mask.second); });
    if (!reader.complete()) return missing;
    return last;
}

Status TexelOwners::compareObjects(const PartFolder& folder, const std::vector<uint8_t>& chosen) const
{
    const Result<TexelOwners> last = readFrom(folder);
    if (!last) return last.error();
    std::map<Hash128, const Owner*> ofTexels;
    std::set<std::string_view> names;
    for (const Owner& owner : last->owners_) {
        ofTexels[owner.texels] = &owner;
        names.insert(owner.name);
    }
    for (const Owner& owner : owners_) {
        if (chosen[std::size_t(owner.object)] != 0) continue;
        const auto found = ofTexels.find(owner.texels);
        const Owner* before = found == ofTexels.end() ? nullptr : found->second;
        const bool same = before != nullptr && before->name == owner.name;
        const bool renamed = before != nullptr && before->shape == owner.shape && !names.contains(owner.name);
        if (same || renamed) continue;
        return Error{ErrorCode::Unsupported,
                     "the last bake in the cache has no object '" + owner.name + "' at the same texels" + kBakeAll};
    }
    return {};
}

std::string TexelOwners::lightWithoutMask(const PartFolder& folder) const
{
    const Result<TexelOwners> last = readFrom(folder);
    for (const auto& mask : masks_) {
        if (!last || !std::binary_search(last->masks_.begin(), last->masks_.end(), mask)) return mask.first;
    }
    return {};
}

} // namespace halflight
