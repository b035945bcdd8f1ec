# SPDX-License-Identifier: GPL-3.0-or-later
"""Windows, keys and redraws: what headless Blender lacks. Runs in a virtual screen, with simulated events."""

import ctypes
import os
import sys
import time
import traceback

import bpy

sys.path.insert(0, os.path.dirname(__file__))
import stage  # noqa: E402
from stage import box, expect, matte  # noqa: E402

LONGEST = 60.0  # seconds that one step may take
PAUSE = 0.3  # seconds in which windows are drawn


def windows():
    return list(bpy.context.window_manager.windows)


def in_window(window, area_type="VIEW_3D"):
    """Operators act on this window."""
    area = next(area for area in window.screen.areas if area.type == area_type)
    region = next(region for region in area.regions if region.type == "WINDOW")
    return bpy.context.temp_override(window=window, area=area, region=region)


def toggle(window):
    with in_window(window):
        expect(bpy.ops.halflight.baked_view() == {"FINISHED"}, "the view is switched")


def middle_of(window, area_type):
    area = next(area for area in window.screen.areas if area.type == area_type)
    return area.x + area.width // 2, area.y + area.height // 2


def press(window, key, place):
    """The mouse is at `place` first, as Blender gives keys to what is below it."""
    x, y = place
    window.event_simulate(type="MOUSEMOVE", value="NOTHING", x=x, y=y)
    window.event_simulate(type=key, value="PRESS", x=x, y=y)
    window.event_simulate(type=key, value="RELEASE", x=x, y=y)


def is_view(extension, window):
    return extension.baked_view.is_view(window.scene)


def bake(window, extension):
    """As a click does; yields until the bake ends."""
    with in_window(window):
        expect(bpy.ops.halflight.bake("INVOKE_DEFAULT") == {"RUNNING_MODAL"}, "the bake runs beside Blender")
    return until(lambda: extension.bake.Job.current is None, "the bake ends")


def until(condition, sentence):
    end = time.monotonic() + LONGEST
    while not condition():
        expect(time.monotonic() < end, f"{sentence}: waited for {LONGEST:.0f} s")
        yield 0.05
    yield PAUSE


def two_scenes():
    """Two scenes, each with a floor of its own."""
    first = stage.empty()
    first.name = "First"
    second = bpy.data.scenes.new("Second")
    second.halflight.quality = "preview"
    for scene in (first, second):
        scene.eevee.taa_samples = 1  # of viewports, which a processor draws here
    window = windows()[0]
    window.scene = second
    with in_window(window):
        box("Other floor", (3, 3, 0.1), (0, 0, 0), matte("Other"))
    window.scene = first
    return first, second


def check_two_windows(extension):
    """Each window has the view of its own scene; leaving one leaves the other alone."""
    scenes = two_scenes()
    yield PAUSE
    bpy.ops.wm.save_as_mainfile(filepath=stage.path("windows.blend"))
    with bpy.context.temp_override(window=windows()[0]):
        bpy.ops.wm.window_new_main()
    yield PAUSE
    for window, scene in zip(windows(), scenes):
        window.scene = scene
        yield PAUSE
        yield from bake(window, extension)
        expect(is_view(extension, window), f"the window shows the view of {scene.name}")
    bpy.ops.wm.save_mainfile()
    yield PAUSE
    expect(all(is_view(extension, window) for window in windows()), "both windows show their views after saving")
    toggle(windows()[0])
    yield PAUSE
    expect(windows()[0].scene == scenes[0] and is_view(extension, windows()[1]), "the other window has its view still")
    toggle(windows()[1])
    yield PAUSE
    expect([window.scene for window in windows()] == list(scenes), "both windows show what they showed")


def check_one_view_twice(extension):
    """Both windows show one view, and one of them a linked copy of it: all leave it before it is removed."""
    first, second = bpy.data.scenes["First"], bpy.data.scenes["Second"]
    windows()[1].scene = first
    toggle(windows()[0])
    yield PAUSE
    windows()[1].scene = windows()[0].scene
    yield PAUSE
    with in_window(windows()[1]):
        bpy.ops.scene.new(type="LINK_COPY")
    yield PAUSE
    expect(windows()[1].scene not in {first, second, windows()[0].scene}, "the second window shows the copy")
    toggle(windows()[0])
    yield PAUSE
    expect([window.scene for window in windows()] == [first, first], "both windows show the user's scene")
    kinds = extension.baked_view.COLLECTIONS
    left = [item.name for kind in kinds for item in getattr(bpy.data, kind) if extension.baked_view.TAG in item]
    expect(not left, f"nothing of the view is left: {left}")
    with bpy.context.temp_override(window=windows()[1]):
        bpy.ops.wm.window_close()
    yield PAUSE


def undo_steps():
    """Names of the undo stack, which Blender prints."""
    flush = ctypes.CDLL(None).fflush
    flush(None)
    kept = os.dup(1)
    with open(stage.path("undo.txt"), "w+b") as file:
        os.dup2(file.fileno(), 1)
        try:
            bpy.context.window_manager.print_undo_steps()
        finally:
            flush(None)
            os.dup2(kept, 1)
            os.close(kept)
        file.seek(0)
        return [line.split("name=")[1].strip().strip("'") for line in file.read().decode().splitlines() if "name=" in line]


def state():
    """What a user sees of Blender, but for the pixels."""
    shown = []
    for window in windows():
        shown += [window.scene.name, window.view_layer.name, window.workspace.name, window.screen.name]
        for area in window.screen.areas:
            shown.append((area.type, area.x, area.y, area.width, area.height))
            if area.type == "VIEW_3D":
                space = area.spaces.active
                shown += [space.shading.type, space.local_view is not None, [list(row) for row in space.region_3d.view_matrix]]
    item = bpy.context.view_layer.objects.active
    selected = sorted(each.name for each in bpy.context.view_layer.objects if each.select_get())
    return [*shown, bpy.context.scene.frame_current, item.name, item.mode, selected]


def check_state(extension):
    """Windows, selection, frame, mode and undo steps after a bake, one that is cancelled, and one that fails."""
    scene = bpy.data.scenes["First"]
    window = windows()[0]
    for name in ("One", "Two"):
        with in_window(window):
            bpy.ops.mesh.primitive_cube_add(size=0.5, location=(len(scene.objects) - 3, 0, 0.3))
            bpy.context.object.name = name
            bpy.ops.ed.undo_push(message="Add " + name)
    with in_window(window):
        scene.frame_set(7)
        scene.halflight.show_view = False
        bpy.ops.view3d.localview()
        bpy.context.space_data.shading.type = "MATERIAL"
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.ed.undo_push(message="Before")
    yield PAUSE
    before, steps = state(), undo_steps()
    expect("Add Two" in steps, f"the undo stack is read: {steps}")
    yield from bake(window, extension)
    expect(state() == before, f"after a bake: {state()}; before: {before}")
    expect(undo_steps()[: len(steps)] == steps, f"after a bake: {undo_steps()}; before: {steps}")
    steps = undo_steps()
    with in_window(window):
        bpy.data.objects["One"]["halflight_lightmap_scale"] = "much"
        try:
            bpy.ops.halflight.bake()
        except RuntimeError:
            pass
        del bpy.data.objects["One"]["halflight_lightmap_scale"]
    yield PAUSE
    expect((state(), undo_steps()) == (before, steps), f"after a failed bake: {state()}, {undo_steps()}")
    with in_window(window):
        bpy.ops.object.mode_set(mode="OBJECT")
        bpy.ops.view3d.localview()
        bpy.ops.ed.undo()
    yield PAUSE
    expect("Two" in bpy.data.objects, "undo goes one step")
    scene = bpy.data.scenes["First"]
    scene.halflight.show_view = True
    before = state()
    yield from bake(window, extension)
    expect(is_view(extension, window), "the view is shown")
    expect(all(a.spaces.active.shading.type == "RENDERED" for a in window.screen.areas if a.type == "VIEW_3D"), "lit")
    toggle(window)
    yield PAUSE
    expect(state() == before, f"after the view: {state()}; before: {before}")


def check_esc(extension):
    """Esc cancels over areas that show the bake, and not while it stops a playback. The panel is drawn then."""
    scene, window = bpy.data.scenes["First"], windows()[0]
    scene.halflight.texels_per_meter, scene.halflight.lightmap_size = 300, 8192
    before, steps = state(), undo_steps()
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    area.spaces.active.show_region_ui = True
    drawn = {}
    spaces = ((bpy.types.SpaceView3D, "UI"), (bpy.types.SpaceProperties, "WINDOW"))

    def note(region):
        drawn[region] = extension.bake.Job.current

    handlers = [(*each, each[0].draw_handler_add(note, (each[1],), each[1], "POST_PIXEL")) for each in spaces]
    with in_window(window):
        bpy.ops.halflight.bake("INVOKE_DEFAULT")
    job = extension.bake.Job.current
    yield from until(lambda: job.progress.share > 0.0, "the bake makes progress")
    press(window, "ESC", middle_of(window, "OUTLINER"))
    yield PAUSE
    expect(not job.cancelled, "Esc over the outliner is not the bake's")
    with in_window(window):
        bpy.ops.screen.animation_play()
    yield PAUSE
    press(window, "ESC", middle_of(window, "VIEW_3D"))
    yield from until(lambda: not window.screen.is_animation_playing, "Esc stops the playback")
    expect(not job.cancelled and extension.bake.Job.current == job, "and not the bake")
    drawn.clear()
    press(window, "ESC", middle_of(window, "VIEW_3D"))
    yield from until(lambda: extension.bake.Job.current is None, "Esc ends the bake")
    expect(job.cancelled, "as cancelled")
    expect(drawn == {"UI": None, "WINDOW": None}, f"both places of the panel are drawn after it: {drawn}")
    expect(state() == before, f"after a cancelled bake: {state()}; before: {before}")
    expect(undo_steps() == steps, f"after a cancelled bake: {undo_steps()}; before: {steps}")
    for space, region, handler in handlers:
        space.draw_handler_remove(handler, region)


def eevee_picture(scene, name):
    """Luminance of Eevee's picture, top row first."""
    engines = scene.render.bl_rna.properties["engine"].enum_items.keys()
    scene.render.engine = "BLENDER_EEVEE_NEXT" if "BLENDER_EEVEE_NEXT" in engines else "BLENDER_EEVEE"
    scene.eevee.taa_render_samples = 8
    return stage.saved_picture(scene, name)


def check_eevee(extension):
    """Eevee's picture of the view against Cycles'; and dynamic objects against that of the user's own scene, as these throw
    shadows there which the view lacks."""
    scene = stage.empty()
    yield PAUSE
    window = windows()[0]
    with in_window(window):
        box("Wall", (3, 0.2, 2.4), (0, 0.8, 1.2), matte("Wall", (0.8, 0.3, 0.2)))
        ball = box("Dynamic", (0.7, 0.7, 0.7), (0.5, -0.6, 0.9), stage.diffuse("Dynamic", (0.3, 0.6, 0.8)))
        ball.halflight_static = "DYNAMIC"
        scene.world.node_tree.nodes["Background"].inputs[0].default_value = (0.3, 0.4, 0.5, 1)
        scene.halflight.show_view = False
        regions = {name: stage.region(scene, name) for name in ("Floor", "Wall", "Dynamic")}
        bpy.ops.wm.save_as_mainfile(filepath=stage.path("eevee.blend"))
        expect(bpy.ops.halflight.bake() == {"FINISHED"}, "the scene is baked")
        truth = stage.picture(scene, "eevee_truth")
        bpy.ops.halflight.baked_view()
    shown = eevee_picture(window.scene, "eevee_view")
    right = stage.picture(window.scene, "eevee_cycles")
    for name, pixels in regions.items():
        wanted, most = (truth, 0.06) if name == "Dynamic" else (right, 0.02)
        error = float(shown[pixels].mean() / wanted[pixels].mean() - 1.0)
        print(f"Eevee, {name}: {100 * error:+.1f} % of {wanted[pixels].mean():.3f}", flush=True)
        expect(abs(error) <= most, f"Eevee: {name} is off by {100 * error:+.1f} %")


CHECKS = (check_two_windows, check_one_view_twice, check_state, check_esc, check_eevee)


def steps():
    # The first events of a new window come late.
    yield 1.0
    extension = stage.install()
    for check in stage.chosen(CHECKS):
        yield from check(extension)


def main():
    running = steps()

    def go_on():
        try:
            return next(running)
        except StopIteration:
            print("windows: all checks passed", flush=True)
            os._exit(0)
        except BaseException:
            traceback.print_exc()
            sys.stderr.flush()
            os._exit(1)

    bpy.app.timers.register(go_on, first_interval=0.1, persistent=True)


main()
