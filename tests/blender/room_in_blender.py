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


def inner(pixels):
    """Those with neighbours of the same object on all four sides."""
    beside = np.pad(pixels, 1)
    return pixels & beside[:-2, 1:-1] & beside[2:, 1:-1] & beside[1:-1, :-2] & beside[1:-1, 2:]


def main():
    stage.install()
    stage.empty()
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)
    scene = room.build(stage.FOLDER)
    scene.halflight.quality = "medium"
    regions = stage.regions(scene)
    stage.SAMPLES = RAYS
    scene.cycles.max_bounces = scene.cycles.diffuse_bounces = BOUNCES
    truth = stage.picture(scene, "room_truth")
    stage.bake("room")
    stage.SAMPLES = 64
    shown = stage.picture(bpy.context.scene, "room_view")
    compared, wrong = 0, []
    for name, region in regions.items():
        pixels = inner(region)
        if not pixels.any():
            continue
        error = float(shown[pixels].mean() / truth[pixels].mean() - 1.0)
        print(f"room, {name}: {100 * error:+.1f} % of {truth[pixels].mean():.3f}, {pixels.sum()} pixels", flush=True)
        if pixels.sum() >= LEAST_PIXELS:
            compared += 1
            if abs(error) > stage.MOST_ERROR:
                wrong.append(f"{name} {100 * error:+.1f} %")
    expect(compared >= 12, f"regions of the room that are compared: {compared}")
    expect(not wrong, f"off by more than 3 %: {wrong}")


main()
