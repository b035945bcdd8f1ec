#!/usr/bin/env python3
"""Submits a plan of `halflight farm plan` to OpenCue with PyOutline: a frame for each worker.

    farm/opencue.py PLAN OUT WORKERS [--show SHOW] [--shot SHOT] [--program halflight] [--cores 4]

All hosts see PLAN, OUT and the program. Written from PyOutline's documentation; not run against a Cuebot.
"""

import argparse
import getpass

import outline
import outline.cuerun
from outline.modules.shell import Shell


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("plan")
    parser.add_argument("out")
    parser.add_argument("workers", type=int)
    parser.add_argument("--show", default="testing")
    parser.add_argument("--shot", default="bake")
    parser.add_argument("--program", default="halflight")
    parser.add_argument("--cores", type=int, default=4)
    options = parser.parse_args()

    frames = f"0-{options.workers - 1}"
    job = outline.Outline("halflight", show=options.show, shot=options.shot, user=getpass.getuser())
    work = [options.program, "farm", "work", options.plan, "--index", "#IFRAME#", "--of", str(options.workers)]
    work += ["--threads", str(options.cores), "--quiet", "--stage"]
    cache = Shell("cache", command=work + ["cache"], range=frames, threads=options.cores)
    tiles = Shell("tiles", command=work + ["tiles"], range=frames, threads=options.cores)
    join_words = [options.program, "farm", "join", options.plan, "-o", options.out, "--of", str(options.workers), "--quiet"]
    join = Shell("join", command=join_words, range="0-0", threads=options.cores)
    tiles.depend_all(cache)
    join.depend_all(tiles)
    for layer in (cache, tiles, join):
        job.add_layer(layer)
    outline.cuerun.launch(job, range=frames, use_pycuerun=False)


if __name__ == "__main__":
    main()
