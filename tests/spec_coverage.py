#!/usr/bin/env python3
"""docs/spec-coverage.md is what scripts/make_spec_coverage.py writes, and every part S1…S36 has tests, a picture that
exists, and mutations. Usage: spec_coverage.py ROOT | --self-test"""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "scripts"))
import make_spec_coverage  # noqa: E402

PARTS = [f"S{i}" for i in range(1, 37)]


def problems_of(parts, tests, mutations, has_file):
    names = [part["name"] for part in parts]
    problems = [] if names == PARTS else [f"tests/spec_parts.toml has {names}, not S1 to S36"]
    for part in parts:
        name = part["name"]
        if not make_spec_coverage.tests_of(part, tests, mutations):
            problems.append(f"{name} has no test")
        for test in part.get("also", ()):
            if test not in tests:
                problems.append(f"{name}: there is no test {test}")
            elif test in make_spec_coverage.tests_of({"name": name}, tests, mutations):
                problems.append(f"{name}: {test} need not be listed in tests/spec_parts.toml")
        if not any(mutation["part"] == name for mutation in mutations):
            problems.append(f"{name} has no mutation")
        if not part["pictures"]:
            problems.append(f"{name} has no picture")
        problems += [f"{name}: there is no picture {file}" for _, file in part["pictures"] if not has_file(file)]
    problems += [f"mutation {m['part']}-{m['name']} is of no part" for m in mutations if m["part"] not in names]
    return problems


def check(root):
    parts, tests, mutations = make_spec_coverage.read(root)
    docs = root / "docs"
    problems = problems_of(parts, tests, mutations, lambda file: (docs / file).is_file())
    if (docs / "spec-coverage.md").read_text(encoding="utf-8") != make_spec_coverage.page_of(parts, tests, mutations):
        problems.append("docs/spec-coverage.md is old: run scripts/make_spec_coverage.py")
    for problem in problems:
        print(problem)
    return 1 if problems else 0


def self_test():
    tests = {f"Law{part}.B" for part in PARTS} | {"Other.Test"}
    mutations = [{"part": part, "name": "m", "fails": [f"bake Law{part}.*"]} for part in PARTS]

    def count(part=None, tests=tests, mutations=mutations, **changes):
        parts = [{"name": name, "what": "x", "pictures": [["x", "x.jpg"]]} for name in PARTS]
        if part:
            parts[PARTS.index(part)].update(changes)
        return len(problems_of(parts, tests, mutations, lambda file: file == "x.jpg"))

    assert count() == 0
    assert count("S3", also=["Other.Test"]) == 0
    assert count("S3", also=["LawS3.B"]) == 1  # its name says it already
    assert count("S3", also=["A.C"]) == 1
    assert count("S3", pictures=[["y", "y.jpg"]]) == 1
    assert count("S3", pictures=[]) == 1
    assert count("S3", name="S4") == 2  # the parts' names, and S3's mutation
    assert count(tests=tests - {"LawS3.B"}) == 1
    assert count(mutations=[m for m in mutations if m["part"] != "S3"]) == 1
    assert count(mutations=mutations + [{"part": "S37", "name": "n", "fails": []}]) == 1
    for name, parts in (("LocalLawS3S4.Near", {"S3", "S4"}), ("Lights.EndsAtDistanceS1", {"S1"}), ("ABS3.A", set()),
                        ("LawS12.StaticCasters", {"S12"}), ("S3a.b", set())):
        assert make_spec_coverage.parts_in(name) == parts, name
    for fail, found in (("render *LocalLawS3S4*", 1), ("cli Chain.test_a", 1), ("render A.B/Instance*:C.*", 2),
                        ("bake A.*", 1)):
        known = {"LocalLawS3S4.Near", "Chain.test_a", "Chain.test_ab", "A.B", "C.D", "LawS1.B"}
        assert len(make_spec_coverage.named_by({"fails": [fail]}, known)) == found, fail
    return 0


if __name__ == "__main__":
    sys.exit(self_test() if sys.argv[1:] == ["--self-test"] else check(pathlib.Path(sys.argv[1])))
