"""The Windows program under Wine, for tests: build/windows/apps/halflight/halflight.exe, or what HALFLIGHT_EXE names."""

import os
import pathlib
import shutil
import stat
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
CACHE = pathlib.Path(os.environ.get("HALFLIGHT_ROOTS", "/var/cache/halflight")) / "windows"
SKIPPED = 77

# Debian's `wine` is a script that complains of a missing 32-bit Wine.
WINE = next((path for path in ("/usr/lib/wine/wine64", shutil.which("wine64"), shutil.which("wine")) if path and os.path.exists(path)), None)


def skip(sentence):
    print("skipped: " + sentence)
    sys.exit(SKIPPED)


def program():
    exe = pathlib.Path(os.environ.get("HALFLIGHT_EXE", ROOT / "build/windows/apps/halflight/halflight.exe"))
    if WINE is None:
        skip("Wine is not installed (apt-get install wine64)")
    if not exe.exists():
        skip(f"there is no {exe}; scripts/build-windows.sh --program builds it")
    return exe


def environment():
    """Of programs under Wine: in a Windows of their own, without its dialogs and Mono."""
    found = dict(os.environ, WINEPREFIX=str(CACHE / "wine"), WINEDEBUG="-all")
    found["WINEDLLOVERRIDES"] = "mscoree=;mshtml=;winedbg.exe=;winemenubuilder.exe="
    return found


def prepare():
    prefix = CACHE / "wine"
    if (prefix / "windows10").exists():
        return
    prefix.mkdir(parents=True, exist_ok=True)
    # Debian's is a Windows 7, for which the program is not. Wine's server keeps pipes open.
    for words in (["wineboot", "-i"], ["winecfg", "/v", "win10"]):
        subprocess.run([WINE, *words], env=environment(), check=True, timeout=300, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    (prefix / "windows10").touch()


def wrapper(folder):
    """A script that stands for the program: tests of the Linux program run it as theirs."""
    path = pathlib.Path(folder) / "halflight"
    words = " ".join(f"{name}='{environment()[name]}'" for name in ("WINEPREFIX", "WINEDEBUG", "WINEDLLOVERRIDES"))
    path.write_text(f'#!/bin/sh\nexport {words}\nexec {WINE} "{program()}" "$@"\n')
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return str(path)


def build_helper(folder):
    """helper.cpp: what other programs of Windows do to this one."""
    compiler = shutil.which("x86_64-w64-mingw32-g++-posix")
    if compiler is None:
        skip("MinGW is not installed (apt-get install g++-mingw-w64-x86-64-posix)")
    exe = os.path.join(folder, "helper.exe")
    source = str(pathlib.Path(__file__).with_name("helper.cpp"))
    subprocess.run([compiler, "-std=c++20", "-O1", "-static", "-municode", "-o", exe, source], check=True)
    return exe
