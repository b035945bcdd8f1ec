# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials of the baked view: emission of albedo times baked light. The user's materials have no part in them."""

import math
import os

import bpy

from . import graph

LIGHTMAP_UV = "lightmap"
COLORS = "vertex color"


class Materials:
    """Makes a material for each pair of glTF material and lightmap page."""

    def __init__(self, document, bindings, folder, lights, groups, lumens_per_watt):
        self.document = document
        self.bindings = bindings
        self.folder = folder  # of the pictures of `bindings`, and for a moment of those of the document
        self.lights = lights  # node group, or None
        self.groups = groups  # view_groups.Groups
        self.lumens_per_watt = lumens_per_watt
        self.images = {}
        self.made = {}

    def get(self, index, page, has_colors):
        key = (index, page, has_colors)
        if key not in self.made:
            self.made[key] = self.make(index, page, has_colors)
        return self.made[key]

    def make(self, index, page, has_colors):
        source = {} if index is None else self.document.json["materials"][index]
        material = bpy.data.materials.new("Baked " + source.get("name", "material"))
        material.use_nodes = True
        material.node_tree.nodes.clear()
        g = graph.Graph(material.node_tree)
        surface = source.get("pbrMetallicRoughness", {})
        base, alpha = self.base_color(g, surface, has_colors)
        light = self.light(g, page)
        if "KHR_materials_unlit" in source.get("extensions", {}):
            radiance = base
        else:
            radiance = g.scaled(g.vector("MULTIPLY", self.albedo(g, surface, base), light), 1.0 / math.pi)
            radiance = g.vector("ADD", radiance, self.emission(g, source))
        emission = g.node("ShaderNodeEmission")
        g.put(emission.inputs["Color"], g.scaled(radiance, 1.0 / self.lumens_per_watt))
        shader = self.with_glass(g, source, emission.outputs[0], base)
        shader = self.with_holes(g, material, source, shader, alpha)
        g.put(g.node("ShaderNodeOutputMaterial").inputs["Surface"], shader)
        leave_out_of_light_sampling(material)
        return material

    def light(self, g, page):
        """Irradiance in lux: the lightmap, and the direct light of mixed lights times their masks."""
        uv = g.uv(LIGHTMAP_UV)
        lightmaps = self.bindings["lightmaps"]
        lightmap = self.file(lightmaps["pages"][page], None)
        light = g.scaled(g.picture(lightmap, uv, "EXTEND")["Color"], lightmaps["unitLux"])
        if self.groups.records:
            pictures = [self.picture_of_group(g, record["lightmaps"], page, uv) for record in self.groups.records]
            light = g.vector("ADD", light, self.groups.irradiance(g, pictures))
        if self.lights is None:
            return light
        group = g.node("ShaderNodeGroup", node_tree=self.lights)
        masks = self.bindings.get("shadowmasks")
        if masks:
            mask = g.picture(self.file(masks[page], "Non-Color"), uv, "EXTEND")
            g.put(group.inputs["Mask"], mask["Color"])
            g.put(group.inputs["Alpha"], mask["Alpha"])
        return g.vector("ADD", light, group.outputs["Irradiance"])

    def picture_of_group(self, g, lightmaps, page, uv):
        """None where a group has no light on the page."""
        name = lightmaps["pages"][page]
        return g.scaled(g.picture(self.file(name, None), uv, "EXTEND")["Color"], lightmaps["unitLux"]) if name else None

    def base_color(self, g, surface, has_colors):
        factor = surface.get("baseColorFactor", [1.0, 1.0, 1.0, 1.0])
        color, alpha = factor[:3], factor[3]
        if "baseColorTexture" in surface:
            texture = self.texture(g, surface["baseColorTexture"], "sRGB")
            color, alpha = g.vector("MULTIPLY", texture["Color"], color), g.scalar("MULTIPLY", texture["Alpha"], alpha)
        if has_colors:
            vertex = g.node("ShaderNodeVertexColor", layer_name=COLORS).outputs
            color, alpha = g.vector("MULTIPLY", vertex["Color"], color), g.scalar("MULTIPLY", vertex["Alpha"], alpha)
        return color, alpha

    def albedo(self, g, surface, base):
        return transport_albedo(g, base, *self.metal(g, surface))

    def metal(self, g, surface):
        """Metallic and roughness: numbers, or sockets where a picture has them."""
        metallic, roughness = surface.get("metallicFactor", 1.0), surface.get("roughnessFactor", 1.0)
        if "metallicRoughnessTexture" not in surface:
            return metallic, roughness
        channels = g.separate(self.texture(g, surface["metallicRoughnessTexture"], "Non-Color")["Color"])
        return g.scalar("MULTIPLY", channels[2], metallic), g.scalar("MULTIPLY", channels[1], roughness)

    def emission(self, g, source):
        extension = source.get("extensions", {}).get("KHR_materials_emissive_strength", {})
        strength = extension.get("emissiveStrength", 1.0)
        baking = source.get("extensions", {}).get("HALFLIGHT_material", {}).get("baking", {})
        if "group" in baking:
            white = g.vector("MULTIPLY", self.groups.weight(g, self.groups.name(baking)), baking["white"])
            if "emissiveTexture" not in source:
                return white
            return g.vector("MULTIPLY", self.texture(g, source["emissiveTexture"], "sRGB")["Color"], white)
        factor = [strength * c for c in source.get("emissiveFactor", (0.0, 0.0, 0.0))]
        if "emissiveTexture" not in source or not any(factor):
            return factor
        return g.vector("MULTIPLY", self.texture(g, source["emissiveTexture"], "sRGB")["Color"], factor)

    def with_glass(self, g, source, shader, base):
        """Glass is clear, and tinted at each face as Cycles does it. What a face mirrors is not shown."""
        glass = source.get("extensions", {}).get("KHR_materials_transmission", {})
        passing = glass.get("transmissionFactor", 0.0)
        if passing <= 0.0:
            return shader
        surface = source.get("pbrMetallicRoughness", {})
        metallic, _ = self.metal(g, surface)
        if metallic != 0.0:
            passing = g.scalar("MULTIPLY", passing, g.scalar("SUBTRACT", 1.0, metallic))
        if "transmissionTexture" in glass:
            texture = self.texture(g, glass["transmissionTexture"], "Non-Color")
            passing = g.scalar("MULTIPLY", passing, g.separate(texture["Color"])[0])
        return clear(g, shader, base, passing, source["extensions"].get("KHR_materials_ior", {}).get("ior", 1.5))

    def with_holes(self, g, material, source, shader, alpha):
        """Alpha, and the backs of single-sided surfaces, let through what is behind."""
        mode = source.get("alphaMode", "OPAQUE")
        is_glass = source.get("extensions", {}).get("KHR_materials_transmission", {}).get("transmissionFactor", 0.0) > 0.0
        visible = None
        if mode == "MASK":
            visible = g.scalar("GREATER_THAN", alpha, source.get("alphaCutoff", 0.5))
        elif mode == "BLEND":
            visible = alpha
        if not source.get("doubleSided", False):
            material.use_backface_culling = True
            front = g.scalar("SUBTRACT", 1.0, g.node("ShaderNodeNewGeometry").outputs["Backfacing"])
            visible = front if visible is None else g.scalar("MULTIPLY", visible, front)
        if mode != "OPAQUE" or is_glass:
            is_blended = mode == "BLEND" or is_glass
            if hasattr(material, "surface_render_method"):  # Blender 4.2 and newer
                material.surface_render_method = "BLENDED" if is_blended else "DITHERED"
            else:
                material.blend_method = "BLEND" if is_blended else "CLIP"
                material.shadow_method = "NONE" if is_glass else "HASHED"
        if visible is None:
            return shader
        return mixed_shader(g, visible, g.node("ShaderNodeBsdfTransparent").outputs[0], shader)

    # -- pictures ----------------------------------------------------------------------------------------------------

    def texture(self, g, reference, space):
        texture = self.document.json["textures"][reference["index"]]
        source = texture.get("extensions", {}).get("EXT_texture_webp", texture).get("source")
        sampler = self.document.json["samplers"][texture["sampler"]] if "sampler" in texture else {}
        extension = "EXTEND" if sampler.get("wrapS") == 33071 else "REPEAT"
        interpolation = "Closest" if sampler.get("magFilter") == 9728 else "Linear"
        transform = reference.get("extensions", {}).get("KHR_texture_transform", {})
        uv = g.uv(uv_name(transform.get("texCoord", reference.get("texCoord", 0))))
        return g.picture(self.image(source, space), transformed(g, uv, transform), extension, interpolation)

    def image(self, index, space):
        if (index, space) not in self.images:
            source = self.document.json["images"][index]
            suffix = {"image/png": ".png", "image/jpeg": ".jpg", "image/webp": ".webp"}[source["mimeType"]]
            path = os.path.join(self.folder, "picture" + suffix)
            with open(path, "wb") as file:
                file.write(self.document.view_bytes(source["bufferView"]))
            self.images[index, space] = self.loaded(path, space, "Baked " + source.get("name", "picture"))
            os.remove(path)
        return self.images[index, space]

    def file(self, name, space):
        if name not in self.images:
            self.images[name] = self.loaded(os.path.join(self.folder, name), space, "Baked " + name)
        return self.images[name]

    @staticmethod
    def loaded(path, space, name):
        """Packed, so that the view does not change while a bake writes the file anew."""
        image = bpy.data.images.load(path, check_existing=False)
        image.name = name
        image.alpha_mode = "CHANNEL_PACKED"
        if space is not None:
            image.colorspace_settings.name = space
        image.pack()
        return image


def uv_name(texcoord):
    return f"uv {texcoord}"


def transformed(g, uv, transform):
    """KHR_texture_transform, whose v runs down; Blender's runs up."""
    if not any(key in transform for key in ("offset", "scale", "rotation")):
        return uv
    flip = ((1.0, -1.0, 1.0), (0.0, 1.0, 0.0))
    uv = g.vector("MULTIPLY_ADD", uv, *flip)
    mapping = g.node("ShaderNodeMapping", vector_type="POINT")
    g.put(mapping.inputs["Vector"], uv)
    mapping.inputs["Location"].default_value = (*transform.get("offset", (0.0, 0.0)), 0.0)
    mapping.inputs["Rotation"].default_value = (0.0, 0.0, -transform.get("rotation", 0.0))
    mapping.inputs["Scale"].default_value = (*transform.get("scale", (1.0, 1.0)), 1.0)
    return g.vector("MULTIPLY_ADD", mapping.outputs["Vector"], *flip)


# -- parts of materials, also of dynamic objects ----------------------------------------------------------------------


def transport_albedo(g, base, metallic, roughness):
    """transportAlbedo() of include/halflight/shading/brdf.h: metals reflect as much as their lobe, to all sides."""
    if metallic == 0.0:
        return base
    square = g.scalar("MULTIPLY", roughness, roughness)
    cube = g.scalar("MULTIPLY", square, roughness)
    lost = g.scalar("MULTIPLY", cube, g.scalar("MULTIPLY_ADD", square, -0.493, 1.084))
    grazing = g.scalar("MULTIPLY", g.scalar("POWER", 2.0, g.scalar("MULTIPLY", square, -5.0)), 0.047)
    lobe = g.scalar("SUBTRACT", g.scalar("SUBTRACT", 1.0, lost), grazing)
    share = g.mixed(1.0, lobe, metallic)
    white = g.scalar("MULTIPLY", metallic, grazing)
    combined = g.node("ShaderNodeCombineXYZ")
    for socket in combined.inputs:
        g.put(socket, white)
    return g.vector("ADD", g.scaled(base, share), combined.outputs[0])


def clear(g, shader, base, passing, ior):
    """A mix of `shader` and clear glass, by the share of light that passes."""
    if isinstance(ior, bpy.types.NodeSocket):
        ratio = g.scalar("DIVIDE", g.scalar("SUBTRACT", ior, 1.0), g.scalar("ADD", ior, 1.0))
        kept = g.scalar("SUBTRACT", 1.0, g.scalar("MULTIPLY", ratio, ratio))
    else:
        kept = 1.0 - ((ior - 1.0) / (ior + 1.0)) ** 2  # by Fresnel's law, straight on
    node = g.node("ShaderNodeBsdfTransparent")
    g.put(node.inputs["Color"], g.scaled(tint(g, base), kept))
    return mixed_shader(g, passing, shader, node.outputs[0])


def tint(g, base):
    """Blender 4.0 and newer halves the colour's effect, as light passes two faces of most things."""
    power = 1.0 if bpy.app.version < (4, 0, 0) else 0.5
    if not isinstance(base, bpy.types.NodeSocket):
        return [c**power for c in base]
    if power == 1.0:
        return base
    combined = g.node("ShaderNodeCombineColor")
    for socket, value in zip(combined.inputs, g.separate(base)):
        g.put(socket, g.scalar("POWER", value, power))
    return combined.outputs[0]


def mixed_shader(g, share, a, b):
    """a at a share of 0, b at 1."""
    mix = g.node("ShaderNodeMixShader")
    for socket, value in zip(mix.inputs, (share, a, b)):
        g.put(socket, value)
    return mix.outputs[0]


def leave_out_of_light_sampling(material):
    """Cycles would sample each triangle as a lamp."""
    cycles = getattr(material, "cycles", None)
    if hasattr(cycles, "emission_sampling"):
        cycles.emission_sampling = "NONE"
    elif hasattr(cycles, "sample_as_light"):
        cycles.sample_as_light = False
