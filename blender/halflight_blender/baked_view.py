# SPDX-License-Identifier: GPL-3.0-or-later
"""The baked view: a scene beside the user's, made of what the baked file holds.

The user's scene, objects and materials are not changed. The view has their settings, world, cameras and lights, their
objects without lightmap as they are, and a mesh for each object with lightmap texels, modifiers and instances resolved.
All that is made here carries TAG, and goes when the view is left.
"""

import json
import os
import uuid

import bpy
import numpy as np

from .export import export_scene, scene_copy
from .glb import Glb
from .view import moving, moving_materials, view_groups, view_lights, view_materials

TAG = view_groups.TAG
SURFACES = {"MESH", "CURVE", "SURFACE", "FONT", "META"}
# Halves of a sheet are moved apart by this share of their largest coordinate: a ray meets one of two faces at one place.
APART = 1e-5
COLLECTIONS = ("scenes", "collections", "objects", "meshes", "materials", "node_groups", "images", "worlds")


def source_of(scene):
    """The user's scene behind a view, or the scene itself."""
    return scene.halflight.view_of or scene


def is_view(scene):
    return scene.halflight.view_of is not None


def views_of(scene):
    """The view of a scene, and what the user copied of it."""
    return [candidate for candidate in bpy.data.scenes if candidate.halflight.view_of == scene]


def all_windows():
    return [window for manager in bpy.data.window_managers for window in manager.windows]


def show(context, files):
    """Builds the view of the window's scene from a bake's files and switches the window to it."""
    source = source_of(context.scene)
    leave(source)
    key = uuid.uuid4().hex
    before = {name: set(getattr(bpy.data, name)) for name in COLLECTIONS}
    try:
        view = build(source, context.view_layer, files)
    except BaseException:
        tag_new(before, key)
        remove(key)
        raise
    tag_new(before, key)
    context.window.scene = view
    layer = view.view_layers[0]
    layer.update()
    view_groups.show_weights(view)
    moving.update(view, layer.depsgraph, key, files)
    show_rendered(context.window, view)
    return view


def tag_new(before, key):
    for name in COLLECTIONS:
        for item in set(getattr(bpy.data, name)) - before[name]:
            item[TAG] = key


def leave(source):
    """Back to the user's scene in each window; its view is gone. What the user added there is in the user's scene.
    True when there was a view."""
    views = views_of(source)
    for view in views:
        moving.keep_moves(view)
        moving.take_duplicates(view, source, TAG)
        keep_additions(source, view)
    for window in all_windows():
        if window.scene in views:
            restore_shading(window, window.scene)
            window.scene = source
    keys = {view.get(TAG) for view in views}
    for view in views:
        view.halflight.view_of = None
    for key in keys:
        remove(key)
        moving.loaded.pop(key, None)
    return bool(views)


def keep_additions(source, view):
    """Objects and collections that were made in the view go where the user would have made them without it."""
    for collection in list(view.collection.children_recursive):
        if TAG not in collection and collection not in source.collection.children_recursive:
            source.collection.children.link(collection)
    known = set(source.objects)
    for item in view.objects:
        if TAG not in item and item not in known:
            if not any(TAG not in c and c in source.collection.children_recursive for c in item.users_collection):
                source.collection.objects.link(item)


def remove(key):
    tagged = [item for name in COLLECTIONS for item in getattr(bpy.data, name) if item.library is None and item.get(TAG) == key]
    bpy.data.batch_remove(tagged)


def build(source, view_layer, files):
    document = Glb(files.baked)
    with open(os.path.join(files.sidecar, "bake.json"), encoding="utf-8") as file:
        bindings = json.load(file)
    view = scene_copy.empty_copy_of(source)
    view.name = source.name + " (baked)"
    view.halflight.view_of = source
    collection = bpy.data.collections.new(view.name)
    view.collection.children.link(collection)

    lights = view_lights.shining_lights(document, bindings)
    add_switches(view, lights)
    lumens = export_scene.lumens_per_watt(source.halflight.units)
    groups = view_groups.Groups(bindings.get("groups", []), document, source, lumens)
    group = view_lights.make_group(lights, bindings.get("shadowmaskChannels"), groups) if lights else None
    materials = view_materials.Materials(document, bindings, files.sidecar, group, groups, lumens)
    matrices = document.world_matrices()
    objects, shown = objects_of(source), set()
    for index, node in enumerate(document.json.get("nodes", [])):
        record = node.get("extensions", {}).get("HALFLIGHT_node", {})
        lightmap = record.get("lightmap", {})
        if "mesh" not in node or index not in matrices:
            continue
        if "page" in lightmap:
            matrix = view_lights.BLENDER_FROM_GLTF @ matrices[index]
            collection.objects.link(make_object(document, node, lightmap, matrix, materials))
            shown.add(objects.get(node.get("name")))
    rest = the_rest(view_layer, shown, instances_with_texels(document))
    for item in rest:
        if item.type in {"LIGHT", "CAMERA", "ARMATURE"}:
            collection.objects.link(item)
    # Probes have attenuations, whatever encoding the masks have.
    plain = view_lights.make_group(lights, None, groups) if lights and bindings.get("shadowmaskChannels") else group
    surfaces = moving_materials.MovingMaterials(plain, groups, lumens)
    moving.add(view, collection, [item for item in rest if item.type in SURFACES | {"EMPTY"}], surfaces)
    view_groups.follow_sky(view, groups)
    return view


def objects_of(source):
    """The user's objects by their names in the baked file."""
    objects = {item.name: item for item in source.objects}
    objects.update((entry.name, entry.item) for entry in source.halflight.baked_objects if entry.item is not None)
    return objects


def note_objects(source, document, keep_last):
    """Remembers which objects the nodes of an exported file are, so that renaming does not part them. `keep_last`: names
    of the last file stay known, as long as it is there."""
    entries = source.halflight.baked_objects
    names = {node.get("name", "") for node in document.get("nodes", []) if "mesh" in node}
    for index in reversed(range(len(entries))):
        if (entries[index].name in names) == keep_last:
            entries.remove(index)
    if not keep_last:
        return
    for name in sorted(names):
        item = bpy.data.objects.get(name)
        if item is not None:
            entry = entries.add()
            entry.name, entry.item = name, item


def forget_deleted(source):
    """An object that is in no scene any more is kept by nothing but the memory of its bake."""
    entries = source.halflight.baked_objects
    for index in reversed(range(len(entries))):
        if entries[index].item is None or not entries[index].item.users_collection:
            entries.remove(index)


def the_rest(view_layer, shown, with_texels):
    """Cameras and lights, and objects and instances of collections without lightmap that the camera sees."""
    found = []
    for item in scene_copy.rendered_objects(view_layer):
        if item.type in SURFACES:
            if item not in shown and not scene_copy.is_unseen(item, view_layer):
                found.append(item)
        elif item.type == "EMPTY":
            is_instance = item.instance_type == "COLLECTION" and item.instance_collection is not None
            if is_instance and item.name not in with_texels and not scene_copy.is_unseen(item, view_layer):
                found.append(item)
        elif item.type in {"LIGHT", "CAMERA", "ARMATURE"}:
            found.append(item)
    return found


def instances_with_texels(document):
    """Names of nodes that have lightmap texels, or have them below."""
    nodes = document.json.get("nodes", [])

    def has_texels(node):
        own = "page" in node.get("extensions", {}).get("HALFLIGHT_node", {}).get("lightmap", {})
        return own or any(has_texels(nodes[child]) for child in node.get("children", []))

    return {node.get("name") for node in nodes if has_texels(node)}


def add_switches(view, lights):
    view.halflight_lights.clear()
    for light in lights:
        item = view.halflight_lights.add()
        item.name = light["name"]
        channels = "".join("RGBA"[channel] for channel in view_lights.mask_channels(light))
        item.shadow = "mask " + channels if channels else "none"


# -- meshes ----------------------------------------------------------------------------------------------------------


def make_object(document, node, lightmap, matrix, materials):
    """In world space, so that any matrix will do."""
    name = "Baked " + node.get("name", "object")
    mesh = bpy.data.meshes.new(name)
    parts = [part_of(document, p, lightmap) for p in document.json["meshes"][node["mesh"]]["primitives"]]
    parts = [part for part in parts if part is not None]
    sets = sorted({key for part in parts for key in part["uvs"]})
    has_colors = any(part["colors"] is not None for part in parts)
    for part in parts:
        mesh.materials.append(materials.get(part["material"], lightmap["page"], has_colors))
    positions = np.concatenate([part["positions"] for part in parts]) @ matrix[:3, :3].T + matrix[:3, 3]
    normals = unit(np.concatenate([part["normals"] for part in parts]) @ cofactors(matrix[:3, :3]).T)
    sided = np.concatenate([np.full(len(part["positions"]), is_side(document, part["material"])) for part in parts])
    positions += normals * (sided * APART * np.abs(positions).max())[:, None]
    starts = np.cumsum([0] + [len(part["positions"]) for part in parts])
    corners = np.concatenate([part["corners"] + start for part, start in zip(parts, starts)])
    if np.linalg.det(matrix[:3, :3]) < 0:
        corners = corners.reshape(-1, 3)[:, ::-1].reshape(-1)
    slots = np.concatenate([np.full(len(part["corners"]) // 3, i) for i, part in enumerate(parts)])
    fill(mesh, positions, corners, slots)
    for key in sets:
        uvs = np.concatenate([part["uvs"].get(key, np.zeros((len(part["positions"]), 2))) for part in parts])
        layer = mesh.uv_layers.new(name=view_materials.LIGHTMAP_UV if key == -1 else view_materials.uv_name(key))
        layer.data.foreach_set("uv", (uvs[corners] * (1, -1) + (0, 1)).astype(np.float32).reshape(-1))
    if has_colors:
        white = np.ones((1, 4), np.float32)
        colors = [np.repeat(white, len(p["positions"]), 0) if p["colors"] is None else p["colors"] for p in parts]
        layer = mesh.color_attributes.new(view_materials.COLORS, "FLOAT_COLOR", "POINT")
        layer.data.foreach_set("color", np.concatenate(colors).astype(np.float32).reshape(-1))
    set_normals(mesh, normals)
    return bpy.data.objects.new(name, mesh)


def is_side(document, material):
    """Whether it is of one half of a sheet whose sides have texels of their own."""
    return material is not None and "halflight_side" in document.json["materials"][material].get("extras", {})


def unit(vectors):
    """What has no length keeps none: Blender chooses the normal there."""
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.divide(vectors, lengths, out=np.zeros_like(vectors), where=lengths > 0)


def cofactors(matrix):
    """What turns normals, but for their length: the inverse's transpose, and right for a matrix that flattens too."""
    x, y, z = matrix.T
    return np.stack([np.cross(y, z), np.cross(z, x), np.cross(x, y)], 1)


def part_of(document, primitive, lightmap):
    """Arrays of a primitive's triangles; None for lines and points. Set -1 of `uvs` is the place on the page."""
    if primitive.get("mode", 4) != 4:
        return None
    attributes = primitive["attributes"]
    positions = document.accessor(attributes["POSITION"]).astype(np.float64)
    if "indices" in primitive:
        corners = document.accessor(primitive["indices"]).reshape(-1).astype(np.int64)
    else:
        corners = np.arange(len(positions))
    corners = corners[: len(corners) // 3 * 3]
    uvs = {i: document.accessor(attributes[f"TEXCOORD_{i}"]) for i in range(8) if f"TEXCOORD_{i}" in attributes}
    uvs[-1] = uvs[lightmap["texCoord"]] * lightmap["scale"] + lightmap["offset"]
    colors = document.accessor(attributes["COLOR_0"]) if "COLOR_0" in attributes else None
    if colors is not None and colors.shape[1] == 3:
        colors = np.concatenate([colors, np.ones((len(colors), 1), colors.dtype)], 1)
    normals = document.accessor(attributes["NORMAL"]) if "NORMAL" in attributes else np.zeros((len(positions), 3))
    return {
        "material": primitive.get("material"),
        "positions": positions,
        "normals": normals.astype(np.float64),
        "corners": corners,
        "uvs": uvs,
        "colors": colors,
    }


def fill(mesh, positions, corners, slots):
    count = len(corners) // 3
    mesh.vertices.add(len(positions))
    mesh.vertices.foreach_set("co", positions.astype(np.float32).reshape(-1))
    mesh.loops.add(len(corners))
    mesh.loops.foreach_set("vertex_index", corners.astype(np.int32))
    mesh.polygons.add(count)
    mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * count, 3, dtype=np.int32))
    if bpy.app.version < (4, 1, 0):
        mesh.polygons.foreach_set("loop_total", np.full(count, 3, np.int32))
    mesh.polygons.foreach_set("material_index", slots.astype(np.int32))
    mesh.polygons.foreach_set("use_smooth", np.ones(count, bool))
    mesh.update(calc_edges=True)


def set_normals(mesh, normals):
    if bpy.app.version < (4, 1, 0):
        mesh.use_auto_smooth = True
    mesh.normals_split_custom_set_from_vertices(normals.tolist())


# -- viewports -------------------------------------------------------------------------------------------------------


def show_rendered(window, view):
    """Other shadings would show none of it, or light its dynamic objects by another world."""
    if view.render.engine == "BLENDER_WORKBENCH":
        engines = view.render.bl_rna.properties["engine"].enum_items.keys()
        view.render.engine = "BLENDER_EEVEE_NEXT" if "BLENDER_EEVEE_NEXT" in engines else "BLENDER_EEVEE"
    changed = []
    for number, area in enumerate(window.screen.areas):
        if area.type == "VIEW_3D" and area.spaces.active.shading.type != "RENDERED":
            changed.append((number, area.spaces.active.shading.type))
            area.spaces.active.shading.type = "RENDERED"
    view["halflight_shading"] = json.dumps(changed)


def restore_shading(window, view):
    areas = window.screen.areas
    for number, shading in json.loads(view.get("halflight_shading", "[]")):
        if number < len(areas) and areas[number].type == "VIEW_3D":
            areas[number].spaces.active.shading.type = shading
