#pragma once
// A state of a bake with light groups (spec S33), as a bake without groups.

#include "halflight/base/result.h"
#include "halflight/scene/baked_scene.h"

#include <string>
#include <vector>

namespace halflight {

/// A weight by the name of its group.
struct GroupWeight {
    std::string name;
    vec3 weight{1.0f};
};

/// The saved weights of the groups, with those of `changes`. "sky" stands for all parts of a sky that changes.
/// InvalidArgument names groups that the bake lacks.
Result<std::vector<vec3>> groupWeights(const BakedScene& baked, const std::vector<GroupWeight>& changes);

/// Adds the light of the groups, each times its weight, to lightmaps, directions, probes and reflection probes.
/// Members' colours and intensities, emission and the sky are those of the weights. The result has no groups. Does
/// nothing in a bake without groups.
void composeGroups(BakedScene& baked, const std::vector<vec3>& weights);

/// Groups that reflection probes keep at the saved weight, as they have little light there, though `weights` change
/// them; their names.
std::vector<std::string> groupsKeptByReflections(const BakedScene& baked, const std::vector<vec3>& weights);

} // namespace halflight
