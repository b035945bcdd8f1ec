# SPDX-License-Identifier: GPL-3.0-or-later
"""Dynamic objects of the baked view: copies that the bake's probes light, at the place where each object is.

A copy shares mesh and animation with the user's object; its materials emit. Where the user moves a copy, the object itself is
moved when the view is left.
"""

import bpy
import mathutils
import numpy as np
from bpy.app.handlers import persistent

from .. import files
from ..export import scene_copy
from ..glb import Glb
from . import probes, view_groups, view_lights
from .moving_materials import NAME as LIGHT, attributes_of

MARK = "halflight_moving"  # on copies, and on what the user duplicates of them
PLACE = "halflight_probed_at"
WEIGHTS = "halflight_probed_weights"  # of light groups, one after the other
LEAST_MOVE = 1e-5  # metres
TRANSFORMS = ("location", "rotation_mode", "rotation_euler", "rotation_quaternion", "rotation_axis_angle", "scale")
TRANSFORMS += ("delta_location", "delta_rotation_euler", "delta_rotation_quaternion", "delta_scale")

loaded = {}  # probes of views, by the view's key


class Moving(bpy.types.PropertyGroup):
    """A copy in the view, and whose it is."""

    copy: bpy.props.PointerProperty(type=bpy.types.Object)
    source: bpy.props.PointerProperty(type=bpy.types.Object)


def add(view, collection, items, surfaces):
    """`items`: the user's objects. `surfaces`: MovingMaterials."""
    copies = {item: item.copy() for item in items}
    for item, copy in copies.items():
        copy.name = item.name + " (baked)"
        copy[MARK] = 1
        if item.parent in copies:
            inverse = item.matrix_parent_inverse.copy()
            copy.parent = copies[item.parent]
            copy.matrix_parent_inverse = inverse
        if item.type == "EMPTY":
            copy.instance_collection = copy_of_collection(item.instance_collection, surfaces)
        else:
            surfaces.set_materials(copy)
        collection.objects.link(copy)
        entry = view.halflight_moving.add()
        entry.copy, entry.source = copy, item
    return copies


def copy_of_collection(collection, surfaces):
    """What an instance shows, with the materials of the view. The light is that of the instance."""
    folder = bpy.data.collections.new(collection.name + " (baked)")
    folder.instance_offset = collection.instance_offset
    for item in scene_copy.rendered_in(collection):
        if item.type not in {"LIGHT", "CAMERA"}:
            copy = item.copy()
            copy.name = item.name + " (baked)"
            if item.type == "EMPTY" and item.instance_collection is not None:
                copy.instance_collection = copy_of_collection(item.instance_collection, surfaces)
            elif hasattr(item.data, "materials"):
                surfaces.set_materials(copy)
            folder.objects.link(copy)
    return folder


def update(scene, depsgraph, key, folder):
    """Gives each copy that is not where it was the light of its place; all copies, where weights of light groups changed."""
    weights = view_groups.weights_of(scene)
    numbers = [number for weight in weights.values() for number in weight]
    moved = []
    for item in scene.objects:
        if MARK not in item:
            continue
        shape = item.evaluated_get(depsgraph)
        middle = middle_of(boxes_of(shape, shape.matrix_world))
        is_lit = list(item.get(WEIGHTS, [])) == numbers
        if not is_lit or np.abs(np.array(item.get(PLACE, (np.inf,) * 3)) - middle).max() > LEAST_MOVE:
            moved.append((item, middle))
    if not moved:
        return
    if key not in loaded:
        loaded[key] = probes.Probes(Glb(folder.baked))
    loaded[key].compose(weights)
    for item, middle in moved:
        factors, occlusion = loaded[key].sample(view_lights.BLENDER_FROM_GLTF[:3, :3].T @ middle)
        item[PLACE] = middle.tolist()
        if numbers:
            item[WEIGHTS] = numbers
        for name, value in attributes_of(factors, occlusion).items():
            item[name] = value
        item.update_tag()


def boxes_of(item, matrix):
    """Corners in the world of the boxes around an object, or around what it instances."""
    if item.type != "EMPTY":
        return np.array([[*corner, 1.0] for corner in item.bound_box]) @ np.array(matrix).T
    collection = item.instance_collection
    offset = mathutils.Matrix.Translation(collection.instance_offset).inverted()
    found = [boxes_of(each, matrix @ offset @ each.matrix_world) for each in collection.objects]
    return np.concatenate(found) if found else np.array([[*matrix.translation, 1.0]])


def middle_of(corners):
    """Of the box around these, in the world."""
    return (corners[:, :3].min(0) + corners[:, :3].max(0)) / 2.0


def keep_moves(view):
    """Where the user moved copies, the objects are moved. Animated values are the animation's."""
    for entry in view.halflight_moving:
        if entry.copy is None or entry.source is None:
            continue
        animated = animated_paths(entry.copy)
        for name in TRANSFORMS:
            value = plain(getattr(entry.copy, name))
            if name not in animated and value != plain(getattr(entry.source, name)):
                setattr(entry.source, name, value)


def animated_paths(item):
    data = item.animation_data
    if data is None:
        return set()
    if data.nla_tracks:
        return set(TRANSFORMS)
    curves = [*(data.action.fcurves if data.action else ()), *data.drivers]
    return {curve.data_path for curve in curves}


def plain(value):
    return value if isinstance(value, str) else list(value)


def take_duplicates(view, source, tag):
    """What the user duplicated of copies is the user's own, and so is what the user made a child of them."""
    sources = {entry.copy: entry.source for entry in view.halflight_moving if entry.copy is not None}
    shown = {copy.instance_collection: item.instance_collection for copy, item in sources.items() if item is not None}
    for item in list(view.objects):
        if MARK in item and item not in sources:
            for name in [name for name in item.keys() if name in {tag, MARK, PLACE, WEIGHTS} or name.startswith(LIGHT)]:
                del item[name]
            item.name = item.name.replace(" (baked)", "")
            if item.type == "EMPTY":
                item.instance_collection = shown.get(item.instance_collection)
            for slot in item.material_slots:
                slot.link = "DATA"
            source.collection.objects.link(item)
        if item.parent in sources and item not in sources:
            inverse = item.matrix_parent_inverse.copy()
            item.parent = sources[item.parent]
            item.matrix_parent_inverse = inverse


@persistent
def after_change(scene, depsgraph=None):
    if depsgraph is None or scene.halflight.view_of is None or not scene.halflight_moving:
        return
    try:
        update(scene, depsgraph, scene.get("halflight_baked_view", ""), files.of(scene))
    except (OSError, ValueError, KeyError) as error:
        print(f"Halflight: probes of the last bake cannot be read: {error}")


HANDLERS = ("depsgraph_update_post", "frame_change_post")


def register():
    bpy.utils.register_class(Moving)
    bpy.types.Scene.halflight_moving = bpy.props.CollectionProperty(type=Moving)
    for name in HANDLERS:
        getattr(bpy.app.handlers, name).append(after_change)


def unregister():
    for name in HANDLERS:
        getattr(bpy.app.handlers, name).remove(after_change)
    del bpy.types.Scene.halflight_moving
    bpy.utils.unregister_class(Moving)
    loaded.clear()
