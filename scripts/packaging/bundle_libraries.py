#!/usr/bin/env python3
"""Makes an installed program relocatable: copies the shared libraries it needs beside it, the C library included.

    bundle_libraries.py PREFIX

PREFIX/bin/halflight becomes a launcher (launcher.sh), the program goes to PREFIX/lib/halflight, its libraries beside it and
their licences to PREFIX/share/doc. The launcher uses the system's glibc where it is as new as the files ask for, and else
the one in lib/halflight/glibc. The Vulkan loader is the system's; it is opened at run time, if at all. With the system's
glibc, libstdc++ is the system's too where it has one: a Vulkan driver of a newer system needs the newer one, and a process
has one only. Needs patchelf. Prints the newest version of glibc that a file asks for.
"""

import pathlib
import platform
import re
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
OF_THE_SYSTEM = re.compile(r"^(ld-linux.*|linux-vdso|lib(c|m|dl|rt|pthread|resolv|util|mvec|anl|vulkan))\.so")

# What the bundled files, or libraries and Vulkan drivers of an older system, may ask of glibc. All are of one version.
GLIBC = ["libc.so.6", "libm.so.6", "libmvec.so.1", "libpthread.so.0", "libdl.so.2", "librt.so.1", "libutil.so.1",
         "libresolv.so.2", "libanl.so.1"]  # fmt: skip
ARGV0_SINCE = (2, 33)  # the loader's --argv0

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


def copy_glibc(program, folder):
    """The build host's loader and C library, byte for byte. Gives the files."""
    loader = pathlib.Path(output("patchelf", "--print-interpreter", program).strip())
    version = tuple(int(part) for part in output("getconf", "GNU_LIBC_VERSION").split()[1].split(".")[:2])
    if version < ARGV0_SINCE:
        raise SystemExit(f"bundle_libraries.py: this host's glibc {version[0]}.{version[1]} cannot be carried along; 2.33 can")
    libc = pathlib.Path(re.search(r"libc\.so\.6 => (\S+)", output("ldd", program))[1])
    files = [loader, *(path for name in GLIBC if (path := libc.with_name(name)).exists())]
    folder.mkdir(exist_ok=True)
    for path in files:
        shutil.copyfile(path.resolve(), folder / path.name)
        (folder / path.name).chmod(0o755)
    return files


def write_launcher(path, loader, needed):
    text = (HERE / "launcher.sh").read_text()
    words = {"LOADER": loader, "LOADER_NAME": loader.name, "MAJOR": needed[0], "MINOR": needed[1]}
    path.write_text(re.sub(r"@(\w+)@", lambda match: str(words[match[1]]), text))
    path.chmod(0o755)


def source_address(package):
    """Where the distribution keeps the source of the version that is installed."""
    source, version = output("dpkg-query", "-W", "-f", "${source:Package} ${source:Version}\n", package).split()[:2]
    ubuntu = "ID=ubuntu" in pathlib.Path("/etc/os-release").read_text().split()
    folder = "https://launchpad.net/ubuntu/+source" if ubuntu else "https://snapshot.debian.org/package"
    return f"{folder}/{source}/{version}"


def copy_licences(libraries, folder):
    """The copyright files of the Debian packages that libraries came in, the licences that these name, and where their
    sources are."""
    folder.mkdir(parents=True, exist_ok=True)
    names = set()
    for library in libraries:
        path = str(library.resolve())
        names |= {path, path.removeprefix("/usr"), str(library)}
    found = subprocess.run(["dpkg-query", "-S", *sorted(names)], capture_output=True, text=True).stdout
    sources, licences = set(), set()
    for package in {line.split(":")[0] for line in found.splitlines()}:
        copyright = pathlib.Path("/usr/share/doc") / package / "copyright"
        if not copyright.exists():
            continue
        shutil.copyfile(copyright, folder / package)
        licences |= set(re.findall(r"/usr/share/common-licenses/([\w.-]*\w)", copyright.read_text(errors="replace")))
        sources.add(f"{package}: {source_address(package)}\n")
    for name in licences:
        licence = pathlib.Path("/usr/share/common-licenses") / name
        if licence.exists():
            shutil.copyfile(licence, folder / name)
    (folder / "SOURCES").write_text("Sources of the libraries in lib/halflight, unchanged:\n" + "".join(sorted(sources)))


def main():
    prefix = pathlib.Path(sys.argv[1])
    launcher = prefix / "bin" / "halflight"
    folder = prefix / "lib" / "halflight"
    folder.mkdir(parents=True, exist_ok=True)
    program = folder / "halflight"
    launcher.rename(program)
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
    glibc = copy_glibc(program, folder / "glibc")
    copy_licences([*libraries.values(), *glibc], prefix / "share" / "doc" / "halflight" / "licences")
    # Searched in this order, for the libraries' own needs too.
    output("patchelf", "--force-rpath", "--set-rpath", ":".join(["$ORIGIN", *SYSTEM_FOLDERS, "$ORIGIN/fallback"]), program)
    needed = max(glibc_of(path) for path in files)
    write_launcher(launcher, glibc[0], needed)
    print(f"{needed[0]}.{needed[1]}")


if __name__ == "__main__":
    main()
