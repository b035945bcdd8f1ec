"""Checks that no file includes a module it must not know (docs/architecture.md). Usage: include_directions_test.py ROOT"""

import os
import re
import sys

# A module and what it may include besides itself: the tree of docs/architecture.md, closed over its arrows.
ALLOWED = {
    "base": set(),
    "shading": {"base"},
    "scene": {"base"},
    "unwrap": {"scene", "base"},
    "bake": {"unwrap", "shading", "scene", "base"},
    "bake_cpu": {"bake", "unwrap", "shading", "scene", "base"},
    "gpu": {"base"},
    "render": {"scene", "shading", "gpu", "base"},
}

# Libraries that only some modules may see.
LIBRARIES = {
    r"tiny_gltf\.h": {"scene"},
    r"embree[34]/.*": {"bake_cpu"},
    r"vulkan/.*": {"gpu", "render"},
    r"toml(\+\+|plusplus)?/.*": {"scene"},
    r"Eigen/.*": {"unwrap"},
    r"CLI/.*": set(),
}

INCLUDE = re.compile(r'^\s*#\s*include\s+["<]([^">]+)[">]', re.MULTILINE)


def files(root):
    for top in ("src", "include/halflight"):
        for module in ALLOWED:
            for folder, _, names in os.walk(os.path.join(root, top, module)):
                for name in names:
                    if name.endswith((".h", ".cpp", ".inl")):
                        yield module, os.path.join(folder, name)


def complaints(root):
    count = 0
    for module, path in files(root):
        shown = os.path.relpath(path, root)
        public = shown.startswith("include")
        with open(path, encoding="utf-8") as file:
            includes = INCLUDE.findall(file.read())
        count += 1
        for name in includes:
            target = re.sub("^halflight/", "", name).split("/")[0] if "/" in name else module
            if target in ALLOWED and target != module and target not in ALLOWED[module]:
                yield f"{shown} includes {name}: {module} must not know {target}"
            if public and target in ALLOWED and "/" in name and not name.startswith("halflight/"):
                yield f"{shown} includes {name}: a public header must not include a private one"
            for pattern, owners in LIBRARIES.items():
                if re.fullmatch(pattern, name) and module not in owners:
                    yield f"{shown} includes {name}: only {sorted(owners) or 'apps'} may"
            if re.fullmatch(r"vulkan/.*|gpu/.*", name) and shown.startswith(os.path.join("src", "render", "frame")):
                yield f"{shown} includes {name}: halflight::frame knows no graphics API"
            if public and re.match(r"(vulkan|embree|tiny_gltf|toml|Eigen)", name):
                yield f"{shown} includes {name}: a public header must not show a library"
    if count < 40:
        yield f"only {count} source files found under {root}"


if __name__ == "__main__":
    found = list(complaints(sys.argv[1]))
    print("\n".join(found) if found else "include directions hold")
    sys.exit(1 if found else 0)
