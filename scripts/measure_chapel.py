#!/usr/bin/env python3
"""Measures the chapel's moods against the path-traced reference with the changed lights, at one exposure: docs/quality_truth.md.

    scripts/measure_chapel.py HALFLIGHT BAKED.glb [MOOD …] [--samples 512] [--size 256x144] [--three] [--keep DIR]

Moods are those of scripts/chapel_moods.json. The measure is that of make_truth_report.py: mean relative luminance error over
boxes of 8 x 8 pixels. --three measures three.js too, in headless Chromium, with WebGLRenderer and WebGPURenderer; without a
browser a sentence says so. --keep stores pictures of the reference, and takes those that are there: they are pictures of the
scene, not of its bake.
"""

import argparse
import json
import pathlib
import struct
import subprocess
import sys
import tempfile

import make_truth_report as truth_report

MOODS = json.loads((pathlib.Path(__file__).parent / "chapel_moods.json").read_text())
DRAW_STATES = truth_report.ROOT / "web/scripts/draw_states.mjs"
RENDERERS = {"webgl": "three.js", "webgpu": "three.js, WebGPU"}


def words_of(mood):
    return [word for group, weight in MOODS["moods"][mood].items() for word in ("--group", f"{group}={','.join(map(str, weight))}")]


class Chapel:
    def __init__(self, halflight, baked, size, folder, keep):
        self.halflight, self.baked, self.size, self.folder, self.keep = halflight, baked, size, folder, keep or folder
        self.keep.mkdir(parents=True, exist_ok=True)

    def render(self, path, *words):
        """Of the program: rows of (r, g, b)."""
        words = ("-o", path, "--camera", MOODS["camera"], "--size", self.size, "--quiet", *words)
        truth_report.run(self.halflight, "render", self.baked, *words)
        return truth_report.boxes(truth_report.read_exr(path))

    def reference(self, mood, samples, seed):
        path = self.keep / f"{mood}-{self.size}-{samples}-{seed}.exr"
        if path.exists():
            return truth_report.boxes(truth_report.read_exr(path))
        return self.render(path, *words_of(mood), "--reference", samples, "--seed", seed)

    def three(self, moods, renderer):
        """Boxes by mood; None where no browser draws."""
        states, out = self.folder / "states.json", self.folder / renderer
        states.write_text(json.dumps({mood: MOODS["moods"][mood] for mood in moods}))
        words = ["node", DRAW_STATES, self.baked, states, out, "--camera", MOODS["camera"], "--size", self.size, "--renderer", renderer]
        result = subprocess.run(words, stderr=subprocess.PIPE, text=True)
        sys.stderr.write(result.stderr)
        if result.returncode == 3:
            return None
        if result.returncode != 0:
            sys.exit(result.returncode)
        return {mood: truth_report.boxes(self.floats(out / f"{mood}.f32")) for mood in moods}

    def floats(self, path):
        width, height = map(int, self.size.split("x"))
        texels = list(struct.iter_unpack("<3f", path.read_bytes()))
        return [texels[y * width : (y + 1) * width] for y in range(height)]

    def row(self, mood, samples, pictures):
        halves = [self.reference(mood, max(1, samples // 2), seed) for seed in ("1", "2")]
        truth = [(a + b) / 2 for a, b in zip(*halves)]
        drawn = [self.render(self.folder / "picture.exr", *words_of(mood), "--path", path, "--samples", "16") for path in ("forward", "deferred")]
        found = [*drawn, *(boxes[mood] for boxes in pictures), halves[0]]
        cells = [truth_report.percent(truth_report.error(values, truth)) for values in found]
        return f"| {mood} | {' | '.join(cells)} | {sum(truth) / len(truth):.3f} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("halflight")
    parser.add_argument("baked")
    parser.add_argument("moods", nargs="*", default=list(MOODS["moods"]))
    parser.add_argument("--samples", type=int, default=512)
    parser.add_argument("--size", default="256x144")
    parser.add_argument("--three", action="store_true")
    parser.add_argument("--keep", type=pathlib.Path)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        chapel = Chapel(options.halflight, options.baked, options.size, pathlib.Path(folder), options.keep)
        pictures = {name: chapel.three(options.moods, renderer) for renderer, name in RENDERERS.items()} if options.three else {}
        pictures = {name: boxes for name, boxes in pictures.items() if boxes is not None}
        columns = ["mood", "forward", "deferred", *pictures, "noise of the reference", "mean, cd/m²"]
        print(f"| {' | '.join(columns)} |\n|{'---|' * len(columns)}")
        for mood in options.moods:
            print(chapel.row(mood, options.samples, pictures.values()), flush=True)


if __name__ == "__main__":
    main()
