# SPDX-License-Identifier: GPL-3.0-or-later
"""What the file cannot hold of a scene: a sentence for each thing, with the object that it is about."""

import os

import bpy

from . import lamps, surfaces

# Inputs of the Principled shader that the bake takes from glTF, by any version's name.
SOCKETS = ("Base Color", "Metallic", "Roughness", "Emission", "Emission Color", "Alpha", "Transmission", "Transmission Weight")
LEFT_OUT = {
    "CURVES": "hair curves are",
    "POINTCLOUD": "point clouds are",
    "VOLUME": "volumes are",
    "GPENCIL": "Grease Pencil is",
    "GREASEPENCIL": "Grease Pencil is",
}
CURE = "; Bake Materials makes pictures of it"
READ_SURFACES = {"ShaderNodeBsdfPrincipled", "ShaderNodeEmission", "ShaderNodeBackground", "ShaderNodeGroup"}


def of(objects, has_pictures):
    """Pairs of sentence and object for what renders, each material once. `has_pictures`: whether a material of an object is
    baked to pictures."""
    found, known = [], set()
    for item in objects:
        found += [(f'"{item.name}": {text}', item.name) for text in of_object(item)]
        if item.type == "LIGHT":
            found += [(f'lamp "{item.name}": {text}', item.name) for text in of_lamp(item.data)]
        for slot in item.material_slots:
            material = slot.material
            if material is not None and material not in known:
                known.add(material)
                cured = has_pictures(item, material)
                said = (text for text in of_material(material) if not (cured and text.endswith(CURE)))
                found += [(f'material "{material.name}": {text}', item.name) for text in said]
    return found


def of_object(item):
    if item.type in LEFT_OUT:
        yield f"{LEFT_OUT[item.type]} left out"
    for modifier in item.modifiers:
        if modifier.type == "PARTICLE_SYSTEM" and modifier.show_render:
            settings = modifier.particle_system.settings
            kind = "its hair" if settings.type == "HAIR" else "its particles"
            yield f'{kind} ("{settings.name}") left out; convert to a mesh to bake it'
    linking = getattr(item, "light_linking", None)
    if linking is not None and (linking.receiver_collection or linking.blocker_collection):
        yield "light linking is left out: it lights and shadows every object"


def of_lamp(data):
    if not data.use_nodes or data.node_tree is None:
        return
    node = lamps.emission_node(data)
    if node is None:
        yield "its nodes are left out: colour and power are those of its settings"
        return
    for name in ("Color", "Strength"):
        if node.inputs[name].is_linked:
            source = source_of(node.inputs[name])
            if source.bl_idname != "ShaderNodeLightFalloff":
                yield f"the node {title(source)} at {name} is left out: set the {name.lower()} as a value"


def of_material(material):
    if not material.use_nodes or material.node_tree is None:
        return
    output = material.node_tree.get_output_node("CYCLES")
    if output is not None and output.inputs["Volume"].is_linked:
        yield "its volume is left out"
    if output is not None and output.inputs["Displacement"].is_linked:
        yield "its displacement is left out; a Displace modifier is baked"
    yield from of_nodes(material, False)


def of_nodes(material, only_lost):
    """`only_lost`: nodes alone that pictures could stand for."""
    node = surfaces.surface_node(material)
    if node is None:
        return
    if node.bl_idname not in READ_SURFACES and node.bl_idname not in surfaces.SHADERS:
        yield f"the shader {title(node)} is not in glTF; the first Principled BSDF below it counts{CURE}"
    for socket in node.inputs:
        if socket.is_linked and (socket.name in SOCKETS or socket.name == "Color"):
            for text in of_source(source_of(socket), 8):
                if not only_lost or text.endswith(CURE):
                    yield f"{socket.name}: {text}"


def lost_nodes(material):
    if material is None or not material.use_nodes or material.node_tree is None:
        return []
    return [text for text in of_nodes(material, True)]


def of_source(node, depth):
    """`depth`: of nodes to look through, as groups may go round."""
    kind = node.bl_idname
    if kind == "ShaderNodeTexImage":
        yield from of_picture(node)
    elif kind in {"ShaderNodeVertexColor", "ShaderNodeAttribute", "ShaderNodeValue", "ShaderNodeRGB"}:
        return
    elif depth > 0 and (kind.startswith(("ShaderNodeSeparate", "ShaderNodeSepRGB")) or is_factor(node)):
        for socket in node.inputs:
            if socket.is_linked:
                yield from of_source(source_of(socket), depth - 1)
    else:
        yield f"the node {title(node)} is not in glTF{CURE}"


def is_factor(node):
    """A picture times a plain number or colour, which is a factor in glTF."""
    if node.bl_idname == "ShaderNodeMath":
        return node.operation == "MULTIPLY"
    return node.bl_idname in {"ShaderNodeMixRGB", "ShaderNodeMix"} and node.blend_type == "MULTIPLY"


def of_picture(node):
    image = node.image
    if image is None:
        yield "an Image Texture has no picture"
    elif image.source == "FILE" and not image.packed_file and not os.path.exists(path_of(image)):
        yield f'the picture "{image.name}" is missing: {path_of(image)}'
    if node.projection != "FLAT":
        yield f"the projection {node.projection.title()} of an Image Texture is not in glTF{CURE}"
    vector = node.inputs["Vector"]
    while vector.is_linked:
        source = vector.links[0]
        kind = source.from_node.bl_idname
        if kind == "ShaderNodeMapping" or kind == "NodeReroute":
            vector = source.from_node.inputs[0]
        elif kind == "ShaderNodeUVMap" or (kind == "ShaderNodeTexCoord" and source.from_socket.name == "UV"):
            return
        else:
            yield f"{source.from_socket.name} coordinates are not in glTF: unwrap, and use UV{CURE}"
            return


def path_of(image):
    return bpy.path.abspath(image.filepath, library=image.library)


def source_of(socket):
    """The node that a link comes from, reroutes passed over."""
    node = socket.links[0].from_node
    while node.bl_idname == "NodeReroute" and node.inputs[0].is_linked:
        node = node.inputs[0].links[0].from_node
    return node


def title(node):
    return node.label or node.bl_label
