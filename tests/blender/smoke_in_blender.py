# SPDX-License-Identifier: GPL-3.0-or-later
"""The quick one: bake, look, leave."""

import os
import sys

import bpy

sys.path.insert(0, os.path.dirname(__file__))
import dump  # noqa: E402
import stage  # noqa: E402
from stage import expect  # noqa: E402

def main():
    extension = stage.install()
    scene = stage.empty()
    stage.box("Cube", (0.8, 0.8, 0.8), (0, 0, 0.4), stage.matte("Cube"))
    bpy.ops.wm.save_as_mainfile(filepath=stage.path("smoke.blend"))
    before = dump.blocks()
    stage.bake("smoke")
    expect(bpy.ops.halflight.baked_view() == {"FINISHED"} and bpy.context.scene == scene, "the view is left")
    changed = dump.difference(before, dump.blocks())
    expect(not changed, changed)
    expect(bpy.ops.halflight.baked_view() == {"FINISHED"}, "the view is shown again")
    stage.compare(extension, "smoke", "Floor", "Cube")


main()
