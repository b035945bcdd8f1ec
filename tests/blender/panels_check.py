# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws every panel into a layout that checks what it is given: a name that does not exist is an error."""

import types

import bpy


class Layout:
    """Stands for a UILayout. Counts what is shown."""

    def __init__(self):
        self.shown = []

    def __setattr__(self, name, value):
        object.__setattr__(self, name, value)

    def row(self, **_options):
        return self

    column = split = row

    def label(self, text="", icon="NONE"):
        self.shown.append(text)

    def prop(self, data, name, text=None, slider=False):
        if name not in data.bl_rna.properties:
            raise AssertionError(f"{data} has no property {name}")
        getattr(data, name)
        self.shown.append(name)

    def operator(self, name, **_options):
        group, operator = name.split(".")
        getattr(getattr(bpy.ops, group), operator).get_rna_type()
        self.shown.append(name)

    def template_list(self, kind, _name, data, items, active_data, active, rows=1):
        bpy.types.UIList.bl_rna_get_subclass_py(kind)
        if items not in data.bl_rna.properties or active not in active_data.bl_rna.properties:
            raise AssertionError(f"list of {items}")
        self.shown.append(kind)


def draw_all(panels, **members):
    """Number of things shown by the panels that are there for a context with these members."""
    members.setdefault("light", None)
    base = bpy.context
    context = types.SimpleNamespace(
        scene=base.scene, collection=base.collection, window_manager=base.window_manager, preferences=base.preferences, **members
    )
    count = 0
    for panel in panels.CLASSES:
        if hasattr(panel, "poll") and not panel.poll(context):
            continue
        layout = Layout()
        panel.draw(types.SimpleNamespace(layout=layout), context)
        if not layout.shown:
            raise AssertionError(f"{panel.__name__} shows nothing")
        count += len(layout.shown)
    return count
