#!/usr/bin/env python3
"""Bakes the same scenes with two programs and compares bytes and processor time: for changes that should move code alone.

    compare_bakes.py BEFORE AFTER [--runs N]

BEFORE and AFTER are two halflight programs. Exits with 1 where any bake's bytes differ. The seconds are the processor's,
of all threads; with --runs, the programs take turns and the median counts.
"""

import argparse
import filecmp
import pathlib
import resource
import statistics
import subprocess
import sys
import tempfile

ASSETS = pathlib.Path(__file__).resolve().parent.parent / "assets"

# Name, scene, options: between them all modes, both integrators and what rays meet.
BAKES = [
    ("shadowmask", "tests/sphere_on_floor.glb", []),
    ("baked indirect, directional", "tests/two_rooms.glb", ["--mode", "baked-indirect", "--directional", "on"]),
    ("subtractive", "tests/five_lights.glb", ["--mode", "subtractive"]),
    ("area lights", "tests/area_lights.glb", []),
    ("sheets", "tests/sheets.glb", ["--two-sided", "on"]),
    ("instances", "tests/instances_1023.glb", ["--lightmap-size", "512", "--probe-spacing", "8"]),
    ("path integrator", "tests/closed_room.glb", ["--integrator", "path", "--samples", "32"]),
    ("alpha and reflections", "courtyard.glb", ["--lightmap-size", "256"]),
]


def seconds(command):
    """Runs a command, and returns the processor's seconds that it took."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\n{done.stderr}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def bake(program, scene, options, folder):
    out = folder / "baked.glb"
    return out, seconds([program, "bake", scene, "-o", out, "--quality", "preview", *options])


def farm(program, scene, _, folder):
    plan, out = folder / "farm", folder / "baked.glb"
    spent = seconds([program, "farm", "plan", scene, "-o", plan, "--quality", "preview"])
    for worker in range(2):
        spent += seconds([program, "farm", "work", plan, "--index", str(worker), "--of", "2"])
    return out, spent + seconds([program, "farm", "join", plan, "-o", out])


def compare(name, make, scene, options, programs, runs):
    """Prints a line. Returns whether the bytes are the same."""
    spent = ([], [])
    same = True
    for _ in range(runs):
        with tempfile.TemporaryDirectory() as first, tempfile.TemporaryDirectory() as second:
            made = []
            for i, folder in enumerate((first, second)):
                out, took = make(programs[i], scene, options, pathlib.Path(folder))
                made.append(out)
                spent[i].append(took)
            same = same and filecmp.cmp(*made, shallow=False)
    before, after = (statistics.median(s) for s in spent)
    print(f"{name:30} {'same bytes' if same else 'OTHER BYTES':12} {before:7.2f} s {after:7.2f} s  {after / before:5.3f}",
          flush=True)
    return same


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("before")
    parser.add_argument("after")
    parser.add_argument("--runs", type=int, default=1)
    arguments = parser.parse_args()
    programs = (arguments.before, arguments.after)
    same = [compare(name, bake, ASSETS / scene, options, programs, arguments.runs) for name, scene, options in BAKES]
    same.append(compare("farm", farm, ASSETS / "tests/sphere_on_floor.glb", [], programs, arguments.runs))
    sys.exit(0 if all(same) else 1)


if __name__ == "__main__":
    main()
