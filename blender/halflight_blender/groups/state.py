# SPDX-License-Identifier: GPL-3.0-or-later
"""A slider and a colour for each light group of the last bake, in the settings of the user's scene.

A group has one state, its weight: brightness times colour. Lamps, emission and world of the scene are their white light times
the weight, so that the scene is drawn, exported and baked again as the baked view shows it. Where they are changed by hand and
all by one factor, the weight follows instead. A group that has a member which cannot be set (it is animated by itself, linked
from a library, or also in another group) changes in the baked view alone.
"""

import contextlib

import bpy
from bpy.app.handlers import persistent

from .. import baked_view
from ..export import export_scene, lamps
from . import animation, members

quiet = []  # not empty while values are set that nothing follows


@contextlib.contextmanager
def quietly():
    quiet.append(1)
    try:
        yield
    finally:
        quiet.pop()


def slider_moved(entry, _context):
    if not quiet:
        apply(entry.id_data)


class GroupMember(bpy.types.PropertyGroup):
    """A lamp, material or world, and its light at the weight 1."""

    item: bpy.props.PointerProperty(type=bpy.types.ID)
    white: bpy.props.FloatVectorProperty(size=3)


class LightGroup(bpy.types.PropertyGroup):
    """A group of the last bake, whose name is that of the group."""

    brightness: bpy.props.FloatProperty(
        name="Brightness",
        description="Of the group's baked light, its lamps and glowing materials. 1: as bright as they are; 0: off",
        default=1.0,
        min=0.0,
        soft_max=2.0,
        update=slider_moved,
    )
    color: bpy.props.FloatVectorProperty(
        name="Colour",
        description="Of the group's light",
        size=3,
        default=(1.0, 1.0, 1.0),
        min=0.0,
        max=1.0,
        subtype="COLOR",
        update=slider_moved,
    )
    is_baked: bpy.props.BoolProperty(options={"HIDDEN"})  # else its keyframes wait for a bake that has it again
    saved: bpy.props.FloatVectorProperty(size=3, options={"HIDDEN"})  # weight in the last file
    unit: bpy.props.FloatVectorProperty(size=3, default=(1.0, 1.0, 1.0), options={"HIDDEN"})  # weight in the file for 1 here
    members: bpy.props.CollectionProperty(type=GroupMember, options={"HIDDEN"})

    def weight(self):
        return [self.brightness * c for c in self.color]

    def weight_in_file(self):
        return [a * b for a, b in zip(self.weight(), self.unit)]

    def set_weight(self, weight):
        """The colour of a group that is off stays."""
        with quietly():
            self.brightness = max(weight)
            if max(weight) > 0.0:
                self.color = [c / max(weight) for c in weight]


def groups_of(scene):
    """Those of the last bake, of the user's scene."""
    return [entry for entry in baked_view.source_of(scene).halflight.light_groups if entry.is_baked]


# -- after a bake -----------------------------------------------------------------------------------------------------


def sync(scene, bindings, document):
    """Takes over the groups of a bake. `bindings`: bake.json; `document`: the baked file. Sliders that are there already keep
    their places, and with them their keyframes keep their meaning."""
    listed = scene.halflight.light_groups
    found = members_of(scene, bindings, document)
    known = {entry.name for entry in groups_of(scene)}
    for entry in listed:
        entry.is_baked = False
    for record in bindings.get("groups", []):
        entry = next((entry for entry in listed if entry.name == record["name"]), None) or listed.add()
        entry.name = record["name"]
        items = found[entry.name]
        if entry.name not in known:  # a sky's parts are radiances, in Blender's numbers here
            entry.unit = [export_scene.lumens_per_watt(scene.halflight.units) if entry.name.startswith("sky.") else 1.0] * 3
        take_weight(entry, record["weight"], entry.name not in known, bool(items))
        note_members(scene, entry, items)
    if not animation.is_animated(scene):  # else the places of the others in the list are those of their keyframes
        for index in reversed(range(len(listed))):
            if not listed[index].is_baked:
                listed.remove(index)


def take_weight(entry, saved, is_new, has_members):
    entry.is_baked = True
    if has_members and not is_new:  # the lamps were baked at the slider's weight
        entry.unit = [s / max(w, members.LEAST) if s > 0.0 else u for s, w, u in zip(saved, entry.weight(), entry.unit)]
    elif is_new or list(saved) != list(entry.saved):
        entry.set_weight([s / u for s, u in zip(saved, entry.unit)])
    entry.saved = saved


def note_members(scene, entry, items):
    before = {member.item: tuple(member.white) for member in entry.members}
    entry.members.clear()
    for item in items:
        member = entry.members.add()
        member.item, member.white = item, white_of(scene, item, entry.weight())
        light = members.with_weight(before.get(item, member.white), entry.weight())
        if item in before and members.is_near(members.light_of(item), as_set(member, light)):
            member.white = before[item]


def white_of(scene, item, weight):
    """Where the weight is 0, as bright as the brightest channel; what is dark altogether is 1 candela, lux or nit."""
    light = members.light_of(item)
    if members.places_of(item)[0] is None:  # a picture, which sliders make brighter and darker alone
        weight = [max(weight)] * 3
    white = [a / b if b > 0.0 else 0.0 for a, b in zip(light, weight)]
    most = max(white)
    if most == 0.0 and max(weight) == 0.0:
        factor = export_scene.lumens_per_watt(scene.halflight.units)
        most = 1.0 / (lamps.intensity_of(item, factor) if isinstance(item, bpy.types.Light) else factor)
    return [a if b > 0.0 else most for a, b in zip(white, weight)]


def members_of(scene, bindings, document):
    """By name of a group: what its slider sets, or nothing where not all of the group can be set."""
    names = [record["name"] for record in bindings.get("groups", [])]
    groups_of_item, unknown = {}, set()

    def note(item, group):
        """`group`: None of what is in none."""
        if item is not None:
            groups_of_item.setdefault(item, set()).add(group)
        elif group is not None:
            unknown.add(group)

    for record in bindings["lights"]:
        item = bpy.data.objects.get(record["node"])
        group = record.get("baking", {}).get("group", -1)
        note(item.data if item is not None and item.type == "LIGHT" else None, names[group] if group >= 0 else None)
    for record in document.json.get("materials", []):
        if not any(record.get("emissiveFactor", ())):
            continue
        group = record.get("extensions", {}).get("HALFLIGHT_material", {}).get("baking", {}).get("group", -1)
        name = record.get("name", "")
        item = bpy.data.materials.get(name) or bpy.data.lights.get(name)  # a lamp of the shape of an ellipse
        note(item, names[group] if group >= 0 else None)
    for record in bindings.get("groups", []):
        if record.get("sky") and not record["name"].startswith("sky."):
            note(scene.world, record["name"])
    found = {name: [] for name in names}
    for item, groups in groups_of_item.items():
        if groups == {None}:
            continue
        if len(groups) == 1 and members.is_free(item):
            found[next(iter(groups))].append(item)
        else:
            unknown |= groups - {None}
    return {name: [] if name in unknown else items for name, items in found.items()}


# -- while sliders and lamps change -----------------------------------------------------------------------------------


def apply(scene):
    """Sets lamps, emission and world of the user's scene, and its baked views, to the weights."""
    for entry in groups_of(scene):
        for member in entry.members:
            if member.item is not None and members.is_free(member.item):
                light = members.with_weight(member.white, entry.weight())
                if not members.is_near(members.light_of(member.item), as_set(member, light)):
                    members.set_light(member.item, light)
    for view in baked_view.views_of(scene):
        baked_view.view_groups.show_weights(view)


def as_set(member, light):
    """What of a light an item can have."""
    return light if members.places_of(member.item)[0] is not None else [max(light)] * 3


def follow(scene):
    """Lamps that were changed by hand take the weight along, or else change what the weight 1 is of them."""
    for entry in groups_of(scene):
        owned = [member for member in entry.members if member.item is not None and members.is_free(member.item)]
        weight, changed = entry.weight(), []
        for member in owned:
            if not members.is_near(members.light_of(member.item), as_set(member, now_of(member, weight))):
                changed.append(member)
        if not changed:
            continue
        factors = [factor_of(member, weight) for member in owned]
        if all(members.is_near(factor, factors[0]) for factor in factors) and not animation.is_animated(scene, entry):
            entry.set_weight(factors[0])
        else:
            for member in changed:
                member.white = [a / max(b, members.LEAST) for a, b in zip(members.light_of(member.item), weight)]
        apply(scene)


def now_of(member, weight):
    """What the member's light is to be: before the slider is moved for the first time, a channel that is off may be 0."""
    light = members.light_of(member.item)
    set_to = members.with_weight(member.white, weight)
    return [0.0 if w == 0.0 and a == 0.0 else b for a, b, w in zip(light, set_to, weight)]


def factor_of(member, weight):
    """Of the member's white light, what it has now."""
    light = members.light_of(member.item)
    factor = [a / b if b > 0.0 else w for a, b, w in zip(light, member.white, weight)]
    return [0.0 if c <= 1.01 * members.LEAST else c for c in factor]


def forget_deleted(scene):
    """A lamp or material that nothing else uses is kept by no group."""
    uses = {}
    for each in bpy.data.scenes:
        for entry in each.halflight.light_groups:
            for member in entry.members:
                if member.item is not None:
                    uses[member.item] = uses.get(member.item, 0) + 1
    for entry in scene.halflight.light_groups:
        for index in reversed(range(len(entry.members))):
            item = entry.members[index].item
            if item is None or item.users - item.use_fake_user <= uses[item]:
                entry.members.remove(index)


@persistent
def after_change(scene, depsgraph):
    if quiet or baked_view.is_view(scene) or not scene.halflight.light_groups:
        return
    kinds = (bpy.types.Light, bpy.types.Material, bpy.types.World, bpy.types.NodeTree)
    if any(isinstance(update.id, kinds) for update in depsgraph.updates):
        with quietly():
            follow(scene)


@persistent
def after_frame(scene, _depsgraph=None):
    """Keyframes have set the sliders of the scene; those of a view's scene are read here."""
    source = baked_view.source_of(scene)
    if not animation.is_animated(source):
        return
    with quietly():
        if source != scene:
            animation.set_to_frame(source, scene.frame_current_final)
        apply(source)


HANDLERS = (("depsgraph_update_post", after_change), ("frame_change_post", after_frame))


def register():
    for name, handler in HANDLERS:
        getattr(bpy.app.handlers, name).insert(0, handler)  # before the view's probes, which read the weights


def unregister():
    for name, handler in HANDLERS:
        getattr(bpy.app.handlers, name).remove(handler)
    for scene in bpy.data.scenes:
        for entry in scene.halflight.light_groups:  # keyframes keep their places in the list
            entry.members.clear()
            entry.is_baked = False
