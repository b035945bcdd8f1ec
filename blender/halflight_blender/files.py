# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of a scene's bake: in a folder beside the .blend, or in Blender's temporary folder while there is none."""

import collections
import os
import shutil

import bpy

from . import baked_view

Files = collections.namedtuple("Files", "folder scene baked tiles sidecar report bindings")


def of(scene):
    folder = os.path.join(root_of(bpy.data.filepath), name_of(baked_view.source_of(scene)))
    inside = [os.path.join(folder, name) for name in ("scene.glb", "baked.glb", "tiles", "pictures", "report.json")]
    return Files(folder, *inside, os.path.join(folder, "pictures", "bake.json"))


def root_of(blend):
    return os.path.splitext(blend)[0] + ".halflight" if blend else os.path.join(bpy.app.tempdir, "halflight")


def name_of(scene):
    return scene.halflight.folder or bpy.path.clean_name(scene.name)


def settle(scene):
    """Gives the scene a folder that no other scene has, and that stays when the scene gets another name."""
    others = [other for other in bpy.data.scenes if other != scene and not baked_view.is_view(other)]
    taken = {name_of(other).lower() for other in others}
    name = wanted = name_of(scene)
    number = 2
    while name.lower() in taken:
        name, number = f"{wanted}_{number}", number + 1
    scene.halflight.folder = name


def follow(before):
    """After a save under another name than `before`: the bakes are beside the new file too."""
    old, new = root_of(before), root_of(bpy.data.filepath)
    if old == new or not os.path.isdir(old):
        return
    for scene in bpy.data.scenes:
        source, target = (os.path.join(root, name_of(scene)) for root in (old, new))
        if os.path.isdir(source) and not baked_view.is_view(scene):
            shutil.copytree(source, target, dirs_exist_ok=True)
