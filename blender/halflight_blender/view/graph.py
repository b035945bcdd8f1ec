# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes written as expressions. An argument is a socket or a number (three numbers for a vector)."""

import bpy


class Graph:
    def __init__(self, tree):
        self.tree = tree
        self.count = 0

    def node(self, kind, **members):
        node = self.tree.nodes.new(kind)
        for name, value in members.items():
            setattr(node, name, value)
        node.location = (180 * (self.count // 8), -170 * (self.count % 8))
        self.count += 1
        return node

    def put(self, socket, value):
        if isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(value, socket)
        else:
            socket.default_value = value

    def scalar(self, operation, *arguments, clamp=False):
        node = self.node("ShaderNodeMath", operation=operation, use_clamp=clamp)
        for socket, value in zip(node.inputs, arguments):
            self.put(socket, value)
        return node.outputs[0]

    def vector(self, operation, *arguments):
        node = self.node("ShaderNodeVectorMath", operation=operation)
        for socket, value in zip(node.inputs, arguments):
            self.put(socket, value)
        return node.outputs["Value" if operation in {"DOT_PRODUCT", "LENGTH", "DISTANCE"} else "Vector"]

    def scaled(self, vector, factor):
        node = self.node("ShaderNodeVectorMath", operation="SCALE")
        self.put(node.inputs[0], vector)
        self.put(node.inputs["Scale"], factor)
        return node.outputs["Vector"]

    def mixed(self, a, b, share):
        """a at a share of 0, b at 1."""
        return self.scalar("ADD", a, self.scalar("MULTIPLY", self.scalar("SUBTRACT", b, a), share))

    def value(self, name, number):
        node = self.node("ShaderNodeValue", name=name, label=name)
        node.outputs[0].default_value = number
        return node.outputs[0]

    def separate(self, color):
        node = self.node("ShaderNodeSeparateColor")
        self.put(node.inputs[0], color)
        return node.outputs

    def combined(self, numbers):
        """A vector of three numbers."""
        node = self.node("ShaderNodeCombineXYZ")
        for socket, number in zip(node.inputs, numbers):
            self.put(socket, number)
        return node.outputs["Vector"]

    def picture(self, image, uv, extension="REPEAT", interpolation="Linear"):
        node = self.node("ShaderNodeTexImage", image=image, extension=extension, interpolation=interpolation)
        self.put(node.inputs["Vector"], uv)
        return node.outputs

    def uv(self, layer):
        return self.node("ShaderNodeUVMap", uv_map=layer).outputs["UV"]


def add_group_socket(tree, name, kind, is_output):
    if hasattr(tree, "interface"):  # Blender 4.0 and newer
        tree.interface.new_socket(name=name, in_out="OUTPUT" if is_output else "INPUT", socket_type=kind)
    else:
        (tree.outputs if is_output else tree.inputs).new(kind, name)
