#!/usr/bin/env python3
"""Checks that source files, functions and folders stay small enough to read.

    file_sizes.py ROOT          exit 1 and one line per file, function or folder that is too large
    file_sizes.py --self-test   shows that each rule can fail

A file has at most 400 lines, a function at most 80, and a folder of src/ at most 25 files of code directly in it. Generated
files and those of others (src/base/mathematics) are exempt. Outside Python the indentation shows where a function ends.
Classes and data are no functions; a loop or callback at the top of a file counts as one.
"""

import ast
import pathlib
import re
import sys
import tempfile

LIMIT = 400
FUNCTION_LIMIT = 80
FOLDER_LIMIT = 25
FOLDERS = "apps assets bench blender examples farm include scripts shaders src tests web".split()
SUFFIXES = set(".h .cpp .py .glsl .vert .frag .js .jsx .mjs .ts .tsx .mts .css .html .sh".split())
GENERATED = ("web/three/src/generated/", "scripts/packaging/python/halflight/_commands.py")
OF_OTHERS = ("src/base/mathematics/",)
NO_FUNCTIONS = {".css", ".html"}
TYPE = re.compile(r"(export )?(default )?(template<.*> )?(class|struct|union|enum|namespace)\b")


def python_functions(text):
    """First and last line of each."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            yield node.lineno, node.end_lineno


def head_of_block(lines, indents, opening):
    """First line of the statement whose block opens in a line, and the statement."""
    first = opening
    while first > 0 and lines[first - 1].strip():
        before = lines[first - 1]
        initializer = before.endswith("}") and indents[first - 1] > indents[opening]  # a_{a} of a constructor
        if re.search(r"[;{}:]$|^\s*(//|\*|#)", before) and not initializer:
            break
        first -= 1
    return first, " ".join(line.strip() for line in lines[first : opening + 1])


def braced_functions(text):
    """First and last line of each, without those inside others."""
    lines = text.splitlines()
    indents = [len(line) - len(line.lstrip()) for line in lines]
    end = -1
    for opening, line in enumerate(lines):
        if opening <= end or not line.endswith("{"):
            continue
        first, head = head_of_block(lines, indents, opening)
        if ")" not in head and "=>" not in head or TYPE.match(head):
            continue
        after = range(opening + 1, len(lines))
        closing = (i for i in after if indents[i] <= indents[opening] and lines[i].lstrip().startswith("}"))
        end = next(closing, len(lines) - 1)
        yield first + 1, end + 1


def long_functions(name, suffix, text):
    for first, last in python_functions(text) if suffix == ".py" else braced_functions(text):
        lines = last - first + 1
        if lines > FUNCTION_LIMIT:
            yield f"{name}:{first}: a function of {lines} lines, at most {FUNCTION_LIMIT}: split it"


def full_folders(root):
    for folder in sorted(path for path in (root / "src").rglob("*") if path.is_dir()):
        name = folder.relative_to(root).as_posix() + "/"
        files = sum(path.suffix in SUFFIXES for path in folder.iterdir() if path.is_file())
        if files > FOLDER_LIMIT and not name.startswith(OF_OTHERS):
            yield f"{name}: {files} files, at most {FOLDER_LIMIT}: split it by what they are for"


def problems_of(root):
    problems = list(full_folders(root))
    for folder in FOLDERS:
        for path in sorted((root / folder).rglob("*")):
            if path.suffix not in SUFFIXES or not path.is_file() or "node_modules" in path.parts:
                continue
            name = path.relative_to(root).as_posix()
            if name.startswith(GENERATED + OF_OTHERS):
                continue
            text = path.read_text(encoding="utf-8", errors="replace")
            lines = len(text.splitlines())
            if path.suffix not in NO_FUNCTIONS:
                problems += long_functions(name, path.suffix, text)
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
        (root / "src/many").mkdir()
        for number in range(FOLDER_LIMIT + 1):
            assert problems_of(root) == []
            (root / f"src/many/{number}.h").touch()
        assert len(problems_of(root)) == 1
        (root / "src/many/0.h").unlink()
        (root / "src/base/mathematics").mkdir(parents=True)
        (root / "src/base/mathematics/long.cpp").write_text("\n" * (LIMIT + 5))
        assert problems_of(root) == []
        (root / "src/short.py").write_text("def fits():\n" + "    pass\n" * (FUNCTION_LIMIT - 1))
        assert problems_of(root) == []
        (root / "src/short.py").write_text("def long():\n" + "    pass\n" * FUNCTION_LIMIT)
        assert len(problems_of(root)) == 1
        (root / "src/short.py").unlink()
        self_test_of_braces(root / "src/short.cpp")


def self_test_of_braces(path):
    shapes = {
        "void f(int a,\n       int b)\n{\n%s}\n": 4,
        "Part::Part(int a)\n    : a_{a}\n{\n%s}\n": 4,
        "class Part {\n    int f() const\n    {\n%s    }\n};\n": 3,
        "template<typename T> int f(T a) {\n%s}\n": 2,
        "test('a', async () => {\n%s});\n": 2,
        "for (const a of b) {\n%s}\n": 2,
        "name() {\n%s}\n": 2,
        "/// A comment (long)\nvoid f()\n{\n%s}\n": 3,
    }
    for shape, own_lines in shapes.items():
        for more, problems in ((0, 0), (1, 1)):
            path.write_text(shape % ("        a();\n" * (FUNCTION_LIMIT - own_lines + more)))
            assert len(problems_of(path.parents[1])) == problems, (shape, more)
    for head in ("struct Part", "const int kTable[] =", "namespace part"):
        path.write_text(head + " {\n" + "    a,\n" * (2 * FUNCTION_LIMIT) + "}\n")
        assert problems_of(path.parents[1]) == [], head


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
