"""What a farm's folder may hold, and what else is found there. Usage: plan_test.py HALFLIGHT SHARED_DIR [TestClass[.test]] …"""

import copy
import glob
import json
import os

import cli_case
from broken_test import FOREIGN
from cli_case import QUICK, read, run
from farm_test import FarmCase


class Plans(FarmCase):
    """A plan is input as any other: what is wrong in it is named, before anything is computed or written."""

    def setUp(self):
        super().setUp()
        self.folder_of_plan = self.plan(self.scene(), *QUICK)
        self.plan_file = os.path.join(self.folder_of_plan, "plan.json")
        self.right = json.loads(read(self.plan_file))
        self.out = self.path("out.glb")
        plan = self.folder_of_plan
        self.commands = [["work", plan], ["join", plan, "-o", self.out], ["status", plan], ["status", plan, "--missing"]]

    def write(self, text):
        with open(self.plan_file, "w") as file:
            file.write(text if isinstance(text, str) else json.dumps(text))

    def refused(self, *words):
        """By all commands that read a plan, in one printable sentence."""
        plan = self.folder_of_plan
        held = sorted(os.listdir(self.folder.name)), sorted(os.listdir(plan))
        self.commands = self.commands[1:] + self.commands[:1]  # one of them after another: all read it by one function
        for command in self.commands[:1]:
            result = run("farm", *command)
            self.assert_one_sentence(result, 1, "plan.json", *words)
            self.assertNotRegex(result.stderr, FOREIGN)
            self.assertTrue(result.stderr[:-1].isprintable(), result.stderr)
        self.assertEqual((sorted(os.listdir(self.folder.name)), sorted(os.listdir(plan))), held)

    def refused_with(self, key, value, *words):
        changed = copy.deepcopy(self.right)
        changed["scenes"][0][key] = value
        self.write(changed)
        with self.subTest(key=key, value=value):
            self.refused(f"/scenes/0/{key}", *words)

    def test_numbers(self):
        for key in ("tiles", "texels", "maskLayers"):
            for value in (-1, 1.8e19, 1e300, 3.7, 1 << 63, 10**9, "12", None, True, [3]):
                if key == "texels" and value == 10**9:
                    continue  # a number of texels, of which there are then other tiles
                self.refused_with(key, value)
        changed = copy.deepcopy(self.right)
        changed["scenes"][0].update(texels=10**9)
        self.write(changed)
        self.refused("/scenes/0/tiles")

    def test_other_texels_than_the_scene_has(self):
        """As many tiles, one texel fewer: the worker sees it when it has rasterized the scene."""
        changed = copy.deepcopy(self.right)
        changed["scenes"][0]["texels"] -= 1
        self.write(changed)
        self.assert_one_sentence(run("farm", "work", self.folder_of_plan, "-q"), 1, "plan anew")

    def test_types(self):
        for key in ("name", "scene", "settings", "options", "cache", "inputs", "parts", "maskLayers", "identity"):
            self.refused_with(key, {"a": 1})
            changed = copy.deepcopy(self.right)
            del changed["scenes"][0][key]
            self.write(changed)
            self.refused(f"/scenes/0/{key}")
        self.refused_with("workers", 4294967295, "no part of a plan")
        for text in ("", "{", "[]", "3", '"x"', "null", "[" * 10000, json.dumps(self.right)[:-5]):
            self.write(text)
            self.refused()
        for key, value in (("scenes", []), ("scenes", {}), ("scenes", 1), ("compares", 1), ("version", 1), ("version", "2")):
            self.write({**self.right, key: value})
            self.refused()

    def test_options(self):
        for options in (
            ["--help"],
            ["-h"],
            ["--report", self.path("r.json")],
            ["--cache", self.path("c")],
            ["--settings", "x.toml"],
            ["--sidecar", self.path("s")],
            ["-o", self.path("o.glb")],
            ["--samples", "0x10"],
            ["--samples", ""],
            ["--time", "9s"],
            ["--noise", "2%", "--integrator", "path"],
            ["another.glb"],
            ["--version"],
            ["--\x1b[31m"],
        ):
            self.refused_with("options", options)
        self.refused_with("options", [1])
        self.refused_with("options", "--samples")

    def test_names(self):
        for name in ("../up", "a/b", "/abs", "..", ".", "", "red\x1b[31m", "line\nbreak", "c1\u009b31m", "nul\0"):
            self.refused_with("name", name)
        for place in ("../tiny.gltf", "/etc/passwd", "scenes/../../x.gltf", ""):
            self.refused_with("scene", place)
        for place in ("../cache", "/tmp", ""):
            self.refused_with("cache", place)
        for folder in ("..", "a/b", "../x.tiles", ""):
            self.refused_with("parts", folder)
        two = copy.deepcopy(self.right)
        two["scenes"].append(two["scenes"][0])
        self.write(two)
        self.refused("/scenes/1/name")

    def test_numbers_of_workers(self):
        workers = os.path.join(self.folder_of_plan, "workers")
        for text in ("4294967295\n", "1e300", "3.7", "0", "-1", "", "four", "16777217", "1\n2\n", "\x1b[31m"):
            with open(workers, "w") as file:
                file.write(text)
            for command in (["status"], ["status", "--missing"], ["join", "-o", self.out]):
                result = run("farm", command[0], self.folder_of_plan, *command[1:])
                with self.subTest(text=text, command=command):
                    self.assert_one_sentence(result, 1, "workers", "--of")
        self.assertEqual(run("farm", "status", self.folder_of_plan, "--of", 3).returncode, 0)
        most = run("farm", "status", self.folder_of_plan, "--of", 1 << 24, "--missing")
        self.assertEqual(most.returncode, 0, most.stderr)
        self.assertEqual(self.work(self.folder_of_plan, 0, 1).returncode, 0)
        self.assertEqual(read(workers), b"1\n")

    def test_a_scenes_own_name_is_made_printable(self):
        odd = self.path("odd\x1b[31m\nname.gltf")
        os.rename(self.path("tiny.gltf"), odd)
        plan = self.plan(odd, *QUICK, folder="second")
        result = run("farm", "status", plan)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertTrue(all(line.isprintable() for line in result.stdout.splitlines()), result.stdout)
        self.assertEqual(len(result.stdout.splitlines()), 2)


class TakenPlaces(FarmCase):
    """A folder where a part's file belongs gets another name; what is in it stays."""

    def test_of_a_worker(self):
        scene = self.scene()
        expected = self.baked(scene, *QUICK)
        plan = self.plan(scene, *QUICK)
        self.assertEqual(self.work(plan, 0, 1).returncode, 0)
        path = self.parts(plan, "lightmap")[0]
        for number, name in ((1, path + ".broken"), (2, path + ".broken-2")):
            os.remove(path)
            os.mkdir(path)
            with open(os.path.join(path, "mine"), "w") as file:
                file.write(f"kept {number}")
            result = self.work(plan, 0, 1)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertIn(os.path.basename(name), result.stderr)
            self.assertIn(os.path.basename(path) + " was a folder", result.stderr)
            self.assertEqual(read(os.path.join(name, "mine")).decode(), f"kept {number}")
            self.assertTrue(os.path.isfile(path))
        self.assertEqual(self.joined(plan), expected)

    def test_of_a_cache(self):
        scene, cache = self.scene(), self.path("cache")
        first, _ = self.bake(scene, "first.glb", "--cache", cache)
        folder = glob.glob(os.path.join(cache, "*", "*.tiles"))[0]
        path = os.path.join(folder, sorted(name for name in os.listdir(folder) if name.startswith("lightmap-"))[0])
        os.remove(path)
        os.mkdir(path)
        os.remove(first)
        second, report = self.bake(scene, "second.glb", "--cache", cache)
        self.assertTrue(any(".broken now" in warning for warning in report["warnings"]), report["warnings"])
        self.assertTrue(os.path.isdir(path + ".broken") and os.path.isfile(path))


if __name__ == "__main__":
    cli_case.main()
