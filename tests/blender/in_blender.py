# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension from installation to uninstallation, run by extension_test.py inside Blender."""

import filecmp
import json
import os
import subprocess
import sys
import time
import types

import bpy
import numpy as np

sys.path.insert(0, os.path.dirname(__file__))
import dump  # noqa: E402
import panels_check  # noqa: E402
import scene as test_scene  # noqa: E402
from stage import FOLDER, HALFLIGHT, expect, install, path  # noqa: E402

SIZE = (112, 63)
MOST_ERROR = 0.03
CAMERA = ("--camera", "Camera", "--specular", "off")


def materials_as_text():
    """What Blender says of all of the user's materials. Not their bytes: these hold run-time counters of pictures too."""
    own = [m for m in bpy.data.materials if "halflight_baked_view" not in m]
    return "\n".join(dump.dump(material) for material in own)


def picture_of(name, scene):
    """Scene-linear pixels of a Cycles picture, top row first."""
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples = 16
    scene.cycles.use_denoising = False
    scene.cycles.pixel_filter_type = "BOX"
    scene.render.filter_size = 1.0
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.render.resolution_percentage = 100
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = path(name)
    bpy.ops.render.render(write_still=True, scene=scene.name)
    return pixels_of(name)


def rendered(name, baked, *options):
    """Pixels of `halflight render`, in watts like Blender's."""
    command = [HALFLIGHT, "render", baked, "-o", path(name), "--size", f"{SIZE[0]}x{SIZE[1]}", "--samples", "16"]
    subprocess.run([*command, "--quiet", "--device", "cpu", *options], check=True)
    return pixels_of(name) / 683.0


def pixels_of(name):
    image = bpy.data.images.load(path(name))
    pixels = np.array(image.pixels[:], np.float32).reshape(SIZE[1], SIZE[0], 4)[::-1, :, :3]
    bpy.data.images.remove(image)
    return pixels


def error_between(a, b):
    """Mean absolute difference over the mean, of channels."""
    return float(np.abs(a - b).mean() / b.mean())


def check_export(document):
    """What the exporter leaves out is in the file, in glTF's units."""
    lights = {light["name"]: light for light in document["extensions"]["KHR_lights_punctual"]["lights"]}
    expect(abs(lights["Sun"]["extras"]["halflight_angular_diameter"] - 2.0) < 1e-4, "the sun's angle")
    expect(abs(lights["Sun"]["intensity"] - 4.0 * 683.0) < 0.1, "the sun's lux")
    expect(abs(lights["Bulb"]["extras"]["halflight_radius"] - 0.08) < 1e-5, "the bulb's radius")
    expect(lights["Bulb"]["extras"]["halflight_shadow_strength"] == 0.6, "a setting of a light")
    expect(lights["Lamp"]["extras"]["halflight_mode"] == "baked", "an enumeration is stored as a word")
    nodes = {node["name"]: node for node in document["nodes"]}
    index = nodes["Panel"]["extensions"]["EXT_lights_area"]["light"]
    panel = document["extensions"]["EXT_lights_area"]["lights"][index]
    divisor = 4.0 if bpy.app.version < (4, 0, 0) else np.pi  # tests/blender/pictures_in_blender.py compares with Cycles
    expect(abs(panel["intensity"] - 683.0 * 20.0 / (divisor * 1.5 * 0.5)) < 1.0, "its radiance is power over area")
    expect(panel["type"] == "rect" and abs(panel["size"] - 0.5) < 1e-6, "the area light's height")
    expect(abs(panel["rect"]["aspect"] - 3.0) < 1e-5 and not panel["extras"], "its width; mixed, as any light")
    expect(nodes["Ball"]["extras"]["halflight_static"] == 0, "a setting of an object")
    expect(nodes["Pillar"]["extras"] == {"halflight_lightmap_scale": 2.0}, "defaults are not stored")
    expect([n["name"] for n in document["nodes"]].count("Stone") == 2, "the collection's instances are there")
    extras = document["scenes"][0]["extras"]
    expect(extras["halflight_sky_image"].endswith("sky.hdr"), "the world's picture is the sky")
    expect(abs(extras["halflight_sky_rotation"] + 40.0) < 1e-3, "turned the other way round than by Mapping")
    expect(abs(extras["halflight_sky_intensity"] - 683.0 * 0.5) < 1e-3, "times the world's strength")
    expect("halflight" not in extras, "settings of the bake stay in the .blend")


def check_view(extension, scene, files):
    """Pixels of the baked view against the program's own renderer."""
    view = bpy.context.scene
    expect(view != scene and extension.baked_view.is_view(view), "the bake shows itself")
    check_panels(extension)
    names = [light.name for light in view.halflight_lights]
    expect(sorted(names) == ["Bulb", "Panel", "Sun"], f"lights of the view: {names}")
    shown = picture_of("view.exr", view)
    truth = rendered("render.exr", files.baked, *CAMERA)
    ball = np.abs(truth - rendered("noball.exr", path("noball.glb"), *CAMERA)).sum(2)
    static = ball < 1e-6
    error = error_between(shown[static], truth[static])
    print(f"baked view against halflight render: {100 * error:.2f} % ({static.mean():.2f} of the pixels)")
    expect(static.mean() > 0.5, "most of the picture is static")
    expect(error <= MOST_ERROR, f"the baked view is off by {100 * error:.2f} %")

    # What one light adds, its mask included, is the picture with it less the picture without it.
    for name in names:
        for light in view.halflight_lights:
            light.on = light.name != name
        view_adds = (shown - picture_of("view_without.exr", view))[static]
        truth_adds = (truth - rendered("render_without.exr", files.baked, *CAMERA, "--light", f"{name}:intensity=0"))[static]
        error = error_between(view_adds, truth_adds)
        print(f"direct light of {name}: {100 * error:.2f} %")
        expect(error <= MOST_ERROR / 2, f"the light {name} is off by {100 * error:.2f} %")


def main():
    start = time.monotonic()
    extension = install()
    scene = test_scene.build(FOLDER)
    bpy.ops.wm.save_as_mainfile(filepath=path("test.blend"))
    before = materials_as_text()
    scene_before = sorted(item.name for item in scene.objects)
    scene.halflight.quality = "preview"
    scene.halflight.texels_per_meter = 12
    scene.halflight.output = "//saved.glb"

    expect(bpy.ops.halflight.bake() == {"FINISHED"}, "the bake ends well")
    print(f"bake: {time.monotonic() - start:.1f} s")
    files = extension.files.of(scene)
    check_settings(extension, scene.halflight, files)
    expect(files.folder.startswith(path("test.halflight")), "files are beside the .blend")
    expect(filecmp.cmp(files.baked, path("saved.glb"), shallow=False), "the baked file is saved where asked")
    with open(files.scene, "rb") as file:
        data = file.read()
    check_export(json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")]))
    make_without_ball(extension, files)
    check_view(extension, scene, files)
    check_leaving(extension, scene, before, scene_before)
    check_panels(extension)
    check_undo(extension, scene)
    check_rebake(extension, scene)
    check_selected(extension)
    check_errors(extension, scene)
    check_cancel(extension)
    check_panorama(extension)
    print(f"whole: {time.monotonic() - start:.1f} s")


def check_settings(extension, settings, files):
    """Switches of the panel are in the program's command line, at their defaults too."""
    shown = panels_check.Layout()
    extension.panels.draw_details(shown, settings)
    for name, default in (("glossy_bounces", True), ("directional", False), ("denoise", True)):
        option = "--" + name.replace("_", "-")
        expect(name in shown.shown, f"{name} is in the panel")
        expect(getattr(settings, name) == default, f"{name} is {default} at first")
        for value in (not default, default):
            setattr(settings, name, value)
            arguments = extension.program.bake_arguments(settings, files)
            expect(arguments[arguments.index(option) + 1] == ("on" if value else "off"), f"{option} follows")


def check_panels(extension):
    """The settings' panels, with and without a view. Light and object are of each kind."""
    objects, world = bpy.data.objects, bpy.context.scene.world
    for name in ("Bulb", "Panel", "Pillar", "Ball"):
        item = objects[name]
        light = item.data if item.type == "LIGHT" else None
        slots = item.material_slots
        members = {"object": item, "light": light, "world": world, "material": slots[0].material if slots else None}
        count = panels_check.draw_all(extension.panels, **members)
        expect(count > 30, f"panels of {name} show {count} things")
    layout = panels_check.Layout()
    panel = types.SimpleNamespace(layout=layout)
    extension.panels.HALFLIGHT_PT_light.draw(panel, types.SimpleNamespace(light=objects["Panel"].data))
    expect({"halflight_mode", "halflight_cast_shadows", "size", "size_y"} <= set(layout.shown), "an area light's panel")


def check_cancel(extension):
    """A cancelled bake leaves the last file alone."""
    del bpy.data.objects["Pillar"]["halflight_lightmap_scale"]
    bpy.context.scene.halflight.texels_per_meter = 100
    files = extension.files.of(bpy.context.scene)
    with open(files.baked, "rb") as file:
        last = file.read()
    job = extension.bake.Job(bpy.context)
    job.export(bpy.context)
    job.start(bpy.context)
    expect(not bpy.ops.halflight.bake.poll(), "one bake at a time")
    while job.progress.share == 0.0 and job.poll(bpy.context) is None:
        time.sleep(0.02)
    expect(bpy.ops.halflight.cancel() == {"FINISHED"}, "the cancel button")
    job.process.wait(20)
    try:
        job.finish(bpy.context, job.poll(bpy.context))
    except extension.bake.BakeError as error:
        expect("cancelled" in str(error), str(error))
    else:
        raise AssertionError("a cancelled bake is no finished one")
    with open(files.baked, "rb") as file:
        expect(file.read() == last, "the last file is as it was")


def check_panorama(extension):
    """A world that is no plain picture is rendered, and has the picture's directions."""
    world = bpy.context.scene.world
    tree = world.node_tree
    for link in list(tree.links):
        if link.to_node.bl_idname in {"ShaderNodeMapping", "ShaderNodeTexEnvironment"}:
            tree.links.remove(link)
    environment = next(n for n in tree.nodes if n.bl_idname == "ShaderNodeTexEnvironment")
    gamma = tree.nodes.new("ShaderNodeGamma")
    tree.links.new(environment.outputs["Color"], gamma.inputs["Color"])
    tree.links.new(gamma.outputs["Color"], tree.nodes["Background"].inputs["Color"])
    expect(extension.export.sky.read_world(world).panorama, "a shader between picture and background")
    world.halflight_sky_width = 64
    extras = {}
    expect(not extension.export.sky.add_sky(bpy.context, extras, 683.0, FOLDER), "no warning")
    expect(extras["halflight_sky_intensity"] == 683.0, "the strength is in the panorama")
    panorama = bpy.data.images.load(extras["halflight_sky_image"])
    a, b = (np.array(i.pixels[:]).reshape(32, 64, 4)[:, :, :3] for i in (panorama, environment.image))
    error = error_between(2.0 * a, b)
    print(f"panorama against its picture: {100 * error:.2f} %")
    expect(error < 0.02, "the panorama looks where the picture does")


def make_without_ball(extension, files):
    """The baked file without its dynamic object, to know the pixels that it touches."""
    document = extension.glb.Glb(files.baked)
    for node in document.json["nodes"]:
        if node.get("name") == "Ball":
            node.pop("mesh")
    document.write(path("noball.glb"))


def check_leaving(extension, scene, before, scene_before):
    expect(bpy.ops.halflight.baked_view() == {"FINISHED"}, "the view is left")
    expect(bpy.context.scene == scene, "the window shows the user's scene")
    after = materials_as_text()
    lines = list(zip(before.splitlines(), after.splitlines()))
    expect(len(lines) > 1000 and before == after, f"materials: {[(a, b) for a, b in lines if a != b][:5]}")
    expect(sorted(item.name for item in scene.objects) == scene_before, "the scene has the objects it had")
    everything = [item.name for name in extension.baked_view.COLLECTIONS for item in getattr(bpy.data, name)]
    left = [name for name in everything if name.startswith("Baked ")]
    expect(not left and len(bpy.data.scenes) == 1, f"nothing of the view is left: {left}")


def check_undo(extension, scene):
    """Undo of switching on is the scene as it was."""
    name = scene.name
    bpy.ops.ed.undo_push(message="before")
    expect(bpy.ops.halflight.baked_view() == {"FINISHED"}, "the view is shown again")
    bpy.ops.ed.undo_push(message="view")
    expect(extension.baked_view.is_view(bpy.context.scene), "on")
    bpy.ops.ed.undo()
    expect(bpy.context.scene.name == name and not extension.baked_view.is_view(bpy.context.scene), "undone")
    expect(not any(m.name.startswith("Baked ") for m in bpy.data.materials), "undo takes the view's materials away")


def check_rebake(extension, _scene):
    """The stale mark, and a second bake that computes only what changed."""
    context, scene = bpy.context, bpy.context.scene
    expect(not extension.stale.check(context), "just baked")
    stone = scene.objects["Pillar"]
    stone.location.x += 0.4
    context.view_layer.update()
    expect(extension.stale.check(context), "a moved object makes the bake stale")
    stone.location.x -= 0.4
    context.view_layer.update()
    expect(not extension.stale.check(context), "moved back, it is not")
    shader = bpy.data.materials["Stone"].node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (0.6, 0.4, 0.3, 1)
    expect(extension.stale.check(context), "a material changed")
    scene.halflight.show_view = False
    files = extension.files.of(scene)
    expect(bpy.ops.halflight.bake() == {"FINISHED"}, "the second bake ends well")
    with open(files.report, encoding="utf-8") as file:
        cache = json.load(file)["cache"]
    print("second bake:", cache, scene.halflight.summary)
    expect(0 < cache["same"] + cache["unchanged"] < cache["tiles"], f"some tiles are reused: {cache}")
    expect(not extension.baked_view.is_view(context.scene), "no view unless asked for")
    expect(not extension.stale.check(context), "baked anew")


def lightmap_of(extension, files):
    """By object of the last bake, by its place in the node tree: its name and the texel at each triangle's middle."""
    with open(os.path.join(files.sidecar, "bake.json"), encoding="utf-8") as file:
        bake = json.load(file)
    pages = []
    for name in bake["lightmaps"]["pages"]:
        image = bpy.data.images.load(os.path.join(files.sidecar, name))
        width, height = image.size
        pages.append(np.array(image.pixels[:], np.float32).reshape(height, width, 4)[::-1, :, :3])
        bpy.data.images.remove(image)
    document = extension.glb.Glb(files.baked)
    nodes = document.json["nodes"]
    texels = {}
    for item in bake["objects"]:
        lightmap = item.get("lightmap", {})
        if "page" not in lightmap:
            continue
        place = iter(item["path"])
        node = nodes[document.json["scenes"][0]["nodes"][next(place)]]
        for child in place:
            node = nodes[node["children"][child]]
        expect(node["name"] == item["node"], f"{node['name']} is at {item['path']}")
        page = pages[lightmap["page"]]
        found = []
        for primitive in document.json["meshes"][node["mesh"]]["primitives"]:
            uv = document.accessor(primitive["attributes"]["TEXCOORD_1"]) * lightmap["scale"] + lightmap["offset"]
            middles = uv[document.accessor(primitive["indices"]).reshape(-1, 3)].mean(1)
            x, y = (middles * page.shape[0]).astype(int).T
            found.append(page[y, x])
        texels[tuple(item["path"])] = (item["node"], np.concatenate(found))
    return texels


def check_selected(extension):
    """Bake Selected changes the texels of what is selected and no others."""
    context, scene = bpy.context, bpy.context.scene
    files = extension.files.of(scene)
    for item in context.selected_objects:
        item.select_set(False)
    message = ""
    try:
        bpy.ops.halflight.bake_selected()
    except RuntimeError as error:
        message = str(error)
    expect("No object with a surface is selected" in message, f"nothing is selected: {message}")
    expect(not extension.stale.check(context), "a refusal changes nothing")
    before = lightmap_of(extension, files)
    scene.objects["Sun"].data.energy *= 3.0
    scene.objects["Pillar"].select_set(True)
    scene.objects["Stones 0"].select_set(True)  # an instance of a collection
    scene.objects["Sun"].select_set(True)  # has no texels
    expect(bpy.ops.halflight.bake_selected() == {"FINISHED"}, "the selected objects are baked")
    expect(extension.stale.check(context), "the whole scene is still not what was baked")
    after = lightmap_of(extension, files)
    expect(before.keys() == after.keys(), "the layout is the same")
    shares = {}
    for place, (name, old) in before.items():
        changed = np.abs(after[place][1] - old).max(1) > 0.01 * old.max(1)
        shares.setdefault(name, []).append(float(changed.mean()))
    print("share of texels changed by Bake Selected:", shares)
    chosen = [*shares.pop("Pillar"), shares["Stone"].pop(0)]
    expect(min(chosen) > 0.5, "the selected objects have new light")
    kept = [share for each in shares.values() for share in each]
    expect(len(kept) > 4 and max(kept) == 0.0, f"the others have kept theirs: {shares}")
    scene.objects["Sun"].data.energy /= 3.0


def check_errors(extension, scene):
    """What the program says is in the list, with its object, and a click selects it."""
    context, scene = bpy.context, bpy.context.scene
    wm = context.window_manager
    bpy.data.objects["Pillar"]["halflight_lightmap_scale"] = "much"
    try:
        result = bpy.ops.halflight.bake()
    except RuntimeError as error:  # what a script gets of an operator that reports an error
        result = str(error)
    expect("FINISHED" not in result, "a wrong setting fails")
    errors = [m for m in wm.halflight_messages if m.severity == "ERROR"]
    print("message:", errors[0].text, "->", errors[0].item)
    expect(len(errors) == 1 and errors[0].item == "Pillar", "the error names its object")
    wm.halflight_message = list(wm.halflight_messages).index(errors[0])
    expect(context.selected_objects == [scene.objects["Pillar"]], "a click selects it")


main()
