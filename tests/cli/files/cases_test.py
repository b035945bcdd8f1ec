"""Small inputs that once gave a wrong picture, a refusal or a crash, each with its right value.
Usage: cases_test.py HALFLIGHT SHARED_DIR [TestClass[.test]] …   The inputs lie in SHARED_DIR/cases; without them all is
skipped (exit code 77, ctest: skipped). The kinds that they belong to have tests beside the code."""

import itertools
import json
import math
import os
import resource
import subprocess
import sys
import unittest

import cli_case
from cli_case import QUICK, Case, decode_png, edited, read, run

VIEW = ["--size", "160x120", "--exposure", "1.5"]


def cases(*parts):
    return os.path.join(cli_case.SHARED, "cases", *parts)


class SharedCase(Case):
    def setUp(self):
        if not os.path.isdir(cases()):
            self.skipTest("no shared cases beside this checkout")
        super().setUp()

    def baked(self, scene, *arguments, name="baked.glb"):
        return self.bake(scene, name, *arguments)[0]

    def picture(self, file, *arguments):
        """Rows of RGB, 0…1."""
        path = self.path("picture.png")
        result = run("render", file, "-o", path, *VIEW, *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        return [[[c / 255 for c in pixel] for pixel in row] for row in decode_png(path)[2]]

    def difference(self, a, b):
        """Mean absolute difference, and the share of pixels that differ by more than a tenth."""
        pairs = [(p, q) for r, s in zip(a, b) for p, q in zip(r, s)]
        each = [max(abs(x - y) for x, y in zip(p, q)) for p, q in pairs]
        return sum(each) / len(each), sum(d > 0.1 for d in each) / len(each)

    def assert_same_picture(self, a, b, mean=0.01, share=0.01):
        off, far = self.difference(a, b)
        self.assertLess(off, mean)
        self.assertLess(far, share)

    def info(self, file):
        result = run("info", file, "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        return json.loads(result.stdout)


class Pictures(SharedCase):
    def test_kept_coordinates_of_shared_meshes(self):
        for name in ("sharedkept.glb", "keptextras.glb"):
            with self.subTest(name=name):
                scene = cases("kept-uv1-shared-mesh", name)
                good = ["--samples", "32", "--lightmap-size", "256"]
                kept = self.picture(self.baked(scene, *good))
                self.assert_same_picture(kept, self.picture(self.baked(scene, *good, "--uv", "unwrap")), 0.02, 0.02)
                self.assert_same_picture(kept, self.picture(scene, "--reference", "64", "--bounces", "1"), 0.03, 0.04)

    def test_texture_that_reads_the_second_set(self):
        scene = cases("uv1-read-by-material", "uv1_valid.glb")
        baked = self.baked(scene)
        for mode in (["--mode", "realtime"], ["--reference", "8"]):
            plain = self.picture(scene, *mode)
            self.assert_same_picture(plain, self.picture(baked, *mode))
            colours = {tuple(round(c, 1) for c in pixel) for row in plain for pixel in row}
            self.assertGreater(len(colours), 2, "the checks are one colour")

    def test_default_view_is_outside(self):
        scene = cases("default-view", "cube.gltf")
        bounds = self.info(scene)["bounds"]
        result = run("render", scene, "-o", self.path("picture.png"), *VIEW, "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        camera = json.loads(result.stdout)["camera"]
        eye, target = camera["eye"], camera["target"]
        inside = [low <= e <= high for low, e, high in zip(bounds["min"], eye, bounds["max"])]
        self.assertFalse(all(inside), "the view stands inside")
        # All corners of the bounds lie within the picture, 160 x 120, Y up.
        forward = [t - e for t, e in zip(target, eye)]
        right = [-forward[2], 0, forward[0]]
        up = [
            right[1] * forward[2] - right[2] * forward[1],
            right[2] * forward[0] - right[0] * forward[2],
            right[0] * forward[1] - right[1] * forward[0],
        ]
        forward, right, up = ([c / math.hypot(*axis) for c in axis] for axis in (forward, right, up))
        half = math.tan(math.radians(camera["verticalFovDegrees"]) / 2)
        for corner in itertools.product(*zip(bounds["min"], bounds["max"])):
            way = [c - e for c, e in zip(corner, eye)]
            along, x, y = (sum(a * w for a, w in zip(axis, way)) for axis in (forward, right, up))
            self.assertGreater(along, 0)
            self.assertLess(abs(y), half * along)
            self.assertLess(abs(x), half * along * 160 / 120)

    def test_georeferenced(self):
        scene = cases("georeferenced", "geo_utm.glb")
        near = edited(scene, self.path("near.glb"), lambda d: d["nodes"][4].pop("translation"))
        good = ["--samples", "32", "--lightmap-size", "256"]
        for mode in ("shadowmask", "distance-shadowmask", "realtime"):
            far_picture = self.picture(self.baked(scene, *good, name="far.glb"), "--mode", mode)
            self.assert_same_picture(
                far_picture, self.picture(self.baked(near, *good, name="n.glb"), "--mode", mode), 0.01, 0.01
            )
        bounds = self.info(scene)["bounds"]
        self.assertAlmostEqual((bounds["min"][0] + bounds["max"][0]) / 2, 5e5, delta=10)
        self.assertAlmostEqual((bounds["min"][2] + bounds["max"][2]) / 2, -5e6, delta=10)

    def test_skins_are_where_their_joints_are(self):
        scene = cases("skin-rest-pose", "skin_moved.glb")

        def plain_box(document):
            node = document["nodes"][4]
            del node["skin"]
            node["translation"] = [-1.5 - 1.0, 0.5, 0.0]  # its parent stands at x = 1

        plain = edited(scene, self.path("plain.glb"), plain_box)
        self.assert_same_picture(self.picture(scene), self.picture(plain), 0.002, 0.002)
        flat = edited(scene, self.path("flat.glb"), lambda d: d["nodes"][4].update(scale=[0, 0, 0]))
        self.assert_same_picture(self.picture(flat), self.picture(plain), 0.002, 0.002)

    def test_specular_glossiness(self):
        scene = cases("specgloss-silent-metal", "specgloss.glb")

        def rough(document):
            document["materials"][1] = {
                "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0, "roughnessFactor": 1}
            }

        self.assert_same_picture(
            self.picture(scene), self.picture(edited(scene, self.path("rough.glb"), rough)), 0.02, 0.02
        )
        self.assertTrue(any("pbrSpecularGlossiness" in w for w in self.info(scene)["warnings"]))


class Reading(SharedCase):
    def test_plus_in_a_uri(self):
        self.assertEqual(self.info(cases("buffer-uri-plus", "s.gltf"))["triangles"]["drawn"] > 0, True)

    def test_harmless_extensions(self):
        for name in ("ior", "clearcoat"):
            info = self.info(cases("harmless-extensions", f"req_KHR_materials_{name}.glb"))
            named = [w for w in info["warnings"] if f"KHR_materials_{name}" in w]
            self.assertEqual(len(named), 1, info["warnings"])

    def test_pointers_move_nodes(self):
        objects = self.info(cases("animation-pointer-node-static", "animptr_node.glb"))["objects"]
        self.assertEqual((objects["static"], objects["dynamic"]), (1, 1))

    def test_odd_cameras(self):
        for name in ("cam_near0.glb", "cam_farlt.glb"):
            scene = cases("odd-cameras", name)
            self.assertTrue(any("cameras/0" in w for w in self.info(scene)["warnings"]), name)
            self.baked(scene)
        tiny = lambda d: d["cameras"][0]["perspective"].update(znear=5e-7)
        scene = edited(cases("odd-cameras", "cam_near0.glb"), self.path("tiny.glb"), tiny)
        self.assertEqual(self.info(scene)["cameras"], ["cam"])


class Attack(SharedCase):
    def assert_refused(self, name, *words):
        for command in (["info"], ["bake", "-o", self.path("out.glb"), *QUICK]):
            with self.subTest(name=name, command=command[0]):
                result = run(command[0], cases("attack", name), *command[1:], timeout=60)
                self.assert_one_sentence(result, 1, name, *words)
                self.assertNotIn("json.exception", result.stderr)
                self.assert_folder_holds()

    def test_wrong_types(self):
        names = [n for n in os.listdir(cases("attack")) if n.startswith("wrong-type")]
        self.assertEqual(len(names), 6)
        for name in names:
            self.assert_refused(name, ": /")

    def test_memory_has_a_limit(self):
        for name in ("implicit200.glb", "images200.glb"):
            before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
            result = run("info", cases("attack", name), timeout=60)
            peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
            self.assertIn(result.returncode, (0, 1), result.stderr)
            self.assertLess(max(peak, before), 1_500_000, name)  # kilobytes

    def test_uris(self):
        self.assert_refused("dot.gltf", "/buffers/0")
        self.assertEqual(run("info", cases("attack", "longer_bin.gltf")).returncode, 0)
        pipe = self.path("pipe.bin")
        os.mkfifo(pipe)
        with open(cases("attack", "longer_bin.gltf")) as file:
            document = json.load(file)
        document["buffers"][0]["uri"] = "pipe.bin"
        with open(self.path("pipe.gltf"), "w") as file:
            json.dump(document, file)
        self.assert_one_sentence(run("info", self.path("pipe.gltf"), timeout=20), 1, "/buffers/0")

    def test_names_are_escaped(self):
        result = run("info", cases("attack", "names.glb"))
        for text in (result.stdout, result.stderr):
            self.assertNotIn("\x1b", text)
            self.assertNotIn("\x9b", text)

    def test_radiance_beyond_floats(self):
        self.assert_refused("nan-probes.glb", ": /")


class WebBroken(SharedCase):
    """The 45 broken copies of a baked file that the cases' own program makes: none is shown in silence."""

    def test_each_is_refused_or_warned_of(self):
        scene = os.path.join(os.path.dirname(__file__), "../../../assets/tests/five_lights.glb")
        baked, folder = self.path("baked.glb"), self.path("broken")
        result = run("bake", scene, "-o", baked, "--quality", "preview", "--lightmap-size", "128", "-q")
        self.assertEqual(result.returncode, 0, result.stderr)
        sound = run("info", baked).stderr
        made = subprocess.run(
            [sys.executable, cases("web-broken", "make.py"), baked, folder], capture_output=True, text=True
        )
        self.assertEqual(made.returncode, 0, made.stderr)
        with open(os.path.join(folder, "names.json")) as file:
            names = json.load(file)
        self.assertEqual(len(names), 45)
        refused = 0
        for name in names:
            path = os.path.join(folder, name + ".glb")
            with self.subTest(name=name):
                result = run("info", path, timeout=60)
                self.assertIn(result.returncode, (0, 1), result.stderr)
                self.assertNotRegex(result.stderr, r"json\.exception|std::|internal error")
                self.assertNotEqual(result.stderr, sound, "it is shown as if it were sound")
                self.assertEqual(len(result.stderr.splitlines()) == 1 or result.returncode == 0, True, result.stderr)
                refused += result.returncode
        self.assertGreaterEqual(refused, 38)
        for name in ("radiance_huge", "reflections_box_huge", "reflections_fade", "reflections_unit", "sky_negative"):
            path = os.path.join(folder, name + ".glb")
            for command in (["info", path], ["optimize", path, self.path("o.glb")], ["render", path, "-o", self.path("o.png")]):
                self.assert_one_sentence(run(*command), 1, name, "/extensions/HALFLIGHT_mixed_lighting/")
        self.assertIn("its shadowmasks", run("info", os.path.join(folder, "masks_gone.glb")).stderr)


if __name__ == "__main__":
    cli_case.main()
