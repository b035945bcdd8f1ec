#include "halflight/scene/light_groups.h"

#include "halflight/scene/turning_lights.h"
#include "scene/model/pose.h"

#include <algorithm>
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
    Grouper(Scene& scene, GroupChoice choice, MixedLightingMode mode) : scene_(scene), choice_(choice), mode_(mode) {}

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
            if (canTurn(light)) continue;
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
        for (std::size_t i = 0; i < scene_.lights.size(); ++i) addDirections(i);
    }

    [[nodiscard]] bool canTurn(const Light& light) const
    {
        return !light.directions.empty() && light.type == LightType::Directional && light.mode == LightMode::Mixed &&
               mode_ != MixedLightingMode::Subtractive;
    }

    /// Groups of a light that turns.
    void addDirections(std::size_t index)
    {
        const Light& light = scene_.lights[index];
        if (light.directions.empty()) return;
        const std::string name = "light " + light.name;
        if (!canTurn(light)) {
            scene_.warnings.push_back(
                name +
                (light.mode == LightMode::Mixed
                     ? " has halflight_directions, which have no effect: subtractive bakes hold its direct light; "
                       "bake with --mode shadowmask or baked-indirect"
                     : std::string(" is ") + nameOf(light.mode) + ", so that its halflight_directions have no " +
                           "effect: make it mixed"));
            return;
        }
        if (!light.group.empty())
            scene_.warnings.push_back(name + " turns, so that it is no member of the light group \"" + light.group +
                                      "\": each of its directions is a group");
        for (std::string& sentence : sparseDirections(light)) scene_.warnings.push_back(std::move(sentence));
        grouping_.turning.push_back({index, grouping_.groups.size(), light.worldFromLight});
        const std::string base = freeBase(light);
        for (std::size_t d = 0; d < light.directions.size(); ++d)
            grouping_.groups.push_back({nameOfDirection(base, d), vec3(0.0f)});
    }

    /// The light's name, or another one of which no group begins.
    [[nodiscard]] std::string freeBase(const Light& light) const
    {
        const std::string last = nameOfDirection(light.name, kMostDirections - 1);
        const std::string first = isGroupName(last) ? light.name : "light";
        const auto taken = [&](const std::string& base) {
            return std::ranges::any_of(grouping_.groups, [&](const LightGroup& group) {
                return group.name == base || group.name.starts_with(base + ".");
            });
        };
        std::string base = first;
        for (int n = 2; taken(base); ++n) base = first.substr(0, kMostGroupName - 9) + " " + std::to_string(n);
        return base;
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
        for (const LightGrouping::Turning& turning : grouping_.turning) {
            const Light& light = scene_.lights[turning.light];
            addTo(int(turning.firstGroup), {light.color, light.intensity});
        }
        for (std::size_t i = 0; i < scene_.lights.size(); ++i) {
            Member light{scene_.lights[i].color, scene_.lights[i].intensity};
            if (const int group = whiteOf(i); group >= 0) light = white[std::size_t(group)].of(light);
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
        for (const LightGrouping::Turning& turning : grouping_.turning) {
            const Light& light = scene_.lights[turning.light];
            const std::vector<float> shares = weightsOfDirections(light.directions, light.direction());
            const vec3 all = white[turning.firstGroup].weight();
            for (std::size_t d = 0; d < shares.size(); ++d)
                grouping_.groups[turning.firstGroup + d].weight = shares[d] * all;
        }
    }

    /// The group that has the white of a light.
    [[nodiscard]] int whiteOf(std::size_t light) const
    {
        const auto turning = std::ranges::find(grouping_.turning, light, &LightGrouping::Turning::light);
        return turning != grouping_.turning.end() ? int(turning->firstGroup) : grouping_.ofLight[light];
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
    MixedLightingMode mode_;
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
    for (std::size_t i = 0; i < scene.lights.size(); ++i) { // of others, the light is the same
        std::swap(scene.lights[i].color, lights[i].color);
        std::swap(scene.lights[i].intensity, lights[i].intensity);
    }
    for (std::size_t i = 0; i < scene.materials.size(); ++i)
        if (ofMaterial[i] >= 0) std::swap(scene.materials[i].emissiveNits, emission[i]);
    if (ofSky[0] >= 0) std::swap(scene.sky, sky);
}

void LightGrouping::spread(Scene& scene)
{
    for (const Turning& of : turning) {
        const std::vector<vec3> directions = scene.lights[of.light].directions;
        for (std::size_t d = 0; d < directions.size(); ++d) {
            const std::size_t place = d == 0 ? of.light : scene.lights.size();
            if (d > 0) {
                scene.lights.push_back(Light(scene.lights[of.light]));
                ofLight.push_back(-1);
            }
            Light& light = scene.lights[place];
            light.worldFromLight = poseLookingAlong(light.position(), directions[d]);
            light.baking.turning = {int(of.firstGroup), d == 0 ? directions : std::vector<vec3>()};
            ofLight[place] = int(of.firstGroup + d);
        }
    }
}

void LightGrouping::gather(Scene& scene)
{
    scene.lights.resize(lights.size());
    ofLight.resize(lights.size());
    for (const Turning& of : turning) {
        Light& light = scene.lights[of.light];
        light.worldFromLight = light.baking.worldFromLight = of.worldFromLight;
        ofLight[of.light] = -1;
    }
}

Result<LightGrouping> groupLights(Scene& scene, GroupChoice choice, MixedLightingMode mode)
{
    return Grouper(scene, choice, mode).group();
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
