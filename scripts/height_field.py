#!/usr/bin/env python3
"""Writes a height field of millions of triangles with a sun, for checks of memory: height_field.py FILE [SIDE].

FILE: a .glb. SIDE: quads along a side, 1600 without it, which is 5.12 million triangles.
"""
import array
import json
import math
import struct
import sys

METERS = 100.0


def height(x, z):
    """Metres: hills, and bumps a few quads wide that shade one another."""
    return 6.0 * math.sin(0.07 * x) * math.cos(0.05 * z) + 0.3 * math.sin(2.3 * x + 1.1 * math.sin(0.7 * z))


def normal(x, z):
    """Of the surface, from central differences."""
    step = 1.0e-3
    across = (height(x - step, z) - height(x + step, z)) / (2.0 * step)
    along = (height(x, z - step) - height(x, z + step)) / (2.0 * step)
    length = math.sqrt(across * across + 1.0 + along * along)
    return across / length, 1.0 / length, along / length


def vertices(side):
    positions = array.array("f")
    normals = array.array("f")
    coordinates = array.array("f")
    for row in range(side + 1):
        v = row / side
        for column in range(side + 1):
            u = column / side
            x, z = METERS * (u - 0.5), METERS * (v - 0.5)
            positions.extend((x, height(x, z), z))
            normals.extend(normal(x, z))
            coordinates.extend((u, v))
    return positions, normals, coordinates


def triangles(side):
    indices = array.array("I")
    for row in range(side):
        for column in range(side):
            corner = row * (side + 1) + column
            below = corner + side + 1
            indices.extend((corner, below, corner + 1, corner + 1, below, below + 1))
    return indices


def document(lists, bounds):
    """A glTF of one mesh; `lists` are its positions, normals, coordinates and indices."""
    kinds = [("VEC3", 5126, 3), ("VEC3", 5126, 3), ("VEC2", 5126, 2), ("SCALAR", 5125, 1)]
    views, accessors, offset = [], [], 0
    for values, (kind, component, width) in zip(lists, kinds):
        size = 4 * len(values)
        views.append({"buffer": 0, "byteOffset": offset, "byteLength": size})
        accessors.append(
            {"bufferView": len(views) - 1, "componentType": component, "count": len(values) // width, "type": kind}
        )
        offset += size
    accessors[0].update(bounds)
    attributes = {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2, "TEXCOORD_1": 2}
    sun = {"type": "directional", "intensity": 20000.0, "name": "Sun"}
    return {
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": [sun]}},
        "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [
            {"mesh": 0, "name": "Ground"},
            {"rotation": [-0.17, 0.2, 0.0, 0.964935], "extensions": {"KHR_lights_punctual": {"light": 0}}},
        ],
        "meshes": [{"primitives": [{"attributes": attributes, "indices": 3}]}],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": offset}],
    }


def main(path, side):
    positions, normals, coordinates = vertices(side)
    bounds = {
        "min": [min(positions[axis::3]) for axis in range(3)],
        "max": [max(positions[axis::3]) for axis in range(3)],
    }
    lists = [positions, normals, coordinates, triangles(side)]
    text = json.dumps(document(lists, bounds)).encode()
    text += b" " * (-len(text) % 4)
    size = sum(4 * len(values) for values in lists)
    with open(path, "wb") as file:
        file.write(struct.pack("<4sIII4s", b"glTF", 2, 28 + len(text) + size, len(text), b"JSON") + text)
        file.write(struct.pack("<I4s", size, b"BIN\0"))
        for values in lists:
            values.tofile(file)


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit("usage: height_field.py FILE [SIDE]")
    main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) == 3 else 1600)
