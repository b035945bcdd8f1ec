#!/usr/bin/env python3
"""One line about the tests of a ctest run that were skipped, and why: scripts/skipped_tests.py BUILD/Testing/Temporary/LastTest.log

GoogleTest's "FILE:LINE: Skipped", reason, "[  SKIPPED ] NAME"; tests/cli/cli_case.py prints "[  SKIPPED ] NAME: reason".
"""

import collections
import pathlib
import re
import sys


def reasons(log):
    for reason, _ in re.findall(r": Skipped\n(.*?)\n+\[  SKIPPED \] (\S+) \(\d+ ms\)\n", log, re.S):
        yield " ".join(reason.split())
    for reason in re.findall(r"^\[  SKIPPED \] [^\n:]+: ([^\n]+)$", log, re.M):
        yield reason


def main():
    count = collections.Counter(reasons(pathlib.Path(sys.argv[1]).read_text(errors="replace")))
    total = sum(count.values())
    details = "; ".join(f"{n} × {reason}" for reason, n in count.most_common())
    print(f"skipped tests: {total}" + (f" ({details})" if total else ""))


if __name__ == "__main__":
    main()
