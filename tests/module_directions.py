#!/usr/bin/env python3
"""Checks that every #include obeys the module directions of docs/architecture.md.

    module_directions.py ROOT          checks ROOT/{include,src,apps}; exit 1 and one line per broken rule
    module_directions.py --self-test   shows on made-up trees that each rule can fail
"""

import pathlib
import re
import sys
import tempfile

# Module -> modules it may include besides itself. Nothing else may be included, not even through a third module.
ALLOWED = {
    "base": set(),
    "shading": {"base"},
    "scene": {"base"},
    "unwrap": {"scene", "base"},
    "bake": {"unwrap", "shading", "scene", "base"},
    "bake_cpu": {"bake", "unwrap", "shading", "scene", "base"},
    "gpu": {"base"},
    "bake_gpu": {"bake", "gpu", "unwrap", "shading", "scene", "base"},
    # The frame's decisions are usable without Vulkan, so they are a module of their own inside render.
    "render/frame": {"scene", "shading", "base"},
    "render": {"render/frame", "scene", "shading", "gpu", "base"},
}

# Libraries that only some folders may see.
CONFINED = [
    (re.compile(r"(^|/)tiny_gltf(_v\d+)?\.h$"), ("src/scene/",)),
    (re.compile(r"^(vulkan/|vk_video/|volk\.h|vk_mem_alloc)"), ("src/gpu/", "src/render/", "src/bake_gpu/", "apps/")),
    (re.compile(r"^(draco/|meshoptimizer\.h$)"), ("src/scene/",)),
    (re.compile(r"^webp/"), ("src/base/",)),
    (re.compile(r"^(embree\d*/|rtcore)"), ("src/bake_cpu/",)),
]
# ... and folders inside those that may not.
EXCLUDED = [(re.compile(r"^(vulkan/|vk_video/|volk\.h|vk_mem_alloc)"), "src/render/frame/")]

INCLUDE = re.compile(r'^\s*#\s*include\s*(?:<([^>]+)>|"([^"]+)")', re.MULTILINE)
SUFFIXES = {".h", ".hpp", ".inl", ".cpp", ".cc"}


def module_of(parts):
    """Module that a path inside src/ or include/halflight/ belongs to, None when it names none."""
    if parts[:2] in (("render", "frame"), ("render", "frame.h"), ("render", "probes.h")):
        return "render/frame"
    return parts[0] if len(parts) > 1 and parts[0] in ALLOWED else None


def module_of_file(relative):
    parts = relative.parts
    if parts[0] == "src":
        return module_of(parts[1:])
    if parts[:2] == ("include", "halflight"):
        return module_of(parts[2:])
    return None


def broken_rules(root):
    problems = []
    count = 0
    for top in ("include", "src", "apps"):
        for path in sorted((root / top).rglob("*")):
            if path.suffix not in SUFFIXES or not path.is_file():
                continue
            count += 1
            relative = path.relative_to(root)
            where = relative.as_posix()
            owner = module_of_file(relative)
            if top != "apps" and owner is None:
                problems.append(f"{where}: belongs to no module of docs/architecture.md")
                continue
            text = path.read_text(encoding="utf-8", errors="replace")
            for match in INCLUDE.finditer(text):
                name = match.group(1) or match.group(2)
                line = text.count("\n", 0, match.start(1) if match.group(1) else match.start(2)) + 1
                for pattern, folders in CONFINED:
                    if pattern.search(name) and not where.startswith(folders):
                        problems.append(f"{where}:{line}: includes {name}, which only {', '.join(folders)} may")
                for pattern, folder in EXCLUDED:
                    if pattern.search(name) and where.startswith(folder):
                        problems.append(f"{where}:{line}: includes {name}, which {folder} may not")
                if top == "apps":
                    continue
                # Relative to the including file first, as the compiler looks it up; then by the include path.
                beside = path.parent / name
                if match.group(2) and beside.is_file():
                    target = module_of_file(beside.resolve().relative_to(root))
                else:
                    parts = pathlib.PurePosixPath(name).parts
                    target = module_of(parts[1:] if parts[0] == "halflight" else parts)
                    if parts[0] == "halflight" and target is None:
                        problems.append(f"{where}:{line}: includes {name}, which is in no module")
                    if parts[0] == "halflight" and len(parts) == 2:
                        continue
                if where.startswith("include/") and not (
                    name.startswith("halflight/") or (match.group(2) and beside.is_file())
                ):
                    if match.group(2):
                        problems.append(f"{where}:{line}: a public header includes the private {name}")
                if target is not None and target != owner and target not in ALLOWED[owner]:
                    problems.append(f"{where}:{line}: {owner} may not include {target} ({name})")
    if count == 0:
        problems.append(f"{root}: no sources found")
    return problems


def self_test():
    good = {
        "include/halflight/base/math.h": "#include <cmath>\n",
        "include/halflight/shading/law.h": '#include "language.h"\n',
        "include/halflight/shading/language.h": '#include "halflight/base/math.h"\n',
        "include/halflight/scene/scene.h": '#include "halflight/base/math.h"\n',
        "include/halflight/render/frame.h": '#include "halflight/scene/scene.h"\n',
        "include/halflight/bake/bake.h": '#include "halflight/scene/scene.h"\n',
        "src/scene/reader.cpp": "#include <tiny_gltf.h>\n",
        "src/bake_cpu/trace.cpp": '#include <embree3/rtcore.h>\n#include "halflight/bake/bake.h"\n',
        "src/gpu/device.h": "#include <vulkan/vulkan.hpp>\n",
        "src/render/pass.cpp": '#include "gpu/device.h"\n#include "render/frame/plan.h"\n#include <vulkan/vulkan.hpp>\n',
        "src/render/frame/plan.h": '#include "halflight/render/frame.h"\n#include "halflight/shading/law.h"\n',
        "apps/tool/main.cpp": '#include "halflight/bake/bake.h"\n#include "gpu/device.h"\n',
    }
    # Each entry breaks exactly one rule: file, its contents, and a part of the complaint.
    bad = [
        ("src/base/x.cpp", '#include "halflight/scene/scene.h"\n', "base may not include scene"),
        ("src/shading/x.cpp", '#include "halflight/scene/scene.h"\n', "shading may not include scene"),
        ("src/scene/x.cpp", '#include "halflight/shading/law.h"\n', "scene may not include shading"),
        ("src/unwrap/x.cpp", '#include "halflight/bake/bake.h"\n', "unwrap may not include bake"),
        ("src/bake/x.cpp", '  #  include "bake_cpu/trace.h"\n', "bake may not include bake_cpu"),
        ("src/gpu/x.cpp", '#include "halflight/scene/scene.h"\n', "gpu may not include scene"),
        ("src/render/x.cpp", '#include "halflight/bake/bake.h"\n', "render may not include bake"),
        ("src/render/x.cpp", '#include "../unwrap/x.h"\n', ""),
        ("src/render/frame/x.cpp", '#include "gpu/device.h"\n', "render/frame may not include gpu"),
        ("src/render/frame/x.cpp", "#include <vulkan/vulkan.h>\n", "src/render/frame/ may not"),
        ("src/render/frame/x.cpp", '#include "render/pass.h"\n', "render/frame may not include render"),
        ("src/render/x.cpp", "#include <tiny_gltf.h>\n", "only src/scene/"),
        ("apps/tool/x.cpp", "#include <tiny_gltf.h>\n", "only src/scene/"),
        ("src/bake/x.cpp", "#include <embree4/rtcore.h>\n", "only src/bake_cpu/"),
        ("apps/tool/x.cpp", "#include <draco/mesh/mesh.h>\n", "only src/scene/"),
        ("src/scene/x.cpp", "#include <webp/decode.h>\n", "only src/base/"),
        ("include/halflight/render/x.h", "#include <vulkan/vulkan.h>\n", "only src/gpu/"),
        ("include/halflight/render/x.h", '#include "gpu/device.h"\n', "private gpu/device.h"),
        ("src/stray/x.cpp", "\n", "belongs to no module"),
        ("src/base/x.cpp", '#include "halflight/nowhere/x.h"\n', "in no module"),
    ]
    failures = []

    def check(files):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder).resolve()
            for name, contents in files.items():
                (root / name).parent.mkdir(parents=True, exist_ok=True)
                (root / name).write_text(contents)
            return broken_rules(root)

    for problem in check(good):
        failures.append(f"complains about a good tree: {problem}")
    if not check({}):
        failures.append("is content with a tree without sources")
    for name, contents, complaint in bad:
        files = dict(good)
        files[name] = contents
        if "../unwrap/x.h" in contents:
            files["src/unwrap/x.h"] = "\n"
            complaint = "render may not include unwrap"
        problems = check(files)
        if not any(name in problem and complaint in problem for problem in problems):
            failures.append(f"misses {name} with {contents.strip()!r}: says {problems}")
    return failures


def main():
    if len(sys.argv) != 2:
        print(__doc__.strip(), file=sys.stderr)
        return 2
    problems = self_test() if sys.argv[1] == "--self-test" else broken_rules(pathlib.Path(sys.argv[1]).resolve())
    for problem in problems:
        print(problem)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
