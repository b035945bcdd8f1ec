# SPDX-License-Identifier: GPL-3.0-or-later
"""Light groups in the baked view: one node group that holds a weight for each, and adds up their light."""

import bpy

from ..export import sky
from ..groups import members
from . import graph

GROUP = "Halflight light groups"
TAG = "halflight_baked_view"  # of all that a view is made of


class Groups:
    """Of a bake. `records`: those of bake.json; `document`: the baked file; `source`: the user's scene."""

    def __init__(self, records, document, source, lumens_per_watt):
        self.records = records
        self.document = document
        self.lumens_per_watt = lumens_per_watt
        self.entries = {entry.name: entry for entry in source.halflight.light_groups if entry.is_baked}
        self.tree = make_group(records) if records else None

    def name(self, baking):
        """Of the group that a light's or material's record names, or None."""
        group = baking.get("group", -1)
        return self.records[group]["name"] if group >= 0 else None

    def node(self, g):
        """Sockets of the group in a material or another group."""
        return g.node("ShaderNodeGroup", node_tree=self.tree)

    def irradiance(self, g, pictures):
        """Sum of the groups' light. `pictures`: a socket in lux at the weight 1 for each group, or None where it has none."""
        node = self.node(g)
        for record, picture in zip(self.records, pictures):
            if picture is not None:
                g.put(node.inputs[light_name(record["name"])], picture)
        return node.outputs["Irradiance"]

    def weight(self, g, name):
        return self.node(g).outputs[weight_name(name)]

    def changed(self, g, light, name):
        """Light that is what it was at the group's weight now, and is to follow the weight."""
        record = next(record for record in self.records if record["name"] == name)
        entry = self.entries.get(name)
        follows = entry is not None and len(entry.members) > 0
        now = [max(w, members.LEAST) * u for w, u in zip(entry.weight(), entry.unit)] if follows else record["weight"]
        return g.vector("MULTIPLY", g.vector("MULTIPLY", light, [1.0 / w if w > 0.0 else 0.0 for w in now]), self.weight(g, name))

    def name_of_material(self, name):
        """The group of a material's emission in the baked file, by the material's name; None where it has several."""
        found = set()
        for record in self.document.json.get("materials", []):
            if record.get("name") == name and any(record.get("emissiveFactor", ())):
                found.add(self.name(record.get("extensions", {}).get("HALFLIGHT_material", {}).get("baking", {})))
        return next(iter(found)) if len(found) == 1 else None


def light_name(name):
    return "Light of " + name


def weight_name(name):
    return "Weight of " + name


def make_group(records):
    """Inputs: light of each group at the weight 1. Outputs: the sum, and each weight."""
    tree = bpy.data.node_groups.new(GROUP, "ShaderNodeTree")
    for record in records:
        graph.add_group_socket(tree, light_name(record["name"]), "NodeSocketVector", False)
    graph.add_group_socket(tree, "Irradiance", "NodeSocketVector", True)
    for record in records:
        graph.add_group_socket(tree, weight_name(record["name"]), "NodeSocketVector", True)
    g = graph.Graph(tree)
    inputs, outputs = g.node("NodeGroupInput").outputs, g.node("NodeGroupOutput").inputs
    total = (0.0, 0.0, 0.0)
    for record in records:
        name = weight_name(record["name"])
        node = g.node("ShaderNodeCombineXYZ", name=name, label=name)
        for socket, value in zip(node.inputs, record["weight"]):
            socket.default_value = value
        g.put(outputs[name], node.outputs[0])
        total = g.vector("ADD", total, g.vector("MULTIPLY", inputs[light_name(record["name"])], node.outputs[0]))
    g.put(outputs["Irradiance"], total)
    return tree


def tree_of(view):
    key = view.get(TAG)
    trees = (tree for tree in bpy.data.node_groups if tree.get(TAG) == key and tree.name.startswith(GROUP))
    return next(trees, None)


def show_weights(view):
    """Sets the weights in a view's node group to those of the sliders."""
    tree = tree_of(view)
    if tree is None:
        return
    for entry in view.halflight.view_of.halflight.light_groups:
        node = tree.nodes.get(weight_name(entry.name))
        if node is None or not entry.is_baked:
            continue
        for socket, value in zip(node.inputs, entry.weight_in_file()):
            if socket.default_value != value:
                socket.default_value = value


def weights_of(view):
    """By name of a group."""
    tree = tree_of(view)
    nodes = [node for node in tree.nodes if node.bl_idname == "ShaderNodeCombineXYZ"] if tree else []
    return {node.name[len(weight_name("")) :]: [socket.default_value for socket in node.inputs] for node in nodes}


# -- the drawn sky ----------------------------------------------------------------------------------------------------


def follow_sky(view, groups):
    """Gives the view a world that follows the weights, where the sky is in a group and the world is what was baked."""
    source = view.halflight.view_of
    names = [record["name"] for record in groups.records if record.get("sky")]
    if not names or any(key in source for key in sky.KEYS):
        return
    if "sky.zenith" in names:
        view.world = gradient_world(groups)
        return
    if source.world is None or not source.world.use_nodes:
        return
    world = source.world.copy()
    background = sky.background_of(world.node_tree)
    if background is None:  # another shader, whose panorama was baked
        bpy.data.worlds.remove(world)
        return
    g = graph.Graph(world.node_tree)
    color = background.inputs["Color"]
    light = color.links[0].from_socket if color.is_linked else list(color.default_value)[:3]
    g.put(color, groups.changed(g, light, names[0]))
    view.world = world


def gradient_world(groups):
    """Zenith, horizon and ground, whose weights are their radiances."""
    world = bpy.data.worlds.new("Baked sky")
    world.use_nodes = True
    world.node_tree.nodes.clear()
    g = graph.Graph(world.node_tree)
    direction = g.node("ShaderNodeSeparateXYZ")
    g.put(direction.inputs[0], g.node("ShaderNodeTexCoord").outputs["Generated"])
    up = direction.outputs[2]
    shares = {
        "sky.zenith": g.scalar("MAXIMUM", up, 0.0),
        "sky.horizon": g.scalar("SUBTRACT", 1.0, g.scalar("ABSOLUTE", up)),
        "sky.ground": g.scalar("MAXIMUM", g.scalar("MULTIPLY", up, -1.0), 0.0),
    }
    total = (0.0, 0.0, 0.0)
    for name, share in shares.items():
        total = g.vector("ADD", total, g.scaled(groups.weight(g, name), share))
    background = g.node("ShaderNodeBackground")
    g.put(background.inputs["Color"], g.scaled(total, 1.0 / groups.lumens_per_watt))
    g.put(g.node("ShaderNodeOutputWorld").inputs["Surface"], background.outputs[0])
    return world
