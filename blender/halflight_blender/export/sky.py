# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's world as Halflight's sky: a colour, an environment picture, or a panorama of any other world shader."""

import math
import os

import bpy

PICTURES = (".hdr", ".exr")
KEYS = ("halflight_sky", "halflight_sky_zenith", "halflight_sky_horizon", "halflight_sky_ground", "halflight_sky_image")


class World:
    """What was understood of a world. `image` is an Image; `panorama` is set where nothing was."""

    def __init__(self, color=(0.0, 0.0, 0.0), image=None, rotation=0.0, strength=1.0, panorama=False):
        self.color = color
        self.image = image
        self.rotation = rotation  # degrees, in the sense of Halflight's sky
        self.strength = strength
        self.panorama = panorama

    def text(self):
        if self.panorama:
            return "A panorama of the world is rendered"
        if self.image:
            return f"Picture {self.image.name}, turned by {self.rotation:.0f}°, times {self.strength:g}"
        return "One colour" if any(self.color) else "Black"


def read_world(world):
    if world is None or world.halflight_sky_source == "NONE":
        return World()
    if not world.use_nodes:
        return World(tuple(world.color))
    background = background_of(world.node_tree)
    if background is None or background.inputs["Strength"].is_linked:
        return World(panorama=True)
    strength = background.inputs["Strength"].default_value
    color = background.inputs["Color"]
    if not color.is_linked:
        return World(tuple(strength * c for c in color.default_value[:3]))
    node = color.links[0].from_node
    rotation = rotation_of(node) if node.bl_idname == "ShaderNodeTexEnvironment" else None
    if rotation is None or not is_plain(node):
        return World(panorama=True)
    return World(image=node.image, rotation=rotation, strength=strength)


def background_of(tree):
    outputs = [n for n in tree.nodes if n.bl_idname == "ShaderNodeOutputWorld" and n.is_active_output]
    if not outputs or not outputs[0].inputs["Surface"].is_linked:
        return None
    node = outputs[0].inputs["Surface"].links[0].from_node
    return node if node.bl_idname == "ShaderNodeBackground" else None


def is_plain(node):
    """An equirectangular picture in a file or packed, of scene-linear light."""
    image = node.image
    if image is None or node.projection != "EQUIRECTANGULAR" or image.source != "FILE" or not image.is_float:
        return False
    name = image.filepath or image.name
    return os.path.splitext(name)[1].lower() in PICTURES and "linear" in image.colorspace_settings.name.lower()


def rotation_of(node):
    """Degrees about the vertical by a Mapping node, all that may be before the picture; None for anything else."""
    vector = node.inputs["Vector"]
    if not vector.is_linked:
        return 0.0
    before = vector.links[0].from_node
    if before.bl_idname == "ShaderNodeTexCoord":
        return 0.0 if vector.links[0].from_socket.name == "Generated" else None
    if before.bl_idname != "ShaderNodeMapping" or before.vector_type not in {"POINT", "TEXTURE", "VECTOR"}:
        return None
    sockets = {s.name: s for s in before.inputs}
    if any(sockets[name].is_linked for name in ("Location", "Rotation", "Scale") if name in sockets):
        return None
    source = sockets["Vector"].links[0].from_socket.name if sockets["Vector"].is_linked else "Generated"
    turn = tuple(sockets["Rotation"].default_value)
    moved = "Location" in sockets and any(abs(v) > 1e-6 for v in sockets["Location"].default_value)
    scaled = any(abs(v - 1.0) > 1e-6 for v in sockets["Scale"].default_value)
    if source != "Generated" or moved or scaled or abs(turn[0]) > 1e-6 or abs(turn[1]) > 1e-6:
        return None
    return math.degrees(turn[2] if before.vector_type == "TEXTURE" else -turn[2])


def add_sky(context, extras, factor, folder):
    """Adds the sky to the scene's extras, unless these name one already. `factor`: lumens per watt."""
    if any(key in extras for key in KEYS):
        return []
    world = read_world(context.scene.world)
    if not world.image and not world.panorama:
        extras["halflight_sky"] = [factor * c for c in world.color]
        return []
    if world.panorama:
        path = os.path.join(folder, "sky_panorama.exr")
        if not render_panorama(context, path):
            return ["the world's shader could not be rendered, as Cycles is not enabled: the sky is black"]
    else:
        path = picture_file(world.image, folder)
        if not os.path.exists(path):
            extras["halflight_sky"] = [0.0, 0.0, 0.0]
            return [f"the world's picture is not there: {path}; the sky is black"]
    extras["halflight_sky_image"] = path
    extras["halflight_sky_rotation"] = world.rotation
    extras["halflight_sky_intensity"] = factor * world.strength
    return []


def picture_file(image, folder):
    if image.packed_file is None:
        return bpy.path.abspath(image.filepath, library=image.library)
    path = os.path.join(folder, "sky" + os.path.splitext(image.filepath or image.name)[1].lower())
    with open(path, "wb") as file:
        file.write(image.packed_file.data)
    return path


def render_panorama(context, path):
    """Renders the world alone. Camera and scene go again; the user's scene is not touched."""
    world = context.scene.world
    scene = bpy.data.scenes.new("Halflight panorama")
    data = bpy.data.cameras.new("Halflight panorama")
    camera = bpy.data.objects.new("Halflight panorama", data)
    try:
        scene.render.engine = "CYCLES"
    except TypeError:
        scene.render.engine = scene.render.engine
    try:
        if scene.render.engine != "CYCLES":
            return False
        scene.collection.objects.link(camera)
        scene.camera, scene.world = camera, world
        camera.rotation_euler = (math.pi / 2, 0.0, -math.pi / 2)  # its middle looks along +X
        data.type = "PANO"
        owner = data if hasattr(data, "panorama_type") else data.cycles
        owner.panorama_type = "EQUIRECTANGULAR"
        scene.cycles.samples = 16
        scene.cycles.use_denoising = False
        render = scene.render
        render.resolution_x, render.resolution_y = world.halflight_sky_width, world.halflight_sky_width // 2
        render.resolution_percentage = 100
        render.use_compositing = render.use_sequencer = False
        render.image_settings.file_format = "OPEN_EXR"
        render.image_settings.color_mode = "RGB"
        render.image_settings.color_depth = "32"
        render.use_file_extension = False
        render.filepath = path
        bpy.ops.render.render(write_still=True, scene=scene.name)
        return os.path.exists(path)
    finally:
        bpy.data.objects.remove(camera)
        bpy.data.cameras.remove(data)
        bpy.data.scenes.remove(scene)
