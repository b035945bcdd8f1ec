#!/usr/bin/env python3
"""Compares bakes of Halflight with bakes of Blender's Cycles: the processor's seconds until both have the same error.

    bench/compare_cycles.py SCENES [--references DIR] [--program PROGRAM] [--runs N] [--output FIGURES.json]

SCENES is a folder with cornell.gltf and courtyard.gltf, each with a lightmap's layout in TEXCOORD_1. Both programs bake
diffuse light with at most four bounces into 512 x 512 texels, without denoising. Error is the root mean square
difference of luminance from many samples of Cycles, over their mean. The references are rendered in parts with seeds of
their own. How much the parts differ tells the mean's noise, which is taken out. A folder keeps them for the next time.

Cycles' seconds are its bake's alone, without Blender's start. Halflight's are the whole program's, its probes included.
The programs take turns, and medians count. Cycles samples the triangle at a texel's centre and counts points inside of
solids as black. So black texels are left out; in the courtyard also those close to one, to a chart's border or to an
edge of the sun's light. Figures named "away" leave these out in both scenes.
"""

import argparse
import json
import math
import os
import pathlib
import platform
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
PROGRAM = HERE.parent / "build/bench/apps/halflight/halflight"
OPTIONS = (
    "--uv keep --lightmap-size 512 --denoise off --bounces 4 --quality preview --reflection-probes off "
    "--glossy-bounces off"
).split()
SUN = '[[light]]\npattern = "*"\nmode = "baked"\nangular_diameter = 0.526\n'

CYCLES_SAMPLES = (16, 64, 256)  # the last is what the programs are compared at
HALFLIGHT_SAMPLES = (16, 32, 64, 128)  # 32 are preview's
PART_SAMPLES = 512
PART_SEED, MEASURED_SEED = 1, 1001  # of the first part of a reference, of the first measured bake
SUN_SAMPLES = 64

# Name, samples of the reference, and whether the sun shines.
SCENES = (("cornell", 4096, False), ("courtyard", 2048, True))


def output_of(command):
    environment = dict(os.environ)
    # Debian's Blender takes the first python3 on PATH for its own, which another one (pyenv) may be.
    if blender := shutil.which("blender"):
        environment["PATH"] = f"{pathlib.Path(blender).resolve().parent}:{environment['PATH']}"
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False, env=environment)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\n{done.stdout}{done.stderr}")
    return done.stdout


def in_blender(*arguments):
    script = HERE / "cycles_in_blender.py"
    return output_of(["blender", "-b", "--python-exit-code", "1", "--python", script, "--", *arguments])


def bake_with_cycles(scene, picture, samples, *options):
    """Returns the processor's seconds of the bake. An interrupted one leaves no picture."""
    unfinished = picture.with_name("unfinished.npy")
    lines = in_blender("bake", scene, unfinished, "--samples", samples, *options).splitlines()
    unfinished.rename(picture)
    return next(float(line.split()[-1]) for line in lines if line.startswith("cpu seconds "))


def bake_with_halflight(program, scene, folder, samples, seed):
    """Returns the processor's seconds, and the picture of a second bake that is not measured."""
    settings = folder / "sun.toml"
    settings.write_text(SUN)
    command = [program, "bake", scene, "-o", folder / "baked.glb", "-q", *OPTIONS, "--settings", settings]
    command += ["--samples", samples, "--seed", seed]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    output_of(command)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    images = folder / f"{scene.stem}_halflight_{samples}_{seed}"
    output_of([*command, "--write-images", images])
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, images / "lightmap_0.exr"


def reference_of(scene, folder, samples, has_sun):
    """What a comparison needs, rendered where the folder does not have it."""
    parts = range(PART_SEED, PART_SEED + max(2, samples // PART_SAMPLES))
    wanted = {folder / f"{scene.stem}_{PART_SAMPLES}_{seed}.npy": (PART_SAMPLES, "--seed", seed) for seed in parts}
    job = {"reference": [str(path) for path in wanted]}
    if has_sun:
        shadowed, unshadowed = folder / f"{scene.stem}_sun.npy", folder / f"{scene.stem}_sun_unshadowed.npy"
        wanted[shadowed] = (SUN_SAMPLES, "--direct")
        wanted[unshadowed] = (SUN_SAMPLES, "--direct", "--no-shadows")
        job |= {"shadowed": str(shadowed), "unshadowed": str(unshadowed)}
    for path, options in wanted.items():
        if not path.exists():
            print(f"rendering {path}", flush=True)
            bake_with_cycles(scene, path, *options)
    return job


def measure(scene, program, runs, folder):
    """Bakes in turn. Returns seconds and pictures by program and samples."""
    seconds, pictures = {}, {}
    for seed in range(MEASURED_SEED, MEASURED_SEED + runs):
        for samples in CYCLES_SAMPLES:
            key, picture = ("cycles", samples), folder / f"{scene.stem}_cycles_{samples}_{seed}.npy"
            seconds.setdefault(key, []).append(bake_with_cycles(scene, picture, samples, "--seed", seed))
            pictures.setdefault(key, []).append(str(picture))
        for samples in HALFLIGHT_SAMPLES:
            key = ("halflight", samples)
            spent, picture = bake_with_halflight(program, scene, folder, samples, seed)
            seconds.setdefault(key, []).append(spent)
            pictures.setdefault(key, []).append(str(picture))
    return seconds, pictures


def seconds_at(error, points, key):
    """Between two measured points on a straight line of logarithms; outside of them, what the nearest one takes."""
    points = sorted(points, key=lambda point: point[key])
    if error <= points[0][key]:
        return points[0]["seconds"]
    for finer, coarser in zip(points, points[1:]):
        if error <= coarser[key]:
            share = math.log(error / finer[key]) / math.log(coarser[key] / finer[key])
            return finer["seconds"] * (coarser["seconds"] / finer["seconds"]) ** share
    return points[-1]["seconds"]


def at_equal_error(figures, key):
    cycles = figures["cycles"][-1]
    ours = seconds_at(cycles[key], figures["halflight"], key)
    return {"error": cycles[key], "cycles": cycles["seconds"], "halflight": ours, "ratio": cycles["seconds"] / ours}


def compare(scene, seconds, pictures, job, folder):
    """Figures of a scene."""
    job |= {"pictures": sum(pictures.values(), []), "result": str(folder / "result.json")}
    (folder / "job.json").write_text(json.dumps(job))
    in_blender("compare", folder / "job.json")
    result = json.loads((folder / "result.json").read_text())
    figures = {"name": scene.stem, "referenceSamples": len(job["reference"]) * PART_SAMPLES}
    figures |= {key: result[key] for key in ("texels", "texelsAway", "referenceNoise")}
    figures |= {"cycles": [], "halflight": []}
    for (program, samples), spent in seconds.items():
        compared = [result["pictures"][path] for path in pictures[program, samples]]
        point = {"samples": samples, "seconds": statistics.median(spent)}
        point |= {key: statistics.median(one[key] for one in compared) for key in ("error", "errorAway", "bias")}
        figures[program].append(point)
    figures |= {"equal": at_equal_error(figures, "error"), "equalAway": at_equal_error(figures, "errorAway")}
    return figures


def show(figures):
    print(
        f"\n{figures['name']}: {figures['texels']:,} texels, {figures['texelsAway']:,} of them away from black ones; "
        f"reference of {figures['referenceSamples']:,} samples, its noise of {figures['referenceNoise']:.2%} taken out"
    )
    print("program    samples  CPU seconds   error    away    bias")
    for name in ("cycles", "halflight"):
        for point in figures[name]:
            print(
                f"{name:10} {point['samples']:7} {point['seconds']:12.2f} {point['error']:7.2%} "
                f"{point['errorAway']:7.2%} {point['bias']:7.2%}"
            )
    for key, which in (("equal", "all"), ("equalAway", "away")):
        equal = figures[key]
        print(
            f"{which}, at {equal['error']:.2%}: Cycles {equal['cycles']:.1f} s, Halflight {equal['halflight']:.2f} s, "
            f"{equal['ratio']:.1f} times",
            flush=True,
        )


def machine():
    try:
        lines = pathlib.Path("/proc/cpuinfo").read_text().splitlines()
        model = next(line.split(":")[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        model = platform.machine()
    return f"{os.cpu_count()} cores of {model}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", type=pathlib.Path)
    parser.add_argument("--references", type=pathlib.Path, default=pathlib.Path("out/cycles"))
    parser.add_argument("--reference-samples", type=int, help="of both scenes (default: 4096, courtyard 2048)")
    parser.add_argument("--program", type=pathlib.Path, default=PROGRAM)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--output", type=pathlib.Path, default=HERE / "cycles_figures.json")
    arguments = parser.parse_args()
    arguments.references.mkdir(parents=True, exist_ok=True)
    versions = [output_of([program, "--version"]).splitlines()[0] for program in ("blender", arguments.program)]
    figures = {"machine": machine(), "versions": versions, "scenes": []}
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        scenes = [(arguments.scenes / f"{name}.gltf", samples, has_sun) for name, samples, has_sun in SCENES]
        measured = [measure(scene, arguments.program, arguments.runs, folder) for scene, _, _ in scenes]
        for (scene, samples, has_sun), (seconds, pictures) in zip(scenes, measured):
            samples = arguments.reference_samples or samples
            job = reference_of(scene, arguments.references, samples, has_sun)
            figures["scenes"].append(compare(scene, seconds, pictures, job, folder))
            show(figures["scenes"][-1])
    arguments.output.write_text(json.dumps(figures, indent=2) + "\n")


main()
