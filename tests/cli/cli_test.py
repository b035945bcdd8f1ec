"""End-to-end tests of the halflight program. Usage: cli_test.py HALFLIGHT SHARED_DIR [TestClass[.test]] …

Exits with 77 (ctest: skipped) when every test that ran was skipped."""

import base64
import json
import os
import signal
import struct
import subprocess
import sys
import tempfile
import threading
import unittest
import zlib

import json_schema
import tiny_scene

HALFLIGHT = ""
SHARED = ""
QUICK = ["--quality", "preview", "--samples", "4", "--shadow-samples", "2", "--bounces", "1", "--lightmap-size", "128"]


def run(*arguments, timeout=240):
    return subprocess.run(
        [HALFLIGHT, *map(str, arguments)], capture_output=True, text=True, timeout=timeout, stdin=subprocess.DEVNULL
    )


def read(path):
    with open(path, "rb") as file:
        return file.read()


def decode_png(path):
    """Width, height and rows of RGBA bytes of an 8-bit RGBA PNG (the PNG specification, section 9: filters)."""
    data = read(path)
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed, header = 8, b"", None
    while at < len(data):
        (length,) = struct.unpack(">I", data[at : at + 4])
        kind, body = data[at + 4 : at + 8], data[at + 8 : at + 8 + length]
        header = struct.unpack(">IIBBBBB", body) if kind == b"IHDR" else header
        packed += body if kind == b"IDAT" else b""
        at += 12 + length
    width, height, depth, color = header[:4]
    channels = {2: 3, 6: 4}[color]
    assert depth == 8
    raw, rows, previous = zlib.decompress(packed), [], bytearray(width * channels)
    for y in range(height):
        begin = y * (width * channels + 1)
        kind, row = raw[begin], bytearray(raw[begin + 1 : begin + 1 + width * channels])
        for i in range(len(row)):
            a = row[i - channels] if i >= channels else 0
            b = previous[i]
            c = previous[i - channels] if i >= channels else 0
            nearest = min((a, b, c), key=lambda value: abs(a + b - c - value))
            row[i] = (row[i] + (0, a, b, (a + b) // 2, nearest)[kind]) & 255
        rows.append([tuple(row[i : i + 3]) for i in range(0, len(row), channels)])
        previous = row
    return width, height, rows


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def scene(self, **arguments):
        path = self.path("tiny.gltf")
        tiny_scene.write(path, **arguments)
        return path

    def bake(self, scene, name, *arguments):
        """Bakes in seconds; returns the file and the report."""
        output = self.path(name)
        result = run("bake", scene, "-o", output, *QUICK, "--json", *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        return output, json.loads(result.stdout)

    def rendered(self, baked, *options):
        """Summary and standard error of a small picture."""
        picture = self.path("picture.exr")
        result = run("render", baked, "-o", picture, "--size", "32x24", "--json", *options)
        self.assertEqual(result.returncode, 0, result.stderr)
        return json.loads(result.stdout), result.stderr

    def assert_one_sentence(self, result, code, *words):
        self.assertEqual(result.returncode, code, result.stderr)
        lines = result.stderr.splitlines()
        self.assertEqual(len(lines), 1, result.stderr)
        self.assertTrue(lines[0].startswith("halflight: "), lines[0])
        for word in words:
            self.assertIn(word, lines[0])
        self.assertEqual(result.stdout, "")

    def assert_folder_holds(self, *names):
        self.assertEqual(sorted(os.listdir(self.folder.name)), sorted(names))


class Help(Case):
    def test_help_of_every_command(self):
        top = run("--help")
        self.assertEqual(top.returncode, 0)
        for command in ("bake", "render", "info"):
            self.assertIn(command, top.stdout)
            text = run(command, "--help")
            self.assertEqual(text.returncode, 0)
            self.assertEqual(text.stderr, "")
            self.assertIn("--json", text.stdout)

    def test_every_option_of_the_contract(self):
        bake = run("bake", "--help").stdout
        for option in (
            "--mode baked-indirect|shadowmask|subtractive,--quality preview|medium|high|ultra,--samples,--bounces,"
            "--device,--texels-per-meter,--lightmap-size,--uv auto|keep|unwrap,--denoise on|off,--probe-spacing,"
            "--threads,--seed,--settings,--write-images,--report,--sky,--padding,--quiet,--subtractive-mask on|off"
        ).split(","):
            self.assertIn(option, bake)
        render = run("render", "--help").stdout
        for option in (
            "--mode auto|realtime|baked-indirect|shadowmask|distance-shadowmask|subtractive,--shadow-distance,"
            "--shadow-fade-range,--cascades 1..4,--size,--camera,--eye,--target,--fov,--exposure,--reference,"
            "--view lit|shadowmask|lightmap|probes|cascades|fade|overlap|texels,--shadow-filter hard|pcf|soft,--validation,--penumbrae on|off,"
            "--path forward|deferred,--light,--cascade-splits,--shadow-color R,G,B"
        ).split(","):
            self.assertIn(option, render)

    def test_what_is_not_there_is_not_in_help(self):
        self.assertEqual("\n  view " in run("--help").stdout, "no window" not in run("--version").stdout)
        self.assertNotIn("gpu", run("bake", "--help").stdout)

    def test_version(self):
        result = run("--version")
        self.assertEqual(result.returncode, 0)
        self.assertRegex(result.stdout, r"^halflight \d+\.\d+\.\d+\n")
        self.assertEqual(run("-V").stdout, result.stdout)
        for line in result.stdout.splitlines()[1:]:
            self.assertRegex(line, r"^(reads (KHR|EXT)_\w+(, (KHR|EXT)_\w+)*|window by .*|no window: .*)$")

    def test_help_words(self):
        top = run("--help").stdout
        for arguments in ([], ["help"]):
            result = run(*arguments)
            self.assertEqual((result.returncode, result.stdout, result.stderr), (0, top, ""))
        for command in ("bake", "render", "info"):
            self.assertEqual(run("help", command).stdout, run(command, "--help").stdout)


class Usage(Case):
    def test_wrong_usage_is_2_with_one_sentence(self):
        scene = self.scene()
        out, png = self.path("out.glb"), self.path("out.png")
        cases = [
            (["bakery"], "no command 'bakery'"),
            (["bakke"], "no command 'bakke'", "did you mean bake?"),
            (["help", "rendr"], "no command 'rendr'", "did you mean render?"),
            (["bake", scene, "-o", out, "--sampels", "3"], "no option '--sampels'", "did you mean --samples?"),
            (["bake", scene, "-o", out, "--texels-per-metre=3"], "did you mean --texels-per-meter?"),
            (["render", scene, "-o", png, "--shadow-dist", "3"], "did you mean --shadow-distance?"),
            (["info", scene, "--jsno"], "did you mean --json?"),
            (["bake", scene, out], "--output", "the output goes after -o: -o " + out),
            (["render", scene, png], "--output", "the output goes after -o: -o " + png),
            (["bake"], "SCENE"),
            (["bake", scene], "--output"),
            (["bake", scene, "-o", self.path("out.png")], ".glb"),
            (["bake", scene, "-o", out, "--nonsense"], "--nonsense"),
            (["bake", scene, "another", "-o", out], "another"),
            (["bake", scene, "-o", out, "--mode", "distance-shadowmask"], "--mode", "baked-indirect"),
            (["bake", scene, "-o", out, "--samples", "0"], "--samples", "1 to"),
            (["bake", scene, "-o", out, "--samples", "1.5"], "--samples", "whole"),
            (["bake", scene, "-o", out, "--samples"], "--samples"),
            (["bake", scene, "-o", out, "--bounces", "-1"], "--bounces", "0 to 256"),
            (["bake", scene, "-o", out, "--lightmap-size", "63"], "--lightmap-size", "64 to 8192"),
            (["bake", scene, "-o", out, "--padding", "0"], "--padding", "1 to 16"),
            (["bake", scene, "-o", out, "--padding", "17"], "--padding", "1 to 16"),
            (["bake", scene, "-o", out, "--texels-per-meter", "nan"], "--texels-per-meter"),
            (["bake", scene, "-o", out, "--texels-per-meter", "1e99"], "--texels-per-meter"),
            (["bake", scene, "-o", out, "--sky", "1,2"], "--sky"),
            (["bake", scene, "-o", out, "--sky=-1,0,0"], "--sky"),
            (["bake", scene, "-o", out, "--seed", "4294967296"], "--seed"),
            (["bake", scene, "-o", out, "--device", "gpu"], "--device"),
            (["render", scene, "-o", self.path("out.jpg")], ".png or .exr"),
            (["render", scene, "-o", png, "--cascades", "5"], "--cascades", "1 to 4"),
            (["render", scene, "-o", png, "--shadow-distance", "-3"], "--shadow-distance"),
            (["render", scene, "-o", png, "--shadow-fade-range", "0"], "--shadow-fade-range", "0.01"),
            (["render", scene, "-o", png, "--size", "0x5"], "--size", "16 to 8192"),
            (["render", scene, "-o", png, "--size", "64"], "--size"),
            (["render", scene, "-o", png, "--eye", "1,2,3"], "--target"),
            (["render", scene, "-o", png, "--eye", "1,2,3", "--target", "1,2,3"], "same point"),
            (["render", scene, "-o", png, "--eye", "1,2,3", "--target", "0,0,0", "--camera", "view"], "--camera"),
            (["render", scene, "-o", png, "--exposure", "bright"], "--exposure"),
            (["render", scene, "-o", png, "--path", "raster"], "--path"),
            (["render", scene, "-o", png, "--light", "sun"], "--light", "NAME:"),
            (["render", scene, "-o", png, "--light", "sun:glow=2"], "--light", "glow"),
            (["render", scene, "-o", png, "--light", "sun:color=1,2"], "--light", "color"),
            (["render", scene, "-o", png, "--bounces", "2"], "--reference"),
            (["render", scene, "-o", png, "--reference", "2", "--mode", "realtime"], "--reference"),
            (["info"], "FILE"),
        ]
        for arguments, *words in cases:
            with self.subTest(arguments=arguments[:1] + arguments[-2:]):
                self.assert_one_sentence(run(*arguments), 2, *words)
        self.assert_folder_holds("tiny.gltf")

    def test_open_image_denoise_where_the_build_has_it(self):
        scene, out = self.scene(), self.path("out.glb")
        result = run("bake", scene, "-o", out, *QUICK, "--quiet", "--denoise", "oidn")
        if result.returncode == 0:
            self.assert_folder_holds("out.glb", "tiny.gltf")
        else:
            self.assert_one_sentence(result, 2, "--denoise", "Open Image Denoise")
            self.assert_folder_holds("tiny.gltf")

    def test_a_bake_never_replaces_its_scene(self):
        scene = self.path("scene.glb")
        tiny_scene.write(scene)
        before = read(scene)
        for name in (os.path.join(".", "scene.glb"), "link.glb"):
            if name == "link.glb":
                os.symlink(scene, self.path(name))
            result = run("bake", scene, "-o", os.path.join(self.folder.name, name))
            self.assert_one_sentence(result, 1, name, "--output would replace the scene")
        self.assertEqual(read(scene), before)

    def test_nothing_written_replaces_what_is_read_or_written(self):
        scene, settings, out = self.scene(), self.path("probes.json"), self.path("out.glb")
        with open(settings, "w") as file:
            file.write("[sky]\nzenith = 1\n")
        os.symlink(scene, self.path("scene.png"))
        os.symlink("out.glb", self.path("later.json"))
        os.mkdir(self.path("images"))
        os.mkdir(self.path("empty"))
        os.symlink(scene, self.path("images/lightmap_12.exr"))
        held = os.listdir(self.folder.name)
        before = read(scene), read(settings)
        here = self.folder.name
        bake = ["bake", scene, "-o", out, "--settings", settings]
        cases = [
            ([*bake, "--report", scene], scene, "--report would replace the scene"),
            ([*bake, "--report", settings], settings, "--report would replace the settings file"),
            ([*bake, "--report", os.path.join(here, ".", "out.glb")], "--report would replace --output"),
            ([*bake, "--report", self.path("later.json")], "later.json", "--report would replace --output"),
            ([*bake, "--write-images", here], settings, "--write-images would replace the settings file"),
            ([*bake, "--write-images", self.path("images")], "lightmap_12.exr", "would replace the scene"),
            (
                ["bake", scene, "-o", out, "--report", self.path("empty/probes.json")]
                + ["--write-images", os.path.join(here, ".", "empty")],
                "probes.json",
                "--write-images would replace --report",
            ),
            (["render", scene, "-o", self.path("scene.png")], "scene.png", "--output would replace the scene"),
            (["render", scene, "-o", scene + ".png", "--settings", scene + ".png"], "replace the settings file"),
        ]
        for arguments, *words in cases:
            with self.subTest(arguments=arguments[2:]):
                self.assert_one_sentence(run(*arguments), 1, *words)
        self.assertEqual((read(scene), read(settings)), before)
        self.assert_folder_holds(*held)

    def test_pipes_are_refused_and_links_stay(self):
        scene, pipe = self.scene(), self.path("pipe.png")
        os.mkfifo(pipe)
        os.symlink("pipe.png", self.path("report.json"))
        self.assert_one_sentence(run("render", scene, "-o", pipe), 1, pipe, "pipe")
        out = self.path("out.glb")
        result = run("bake", scene, "-o", out, "--report", self.path("report.json"))
        self.assert_one_sentence(result, 1, "report.json", "pipe")
        self.assert_folder_holds("pipe.png", "report.json", "tiny.gltf")
        os.symlink("real.glb", out)
        self.bake(scene, "out.glb")
        self.assertTrue(os.path.islink(out))
        self.assertEqual(read(self.path("real.glb"))[:4], b"glTF")

    def test_files_that_cannot_be_used_are_1_with_their_name(self):
        scene = self.scene()
        absent = self.path("absent.glb")
        out = self.path("out.glb")
        self.assert_one_sentence(run("bake", absent, "-o", out), 1, absent)
        self.assert_one_sentence(run("info", absent), 1, absent)
        self.assert_one_sentence(run("render", absent, "-o", self.path("out.png")), 1, absent)
        self.assert_one_sentence(run("info", self.folder.name), 1, self.folder.name)
        nowhere = self.path("nowhere/out.glb")
        self.assert_one_sentence(run("bake", scene, "-o", nowhere), 1, nowhere, "folder")
        self.assert_one_sentence(run("bake", scene, "-o", out, "--report", self.path("nowhere/r.json")), 1, "r.json")
        self.assert_one_sentence(run("bake", scene, "-o", out, "--settings", self.path("s.toml")), 1, "s.toml")
        self.assert_one_sentence(run("render", scene, "-o", self.path("o.png"), "--camera", "nope"), 1, "nope", "view")
        self.assert_one_sentence(
            run("render", scene, "-o", self.path("o.png"), "--light", "nope:intensity=1"), 1, "nope", "sun", "spot 0"
        )
        self.assert_folder_holds("tiny.gltf")


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
        self.assert_one_sentence(result, 1, "baked.gltf", "baked.bin", "another name")
        self.assertEqual(read(buffer), before)

    def test_moz_lightmap_is_opt_in(self):
        scene, cache = self.scene(), self.path("cache")
        plain, _ = self.bake(scene, "plain.glb")
        moz, _ = self.bake(scene, "moz.glb", "--moz-lightmap")
        self.assertNotIn(b"MOZ_", read(plain))
        self.assertIn(b"MOZ_lightmap", read(moz))
        # What is written is part of what makes an output up to date.
        out = self.path("out.glb")
        run("bake", scene, "-o", out, *QUICK, "--cache", cache)
        again = run("bake", scene, "-o", out, *QUICK, "--cache", cache, "--moz-lightmap")
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual(read(out), read(moz))


class Streams(Case):
    """Messages never end a bake; results that cannot be written are failures; names cannot steer a terminal."""

    def shell(self, command, **variables):
        return subprocess.run(
            ["bash", "-c", command], capture_output=True, text=True, timeout=240, env={**os.environ, **variables}
        )

    def bake_in_shell(self, redirection):
        out = self.path("out.glb")
        result = self.shell(
            '"$H" bake "$S" -o "$O" ' + " ".join(QUICK) + " " + redirection, H=HALFLIGHT, S=self.scene(), O=out
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
                                H=HALFLIGHT, S=self.scene())
            self.assertEqual(result.returncode, 1, command)

    def test_a_file_size_limit_is_an_error_of_writing(self):
        result, whole = self.bake_in_shell("2>&1 >/dev/null | cat; exit ${PIPESTATUS[0]}")
        self.assertEqual((result.returncode, whole), (0, True), result.stdout)
        out = self.path("out.glb")
        result = self.shell(
            'ulimit -f 4; "$H" bake "$S" -o "$O" ' + " ".join(QUICK) + " 2>&1 >/dev/null | cat; exit ${PIPESTATUS[0]}",
            H=HALFLIGHT, S=self.scene(), O=out,
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


class Malformed(Case):
    # Files of shared/scenes/malformed that are valid, if odd: they may load.
    ODD = {"primitive_no_position.gltf", "required_ext_meshopt_box.glb"}

    def test_one_sentence_and_no_output(self):
        folder = os.path.join(SHARED, "scenes", "malformed")
        if not os.path.isdir(folder):
            self.skipTest("no shared scenes beside this checkout")
        names = sorted(name for name in os.listdir(folder) if name.endswith((".glb", ".gltf")))
        self.assertGreater(len(names), 10)
        for name in names:
            path = os.path.join(folder, name)
            for command in (["bake", path, "-o", self.path("out.glb"), *QUICK], ["info", path]):
                with self.subTest(name=name, command=command[0]):
                    result = run(*command, timeout=60)
                    if name in self.ODD and result.returncode == 0:
                        if os.path.exists(self.path("out.glb")):
                            os.remove(self.path("out.glb"))
                        continue
                    self.assert_one_sentence(result, 1, path + ": ")
                    self.assert_folder_holds()


class Chain(Case):
    def test_bake_info_render(self):
        scene = self.scene()
        report_file, images = self.path("report.json"), self.path("images")
        baked, report = self.bake(scene, "baked.glb", "--report", report_file, "--write-images", images)
        self.assertEqual(read(baked)[:4], b"glTF")
        self.assertEqual(json.loads(read(report_file)), report)
        for name in ("lightmap_0.exr", "shadowmask_0.png", "probes.json"):
            self.assertIn(name, os.listdir(images))

        info = json.loads(run("info", baked, "--json").stdout)
        self.assertTrue(info["baked"])
        self.assertEqual(info["mode"], "shadowmask")
        self.assertEqual(info["objects"]["static"], 4)
        self.assertEqual(info["objects"]["dynamic"], 1)
        self.assertEqual(info["cameras"], ["view"])
        self.assertEqual(info["lightmap"], {"pages": 1, "size": 128, "directional": False})
        self.assertEqual(info["shadowmask"], {"pages": 1, "size": 128})
        self.assertGreater(info["probes"]["valid"], 0)
        lights = {light["name"]: light for light in info["lights"]}
        self.assertEqual(lights["sun"]["bakedAs"], "mixed")
        self.assertEqual(sorted(light["channel"] for light in lights.values()), [0, 1])
        self.assertIn("sun", run("info", baked).stdout)
        plain = json.loads(run("info", scene, "--json").stdout)
        self.assertFalse(plain["baked"])
        self.assertEqual(plain["triangles"], {"stored": 12, "drawn": 60})

        size = ["--size", "96x64"]
        picture = self.path("picture.png")
        result = run("render", baked, "-o", picture, *size, "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        summary = json.loads(result.stdout)
        self.assertEqual(summary["mode"], "shadowmask")
        self.assertEqual(summary["camera"]["name"], "view")
        width, height, rows = decode_png(picture)
        self.assertEqual((width, height), (96, 64))
        values = [sum(pixel) / 3 for row in rows for pixel in row]
        self.assertGreater(max(values), 100, "the picture is dark")
        self.assertGreater(max(values) - min(values), 60, "the picture is flat")

        # The exposure that was chosen gives the same picture when it is asked for.
        again = self.path("again.png")
        result = run("render", baked, "-o", again, *size, "--exposure", repr(summary["exposure"]))
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(read(picture), read(again))

        radiance = self.path("radiance.exr")
        self.assertEqual(run("render", baked, "-o", radiance, *size).returncode, 0)
        self.assertEqual(read(radiance)[:4], b"\x76\x2f\x31\x01")

    def test_modes_that_fit_the_bake(self):
        scene = self.scene()
        fits = {
            "shadowmask": {"realtime", "baked-indirect", "shadowmask", "distance-shadowmask"},
            "subtractive": {"realtime", "subtractive"},
            "baked-indirect": {"realtime", "baked-indirect"},
        }
        modes = ["realtime", "baked-indirect", "shadowmask", "distance-shadowmask", "subtractive"]
        for bake_mode, run_modes in fits.items():
            baked, _ = self.bake(scene, bake_mode + ".glb", "--mode", bake_mode)
            for mode in modes:
                with self.subTest(baked=bake_mode, mode=mode):
                    picture = self.path("picture.png")
                    result = run("render", baked, "-o", picture, "--size", "32x32", "--mode", mode, "--quiet")
                    if mode in run_modes:
                        self.assertEqual(result.returncode, 0, result.stderr)
                        self.assertEqual(result.stderr, "")
                        os.remove(picture)
                    else:
                        self.assert_one_sentence(result, 1, baked, "can only be drawn in")
                        self.assertFalse(os.path.exists(picture))

    def test_subtractive_mask_and_shadow_colour(self):
        """S22, S23: the main light's mask by default; the bake's colour unless the author or --shadow-color says another."""
        scene = self.scene()
        described = {}
        for mask in ("on", "off"):
            options = ("--mode", "subtractive") + (() if mask == "on" else ("--subtractive-mask", "off"))
            baked, _ = self.bake(scene, mask + ".glb", *options)
            described[mask] = json.loads(run("info", baked, "--json").stdout)["subtractive"]
            self.assertEqual(described[mask]["mask"], mask == "on")
            self.assertTrue(described[mask]["shadowColorFromBake"])
            self.assertGreater(min(described[mask]["shadowColor"]), 0.0)
        self.assertGreaterEqual(described["off"]["shadowColor"][1], described["on"]["shadowColor"][1])

        def picture(name, *options):
            path = self.path("picture.png")
            result = run("render", self.path(name), "-o", path, "--size", "64x48", "--exposure", "3", *options)
            self.assertEqual(result.returncode, 0, result.stderr)
            return read(path)

        self.assertNotEqual(picture("off.glb"), picture("off.glb", "--shadow-color", "1e6,1e6,1e6"))
        wrong = run("render", self.path("on.glb"), "-o", self.path("p.png"), "--shadow-color", "-1,0,0")
        self.assertEqual(wrong.returncode, 2)

        # Baked again, from the file and through a cache: what the bake chose is no wish of the author's.
        again, report = self.bake(self.path("on.glb"), "again.glb", "--mode", "subtractive", "--cache", self.path("tiles"))
        self.assertTrue(json.loads(run("info", again, "--json").stdout)["subtractive"]["shadowColorFromBake"])
        third, _ = self.bake(self.path("on.glb"), "third.glb", "--mode", "subtractive", "--cache", self.path("tiles"))
        self.assertEqual(read(again), read(third))

    def test_lights_change_after_the_bake(self):
        """S29: brightness and colour are taken as they come, in proportion; a turned or moved light is named."""
        baked, _ = self.bake(self.scene(), "baked.glb")

        def picture(*options):
            path = self.path("picture.png")
            result = run("render", baked, "-o", path, "--size", "64x48", "--exposure", "3", "--json", *options)
            self.assertEqual(result.returncode, 0, result.stderr)
            return decode_png(path)[2], json.loads(result.stdout)["warnings"], result.stderr

        plain, warnings, _ = picture()
        self.assertEqual(warnings, [])
        brighter, warnings, errors = picture("--light", "sun:intensity=9,color=1,0.5,0.25")
        self.assertEqual((warnings, errors), ([], ""))
        self.assertNotEqual(plain, brighter)
        self.assertGreater(sum(p[0] for row in brighter for p in row), sum(p[0] for row in plain for p in row))
        turned, warnings, errors = picture("--light", "sun:direction=1,-1,0")
        self.assertNotEqual(plain, turned)
        self.assertEqual(len(warnings), 1)
        for text in (warnings[0], errors):
            self.assertIn('"sun"', text)
            self.assertIn("out of step", text)
        _, warnings, _ = picture("--light", "spot 0:position=0,3,2", "--mode", "distance-shadowmask")
        self.assertEqual(len(warnings), 1)
        self.assertIn('"spot 0"', warnings[0])
        _, warnings, _ = picture("--light", "sun:direction=1,-1,0", "--mode", "realtime")
        self.assertEqual(warnings, [], "in realtime mode nothing baked is read")

    def test_changes_that_do_not_show_are_said(self):
        """S29: each once, in the messages and in the JSON, on both paths, with what helps."""
        settings = self.path("settings.toml")
        with open(settings, "w", encoding="utf-8") as file:
            file.write('[[light]]\npattern = "spot*"\nmode = "baked"\n')
        baked, _ = self.bake(self.scene(), "baked.glb", "--settings", settings)
        subtractive, _ = self.bake(self.scene(), "subtractive.glb", "--mode", "subtractive")
        for file, options, words in (
            (baked, ["--light", "spot 0:intensity=1"], ['"spot 0"', "no effect", "fully baked", "mixed"]),
            (baked, ["--light", "spot 0:range=2"], ['"spot 0"', "range", "no effect"]),
            (baked, ["--light", "sun:intensity=100"], ['"sun"', "factor of 20", "indirect multiplier of 0"]),
            (subtractive, ["--light", "sun:color=1,0,0"], ['"sun"', "static objects", "shadowmask mode"]),
            (subtractive, ["--light", "spot 0:intensity=70"], ['"spot 0"', "static objects"]),
        ):
            for path in ("forward", "deferred"):
                with self.subTest(options=options, path=path):
                    summary, errors = self.rendered(file, *options, "--path", path)
                    self.assertEqual(len(summary["warnings"]), 1, summary["warnings"])
                    self.assertEqual(errors.count("\n"), 1, errors)
                    for word in words:
                        self.assertIn(word, summary["warnings"][0])
                        self.assertIn(word, errors)
        self.assertEqual(self.rendered(baked, "--light", "spot 0:intensity=1", "--mode", "realtime")[0]["warnings"], [])
        # As at the bake, and a setting that only a bake heeds.
        self.assertEqual(self.rendered(baked, "--settings", settings)[0]["warnings"], [])
        with open(settings, "a", encoding="utf-8") as file:
            file.write('[[light]]\npattern = "sun"\nmode = "realtime"\n')
        warnings = self.rendered(baked, "--settings", settings)[0]["warnings"]
        self.assertEqual(len(warnings), 1, warnings)
        self.assertIn("mode of \"sun\" has no effect on a baked file", warnings[0])
        self.assertEqual(self.rendered(baked, "--settings", settings, "--reference", "1")[0]["warnings"], warnings)

    def test_what_the_reader_found_is_printed(self):
        """As info prints it, and what the frame says of the same light is not said again."""
        baked, _ = self.bake(self.scene(), "baked.glb", "--mode", "subtractive")
        data = bytearray(read(baked))
        at = data.index(b'"intensity":5')
        data[at : at + 13] = b'"intensity":7'
        stale = self.path("stale.glb")
        with open(stale, "wb") as file:
            file.write(data)
        found = json.loads(run("info", stale, "--json").stdout)["warnings"]
        self.assertEqual(len(found), 1, found)
        for word in ("is stale", '"sun"', "static objects"):
            self.assertIn(word, found[0])
        for options in ([], ["--path", "deferred"], ["--reference", "1"]):
            summary, errors = self.rendered(stale, *options)
            self.assertEqual(summary["warnings"], found)
            self.assertIn("is stale", errors)
        # Its own warnings come beside them.
        result = run("render", stale, "-o", self.path("p.exr"), "--size", "32x24", "--json", "--exposure", "1")
        warnings = json.loads(result.stdout)["warnings"]
        self.assertEqual(warnings[:-1], found)
        self.assertIn("--exposure has no effect", warnings[-1])
        quiet = run("render", stale, "-o", self.path("p.exr"), "--size", "32x24", "--quiet")
        self.assertEqual((quiet.returncode, quiet.stderr), (0, ""))

    def test_a_row_for_each_light(self):
        """S5, S10, S12: every light says what it has in the frame, or why not."""
        baked, report = self.bake(self.scene(spots=5), "baked.glb")
        lost = {light["name"] for light in report["lights"] if light["channel"] < 0}
        summary, _ = self.rendered(baked, "--mode", "shadowmask")
        rows = {row["name"]: row for row in summary["lights"]["rows"]}
        self.assertEqual(len(rows), 6)
        for name, row in rows.items():
            if name in lost:
                self.assertFalse(row["inFrame"])
                self.assertIn("no shadowmask channel was left", row["reason"])
                continue
            self.assertTrue(row["bakedShadow"]["used"])
            shadow = row["realtimeShadow"]
            self.assertEqual((shadow["used"], shadow["staticCasters"], shadow["dynamicCasters"]), (True, 0, 1))
            self.assertEqual((shadow["cascades"], shadow["tiles"]), (4, 0) if name == "sun" else (0, 1))
        self.assertEqual(summary["lights"]["inView"], 4)
        sun = self.rendered(baked, "--mode", "distance-shadowmask", "--cascade-splits", "0.2,0.5")[0]["lights"]["rows"][0]
        self.assertEqual(sun["realtimeShadow"]["cascades"], 3)
        self.assertEqual(sun["realtimeShadow"]["staticCasters"], 4)
        off = self.rendered(baked, "--light", "sun:strength=0")[0]["lights"]["rows"][0]
        self.assertIn("strength is 0", off["realtimeShadow"]["reason"])

        # Lights that lost their channels are counted where they reach: the floor's middle is white, not red.
        overlap = self.path("overlap.png")
        result = run("render", baked, "-o", overlap, "--view", "overlap", "--size", "64x48")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn((255, 255, 255), {pixel for row in decode_png(overlap)[2] for pixel in row})

    def test_cascade_splits_are_checked(self):
        for splits in ("0.5,0.2", "0", "1", "0.1,0.2,0.3,0.4", "a", "0.1,,0.2"):
            result = run("render", "x.glb", "-o", self.path("p.exr"), "--cascade-splits", splits)
            self.assert_one_sentence(result, 2, "ascending numbers")
        result = run("render", "x.glb", "-o", self.path("p.exr"), "--cascade-splits", "0.5", "--cascades", "4")
        self.assert_one_sentence(result, 2, "--cascades 4 needs 3")

    def test_json_follows_its_schemas(self):
        plain = self.scene(spots=5)
        baked, report = self.bake(plain, "baked.glb")
        values = [(report, "bake_report")]
        for file in (plain, baked):
            values.append((json.loads(run("info", file, "--json").stdout), "info_output"))
            for options in ([], ["--path", "deferred", "--timings"], ["--reference", "1"], ["--view", "overlap"]):
                values.append((self.rendered(file, *options)[0], "render_output"))
        for value, name in values:
            self.assertEqual(json_schema.check(value, name), [])
        # The checker finds what is wrong.
        rendered = values[-1][0]
        for path, wrong in (("mode", "half-baked"), ("size", [1]), ("warnings", "none"), ("extra", 1)):
            self.assertNotEqual(json_schema.problems({**rendered, path: wrong}, json_schema.load("render_output")), [])
        row = rendered["lights"]["rows"][0]
        del row["bakedShadow"]
        self.assertNotEqual(json_schema.problems(rendered, json_schema.load("render_output")), [])

    def test_every_view(self):
        baked, _ = self.bake(self.scene(), "baked.glb")
        seen = set()
        for view in ("lit", "shadowmask", "lightmap", "probes", "cascades", "fade", "overlap", "texels"):
            picture = self.path(view + ".png")
            result = run("render", baked, "-o", picture, "--size", "48x48", "--view", view, "--shadow-distance", "8")
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(decode_png(picture)[:2], (48, 48))
            seen.add(read(picture))
        self.assertEqual(len(seen), 8, "two views are the same picture")

    def test_plain_file_renders_in_realtime(self):
        picture = self.path("picture.png")
        view = ["--size", "64x64", "--eye=4,3,5", "--target=0,0,0"]
        result = run("render", self.scene(), "-o", picture, *view, "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(json.loads(result.stdout)["mode"], "realtime")
        _, _, rows = decode_png(picture)
        self.assertGreater(max(max(pixel) for row in rows for pixel in row), 60)

    def test_reference(self):
        scene = self.scene()
        first, second = self.path("a.exr"), self.path("b.exr")
        options = ["--reference", "4", "--bounces", "2", "--size", "48x32", "--quiet"]
        for output, threads in ((first, "1"), (second, "2")):
            result = run("render", scene, "-o", output, *options, "--threads", threads)
            self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(read(first), read(second))

    def test_fifth_overlapping_light_is_named(self):
        output = self.path("baked.glb")
        result = run("bake", self.scene(spots=5), "-o", output, *QUICK, "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        lights = json.loads(result.stdout)["lights"]
        self.assertEqual(len(lights), 6)
        overflow = [light for light in lights if light["channel"] < 0]
        self.assertEqual(len(overflow), 2)
        for light in overflow:
            self.assertTrue(light["reason"])
            self.assertTrue(any(light["name"] in line for line in result.stderr.splitlines()), result.stderr)
        info = json.loads(run("info", output, "--json").stdout)
        self.assertEqual(sorted(light["channel"] for light in info["lights"]), [-1, -1, 0, 1, 2, 3])

    def test_quiet_is_quiet(self):
        result = run("bake", self.scene(), "-o", self.path("baked.glb"), *QUICK, "--quiet")
        self.assertEqual((result.returncode, result.stdout, result.stderr), (0, "", ""))
        self.assert_folder_holds("baked.glb", "tiny.gltf")

    def test_bounces_0_is_direct_light_only(self):
        # The lightmap of mixed lights holds bounced light alone, and this scene has no other light.
        brightest = {}
        for bounces in ("0", "1"):
            baked, report = self.bake(self.scene(), "baked.glb", "--bounces", bounces)
            self.assertEqual(report["quality"]["bounces"], int(bounces))
            picture = self.path("lightmap.png")
            result = run("render", baked, "-o", picture, "--view", "lightmap", "--size", "64x64", "--exposure", "0")
            self.assertEqual(result.returncode, 0, result.stderr)
            brightest[bounces] = max(max(pixel) for row in decode_png(picture)[2] for pixel in row)
        self.assertEqual(brightest["0"], 0)
        self.assertGreater(brightest["1"], 20)


class Georeferenced(Case):
    """A scene far from the world's origin gives the light and the picture of the same scene at the origin."""

    def moved(self, name, offset):
        path = self.scene()
        with open(path) as file:
            document = json.load(file)
        document["nodes"].append({"children": document["scenes"][0]["nodes"], "translation": list(offset)})
        document["scenes"][0]["nodes"] = [len(document["nodes"]) - 1]
        path = self.path(name)
        with open(path, "w") as file:
            json.dump(document, file)
        return path

    def pages(self, baked):
        data = read(baked)
        (length,) = struct.unpack("<I", data[12:16])
        document = json.loads(data[20 : 20 + length])
        root = document["extensions"]["HALFLIGHT_mixed_lighting"]
        images = []
        for texture in [document["textures"][p["index"]] for p in root["lightmaps"] + root["shadowmasks"]]:
            image = document["images"][texture.get("extensions", {}).get("HALFLIGHT_texture_ktx2", texture)["source"]]
            view = document["bufferViews"][image["bufferView"]]
            images.append(data[28 + length + view.get("byteOffset", 0) :][: view["byteLength"]])
        return root, images

    def picture(self, scene, *arguments):
        png = self.path("picture.png")
        result = run("render", scene, "-o", png, "--size", "96x64", "--exposure", "1", "--json", *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        return decode_png(png)[2], json.loads(result.stdout)

    def difference(self, a, b):
        """Mean difference of two pictures in levels, and the share of pixels that differ by more than 12."""
        levels = [max(abs(x - y) for x, y in zip(p, q)) for r, s in zip(a, b) for p, q in zip(r, s)]
        return sum(levels) / len(levels), sum(level > 12 for level in levels) / len(levels)

    def test_same_light_and_picture(self):
        here, _ = self.bake(self.moved("here.gltf", (0, 0, 0)), "here.glb")
        root, pages = self.pages(here)
        self.assertNotIn("origin", root)
        modes = [[], ["--mode", "distance-shadowmask"], ["--mode", "realtime"]]
        pictures = [self.picture(here, *mode)[0] for mode in modes]
        for offset in ((5.0e5, 0.0, -5.0e6), (1.0e7, 0.0, 0.0), (421337.123, 98.76, -5123456.789)):
            with self.subTest(offset=offset):
                even = all(c == int(c) for c in offset)
                images = self.path("images")
                there, report = self.bake(self.moved("there.gltf", offset), "there.glb", "--write-images", images)
                self.assertEqual([w for w in report["warnings"] if "middle" in w], [])
                root, moved_pages = self.pages(there)
                self.assertLess(max(abs(a - b) for a, b in zip(root["origin"], offset)), 20)
                if even:  # a multiple of the step of local origins: every byte
                    self.assertEqual(root["origin"], list(offset))
                    self.assertEqual(moved_pages, pages)
                for mode, expected in zip(modes, pictures):
                    mean, far = self.difference(self.picture(there, *mode)[0], expected)
                    self.assertLess(mean, 0.0001 if even else 0.7, mode)
                    self.assertLess(far, 0.0001 if even else 0.01, mode)

                # What users write and read are the world's coordinates.
                x, y, z = offset
                eye = "--eye=%.3f,%.3f,%.3f" % (x + 4, y + 3, z + 5)
                target = "--target=%.3f,%.3f,%.3f" % (x, y + 0.5, z)
                rows, summary = self.picture(there, eye, target)
                mean, _ = self.difference(rows, self.picture(here, "--eye=4,3,5", "--target=0,0.5,0")[0])
                self.assertLess(mean, 0.0001 if even else 0.7)
                for c in range(3):
                    self.assertAlmostEqual(summary["camera"]["eye"][c], offset[c] + (4, 3, 5)[c], 4)
                bounds = json.loads(run("info", there, "--json").stdout)["bounds"]
                for c in range(3):
                    self.assertAlmostEqual(bounds["min"][c], offset[c] + (-3.05, -0.1, -3.05)[c], 4)
                probes = json.loads(read(os.path.join(images, "probes.json")))["probes"]
                for probe in probes:
                    self.assertLess(max(abs(p - o) for p, o in zip(probe["position"], offset)), 10)
                # A lamp that is put where it stood is not moved; in the file's coordinates.
                spot = "spot 0:position=%.3f,%.3f,%.3f" % (x + 1.5, y + 3, z + 2)
                _, summary = self.picture(there, "--light", spot)
                self.assertEqual([w for w in summary["warnings"] if "moved" in w], [])


class Reach(Case):
    """Lights without a range that share channels, and lights whose range grew since the bake (spec section 4)."""

    def boxes(self, name, blocks, lamps):
        """Blocks are (centre, size), lamps (position, candela, range or None)."""
        path = self.scene()
        with open(path) as file:
            document = json.load(file)
        nodes = [{"mesh": 0, "name": "block %d" % i, "translation": c, "scale": s} for i, (c, s) in enumerate(blocks)]
        lights = []
        for i, (position, candela, reach) in enumerate(lamps):
            light = {"type": "point", "name": "lamp %d" % i, "intensity": candela}
            if reach:
                light["range"] = reach
            nodes.append({"translation": position, "extensions": {"KHR_lights_punctual": {"light": i}}})
            lights.append(light)
        document["nodes"] = nodes
        document["scenes"][0]["nodes"] = list(range(len(nodes)))
        document["extensions"]["KHR_lights_punctual"]["lights"] = lights
        del document["cameras"]
        path = self.path(name)
        with open(path, "w") as file:
            json.dump(document, file)
        return path

    def picture(self, scene, *arguments):
        png = self.path("picture.png")
        size = [] if "--size" in arguments else ["--size", "144x32"]
        result = run("render", scene, "-o", png, *size, "--json", *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        return decode_png(png)[2]

    def test_six_lamps_without_range_keep_their_masks(self):
        xs = [36 * i for i in range(6)]
        blocks = [([90, -0.05, 0], [240, 0.1, 24])]
        blocks += [([x + 5, 1.5, 1], [1, 3, 2]) for x in xs]
        scene = self.boxes("street.gltf", blocks, [([x, 5, 0], 2000, None) for x in xs])
        baked, report = self.bake(scene, "street.glb", "--lightmap-size", "256")
        for light in report["lights"]:
            self.assertEqual(light["bakedAs"], "mixed", light)
            self.assertGreaterEqual(light["channel"], 0)
            self.assertTrue(light["reach"] == 0 or light["reach"] > 36, light)
        self.assertGreaterEqual(sum(light["reach"] > 0 for light in report["lights"]), 2)
        self.assertEqual(sum("have no range" in w for w in report["warnings"]), 1, report["warnings"])
        view = ["--eye=90,60,90", "--target=90,0,0", "--fov", "75", "--exposure", "4"]
        shown = self.picture(baked, *view)
        truth = self.picture(baked, *view, "--reference", "64", "--bounces", "2")
        levels = [max(abs(a - b) for a, b in zip(p, q)) for r, s in zip(shown, truth) for p, q in zip(r, s)]
        self.assertGreater(max(max(p) for row in truth for p in row), 60)
        self.assertLess(sum(levels) / len(levels), 4)
        self.assertLess(sum(level > 40 for level in levels) / len(levels), 0.03)

    def test_a_grown_range_takes_no_other_lights_shadow(self):
        # Two lamps that share a channel; a block in the light of the second throws its shadow to the right.
        blocks = [([6, -0.05, 0], [30, 0.1, 12]), ([14, 0.5, 0], [0.5, 1, 3])]
        lamps = [([0, 3, 0], 100, 5), ([12, 3, 0], 100, 5)]
        baked, report = self.bake(self.boxes("two.gltf", blocks, lamps), "two.glb")
        self.assertEqual([light["channel"] for light in report["lights"]], [0, 0])
        self.assertEqual([light["reach"] for light in report["lights"]], [5, 5])
        view = ["--eye=15,6,0.01", "--target=15,0,0", "--fov", "40", "--exposure", "-4", "--size", "64x64"]
        off = ["--light", "lamp 1:intensity=0"]
        for path in ("forward", "deferred"):
            grown = self.picture(baked, *view, *off, "--light", "lamp 0:range=60", "--path", path)
            # Truth: the first lamp alone with that range; its own shadow lies where the second lamp's does, but no mask
            # of it was baked there, so that it shines through.
            alone = self.boxes("alone.gltf", blocks[:1], [([0, 3, 0], 100, 60)])
            free = self.picture(alone, *view, "--mode", "realtime", "--path", path)
            shadowed = self.picture(baked, *view, "--light", "lamp 0:intensity=0", "--path", path)
            lit = self.picture(self.boxes("lit.gltf", blocks[:1], [([12, 3, 0], 100, 5)]), *view, "--mode", "realtime",
                               "--path", path)
            seen = 0
            for y in range(64):
                for x in range(24, 64):  # beyond the block
                    dark = lit[y][x][0] > 40 and shadowed[y][x][0] < lit[y][x][0] // 3
                    if dark and max(grown[y][x]) > 0:
                        seen += 1
                        self.assertLess(abs(grown[y][x][0] - free[y][x][0]), 0.15 * free[y][x][0] + 6, (path, x, y))
            self.assertGreater(seen, 20, path)


class Determinism(Case):
    def test_threads_change_no_byte(self):
        scene = self.scene()
        one, _ = self.bake(scene, "one.glb", "--threads", "1")
        two, _ = self.bake(scene, "two.glb", "--threads", "2")
        self.assertEqual(read(one), read(two))
        other, _ = self.bake(scene, "other.glb", "--seed", "2")
        self.assertNotEqual(read(one), read(other))


class Interrupt(Case):
    def interrupt(self, number, *arguments):
        """Sends the signal once the program has named the stage of tracing rays; returns exit code and last line."""
        process = subprocess.Popen(
            [HALFLIGHT, *arguments], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, bufsize=0
        )
        watchdog = threading.Timer(120, process.kill)
        watchdog.start()
        last = ""
        sent = False
        # A stage's line ends when the stage does, so lines are read as they grow.
        while piece := os.read(process.stderr.fileno(), 4096).decode():
            last += piece
            if not sent and self.long_stage in last:
                process.send_signal(number)
                sent = True
        process.stderr.close()
        code = process.wait()
        watchdog.cancel()
        self.assertTrue(sent, "no stage named " + self.long_stage)
        return code, last.splitlines(keepends=True)[-1]

    def test_interrupted_bake_leaves_nothing(self):
        self.long_stage = "lightmap"
        scene = self.scene()
        for number in (signal.SIGINT, signal.SIGTERM):
            outputs = ["-o", self.path("out.glb"), "--report", self.path("r.json")]
            code, last = self.interrupt(
                number, "bake", scene, *outputs, "--samples", "20000", "--lightmap-size", "256"
            )
            self.assertEqual(code, 1)
            self.assertEqual(last, "halflight: interrupted\n")
            self.assert_folder_holds("tiny.gltf")

    def test_interrupted_reference_leaves_nothing(self):
        self.long_stage = "reference"
        scene = self.scene()
        code, last = self.interrupt(signal.SIGINT, "render", scene, "-o", self.path("out.png"), "--reference", "100000")
        self.assertEqual((code, last), (1, "halflight: interrupted\n"))
        self.assert_folder_holds("tiny.gltf")


def main(names):
    """Runs the tests of the calling program; exits with 77 when all were skipped."""
    program = unittest.main(argv=sys.argv[:1] + names, exit=False, verbosity=1)
    outcome = program.result
    for test, reason in outcome.skipped:
        print(f"[  SKIPPED ] {test.id()}: {reason}")
    if outcome.wasSuccessful() and outcome.testsRun == len(outcome.skipped):
        sys.exit(77)
    sys.exit(0 if outcome.wasSuccessful() else 1)


if __name__ == "__main__":
    HALFLIGHT, SHARED = sys.argv[1:3]
    main(sys.argv[3:])
