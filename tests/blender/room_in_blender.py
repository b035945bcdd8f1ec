# SPDX-License-Identifier: GPL-3.0-or-later
"""Every region of a furnished room in the baked view, against Cycles' picture of the room itself."""

import os
import sys

import bpy
import numpy as np

sys.path.insert(0, os.path.dirname(__file__))
import room  # noqa: E402
import stage  # noqa: E402
from stage import expect  # noqa: E402

LEAST_PIXELS = 20  # of a region that is compared, without its edge: a pixel there shows two objects
RAYS = 768  # per pixel of Cycles' picture
BOUNCES = 32  # as the bake has all of them; Cycles' default of 4 is darker by 5 % in this room
# Of one or two pixels, each of which shows the wall behind too. They are drawn larger, with fewer rays per pixel.
THIN = ("Sign", "Lamp pole", "Window bar 0")
ENLARGED, THIN_RAYS = 6, 128


def inner(pixels):
    """Those with neighbours of the same object on all four sides."""
    beside = np.pad(pixels, 1)
    return pixels & beside[:-2, 1:-1] & beside[2:, 1:-1] & beside[1:-1, :-2] & beside[1:-1, 2:]


def compare(name, pixels, shown, truth):
    """The error in percent where it is too large, as a list."""
    error = 100.0 * float(shown[pixels].mean() / truth[pixels].mean() - 1.0)
    print(f"room, {name}: {error:+.1f} % of {truth[pixels].mean():.3f}, {pixels.sum()} pixels", flush=True)
    return [f"{name} {error:+.1f} %"] if pixels.sum() >= LEAST_PIXELS and abs(error) > 100.0 * stage.MOST_ERROR else []


def picture(scene, name, rays):
    bpy.context.window.scene = scene
    stage.SAMPLES = rays
    return stage.picture(scene, name)


def draw_around(scene, pixels):
    """Renders no more than the rectangle around these pixels."""
    rows, columns = np.nonzero(pixels)
    height, width = pixels.shape
    scene.render.use_border = True
    scene.render.border_min_x, scene.render.border_max_x = columns.min() / width, (columns.max() + 1) / width
    scene.render.border_min_y, scene.render.border_max_y = 1.0 - (rows.max() + 1) / height, 1.0 - rows.min() / height


def compare_thin(scene, view, small):
    """`small`: their regions in the picture that is not enlarged."""
    stage.WIDTH, stage.HEIGHT = ENLARGED * stage.WIDTH, ENLARGED * stage.HEIGHT
    wrong = []
    for name in THIN:
        bpy.context.window.scene = scene
        with_neighbours = ~inner(~small[name])
        region = stage.regions(scene, np.kron(with_neighbours, np.ones((ENLARGED, ENLARGED), bool)))[name]
        for each in (scene, view):
            each.render.resolution_x, each.render.resolution_y = stage.WIDTH, stage.HEIGHT
            draw_around(each, region)
        pixels = inner(inner(region))
        expect(pixels.sum() >= LEAST_PIXELS, f"{name} is in the picture")
        truth = picture(scene, "thin_truth", THIN_RAYS)
        wrong += compare(f"{name}, enlarged", pixels, picture(view, "thin_view", THIN_RAYS // 4), truth)
    return wrong


def main():
    stage.install()
    stage.empty()
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)
    scene = room.build(stage.FOLDER)
    scene.halflight.quality = "medium"
    whole = stage.regions(scene)
    regions = {name: inner(region) for name, region in whole.items()}
    scene.cycles.max_bounces = scene.cycles.diffuse_bounces = BOUNCES
    truth = picture(scene, "room_truth", RAYS)
    view = stage.bake("room")
    shown = picture(view, "room_view", 64)
    wrong = []
    for name, pixels in regions.items():
        if pixels.any():
            wrong += compare(name, pixels, shown, truth)
    compared = sum(pixels.sum() >= LEAST_PIXELS for pixels in regions.values())
    expect(compared >= 12, f"regions of the room that are compared: {compared}")
    wrong += compare_thin(scene, view, {name: whole[name] for name in THIN})
    expect(not wrong, f"off by more than 3 %: {wrong}")


main()
