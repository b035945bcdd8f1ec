"""Halflight bakes lightmaps, shadowmasks and probes into glTF files.

    import halflight
    report = halflight.bake("scene.glb", "baked.glb", quality="preview", texels_per_meter=20)

This module runs the program that it brings along; `halflight bake --help` lists the settings.
"""

import json
import os
import pathlib
import stat
import subprocess
import sys

__version__ = "@VERSION@"

_SWITCHES = {"moz_lightmap"}  # options without a value; other booleans are on|off


class Error(RuntimeError):
    """What the program said. `code` is its exit code: 1 failed, 2 wrong usage."""

    def __init__(self, message, code):
        super().__init__(message)
        self.code = code


def executable():
    """Path of the program."""
    folder = pathlib.Path(__file__).with_name("program")
    path = folder / "bin" / ("halflight.exe" if os.name == "nt" else "halflight")
    if os.name == "posix":
        # Some installers of wheels, Blender's among them, lose the right to run files: the launcher, the program, the loader.
        for file in (path, folder / "lib/halflight/halflight", *folder.glob("lib/halflight/glibc/ld-*")):
            if not os.access(file, os.X_OK):
                file.chmod(file.stat().st_mode | stat.S_IXUSR | stat.S_IXGRP | stat.S_IXOTH)
    return str(path)


def arguments(settings):
    """Settings as options: texels_per_meter=20 is --texels-per-meter 20. None and False switches are left out."""
    words = []
    for key, value in settings.items():
        option = "--" + key.replace("_", "-")
        if value is None or key in _SWITCHES and not value:
            continue
        if key in _SWITCHES:
            words.append(option)
            continue
        if isinstance(value, bool):
            value = "on" if value else "off"
        elif isinstance(value, (list, tuple)):
            value = ",".join(str(part) for part in value)
        words += [option, str(value)]
    return words


def bake(path, output=None, **settings):
    """Bakes the scene at `path` into `output` (default: NAME-baked.glb beside it). Returns the report, a dictionary with
    the output's path as "output". Raises Error with the program's sentence where it fails."""
    source = pathlib.Path(path)
    output = pathlib.Path(output) if output else source.with_name(source.stem + "-baked.glb")
    command = [executable(), "bake", str(source), "-o", str(output), *arguments(settings), "--json", "--quiet"]
    result = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, encoding="utf-8")
    if result.returncode != 0:
        raise Error(result.stderr.strip().replace("halflight: ", "", 1), result.returncode)
    report = json.loads(result.stdout)
    report["output"] = str(output)
    return report


def main():
    """The program itself, for the console script of the wheel."""
    path = executable()
    if os.name == "posix":
        os.execv(path, [path, *sys.argv[1:]])
    sys.exit(subprocess.run([path, *sys.argv[1:]]).returncode)
