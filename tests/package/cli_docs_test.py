#!/usr/bin/env python3
"""Manual pages and completions hold every command and option, and the shells that are here take them.

    cli_docs_test.py HALFLIGHT MAKE_CLI_DOCS
"""

import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

HALFLIGHT, MAKE = sys.argv[1:3]


def run(*command, **options):
    return subprocess.run(command, capture_output=True, text=True, **options)


def commands_of(program):
    """Words and description of each command, those below others included."""
    for command in program["commands"]:
        yield [command["name"]], command
        for words, below in commands_of(command):
            yield [command["name"], *words], below


class CliDocs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.out = pathlib.Path(cls.folder.name)
        subprocess.run([sys.executable, MAKE, HALFLIGHT, cls.out], check=True)
        cls.program = json.loads(run(HALFLIGHT, "--describe").stdout)

    def test_description_is_that_of_the_help(self):
        names = [command["name"] for command in self.program["commands"]]
        self.assertLessEqual({"bake", "farm", "render", "info", "optimize"}, set(names))
        for words, command in commands_of(self.program):
            shown = set(re.findall(r"^  (?:-\w,)?(--[\w-]+)", run(HALFLIGHT, *words, "--help").stdout, re.M))
            described = {name for o in command["options"] for name in o.get("names", []) if name.startswith("--")}
            self.assertEqual(described, shown)

    def test_manual_pages(self):
        for words, command in commands_of(self.program):
            page = (self.out / "man1" / f"{'-'.join(['halflight', *words])}.1").read_text()
            self.assertTrue(page.isascii())
            for option in command["options"]:
                for name in option.get("names", [option.get("positional")]):
                    self.assertIn(name.replace("-", "\\-"), page)
        if shutil.which("groff"):
            for page in sorted((self.out / "man1").iterdir()):
                result = run("groff", "-man", "-Tutf8", "-ww", "-z", str(page))
                self.assertEqual((result.returncode, result.stderr), (0, ""), page.name)

    def bash(self, *words):
        line = " ".join(f"'{word}'" for word in words)
        script = f"source {self.out}/halflight.bash; COMP_WORDS=({line}); COMP_CWORD={len(words) - 1}; _halflight; "
        return run("bash", "-c", script + 'printf "%s\\n" "${COMPREPLY[@]}"').stdout.split()

    def test_bash(self):
        self.assertEqual(self.bash("halflight", "b"), ["bake"])
        self.assertEqual(self.bash("halflight", "bake", "--quality", ""), ["preview", "medium", "high", "ultra"])
        self.assertEqual(self.bash("halflight", "bake", "--mode", "s"), ["shadowmask", "subtractive"])
        self.assertEqual(self.bash("halflight", "render", "--cascade-s"), ["--cascade-splits"])
        self.assertEqual(self.bash("halflight", "bake", "--samples", ""), [])
        self.assertEqual(self.bash("halflight", "farm", "pl"), ["plan"])
        self.assertEqual(self.bash("halflight", "farm", "work", "--ind"), ["--index"])

    def test_zsh_and_fish(self):
        if shutil.which("zsh"):
            self.assertEqual(run("zsh", "-n", f"{self.out}/_halflight").returncode, 0)
        if shutil.which("fish"):
            said = run("fish", "-c", f"source {self.out}/halflight.fish; complete -C 'halflight bake --quality '")
            self.assertEqual([line.split()[0] for line in said.stdout.splitlines()], ["high", "medium", "preview", "ultra"])
            said = run("fish", "-c", f"source {self.out}/halflight.fish; complete -C 'halflight farm st'")
            self.assertEqual(said.stdout.split(), ["status"])
        for name in ("_halflight", "halflight.fish"):
            text = (self.out / name).read_text()
            for command in self.program["commands"]:
                self.assertIn(command["name"], text)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
