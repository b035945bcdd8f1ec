#!/usr/bin/env python3
"""Makes an installed program relocatable: copies the shared libraries it needs beside it.

    bundle_libraries.py PREFIX      PREFIX/bin/halflight gets PREFIX/lib/halflight/*.so; their licences go to PREFIX/share/doc

The C library and its parts stay the system's; the Vulkan loader is opened at run time, if at all. libstdc++ is the
system's where it has one: a Vulkan driver of a newer system needs the newer one, and a process has one only. Needs
patchelf. Prints the newest version of glibc that a bundled file asks for.
"""

import pathlib
import platform
import re
import shutil
import subprocess
import sys

OF_THE_SYSTEM = re.compile(r"^(ld-linux.*|linux-vdso|lib(c|m|dl|rt|pthread|resolv|util|mvec|vulkan))\.so")

SYSTEM_FIRST = re.compile(r"^lib(stdc\+\+|gcc_s)\.so")
MULTIARCH = f"{platform.machine()}-linux-gnu"
SYSTEM_FOLDERS = [f"/usr/lib/{MULTIARCH}", f"/lib/{MULTIARCH}", "/usr/lib64", "/lib64", "/usr/lib", "/lib"]


def output(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def libraries_of(program):
    """Name and place of all that the loader finds for it, directly and indirectly."""
    found = {}
    for line in output("ldd", program).splitlines():
        match = re.match(r"\s*(\S+) => (\S+)", line)
        if match and not OF_THE_SYSTEM.match(match[1]):
            if not match[2].startswith("/"):
                raise SystemExit(f"bundle_libraries.py: {match[1]} was not found")
            found[match[1]] = pathlib.Path(match[2])
    return found


def glibc_of(path):
    """The newest GLIBC_x.y among its symbols."""
    versions = re.findall(r"GLIBC_(\d+)\.(\d+)", output("objdump", "-T", path))
    return max(((int(a), int(b)) for a, b in versions), default=(0, 0))


def copy_licences(libraries, folder):
    """The copyright files of the Debian packages that libraries came in."""
    folder.mkdir(parents=True, exist_ok=True)
    names = set()
    for library in libraries:
        path = str(library.resolve())
        names |= {path, path.removeprefix("/usr"), str(library)}
    found = subprocess.run(["dpkg-query", "-S", *sorted(names)], capture_output=True, text=True).stdout
    for package in {line.split(":")[0] for line in found.splitlines()}:
        copyright = pathlib.Path("/usr/share/doc") / package / "copyright"
        if copyright.exists():
            shutil.copyfile(copyright, folder / package)


def main():
    prefix = pathlib.Path(sys.argv[1])
    program = prefix / "bin" / "halflight"
    folder = prefix / "lib" / "halflight"
    folder.mkdir(parents=True, exist_ok=True)
    files = [program]
    libraries = libraries_of(program)
    for name, source in sorted(libraries.items()):
        target = folder / ("fallback" if SYSTEM_FIRST.match(name) else "") / name
        target.parent.mkdir(exist_ok=True)
        shutil.copyfile(source.resolve(), target)
        target.chmod(0o755)
        output("strip", "--strip-unneeded", target)
        output("patchelf", "--force-rpath", "--set-rpath", "$ORIGIN", target)
        files.append(target)
    copy_licences(libraries.values(), prefix / "share" / "doc" / "halflight" / "licences")
    # Searched in this order, for the libraries' own needs too.
    path = ["$ORIGIN/../lib/halflight", *SYSTEM_FOLDERS, "$ORIGIN/../lib/halflight/fallback"]
    output("patchelf", "--force-rpath", "--set-rpath", ":".join(path), program)
    newest = max(glibc_of(path) for path in files)
    print(f"{newest[0]}.{newest[1]}")


if __name__ == "__main__":
    main()
