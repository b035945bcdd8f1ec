#!/usr/bin/env python3
"""Bakes a tiny scene and runs the example on it: run_example.py HALFLIGHT RENDER_IMAGE FOLDER_OF_TINY_SCENE"""

import os
import subprocess
import sys
import tempfile

halflight, render_image, tests = sys.argv[1:]
sys.path.insert(0, tests)
import tiny_scene  # noqa: E402

with tempfile.TemporaryDirectory() as folder:
    scene, baked = os.path.join(folder, "tiny.gltf"), os.path.join(folder, "tiny.glb")
    tiny_scene.write(scene)
    subprocess.run([halflight, "bake", scene, "-o", baked, "--quality", "preview", "--lightmap-size", "128", "-q"], check=True)
    for path, targets in (("forward", 0), ("deferred", 5)):
        picture = os.path.join(folder, path + ".png")
        said = subprocess.run([render_image, baked, picture, path], check=True, capture_output=True, text=True)
        print(said.stdout, end="")
        if "targets %d\n" % targets not in said.stdout or "2 lights" not in said.stdout or said.stderr:
            sys.exit("not what the scene has: " + said.stdout + said.stderr)
        with open(picture, "rb") as file:
            if file.read(8) != b"\x89PNG\r\n\x1a\n" or os.path.getsize(picture) < 10000:
                sys.exit("no picture in " + picture)
    if subprocess.run([render_image, os.path.join(folder, "absent.glb"), picture], capture_output=True).returncode != 1:
        sys.exit("an absent file should fail")
