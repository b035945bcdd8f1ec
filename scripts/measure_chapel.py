#!/usr/bin/env python3
"""Measures the chapel's moods against the path-traced reference with the changed lights, at one exposure: docs/quality_truth.md.

    scripts/measure_chapel.py HALFLIGHT BAKED.glb [MOOD …] [--samples 512] [--size 256x144]

Moods are those of scripts/chapel_moods.json. The measure is that of make_truth_report.py: mean relative luminance error over
boxes of 8 x 8 pixels.
"""

import argparse
import json
import pathlib
import tempfile

import make_truth_report as truth_report

MOODS = json.loads((pathlib.Path(__file__).parent / "chapel_moods.json").read_text())


def words_of(mood):
    return [word for group, weight in MOODS["moods"][mood].items() for word in ("--group", f"{group}={','.join(map(str, weight))}")]


class Chapel:
    def __init__(self, halflight, baked, size, folder):
        self.command = [halflight, "render", baked, "-o", folder / "picture.exr", "--camera", MOODS["camera"], "--size", size, "--quiet"]
        self.path = folder / "picture.exr"

    def picture(self, *words):
        truth_report.run(*self.command, *words)
        return truth_report.boxes(truth_report.read_exr(self.path))

    def row(self, mood, samples):
        words = words_of(mood)
        halves = [self.picture(*words, "--reference", max(1, samples // 2), "--seed", seed) for seed in ("1", "2")]
        truth = [(a + b) / 2 for a, b in zip(*halves)]
        found = [self.picture(*words, "--path", path, "--samples", "16") for path in ("forward", "deferred")]
        cells = [truth_report.percent(truth_report.error(values, truth)) for values in (*found, halves[0])]
        return f"| {mood} | {' | '.join(cells)} | {sum(truth) / len(truth):.3f} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("halflight")
    parser.add_argument("baked")
    parser.add_argument("moods", nargs="*", default=list(MOODS["moods"]))
    parser.add_argument("--samples", type=int, default=512)
    parser.add_argument("--size", default="256x144")
    options = parser.parse_args()
    print("| mood | forward | deferred | noise of the reference | mean, cd/m² |\n|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        chapel = Chapel(options.halflight, options.baked, options.size, pathlib.Path(folder))
        for mood in options.moods:
            print(chapel.row(mood, options.samples), flush=True)


if __name__ == "__main__":
    main()
