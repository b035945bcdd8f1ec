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
    "unwrap": {"scene", "shading", "base"},
    # The bake checks its probes with what renderers interpolate.
    "bake": {"unwrap", "render/frame", "shading", "scene", "base"},
    "transport": {"bake", "render/frame", "unwrap", "shading", "scene", "base"},
    "bake_cpu": {"transport", "bake", "render/frame", "unwrap", "shading", "scene", "base"},
    "gpu": {"base"},
    "bake_gpu": {"bake_cpu", "transport", "bake", "render/frame", "gpu", "unwrap", "shading", "scene", "base"},
    # The frame's decisions are usable without Vulkan, so they are a module of their own inside render.
    "render/frame": {"scene", "shading", "base"},
    "render": {"render/frame", "scene", "shading", "gpu", "base"},
    "view": {"render", "render/frame", "bake_cpu", "transport", "bake", "unwrap", "gpu", "scene", "shading", "base"},
}

def floors(*names):
    """Folders from the lowest up: each may include those before it."""
    return {name: set(names[:i]) for i, name in enumerate(names)}


# Folders inside a module -> folders of the same module they may include besides themselves. Files outside these folders
# may include all of them, and none of the folders may include such a file.
FOLDERS = {
    "scene": floors(
        "model", "pictures", "document", "document/decode", "format", "load", "settings", "read/geometry",
        "read/looks", "read", "write/meshes", "write", "files"
    ),
    "bake": floors(
        "settings", "geometry", "texels", "seams", "denoise", "pages", "sides", "cache", "lights", "report",
        "probes", "reflections", "live"
    ),
    "unwrap": floors("surface", "objects", "charts", "pack", "cuts", "result"),
    "render": floors("frame", "scene", "passes"),
    "view": floors("state", "panels", "window", "scene"),
    "transport": {
        "random": set(),
        "trace": {"random"},
        "sample": {"random", "trace"},
        "texels": {"sample", "random", "trace"},
        "radiosity": {"texels", "sample", "random", "trace"},
        "shadows": {"texels", "sample", "random", "trace"},
        "guiding": {"radiosity", "texels", "sample", "random", "trace"},
        "lightmap": {"guiding", "radiosity", "texels", "sample", "random", "trace"},
    },
    "bake_cpu": floors("trace", "reference"),
}

# Libraries that only some folders may see: the last column of the table in docs/architecture.md, which the check compares
# with the names here.
CONFINED = [
    ("GLM", r"^glm/", ("include/", "src/", "apps/")),
    ("fmt", r"^(fmt/|spdlog/fmt/)", ("src/unwrap/", "src/view/", "apps/")),
    ("spdlog", r"^spdlog/(?!fmt/)", ("include/halflight/base/",)),
    ("OpenEXR", r"^(Imf|Imath|Iex)\w*\.h$", ("src/base/",)),
    ("libpng", r"^png\.h$", ("src/base/",)),
    ("libwebp", r"^webp/", ("src/base/",)),
    ("stb", r"^stb_\w+\.h$", ("src/base/",)),
    ("oneTBB", r"^(tbb|oneapi)/", ("src/base/",)),
    ("xxHash", r"^xxhash\.h$", ("src/base/",)),
    ("Emscripten", r"^emscripten", ("src/base/",)),
    ("POSIX", r"^(dirent|fcntl|pthread|termios|unistd|sys/\w+)\.h$", ("src/base/",)),
    ("toml++", r"^toml\+\+/", ("src/scene/",)),
    ("zstd", r"^zstd\.h$", ("src/scene/",)),
    ("Draco", r"^draco/", ("src/scene/",)),
    ("meshoptimizer", r"^meshoptimizer\.h$", ("src/scene/",)),
    ("nlohmann-json", r"^nlohmann/", ("src/scene/", "src/bake/", "apps/")),
    ("Eigen", r"^Eigen/", ("src/unwrap/", "src/bake/")),
    ("Embree", r"^(embree\d*/|rtcore)", ("src/bake_cpu/",)),
    ("Vulkan", r"^(vulkan/|vk_video/|volk\.h|vk_mem_alloc)", ("src/gpu/", "src/render/", "src/view/", "include/halflight/render/vulkan_target.h", "src/bake_gpu/")),
    ("SDL2", r"^SDL\w*\.h$", ("src/view/",)),
    ("Dear ImGui", r"^(imgui\.h|backends/imgui_)", ("src/view/",)),
    ("CLI11", r"^CLI/", ("apps/",)),
]
CONFINED = [(name, re.compile(pattern), folders) for name, pattern, folders in CONFINED]
# Headers of the language and of the operating system.
SYSTEM = re.compile(r"^([a-z_0-9]+|c?(unistd|fcntl|malloc|dlfcn|windows|psapi|signal|io|process|sys/\w+)\.h)$")
# ... and folders inside those that may not.
EXCLUDED = [(re.compile(r"^(vulkan/|vk_video/|volk\.h|vk_mem_alloc)"), "src/render/frame/")]

INCLUDE = re.compile(r'^\s*#\s*include\s*(?:<([^>]+)>|"([^"]+)")', re.MULTILINE)
SUFFIXES = {".h", ".hpp", ".inl", ".cpp", ".cc"}


def module_of(parts):
    """Module that a path inside src/ or include/halflight/ belongs to, None when it names none."""
    if parts[:2] in (("render", "frame"), ("render", "frame.h"), ("render", "probes.h"), ("render", "compose.h")):
        return "render/frame"
    return parts[0] if len(parts) > 1 and parts[0] in ALLOWED else None


def module_of_file(relative):
    parts = relative.parts
    if parts[0] == "src":
        return module_of(parts[1:])
    if parts[:2] == ("include", "halflight"):
        return module_of(parts[2:])
    return None


def folder_problem(where, name, target_file):
    """What is wrong with an include inside a module that has FOLDERS, None if nothing is."""
    parts = pathlib.PurePosixPath(where).parts
    target = target_file.parts
    if parts[0] != "src" or target[0] != "src" or parts[1] != target[1] or parts[1] not in FOLDERS or len(parts) < 4:
        return None
    folders = FOLDERS[parts[1]]
    folder = "/".join(parts[2:-1])
    other = "/".join(target[2:-1]) or None
    if folder not in folders:
        return f"{where}: {parts[1]}/{folder} is not in FOLDERS of tests/module_directions.py"
    if other == folder or other in folders[folder]:
        return None
    return f"{parts[1]}/{folder} may not include {name}"


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
                known = bool(match.group(2)) or name.startswith("halflight/") or bool(SYSTEM.search(name))
                for _, pattern, folders in CONFINED:
                    if not pattern.search(name):
                        continue
                    known = True
                    if not where.startswith(folders):
                        problems.append(f"{where}:{line}: includes {name}, which only {', '.join(folders)} may")
                if not known:
                    problems.append(f"{where}:{line}: includes {name}, of a library that docs/architecture.md does not list")
                for pattern, folder in EXCLUDED:
                    if pattern.search(name) and where.startswith(folder):
                        problems.append(f"{where}:{line}: includes {name}, which {folder} may not")
                if top == "apps":
                    continue
                # Relative to the including file first, as the compiler looks it up; then by the include path.
                beside = path.parent / name
                inside = root / "src" / name
                file = beside if beside.is_file() else inside
                if match.group(2) and file.is_file():
                    problem = folder_problem(where, name, file.resolve().relative_to(root))
                    if problem is not None:
                        problems.append(f"{where}:{line}: {problem}")
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


def table_problems(text):
    """Differences between the module table of docs/architecture.md and the rules above."""
    problems = []
    rows = re.findall(r"^\| `([\w/]+)`[^|]*\|([^|]*)\|[^|]*\|([^|]*)\|$", text, re.MULTILINE)
    listed = {}
    for module, may, libraries in rows:
        folder = "apps/" if module.startswith("apps") else module
        for library in filter(None, (word.strip() for word in libraries.split(","))):
            listed.setdefault(library, set()).add(folder)
        if module in ALLOWED:
            direct = {"render/frame" if word.strip() == "frame" else word.strip() for word in may.split(",")} - {""}
            reached = set(direct)
            for name in direct:
                reached |= ALLOWED.get(name, set())
            if reached != ALLOWED[module]:
                problems.append(f"docs/architecture.md: {module} may include {may.strip() or 'nothing'}, the check says "
                                f"{', '.join(sorted(ALLOWED[module])) or 'nothing'}")
    for library, _, folders in CONFINED:
        if folders == ("include/", "src/", "apps/"):
            continue
        allowed = {f if f == "apps/" else re.sub(r"^(src|include/halflight)/|/$", "", f) for f in folders}
        allowed -= {"render/vulkan_target.h"}  # one header of render
        if listed.get(library, set()) != allowed:
            problems.append(f"docs/architecture.md: {library} is listed for {sorted(listed.get(library, set()))}, "
                            f"the check allows {sorted(allowed)}")
    for library in sorted(set(listed) - {name for name, _, _ in CONFINED}):
        problems.append(f"docs/architecture.md: the check does not know {library}")
    return problems


def self_test():
    good = {
        "include/halflight/base/math.h": "#include <cmath>\n",
        "include/halflight/shading/law.h": '#include "language.h"\n',
        "include/halflight/shading/language.h": '#include "halflight/base/math.h"\n',
        "include/halflight/scene/scene.h": '#include "halflight/base/math.h"\n',
        "include/halflight/render/frame.h": '#include "halflight/scene/scene.h"\n',
        "include/halflight/bake/bake.h": '#include "halflight/scene/scene.h"\n',
        "src/scene/reader.cpp": "#include <zstd.h>\n",
        "src/bake_cpu/trace.cpp": '#include <embree3/rtcore.h>\n#include "halflight/bake/bake.h"\n',
        "src/bake_cpu/trace/kernels.h": '#include <embree3/rtcore.h>\n#include "transport/trace/rays.h"\n',
        "src/transport/trace/rays.h": "#include <span>\n",
        "src/transport/sample/light.h": '#include "transport/trace/rays.h"\n',
        "src/transport/lightmap/gather.cpp": '#include "transport/sample/light.h"\n#include "transport/trace/rays.h"\n',
        "src/transport/wiring.h": '#include "transport/sample/light.h"\n',
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
        ("src/render/x.cpp", "#include <zstd.h>\n", "only src/scene/"),
        ("apps/tool/x.cpp", "#include <zstd.h>\n", "only src/scene/"),
        ("src/bake/x.cpp", "#include <embree4/rtcore.h>\n", "only src/bake_cpu/"),
        ("src/transport/x.cpp", '#include "bake_cpu/trace/kernels.h"\n', "transport may not include bake_cpu"),
        ("src/transport/trace/x.cpp", '#include "transport/sample/light.h"\n', "transport/trace may not include"),
        ("src/transport/trace/y.cpp", '#include "../sample/light.h"\n', "transport/trace may not include"),
        ("src/transport/sample/x.cpp", '#include "transport/wiring.h"\n', "transport/sample may not include"),
        ("src/transport/stray/x.cpp", '#include "transport/trace/rays.h"\n', "is not in FOLDERS"),
        ("apps/tool/x.cpp", "#include <unistd.h>\n", "only src/base/"),
        ("apps/tool/x.cpp", "#include <draco/mesh/mesh.h>\n", "only src/scene/"),
        ("src/scene/x.cpp", "#include <webp/decode.h>\n", "only src/base/"),
        ("include/halflight/render/x.h", "#include <vulkan/vulkan.h>\n", "only src/gpu/"),
        ("include/halflight/render/x.h", '#include "gpu/device.h"\n', "private gpu/device.h"),
        ("src/scene/x.cpp", "#include <tbb/parallel_for.h>\n", "only src/base/"),
        ("src/render/x.cpp", "#include <Eigen/Dense>\n", "only src/unwrap/"),
        ("src/scene/x.cpp", "#include <boost/optional.hpp>\n", "does not list"),
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
    page = (pathlib.Path(__file__).resolve().parent.parent / "docs/architecture.md").read_text(encoding="utf-8")
    for old, new in (("toml++, ", ""), ("| Embree |", "| Embree, Boost |"), ("| unwrap, frame, shading |", "| scene |")):
        if old not in page or not table_problems(page.replace(old, new)):
            failures.append(f"is content with the table when {old!r} becomes {new!r}")
    return failures


def main():
    if len(sys.argv) != 2:
        print(__doc__.strip(), file=sys.stderr)
        return 2
    if sys.argv[1] == "--self-test":
        problems = self_test()
    else:
        root = pathlib.Path(sys.argv[1]).resolve()
        problems = broken_rules(root) + table_problems((root / "docs/architecture.md").read_text(encoding="utf-8"))
    for problem in problems:
        print(problem)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
