"""Files whose numbers are not what they should be. Usage: broken_test.py HALFLIGHT SHARED_DIR [TestClass[.test]] …"""

import base64
import copy
import json
import math
import os
import pathlib
import re
import struct
import sys

import cli_case
from cli_case import QUICK, Case, read, run

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "scripts"))
import make_truth_report as report

# What libraries call themselves in their messages, and what this program says where one of them gave up.
FOREIGN = re.compile(r"json\.exception|nlohmann|std::|basic_string|bad_alloc|toml::|CLI::|Imf|_M_|internal error")


def parts_of(path):
    """JSON and binary chunk of a GLB."""
    data = read(path)
    (length,) = struct.unpack_from("<I", data, 12)
    text = data[20 : 20 + length]
    return json.loads(text), bytearray(data[28 + length :])


def write_glb(path, document, binary):
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary)))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary)


def tables():
    """Rows of src/scene/document/bake_ranges.h: members, and values of accessors."""
    text = (ROOT / "src/scene/document/bake_ranges.h").read_text()
    rows = re.compile(r'\{"([^"]+)", ([^,}]+), ([^,}]+)(, true)?\},')
    halves = text.split("kBakeValueRanges")
    return [
        [(path.split("/"), float(least), float(most), bool(above)) for path, least, most, above in rows.findall(half)]
        for half in halves[:2]
    ]


def places(value, steps, path=()):
    """(holder, key, path) of all numbers that a path leads to; of arrays, the last number."""
    if not steps:
        return
    step, rest = steps[0], steps[1:]
    keys = range(len(value)) if isinstance(value, list) else value.keys()
    for key in [k for k in keys if step in ("*", k)] if isinstance(value, (list, dict)) else []:
        here = (*path, str(key))
        if rest:
            yield from places(value[key], rest, here)
        elif isinstance(value[key], list):
            yield value[key], len(value[key]) - 1, (*here, str(len(value[key]) - 1))
        else:
            yield value, key, here


class BrokenCase(Case):
    def assert_refused(self, path, *words):
        result = run("info", path)
        self.assert_one_sentence(result, 1, *words)
        self.assertNotRegex(result.stderr, FOREIGN)


class Ranges(BrokenCase):
    """A bake whose numbers are, one at a time, beyond their range."""

    def setUp(self):
        super().setUp()
        scene = self.scene(spots=2)
        with open(scene) as file:
            document = json.load(file)
        document["scenes"][0]["extras"] = {"halflight_probes": [[0, 1, 0], [1, 1, 1]]}
        with open(scene, "w") as file:
            json.dump(document, file)
        options = ["--shadowmask-encoding", "distance-field", "--probe-layout", "grid"]
        self.baked, _ = self.bake(scene, "baked.glb", *options)
        self.document, self.binary = parts_of(self.baked)
        self.broken = self.path("broken.glb")

    def test_every_member(self):
        tried = 0
        for steps, least, most, above in tables()[0]:
            found = list(places(self.document, steps))
            for _, _, path in found[:1]:
                values = [most * 1.01 + 1e-3, least - 1e-3 - abs(least) * 0.01, *([0.0] if above else [])]
                for value in (v for v in values if abs(v) < 3.4028e38):
                    document = copy.deepcopy(self.document)
                    holder = document
                    for step in path[:-1]:
                        holder = holder[int(step) if isinstance(holder, list) else step]
                    key = int(path[-1]) if isinstance(holder, list) else path[-1]
                    whole = math.ceil(value) if value > most else math.floor(value)
                    holder[key] = whole if isinstance(holder[key], int) else value
                    write_glb(self.broken, document, self.binary)
                    with self.subTest(path="/".join(path), value=value):
                        self.assert_refused(self.broken, "/" + "/".join(path))
                        tried += 1
        self.assertGreater(tried, 72)

    def test_values_of_accessors(self):
        probes = self.document["extensions"]["HALFLIGHT_mixed_lighting"]["probes"]
        for steps, least, most, _ in tables()[1]:
            if steps[-1] not in probes:
                continue
            accessor = self.document["accessors"][probes[steps[-1]]]
            view = self.document["bufferViews"][accessor["bufferView"]]
            at = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
            for value in (most * 1.1 + 0.1, least - 0.1 - abs(least) * 0.1):
                binary = bytearray(self.binary)
                struct.pack_into("<f", binary, at, value)
                write_glb(self.broken, self.document, binary)
                with self.subTest(member=steps[-1], value=value):
                    self.assert_refused(self.broken, "/extensions/HALFLIGHT_mixed_lighting/probes")

    def change(self, change):
        document = copy.deepcopy(self.document)
        change(document["extensions"]["HALFLIGHT_mixed_lighting"])
        write_glb(self.broken, document, self.binary)

    def test_a_grid_that_is_not_the_probes(self):
        """Such a grid made the search for a probe's neighbours endless."""
        self.baked, _ = self.bake(self.scene(), "grid.glb", "--probe-layout", "grid")
        self.document, self.binary = parts_of(self.baked)
        for key, values in (("spacing", [1e-9] * 3), ("spacing", [3.0, 1.0, 1.0]), ("origin", [9e6, 0, 0])):
            self.change(lambda bake, key=key, values=values: bake["probes"]["grid"].update({key: values}))
            self.assert_refused(self.broken, "/probes/grid", "probe")

    def test_a_box_without_a_thickness(self):
        if "reflectionProbes" not in self.document["extensions"]["HALFLIGHT_mixed_lighting"]:
            self.skipTest("the bake has no reflection probe")
        flat = [1, 0, 0, 0, 0, 1e-9, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
        self.change(lambda bake: bake["reflectionProbes"]["probes"][0].update({"box": flat}))
        self.assert_refused(self.broken, "/reflectionProbes/probes/0", "box")

    def test_members_that_are_gone(self):
        """A tool that drops a part of the bake: the file is shown, and the loss is named."""
        for name in ("shadowmasks", "shadowmaskChannels", "probes", "reflectionProbes"):
            if name not in self.document["extensions"]["HALFLIGHT_mixed_lighting"]:
                continue
            self.change(lambda bake, name=name: bake.pop(name))
            result = run("info", self.broken)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertIn("has lost part of its bake: its " + name, result.stderr)
            self.assertIn("its " + name, " ".join(json.loads(run("info", "--json", self.broken).stdout)["lost"]))

    def test_masks_of_files_without_a_list(self):
        """As earlier versions wrote them."""

        def change(bake):
            del bake["shadowmasks"], bake["atBake"]["members"]

        self.change(change)
        self.assertIn("has lost part of its bake: its shadowmasks", run("info", self.broken).stderr)

    def test_numbers_at_their_limits_make_no_odd_pixel(self):
        def change(bake):
            bake["lightmapUnitLux"] = 1e13
            bake["sky"].update(zenith=[1e12] * 3, horizon=[1e12, 0, 1e12], ground=[0, 0, 0])
            if "reflectionProbes" in bake:
                bake["reflectionProbes"]["unitNits"] = 1e13
                for probe in bake["reflectionProbes"]["probes"]:
                    probe["fade"] = 1e-6

        self.change(change)
        picture = self.path("picture.exr")
        result = run("render", self.broken, "-o", picture, "--size", "48x32")
        self.assertEqual(result.returncode, 0, result.stderr)
        values = [value for row in report.exr_rows(pathlib.Path(picture)) for of in row.values() for value in of]
        self.assertEqual(len(values) % (48 * 32), 0)
        self.assertTrue(all(math.isfinite(value) and value >= 0 for value in values))


class NotFinite(BrokenCase):
    """A scene with each kind of accessor, of which one number is NaN or infinite."""

    def setUp(self):
        super().setUp()
        self.file = self.scene()
        with open(self.file) as file:
            self.document = json.load(file)
        uri = self.document["buffers"][0]["uri"]
        self.data = bytearray(base64.b64decode(uri.split(",", 1)[1]))
        self.kinds = {"POSITION": 0, "NORMAL": 1}
        count = self.document["accessors"][0]["count"]
        attributes = self.document["meshes"][0]["primitives"][0]["attributes"]
        for name, kind, values in (
            ("TANGENT", "VEC4", [1, 0, 0, 1] * count),
            ("TEXCOORD_0", "VEC2", [0.5, 0.5] * count),
            ("TEXCOORD_3", "VEC2", [0.5, 0.5] * count),
            ("COLOR_0", "VEC4", [1, 1, 1, 1] * count),
            ("_CUSTOM", "SCALAR", [1] * count),
        ):
            attributes[name] = self.add(name, kind, values)
        self.document["meshes"][0]["primitives"][0]["targets"] = [
            {
                "POSITION": self.add("target POSITION", "VEC3", [0, 0, 0] * count),
                "NORMAL": self.add("target NORMAL", "VEC3", [0, 0, 0] * count),
                "TANGENT": self.add("target TANGENT", "VEC3", [0, 0, 0] * count),
            }
        ]
        skinned = copy.deepcopy(self.document["meshes"][0])
        joints = self.add("JOINTS_0", "VEC4", [0, 0, 0, 0] * count, 5123, "H")
        weights = self.add("WEIGHTS_0", "VEC4", [1, 0, 0, 0] * count)
        skinned["primitives"][0]["attributes"] |= {"JOINTS_0": joints, "WEIGHTS_0": weights}
        self.document["meshes"].append(skinned)
        nodes = self.document["nodes"]
        nodes += [{"name": "joint"}, {"name": "skinned", "mesh": 1, "skin": 0}]
        self.document["scenes"][0]["nodes"] += [len(nodes) - 2, len(nodes) - 1]
        identity = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
        bind = self.add("inverse bind", "MAT4", identity)
        self.document["skins"] = [{"joints": [len(nodes) - 2], "inverseBindMatrices": bind}]
        sampler = {"input": self.add("key times", "SCALAR", [0, 1]), "output": self.add("keys", "VEC3", [0, 0, 0, 1, 0, 0])}
        target = {"node": 4, "path": "translation"}
        self.document["animations"] = [{"samplers": [sampler], "channels": [{"sampler": 0, "target": target}]}]
        spread = {"TRANSLATION": self.add("instances", "VEC3", [5, 0, 0, 6, 0, 0]), "_OWN": self.add("own", "SCALAR", [1, 2])}
        nodes.append({"name": "many", "mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": spread}}})
        self.document["scenes"][0]["nodes"].append(len(nodes) - 1)
        self.document["extensionsUsed"].append("EXT_mesh_gpu_instancing")
        self.add("unused", "SCALAR", [1, 2])

    def add(self, name, kind, values, component=5126, letter="f"):
        self.data += bytes(-len(self.data) % 4)
        packed = struct.pack(f"<{len(values)}{letter}", *values)
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(packed)}
        self.data += packed
        size = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}[kind]
        accessor = {"bufferView": len(self.document["bufferViews"]), "componentType": component, "count": len(values) // size}
        if name == "key times":
            accessor |= {"min": [0], "max": [1]}
        self.document["bufferViews"].append(view)
        self.document["accessors"].append(accessor | {"type": kind})
        self.kinds[name] = len(self.document["accessors"]) - 1
        return self.kinds[name]

    def write(self, name=None, element=1, value=math.nan):
        data = bytearray(self.data)
        if name is not None:
            accessor = self.document["accessors"][self.kinds[name]]
            size = {"SCALAR": 4, "VEC2": 8, "VEC3": 12, "VEC4": 16, "MAT4": 64}[accessor["type"]]
            start = self.document["bufferViews"][accessor["bufferView"]]["byteOffset"]
            struct.pack_into("<f", data, start + element * size, value)
        document = copy.deepcopy(self.document)
        document["buffers"] = [{"byteLength": len(data)}]
        write_glb(self.path("broken.glb"), document, data)
        return self.path("broken.glb")

    def test_the_scene_is_right_without(self):
        self.assertEqual(run("info", self.write()).returncode, 0)

    def test_each_kind_is_refused(self):
        out = self.path("out.glb")
        for name, index in self.kinds.items():
            if "TANGENT" in name or name == "JOINTS_0":
                continue
            element = 0 if name == "inverse bind" else 1
            for value in (math.nan, -math.inf):
                file = self.write(name, element, value)
                with self.subTest(kind=name, value=value):
                    words = [f"/accessors/{index}: element {element} ", "not finite"]
                    self.assert_refused(file, *words)
                    self.assert_one_sentence(run("optimize", file, out), 1, *words)
        bake = ["bake", file, "-o", out, *QUICK, "-q"]
        for command in (bake, [*bake, "--export", "unlit"], [*bake, "--sidecar", self.path("side")], ["render", file, "-o", out[:-3] + "png"]):
            self.assert_one_sentence(run(*command), 1, *words)
        self.assertFalse(os.path.exists(out))

    def test_tangents_are_made_anew(self):
        for name in ("TANGENT", "target TANGENT"):
            file, out = self.write(name), self.path(name + ".glb")
            result = run("optimize", file, out)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertIn("/meshes/0/primitives/0: its tangents are left out and made anew", result.stderr)
            result = run("bake", file, "-o", self.path("baked.glb"), *QUICK)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertIn("its tangents are left out", result.stderr)
            for written in (out, self.path("baked.glb")):
                document, binary = parts_of(written)
                self.assertNotIn("TANGENT", json.dumps(document["meshes"]))
                self.assertEqual(run("info", written).returncode, 0)
            self.assertNotIn(struct.pack("<f", math.nan), binary)

    def test_a_tangent_that_is_something_else_too(self):
        self.document["meshes"][0]["primitives"][0]["attributes"]["_OTHER"] = self.kinds["TANGENT"]
        self.assert_refused(self.write("TANGENT"), f"/accessors/{self.kinds['TANGENT']}")


class Words(BrokenCase):
    """Messages are this program's own, whatever a file holds."""

    def test_primitives_without_positions(self):
        scene = self.scene()
        with open(scene) as file:
            document = json.load(file)
        mesh = document["meshes"][0]["primitives"]
        out = self.path("out.glb")
        for attributes in ({"NORMAL": 1}, {}):
            mesh.append({"attributes": attributes})
            with open(scene, "w") as file:
                json.dump(document, file)
            result = run("optimize", scene, out)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(parts_of(out)[0]["meshes"][0]["primitives"][-1]["attributes"].keys(), attributes.keys())
            mesh.pop()
        mesh.append({"material": 0})
        with open(scene, "w") as file:
            json.dump(document, file)
        self.assert_refused(scene, "/meshes/0/primitives/1", "has no attributes")

    def test_members_that_are_gone_or_of_another_type(self):
        """Each member of a small scene is, one at a time, gone, a text, an object, a huge number and null."""
        scene = self.scene()
        with open(scene) as file:
            document = json.load(file)

        def members(value, path=()):
            for key in value if isinstance(value, dict) else range(len(value)):
                yield (*path, key)
                if isinstance(value[key], (dict, list)):
                    yield from members(value[key], (*path, key))

        gone = object()
        number = 0
        for path in members(document):
            if path[0] == "buffers" or path[-1] == "extras":
                continue
            for value in (gone, "x", {}, [], 1e38, 1 << 40, -1, None):
                number += 1
                if number % 7:  # a sample of some hundred
                    continue
                changed = copy.deepcopy(document)
                holder = changed
                for step in path[:-1]:
                    holder = holder[step]
                if value is gone:
                    del holder[path[-1]]
                else:
                    holder[path[-1]] = value
                with open(scene, "w") as file:
                    json.dump(changed, file)
                with self.subTest(path=path, value=value):
                    result = run("optimize", scene, self.path("out.glb"))
                    self.assertIn(result.returncode, (0, 1), result.stderr)
                    self.assertNotRegex(result.stderr, FOREIGN)


if __name__ == "__main__":
    cli_case.main()
