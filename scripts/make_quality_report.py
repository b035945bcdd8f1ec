#!/usr/bin/env python3
"""Measures the scenes of assets/quality/ anew and puts the figures into docs/quality.md, the pictures into docs/images/quality/.

    cmake --preset bench && cmake --build --preset bench
    scripts/make_quality_report.py [--build build/bench] [--figures-only]
"""

import argparse
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
BEGIN, END = "<!-- figures: scripts/make_quality_report.py -->\n", "<!-- end of figures -->\n"

BAKE = ["--quality", "preview", "--lightmap-size", "512", "--probe-spacing", "1000"]
# name: scene, options of the bake, options of the render
PICTURES = {
    "edges": ("rims", ["--texels-per-meter", "37"], ["--view", "lightmap", "--exposure", "1"]),
    "seams": ("seams", ["--texels-per-meter", "20", "--samples", "256"], ["--exposure", "2"]),
    "hems": ("curtain", ["--texels-per-meter", "10", "--bounces", "0"], ["--view", "lightmap", "--exposure", "2.2"]),
    "mask-attenuation": ("mask_edges", ["--texels-per-meter", "10"], ["--exposure", "0"]),
    "mask-distance": ("mask_edges", ["--texels-per-meter", "10", "--shadowmask-encoding", "distance-field"], ["--exposure", "0"]),
    "terminator": ("terminator", ["--texels-per-meter", "24"], ["--exposure", "0"]),
    "contact-raw": ("contact", ["--texels-per-meter", "14", "--samples", "16", "--denoise", "off"], ["--exposure", "0.5"]),
    "contact-denoised": ("contact", ["--texels-per-meter", "14", "--samples", "16"], ["--exposure", "0.5"]),
}


def run(*command):
    return subprocess.run([str(word) for word in command], check=True, capture_output=True, text=True).stdout


def pictures(halflight, folder):
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        for name, (scene, bake, render) in PICTURES.items():
            baked = pathlib.Path(scratch) / f"{name}.glb"
            run(halflight, "bake", ROOT / "assets" / "quality" / f"{scene}.glb", "-o", baked, *BAKE, *bake, "--quiet")
            run(halflight, "render", baked, "-o", folder / f"{name}.png", "--size", "480x270", *render)
            print(folder / f"{name}.png")


def figures(bench):
    # Exit code 1 says that a limit is missed; the table says which.
    result = subprocess.run([str(bench), "--markdown", "--assets", str(ROOT / "assets")], capture_output=True, text=True)
    if result.returncode not in (0, 1) or not result.stdout:
        sys.exit(f"{bench} failed: {result.stderr}")
    return by_scene(result.stdout)


def by_scene(table):
    """The rows of a table as one table for each scene, with notes below it, so that lines stay short enough to read."""
    lines, notes, shown = [], [], None
    for row in table.splitlines()[2:]:
        what, scene, figure, measured, limit, note = (cell.strip() for cell in row.strip("|").split("|"))
        if (what, scene) != shown:
            shown = (what, scene)
            lines += notes + ["", f"**{what}**, {scene}", "", "| what | measured | limit |", "|---|---|---|"]
            notes = []
        lines.append(f"| {figure} | {measured} | {limit} |")
        notes += ["", f"*{figure}*: {note}."] if note else []
    return "\n".join(lines + notes) + "\n\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "bench")
    parser.add_argument("--figures-only", action="store_true")
    options = parser.parse_args()
    table = figures(options.build / "bench" / "bench_quality")
    page = ROOT / "docs" / "quality.md"
    text = page.read_text()
    before, rest = text.split(BEGIN)
    page.write_text(before + BEGIN + table + END + rest.split(END)[1])
    print(table)
    if not options.figures_only:
        pictures(options.build / "apps" / "halflight" / "halflight", ROOT / "docs" / "images" / "quality")


if __name__ == "__main__":
    main()
