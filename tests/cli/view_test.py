"""The real window, on a virtual display and Vulkan's CPU driver. Usage: view_test.py HALFLIGHT SHARED_DIR [TestClass[.test]] …
Needs Xvfb, xdotool and ImageMagick; skipped where one is missing, and in builds without a window."""

import os
import re
import shlex
import shutil
import subprocess
import threading
import time
import unittest

import cli_case
from cli_case import QUICK, Case, decode_png, read, run

TOOLS = ("Xvfb", "xdotool", "import", "convert")
SECONDS = 120  # for what takes a second on a quiet machine


class Display:
    """A virtual screen without a window manager."""

    def __init__(self):
        read_end, write_end = os.pipe()
        self.process = subprocess.Popen(
            ["Xvfb", "-displayfd", str(write_end), "-screen", "0", "1280x800x24", "-nolisten", "tcp"],
            pass_fds=[write_end], stderr=subprocess.DEVNULL)
        os.close(write_end)
        with os.fdopen(read_end) as file:
            self.name = ":" + file.readline().strip()

    def close(self):
        self.process.terminate()
        self.process.wait()


class Window:
    """`halflight view` with these arguments, and the lines it says."""

    def __init__(self, display, *arguments, cwd):
        self.environment = dict(os.environ, DISPLAY=display.name, SDL_VIDEODRIVER="x11")
        self.lines = []
        self.process = subprocess.Popen(
            [cli_case.HALFLIGHT, "view", *map(str, arguments), "--device", "cpu", "--validation"],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=self.environment, cwd=cwd)
        self.reader = threading.Thread(target=lambda: self.lines.extend(iter(self.process.stdout.readline, "")))
        self.reader.start()
        self.id = self.do("search", "--sync", "--onlyvisible", "--pid", self.process.pid).split()[-1]
        self.do("windowfocus", "--sync", self.id)

    def do(self, *arguments):
        return subprocess.run(["xdotool", *map(str, arguments)], env=self.environment, text=True, check=True,
                              stdout=subprocess.PIPE, timeout=SECONDS).stdout

    def key(self, *names):
        for name in names:
            self.do("key", name)
            time.sleep(0.15)

    def said(self, pattern, after=0):
        """The match of the first such line, waited for."""
        limit = time.monotonic() + SECONDS
        while time.monotonic() < limit:
            for line in self.lines[after:]:
                match = re.search(pattern, line)
                if match:
                    return match
            if self.process.poll() is not None:
                break
            time.sleep(0.05)
        raise AssertionError(f"nothing like '{pattern}' in {self.lines}; {self.process.poll()}")

    def grab(self, path):
        subprocess.run(["import", "-window", self.id, path], env=self.environment, check=True, timeout=SECONDS)

    def quit(self):
        self.key("Escape")
        try:
            code = self.process.wait(timeout=SECONDS)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise
        self.reader.join()
        errors = self.process.stderr.read()
        self.process.stderr.close()
        self.process.stdout.close()
        return code, errors


@unittest.skipIf(any(shutil.which(tool) is None for tool in TOOLS), "needs " + ", ".join(TOOLS))
class View(Case):
    def setUp(self):
        super().setUp()
        if "no window" in run("--version").stdout:
            self.skipTest("this build has no window")
        self.display = Display()
        self.addCleanup(self.display.close)

    def window(self, *arguments):
        return Window(self.display, *arguments, cwd=self.folder.name)

    def assert_ends_well(self, window):
        code, errors = window.quit()
        self.assertEqual((code, errors), (0, ""), window.lines)
        frames = int(window.said(r"^(\d+) frames").group(1))
        self.assertGreater(frames, 5)
        return frames

    def pixels(self, path):
        """Rows of (r, g, b)."""
        plain = path + ".png"
        subprocess.run(["convert", path, "-depth", "8", "-define", "png:color-type=2", plain], check=True)
        return decode_png(plain)[2]

    def assert_same_picture(self, a, b, what):
        first, second = self.pixels(a), self.pixels(b)
        self.assertEqual((len(first), len(first[0])), (len(second), len(second[0])), what)
        worst = max(abs(x - y) for p, q in zip(first, second) for u, v in zip(p, q) for x, y in zip(u, v))
        self.assertLessEqual(worst, 1, what)  # a rounding: the window encodes on the device
        self.assertGreater(len({pixel for row in first for pixel in row}), 20, what + " shows something")

    def assert_comes_to_show(self, window, picture, what):
        """The window shows the picture, some frames later on a busy machine."""
        grab = self.path("grab.png")
        limit = time.monotonic() + SECONDS
        while True:
            time.sleep(0.3)
            window.grab(grab)
            try:
                return self.assert_same_picture(grab, picture, what)
            except AssertionError:
                if time.monotonic() > limit:
                    raise

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

    def answer_seconds(self, window):
        """Until a screenshot follows a drag of the mouse, the median of five; each shows another place."""
        seconds = []
        eyes = set()
        for i in range(5):
            said = len(window.lines)
            window.do("mousemove", "--window", window.id, 450, 100, "mousedown", 1)
            window.do("mousemove", "--window", window.id, 430 - 5 * i, 110, "mouseup", 1)
            start = time.monotonic()
            window.do("key", "F12")
            eyes.add(window.said(r"screenshot_\d+\.png: .* --eye (\S+)", said).group(1))
            seconds.append(time.monotonic() - start)
        self.assertEqual(len(eyes), len(seconds), "the mouse moves the camera")
        return sorted(seconds)[2]

    def test_answers_while_there_is_work_in_the_background(self):
        """A bake, its end, and the reference that gets better: a key is answered about as soon as without them."""
        window = self.window(self.scene(), "--size", "500x300", "--quality", "ultra", "--lightmap-size", "256")
        window.key("Tab")
        quiet = self.answer_seconds(window)
        most = 4.0 * quiet + 1.0  # the work takes a part of the processor, and more where that has few cores
        window.key("b")
        window.said(r"first light after")
        self.assertLess(self.answer_seconds(window), most, f"a bake; without it {quiet}")
        window.key("Escape")
        window.said(r"^bake: cancelled")
        window.key("r")
        self.assertLess(self.answer_seconds(window), most, f"the reference; without it {quiet}")
        time.sleep(2.0)  # now it is refined
        self.assertLess(self.answer_seconds(window), most, f"the reference, refined; without it {quiet}")
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


if __name__ == "__main__":
    cli_case.main()
