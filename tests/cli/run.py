"""Runs a file of tests: run.py FILE HALFLIGHT SHARED [CLASS | CLASS.test …], with FILE as farm/farm_test.py.

Tests are in rooms by topic. All rooms are in the path when they run (cli_case.py)."""

import os
import runpy
import sys

import cli_case  # noqa: F401  adds the rooms

if __name__ == "__main__":
    script = os.path.join(os.path.dirname(os.path.abspath(__file__)), sys.argv[1])
    sys.argv = [script, *sys.argv[2:]]
    runpy.run_path(script, run_name="__main__")
