# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake Materials, the list's cure for nodes that glTF lacks."""

import bpy

from . import baked_view, bake
from .export import material_pictures, scene_copy


class HALFLIGHT_OT_bake_materials(bpy.types.Operator):
    """Bake again, with pictures in place of the nodes that glTF lacks. Your materials are not changed"""

    bl_idname = "halflight.bake_materials"
    bl_label = "Bake Materials"

    size: bpy.props.IntProperty(
        name="Picture Size", description="Texels along each side", default=1024, min=16, max=8192, options={"SKIP_SAVE"}
    )

    @classmethod
    def poll(cls, _context):
        return bake.Job.current is None

    def objects(self, context):
        """Those of the user's scene, also while the view is shown."""
        source = baked_view.source_of(context.scene)
        layer = context.view_layer if source == context.scene else source.view_layers[0]
        return scene_copy.rendered_objects(layer)

    def invoke(self, context, _event):
        self.size = baked_view.source_of(context.scene).halflight.material_size
        return context.window_manager.invoke_props_dialog(self)

    def draw(self, context):
        self.layout.prop(self, "size")
        count, seconds = material_pictures.estimate(self.objects(context), self.size)
        self.layout.label(text=f"{count} pictures of {self.size} x {self.size} texels, about {max(seconds, 1.0):.0f} s")

    def execute(self, context):
        settings = baked_view.source_of(context.scene).halflight
        settings.bake_materials, settings.material_size = True, self.size
        if bpy.app.background:
            return bpy.ops.halflight.bake()
        bpy.ops.halflight.bake("INVOKE_DEFAULT")
        return {"FINISHED"}


def register():
    bpy.utils.register_class(HALFLIGHT_OT_bake_materials)


def unregister():
    bpy.utils.unregister_class(HALFLIGHT_OT_bake_materials)
