"""No output replaces an input. Usage: inputs_test.py HALFLIGHT SHARED_DIR [TestClass[.test]] …"""

import base64
import glob
import json
import os
import struct
import zlib

import cli_case
from cli_case import QUICK, Case, read, run


def png_of(color):
    """A PNG of one RGB texel (the PNG specification, sections 5 and 11)."""

    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    header = struct.pack(">IIBBBBB", 1, 1, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(bytes([0, *color]))) + chunk(b"IEND", b"")


class Inputs(Case):
    """A scene whose buffer, texture and skies are files of their own, all read by all commands."""

    def setUp(self):
        super().setUp()
        self.file = self.scene()
        with open(self.file) as file:
            document = json.load(file)
        buffer = document["buffers"][0]
        with open(self.path("data.glb"), "wb") as file:  # a buffer may have any name
            file.write(base64.b64decode(buffer["uri"].split(",", 1)[1]))
        buffer["uri"] = "data.glb"
        with open(self.path("texture.png"), "wb") as file:
            file.write(png_of((200, 100, 50)))
        document["images"] = [{"uri": "texture.png"}]
        document["textures"] = [{"source": 0}]
        document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {"index": 0}
        picture = run("render", self.file, "-o", self.path("sky.exr"), "--size", "32x16", "-q", "--reference", 1)
        self.assertEqual(picture.returncode, 0, picture.stderr)
        os.mkdir(self.path("skies"))
        os.rename(self.path("sky.exr"), self.path("skies/sky.exr"))
        with open(self.path("skies/lightmap_3.exr"), "wb") as file:
            file.write(read(self.path("skies/sky.exr")))
        document["scenes"][0]["extras"] = {"halflight_sky_image": "skies/sky.exr"}
        with open(self.file, "w") as file:
            json.dump(document, file)
        with open(self.path("night.toml"), "w") as file:
            file.write('[sky]\nimage = "skies/lightmap_3.exr"\n')
        self.read = {name: read(self.path(name)) for name in self.files()}

    def files(self):
        found = glob.glob("**", root_dir=self.folder.name, recursive=True)
        return sorted(name for name in found if os.path.isfile(self.path(name)))

    def refused(self, arguments, *words):
        """The command fails at once, and no file is another or new."""
        held = self.files()
        with self.subTest(arguments=arguments):
            self.assert_one_sentence(run(*arguments), 1, "would replace", *words)
        self.assertEqual(self.files(), held)
        self.assertEqual({name: read(self.path(name)) for name in self.read}, self.read)

    def bake_with(self, *options):
        return ["bake", self.file, "-o", self.path("out.glb"), *QUICK, "-q", *options]

    def test_of_a_bake(self):
        night = ["--settings", self.path("night.toml")]
        for name, word in (
            ("tiny.gltf", "the scene"),
            ("data.glb", "the scene's data.glb"),
            ("texture.png", "the scene's texture.png"),
            ("skies/sky.exr", "the scene's sky.exr"),
        ):
            self.refused(self.bake_with("--report", self.path(name)), self.path(name), "--report", word)
        self.refused(["bake", self.file, "-o", self.path("data.glb"), *QUICK], "--output", "data.glb")
        self.refused(self.bake_with("--sidecar", self.path("skies")), "sky.exr", "--sidecar")
        self.refused(self.bake_with("--write-images", self.path("skies"), *night), "lightmap_3.exr", "--write-images")
        self.refused(self.bake_with("--sidecar", self.path("skies"), *night), "--sidecar")
        self.refused(self.bake_with("--report", self.path("skies/lightmap_3.exr"), *night), "the settings file's")
        self.refused(self.bake_with("--export", "unlit", "--report", self.path("texture.png")), "--report")

    def test_by_other_names(self):
        os.symlink("texture.png", self.path("link.json"))
        os.symlink("link.json", self.path("second.json"))
        os.link(self.path("texture.png"), self.path("hard.json"))
        os.mkdir(self.path("beside"))
        os.symlink(self.path("skies"), self.path("beside/lit"))
        os.symlink("../texture.png", self.path("beside/shadowmask_0.png"))
        self.refused(self.bake_with("--report", self.path("link.json")), "link.json", "texture.png")
        self.refused(self.bake_with("--report", self.path("second.json")), "second.json", "texture.png")
        self.refused(self.bake_with("--report", self.path("hard.json")), "hard.json", "texture.png")
        self.refused(self.bake_with("--report", self.path("./skies/../beside/../texture.png")), "texture.png")
        self.refused(self.bake_with("--sidecar", self.path("beside/lit")), "sky.exr")
        self.refused(self.bake_with("--write-images", self.path("beside")), "shadowmask_0.png", "texture.png")

    def test_of_other_commands(self):
        self.refused(["render", self.file, "-o", self.path("texture.png")], "--output", "the scene's texture.png")
        sky = self.path("skies/sky.exr")
        self.refused(["render", self.file, "-o", sky, "--reference", "1"], "--output", "the scene's sky.exr")
        other = self.path("skies/lightmap_3.exr")
        self.refused(["render", self.file, "-o", other, "--settings", self.path("night.toml")], "the settings file's")
        self.refused(["optimize", self.file, self.path("data.glb")], "OUT", "the scene's data.glb")

    def test_outputs_of_one_command(self):
        """The buffer beside a .gltf and a report are both new, and one file."""
        bake = ["bake", self.file, "-o", self.path("out.gltf"), *QUICK, "-q"]
        for name in ("out.bin", "out_image_0.png"):
            self.refused([*bake, "--report", self.path("skies/../" + name)], name)

    def test_all_that_is_written_counts(self):
        """Each file that a bake writes is, as a link to the scene's texture, refused."""
        options = ["--sidecar", self.path("sidecar"), "--write-images", self.path("images"), "--report", self.path("r.json")]
        written = run("bake", self.file, "-o", self.path("out.gltf"), *QUICK, "-q", "--directional", "on", *options)
        self.assertEqual(written.returncode, 0, written.stderr)
        names = set(self.files()) - set(self.read)
        self.assertGreater(len(names), 12)
        for name in sorted(names):
            kept = read(self.path(name))
            os.remove(self.path(name))
            os.symlink(self.path("texture.png"), self.path(name))
            self.refused(["bake", self.file, "-o", self.path("out.gltf"), *QUICK, "-q", *options], os.path.basename(name))
            os.remove(self.path(name))
            with open(self.path(name), "wb") as file:
                file.write(kept)

    def test_of_a_farm(self):
        plan, out = self.path("plan"), self.path("out.glb")
        result = run("farm", "plan", self.file, "-o", plan, "-q", *QUICK)
        self.assertEqual(result.returncode, 0, result.stderr)
        result = run("farm", "work", plan, "-q")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.read |= {name: read(self.path(name)) for name in self.files()}
        join = ["farm", "join", plan, "-q", "-o"]
        for name in ("plan.json", "workers", "scenes/0/tiny.gltf", "scenes/0/texture.png", "scenes/0/skies/sky.exr"):
            self.refused([*join, out, "--report", os.path.join(plan, name)], os.path.basename(name))
        self.refused([*join, os.path.join(plan, "scenes/0/data.glb")], "data.glb")
        self.refused([*join, out, "--sidecar", os.path.join(plan, "scenes/0/skies")], "sky.exr")
        result = run(*join, out)
        self.assertEqual(result.returncode, 0, result.stderr)

    def test_one_report_of_several_scenes(self):
        plan = self.path("plan")
        result = run("farm", "plan", self.file, self.file, "-o", plan, "-q", *QUICK)
        self.assertEqual(result.returncode, 0, result.stderr)
        for option in ("--report", "--sidecar", "--write-images"):
            refused = run("farm", "join", plan, "-o", self.path("out"), "-q", option, self.path("some"))
            self.assert_one_sentence(refused, 2, "--report", "--scene")

    def test_what_a_command_is_made_to_update(self):
        """A cache, and outputs of the last run of the same command."""
        options = ["--cache", self.path("cache"), "--report", self.path("report.json"), "--sidecar", self.path("sidecar")]
        for _ in range(2):
            result = run(*self.bake_with(*options))
            self.assertEqual(result.returncode, 0, result.stderr)


if __name__ == "__main__":
    cli_case.main()
