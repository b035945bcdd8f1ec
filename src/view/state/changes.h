#pragma once
// What a user chose and changed, as text: a command line and a settings file.

#include "view/state/view_state.h"

namespace halflight::view {

/// Files as the command line names them.
struct CommandFiles {
    std::string scene;
    std::string settings; ///< of --settings; empty without
};
/// The command line that renders the same picture; of views steeper than 87 degrees, another roll of it. `scene` is as
/// it is now, `atLoad` as the files have it.
std::string commandLine(const ViewState& state, const CommandFiles& files, ivec2 size, const Scene& scene,
                        const Scene& atLoad);

/// What was changed of lights and objects for the next bake, as a settings file; empty when nothing was.
std::string settingsFile(const Scene& scene, const Scene& atLoad);

/// What the two do not say of the changes, for people; empty where they say all.
std::string leftOutOfCommandLine(const ViewState& state, const Scene& scene, const Scene& atLoad);
std::string leftOutOfSettings(const Scene& scene, const Scene& atLoad);

} // namespace halflight::view
