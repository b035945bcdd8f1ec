#!/usr/bin/env python3
"""docs/spec-coverage.md is true: every part S1…S32 has a row; the tests, mutations and pictures it names exist, and every
mutation of scripts/mutations.toml is in it, but for those of web/. Usage: spec_coverage.py ROOT | --self-test"""

import pathlib
import re
import sys
import tomllib

PARTS = [f"S{i}" for i in range(1, 33)]
COLUMNS = ("part", "shows", "tests", "picture", "mutations")


def rows_of(text):
    """{part: cells} of the table's rows, and the parts that occur twice."""
    rows, twice = {}, []
    for line in text.splitlines():
        match = re.match(r"\|\s*(S\d+)\s*\|", line)
        if not match:
            continue
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if match[1] in rows:
            twice.append(match[1])
        rows[match[1]] = dict(zip(COLUMNS, cells))
    return rows, twice


def names_in(cell):
    return re.findall(r"`([^`]+)`", cell)


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


def problems_of(text, tests, mutations, has_file):
    rows, twice = rows_of(text)
    problems = [f"{part} has two rows" for part in twice]
    named = set()
    for part in PARTS:
        row = rows.get(part)
        if row is None or len(row) < len(COLUMNS):
            problems.append(f"{part} has no row of {len(COLUMNS)} columns")
            continue
        if not names_in(row["tests"]):
            problems.append(f"{part} names no test")
        problems += [f"{part}: there is no test {name}" for name in names_in(row["tests"]) if name not in tests]
        if not names_in(row["mutations"]):
            problems.append(f"{part} names no mutation")
        for name in names_in(row["mutations"]):
            full = f"{part}-{name}"
            named.add(full)
            if full not in mutations:
                problems.append(f"{part}: there is no mutation {full}")
        if "](" not in row["picture"]:
            problems.append(f"{part} shows no picture")
        for link in re.findall(r"\]\(([^)#]+)\)", row["picture"]):
            if not has_file(link):
                problems.append(f"{part}: there is no picture {link}")
    problems += [f"{name} is in no row" for name in sorted(set(mutations) - named)]
    return problems


def check(root):
    with open(root / "scripts" / "mutations.toml", "rb") as file:
        mutations = [f"{m['part']}-{m['name']}" for m in tomllib.load(file)["mutation"] if m["part"] not in ("WEB", "FILE")]
    docs = root / "docs"
    problems = problems_of((docs / "spec-coverage.md").read_text(), known_tests(root), mutations,
                           lambda link: (docs / link).is_file())
    for problem in problems:
        print(f"docs/spec-coverage.md: {problem}")
    return 1 if problems else 0


def self_test():
    def page(**changes):
        row = {"tests": "`A.B`", "picture": "[x](x.jpg)", "mutations": "`m`"}
        return "\n".join("| {} | what | {} | {} | {} |".format(part, *({**row, **changes.get(part, {})}).values())
                         for part in PARTS if part not in changes.get("without", ()))

    mutations = [f"{part}-m" for part in PARTS]

    def count(text, mutations=mutations):
        return len(problems_of(text, {"A.B"}, mutations, lambda link: link == "x.jpg"))

    assert count(page()) == 0
    assert count(page(without=("S7",))) == 2  # and its mutation is in no row
    assert count(page() + "\n| S7 | twice | `A.B` | [x](x.jpg) | `m` |") == 1
    assert count(page(S3={"tests": "`A.C`"})) == 1
    assert count(page(S3={"tests": "none"})) == 1
    assert count(page(S3={"picture": "[y](y.jpg)"})) == 1
    assert count(page(S3={"picture": "a view"})) == 1
    assert count(page(S3={"mutations": "`m`, `n`"})) == 1
    assert count(page(S3={"mutations": "–"})) == 2
    assert count(page(), mutations + ["S3-n"]) == 1
    return 0


if __name__ == "__main__":
    sys.exit(self_test() if sys.argv[1:] == ["--self-test"] else check(pathlib.Path(sys.argv[1])))
