"""Writes a glTF 2.0 binary: meshes shared between nodes, KHR_lights_punctual, cameras, embedded PNGs, Halflight's extras."""

import json
import math
import pathlib
import struct
import sys

from . import mesh as m, vertices


def look_rotation(eye, target, up=(0.0, 1.0, 0.0)):
    """Quaternion (x, y, z, w) that turns local -Z to the target: for cameras and lights."""
    back = m.normalize(m.sub(eye, target))
    if abs(m.dot(back, up)) > 0.999:
        up = (0.0, 0.0, -1.0)
    right = m.normalize(m.cross(up, back))
    top = m.cross(back, right)
    # Rotation matrix with these columns to quaternion (Shepperd 1978, with the largest of the four as the pivot).
    (a, d, g), (b, e, h), (c, f, i) = right, top, back
    candidates = [1 + a + e + i, 1 + a - e - i, 1 - a + e - i, 1 - a - e + i]
    pivot = candidates.index(max(candidates))
    s = math.sqrt(candidates[pivot]) * 2
    q = {0: ((h - f) / s, (c - g) / s, (d - b) / s, s / 4), 1: (s / 4, (b + d) / s, (c + g) / s, (h - f) / s),
         2: ((b + d) / s, s / 4, (f + h) / s, (c - g) / s), 3: ((c + g) / s, (f + h) / s, s / 4, (d - b) / s)}[pivot]
    n = math.sqrt(sum(x * x for x in q))
    return tuple(x / n for x in q)


def y_rotation(degrees):
    half = math.radians(degrees) / 2
    return (0.0, math.sin(half), 0.0, math.cos(half))


def _without_uv(arrays):
    known, result = {}, {"position": [], "normal": [], "index": []}
    for i in arrays["index"]:
        key = (arrays["position"][i], tuple(round(x * 1e4) for x in arrays["normal"][i]))
        if key not in known:
            known[key] = len(result["position"])
            result["position"].append(arrays["position"][i])
            result["normal"].append(arrays["normal"][i])
        result["index"].append(known[key])
    return result


def _tidy(values, digits=6):
    return [round(float(v), digits) + 0.0 for v in values]


class Document:
    def __init__(self, generator):
        self.json = {"asset": {"version": "2.0", "generator": generator}, "scene": 0, "scenes": [{"nodes": []}], "nodes": []}
        self.binary = bytearray()
        self.materials, self.meshes, self.used = {}, {}, set()
        self.drawn_triangles = self.stored_triangles = self.static_count = self.dynamic_count = 0

    def _list(self, name):
        return self.json.setdefault(name, [])

    def _append(self, name, value):
        self._list(name).append(value)
        return len(self.json[name]) - 1

    def _view(self, data, target=None):
        while len(self.binary) % 4:
            self.binary.append(0)
        view = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)}
        if target:
            view["target"] = target
        self.binary += data
        return self._append("bufferViews", view)

    def _accessor(self, rows, kind):
        width = {"VEC2": 2, "VEC3": 3, "VEC4": 4}[kind]
        flat = [struct.unpack("<f", struct.pack("<f", x))[0] for row in rows for x in row]
        accessor = {"bufferView": self._view(struct.pack(f"<{len(flat)}f", *flat), 34962), "componentType": 5126,
                    "count": len(rows), "type": kind}
        return accessor, flat, width

    def texture(self, png, name, repeat=True):
        image = self._append("images", {"name": name, "mimeType": "image/png", "bufferView": self._view(png)})
        wrap = 10497 if repeat else 33071
        sampler = {"magFilter": 9729, "minFilter": 9987, "wrapS": wrap, "wrapT": wrap}
        if sampler not in self._list("samplers"):
            self._append("samplers", sampler)
        return self._append("textures", {"name": name, "source": image, "sampler": self.json["samplers"].index(sampler)})

    def material(self, name, color=(1, 1, 1), roughness=0.9, metallic=0.0, texture=None, normal=None, normal_scale=1.0,
                 emissive=None, strength=1.0, mask=None, double_sided=False):
        pbr = {"metallicFactor": metallic, "roughnessFactor": roughness}
        if tuple(color) != (1, 1, 1):
            pbr["baseColorFactor"] = _tidy([*color, 1.0])
        if texture is not None:
            pbr["baseColorTexture"] = {"index": texture}
        material = {"name": name, "pbrMetallicRoughness": pbr}
        if normal is not None:
            material["normalTexture"] = {"index": normal, "scale": normal_scale}
        if emissive:
            material["emissiveFactor"] = _tidy(emissive)
            if strength != 1.0:
                material["extensions"] = {"KHR_materials_emissive_strength": {"emissiveStrength": strength}}
                self.used.add("KHR_materials_emissive_strength")
        if mask is not None:
            material.update(alphaMode="MASK", alphaCutoff=mask)
        if double_sided:
            material["doubleSided"] = True
        self.materials[name] = (self._append("materials", material), normal is not None, texture is not None or normal is not None)

    def mesh(self, name, parts, closed=True, crease=35.0):
        """parts: [(Mesh, material name, texture repeats per metre)]. Checked before it is stored; `closed` asks that the
        parts together bound solids."""
        if closed:
            vertices.check_closed([t for part in parts for t in part[0].triangles], name)
        primitives, triangles, points = [], 0, []
        for solid, material, density in parts:
            index, needs_tangents, textured = self.materials[material]
            arrays = vertices.vertex_arrays(solid, density, crease, needs_tangents)
            vertices.check_arrays(arrays, f"{name}/{material}")
            if not textured:  # positions and normals alone, merged where only the coordinates differed
                arrays = _without_uv(arrays)
            position, flat, _ = self._accessor(arrays["position"], "VEC3")
            position["min"] = [min(flat[i::3]) for i in range(3)]
            position["max"] = [max(flat[i::3]) for i in range(3)]
            attributes = {"POSITION": self._append("accessors", position)}
            for semantic, key, kind in (("NORMAL", "normal", "VEC3"), ("TANGENT", "tangent", "VEC4"), ("TEXCOORD_0", "uv", "VEC2")):
                if key in arrays:
                    attributes[semantic] = self._append("accessors", self._accessor(arrays[key], kind)[0])
            wide = len(arrays["position"]) > 65535
            data = struct.pack(f"<{len(arrays['index'])}{'I' if wide else 'H'}", *arrays["index"])
            indices = self._append("accessors", {"bufferView": self._view(data, 34963), "type": "SCALAR",
                                                 "componentType": 5125 if wide else 5123, "count": len(arrays["index"])})
            primitives.append({"attributes": attributes, "indices": indices, "material": index})
            triangles += len(arrays["index"]) // 3
            points += arrays["position"]
        self.stored_triangles += triangles
        self.meshes[name] = (self._append("meshes", {"name": name, "primitives": primitives}), triangles)

    def node(self, name, mesh=None, at=None, turn=None, rotation=None, scale=None, extras=None, **more):
        """turn: degrees about Y; rotation: quaternion."""
        node = {"name": name}
        if mesh is not None:
            node["mesh"], triangles = self.meshes[mesh]
            self.drawn_triangles += triangles
            if (extras or {}).get("halflight_static", 1):
                self.static_count += 1
            else:
                self.dynamic_count += 1
        if at is not None:
            node["translation"] = _tidy(at)
        if turn:
            rotation = y_rotation(turn)
        if rotation is not None:
            node["rotation"] = _tidy(rotation, 8)
        if scale is not None:
            node["scale"] = _tidy((scale,) * 3 if isinstance(scale, (int, float)) else scale)
        if extras:
            node["extras"] = extras
        node.update(more)
        index = self._append("nodes", node)
        self.json["scenes"][0]["nodes"].append(index)
        return index

    def instances(self, name, mesh, positions, extras=None):
        """One node that draws a mesh at each of these places."""
        self.used.add("EXT_mesh_gpu_instancing")
        translation = self._append("accessors", self._accessor(positions, "VEC3")[0])
        index = self.node(name, mesh, extras=extras, extensions={
            "EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": translation}}})
        self.drawn_triangles += (len(positions) - 1) * self.meshes[mesh][1]
        return index

    def camera(self, name, eye, target, vertical_fov_degrees=50.0, aspect=16 / 9, near=0.05, far=200.0):
        camera = self._append("cameras", {"name": name, "type": "perspective", "perspective": {
            "yfov": round(math.radians(vertical_fov_degrees), 6), "aspectRatio": round(aspect, 6), "znear": near, "zfar": far}})
        self.node(name, at=eye, rotation=look_rotation(eye, target), camera=camera)

    def light(self, name, kind, color, intensity, at=None, target=None, cone_range=None, inner=None, outer=None, extras=None):
        """cone_range: KHR_lights_punctual's range in metres; inner, outer: half angles in degrees."""
        self.used.add("KHR_lights_punctual")
        lights = self.json.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {"lights": []})["lights"]
        light = {"name": name, "type": kind, "color": _tidy(color), "intensity": intensity}
        if cone_range:
            light["range"] = cone_range
        if kind == "spot":
            light["spot"] = {"innerConeAngle": round(math.radians(inner), 6), "outerConeAngle": round(math.radians(outer), 6)}
        lights.append(light)
        rotation = look_rotation(at, target) if target is not None else None
        self.node(name, at=at, rotation=rotation, extras=extras,
                  extensions={"KHR_lights_punctual": {"light": len(lights) - 1}})

    def scene(self, name, extras):
        self.json["scenes"][0].update(name=name, extras=extras)

    def scale_lightmaps(self, scales):
        """Texels per metre of static nodes that do not say it themselves, by their meshes' names; 1 unless named."""
        names = [mesh["name"] for mesh in self.json["meshes"]]
        for node in self.json["nodes"]:
            scale = scales.get(names[node["mesh"]], 1) if "mesh" in node else 1
            if scale != 1 and node.get("extras", {}).get("halflight_static", 1):
                node.setdefault("extras", {}).setdefault("halflight_lightmap_scale", scale)

    def glb(self):
        if self.used:
            self.json["extensionsUsed"] = sorted(self.used)
        while len(self.binary) % 4:
            self.binary.append(0)
        self.json["buffers"] = [{"byteLength": len(self.binary)}]
        text = json.dumps(self.json, separators=(",", ":"), ensure_ascii=True).encode()
        text += b" " * (-len(text) % 4)
        total = 12 + 8 + len(text) + 8 + len(self.binary)
        return (struct.pack("<4sII", b"glTF", 2, total) + struct.pack("<I4s", len(text), b"JSON") + text +
                struct.pack("<I4s", len(self.binary), b"BIN\0") + bytes(self.binary))


def target_of(place):
    """What the command line names, or assets/PLACE."""
    default = pathlib.Path(__file__).resolve().parent.parent.parent / "assets" / place
    return pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else default


def write_showcase(name, make):
    """Writes a scene to assets/NAME.glb or to the file that the command line names."""
    path = target_of(name + ".glb")
    doc = make()
    data = doc.glb()
    path.write_bytes(data)
    print(f"{path}: {len(data) / 1e6:.2f} MB, {doc.drawn_triangles} triangles drawn ({doc.stored_triangles} stored), "
          f"{doc.static_count} static and {doc.dynamic_count} dynamic nodes")


def write_scenes(folder, makers):
    """Writes a file for each maker, named after it, to assets/FOLDER or to the folder that the command line names."""
    target = target_of(folder)
    target.mkdir(parents=True, exist_ok=True)
    for make in makers:
        doc = make()
        data = doc.glb()
        path = target / f"{make.__name__}.glb"
        path.write_bytes(data)
        print(f"{path}: {len(data) / 1e3:.1f} kB, {doc.drawn_triangles} triangles drawn")
