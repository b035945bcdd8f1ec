"""`halflight bake`, what `info` and `render` say of its files, and interruptions.
Usage: bake_test.py HALFLIGHT SHARED_DIR [TestClass[.test]] …"""

import json
import os
import re
import signal
import struct
import subprocess
import threading

import cli_case
import json_schema
from cli_case import QUICK, Case, decode_png, read, run


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
        self.assertEqual(info["shadowmask"], {"pages": 1, "layers": 1, "size": 128})
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

    def test_json_follows_its_schemas(self):
        plain = self.scene(spots=5)
        baked, report = self.bake(plain, "baked.glb")
        values = [(report, "bake_report")]
        for file in (plain, baked):
            values.append((json.loads(run("info", file, "--json").stdout), "info_output"))
            for options in ([], ["--path", "deferred", "--timings"], ["--reference", "1"], ["--view", "overlap"]):
                values.append((self.rendered(file, *options)[0], "render_output"))
        values.append((json.loads(run("optimize", baked, self.path("small.glb"), "--json").stdout), "optimize_output"))
        for value, name in values:
            self.assertEqual(json_schema.check(value, name), [])
        # The checker finds what is wrong.
        rendered = values[-2][0]
        for path, wrong in (("mode", "half-baked"), ("size", [1]), ("warnings", "none"), ("extra", 1)):
            self.assertNotEqual(json_schema.problems({**rendered, path: wrong}, json_schema.load("render_output")), [])
        row = rendered["lights"]["rows"][0]
        del row["bakedShadow"]
        self.assertNotEqual(json_schema.problems(rendered, json_schema.load("render_output")), [])

    def test_fifth_overlapping_light_is_named(self):
        output = self.path("baked.glb")
        result = run("bake", self.scene(spots=5), "-o", output, *QUICK, "--mask-layers", "1", "--json")
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

    def test_mask_layers(self):
        scene, output = self.scene(spots=5), self.path("baked.glb")
        bake = run("bake", scene, "-o", output, *QUICK, "--json")
        self.assertEqual(bake.returncode, 0, bake.stderr)
        self.assertNotIn("fully baked", bake.stderr)
        info = json.loads(run("info", output, "--json").stdout)
        self.assertEqual(info["shadowmask"]["layers"], 2)
        self.assertEqual(sorted(light["channel"] for light in info["lights"]), [0, 1, 2, 3, 4, 5])
        self.assertIn(", 2 layers", run("info", output).stdout)
        # A sidecar is what other engines read, with four channels, unless layers are asked for.
        for options, layers in (([], 1), (["--mask-layers", "auto"], 2)):
            folder = self.path(f"beside_{layers}")
            result = run("bake", scene, "-o", output, *QUICK, "-q", "--sidecar", folder, *options)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(json.loads(run("info", output, "--json").stdout)["shadowmask"]["layers"], layers)
        # Where four channels do, the bytes are those of one layer.
        scene = self.scene(spots=2)
        for name, options in (("auto", []), ("one", ["--mask-layers", "1"])):
            self.assertEqual(run("bake", scene, "-o", self.path(name + ".glb"), *QUICK, "-q", *options).returncode, 0)
        with open(self.path("auto.glb"), "rb") as auto, open(self.path("one.glb"), "rb") as one:
            self.assertEqual(auto.read(), one.read())

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
        baked, report = self.bake(scene, "street.glb", "--lightmap-size", "256", "--mask-layers", "1")
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

    def test_a_time_prints_the_samples_that_repeat_it(self):
        scene = self.scene()
        timed = self.path("timed.glb")
        effort = ["--quality", "preview", "--bounces", "1", "--lightmap-size", "128"]
        result = run("bake", scene, "-o", timed, *effort, "--time", "2s")
        self.assertEqual(result.returncode, 0, result.stderr)
        samples = re.search(r"--samples (\d+) in place of --time", result.stdout)[1]
        plain, _ = self.bake(scene, "plain.glb", "--samples", samples, effort=effort)
        self.assertEqual(read(timed), read(plain))


class Interrupt(Case):
    def interrupt(self, number, *arguments):
        """Sends the signal once the program has named the stage of tracing rays; returns exit code and last line."""
        process = subprocess.Popen(
            [cli_case.HALFLIGHT, *arguments], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, bufsize=0
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


if __name__ == "__main__":
    cli_case.main()
