"""The program for Linux on arm64 under qemu-user. Usage: arm64_test.py HALFLIGHT SHARED_DIR [TestClass[.test]] …

HALFLIGHT is the x86-64 program, whose results are compared with. That of arm64 is build/arm64/apps/halflight/halflight, or
what HALFLIGHT_ARM64 names."""

import glob
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tarfile
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests/cli"), str(ROOT / "scripts")]
import cli_case  # noqa: E402
from cli_case import QUICK, read  # noqa: E402
from farm_test import FarmCase  # noqa: E402
from identity_test import layout  # noqa: E402
from make_truth_report import read_exr  # noqa: E402

BUILD = ROOT / "build/arm64"
SYSROOT = pathlib.Path(os.environ.get("HALFLIGHT_ROOTS", "/var/cache/halflight")) / "arm64/sysroot"
QEMU = "qemu-aarch64-static"
TOOLS = "aarch64-linux-gnu-"
SKIPPED = 77
AARCH64 = (183).to_bytes(2, "little")  # e_machine of ELF


def skip(sentence):
    print("skipped: " + sentence)
    sys.exit(SKIPPED)


def program():
    path = pathlib.Path(os.environ.get("HALFLIGHT_ARM64", BUILD / "apps/halflight/halflight"))
    for name in (QEMU, TOOLS + "objdump"):
        if shutil.which(name) is None:
            skip(f"{name} is not installed (apt-get install g++-aarch64-linux-gnu qemu-user-static)")
    for there in (path, SYSROOT):
        if not there.exists():
            skip(f"there is no {there}; scripts/build-arm64.sh makes it")
    return path


def run(*words, path=None, environment=None):
    """Of the arm64 program."""
    command = [QEMU, "-L", str(SYSROOT), str(path or program()), *map(str, words)]
    return subprocess.run(command, capture_output=True, encoding="utf-8", timeout=1500, stdin=subprocess.DEVNULL,
                          env={**os.environ, **(environment or {})})


def identity(said):
    return re.search(r"bakes as (\S+)", said.stdout)[1]


class Identity(FarmCase):
    def test_is_of_this_architecture(self):
        said = run("--version")
        self.assertEqual(said.returncode, 0, said.stderr)
        self.assertRegex(said.stdout, r"^halflight [\d.]+\n")
        self.assertRegex(identity(said), r"^cpu-embree-[\d.]+-neon-[0-9a-f]{8}$")
        self.assertNotEqual(identity(said), identity(cli_case.run("--version")))
        print(f"arm64: {identity(said)}, x86-64: {identity(cli_case.run('--version'))}")

    def test_other_instruction_sets_are_refused(self):
        for name in ("avx2", "avx512"):
            result = run("bake", self.scene(), "-o", self.path("x.glb"), *QUICK, "-q", "--isa", name)
            self.assert_one_sentence(result, 1, name, "--isa sse2, which all have")
        self.assert_folder_holds("tiny.gltf")

    def test_descriptions_and_errors_are_those_of_x86(self):
        for words in (["--describe"], ["info", ROOT / "assets/courtyard.glb", "--json"], ["bake", "none.glb", "-o", "x.glb"], ["bake"]):
            with self.subTest(words=words):
                one, other = run(*words), cli_case.run(*words)
                self.assertEqual((one.returncode, one.stdout, one.stderr), (other.returncode, other.stdout, other.stderr))


class Bakes(FarmCase):
    """Four scenes: the layout of x86-64, and its light within half a per cent."""

    scenes = ("closed_room.glb", "sphere_on_floor.glb", "penumbra.glb", "compressed/plain.glb")

    def baked_by(self, runner, name, scene, *options):
        output, images = self.path(name + ".glb"), self.path(name)
        words = ["bake", ROOT / "assets/tests" / scene, "-o", output, "--quality", "preview", "--json", "--write-images", images]
        result = runner(*words, *options)
        self.assertEqual(result.returncode, 0, result.stderr)
        report = json.loads(result.stdout)
        lightmap = {key: report["lightmap"][key] for key in ("charts", "cuts", "pages", "size", "coveredTexels")}
        channels = [(light["name"], light["channel"]) for light in report["lights"]]
        pages = sorted(glob.glob(os.path.join(images, "lightmap_*.exr")))
        texels = [value for page in pages if "raw" not in page for row in read_exr(pathlib.Path(page)) for texel in row for value in texel]
        return (lightmap, channels, report["triangles"], report["probes"]["count"]), layout(output), texels, read(output)

    def test_four_scenes(self):
        sets = [name for name in ("sse2", "avx2") if cli_case.run("bake", self.scene(), "-o", self.path("x.glb"), *QUICK, "-q", "--isa", name).returncode == 0]
        for scene in self.scenes:
            words, parts, light, data = self.baked_by(run, "arm64", scene)
            self.assertGreater(sum(light), 0)
            for name in sets:
                with self.subTest(scene=scene, isa=name):
                    other_words, other_parts, other_light, other_data = self.baked_by(cli_case.run, name, scene, "--isa", name)
                    self.assertEqual(words, other_words)
                    self.assertEqual(parts, other_parts)
                    self.assertEqual(len(light), len(other_light))
                    difference = sum(abs(a - b) for a, b in zip(light, other_light)) / sum(other_light)
                    bytes_apart = sum(a != b for a, b in zip(data, other_data)) + abs(len(data) - len(other_data))
                    print(f"{scene}, arm64 against {name}: {bytes_apart} of {len(data)} bytes differ, light by {100 * difference:.4f} % in the mean")
                    self.assertLess(difference, 0.005)


class Farms(FarmCase):
    def test_a_plan_of_x86_is_refused(self):
        ours, theirs = identity(run("--version")), identity(cli_case.run("--version"))
        plan = self.plan(self.scene(), *QUICK)
        words = (ours, theirs, "--isa sse2", "--mixed")
        self.assert_one_sentence(run("farm", "work", plan, "--index", 0, "--of", 1, "-q"), 1, *words)
        self.work_all(plan, 1)
        self.assert_one_sentence(run("farm", "join", plan, "-o", self.path("joined.glb"), "-q"), 1, *words)
        self.assertFalse(os.path.exists(self.path("joined.glb")))

    def test_mixed_plans_are_for_both(self):
        plan = self.plan(self.scene(), *QUICK, "--mixed")
        self.assertEqual(self.work(plan, 0, 2).returncode, 0)
        result = run("farm", "work", plan, "--index", 1, "--of", 2, "-q")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(self.joined(plan)[:4], b"glTF")

    def test_results_of_x86_stay_in_a_cache(self):
        scene, cache = self.scene(), self.path("cache")
        self.bake(scene, "a.glb", "--cache", cache)
        theirs = identity(cli_case.run("--version"))
        held = {path: read(path) for path in glob.glob(os.path.join(cache, theirs, "**"), recursive=True) if os.path.isfile(path)}
        self.assertTrue(held)
        result = run("bake", scene, "-o", self.path("b.glb"), *QUICK, "--cache", cache, "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        report = json.loads(result.stdout)
        self.assertEqual(report["cache"]["same"], 0)
        self.assertEqual(len([line for line in report["warnings"] if theirs in line and report["identity"] in line]), 1, report["warnings"])
        self.assertEqual({path: read(path) for path in held}, held)


class Instructions(FarmCase):
    """No fused multiplication and addition in what is compiled here: it rounds once where x86-64 rounds twice."""

    FUSED = re.compile(r"\t(fn?m(?:add|sub)|fml[as])\t")

    def count(self, path):
        said = subprocess.run([TOOLS + "objdump", "-d", "--no-show-raw-insn", path], check=True, capture_output=True, text=True).stdout
        self.assertIn("aarch64", said)
        return len(self.FUSED.findall(said))

    def test_none_is_fused(self):
        objects = sorted(BUILD.glob("src/**/*.o"))
        self.assertGreater(len(objects), 20)
        found = {str(path.relative_to(BUILD)): count for path in objects if (count := self.count(path))}
        self.assertEqual(found, {})
        self.assertGreater(self.count(SYSROOT / "usr/lib/aarch64-linux-gnu/libembree3.so.3"), 0, "they would be seen")

    def test_mathematics_are_the_projects_own(self):
        libraries = [BUILD / "src" / name / f"libhalflight_{pathlib.Path(name).name}.a" for name in ("base", "scene", "unwrap", "render/frame", "bake", "bake_cpu")]
        script = ROOT / "tests/base/libm_symbols.py"
        libm = SYSROOT / "lib/aarch64-linux-gnu/libm.so.6"
        result = subprocess.run([sys.executable, script, libm, *libraries], capture_output=True, text=True)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)


class Packages(FarmCase):
    """.deb, tarball and wheel by scripts/package.sh; the tarball's program runs with each glibc."""

    def setUp(self):
        super().setUp()
        missing = [name for name in ("patchelf", "dpkg-shlibdeps", "fakeroot") if shutil.which(name) is None]
        if missing:
            self.skipTest(f"{missing[0]} is not installed (apt-get install patchelf dpkg-dev fakeroot)")
        out = self.path("out")
        subprocess.run([ROOT / "scripts/package.sh", "--target", "arm64", "--out", out], check=True, stdout=subprocess.DEVNULL,
                       env={**os.environ, "HALFLIGHT_ARM64_SYSROOT": str(SYSROOT)})
        self.files = sorted(os.listdir(out))
        self.out = pathlib.Path(out)

    def one(self, pattern):
        (path,) = self.out.glob(pattern)
        return path

    def assert_all_of_arm64(self, files):
        programs = [data for data in files if data[:4] == b"\x7fELF"]
        self.assertGreater(len(programs), 0)
        for data in programs:
            self.assertEqual(data[18:20], AARCH64)
        return len(programs)

    def check_deb(self):
        deb = self.one("halflight_*_arm64.deb")
        fields = dict(line.split(": ", 1) for line in subprocess.run(["dpkg-deb", "-f", deb], check=True, capture_output=True, text=True).stdout.splitlines() if ": " in line)
        self.assertEqual(fields["Architecture"], "arm64")
        for name in ("libc6", "libembree3-3", "libopenexr-3-1-30", "libtbb12", "libzstd1", "libpng16-16", "libstdc++6"):
            self.assertRegex(fields["Depends"], rf"(^|, ){re.escape(name)}( \(|,|$)")
        tree = pathlib.Path(self.path("deb"))
        subprocess.run(["dpkg-deb", "-x", deb, tree], check=True)
        self.assertEqual(self.assert_all_of_arm64([path.read_bytes() for path in tree.rglob("*") if path.is_file()]), 1)
        self.assertTrue(list(tree.glob("usr/share/man/man1/halflight-bake.1*")))
        self.assertEqual(run("--version", path=tree / "usr/bin/halflight").stdout, run("--version").stdout)

    def check_bundled(self, bundled):
        """The relocatable program, with no library of the sysroot but glibc's, and with none at all."""
        self.assertGreater(self.assert_all_of_arm64([path.read_bytes() for path in bundled.rglob("*") if path.is_file()]), 15)
        libraries = bundled / "lib/halflight"
        for name in ("glibc/ld-linux-aarch64.so.1", "glibc/libc.so.6", "libembree3.so.3", "fallback/libstdc++.so.6"):
            self.assertTrue((libraries / name).is_file(), name)
        licences = bundled / "share/doc/halflight/licences"
        self.assertRegex((licences / "SOURCES").read_text(), r"libembree3-3: https://snapshot.debian.org/package/embree/3.13.5")
        self.assertTrue((licences / "libc6").is_file() and (licences / "LGPL-2.1").is_file())
        self.assertRegex((licences.parent / "copyright").read_text(), r"(?s)MIT License.*Arm Limited.*Sun Microsystems")
        launcher = (bundled / "bin/halflight").read_text()
        self.assertIn("$(/lib/ld-linux-aarch64.so.1 --version", launcher)
        loader = libraries / "glibc/ld-linux-aarch64.so.1"
        paths = ":".join(str(libraries / name) for name in ("glibc", "", "fallback"))
        command = [QEMU, str(loader), "--inhibit-rpath", "", "--library-path", paths, str(libraries / "halflight"), "--version"]
        said = subprocess.run(command, capture_output=True, text=True)
        self.assertEqual((said.returncode, said.stdout), (0, run("--version").stdout), said.stderr)

    def test_of_each_kind(self):
        print("\n".join(f"{name}: {os.path.getsize(self.out / name) / 1e6:.1f} MB" for name in self.files))
        self.assertEqual(len(self.files), 4, self.files)
        self.check_deb()
        with tarfile.open(self.one("halflight-*-linux-aarch64.tar.gz")) as archive:
            archive.extractall(self.path("tar"))
        (bundled,) = pathlib.Path(self.path("tar")).iterdir()
        self.check_bundled(bundled)
        wheel = self.one("halflight-*-py3-none-manylinux_2_36_aarch64.whl")
        with zipfile.ZipFile(wheel) as archive:
            self.assertIn("Tag: py3-none-manylinux_2_36_aarch64", archive.read([name for name in archive.namelist() if name.endswith("/WHEEL")][0]).decode())
            inside = {name.removeprefix("halflight/program/"): archive.read(name) for name in archive.namelist() if name.startswith("halflight/program/lib/")}
        self.assertEqual(inside, {path.relative_to(bundled).as_posix(): path.read_bytes() for path in (bundled / "lib").rglob("*") if path.is_file()})


if __name__ == "__main__":
    program()
    cli_case.main()
