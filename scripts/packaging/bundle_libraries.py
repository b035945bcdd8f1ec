#!/usr/bin/env python3
"""Makes an installed program relocatable: copies the shared libraries it needs beside it, the C library included.

    bundle_libraries.py PREFIX [MACHINE ROOT EMULATOR]

PREFIX/bin/halflight becomes a launcher (launcher.sh), the program goes to PREFIX/lib/halflight, its libraries beside it and
their licences to PREFIX/share/doc. The launcher uses the system's glibc where it is as new as the files ask for, and else
the one in lib/halflight/glibc. The Vulkan loader is the system's; it is opened at run time, if at all. With the system's
glibc, libstdc++ is the system's too where it has one: a Vulkan driver of a newer system needs the newer one, and a process
has one only. Needs patchelf. Prints the newest version of glibc that a file asks for.

The last three are of a program for another machine: aarch64, the folder with that system's libraries and dpkg's database
(scripts/arm64/sysroot.sh), and the program that runs its programs.
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


def output(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


class Target:
    """The system that the program is for: this one, or one whose files are in a folder."""

    def __init__(self, machine="", root="/", emulator=""):
        self.root = pathlib.Path(root).resolve()
        self.run = [emulator, "-L", root] if emulator else []
        self.tools = f"{machine}-linux-gnu-" if machine else ""
        multiarch = f"{machine or platform.machine()}-linux-gnu"
        self.folders = [f"/usr/lib/{multiarch}", f"/lib/{multiarch}", "/usr/lib64", "/lib64", "/usr/lib", "/lib"]
        self.database = f"--admindir={self.path('/var/lib/dpkg')}"

    def path(self, name):
        """Of a file that the target's own programs call so."""
        return self.root / str(name).lstrip("/")

    def all_libraries(self, program):
        """Name and place of all that the loader finds for it, directly and indirectly."""
        # What ldd does, by the loader that the program asks for.
        said = output(*self.run, self.path(loader_of(program)), "--list", program)
        found = dict(re.findall(r"^\s*([^\s/]+) => (\S+)", said, re.MULTILINE))  # the loader itself has a "/"
        missing = [name for name, place in found.items() if not place.startswith("/")]
        if missing:
            raise SystemExit(f"bundle_libraries.py: {missing[0]} was not found")
        return {name: self.path(place) for name, place in found.items()}


def loader_of(program):
    return output("patchelf", "--print-interpreter", program).strip()


def glibc_of(path, target):
    """The newest GLIBC_x.y among its symbols."""
    versions = re.findall(r"GLIBC_(\d+)\.(\d+)", output(target.tools + "objdump", "-T", path))
    return max(((int(a), int(b)) for a, b in versions), default=(0, 0))


def copy_glibc(loader, libc, target, folder):
    """The target's loader and C library, byte for byte. Gives the files."""
    said = subprocess.run([*target.run, loader, "--version"], capture_output=True, text=True).stdout
    version = re.search(r"release version (\d+)\.(\d+)", said)
    if not version or (int(version[1]), int(version[2])) < ARGV0_SINCE:
        raise SystemExit("bundle_libraries.py: this system's glibc cannot be carried along; those from 2.33 on can")
    files = [loader, *(path for name in GLIBC if (path := libc.with_name(name)).exists())]
    folder.mkdir(exist_ok=True)
    for path in files:
        shutil.copyfile(path.resolve(), folder / path.name)
        (folder / path.name).chmod(0o755)
    return files


def write_launcher(path, loader, needed):
    text = (HERE / "launcher.sh").read_text()
    words = {"LOADER": loader, "LOADER_NAME": pathlib.Path(loader).name, "MAJOR": needed[0], "MINOR": needed[1]}
    path.write_text(re.sub(r"@(\w+)@", lambda match: str(words[match[1]]), text))
    path.chmod(0o755)


def source_address(package, target):
    """Where the distribution keeps the source of the version that is installed."""
    form = "${source:Package} ${source:Version}\n"
    source, version = output("dpkg-query", target.database, "-W", "-f", form, package).split()[:2]
    ubuntu = "ID=ubuntu" in target.path("/etc/os-release").read_text().split()
    folder = "https://launchpad.net/ubuntu/+source" if ubuntu else "https://snapshot.debian.org/package"
    return f"{folder}/{source}/{version}"


def copy_licences(libraries, target, folder):
    """The copyright files of the Debian packages that libraries came in, the licences that these name, and where their
    sources are."""
    folder.mkdir(parents=True, exist_ok=True)
    names = set()
    for library in libraries:
        for name in (library.resolve(), library):
            path = f"/{name.relative_to(target.root)}"
            names |= {path, path.removeprefix("/usr")}
    query = ["dpkg-query", target.database, "-S", *sorted(names)]
    found = subprocess.run(query, capture_output=True, text=True).stdout
    sources, licences = set(), set()
    for package in {line.split(":")[0] for line in found.splitlines()}:
        copyright = target.path(f"/usr/share/doc/{package}/copyright")
        if not copyright.exists():
            continue
        shutil.copyfile(copyright, folder / package)
        licences |= set(re.findall(r"/usr/share/common-licenses/([\w.-]*\w)", copyright.read_text(errors="replace")))
        sources.add(f"{package}: {source_address(package, target)}\n")
    for name in licences:
        licence = target.path(f"/usr/share/common-licenses/{name}")
        if licence.exists():
            shutil.copyfile(licence, folder / name)
    (folder / "SOURCES").write_text("Sources of the libraries in lib/halflight, unchanged:\n" + "".join(sorted(sources)))


def main():
    prefix, target = pathlib.Path(sys.argv[1]), Target(*sys.argv[2:])
    launcher = prefix / "bin" / "halflight"
    folder = prefix / "lib" / "halflight"
    folder.mkdir(parents=True, exist_ok=True)
    program = folder / "halflight"
    launcher.rename(program)
    files = [program]
    loader = loader_of(program)
    found = target.all_libraries(program)
    libraries = {name: path for name, path in found.items() if not OF_THE_SYSTEM.match(name)}
    for name, source in sorted(libraries.items()):
        copy = folder / ("fallback" if SYSTEM_FIRST.match(name) else "") / name
        copy.parent.mkdir(exist_ok=True)
        shutil.copyfile(source.resolve(), copy)
        copy.chmod(0o755)
        output(target.tools + "strip", "--strip-unneeded", copy)
        output("patchelf", "--force-rpath", "--set-rpath", "$ORIGIN", copy)
        files.append(copy)
    glibc = copy_glibc(target.path(loader), found["libc.so.6"], target, folder / "glibc")
    copy_licences([*libraries.values(), *glibc], target, prefix / "share" / "doc" / "halflight" / "licences")
    # Searched in this order, for the libraries' own needs too.
    output("patchelf", "--force-rpath", "--set-rpath", ":".join(["$ORIGIN", *target.folders, "$ORIGIN/fallback"]), program)
    needed = max(glibc_of(path, target) for path in files)
    write_launcher(launcher, loader, needed)
    print(f"{needed[0]}.{needed[1]}")


if __name__ == "__main__":
    main()
