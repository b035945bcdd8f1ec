"""`halflight render`. Usage: render_test.py HALFLIGHT SHARED_DIR [TestClass[.test]] …"""

import json
import os

import cli_case
from cli_case import Case, decode_png, read, run


class Render(Case):
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

    def test_cascade_splits_are_checked(self):
        for splits in ("0.5,0.2", "0", "1", "0.1,0.2,0.3,0.4", "a", "0.1,,0.2"):
            result = run("render", "x.glb", "-o", self.path("p.exr"), "--cascade-splits", splits)
            self.assert_one_sentence(result, 2, "ascending numbers")
        result = run("render", "x.glb", "-o", self.path("p.exr"), "--cascade-splits", "0.5", "--cascades", "4")
        self.assert_one_sentence(result, 2, "--cascades 4 needs 3")

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


class RenderReports(Case):
    """What a picture's summary, messages and debug views say of its lights."""

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

    def test_a_row_for_each_light(self):
        """S5, S10, S12: every light says what it has in the frame, or why not."""
        baked, report = self.bake(self.scene(spots=5), "baked.glb", "--mask-layers", "1")
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


class Choices(Case):
    def test_samples_of_a_pixel(self):
        baked, _ = self.bake(self.scene(), "baked.glb")
        view = ["--eye=4,3,5", "--target=0,0,0"]
        exact, fine, usual = (self.rendered(baked, *view, *samples)[0]
                              for samples in (["--samples", "1"], ["--samples", "16"], []))
        self.assertEqual([exact["samples"], fine["samples"], usual["samples"]], [1, 16, 4])
        self.assertEqual(self.rendered(baked, *view, "--view", "probes")[0]["samples"], 1)
        for samples in ("2", "0", "64", "a"):
            result = run("render", baked, "-o", self.path("p.exr"), "--samples", samples)
            self.assert_one_sentence(result, 2, "1, 4, 9 or 16")

    def test_shadow_distance_follows_the_view(self):
        baked, _ = self.bake(self.scene(), "baked.glb")
        view = ["--eye=4,3,5", "--target=0,0,0", "--mode", "baked-indirect"]
        shadows = self.rendered(baked, *view)[0]["shadows"]
        self.assertFalse(shadows["given"])
        self.assertEqual(shadows["shareBeyond"], 0)
        self.assertGreater(shadows["distance"], shadows["farthestInView"])
        self.assertLess(shadows["distance"], shadows["farthestInView"] + 2)
        # Half of what is in view, about: said with the share and the cure.
        summary = self.rendered(baked, *view, "--shadow-distance", "7")[0]
        self.assertTrue(summary["shadows"]["given"])
        self.assertGreater(summary["shadows"]["shareBeyond"], 0.05)
        self.assertLess(summary["shadows"]["shareBeyond"], 0.95)
        said = [w for w in summary["warnings"] if "realtime shadows end 7 m" in w and "--shadow-distance" in w]
        self.assertEqual(len(said), 1, summary["warnings"])

    def test_surfaces_of_the_reference(self):
        view = ["--reference", "64", "--bounces", "2", "--size", "48x32", "--eye=4,3,5", "--target=0,0,0"]
        means = {}
        for surfaces, options in (("full", []), ("diffuse-bounces", ["--reference-diffuse"]),
                                  ("diffuse-view", ["--specular", "off"]),
                                  ("diffuse", ["--specular", "off", "--reference-diffuse"])):
            result = run("render", self.scene(), "-o", self.path("p.exr"), *view, *options, "--json")
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(json.loads(result.stdout)["surfaces"], surfaces)
            means[surfaces] = read(self.path("p.exr"))
        self.assertEqual(len(set(means.values())), 4, "an option does nothing")
        for option in ("--reference-diffuse", "--reference-clamp=2"):
            self.assert_one_sentence(run("render", self.scene(), "-o", self.path("p.exr"), option), 2, "--reference")


if __name__ == "__main__":
    cli_case.main()
