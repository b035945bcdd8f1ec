#!/usr/bin/env python3
"""Bakes a tiny scene in the example's window, on a virtual display, and as `halflight bake` does: the files are the same.
run_window.py HALFLIGHT BAKE_WINDOW FOLDER_OF_TINY_SCENE; exit 77 (skipped) without Xvfb."""

import os
import shutil
import subprocess
import sys
import tempfile

halflight, bake_window, tests = sys.argv[1:]
sys.path.insert(0, tests)
import tiny_scene  # noqa: E402

if shutil.which("Xvfb") is None:
    print("needs Xvfb")
    sys.exit(77)

with tempfile.TemporaryDirectory() as folder:
    scene, baked, plain = (os.path.join(folder, name) for name in ("tiny.gltf", "window.glb", "plain.glb"))
    tiny_scene.write(scene)
    read_end, write_end = os.pipe()
    display = subprocess.Popen(["Xvfb", "-displayfd", str(write_end), "-screen", "0", "800x600x24", "-nolisten", "tcp"],
                               pass_fds=[write_end], stderr=subprocess.DEVNULL)
    try:
        os.close(write_end)
        with os.fdopen(read_end) as file:
            environment = dict(os.environ, DISPLAY=":" + file.readline().strip(), SDL_VIDEODRIVER="x11")
        said = subprocess.run([bake_window, scene, baked, "once"], env=environment, capture_output=True, text=True, timeout=250)
        absent = subprocess.run([bake_window, os.path.join(folder, "absent.glb"), baked, "once"], env=environment,
                                capture_output=True, text=True, timeout=60)
    finally:
        display.terminate()
        display.wait()
    if said.returncode != 0 or said.stderr:
        sys.exit("the window failed: " + said.stdout + said.stderr)
    if absent.returncode != 1 or not absent.stderr.startswith("bake_window: "):
        sys.exit("an absent file should fail: " + absent.stderr)
    subprocess.run([halflight, "bake", scene, "-o", plain, "--quality", "preview", "--lightmap-size", "128", "-q"], check=True)
    with open(baked, "rb") as one, open(plain, "rb") as other:
        if one.read() != other.read():
            sys.exit("the window's file is not that of halflight bake")
    print("the same file")
