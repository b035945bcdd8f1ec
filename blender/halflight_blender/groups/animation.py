# SPDX-License-Identifier: GPL-3.0-or-later
"""Keyframes of light groups: read for the baked view, whose scene has none, and written into the baked file."""

import numpy as np

from ..glb import Glb

PATH = "halflight.light_groups["
POINTER = "/extensions/HALFLIGHT_mixed_lighting/groups/{}/weight"
EXTENSION = "KHR_animation_pointer"
NAME = "Light groups"
# A key is left out where a straight line between its neighbours is as near as this, of the largest weight: below one step of a
# screen with 8 bits.
STRAIGHT = 1.0 / 1024.0


def curves_of(scene):
    """Keyframes and drivers of groups."""
    data = scene.animation_data
    if data is None:
        return []
    curves = [*(data.action.fcurves if data.action else ()), *data.drivers]
    return [curve for curve in curves if curve.data_path.startswith(PATH)]


def is_animated(scene, entry=None):
    """`entry`: one group of the scene, or any."""
    if entry is None:
        return bool(curves_of(scene))
    return any(curve.data_path.startswith(entry.path_from_id() + ".") for curve in curves_of(scene))


def set_to_frame(scene, frame):
    """Sets the sliders to their keyframes. Drivers are Blender's."""
    data = scene.animation_data
    for curve in data.action.fcurves if data is not None and data.action else ():
        if curve.data_path.startswith(PATH) and not curve.mute:
            path, name = curve.data_path.rsplit(".", 1)
            try:
                owner = scene.path_resolve(path)
            except ValueError:  # of a group that is gone
                continue
            if name == "color":
                owner.color[curve.array_index] = curve.evaluate(frame)
            else:
                owner.brightness = curve.evaluate(frame)


def sampled(scene, entries):
    """Weights in the file at each frame of the scene's range, by frame and group. The sliders are left as they are."""
    before = [(entry.brightness, tuple(entry.color)) for entry in entries]
    rows = []
    for frame in range(scene.frame_start, scene.frame_end + 1):
        set_to_frame(scene, frame)
        rows.append([entry.weight_in_file() for entry in entries])
    for entry, (brightness, color) in zip(entries, before):
        entry.brightness, entry.color = brightness, color
    return np.array(rows, np.float32)


def needed(values):
    """Numbers of the keys that a line through the others does not give."""
    most = STRAIGHT * max(float(np.abs(values).max()), 1e-30)
    kept, start = [0], 0
    for end in range(2, len(values)):
        shares = (np.arange(start + 1, end) - start)[:, None] / (end - start)
        line = values[start] + (values[end] - values[start]) * shares
        if np.abs(line - values[start + 1 : end]).max() > most:
            start = end - 1
            kept.append(start)
    return kept + ([len(values) - 1] if len(values) > 1 else [])


def write(scene, entries, path):
    """Adds an animation of the weights to the baked file, where sliders have keyframes. `entries`: the groups, in the file's
    order. Seconds are Blender's frames over frames per second, as its exporter has them."""
    moving = [number for number, entry in enumerate(entries) if is_animated(scene, entry)]
    document = Glb(path)
    animations = [each for each in document.json.get("animations", []) if each.get("name") != NAME]
    if not moving:
        return
    rows = sampled(scene, entries)
    rate = scene.render.fps / scene.render.fps_base
    samplers, channels = [], []
    for number in moving:
        keys = needed(rows[:, number])
        seconds = np.array([[(scene.frame_start + key) / rate] for key in keys], np.float32)
        times = document.add_accessor(seconds, "SCALAR")
        document.json["accessors"][times].update(min=seconds.min(0).tolist(), max=seconds.max(0).tolist())
        output = document.add_accessor(rows[keys, number], "VEC3")
        samplers.append({"input": times, "output": output, "interpolation": "LINEAR"})
        target = {"path": "pointer", "extensions": {EXTENSION: {"pointer": POINTER.format(number)}}}
        channels.append({"sampler": len(samplers) - 1, "target": target})
    document.json["animations"] = [*animations, {"name": NAME, "samplers": samplers, "channels": channels}]
    document.use_extension(EXTENSION)
    document.write(path)
