"""Writes a small glTF scene for the command-line tests: a floor, two walls, a block, a dynamic block, lights, a camera."""

import base64
import json
import math
import struct

# Unit cube around the origin, flat-shaded: four vertices a face, wound counter-clockwise seen from outside.
_FACES = [
    ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    ((-1, 0, 0), (0, 0, 1), (0, 1, 0)),
    ((0, 1, 0), (0, 0, 1), (1, 0, 0)),
    ((0, -1, 0), (1, 0, 0), (0, 0, 1)),
    ((0, 0, 1), (1, 0, 0), (0, 1, 0)),
    ((0, 0, -1), (0, 1, 0), (1, 0, 0)),
]


def _cube():
    positions, normals, indices = [], [], []
    for normal, u, v in _FACES:
        first = len(positions)
        for a, b in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)):
            positions.append([0.5 * n + a * i + b * j for n, i, j in zip(normal, u, v)])
            normals.append(normal)
        indices += [first, first + 1, first + 2, first, first + 2, first + 3]
    return positions, normals, indices


def _look_at(eye, target):
    """Quaternion x, y, z, w that turns -Z towards target."""
    back = [e - t for e, t in zip(eye, target)]
    length = math.sqrt(sum(c * c for c in back))
    back = [c / length for c in back]
    yaw = math.atan2(back[0], back[2])
    pitch = -math.asin(back[1])
    cy, sy, cp, sp = math.cos(yaw / 2), math.sin(yaw / 2), math.cos(pitch / 2), math.sin(pitch / 2)
    return [cy * sp, sy * cp, -sy * sp, cy * cp]


def _blocks_and_lights(spots):
    """(nodes, lights)"""

    def block(name, center, size, **extras):
        node = {"name": name, "mesh": 0, "translation": center, "scale": size}
        if extras:
            node["extras"] = extras
        return node

    nodes = [
        block("floor", [0, -0.05, 0], [6, 0.1, 6]),
        block("wall", [-3, 1.5, 0], [0.1, 3, 6]),
        block("back", [0, 1.5, -3], [6, 3, 0.1]),
        block("pillar", [0.5, 0.75, 0.3], [0.5, 1.5, 0.5]),
        block("crate", [-1, 0.4, 0.8], [0.6, 0.6, 0.6], halflight_static=0),
        {
            "name": "sun",
            "rotation": _look_at([3, 6, 4], [0, 0, 0]),
            "extensions": {"KHR_lights_punctual": {"light": 0}},
        },
        {"name": "view", "camera": 0, "translation": [4, 3, 5], "rotation": _look_at([4, 3, 5], [0, 0.5, 0])},
    ]
    lights = [{"name": "sun", "type": "directional", "intensity": 5.0}]
    for i in range(spots):
        eye = [1.5 - i, 3.0, 2.0]
        lights.append(
            {
                "name": "spot %d" % i,
                "type": "spot",
                "intensity": 60.0 - i,
                "range": 10.0,
                "spot": {"innerConeAngle": 0.3, "outerConeAngle": 0.9},
            }
        )
        nodes.append(
            {
                "name": "spot %d" % i,
                "translation": eye,
                "rotation": _look_at(eye, [0, 0, 0]),
                "extensions": {"KHR_lights_punctual": {"light": i + 1}},
            }
        )
    return nodes, lights


def write(path, spots=1):
    """`spots` mixed spot lights reach the same floor, besides one mixed directional light."""
    positions, normals, indices = _cube()
    data = b"".join(struct.pack("<3f", *p) for p in positions)
    data += b"".join(struct.pack("<3f", *n) for n in normals)
    data += struct.pack("<%dH" % len(indices), *indices)
    count = len(positions)
    nodes, lights = _blocks_and_lights(spots)
    document = {
        "asset": {"version": "2.0", "generator": "Halflight tests"},
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": lights}},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(nodes)))}],
        "nodes": nodes,
        "cameras": [{"name": "view", "type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.05}}],
        "meshes": [
            {"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2, "material": 0}], "name": "cube"}
        ],
        "materials": [
            {"name": "plaster", "pbrMetallicRoughness": {"baseColorFactor": [0.7, 0.6, 0.5, 1], "metallicFactor": 0}}
        ],
        "accessors": [
            {
                "bufferView": 0,
                "componentType": 5126,
                "count": count,
                "type": "VEC3",
                "min": [-0.5] * 3,
                "max": [0.5] * 3,
            },
            {"bufferView": 1, "componentType": 5126, "count": count, "type": "VEC3"},
            {"bufferView": 2, "componentType": 5123, "count": len(indices), "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 12 * count, "target": 34962},
            {"buffer": 0, "byteOffset": 12 * count, "byteLength": 12 * count, "target": 34962},
            {"buffer": 0, "byteOffset": 24 * count, "byteLength": 2 * len(indices), "target": 34963},
        ],
        "buffers": [
            {
                "byteLength": len(data),
                "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode("ascii"),
            }
        ],
    }
    with open(path, "w", encoding="utf-8") as file:
        json.dump(document, file)
