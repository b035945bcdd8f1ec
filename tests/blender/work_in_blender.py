# SPDX-License-Identifier: GPL-3.0-or-later
"""Nobody loses work: what is in the user's file stays, whatever is done around a bake."""

import contextlib
import os
import sys
import time

import bpy

sys.path.insert(0, os.path.dirname(__file__))
import dump  # noqa: E402
import scene as test_scene  # noqa: E402
import stage  # noqa: E402
from stage import bake, box, expect, matte  # noqa: E402

CUBE = (0.8, 0.8, 0.8)
NOBODY = 65534


def is_view(extension):
    return extension.baked_view.is_view(bpy.context.scene)


def toggle():
    expect(bpy.ops.halflight.baked_view() == {"FINISHED"}, "the view is switched")


def left_of_views(extension):
    kinds = extension.baked_view.COLLECTIONS
    return [item.name for kind in kinds for item in getattr(bpy.data, kind) if extension.baked_view.TAG in item]


def refusal():
    """The sentence with which a bake fails."""
    try:
        bpy.ops.halflight.bake()
    except RuntimeError as error:
        return str(error)
    raise AssertionError("a bake that cannot be is refused")


def check_views(extension):
    """Two scenes have a view each; a linked copy of a view goes with it."""
    first = stage.empty()
    bake("views")
    bpy.ops.scene.new(type="LINK_COPY")
    toggle()
    expect(bpy.context.scene == first and not left_of_views(extension), f"left: {left_of_views(extension)}")
    second = bpy.data.scenes.new("Second")
    bpy.context.window.scene = second
    second.halflight.quality = "preview"
    box("Other floor", (3, 3, 0.1), (0, 0, 0), matte("Other"))
    expect(bpy.ops.halflight.bake() == {"FINISHED"}, "the second scene is baked")
    kept = sorted(item.name for item in bpy.context.scene.objects)
    bpy.context.window.scene = first
    toggle()
    toggle()
    view = extension.baked_view.views_of(second)[0]
    expect(sorted(item.name for item in view.objects) == kept, "leaving one view leaves the other's objects")
    expect(any(m.name.startswith("Baked Other") for m in bpy.data.materials), "and its materials")
    bpy.context.window.scene = view
    toggle()
    expect(bpy.context.scene == second and not left_of_views(extension), f"left: {left_of_views(extension)}")


def check_saving(extension):
    """What the user adds in the view is saved, and the view is not."""
    scene = stage.empty()
    bake("saving")
    bpy.ops.halflight.baked_view()
    bpy.ops.wm.save_mainfile()
    without = os.path.getsize(bpy.data.filepath)
    toggle()
    light = bpy.context.scene.halflight_lights[0].name
    bpy.context.scene.halflight_lights[0].on = False
    box("My work", (0.5, 0.5, 0.5), (0, 0, 1))
    folder = bpy.data.collections.new("My folder")
    bpy.context.scene.collection.children.link(folder)
    box("In my folder", (0.5, 0.5, 0.5), (1, 0, 1), collection=folder)
    bpy.ops.wm.save_mainfile()
    expect(is_view(extension), "the view is shown after saving")
    expect([item.on for item in bpy.context.scene.halflight_lights if item.name == light] == [False], "as it was")
    expect("My work" in scene.objects, "what was added is in the user's scene")
    size = os.path.getsize(bpy.data.filepath)
    expect(size < without + 100_000, f"the view is not in the file: {without} and {size} bytes")
    for _ in range(2):
        bpy.ops.wm.open_mainfile(filepath=bpy.data.filepath)
        scene = bpy.context.scene
        expect(len(bpy.data.scenes) == 1 and not left_of_views(extension), "the file has no view")
        expect({"My work", "In my folder"} <= set(scene.objects.keys()), f"objects: {scene.objects.keys()}")
        expect("My folder" in scene.collection.children, "and their collection")
        bpy.ops.wm.save_mainfile()
    toggle()
    floor = scene.objects["Floor"]
    expect(floor.users == 2, f"a collection and the memory of the bake use it: {floor.users}")
    scene.collection.objects.unlink(floor)
    bpy.ops.wm.save_mainfile()
    toggle()
    expect(floor.users == 0, f"nothing keeps a deleted object: {floor.users}")
    expect(len(bpy.data.scenes) == 1 and not left_of_views(extension), "the view can be left after a save")


def check_state(extension):
    """Frame, selection, mode and modifiers after a bake, a failed one and a cancelled one."""
    scene = stage.empty()
    scene.halflight.show_view = False
    cube = box("Mover", CUBE, (1, 0, 0.5), matte("Mover"))
    cube.keyframe_insert("location", frame=1)
    cube.location.x = -1
    cube.keyframe_insert("location", frame=40)
    scene.frame_set(5)
    bpy.context.view_layer.objects.active = cube
    cube.select_set(True)
    bpy.ops.object.mode_set(mode="EDIT")

    def state():
        selected = sorted(item.name for item in bpy.context.selected_objects)
        names = sorted(item.name for kind in ("scenes", "objects", "collections", "meshes") for item in getattr(bpy.data, kind))
        camera = scene.camera and scene.camera.name
        return scene.frame_current, selected, bpy.context.object.name, bpy.context.object.mode, names, camera, scene.name

    before = state()
    bake("state")
    expect(state() == before, f"after a bake: {state()}, before: {before}")
    expect(not extension.stale.check(bpy.context), "nothing was edited")
    cube["halflight_lightmap_scale"] = "much"
    refusal()
    expect(state() == before, f"after a failed bake: {state()}")
    del cube["halflight_lightmap_scale"]
    scene.halflight.texels_per_meter = 200
    cancelled_bake(extension)
    expect(state() == before, f"after a cancelled bake: {state()}")
    bpy.ops.object.mode_set(mode="OBJECT")


def check_files(extension):
    """The bake stays when scene or file get other names; where it cannot be, a sentence says what to do."""
    scene = stage.empty()
    expect(bpy.ops.halflight.bake() == {"FINISHED"}, "a file that was never saved is baked")
    toggle()
    bpy.ops.wm.save_as_mainfile(filepath=stage.path("-odd näme #1 ?.blend"))
    toggle()
    expect(is_view(extension), "the bake follows the first save")
    toggle()
    scene.name = "Another name"
    toggle()
    toggle()
    bpy.ops.wm.save_as_mainfile(filepath=stage.path("copy.blend"))
    toggle()
    expect(is_view(extension), "the bake follows Save As, and a scene's new name")
    toggle()
    for name in ("a/b", "a?b"):
        other = bpy.data.scenes.new(name)
        bpy.context.window.scene = other
        other.halflight.quality, other.halflight.show_view = "preview", False
        box("Floor of " + name, (1, 1, 0.1), (0, 0, 0))
        expect(bpy.ops.halflight.bake() == {"FINISHED"}, f"the scene {name} is baked")
    folders = [extension.files.of(each).folder for each in bpy.data.scenes]
    expect(len({folder.lower() for folder in folders}) == 3, f"a folder for each scene: {folders}")
    empty = bpy.data.scenes.new("Nothing")
    bpy.context.window.scene = empty
    expect("no object with a surface renders" in refusal(), "an empty scene")
    bpy.context.window.scene = scene
    folder = stage.path("blocked.halflight")
    with open(folder, "w", encoding="utf-8"):
        pass
    bpy.ops.wm.save_as_mainfile(filepath=stage.path("blocked.blend"))
    sentence = refusal()
    expect("cannot be made or written" in sentence and "Traceback" not in sentence, f"a file is in the way: {sentence}")
    os.remove(folder)
    os.mkdir(folder)
    with read_only(folder):
        sentence = refusal()
    expect("cannot be made or written" in sentence and "Traceback" not in sentence, f"a read-only folder: {sentence}")


@contextlib.contextmanager
def read_only(folder):
    """Root writes everywhere, so that it is nobody within."""
    is_root = os.geteuid() == 0
    os.chmod(stage.FOLDER, 0o755)
    os.chmod(folder, 0o555)
    if is_root:
        os.seteuid(NOBODY)
    try:
        yield
    finally:
        if is_root:
            os.seteuid(0)
        os.chmod(folder, 0o755)


def rich_scene():
    """The extension test's scene, and things of many kinds: a rig, a curve, letters, hair, keyframes, drivers, nodes."""
    stage.empty()
    scene = test_scene.build(stage.FOLDER)
    scene.halflight.quality, scene.halflight.texels_per_meter = "preview", 6
    scene.halflight.bake_materials, scene.halflight.material_size = True, 64
    pillar, ball = scene.objects["Pillar"], scene.objects["Ball"]
    material = pillar.data.materials[0]
    noise = material.node_tree.nodes.new("ShaderNodeTexNoise")
    material.node_tree.links.new(noise.outputs[1], material.node_tree.nodes["Principled BSDF"].inputs["Base Color"])
    curve = bpy.data.curves.new("Cable", "CURVE")
    curve.dimensions, curve.bevel_depth = "3D", 0.05
    curve.splines.new("BEZIER").bezier_points.add(1)
    curve.splines[0].bezier_points[1].co = (1, 0, 0.5)
    letters = bpy.data.curves.new("Letters", "FONT")
    rig = bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig"))
    for name, data in (("Cable", curve), ("Letters", letters)):
        scene.collection.objects.link(bpy.data.objects.new(name, data))
    scene.collection.objects.link(rig)
    ball.parent = rig
    ball.keyframe_insert("location", frame=1)
    scene.objects["Twin"].driver_add("location", 2).driver.expression = "0.8"
    scene.objects["Floor"].modifiers.new("Hair", "PARTICLE_SYSTEM")
    scene.objects["Floor"].particle_systems[0].settings.type = "HAIR"
    scene.objects["Wall"].shape_key_add(name="Basis")
    scene.frame_set(3)
    bpy.context.view_layer.update()
    return scene


def reload(name):
    bpy.ops.wm.save_as_mainfile(filepath=stage.path(name))
    bpy.ops.wm.open_mainfile(filepath=stage.path(name))


def check_blocks(extension):
    """Every property of every data-block is as it was: bake, view on, save, view off, a cancelled bake, reload."""
    rich_scene()
    reload("blocks.blend")
    before = dump.blocks()

    def same(when):
        changed = dump.difference(before, dump.blocks())
        expect(not changed, f"after {when}: {changed}")

    expect(bpy.ops.halflight.bake() == {"FINISHED"}, "the scene is baked")
    toggle()
    same("a bake")
    toggle()
    bpy.ops.wm.save_mainfile()
    expect(is_view(extension), "the view is shown after the save")
    toggle()
    same("a save in the view")
    scene = bpy.context.scene
    scene.halflight.texels_per_meter = 200
    cancelled_bake(extension)
    same("a cancelled bake")
    toggle()
    reload("blocks.blend")
    expect(not is_view(extension), "the file has no view")
    same("the view and a reload")


def cancelled_bake(extension):
    job = extension.bake.Job(bpy.context)
    job.export(bpy.context)
    job.start(bpy.context)
    while job.progress.share == 0.0 and job.poll(bpy.context) is None:
        time.sleep(0.02)
    job.cancel()
    job.process.wait(60)
    try:
        job.finish(bpy.context, job.poll(bpy.context))
    except extension.bake.BakeError:
        pass


def check_removal(extension):
    """Without the extension there is no view, in the session and in the file."""
    scene = stage.empty()
    bake("removal")
    name, objects = extension.__name__, sorted(scene.objects.keys())
    bpy.ops.preferences.addon_disable(module=name)
    expect(bpy.context.scene == scene, "the window shows the user's scene")
    expect(scene.objects["Floor"].users == 1, "a deleted object would stay in the file")
    bpy.ops.wm.save_mainfile()
    for when in ("in the session", "in the file"):
        names = sorted(item.name for item in bpy.data.objects)
        left = left_of_views(extension)
        expect(len(bpy.data.scenes) == 1 and names == objects and not left, f"{when} the view is gone too: {names}, {left}")
        bpy.ops.wm.open_mainfile(filepath=bpy.data.filepath)


stage.run(check_views, check_saving, check_state, check_blocks, check_files, check_removal)
