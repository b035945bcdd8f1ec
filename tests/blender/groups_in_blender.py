# SPDX-License-Identifier: GPL-3.0-or-later
"""Light groups: their names in the file, sliders against `halflight render --group`, lamps that follow, keyframes, undo, files."""

import json
import os
import subprocess
import sys

import bpy
import numpy as np

sys.path.insert(0, os.path.dirname(__file__))
import panels_check  # noqa: E402
import stage  # noqa: E402
from stage import HALFLIGHT, HEIGHT, WIDTH, box, expect, lamp, matte, path  # noqa: E402

MOST_ERROR = 0.03  # of the mean, between the view and the program's own picture


def build():
    """A corner with two lamps in a collection that names their group, a spot, a sign and a ball."""
    scene = stage.empty(sun=False)
    box("Wall", (6, 0.1, 3), (0, 2.45, 1.5), matte("Wall", (0.8, 0.75, 0.7)))
    box("Side", (0.1, 5, 3), (-2.95, 0, 1.5), matte("Side", (0.7, 0.3, 0.2)))
    box("Block", (0.8, 0.8, 1.1), (0.9, 0.6, 0.55), matte("Block"))
    ball = box("Ball", (0.5, 0.5, 0.5), (-0.6, -0.8, 0.6), matte("Ball"))
    ball.halflight_static = "DYNAMIC"
    lamps = stage.add_collection("Lamps")
    lamps.halflight_group = "lamps"
    for place, energy in (((-1.5, 0.5, 1.9), 60), ((2.2, 1.2, 1.6), 30)):
        lamp("POINT", place, energy, collection=lamps, color=(1.0, 0.5, 0.2), shadow_soft_size=0.05).data.halflight_mode = "BAKED"
    spot = lamp("SPOT", (0.5, -1.5, 2.6), 200, (25, 0, 0), color=(0.3, 0.5, 1.0), spot_size=1.2)
    spot.data.halflight_group = "spot"
    sign = box("Sign", (1.2, 0.05, 0.4), (-0.8, 2.35, 1.4), matte("Glow", (0.1, 0.1, 0.1)))
    inputs = sign.active_material.node_tree.nodes["Principled BSDF"].inputs
    inputs["Emission Color" if "Emission Color" in inputs else "Emission"].default_value = (0.2, 1.0, 0.4, 1.0)
    inputs["Emission Strength"].default_value = 2.0
    sign.active_material.halflight_group = "sign"
    scene.world.node_tree.nodes["Background"].inputs[0].default_value = (0.05, 0.08, 0.12, 1)
    scene.halflight_sky_changes = True
    scene.halflight.texels_per_meter = 16
    scene.halflight.probe_spacing = 0.5
    return scene


def weights_of(scene):
    return {entry.name: tuple(entry.weight_in_file()) for entry in scene.halflight.light_groups}


def group(scene, name):
    return scene.halflight.light_groups[name]


def close(a, b, most=1e-4):
    return np.allclose(a, b, rtol=most, atol=most)


def color_picture(scene, name):
    """Pixels of Cycles' picture, top row first."""
    stage.picture(scene, name)
    return pixels_of(name)


def pixels_of(name):
    image = bpy.data.images.load(path(name + ".exr"))
    pixels = np.array(image.pixels[:]).reshape(HEIGHT, WIDTH, 4)[::-1, :, :3]
    bpy.data.images.remove(image)
    return pixels


def rendered(extension, scene, name):
    """The program's own picture at the sliders' weights, in watts like Blender's."""
    command = [HALFLIGHT, "render", extension.files.of(scene).baked, "-o", path(name + ".exr"), "--camera", "Camera"]
    command += ["--specular", "off", "--size", f"{WIDTH}x{HEIGHT}", "--samples", "16", "--quiet", "--device", "cpu"]
    for key, weight in weights_of(scene).items():
        command += ["--group", key + "=" + ",".join(f"{w:.9g}" for w in weight)]
    subprocess.run(command, check=True)
    return pixels_of(name) / 683.0


def compare(extension, scene, name):
    """The view at the sliders' weights against the program."""
    shown, truth = color_picture(bpy.context.scene, name + "_view"), rendered(extension, scene, name + "_program")
    error = float(np.abs(shown - truth).mean() / truth.mean())
    print(f"{name}: {100 * error:.2f} % of {truth.mean():.3f}")
    expect(error <= MOST_ERROR, f"{name}: the view is off by {100 * error:.2f} %")
    return shown


def json_of(file):
    with open(file, "rb") as opened:
        data = opened.read()
    return json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])


def check_export(extension):
    """What names a group is in the file, on lights, nodes, materials and the scene; a collection's objects name its group."""
    scene = build()
    stage.add_collection("Inner")
    inner = bpy.data.collections["Inner"]
    scene.collection.children.unlink(inner)
    bpy.data.collections["Lamps"].children.link(inner)
    lamp("POINT", (0, 0, 2), 5, collection=inner).name = "Deep"
    lamp("POINT", (0, 1, 2), 5, collection=inner).name = "Own"
    bpy.data.objects["Own"].halflight_group = "own"
    scene.halflight_sky_changes, scene.halflight_sky_group = False, "day"
    os.makedirs(path("export"), exist_ok=True)
    extension.export.export_scene.export_scene(bpy.context, path("groups.glb"), "SPEC", path("export"))
    document = json_of(path("groups.glb"))
    nodes = {node["name"]: node.get("extras", {}).get("halflight_group") for node in document["nodes"]}
    wanted = {"Point": "lamps", "Point.001": "lamps", "Deep": "lamps", "Own": "own", "Spot": None, "Block": None}
    expect({name: nodes[name] for name in wanted} == wanted, f"groups of nodes: {nodes}")
    lights = {light["name"]: light["extras"].get("halflight_group") for light in document["extensions"]["KHR_lights_punctual"]["lights"]}
    expect(lights["Spot"] == "spot" and lights["Point"] is None, f"groups of lights: {lights}")
    materials = {material["name"]: material.get("extras", {}).get("halflight_group") for material in document["materials"]}
    expect(materials["Glow"] == "sign" and materials["Wall"] is None, f"groups of materials: {materials}")
    extras = document["scenes"][0]["extras"]
    expect(extras["halflight_sky_group"] == "day" and "halflight_sky_changes" not in extras, f"the sky's group: {extras}")
    expect("halflight" not in extras, "sliders stay in the .blend")
    expect(all("halflight_group" not in item for item in bpy.data.objects if item.name != "Own"), "nothing of the user's is changed")


def check_sums(extension):
    """The view adds the groups up as the program does, at the bake's weights and at others; sky and ball follow."""
    scene = build()
    stage.bake("groups")
    names = [entry.name for entry in scene.halflight.light_groups]
    expect(sorted(names) == ["lamps", "sign", "sky.ground", "sky.horizon", "sky.zenith", "spot"], f"groups: {names}")
    expect(panels_check.draw_all(extension.panels, object=None, world=scene.world, material=None) > 20, "panels with sliders")
    layout = panels_check.Layout()
    extension.panels.draw_groups(layout, bpy.context)
    expect(layout.shown == ["brightness", "color"] * len(names), f"a slider and a colour each: {layout.shown}")
    expect(close(group(scene, "lamps").weight(), (1.0, 0.5, 0.2)), "a lamp's colour is the weight")
    expect(close(group(scene, "sky.zenith").weight(), (0.05, 0.08, 0.12)), "the sky's is its radiance")
    saved = compare(extension, scene, "saved")
    group(scene, "lamps").brightness, group(scene, "lamps").color = 1.5, (0.2, 0.6, 1.0)
    group(scene, "spot").brightness = 0.3
    group(scene, "sign").color = (1.0, 0.1, 0.1)
    group(scene, "sky.horizon").brightness, group(scene, "sky.horizon").color = 0.4, (1.0, 0.5, 0.2)
    bpy.context.view_layer.update()
    changed = compare(extension, scene, "changed")
    expect(np.abs(changed - saved).mean() > 0.1 * saved.mean(), "the picture has changed")
    for name in ("lamps", "spot", "sky.zenith", "sky.horizon", "sky.ground"):
        group(scene, name).brightness = 0.0
    bpy.context.view_layer.update()
    compare(extension, scene, "sign_alone")


def lamp_light(name):
    data = bpy.data.objects[name].data
    return [data.energy * c for c in data.color]


def glow():
    inputs = bpy.data.materials["Glow"].node_tree.nodes["Principled BSDF"].inputs
    color = inputs["Emission Color" if "Emission Color" in inputs else "Emission"].default_value
    return [inputs["Emission Strength"].default_value * c for c in color[:3]]


def check_one_state(extension):
    """Sliders set lamps and emission; lamps that are changed alike set the slider; a bake of either is no other light."""
    context, scene = bpy.context, build()
    scene.halflight.show_view = False
    stage.bake("state")
    expect(not extension.stale.check(context), "just baked")
    group(scene, "lamps").brightness = 0.25
    group(scene, "sign").color = (1.0, 0.5, 0.4)
    context.view_layer.update()
    expect(close(lamp_light("Point"), (15.0, 7.5, 3.0)) and close(lamp_light("Point.001"), (7.5, 3.75, 1.5)), "lamps follow")
    expect(close(glow(), (2.0, 1.0, 0.8)), f"emission follows: {glow()}")
    expect(not extension.stale.check(context), "a weight is no change for the bake")
    for name in ("Point", "Point.001"):
        bpy.data.objects[name].data.energy *= 2.0
    context.view_layer.update()
    expect(close(group(scene, "lamps").weight(), (0.5, 0.25, 0.1)), "lamps changed alike set the slider")
    expect(not extension.stale.check(context), "and are no change for the bake")
    group(scene, "spot").brightness = 0.0
    context.view_layer.update()
    expect(0.0 < bpy.data.objects["Spot"].data.energy < 0.01, "a lamp that is off keeps its colour")
    before = weights_of(scene)
    expect(bpy.ops.halflight.bake() == {"FINISHED"}, "it is baked at these weights")
    expect(close(group(scene, "lamps").weight(), (0.5, 0.25, 0.1)), "the slider stays where it is")
    expect(close(weights_of(scene)["lamps"], before["lamps"]), "and means the same in the file")
    group(scene, "spot").brightness = 1.0
    context.view_layer.update()
    expect(close(lamp_light("Spot"), (60.0, 100.0, 200.0)), f"the lamp comes back in its colour: {lamp_light('Spot')}")
    bpy.ops.halflight.baked_view()
    compare(extension, scene, "back")
    bpy.ops.halflight.baked_view()
    bpy.data.objects["Point"].data.energy *= 3.0
    context.view_layer.update()
    expect(close(group(scene, "lamps").weight(), (0.5, 0.25, 0.1)), "one lamp of two is not the group")
    expect(extension.stale.check(context), "and changes the bake")
    group(scene, "lamps").brightness = 1.0
    context.view_layer.update()
    expect(close(lamp_light("Point"), (180.0, 90.0, 36.0)), "the slider knows the lamp's new light")


def check_world(extension):
    """A sky in a group of its own: the world follows the slider, and the drawn sky of the view too."""
    scene = build()
    scene.halflight_sky_changes, scene.halflight_sky_group = False, "day"
    stage.bake("world")
    group(scene, "day").brightness *= 2.0
    group(scene, "day").color = (1.0, 0.4, 0.4)
    background = scene.world.node_tree.nodes["Background"].inputs
    light = [background["Strength"].default_value * c for c in background["Color"].default_value[:3]]
    day = group(scene, "day")
    expect(close(light, np.array(day.weight()) * day.members[0].white), f"the world follows: {light}")
    for name in ("lamps", "spot", "sign"):
        group(scene, name).brightness = 0.0
    bpy.context.view_layer.update()
    compare(extension, scene, "world")


def check_not_twice(extension):
    """A lamp with keyframes of its own is moved by nothing else."""
    scene = build()
    spot = bpy.data.objects["Spot"].data
    spot.keyframe_insert("energy", frame=1)
    stage.bake("not_twice")
    group(scene, "spot").brightness = 0.1
    expect(close(lamp_light("Spot"), (60.0, 100.0, 200.0)), "the lamp is its own animation's")
    compare(extension, scene, "view_alone")


def check_keyframes(extension):
    """Frames and renders of an animation follow, in the view and in the scene; the baked file has the animation."""
    scene = build()
    stage.bake("keys")
    lamps = group(scene, "lamps")
    for frame, brightness in ((1, 1.0), (11, 0.0), (21, 0.5)):
        lamps.brightness = brightness
        lamps.keyframe_insert("brightness", frame=frame)
    for curve in scene.animation_data.action.fcurves:
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    view = bpy.context.scene
    view.render.engine, view.cycles.samples, view.cycles.use_denoising = "CYCLES", 4, False
    view.frame_start, view.frame_end, view.frame_step = 1, 11, 5
    view.render.image_settings.file_format, view.render.filepath = "OPEN_EXR", path("frame_")
    bpy.ops.render.render(animation=True, scene=view.name)
    frames = [pixels_of(f"frame_{number:04d}") for number in (1, 6, 11)]
    full, half, none = (frame.mean() for frame in frames)
    print(f"frames of the animation: {full:.4f}, {half:.4f}, {none:.4f}")
    expect(none < 0.8 * full and abs(half - (full + none) / 2) < 0.01 * full, "the pictures follow the keyframes")
    view.frame_set(16)
    expect(close(group(scene, "lamps").brightness, 0.25), "the slider follows in the view")
    compare(extension, scene, "frame_16")
    bpy.ops.halflight.baked_view()
    scene.frame_set(6)
    expect(close(lamp_light("Point"), (30.0, 15.0, 6.0)), f"lamps follow in the scene: {lamp_light('Point')}")
    scene.frame_start, scene.frame_end = 1, 21
    expect(bpy.ops.halflight.bake() == {"FINISHED"}, "it is baked at a frame")
    document = extension.glb.Glb(extension.files.of(scene).baked)
    found = [each for each in document.json["animations"] if each["name"] == "Light groups"]
    expect(len(found) == 1 and "KHR_animation_pointer" in document.json["extensionsUsed"], "the file has the animation")
    (channel,), (sampler,) = found[0]["channels"], found[0]["samplers"]
    number = [each["name"] for each in document.json["extensions"]["HALFLIGHT_mixed_lighting"]["groups"]].index("lamps")
    pointer = channel["target"]["extensions"]["KHR_animation_pointer"]["pointer"]
    expect(pointer == f"/extensions/HALFLIGHT_mixed_lighting/groups/{number}/weight", pointer)
    seconds, weights = document.accessor(sampler["input"])[:, 0], document.accessor(sampler["output"])
    expect(close(seconds, np.array([1, 11, 21]) / 24), f"a key where the line bends: {seconds}")
    unit = np.array(group(scene, "lamps").unit) * group(scene, "lamps").color
    expect(close(weights, np.outer([1.0, 0.0, 0.5], unit)), f"weights: {weights}")
    subprocess.run([HALFLIGHT, "info", extension.files.of(scene).baked], check=True, stdout=subprocess.DEVNULL)
    expect(bpy.ops.halflight.baked_view() in ({"FINISHED"}, {"CANCELLED"}), "the view is left")
    reopen("keys", frame=16)
    expect(close(bpy.context.scene.halflight.light_groups["lamps"].brightness, 0.25), "keyframes are in the .blend")


def reopen(name, frame=None):
    bpy.ops.wm.save_as_mainfile(filepath=path(name + ".blend"))
    bpy.ops.wm.open_mainfile(filepath=path(name + ".blend"))
    if frame is not None:
        bpy.context.scene.frame_set(frame)


def check_files(extension):
    """Undo takes slider and lamp back together; a saved file has both, and its view shows them."""
    scene = build()
    scene.halflight.show_view = False
    stage.bake("files")
    bpy.ops.ed.undo_push(message="before")
    group(scene, "lamps").brightness = 0.5
    bpy.context.view_layer.update()
    bpy.ops.ed.undo_push(message="slider")
    bpy.ops.ed.undo()
    scene = bpy.context.scene
    expect(close(group(scene, "lamps").brightness, 1.0) and close(lamp_light("Point"), (60, 30, 12)), "undo takes both back")
    group(scene, "lamps").brightness = 0.5
    bpy.ops.halflight.baked_view()
    reopen("files")
    scene = bpy.context.scene
    expect(close(group(scene, "lamps").brightness, 0.5) and close(lamp_light("Point"), (30, 15, 6)), "the file has both")
    bpy.ops.halflight.baked_view()
    compare(extension, scene, "reopened")
    bpy.ops.halflight.baked_view()
    group(scene, "lamps").brightness = 1.0
    expect(close(lamp_light("Point"), (60, 30, 12)), "sliders of the file move its lamps")
    bpy.data.objects.remove(bpy.data.objects["Spot"])
    reopen("files")
    expect("Spot" not in bpy.data.lights, "no group keeps a deleted lamp")
    name = extension.__name__
    bpy.ops.preferences.addon_disable(module=name)
    expect(bpy.data.lights["Point"].users == 1, "nor does the file without the extension")


stage.run(check_export, check_sums, check_one_state, check_world, check_not_twice, check_keyframes, check_files)
