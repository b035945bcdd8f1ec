# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials of dynamic objects in the baked view: copies of the user's, whose shaders emit albedo times the probes' light.

An object's light is in eight custom properties of four numbers, as many as Eevee hands to a material.
"""

import math

import bpy

from ..export import channels, surfaces
from . import graph, view_materials

GROUP = "Halflight probes"
NAME = "halflight_probe_light_"
# By property: which factors of probes.polynomials() its four numbers are, of one channel.
FIRST, SECOND = (0, 1, 2, 3), (4, 5, 6, 7)
LAST = 8


def attributes_of(factors, occlusion):
    """Custom properties, by name. `factors`: nine rows of RGB."""
    found = {}
    for channel in range(3):
        found[NAME + str(channel)] = [float(factors[i][channel]) for i in FIRST]
        found[NAME + str(3 + channel)] = [float(factors[i][channel]) for i in SECOND]
    found[NAME + "6"] = [float(value) for value in factors[LAST]] + [0.0]
    found[NAME + "7"] = [float(value) for value in occlusion]
    return found


def probe_group():
    """Outputs: irradiance of the probes on the surface's normal, and the occlusion of each channel, as a mask has it."""
    tree = bpy.data.node_groups.new(GROUP, "ShaderNodeTree")
    for name, kind in (("Irradiance", "NodeSocketVector"), ("Mask", "NodeSocketColor"), ("Alpha", "NodeSocketFloat")):
        graph.add_group_socket(tree, name, kind, True)
    g = graph.Graph(tree)
    normal = g.node("ShaderNodeSeparateXYZ")
    g.put(normal.inputs[0], g.node("ShaderNodeNewGeometry").outputs["Normal"])
    # glTF's axes: its Y is Blender's Z, its Z is Blender's −Y.
    x, y, z = normal.outputs[0], normal.outputs[2], g.scalar("MULTIPLY", normal.outputs[1], -1.0)
    square = g.scalar("MULTIPLY_ADD", g.scalar("MULTIPLY", z, z), 3.0, -1.0)
    across = g.scalar("SUBTRACT", g.scalar("MULTIPLY", x, x), g.scalar("MULTIPLY", y, y))
    second = [g.scalar("MULTIPLY", x, y), g.scalar("MULTIPLY", y, z), square, g.scalar("MULTIPLY", x, z)]
    last = g.node("ShaderNodeSeparateXYZ")
    g.put(last.inputs[0], attribute(g, 6)["Vector"])
    combined = g.node("ShaderNodeCombineXYZ")
    for channel in range(3):
        total = g.scalar("MULTIPLY", last.outputs[channel], across)
        for number, values in ((channel, (1.0, y, z, x)), (3 + channel, second)):
            source = attribute(g, number)
            parts = g.node("ShaderNodeSeparateXYZ")
            g.put(parts.inputs[0], source["Vector"])
            for factor, value in zip((*parts.outputs, source["Alpha"]), values):
                total = g.scalar("MULTIPLY_ADD", factor, value, total)
        g.put(combined.inputs[channel], g.scalar("MAXIMUM", total, 0.0))
    occlusion = attribute(g, 7)
    outputs = g.node("NodeGroupOutput").inputs
    g.put(outputs["Irradiance"], combined.outputs[0])
    g.put(outputs["Mask"], occlusion["Color"])
    g.put(outputs["Alpha"], occlusion["Alpha"])
    return tree


def attribute(g, number):
    """Of the instance of a collection, or else of the object."""
    return g.node("ShaderNodeAttribute", attribute_type="INSTANCER", attribute_name=NAME + str(number)).outputs


class MovingMaterials:
    """A copy of each of the user's materials that dynamic objects have."""

    def __init__(self, lights, groups, lumens_per_watt):
        self.lights = lights  # node group of the direct light, or None
        self.groups = groups  # view_groups.Groups
        self.lumens_per_watt = lumens_per_watt
        self.group = None
        self.made = {}

    def set_materials(self, item):
        """In the object's own slots; the mesh, which is the user's, keeps its materials."""
        if not item.material_slots:
            item.data = item.data.copy()
            item.data.materials.append(None)
        for slot in item.material_slots:
            material = self.get(slot.material)
            slot.link = "OBJECT"
            slot.material = material

    def get(self, material):
        if material not in self.made:
            self.made[material] = self.make(material)
        return self.made[material]

    def make(self, material):
        if material is None:
            copy = bpy.data.materials.new("Baked default")
            copy.diffuse_color = (*surfaces.GREY, 1.0)
            plain = surfaces.replacement_of(copy)
            bpy.data.materials.remove(copy)
            copy = plain
        else:
            copy = surfaces.replacement_of(material) or material.copy()
        copy.pop("halflight_copy_of", None)
        copy.name = "Baked " + (material.name if material else "default")
        g = graph.Graph(copy.node_tree)
        light = self.light(g)
        for node in list(copy.node_tree.nodes):
            if node.bl_idname == "ShaderNodeBsdfPrincipled" or node.bl_idname in surfaces.SHADERS:
                self.replace(g, node, light, material and self.groups.name_of_material(material.name))
        view_materials.leave_out_of_light_sampling(copy)
        return copy

    def light(self, g):
        """Irradiance in lux: that of the probes, and mixed lights times their occlusion."""
        self.group = self.group or probe_group()
        probes = g.node("ShaderNodeGroup", node_tree=self.group).outputs
        if self.lights is None:
            return probes["Irradiance"]
        lights = g.node("ShaderNodeGroup", node_tree=self.lights)
        g.put(lights.inputs["Mask"], probes["Mask"])
        g.put(lights.inputs["Alpha"], probes["Alpha"])
        return g.vector("ADD", probes["Irradiance"], lights.outputs["Irradiance"])

    def replace(self, g, node, light, group):
        """What the shader's output led to gets emission instead. `group`: light group of the material's own emission, or None."""
        targets = [link.to_socket for link in node.outputs[0].links]
        if not targets:
            return
        color, members = surfaces.SHADERS.get(node.bl_idname, ("Base Color", {}))
        base = channels.value(node, color, "Color")
        metallic = members.get("Metallic", channels.value(node, "Metallic", default=0.0))
        albedo = view_materials.transport_albedo(g, base, metallic, channels.value(node, "Roughness", default=1.0))
        radiance = g.scaled(g.vector("MULTIPLY", albedo, light), 1.0 / (math.pi * self.lumens_per_watt))
        if node.bl_idname == "ShaderNodeBsdfPrincipled":
            glow = channels.value(node, "Emission Color", "Emission", default=(0.0, 0.0, 0.0))
            glow = g.scaled(glow, channels.value(node, "Emission Strength", default=1.0))
            radiance = g.vector("ADD", radiance, self.groups.changed(g, glow, group) if group else glow)
        emission = g.node("ShaderNodeEmission")
        g.put(emission.inputs["Color"], radiance)
        shader = emission.outputs[0]
        passing = members.get("Transmission", channels.value(node, "Transmission Weight", "Transmission", default=0.0))
        if passing != 0.0:
            shader = view_materials.clear(g, shader, base, passing, channels.value(node, "IOR", default=1.45))
        alpha = channels.value(node, "Alpha", default=1.0)
        if alpha != 1.0:
            shader = view_materials.mixed_shader(g, alpha, g.node("ShaderNodeBsdfTransparent").outputs[0], shader)
        for target in targets:
            g.put(target, shader)
