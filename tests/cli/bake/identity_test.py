"""What a bake promises where processors differ: the same layout with each instruction set, the same picture within
noise, and a sentence where results of one would mix with another's.
Usage: identity_test.py HALFLIGHT SHARED_DIR [TestClass[.test]] …"""

import glob
import json
import os
import re
import struct

import cli_case
import json_schema
from cli_case import QUICK, Case, decode_png, read, run
from farm_test import FarmCase

ASSETS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "assets")
SETS = ("sse2", "avx2", "avx512")
# What lays out texels is the same with few samples; their number changes light alone.
FEW = ["--quality", "preview", "--samples", "16", "--shadow-samples", "2", "--bounces", "1", "--reflection-probes", "off"]


def sets_of_this_processor(folder):
    """All processors of x86 have sse2; the others are refused in a sentence where they are missing."""
    found = []
    for name in SETS:
        result = run("bake", os.path.join(ASSETS, "tests", "penumbra.glb"), "-o", os.path.join(folder, "x.glb"), *FEW, "-q", "--isa", name)
        if result.returncode == 0:
            found.append(name)
        else:
            assert result.returncode == 1 and "--isa sse2" in result.stderr, result.stderr
    return found


def layout(path):
    """Bytes of all vertices and triangles, with the lightmap coordinates; lights with their channels."""
    data = read(path)
    (length,) = struct.unpack("<I", data[12:16])
    document = json.loads(data[20 : 20 + length])
    binary = data[28 + length :]
    views = document["bufferViews"]
    parts = []
    for mesh in document["meshes"]:
        for primitive in mesh["primitives"]:
            for name, number in sorted({**primitive["attributes"], "indices": primitive["indices"]}.items()):
                accessor = document["accessors"][number]
                view = views[accessor["bufferView"]]
                begin = view.get("byteOffset", 0)
                parts.append((name, accessor["count"], binary[begin : begin + view["byteLength"]]))
    return parts, document.get("extensions", {}).get("KHR_lights_punctual")


class Layouts(Case):
    """Charts, lightmap coordinates, pages and channels do not depend on the processor. Probes are closer together where
    light changes, which noise decides for some: their number is the same within 1 %."""

    scenes = [os.path.join(ASSETS, "tests", name + ".glb") for name in ("sphere_on_floor", "closed_room", "bumpy_wall")]
    options = FEW

    def reports(self, scene):
        """By instruction set: what a bake says of its layout, and the file."""
        found = {}
        for name in self.sets:
            output = self.path(name + ".glb")
            result = run("bake", scene, "-o", output, *self.options, "--isa", name, "--json", timeout=900)
            self.assertEqual(result.returncode, 0, result.stderr)
            report = json.loads(result.stdout)
            self.assertIn(f"-{name}-", report["identity"])
            lightmap = {key: report["lightmap"][key] for key in ("charts", "cuts", "pages", "size", "coveredTexels")}
            channels = [(light["name"], light["channel"]) for light in report["lights"]]
            found[name] = (lightmap, channels, report["triangles"]), report["probes"]["count"], output
        return found

    def test_are_those_of_each_instruction_set(self):
        self.sets = sets_of_this_processor(self.folder.name)
        self.assertGreaterEqual(len(self.sets), 1)
        for scene in self.scenes:
            with self.subTest(scene=os.path.basename(scene)):
                found = self.reports(scene)
                words, probes, first = found[self.sets[0]]
                for name in self.sets[1:]:
                    self.assertEqual(found[name][0], words, name)
                    self.assertAlmostEqual(found[name][1], probes, delta=0.01 * probes, msg=name)
                    self.assertEqual(layout(found[name][2]), layout(first), name)
                self.compare_pictures([found[name][2] for name in self.sets])

    def compare_pictures(self, files):
        pass


class AllLayouts(Layouts):
    """The same of all the project's scenes, and their pictures: other rays give light that differs within its noise."""

    options = ["--quality", "preview", "--lightmap-size", "512"]

    def setUp(self):
        super().setUp()
        files = sorted(glob.glob(os.path.join(ASSETS, "**", "*.glb"), recursive=True))
        said = {file: run("info", file, "--json") for file in files}
        self.scenes = [file for file in files if said[file].returncode == 0 and not json.loads(said[file].stdout)["baked"]]
        self.assertGreater(len(self.scenes), 20)

    def compare_pictures(self, files):
        pictures = []
        for number, file in enumerate(files):
            picture = self.path(f"{number}.png")
            result = run("render", file, "-o", picture, "--size", "320x180", "-q")
            self.assertEqual(result.returncode, 0, result.stderr)
            pictures.append(decode_png(picture)[2])
        for picture in pictures[1:]:
            differences = [
                abs(a - b) for row, other in zip(picture, pictures[0]) for x, y in zip(row, other) for a, b in zip(x, y)
            ]
            self.assertLess(sum(differences) / len(differences), 0.006 * 255)


class Identities(FarmCase):
    def test_are_in_reports_versions_and_plans(self):
        version = run("--version").stdout
        (identity,) = re.findall(r"bakes as (cpu-embree-[\d.]+-\w+-[0-9a-f]{8})\n", version)
        baked, report = self.bake(self.scene(), "baked.glb")
        json_schema.check(report, "bake_report")
        self.assertEqual(report["identity"], identity)
        self.assertIn(f"identity   {identity}\n", run("bake", self.scene(), "-o", baked, *QUICK).stdout)
        plan = self.plan(self.scene(), *QUICK)
        self.assertEqual(json.loads(read(os.path.join(plan, "plan.json")))["scenes"][0]["identity"], identity)

    def foreign(self, *arguments):
        """A plan of another machine."""
        plan = self.plan(self.scene(), *QUICK, *arguments)
        file = os.path.join(plan, "plan.json")
        words = json.loads(read(file))
        words["scenes"][0]["identity"] = "cpu-embree-9.9.9-avx2-00000000"
        with open(file, "w") as out:
            json.dump(words, out)
        return plan

    def test_of_another_machine_stop_farms(self):
        plan = self.foreign()
        words = ("cpu-embree-9.9.9-avx2-00000000", "cpu-embree-3", "--isa sse2", "--mixed")
        self.assert_one_sentence(self.work(plan, 0, 1), 1, *words)
        # The tiles of the other machine, as if it had made them: what would be joined here has other bytes.
        cache = os.path.join(plan, "cache")
        own = self.plan(self.scene(), *QUICK, folder="own")
        self.work_all(own, 1)
        (made,) = os.listdir(os.path.join(own, "cache"))
        os.rename(os.path.join(own, "cache", made), os.path.join(cache, "cpu-embree-9.9.9-avx2-00000000"))
        self.assert_one_sentence(self.join(plan), 1, *words)

    def test_one_instruction_set_or_mixed_machines(self):
        for arguments in (["--isa", "sse2"], ["--mixed"]):
            plan = self.plan(self.scene(), *QUICK, *arguments, folder=arguments[-1].strip("-"))
            self.work_all(plan, 2)
            joined = self.joined(plan)
            baked = self.baked(self.scene(), *QUICK, *[word for word in arguments if word != "--mixed"])
            self.assertEqual(joined, baked, "one machine gives the bytes of its bake, mixed or not")

    def test_have_their_own_results_in_a_cache(self):
        scene, cache = self.scene(), self.path("cache")
        output, _ = self.bake(scene, "a.glb", "--cache", cache)
        (own,) = [name for name in os.listdir(cache) if name.startswith("cpu-")]
        other = "cpu-embree-9.9.9-avx2-00000000"
        os.rename(os.path.join(cache, own), os.path.join(cache, other))
        held = sorted(glob.glob(os.path.join(cache, other, "**"), recursive=True))
        os.remove(output)
        result = run("bake", scene, "-o", output, *QUICK, "--cache", cache, "--json")
        report = json.loads(result.stdout)
        self.assertEqual(report["cache"]["same"], 0)
        said = [line for line in report["warnings"] if other in line]
        self.assertEqual(len(said), 1, report["warnings"])
        self.assertEqual(sorted(glob.glob(os.path.join(cache, other, "**"), recursive=True)), held)


if __name__ == "__main__":
    cli_case.main()
