"""What `halflight bake` can write besides its usual file. Usage: outputs_test.py HALFLIGHT SHARED_DIR [TestClass[.test]] …
"""

import glob
import json
import math
import os
import struct

import cli_case
import json_schema
from cli_case import QUICK, Case, decode_png, read, run


def json_of(path):
    data = read(path)
    (length,) = struct.unpack("<I", data[12:16])
    return json.loads(data[20 : 20 + length])


class Formats(Case):
    def test_lightmap_formats(self):
        sizes = {}
        for name, limit in (("rgb9e5", 2.0**-9), ("half", 2.0**-11), ("webp", 0.5)):
            baked, report = self.bake(self.scene(), name + ".glb", "--lightmap-format", name)
            json_schema.check(report, "bake_report")
            self.assertEqual(report["lightmap"]["format"], name)
            self.assertEqual(len(report["lightmap"]["written"]), report["lightmap"]["pages"])
            for page in report["lightmap"]["written"]:
                self.assertGreater(page["mostError"], 0)
                self.assertLessEqual(page["meanError"], page["mostError"])
                self.assertLessEqual(page["mostError"], limit * 1.001)
                if name == "webp":  # 8 bits: single dark texels of so few samples are far off
                    self.assertLess(page["meanError"], 0.02)
            sizes[name] = sum(page["bytes"] for page in report["lightmap"]["written"])
            self.assertEqual(sizes[name], report["bytes"]["lightmaps"])
            self.assertEqual(run("info", baked).returncode, 0)
            self.rendered(baked, "--eye=4,3,5", "--target=0,0,0")
        self.assertLess(sizes["webp"], sizes["rgb9e5"] / 2)
        result = run("bake", self.scene(), "-o", self.path("x.glb"), "--lightmap-format", "exr")
        self.assert_one_sentence(result, 2, "--lightmap-format", "rgb9e5, half, webp")


class GroupsCase(Case):
    ROOMS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../assets/tests/light_groups.glb")

    def baked_groups(self, *options):
        output = self.path("baked.glb")
        result = run("bake", self.ROOMS, "-o", output, *QUICK, "-q", *options)
        self.assertEqual(result.returncode, 0, result.stderr)
        return output, json.loads(run("info", output, "--json").stdout)


class LightGroups(GroupsCase):
    """S33: --groups, compose and --group."""

    def test_groups_are_listed_composed_and_drawn(self):
        baked, info = self.baked_groups()
        json_schema.check(info, "info_output")
        self.assertEqual([group["name"] for group in info["groups"]], ["lamp", "sun", "west", "east", "day"])
        self.assertEqual(json_of(baked)["extensions"]["HALFLIGHT_mixed_lighting"]["version"], 3)
        self.assertIn("light group", run("info", baked).stdout)
        state = self.path("state.glb")
        result = run("compose", baked, "-o", state, "--group", "lamp=1", "--group", "sun=0", "--group", "day=0.1,0.1,0.2")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("lamp=1, sun=0", result.stdout)
        info = json.loads(run("info", state, "--json").stdout)
        self.assertNotIn("groups", info)
        self.assertEqual([w for w in info["warnings"] if "stale" in w], [])
        lights = {light["name"]: light for light in info["lights"]}
        self.assertEqual((lights["lamp"]["color"], lights["sun"]["color"]), ([1, 1, 1], [0, 0, 0]))
        self.assertEqual(json_of(state)["extensions"]["HALFLIGHT_mixed_lighting"]["version"], 2)
        changes = ["--group", "lamp=1", "--group", "sun=0", "--group", "day=0.1,0.1,0.2"]
        pictures = []
        for name, file, options in (("a.png", baked, changes), ("b.png", state, [])):
            size = ["--size", "64x64", "--exposure", "2", "-q"]
            self.assertEqual(run("render", file, "-o", self.path(name), *size, *options).returncode, 0)
            pictures.append(decode_png(self.path(name))[2])
        for a, b in zip(*(sum(rows, []) for rows in pictures)):  # a device's and the processor's sum, to rounding
            self.assertLessEqual(max(abs(x - y) for x, y in zip(a, b)), 2)
        small = self.path("small.glb")
        self.assertEqual(run("optimize", baked, small).returncode, 0)
        self.assertEqual(run("compose", small, "-o", state, "-q", "--group", "sun=0").returncode, 0)

    def test_what_is_wrong(self):
        baked, _ = self.baked_groups("--reflection-probes", "off")
        out = ["-o", self.path("x.glb")]
        self.assert_one_sentence(run("compose", baked, *out, "--group", "moon=1"), 1, "moon", "lamp, sun, west, east, day")
        self.assert_one_sentence(run("compose", baked, *out, "--group", "sun=-1"), 2, "--group", "sun=-1")
        self.assert_one_sentence(run("compose", baked, *out, "--group", "sun"), 2, "--group", "lamps=0.5")
        self.assert_one_sentence(run("compose", self.ROOMS, *out), 1, "has no light groups")
        self.assert_one_sentence(run("compose", baked, "-o", self.path("x.png")), 2, ".glb or .gltf")
        self.assert_one_sentence(run("compose", baked, *out, "--sky-zenith", "1"), 1, "halflight_sky_changes = 1")
        self.assert_one_sentence(run("compose", baked, *out, "--sky", "blue"), 2, "--sky", "'blue'")
        unlit = ["--export", "unlit", "--groups", "each"]
        self.assert_one_sentence(run("bake", self.ROOMS, *out, *QUICK, *unlit), 2, "exports hold no light groups")


class ChangingGroups(GroupsCase):
    """S33, S34: groups of each light, in sidecars, of a sky that changes and a sun that turns."""

    def test_each_and_off(self):
        _, info = self.baked_groups("--groups", "each")
        self.assertEqual(len(info["groups"]), 5, "three lights and the material in two rooms")
        _, info = self.baked_groups("--groups", "off")
        self.assertNotIn("groups", info)

    def test_a_sidecar_has_them_where_it_is_asked_to(self):
        for options, count in (([], 0), (["--groups", "authored"], 5)):
            side = self.path("side%d" % count)
            self.baked_groups("--sidecar", side, *options)
            with open(os.path.join(side, "bake.json"), encoding="utf-8") as file:
                bake = json.load(file)
            json_schema.check(bake, "sidecar")
            self.assertEqual(bake["version"], 2 if count else 1)
            self.assertEqual(len(bake.get("groups", [])), count)
            for group in bake.get("groups", []):
                self.assertEqual(len(group["radiance"]), len(bake["probes"]["radiance"]))
                for page in filter(None, group["lightmaps"]["pages"]):
                    self.assertTrue(page.startswith("lightmap_%s_" % group["name"]))
                    self.assertTrue(os.path.exists(os.path.join(side, page)))

    def test_a_sky_that_changes(self):
        """S34"""
        settings = self.path("sky.toml")
        with open(settings, "w", encoding="utf-8") as file:
            file.write("[sky]\nzenith = [1, 2, 4]\nhorizon = 3\nground = 0.5\nchanges = true\n")
        baked, info = self.baked_groups("--settings", settings)
        parts = {group["name"]: group["weight"] for group in info["groups"] if group["sky"]}
        self.assertEqual(list(parts), ["sky.zenith", "sky.horizon", "sky.ground"])
        for value, truth in zip(parts["sky.zenith"], [1, 2, 4]):
            self.assertAlmostEqual(value, truth, 4)
        state = self.path("state.glb")
        options = ["--sky", "0", "--sky-horizon", "9,6,3"]
        self.assertEqual(run("compose", baked, "-o", state, "-q", *options).returncode, 0)
        sky = json.loads(run("info", state, "--json").stdout)["sky"]
        self.assertEqual((sky["zenith"], sky["horizon"], sky["ground"]), ([0, 0, 0], [9, 6, 3], [0, 0, 0]))
        pictures = []
        for name, file, changes in (("a.png", baked, options), ("b.png", state, [])):
            size = ["--size", "64x64", "--exposure", "2", "-q"]
            self.assertEqual(run("render", file, "-o", self.path(name), *size, *changes).returncode, 0)
            pictures.append(read(self.path(name)))
        self.assertEqual(*pictures)

    def test_a_sun_that_turns(self):
        """S34"""
        settings = self.path("sun.toml")
        with open(settings, "w", encoding="utf-8") as file:
            file.write('[[light]]\npattern = "sun"\nmode = "mixed"\n'
                       "directions = [[-0.56, -0.6, -0.57], [-0.36, -0.6, -0.72], [-0.12, -0.6, -0.79]]\n")
        baked, info = self.baked_groups("--settings", settings)
        suns = [group for group in info["groups"] if group["name"].startswith("sun")]
        self.assertEqual([sun["name"] for sun in suns], ["sun.1", "sun.2", "sun.3"])
        self.assertTrue(all(sun["lights"] == ["sun"] and sun["bytes"] > 0 for sun in suns))
        self.assertAlmostEqual(suns[0]["direction"][1], -0.6 / math.sqrt(0.56**2 + 0.6**2 + 0.57**2), 4)
        self.assertGreater(suns[1]["weight"][0], 0.9, "where it shines in the scene")
        self.assertIn("along -0.", run("info", baked).stdout)
        state = self.path("state.glb")
        turned = ["--light", "sun:direction=-0.46,-0.6,-0.65,color=1,1,1,intensity=20"]
        result = run("compose", baked, "-o", state, *turned, "--group", "lamp=0")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("sun=0.5", result.stdout)
        info = json.loads(run("info", state, "--json").stdout)
        self.assertEqual([w for w in info["warnings"] if "stale" in w], [])
        pictures = []
        for name, file, options in (("a.png", baked, [*turned, "--group", "lamp=0"]), ("b.png", state, [])):
            size = ["--size", "64x64", "--exposure", "2", "-q"]
            self.assertEqual(run("render", file, "-o", self.path(name), *size, *options).returncode, 0)
            pictures.append(decode_png(self.path(name))[2])
        for a, b in zip(*(sum(rows, []) for rows in pictures)):
            self.assertLessEqual(max(abs(x - y) for x, y in zip(a, b)), 2)
        far = run("compose", baked, "-o", state, "--light", "sun:direction=1,-1,0")
        self.assertRegex(far.stderr, r'light "sun" shines \d+.* degrees away from the nearest direction of its bake')
        short = run("render", baked, "-o", self.path("a.png"), "--shadow-distance", "1", "--size", "64x64")
        self.assertIn("sun\" turns, so that it has no baked shadows: beyond the shadow distance of 1 m", short.stderr)
        out = ["-o", self.path("x.glb")]
        self.assert_one_sentence(run("compose", baked, *out, "--group", "sun.2=1"), 1, 'turn the light, or set "sun"')
        self.assert_one_sentence(run("compose", baked, *out, "--light", "lamp:intensity=1"), 1, '"lamp" does not turn')
        self.assert_one_sentence(run("compose", baked, *out, "--light", "sun:strength=0.5"), 1, "nothing else")
        self.assert_one_sentence(run("compose", baked, *out, "--light", "moon:intensity=1"), 1, "moon")


class Progress(Case):
    """--progress lines: what other programs show of a bake, such as the Blender extension."""

    def test_lines_for_programs(self):
        command = ["bake", self.scene(), "-o", self.path("out.glb"), *cli_case.QUICK, "--samples", "16", "--progress", "lines"]
        result = run(*command)
        self.assertEqual(result.returncode, 0, result.stderr)
        lines = result.stderr.splitlines()
        last = {}
        for line in lines:
            self.assertRegex(line, r"^progress: [a-z ]+ \d+ %$")
            stage, percent = line[len("progress: ") : -len(" %")].rsplit(" ", 1)
            self.assertGreaterEqual(int(percent), last.get(stage, 0), "percents of a stage only grow")
            last[stage] = int(percent)
        self.assertEqual(set(last.values()), {100}, "every stage ends")
        self.assertIn("lightmap", last)
        quiet = run(*command, "--quiet")
        self.assertEqual((quiet.returncode, quiet.stderr), (0, ""))


class EarlierSky(Case):
    def test_the_sky_of_an_earlier_bake_is_named(self):
        with open(self.path("sky.hdr"), "wb") as file:  # 4 x 2 texels of (1, 1, 1)
            file.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n" + bytes([128, 128, 128, 129]) * 8)
        with open(self.path("sky.toml"), "w") as file:
            file.write('[sky]\nimage = "sky.hdr"\n')
        settings = ["--settings", self.path("sky.toml")]
        first, again = self.path("first.glb"), self.path("again.glb")
        for source, options, named in [(self.scene(), settings, False), (first, [], True), (first, settings, False)]:
            result = run("bake", source, "-o", again if source == first else first, *cli_case.QUICK, *options)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual("earlier bake" in result.stderr, named, result.stderr)


class ReflectionProbes(Case):
    def scene(self):
        """Of gloss: dull surfaces get no reflection probes."""
        path = super().scene()
        with open(path, encoding="utf-8") as file:
            document = json.load(file)
        document["materials"][0]["pbrMetallicRoughness"].update({"metallicFactor": 1, "roughnessFactor": 0.2})
        with open(path, "w", encoding="utf-8") as file:
            json.dump(document, file)
        return path

    def test_on_off_and_by_the_file(self):
        baked, report = self.bake(self.scene(), "baked.glb")
        root = json_of(baked)["extensions"]["HALFLIGHT_mixed_lighting"]
        json_schema.check(root, "HALFLIGHT_mixed_lighting")
        probes = root["reflectionProbes"]["probes"]
        self.assertEqual(report["reflectionProbes"]["count"], len(probes))
        self.assertGreater(len(probes), 0)
        self.assertGreater(report["bytes"]["reflectionProbes"], 0)
        self.rendered(baked, "--eye=4,3,5", "--target=0,0,0", "--reflection-probes", "off")
        off, report = self.bake(self.scene(), "off.glb", "--reflection-probes", "off")
        self.assertNotIn("reflectionProbes", json_of(off)["extensions"]["HALFLIGHT_mixed_lighting"])
        self.assertEqual(report["reflectionProbes"]["count"], 0)

        with open(self.path("one.toml"), "w", encoding="utf-8") as file:
            file.write('[[node]]\npattern = "crate"\nreflection_probe = true\n')
        asked, report = self.bake(self.scene(), "asked.glb", "--settings", self.path("one.toml"))
        root = json_of(asked)["extensions"]["HALFLIGHT_mixed_lighting"]
        json_schema.check(root, "HALFLIGHT_mixed_lighting")
        self.assertEqual(report["reflectionProbes"]["count"], 1)
        self.assertEqual([root["reflectionProbes"]["probes"][0]["box"]], root["authoredReflectionProbes"])
        again, report = self.bake(asked, "again.glb")
        self.assertEqual(report["reflectionProbes"]["count"], 1, "the record of the earlier bake")


class Sidecar(Case):
    def test_beside_the_file(self):
        baked, report = self.bake(self.scene(), "baked.glb", "--sidecar", self.path("beside"))
        with open(self.path("beside/bake.json"), encoding="utf-8") as file:
            sidecar = json.load(file)
        json_schema.check(sidecar, "sidecar")
        self.assertEqual(sidecar["file"], "baked.glb")
        document = json_of(baked)
        records = {node["name"]: node["extensions"] for node in document["nodes"] if "extensions" in node}
        self.assertEqual(len(sidecar["objects"]), sum("HALFLIGHT_node" in r for r in records.values()))
        for binding in sidecar["objects"]:
            self.assertEqual(binding.get("lightmap"), records[binding["node"]]["HALFLIGHT_node"].get("lightmap"))
        for name in sidecar["lightmaps"]["pages"] + sidecar["shadowmasks"]:
            self.assertGreater(len(read(self.path("beside/" + name))), 0)
        self.assertEqual(sidecar["lightmaps"]["format"], "exr")
        self.assertEqual(len(sidecar["probes"]["positions"]), report["probes"]["count"])
        self.bake(self.scene(), "baked.glb", "--sidecar", self.path("half"), "--lightmap-format", "half")
        self.assertIn("lightmap_0.ktx2", os.listdir(self.path("half")))

    def test_contradictions(self):
        scene, out = self.scene(), self.path("out.glb")
        result = run("bake", scene, "-o", out, "--sidecar", self.path("d"), "--write-images", self.path("d"))
        self.assert_one_sentence(result, 1, "--write-images", "--sidecar")
        result = run("bake", scene, "-o", out, "--sidecar", self.path("d"), "--export", "unlit")
        self.assert_one_sentence(result, 2, "--sidecar", "--export")
        report = self.path("d/bake.json")
        os.mkdir(self.path("d"))
        result = run("bake", scene, "-o", out, "--sidecar", self.path("d"), "--report", report)
        self.assert_one_sentence(result, 1, "--sidecar would replace --report")


class Export(Case):
    def test_core_gltf(self):
        for style, extension in (("unlit", "KHR_materials_unlit"), ("emissive", "KHR_materials_emissive_strength")):
            exported, report = self.bake(self.scene(), style + ".glb", "--export", style)
            json_schema.check(report, "bake_report")
            self.assertEqual(report["export"]["style"], style)
            self.assertEqual(report["export"]["keptObjects"], ["crate"])
            self.assertEqual(report["export"]["bytes"], len(read(exported)))
            self.assertTrue(any("'crate'" in warning for warning in report["warnings"]), report["warnings"])
            self.assertTrue(all(light["bakedAs"] == "baked" for light in report["lights"]))
            document = json_of(exported)
            self.assertNotIn("HALFLIGHT", json.dumps(document))
            self.assertIn(extension, document["extensionsUsed"])
            self.assertIn("not baked", run("info", exported).stdout)

    def test_exposure(self):
        factors = []
        for exposure in ("0", "2"):
            exported, report = self.bake(self.scene(), "e.glb", "--export", "unlit", "--exposure", exposure)
            self.assertEqual(report["export"]["exposure"], float(exposure))
            lights = json_of(exported)["extensions"]["KHR_lights_punctual"]["lights"]
            factors.append(lights[0]["intensity"])
        self.assertAlmostEqual(factors[0] / factors[1], 4, places=5)

    def test_scale(self):
        reports = [self.bake(self.scene(), "s.glb", "--export", "unlit", "--export-scale", s)[1] for s in ("1", "4")]
        self.assertEqual([report["export"]["scale"] for report in reports], [1, 4])
        self.assertGreater(reports[1]["export"]["pictureBytes"], reports[0]["export"]["pictureBytes"])

    def test_contradictions(self):
        scene, out = self.scene(), self.path("out.glb")
        for options, words in (
            (["--export", "unlit", "--mode", "subtractive"], ["--export", "--mode"]),
            (["--export", "unlit", "--lightmap-format", "half"], ["--export", "--lightmap-format"]),
            (["--export", "emissive", "--directional", "on"], ["--export", "--directional"]),
            (["--exposure", "3"], ["--exposure", "--export"]),
            (["--export-scale", "2"], ["--export-scale", "--export"]),
            (["--export", "lit"], ["--export", "unlit, emissive"]),
        ):
            self.assert_one_sentence(run("bake", scene, "-o", out, *options), 2, *words)
        result = run("bake", scene, "-o", self.path("out.gltf"), "--export", "unlit")
        self.assert_one_sentence(result, 2, "--export", ".glb")
        self.assert_folder_holds("tiny.gltf")


class SomeObjects(Case):
    """bake --only: what it needs, and how objects are named. All objects of the scene share a mesh."""

    def setUp(self):
        super().setUp()
        self.cache = ["--cache", self.path("cache")]
        self.file = self.scene()
        with open(self.file) as file:
            document = json.load(file)
        nodes = document["nodes"]
        nodes.append({"name": "walls", "children": [n for n, node in enumerate(nodes) if node["name"] in ("wall", "back")]})
        top = set(range(len(nodes))) - set(nodes[-1]["children"])
        document["scenes"][0]["nodes"] = sorted(top)
        with open(self.file, "w") as file:
            json.dump(document, file)

    def refused(self, code, arguments, *words):
        """Neither the file nor a folder is there afterwards that was not before."""
        before = sorted(os.listdir(self.folder.name))
        folders = ["--write-images", self.path("images"), "--sidecar", self.path("more/sidecar")]
        result = run("bake", self.file, "-o", self.path("refused.glb"), "-q", *QUICK, *folders, *arguments)
        self.assert_one_sentence(result, code, *words)
        self.assert_folder_holds(*before)

    def test_an_unchanged_scene_gives_the_same_file(self):
        whole, _ = self.bake(self.file, "whole.glb", *self.cache)
        for number, names in enumerate((["--only", "pillar"], ["--only", "walls,floor"], ["--only=wall", "--only=pillar"])):
            some, report = self.bake(self.file, f"some{number}.glb", *self.cache, *names)
            self.assertEqual(read(some), read(whole), names)
            self.assertEqual(report["cache"]["same"], 0)
            self.assertLess(report["cache"]["unchanged"] + report["cache"]["kept"], report["cache"]["tiles"])
        plain = run("bake", self.file, "-o", whole, *QUICK, *self.cache, "--only", "pillar")
        self.assertIn("of other objects kept", plain.stdout)

    def test_what_is_missing_is_said(self):
        self.refused(2, ["--only", "pillar"], "--only needs --cache")
        self.refused(1, [*self.cache, "--only", "pillar"], "no finished bake", "bake the whole scene once")
        self.bake(self.file, "whole.glb", *self.cache)
        before = sorted(glob.glob(self.path("cache/**"), recursive=True))
        self.refused(1, [*self.cache, "--only", "pillar,chair"], "'chair'")
        self.refused(1, [*self.cache, "--only", "sun"], "'sun'")
        self.refused(1, [*self.cache, "--only", "crate"], "lightmap texels")
        self.refused(1, [*self.cache, "--only", "pillar", "--texels-per-meter", "3"], "no finished bake with this layout")
        self.refused(1, [*self.cache, "--only", "pillar", "--seed", "2"], "and these settings")
        self.assertEqual(sorted(glob.glob(self.path("cache/**"), recursive=True)), before, "refusals leave nothing behind")


if __name__ == "__main__":
    cli_case.main()
