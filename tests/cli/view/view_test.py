"""The real window: pictures, mouse, keys, panels, files (view_case.py).
Usage: view_test.py HALFLIGHT SHARED_DIR [TestClass[.test]] …"""

import os
import re
import shlex
import shutil
import subprocess
import time

import cli_case
from cli_case import QUICK, Case, read, run
from view_case import SECONDS, ViewCase


class View(ViewCase):
    def test_the_windows_pixels_are_those_of_render(self):
        """Every mode, both paths, a view: the window, its screenshot, and the command line it prints."""
        baked, _ = self.bake(self.scene(), "baked.glb")
        window = self.window(baked, "--size", "320x200", "--eye=4,3,5", "--target=0,0,0")
        window.key("Tab")  # no panels
        for i, keys in enumerate((["1"], ["2"], ["3"], ["4"], ["p"], ["v"])):
            said = len(window.lines)
            window.key(*keys)
            window.key("F12")
            line = window.said(r"screenshot_\d+\.png: halflight .*", said).group(0)
            name, command = line.split(": ", 1)
            shot = self.path(name)
            self.assert_comes_to_show(window, shot, f"{keys}: the window and its screenshot")
            words = shlex.split(command)
            self.assertEqual(words[:2], ["halflight", "render"])
            words[words.index("-o") + 1] = self.path(f"render{i}.png")
            result = run(*words[1:], "--device", "cpu")
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assert_same_picture(self.path(f"render{i}.png"), shot, f"{keys}: {command}")
        self.assert_ends_well(window)

    def test_mouse_panels_and_sizes(self):
        """500 frames of use without a message of the validation layer."""
        baked, _ = self.bake(self.scene(), "baked.glb")
        window = self.window(baked, "--size", "500x300")
        window.key("F12")
        window.said(r"screenshot_001\.png: ")  # it draws
        for width, height in ((333, 217), (800, 600), (65, 41), (500, 300)):
            window.do("windowsize", "--sync", window.id, width, height)
            time.sleep(0.3)
        for button in (1, 2, 3):
            window.do("mousemove", "--window", window.id, 450, 100, "mousedown", button)
            for x in range(450, 380, -10):
                window.do("mousemove", "--window", window.id, x, 120)
            window.do("mouseup", button)
        window.do("mousemove", "--window", window.id, 450, 100, "click", 4, "click", 4, "click", 5)
        window.do("click", 1)  # selects what is there
        window.do("keydown", "w"), time.sleep(0.3), window.do("keyup", "w")
        window.do("keydown", "d"), time.sleep(0.3), window.do("keyup", "d")
        window.key("f", "x", "c", "c", "v", "v", "v", "v", "v", "v", "v", "F12")  # compared with the reference to the end
        window.said(r"screenshot_002\.png: ")
        for y in range(20, 300, 14):  # whatever is under the mouse: sections open, buttons are pressed
            window.do("mousemove", "--window", window.id, 60, y, "click", 1)
            time.sleep(0.05)
        window.do("windowunmap", "--sync", window.id)
        time.sleep(0.3)
        window.do("windowmap", "--sync", window.id)
        window.do("windowfocus", "--sync", window.id)
        window.do("mousemove", "--window", window.id, 450, 200)
        time.sleep(0.5)
        while window.process.poll() is None:
            window.key("Escape")
        self.assert_ends_well(window)

    def test_numbers_are_dragged_and_typed(self):
        """Faster than pictures are drawn: every press, move and key counts."""
        window = self.window(self.scene(), "--size", "500x300", "--exposure", "1")
        exposure = (60, 129)  # where the panel has it
        mouse = lambda x, y: ("mousemove", "--window", window.id, x, y)

        def shot():
            said = len(window.lines)
            window.do("key", "F12")
            line = window.said(r"screenshot_\d+\.png: .*", said).group(0)
            return float(re.search(r"--exposure (\S+)", line).group(1))

        self.assertEqual(shot(), 1.0)
        window.do(*mouse(60, 60), "click", 1)
        shot()  # the list of modes is open
        window.do("key", "Escape")  # closes it, and ends no program
        window.do(*mouse(*exposure), "mousedown", 1, *mouse(80, 129), *mouse(100, 129), "mouseup", 1, *mouse(60, 280))
        self.assertAlmostEqual(shot(), 3.0, places=4)  # 0.05 a pixel
        typed = ("key", "2", "key", "period", "key", "5")
        control = (*mouse(*exposure), "keydown", "ctrl", "click", 1, "keyup", "ctrl", *mouse(450, 200))
        window.do(*control, *typed, "key", "Return")
        self.assertEqual(shot(), 2.5)
        window.do(*control, "key", "7", "key", "Escape")  # ends the typing, not the program
        self.assertEqual(shot(), 2.5)
        window.do(*control, "key", "7", "key", "Tab", "key", "Escape")  # the next number is typed, until Escape
        self.assertEqual(shot(), 7.0)
        window.do(*mouse(450, 200), "mousedown", 1, *mouse(420, 200), "mouseup", 1)  # in the picture
        self.assertEqual(shot(), 7.0)
        self.assert_ends_well(window)

    def test_ends_after_the_frames_asked_for(self):
        window = self.window(self.scene(), "--size", "200x120", "--frames", "500")
        self.assertEqual(window.process.wait(timeout=SECONDS), 0)
        self.assertEqual(window.said(r"^(\d+) frames").group(1), "500")
        window.reader.join()
        self.assertEqual(window.process.stderr.read(), "")
        window.process.stderr.close()
        window.process.stdout.close()

    def test_a_press_is_one_thing(self):
        """A slow orbit selects nothing, Ctrl-S does not fly, --light changes the light that is shown."""
        scene = self.scene()
        window = self.window(scene, "--size", "500x300", "--light", "sun:intensity=0.5,color=1,0,0")

        def command():
            said = len(window.lines)
            window.key("F12")
            return window.said(r"(screenshot_\d+\.png): (halflight .*)", said)

        first = command()
        self.assertIn("--light sun:intensity=0.5,color=1,0,0", " ".join(shlex.split(first.group(2))))
        words = shlex.split(first.group(2))
        words[words.index("-o") + 1] = self.path("render.png")
        self.assertEqual(run(*words[1:], "--device", "cpu").returncode, 0)
        self.assertIn("--camera", words)
        self.assert_same_picture(self.path("render.png"), self.path(first.group(1)), "the light, by the file's camera")
        eye = lambda match: [float(x) for x in re.search(r"--eye (\S+)", match.group(2)).group(1).split(",")]
        window.key("f")
        whole = eye(command())
        for places in (range(450, 430, -1), range(430, 450)):  # there and back
            window.do("mousemove", "--window", window.id, places[0], 200, "mousedown", 1)
            for x in (*places, 2 * places[-1] - places[-2]):
                window.do("mousemove", "--window", window.id, x, 200)
            window.do("mouseup", 1)
        window.key("f")
        turned = command()
        for before, after in zip(whole, eye(turned)):
            self.assertAlmostEqual(before, after, 3, "nothing was selected: F looks at the whole scene")
        window.do("keydown", "ctrl", "keydown", "s"), time.sleep(0.4), window.do("keyup", "s", "keyup", "ctrl")
        self.assertEqual(eye(command()), eye(turned))
        self.assert_ends_well(window)
        window = self.window(scene, "--size", "500x300", "--light", "nobody:intensity=1")
        self.assertEqual(window.process.wait(timeout=SECONDS), 1)
        self.assertIn("no light is named 'nobody'; there are: sun", window.quit()[1])

    def test_a_lost_device_is_replaced(self):
        """The window goes on with another device; where that fails at once, it says so and keeps what was changed."""
        baked, _ = self.bake(self.scene(), "baked.glb")
        window = self.window(baked, "--size", "320x200", "--lose-device", "10")
        window.said("the device failed, another is made: .*device")
        window.key("Tab", "F12")
        window.said(r"screenshot_\d+\.png: ")
        self.assert_ends_well(window)
        window = self.window(baked, "--size", "320x200", "--lose-device", "10,12")
        self.assertEqual(window.process.wait(timeout=SECONDS), 1)
        window.reader.join()
        errors = window.process.stderr.read()
        window.process.stderr.close()
        window.process.stdout.close()
        self.assertEqual(len(errors.strip().splitlines()), 1, errors)
        self.assertIn("device", errors)
        self.assertIn("nothing was changed\n", window.lines)

    def test_a_changed_file_is_read_again(self):
        baked, _ = self.bake(self.scene(), "baked.glb")
        window = self.window(baked, "--size", "320x200", "--eye=4,3,5", "--target=0,0,0", "--exposure", "1")
        window.key("Tab", "F12")
        first = window.said(r"(screenshot_\d+\.png): ").group(1)
        result = run("bake", self.scene(), "-o", self.path("other.glb"), *QUICK, "--bounces", "0", "-q")
        self.assertEqual(result.returncode, 0, result.stderr)
        os.replace(self.path("other.glb"), baked)
        limit = time.monotonic() + SECONDS
        while time.monotonic() < limit:
            time.sleep(0.5)
            said = len(window.lines)
            window.key("F12")
            match = window.said(r"(screenshot_\d+\.png): .*--eye 4,3,5", said)
            if read(self.path(match.group(1))) != read(self.path(first)):
                break
        self.assertLess(time.monotonic(), limit, "the picture stays as it was")
        self.assert_ends_well(window)

    def test_a_file_that_breaks_leaves_what_was_shown(self):
        """The window says why, once, and goes on."""
        scene = self.scene()
        window = self.window(scene, "--size", "320x200", "--exposure", "1")
        window.key("Tab", "F12")
        first = window.said(r"(screenshot_\d+\.png): ").group(1)
        said = len(window.lines)
        with open(scene, "wb") as file:
            file.write(b"nothing")
        name = re.escape(os.path.basename(scene))
        window.said(rf"^{name}: .*neither a GLB", said)
        time.sleep(2.5)  # more than two looks at the file
        said = len(window.lines)
        window.key("F12")
        second = window.said(r"(screenshot_\d+\.png): ", said).group(1)
        self.assertEqual(read(self.path(first)), read(self.path(second)))
        self.assertEqual(sum(line.startswith(os.path.basename(scene)) for line in window.lines), 1, window.lines)
        self.assert_ends_well(window)

    def test_a_file_that_is_not_one(self):
        broken = self.path("broken.glb")
        with open(broken, "wb") as file:
            file.write(b"nothing")
        environment = dict(os.environ, DISPLAY=self.display.name)
        result = subprocess.run([cli_case.HALFLIGHT, "view", broken, "--device", "cpu"], capture_output=True, text=True,
                                env=environment, timeout=SECONDS)
        self.assert_one_sentence(result, 1, "broken.glb")


class NoDisplay(Case):
    def test_one_sentence_without_a_display(self):
        environment = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
        environment["SDL_VIDEODRIVER"] = "x11"
        result = subprocess.run([cli_case.HALFLIGHT, "view", self.scene()], capture_output=True, text=True,
                                env=environment, timeout=SECONDS)
        self.assert_one_sentence(result, 1, "window")

    def test_without_the_window_program(self):
        """As in tarball and wheel, and in Debian before halflight-view is installed."""
        alone = shutil.copy(cli_case.HALFLIGHT, self.path("halflight"))
        run_alone = lambda *words: subprocess.run([alone, *words], capture_output=True, text=True)  # noqa: E731
        self.assert_one_sentence(run_alone("view", self.scene()), 1, "the package halflight-view")
        self.assertNotIn("\n  view ", run_alone("--help").stdout)
        self.assertIn("\nno window: ", run_alone("--version").stdout)


if __name__ == "__main__":
    cli_case.main()
