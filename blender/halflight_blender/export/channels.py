# SPDX-License-Identifier: GPL-3.0-or-later
"""What a material's nodes say of base colour, metallic, roughness, emission and alpha: for each a socket or a constant.

Mix and Add shaders are followed, as glTF has one surface for each material.
"""

import bpy

from ..view import graph
from . import surfaces

COLOR, GLOW, METALLIC, ROUGHNESS, ALPHA = CHANNELS = ("base color", "emission", "metallic", "roughness", "alpha")
EMITTERS = {"ShaderNodeEmission", "ShaderNodeBackground"}
CLEAR = "ShaderNodeBsdfTransparent"
PLAIN = {COLOR: (0.0, 0.0, 0.0), GLOW: (0.0, 0.0, 0.0), METALLIC: 0.0, ROUGHNESS: 1.0, ALPHA: 1.0}


def surface_of(material):
    """The shader of a material whose channels can be told; None where it has another one below it."""
    node = surfaces.surface_node(material) if material is not None and material.use_nodes else None
    return node if node is not None and is_known(node, 8) else None


def is_known(node, depth):
    if node.bl_idname in {"ShaderNodeMixShader", "ShaderNodeAddShader"} and depth > 0:
        return all(is_known(each, depth - 1) for each in shaders_of(node))
    return node.bl_idname in {"ShaderNodeBsdfPrincipled", CLEAR} | EMITTERS | surfaces.SHADERS.keys()


def shaders_of(node):
    """Of a Mix or Add shader. What leads nowhere is black, and left out."""
    sockets = [socket for socket in node.inputs if socket.type == "SHADER" and socket.is_linked]
    return [from_node(socket) for socket in sockets]


def from_node(socket):
    node = socket.links[0].from_node
    while node.bl_idname == "NodeReroute" and node.inputs[0].is_linked:
        node = node.inputs[0].links[0].from_node
    return node


def channel(g, node, name):
    """A socket, or a constant: three numbers of a colour, one of others. `g`: graph.Graph of the node's tree."""
    kind = node.bl_idname
    if kind in {"ShaderNodeMixShader", "ShaderNodeAddShader"}:
        return combined(g, node, name)
    if kind == "ShaderNodeBsdfPrincipled":
        return of_principled(g, node, name)
    if kind == CLEAR:
        return 0.0 if name == ALPHA else PLAIN[name]
    if kind in EMITTERS:
        return times(g, value(node, "Color"), value(node, "Strength", default=1.0)) if name == GLOW else PLAIN[name]
    color, members = surfaces.SHADERS[kind]
    if name == COLOR:
        return value(node, "Color", color)
    if name == METALLIC:
        return members.get("Metallic", 0.0)
    if name == ROUGHNESS:
        return members.get("Roughness", value(node, "Roughness", default=1.0))
    return PLAIN[name]


def of_principled(g, node, name):
    if name == GLOW:
        return times(g, value(node, "Emission Color", "Emission"), value(node, "Emission Strength", default=1.0))
    return value(node, {COLOR: "Base Color", METALLIC: "Metallic", ROUGHNESS: "Roughness", ALPHA: "Alpha"}[name])


def combined(g, node, name):
    shaders = shaders_of(node)
    if len(shaders) < 2:
        return channel(g, shaders[0], name) if shaders else PLAIN[name]
    # Where light passes, or shines alone, the surface is that of the other shader.
    absent = {ALPHA: set(), GLOW: {CLEAR}}.get(name, {CLEAR} | EMITTERS)
    if node.bl_idname == "ShaderNodeAddShader" or name not in {ALPHA, GLOW}:
        counting = [each for each in shaders if each.bl_idname not in absent] or shaders[:1]
        if len(counting) == 1:
            return channel(g, counting[0], name)
    first, second = (channel(g, each, name) for each in shaders)
    if node.bl_idname == "ShaderNodeMixShader":
        return mixed(g, first, second, value(node, node.inputs[0].name, default=0.5))
    if name in {COLOR, GLOW}:
        return summed(g, first, second)
    return mixed(g, first, second, 0.5)


def value(node, *names, default=None):
    found = next((node.inputs[name] for name in names if name in node.inputs), None)
    if found is None:
        return default
    if found.is_linked:
        return found.links[0].from_socket
    constant = found.default_value
    return tuple(constant)[:3] if hasattr(constant, "__len__") else constant


def is_constant(*values):
    return not any(isinstance(each, bpy.types.NodeSocket) for each in values)


def times(g, color, factor):
    if is_constant(color, factor):
        return tuple(each * factor for each in color)
    return g.scaled(color, factor)


def summed(g, first, second):
    if is_constant(first, second):
        return tuple(a + b for a, b in zip(first, second))
    return g.vector("ADD", first, second)


def mixed(g, first, second, share):
    """`first` at a share of 0, `second` at 1."""
    if is_constant(first, second) and first == second:
        return first
    if is_constant(first, second, share):
        pairs = zip(first, second) if isinstance(first, tuple) else None
        return tuple(a + (b - a) * share for a, b in pairs) if pairs else first + (second - first) * share
    if isinstance(first, tuple) or isinstance(second, tuple) or is_color(first) or is_color(second):
        return g.vector("ADD", first, g.scaled(g.vector("SUBTRACT", second, first), share))
    return g.mixed(first, second, share)


def is_color(socket):
    return isinstance(socket, bpy.types.NodeSocket) and socket.type in {"RGBA", "VECTOR"}


def graph_of(material):
    return graph.Graph(material.node_tree)
