"""The command line's own tests (tests/cli) with halflight.exe under Wine.
Usage: cli_under_wine.py SHARED_DIR [FILE …]

A script of the program's name stands for it, so that the tests are those of Linux. CANNOT names those that need what
neither Windows nor Wine has."""

import importlib
import pathlib
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
    "farm_test.FarmTrouble": "kills and stops processes by POSIX signals, fills a disk",
}


class Timed(unittest.TextTestResult):
    """Says what each test took."""

    def startTest(self, test):
        self.began = time.monotonic()
        super().startTest(test)

    def addSuccess(self, test):
        self.stream.write(f"{time.monotonic() - self.began:.1f} s ")
        super().addSuccess(test)


def cases(suite):
    for item in suite:
        if isinstance(item, unittest.TestSuite):
            yield from cases(item)
        else:
            yield item


def reason(name):
    return next((why for key, why in CANNOT.items() if name == key or name.startswith(key + ".")), None)


def main():
    shared, names = sys.argv[1], sys.argv[2:]
    wine.program()
    wine.prepare()
    import cli_case

    files = names or sorted(path.stem for path in (wine.ROOT / "tests/cli").glob("*_test.py"))
    whole = unittest.TestSuite()
    left_out, known = [], set()
    with tempfile.TemporaryDirectory() as folder:
        cli_case.HALFLIGHT, cli_case.SHARED = wine.wrapper(folder), shared
        for file in files:
            module = importlib.import_module(file.split(".")[0])
            for case in cases(unittest.defaultTestLoader.loadTestsFromModule(module)):
                known.add(case.id())
                if not case.id().startswith(file):
                    continue
                why = reason(case.id())
                if why is None:
                    whole.addTest(case)
                else:
                    left_out.append(f"{case.id()}: {why}")
        if not names:
            gone = [key for key in CANNOT if not any(name == key or name.startswith(key + ".") for name in known)]
            assert not gone, f"tests that are no more: {gone}"
        with wine.running():
            result = unittest.TextTestRunner(verbosity=2, resultclass=Timed).run(whole)
    for line in left_out:
        print("not here: " + line)
    print(f"{result.testsRun} run, {len(left_out)} not here")
    return 0 if result.wasSuccessful() else 1


if __name__ == "__main__":
    sys.exit(main())
