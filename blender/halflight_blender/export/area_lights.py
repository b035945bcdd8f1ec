# SPDX-License-Identifier: GPL-3.0-or-later
"""Area lights, which Blender's exporter leaves out: EXT_lights_area, and emissive surfaces for ellipses."""

import math

import bpy
import numpy as np

from . import lamps

EXTENSION = "EXT_lights_area"
CORNERS = 32  # of an ellipse: its area is 0.6 % less than the curve's, which the radiance makes up for


def outline(light):
    """Corners in the light's plane, counter-clockwise as seen from where it shines (-Z)."""
    width = light.size
    height = light.size_y if light.shape in {"RECTANGLE", "ELLIPSE"} else light.size
    if light.shape in {"DISK", "ELLIPSE"}:
        angles = -2.0 * math.pi * np.arange(CORNERS) / CORNERS
        return np.stack([np.cos(angles) * width / 2, np.sin(angles) * height / 2], 1)
    return np.array([(-1, -1), (-1, 1), (1, 1), (1, -1)]) * (width / 2, height / 2)


def area_of(corners):
    x, y = corners[:, 0], corners[:, 1]
    return abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2


def add_lights(document, factor, held):
    """`factor`: lumens per watt; `held`: lamps.held_lamps(). Returns sentences about what is left out."""
    warnings = []
    matrices = document.world_matrices()
    for index, node in enumerate(document.json.get("nodes", [])):
        item = bpy.data.objects.get(node.get("name", ""))
        if item is None or item.type != "LIGHT" or item.data.type != "AREA" or index not in matrices:
            continue
        light = item.data
        if getattr(light, "spread", math.pi) < math.radians(179.0):
            warnings.append(f'area light "{item.name}": its spread is left out; it shines to all of one side')
        if light.shape != "ELLIPSE":
            add_light(document, node, light, matrices[index], factor, held)
            continue
        corners = outline(light)
        scale = np.linalg.norm(np.cross(matrices[index][:3, 0], matrices[index][:3, 1]))
        area = area_of(corners) * scale
        strength = lamps.emission_of(light)[1]
        if area <= 0.0 or strength <= 0.0:
            continue
        node["mesh"] = add_mesh(document, light, corners, radiance_of(strength * factor, area))
        # It lights as an emissive surface does. It needs no texels, and Blender's area lights throw no shadow.
        extras = node.setdefault("extras", {})
        extras.update({"halflight_lightmap_scale": 0, "halflight_cast_shadows": 0})
        if light.get("halflight_group"):
            extras.setdefault("halflight_group", light["halflight_group"])
        if light.get("halflight_mode") is not None:
            warnings.append(f'area light "{item.name}": an ellipse is always baked, whatever its mode')
    return warnings


def add_light(document, node, light, matrix, factor, held):
    """A rectangle or disk of the extension: radiance, and sizes that the node's largest scale multiplies."""
    scales = np.linalg.norm(matrix[:3, :3], axis=0)
    width = light.size * scales[0]
    height = (light.size_y if light.shape == "RECTANGLE" else light.size) * scales[1]
    is_disk = light.shape == "DISK"
    area = math.pi / 4 * width * width if is_disk else width * height
    color, strength = lamps.split(light, held)
    if area <= 0.0 or strength <= 0.0:
        return
    size = float((width if is_disk else height) / scales.max())
    # Settings on the object itself are in the node's extras, which go before those of the light.
    extras = {key: plain(value) for key, value in light.items() if key.startswith("halflight_")}
    if not lamps.casts_shadows(light):
        extras.setdefault("halflight_cast_shadows", 0)
    extension = document.json.setdefault("extensions", {}).setdefault(EXTENSION, {"lights": []})
    record = {
        "name": light.name,
        "type": "disk" if is_disk else "rect",
        "color": color,
        "intensity": radiance_of(strength * factor, area),
        "size": size,
        "extras": extras,
    }
    if not is_disk:
        record["rect"] = {"aspect": float(width / height)}
    node.setdefault("extensions", {})[EXTENSION] = {"light": len(extension["lights"])}
    extension["lights"].append(record)
    document.use_extension(EXTENSION)


def plain(value):
    return value.to_list() if hasattr(value, "to_list") else value


def radiance_of(power, area):
    """Blender before 4.0 gives an area light less than a Lambertian emitter of one side would have."""
    return power / ((4.0 if bpy.app.version < (4, 0, 0) else math.pi) * area)


def add_mesh(document, light, corners, radiance):
    document.use_extension("KHR_materials_emissive_strength")
    color = np.array(lamps.emission_of(light)[0])
    brightest = max(float(color.max()), 1e-6)
    document.list("materials").append(
        {
            "name": light.name,
            "emissiveFactor": (color / brightest).tolist(),
            "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0},
            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": radiance * brightest}},
        }
    )
    count = len(corners)
    positions = np.zeros((count, 3), np.float32)
    positions[:, :2] = corners
    normals = np.tile(np.array([0, 0, -1], np.float32), (count, 1))
    fan = np.array([(0, i, i + 1) for i in range(1, count - 1)], np.uint16).reshape(-1, 1)
    document.list("meshes").append(
        {
            "name": light.name,
            "primitives": [
                {
                    "attributes": {
                        "POSITION": document.add_accessor(positions, "VEC3"),
                        "NORMAL": document.add_accessor(normals, "VEC3"),
                    },
                    "indices": document.add_accessor(fan, "SCALAR"),
                    "material": len(document.json["materials"]) - 1,
                }
            ],
        }
    )
    return len(document.json["meshes"]) - 1
