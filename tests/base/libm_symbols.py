#!/usr/bin/env python3
"""Checks that what a bake runs calls only exact functions of the C library's mathematics.

    libm_symbols.py LIBM.so LIBRARY.a...   exit 1 and one line per inexact function and object
    libm_symbols.py --self-test            shows that the check can fail (needs a C++ compiler)

Others differ between systems, versions and processors: base/mathematics.h has the project's own. Names are taken from
the C library itself (nm), so that its variants (sincosf, __powf_finite, ...) and its vector ones (_ZGVbN4v_sinf) count.
"""

import pathlib
import re
import subprocess
import sys
import tempfile

# Rounded as IEEE 754 asks for, or without any rounding.
EXACT = ("ceil copysign fabs fdim floor fmax fmin fmod frexp ilogb ldexp llrint llround logb lrint lround modf nearbyint "
         "nextafter remainder rint round scalbln scalbn sqrt trunc").split()
EXACT = {name + suffix for name in EXACT for suffix in ("", "f", "l")}
VECTOR = re.compile(r"_ZGV\w+_(\w+)$")


def names(*arguments):
    """Objects and names of `nm -A`."""
    lines = subprocess.run(["nm", "-A", *arguments], check=True, capture_output=True, text=True).stdout.splitlines()
    return [(re.sub(r":\s*[0-9a-f]*\s*$", "", line.rsplit(None, 2)[0]), line.split()[-1].split("@")[0]) for line in lines]


def inexact(libm, libraries):
    """What the libraries ask of libm and vector variants of it, without the exact ones. Gives lines of text."""
    offered = {name for _, name in names("-D", "--defined-only", libm)}
    if "sin" not in offered or "powf" not in offered:
        raise SystemExit(f"libm_symbols.py: {libm} is no library of mathematics")
    found, seen = [], 0
    for library in libraries:
        for place, name in names("--undefined-only", library):
            seen += 1
            if (name in offered and name not in EXACT) or VECTOR.match(name):
                found.append(f"{place}: {name}: use math:: of halflight/base/mathematics.h")
    if seen == 0:
        raise SystemExit("libm_symbols.py: no undefined symbols: wrong files")
    return sorted(set(found))


def self_test(libm, compiler):
    """One function after the other, as an object of its own."""
    with tempfile.TemporaryDirectory() as folder:
        for call, complaint in (("std::sqrt(x) + std::floor(x) + std::fmod(x, 3.0)", False), ("std::sin(x)", True),
                                ("std::sin(float(x))", True), ("std::sin(x) + std::cos(x)", True),
                                ("std::pow(2.0f, float(x))", True), ("std::fma(x, x, 1.0)", True),
                                ("std::hypot(x, 2.0)", True)):  # fmt: skip
            source = pathlib.Path(folder) / "call.cpp"
            source.write_text(f"#include <cmath>\ndouble call(double x)\n{{\n    return {call};\n}}\n")
            target = source.with_suffix(".o")
            subprocess.run([compiler, "-std=c++14", "-O2", "-fno-math-errno", "-c", source, "-o", target], check=True)
            if bool(inexact(libm, [target])) != complaint:
                return [f"{call}: {'is not noticed' if complaint else 'is exact'}"]
    return []


def main():
    if sys.argv[1] == "--self-test":
        problems = self_test(sys.argv[2], sys.argv[3])
    else:
        problems = inexact(sys.argv[1], sys.argv[2:])
    print("\n".join(problems) or "only exact functions")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
