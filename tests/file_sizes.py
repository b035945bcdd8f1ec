#!/usr/bin/env python3
"""Checks that source files, and functions of Python, stay short enough to read.

    file_sizes.py ROOT          exit 1 and one line per file or function that is too long
    file_sizes.py --self-test   shows that each rule can fail

A file has at most 400 lines, a Python function at most 80. Generated files and those of others (src/base/mathematics)
are exempt.
"""

import ast
import pathlib
import sys
import tempfile

LIMIT = 400
FUNCTION_LIMIT = 80
FOLDERS = ("apps", "assets", "bench", "blender", "examples", "farm", "include", "scripts", "shaders", "src", "tests", "web")
SUFFIXES = {".h", ".cpp", ".py", ".glsl", ".vert", ".frag", ".js", ".jsx", ".mjs", ".ts", ".tsx", ".mts", ".css", ".html", ".sh"}
GENERATED = ("web/three/src/generated/", "scripts/packaging/python/halflight/_commands.py")
OF_OTHERS = ("src/base/mathematics/",)


def long_functions(name, text):
    functions = (n for n in ast.walk(ast.parse(text)) if isinstance(n, (ast.FunctionDef, ast.AsyncFunctionDef)))
    for function in functions:
        lines = function.end_lineno - function.lineno + 1
        if lines > FUNCTION_LIMIT:
            yield f"{name}: {function.name}() has {lines} lines, at most {FUNCTION_LIMIT}: split it"


def problems_of(root):
    problems = []
    for folder in FOLDERS:
        for path in sorted((root / folder).rglob("*")):
            if path.suffix not in SUFFIXES or not path.is_file() or "node_modules" in path.parts:
                continue
            name = path.relative_to(root).as_posix()
            if name.startswith(GENERATED + OF_OTHERS):
                continue
            text = path.read_text(encoding="utf-8", errors="replace")
            lines = len(text.splitlines())
            if path.suffix == ".py":
                problems += long_functions(name, text)
            if lines > LIMIT:
                problems.append(f"{name}: {lines} lines, at most {LIMIT}: split it by what it holds")
    return problems


def self_test():
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        (root / "src").mkdir()
        (root / "src/short.cpp").write_text("\n" * LIMIT)
        assert problems_of(root) == []
        (root / "src/long.cpp").write_text("\n" * (LIMIT + 5))
        assert len(problems_of(root)) == 1
        (root / "src/long.cpp").unlink()
        (root / "web/three/src/generated").mkdir(parents=True)
        (root / "web/three/src/generated/long.js").write_text("\n" * (LIMIT + 5))
        assert problems_of(root) == []
        (root / "web/three/src/long.js").write_text("\n" * (LIMIT + 5))
        assert len(problems_of(root)) == 1
        (root / "web/three/src/long.js").unlink()
        (root / "src/base/mathematics").mkdir(parents=True)
        (root / "src/base/mathematics/long.cpp").write_text("\n" * (LIMIT + 5))
        assert problems_of(root) == []
        (root / "src/short.py").write_text("def fits():\n" + "    pass\n" * (FUNCTION_LIMIT - 1))
        assert problems_of(root) == []
        (root / "src/short.py").write_text("def long():\n" + "    pass\n" * FUNCTION_LIMIT)
        assert len(problems_of(root)) == 1


def main():
    if sys.argv[1:] == ["--self-test"]:
        self_test()
        return 0
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    problems = problems_of(pathlib.Path(sys.argv[1]))
    print("\n".join(problems) or "every file is short enough")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
