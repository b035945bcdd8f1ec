"""Files with KHR_materials_variants. Usage: variants_test.py HALFLIGHT SHARED_DIR [TestClass[.test]] …"""

import json
import os
import struct

import cli_case
from cli_case import QUICK, Case, edited, read, run

ROOMS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../assets/tests/light_groups.glb")


def json_of(path):
    data = read(path)
    (length,) = struct.unpack("<I", data[12:16])
    return json.loads(data[20 : 20 + length])


class Variants(Case):
    def test_variants_shine_by_the_weight_of_what_they_replace(self):
        """S33. The strips' nodes are of groups; each strip has a red variant, and names its own material in another."""
        def with_variants(document):
            neon = next(i for i, m in enumerate(document["materials"]) if m["name"] == "neon")
            red = json.loads(json.dumps(document["materials"][neon]))
            red.update(name="red neon", emissiveFactor=[1, 0.2, 0])
            document["materials"].append(red)
            variants = [{"material": neon, "variants": [0]}, {"material": neon + 1, "variants": [1]}]
            for mesh in document["meshes"]:
                for primitive in (p for p in mesh["primitives"] if p.get("material") == neon):
                    primitive["extensions"] = {"KHR_materials_variants": {"mappings": variants}}
            document.setdefault("extensions", {}).update({"KHR_materials_variants": {"variants": [{"name": "day"}, {"name": "night"}]}})
            document["extensionsUsed"].append("KHR_materials_variants")

        scene, output, again = edited(ROOMS, self.path("variants.glb"), with_variants), self.path("baked.glb"), self.path("again.glb")
        self.assertEqual(run("bake", scene, "-o", output, *QUICK, "-q").returncode, 0)
        document = json_of(output)
        groups = [group["name"] for group in document["extensions"]["HALFLIGHT_mixed_lighting"]["groups"]]
        strips = {node["name"]: document["meshes"][node["mesh"]]["primitives"][0] for node in document["nodes"] if node["name"].startswith("strip")}
        for name, primitive in strips.items():
            own, red = (m["material"] for m in primitive["extensions"]["KHR_materials_variants"]["mappings"])
            self.assertEqual(own, primitive["material"])
            baking = [document["materials"][i]["extensions"]["HALFLIGHT_material"]["baking"] for i in (own, red)]
            self.assertEqual([groups[b["group"]] for b in baking], [name.replace("strip_", "")] * 2)
            for white, nits, weight in zip(baking[1]["white"], (30, 6, 0), (1, 0.73, 0.47)):
                self.assertAlmostEqual(white, nits / weight, 3)
        # A state without groups dims the variants, and a second bake has as many materials.
        state = self.path("state.glb")
        self.assertEqual(run("compose", output, "-o", state, "-q", "--group", "west=0").returncode, 0)
        dark = json_of(state)
        for node in (n for n in dark["nodes"] if n["name"] == "strip_west"):
            for mapping in dark["meshes"][node["mesh"]]["primitives"][0]["extensions"]["KHR_materials_variants"]["mappings"]:
                self.assertEqual(dark["materials"][mapping["material"]].get("emissiveFactor", [0, 0, 0]), [0, 0, 0])
        self.assertEqual(run("bake", output, "-o", again, *QUICK, "-q").returncode, 0)
        self.assertEqual(len(json_of(again)["materials"]), len(document["materials"]))


if __name__ == "__main__":
    cli_case.main()
