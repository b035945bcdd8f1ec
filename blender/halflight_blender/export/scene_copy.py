# SPDX-License-Identifier: GPL-3.0-or-later
"""What the exporter reads in place of the user's scene: a scene of copies, with everything as renders have it.

The user's objects, their modifiers and the scene's frame are not touched. Copies share meshes, actions and materials.
"""

import contextlib

import bpy

from . import surfaces

SOURCE = "halflight_copy_of"  # on copies: the name of what they are copies of
BARE = "halflight_only_place"  # on copies of parents that do not render: their place counts, their geometry does not
# Of modifiers: what the viewport uses, and what renders use.
RENDER_LEVELS = {
    "SUBSURF": ("levels", "render_levels"),
    "MULTIRES": ("levels", "render_levels"),
    "SCREW": ("steps", "render_steps"),
    "OCEAN": ("viewport_resolution", "resolution"),
}


def rendered_objects(view_layer):
    """Objects of a view layer that take part in renders, in its order: in a collection that is neither excluded nor
    without its camera icon, and with their own camera icon on."""
    found = {}

    def walk(layer):
        if layer.collection.hide_render:
            return
        if not layer.exclude:
            found.update((item, None) for item in layer.collection.objects if not item.hide_render)
        for child in layer.children:
            walk(child)

    walk(view_layer.layer_collection)
    return list(found)


def rendered_in(collection):
    """The same for a collection that is instanced."""
    found = {item: None for item in collection.objects if not item.hide_render}
    for child in collection.children:
        if not child.hide_render:
            found.update((item, None) for item in rendered_in(child))
    return list(found)


def is_unseen(item, view_layer):
    """The camera does not see it, though it lights and shadows others."""
    if getattr(item, "is_holdout", False) or not getattr(item, "visible_camera", True):
        return True
    return item.holdout_get(view_layer=view_layer) or item.indirect_only_get(view_layer=view_layer)


@contextlib.contextmanager
def copied_scene(context):
    """The window shows the copy within. All that was made goes at the end, whatever happens."""
    source, view_layer, window = context.scene, context.view_layer, context.window
    copy = Copy(source, view_layer)
    try:
        copy.make()
        window.scene = copy.scene
        for item in copy.copies.values():
            item.update_tag()  # else what was hidden in viewports stays where it was last shown
        window.view_layer.update()
        yield copy
    finally:
        window.scene = source
        window.view_layer = view_layer
        copy.remove()


class Copy:
    def __init__(self, source, view_layer):
        self.source = source
        self.view_layer = view_layer
        self.scene = None
        self.copies = {}  # of objects, by the original
        self.collections = {}
        self.data = []
        self.pictures = []  # data-blocks of Bake Materials
        self.surfaced = {}  # copies of data with replaced materials
        self.edited = {}  # copies of data that is in edit mode, by the original
        self.surfaces = surfaces.Surfaces()
        self.parents = {child: each for each in bpy.data.collections for child in each.children}

    def make(self):
        self.scene = empty_copy_of(self.source)
        folder = bpy.data.collections.new("Halflight export")
        self.collections[None] = folder
        self.scene.collection.children.link(folder)
        shown = rendered_objects(self.view_layer)
        for item in shown:
            self.copy_of(item)
        for item in shown:
            self.with_parents(item, folder)
        if self.source.camera in self.copies:
            self.scene.camera = self.copies[self.source.camera]

    def with_parents(self, item, folder):
        """Links the copy and those of its parents. Parents that do not render keep their place alone."""
        copy = self.copies[item]
        copy.hide_render = False
        if copy.name not in folder.objects:
            folder.objects.link(copy)
        parent = item.parent
        while parent is not None:
            if self.copies[parent].hide_render:
                self.copies[parent].hide_render = False
                self.copies[parent][BARE] = 1
                folder.objects.link(self.copies[parent])
            parent = parent.parent
        self.copies[item].pop(BARE, None)

    def copy_of(self, item):
        """Not linked anywhere, and off in renders, until with_parents()."""
        if item in self.copies:
            return self.copies[item]
        copy = item.copy()
        self.copies[item] = copy
        copy[SOURCE] = item.name
        copy.hide_render = True
        copy.hide_viewport = False
        if getattr(item.data, "is_editmode", False):
            copy.data = self.out_of_edit_mode(item.data)
        for modifier in copy.modifiers:
            self.as_in_renders(modifier)
        if item.type in {"CURVE", "SURFACE", "FONT", "META"}:
            self.set_render_resolution(copy)
        if item.parent is not None:
            inverse = item.matrix_parent_inverse.copy()
            copy.parent = self.copy_of(item.parent)
            copy.matrix_parent_inverse = inverse
        self.set_visibility(copy, item)
        self.set_light_group(copy, item)
        self.set_materials(copy)
        if item.instance_type == "COLLECTION" and item.instance_collection is not None:
            copy.instance_collection = self.collection_of(item.instance_collection)
        return copy

    def out_of_edit_mode(self, data):
        """Data in edit mode has no arrays that the exporter could read."""
        if data not in self.edited:
            self.edited[data] = self.own_copy(data)
        return self.edited[data]

    def own_copy(self, data):
        copy = data.copy()
        if SOURCE not in copy:
            copy[SOURCE] = data.name
        self.data.append(copy)
        return copy

    def collection_of(self, collection):
        if collection not in self.collections:
            folder = bpy.data.collections.new(collection.name)
            folder.instance_offset = collection.instance_offset
            self.collections[collection] = folder
            items = rendered_in(collection)
            for item in items:
                self.copy_of(item)
            for item in items:
                self.with_parents(item, folder)
        return self.collections[collection]

    def as_in_renders(self, modifier):
        """Settings of renders, and copies in place of the objects that it names."""
        modifier.show_viewport = modifier.show_render
        if modifier.type in RENDER_LEVELS:
            shown, rendered = RENDER_LEVELS[modifier.type]
            setattr(modifier, shown, getattr(modifier, rendered))
        for member in modifier.bl_rna.properties:
            if member.type != "POINTER" or member.fixed_type.identifier != "Object" or member.is_readonly:
                continue
            other = getattr(modifier, member.identifier)
            if other is not None:
                setattr(modifier, member.identifier, self.copy_of(other))

    def set_render_resolution(self, copy):
        rendered = getattr(copy.data, "render_resolution_u", 0) or getattr(copy.data, "render_resolution", 0)
        if not rendered:
            return
        copy.data = copy.data.copy()
        self.data.append(copy.data)
        if copy.type == "META":
            copy.data.resolution = rendered
            return
        copy.data.resolution_u = rendered
        copy.data.resolution_v = copy.data.render_resolution_v or copy.data.resolution_v
        for spline in getattr(copy.data, "splines", ()):
            spline.resolution_u = rendered
            spline.resolution_v = copy.data.render_resolution_v or spline.resolution_v

    def set_visibility(self, copy, item):
        if is_unseen(item, self.view_layer):
            copy["halflight_lightmap_scale"] = 0.0
        if not getattr(item, "visible_shadow", True) and "halflight_cast_shadows" not in copy:
            copy["halflight_cast_shadows"] = 0

    def set_light_group(self, copy, item):
        """Objects without a light group take that of their collection, or of the next one above it that has one."""
        instanced = [item.instance_collection] if item.instance_type == "COLLECTION" and item.instance_collection else []
        if copy.get("halflight_group") or item.parent is not None:  # a parent's group holds for its children
            return
        for collection in [*instanced, *item.users_collection]:
            while collection is not None and not collection.get("halflight_group"):
                collection = self.parents.get(collection)
            if collection is not None:
                copy["halflight_group"] = collection["halflight_group"]
                return

    def set_materials(self, copy):
        """In the data, as exporters take those of modified objects from there. Copies of one mesh share it still."""
        own = [slot.material for slot in copy.material_slots]
        replaced = [self.surfaces.replacement(material) if material else None for material in own]
        if not any(replaced):
            return
        materials = [new or material for new, material in zip(replaced, own)]
        key = (copy.data.name_full, tuple(material and material.name_full for material in materials))
        if key not in self.surfaced:
            self.surfaced[key] = self.own_copy(copy.data)
        use_data(copy, self.surfaced[key], materials)

    def remove(self):
        made = [*self.copies.values(), *self.collections.values(), *self.data, *self.surfaces.made(), *self.pictures]
        if self.scene is not None:
            made.append(self.scene)
        bpy.data.batch_remove(made)


def use_data(item, data, materials):
    """Gives an object this data with these materials."""
    item.data = data
    for index, (slot, material) in enumerate(zip(item.material_slots, materials)):
        slot.link = "DATA"
        data.materials[index] = material


def empty_copy_of(scene):
    """A scene with the settings of `scene` and nothing in it. Scene.copy() would count each object's users up for good."""
    copy = bpy.data.scenes.new(scene.name)
    copy_members(scene, copy)
    for key, value in scene.items():
        if not hasattr(value, "keys"):  # groups are settings of add-ons, which copy_members() has copied
            copy[key] = value.to_list() if hasattr(value, "to_list") else value
    copy.use_nodes = False
    copy.render.simplify_subdivision = copy.render.simplify_subdivision_render
    return copy


# Of a scene: what is not a setting of its pictures.
NO_SETTINGS = {"rna_type", "name", "halflight", "tool_settings", "sequence_editor", "rigidbody_world", "node_tree", "ffmpeg"}
NO_SETTINGS |= {"denoiser", "preview_denoiser"}  # whose value is no choice in builds without one
NO_SETTINGS |= {"preview_pause"}  # Cycles redraws the area then, and there may be none


def copy_members(source, target):
    """Numbers, words and data-blocks of a scene and of its groups of settings."""
    for member in source.bl_rna.properties:
        name = member.identifier
        if name in NO_SETTINGS or member.type == "COLLECTION":
            continue
        value = getattr(source, name)
        if member.type == "POINTER" and not isinstance(value, bpy.types.ID):
            if value is not None and getattr(target, name) is not None:
                copy_members(value, getattr(target, name))
        elif not member.is_readonly:
            try:
                setattr(target, name, value)
            except (TypeError, AttributeError, RuntimeError):
                pass  # a choice that the present settings do not offer


def restore_names(document, copy):
    """The originals' names in place of the copies', and nothing of parents that do not render but their place."""
    names = {item.name: original.name for original, item in copy.copies.items()}
    for node in document.json.get("nodes", []):
        extras = node.get("extras", {})
        node["name"] = extras.pop(SOURCE, node.get("name", ""))
        if extras.pop(BARE, None) is not None:
            for key in ("mesh", "camera", "skin"):
                node.pop(key, None)
            node.get("extensions", {}).pop("KHR_lights_punctual", None)
        drop_empty(node, "extras", "extensions")
    for material in document.json.get("materials", []):
        extras = material.get("extras", {})
        material["name"] = extras.pop(SOURCE, material.get("name", ""))
        drop_empty(material, "extras")
    for mesh in document.json.get("meshes", []):
        mesh["name"] = mesh.get("extras", {}).pop(SOURCE, mesh.get("name", ""))
        drop_empty(mesh, "extras")
    for skin in document.json.get("skins", []):
        skin["name"] = names.get(skin.get("name"), skin.get("name", ""))
    document.json["scenes"][document.json.get("scene", 0)]["name"] = copy.source.name


def drop_empty(owner, *keys):
    for key in keys:
        if key in owner and not owner[key]:
            del owner[key]
