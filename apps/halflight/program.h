#pragma once
// The two programs: halflight (bake mixed lighting into a glTF file, render it, look into it) and halflight-view.

namespace halflight::cli {

struct ViewCommandOptions;
using OpenWindow = int (*)(const ViewCommandOptions&);

/// What main() does: runs the command that the arguments name, and returns the exit code. With `openWindow` this is
/// halflight-view, which has the command `view` alone; without, `view` starts halflight-view.
int runProgram(int argc, char** argv, OpenWindow openWindow = nullptr);

/// What main() does last: returns `code`. But where a driver still compiles what a bake that ended early has not come
/// to use, the program ends here: exit() would take down what the driver's threads use.
int leavingWith(int code);

} // namespace halflight::cli
