# SPDX-License-Identifier: GPL-3.0-or-later
"""Halflight in Blender: one click from a scene to its baked light.

Read by Blender 4.2 and newer through blender_manifest.toml, by older ones through bl_info.
"""

bl_info = {
    "name": "Halflight",
    "author": "The Halflight authors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "3D View > Sidebar > Halflight; World, Light, Object and Material properties",
    "description": "Bake lightmaps, shadowmasks and probes into glTF, and look at them",
    "category": "Render",
}

try:
    import numpy  # noqa: F401
except ImportError:
    raise ImportError("Halflight needs numpy: apt install python3-numpy (this Blender's Python has none)") from None

from . import bake, keeping, material_operator, messages, panels, preferences, properties, stale  # noqa: E402
from .groups import state  # noqa: E402
from .view import moving, view_operator  # noqa: E402

MODULES = (preferences, properties, messages, bake, material_operator, view_operator, moving, state, stale, panels, keeping)


def register():
    for module in MODULES:
        module.register()


def unregister():
    for module in reversed(MODULES):
        module.unregister()
