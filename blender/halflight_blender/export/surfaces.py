# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces as Cycles draws them, for an exporter that reads the Principled shader alone.

A material whose surface is another shader gets a replacement for the export. The user's material is not changed.
"""

import bpy

GREY = (0.8, 0.8, 0.8)  # of a surface without a material
NAMES = {"Specular": ("Specular", "Specular IOR Level"), "Transmission": ("Transmission", "Transmission Weight")}
NAMES["Emission"] = ("Emission", "Emission Color")
# Shader: where its colour goes, and what else the Principled shader is set to.
MATTE = {"Metallic": 0.0, "Roughness": 1.0, "Specular": 0.0}
SHADERS = {
    "ShaderNodeBsdfDiffuse": ("Base Color", MATTE),
    "ShaderNodeBsdfGlossy": ("Base Color", {"Metallic": 1.0}),
    "ShaderNodeBsdfAnisotropic": ("Base Color", {"Metallic": 1.0}),
    "ShaderNodeBsdfMetallic": ("Base Color", {"Metallic": 1.0}),
    "ShaderNodeBsdfGlass": ("Base Color", {"Transmission": 1.0, "Metallic": 0.0}),
    "ShaderNodeBsdfRefraction": ("Base Color", {"Transmission": 1.0, "Metallic": 0.0}),
    "ShaderNodeBsdfTranslucent": ("Base Color", MATTE),
    "ShaderNodeBsdfToon": ("Base Color", MATTE),
    "ShaderNodeBsdfVelvet": ("Base Color", MATTE),
    "ShaderNodeBsdfSheen": ("Base Color", MATTE),
    "ShaderNodeSubsurfaceScattering": ("Base Color", MATTE),
}


def surface_node(material):
    """The shader that Cycles draws; None where there is none."""
    if material.node_tree is None:
        return None
    output = material.node_tree.get_output_node("CYCLES")
    if output is None or not output.inputs["Surface"].is_linked:
        return None
    node = output.inputs["Surface"].links[0].from_node
    while node.bl_idname == "NodeReroute" and node.inputs[0].is_linked:
        node = node.inputs[0].links[0].from_node
    return node


class Surfaces:
    def __init__(self):
        self.known = {}

    def replacement(self, material):
        """A material for the exporter, or None where it reads the material itself."""
        if material not in self.known:
            self.known[material] = replacement_of(material)
        return self.known[material]

    def made(self):
        return [material for material in self.known.values() if material is not None]


def replacement_of(material):
    node = surface_node(material) if material.use_nodes else None
    if node is not None and node.bl_idname not in SHADERS:
        return with_alpha(material, node)
    copy = copy_of(material)
    copy.use_nodes = True
    tree = copy.node_tree
    if not material.use_nodes:
        tree.nodes.clear()
    shader = tree.nodes.new("ShaderNodeBsdfPrincipled")
    if node is None:
        # Without nodes it is matte, in the colour of its settings; with nodes that lead nowhere it is black.
        color = (0.0, 0.0, 0.0) if material.use_nodes else material.diffuse_color[:3]
        put(shader, "Base Color", (*color, 1.0))
        members = MATTE
    else:
        old = surface_node(copy)
        color, members = SHADERS[node.bl_idname]
        move(tree, old, "Color" if "Color" in old.inputs else "Base Color", shader, color)
        for name in ("Roughness", "Normal"):
            if name in old.inputs and name not in members:
                move(tree, old, name, shader, name)
    for name, value in members.items():
        put(shader, name, value)
    output = tree.get_output_node("CYCLES") or tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return copy


def copy_of(material):
    copy = material.copy()
    copy["halflight_copy_of"] = material.name
    return copy


def with_alpha(material, node):
    """Cycles has a shader's alpha whatever the blend mode is. The exporter before Blender 4.2 has it by that mode alone."""
    if node.bl_idname != "ShaderNodeBsdfPrincipled" or bpy.app.version >= (4, 2, 0) or material.blend_method != "OPAQUE":
        return None
    alpha = node.inputs["Alpha"]
    if not alpha.is_linked and alpha.default_value >= 1.0:
        return None
    copy = copy_of(material)
    copy.blend_method = "BLEND"
    return copy


def input_of(shader, name):
    return next(shader.inputs[each] for each in NAMES.get(name, (name,)) if each in shader.inputs)


def put(shader, name, value):
    input_of(shader, name).default_value = value


def move(tree, old, name, shader, to):
    """The value or the link of an input."""
    source, target = old.inputs[name], input_of(shader, to)
    if source.is_linked:
        tree.links.new(source.links[0].from_socket, target)
    elif hasattr(source, "default_value") and name != "Normal":
        target.default_value = source.default_value


# -- in the file -----------------------------------------------------------------------------------------------------


def add_default(document):
    """Surfaces without a material are Blender's grey; glTF's default is white metal."""
    bare = [
        primitive
        for mesh in document.json.get("meshes", [])
        for primitive in mesh["primitives"]
        if "material" not in primitive
    ]
    if not bare:
        return
    record = {
        "name": "Default",
        "doubleSided": True,
        "pbrMetallicRoughness": {"baseColorFactor": [*GREY, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0},
    }
    materials = document.list("materials")
    materials.append(record)
    for primitive in bare:
        primitive["material"] = len(materials) - 1


def split_specular(document):
    """Exporters before Blender 4.0 put Specular into the colour of the reflection, which Halflight does not read. The factor
    that it reads is 1 there, so that matte surfaces would be glossy and reflect less."""
    for material in document.json.get("materials", []):
        extension = material.get("extensions", {}).get("KHR_materials_specular", {})
        if "specularColorFactor" not in extension or "specularFactor" in extension:
            continue
        color = extension.pop("specularColorFactor")
        extension["specularFactor"] = min(max(color), 1.0)
        if max(color) > 0.0 and min(color) < max(color):
            extension["specularColorFactor"] = [c / extension["specularFactor"] for c in color]


def drop_unread_colors(document):
    """glTF multiplies by vertex colours wherever there are any; Blender only where a node reads them."""
    reads = []
    for material in document.json.get("materials", []):
        has_pictures = material.get("extras", {}).pop("halflight_pictures", None) is not None  # which hold the colours
        reads.append(not has_pictures and reads_colors(bpy.data.materials.get(material.get("name", ""))))
        if not material.get("extras", True):
            del material["extras"]
    for mesh in document.json.get("meshes", []):
        for primitive in mesh["primitives"]:
            if "material" in primitive and reads[primitive["material"]]:
                continue
            for key in [key for key in primitive["attributes"] if key.startswith("COLOR_")]:
                del primitive["attributes"][key]


def reads_colors(material):
    """Whether the base colour is a vertex colour, or one times something else."""
    if material is None or not material.use_nodes:
        return False
    node = surface_node(material)
    socket = next((node.inputs[name] for name in ("Base Color", "Color") if node and name in node.inputs), None)
    return socket is not None and is_multiplied(socket)


def is_multiplied(socket):
    if not socket.is_linked:
        return False
    node = socket.links[0].from_node
    if node.bl_idname in {"ShaderNodeVertexColor", "ShaderNodeAttribute"}:
        return True
    if node.bl_idname in {"ShaderNodeMixRGB", "ShaderNodeMix"} and node.blend_type == "MULTIPLY":
        return any(is_multiplied(each) for each in node.inputs if each.type == "RGBA")
    return node.bl_idname == "NodeReroute" and is_multiplied(node.inputs[0])
