# SPDX-License-Identifier: GPL-3.0-or-later
"""Point, spot and sun lamps as Cycles has them: what the exporter leaves out of KHR_lights_punctual, or reads otherwise."""

import math

import bpy

# A spot's inner angle stays below its outer one, as glTF demands, by this much: 0.006 degrees.
LEAST_RING = 1e-4


def complete(document, factor, held):
    """`factor`: lumens per watt; `held`: held_lamps()."""
    lights = document.json.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", [])
    for node in document.json.get("nodes", []):
        index = node.get("extensions", {}).get("KHR_lights_punctual", {}).get("light")
        item = bpy.data.objects.get(node.get("name", ""))
        if index is not None and item is not None and item.type == "LIGHT":
            write(lights[index], item.data, factor, held)


def write(light, data, factor, held):
    extras = light.setdefault("extras", {})
    light["color"], strength = split(data, held)
    light["intensity"] = strength * intensity_of(data, factor)
    if data.type == "SUN":
        extras.setdefault("halflight_angular_diameter", math.degrees(data.angle))
    else:
        extras.setdefault("halflight_radius", data.shadow_soft_size)
    if data.type == "SPOT":
        light["spot"] = cone_of(data)
    if not casts_shadows(data):
        extras.setdefault("halflight_cast_shadows", 0)


def intensity_of(data, factor):
    """Lux of a sun, candela of others, of one of Blender's units."""
    if data.type == "SUN":
        return factor
    return factor / (4.0 * math.pi) * (mean_cosine(data) if dims(data) else 1.0)


def cone_of(data):
    """glTF squares a linear ramp over the cosine, Blender has a smoothstep: this inner angle has the same flux."""
    outer = min(data.spot_size / 2.0, math.pi / 2.0)
    cosine = math.cos(outer) + 0.75 * data.spot_blend * (1.0 - math.cos(outer))
    inner = min(math.acos(min(cosine, 1.0)), outer - LEAST_RING)
    return {"innerConeAngle": max(inner, 0.0), "outerConeAngle": outer}


def dims(data):
    """Cycles before Blender 4.0 multiplies a spot's light by the cosine to its axis."""
    return data.type == "SPOT" and bpy.app.version < (4, 0, 0)


def mean_cosine(data):
    """Over the spot's cone, weighted by the smoothstep at its edge: what the cosine leaves of the flux."""
    edge = math.cos(min(data.spot_size / 2.0, math.pi / 2.0))
    ramp = data.spot_blend * (1.0 - edge)
    weighted = (1.0 - (edge + ramp) ** 2) / 2.0 + edge * ramp / 2.0 + 0.35 * ramp * ramp
    return weighted / (1.0 - edge - ramp / 2.0)


def emission_of(data):
    """Colour, and watts (a sun's: watts per square metre), times what an Emission node of plain numbers makes of them."""
    color, strength = list(data.color), data.energy
    node = emission_node(data)
    if node is None:
        return color, strength
    if not node.inputs["Color"].is_linked:
        color = [a * b for a, b in zip(color, node.inputs["Color"].default_value)]
    source = node.inputs["Strength"]
    if source.is_linked and source.links[0].from_node.bl_idname == "ShaderNodeLightFalloff":
        source = source.links[0].from_node.inputs["Strength"]
    return color, strength * (1.0 if source.is_linked else source.default_value)


def emission_node(data):
    """None where the lamp has no nodes, or other ones than Emission."""
    if not data.use_nodes or data.node_tree is None:
        return None
    output = data.node_tree.get_output_node("CYCLES")
    if output is None or not output.inputs["Surface"].is_linked:
        return None
    node = output.inputs["Surface"].links[0].from_node
    return node if node.bl_idname == "ShaderNodeEmission" else None


def held_lamps(scene):
    """Lamps that a light group's slider sets: their light at the weight 1, and the weight."""
    entries = [entry for entry in scene.halflight.light_groups if entry.is_baked]
    return {member.item: (tuple(member.white), entry.weight()) for entry in entries for member in entry.members}


def split(data, held):
    """Colour and strength in the file. A lamp that its group dims keeps its strength there: the colour is darker, as the bake
    takes weights from colours."""
    color, strength = normalized(*emission_of(data))
    if data not in held:
        return color, strength
    white, weight = held[data]
    now = data.energy * max(data.color)
    share = max(white) * max(1.0, *weight) / now if now > 0.0 else 1.0
    return [c / max(share, 1.0) for c in color], strength * max(share, 1.0)


def normalized(color, strength):
    """glTF's colours are at most 1."""
    largest = max(*color, 1.0)
    return [max(c, 0.0) / largest for c in color], strength * largest


def casts_shadows(data):
    """Cycles and Eevee have a box each before Blender 4.2: a lamp throws shadows where both are on."""
    return data.use_shadow and getattr(data.cycles, "cast_shadow", True)
