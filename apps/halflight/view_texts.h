#pragma once
// What a user chose and changed in the window, as text: a command line and a settings file.

#include "halflight/view/view.h"

namespace halflight::cli {

/// The command line that renders the same picture; of views steeper than 87 degrees, another roll of it.
ViewText commandLine(const ViewedPicture& picture);
/// What was changed of lights and objects for the next bake, as a settings file; empty when nothing was.
ViewText settingsFile(const Scene& scene, const Scene& atLoad);

} // namespace halflight::cli
