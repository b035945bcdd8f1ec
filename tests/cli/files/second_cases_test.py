"""Small inputs that once gave a wrong picture or a refusal: the second list of SHARED_DIR/cases/README.md.
Usage: second_cases_test.py HALFLIGHT SHARED_DIR [TestClass[.test]] …   Without the inputs all is skipped (exit code 77).
"""

import json
import math
import os
import shutil
import struct

import cli_case
from cases_test import SharedCase, cases
from cli_case import QUICK, Case, decode_png, edited, read, run

LUMENS_PER_WATT = 683.0


class SecondCase(SharedCase):
    def linear(self, file, exposure, *arguments):
        """Mean of linear RGB of a small picture, where nothing is brighter than white."""
        path = self.path("linear.png")
        result = run("render", file, "-o", path, "--size", "64x48", "--tone-mapping", "none", "--exposure", exposure,
                     *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        values = [c / 255 for row in decode_png(path)[2] for pixel in row for c in pixel]
        self.assertLess(max(values), 1.0, "clipped")
        linear = [v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in values]
        return sum(linear) / len(linear)

    def warnings(self, *command):
        result = run(*command)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stderr


class Glass(SecondCase):
    def below(self, file, x, *arguments):
        """Light on the floor under a pane that stands 1 m above it."""
        view = ["--eye", f"{x},0.5,0.02", "--target", f"{x},0,0", "--fov", "40"]
        return self.linear(file, 2.0, *view, "--shadow-filter", "soft", *arguments)

    def test_panes_let_light_through(self):
        """Right: 0.96 of what the transmission lets through, of metals what they are not. The red pane lets 1, 0.1 and 0.1
        of the channels through, but in realtime shadows, which are grey."""
        def half_cut_out(document):
            material = document["materials"][8]
            material["pbrMetallicRoughness"]["baseColorFactor"][3] = 0.4

        scene = cases("glass-mask", "in.glb")
        cut = edited(scene, self.path("cut.glb"), half_cut_out)
        panes = [(-9, 0.48), (-6, 0.96), (-3, 0.0), (0, 0.48), (3, 0.98), (6, 0.96 * 1.2 / 3), (12, 0.96)]
        baked = self.baked(scene, "--lightmap-size", "256", "--bounces", "0")
        for file, mode in [(scene, ["--reference", "64", "--bounces", "0"]), (scene, ["--mode", "realtime"]), (baked, []),
                           (baked, ["--path", "deferred"])]:
            open_floor = self.below(file, -11, *mode)
            for x, right in panes:
                if x == 6 and "realtime" in mode:
                    right = 0.96
                with self.subTest(mode=mode, x=x):
                    self.assertAlmostEqual(self.below(file, x, *mode) / open_floor, right, delta=0.02)
            self.assertAlmostEqual(self.below(cut, 12, *mode) / open_floor, 1.0, delta=0.02)

    def test_textures_of_opaque_glass(self):
        """The base colour's alpha does not count; the transmission's texture and that of metallic do. The texture is red in
        one half and black in the other, and realtime shadows are grey."""
        def with_textures(document):
            document["materials"][2]["pbrMetallicRoughness"]["baseColorTexture"] = {"index": 0}
            document["materials"][3]["pbrMetallicRoughness"]["metallicRoughnessTexture"] = {"index": 0}

        scene = edited(cases("glass-mask", "in.glb"), self.path("textures.glb"), with_textures)
        for mode, right in ((["--reference", "64", "--bounces", "0"], 0.96 / 6), (["--mode", "realtime"], 0.96)):
            open_floor = self.below(scene, -11, *mode)
            self.assertAlmostEqual(self.below(scene, -6, *mode) / open_floor, right, delta=0.02)


class Skies(SecondCase):
    def test_odd_values_are_clamped(self):
        result = run("bake", cases("sky-values", "negative.glb"), "-o", self.path("out.glb"), *QUICK)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("2 texels have a negative value", result.stderr)

    def test_exposure_is_taken_out(self):
        plain = self.path("plain.glb")
        shutil.copy(cases("sky-values", "exposure2.glb"), plain)
        header = read(cases("sky-values", "exposure2.hdr"))
        with open(self.path("exposure2.hdr"), "wb") as file:
            file.write(header.replace(b"EXPOSURE=2\n", b""))
        bright = self.linear(plain, 9.0, "--eye", "0,20,0", "--target", "0,20,-1")
        dark = self.linear(cases("sky-values", "exposure2.glb"), 9.0, "--eye", "0,20,0", "--target", "0,20,-1")
        self.assertAlmostEqual(dark / bright, 0.5, delta=0.01)


class Cameras(SecondCase):
    def test_camera_without_zfar_sees_everything(self):
        scene = cases("camera-without-zfar", "in.glb")
        reference = self.picture(scene, "--camera", "no zfar", "--reference", "64")
        for path in ("forward", "deferred"):
            named = self.picture(scene, "--camera", "no zfar", "--path", path)
            self.assert_same_picture(named, self.picture(scene, "--camera", "zfar 10000", "--path", path), 0.001, 0.001)
            self.assert_same_picture(named, reference, 0.03, 0.05)


class TextureSets(SecondCase):
    def with_set(self, n, name, transform=False):
        """The case of the second set, its coordinates in TEXCOORD_n."""
        def change(document):
            attributes = document["meshes"][0]["primitives"][0]["attributes"]
            attributes[f"TEXCOORD_{n}"] = attributes.pop("TEXCOORD_1")
            for k in range(1, n):
                attributes[f"TEXCOORD_{k}"] = attributes["TEXCOORD_0"]
            slot = document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]
            slot["texCoord"] = 0 if transform else n
            if transform:
                slot["extensions"] = {"KHR_texture_transform": {"texCoord": n}}
                document["extensionsUsed"].append("KHR_texture_transform")

        return edited(cases("uv1-read-by-material", "uv1_valid.glb"), self.path(name), change)

    def test_pictures_of_every_file(self):
        good = ["--samples", "32", "--lightmap-size", "256"]
        source = cases("uv1-read-by-material", "uv1_valid.glb")
        right = self.picture(source)
        right_baked = self.picture(self.baked(source, *good, "--uv", "unwrap", name="right.glb"))
        for n, transform in ((2, False), (3, True), (7, False)):
            with self.subTest(n=n, transform=transform):
                scene = self.with_set(n, "set.glb", transform)
                self.assertNotIn("TEXCOORD", self.warnings("info", scene))
                self.assert_same_picture(self.picture(scene), right, 0.002, 0.002)
                baked = self.baked(scene, *good, name="once.glb")
                self.assert_same_picture(self.picture(baked), right_baked)
                again = self.baked(baked, *good, name="twice.glb")
                self.assert_same_picture(self.picture(again), right_baked)
                for path in ("forward", "deferred"):
                    self.assert_same_picture(self.picture(again, "--mode", "realtime", "--path", path), right, 0.01)
                reference = self.picture(again, "--reference", "16")
                self.assert_same_picture(reference, self.picture(source, "--reference", "16"), 0.02, 0.02)
        small = self.path("small.glb")
        self.warnings("optimize", baked, small)
        self.assert_same_picture(self.picture(small), right_baked, 0.02, 0.02)
        exported = self.path("export.glb")
        self.warnings("bake", scene, "-o", exported, *QUICK, *good, "--export", "unlit")
        first = self.picture(exported, "--mode", "realtime")
        self.warnings("bake", source, "-o", exported, *QUICK, *good, "--uv", "unwrap", "--export", "unlit")
        self.assert_same_picture(first, self.picture(exported, "--mode", "realtime"), 0.03, 0.05)

    def test_what_is_not_read_is_a_warning(self):
        self.assertIn("reads TEXCOORD_8", self.warnings("info", self.with_set(8, "eight.glb")))

        def three(document):
            material = document["materials"][0]
            material["name"] = "three sets"
            material["emissiveTexture"] = {"index": 0, "texCoord": 2}
            material["occlusionTexture"] = {"index": 0, "texCoord": 3}

        scene = edited(cases("uv1-read-by-material", "uv1_valid.glb"), self.path("three.glb"), three)
        self.assertRegex(self.warnings("info", scene), '"three sets" reads TEXCOORD_[23] as a third set')


class Emission(SecondCase):
    def scene_of(self, generator, mark=None):
        def change(document):
            document["asset"]["generator"] = generator
            document["materials"][0].update(emissiveFactor=[0.5, 0.5, 0.5])
            document["materials"][0].pop("pbrMetallicRoughness")
            document["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"] = 0.001
            if mark:
                document["scenes"][0]["extras"] = {"halflight_emission_unit": mark}

        return edited(cases("uv1-read-by-material", "uv1_valid.glb"), self.path("glow.glb"), change)

    def shown(self, file, *arguments):
        """Radiance of the middle, nits, for 0.5 in the file."""
        view = ["--eye", "0,1,0.01", "--target", "0,0,0", "--mode", "realtime"]
        blender = "--emission-unit" in arguments or "scaled" in file
        exposure = math.log2(LUMENS_PER_WATT) if blender else 0.0
        return self.linear(file, exposure, *view, *arguments) * 2.0**exposure

    BLENDER = "Khronos glTF Blender I/O v4.3.47"

    def test_blenders_emission(self):
        scene = self.scene_of(self.BLENDER)
        for command in (["info", scene], ["bake", scene, "-o", self.path("plain.glb"), *QUICK]):
            self.assertIn("--emission-unit blender", self.warnings(*command))
        plain = self.shown(scene)
        self.assertAlmostEqual(self.shown(scene, "--emission-unit", "blender") / plain, LUMENS_PER_WATT, delta=10)
        for command in (["--emission-unit", "blender"], ["--emission-unit", "nits"]):
            told = self.warnings("bake", scene, "-o", self.path("told.glb"), *QUICK, *command)
            self.assertNotIn("emission ", told)
        settings = self.path("s.toml")
        with open(settings, "w") as file:
            file.write('[scene]\nemission_unit = "blender"\n')
        by_settings, _ = self.bake(scene, "settings scaled.glb", "--settings", settings)
        scaled, _ = self.bake(scene, "scaled.glb", "--emission-unit", "blender")
        again, _ = self.bake(scaled, "twice scaled.glb", "--emission-unit", "blender")
        for file in (by_settings, scaled, again):
            document = json_of(file)
            strength = document["materials"][0]["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"]
            self.assertEqual(strength, LUMENS_PER_WATT)
            self.assertIn("KHR_materials_emissive_strength", document["extensionsUsed"])
            self.assertEqual(document["scenes"][0]["extras"]["halflight_emission_unit"], "nits")
            self.assertAlmostEqual(self.shown(file) / plain, LUMENS_PER_WATT, delta=10)
            self.assertNotIn("emission ", self.warnings("info", file))

    def test_marked_files_stay_as_they_are(self):
        scene = self.scene_of(self.BLENDER, "nits")
        self.assertNotIn("emission ", self.warnings("info", scene))
        said = self.warnings("bake", scene, "-o", self.path("out.glb"), *QUICK, "--emission-unit", "blender")
        self.assertIn("says that its emission is in nits", said)
        self.assertNotIn("KHR_materials_emissive_strength", json.dumps(json_of(self.path("out.glb"))))
        self.assertNotIn("emission ", self.warnings("info", self.scene_of("Some Other Program")))
        blender = self.scene_of(self.BLENDER, "blender")
        self.assertNotIn("emission ", self.warnings("info", blender))
        result = run("info", self.scene_of(self.BLENDER, "candles"))
        self.assertEqual(result.returncode, 1)
        self.assertIn('"nits" or "blender"', result.stderr)


class Meshopt(Case):
    def test_buffer_that_only_compressed_views_refer_to(self):
        """It needs neither a uri nor "fallback": nothing reads its bytes. One that a plain view reads does."""
        assets = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "assets", "tests", "compressed")
        source = os.path.join(assets, "gltfpack_ext.glb")

        def unmarked(document):
            marked = [b for b in document["buffers"] if "extensions" in b]
            self.assertEqual(len(marked), 1)
            marked[0].pop("extensions")

        def read_plainly(document):
            unmarked(document)
            view = next(v for v in document["bufferViews"] if "extensions" in v)
            view.pop("extensions")

        right = run("info", source, "--json")
        if "meshopt" in right.stderr:
            self.skipTest("this build has no meshoptimizer")
        result = run("info", edited(source, self.path("unmarked.glb"), unmarked), "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(json.loads(result.stdout)["bounds"], json.loads(right.stdout)["bounds"])
        plain = run("info", edited(source, self.path("plain.glb"), read_plainly))
        self.assert_one_sentence(plain, 1, "/buffers/", "neither a uri nor a binary chunk")


def json_of(glb):
    data = read(glb)
    (length,) = struct.unpack("<I", data[12:16])
    return json.loads(data[20 : 20 + length])


if __name__ == "__main__":
    cli_case.main()
