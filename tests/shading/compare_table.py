#!/usr/bin/env python3
"""Checks that assets/conformance/law.json holds what the formulas give. Usage: compare_table.py PROGRAM EXPECTED.json

PROGRAM prints the table anew. Numbers may differ by the last digits of another C library's functions."""

import json
import math
import subprocess
import sys

TOLERANCE = 1e-6  # relative, and absolute below 1


def differences(expected, found, path=""):
    if isinstance(expected, (int, float)) and isinstance(found, (int, float)) and not isinstance(expected, bool):
        if not math.isclose(expected, found, rel_tol=TOLERANCE, abs_tol=TOLERANCE):
            yield f"{path}: {expected} in the file, {found} by the formula"
    elif isinstance(expected, dict) and isinstance(found, dict) and expected.keys() == found.keys():
        for key in expected:
            yield from differences(expected[key], found[key], f"{path}/{key}")
    elif isinstance(expected, list) and isinstance(found, list) and len(expected) == len(found):
        for i, (a, b) in enumerate(zip(expected, found)):
            yield from differences(a, b, f"{path}/{i}")
    elif expected != found:
        yield f"{path}: {expected!r} in the file, {found!r} by the formula"


def main():
    program, file = sys.argv[1:3]
    printed = json.loads(subprocess.run([program], capture_output=True, text=True, check=True).stdout)
    with open(file, encoding="utf-8") as stream:
        wrong = list(differences(json.load(stream), printed))
    for line in wrong[:20]:
        print(line)
    if wrong:
        print(f"{len(wrong)} differences: a formula changed, or write the table anew: {program} > {file}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
