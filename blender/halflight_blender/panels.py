# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels: the bake in the 3D view's sidebar and in Render properties, settings where Blender has its own."""

import bpy

from . import baked_view, bake, preferences, program, stale, wording
from .export import sky
from .groups import state


def draw_bake(layout, context):
    scene = baked_view.source_of(context.scene)
    settings = scene.halflight
    job = bake.Job.current
    if job is not None:
        layout.label(text=job.progress.text(), icon="RENDER_STILL")
        layout.operator("halflight.cancel", icon="CANCEL")
        return
    column = layout.column(align=True)
    column.scale_y = 1.3
    column.operator("halflight.bake", icon="LIGHT_SUN")
    column.operator("halflight.bake_selected", icon="RESTRICT_SELECT_OFF")
    shown = baked_view.is_view(context.scene)
    column.operator("halflight.baked_view", icon="HIDE_OFF" if shown else "HIDE_ON", depress=shown)
    lines = layout.column(align=True)
    for line in settings.summary.splitlines():
        lines.label(text=line)
    if stale.is_stale(scene):
        layout.label(text="Changed since the bake", icon="ERROR")
    column = layout.column()
    column.use_property_split = True
    for name in ("mode", "quality", "texels_per_meter", "output", "show_view"):
        column.prop(settings, name)
    messages = context.window_manager.halflight_messages
    if messages:
        layout.template_list(
            "HALFLIGHT_UL_messages", "", context.window_manager, "halflight_messages", context.window_manager,
            "halflight_message", rows=min(6, len(messages)),
        )  # fmt: skip
        draw_message(layout, context)
        if any(message.is_curable for message in messages):
            layout.operator("halflight.bake_materials", icon="TEXTURE")


def draw_message(layout, context):
    """The clicked message as a whole, in lines that fit the sidebar."""
    manager = context.window_manager
    if not 0 <= manager.halflight_message < len(manager.halflight_messages):
        return
    width = context.region.width if getattr(context, "region", None) else 280
    column = layout.column(align=True)
    # A letter is about 7 pixels wide at a scale of 1.
    letters = max(20, int(width / (7.0 * context.preferences.system.ui_scale)) - 4)
    for line in wording.wrapped(manager.halflight_messages[manager.halflight_message].text, letters):
        column.label(text=line)


def draw_lights(layout, context):
    for light in context.scene.halflight_lights:
        row = layout.split(factor=0.75)
        row.prop(light, "on", text=light.name)
        row.label(text=light.shadow)


def draw_groups(layout, context):
    for group in state.groups_of(context.scene):
        row = layout.split(factor=0.75, align=True)
        row.prop(group, "brightness", text=group.name, slider=True)
        row.prop(group, "color", text="")


def draw_details(layout, settings):
    layout.use_property_split = True
    groups = (
        ("samples", "noise", "shadow_samples", "bounces", "glossy_bounces", "integrator", "denoise", "seed"),
        ("groups",),
        ("lightmap_size", "two_sided", "directional", "shadowmask_encoding"),
        ("probe_layout", "probe_spacing"),
        ("bake_materials", "material_size"),
        ("units", "device", "threads"),
    )
    for names in groups:
        column = layout.column(align=True)
        for name in names:
            column.prop(settings, name)


class Sidebar:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Halflight"


class HALFLIGHT_PT_bake(Sidebar, bpy.types.Panel):
    bl_label = "Halflight"

    def draw(self, context):
        draw_bake(self.layout, context)


class GroupsPanel:
    bl_label = "Light Groups"

    @classmethod
    def poll(cls, context):
        return len(state.groups_of(context.scene)) > 0

    def draw(self, context):
        draw_groups(self.layout, context)


class HALFLIGHT_PT_groups(GroupsPanel, Sidebar, bpy.types.Panel):
    bl_parent_id = "HALFLIGHT_PT_bake"


class HALFLIGHT_PT_lights(Sidebar, bpy.types.Panel):
    bl_label = "Lights of the Baked View"
    bl_parent_id = "HALFLIGHT_PT_bake"

    @classmethod
    def poll(cls, context):
        return baked_view.is_view(context.scene) and len(context.scene.halflight_lights) > 0

    def draw(self, context):
        draw_lights(self.layout, context)


class HALFLIGHT_PT_details(Sidebar, bpy.types.Panel):
    bl_label = "Details"
    bl_parent_id = "HALFLIGHT_PT_bake"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        draw_details(self.layout, baked_view.source_of(context.scene).halflight)
        found = preferences.find_program(context)
        text = f"{program.version(found.path)} {found.where}" if found else program.NOT_FOUND
        self.layout.label(text=text)


class Properties:
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_label = "Halflight"
    bl_options = {"DEFAULT_CLOSED"}


class HALFLIGHT_PT_render(Properties, bpy.types.Panel):
    bl_context = "render"

    def draw(self, context):
        draw_bake(self.layout, context)


class HALFLIGHT_PT_render_groups(GroupsPanel, Properties, bpy.types.Panel):
    bl_label = "Light Groups"
    bl_context = "render"
    bl_parent_id = "HALFLIGHT_PT_render"
    bl_options = set()


class HALFLIGHT_PT_render_details(Properties, bpy.types.Panel):
    bl_label = "Details"
    bl_context = "render"
    bl_parent_id = "HALFLIGHT_PT_render"

    def draw(self, context):
        draw_details(self.layout, baked_view.source_of(context.scene).halflight)


class HALFLIGHT_PT_world(Properties, bpy.types.Panel):
    bl_context = "world"

    @classmethod
    def poll(cls, context):
        return context.world is not None

    def draw(self, context):
        layout, world = self.layout, context.world
        layout.use_property_split = True
        layout.prop(world, "halflight_sky_source")
        understood = sky.read_world(world)
        named = any(key in context.scene for key in sky.KEYS)
        layout.label(text="The scene's own properties name the sky" if named else understood.text(), icon="WORLD")
        if understood.panorama:
            layout.prop(world, "halflight_sky_width")
        layout.prop(context.scene, "halflight_sky_changes")
        if not context.scene.halflight_sky_changes:
            layout.prop(context.scene, "halflight_sky_group")
        layout.prop(context.scene, "halflight_shadow_color")


class HALFLIGHT_PT_light(Properties, bpy.types.Panel):
    bl_context = "data"

    @classmethod
    def poll(cls, context):
        return context.light is not None

    def draw(self, context):
        layout, light = self.layout, context.light
        layout.use_property_split = True
        if light.type == "AREA":
            column = layout.column(align=True)
            for name in ("shape", "size") + (("size_y",) if light.shape in {"RECTANGLE", "ELLIPSE"} else ()):
                column.prop(light, name)
            if light.shape == "ELLIPSE":
                layout.label(text="An ellipse is always baked, as an emissive surface", icon="INFO")
                layout.prop(light, "halflight_group")
                return
        for name in ("mode", "group", "cast_shadows", "shadow_strength", "indirect_multiplier"):
            layout.prop(light, "halflight_" + name)
        if light.type == "AREA":
            return
        column = layout.column(align=True)
        for name in ("depth_bias", "slope_bias", "normal_bias"):
            column.prop(light, "halflight_" + name)


class HALFLIGHT_PT_object(Properties, bpy.types.Panel):
    bl_context = "object"

    @classmethod
    def poll(cls, context):
        return context.object is not None and context.object.type in baked_view.SURFACES | {"EMPTY", "ARMATURE"}

    def draw(self, context):
        layout, item = self.layout, context.object
        layout.use_property_split = True
        for name in ("static", "lightmap_scale", "two_sided", "cast_shadows", "receive_shadows", "group", "probes"):
            layout.prop(item, "halflight_" + name)
        if item.halflight_probes == "VOLUME":
            layout.prop(item, "halflight_probe_resolution")


class HALFLIGHT_PT_material(Properties, bpy.types.Panel):
    bl_context = "material"

    @classmethod
    def poll(cls, context):
        return context.material is not None

    def draw(self, context):
        self.layout.use_property_split = True
        for name in ("cast_shadows", "receive_shadows", "group"):
            self.layout.prop(context.material, "halflight_" + name)


class HALFLIGHT_PT_collection(Properties, bpy.types.Panel):
    bl_context = "collection"

    @classmethod
    def poll(cls, context):
        return context.collection is not None

    def draw(self, context):
        self.layout.use_property_split = True
        self.layout.prop(context.collection, "halflight_group")


CLASSES = (
    HALFLIGHT_PT_bake,
    HALFLIGHT_PT_groups,
    HALFLIGHT_PT_lights,
    HALFLIGHT_PT_details,
    HALFLIGHT_PT_render,
    HALFLIGHT_PT_render_groups,
    HALFLIGHT_PT_render_details,
    HALFLIGHT_PT_world,
    HALFLIGHT_PT_light,
    HALFLIGHT_PT_object,
    HALFLIGHT_PT_material,
    HALFLIGHT_PT_collection,
)


def register():
    for item in CLASSES:
        bpy.utils.register_class(item)


def unregister():
    for item in reversed(CLASSES):
        bpy.utils.unregister_class(item)
