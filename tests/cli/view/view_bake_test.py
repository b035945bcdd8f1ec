"""The real window: bakes in the background, and comparisons with them (view_case.py).
Usage: view_bake_test.py HALFLIGHT SHARED_DIR [TestClass[.test]] …"""

import os
import shlex
import subprocess
import time

import cli_case
from cli_case import read, run
from view_case import SECONDS, ViewCase


class ViewBake(ViewCase):
    def test_a_live_bake_is_the_bakes(self):
        """First light, then the finished bake, whose file is that of `halflight bake`, byte for byte."""
        scene = self.scene()
        options = ["--quality", "preview", "--lightmap-size", "256"]
        window = self.window(scene, "--size", "320x200", "--bake", *options)
        window.said(r"light of probes after \d")
        window.said(r"first light after \d")
        window.said(r"^baked in \d")
        window.key("ctrl+s")
        window.said(r"^saved tiny_baked\.glb")
        self.assert_ends_well(window)
        result = run("bake", scene, "-o", self.path("plain.glb"), *options, "-q")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(read(self.path("tiny_baked.glb")), read(self.path("plain.glb")))

    def test_a_bake_that_is_not_saved_is_not_lost(self):
        """Neither by one Escape, nor by F5, nor by a file that changes."""
        scene = self.scene()
        window = self.window(scene, "--size", "320x200", "--bake", "--quality", "preview", "--lightmap-size", "64")
        window.said(r"^baked in \d")
        said = len(window.lines)
        os.utime(scene)
        window.said(r"has changed; F5 reads it, and loses the bake", said)
        window.key("Escape")
        window.said(r"the bake is not saved: Ctrl-S saves it; Escape once more", said)
        time.sleep(4.2)  # as long as that is shown
        said = len(window.lines)
        window.key("F5")
        window.said(r"the bake is not saved: .*F5 once more", said)
        window.key("ctrl+s")
        window.said(r"^saved tiny_baked\.glb", said)
        window.key("F12")
        command = shlex.split(window.said(r"screenshot_001\.png: (halflight .*)", said).group(1))
        self.assertEqual(command[:3], ["halflight", "render", "tiny_baked.glb"])
        command[command.index("-o") + 1] = self.path("render.png")
        result = subprocess.run([cli_case.HALFLIGHT, *command[1:], "--device", "cpu"], cwd=self.folder.name)
        self.assertEqual(result.returncode, 0)
        self.assert_same_picture(self.path("render.png"), self.path("screenshot_001.png"), "the saved bake")
        window.do("key", "Escape")
        self.assertEqual(window.process.wait(timeout=SECONDS), 0)
        self.assert_ends_well(window)

    def test_closes_while_it_opens_and_while_it_bakes(self):
        """Escape ends it whatever it does, after a bake with a second one."""
        scene = self.scene()
        for pause in (0.0, 0.1, 0.4):
            window = self.window(scene, "--size", "320x200")
            time.sleep(pause)
            self.assertEqual(window.quit(), (0, ""), window.lines)
        window = self.window(scene, "--size", "320x200", "--bake", "--quality", "ultra")
        window.said(r"first picture after \d")
        window.key("Escape")
        self.assertEqual(window.quit(), (0, ""), window.lines)

    def test_a_cancelled_bake_leaves_what_was_shown(self):
        baked, _ = self.bake(self.scene(), "baked.glb")
        window = self.window(baked, "--size", "320x200", "--quality", "ultra")
        window.key("Tab", "F12")
        first = window.said(r"(screenshot_\d+\.png): ").group(1)
        window.key("b")
        window.said(r"first light after")
        window.key("Escape")
        window.said(r"^bake: cancelled")
        said = len(window.lines)
        window.key("3", "F12")
        second = window.said(r"(screenshot_\d+\.png): ", said).group(1)
        self.assertEqual(read(self.path(first)), read(self.path(second)))
        self.assert_ends_well(window)

    def test_compare_with_the_reference_and_before_the_bake(self):
        """Right of the line: what is path traced, then the light before the bake. Left of it the picture stays."""
        scene = self.scene()
        window = self.window(scene, "--size", "640x200", "--bake", "--quality", "preview", "--lightmap-size", "128")
        window.said(r"^baked in \d")
        window.key("Tab", "F12")
        shot = self.path(window.said(r"(screenshot_\d+\.png): ").group(1))
        whole = self.pixels(shot)
        for compared in ("before", "reference"):
            window.key("c" if compared == "before" else "r")
            limit = time.monotonic() + SECONDS
            while True:
                time.sleep(0.5)
                window.grab(self.path("grab.png"))
                rows = self.pixels(self.path("grab.png"))
                left = [row[:300] for row in rows[:150]]
                right = [row[340:] for row in rows[:150]]
                same = max(abs(a - b) for p, q in zip(left, whole) for u, v in zip(p, q) for a, b in zip(u, v)) <= 1
                other = sum(abs(a - b) for p, q in zip(right, [row[340:] for row in whole]) for u, v in zip(p, q)
                            for a, b in zip(u, v))
                if same and other > 20000 and len({pixel for row in right for pixel in row}) > 20:
                    break
                self.assertLess(time.monotonic(), limit, f"{compared}: left is the same {same}, right differs by {other}")
        self.assert_ends_well(window)

    def assert_answers(self, window):
        """A screenshot follows a drag of the mouse, five times; each shows another place."""
        eyes = set()
        for i in range(5):
            said = len(window.lines)
            window.do("mousemove", "--window", window.id, 450, 100, "mousedown", 1)
            window.do("mousemove", "--window", window.id, 430 - 5 * i, 110, "mouseup", 1)
            window.do("key", "F12")
            eyes.add(window.said(r"screenshot_\d+\.png: .* --eye (\S+)", said).group(1))
        self.assertEqual(len(eyes), 5, "the mouse moves the camera")

    def test_answers_while_there_is_work_in_the_background(self):
        """Keys are answered before a bake ends, and while the reference gets better, which takes as long."""
        window = self.window(self.scene(), "--size", "500x300", "--quality", "ultra", "--lightmap-size", "256")
        window.said(r"first picture after \d")  # the mouse moves nothing before
        window.key("Tab")
        self.assert_answers(window)
        window.key("b")
        window.said(r"first light after")
        self.assert_answers(window)
        self.assertFalse(any(line.startswith("baked in") for line in window.lines), window.lines)
        window.key("Escape")
        window.said(r"^bake: cancelled")
        window.key("r")
        self.assert_answers(window)
        time.sleep(2.0)  # now it is refined, on a quiet machine
        self.assert_answers(window)
        self.assert_ends_well(window)


if __name__ == "__main__":
    cli_case.main()
