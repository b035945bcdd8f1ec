# SPDX-License-Identifier: GPL-3.0-or-later
"""The zip with the program: it installs, brings its program along, bakes from the command line, and goes without a trace."""

import os
import subprocess
import sys

import addon_utils
import bpy

sys.path.insert(0, os.path.dirname(__file__))
import stage  # noqa: E402
from stage import expect  # noqa: E402


def check_numpy():
    """Without numpy a sentence names the package. Blender itself has loaded it already: it is hidden here."""
    name = stage.copy_files()
    hidden = {key: sys.modules.pop(key) for key in list(sys.modules) if key.split(".")[0] == "numpy"}
    sys.modules["numpy"] = None
    said = ""
    try:
        bpy.ops.preferences.addon_enable(module=name)
    except RuntimeError as error:
        said = str(error)
    finally:
        del sys.modules["numpy"]
        sys.modules.update(hidden)
    expect("numpy" in said and "apt install python3-numpy" in said, f"what is missing is named: {said}")
    expect(not addon_utils.check(name)[1], "it is not enabled")


def check_program(extension):
    """The program of the zip is found and baked with, though no preference and no PATH has one."""
    expect(not extension.preferences.of(bpy.context).program, "no preference names the program")
    found = extension.preferences.find_program(bpy.context)
    expect(extension.program.version(found.path).startswith("halflight "), f"it runs: {found}")
    expect(extension.preferences.find_program(bpy.context) == found, "and is found again")
    stage.empty()
    stage.bake("installed")
    bpy.ops.halflight.baked_view()
    return found.path


def run_blender(name):
    """Exit code and output of a Blender that opens this file, bakes, and ends."""
    command = [bpy.app.binary_path, "-b", stage.path(name), "--python-exit-code", "1"]
    command += ["--python-expr", "import bpy; bpy.ops.halflight.bake()"]
    result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace")
    return result.returncode, result.stdout


def check_command_line(_extension):
    """docs/guide/blender.md's line: what is said is printed, and the exit code tells whether it was baked."""
    bpy.ops.wm.save_userpref()
    scene = stage.empty()
    scene.objects["Floor"].modifiers.new("Hair", "PARTICLE_SYSTEM")
    scene.objects["Floor"].particle_systems[0].settings.type = "HAIR"
    bpy.ops.wm.save_as_mainfile(filepath=stage.path("good.blend"))
    code, said = run_blender("good.blend")
    expect(code == 0 and "Halflight: warning:" in said and "hair" in said, f"code {code}: {said[-2000:]}")
    expect(os.path.exists(stage.path("good.halflight/Scene/baked.glb")), "the file is baked")
    scene.objects["Floor"]["halflight_lightmap_scale"] = "much"
    bpy.ops.wm.save_as_mainfile(filepath=stage.path("bad.blend"))
    code, said = run_blender("bad.blend")
    expect(code == 1 and "Halflight: error:" in said and "lightmap_scale" in said, f"code {code}: {said[-2000:]}")


def check_removal(extension, program):
    """Removing the extension removes its program."""
    name = extension.__name__
    if bpy.app.version >= (4, 2, 0):
        index = [repo.module for repo in bpy.context.preferences.extensions.repos].index("user_default")
        bpy.ops.extensions.package_uninstall(repo_index=index, pkg_id="halflight")
    else:
        window = bpy.context.window_manager.windows[0]
        with bpy.context.temp_override(window=window, area=window.screen.areas[0]):  # it is redrawn
            bpy.ops.preferences.addon_remove(module=name)
    expect(name not in bpy.context.preferences.addons, "it is not enabled any more")
    expect(not os.path.exists(program), f"{program} is gone")


def main():
    check_numpy()
    extension = stage.install()
    program = check_program(extension)
    check_command_line(extension)
    check_removal(extension, program)


main()
