# SPDX-License-Identifier: GPL-3.0-or-later
"""What one sees is what one made: baked views against Cycles' pictures of the scenes themselves."""

import math
import os
import sys

import bpy
import mathutils
import numpy as np

sys.path.insert(0, os.path.dirname(__file__))
import stage  # noqa: E402
from stage import bake, box, compare, diffuse, expect, lamp, matte  # noqa: E402

CUBE = (0.8, 0.8, 0.8)
# Metres between the probes that light dynamic objects. Preview's automatic layout has a sixth as many in these scenes.
PROBE_SPACING = 0.3


def shown(view, prefix=""):
    return sorted(item.name for item in view.objects if item.type == "MESH" and item.name.startswith(prefix))


def check_what_renders(extension):
    """Excluded, disabled and render-hidden things are not baked. What the camera does not see throws its shadow."""
    stage.empty()
    excluded, disabled = stage.add_collection("Excluded"), stage.add_collection("No camera icon")
    indirect = stage.add_collection("Indirect only")
    box("Wall beside", (0.1, 3, 1.5), (2.8, 0.5, 0.75), matte("Orange", (0.9, 0.4, 0.1)), indirect)
    parent = box("Old box", (2, 2, 2), (1.5, 0, 0.4), matte("Red", (0.8, 0.1, 0.1)), excluded)
    lamp("POINT", (1, -0.5, 1.5), 150, collection=excluded)
    kid = box("Kid", (0.3, 0.3, 0.3), (-0.6, 0, 0.2), matte("Kid"))
    kid.parent = parent
    box("Cutter", CUBE, (0, 0, 0.4), matte("Cutter"), disabled)
    disabled.hide_render = True
    hidden = box("Hidden", CUBE, (0, 1, 0.4), matte("Hidden"))
    hidden.hide_render = True
    moved = box("Off in viewports", (0.5, 0.5, 0.5), (0, 0, 0.3), matte("Moved"))
    bpy.context.view_layer.update()
    moved.hide_viewport = True
    moved.location.x = 2
    held = box("Holdout", (0.4, 0.4, 0.4), (-2, 1, 1.5), matte("Held"))
    held.is_holdout = True
    box("Unseen", (0.4, 0.4, 0.4), (-1.0, 0.5, 1.5), matte("Unseen")).visible_camera = False
    bpy.context.view_layer.layer_collection.children["Excluded"].exclude = True
    bpy.context.view_layer.layer_collection.children["Indirect only"].indirect_only = True
    view = bake("renders")
    expect(shown(view) == ["Baked Floor", "Baked Kid", "Baked Off in viewports"], f"the view shows {shown(view)}")
    middle = np.mean([v.co for v in bpy.data.objects["Baked Off in viewports"].data.vertices], 0)
    expect(abs(middle[0] - 2.0) < 1e-3, f"an object that viewports do not show is where it renders: {middle}")
    middle = np.mean([v.co for v in bpy.data.objects["Baked Kid"].data.vertices], 0)
    expect(np.allclose(middle, kid.matrix_world.translation, atol=1e-3), f"the child of an excluded object: {middle}")
    expect([light.name for light in view.halflight_lights] == ["Sun"], "lamps of excluded collections are out")
    compare(extension, "what renders", "Floor", "Kid")


def check_materials(extension):
    """Surfaces without a Principled shader."""
    scene = stage.empty()
    surfaces = {name: bpy.data.materials.new(name) for name in ("Without nodes", "Nowhere")}
    surfaces["Without nodes"].diffuse_color, surfaces["Without nodes"].metallic = (0.2, 0.6, 0.2, 1.0), 1.0
    surfaces["Nowhere"].use_nodes = True
    surfaces["Nowhere"].node_tree.nodes.clear()
    surfaces["Diffuse"] = stage.diffuse("Diffuse", (0.1, 0.7, 0.1))
    for number, (name, surface) in enumerate(surfaces.items()):
        box(name, (0.6, 0.6, 0.6), (-2 + number, 0, 0.3), surface)
    box("Clay", (0.6, 0.6, 0.6), (1, 0, 0.3))
    slot = box("Empty slot", (0.6, 0.6, 0.6), (2, 0, 0.3))
    slot.data.materials.append(None)
    sheer = matte("Sheer", (0.2, 0.3, 0.8), Alpha=0.5)
    expect(bpy.app.version >= (4, 2, 0) or sheer.blend_method == "OPAQUE", "Cycles does not read the blend mode")
    bpy.ops.mesh.primitive_plane_add(size=0.8, location=(-2, -1.4, 0.5), rotation=(1.4, 0, 0))
    bpy.context.object.name = "Sheer"
    bpy.context.object.data.materials.append(sheer)
    letters = bpy.data.curves.new("Letters", "FONT")
    letters.body, letters.extrude, letters.size = "MM", 0.1, 1.2
    item = bpy.data.objects.new("Letters", letters)
    item.location, item.rotation_euler = (-0.8, 1.0, 0.2), (1.2, 0, 0)
    scene.collection.objects.link(item)
    bpy.context.view_layer.update()
    before = sorted(material.name for material in bpy.data.materials)
    bake("materials")
    own = sorted(m.name for m in bpy.data.materials if extension.baked_view.TAG not in m)
    expect(own == before, f"materials are those of the user: {own}")
    exported = extension.glb.Glb(extension.files.of(scene).scene).json["materials"]
    gloss = {item["name"]: item.get("extensions", {}).get("KHR_materials_specular") for item in exported}
    expect(gloss["Diffuse"] == gloss["Floor"] == {"specularFactor": 0}, f"matte surfaces have no gloss: {gloss}")
    black = stage.region(bpy.context.scene, "Baked Nowhere")
    light = float(stage.picture(bpy.context.scene, "nowhere")[black].mean())
    expect(light < 0.02, f"a shader that leads nowhere is black: {light}")
    compare(extension, "materials", "Floor", "Without nodes", "Diffuse", "Clay", "Empty slot", "Letters", "Sheer")


def check_lamps(extension):
    """Flux of each kind of lamp, with nodes and without a shadow."""
    for shape in ("SQUARE", "DISK", "ELLIPSE"):
        stage.empty(sun=False)
        lamp("AREA", (0, 0, 3), 100, (20, 0, 0), shape=shape, size=0.8, size_y=0.4)
        bake("area")
        compare(extension, f"area light {shape}", "Floor")
    for blend in (0.0, 0.15, 0.5, 1.0):
        stage.empty(sun=False)
        lamp("SPOT", (0, 0, 3), 200, spot_blend=blend, spot_size=math.radians(60), shadow_soft_size=0.02)
        bake("spot")
        expect(not [text for text in stage.messages() if "one" in text and "Spot" in text], "a spot gives no warning")
        compare(extension, f"spot with a blend of {blend}", "Floor")
    stage.empty(sun=False)
    bulb = lamp("POINT", (1, -0.5, 1.5), 40, use_shadow=False)
    if hasattr(bulb.data.cycles, "cast_shadow"):
        bulb.data.cycles.cast_shadow = False
    bulb.data.use_nodes = True
    inputs = bulb.data.node_tree.nodes["Emission"].inputs
    inputs["Strength"].default_value, inputs["Color"].default_value = 3.0, (1.0, 0.5, 0.25, 1.0)
    box("Cube", CUBE, (0.5, 0.2, 0.4), matte("Cube"))
    view = bake("nodes")
    expect([light.shadow for light in view.halflight_lights] == ["none"], "a lamp without shadow has no mask")
    compare(extension, "lamp with nodes, without shadow", "Floor", "Cube")


def check_shapes(extension):
    """Modifiers, vertex colours, posed bones, instances and flattened objects."""
    scene = stage.empty()
    round_ = box("Round", CUBE, (-1.8, 0, 0.4), matte("Round"))
    modifier = round_.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels, modifier.render_levels = 0, 3
    hidden = round_.modifiers.new("Viewport only", "SOLIDIFY")
    hidden.thickness, hidden.show_render = 0.01, False
    masked = box("Masked", CUBE, (-0.6, 0, 0.4), matte("Masked"))
    colors = masked.data.color_attributes.new("Mask", "BYTE_COLOR", "CORNER")
    for item in colors.data:
        item.color = (0.1, 0.1, 0.1, 1.0)
    painted = box("Painted", CUBE, (0.6, 0, 0.4), matte("Painted"))
    colors = painted.data.color_attributes.new("Paint", "FLOAT_COLOR", "POINT")
    for item in colors.data:
        item.color = (0.2, 0.5, 0.3, 1.0)
    tree = painted.data.materials[0].node_tree
    node = tree.nodes.new("ShaderNodeVertexColor")
    node.layer_name = "Paint"
    tree.links.new(node.outputs["Color"], tree.nodes["Principled BSDF"].inputs["Base Color"])
    collection = bpy.data.collections.new("Stones")
    collection.instance_offset = (1, 0, 0)
    stone = box("Stone", (0.3, 0.3, 0.3), (1, 0, 0.2), matte("Stone"), collection)
    stone.modifiers.new("Subdivision", "SUBSURF").levels = 0
    instance = bpy.data.objects.new("Stones", None)
    instance.instance_type, instance.instance_collection = "COLLECTION", collection
    instance.location = (-1.8, -1.2, 0)
    scene.collection.objects.link(instance)
    kid, pose = add_posed()
    bake("shapes")
    faces = len(bpy.data.objects["Baked Round"].data.polygons)
    expect(faces == 6 * 4**3 * 2, f"subdivision as in renders: {faces} triangles")
    expect((modifier.levels, hidden.show_viewport) == (0, True), "the user's modifiers are as they were")
    middle = np.mean([v.co for v in bpy.data.objects["Baked Kid"].data.vertices], 0)
    expect(np.allclose(middle, kid.matrix_world.translation, atol=1e-3), f"the child of a posed bone: {middle}")
    middle = np.mean([v.co for v in bpy.data.objects["Baked Stone"].data.vertices], 0)
    expect(np.allclose(middle, (-1.8, -1.2, 0.2), atol=1e-2), f"the instance of a collection: {middle}")
    compare(extension, "shapes", "Floor", "Round", "Masked", "Painted", "Kid")


def check_flat(_extension):
    """A scale of 0 does not end the view. Cycles draws such objects black, so there is nothing to compare with."""
    stage.empty()
    box("Flat", (1, 1, 0), (0, 0, 0.2), matte("Flat"))
    expect("Baked Flat" in shown(bake("flat")), "a flattened object is in the view")


def check_sheets(extension):
    """Sheets with texels on both sides, seen from either side: one lies on the floor, one stands on its edge in the sun."""
    stage.empty()
    for name, location, turn in (("Rug", (-1, 0, 0.01), 0), ("Lit", (0.6, 0, 0.7), 90), ("Shaded", (2, 0, 0.7), -90)):
        bpy.ops.mesh.primitive_plane_add(size=1.2, location=location, rotation=(math.radians(turn), 0, 0))
        bpy.context.object.name = name
        bpy.context.object.data.materials.append(matte(name, (0.7, 0.3, 0.3)))
    bake("sheets")
    compare(extension, "sheets", "Rug", "Lit", "Shaded")


def add_posed():
    """A box below a bone that is posed and not animated."""
    scene = bpy.context.scene
    armature = bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig"))
    scene.collection.objects.link(armature)
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    bone = armature.data.edit_bones.new("Arm")
    bone.head, bone.tail = (0, 0, 0), (0, 0, 1)
    bpy.ops.object.mode_set(mode="OBJECT")
    kid = box("Kid", (0.4, 0.4, 0.4), (1.8, 0, 0.5), matte("Kid"))
    kid.parent, kid.parent_type, kid.parent_bone = armature, "BONE", "Arm"
    bpy.context.view_layer.update()
    pose = armature.pose.bones["Arm"]
    kid.matrix_parent_inverse = (armature.matrix_world @ pose.matrix @ mathutils.Matrix.Translation((0, 1, 0))).inverted()
    pose.rotation_mode, pose.rotation_euler = "XYZ", (0.2, 0.3, 0.1)
    bpy.context.view_layer.update()
    return kid, pose


def check_glass(extension):
    """A wall and a dynamic object seen through panes, clear and tinted. In Cycles no light shines through glass, so these
    stop none. An index of refraction of 1 mirrors nothing; the view does not show what glass mirrors."""
    for name, color in (("Clear", (1, 1, 1)), ("Tinted", (0.2, 0.5, 0.3))):
        stage.empty()
        box("Wall", (6, 0.1, 2.4), (0, 1.5, 1.2), matte("Wall"))
        moving = box("Moving", (0.9, 0.5, 0.5), (0, 0.9, 0.7), matte("Moving", (0.8, 0.2, 0.2)))
        moving.halflight_static = "DYNAMIC"
        pane = box(name, (2.0, 0.02, 1.2), (0, 0, 0.7), matte(name, color, Transmission=1.0, Roughness=0.0, IOR=1.0))
        for item in (pane, moving):  # the view has no shadows of dynamic objects
            item.visible_shadow = item.visible_diffuse = False
        bake("glass")
        compare(extension, f"glass {name}", name)


def check_colored_masks(extension):
    """Behind coloured glass a light's mask has a colour: the floor has each channel's share of the sun."""
    scene = stage.empty(sun=False)
    sun = {"name": "sun", "type": "directional", "color": [1.0, 1.0, 1.0], "group": -1, "axis": [0, 0, -1], "corners": None}
    sun |= {"strength": 1.0, "channel": 0, "colored": True, "reach": 0.0}
    material = bpy.data.materials.new("Lit")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    light, shader, output = (tree.nodes.new("ShaderNode" + kind) for kind in ("Group", "Emission", "OutputMaterial"))
    light.node_tree = extension.view.view_lights.make_group([sun], None, None)
    mask = (0.2, 0.5, 0.9)
    light.inputs["Mask"].default_value, light.inputs["Alpha"].default_value = (*mask, 1), 1.0
    tree.links.new(light.outputs["Irradiance"], shader.inputs["Color"])
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    floor = scene.objects["Floor"]
    floor.data.materials[0] = material
    seen = np.median(stage.picture(scene, "colored_masks")[stage.region(scene, "Floor")])
    expect(abs(seen - np.dot((0.2126, 0.7152, 0.0722), mask)) < 0.005, f"coloured mask: luminance {seen}")


def add_ball(name, location, surface):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12, radius=0.35, location=location)
    ball = bpy.context.object
    ball.name, ball.halflight_static = name, "DYNAMIC"
    ball.data.materials.append(surface)
    bpy.ops.object.shade_smooth()
    return ball


def check_moving(extension):
    """Dynamic objects have the probes' light of the place where they are: in the sun, in a shadow, and where they are moved."""
    scene = stage.empty()
    scene.world.node_tree.nodes["Background"].inputs[0].default_value = (0.3, 0.4, 0.5, 1)
    box("Wall", (3, 0.2, 2.4), (-1.5, 0.4, 1.2), diffuse("Wall", (0.8, 0.3, 0.2)))
    box("Roof", (3, 2.2, 0.1), (-1.5, 1.4, 2.4), diffuse("Roof"))
    ball = add_ball("Ball", (1.4, 0.2, 0.8), diffuse("Ball", (0.3, 0.6, 0.8)))
    dark = add_ball("Dark", (-1.5, -0.9, 0.6), diffuse("Dark"))
    kid = box("Kid", (0.4, 0.4, 0.4), (0, 0, 0.9), diffuse("Kid"))
    kid.parent = ball
    stones = bpy.data.collections.new("Stones")
    box("Stone", (0.4, 0.4, 0.4), (5, 0, 0), diffuse("Stone", (0.7, 0.6, 0.2)), stones)
    instance = bpy.data.objects.new("Stones", None)
    instance.instance_type, instance.instance_collection = "COLLECTION", stones
    instance.halflight_static = "DYNAMIC"
    instance.location = (-2.6, -1.5, 0.8)
    stones.instance_offset = (5, 0, 0)
    scene.collection.objects.link(instance)
    scene.halflight.probe_spacing = PROBE_SPACING
    view = bake("moving")
    names = sorted(item.name for item in view.objects if item.name.endswith("(baked)"))
    expect(names == ["Ball (baked)", "Dark (baked)", "Kid (baked)", "Stones (baked)"], f"dynamic objects of the view: {names}")
    compare(extension, "in the sun", "Ball", "Dark", "Kid", "Stone")
    copy = view.objects["Ball (baked)"]
    copy.location = (-1.8, 1.2, 0.8)
    bpy.context.view_layer.update()
    light = list(copy["halflight_probe_light_0"])
    twin = view.objects["Kid (baked)"].copy()  # as Shift-D does
    view.collection.objects.link(twin)
    bpy.ops.halflight.baked_view()
    mine = next((item for item in scene.objects if item.name.startswith("Kid.")), None)
    expect(mine == twin and mine.parent == ball, f"what is duplicated in the view stays: {scene.objects.keys()}")
    expect(mine.material_slots[0].material == kid.data.materials[0], "with the user's material")
    bpy.data.objects.remove(mine)
    place = tuple(round(v, 4) for v in ball.location)
    expect(place == (-1.8, 1.2, 0.8), f"what is moved in the view stays there: {place}")
    bpy.ops.halflight.baked_view()
    again = list(bpy.context.scene.objects["Ball (baked)"]["halflight_probe_light_0"])
    expect(again == light, "its light was that of the place")
    scene.camera.location, scene.camera.rotation_euler = (-1.8, 5.5, 2.0), (math.radians(75), 0, math.radians(180))
    compare(extension, "in the shadow", "Ball")


def check_renamed(extension):
    """An object that got another name after the bake is shown once."""
    scene = stage.empty()
    cube = box("Cube", CUBE, (0, 0, 0.4), matte("Cube"))
    bake("renamed")
    bpy.ops.halflight.baked_view()
    cube.name = "Crate"
    box("Cube", (0.3, 0.3, 0.3), (1.5, 0, 0.3), matte("New"))
    bpy.ops.halflight.baked_view()
    names = shown(bpy.context.scene)
    expect(names == ["Baked Cube", "Baked Floor", "Cube (baked)"], f"renamed: {names}")
    bpy.ops.halflight.baked_view()
    expect(bpy.context.scene == scene and not extension.baked_view.is_view(scene), "the view is left")


CHECKS = (check_what_renders, check_materials, check_lamps, check_shapes, check_sheets, check_flat)
stage.run(*CHECKS, check_glass, check_colored_masks, check_moving, check_renamed)
