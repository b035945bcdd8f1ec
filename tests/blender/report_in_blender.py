# SPDX-License-Identifier: GPL-3.0-or-later
"""Nothing is dropped in silence: the list after a bake, and its wording."""

import os
import sys
import types

import bpy
import numpy as np

sys.path.insert(0, os.path.dirname(__file__))
import panels_check  # noqa: E402
import stage  # noqa: E402
from stage import bake, box, compare, expect, lamp, matte  # noqa: E402

SIZE, BIG = (0.4, 0.4, 0.4), (0.9, 0.9, 0.8)


def linked(name, kind, output=0, **members):
    """A matte material whose base colour comes from a node."""
    material = matte(name)
    tree = material.node_tree
    node = tree.nodes.new(kind)
    for key, value in members.items():
        setattr(node, key, value)
    tree.links.new(node.outputs[output], tree.nodes["Principled BSDF"].inputs["Base Color"])
    return material, node


def add_dropped_things():
    """Returns pairs of words that must stand in one message, and the object that it selects."""
    box("Noisy", SIZE, (-2, 0, 0.2), linked("Noise", "ShaderNodeTexNoise", 1)[0])
    box("Hued", SIZE, (-1.5, 0, 0.2), linked("Hue", "ShaderNodeHueSaturation")[0])
    box("Gone", SIZE, (-1, 0, 0.2), linked("No picture", "ShaderNodeTexImage")[0])
    image = bpy.data.images.new("Lost", 4, 4)
    image.filepath_raw, image.source = stage.path("lost.png"), "FILE"
    box("Lost", SIZE, (-0.5, 0, 0.2), linked("Missing", "ShaderNodeTexImage", image=image)[0])
    packed = bpy.data.images.new("Grid", 4, 4)
    packed.pack()
    material, node = linked("Generated", "ShaderNodeTexImage", image=packed)
    coordinates = material.node_tree.nodes.new("ShaderNodeTexCoord")
    material.node_tree.links.new(coordinates.outputs["Generated"], node.inputs["Vector"])
    box("Unwrapped", SIZE, (0, 0, 0.2), material)
    box("Mixed", SIZE, (-2.5, 0, 0.2), linked("Mix", "ShaderNodeMixRGB", blend_type="ADD")[0])
    rug = box("Rug", SIZE, (0.5, 0, 0.2), matte("Rug"))
    rug.modifiers.new("Hair", "PARTICLE_SYSTEM")
    rug.particle_systems[0].settings.type = "HAIR"
    rug.particle_systems[0].settings.count = 5
    box("Sprayed", SIZE, (2, 0, 0.2), matte("Spray")).modifiers.new("Drops", "PARTICLE_SYSTEM")
    if bpy.app.version >= (4, 0, 0):
        chosen = box("Chosen", SIZE, (2.5, 0, 0.2), matte("Chosen"))
        chosen.light_linking.receiver_collection = bpy.data.collections.new("Lit")
    foggy = matte("Fog")
    scatter = foggy.node_tree.nodes.new("ShaderNodeVolumeScatter")
    foggy.node_tree.links.new(scatter.outputs[0], foggy.node_tree.nodes["Material Output"].inputs["Volume"])
    box("Foggy", SIZE, (1, 0, 0.2), foggy)
    bulb = lamp("POINT", (1, -1, 1.5), 20)
    bulb.data.use_nodes = True
    tree = bulb.data.node_tree
    blackbody = tree.nodes.new("ShaderNodeBlackbody")
    tree.links.new(blackbody.outputs[0], tree.nodes["Emission"].inputs["Color"])
    box("Plain", SIZE, (1.5, 0, 0.2), matte("Plain"))
    linking = [(("light linking",), "Chosen")] if bpy.app.version >= (4, 0, 0) else []
    return (
        *linking,
        (("Mix", "Base Color"), "Mixed"),
        (("its particles",), "Sprayed"),
        (("Noise", "Base Color"), "Noisy"),
        (("Hue", "Base Color"), "Hued"),
        (("No picture", "has no picture"), "Gone"),
        (("Lost", "missing", "lost.png"), "Lost"),
        (("Generated", "coordinates"), "Unwrapped"),
        (("hair",), "Rug"),
        (("Fog", "volume"), "Foggy"),
        (("Blackbody", "Color"), "Point"),
    )


def check_list(extension):
    """One row for each thing, which selects its object; nothing about what is baked."""
    scene = stage.empty()
    scene.halflight.show_view = False
    dropped = add_dropped_things()
    bake("dropped")
    listed = bpy.context.window_manager.halflight_messages
    for words, item in dropped:
        rows = [i for i, row in enumerate(listed) if all(word in row.text for word in words)]
        expect(len(rows) == 1, f"one row about {words}: {[row.text for row in listed]}")
        bpy.ops.halflight.message(index=rows[0])
        selected = [each.name for each in bpy.context.selected_objects]
        expect(selected == [item], f"a click on {words} selects {selected}")
    plain = [row.text for row in listed if "Plain" in row.text or "Floor" in row.text or "KHR_" in row.text]
    expect(not plain, f"what is baked gives no row: {plain}")
    expect(not [row.text for row in listed if "--" in row.text], "no command-line options")


def nodes_of(material):
    tree = material.node_tree
    return tree, tree.nodes, tree.nodes["Principled BSDF"].inputs


def add_curable_things():
    """A material for each channel whose nodes glTF lacks, and one of mixed shaders."""
    noise = linked("Noise", "ShaderNodeTexNoise", 1)[0]
    noise.node_tree.nodes["Noise Texture"].inputs["Scale"].default_value = 2.0
    first = box("Noisy", BIG, (-2.1, 0, 0.4), noise)
    twin = bpy.data.objects.new("Twin", first.data)  # shares the pictures
    twin.location = (-2.1, -1.3, 0.4)
    twin.scale = (0.4, 0.4, 0.4)
    bpy.context.scene.collection.objects.link(twin)
    mixed = matte("Mixed", (0.7, 0.1, 0.1))
    tree, nodes, _ = nodes_of(mixed)
    other, mix, checker = (nodes.new("ShaderNode" + kind) for kind in ("BsdfDiffuse", "MixShader", "TexChecker"))
    other.inputs["Color"].default_value, checker.inputs["Scale"].default_value = (0.1, 0.2, 0.8, 1.0), 3.0
    tree.links.new(checker.outputs["Fac"], mix.inputs[0])
    tree.links.new(nodes["Principled BSDF"].outputs[0], mix.inputs[1])
    tree.links.new(other.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], nodes["Material Output"].inputs["Surface"])
    subdivided = box("Mixed", BIG, (-0.7, 0, 0.4), mixed)
    subdivided.modifiers.new("Bevel", "BEVEL").width = 0.05
    glowing = matte("Glowing", (0.0, 0.0, 0.0))
    tree, nodes, inputs = nodes_of(glowing)
    wave = nodes.new("ShaderNodeTexWave")
    wave.inputs["Scale"].default_value = 2.0
    tree.links.new(wave.outputs["Color"], inputs["Emission Color" if "Emission Color" in inputs else "Emission"])
    inputs["Emission Strength"].default_value = 3.0
    box("Glowing", BIG, (0.7, 0, 0.4), glowing)
    worn = matte("Worn")
    tree, nodes, inputs = nodes_of(worn)
    checker = nodes.new("ShaderNodeTexChecker")
    for name in ("Metallic", "Roughness"):
        tree.links.new(checker.outputs["Fac"], inputs[name])
    box("Worn", SIZE, (0.7, -1.3, 0.2), worn)
    holes = matte("Holes", (0.3, 0.7, 0.3))
    tree, nodes, inputs = nodes_of(holes)
    checker = nodes.new("ShaderNodeTexChecker")
    checker.inputs["Scale"].default_value = 4.0
    tree.links.new(checker.outputs["Fac"], inputs["Alpha"])
    bpy.ops.mesh.primitive_plane_add(size=1.0, location=(2.1, -0.3, 0.6), rotation=(1.4, 0, 0))
    bpy.context.object.name = "Holes"
    bpy.context.object.data.materials.append(holes)
    return first, twin


def surface_picture(extension, scene, name):
    """Metallic and roughness of a material's picture in the exported file."""
    document = extension.glb.Glb(extension.files.of(scene).scene)
    json = document.json
    surface = next(item for item in json["materials"] if item["name"] == name)["pbrMetallicRoughness"]
    image = json["images"][json["textures"][surface["metallicRoughnessTexture"]["index"]]["source"]]
    with open(stage.path("surface.png"), "wb") as file:
        file.write(document.view_bytes(image["bufferView"]))
    picture = bpy.data.images.load(stage.path("surface.png"))
    picture.colorspace_settings.name = "Non-Color"
    pixels = np.array(picture.pixels[:]).reshape(-1, 4)
    bpy.data.images.remove(picture)
    return pixels[:, 2], pixels[:, 1]


def check_cure(extension):
    """Bake Materials: the view shows what Cycles does, the rows are gone, and nothing of the user's is changed."""
    scene = stage.empty()
    scene.world.node_tree.nodes["Background"].inputs[0].default_value = (0.4, 0.4, 0.4, 1)
    add_curable_things()
    bake("curable")
    bpy.ops.halflight.baked_view()
    rows = [row.text for row in bpy.context.window_manager.halflight_messages if row.is_curable]
    expect({"Noise", "Mixed", "Glowing", "Worn", "Holes"} <= {row.split('"')[1] for row in rows}, f"rows with a cure: {rows}")
    count, seconds = extension.export.material_pictures.estimate(scene.objects, 256)
    expect(count == 7 and seconds > 0.0, f"colour of three, roughness of two, emission, alpha: {count}, {seconds:.1f} s")
    layout = panels_check.Layout()
    dialog = extension.material_operator.HALFLIGHT_OT_bake_materials
    members = {"size": 256, "objects": lambda _context: scene.objects}
    members["bl_rna"] = bpy.ops.halflight.bake_materials.get_rna_type()
    dialog.draw(types.SimpleNamespace(layout=layout, **members), bpy.context)
    expect("7 pictures of 256 x 256 texels" in layout.shown[-1] and layout.shown[0] == "size", f"shown first: {layout.shown}")
    kinds = ("objects", "meshes", "materials", "images", "scenes", "collections")

    def names():
        return {kind: sorted(item.name for item in getattr(bpy.data, kind) if item.name != "Render Result") for kind in kinds}

    before = names()
    nodes = {material.name: len(material.node_tree.nodes) for material in bpy.data.materials}
    expect(bpy.ops.halflight.bake_materials(size=256) == {"FINISHED"}, "materials are baked")
    rows = [row.text for row in bpy.context.window_manager.halflight_messages if row.is_curable]
    expect(not rows, f"no row is left: {rows}")
    metallic, roughness = surface_picture(extension, scene, "Worn")
    expect(np.abs(metallic - roughness).max() < 0.01, "one node made both")
    ends = [float((np.abs(metallic - end) < 0.02).mean()) for end in (0.0, 1.0)]
    expect(min(ends) > 0.2 and sum(ends) > 0.9, f"a checker's picture is black and white: {ends}")
    compare(extension, "pictures", "Noisy", "Twin", "Mixed", "Glowing", "Holes", "Floor")
    trees = [bpy.data.objects[name].data.materials[0].node_tree for name in ("Baked Noisy", "Baked Twin")]
    images = {node.image for tree in trees for node in tree.nodes if node.bl_idname == "ShaderNodeTexImage"}
    images = {image for image in images if "color" in image.name}
    expect(len(images) == 1, f"objects that share a mesh share the pictures: {images}")
    bpy.ops.halflight.baked_view()
    expect(names() == before, f"data-blocks: {names()}; before: {before}")
    expect({m.name: len(m.node_tree.nodes) for m in bpy.data.materials} == nodes, "the user's materials are as they were")
    scene.halflight.show_view = False
    noisy = scene.objects["Noisy"]
    noisy.hide_select = True
    bpy.context.view_layer.objects.active = scene.objects["Mixed"]
    scene.objects["Mixed"].select_set(True)
    bpy.ops.object.mode_set(mode="EDIT")
    expect(bpy.ops.halflight.bake() == {"FINISHED"}, "also while one object is edited, and another cannot be selected")
    expect(bpy.context.object.mode == "EDIT" and noisy.hide_select, "which stays so")
    bpy.ops.object.mode_set(mode="OBJECT")


def check_wording(extension):
    """Options of the program have the panel's names."""
    settings = bpy.context.scene.halflight.bl_rna.properties
    labels = {each.identifier.replace("_", "-"): each.name for each in settings}
    words = extension.wording
    said = words.in_blender("too few; --probe-spacing makes all probes denser", labels)
    expect(said == "too few; *Probe Spacing* makes all probes denser", said)
    said = words.in_blender("try others (--uv, --padding, --texels-per-meter)", labels)
    expect("--" not in said and "*Texels per Meter*" in said, said)
    ignored = 'kept in the file but not read, as baked light does not need them: "KHR_materials_ior"'
    for text in (ignored, "1 normal-mapped primitives got generated tangents"):
        said = words.in_blender(text, labels)
        expect(said is None, f"nobody in Blender can act on it: {said}")
    said = words.in_blender("free it; or bake with --mask-layers auto", labels)
    expect(said == "free it", f"the view reads one mask layer: {said}")
    message = extension.messages.HALFLIGHT_OT_message
    listed = bpy.context.window_manager.halflight_messages
    long = listed.add()
    long.severity, long.text = "WARNING", "one sentence of many words " * 8
    tooltip = message.description(bpy.context, types.SimpleNamespace(index=len(listed) - 1))
    expect(tooltip == long.text, f"the tooltip is the whole sentence: {tooltip}")
    bpy.ops.halflight.message(index=len(listed) - 1)
    layout = panels_check.Layout()
    preferences = types.SimpleNamespace(system=types.SimpleNamespace(ui_scale=1.0))  # headless, Blender says 0
    members = {"window_manager": bpy.context.window_manager, "preferences": preferences}
    extension.panels.draw_message(layout, types.SimpleNamespace(**members))
    shown = " ".join(layout.shown)
    expect(shown == long.text.strip() and max(map(len, layout.shown)) < 40, f"and the panel wraps it: {layout.shown}")
    lines = words.wrapped("a sentence of several words that is long", 12)
    expect(max(len(line) for line in lines) <= 12 and " ".join(lines).endswith("is long"), f"{lines}")


stage.run(check_list, check_cure, check_wording)
