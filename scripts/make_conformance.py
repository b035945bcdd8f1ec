#!/usr/bin/env python3
"""Bakes and draws assets/conformance, the pack that other runtimes are held to (docs/conformance.md).

    scripts/make_conformance.py HALFLIGHT [FOLDER]

HALFLIGHT is the program, FOLDER is assets/conformance unless given. law.json is made by tests/shading/law_table.cpp.
"""

import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
SIZE = "96x54"
MODES = ("realtime", "baked-indirect", "shadowmask", "distance-shadowmask")

# File, what it is for, bake options, cameras, render options. Few texels and probes: the files are to stay small.
FILES = (
    ("sphere_on_floor", "one sun, one dynamic sphere: the least that a runtime needs", ["--texels-per-meter", "10", "--probe-spacing", "1.5"], ["main"], []),
    ("five_lights", "four channels, and a fifth light that is fully baked", ["--texels-per-meter", "10", "--probe-spacing", "1.5", "--mask-layers", "1"],
     ["main"], []),
    ("thirteen_lights", "four mask layers, read from masks, probes and a volume", ["--texels-per-meter", "5", "--probe-layout", "grid", "--probe-spacing", "1.3"],
     ["main"], ["--shadow-distance", "0.5", "--shadow-fade-range", "0.4"]),
    ("coloured_glass", "a coloured mask: what passes three windows of a mixed sun, without the glass itself",
     ["--texels-per-meter", "8", "--probe-layout", "grid", "--probe-spacing", "1.5", "--reflection-probes", "off", "--settings", ROOT / "assets/tests/mixed_sun.toml"],
     ["floor"], ["--shadow-distance", "0.5", "--shadow-fade-range", "0.4"]),
    ("avenue", "shadow distance and fade; static and dynamic casters", ["--texels-per-meter", "4", "--probe-spacing", "4"], ["main", "close"],
     ["--shadow-distance", "20", "--shadow-fade-range", "6"]),
    ("proxy_volume", "probe light and occlusion, at one point and in volumes", ["--texels-per-meter", "8", "--probe-spacing", "1.5"], ["main"], []),
    ("bumpy_wall", "directional lightmap under a normal map; a baked light", ["--texels-per-meter", "10", "--directional", "on", "--probe-spacing", "1.5"],
     ["main"], []),
    ("light_groups", "light groups: saved weights, and others", ["--texels-per-meter", "4", "--directional", "on", "--probe-layout", "grid", "--probe-spacing", "1",
                                                                "--reflection-probes", "off"], ["main"], []),
    ("metal_rooms", "reflection probes of light groups, under a sky that changes",
     ["--texels-per-meter", "3", "--probe-layout", "grid", "--probe-spacing", "1.5", "--directional", "off"], ["main"], []),
)

# By file, where not all modes are drawn: realtime shadows of glass are grey, and three.js has its own.
MODES_OF = {"coloured_glass": ("shadowmask", "distance-shadowmask"), "metal_rooms": ("realtime", "shadowmask")}
# Weights of light groups by file, in pictures after those of the saved weights.
STATES = {"light_groups": {"lamp": [2, 3, 9], "sun": [0, 0, 0], "west": [0.1, 0.2, 0], "east": [0, 0, 0], "day": [0.02, 0.05, 0.3]},
          "metal_rooms": {"lamp": [1, 2, 4], "sun": [0.1, 0.05, 0], "west": [1, 0.1, 0], "east": [0, 0, 0], "sky.zenith": [0.1, 0.2, 1],
                          "sky.horizon": [6, 2, 0.5], "sky.ground": [0, 0.3, 0]}}


def run(*arguments):
    result = subprocess.run(list(map(str, arguments)), capture_output=True, text=True)
    if result.returncode != 0:
        sys.exit(f"{' '.join(map(str, arguments))}: {result.stderr}")
    return result.stdout


def pictures_of(program, folder, baked, cameras, modes, options, weights=None):
    groups = [word for name, rgb in (weights or {}).items() for word in ("--group", f"{name}={','.join(map(str, rgb))}")]
    for camera in cameras:
        for mode in modes:
            name = f"{baked.stem}_{camera}_{mode}{'_weights' if weights else ''}.exr"
            summary = json.loads(run(program, "render", baked, "-o", folder / name, "--size", SIZE, "--samples", 1, "--penumbrae", "off", "--mode", mode,
                                     "--camera", camera, "--json", *options, *groups))
            yield {
                "file": baked.name,
                "camera": camera,
                "mode": mode,
                **({"groups": weights} if weights else {}),
                "shadowDistance": summary["shadows"]["distance"],
                "shadowFadeRange": float(options[3]) if options else 1.0,
                "picture": name,
            }


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    program = pathlib.Path(sys.argv[1]).resolve()
    folder = pathlib.Path(sys.argv[2] if len(sys.argv) == 3 else ROOT / "assets/conformance")
    folder.mkdir(parents=True, exist_ok=True)
    entries, files = [], []
    for name, purpose, bake, cameras, options in FILES:
        scene = ROOT / "assets/tests" / f"{name}.glb"
        for suffix, mode, modes in (("", "shadowmask", MODES_OF.get(name, MODES)), ("_subtractive", "subtractive", ("subtractive",))):
            if suffix and name != "sphere_on_floor":
                continue
            baked = folder / f"{name}{suffix}.glb"
            run(program, "bake", scene, "-o", baked, "--quality", "preview", "--mode", mode, *bake)
            files.append({"file": baked.name, "purpose": purpose if not suffix else "the same in subtractive mode"})
            for weights in (None, STATES[name]) if name in STATES else (None,):
                entries += pictures_of(program, folder, baked, cameras, modes, options, weights)
    index = {
        "version": 1,
        "size": list(map(int, SIZE.split("x"))),
        "files": files,
        "tolerances": {"meanRelative": 0.015, "shareOfPixels": 0.97, "pixelRelative": 0.05},
        "pictures": entries,
    }
    (folder / "pictures.json").write_text(json.dumps(index, indent=1) + "\n", encoding="utf-8")
    print(f"{len(entries)} pictures of {len(files)} files in {folder}")


if __name__ == "__main__":
    main()
