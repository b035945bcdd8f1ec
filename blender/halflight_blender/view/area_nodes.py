# SPDX-License-Identifier: GPL-3.0-or-later
"""Irradiance of area lights as shader nodes: Lambert's contour integral over the part above the surface's horizon."""

import math

import bpy
import numpy as np

from . import graph

GROUP = "Halflight edge of an area light"
DISK_CORNERS = 12  # of a regular polygon with the disk's area


def corners_of(light, axes, scale, center):
    """Of an EXT_lights_area light, counter-clockwise as seen from its back; none of other lights."""
    if light["type"] not in {"rect", "disk"}:
        return []
    size = light.get("size", 1.0) * scale / 2.0
    if light["type"] == "disk":
        angles = 2.0 * math.pi * (np.arange(DISK_CORNERS) + 0.5) / DISK_CORNERS
        radius = size * math.sqrt(2.0 * math.pi / (DISK_CORNERS * math.sin(2.0 * math.pi / DISK_CORNERS)))
        plane = radius * np.stack([np.cos(angles), np.sin(angles)], 1)
    else:
        width = size * light.get("rect", {}).get("aspect", 1.0)
        plane = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * (width, size)
    return (center + plane @ axes[:, :2].T).tolist()


def irradiance(g, corners, geometry, edge):
    """For radiance 1; `edge`: edge_group(). Where an edge is below the horizon, the contour goes along the horizon instead."""
    normal = geometry["Normal"]
    towards = [g.vector("SUBTRACT", corner, geometry["Position"]) for corner in corners]
    above, along = 0.0, 0.0
    for start, end in zip(towards, towards[1:] + towards[:1]):
        node = g.node("ShaderNodeGroup", node_tree=edge)
        for name, value in (("Start", start), ("End", end), ("Normal", normal)):
            g.put(node.inputs[name], value)
        above = g.scalar("ADD", above, node.outputs["Above"])
        along = g.scalar("ADD", along, node.outputs["Along"])
    # Edges that go round below the surface turn by a whole circle more than the way along the horizon does.
    turn = g.scalar("MULTIPLY", g.scalar("LESS_THAN", along, -math.pi), 2.0 * math.pi)
    total = g.scalar("ADD", above, g.scalar("ADD", along, turn))
    return g.scalar("MULTIPLY", g.scalar("MAXIMUM", total, 0.0), 0.5)


def edge_group():
    """Inputs: vectors to both ends, and the normal. Outputs: the integral of the part above the horizon, and the angle
    along the horizon of the part below."""
    tree = bpy.data.node_groups.new(GROUP, "ShaderNodeTree")
    for name in ("Start", "End", "Normal"):
        graph.add_group_socket(tree, name, "NodeSocketVector", False)
    for name in ("Above", "Along"):
        graph.add_group_socket(tree, name, "NodeSocketFloat", True)
    g = graph.Graph(tree)
    inputs, outputs = g.node("NodeGroupInput").outputs, g.node("NodeGroupOutput").inputs
    start, end, normal = inputs["Start"], inputs["End"], inputs["Normal"]
    heights = [g.vector("DOT_PRODUCT", p, normal) for p in (start, end)]
    crosses = g.scalar("LESS_THAN", g.scalar("MULTIPLY", *heights), 0.0)
    share = g.scalar("MULTIPLY", crosses, g.scalar("DIVIDE", heights[0], g.scalar("SUBTRACT", *heights)))
    crossing = g.vector("ADD", start, g.scaled(g.vector("SUBTRACT", end, start), share))
    ups = [g.scalar("GREATER_THAN", height, 0.0) for height in heights]
    high, low = [], []
    for point, up in zip((start, end), ups):
        way = g.vector("SUBTRACT", point, crossing)
        high.append(g.vector("ADD", crossing, g.scaled(way, up)))
        low.append(flattened(g, g.vector("ADD", crossing, g.scaled(way, g.scalar("SUBTRACT", 1.0, up))), normal))
    across = g.vector("CROSS_PRODUCT", *high)
    sine = g.vector("LENGTH", across)
    angle = g.scalar("ARCTAN2", sine, g.vector("DOT_PRODUCT", *high))
    g.put(outputs["Above"], g.scalar("MULTIPLY", g.vector("DOT_PRODUCT", across, normal), g.scalar("DIVIDE", angle, sine)))
    turned = g.vector("DOT_PRODUCT", g.vector("CROSS_PRODUCT", *low), normal)
    g.put(outputs["Along"], g.scalar("ARCTAN2", turned, g.vector("DOT_PRODUCT", *low)))
    return tree


def flattened(g, vector, normal):
    return g.vector("SUBTRACT", vector, g.scaled(normal, g.vector("DOT_PRODUCT", vector, normal)))
