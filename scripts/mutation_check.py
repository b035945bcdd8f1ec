#!/usr/bin/env python3
"""Shows that the tests can fail: breaks one thing at a time and runs the tests that must notice.

    scripts/mutation_check.py [--only S12[,NAME…]] [--list] [--text] [--jobs N] [--report FILE.md]

scripts/mutations.toml lists the mutations: a part of the specification, a file, a text in it, what it becomes, and the tests
that must then fail: "PROGRAM GTEST_FILTER", "cli CLASS.test", or "web PART NAME" for a file of web/tests or a part of its browser
or framework tests and a pattern of test names. A copy of the source tree in build/mutation is built once; each mutation changes one file there, builds
only the test programs concerned, runs the tests named and puts the file back. Nothing outside build/mutation is written.

Exits with 1 when a mutation survives (a named test does not fail), when its text is not in its file exactly once, when it does
not compile, or when a test fails without any mutation. --text checks the texts only, in a second. Not part of CI: some twenty
minutes on two free cores, the first build not counted.
"""

import argparse
import filecmp
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time
import tomllib

ROOT = pathlib.Path(__file__).resolve().parent.parent
TREE = ROOT / "build" / "mutation" / "tree"
BUILD = ROOT / "build" / "mutation" / "build"
TIMEOUT_SECONDS = 600


def read_table():
    with open(ROOT / "scripts" / "mutations.toml", "rb") as file:
        table = tomllib.load(file)["mutation"]
    for mutation in table:
        mutation["id"] = f"{mutation['part']}-{mutation['name']}"
    ids = [mutation["id"] for mutation in table]
    assert len(ids) == len(set(ids)), "two mutations have one name"
    return table


def selected(table, only):
    if not only:
        return table
    wanted = set(only.split(","))
    chosen = [m for m in table if {m["part"], m["name"], m["id"]} & wanted]
    unknown = wanted - {key for m in table for key in (m["part"], m["name"], m["id"])}
    if unknown:
        sys.exit(f"mutation_check.py: no mutation is called {', '.join(sorted(unknown))}")
    return chosen


def text_problem(mutation, root):
    path = root / mutation["file"]
    if not path.is_file():
        return f"{mutation['file']} does not exist"
    count = path.read_text().count(mutation["old"])
    return None if count == 1 else f"its text occurs {count} times in {mutation['file']}"


def copy_tree():
    """Brings the copy up to date; files that are equal keep their times, so that the build has little to do."""
    names = subprocess.run(["git", "ls-files", "-z", "-co", "--exclude-standard"], cwd=ROOT, check=True, capture_output=True)
    wanted = {name for name in names.stdout.decode().split("\0") if name and (ROOT / name).is_file()}
    for name in wanted:
        source, target = ROOT / name, TREE / name
        if not target.is_file() or not filecmp.cmp(source, target, shallow=False):
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, target)
            shutil.copymode(source, target)
    for path in [p for p in TREE.rglob("*") if p.is_file()]:
        if str(path.relative_to(TREE)) not in wanted:
            path.unlink()
    shared = TREE.parent / "shared"  # tests look for ../shared
    for folder in ("web", "web/examples", "web/examples/aframe"):
        modules = ROOT / folder / "node_modules"
        if modules.is_dir() and not (TREE / folder / "node_modules").exists():
            (TREE / folder / "node_modules").symlink_to(modules.resolve())
    if (ROOT.parent / "shared").is_dir() and not shared.exists():
        shared.symlink_to((ROOT.parent / "shared").resolve())


def run(command, timeout=TIMEOUT_SECONDS):
    environment = dict(os.environ, CCACHE_BASEDIR=str(TREE.parent))
    try:
        done = subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=timeout, env=environment)
        return done.returncode, done.stdout + done.stderr
    except subprocess.TimeoutExpired:
        return -1, "ran out of time"


def build(programs, jobs):
    own_program = "HALFLIGHT_PROGRAM" in os.environ  # for the tests of web/, which change no C++
    names = {"cli": "halflight", "web": None if own_program else "halflight"}
    targets = sorted({names.get(program, f"test_{program}") for program in programs} - {None})
    if not targets:
        return 0, ""
    return run(["ninja", "-C", str(BUILD), f"-j{jobs}", *targets], timeout=3600)


def run_web_tests(pattern):
    part, name = pattern.split(" ", 1)
    tests = TREE / "web/tests"
    groups = ("browser", "frameworks")
    script = tests / (next((group for group in groups if (tests / group / f"{part}.mjs").is_file()), part) + ".test.mjs")
    program = os.environ.get("HALFLIGHT_PROGRAM", str(BUILD / "apps/halflight/halflight"))
    _, output = run(["env", f"HALFLIGHT_WEB_PARTS={part}", f"HALFLIGHT_PROGRAM={program}", "node", "--test-reporter=tap", "--test",
                     f"--test-name-pattern={name}", str(script)])
    results = re.findall(r"^\s*(ok|not ok) \d+ - (.*)$", output, re.M)
    results = [(word, test) for word, test in results if "# SKIP" not in test and not test.endswith(".mjs")]
    return len(results), [test for word, test in results if word == "not ok"]


def run_tests(program, pattern, fast=True):
    """(number of tests that ran, names of those that failed)"""
    if program == "web":
        return run_web_tests(pattern)
    if program == "cli":
        name = pattern.split(".")[0]
        files = (TREE / "tests" / "cli").rglob("*_test.py")
        script = next(file for file in files if f"class {name}(" in file.read_text())
        program_file = str(BUILD / "apps/halflight/halflight")
        runner = str(TREE / "tests/cli/run.py")
        code, output = run([sys.executable, runner, str(script), program_file, str(TREE / "../shared"), pattern])
        return 1, [pattern] if code not in (0, 77) else []
    command = [str(next((BUILD / "tests").glob(f"*/test_{program}"))), f"--gtest_filter={pattern}", "--gtest_color=no"]
    code, output = run(command + (["--gtest_fail_fast"] if fast else []))
    lines = output.splitlines()
    count = sum(line.startswith("[ RUN ") for line in lines)
    failed = [line.split("] ", 1)[1].split(",")[0].split(" (")[0] for line in lines if line.startswith("[  FAILED  ] ")]
    failed = [name for name in failed if "." in name]
    if code != 0 and not failed:
        failed = [f"the program ended with {code}"]
    return count, list(dict.fromkeys(failed))


def tests_of(mutation):
    return [entry.split(" ", 1) for entry in mutation["fails"]]


def check_unchanged(table, jobs):
    """Without a mutation every named test passes, and every pattern names one."""
    print("building and testing the tree as it is …", flush=True)
    tests = sorted({tuple(test) for mutation in table for test in tests_of(mutation)})
    code, output = build({program for program, _ in tests}, jobs)
    if code != 0:
        sys.exit("mutation_check.py: the tree does not build\n" + output[-3000:])
    fine = True
    for program, pattern in tests:
        count, failed = run_tests(program, pattern, fast=False)
        if count == 0 or failed:
            fine = False
            print(f"  {program} {pattern}: " + ("names no test" if count == 0 else "fails: " + ", ".join(failed)), flush=True)
    return fine


def try_mutation(mutation, jobs):
    """(killed, what was seen)"""
    problem = text_problem(mutation, TREE)
    if problem:
        return False, problem
    path = TREE / mutation["file"]
    before = path.read_text()
    path.write_text(before.replace(mutation["old"], mutation["new"]))
    try:
        code, output = build({program for program, _ in tests_of(mutation)}, jobs)
        if code != 0:
            errors = [line for line in output.splitlines() if "error" in line.lower()]
            return False, "does not compile: " + (errors[0] if errors else output[-300:])
        seen, killed = [], True
        for program, pattern in tests_of(mutation):
            _, failed = run_tests(program, pattern)
            killed = killed and bool(failed)
            seen.append(failed[0] if failed else f"{program} {pattern} SURVIVES")
        return killed, ", ".join(seen)
    finally:
        path.write_text(before)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--only", help="parts or names, separated by commas")
    parser.add_argument("--list", action="store_true", help="what would be tried")
    parser.add_argument("--text", action="store_true", help="check that every text is in its file, no more")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--report", type=pathlib.Path, help="write the results as a Markdown table")
    arguments = parser.parse_args()
    table = selected(read_table(), arguments.only)
    if arguments.list:
        for mutation in table:
            print(f"{mutation['id']:32} {mutation['what']}")
        return 0
    problems = {m["id"]: text_problem(m, ROOT) for m in table if text_problem(m, ROOT)}
    for name, problem in problems.items():
        print(f"{name}: {problem}")
    if arguments.text or problems:
        return 1 if problems else 0

    TREE.mkdir(parents=True, exist_ok=True)
    copy_tree()
    programs = {program for mutation in table for program, _ in tests_of(mutation)}
    if not (BUILD / "build.ninja").is_file() and (programs != {"web"} or "HALFLIGHT_PROGRAM" not in os.environ):
        code, output = run(["cmake", "-S", str(TREE), "-B", str(BUILD), "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                            "-DCMAKE_CXX_FLAGS_RELEASE=-O1", "-DCMAKE_UNITY_BUILD_BATCH_SIZE=8"], timeout=600)
        if code != 0:
            sys.exit("mutation_check.py: cmake failed\n" + output[-3000:])
    fine = check_unchanged(table, arguments.jobs)
    rows, begin = [], time.monotonic()
    for mutation in table:
        start = time.monotonic()
        killed, seen = try_mutation(mutation, arguments.jobs)
        fine = fine and killed
        rows.append((mutation, killed, seen))
        print(f"{'killed  ' if killed else 'SURVIVES'} {mutation['id']:32} {time.monotonic() - start:5.0f} s  {seen}", flush=True)
    count = sum(killed for _, killed, _ in rows)
    print(f"{count} of {len(rows)} killed in {time.monotonic() - begin:.0f} s")
    if arguments.report:
        lines = ["| mutation | what it breaks | first test that failed |", "|---|---|---|"]
        lines += [f"| {m['id']} | {m['what']} | {seen if killed else '**survives**'} |" for m, killed, seen in rows]
        arguments.report.write_text("\n".join(lines) + "\n")
    return 0 if fine else 1


if __name__ == "__main__":
    sys.exit(main())
