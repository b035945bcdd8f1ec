# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes, their bakes, and Cycles' pictures of the user's scene and of the baked view: for the scripts run in Blender."""

import importlib
import math
import os
import sys

import bpy
import numpy as np

HALFLIGHT, PACKAGE, FOLDER = sys.argv[sys.argv.index("--") + 1 :]
WIDTH, HEIGHT = 120, 75
SAMPLES = 64
# Of a region's mean radiance, between the baked view and Cycles' picture of the scene itself.
MOST_ERROR = 0.03


def expect(condition, sentence):
    if not condition:
        raise AssertionError(sentence)


def path(name):
    return os.path.join(FOLDER, name)


def copy_files():
    """Unpacks the package where Blender looks for it. Returns the name of its module."""
    if bpy.app.version >= (4, 2, 0):
        bpy.ops.extensions.package_install_files(filepath=PACKAGE, repo="user_default", enable_on_install=False)
        return "bl_ext.user_default.halflight"
    bpy.ops.preferences.addon_install(filepath=PACKAGE)
    return "halflight_blender"


def install():
    """Returns the package of the extension."""
    name = copy_files()
    bpy.ops.preferences.addon_enable(module=name)
    extension = importlib.import_module(name)
    if os.environ.get("HALFLIGHT_WHEEL"):
        found = extension.preferences.find_program(bpy.context)
        expect(found is not None and found.where == "from the wheel", f"the wheel's program is found: {found}")
        print("program of the wheel:", extension.program.version(found.path))
    else:
        bpy.context.preferences.addons[name].preferences.program = HALFLIGHT
    return extension


def chosen(checks):
    """All, or those that HALFLIGHT_CHECKS names, while working on them. Prints CPU seconds of each, programs included."""
    wanted = os.environ.get("HALFLIGHT_CHECKS", "").split()
    for check in checks:
        if not wanted or check.__name__ in wanted:
            print(check.__name__, flush=True)
            start = sum(os.times()[:4])
            yield check
            print(f"{check.__name__}: {sum(os.times()[:4]) - start:.1f} CPU s", flush=True)


def run(*checks):
    extension = install()
    for check in chosen(checks):
        check(extension)


# -- scenes ----------------------------------------------------------------------------------------------------------


def empty(sun=True):
    """A floor, a camera, a black world and a sun."""
    bpy.ops.wm.read_homefile(use_empty=True, app_template="")
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("Black")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs[0].default_value = (0, 0, 0, 1)
    scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT
    scene.halflight.quality = "preview"
    box("Floor", (6, 5, 0.1), (0, 0, -0.05), matte("Floor", (0.7, 0.7, 0.7)))
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler, camera.data.lens = (0, -5.5, 3.2), (math.radians(62), 0, 0), 30
    scene.collection.objects.link(camera)
    scene.camera = camera
    if sun:
        lamp("SUN", (0, 0, 4), 3, (40, 20, 0), angle=0.03)
    return scene


def matte(name, color=(0.8, 0.8, 0.8), **members):
    """Principled without gloss. Blender 3.4 draws its diffuse part as Diffuse BSDF does at a roughness of 0.5."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    inputs = material.node_tree.nodes["Principled BSDF"].inputs
    inputs["Base Color"].default_value = (*color, 1)
    inputs["Roughness"].default_value = 0.5
    inputs["Specular" if "Specular" in inputs else "Specular IOR Level"].default_value = 0
    for key, value in members.items():
        inputs[key if key in inputs else key + " Weight"].default_value = value
    return material


def diffuse(name, color=(0.8, 0.8, 0.8)):
    """Diffuse BSDF, which every Blender draws by Lambert's law."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    shader, output = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeOutputMaterial")
    shader.inputs["Color"].default_value = (*color, 1)
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material


def box(name, size, location, material=None, collection=None):
    x, y, z = 0.5, 0.5, 0.5
    corners = [(a, b, c) for a in (-x, x) for b in (-y, y) for c in (-z, z)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(corners, [], faces)
    item = bpy.data.objects.new(name, mesh)
    item.location, item.scale = location, size
    if material:
        mesh.materials.append(material)
    (collection or bpy.context.scene.collection).objects.link(item)
    bpy.context.view_layer.update()
    return item


def lamp(kind, location, energy, degrees=(0, 0, 0), collection=None, **members):
    light = bpy.data.lights.new(kind.title(), kind)
    light.energy = energy
    for key, value in members.items():
        setattr(light, key, value)
    item = bpy.data.objects.new(kind.title(), light)
    item.location, item.rotation_euler = location, [math.radians(angle) for angle in degrees]
    (collection or bpy.context.scene.collection).objects.link(item)
    return item


def add_collection(name):
    collection = bpy.data.collections.new(name)
    bpy.context.scene.collection.children.link(collection)
    return collection


def bake(name="scene"):
    """Saves the file and bakes it. The window shows the view."""
    bpy.ops.wm.save_as_mainfile(filepath=path(name + ".blend"))
    expect(bpy.ops.halflight.bake() == {"FINISHED"}, f"{name} is baked")
    return bpy.context.scene


def messages():
    return [message.text for message in bpy.context.window_manager.halflight_messages]


# -- pictures --------------------------------------------------------------------------------------------------------


def picture(scene, name):
    """Luminance of Cycles' picture, top row first."""
    scene.render.engine, scene.cycles.device = "CYCLES", "CPU"
    scene.cycles.samples, scene.cycles.use_denoising = SAMPLES, False
    scene.cycles.caustics_reflective = scene.cycles.caustics_refractive = False
    return saved_picture(scene, name)


def saved_picture(scene, name):
    """The same of the engine that is set."""
    scene.render.image_settings.file_format, scene.render.filepath = "OPEN_EXR", path(name + ".exr")
    bpy.ops.render.render(write_still=True, scene=scene.name)
    image = bpy.data.images.load(path(name + ".exr"))
    pixels = np.array(image.pixels[:]).reshape(HEIGHT, WIDTH, 4)[::-1, :, :3] @ (0.2126, 0.7152, 0.0722)
    bpy.data.images.remove(image)
    return pixels


def region(scene, name):
    """Pixels whose middle shows an object of the window's scene."""
    return regions(scene).get(name, np.zeros((HEIGHT, WIDTH), bool))


def regions(scene, among=None):
    """The same of each object that is in the picture, by its name. `among`: pixels to look at, or all."""
    depsgraph, camera = bpy.context.evaluated_depsgraph_get(), scene.camera
    top_right, _, bottom_left, top_left = camera.data.view_frame(scene=scene)
    found = {}
    for y, x in np.argwhere(np.ones((HEIGHT, WIDTH), bool) if among is None else among):
        place = top_left.copy()
        place.x += (top_right.x - top_left.x) * (x + 0.5) / WIDTH
        place.y += (bottom_left.y - top_left.y) * (y + 0.5) / HEIGHT
        direction = (camera.matrix_world.to_3x3() @ place).normalized()
        hit = scene.ray_cast(depsgraph, camera.matrix_world.translation, direction)
        if hit[0]:
            found.setdefault(hit[4].name, np.zeros((HEIGHT, WIDTH), bool))[y, x] = True
    return found


def compare(extension, title, *names, least=30, most=MOST_ERROR):
    """Mean radiance of objects in the baked view, against Cycles' picture of the user's own scene."""
    view = bpy.context.scene
    source = extension.baked_view.source_of(view)
    bpy.context.window.scene = source
    found = regions(source)
    truth = picture(source, title.replace(" ", "_") + "_truth")
    bpy.context.window.scene = view
    shown = picture(view, title.replace(" ", "_") + "_view")
    for name in names:
        pixels = found.get(name, np.zeros((HEIGHT, WIDTH), bool))
        expect(pixels.sum() >= least, f"{title}: {name} is in the picture ({pixels.sum()} pixels)")
        error = float(shown[pixels].mean() / truth[pixels].mean() - 1.0)
        print(f"{title}, {name}: {100 * error:+.1f} % of {truth[pixels].mean():.3f}")
        expect(abs(error) <= most, f"{title}: {name} is off by {100 * error:+.1f} %")
