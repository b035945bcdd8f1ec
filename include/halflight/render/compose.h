#pragma once
// States of a bake with light groups (spec S33): what weights make of its light and of the members of groups. The
// renderer adds the pages itself (Renderer::setLightGroup()); composeGroups() makes a bake without groups of a state.

#include "halflight/base/result.h"
#include "halflight/scene/baked_scene.h"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace halflight {

/// The largest weight that may be set.
constexpr float kMostGroupWeight = 1.0e12f;

/// A weight by the name of its group.
struct GroupWeight {
    std::string name;
    vec3 weight{1.0f};
};

/// The weights that the file saves, by group; of lights that turn those of the lights as they are in the scene.
std::vector<vec3> savedWeights(const BakedScene& baked);
/// These, with those of `changes`. "sky" stands for all parts of a sky that changes, the name of a light that turns for
/// its directions, whose weights are the change's times those of turning_lights.h. InvalidArgument names groups that
/// the bake lacks, single directions, and weights outside 0 to kMostGroupWeight.
Result<std::vector<vec3>> groupWeights(const BakedScene& baked, const std::vector<GroupWeight>& changes);
/// One of these changes; `weights` by group.
Status changeGroupWeight(const BakedScene& baked, const GroupWeight& change, std::vector<vec3>& weights);
/// What there is to set: the groups in their order, each light that turns as one, by its name.
std::vector<GroupWeight> settableWeights(const BakedScene& baked, std::span<const vec3> weights);

/// Adds the light of the groups, each times its weight, to lightmaps, directions, probes, reflection probes and the
/// colour of subtractive shadows. Members are those of composeMembers() and composedSky(). The result has no groups.
/// Does nothing in a bake without groups.
void composeGroups(BakedScene& baked, const std::vector<vec3>& weights);

/// Radiance of the bake's probes: the rest's, and each group's times its weight. `weights`: by group.
std::vector<SphericalHarmonicsL2> composedRadiance(const BakedScene& baked, std::span<const vec3> weights);

/// Colour and intensity of the lights that are in groups, and emission of materials, at these weights. `saved`: lights
/// and materials as the file has them, at the saved weights; may be `scene` itself. A light that turns keeps its
/// direction. A light keeps its intensity where its colour can be at most 1, so that one that is off is black.
/// BakingOutput::atBake follows: bounced light does.
void composeMembers(const Scene& saved, std::span<const BakedGroup> groups, std::span<const vec3> weights,
                    Scene& scene);

/// The weight of the sky's group over the saved one: what a sky's picture is multiplied with. 1 where the sky is in
/// none.
vec3 composedSkyFactor(std::span<const BakedGroup> groups, std::span<const vec3> weights);
/// The sky at these weights. `saved`: as the file has it. A picture is multiplied texel by texel.
Sky composedSky(const Sky& saved, std::span<const BakedGroup> groups, std::span<const vec3> weights);

/// S34. Weights of the groups of lights that turn, of their light and direction in `lights`. Those of other groups
/// stay, and those that are right to 1/10,000.
void followTurningLights(std::span<const Light> lights, std::span<vec3> weights);
/// The same of one light at a colour times intensity of `weight` times its white light.
void setTurning(const Light& light, vec3 weight, std::span<vec3> weights);
/// That weight, as `weights` have it for the light's direction.
vec3 weightOfTurning(const Light& light, std::span<const vec3> weights);

/// The weight with which the lights of a group are as the scene has them: one factor for all, by channel, to 1/10,000.
/// `weight`: the group's until now, which channels keep that are black in all of them. Nothing where the lights are not
/// of one factor, or the group has none.
std::optional<vec3> weightOfLights(const Scene& scene, int group, vec3 weight);

/// The bake's reflection probes with the pictures of the groups, each times its weight.
ReflectionSet composedReflections(const BakedScene& baked, std::span<const vec3> weights);

/// Names of groups that reflection probes show at the saved weight, as they have little light there, though `weights`
/// change them.
std::vector<std::string> groupsKeptByReflections(const BakedScene& baked, std::span<const vec3> weights);
/// A warning for each of them.
std::vector<std::string> oldReflections(const BakedScene& baked, std::span<const vec3> weights);

} // namespace halflight
