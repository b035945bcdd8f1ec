#!/usr/bin/env python3
"""Counts the tuning constants of the bake (src/bake, src/bake_cpu), so that they get fewer and stay explained.

    tuning_constants.py ROOT          exit 1 and one line per problem
    tuning_constants.py ROOT --list   prints them all
    tuning_constants.py --self-test   shows that each rule can fail

A tuning constant is a number that somebody chose: a threshold, a weight, a number of samples, a size. It counts with a
name (`constexpr ... kName = 0.3f`) and without one (`0.3f` in an expression). There are at most LIMIT, and each one with a name has
a comment beside it, on its line or above its group, that gives its unit and the reason or the measurement it comes from.

No tuning constants are
- seeds, texts, sentinels (~0u), and values made from other constants: recognized by their form;
- what a file format, a data layout or a formula sets: FIXED names them, with what sets them;
- sizes of work, which change no result: WORK names them;
- guards against rounding and division by zero: numbers without a name of at most 1/1000, or next to 1.
"""

import pathlib
import re
import sys
import tempfile

LIMIT = 134  # may only shrink; the aim is 99
FOLDERS = ("src/bake", "src/bake_cpu")
LEAST_WORDS = 4

# By file: what sets the value.
FIXED = {
    "src/bake/cache.cpp": {"kParts": "size of a name's hash"},
    "src/bake/channels.cpp": {
        "kChannels": "file format",
        "0.8191725133961645": "R3 sequence (Roberts 2018)",
        "0.6710436067037893": "R3 sequence",
        "0.5497004779019703": "R3 sequence",
    },
    "src/bake/denoise.cpp": {
        "kSpline": "B3 spline",
        "kTerms": "a polynomial of 5 x 5 taps",
        "kCorrelation": "kernel of the filter",
        "32.0": "exponent of falloff()",
        "kLinear": "sum of squares over 5 x 5 taps",
        "kSquare": "sum of squares over 5 x 5 taps",
        "kMixed": "sum of squares over 5 x 5 taps",
        "2.1": "variance of the fitted trend",
        "kTapsBetween": "distance of two taps",
    },
    "src/bake/denoise_taps.h": {"kTaps": "5 x 5", "kMiddleTap": "of 5 x 5", "kPaddedTaps": "lanes"},
    "src/bake/denoise.h": {"kMaxCount": "9 x 9 - 1"},
    "src/bake/dilate.cpp": {"0.70710678": "1 / sqrt(2)"},
    "src/bake/front.cpp": {"kFewestSamples": "one block"},
    "src/bake/front_parts.cpp": {"kFrontVersion": "version", "kMost": "guard against damaged files"},
    "src/bake/gather.cpp": {"kCacheVersion": "version"},
    "src/bake/geometry.cpp": {"kLeast": "guard"},
    "src/bake/image_denoise.cpp": {"kMiddleGrey": "18 % grey"},
    "src/bake/mask_field.cpp": {
        "kRangeTexels": "file format",
        "kReach": "of kRangeTexels",
        "kStraight": "sqrt(2)",
        "kHalfPiece": "1 / sqrt(2)",
    },
    "src/bake/part_folder.cpp": {"kDigits": "file names"},
    "src/bake/probe_sight.cpp": {"kCells": "file format", "kNearest": "16 bits", "65535.0": "16 bits"},
    "src/bake/probes.cpp": {"kNewPointsOfCell": "27 - 8"},
    "src/bake/seams.cpp": {"kDark": "guard"},
    "src/bake/shared_meshes.cpp": {"kFlattest": "guard against rounding"},
    "src/bake/stages.h": {"kDilationRings": "bicubic filtering"},
    "src/bake_cpu/guiding/patch_light.h": {"kNoAxis": "sentinel"},
    "src/bake_cpu/guiding/receiver_grid.h": {"kMask": "20 bits"},
    "src/bake_cpu/lightmap/next_event.cpp": {"kSkyMeters": "beyond all geometry"},
    "src/bake_cpu/radiosity/lobe_moments.h": {"kDiffuse": "mean cosine of a diffuse surface"},
    "src/bake_cpu/radiosity/patch_layout.h": {"kMaxPatches": "29 bits"},
    "src/bake_cpu/radiosity/patches.h": {"kAxes": "of space, both directions"},
    "src/bake_cpu/radiosity/solve.cpp": {"18.0": "moments over a hemisphere", "kMostTilt": "guard: radiance above 0"},
    "src/bake_cpu/radiosity/split_patches.cpp": {
        "kWhole": "guard",
        "7.0": "lanes beside the first",
        "kBorder": "corners and middles of a square",
    },
    "src/bake_cpu/sample/light_tree.cpp": {"kLeastCosine": "guard against rounding"},
    "src/bake_cpu/sample/light_tree.h": {"kRoot": "index", "kLanes": "lanes"},
    "src/bake_cpu/sample/stratified_pattern.h": {"kBlock": "4 x 4 strata"},
    "src/bake_cpu/shadows/shadow_pass.h": {"kMostRays": "24 bits"},
    "src/bake_cpu/shadows/shadow_rays.h": {"kLit": "8 bits", "kMost": "guard", "kHalf": "lanes"},
    "src/bake_cpu/texels/ray_bundle.h": {"kAllStrata": "0 to 15"},
    "src/bake_cpu/texels/valid_points.cpp": {"kBlock": "a point of each texel of a block makes kMaxTexelPoints"},
    "src/bake_cpu/texels/sparse_grid.cpp": {"kCovered": "guard", "kSlack": "guard"},
    "src/bake_cpu/trace/embree.h": {"kPacket": "lanes"},
    "src/bake_cpu/trace/ray_tracer.cpp": {"kMaxCrossings": "guard against endless rays"},
}

# By file: sizes of work, which change no result: what a thread, a file, a progress bar or memory takes at a time.
WORK = {
    "src/bake/bake_report.cpp": ["kOwnWarnings"],
    "src/bake/bake_session.cpp": ["kEnough"],
    "src/bake/cache.cpp": ["kKeptBakes", "kInUse", "kComparisonShare", "kBatchItems"],
    "src/bake/cache.h": ["kTexelTile", "kProbeTile", "kProbeTilesPerPart"],
    "src/bake/dilate.cpp": ["kTexelsPerTask"],
    "src/bake/facet_orientation.cpp": ["kRaysAtOnce", "kBlockPatches", "kEnough"],
    "src/bake/live_light.cpp": ["kSide", "kMostSquares", "kFirstTexels", "kSecondsAtOnce"],
    "src/bake/live_pages.h": ["kBlock"],
    "src/bake/probe_sight.cpp": ["kAtOnce"],
    "src/bake/rasterize.cpp": ["kTrianglesPerRun", "kSquare"],
    "src/bake/seam_edges.cpp": ["1024.0", "8.0"],
    "src/bake/seam_parts.cpp": ["kFewest"],
    "src/bake/shared_meshes.cpp": ["kFewestSaved"],
    "src/bake/texel_order.cpp": ["kMostTexels", "kPlaces"],
    "src/bake_cpu/guiding/build_guides.cpp": ["kAtOnce"],
    "src/bake_cpu/lightmap/cached_lightmap.cpp": ["kPartTexels"],
    "src/bake_cpu/lightmap/lightmap_run.cpp": ["kGrain"],
    "src/bake_cpu/lightmap/path_lightmap.cpp": ["kTexelGrain"],
    "src/bake_cpu/radiosity/build.cpp": ["kRangeItems", "kMostParts", "kFewestRanges"],
    "src/bake_cpu/radiosity/patches.cpp": ["kBlock"],
    "src/bake_cpu/shadows/baked_lights.cpp": ["kLightsAtOnce", "0.9"],
    "src/bake_cpu/shadows/light_reach.cpp": ["kLeaf", "kRun"],
    "src/bake_cpu/shadows/shadow_pass.cpp": ["0.7", "0.85"],
    "src/bake_cpu/shadows/shadow_pass.h": ["kMaxShadowSources"],
    "src/bake_cpu/texels/near_triangles.cpp": ["kMostTriangles"],
    "src/bake_cpu/texels/texel_group.h": ["kGrain"],
    "src/bake_cpu/texels/valid_points.cpp": ["kGrain", "kPartTexels"],
}

NAMED = re.compile(r"constexpr\s+(?P<type>[\w:<>, ]+[\w>*]\s*\*?)\s*\b(?P<name>k[A-Z]\w*)(\[\d*\])?\s*(=|\{)\s*(?P<value>.*)$")
DECIMAL = re.compile(r"(?<![\w.])(\d+\.\d*(?:e[-+]?\d+)?|0x[0-9a-f.]+p[-+]?\d+)f?")
PLAIN = {0.0, 0.25, 0.5, 1.0, 2.0, 3.0, 4.0, 255.0}


def code_of(line):
    return re.sub(r'"[^"]*"', '""', line.split("//")[0])


def is_free(kind, value):
    """Recognized by form: seeds, texts, sentinels, values made from other constants."""
    return "char" in kind or value.startswith(("0x5eed", "~", "uint64_t(~", "~uint64_t")) or re.search(r"\bk[A-Z]", value)


def is_guard(value):
    return value <= 1.0e-3 or value >= 1.0e6 or 0.99 < value < 1.01


def comment_of(lines, number):
    """The comment on a line, or above its group: lines that follow one another without a gap."""
    own = lines[number].partition("//")[2].strip("/< ")
    if own:
        return own
    words = []
    above = number - 1
    while above >= 0 and NAMED.search(code_of(lines[above])):
        above -= 1
    while above >= 0 and lines[above].strip().startswith("//"):
        words.insert(0, lines[above].strip().lstrip("/< "))
        above -= 1
    # A statement in two lines may have its comment on the second.
    if not words and number + 1 < len(lines):
        return lines[number + 1].partition("//")[2].strip("/< ")
    return " ".join(words)


def exempt(name):
    return [*FIXED.get(name, ()), *WORK.get(name, ())]


def constants_of(root):
    """(file, line, name or number, comment or None) of all tuning constants, and the names in FIXED that exist."""
    found = []
    fixed = set()
    for folder in FOLDERS:
        for path in sorted((root / folder).rglob("*")):
            if path.suffix not in (".h", ".cpp"):
                continue
            name = path.relative_to(root).as_posix()
            lines = path.read_text(encoding="utf-8").splitlines()
            for number, line in enumerate(lines):
                code = code_of(line)
                match = NAMED.search(code)
                if match:
                    if match["name"] in exempt(name):
                        fixed.add((name, match["name"]))
                    elif not is_free(match["type"], match["value"].strip()):
                        found.append((name, number + 1, match["name"], comment_of(lines, number)))
                    continue
                for text in DECIMAL.findall(code):
                    value = float.fromhex(text) if text.startswith("0x") else float(text)
                    if value not in PLAIN and not is_guard(value) and text not in exempt(name):
                        found.append((name, number + 1, text, None))
                    elif text in exempt(name):
                        fixed.add((name, text))
    return found, fixed


def problems_of(root, limit=LIMIT):
    found, fixed = constants_of(root)
    problems = []
    for name, line, what, comment in found:
        if comment is not None and len(comment.split()) < LEAST_WORDS:
            problems.append(f"{name}:{line}: {what} has no comment with its unit and reason")
    for table, of in (("FIXED", FIXED), ("WORK", WORK)):
        for name, values in of.items():
            problems += [f"{name}: {v} is in {table} and does not exist" for v in values if (name, v) not in fixed]
    if len(found) > limit:
        problems.append(f"{len(found)} tuning constants, at most {limit}: measure with bench_bake ablate what each gains")
    return problems


def self_test():
    def problems(text, limit=1):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            (root / "src/bake").mkdir(parents=True)
            (root / "src/bake/a.cpp").write_text(text)
            saved = dict(FIXED), dict(WORK)
            FIXED.clear()
            WORK.clear()
            try:
                return problems_of(root, limit)
            finally:
                FIXED.update(saved[0])
                WORK.update(saved[1])

    explained = "/// Texels; below, shadows of leaves are lost.\nconstexpr float kWidth = 1.5f;\n"
    checks = [
        not problems(explained),
        problems("constexpr float kWidth = 1.5f;\n"),
        problems(explained, 0),
        problems("float f() { return 1.7f; }\n", 0),
        not problems("float f() { return 1.0e-6f + 0.999f; }\n", 0),
        not problems("constexpr uint32_t kSeed = 0x5eed0001u;\nconstexpr int kTwice = 2 * kOther;\n", 0),
    ]
    if not all(checks):
        sys.exit(f"self-test failed: {[bool(c) for c in checks]}")


def main():
    if sys.argv[1:] == ["--self-test"]:
        self_test()
        return
    root = pathlib.Path(sys.argv[1])
    if "--list" in sys.argv:
        found, _ = constants_of(root)
        for name, line, what, comment in found:
            print(f"{name}:{line}: {what}: {comment}")
        print(len(found))
        return
    problems = problems_of(root)
    print("\n".join(problems) if problems else f"{len(constants_of(root)[0])} tuning constants")
    sys.exit(1 if problems else 0)


if __name__ == "__main__":
    main()
