"""Ctrl-C at random moments. Usage: interrupt_test.py HALFLIGHT SHARED_DIR [TestClass[.test]] …

Whatever a run is doing, it ends soon, with an exit code that is not 0, and leaves no file. Moments and "soon" are shares
of what the whole run takes on this machine: soon is a fifth of its processor time, so that other programs do not count. Exits with
77 (ctest: skipped) when every test that ran was skipped."""

import json
import math
import os
import random
import resource
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest

HALFLIGHT = ""
SHARED = ""
MOST_SHARE = 0.2  # of the whole run's processor time, after the signal


def cpu_seconds(pid):
    """Of a process that runs, all of its threads."""
    with open(f"/proc/{pid}/stat") as file:
        fields = file.read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def write_terrain(path, n=250):
    """A floor of n x n bumpy quads in one mesh: seconds of charts, flattening and packing."""
    positions, normals, indices = [], [], []
    for j in range(n + 1):
        for i in range(n + 1):
            x, z = 40.0 * i / n - 20.0, 40.0 * j / n - 20.0
            height = math.sin(1.7 * x) * math.cos(1.3 * z) + 0.3 * math.sin(5.1 * x + 3.7 * z)
            positions.append((x, height, z))
            normals.append((0.0, 1.0, 0.0))
    for j in range(n):
        for i in range(n):
            a = j * (n + 1) + i
            indices += [a, a + n + 1, a + 1, a + 1, a + n + 1, a + n + 2]
    parts = [
        b"".join(struct.pack("<3f", *p) for p in positions),
        b"".join(struct.pack("<3f", *p) for p in normals),
        struct.pack("<%dI" % len(indices), *indices),
    ]
    views, at = [], 0
    for part in parts:
        views.append({"buffer": 0, "byteOffset": at, "byteLength": len(part)})
        at += len(part)
    low = [min(p[k] for p in positions) for k in range(3)]
    high = [max(p[k] for p in positions) for k in range(3)]
    document = {
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": 3.0}]}},
        "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [
            {"name": "terrain", "mesh": 0},
            {"name": "sun", "rotation": [-0.5, 0.2, 0.1, 0.83], "extensions": {"KHR_lights_punctual": {"light": 0}}},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2}]}],
        "accessors": [
            {
                "bufferView": 0, "componentType": 5126, "count": len(positions), "type": "VEC3",
                "min": low, "max": high,
            },
            {"bufferView": 1, "componentType": 5126, "count": len(positions), "type": "VEC3"},
            {"bufferView": 2, "componentType": 5125, "count": len(indices), "type": "SCALAR"},
        ],
        "bufferViews": views,
        "buffers": [{"byteLength": at}],
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    data = b"".join(parts)
    with open(path, "wb") as file:
        file.write(struct.pack("<4sIII4s", b"glTF", 2, 28 + len(text) + len(data), len(text), b"JSON") + text)
        file.write(struct.pack("<I4s", len(data), b"BIN\0") + data)


class Moments(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.random = random.Random(7)

    def run_whole(self, output, *arguments):
        """Its processor time."""
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([HALFLIGHT, *arguments, "-o", output], check=True, capture_output=True, stdin=subprocess.DEVNULL)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        os.remove(output)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    def interrupt_at(self, seconds, whole, output, *arguments):
        """After so much processor time. Returns whether the run had ended by itself."""
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        process = subprocess.Popen(
            [HALFLIGHT, *arguments, "-o", output],
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, stdin=subprocess.DEVNULL,
        )
        while process.poll() is None and cpu_seconds(process.pid) < seconds:
            time.sleep(0.01)
        if process.poll() is not None:
            self.assertEqual(process.returncode, 0, process.communicate()[1])
            os.remove(output)
            return True
        sent = cpu_seconds(process.pid)
        process.send_signal(signal.SIGINT)
        _, messages = process.communicate()
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        took = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime - sent
        where = "interrupted at %.2f of %.2f s: %s" % (seconds, whole, messages.decode(errors="replace")[-300:])
        self.assertLess(took, MOST_SHARE * whole + 0.1, where)
        if process.returncode == 0:  # the output was about to take its name
            self.assertTrue(os.path.exists(output), where)
            os.remove(output)
            return True
        # Before the program listens, the signal itself ends it.
        self.assertIn(process.returncode, (1, -signal.SIGINT), where)
        self.assertFalse(os.path.exists(output), where)
        left = [name for name in os.listdir(self.folder.name) if ".tmp" in name]
        self.assertEqual(left, [], where)
        return False

    def interrupt_at_moments(self, count, *arguments):
        output = os.path.join(self.folder.name, "out" + (".png" if arguments[0] == "render" else ".glb"))
        whole = self.run_whole(output, *arguments)
        interrupted = 0
        for i in range(count):
            moment = 0.98 * whole * (i + self.random.random()) / count
            if self.interrupt_at(moment, whole, output, *arguments):
                break
            interrupted += 1
        self.assertGreater(interrupted, 2)

    def test_bake_of_a_terrain(self):
        scene = os.path.join(self.folder.name, "terrain.glb")
        write_terrain(scene)
        self.interrupt_at_moments(9, "bake", scene, "--quality", "preview", "--lightmap-size", "512")

    def test_bake_while_a_driver_compiles(self):
        """The program ends while threads of the driver are at work."""
        version = subprocess.run([HALFLIGHT, "--version"], capture_output=True, text=True, check=True).stdout
        if "llvmpipe" not in version:
            self.skipTest("no Vulkan driver for the CPU that bakes")
        scene = os.path.join(self.folder.name, "terrain.glb")
        output = os.path.join(self.folder.name, "out.glb")
        write_terrain(scene, 20)
        arguments = [HALFLIGHT, "bake", scene, "-o", output, "--lightmap-size", "64", "--device", "gpu:llvmpipe"]
        for moment in (0.2, 0.4, 0.8, 1.6):  # processor time; all shaders take ten seconds
            process = subprocess.Popen(
                arguments, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, stdin=subprocess.DEVNULL,
                env={**os.environ, "MESA_SHADER_CACHE_DISABLE": "true"},
            )
            while process.poll() is None and cpu_seconds(process.pid) < moment:
                time.sleep(0.01)
            process.send_signal(signal.SIGINT)
            _, messages = process.communicate()
            self.assertIn(process.returncode, (1, -signal.SIGINT), messages.decode(errors="replace")[-300:])
            self.assertFalse(os.path.exists(output))

    def test_reference_of_a_terrain(self):
        scene = os.path.join(self.folder.name, "terrain.glb")
        write_terrain(scene)
        self.interrupt_at_moments(4, "render", scene, "--reference", "16", "--size", "320x180")

    def test_bake_of_sponza(self):
        scene = os.path.join(SHARED, "scenes", "sponza_crytek.glb")
        if not os.path.exists(scene):
            self.skipTest("no shared scenes beside this checkout")
        self.interrupt_at_moments(5, "bake", scene, "--quality", "preview")


if __name__ == "__main__":
    HALFLIGHT, SHARED = sys.argv[1:3]
    program = unittest.main(argv=sys.argv[:1] + sys.argv[3:], exit=False, verbosity=1)
    outcome = program.result
    skipped = outcome.testsRun > 0 and len(outcome.skipped) == outcome.testsRun
    sys.exit(77 if outcome.wasSuccessful() and skipped else 0 if outcome.wasSuccessful() else 1)
