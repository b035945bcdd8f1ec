# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a scene is still what was baked: a digest of all that the bake reads, compared a second after each change."""

import hashlib

import bpy
import numpy as np
from bpy.app.handlers import persistent

from . import baked_view
from .groups import members

DELAY = 1.0  # seconds without a change
stale = {}  # by scene's name: True, False; absent: not known


def is_stale(scene):
    return stale.get(baked_view.source_of(scene).name, False)


def digest(scene, depsgraph):
    """Of evaluated objects, instances included, their surfaces and lights, the world, and the settings of the bake."""
    digest = hashlib.blake2b(digest_size=16)
    known = {}
    whites = whites_of(scene)

    def add(*values):
        digest.update(repr(values).encode())

    def add_once(item, write):
        """Shared data is written once, then named."""
        if item is not None and item.original.name_full not in known.setdefault(type(item), set()):
            known[type(item)].add(item.original.name_full)
            add(item.original.name_full)
            write(item)

    def mesh(data):
        for values, name, width in ((data.vertices, "co", 3), (data.polygons, "material_index", 1)):
            array = np.zeros(len(values) * width, np.float32 if width == 3 else np.int32)
            values.foreach_get(name, array)
            digest.update(array.tobytes())
        for layer in data.uv_layers:
            array = np.zeros(len(layer.data) * 2, np.float32)
            layer.data.foreach_get("uv", array)
            digest.update(array.tobytes())

    def nodes(tree, item=None):
        """`item`: whose tree it is, where a light group may set its emission."""
        set_here = sockets_of_group(item) if item in whites else set()
        add(whites.get(item))
        for node in tree.nodes:
            add(node.bl_idname, node.mute, getattr(getattr(node, "image", None), "name", None))
            for socket in node.inputs:
                value = None if (node.name, socket.identifier) in set_here else getattr(socket, "default_value", None)
                add(tuple(value) if hasattr(value, "__len__") and not isinstance(value, str) else value)
            if getattr(node, "node_tree", None):
                add_once(node.node_tree, nodes)
        for link in tree.links:
            add(link.from_node.name, link.from_socket.identifier, link.to_node.name, link.to_socket.identifier)

    def material(item):
        add(extras(item), item.use_backface_culling, tuple(item.diffuse_color))
        if item.use_nodes:
            nodes(item.node_tree, item.original)

    def light(item):
        names = ("type", "energy", "shadow_soft_size", "angle", "spot_size", "spot_blend", "shape", "size", "size_y")
        white = whites.get(item.original)
        values = [getattr(item, name, None) for name in names if white is None or name != "energy"]
        add(white or tuple(item.color), values, extras(item))

    for instance in depsgraph.object_instances:
        item = instance.object
        if item.type not in baked_view.SURFACES | {"LIGHT"}:
            continue
        add(item.original.name_full, [round(v, 5) for row in instance.matrix_world for v in row], extras(item.original))
        if item.type == "LIGHT":
            add_once(item.data, light)
        elif item.type == "MESH":
            # An object's evaluated mesh is its own where it has modifiers.
            key = (item.original.name_full, item.data.original.name_full)
            if key not in known:
                known[key] = True
                mesh(item.data)
        for slot in item.material_slots:
            add_once(slot.material, material)
    if scene.world:
        add(tuple(scene.world.color), scene.world.halflight_sky_source)
        if scene.world.use_nodes:
            nodes(scene.world.node_tree, scene.world)
    settings = scene.halflight
    left_out = {"rna_type", "name", "baked_digest", "summary", "view_of", "output", "show_view", "device", "threads"}
    left_out |= {"baked_objects", "folder", "light_groups"}
    names = [p.identifier for p in settings.bl_rna.properties if p.identifier not in left_out]
    add(extras(scene), [getattr(settings, name) for name in names])
    return digest.hexdigest()


def whites_of(scene):
    """What of lamps, materials and world a light group's slider sets, at the weight 1: the weight is no change for the bake."""
    entries = [entry for entry in scene.halflight.light_groups if entry.is_baked]
    owned = [member for entry in entries for member in entry.members if member.item is not None]
    return {member.item: [f"{c:.4g}" for c in member.white] for member in owned}


def sockets_of_group(item):
    places = [place for place in members.places_of(item) if place is not None]
    return {(place.owner.node.name, place.owner.identifier) for place in places}


def extras(item):
    values = ((key, item[key]) for key in item.keys() if key.startswith("halflight_"))
    return sorted((key, value.to_list() if hasattr(value, "to_list") else value) for key, value in values)


def note_bake(context, scene):
    scene.halflight.baked_digest = digest(scene, context.evaluated_depsgraph_get())
    stale[scene.name] = False


def check(context):
    """Compares now. True when the scene changed since its bake."""
    scene = context.scene
    if baked_view.is_view(scene) or not scene.halflight.baked_digest:
        return is_stale(scene)
    stale[scene.name] = digest(scene, context.evaluated_depsgraph_get()) != scene.halflight.baked_digest
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            area.tag_redraw()
    return stale[scene.name]


def check_later():
    if bpy.app.background:
        return
    if bpy.app.timers.is_registered(check_now):
        bpy.app.timers.unregister(check_now)
    bpy.app.timers.register(check_now, first_interval=DELAY)


def check_now():
    if bpy.context.window_manager.windows and bpy.context.mode == "OBJECT":
        check(bpy.context)


@persistent
def after_change(scene, depsgraph):
    if baked_view.is_view(scene) or not scene.halflight.baked_digest:
        return
    changed = any(u.is_updated_geometry or u.is_updated_transform or u.is_updated_shading for u in depsgraph.updates)
    if changed:
        check_later()


@persistent
def after_load(*_arguments):
    stale.clear()
    check_later()


def register():
    bpy.app.handlers.depsgraph_update_post.append(after_change)
    bpy.app.handlers.load_post.append(after_load)
    bpy.app.handlers.undo_post.append(after_load)


def unregister():
    if bpy.app.timers.is_registered(check_now):
        bpy.app.timers.unregister(check_now)
    bpy.app.handlers.undo_post.remove(after_load)
    bpy.app.handlers.load_post.remove(after_load)
    bpy.app.handlers.depsgraph_update_post.remove(after_change)
