# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake Materials: pictures in place of nodes that glTF lacks, for the exported copies alone.

Each object whose materials need it gets a mesh of its own, modifiers applied, with a UV set for the pictures. Cycles bakes each
channel as emission, with a copy of the material that emits it.
"""

import bpy
import numpy as np

from . import channels, findings, scene_copy

UV = "halflight materials"
MARGIN = 8  # texels around each island
SAMPLES = 4
TEXELS_PER_SECOND = 1.5e6  # about, of one channel
# What a copy bakes at once: name, and the channels that it has as red, green and blue.
PASSES = (
    ("alpha", (channels.ALPHA,)),
    ("color", (channels.COLOR,)),
    ("surface", (channels.ROUGHNESS, channels.METALLIC)),
    ("emission", (channels.GLOW,)),
)
# Nodes whose values differ between objects that share a mesh.
BY_OBJECT = {"ShaderNode" + kind for kind in ("ObjectInfo", "NewGeometry", "ParticleInfo", "HairInfo", "CameraData")}


def is_curable(material):
    return bool(findings.lost_nodes(material)) and channels.surface_of(material) is not None


def can_bake(item):
    """Skins and shape keys would be lost with the modifiers."""
    moves = any(modifier.type in {"ARMATURE", "LATTICE", "MESH_DEFORM"} for modifier in item.modifiers)
    return item.type == "MESH" and not moves and item.data.shape_keys is None and len(item.data.uv_layers) < 8


def needed(objects):
    """Objects of the scene whose materials get pictures, one for each mesh where these are the same."""
    found = {}
    for item in objects:
        if can_bake(item) and any(is_curable(slot.material) for slot in item.material_slots):
            found.setdefault(key_of(item), []).append(item)
    return found


def key_of(item):
    """Objects with the same key have the same pictures."""
    materials = tuple(slot.material.name_full if slot.material else "" for slot in item.material_slots)
    if item.modifiers or any(slot.material and is_by_object(slot.material.node_tree, 4) for slot in item.material_slots):
        return (item.name_full,)
    return (item.data.name_full, *materials)


def is_by_object(tree, depth):
    for node in tree.nodes if tree else ():
        if node.bl_idname in BY_OBJECT or getattr(node, "attribute_type", "GEOMETRY") != "GEOMETRY":
            return True
        outputs = ("Object", "Camera", "Window") if node.bl_idname == "ShaderNodeTexCoord" else ()
        if any(node.outputs[name].is_linked for name in outputs):
            return True
        if depth > 0 and getattr(node, "node_tree", None) and is_by_object(node.node_tree, depth - 1):
            return True
    return False


def estimate(objects, size):
    """Number of pictures, and seconds to bake them."""
    count = 0
    for items in needed(objects).values():
        materials = [slot.material for slot in items[0].material_slots if is_curable(slot.material)]
        linked = {name for material in materials for name in linked_channels(material)}
        if channels.ALPHA in linked:
            linked.add(channels.COLOR)
        count += sum(bool(linked & set(members)) for _, members in PASSES)
    return count, count * size * size / TEXELS_PER_SECOND


def linked_channels(material):
    """Without a change of the material."""
    copy = material.copy()
    try:
        g, node = channels.graph_of(copy), channels.surface_of(copy)
        return [name for name in channels.CHANNELS if not channels.is_constant(channels.channel(g, node, name))]
    finally:
        bpy.data.materials.remove(copy)


class Pictures:
    """Bakes within a scene of its own, which the window shows meanwhile."""

    def __init__(self, size):
        self.size = size
        self.made = []  # data-blocks, for the copy of the scene to remove
        self.scene = None

    def bake(self, context, copies):
        """`copies`: of the user's objects, by the original."""
        window = context.window
        before = window.scene
        self.scene = bpy.data.scenes.new("Halflight materials")
        try:
            window.scene = self.scene
            prepare(self.scene)
            for items in needed(copies).values():
                materials = self.bake_object(context, items[0], copies[items[0]])
                mesh = copies[items[0]].data
                for item in items:
                    copies[item].modifiers.clear()
                    scene_copy.use_data(copies[item], mesh, materials)
        finally:
            window.scene = before
            bpy.data.scenes.remove(self.scene)

    def bake_object(self, context, item, copy):
        """The copy has a mesh of its own then. Returns the material of each slot."""
        self.scene.collection.objects.link(copy)
        was_hidden, copy.hide_render, copy.hide_select = copy.hide_render, False, False
        context.view_layer.update()
        depsgraph = context.evaluated_depsgraph_get()
        shape = copy.evaluated_get(depsgraph)
        mesh = bpy.data.meshes.new_from_object(shape, preserve_all_data_layers=True, depsgraph=depsgraph)
        mesh[scene_copy.SOURCE] = item.data.name
        self.made.append(mesh)
        copy.modifiers.clear()
        copy.data = mesh
        own = [slot.material for slot in item.material_slots]
        shown = [slot.material for slot in copy.material_slots]
        curable = [is_curable(material) for material in own]
        unwrap(context, copy, any(reads_uv(material) for material in own))
        try:
            pictures = {}
            for name, members in PASSES:
                forced = name == "color" and pictures["alpha"] is not None  # glTF has both in one picture
                pictures[name] = self.bake_pass(copy, name, members, own, curable, forced)
        finally:
            for slot, material in zip(copy.material_slots, shown):
                slot.material = material
            copy.hide_render = was_hidden
            self.scene.collection.objects.unlink(copy)
        images = self.images_of(item, pictures)
        slots = zip(own, shown, curable)
        return [self.final(material, images) if cure else other for material, other, cure in slots]

    def bake_pass(self, copy, name, members, own, curable, forced):
        """Pixels, or None where the channels are constants in all materials."""
        image = bpy.data.images.new("Halflight " + name, self.size, self.size, float_buffer=True)
        image.colorspace_settings.name = "Non-Color"
        emitting, varies = [], forced
        for material, cure in zip(own, curable):
            each, linked = emitter(material if cure else None, members, image)
            emitting.append(each)
            varies = varies or linked
        try:
            if not varies:
                return None
            for slot, material in zip(copy.material_slots, emitting):
                slot.link = "OBJECT"
                slot.material = material
            bpy.ops.object.bake(type="EMIT", margin=MARGIN, use_clear=True, uv_layer=UV, target="IMAGE_TEXTURES")
            pixels = np.zeros(self.size * self.size * 4, np.float32)
            image.pixels.foreach_get(pixels)
            return pixels.reshape(-1, 4)
        finally:
            bpy.data.batch_remove([*emitting, image])

    def images_of(self, item, pictures):
        """Pictures for the exporter: colour with alpha, roughness with metallic, and emission with its strength."""
        images, strength = {}, 1.0
        color, alpha, glow = pictures["color"], pictures["alpha"], pictures["emission"]
        if color is not None:
            pixels = np.ones((self.size * self.size, 4), np.float32)
            pixels[:, :3] = encoded(color[:, :3])
            pixels[:, 3] = alpha[:, 0] if alpha is not None else 1.0
            images["color"] = self.image(f"{item.name} color", pixels, "sRGB")
        if pictures["surface"] is not None:
            images["surface"] = self.image(f"{item.name} surface", pictures["surface"], "Non-Color")
        if glow is not None:
            strength = max(float(glow[:, :3].max()), 1e-6)
            pixels = np.ones_like(glow)
            pixels[:, :3] = encoded(glow[:, :3] / strength)
            images["emission"] = self.image(f"{item.name} emission", pixels, "sRGB")
        return images, strength, alpha is not None

    def image(self, name, pixels, space):
        image = bpy.data.images.new(name, self.size, self.size, alpha=True)
        image.colorspace_settings.name = space
        image.pixels.foreach_set(np.clip(pixels, 0.0, 1.0).reshape(-1))
        image.pack()
        self.made.append(image)
        return image

    def final(self, material, baked):
        """A copy whose Principled shader reads the pictures, and has the constants of what does not vary."""
        images, strength, has_alpha = baked
        copy = material.copy()
        copy["halflight_copy_of"] = material.name
        copy["halflight_pictures"] = 1
        self.made.append(copy)
        g, surface = channels.graph_of(copy), channels.surface_of(copy)
        constants = {name: channels.channel(g, surface, name) for name in channels.CHANNELS}
        shader = surface
        if surface.bl_idname != "ShaderNodeBsdfPrincipled":
            shader = g.node("ShaderNodeBsdfPrincipled")
            g.put(copy.node_tree.get_output_node("CYCLES").inputs["Surface"], shader.outputs[0])
        textures = {name: g.picture(image, g.uv(UV)) for name, image in images.items()}
        found = {}
        if "color" in textures:
            found[channels.COLOR] = textures["color"]["Color"]
            if has_alpha:
                found[channels.ALPHA] = textures["color"]["Alpha"]
                if getattr(copy, "blend_method", "") == "OPAQUE":  # which the exporter takes at its word, and Cycles does not
                    copy.blend_method = "BLEND"
        if "surface" in textures:
            parts = g.separate(textures["surface"]["Color"])
            found[channels.ROUGHNESS], found[channels.METALLIC] = parts[1], parts[2]
        if "emission" in textures:
            found[channels.GLOW] = textures["emission"]["Color"]
        set_shader(g, shader, found, constants, strength if "emission" in textures else 1.0)
        return copy


def reads_uv(material):
    """Whether nodes may read the user's UV sets, while materials are baked or in the exported file."""
    if material is None or not material.use_nodes:
        return False
    kinds = {"ShaderNodeTexImage", "ShaderNodeUVMap", "ShaderNodeTexCoord", "ShaderNodeNormalMap", "ShaderNodeTangent"}
    return any(node.bl_idname in kinds or getattr(node, "node_tree", None) for node in material.node_tree.nodes)


def prepare(scene):
    scene.render.engine = "CYCLES"
    scene.cycles.device, scene.cycles.samples = "CPU", SAMPLES
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.render.bake.use_selected_to_active = False


def unwrap(context, item, is_read):
    """A UV set in which nothing overlaps: the first where no material reads that, as the second may be the lightmap's."""
    layers = item.data.uv_layers
    if layers and not is_read:
        layers[0].name = UV
    else:
        layers.new(name=UV, do_init=False)
    layers.active = layers[UV]
    context.view_layer.objects.active = item
    item.select_set(True)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.reveal()
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.uv.smart_project(island_margin=0.01)
    bpy.ops.object.mode_set(mode="OBJECT")
    (layers[0] if is_read else layers[UV]).active_render = True


def emitter(material, members, image):
    """A material that emits these channels, and whether one of them varies. None: one that emits nothing."""
    copy = material.copy() if material else bpy.data.materials.new("Halflight black")
    copy.use_nodes = True
    g = channels.graph_of(copy)
    node = channels.surface_of(copy) if material else None
    values = [channels.channel(g, node, name) if node else 0.0 for name in members]
    emission = g.node("ShaderNodeEmission")
    if len(values) == 1 and not isinstance(values[0], float):
        source = values[0] if not channels.is_constant(values[0]) else (*values[0], 1.0)
        g.put(emission.inputs["Color"], source)
    else:
        combined = g.node("ShaderNodeCombineXYZ")
        for socket, value in zip(combined.inputs if len(values) == 1 else combined.inputs[1:], values):
            g.put(socket, value)
        g.put(emission.inputs["Color"], combined.outputs[0])
    output = copy.node_tree.get_output_node("CYCLES") or g.node("ShaderNodeOutputMaterial")
    for link in [*output.inputs["Volume"].links, *output.inputs["Displacement"].links]:
        copy.node_tree.links.remove(link)
    g.put(output.inputs["Surface"], emission.outputs[0])
    target = g.node("ShaderNodeTexImage", image=image)
    copy.node_tree.nodes.active = target
    return copy, not channels.is_constant(*values)


def set_shader(g, shader, found, constants, strength):
    names = {
        channels.COLOR: ("Base Color",),
        channels.METALLIC: ("Metallic",),
        channels.ROUGHNESS: ("Roughness",),
        channels.ALPHA: ("Alpha",),
        channels.GLOW: ("Emission Color", "Emission"),
    }
    for name, sockets in names.items():
        socket = next(shader.inputs[each] for each in sockets if each in shader.inputs)
        source = found.get(name)
        for link in list(socket.links):
            g.tree.links.remove(link)
        if source is not None:
            g.put(socket, source)
        elif channels.is_constant(constants[name]):
            constant = constants[name]
            socket.default_value = (*constant, 1.0) if isinstance(constant, tuple) else constant
    socket = shader.inputs["Emission Strength"]
    for link in list(socket.links):
        g.tree.links.remove(link)
    socket.default_value = strength


def encoded(color):
    """sRGB's transfer function."""
    color = np.clip(color, 0.0, 1.0)
    return np.where(color <= 0.0031308, 12.92 * color, 1.055 * np.power(np.maximum(color, 1e-8), 1.0 / 2.4) - 0.055)
