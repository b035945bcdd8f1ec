# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of a scene's bake: in a folder beside the .blend, or in Blender's temporary folder while there is none."""

import collections
import os

import bpy

from . import baked_view

Files = collections.namedtuple("Files", "folder scene baked tiles sidecar report")


def of(scene):
    scene = baked_view.source_of(scene)
    if bpy.data.filepath:
        folder = os.path.splitext(bpy.data.filepath)[0] + ".halflight"
    else:
        folder = os.path.join(bpy.app.tempdir, "halflight")
    folder = os.path.join(folder, bpy.path.clean_name(scene.name))
    inside = [os.path.join(folder, name) for name in ("scene.glb", "baked.glb", "tiles", "pictures", "report.json")]
    return Files(folder, *inside)
