# SPDX-License-Identifier: GPL-3.0-or-later
"""A furnished room of matte surfaces: a window with a pane, sun, a picture as the sky, an area light, a glowing bulb,
pictures as textures, modifiers, linked duplicates, letters, a curve, instances of a collection, leaves with holes, a ball."""

import math
import os

import bpy
import numpy as np
import stage

WIDTH, DEPTH, HEIGHT = 5.0, 4.0, 2.7


def build(folder):
    """In an empty scene; returns it."""
    scene = bpy.context.scene
    surfaces = Surfaces(folder)
    add_walls(surfaces)
    add_furniture(surfaces)
    add_small_things(surfaces)
    add_books(surfaces)
    add_leaves(surfaces)
    add_lights()
    add_sky(scene, folder)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (1.6, -1.85, 1.65), (math.radians(80), 0, math.radians(33))
    camera.data.lens = 19
    scene.collection.objects.link(camera)
    scene.camera = camera
    bpy.context.view_layer.update()
    return scene


# -- surfaces --------------------------------------------------------------------------------------------------------


class Surfaces:
    """Materials by name. Blender before 4.0 draws Principled's diffuse part otherwise, so these are Diffuse BSDF."""

    def __init__(self, folder):
        self.folder = folder
        self.random = np.random.default_rng(5)
        self.made = {}
        for name, color in (
            ("Plaster", (0.82, 0.79, 0.74)), ("Red plaster", (0.62, 0.16, 0.1)), ("Ceiling", (0.9, 0.9, 0.9)),
            ("Brass", (0.9, 0.65, 0.3)), ("Black", (0.03, 0.03, 0.03)), ("Letters", (0.05, 0.25, 0.5)),
            ("Cable", (0.02, 0.02, 0.02)), ("Rug", (0.5, 0.1, 0.15)), ("Ball", (0.1, 0.6, 0.2)),
            ("Book 0", (0.5, 0.1, 0.1)), ("Book 1", (0.1, 0.3, 0.15)), ("Book 2", (0.1, 0.15, 0.45)),
            ("Book 3", (0.6, 0.5, 0.2)),
        ):  # fmt: skip
            self.add(name, color)
        self.add("Wood floor", picture=self.wood(), repeat=3)
        self.add("Table wood", picture=self.made["Wood floor"].node_tree.nodes["Image Texture"].image)
        self.add("Fabric", picture=self.fabric(), repeat=2)
        self.add_leaf()
        self.add_principled("Glow", "Emission Color", "Emission", (1.0, 0.75, 0.45, 1.0), {"Emission Strength": 12.0})
        self.add_principled("Glass", "Transmission Weight", "Transmission", 1.0, {"IOR": 1.45, "Roughness": 0.0})

    def __getitem__(self, name):
        return self.made[name]

    def add(self, name, color=(1, 1, 1), picture=None, repeat=1):
        material = self.made[name] = stage.diffuse(name, color)
        tree = material.node_tree
        if picture is not None:
            kinds = ("TexImage", "Mapping", "TexCoord")
            texture, mapping, place = (tree.nodes.new("ShaderNode" + kind) for kind in kinds)
            texture.image = picture
            mapping.inputs["Scale"].default_value = (repeat, repeat, 1)
            tree.links.new(place.outputs["UV"], mapping.inputs["Vector"])
            tree.links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
            tree.links.new(texture.outputs["Color"], tree.nodes["Diffuse BSDF"].inputs["Color"])
        return material

    def add_principled(self, name, new, old, value, others):
        material = self.made[name] = bpy.data.materials.new(name)
        material.use_nodes = True
        inputs = material.node_tree.nodes["Principled BSDF"].inputs
        inputs["Specular IOR Level" if "Specular IOR Level" in inputs else "Specular"].default_value = 0.0
        inputs["Base Color"].default_value = (1, 1, 1, 1)
        inputs[new if new in inputs else old].default_value = value
        for key, number in others.items():
            inputs[key].default_value = number
        return inputs

    def add_leaf(self):
        y, x = np.mgrid[0:256, 0:256] / 256
        inside = ((x - 0.5) ** 2 / 0.06 + (y - 0.5) ** 2 / 0.2 < 1).astype(float)
        flat = np.ones_like(inside)
        image = self.picture("leaf", np.stack([0.2 * flat, 0.5 * flat, 0.15 * flat, inside], 2))
        inputs = self.add_principled("Leaf", "Alpha", "Alpha", 1.0, {"Roughness": 0.6})
        tree = self.made["Leaf"].node_tree
        texture = tree.nodes.new("ShaderNodeTexImage")
        texture.image = image
        tree.links.new(texture.outputs["Color"], inputs["Base Color"])
        tree.links.new(texture.outputs["Alpha"], inputs["Alpha"])
        self.made["Leaf"].blend_method = "CLIP"

    def picture(self, name, values):
        image = bpy.data.images.new(name, values.shape[1], values.shape[0], alpha=values.shape[2] == 4)
        pixels = np.ones((*values.shape[:2], 4), np.float32)
        pixels[..., : values.shape[2]] = values
        image.pixels.foreach_set(pixels.reshape(-1))
        image.pack()
        return image

    def wood(self):
        y, _ = np.mgrid[0:256, 0:256] / 256
        value = 0.45 + (self.random.random(6) * 0.25)[(y * 6).astype(int)] + 0.1 * (self.noise(32) - 0.5)
        planks = np.stack([value, value * 0.72, value * 0.5], 2)
        planks[(y * 6) % 1 < 0.05] *= 0.4
        return self.picture("wood", planks)

    def fabric(self):
        y, x = np.mgrid[0:256, 0:256] / 256
        value = 0.5 + 0.35 * (((x * 32).astype(int) + (y * 32).astype(int)) % 2)
        return self.picture("fabric", np.stack([value * 0.35, value * 0.5, value * 0.75], 2))

    def noise(self, cells):
        grid = self.random.random((cells, cells))
        place = np.arange(256) / 256 * cells
        low, share = place.astype(int), place % 1
        share = share * share * (3 - 2 * share)
        rows = grid[:, low] * (1 - share) + grid[:, (low + 1) % cells] * share
        return rows[low] * (1 - share)[:, None] + rows[(low + 1) % cells] * share[:, None]


# -- things ----------------------------------------------------------------------------------------------------------


def link(item, collection=None):
    (collection or bpy.context.scene.collection).objects.link(item)
    return item


def box(name, size, location, surface, collection=None, scale=1.0):
    """`scale`: of its texture coordinates, which are its sides' in metres."""
    x, y, z = (each / 2 for each in size)
    corners = [(a, b, c) for a in (-x, x) for b in (-y, y) for c in (-z, z)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return mesh(name, corners, faces, location, surface, collection, scale)


def mesh(name, corners, faces, location, surface, collection=None, scale=1.0):
    data = bpy.data.meshes.new(name)
    data.from_pydata(corners, [], faces)
    data.materials.append(surface)
    layer = data.uv_layers.new(name="UVMap").data
    for face in data.polygons:
        across = max(range(3), key=lambda axis: abs(face.normal[axis]))
        u, v = (axis for axis in range(3) if axis != across)
        for index in face.loop_indices:
            place = data.vertices[data.loops[index].vertex_index].co
            layer[index].uv = (place[u] * scale + 0.5, place[v] * scale + 0.5)
    item = bpy.data.objects.new(name, data)
    item.location = location
    return link(item, collection)


def add_walls(s):
    outer, half = WIDTH + 0.4, -WIDTH / 2 - 0.1
    box("Floor", (outer, DEPTH + 0.4, 0.2), (0, 0, -0.1), s["Wood floor"], scale=0.2)
    box("Ceiling", (outer, DEPTH + 0.4, 0.2), (0, 0, HEIGHT + 0.1), s["Ceiling"])
    for name, side in (("Wall back", 1), ("Wall front", -1)):
        box(name, (outer, 0.2, HEIGHT), (0, side * (DEPTH / 2 + 0.1), HEIGHT / 2), s["Plaster"])
        width = DEPTH / 2 - 0.9
        place = (half, side * (0.9 + width / 2), HEIGHT / 2)
        box("Wall window b" if side > 0 else "Wall window a", (0.2, width, HEIGHT), place, s["Plaster"])
    box("Wall right", (0.2, DEPTH, HEIGHT), (WIDTH / 2 + 0.1, 0, HEIGHT / 2), s["Red plaster"])
    box("Wall window c", (0.2, 1.8, 0.9), (half, 0, 0.45), s["Plaster"])
    box("Wall window d", (0.2, 1.8, HEIGHT - 2.2), (half, 0, (HEIGHT + 2.2) / 2), s["Plaster"])
    box("Window bar 0", (0.06, 0.05, 1.3), (half, 0, 1.55), s["Plaster"])
    box("Window bar 1", (0.06, 1.8, 0.05), (half, 0, 1.55), s["Plaster"])
    corners = [(0, -0.9, 0.9), (0, 0.9, 0.9), (0, 0.9, 2.2), (0, -0.9, 2.2)]
    pane = mesh("Pane", corners, [(0, 1, 2, 3)], (half - 0.05, 0, 0), s["Glass"])
    pane.visible_shadow = pane.visible_diffuse = False  # Cycles lets no light of lamps through glass without caustics


def add_furniture(s):
    box("Table", (1.5, 0.8, 0.05), (0.3, 0.2, 0.72), s["Table wood"], scale=0.6)
    for number, (x, y) in enumerate(((-1, -1), (1, -1), (-1, 1), (1, 1))):
        box(f"Table leg {number}", (0.06, 0.06, 0.7), (0.3 + x * 0.68, 0.2 + y * 0.34, 0.35), s["Table wood"])
    chair = box("Chair", (0.42, 0.42, 0.04), (0.0, 0.95, 0.45), s["Table wood"])
    chair.modifiers.new("Bevel", "BEVEL").width = 0.01
    back = box("Chair back", (0.42, 0.03, 0.45), (0, 0.2, 0.27), s["Table wood"])
    back.parent = chair
    for number, (x, y, turn) in enumerate(((0.7, 0.95, 0.1), (0.0, -0.55, math.pi), (0.8, -0.5, math.pi - 0.3))):
        twin, twin_back = link(chair.copy()), link(back.copy())
        twin.name, twin_back.name, twin_back.parent = f"Chair {number}", f"Chair back {number}", twin
        twin.location, twin.rotation_euler = (x, y, 0.45), (0, 0, turn)
    for name, size, place in (("Sofa", (1.7, 0.7, 0.4), (0.6, 1.55, 0.25)), ("Sofa back", (1.7, 0.2, 0.6), (0.6, 1.85, 0.6))):
        bevel = box(name, size, place, s["Fabric"]).modifiers.new("Bevel", "BEVEL")
        bevel.width, bevel.segments = 0.08, 3
    rug = [(-0.7, -0.5, 0), (0.7, -0.5, 0), (0.7, 0.5, 0), (-0.7, 0.5, 0)]
    mesh("Rug", rug, [(0, 1, 2, 3)], (-1.1, 0.5, 0.01), s["Rug"])
    box("Shelf", (1.4, 0.3, 0.04), (-1.4, 1.85, 0.6), s["Table wood"])


def add_small_things(s):
    bpy.ops.mesh.primitive_monkey_add(size=0.35, location=(0.55, 0.15, 0.93), rotation=(0, 0, -0.6))
    smooth("Statue", s["Brass"]).modifiers.new("Subdivision", "SUBSURF").levels = 0
    box("Lamp pole", (0.04, 0.04, 1.4), (2.1, 1.6, 0.7), s["Black"])
    bpy.ops.mesh.primitive_uv_sphere_add(segments=20, ring_count=12, radius=0.14, location=(2.1, 1.6, 1.5))
    smooth("Bulb", s["Glow"])
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=16, radius=0.2, location=(-1.0, -0.6, 0.6))
    smooth("Ball", s["Ball"])
    letters = bpy.data.curves.new("Sign", "FONT")
    letters.body, letters.size, letters.extrude = "Half light", 0.5, 0.03
    letters.materials.append(s["Letters"])
    sign = link(bpy.data.objects.new("Sign", letters))
    sign.location, sign.rotation_euler = (-1.9, DEPTH / 2 - 0.04, 1.7), (math.pi / 2, 0, 0)
    cable = bpy.data.curves.new("Cable", "CURVE")
    cable.dimensions, cable.bevel_depth = "3D", 0.012
    cable.splines.new("BEZIER").bezier_points.add(2)
    for point, place in zip(cable.splines[0].bezier_points, ((2.1, 1.6, 0.02), (1.7, 1.0, 0.02), (2.35, 0.2, 0.02))):
        point.co, point.handle_left_type, point.handle_right_type = place, "AUTO", "AUTO"
    cable.materials.append(s["Cable"])
    link(bpy.data.objects.new("Cable", cable))


def smooth(name, surface):
    item = bpy.context.object
    item.name = name
    item.data.materials.append(surface)
    bpy.ops.object.shade_smooth()
    return item


def add_books(s):
    books = bpy.data.collections.new("Books")
    place = 0.0
    sizes = ((0.04, 0.2), (0.06, 0.26), (0.03, 0.22), (0.05, 0.28), (0.04, 0.18), (0.06, 0.24))
    for number, (width, height) in enumerate(sizes):
        box(f"Book {number}", (width, 0.16, height), (place + width / 2, 0, height / 2), s[f"Book {number % 4}"], books)
        place += width + 0.003
    places = (((-1.9, 1.85, 0.62), 0), ((-1.4, 1.85, 0.62), 0.15), ((0.0, 0.35, 0.745), 0.7))
    for number, (location, turn) in enumerate(places):
        instance = link(bpy.data.objects.new(f"Books {number}", None))
        instance.instance_type, instance.instance_collection = "COLLECTION", books
        instance.location, instance.rotation_euler = location, (0, 0, turn)


def add_leaves(s):
    box("Pot", (0.25, 0.25, 0.25), (-2.1, -1.4, 0.125), s["Red plaster"])
    corners, faces = [], []
    for number in range(14):
        x, y, z = math.cos(number * 2.4), math.sin(number * 2.4), 0.3 + 0.05 * number
        first = len(corners)
        corners += [(-0.1 * y, 0.1 * x, z), (0.1 * y, -0.1 * x, z)]
        corners += [(0.35 * x + 0.1 * y, 0.35 * y - 0.1 * x, z + 0.15), (0.35 * x - 0.1 * y, 0.35 * y + 0.1 * x, z + 0.15)]
        faces.append(tuple(range(first, first + 4)))
    leaves = mesh("Leaves", corners, faces, (-2.1, -1.4, 0), s["Leaf"])
    for face in leaves.data.polygons:
        for index, uv in zip(face.loop_indices, ((0, 0), (1, 0), (1, 1), (0, 1))):
            leaves.data.uv_layers[0].data[index].uv = uv


def add_lights():
    panel = bpy.data.lights.new("Ceiling panel", "AREA")
    panel.shape, panel.size, panel.size_y, panel.energy, panel.color = "RECTANGLE", 1.0, 0.4, 25, (1, 0.95, 0.85)
    link(bpy.data.objects.new("Ceiling panel", panel)).location = (0.3, 0.2, HEIGHT - 0.02)
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.angle, sun.color = 5, math.radians(0.5), (1, 0.93, 0.82)
    link(bpy.data.objects.new("Sun", sun)).rotation_euler = (0, math.radians(-55), math.radians(-14))


def add_sky(scene, folder):
    height, width = 64, 128
    up = (np.mgrid[0:height, 0:width][0] + 0.5) / height - 0.5
    value = np.where(up > 0, 0.9 - 1.2 * up, 0.25)
    pixels = np.stack([value * 0.75, value * 0.88, value * 1.1, np.ones_like(value)], 2).astype(np.float32)
    image = bpy.data.images.new("room_sky", width, height, float_buffer=True)
    image.pixels.foreach_set(pixels.reshape(-1))
    image.file_format, image.filepath_raw = "HDR", os.path.join(folder, "room_sky.hdr")
    image.save()
    bpy.data.images.remove(image)
    world = scene.world = bpy.data.worlds.new("Sky")
    world.use_nodes = True
    tree = world.node_tree
    environment = tree.nodes.new("ShaderNodeTexEnvironment")
    environment.image = bpy.data.images.load(os.path.join(folder, "room_sky.hdr"))
    tree.links.new(environment.outputs["Color"], tree.nodes["Background"].inputs["Color"])
