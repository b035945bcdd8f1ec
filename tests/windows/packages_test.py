"""What scripts/build-windows.sh packs: zip, wheel and Blender's extension. Usage: packages_test.py HALFLIGHT SHARED_DIR

The programs out of zip and wheel run under Wine. HALFLIGHT is the Linux program."""

import base64
import csv
import hashlib
import io
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
import unittest
import zipfile

import wine  # finds what is in tests/cli
import tiny_scene
from wine_test import QUICK, run

HALFLIGHT = ""
# Which licence is whose: of each library that is linked, by the beginning of its file's name.
LICENCES = {
    "embree": "embree", "lexers": "embree", "math": "embree", "simd": "embree", "sys": "embree", "tasking": "embree",
    "tbb": "onetbb", "Iex": "openexr", "IlmThread": "openexr", "OpenEXR": "openexr", "Imath": "imath", "draco": "draco",
    "meshoptimizer": "meshoptimizer", "webp": "libwebp", "png": "libpng1.6", "z": "zlib", "zstd": "libzstd",
    "xxhash": "xxhash", "fmt": "fmtlib", "spdlog": "spdlog",
}  # fmt: skip
# Those of headers, of the compiler's libraries and of Windows' own functions.
OTHERS = {"libcli11-dev", "libdraco-dev", "libeigen3-dev", "libglm-dev", "libstb-dev", "libtomlplusplus-dev",
          "libvulkan-dev", "nlohmann-json3-dev", "gcc", "mingw-w64"}  # fmt: skip
OF_WINDOWS = {"KERNEL32.dll", "ADVAPI32.dll", "msvcrt.dll"}


def linked_libraries():
    """Names of the static libraries of the prefix that halflight.exe is linked with."""
    ninja = (wine.ROOT / "build/windows/build.ninja").read_text()
    (line,) = re.findall(r"build apps/halflight/halflight\.exe: .*?\n  LINK_LIBRARIES = (.*?)\n", ninja, re.S)
    names = {pathlib.Path(word).name for word in line.split() if word.endswith(".a") and "/prefix/" in word}
    return {re.sub(r"^lib|\.dll|\.a$", "", name) for name in names}


class Packages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="halflight Pakete ")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        subprocess.run([wine.ROOT / "scripts/build-windows.sh", "--cached", cls.folder / "out"], check=True, stdout=subprocess.DEVNULL)
        cls.zip, cls.blender = (cls.one(pattern) for pattern in ("halflight-[0-9]*-windows-x64.zip", "halflight-blender-*-windows-x64.zip"))
        cls.wheel = cls.one("halflight-*-py3-none-win_amd64.whl")
        with zipfile.ZipFile(cls.zip) as archive:
            archive.extractall(cls.folder / "zip")
        (cls.unpacked,) = (cls.folder / "zip").iterdir()

    @classmethod
    def one(cls, pattern):
        (path,) = (cls.folder / "out").glob(pattern)
        return path

    def test_zip_and_wheel_bake_the_bytes_of_linux(self):
        scene = self.folder / "szene.gltf"
        tiny_scene.write(scene)
        expected = self.folder / "linux.glb"
        subprocess.run([HALFLIGHT, "bake", scene, "-o", expected, *QUICK, "--quiet"], check=True)
        with zipfile.ZipFile(self.wheel) as archive:
            archive.extractall(self.folder / "wheel")
        for program in (self.unpacked / "bin/halflight.exe", self.folder / "wheel/halflight/program/bin/halflight.exe"):
            output = self.folder / "windows.glb"
            result = run("bake", scene, "-o", output, *QUICK, "--quiet", program=program)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(output.read_bytes(), expected.read_bytes())
            output.unlink()

    def test_licences_of_all_that_is_linked(self):
        texts = {path.stem for path in (self.unpacked / "share/doc/halflight/licences").glob("*.txt")}
        self.assertGreater(len(linked_libraries()), 12)
        ours = set()
        for library in linked_libraries():
            (owner,) = {LICENCES[name] for name in sorted(LICENCES, key=len) if re.match(rf"{name}([\d_-]|Core|Util|$)", library)}
            ours.add(owner)
        self.assertEqual(texts, ours | OTHERS)
        copyright = (self.unpacked / "share/doc/halflight/copyright").read_text()
        for words in ("MIT License", "Arm Limited", "Sun Microsystems"):
            self.assertIn(words, copyright)
        with zipfile.ZipFile(self.wheel) as archive:
            names = archive.namelist()
            self.assertEqual({pathlib.Path(name).stem for name in names if "/licences/" in name}, texts)
            (licence,) = [name for name in names if name.endswith(".dist-info/LICENSE")]
            self.assertEqual(archive.read(licence).decode(), copyright)

    def test_the_program_needs_libraries_of_windows_alone(self):
        said = subprocess.run(["objdump", "-p", self.unpacked / "bin/halflight.exe"], check=True, capture_output=True, text=True).stdout
        self.assertEqual({name for name in re.findall(r"DLL Name: (\S+)", said)} - OF_WINDOWS, set())
        self.assertEqual([path.name for path in (self.unpacked / "bin").iterdir()], ["halflight.exe"])

    def test_the_wheels_record_and_tag(self):
        with zipfile.ZipFile(self.wheel) as archive:
            (record,) = [name for name in archive.namelist() if name.endswith("/RECORD")]
            rows = list(csv.reader(io.StringIO(archive.read(record).decode())))
            self.assertEqual(sorted(row[0] for row in rows), sorted(archive.namelist()))
            for name, digest, size in rows:
                if name != record:
                    data = archive.read(name)
                    found = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
                    self.assertEqual((f"sha256={found}", str(len(data))), (digest, size))
            self.assertIn("Tag: py3-none-win_amd64\n", archive.read(record.replace("RECORD", "WHEEL")).decode())

    def test_blenders_extension_has_the_wheel_for_windows_alone(self):
        with zipfile.ZipFile(self.blender) as archive:
            (manifest,) = [name for name in archive.namelist() if name.endswith("blender_manifest.toml")]
            said = tomllib.loads(archive.read(manifest).decode())
            self.assertEqual(said.get("platforms"), ["windows-x64"])
            (wheel,) = [name for name in archive.namelist() if name.endswith(".whl")]
            self.assertEqual(archive.read(wheel), self.wheel.read_bytes())

    def test_the_program_can_be_replaced_after_use(self):
        """As an update of the extension does it."""
        helper = wine.build_helper(tempfile.mkdtemp(dir=wine.CACHE))
        self.addCleanup(shutil.rmtree, os.path.dirname(helper))
        scene, program, update = (self.folder / name for name in ("ersetzt.gltf", "ersetzt.exe", "neu.exe"))
        tiny_scene.write(scene)
        shutil.copy(self.unpacked / "bin/halflight.exe", program)
        update.write_bytes(b"the next version")
        words = ["Z:" + str(path).replace("/", "\\") for path in (update, program)]
        result = run("replace", 0, *words, "bake", scene, "-o", self.folder / "ersetzt.glb", *QUICK, "--quiet", program=helper)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertTrue((self.folder / "ersetzt.glb").exists())
        self.assertEqual(program.read_bytes(), b"the next version")


if __name__ == "__main__":
    HALFLIGHT = os.path.abspath(sys.argv[1])
    wine.run_tests()
