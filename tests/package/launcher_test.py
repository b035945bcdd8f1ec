#!/usr/bin/env python3
"""The launcher of tarball and wheel: which glibc it chooses, and that the program behaves as the build tree's with each.

    launcher_test.py HALFLIGHT SOURCE

Exits with 77 (ctest: skipped) where patchelf or objdump is missing.
"""

import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

BUILT, SOURCE = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
sys.path.insert(0, str(SOURCE / "tests" / "cli"))
import tiny_scene  # noqa: E402

PACKAGING = SOURCE / "scripts" / "packaging"
QUICK = ["--quality", "preview", "--samples", "4", "--bounces", "1", "--lightmap-size", "64", "--quiet"]


def run(*command, glibc=None, **options):
    environment = {**os.environ, **({"HALFLIGHT_GLIBC": glibc} if glibc is not None else {})}
    return subprocess.run([*map(str, command)], capture_output=True, text=True, env=environment, **options)


def write_script(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("#!/bin/sh\n" + text)
    path.chmod(0o755)


class Choice(unittest.TestCase):
    """The launcher of a program that needs glibc 2.36, with loaders that tell other versions."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.loader = self.folder / "ld.so"
        words = {"LOADER": self.loader, "LOADER_NAME": "ld.so", "MAJOR": 2, "MINOR": 36}
        text = (PACKAGING / "launcher.sh").read_text()
        for name, value in words.items():
            text = text.replace(f"@{name}@", str(value))
        self.assertNotRegex(text, r"@\w+@")
        self.launcher = self.folder / "bin" / "halflight"
        write_script(self.launcher, text)
        write_script(self.folder / "lib/halflight/halflight", "echo system\n")
        write_script(self.folder / "lib/halflight/glibc/ld.so", "echo bundled\n")

    def choice(self, glibc=""):
        result = run(self.launcher, glibc=glibc)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        return result.stdout.strip()

    def test_version_of_the_loader(self):
        forms = ["ld.so (Debian GLIBC {0}-9+deb12u14) stable", "ld.so (GNU libc) development", "ld.so (Gentoo {0} (patchset 10)) stable"]
        versions = {"2.36": "system", "2.36.9000": "system", "2.41": "system", "2.100": "system", "3.0": "system",
                    "2.35": "bundled", "2.4": "bundled", "1.99": "bundled", "": "bundled", "two.40": "bundled"}  # fmt: skip
        for form in forms:
            for version, expected in versions.items():
                said = f"{form.format(version)} release version {version}.\nCopyright (C) 2022"
                write_script(self.loader, f"cat <<'END'\n{said}\nEND\n")
                self.assertEqual(self.choice(), expected, said)

    def test_loaders_that_tell_none(self):
        self.assertEqual(self.choice(), "bundled", "no loader: musl")
        write_script(self.loader, "echo '--version: cannot open shared object file' >&2; exit 127\n")
        self.assertEqual(self.choice(), "bundled", "before glibc 2.33")
        write_script(self.loader, "printf 'musl libc (x86_64)\\nVersion 1.2.5\\n' >&2; exit 1\n")
        self.assertEqual(self.choice(), "bundled", "gcompat")

    def test_by_hand(self):
        self.assertEqual(self.choice("system"), "system")
        write_script(self.loader, "echo 'ld.so (GNU libc) stable release version 2.41.'\n")
        self.assertEqual(self.choice("bundled"), "bundled")
        wrong = run(self.launcher, glibc="2.31")
        self.assertEqual((wrong.returncode, wrong.stdout), (2, ""))
        self.assertEqual(wrong.stderr, "halflight: HALFLIGHT_GLIBC must be system or bundled, not '2.31'\n")

    def test_ways_to_the_launcher(self):
        links = self.folder / "with space" / "more"
        links.mkdir(parents=True)
        (links / "first").symlink_to(self.launcher)
        (links / "second").symlink_to("first")
        (links / "folder").symlink_to(self.folder / "bin")
        for command, cwd in (([links / "second"], "/"), ([links / "folder/halflight"], "/"), (["./second"], links),
                             (["sh", "halflight"], self.folder / "bin"), (["bin/halflight"], self.folder)):  # fmt: skip
            self.assertEqual(run(*command, cwd=cwd, glibc="system").stdout, "system\n", command)
        on_path = {**os.environ, "PATH": f"{links}:{os.environ['PATH']}", "HALFLIGHT_GLIBC": "bundled"}
        self.assertEqual(subprocess.check_output(["second"], env=on_path, cwd="/", text=True), "bundled\n")


class Program(unittest.TestCase):
    """The program itself, in a folder whose name has a space and a colon."""

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        cls.prefix = cls.folder / "a folder: its program"
        (cls.prefix / "bin").mkdir(parents=True)
        cls.launcher = cls.prefix / "bin" / "halflight"
        shutil.copy(BUILT, cls.launcher)
        subprocess.run([sys.executable, PACKAGING / "bundle_libraries.py", cls.prefix], check=True, stdout=subprocess.DEVNULL)
        cls.scene = cls.folder / "tiny.gltf"
        tiny_scene.write(cls.scene)

    def maps(self, glibc):
        """The shared libraries in a bake's memory, once it has started."""
        environment = {**os.environ, "HALFLIGHT_GLIBC": glibc}
        command = [self.launcher, "bake", self.scene, "-o", self.folder / "endless.glb", *QUICK, "--samples", "100000"]
        process = subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True)
        try:
            for _ in range(600):
                text = pathlib.Path(f"/proc/{process.pid}/maps").read_text()
                if "libOpenEXR" in text and "libc.so.6" in text:
                    break
                time.sleep(0.05)
            time.sleep(0.5)  # the handler of Ctrl-C is there
        finally:
            process.send_signal(signal.SIGINT)
            said = process.communicate(timeout=60)[1]
        self.assertEqual((process.returncode, said), (1, "halflight: interrupted\n"))
        self.assertFalse((self.folder / "endless.glb").exists())
        return {line.split(None, 5)[5] for line in text.splitlines() if ".so" in line}

    def test_libraries_and_interrupt(self):
        """Each choice has one glibc, all of it from one place, and Ctrl-C reaches the program."""
        own = str(self.prefix / "lib" / "halflight")
        for glibc in ("system", "bundled"):
            libraries = self.maps(glibc)
            for name in ("ld-linux", "libc.so", "libm.so", "libstdc++.so", "libembree"):
                found = [path for path in libraries if name in path]
                self.assertEqual(len(found), 1, (glibc, name, found))
                here = found[0].startswith(own)
                self.assertEqual(here, glibc == "bundled" or name == "libembree", (glibc, found))

    def test_bytes_and_sentences(self):
        expected = self.folder / "expected.glb"
        subprocess.run([BUILT, "bake", self.scene, "-o", expected, *QUICK], check=True)
        for glibc in ("system", "bundled"):
            output = self.folder / f"{glibc}.glb"
            result = run(self.launcher, "bake", self.scene, "-o", output, *QUICK, glibc=glibc)
            self.assertEqual((result.returncode, result.stdout, result.stderr), (0, "", ""))
            self.assertEqual(output.read_bytes(), expected.read_bytes(), glibc)
            result = run(self.launcher, "info", "no such.glb", glibc=glibc, cwd="/")
            self.assertEqual((result.returncode, result.stderr), (1, "halflight: no such.glb: no such file\n"))
            result = run(self.launcher, "bake", "--quality", "best", self.scene, "-o", "x.glb", glibc=glibc)
            self.assertEqual(result.returncode, 2, result.stderr)

    def test_every_version_asked_for_is_there(self):
        """The bundled glibc defines all versions of its symbols that a bundled file asks for."""
        folder = self.prefix / "lib" / "halflight"
        dump = lambda path: subprocess.check_output(["objdump", "-p", path], text=True)  # noqa: E731
        defined = set(re.findall(r"0x\w+ (GLIBC_[\d.]+)", dump(folder / "glibc" / "libc.so.6").split("Version References")[0]))
        files = [path for path in folder.rglob("*") if path.is_file()]
        asked = {word for path in files for word in re.findall(r" (GLIBC_[\d.]+)\n", dump(path).split("Version References")[-1])}
        self.assertIn("GLIBC_2.34", asked)
        self.assertLessEqual(asked, defined)
        needed = {word for path in files for word in re.findall(r"NEEDED +(\S+)", dump(path))}
        self.assertLessEqual(needed, {path.name for path in files})

    def test_licences(self):
        folder = self.prefix / "share" / "doc" / "halflight" / "licences"
        sources = (folder / "SOURCES").read_text()
        for package in ("libc6", "libtbb12"):
            self.assertGreater((folder / package).stat().st_size, 500)
            self.assertRegex(sources, rf"(?m)^{package}: https://\S+/(package|\+source)/(glibc|onetbb)/\d\S+$")
        self.assertIn("GNU LESSER GENERAL PUBLIC LICENSE", (folder / "LGPL-2.1").read_text())


if __name__ == "__main__":
    missing = [tool for tool in ("patchelf", "objdump") if not shutil.which(tool)]
    if missing:
        print(f"skipped: {missing[0]} is missing (apt-get install patchelf binutils)")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1])
