# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps, emissive materials and worlds as members of light groups: their light as one colour that can be read and set."""

import bpy

from ..export import sky, surfaces

# Weight of a channel that is off: members keep this share of their light, so that their colours are not lost. It is below
# one step of a screen's darkest tones.
LEAST = 2.0**-16


class Place:
    """A number or colour that may be set: a property of `owner`, whose name is `member`."""

    def __init__(self, owner, member):
        self.owner = owner
        self.member = member

    def get(self):
        return getattr(self.owner, self.member)

    def set(self, value):
        setattr(self.owner, self.member, value)


def socket(found):
    """None where a link decides."""
    return None if found.is_linked else Place(found, "default_value")


def places_of(item):
    """Where an item has colour and strength. A colour of None is that of a picture; a strength of None cannot be set."""
    if isinstance(item, bpy.types.Light):
        return Place(item, "color"), Place(item, "energy")
    node = glowing_node(item)
    if node is None:
        return None, None
    names = ("Emission Color", "Emission", "Color")
    color = next(node.inputs[name] for name in names if name in node.inputs)
    strength = node.inputs["Emission Strength" if "Emission Strength" in node.inputs else "Strength"]
    return socket(color), socket(strength)


def glowing_node(item):
    if not item.use_nodes or item.node_tree is None:
        return None
    if isinstance(item, bpy.types.World):
        return sky.background_of(item.node_tree)
    node = surfaces.surface_node(item)
    known = {"ShaderNodeBsdfPrincipled", "ShaderNodeEmission"}
    return node if node is not None and node.bl_idname in known else None


def is_free(item):
    """Whether a slider may set it: its strength is a number that nothing else moves, in this file."""
    if item.library is not None or item.override_library is not None or places_of(item)[1] is None:
        return False
    if isinstance(item, bpy.types.Light):
        return not moved_paths(item) & {"color", "energy"}
    prefix = glowing_node(item).path_from_id()
    return not any(path.startswith(prefix) for path in moved_paths(item.node_tree))


def moved_paths(owner):
    """Paths that the owner's animation or drivers set."""
    data = owner.animation_data
    if data is None:
        return set()
    return {curve.data_path for curve in [*(data.action.fcurves if data.action else ()), *data.drivers]}


def light_of(item):
    """Colour times strength. That of a picture counts as white."""
    color, strength = places_of(item)
    return [strength.get() * c for c in (color.get()[:3] if color else (1.0, 1.0, 1.0))]


def set_light(item, light):
    """The largest channel of the colour stays as it is, unless the item is black. A picture keeps its colours."""
    color, strength = places_of(item)
    largest = max(light)
    if color is None:
        strength.set(largest)
        return
    old = list(color.get())
    scale = max(old[:3]) or 1.0
    strength.set(largest / scale)
    if largest > 0.0:
        color.set([scale * c / largest for c in light] + old[3:])


def with_weight(white, weight):
    return [a * max(b, LEAST) for a, b in zip(white, weight)]


def is_near(a, b):
    """To the rounding of single precision, several times over."""
    most = max(max(map(abs, a)), max(map(abs, b)))
    return all(abs(x - y) <= 1e-5 * most for x, y in zip(a, b))
