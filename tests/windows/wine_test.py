"""halflight.exe under Wine. Usage: wine_test.py HALFLIGHT SHARED_DIR [TestClass[.test]] …

HALFLIGHT is the Linux program, whose results are compared with."""

import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import wine  # finds what is in tests/cli
import tiny_scene

HALFLIGHT = ""
ASSETS = wine.ROOT / "assets"
QUICK = ["--quality", "preview", "--samples", "16", "--shadow-samples", "4", "--lightmap-size", "256"]
SLOW = ["--quality", "ultra", "--samples", "4096"]  # far longer than any test waits


def run(*words, program=None, timeout=600, **options):
    """Of the Windows program, or another program of Windows."""
    command = [wine.WINE, str(program or wine.program()), *map(str, words)]
    options.setdefault("env", wine.environment())
    return subprocess.run(command, capture_output=True, encoding="utf-8", timeout=timeout, stdin=subprocess.DEVNULL, **options)


def on_windows(path):
    """Wine's name of a file: its drive Z: is the root."""
    return "Z:" + str(path).replace("/", "\\")


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def scene(self, name="tiny.gltf"):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        tiny_scene.write(str(path))
        return path

    def assert_baked(self, result, output):
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(output.read_bytes()[:4], b"glTF")

    def assert_no_temporary(self, folder=None):
        self.assertEqual([name for name in os.listdir(folder or self.folder) if ".tmp" in name], [])


class Bytes(Case):
    """The bytes of the Linux program with the same instruction set: files, EXR pictures and the identity."""

    # Draco, Meshopt and WebP are read, area lights use most of the mathematics.
    bakes = [
        ("sphere_on_floor.glb", "avx2"),
        ("sphere_on_floor.glb", "sse2"),
        ("area_lights.glb", "avx2"),
        ("closed_room.glb", "sse2"),
        ("compressed/draco_edgebreaker.glb", "avx2"),
        ("compressed/webp.glb", "sse2"),
    ]

    def test_six_bakes(self):
        for name, instructions in self.bakes:
            with self.subTest(scene=name, isa=instructions):
                scene = ASSETS / "tests" / name
                results = []
                for system in ("linux", "windows"):
                    output, images = self.folder / f"{system}.glb", self.folder / system
                    words = ["bake", scene, "-o", output, *QUICK, "--isa", instructions, "--json", "--write-images", images]
                    if system == "linux":
                        result = subprocess.run([HALFLIGHT, *map(str, words)], capture_output=True, encoding="utf-8")
                    else:
                        result = run(*words)
                    self.assert_baked(result, output)
                    pictures = {path.name: path.read_bytes() for path in sorted(images.iterdir())}
                    results.append((json.loads(result.stdout)["identity"], output.read_bytes(), pictures))
                    output.unlink()
                    shutil.rmtree(images)
                (identity, file, pictures), (other_identity, other_file, other_pictures) = results
                self.assertEqual(identity, other_identity)
                self.assertTrue(file == other_file, "the files differ")
                self.assertTrue(any(name.endswith(".exr") for name in pictures))
                self.assertEqual(sorted(pictures), sorted(other_pictures))
                for picture in pictures:
                    self.assertTrue(pictures[picture] == other_pictures[picture], picture)


class Names(Case):
    def test_three_scripts_and_beyond_16_bits(self):
        for name in ("Grüße aus Köln", "日本語の部屋", "Комната", "a 🏠 b"):
            with self.subTest(name=name):
                scene = self.scene(f"{name}/{name}.gltf")
                output, cache = scene.parent / f"{name} gebacken.glb", scene.parent / "Čache"
                images, report = scene.parent / f"{name} 1", scene.parent / f"{name}.json"
                result = run("bake", scene, "-o", on_windows(output), *QUICK, "--cache", cache, "--write-images", images, "--report", report, "--json")
                self.assert_baked(result, output)
                self.assertIn(f"{name} gebacken.glb", json.loads(result.stdout).get("output", f"{name} gebacken.glb"))
                self.assertEqual(sorted(os.listdir(scene.parent)), sorted([scene.name, output.name, cache.name, images.name, report.name]))
                said = json.loads(run("info", on_windows(output), "--json").stdout)
                self.assertEqual(said["file"], on_windows(output))
                self.assertTrue(said["baked"])
                missing = run("info", scene.parent / f"{name}-.glb")
                self.assertEqual(missing.returncode, 1)
                self.assertIn(f"{name}-.glb: no such file", missing.stderr)

    def test_drives_folders_and_an_output_that_is_there(self):
        scene = self.scene("scene.gltf")
        output = self.folder / "out.glb"
        output.write_bytes(b"the old one")
        result = run("bake", "scene.gltf", "-o", "out.glb", *QUICK, "--quiet", cwd=self.folder)
        self.assert_baked(result, output)
        again = run("bake", on_windows(scene), "-o", on_windows(self.folder / "again.glb"), *QUICK, "--cache", on_windows(self.folder / "new" / "cache"), "--quiet")
        self.assert_baked(again, self.folder / "again.glb")
        self.assertTrue((self.folder / "new" / "cache").is_dir())
        self.assertTrue(output.read_bytes() == (self.folder / "again.glb").read_bytes())
        self.assert_no_temporary()

    def test_another_drive_and_the_folder_that_it_is_in(self):
        drive = wine.CACHE / "wine/dosdevices/y:"
        drive.unlink(missing_ok=True)
        drive.symlink_to(self.folder)
        self.addCleanup(drive.unlink)
        self.scene("scene.gltf")
        for scene, output, cache in (("Y:\\scene.gltf", "Y:\\a.glb", "Y:\\cache 1"), ("y:scene.gltf", "y:b.glb", "y:cache 2")):
            result = run("bake", scene, "-o", output, *QUICK, "--cache", cache, "--quiet")
            self.assert_baked(result, self.folder / output[-5:])
            self.assertTrue((self.folder / cache[-7:]).is_dir())
        self.assert_no_temporary()

    def test_names_that_differ_in_case_are_one_file(self):
        scene = self.scene("scene.gltf")
        before = scene.read_bytes()
        result = run("bake", on_windows(scene), "-o", on_windows(self.folder / "SCENE.GLTF"), *QUICK)
        self.assertEqual(result.returncode, 1)
        self.assertRegex(result.stderr, r"^halflight: .*SCENE\.GLTF: --output would replace the scene\r?\n$")
        self.assertEqual(scene.read_bytes(), before)

    def test_folders_and_drives_that_are_not_there(self):
        scene = on_windows(self.scene("scene.gltf"))
        for output, words in (("none\\out.glb", "the folder none does not exist"), ("Q:\\out.glb", "the folder Q:\\ does not exist")):
            result = run("bake", scene, "-o", output, *QUICK, cwd=self.folder)
            self.assertEqual((result.returncode, result.stderr), (1, f"halflight: {output}: {words}\n"))
        for file in ("Q:\\scene.glb", "\\\\nobody\\share\\scene.glb"):
            result = run("info", file)
            self.assertEqual((result.returncode, result.stderr), (1, f"halflight: {file}: no such file\n"))
        self.assertEqual(os.listdir(self.folder), ["scene.gltf"])

    def test_paths_longer_than_260_letters(self):
        parts = ["a folder with a long name " * 3 + str(i) for i in range(5)]
        scene = self.scene(os.path.join(*parts, "scene.gltf"))
        self.assertGreater(len(str(scene)), 300)
        output = scene.parent / "out.glb"
        self.assert_baked(run("bake", on_windows(scene), "-o", on_windows(output), *QUICK, "--quiet"), output)
        output.unlink()
        words = ["\\\\?\\" + on_windows(path) for path in (scene, output)]  # as programs write them
        self.assert_baked(run("bake", words[0], "-o", words[1], *QUICK, "--quiet"), output)


class Cancel(Case):
    def assert_cancelled(self, code, errors, seconds):
        self.assertEqual(code, 1, errors)
        self.assertIn("interrupted", errors)
        self.assertEqual(os.listdir(self.folder), ["tiny.gltf"])
        self.assertLess(seconds, 20.0)  # Wine's start and end, and other programs

    def test_ctrl_c(self):
        scene = self.scene()
        words = [wine.WINE, str(wine.program()), "bake", str(scene), "-o", str(self.folder / "out.glb"), *SLOW, "--progress", "lines"]
        process = subprocess.Popen(words, stderr=subprocess.PIPE, stdin=subprocess.DEVNULL, encoding="utf-8", env=wine.environment())
        for line in process.stderr:
            if line.startswith("progress: lightmap"):
                break
        begin = time.monotonic()
        process.send_signal(signal.SIGINT)  # Wine makes it Ctrl-C
        errors = process.stderr.read()
        process.stderr.close()
        self.assert_cancelled(process.wait(), errors, time.monotonic() - begin)

    def cancelled_by(self, *helping):
        """What the helper does to a bake."""
        scene = self.scene()
        helper = wine.build_helper(tempfile.mkdtemp(dir=wine.CACHE))
        self.addCleanup(shutil.rmtree, os.path.dirname(helper))
        begin = time.monotonic()
        result = run(*helping, on_windows(wine.program()), "bake", on_windows(scene), "-o", on_windows(self.folder / "out.glb"), *SLOW, program=helper)
        self.assert_cancelled(result.returncode, result.stderr, time.monotonic() - begin)

    def test_the_event_of_a_program_without_a_console(self):
        self.cancelled_by("cancel", 500)

    def test_a_closed_console(self):
        self.cancelled_by("console", 500, 2)

    def test_ctrl_break(self):
        self.cancelled_by("console", 500, 1)


class OpenFiles(Case):
    """Windows replaces no file that another program has open."""

    def bake_while_open(self, milliseconds):
        scene = self.scene()
        output = self.folder / "out.glb"
        output.write_bytes(b"the old one")
        helper = wine.build_helper(tempfile.mkdtemp(dir=wine.CACHE))
        self.addCleanup(shutil.rmtree, os.path.dirname(helper))
        words = [on_windows(wine.program()), "bake", on_windows(scene), "-o", on_windows(output), *QUICK, "--quiet"]
        return run("hold", milliseconds, on_windows(output), *words, program=helper), output

    def test_is_a_sentence(self):
        result, output = self.bake_while_open(600_000)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("out.glb: cannot be replaced (another program has it open)", result.stderr)
        self.assertEqual(output.read_bytes(), b"the old one")
        self.assert_no_temporary()

    def test_is_replaced_once_it_is_closed(self):
        result, output = self.bake_while_open(300)
        self.assert_baked(result, output)


class Programs(Case):
    """GoogleTest programs of base, scene and bake (programs/CMakeLists.txt): the stored bits of the mathematics, among others."""

    # Links need a right that users of Windows rarely have. The last compares with MinGW's long double, which is wrong for
    # large angles; the stored bits are compared in other tests.
    left_out = "-FilesInUse.OneFileHasManyNames:FilesInUse.FilesThatAreYetToBeMade:Mathematics.IsAsExactAsTheHeaderSays"

    def test_pass(self):
        build = wine.ROOT / "build/windows"
        if not pathlib.Path("/usr/src/googletest/CMakeLists.txt").exists():
            self.skipTest("GoogleTest's sources are not installed (apt-get install googletest)")
        subprocess.run(["cmake", "--build", build, "--target", "windows_tests", "--", "--quiet"], check=True, stdout=subprocess.DEVNULL)
        for name, least in (("base", 20), ("scene", 30), ("bake", 15)):
            with self.subTest(program=name):
                result = run("--gtest_brief=1", f"--gtest_filter={self.left_out}", program=build / f"tests/windows/programs/test_{name}.exe")
                self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
                passed = int(re.search(r"\[  PASSED  \] (\d+) test", result.stdout)[1])
                self.assertGreaterEqual(passed, least)
                print(f"test_{name}.exe: {passed} tests passed")


class Picture(Case):
    """halflight.exe render, by Windows' Vulkan loader, which Wine connects to this system's."""

    def test_the_bytes_of_linux(self):
        baked = self.folder / "baked.glb"
        subprocess.run([HALFLIGHT, "bake", ASSETS / "tests/sphere_on_floor.glb", "-o", baked, *QUICK, "--quiet"], check=True)
        words = ["render", str(baked), "--size", "320x240", "--device", "cpu", "--json", "-o"]
        subprocess.run([HALFLIGHT, *words, self.folder / "linux.png"], check=True, capture_output=True)
        result = run(*words, self.folder / "windows.png")
        self.assertEqual(result.returncode, 0, result.stderr)
        linux, windows = ((self.folder / f"{name}.png").read_bytes() for name in ("linux", "windows"))
        keep = os.environ.get("HALFLIGHT_KEEP_PICTURE")
        if keep:
            pathlib.Path(keep).write_bytes(windows)
        self.assertTrue(linux == windows, "the pictures differ")


if __name__ == "__main__":
    HALFLIGHT = os.path.abspath(sys.argv[1])
    wine.run_tests()
