# SPDX-License-Identifier: GPL-3.0-or-later
"""Errors and warnings of the last bake in a list; a click selects the object that one names."""

import re

import bpy

from . import baked_view, wording
from .export import findings


class Message(bpy.types.PropertyGroup):
    severity: bpy.props.EnumProperty(items=[("ERROR", "Error", ""), ("WARNING", "Warning", "")])
    text: bpy.props.StringProperty()
    item: bpy.props.StringProperty()  # name of the object, or empty
    is_curable: bpy.props.BoolProperty()  # by Bake Materials


class HALFLIGHT_UL_messages(bpy.types.UIList):
    def draw_item(self, _context, layout, _data, message, _icon, _active_data, _active_property, index):
        icon = "CANCEL" if message.severity == "ERROR" else "ERROR"
        layout.label(text=message.text, icon=icon)
        layout.operator("halflight.message", text="", icon="RESTRICT_SELECT_OFF" if message.item else "INFO").index = index


class HALFLIGHT_OT_message(bpy.types.Operator):
    """The whole message as a tooltip; a click selects its object"""

    bl_idname = "halflight.message"
    bl_label = "Message"

    index: bpy.props.IntProperty(options={"HIDDEN", "SKIP_SAVE"})

    @classmethod
    def description(cls, context, properties):
        listed = context.window_manager.halflight_messages
        return listed[properties.index].text if 0 <= properties.index < len(listed) else ""

    def execute(self, context):
        context.window_manager.halflight_message = self.index
        return {"FINISHED"}


def select(window_manager, context):
    """The list's active message was clicked."""
    index = window_manager.halflight_message
    if not 0 <= index < len(window_manager.halflight_messages):
        return
    item = context.scene.objects.get(window_manager.halflight_messages[index].item)
    if item is None or context.mode != "OBJECT":
        return
    for other in context.selected_objects:
        other.select_set(False)
    item.select_set(True)
    context.view_layer.objects.active = item


def clear(context):
    context.window_manager.halflight_messages.clear()


def add(context, severity, text, document=None, item=None):
    """`document`: the JSON of the exported file, for messages that name an element by its path. `item`: name of the
    object, where it is known."""
    labels = {p.identifier.replace("_", "-"): p.name for p in context.scene.halflight.bl_rna.properties}
    text = wording.in_blender(text, labels)
    if text is None:
        return
    if bpy.app.background:
        print(f"Halflight: {severity.lower()}: {text}", flush=True)
    message = context.window_manager.halflight_messages.add()
    message.severity = severity
    message.text = text
    message.is_curable = text.endswith(findings.CURE)
    message.item = item or object_of(text, baked_view.source_of(context.scene), document) or ""


def add_line(context, line, path, document):
    """A line of the program's standard error. True when it was an error."""
    text = line.strip()
    if not text:
        return False
    text = text[len("halflight: ") :] if text.startswith("halflight: ") else text
    is_warning = text.startswith("warning: ")
    text = (text[len("warning: ") :] if is_warning else text).replace(path + ": ", "")
    add(context, "WARNING" if is_warning else "ERROR", text, document)
    return not is_warning


def object_of(text, scene, document):
    """Name of the object that a sentence is about: by glTF path, or the longest name that stands in it."""
    found = re.search(r"/(nodes|meshes|materials|lights)/(\d+)", text)
    if found and document:
        name = node_name(document, found[1], int(found[2]))
        if name in scene.objects:
            return name
    names = sorted((item.name for item in scene.objects), key=len, reverse=True)
    for name in names:
        if re.search(rf"(?<![\w.]){re.escape(name)}(?![\w.]*\w)", text):
            return name
    return None


def node_name(document, kind, index):
    """Name of the node, or of the first node that has this mesh, material or light."""
    meshes = document.get("meshes", [])
    for number, node in enumerate(document.get("nodes", [])):
        light = node.get("extensions", {}).get("KHR_lights_punctual", {}).get("light")
        parts = meshes[node["mesh"]]["primitives"] if "mesh" in node else []
        if (
            (kind == "nodes" and number == index)
            or (kind == "meshes" and node.get("mesh") == index)
            or (kind == "lights" and light == index)
            or (kind == "materials" and any(part.get("material") == index for part in parts))
        ):
            return node.get("name")
    return None


CLASSES = (Message, HALFLIGHT_UL_messages, HALFLIGHT_OT_message)


def register():
    for item in CLASSES:
        bpy.utils.register_class(item)
    bpy.types.WindowManager.halflight_messages = bpy.props.CollectionProperty(type=Message)
    bpy.types.WindowManager.halflight_message = bpy.props.IntProperty(default=-1, update=select)


def unregister():
    del bpy.types.WindowManager.halflight_message
    del bpy.types.WindowManager.halflight_messages
    for item in reversed(CLASSES):
        bpy.utils.unregister_class(item)
