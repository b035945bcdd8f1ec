#!/usr/bin/env python3
"""Has another compiler check the sources, which finds what one compiler or C++ library alone takes.

    check_portable.py build/asan/compile_commands.json [--compiler clang++-16] [--libcxx] [--jobs 2]

The preset asan compiles each source by itself, so that all are in its list.

--libcxx: with LLVM's C++ library instead of GNU's; Apple's derives from it. Nothing is linked. Prints errors and warnings;
exit code 1 where there are any.
"""

import argparse
import concurrent.futures
import json
import pathlib
import shlex
import subprocess

FOLDERS = ("src", "apps", "examples", "bench")
# The last two: what other compilers than GCC and clang do not have.
FLAGS = ["-fsyntax-only", "-Wall", "-Wextra", "-Wno-missing-field-initializers", "-Wgnu", "-Wc99-extensions"]


def arguments_of(command):
    """Definitions, folders and the language of a compile command: what does not depend on the compiler."""
    words = shlex.split(command)
    for i, word in enumerate(words):
        if word.startswith(("-I", "-D", "-std=")):
            yield word
        elif word == "-isystem":
            yield from (word, words[i + 1])
        elif word == "-w":
            yield word


def commands(database, compiler):
    root = pathlib.Path(__file__).resolve().parents[1]
    checked = set()
    for entry in json.loads(database.read_text()):
        path = pathlib.Path(entry["file"])
        ours = path.is_relative_to(root) and path.relative_to(root).parts[0] in FOLDERS
        if ours and path not in checked:
            checked.add(path)
            yield path.relative_to(root), [*compiler, *arguments_of(entry["command"]), *FLAGS, str(path)], entry["directory"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("database", type=pathlib.Path)
    parser.add_argument("--compiler", default="clang++")
    parser.add_argument("--libcxx", action="store_true")
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    compiler = [options.compiler, *(["-stdlib=libc++"] if options.libcxx else [])]

    def check(job):
        path, command, folder = job
        return path, subprocess.run(command, cwd=folder, capture_output=True, text=True)

    files = faults = 0
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for path, result in pool.map(check, commands(options.database, compiler)):
            files += 1
            if result.returncode != 0 or result.stderr:
                faults += 1
                print(f"{path}:\n{result.stderr}", flush=True)
    print(f"check_portable.py: {files} files, {faults} with messages")
    return 1 if faults or files == 0 else 0


if __name__ == "__main__":
    raise SystemExit(main())
