#!/usr/bin/env python3
"""Runs a script of this folder in a headless Blender with a profile of its own.

    extension_test.py HALFLIGHT EXTENSION_FOLDER [SCRIPT [KEEP_FOLDER]]

SCRIPT is in_blender.py if not given; windows_in_blender.py runs in the windows of a virtual screen (Xvfb). Blender is
$HALFLIGHT_BLENDER, else the one on PATH. $HALFLIGHT_WHEEL is packed into the extension where it is set, and for
install_in_blender.py a wheel that starts HALFLIGHT. With KEEP_FOLDER, the pictures stay there.
"""

import os
import pathlib
import platform
import shlex
import shutil
import subprocess
import sys
import tempfile

SKIPPED = 77
WINDOWS, INSTALL = "windows_in_blender.py", "install_in_blender.py"
SCREEN = "-screen 0 640x420x24 +extension GLX"


def make_wheel(halflight, folder):
    """A wheel like that of scripts/package.sh, but its program starts the one of the build."""
    program = shlex.quote(str(pathlib.Path(halflight).resolve()))
    for name, started in (("bin/halflight", '"${0%/*}/../lib/halflight/halflight"'), ("lib/halflight/halflight", program)):
        path = folder / "prefix" / name
        path.parent.mkdir(parents=True)
        path.write_text(f'#!/bin/sh\nexec {started} "$@"\n')
    notices = folder / "prefix/share/doc/halflight/copyright"
    notices.parent.mkdir(parents=True)
    notices.write_text("as installed")
    script = pathlib.Path(__file__).resolve().parents[2] / "scripts/packaging/make_wheel.py"
    command = [sys.executable, script, folder / "prefix", "0.1.0", f"manylinux_2_17_{platform.machine()}", folder]
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout.strip()


def main():
    halflight, extension = sys.argv[1:3]
    blender = os.environ.get("HALFLIGHT_BLENDER") or shutil.which("blender")
    if blender is None:
        print("skipped: there is no Blender on PATH (apt-get install blender), and HALFLIGHT_BLENDER names none")
        return SKIPPED
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(sys.argv[4] if len(sys.argv) > 4 else temporary).resolve()
        folder.mkdir(parents=True, exist_ok=True)
        package = folder / "halflight.zip"
        script = pathlib.Path(__file__).with_name(sys.argv[3] if len(sys.argv) > 3 else "in_blender.py")
        wheel = os.environ.get("HALFLIGHT_WHEEL")
        if wheel is None and script.name == INSTALL:
            wheel = make_wheel(halflight, pathlib.Path(temporary))
        options = ["--wheel", wheel] if wheel else []
        subprocess.run([sys.executable, f"{extension}/make_zip.py", package, *options], check=True)
        environment = dict(os.environ, BLENDER_USER_RESOURCES=temporary, BLENDER_USER_CONFIG=f"{temporary}/config")
        environment.update(BLENDER_USER_SCRIPTS=f"{temporary}/scripts", BLENDER_USER_DATAFILES=f"{temporary}/data")
        # Debian's Blender takes the first python3 on PATH for its own, which another one (pyenv) may be.
        environment["PATH"] = f"{pathlib.Path(blender).resolve().parent}:{environment['PATH']}"
        if script.name == INSTALL:
            environment["HALFLIGHT_WHEEL"] = wheel
        command = [blender, "-b"]
        if script.name == WINDOWS:
            if shutil.which("xvfb-run") is None:
                print("skipped: there is no virtual screen (apt-get install xvfb xauth)")
                return SKIPPED
            command = ["xvfb-run", "-a", "-s", SCREEN, blender, "--no-window-focus", "--enable-event-simulate"]
        command += ["--factory-startup", "--python-exit-code", "1", "--python", str(script), "--"]
        result = subprocess.run([*command, halflight, str(package), str(folder)], env=environment)
        return result.returncode


if __name__ == "__main__":
    sys.exit(main())
