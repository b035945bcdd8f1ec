"""The command line's own tests (tests/cli) with halflight.exe under Wine.
Usage: cli_under_wine.py SHARED_DIR [all] [FILE …]

A script of the program's name stands for it, so that the tests are those of Linux. CANNOT names those that need what
neither Windows nor Wine has."""

import importlib
import pathlib
import re
import sys
import tempfile
import time
import unittest

import wine

# Whole files, classes, or tests; why they cannot run here.
CANNOT = {
    "view_test": "there is no window in the Windows program",
    "view_bake_test": "there is no window in the Windows program",
    "launchers_test": "GNU parallel and Slurm start Linux programs",
    "bake_test.Interrupt.test_interrupted_bake_leaves_nothing": "sends SIGTERM, which Windows has not; wine_test.py cancels",
    "interrupt_test": "reads /proc and measures a process of Linux; wine_test.py cancels",
    "truth_test": "compares pictures of minutes; light and pictures have the bytes of Linux (wine_test.py)",
    "identity_test.AllLayouts": "bakes each scene with each instruction set; the bytes are those of Linux",
    "places_test.Streams": "/dev/full, closed streams and limits of POSIX",
    "places_test.FullDisk": "mounts a small disk",
    "places_test.Places.test_files_beside_a_gltf_never_replace_the_scenes": "expects / in the names of files in messages",
    "plan_test.Plans.test_a_scenes_own_name_is_made_printable": "names a file with letters that Windows refuses",
    "usage_test.Usage.test_nothing_written_replaces_what_is_read_or_written": "makes links of Linux, which Wine hides",
    "usage_test.Usage.test_pipes_are_refused_and_links_stay": "makes pipes and links of Linux",
    "farm_test.FarmTrouble": "kills and stops processes by POSIX signals, fills a disk",
}

# These can run here, and take half of all the time. What they show is light, whose bytes are those of Linux (wine_test.py).
# `cli_under_wine.py SHARED_DIR all` runs them too.
LIGHT = {
    "bake_test.Georeferenced", "bake_test.Reach", "cases_test.Pictures", "second_cases_test.Glass",
    "second_cases_test.Emission", "second_cases_test.TextureSets", "sheets_test.Boards", "sheets_test.Sheets",
    "sheets_test.SharedSheets",
}  # fmt: skip


class Timed(unittest.TextTestResult):
    """Says what each test took."""

    def startTest(self, test):
        self.began = time.monotonic()
        super().startTest(test)

    def addSuccess(self, test):
        self.stream.write(f"{time.monotonic() - self.began:.1f} s ")
        super().addSuccess(test)


def without_wines_own(run):
    """Wine may say at a program's end that it lost its server."""

    def quiet(*words, **options):
        result = run(*words, **options)
        if isinstance(result.stderr, str):
            result.stderr = re.sub(r"(?m)^wine client error:.*\n", "", result.stderr)
        return result

    return quiet


def cases(suite):
    for item in suite:
        if isinstance(item, unittest.TestSuite):
            yield from cases(item)
        else:
            yield item


def reason(name, are_all):
    left_out = CANNOT if are_all else {**CANNOT, **dict.fromkeys(LIGHT, "light, whose bytes are those of Linux")}
    return next((why for key, why in left_out.items() if name == key or name.startswith(key + ".")), None)


def main():
    shared, names = sys.argv[1], [name for name in sys.argv[2:] if name != "all"]
    wine.program()
    wine.prepare()
    import cli_case

    files = names or sorted(path.stem for path in (wine.ROOT / "tests/cli").rglob("*_test.py"))
    whole = unittest.TestSuite()
    left_out, known = [], set()
    with tempfile.TemporaryDirectory() as folder:
        cli_case.HALFLIGHT, cli_case.SHARED = wine.wrapper(folder), shared
        cli_case.run = without_wines_own(cli_case.run)
        for file in files:
            module = importlib.import_module(file.split(".")[0])
            for case in cases(unittest.defaultTestLoader.loadTestsFromModule(module)):
                known.add(case.id())
                if not case.id().startswith(file):
                    continue
                why = reason(case.id(), "all" in sys.argv)
                if why is None:
                    whole.addTest(case)
                else:
                    left_out.append(f"{case.id()}: {why}")
        if not names:
            gone = [key for key in {*CANNOT, *LIGHT} if not any(name == key or name.startswith(key + ".") for name in known)]
            assert not gone, f"tests that are no more: {gone}"
        with wine.running():
            result = unittest.TextTestRunner(verbosity=2, resultclass=Timed).run(whole)
    for line in left_out:
        print("not here: " + line)
    print(f"{result.testsRun} run, {len(left_out)} not here")
    return 0 if result.wasSuccessful() else 1


if __name__ == "__main__":
    sys.exit(main())
