#!/usr/bin/env python3
"""Writes docs/spec-coverage.md: what shows that each part of the specification holds.

    scripts/make_spec_coverage.py

A test belongs to a part when its name says so: `LawS12.StaticCasters` to S12, `LocalLawS3S4.…` to S3 and S4. It also
does when a mutation of the part names it (`fails` in scripts/mutations.toml), or when tests/spec_parts.toml lists it.
Pictures and what a part shows are in tests/spec_parts.toml. tests/spec_coverage.py fails while the page is old.
"""

import fnmatch
import pathlib
import re
import textwrap
import tomllib

ROOT = pathlib.Path(__file__).resolve().parents[1]
COLUMNS = 118
NO_PARTS = ("WEB", "FILE")  # mutations of web/ and of file readers belong to no part

HEADER = """\
# Coverage of the specification

<!-- scripts/make_spec_coverage.py writes this page. -->

Each part has what it shows, the tests that prove it, a picture, and what was broken on purpose to see these tests fail.

- **Tests** have names such as `Suite.Test` (GoogleTest; a parameterized one stands for all its instances) or
  `Class.test_name` of `tests/cli`. `ctest -R LawPixels` runs some of them.
- Pixel tests compare rendered radiance with the law's value, worked out by hand or on the CPU. They compare with no
  older pictures. Most run forward and deferred: near the camera, within the fade and beyond the shadow distance.
- **Pictures** are made by `scripts/make_contact_sheets.py` from the scenes in `assets/`.
- **Mutations** are entries of `scripts/mutations.toml`. `scripts/mutation_check.py` breaks one thing at a time in a
  copy of the tree. The tests named there must fail.

"""

FOOTER = """\
## Beyond the parts

| test | what it shows |
|---|---|
| `Progress.test_lines_for_programs` | progress as lines |
| `blender.extension` | installs it, bakes, compares the view with `halflight render`; materials stay |
| `blender.smoke`, `blender.pictures`, `blender.room` | the view against Cycles' pictures of the scenes themselves |
| `blender.work` | nothing of the user's is lost |
| `blender.windows` | the same in the windows of a virtual screen, with keys pressed |
| `blender.report` | nothing is dropped in silence |
| `blender.install` | the zip with its program, and bakes from the command line |
| `CliDocs.*`, `scripts/test_packages.sh` | manual pages, completions, [packages](packages.md) |
"""


def known_tests(root):
    """Suite.Test of GoogleTest, Class.test_name of unittest."""
    known = set()
    for path in (root / "tests").rglob("*.cpp"):
        for suite, test in re.findall(r"^TEST(?:_F|_P)?\((\w+),\s*(\w+)\)", path.read_text(), re.M):
            known.add(f"{suite}.{test}")
    for path in (root / "tests").rglob("*_test.py"):
        current = ""
        for line in path.read_text().splitlines():
            if match := re.match(r"class (\w+)", line):
                current = match[1]
            if match := re.match(r"    def (test_\w+)", line):
                known.add(f"{current}.{match[1]}")
    return known


def parts_in(name):
    """The parts that a test's name says: S3 and S4 of LocalLawS3S4.NearInTheFadeAndBeyond."""
    return {part for run in re.findall(r"(?<![A-Z])((?:S\d+)+)(?![0-9a-z])", name) for part in re.findall(r"S\d+", run)}


def named_by(mutation, tests):
    """The tests that a mutation's `fails` name: "PROGRAM FILTER", without the parameters of instances."""
    filters = [part for fail in mutation["fails"] for part in fail.split(" ", 1)[1].split(":")]
    patterns = [re.sub(r"/.*$", "", part.lstrip("*")) for part in filters]
    return {test for test in tests for pattern in patterns
            if fnmatch.fnmatchcase(test, pattern if "." in pattern else pattern.rstrip("*") + "*")}


def tests_of(part, tests, mutations):
    found = {test for test in tests if part["name"] in parts_in(test)} | set(part.get("also", ()))
    for mutation in mutations:
        if mutation["part"] == part["name"]:
            found |= named_by(mutation, tests)
    return sorted(found)


def wrapped(text, **indents):
    return textwrap.fill(text, COLUMNS, break_long_words=False, break_on_hyphens=False, **indents)


def section_of(part, tests, mutations):
    def paragraph(title, words):
        return wrapped(f"{title}: " + " ".join(words)) + "\n"

    facts = [" ".join(fact.split()) for fact in part["what"].split("; ")]
    lines = [wrapped(fact, initial_indent="- ", subsequent_indent="  ") for fact in facts]
    names = [m["name"] for m in mutations if m["part"] == part["name"]]
    return "\n".join([
        f"## {part['name']}\n", *lines, "",
        paragraph("Tests", [f"`{test}`" for test in tests_of(part, tests, mutations)]),
        paragraph("Picture", [f"[{text}]({file})" for text, file in part["pictures"]]),
        paragraph("Mutations", [f"`{name}`" for name in names]),
    ])


def read(root):
    with open(root / "tests" / "spec_parts.toml", "rb") as file:
        parts = tomllib.load(file)["part"]
    with open(root / "scripts" / "mutations.toml", "rb") as file:
        mutations = [m for m in tomllib.load(file)["mutation"] if m["part"] not in NO_PARTS]
    return parts, known_tests(root), mutations


def page_of(parts, tests, mutations):
    return HEADER + "\n".join(section_of(part, tests, mutations) for part in parts) + "\n" + FOOTER


if __name__ == "__main__":
    (ROOT / "docs" / "spec-coverage.md").write_text(page_of(*read(ROOT)), encoding="utf-8")
