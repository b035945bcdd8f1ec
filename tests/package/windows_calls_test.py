#!/usr/bin/env python3
"""What the Python module and the Blender extension ask of Windows, where neither runs here: no console that flashes up,
and a cancel by the event that halflight.exe waits for. Windows' calls are recorded. tests/windows sets the real event.

    windows_calls_test.py SOURCE
"""

import importlib
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

SOURCE = pathlib.Path(sys.argv[1])
NO_WINDOW = 0x08000000
EVENT_MODIFY_STATE = 2
sys.dont_write_bytecode = True


class Kernel:
    """kernel32.dll with one event, or with none."""

    def __init__(self, event):
        self.calls = []
        self.OpenEventW = mock.Mock(side_effect=lambda *words: self.calls.append(("open", *words)) or event)
        self.SetEvent = mock.Mock(side_effect=lambda handle: self.calls.append(("set", handle.value)))
        self.CloseHandle = mock.Mock(side_effect=lambda handle: self.calls.append(("close", handle.value)))


def name_in_program():
    source = (SOURCE / "src/base/system_windows.cpp").read_text()
    (name,) = re.findall(r'std::wstring name = L"(Local\\\\halflight-cancel-)" \+ std::to_wstring\(GetCurrentProcessId', source)
    return name.replace("\\\\", "\\")


class WindowsCalls(unittest.TestCase):
    def setUp(self):
        self.process = mock.Mock(pid=4711)

    def check_cancel(self, cancel):
        for event in (99, 0):
            kernel = Kernel(event)
            self.process.reset_mock()
            with mock.patch("ctypes.WinDLL", lambda name: kernel, create=True):
                cancel(self.process)
            self.assertEqual(kernel.calls[0], ("open", EVENT_MODIFY_STATE, False, name_in_program() + "4711"))
            self.assertEqual(kernel.calls[1:], [("set", event), ("close", event)] if event else [])
            self.assertEqual(self.process.terminate.called, not event, "before there is an event, nothing is half-written")

    def test_of_the_python_module(self):
        with tempfile.TemporaryDirectory() as folder:
            shutil.copytree(SOURCE / "scripts/packaging/python/halflight", pathlib.Path(folder) / "halflight")
            with mock.patch("sys.path", [folder, *sys.path]):
                module = importlib.import_module("halflight._run")
        with mock.patch("sys.platform", "win32"), mock.patch.object(subprocess, "CREATE_NO_WINDOW", NO_WINDOW, create=True):
            self.assertEqual(module.hidden(), {"creationflags": NO_WINDOW})
            self.check_cancel(module.cancel)

    def test_of_the_blender_extension(self):
        path = SOURCE / "blender/halflight_blender/program.py"
        specification = importlib.util.spec_from_file_location("extension_program", path)
        module = importlib.util.module_from_spec(specification)
        with mock.patch.object(subprocess, "CREATE_NO_WINDOW", NO_WINDOW, create=True):
            specification.loader.exec_module(module)
        self.assertEqual(module.HIDDEN, {"creationflags": NO_WINDOW})
        with mock.patch("os.name", "nt"):
            self.check_cancel(module.cancel)

    def test_each_start_of_the_program_is_hidden(self):
        calls = 0
        for folder in ("blender/halflight_blender", "scripts/packaging/python/halflight"):
            for path in (SOURCE / folder).glob("*.py"):
                for call in re.findall(r"subprocess\.(?:run|Popen)\((?:[^()]|\([^()]*\))*\)", path.read_text()):
                    if "sys.argv" in call:
                        continue  # the command `halflight` of a wheel is typed into a console
                    calls += 1
                    self.assertRegex(call, r"\*\*(program\.)?(HIDDEN|hidden\(\))", f"{path.name}: a console would flash up")
        self.assertGreaterEqual(calls, 3)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
