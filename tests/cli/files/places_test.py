"""Where outputs and messages go, and what happens where they cannot.
Usage: places_test.py HALFLIGHT SHARED_DIR [TestClass[.test]] …"""

import base64
import json
import os
import resource
import shutil
import subprocess

import cli_case
import tiny_scene
from cli_case import QUICK, Case, read, run


class Places(Case):
    """Places that are written at the end are tried at the start; a cache that fails on the way costs no bake."""

    def test_places_that_cannot_be_written_are_found_before_the_bake(self):
        scene, out, file = self.scene(), self.path("out.glb"), self.path("file")
        with open(file, "w"):
            pass
        cases = [
            ["-o", "/proc/out.glb"],
            ["-o", out, "--report", "/proc/report.json"],
            ["-o", out, "--write-images", file],
            ["-o", out, "--write-images", "/proc/images"],
            ["-o", out, "--cache", file],
            ["-o", out, "--cache", "/proc/cache"],
        ]
        for arguments in cases:
            with self.subTest(arguments=arguments):
                result = run("bake", scene, *arguments, *QUICK)
                self.assert_one_sentence(result, 1, arguments[-1])  # one sentence: no stage has begun
                self.assert_folder_holds("file", "tiny.gltf")

    def test_a_cache_that_fails_on_the_way_is_a_warning(self):
        scene, out, cache = self.scene(), self.path("out.glb"), self.path("cache")
        self.bake(scene, "out.glb", "--cache", cache)
        expected = read(out)
        os.remove(out)
        for path in [os.path.join(folder, name) for folder, _, names in os.walk(cache) for name in names]:
            os.remove(path)  # folders where files would be written
            os.mkdir(path)
            open(os.path.join(path, "full"), "w").close()
        result = run("bake", scene, "-o", out, *QUICK, "--cache", cache)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("the cache " + cache, result.stderr)
        self.assertEqual(read(out), expected)

    def test_pictures_that_cannot_be_written_cost_no_bake(self):
        scene, out, images = self.scene(), self.path("out.glb"), self.path("images")
        os.makedirs(os.path.join(images, "lightmap_0.exr"))
        result = run("bake", scene, "-o", out, *QUICK, "--write-images", images)
        self.assertEqual(result.returncode, 1)
        self.assertIn("lightmap_0.exr", result.stderr.splitlines()[-1])
        self.assertEqual(run("info", out).returncode, 0)

    def test_gltf_with_files_beside_it(self):
        scene = self.scene()
        one, _ = self.bake(scene, "one.glb")
        separate, _ = self.bake(scene, "separate.gltf")
        self.assert_folder_holds("one.glb", "separate.bin", "separate.gltf", "tiny.gltf")
        info = [json.loads(run("info", file, "--json").stdout) for file in (one, separate)]
        for result in info:
            del result["file"]
        self.assertEqual(*info)
        pictures = []
        for file in (one, separate):
            picture = self.path("picture.png")
            self.assertEqual(run("render", file, "-o", picture, "--size", "32x32").returncode, 0)
            pictures.append(read(picture))
        self.assertEqual(*pictures)

    def test_files_beside_a_gltf_never_replace_the_scenes(self):
        scene, buffer = self.path("scene.gltf"), self.path("baked.bin")
        tiny_scene.write(scene)
        with open(scene) as file:
            document = json.load(file)
        with open(buffer, "wb") as file:
            file.write(base64.b64decode(document["buffers"][0]["uri"].split(",")[1]))
        document["buffers"][0]["uri"] = "baked.bin"
        with open(scene, "w") as file:
            json.dump(document, file)
        before = read(buffer)
        result = run("bake", scene, "-o", self.path("baked.gltf"), *QUICK)
        self.assert_one_sentence(result, 1, buffer, "--output would replace the scene's baked.bin")
        self.assertEqual(read(buffer), before)

    def test_what_is_written_makes_an_output_up_to_date(self):
        scene, cache, out = self.scene(), self.path("cache"), self.path("out.glb")
        half, _ = self.bake(scene, "half.glb", "--lightmap-format", "half")
        run("bake", scene, "-o", out, *QUICK, "--cache", cache)
        again = run("bake", scene, "-o", out, *QUICK, "--cache", cache, "--lightmap-format", "half")
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual(read(out), read(half))


class Streams(Case):
    """Messages never end a bake; results that cannot be written are failures; names cannot steer a terminal."""

    def shell(self, command, **variables):
        return subprocess.run(
            ["bash", "-c", command], capture_output=True, text=True, timeout=240, env={**os.environ, **variables}
        )

    def bake_in_shell(self, redirection):
        out = self.path("out.glb")
        result = self.shell(
            '"$H" bake "$S" -o "$O" ' + " ".join(QUICK) + " " + redirection, H=cli_case.HALFLIGHT, S=self.scene(), O=out
        )
        whole = os.path.exists(out) and read(out)[:4] == b"glTF"
        if whole:
            self.assertEqual(run("info", out).returncode, 0)
            os.remove(out)
        return result, whole

    def test_messages_that_cannot_be_written_lose_nothing(self):
        for redirection in ("2>/dev/full >/dev/null", "2>&- >/dev/null", ">/dev/null 2> >(exec true)"):
            with self.subTest(redirection=redirection):
                result, whole = self.bake_in_shell(redirection)
                self.assertEqual((result.returncode, whole), (0, True), result.stderr)

    def test_results_that_cannot_be_written_are_1(self):
        for redirection in (">/dev/full", ">&-", "--json >/dev/full", "--json > >(exec true)", ">/dev/full 2>/dev/full"):
            with self.subTest(redirection=redirection):
                result, whole = self.bake_in_shell(redirection)
                self.assertEqual((result.returncode, whole), (1, True), result.stderr)
                if "2>" not in redirection:
                    self.assertIn("standard output cannot be written", result.stderr.splitlines()[-1])
        for command in ("info", "--help", "--version", "bake --help"):
            result = self.shell(f'"$H" {command} {chr(34) + "$S" + chr(34) if command == "info" else ""} >/dev/full',
                                H=cli_case.HALFLIGHT, S=self.scene())
            self.assertEqual(result.returncode, 1, command)

    def test_a_file_size_limit_is_an_error_of_writing(self):
        result, whole = self.bake_in_shell("2>&1 >/dev/null | cat; exit ${PIPESTATUS[0]}")
        self.assertEqual((result.returncode, whole), (0, True), result.stdout)
        out = self.path("out.glb")
        result = self.shell(
            'ulimit -f 4; "$H" bake "$S" -o "$O" ' + " ".join(QUICK) + " 2>&1 >/dev/null | cat; exit ${PIPESTATUS[0]}",
            H=cli_case.HALFLIGHT, S=self.scene(), O=out,
        )
        self.assertEqual(result.returncode, 1, result.stdout)
        self.assertIn(out + ": could not be written", result.stdout.splitlines()[-1])
        self.assert_folder_holds("tiny.gltf")

    def test_progress_in_a_log_is_one_line_a_stage(self):
        result = run("bake", self.scene(), "-o", self.path("out.glb"), *QUICK, "--samples", "16")
        self.assertEqual(result.returncode, 0, result.stderr)
        lines = result.stderr.splitlines()
        stages = [line.split()[0] for line in lines]
        self.assertEqual(len(stages), len(set(stages)), result.stderr)
        for line in lines:
            self.assertRegex(line, r"^[a-z ]+( \d+ %)* \d+\.\d s$")

    def test_names_cannot_steer_the_terminal(self):
        bad = "a\n\x1b[31m\x9b2J\u009b1m\u202eb\x7f"
        path = self.path("named.gltf")
        tiny_scene.write(path)
        with open(path) as file:
            document = json.load(file)
        for kind in ("nodes", "cameras", "meshes", "materials"):
            for element in document.get(kind, []):
                element["name"] = bad
        for light in document["extensions"]["KHR_lights_punctual"]["lights"]:
            light["name"] = bad
        document["nodes"][0].setdefault("extras", {})["halflight_nonsense" + bad] = 1
        with open(path, "w") as file:
            json.dump(document, file)
        out, png = self.path("out.glb"), self.path("out.png")
        commands = (
            ["info", path], ["info", path, "--json"], ["bake", path, "-o", out, *QUICK],
            ["bake", path, "-o", out, *QUICK, "--json"], ["render", path, "-o", png, "--size", "16x16"],
            ["render", path, "-o", png, "--size", "16x16", "--json"], ["render", path, "-o", png, "--camera", "x"],
            ["render", path, "-o", png, "--light", "x:intensity=1"],
        )
        for command in commands:
            with self.subTest(command=command):
                result = run(*command)
                for text in (result.stdout, result.stderr):
                    for control in ("\x1b", "\x9b", "\u202e", "\x7f"):
                        self.assertNotIn(control, text)
                if "--json" in command:
                    self.assertIn(bad, "\n".join(self.strings(json.loads(result.stdout))))
                for line in result.stderr.splitlines():
                    self.assertRegex(line, r"^(halflight: |[a-z ]+ \d)")

    def strings(self, value):
        if isinstance(value, str):
            yield value
        elif isinstance(value, (list, dict)):
            for item in value.values() if isinstance(value, dict) else value:
                yield from self.strings(item)


class FullDisk(Case):
    """Files of one option are whole, all of them, or none is there."""

    def setUp(self):
        super().setUp()
        self.file = self.scene()
        with open(self.path("sky.hdr"), "wb") as file:  # 4 x 2 texels of (1, 1, 1)
            file.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n" + bytes([128, 128, 128, 129]) * 8)
        with open(self.path("sky.toml"), "w") as file:
            file.write('[sky]\nimage = "sky.hdr"\n')
        self.options = ["--settings", self.path("sky.toml"), "--directional", "on", *QUICK, "-q"]

    def bake_within(self, most, *arguments):
        """Files cannot grow beyond `most` bytes."""
        command = ["bake", self.file, *map(str, arguments), *self.options]
        return subprocess.run(
            [cli_case.HALFLIGHT, *command],
            capture_output=True,
            text=True,
            stdin=subprocess.DEVNULL,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (most, most)),
        )

    def sizes(self, folder):
        return {entry.name: entry.stat().st_size for entry in os.scandir(folder)}

    def check(self, folder, *arguments):
        """With every limit at which some file of the folder no longer fits."""
        whole = run("bake", self.file, *arguments, *self.options)
        self.assertEqual(whole.returncode, 0, whole.stderr)
        sizes = self.sizes(folder)
        self.assertGreater(len(sizes), 1)
        for name in sizes:
            os.remove(os.path.join(folder, name))
        for most in sorted(set(sizes.values()))[:-1] + [max(sizes.values()) - 1]:
            with self.subTest(most=most):
                result = self.bake_within(max(most, 4096), *arguments)
                if max(most, 4096) >= max(sizes.values()):
                    continue
                self.assertEqual(result.returncode, 1, result.stderr)
                self.assertEqual(self.sizes(folder) if os.path.isdir(folder) else {}, {}, result.stderr)

    def test_a_gltf_with_its_buffer_and_pictures(self):
        with open(self.file) as file:
            document = json.load(file)
        document["images"] = [{"uri": "data:image/png;base64," + SMALL_PNG}]
        document["textures"] = [{"source": 0}]
        document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {"index": 0}
        with open(self.file, "w") as file:
            json.dump(document, file)
        os.mkdir(self.path("out"))
        self.check(self.path("out"), "-o", self.path("out/baked.gltf"))

    def test_a_sidecar(self):
        self.check(self.path("side"), "-o", self.path("baked.glb"), "--sidecar", self.path("side"))

    def test_pictures_leave_the_baked_file(self):
        images, out = self.path("images"), self.path("baked.gltf")
        self.check(images, "-o", out, "--write-images", images)
        os.remove(out)
        os.makedirs(images, exist_ok=True)
        os.mkdir(os.path.join(images, "probes.json"))
        result = run("bake", self.file, "-o", out, "--write-images", images, *self.options)
        self.assertEqual(result.returncode, 1)
        self.assertIn("probes.json", result.stderr)
        self.assertEqual(os.listdir(images), ["probes.json"])
        self.assertEqual(run("info", out).returncode, 0)

    def test_a_disk_that_is_full(self):
        """Not a limit of the process, but no space: of a disk of 200 kB."""
        disk = self.path("disk")
        os.mkdir(disk)
        mounted = shutil.which("mount") and subprocess.run(
            ["mount", "-t", "tmpfs", "-o", "size=200k", "tmpfs", disk], capture_output=True
        )
        if not mounted or mounted.returncode != 0:
            self.skipTest("no right to mount a small disk")
        self.addCleanup(subprocess.run, ["umount", disk])
        whole = run("bake", self.file, "-o", self.path("whole.glb"), "--sidecar", self.path("side"), *self.options)
        self.assertEqual(whole.returncode, 0, whole.stderr)
        self.assertGreater(sum(self.sizes(self.path("side")).values()), 200_000)
        for arguments in (
            ["-o", self.path("baked.glb"), "--sidecar", os.path.join(disk, "side")],
            ["-o", self.path("baked.glb"), "--write-images", os.path.join(disk, "images")],
            ["-o", os.path.join(disk, "baked.gltf")],
        ):
            with self.subTest(arguments=arguments):
                result = run("bake", self.file, *arguments, *self.options)
                self.assertEqual(result.returncode, 1, result.stderr)
                self.assertEqual(os.listdir(disk), [], result.stderr)
        with open(os.path.join(disk, "fill"), "wb") as file:
            file.write(bytes(190_000))
        picture = os.path.join(disk, "picture.exr")
        result = run("render", self.file, "-o", picture, "--size", "256x256", "--reference", 1, "-q")
        self.assert_one_sentence(result, 1, picture)
        self.assertEqual(os.listdir(disk), ["fill"])


# A grey texel (PNG).
SMALL_PNG = (
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="
)

if __name__ == "__main__":
    cli_case.main()
