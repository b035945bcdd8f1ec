# SPDX-License-Identifier: GPL-3.0-or-later
"""The halflight program: where it is, which version, and its command line. Imports nothing of Blender."""

import collections
import ctypes
import functools
import glob
import importlib.util
import os
import platform
import shutil
import signal
import subprocess
import tempfile
import zipfile

NOT_FOUND = "The halflight program was not found: install the zip that has it, or its package, or name it in the preferences"
WHEELS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "wheels")
SYSTEMS = {"Linux": "manylinux", "Windows": "win", "Darwin": "macosx"}
MACHINES = {"AMD64": "amd64", "aarch64": "aarch64", "arm64": "arm64"}  # of wheels' names; others are as Python says

Found = collections.namedtuple("Found", "path where")


def find(preferred=""):
    """The program by preference, then that of the wheel, then that on PATH; None when there is none."""
    if preferred:
        path = os.path.abspath(os.path.expanduser(preferred))
        return Found(path, "from the preferences") if os.access(path, os.X_OK) else None
    path = of_wheel()
    if path:
        return Found(path, "from the wheel")
    path = shutil.which("halflight")
    return Found(path, "on PATH") if path else None


def of_wheel():
    """Blender 4.2 and newer install the wheel; for older ones it is unpacked beside itself, when it is first needed."""
    try:
        import halflight as module
    except ImportError:
        module = unpacked_wheel(WHEELS)
    executable = getattr(module, "executable", None)
    return executable() if executable else None


def unpacked_wheel(folder):
    """The module of the wheel for this system in `folder`; None where there is none, or it cannot be unpacked."""
    machine = MACHINES.get(platform.machine(), platform.machine())
    system = SYSTEMS.get(platform.system(), "?")
    wheels = [path for path in glob.glob(os.path.join(glob.escape(folder), "halflight-*.whl")) if fits(path, system, machine)]
    if not wheels:
        return None
    target = os.path.splitext(max(wheels))[0]
    module = os.path.join(target, "halflight", "_run.py")  # it imports nothing of the others
    try:
        if not os.path.exists(module):
            unpack(max(wheels), target)
        return module_at(module)
    except OSError as error:
        print(f"Halflight: {max(wheels)} cannot be unpacked ({error.strerror}): name the program in the preferences")
        return None


@functools.lru_cache(maxsize=1)
def module_at(path):
    specification = importlib.util.spec_from_file_location("halflight_of_wheel", path)
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def fits(path, system, machine):
    tag = os.path.basename(path).rsplit("-", 1)[-1]
    return tag.startswith(system) and tag.endswith(f"_{machine}.whl")


def unpack(wheel, target):
    """Whole or not at all: two Blenders may do it at once."""
    with tempfile.TemporaryDirectory(dir=os.path.dirname(target)) as temporary:
        whole = os.path.join(temporary, "wheel")
        with zipfile.ZipFile(wheel) as archive:
            archive.extractall(whole)
        try:
            os.rename(whole, target)
        except OSError:
            if not os.path.exists(target):
                raise


# No console flashes up on Windows.
HIDDEN = {"creationflags": getattr(subprocess, "CREATE_NO_WINDOW", 0)}


def cancel(process):
    """As Ctrl-C does: the program leaves nothing half-written; finished tiles stay in its cache. Windows has no such signal
    without a console; the program waits for an event instead."""
    if os.name == "posix":
        process.send_signal(signal.SIGINT)
        return
    kernel = ctypes.WinDLL("kernel32")
    kernel.OpenEventW.restype = ctypes.c_void_p
    may_set = 2  # EVENT_MODIFY_STATE
    event = kernel.OpenEventW(may_set, False, f"Local\\halflight-cancel-{process.pid}")
    if event:
        kernel.SetEvent(ctypes.c_void_p(event))
        kernel.CloseHandle(ctypes.c_void_p(event))
    else:  # it has not begun
        process.terminate()


def version(path):
    """Its first line of --version, or a sentence about why there is none."""
    try:
        return version_at(path, os.stat(path).st_mtime_ns)
    except OSError as error:
        return f"cannot be run ({error.strerror})"


@functools.lru_cache(maxsize=8)
def version_at(path, _changed):
    try:
        result = subprocess.run([path, "--version"], capture_output=True, text=True, timeout=20, **HIDDEN)
    except (OSError, subprocess.TimeoutExpired) as error:
        return f"cannot be run ({error})"
    lines = result.stdout.splitlines()
    return lines[0] if result.returncode == 0 and lines else "does not answer --version"


def bake_arguments(settings, files, only=()):
    """Arguments of `halflight bake`. `settings` has the members of properties.BakeSettings; 0 stands for automatic.
    `only`: names of nodes, when these alone are baked."""
    arguments = ["bake", files.scene, "-o", files.baked, "--cache", files.tiles, "--sidecar", files.sidecar]
    arguments += ["--report", files.report, "--progress", "lines"]
    arguments += ["--mode", settings.mode, "--quality", settings.quality, "--integrator", settings.integrator]
    arguments += ["--denoise", "on" if settings.denoise else "off"]
    arguments += ["--glossy-bounces", "on" if settings.glossy_bounces else "off"]
    arguments += ["--directional", "on" if settings.directional else "off"]
    arguments += ["--shadowmask-encoding", settings.shadowmask_encoding, "--probe-layout", settings.probe_layout]
    arguments += ["--two-sided", settings.two_sided, "--groups", settings.groups]
    arguments += ["--seed", str(settings.seed), "--threads", str(settings.threads), "--device", settings.device]
    given = (
        ("--texels-per-meter", settings.texels_per_meter),
        ("--lightmap-size", settings.lightmap_size),
        ("--samples", settings.samples),
        ("--shadow-samples", settings.shadow_samples),
        ("--noise", settings.noise),
        ("--probe-spacing", settings.probe_spacing),
    )
    for option, value in given:
        if value > 0:
            arguments += [option, f"{value:g}"]
    if settings.bounces >= 0:
        arguments += ["--bounces", str(settings.bounces)]
    return arguments + [f"--only={name}" for name in only]


# Share of a bake's time that each stage takes, about: for one bar over all of them.
STAGE_SHARES = {
    "measure": 0.01,
    "charts": 0.05,
    "pack": 0.02,
    "validity": 0.03,
    "bounces": 0.05,
    "lightmap": 0.50,
    "lights": 0.05,
    "denoise": 0.10,
    "shadowmask": 0.10,
    "probes": 0.07,
    "write": 0.02,
}


class Progress:
    """Follows the program's lines "progress: STAGE PERCENT %"."""

    def __init__(self):
        self.stage = "start"
        self.share = 0.0
        self.finished = set()

    def read(self, line):
        """True when `line` was one of progress."""
        words = line.split()
        if len(words) < 4 or words[0] != "progress:" or words[-1] != "%":
            return False
        stage, percent = " ".join(words[1:-2]), float(words[-2])
        if stage != self.stage:
            self.finished.add(self.stage)
        self.stage = stage
        before = sum(STAGE_SHARES.get(name, 0.0) for name in self.finished)
        self.share = min(1.0, before + STAGE_SHARES.get(stage, 0.0) * percent / 100.0)
        return True

    def text(self):
        return f"{self.stage} ({100.0 * self.share:.0f} %)"
