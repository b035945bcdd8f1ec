# SPDX-License-Identifier: GPL-3.0-or-later
"""Switching the baked view on and off, and its lights."""

import os

import bpy

from .. import baked_view, files
from . import view_lights


class HALFLIGHT_OT_baked_view(bpy.types.Operator):
    """Show the last bake in place of the scene, or the scene again. No object or material is changed"""

    bl_idname = "halflight.baked_view"
    bl_label = "Baked View"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        scene = context.scene
        return baked_view.is_view(scene) or os.path.exists(files.of(scene).baked)

    def execute(self, context):
        if baked_view.is_view(context.scene):
            baked_view.leave(baked_view.source_of(context.scene))
            return {"FINISHED"}
        try:
            baked_view.show(context, files.of(context.scene))
        except (OSError, ValueError, KeyError) as error:
            self.report({"ERROR"}, f"The last bake cannot be shown: {error}; bake again")
            return {"CANCELLED"}
        return {"FINISHED"}


def switch_light(item, _context):
    key = item.id_data.get(baked_view.TAG)
    groups = (tree for tree in bpy.data.node_groups if tree.get(baked_view.TAG) == key)
    for group in groups:
        node = group.nodes.get(view_lights.switch_name(item.name))
        if node:
            node.outputs[0].default_value = 1.0 if item.on else 0.0


class LightSwitch(bpy.types.PropertyGroup):
    """A light of the baked view. Its name is that of the object."""

    shadow: bpy.props.StringProperty()
    on: bpy.props.BoolProperty(
        name="On", description="Direct light of this light, times its mask", default=True, update=switch_light
    )


CLASSES = (LightSwitch, HALFLIGHT_OT_baked_view)


def register():
    for item in CLASSES:
        bpy.utils.register_class(item)
    bpy.types.Scene.halflight_lights = bpy.props.CollectionProperty(type=LightSwitch)


def unregister():
    del bpy.types.Scene.halflight_lights
    for item in reversed(CLASSES):
        bpy.utils.unregister_class(item)
