#pragma once
// Light groups (spec S33): sets of lights, emissive materials and the sky whose light a bake stores by itself.

#include "halflight/base/result.h"
#include "halflight/scene/scene.h"

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace halflight {

/// Groups of a file. What is in none is the rest.
constexpr std::size_t kMostLightGroups = 16;
constexpr std::size_t kMostGroupName = 64; ///< bytes

/// 1 to kMostGroupName bytes without control characters. Names that begin with "sky." are kept for parts of the sky.
bool isGroupName(std::string_view name);
constexpr const char* kGroupNames = "a name of 1 to 64 characters that does not begin with \"sky.\"";

/// Authored: as the scene says. Each: every light and emissive material is a group. Off: there are no groups.
enum class GroupChoice { Authored, Each, Off };
/// As --groups has it: "authored", "each", "off".
const char* nameOf(GroupChoice choice);

/// Groups of a sky that changes (spec S34). Weights of a gradient's colours are their radiances in cd/m2. A picture is
/// one group.
constexpr std::array<const char*, 3> kSkyParts = {"sky.zenith", "sky.horizon", "sky.ground"};
constexpr const char* kSkyPictureGroup = "sky.picture";
/// The colour of a gradient that a group of that name is; null for other names.
vec3* skyPartOf(Sky& sky, std::string_view group);

struct LightGroup {
    std::string name;
    /// By channel, what the group's light is multiplied by. In a bake, that of the lights as they are in the scene.
    vec3 weight{1.0f};
    /// What white light of the finished bake is over that which is baked: parts of the sky are baked as bright as they
    /// are, so that samples go where light is.
    float finished = 1.0f;
};

/// Which group each source of light belongs to, and its white light. A group is baked in white: colours are over the
/// largest of the group by channel, the group's weight. They are 1 in a channel in which the group is black. A group
/// that is all dark has the weight 0, and its members the intensity 1.
struct LightGrouping {
    std::vector<LightGroup> groups;
    std::vector<int> ofLight;             ///< by Scene::lights; -1 = the rest
    std::vector<int> ofMaterial;          ///< by Scene::materials
    std::array<int, 3> ofSky{-1, -1, -1}; ///< zenith, horizon and ground; of pictures all the same

    struct LightValue {
        vec3 color{1.0f};
        float intensity = 1.0f;
    };
    std::vector<LightValue> lights; ///< by Scene::lights
    /// Lights that turn (spec S34, turning_lights.h) are in no group by themselves. They have one for each direction.
    struct Turning {
        std::size_t light = 0;
        std::size_t firstGroup = 0;
        mat4 worldFromLight{1.0f}; ///< pose in the scene
    };
    std::vector<Turning> turning;
    std::vector<vec3> emission; ///< nits, by Scene::materials
    Sky sky;

    /// Exchanges the light of the scene's sources with that of this grouping: white by the first call, as the scene had
    /// it by the second.
    void exchange(Scene& scene);
    /// Puts a light for each direction in the place of every light that turns: the first where it was, the others at
    /// the end. `ofLight` has their groups.
    void spread(Scene& scene);
    /// Takes them away again. `lights` and `ofLight` are those of the scene's own lights.
    void gather(Scene& scene);
};

/// Sources without baked light are in no group. Adds warnings of them to the scene's. InvalidArgument where there are
/// more than kMostLightGroups. Light::directions count in modes whose direct light is of run time.
Result<LightGrouping> groupLights(Scene& scene, GroupChoice choice,
                                  MixedLightingMode mode = MixedLightingMode::Shadowmask);

/// Gives materials that emit the groups of their objects' nodes. A material of several groups becomes several, and so
/// does a mesh. `groups`: by object; empty = the node has none.
void groupEmission(Scene& scene, const std::vector<std::string>& groups);

/// The sky with its light times a colour.
Sky scaledSky(const Sky& sky, vec3 factor);

/// What a sky in a group is multiplied with for another weight than `saved`, with which the file has it; 0 in a channel
/// in which it is black. All there is to a picture; a gradient's black channels are white by skyAtWeight().
vec3 skyFactor(vec3 saved, vec3 weight);
/// The sky of a group of the saved weight `saved` at another one: white light by LightGrouping's rule, times the
/// weight.
Sky skyAtWeight(const Sky& sky, vec3 saved, vec3 weight);

} // namespace halflight
