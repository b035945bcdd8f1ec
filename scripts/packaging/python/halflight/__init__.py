"""Halflight bakes lightmaps, shadowmasks and probes into glTF files.

    import halflight
    report = halflight.bake("scene.glb", "baked.glb", quality="preview", texels_per_meter=20)
    print(report.seconds, report.warnings)

`bake`, `render`, `info` and `optimize` run the program that this module brings along. help(halflight.bake) lists the
settings.
"""

import os
import subprocess
import sys

from ._commands import bake, info, optimize, render
from ._report_bake import BakeReport
from ._report_info import InfoReport
from ._report_optimize import OptimizeReport
from ._report_render import RenderReport
from ._run import Error, executable

__version__ = "@VERSION@"
__all__ = [
    "BakeReport",
    "Error",
    "InfoReport",
    "OptimizeReport",
    "RenderReport",
    "bake",
    "executable",
    "info",
    "optimize",
    "render",
]


def main() -> None:
    """The program itself, for the console script of the wheel."""
    path = executable()
    if os.name == "posix":
        os.execv(path, [path, *sys.argv[1:]])
    sys.exit(subprocess.run([path, *sys.argv[1:]]).returncode)
