"""Pictures of baked scenes against the path-traced reference. Usage: truth_test.py HALFLIGHT SHARED_DIR [TestClass[.test]] …"""

import argparse
import json
import math
import pathlib
import sys
import tempfile

import cli_case
import tiny_scene
from cli_case import Case

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "scripts"))
import make_truth_report as report


MAZE = 3  # boxes along each side


def write_maze(path):
    """Boxes of rough metal of different heights on a floor, a lamp at every second crossing, a camera in a corridor."""
    tiny_scene.write(path)
    document = json.loads(pathlib.Path(path).read_text(encoding="utf-8"))
    rotation = [0, math.sin(-0.1), 0, math.cos(-0.1)]
    nodes = [
        {"name": "floor", "mesh": 0, "translation": [0, -0.1, 0], "scale": [8, 0.2, 8]},
        {"name": "camera", "camera": 0, "translation": [-1.1, 1.1, 3.6], "rotation": rotation},
    ]
    mesh = document["meshes"][0]["primitives"][0]
    materials = [{"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0, "roughnessFactor": 0.6}}]
    meshes = [{"primitives": [{**mesh, "material": 0}]}]
    for i in range(MAZE**2):
        x, z = i % MAZE, i // MAZE
        color = [0.3 + 0.1 * ((3 * i + channel) % 5) for channel in (0, 2, 4)]
        materials.append({"pbrMetallicRoughness": {"baseColorFactor": [*color, 1], "metallicFactor": 1, "roughnessFactor": 0.3 + 0.03 * i}})
        meshes.append({"primitives": [{**mesh, "material": i + 1}]})
        height = 1.3 + 0.1 * (i * 5 % 9)
        nodes.append({"name": f"box_{i}", "mesh": i + 1, "translation": [2.2 * (x - 1), height / 2, 2.2 * (z - 1)], "scale": [1.4, height, 1.4]})
    lights = [{"type": "point", "intensity": 8 + i, "color": [1, 0.9 - 0.1 * i, 0.5 + 0.1 * i], "range": 9} for i in range(5)]
    for i, place in enumerate([(-1.1, -1.1), (1.1, 1.1), (-3.3, 1.1), (1.1, -3.3), (3.3, 3.3)]):
        nodes.append({"name": f"lamp_{i}", "translation": [place[0], 1.2, place[1]], "extensions": {"KHR_lights_punctual": {"light": i}}})
    document.update(nodes=nodes, meshes=meshes, materials=materials, scenes=[{"nodes": list(range(len(nodes)))}])
    document["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1.1, "znear": 0.05, "zfar": 100, "aspectRatio": 16 / 9}}]
    document["extensions"] = {"KHR_lights_punctual": {"lights": lights}}
    pathlib.Path(path).write_text(json.dumps(document), encoding="utf-8")


class Truth(Case):
    def test_reflection_probes_bring_a_glossy_room_nearer(self):
        """4.6 % with the probes and 7.9 % without them; probes at badly chosen places are worse than none."""
        scene = pathlib.Path(cli_case.SHARED, "scenes", "cornell_box_emissive.glb")
        if not scene.exists():
            self.skipTest(f"there is no {scene}")
        with tempfile.TemporaryDirectory() as folder:
            options = argparse.Namespace(keep=None, size="128x72")
            shown = report.Scene(cli_case.HALFLIGHT, scene, options, pathlib.Path(folder))
            truth, noise = shown.truth(256)
            mode = ["--mode", "distance-shadowmask"]
            near = report.error(shown.picture(*mode), truth)
            without = report.error(shown.picture(*mode, "--reflection-probes", "off"), truth)
        self.assertLess(noise, 0.03)
        self.assertLess(near, 0.065)
        self.assertLess(near, 0.8 * without)

    def maze_errors(self, scene, samples, *options):
        """Of a preview, against the reference: with reflection probes, without them, and the reference's noise."""
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            baked = folder / f"{scene.stem}.glb"
            report.run(cli_case.HALFLIGHT, "bake", scene, "-o", baked, "--quality", "preview", "--lightmap-size", "256", "--quiet", *options)
            shown = report.Scene(cli_case.HALFLIGHT, scene, argparse.Namespace(keep=folder, size="128x72"), folder)
            truth, noise = shown.truth(samples)
            mode = ["--mode", "distance-shadowmask"]
            near = report.error(shown.picture(*mode), truth)
            return near, report.error(shown.picture(*mode, "--reflection-probes", "off"), truth), noise

    def test_probes_make_no_maze_of_metal_worse(self):
        """A small maze, so that the test needs no file: with directions and without them."""
        with tempfile.TemporaryDirectory() as folder:
            scene = pathlib.Path(folder, "maze.gltf")
            write_maze(scene)
            for directional in ("on", "off"):
                near, without, noise = self.maze_errors(scene, 256, "--directional", directional)
                self.assertLess(near, without + 0.3 * noise, directional)

    def test_probes_make_the_metal_maze_no_worse(self):
        """Two probes for 36 boxes made 97 % of 65 %."""
        scene = pathlib.Path(cli_case.SHARED, "cases", "metal-maze", "metal_maze.glb")
        if not scene.exists():
            self.skipTest(f"there is no {scene}")
        near, without, noise = self.maze_errors(scene, 256)
        self.assertLess(near, without + 0.3 * noise)
        self.assertLess(near, 0.45)


if __name__ == "__main__":
    cli_case.main()
