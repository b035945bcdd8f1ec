#!/usr/bin/env python3
"""Measures pictures of baked scenes against the path-traced reference, and puts the figures into docs/quality_truth.md.

    cmake --preset release && cmake --build --preset release
    scripts/make_truth_report.py [--samples 256] [--size 320x180] [SCENE.glb …]

Scenes are names in ../shared/scenes or paths; without any, all scenes with materials there and the showcase. Each is baked once
(--quality medium, shadowmask), and seen by its first camera, or as VIEWS says. The error of a mode is the mean of |L - R| / (R + M / 100) over boxes of 8 x 8 pixels that show
surfaces: L and R are a box's mean luminances in picture and reference, M is the mean of R. Rows of scenes that are not run keep
their figures. --keep DIR stores the bakes, and reads those that are there. --parts prints where a scene's error comes from instead, with
16 samples per pixel: of the bake and its display without specular lobes, against the reference without them; of the picture, against
the reference whose light goes on from diffuse surfaces as the bake's does; and of that light, against the whole reference. --pictures writes pairs of pictures at the reference's
exposure to docs/images/truth/.
"""

import argparse
import json
import pathlib
import struct
import subprocess
import sys
import tempfile
import zlib

ROOT = pathlib.Path(__file__).resolve().parent.parent
SHARED = ROOT.parent / "shared" / "scenes"
PAGE = ROOT / "docs" / "quality_truth.md"
BEGIN, END = "<!-- figures: scripts/make_truth_report.py -->\n", "<!-- end of figures -->\n"
MODES = ("baked-indirect", "shadowmask", "distance-shadowmask")
SCENES = (
    "sponza_crytek grey_white_room cornell_box_emissive cornell_box_point_light cornell_box_blend_nvidia mixed_lighting_chair "
    "dream_apartment_no_uv japanese_bridge_garden negative_scale_zoo primitive_zoo"
).split()
# Files without a camera whose view from outside shows the backs of walls.
VIEWS = {
    "cornell_box_emissive": ["--eye=-278,274,560", "--target=-278,274,-280"],
    "dream_apartment_no_uv": ["--eye=11.5,1.6,-3.4", "--target=8,1,-8"],
}
BOX = 8


def read_exr(path):
    """Rows of (r, g, b) of what `halflight render` writes."""
    return [list(zip(row["R"], row["G"], row["B"])) for row in exr_rows(path)]


def exr_rows(path):
    """Of each row the floats by channel: ZIP-compressed scan lines."""
    data = path.read_bytes()
    if data[:4] != b"\x76\x2f\x31\x01":
        sys.exit(f"{path}: not an OpenEXR file")
    at, attributes = 8, {}
    while data[at] != 0:
        name, kind, rest = data[at:].split(b"\0", 2)
        at += len(name) + len(kind) + 2
        size = struct.unpack_from("<i", data, at)[0]
        attributes[name] = data[at + 4 : at + 4 + size]
        at += 4 + size
    at += 1
    x0, y0, x1, y1 = struct.unpack("<4i", attributes[b"dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    names = [entry[: entry.index(b"\0")] for entry in channels(attributes[b"channels"])]
    rows = []
    for (offset,) in struct.iter_unpack("<Q", data[at : at + 8 * -(-height // 16)]):
        _, size = struct.unpack_from("<2i", data, offset)
        lines = min(16, height - len(rows))
        block = unpacked(data[offset + 8 : offset + 8 + size], 4 * width * lines * len(names))
        for line in range(lines):
            values = {}
            for i, name in enumerate(names):
                values[name.decode()] = struct.unpack_from(f"<{width}f", block, 4 * width * (line * len(names) + i))
            rows.append(values)
    return rows


def channels(text):
    """Name and values of each channel: a name, then 16 bytes."""
    while text and text[0] != 0:
        end = text.index(b"\0") + 17
        yield text[:end]
        text = text[end:]


def unpacked(block, size):
    """OpenEXR's ZIP: deflate over differences of bytes, whose even ones come first."""
    if len(block) == size:
        return block
    differences = bytearray(zlib.decompress(block))
    for i in range(1, len(differences)):
        differences[i] = (differences[i - 1] + differences[i] - 128) & 255
    half = (len(differences) + 1) // 2
    out = bytearray(len(differences))
    out[0::2], out[1::2] = differences[:half], differences[half:]
    return bytes(out)


def boxes(rows):
    """Mean luminance of each 8 x 8 box that lies wholly in the picture."""
    out = []
    for y in range(0, len(rows) - BOX + 1, BOX):
        for x in range(0, len(rows[0]) - BOX + 1, BOX):
            texels = [texel for row in rows[y : y + BOX] for texel in row[x : x + BOX]]
            out.append(sum(0.2126 * r + 0.7152 * g + 0.0722 * b for r, g, b in texels) / len(texels))
    return out


def error(found, truth):
    floor = 0.01 * sum(truth) / len(truth)
    return sum(abs(f - t) / (t + floor) for f, t in zip(found, truth)) / len(truth)


def run(*command):
    result = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if result.returncode != 0:
        sys.exit(result.stderr)
    return result.stdout


class Scene:
    """A baked scene, and the boxes of its pictures that show surfaces."""

    def __init__(self, halflight, scene, options, folder):
        self.halflight, self.folder = halflight, folder
        self.baked = (options.keep or folder) / f"{scene.stem}.glb"
        if not self.baked.exists():
            run(halflight, "bake", scene, "-o", self.baked, "--quality", "medium", "--quiet")
        self.view = ["--size", options.size, "--quiet", *VIEWS.get(scene.stem, [])]
        # All surfaces lie beyond a shadow distance of a centimetre, and the view of the fade is 0 where there are none.
        self.chosen = None
        fade = self.picture("--view", "fade", "--shadow-distance", "0.01", "--shadow-fade-range", "0.01")
        self.chosen = [share > 0.5 for share in fade]
        if not any(self.chosen):
            sys.exit(f"{scene.name}: the picture shows no surface")

    def picture(self, *words):
        """Means of the boxes of one picture."""
        path = self.folder / "picture.exr"
        run(self.halflight, "render", self.baked, "-o", path, *self.view, *words)
        means = boxes(read_exr(path))
        return means if self.chosen is None else [mean for mean, shows in zip(means, self.chosen) if shows]

    def truth(self, samples, *words):
        """The reference, and its noise: the halves of its samples differ by twice what their mean is off by, about."""
        half = ["--reference", max(1, samples // 2), *words]
        halves = [self.picture(*half, "--seed", seed) for seed in ("1", "2")]
        mean = [(a + b) / 2 for a, b in zip(*halves)]
        return mean, error(halves[0], mean)


def percent(value):
    return f"{100 * value:.1f} %"


def parts(halflight, scene, options, folder):
    shown = Scene(halflight, scene, options, folder)
    whole, noise = shown.truth(options.samples)
    diffuse_light, _ = shown.truth(options.samples, "--reference-diffuse")
    diffuse, _ = shown.truth(options.samples, "--specular", "off")
    mode = ["--mode", MODES[-1]]
    fine = [*mode, "--samples", "16"]
    picture = shown.picture(*fine)
    cells = [
        error(shown.picture(*mode), whole),
        error(picture, whole),
        error(shown.picture(*fine, "--specular", "off"), diffuse),
        error(picture, diffuse_light),
        error(diffuse_light, whole),
        noise,
    ]
    return f"| {scene.stem} | {' | '.join(percent(cell) for cell in cells)} |\n"


def measure(halflight, scene, options, folder):
    shown = Scene(halflight, scene, options, folder)
    truth, noise = shown.truth(options.samples)
    cells = []
    pictures_of = [["--mode", mode] for mode in MODES] + [["--mode", MODES[-1], "--reflection-probes", "off"]]
    for wanted in pictures_of:
        cells.append(percent(error(shown.picture(*wanted), truth)))
    if options.pictures:
        pictures(halflight, scene, shown.baked, options)
    return f"| {scene.stem} | {' | '.join(cells)} | {percent(noise)} | {options.samples}, {options.size} |\n"


def pictures(halflight, scene, baked, options):
    folder = ROOT / "docs" / "images" / "truth"
    folder.mkdir(parents=True, exist_ok=True)
    view = ["--size", options.size, "--json", *VIEWS.get(scene.stem, [])]
    truth = run(halflight, "render", baked, "-o", folder / f"{scene.stem}-truth.png", *view, "--reference", options.samples)
    exposure = str(json.loads(truth)["exposure"])
    run(halflight, "render", baked, "-o", folder / f"{scene.stem}.png", *view, "--mode", MODES[-1], "--exposure", exposure)


def with_rows(text, rows):
    """The page with new rows, old ones kept, in the order of their names."""
    before, rest = text.split(BEGIN)
    table, after = rest.split(END)
    lines = table.splitlines(keepends=True)
    kept = {line.split("|")[1].strip(): line for line in lines[2:]}
    kept.update(rows)
    return before + BEGIN + "".join(lines[:2]) + "".join(kept[name] for name in sorted(kept)) + END + after


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", metavar="SCENE")
    parser.add_argument("--samples", type=int, default=256, help="of the reference, per pixel")
    parser.add_argument("--size", default="320x180")
    parser.add_argument("--pictures", action="store_true")
    parser.add_argument("--parts", action="store_true")
    parser.add_argument("--keep", type=pathlib.Path, metavar="DIR")
    parser.add_argument("--halflight", type=pathlib.Path, default=ROOT / "build/release/apps/halflight/halflight")
    options = parser.parse_args()
    scenes = [pathlib.Path(s) if pathlib.Path(s).exists() else SHARED / s for s in options.scenes]
    if not scenes:
        scenes = [SHARED / f"{name}.glb" for name in SCENES] + [ROOT / "assets" / "courtyard.glb"]
    for scene in scenes:
        if not scene.exists():
            print(f"{scene.name} is skipped: there is no {scene}", file=sys.stderr)
            continue
        with tempfile.TemporaryDirectory() as folder:
            row = (parts if options.parts else measure)(options.halflight, scene, options, pathlib.Path(folder))
        print(row, end="", flush=True)
        if options.parts:
            continue
        PAGE.write_text(with_rows(PAGE.read_text(), {scene.stem: row}))


if __name__ == "__main__":
    main()
