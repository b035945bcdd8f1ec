#!/usr/bin/env python3
"""Checks that the baker's private vocabulary stays gone: the literature has words for what it named.

    old_words.py ROOT          exit 1 and one line per word that came back
    old_words.py --self-test   shows that each rule can fail

docs/lab/ and docs/glossary.md may have them. A word of plain English, or of another field (a cell of a grid, the rank of a value),
is forbidden where it had a private meaning only.
"""

import pathlib
import re
import subprocess
import sys

# Anywhere: what it was called, and what it is called.
EVERYWHERE = {
    r"bright cells?|BrightCells?": "secondary light source",
    r"sightings?": "observation",
    r"Company\b": "connected component",
    r"\bwiden\b": "coarser level",
    r"witness(es)?": "check sample",
    r"InsideOut|\bhollows\b": "facet orientation",
    r"outside points?": "valid sample point",
    r"slow paths?": "continuation path",
    r"emitterWay": "next-event contribution",
    r"rayWeight": "MIS weight",
    r"arrivingLight": "transmittance",
    r"texels between others|between-texels?": "interpolated texel",
    r"(is|as|where|unless) told\b": "by default, given, receives",
}
# In the CPU baker: words that had meanings of their own there.
IN_BAKE_CPU = {
    r"\bcubes?\b": "hash grid cell, region",
    r"\b(looks?|looked|knows?|known|told|asks?|hears?)\b(?! up\b)": "a standard verb; texels do not look or know",
    r"\brecords?\b": "FaceId",
    r"\bdivided (patch|cell)": "split patch",
    r"\bturn of the pattern|\bturned\b": "XOR shuffle, flipped",
    r"\blattice\b": "sparse grid",
    r"(?<!hash grid )(?<!grid )\bcells? of (the )?(pattern|block)": "stratum",
    r"\bcompany\b": "connected component",
}
SKIPPED = ("docs/lab/", "docs/glossary.md", "tests/old_words.py")


def problems_in(name, text):
    problems = []
    words = dict(EVERYWHERE)
    if name.startswith("src/bake_cpu/"):
        words.update(IN_BAKE_CPU)
    for number, line in enumerate(text.splitlines(), 1):
        for pattern, instead in words.items():
            found = re.search(pattern, line)
            if found:
                problems.append(f"{name}:{number}: \"{found[0]}\": {instead}")
    return problems


def self_test():
    examples = ["a bright cell", "sightings", "class Company", "widen", "witnesses", "hollows", "outside point", "slow path",
                "emitterWay", "rayWeight", "arrivingLight", "texels between others", "as told"]
    local = ["in cubes", "a texel knows", "a record", "divided patch", "turned", "lattice", "cells of the pattern", "its company"]
    missed = [e for e in examples if not problems_in("src/base/a.h", e)]
    missed += [e for e in local if not problems_in("src/bake_cpu/a.h", e) or problems_in("src/base/a.h", e)]
    if missed or problems_in("src/bake_cpu/a.h", "It looks up a patch by its hash grid cell"):
        sys.exit(f"self-test failed: {missed}")


def main():
    if sys.argv[1:] == ["--self-test"]:
        self_test()
        return
    root = pathlib.Path(sys.argv[1])
    names = subprocess.run(["git", "-C", root, "ls-files", "-z"], capture_output=True, text=True, check=False)
    if names.returncode != 0:
        print("not a git working tree: nothing to check")
        return
    problems = []
    for name in filter(None, names.stdout.split("\0")):
        path = root / name
        if name.startswith(SKIPPED) or not path.is_file():
            continue
        try:
            problems += problems_in(name, path.read_text(encoding="utf-8"))
        except UnicodeDecodeError:
            continue
    print("\n".join(problems) if problems else "no old words")
    sys.exit(1 if problems else 0)


if __name__ == "__main__":
    main()
