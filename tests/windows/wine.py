"""The Windows program under Wine, for tests: build/windows/apps/halflight/halflight.exe, or what HALFLIGHT_EXE names."""

import contextlib
import os
import pathlib
import shutil
import stat
import subprocess
import sys
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/cli"))
import cli_case  # noqa: E402, F401  adds the rooms of tests/cli
from view_case import Display  # noqa: E402

CACHE = pathlib.Path(os.environ.get("HALFLIGHT_ROOTS", "/var/cache/halflight")) / "windows"
SKIPPED = 77
PATIENCE = 120  # seconds in which Wine starts, beside other programs

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


def has_desktop():
    for path in pathlib.Path("/proc").glob("[0-9]*/cmdline"):
        with contextlib.suppress(OSError):  # it has ended
            if b"explorer.exe" in path.read_bytes():
                return True
    return False


@contextlib.contextmanager
def running():
    """Wine's services and a virtual screen, which its Vulkan asks for, for all programs meanwhile. Each program would start
    services of its own otherwise, which takes longer than most of them, and would leave them its pipes."""
    if shutil.which("Xvfb") is None:
        skip("Xvfb is not installed (apt-get install xvfb)")
    display = Display()
    os.environ["DISPLAY"] = display.name
    nothing = subprocess.DEVNULL
    window = subprocess.Popen([WINE, "notepad"], env=environment(), stdin=nothing, stdout=nothing, stderr=nothing)
    try:
        end = time.monotonic() + PATIENCE
        while not has_desktop():
            assert window.poll() is None and time.monotonic() < end, "Wine starts no desktop"
            time.sleep(0.1)
        yield
    finally:
        window.terminate()
        window.wait()
        display.close()


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


def run_tests():
    """Runs the tests of the file that was started: FILE HALFLIGHT SHARED [unittest's own words]."""
    program()
    prepare()
    with running():
        unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=2)
