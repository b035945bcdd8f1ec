# SPDX-License-Identifier: GPL-3.0-or-later
"""Binary glTF: JSON, buffer and accessors as numpy arrays. Imports nothing of Blender."""

import json
import struct

import numpy as np

TYPES = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


class Glb:
    def __init__(self, path):
        with open(path, "rb") as file:
            data = file.read()
        if data[:4] != b"glTF":
            raise ValueError(f"{path} is no binary glTF")
        length = struct.unpack_from("<I", data, 12)[0]
        self.json = json.loads(data[20 : 20 + length])
        self.binary = bytearray(data[28 + length :])

    def write(self, path):
        text = json.dumps(self.json, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        self.binary += b"\0" * (-len(self.binary) % 4)
        if self.binary:
            self.json.setdefault("buffers", [{}])[0]["byteLength"] = len(self.binary)
            text = json.dumps(self.json, separators=(",", ":")).encode()
            text += b" " * (-len(text) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
        if self.binary:
            chunks += struct.pack("<II", len(self.binary), 0x004E4942) + bytes(self.binary)
        with open(path, "wb") as file:
            file.write(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)

    def list(self, name):
        return self.json.setdefault(name, [])

    def use_extension(self, name):
        used = self.list("extensionsUsed")
        if name not in used:
            used.append(name)

    def view_bytes(self, index):
        view = self.json["bufferViews"][index]
        start = view.get("byteOffset", 0)
        return bytes(self.binary[start : start + view["byteLength"]])

    def accessor(self, index):
        """Values as a two-dimensional array; fractions as floats in 0…1."""
        accessor = self.json["accessors"][index]
        dtype, width, count = TYPES[accessor["componentType"]], WIDTHS[accessor["type"]], accessor["count"]
        if "sparse" in accessor or "bufferView" not in accessor:
            raise ValueError("sparse accessors are not read")
        view = self.json["bufferViews"][accessor["bufferView"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        item = np.dtype(dtype).itemsize * width
        stride = view.get("byteStride", item)
        rows = np.ndarray((count, width), dtype, self.binary, start, (stride, np.dtype(dtype).itemsize))
        if not accessor.get("normalized"):
            return rows.copy()
        return np.maximum(rows.astype(np.float32) / np.iinfo(dtype).max, -1.0)

    def add_accessor(self, values, kind):
        values = np.ascontiguousarray(values)
        codes = {np.dtype(dtype): code for code, dtype in TYPES.items()}
        self.binary += b"\0" * (-len(self.binary) % 4)
        self.list("bufferViews").append({"buffer": 0, "byteOffset": len(self.binary), "byteLength": values.nbytes})
        self.binary += values.tobytes()
        self.json.setdefault("buffers", [{}])
        accessor = {
            "bufferView": len(self.json["bufferViews"]) - 1,
            "componentType": codes[values.dtype],
            "count": len(values),
            "type": kind,
        }
        if kind == "VEC3":
            accessor["min"], accessor["max"] = values.min(0).tolist(), values.max(0).tolist()
        self.list("accessors").append(accessor)
        return len(self.json["accessors"]) - 1

    def world_matrices(self):
        """4x4 matrix of each node of the default scene, by index."""
        matrices = {}
        nodes = self.json.get("nodes", [])
        roots = self.json["scenes"][self.json.get("scene", 0)].get("nodes", [])
        left = [(root, np.identity(4)) for root in roots]
        while left:
            index, parent = left.pop()
            matrices[index] = parent @ local_matrix(nodes[index])
            left += [(child, matrices[index]) for child in nodes[index].get("children", [])]
        return matrices


def local_matrix(node):
    if "matrix" in node:
        return np.array(node["matrix"], np.float64).reshape(4, 4).T
    x, y, z, w = node.get("rotation", (0.0, 0.0, 0.0, 1.0))
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    matrix = np.identity(4)
    matrix[:3, :3] = rotation * np.array(node.get("scale", (1.0, 1.0, 1.0)))
    matrix[:3, 3] = node.get("translation", (0.0, 0.0, 0.0))
    return matrix
