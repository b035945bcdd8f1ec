# SPDX-License-Identifier: GPL-3.0-or-later
"""The test's scene: mesh, sun, point, spot and area light, HDRI world, settings, instances, modifiers."""

import math
import os

import bpy
import numpy as np


def build(folder):
    scene = bpy.context.scene
    data = bpy.data
    bpy.data.batch_remove([*data.objects, *data.meshes, *data.lights, *data.cameras, *data.materials])
    checker = picture_material(folder)
    floor = add_mesh("Floor", box((6, 6, 0.2)), (0, 0, -0.1), checker)
    floor.data.uv_layers.new(name="UVMap")
    for loop in floor.data.loops:
        co = floor.data.vertices[loop.vertex_index].co
        floor.data.uv_layers[0].data[loop.index].uv = (co.x / 6 + 0.5, co.y / 6 + 0.5)
    add_mesh("Wall", box((6, 0.2, 2.4)), (0, 2.9, 1.2), material("Red", (0.7, 0.15, 0.1)))
    pillar = add_mesh("Pillar", box((0.5, 0.5, 1.6)), (-1.2, 0.5, 0.8), material("White", (0.75, 0.75, 0.75)))
    pillar.halflight_lightmap_scale = 2.0
    # A linked duplicate, whose modifier gives it more geometry than its mesh has.
    twin = bpy.data.objects.new("Twin", pillar.data)
    twin.location = (1.4, 1.2, 0.8)
    bevel = twin.modifiers.new("Bevel", "BEVEL")
    bevel.width, bevel.segments = 0.12, 2
    scene.collection.objects.link(twin)
    ball = add_ball("Ball", (0.3, -0.6, 0.4), 0.4, material("Blue", (0.1, 0.2, 0.7)))
    ball.halflight_static = "DYNAMIC"
    add_instances(scene)
    add_glow()
    add_lights()
    add_world(scene, folder)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (3.6, -5.2, 3.2), (math.radians(65), 0, math.radians(35))
    scene.collection.objects.link(camera)
    scene.camera = camera
    return scene


def add_mesh(name, data, location, surface):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(*data)
    mesh.materials.append(surface)
    item = bpy.data.objects.new(name, mesh)
    item.location = location
    bpy.context.scene.collection.objects.link(item)
    return item


def box(size):
    x, y, z = (s / 2 for s in size)
    corners = [(a, b, c) for a in (-x, x) for b in (-y, y) for c in (-z, z)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners, [], faces


def add_ball(name, location, radius, surface):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12, radius=radius, location=location)
    item = bpy.context.object
    item.name = name
    item.data.materials.append(surface)
    return item


def material(name, color):
    surface = bpy.data.materials.new(name)
    surface.use_nodes = True
    surface.use_backface_culling = True
    shader = surface.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*color, 1.0)
    shader.inputs["Roughness"].default_value = 0.9
    return surface


def picture_material(folder):
    """A picture of large soft squares, so that filtering does not matter."""
    surface = material("Checker", (1, 1, 1))
    image = bpy.data.images.new("Checker", 64, 64)
    y, x = np.mgrid[0:64, 0:64] / 64.0
    value = 0.45 + 0.25 * np.sin(2 * np.pi * x) * np.sin(2 * np.pi * y)
    pixels = np.stack([value, value * 0.9, value * 0.7, np.ones_like(value)], 2)
    image.pixels[:] = pixels.astype(np.float32).reshape(-1)
    image.pack()
    node = surface.node_tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    surface.node_tree.links.new(
        node.outputs["Color"], surface.node_tree.nodes["Principled BSDF"].inputs["Base Color"]
    )
    return surface


def add_instances(scene):
    collection = bpy.data.collections.new("Stones")
    stone = bpy.data.objects.new("Stone", bpy.data.meshes.new("Stone"))
    stone.data.from_pydata(*box((0.4, 0.3, 0.3)))
    stone.data.materials.append(material("Stone", (0.5, 0.55, 0.5)))
    stone.location = (0, 0, 0.15)
    collection.objects.link(stone)
    for number, (x, y, turn) in enumerate(((-2.2, -1.0, 0.4), (2.2, -0.4, 1.2))):
        empty = bpy.data.objects.new(f"Stones {number}", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
        empty.location, empty.rotation_euler = (x, y, 0), (0, 0, turn)
        scene.collection.objects.link(empty)


def add_glow():
    surface = material("Glow", (0, 0, 0))
    inputs = surface.node_tree.nodes["Principled BSDF"].inputs
    inputs["Emission Color" if "Emission Color" in inputs else "Emission"].default_value = (0.2, 1.0, 0.4, 1.0)
    inputs["Emission Strength"].default_value = 0.6
    add_mesh("Sign", box((0.8, 0.05, 0.3)), (0.2, 2.7, 1.5), surface)


def add_light(kind, name, location, energy, **members):
    light = bpy.data.lights.new(name, kind)
    light.energy = energy
    for key, value in members.items():
        setattr(light, key, value)
    item = bpy.data.objects.new(name, light)
    item.location = location
    bpy.context.scene.collection.objects.link(item)
    return item


def add_lights():
    sun = add_light("SUN", "Sun", (0, 0, 5), 4.0, angle=math.radians(2.0), color=(1.0, 0.95, 0.85))
    sun.rotation_euler = (math.radians(-40), 0, math.radians(25))
    add_light(
        "POINT", "Bulb", (-2.2, 1.2, 0.9), 60.0, shadow_soft_size=0.08, use_custom_distance=True, cutoff_distance=4.5
    ).data.halflight_shadow_strength = 0.6
    add_light(
        "SPOT", "Lamp", (2.2, -0.5, 2.0), 150.0, spot_size=math.radians(50), spot_blend=0.4, color=(1.0, 0.8, 0.5)
    ).data.halflight_mode = "BAKED"
    panel = add_light("AREA", "Panel", (-2.0, -0.5, 1.8), 20.0, shape="RECTANGLE", size=1.5, size_y=0.5)
    panel.rotation_euler = (0, math.radians(-25), 0)


def add_world(scene, folder):
    """A sky of 64 x 32 texels, brighter towards one side, turned by 40 degrees."""
    image = bpy.data.images.new("sky", 64, 32, float_buffer=True)
    v, u = np.mgrid[0:32, 0:64]
    u, v = (u + 0.5) / 64, (v + 0.5) / 32
    value = np.where(v > 0.5, 0.3 + 0.4 * v + 0.3 * np.cos(2 * np.pi * u), 0.1)
    pixels = np.stack([0.8 * value, 0.9 * value, value, np.ones_like(value)], 2).astype(np.float32)
    image.pixels[:] = pixels.reshape(-1)
    image.file_format = "HDR"
    image.filepath_raw = os.path.join(folder, "sky.hdr")
    image.save()
    bpy.data.images.remove(image)
    world = bpy.data.worlds.new("Sky")
    world.use_nodes = True
    tree = world.node_tree
    environment = tree.nodes.new("ShaderNodeTexEnvironment")
    environment.image = bpy.data.images.load(os.path.join(folder, "sky.hdr"))
    mapping, coordinates = tree.nodes.new("ShaderNodeMapping"), tree.nodes.new("ShaderNodeTexCoord")
    mapping.inputs["Rotation"].default_value = (0, 0, math.radians(40))
    tree.links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], environment.inputs["Vector"])
    background = tree.nodes["Background"]
    background.inputs["Strength"].default_value = 0.5
    tree.links.new(environment.outputs["Color"], background.inputs["Color"])
    scene.world = world
