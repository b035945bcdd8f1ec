# SPDX-License-Identifier: GPL-3.0-or-later
"""The quick one: bake, look, leave."""

import os
import sys

import bpy

sys.path.insert(0, os.path.dirname(__file__))
import dump  # noqa: E402
import stage  # noqa: E402
from stage import expect  # noqa: E402

KINDS = ("scenes", "objects", "meshes", "materials", "lights", "cameras", "worlds", "collections", "node_groups", "images")


def blocks():
    """What Blender says of each of the user's data-blocks, but for the settings and results of the bake."""
    for mesh in bpy.data.meshes:
        if hasattr(mesh, "calc_normals_split"):  # before Blender 4.1 these are made when they are first needed
            mesh.calc_normals_split()
    return {(kind, item.name): dump.dump(item) for kind in KINDS for item in getattr(bpy.data, kind)}


def main():
    extension = stage.install()
    scene = stage.empty()
    stage.box("Cube", (0.8, 0.8, 0.8), (0, 0, 0.4), stage.matte("Cube"))
    bpy.ops.wm.save_as_mainfile(filepath=stage.path("smoke.blend"))
    before = blocks()
    stage.bake("smoke")
    expect(bpy.ops.halflight.baked_view() == {"FINISHED"} and bpy.context.scene == scene, "the view is left")
    after = blocks()
    expect(before.keys() == after.keys(), f"data-blocks: {before.keys() ^ after.keys()}")
    for key, text in before.items():
        pairs = zip(text.splitlines(), after[key].splitlines())
        expect(text == after[key], f"{key} changed: {[pair for pair in pairs if pair[0] != pair[1]][:4]}")
    expect(bpy.ops.halflight.baked_view() == {"FINISHED"}, "the view is shown again")
    stage.compare(extension, "smoke", "Floor", "Cube")


main()
