"""Small glTF scenes of double-sided single sheets, written as .gltf with their data in it."""

import base64
import json
import math
import struct

from tiny_scene import _look_at as look_at


class Builder:
    """Quads with a mesh each, or several in one mesh; diffuse materials alone."""

    def __init__(self, sky=0.0):
        self.data = b""
        self.document = {
            "asset": {"version": "2.0", "generator": "Halflight tests"},
            "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_specular"],
            "extensions": {"KHR_lights_punctual": {"lights": []}},
            "scene": 0,
            "scenes": [{"nodes": [], "extras": {"halflight_sky": sky}}],
            "nodes": [],
            "cameras": [],
            "meshes": [],
            "materials": [],
            "accessors": [],
            "bufferViews": [],
        }

    def material(self, color, double_sided=True, emission=0.0, alpha=1.0):
        material = {
            "pbrMetallicRoughness": {"baseColorFactor": [*color, alpha], "metallicFactor": 0, "roughnessFactor": 1},
            "extensions": {"KHR_materials_specular": {"specularFactor": 0}},
        }
        if double_sided:
            material["doubleSided"] = True
        if emission:
            material["emissiveFactor"] = [emission] * 3
        if alpha < 1:
            material["alphaMode"] = "BLEND"
        self.document["materials"].append(material)
        return len(self.document["materials"]) - 1

    def accessor(self, rows, kind, component, layout):
        document = self.document
        flat = [value for row in rows for value in row]
        blob = struct.pack("<%d%s" % (len(flat), layout), *flat)
        document["bufferViews"].append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(blob)})
        self.data += blob + b"\0" * (-len(blob) % 4)
        accessor = {
            "bufferView": len(document["bufferViews"]) - 1,
            "componentType": component,
            "count": len(rows),
            "type": kind,
        }
        if kind == "VEC3":
            accessor["min"] = [min(row[i] for row in rows) for i in range(3)]
            accessor["max"] = [max(row[i] for row in rows) for i in range(3)]
        document["accessors"].append(accessor)
        return len(document["accessors"]) - 1

    def quads(self, name, quads, material, **extras):
        """Each quad: corner and two edges; its normal is the first edge times the second."""
        positions, normals, indices = [], [], []
        for corner, u, v in quads:
            cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
            length = math.sqrt(sum(c * c for c in cross))
            first = len(positions)
            for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
                positions.append([c + a * i + b * j for c, i, j in zip(corner, u, v)])
                normals.append([c / length for c in cross])
            indices += [[first], [first + 1], [first + 2], [first], [first + 2], [first + 3]]
        primitive = {
            "attributes": {
                "POSITION": self.accessor(positions, "VEC3", 5126, "f"),
                "NORMAL": self.accessor(normals, "VEC3", 5126, "f"),
            },
            "indices": self.accessor(indices, "SCALAR", 5123, "H"),
            "material": material,
        }
        self.document["meshes"].append({"name": name, "primitives": [primitive]})
        node = {"name": name, "mesh": len(self.document["meshes"]) - 1}
        if extras:
            node["extras"] = extras
        return self.node(node)

    def node(self, node):
        self.document["nodes"].append(node)
        self.document["scenes"][0]["nodes"].append(len(self.document["nodes"]) - 1)
        return len(self.document["nodes"]) - 1

    def light(self, kind, intensity, position, target, **extras):
        lights = self.document["extensions"]["KHR_lights_punctual"]["lights"]
        lights.append({"name": kind, "type": kind, "intensity": intensity})
        node = {
            "name": kind,
            "translation": position,
            "rotation": look_at(position, target),
            "extensions": {"KHR_lights_punctual": {"light": len(lights) - 1}},
        }
        if extras:
            node["extras"] = extras
        self.node(node)

    def camera(self, name, eye, target):
        camera = {"name": name, "type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.01}}
        self.document["cameras"].append(camera)
        node = {"name": name, "camera": len(self.document["cameras"]) - 1}
        self.node({**node, "translation": eye, "rotation": look_at(eye, target)})

    def write(self, path):
        document = {key: value for key, value in self.document.items() if value != []}
        if not self.document["extensions"]["KHR_lights_punctual"]["lights"]:
            del document["extensions"]
            document["extensionsUsed"] = ["KHR_materials_specular"]
        uri = "data:application/octet-stream;base64," + base64.b64encode(self.data).decode("ascii")
        document["buffers"] = [{"byteLength": len(self.data), "uri": uri}]
        with open(path, "w", encoding="utf-8") as file:
            json.dump(document, file)
        return path


def boards(path, sky=1.0, **extras):
    """Two boards side by side on a floor, under a sun in front of them. The second one's back faces the sun."""
    scene = Builder(sky)
    grey = scene.material([0.5, 0.5, 0.5], double_sided=False)
    paint = scene.material([0.7, 0.5, 0.3])
    scene.quads("floor", [([-6, 0, 4], [12, 0, 0], [0, 0, -8])], grey)
    scene.quads("front", [([-2.5, 0.2, 0], [2, 0, 0], [0, 2, 0])], paint, **extras)
    scene.quads("back", [([2.5, 0.2, 0], [-2, 0, 0], [0, 2, 0])], paint, **extras)
    scene.light("directional", 10, [2, 6, 7], [0, 0, 0])
    scene.camera("lit", [0, 1.6, 6], [0, 1.1, 0])
    scene.camera("dark", [0, 1.6, -6], [0, 1.1, 0])
    return scene.write(path)


def room(path, outward, sky=0.5):
    """A room of six single walls, one of them with a doorway's width missing, and a baked lamp in it."""
    scene = Builder(sky)
    paint = scene.material([0.6, 0.6, 0.6])
    ground = scene.material([0.4, 0.4, 0.4], double_sided=False)
    walls = [
        ([-2, 0, 2], [4, 0, 0], [0, 0, -4]),  # floor
        ([-2, 2.5, -2], [4, 0, 0], [0, 0, 4]),  # ceiling
        ([-2, 0, -2], [4, 0, 0], [0, 2.5, 0]),
        ([-2, 0, 2], [0, 0, -4], [0, 2.5, 0]),
        ([2, 0, -2], [0, 0, 4], [0, 2.5, 0]),
        ([2, 0, 2], [-3, 0, 0], [0, 2.5, 0]),  # front, a metre is open
    ]
    if outward:
        walls = [(corner, v, u) for corner, u, v in walls]
    scene.quads("room", walls, paint)
    scene.quads("ground", [([-20, -0.01, 20], [40, 0, 0], [0, 0, -40])], ground)
    scene.light("point", 40, [0, 1.8, 0], [0, 0, 0], halflight_mode="baked")
    scene.camera("inside", [1.6, 1.4, 1.6], [-1.5, 0.8, -1.5])
    scene.camera("outside", [5, 2.5, -6], [0, 1.2, 0])
    return scene.write(path)


def lampshade(path):
    """A shade of 16 strips, open above and below, around a lamp, over a table under a dim sky."""
    scene = Builder(0.2)
    cloth = scene.material([0.8, 0.7, 0.6])
    table = scene.material([0.5, 0.5, 0.5], double_sided=False)
    corners = [(0.25 * math.cos(a * math.pi / 8), 0.25 * math.sin(a * math.pi / 8)) for a in range(17)]
    strips = [([x, 0.6, z], [0, 0.4, 0], [p - x, 0, q - z]) for (x, z), (p, q) in zip(corners, corners[1:])]
    scene.quads("shade", strips, cloth)
    scene.quads("table", [([-2, 0, 2], [4, 0, 0], [0, 0, -4])], table)
    scene.light("point", 20, [0, 0.8, 0], [0, 0, 0])
    scene.camera("above", [0.5, 1.7, 0.6], [0, 0.8, 0])
    scene.camera("outside", [0, 0.9, 1.5], [0, 0.8, 0])
    return scene.write(path)


def pane(path, copies=1):
    """A sun through a blended pane, 60 % opaque, that hangs level over a floor; its sides are lit differently."""
    scene = Builder(0.0)
    floor = scene.material([0.5, 0.5, 0.5], double_sided=False)
    glass = scene.material([0.8, 0.8, 0.8], alpha=0.6)
    scene.quads("floor", [([-3, 0, 3], [6, 0, 0], [0, 0, -6])], floor)
    scene.quads("pane", [([-1, 1, 1], [2, 0, 0], [0, 0, -2])], glass)
    scene.light("directional", 10, [0, 10, 0], [0, 0, 0.001])
    scene.camera("view", [0, 0.5, 3.5], [0, 0.2, 0])
    return scene.write(path)
