#include "halflight/scene/light_groups.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

namespace halflight {

namespace {

/// The light of a member as a colour and an intensity.
struct Member {
    vec3 color{0.0f};
    float intensity = 0.0f;

    [[nodiscard]] bool dark() const { return color * intensity == vec3(0.0f); }
};

Member memberOf(vec3 light)
{
    const float most = std::max({light.x, light.y, light.z});
    return most > 0.0f ? Member{light / most, most} : Member{};
}

/// Of a gradient, the largest of its colours by channel. A picture is white.
Member memberOf(const Sky& sky)
{
    if (sky.picture) return {vec3(1.0f), 1.0f};
    return memberOf(glm::max(glm::max(sky.zenith, sky.horizon), sky.ground));
}

/// The white light of a group's members.
class White {
public:
    void add(const Member& member)
    {
        if (!member.dark()) weight_ = glm::max(weight_, member.color);
    }
    [[nodiscard]] vec3 weight() const { return weight_; }
    /// Members that are dark stay so where others are lit: one weight serves all.
    [[nodiscard]] Member of(const Member& member) const
    {
        if (member.dark() && weight_ != vec3(0.0f)) return member;
        return {color(member.color), member.intensity > 0.0f ? member.intensity : 1.0f};
    }
    [[nodiscard]] vec3 color(vec3 color) const
    {
        vec3 white(1.0f);
        for (int c = 0; c < 3; ++c)
            if (weight_[c] > 0.0f) white[c] = color[c] / weight_[c];
        return white;
    }

private:
    vec3 weight_{0.0f};
};

class Grouper {
public:
    Grouper(Scene& scene, GroupChoice choice) : scene_(scene), choice_(choice) {}

    Result<LightGrouping> group()
    {
        grouping_.ofLight.assign(scene_.lights.size(), -1);
        grouping_.ofMaterial.assign(scene_.materials.size(), -1);
        findMembers();
        if (grouping_.groups.size() > kMostLightGroups) {
            return Error{ErrorCode::InvalidArgument,
                         "has " + std::to_string(grouping_.groups.size()) + " light groups, and a bake has at most " +
                             std::to_string(kMostLightGroups) + ": put lights into common groups, or bake with " +
                             "--groups off",
                         ""};
        }
        makeWhite();
        return std::move(grouping_);
    }

private:
    void findMembers()
    {
        if (choice_ == GroupChoice::Off) return;
        for (std::size_t i = 0; i < scene_.lights.size(); ++i) {
            const Light& light = scene_.lights[i];
            const std::string& name = choice_ == GroupChoice::Each ? light.name : light.group;
            if (light.mode != LightMode::Realtime) {
                grouping_.ofLight[i] = groupNamed(name, "light");
            } else if (!light.group.empty() && choice_ == GroupChoice::Authored) {
                scene_.warnings.push_back("light " + light.name +
                                          " is realtime, so that it is no member of the light " + "group \"" +
                                          light.group + "\"");
            }
        }
        const std::set<int> used = usedMaterials();
        for (std::size_t i = 0; i < scene_.materials.size(); ++i) {
            const Material& material = scene_.materials[i];
            const bool emits = material.emissiveNits != vec3(0.0f);
            if (!used.contains(int(i)) || (choice_ == GroupChoice::Each && !emits)) continue;
            grouping_.ofMaterial[i] =
                groupNamed(choice_ == GroupChoice::Each ? material.name : material.group, "material");
        }
        if (scene_.sky.changes) {
            addSkyParts();
        } else if (choice_ == GroupChoice::Authored) {
            grouping_.ofSky.fill(groupNamed(scene_.sky.group, "sky"));
        }
    }

    void addSkyParts()
    {
        if (!scene_.sky.group.empty())
            scene_.warnings.push_back("the sky changes, so that it is no member of the light group \"" +
                                      scene_.sky.group + "\"");
        for (std::size_t part = 0; part < kSkyParts.size(); ++part) {
            if (!scene_.sky.picture || part == 0)
                grouping_.groups.push_back({scene_.sky.picture ? kSkyPictureGroup : kSkyParts[part], vec3(0.0f)});
            grouping_.ofSky[part] = int(grouping_.groups.size()) - 1;
        }
    }

    /// Of the objects in the scene.
    [[nodiscard]] std::set<int> usedMaterials() const
    {
        std::set<int> used;
        for (const Object& object : scene_.objects)
            for (const MeshPart& part : scene_.meshes[std::size_t(object.mesh)].parts) used.insert(part.material);
        return used;
    }

    [[nodiscard]] bool isTaken(const std::string& name) const
    {
        return std::ranges::find(grouping_.groups, name, &LightGroup::name) != grouping_.groups.end();
    }

    /// -1 for the empty name. With GroupChoice::Each, each call makes a group, and names that are taken get a number.
    int groupNamed(const std::string& name, const std::string& kind)
    {
        if (choice_ == GroupChoice::Authored) {
            if (name.empty()) return -1;
            const auto same = std::ranges::find(grouping_.groups, name, &LightGroup::name);
            if (same != grouping_.groups.end()) return int(same - grouping_.groups.begin());
            grouping_.groups.push_back({name, vec3(0.0f)});
            return int(grouping_.groups.size()) - 1;
        }
        const std::string first = isGroupName(name) ? name : kind;
        std::string free = first;
        for (int n = 2; isTaken(free); ++n) free = first.substr(0, kMostGroupName - 6) + " " + std::to_string(n);
        grouping_.groups.push_back({free, vec3(0.0f)});
        return int(grouping_.groups.size()) - 1;
    }

    void makeWhite()
    {
        std::vector<White> white(grouping_.groups.size());
        const auto addTo = [&](int group, const Member& member) {
            if (group >= 0) white[std::size_t(group)].add(member);
        };
        for (std::size_t i = 0; i < scene_.lights.size(); ++i)
            addTo(grouping_.ofLight[i], {scene_.lights[i].color, scene_.lights[i].intensity});
        for (std::size_t i = 0; i < scene_.materials.size(); ++i)
            addTo(grouping_.ofMaterial[i], memberOf(scene_.materials[i].emissiveNits));
        if (!skyHasParts()) addTo(grouping_.ofSky[0], memberOf(scene_.sky));
        for (std::size_t i = 0; i < scene_.lights.size(); ++i) {
            Member light{scene_.lights[i].color, scene_.lights[i].intensity};
            if (const int group = grouping_.ofLight[i]; group >= 0) light = white[std::size_t(group)].of(light);
            grouping_.lights.push_back({light.color, light.intensity});
        }
        for (std::size_t i = 0; i < scene_.materials.size(); ++i) {
            vec3 nits = scene_.materials[i].emissiveNits;
            if (const int group = grouping_.ofMaterial[i]; group >= 0) {
                const Member emission = white[std::size_t(group)].of(memberOf(nits));
                nits = emission.color * emission.intensity;
            }
            grouping_.emission.push_back(nits);
        }
        grouping_.sky = scene_.sky;
        if (skyHasParts()) {
            makePartsWhite(white);
        } else if (grouping_.ofSky[0] >= 0) {
            grouping_.sky = whiteSky(white[std::size_t(grouping_.ofSky[0])]);
        }
        for (std::size_t g = 0; g < white.size(); ++g) grouping_.groups[g].weight = white[g].weight();
    }

    [[nodiscard]] bool skyHasParts() const { return grouping_.ofSky[0] != grouping_.ofSky[1]; }

    /// Each part is grey while it is baked, and 1 cd/m2 when the bake is finished.
    void makePartsWhite(std::vector<White>& white)
    {
        for (std::size_t part = 0; part < kSkyParts.size(); ++part) {
            const auto group = std::size_t(grouping_.ofSky[part]);
            vec3& color = *skyPartOf(grouping_.sky, kSkyParts[part]);
            const Member member = memberOf(color);
            white[group].add(member);
            const float nits = member.dark() ? 1.0f : member.intensity;
            color = vec3(nits);
            grouping_.groups[group].finished = 1.0f / nits;
        }
    }

    [[nodiscard]] Sky whiteSky(const White& white) const
    {
        const Sky& sky = scene_.sky;
        if (sky.picture) return scaledSky(sky, 1.0f / white.weight());
        const Member whole = memberOf(sky);
        const Member all = white.of(whole);
        Sky out = sky;
        if (all.dark()) return out;
        for (vec3* color : {&out.zenith, &out.horizon, &out.ground})
            *color = white.color(whole.dark() ? vec3(0.0f) : *color / whole.intensity) * all.intensity;
        return out;
    }

    Scene& scene_;
    GroupChoice choice_;
    LightGrouping grouping_;
};

} // namespace

bool isGroupName(std::string_view name)
{
    return !name.empty() && name.size() <= kMostGroupName && !name.starts_with("sky.") &&
           std::ranges::none_of(name, [](char c) { return static_cast<unsigned char>(c) < 32 || c == 127; });
}

const char* nameOf(GroupChoice choice)
{
    constexpr const char* kNames[] = {"authored", "each", "off"};
    return kNames[int(choice)];
}

void LightGrouping::exchange(Scene& scene)
{
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        if (ofLight[i] < 0) continue;
        std::swap(scene.lights[i].color, lights[i].color);
        std::swap(scene.lights[i].intensity, lights[i].intensity);
    }
    for (std::size_t i = 0; i < scene.materials.size(); ++i)
        if (ofMaterial[i] >= 0) std::swap(scene.materials[i].emissiveNits, emission[i]);
    if (ofSky[0] >= 0) std::swap(scene.sky, sky);
}

Result<LightGrouping> groupLights(Scene& scene, GroupChoice choice)
{
    return Grouper(scene, choice).group();
}

void groupEmission(Scene& scene, const std::vector<std::string>& groups)
{
    using Place = std::pair<int, std::string>;       // a mesh or a material, and a group
    std::map<int, std::set<std::string>> ofMaterial; // groups of its objects
    std::map<int, std::set<std::string>> ofMesh;
    const auto emits = [&](const MeshPart& part) { return materialOf(scene, part).emissiveNits != vec3(0.0f); };
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        const int mesh = scene.objects[i].mesh;
        ofMesh[mesh].insert(groups[i]);
        for (const MeshPart& part : scene.meshes[std::size_t(mesh)].parts)
            if (part.material >= 0 && emits(part)) ofMaterial[part.material].insert(groups[i]);
    }
    std::map<Place, int> materials;
    const auto materialIn = [&](int material, const std::string& group) {
        if (scene.materials[std::size_t(material)].group == group) return material;
        const auto [entry, isNew] = materials.try_emplace({material, group}, material);
        if (!isNew) return entry->second;
        if (ofMaterial[material].size() > 1) {
            entry->second = int(scene.materials.size());
            scene.materials.push_back(Material(scene.materials[std::size_t(material)]));
        }
        scene.materials[std::size_t(entry->second)].group = group;
        return entry->second;
    };
    std::map<Place, int> meshes;
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        const std::string& group = groups[i];
        int& mesh = scene.objects[i].mesh;
        const std::vector<MeshPart>& parts = scene.meshes[std::size_t(mesh)].parts;
        if (group.empty() || std::ranges::none_of(parts, emits)) continue;
        const auto [entry, isNew] = meshes.try_emplace({mesh, group}, mesh);
        if (isNew) {
            if (ofMesh[mesh].size() > 1) {
                entry->second = int(scene.meshes.size());
                scene.meshes.push_back(Mesh(scene.meshes[std::size_t(mesh)]));
            }
            for (MeshPart& part : scene.meshes[std::size_t(entry->second)].parts)
                if (part.material >= 0 && emits(part)) part.material = materialIn(part.material, group);
        }
        mesh = entry->second;
    }
}

vec3* skyPartOf(Sky& sky, std::string_view group)
{
    const std::array<vec3*, 3> colors = {&sky.zenith, &sky.horizon, &sky.ground};
    const auto part = std::ranges::find(kSkyParts, group);
    return part == kSkyParts.end() ? nullptr : colors[std::size_t(part - kSkyParts.begin())];
}

Sky scaledSky(const Sky& sky, vec3 factor)
{
    Sky out = sky;
    if (factor == vec3(1.0f)) return out;
    for (vec3* color : {&out.zenith, &out.horizon, &out.ground}) *color *= factor;
    if (!sky.picture) return out;
    ImageRgb32f picture = *sky.picture;
    for (vec3& texel : picture.texels()) texel *= factor;
    out.picture = std::make_shared<const ImageRgb32f>(std::move(picture));
    return out;
}

vec3 skyFactor(vec3 saved, vec3 weight)
{
    vec3 factor(0.0f);
    for (int c = 0; c < 3; ++c)
        if (saved[c] > 0.0f) factor[c] = weight[c] / saved[c];
    return factor;
}

Sky skyAtWeight(const Sky& sky, vec3 saved, vec3 weight)
{
    if (weight == saved) return sky;
    Sky out = scaledSky(sky, skyFactor(saved, weight));
    const Member member = memberOf(sky);
    if (sky.picture || (member.dark() && saved != vec3(0.0f))) return out;
    // A channel in which the whole group was black is 1 in White, and as bright as the brightest one.
    const float intensity = member.dark() ? 1.0f : member.intensity;
    for (int c = 0; c < 3; ++c)
        if (!(saved[c] > 0.0f))
            for (vec3* color : {&out.zenith, &out.horizon, &out.ground}) (*color)[c] = intensity * weight[c];
    return out;
}

} // namespace halflight
