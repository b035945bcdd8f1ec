#!/usr/bin/env python3
"""Checks that no two files define a class of the same name in the same namespace.

    one_definition.py ROOT          checks ROOT/{include,src,apps}; exit 1 and one line per name
    one_definition.py --self-test   shows on a made-up tree that it can fail

Where two classes of a program have one name, their destructors and other inline functions do too. The linker keeps one
of them for both classes, and says nothing.
"""

import collections
import pathlib
import re
import sys
import tempfile

DEFINITION = re.compile(r"^(?:class|struct)\s+(\w+)(?:\s+final)?\s*(?::[^:].*)?(?:\{|$)")
BEGIN = re.compile(r"^(?:namespace(?:\s+([\w:]+))?\s*\{|HL_NAMESPACE_BEGIN)")
END = re.compile(r"^(?:\} // namespace|HL_NAMESPACE_END)")


def classes(text):
    """Full names of the classes that a source defines, but for those of unnamed namespaces."""
    inside = []
    for line in text.splitlines():
        if match := BEGIN.match(line):
            inside.append(match[1] or ("halflight::shading" if line.startswith("HL_") else ""))
        elif END.match(line):
            inside.pop()
        elif (match := DEFINITION.match(line)) and "" not in inside:
            yield "::".join([*inside, match[1]])


def names_of_several(root):
    files = collections.defaultdict(set)
    for folder in ("include", "src", "apps"):
        for path in sorted((root / folder).rglob("*")):
            if path.suffix in (".h", ".cpp"):
                for name in classes(path.read_text()):
                    files[name].add(str(path.relative_to(root)))
    return {name: sorted(paths) for name, paths in files.items() if len(paths) > 1}


def self_test():
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        for name, text in {
            "src/a.h": "namespace halflight {\nclass Scene {\n};\nstruct Same : Base {\n};\n} // namespace halflight\n",
            "src/b.h": "namespace halflight::b {\nclass Scene {\n};\n} // namespace halflight::b\n",
            "src/c.cpp": "namespace halflight {\nnamespace {\nclass Scene {\n};\n} // namespace\nclass Same final\n"
                         "    : public Base {\n};\n} // namespace halflight\n",
        }.items():
            (root / name).parent.mkdir(exist_ok=True)
            (root / name).write_text(text)
        assert names_of_several(root) == {"halflight::Same": ["src/a.h", "src/c.cpp"]}, names_of_several(root)


if __name__ == "__main__":
    if sys.argv[1:] == ["--self-test"]:
        self_test()
        sys.exit()
    several = names_of_several(pathlib.Path(sys.argv[1]))
    for name, paths in sorted(several.items()):
        print(f"{name} is defined in {' and '.join(paths)}: the linker would mix up their functions")
    sys.exit(1 if several else 0)
