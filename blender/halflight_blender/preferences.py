# SPDX-License-Identifier: GPL-3.0-or-later
"""Preferences of the extension: where the program is."""

import bpy

from . import program


class HalflightPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    program: bpy.props.StringProperty(
        name="Program",
        description="The halflight program. Empty: the one of the Python wheel, else the one on PATH",
        subtype="FILE_PATH",
    )

    def draw(self, _context):
        layout = self.layout
        layout.prop(self, "program")
        found = program.find(self.program)
        if found is None:
            layout.label(text=program.NOT_FOUND, icon="ERROR")
        else:
            layout.label(text=f"{program.version(found.path)}, {found.where}: {found.path}", icon="CHECKMARK")


def of(context):
    """Preferences, or None where the package is used without being enabled."""
    addon = context.preferences.addons.get(__package__)
    return addon.preferences if addon else None


def find_program(context):
    preferences = of(context)
    return program.find(preferences.program if preferences else "")


def register():
    bpy.utils.register_class(HalflightPreferences)


def unregister():
    bpy.utils.unregister_class(HalflightPreferences)
