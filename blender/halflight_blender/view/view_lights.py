# SPDX-License-Identifier: GPL-3.0-or-later
"""Direct light of mixed lights in the baked view: one node group, which multiplies each light by its mask.

The formulas are those of include/halflight/shading/light.h, area_light.h and law.h. tests/blender compares pictures with
them.
"""

import math

import bpy
import numpy as np

from ..export import area_lights
from . import area_nodes, graph

GROUP = "Halflight lights"
# glTF's Y up to Blender's Z up.
BLENDER_FROM_GLTF = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]], np.float64)


def shining_lights(document, bindings):
    """The lights that shine at run time, as dictionaries. `bindings`: bake.json."""
    matrices = document.world_matrices()
    nodes = document.json["nodes"]
    punctual = document.json.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", [])
    lights = []
    for record in bindings["lights"]:
        baking = record.get("baking", {})
        if baking.get("bakeType", record["mode"]) == "baked" or bindings["mode"] == "subtractive":
            continue
        index = node_at(document, record["path"])
        extensions = nodes[index]["extensions"]
        if area_lights.EXTENSION in extensions:
            light = document.json["extensions"][area_lights.EXTENSION]["lights"]
            light = light[extensions[area_lights.EXTENSION]["light"]]
        else:
            light = punctual[extensions["KHR_lights_punctual"]["light"]]
        matrix = BLENDER_FROM_GLTF @ matrices[index]
        scales = np.linalg.norm(matrix[:3, :3], axis=0)
        intensity = light.get("intensity", 1.0)
        lights.append(
            {
                "name": record["node"] or light.get("name", "light"),
                "type": light["type"],
                "color": baking.get("white") or [intensity * c for c in light.get("color", (1.0, 1.0, 1.0))],
                "group": baking.get("group", -1),
                "position": matrix[:3, 3].tolist(),
                "axis": (-matrix[:3, 2] / scales[2]).tolist(),
                "corners": area_nodes.corners_of(light, matrix[:3, :3] / scales, scales.max(), matrix[:3, 3]),
                "range": light.get("range", record.get("range", 0.0)),
                "cone": cone_of(light),
                "strength": record.get("shadowStrength", 1.0),
                "channel": baking.get("occlusionMaskChannel", -1),
                "colored": baking.get("coloredMask", False),
                "reach": baking.get("reach", 0.0),
            }
        )
    return lights


def cone_of(light):
    spot = light.get("spot", {})
    outer = spot.get("outerConeAngle", math.pi / 4)
    inner = min(spot.get("innerConeAngle", 0.0), outer)
    scale = 1.0 / max(0.001, math.cos(inner) - math.cos(outer))
    return scale, -math.cos(outer) * scale


def node_at(document, path):
    """Index of the node at a path of bake.json: its place among the scene's nodes, then among children."""
    nodes = document.json["nodes"]
    siblings = document.json["scenes"][document.json.get("scene", 0)]["nodes"]
    for place in path:
        index = siblings[place]
        siblings = nodes[index].get("children", [])
    return index


def make_group(lights, encodings, groups):
    """Inputs: the mask's colour and alpha. Output: irradiance in lux. `encodings`: bake.json's shadowmaskChannels. `groups`:
    view_groups.Groups."""
    tree = bpy.data.node_groups.new(GROUP, "ShaderNodeTree")
    graph.add_group_socket(tree, "Mask", "NodeSocketColor", False)
    graph.add_group_socket(tree, "Alpha", "NodeSocketFloat", False)
    graph.add_group_socket(tree, "Irradiance", "NodeSocketVector", True)
    g = graph.Graph(tree)
    inputs = g.node("NodeGroupInput").outputs
    geometry = g.node("ShaderNodeNewGeometry").outputs
    colors = g.separate(inputs["Mask"])
    masks = [colors[0], colors[1], colors[2], inputs["Alpha"]]
    masks = [decoded(g, mask, encodings[i] if encodings else {}) for i, mask in enumerate(masks)]
    edge = area_nodes.edge_group() if any(light["corners"] for light in lights) else None
    total = (0.0, 0.0, 0.0)
    for light in lights:
        factor, distance = unshadowed(g, light, geometry, edge)
        factor = g.scalar("MULTIPLY", factor, g.value(switch_name(light["name"]), 1.0))
        color = light["color"]  # at the weight 1 of its group
        if light["group"] >= 0:
            color = g.vector("MULTIPLY", groups.weight(g, groups.records[light["group"]]["name"]), color)
        arriving = [shadow(g, light, masks[channel], distance) for channel in mask_channels(light)]
        if light["colored"]:
            color = g.vector("MULTIPLY", color, g.combined(arriving))
        elif arriving:
            factor = g.scalar("MULTIPLY", factor, arriving[0])
        total = g.vector("ADD", total, g.scaled(color, factor))
    g.put(g.node("NodeGroupOutput").inputs["Irradiance"], total)
    return tree


def mask_channels(light):
    """Behind coloured glass those of red, green and blue; else one, or none."""
    first = light["channel"]
    return range(first, first + (3 if light["colored"] else 1)) if first >= 0 else ()


def switch_name(light):
    return "on: " + light


def unshadowed(g, light, geometry, edge):
    """Irradiance over the light's intensity, and the distance (None of directional lights)."""
    if light["type"] == "directional":
        towards = [-c for c in light["axis"]]
        return g.scalar("MAXIMUM", g.vector("DOT_PRODUCT", geometry["Normal"], towards), 0.0), None
    to_light = g.vector("SUBTRACT", light["position"], geometry["Position"])
    distance = g.vector("LENGTH", to_light)
    if light["corners"]:
        factor = area_nodes.irradiance(g, light["corners"], geometry, edge)
        in_front = g.scalar("LESS_THAN", g.vector("DOT_PRODUCT", to_light, light["axis"]), 0.0)
        return windowed(g, g.scalar("MULTIPLY", factor, in_front), light, distance), distance
    direction = g.vector("NORMALIZE", to_light)
    cosine = g.scalar("MAXIMUM", g.vector("DOT_PRODUCT", geometry["Normal"], direction), 0.0)
    square = g.scalar("MAXIMUM", g.scalar("MULTIPLY", distance, distance), 1e-6)
    factor = windowed(g, g.scalar("DIVIDE", cosine, square), light, distance)
    if light["type"] == "spot":
        scale, offset = light["cone"]
        angle = g.vector("DOT_PRODUCT", direction, [-c for c in light["axis"]])
        cone = g.scalar("MULTIPLY_ADD", angle, scale, offset, clamp=True)
        factor = g.scalar("MULTIPLY", factor, g.scalar("MULTIPLY", cone, cone))
    return factor, distance


def windowed(g, factor, light, distance):
    if light["range"] <= 0.0:
        return factor
    ratio = g.scalar("DIVIDE", distance, light["range"])
    window = g.scalar("SUBTRACT", 1.0, g.scalar("POWER", ratio, 4.0), clamp=True)
    return g.scalar("MULTIPLY", factor, window)


def decoded(g, mask, encoding):
    if encoding.get("encoding") != "distance":
        return mask
    slope = 2.0 * encoding["rangeTexels"] / max(encoding["penumbraTexels"], 1.0)
    return g.scalar("MULTIPLY_ADD", mask, slope, 0.5 - slope / 2.0, clamp=True)


def shadow(g, light, mask, distance):
    """What arrives past static objects: 1 beyond the light's reach, and weakened by its shadow strength."""
    blocked = g.scalar("SUBTRACT", 1.0, mask)
    if light["reach"] > 0.0 and distance is not None:
        blocked = g.scalar("MULTIPLY", blocked, g.scalar("LESS_THAN", distance, light["reach"]))
    return g.scalar("SUBTRACT", 1.0, g.scalar("MULTIPLY", blocked, light["strength"]))
