"""The real window, on a virtual display and Vulkan's CPU driver: what its tests share. Needs
Xvfb, xdotool and ImageMagick; skipped where one is missing, and in builds without a window."""

import os
import re
import shutil
import subprocess
import threading
import time
import unittest

import cli_case
from cli_case import Case, decode_png, run

TOOLS = ("Xvfb", "xdotool", "import", "convert")
SECONDS = 400  # for what takes a second on a quiet machine; only what hangs takes so long


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
        """By Escape, twice where a bake is not saved."""
        limit = time.monotonic() + SECONDS
        while (code := self.process.poll()) is None:
            if time.monotonic() > limit:
                self.process.kill()
                raise AssertionError(f"does not end: {self.lines}")
            subprocess.run(["xdotool", "key", "Escape"], env=self.environment, timeout=SECONDS)
            try:
                self.process.wait(timeout=1)
            except subprocess.TimeoutExpired:
                pass
        self.reader.join()
        errors = self.process.stderr.read()
        self.process.stderr.close()
        self.process.stdout.close()
        return code, errors


@unittest.skipIf(any(shutil.which(tool) is None for tool in TOOLS), "needs " + ", ".join(TOOLS))
class ViewCase(Case):
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
