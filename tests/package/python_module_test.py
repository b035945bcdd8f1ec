#!/usr/bin/env python3
"""The Python module: its generated files, its types, and what it does with the built program.

    python_module_test.py HALFLIGHT SOURCE
"""

import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

HALFLIGHT, SOURCE = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
sys.path.insert(0, str(SOURCE / "tests" / "cli"))
import tiny_scene  # noqa: E402

PACKAGING = SOURCE / "scripts" / "packaging"
QUICK = dict(quality="preview", samples=4, shadow_samples=2, bounces=1, lightmap_size=64)
CELL = """
import halflight
report = halflight.bake("tiny.gltf", "cell.glb", progress=True, **SETTINGS)
halflight.render("cell.glb", "cell.png", size=(32, 18), device="cpu") if RENDERS else None
"""
NOTEBOOK = ("nbclient", "nbformat", "ipykernel")
RUN_CELL = """
import json, sys, nbclient, nbformat
notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(sys.argv[1])])
nbclient.NotebookClient(notebook, timeout=120, kernel_name="python3").execute()
print(json.dumps(notebook.cells[0].outputs))
"""


def has_modules(python, *names):
    """Whether an interpreter is there and has them; Debian's packages are for its own."""
    code = f"import {', '.join(names)}"
    return bool(shutil.which(python)) and subprocess.run([python, "-c", code], capture_output=True).returncode == 0


def lay_out(folder):
    """The module as the wheel has it, with the built program."""
    shutil.copytree(PACKAGING / "python" / "halflight", folder / "halflight")
    program = folder / "halflight" / "program" / "bin"
    program.mkdir(parents=True)
    (program / "halflight").symlink_to(HALFLIGHT.resolve())


class Files(unittest.TestCase):
    def test_generated_files_are_those_of_this_program(self):
        with tempfile.TemporaryDirectory() as name:
            subprocess.run([sys.executable, PACKAGING / "make_python_module.py", HALFLIGHT, name], check=True)
            made = {path.name: path.read_text() for path in pathlib.Path(name).iterdir()}
        self.assertEqual(len(made), 5)
        for name, text in made.items():
            committed = (PACKAGING / "python" / "halflight" / name).read_text()
            self.assertEqual(committed, text, "run scripts/packaging/make_python_module.py HALFLIGHT")

    def test_a_new_kind_of_value_is_refused(self):
        description = json.loads(subprocess.check_output([HALFLIGHT, "--describe"]))
        description["commands"][0]["options"][3]["value"] = "FORTNIGHTS"
        with tempfile.TemporaryDirectory() as name:
            program = pathlib.Path(name) / "program"
            program.write_text(f"#!/bin/sh\ncat <<'END'\n{json.dumps(description)}\nEND\n")
            program.chmod(0o755)
            command = [sys.executable, PACKAGING / "make_python_module.py", program, name]
            result = subprocess.run(command, capture_output=True, text=True)
        self.assertEqual((result.returncode, result.stderr), (1, "make_python_module.py: no type for the value FORTNIGHTS of ['--mode']\n"))

    def test_types(self):
        if not shutil.which("mypy"):
            self.skipTest("mypy is missing (apt-get install mypy)")
        with tempfile.TemporaryDirectory() as name:
            command = ["mypy", "--strict", "--cache-dir", name, "halflight", SOURCE / "tests/package/python_module_types.py"]
            result = subprocess.run(command, cwd=PACKAGING / "python", capture_output=True, text=True)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)


class Module(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        lay_out(cls.folder)
        sys.path.insert(0, folder.name)
        os.chdir(folder.name)
        tiny_scene.write("tiny.gltf")
        shutil.copy("tiny.gltf", "-tiny.gltf")
        import halflight

        cls.halflight, cls.steps = halflight, []
        cls.baked = halflight.bake("tiny.gltf", progress=lambda *step: cls.steps.append(step), **QUICK)

    def with_fields(self, record, path="report"):
        """All members of the program's JSON have fields, those of its parts too. Returns how many."""
        count = 0
        for name, value in record.items():
            field = "".join("_" + c.lower() if c.isupper() else c for c in name)
            self.assertIn(field, record.__dict__, f"{path}.{name}: docs/schemas lacks it")
            self.assertIs(record[name], getattr(record, field))
            for part in value if isinstance(value, list) else [value]:
                self.assertNotIsInstance(part, dict, f"{path}.{name}")
                count += self.with_fields(part, f"{path}.{name}") if hasattr(part, "to_dict") else 1
        return count

    def test_bake(self):
        report = self.baked
        self.assertEqual(report.output, "tiny-baked.glb")
        self.assertGreater(report.peak_memory_bytes, 1 << 20)
        self.assertEqual(report["lightmap"]["pages"], report.lightmap.pages)
        self.assertEqual(report.lights[0].baked_as, report["lights"][0]["bakedAs"])
        self.assertGreater(self.with_fields(report), 60)
        self.assertEqual(json.loads(json.dumps(report.to_dict()))["seconds"], report.seconds)
        self.assertEqual((report.get("nothing", 1), "nothing" in report, dict(report)["noise"]), (1, False, report.noise))
        with self.assertRaises(KeyError):
            report["peak_memory_bytes"]

    def test_progress(self):
        stages = [stage for stage, _ in self.steps]
        self.assertTrue({"charts", "lightmap", "probes", "write"} <= set(stages), stages)
        self.assertEqual(len(self.steps), len(set(self.steps)))
        self.assertTrue(all(0 <= share <= 1 for _, share in self.steps))
        self.assertEqual(self.steps[-1], ("write", 1.0))

    def test_an_exception_of_progress_ends_the_bake(self):
        def stop(stage, share):
            raise ZeroDivisionError(stage)

        with self.assertRaises(ZeroDivisionError):
            self.halflight.bake("tiny.gltf", "stopped.glb", progress=stop, **{**QUICK, "samples": 100000})
        self.assertEqual(list(self.folder.glob("*stopped*")), [])

    def test_other_commands(self):
        info = self.halflight.info("tiny-baked.glb")
        self.assertTrue(info.baked and info.mode == "shadowmask" and info.bounds is not None)
        self.assertGreater(self.with_fields(info), 40)
        smaller = self.halflight.optimize("tiny-baked.glb", pathlib.Path("small.glb"), lightmap_bits=7)
        self.assertEqual(smaller.bytes.file.after, pathlib.Path("small.glb").stat().st_size)
        self.assertEqual(self.with_fields(smaller), 15)

    def test_render(self):
        try:
            picture = self.halflight.render("tiny-baked.glb", "-picture.png", size=(32, 18), device="cpu", exposure=-1)
        except self.halflight.Error as error:
            self.skipTest(f"no picture can be drawn here: {error}")
        self.assertEqual((picture.size, picture.exposure, picture.output), ([32, 18], -1, "-picture.png"))
        self.assertGreater(self.with_fields(picture), 40)
        self.assertEqual(picture._repr_png_(), pathlib.Path("-picture.png").read_bytes())

    def test_names_that_begin_with_a_dash(self):
        report = self.halflight.bake("-tiny.gltf", seed=2, **QUICK)
        self.assertEqual(report.output, "-tiny-baked.glb")
        self.halflight.optimize("-tiny-baked.glb", "-small.glb")
        self.assertTrue(self.halflight.info("-small.glb").baked)
        with self.assertRaisesRegex(self.halflight.Error, "'-nobody'"):
            self.halflight.bake("-tiny.gltf", only=["-nobody"], cache="-cache", **QUICK)

    def test_errors(self):
        for code, sentence, settings in (
            (1, "missing.glb: no such file", {}),
            (2, "--quality: must be one of preview", dict(quality="best")),
            (1, "missing.glb: no such file", dict(progress=print)),
        ):
            with self.assertRaises(self.halflight.Error) as caught:
                self.halflight.bake("missing.glb", "out.glb", **settings)
            self.assertEqual(caught.exception.code, code)
            self.assertIn(sentence, str(caught.exception))
            self.assertNotRegex(str(caught.exception), "^halflight|\n")

    def test_settings_as_words(self):
        run = sys.modules["halflight._run"]
        words = [*run.option("--sky", (1, 2.5, 3)), *run.option("--size", (4, 3), between="x"), *run.option("--uv", None)]
        words += [*run.option("--denoise", False), *run.flag("--json", True), *run.flag("--quiet", False), *run.each("--only", "a")]
        words += [*run.each("--only", ("b", "c")), *run.option("--cache", pathlib.Path("-d"))]
        self.assertEqual(words, ["--sky=1,2.5,3", "--size=4x3", "--denoise=off", "--json", "--only=a", "--only=b", "--only=c", "--cache=-d"])  # fmt: skip

    def test_help(self):
        shown = subprocess.check_output([sys.executable, "-c", "import halflight; help(halflight.bake)"], text=True)
        self.assertRegex(shown, r"texels_per_meter \(X\): lightmap density")
        self.assertIn("BakeReport", shown)

    def test_notebook_cell(self):
        python = next((p for p in (sys.executable, "/usr/bin/python3") if has_modules(p, *NOTEBOOK)), None)
        if python is None:
            self.skipTest("notebook tools are missing (apt-get install python3-nbclient python3-ipykernel)")
        renders = (self.folder / "-picture.png").exists()
        code = CELL.replace("SETTINGS", repr(QUICK)).replace("RENDERS", repr(renders))
        quiet = {**os.environ, "PYDEVD_DISABLE_FILE_VALIDATION": "1"}
        outputs = json.loads(subprocess.check_output([python, "-c", RUN_CELL, code], env=quiet))
        text = "".join(output.get("text", "") for output in outputs)
        if has_modules(python, "tqdm", "ipywidgets"):
            self.assertIn("application/vnd.jupyter.widget-view+json", str(outputs))
        elif has_modules(python, "tqdm"):
            self.assertRegex(text, r"lightmap: 100 %\|█+\|")
        else:
            self.assertIn("halflight: lightmap\n", text)
        pictures = [output for output in outputs if "image/png" in output.get("data", {})]
        self.assertEqual(len(pictures), renders)

    def test_bar_without_tqdm(self):
        code = "import sys; sys.modules['tqdm.auto'] = None\nimport halflight\n"
        code += f"halflight.bake('tiny.gltf', 'bar.glb', progress=True, **{QUICK})"
        said = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
        self.assertEqual(said.stdout, "")
        self.assertIn("halflight: lightmap\n", said.stderr)
        self.assertEqual(len(set(said.stderr.splitlines())), len(said.stderr.splitlines()))


class Result(unittest.TextTestResult):
    """Says why a test was skipped in the words that scripts/skipped_tests.py reads."""

    def addSkip(self, test, reason):
        super().addSkip(test, reason)
        print(f"[  SKIPPED ] {test.id()}: {reason}", flush=True)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], testRunner=unittest.TextTestRunner(resultclass=Result))
