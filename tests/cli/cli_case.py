"""What the end-to-end tests of the halflight program have in common."""

import json
import os
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

import tiny_scene

FOLDER = os.path.dirname(os.path.abspath(__file__))
# Tests and helpers are in rooms by topic, and import one another by name.
sys.path += sorted(entry.path for entry in os.scandir(FOLDER) if entry.is_dir() and not entry.name.startswith("_"))

HALFLIGHT = ""
SHARED = ""
QUICK = ["--quality", "preview", "--samples", "4", "--shadow-samples", "2", "--bounces", "1", "--lightmap-size", "128"]


def run(*arguments, timeout=240):
    return subprocess.run(
        [HALFLIGHT, *map(str, arguments)], capture_output=True, text=True, timeout=timeout, stdin=subprocess.DEVNULL
    )


def read(path):
    with open(path, "rb") as file:
        return file.read()


def decode_png(path):
    """Width, height and rows of RGBA bytes of an 8-bit RGBA PNG (the PNG specification, section 9: filters)."""
    data = read(path)
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed, header = 8, b"", None
    while at < len(data):
        (length,) = struct.unpack(">I", data[at : at + 4])
        kind, body = data[at + 4 : at + 8], data[at + 8 : at + 8 + length]
        header = struct.unpack(">IIBBBBB", body) if kind == b"IHDR" else header
        packed += body if kind == b"IDAT" else b""
        at += 12 + length
    width, height, depth, color = header[:4]
    channels = {2: 3, 6: 4}[color]
    assert depth == 8
    raw, rows, previous = zlib.decompress(packed), [], bytearray(width * channels)
    for y in range(height):
        begin = y * (width * channels + 1)
        kind, row = raw[begin], bytearray(raw[begin + 1 : begin + 1 + width * channels])
        for i in range(len(row)):
            a = row[i - channels] if i >= channels else 0
            b = previous[i]
            c = previous[i - channels] if i >= channels else 0
            nearest = min((a, b, c), key=lambda value: abs(a + b - c - value))
            row[i] = (row[i] + (0, a, b, (a + b) // 2, nearest)[kind]) & 255
        rows.append([tuple(row[i : i + 3]) for i in range(0, len(row), channels)])
        previous = row
    return width, height, rows


def edited(source, target, change):
    """A copy of a GLB whose JSON went through `change`."""
    data = read(source)
    (length,) = struct.unpack("<I", data[12:16])
    document = json.loads(data[20 : 20 + length])
    change(document)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + length :]
    with open(target, "wb") as file:
        file.write(b"glTF" + struct.pack("<II", 2, 20 + len(text) + len(rest)))
        file.write(struct.pack("<I", len(text)) + b"JSON" + text + rest)
    return target


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def scene(self, **arguments):
        path = self.path("tiny.gltf")
        tiny_scene.write(path, **arguments)
        return path

    def bake(self, scene, name, *arguments, effort=QUICK):
        """Bakes in seconds; returns the file and the report."""
        output = self.path(name)
        result = run("bake", scene, "-o", output, *effort, "--json", *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        return output, json.loads(result.stdout)

    def rendered(self, baked, *options):
        """Summary and standard error of a small picture."""
        picture = self.path("picture.exr")
        result = run("render", baked, "-o", picture, "--size", "32x24", "--json", *options)
        self.assertEqual(result.returncode, 0, result.stderr)
        return json.loads(result.stdout), result.stderr

    def assert_one_sentence(self, result, code, *words):
        self.assertEqual(result.returncode, code, result.stderr)
        lines = result.stderr.splitlines()
        self.assertEqual(len(lines), 1, result.stderr)
        self.assertTrue(lines[0].startswith("halflight: "), lines[0])
        for word in words:
            self.assertIn(word, lines[0])
        self.assertEqual(result.stdout, "")

    def assert_folder_holds(self, *names):
        self.assertEqual(sorted(os.listdir(self.folder.name)), sorted(names))


def main():
    """Runs the tests of the calling program; exits with 77 (ctest: skipped) when all that ran were skipped."""
    global HALFLIGHT, SHARED
    HALFLIGHT, SHARED = sys.argv[1:3]
    program = unittest.main(argv=sys.argv[:1] + sys.argv[3:], exit=False, verbosity=1)
    outcome = program.result
    for test, reason in outcome.skipped:
        print(f"[  SKIPPED ] {test.id()}: {reason}")
    if outcome.wasSuccessful() and outcome.testsRun == len(outcome.skipped):
        sys.exit(77)
    sys.exit(0 if outcome.wasSuccessful() else 1)
