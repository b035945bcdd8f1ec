"""Runs the program that came along."""

import contextlib
import ctypes
import importlib
import json
import os
import pathlib
import stat
import subprocess
import sys
import tempfile
from typing import IO, Any, Callable, Dict, Iterator, List, Optional, Sequence, Tuple, Union

Path = Union[str, "os.PathLike[str]"]
Progress = Union[Callable[[str, float], object], bool, None]


class Error(RuntimeError):
    """What the program said. `code` is its exit code: 1 failed, 2 wrong usage."""

    def __init__(self, message: str, code: int) -> None:
        super().__init__(message)
        self.code = code


def executable() -> str:
    """Path of the program."""
    folder = pathlib.Path(__file__).with_name("program")
    path = folder / "bin" / ("halflight.exe" if os.name == "nt" else "halflight")
    if os.name == "posix":
        # Some installers of wheels, Blender's among them, lose the right to run files: launcher, program, loader.
        for file in (path, folder / "lib/halflight/halflight", *folder.glob("lib/halflight/glibc/ld-*")):
            if file.exists() and not os.access(file, os.X_OK):
                file.chmod(file.stat().st_mode | stat.S_IXUSR | stat.S_IXGRP | stat.S_IXOTH)
    return str(path)


# -- settings as words of the command line; a value after "=" may begin with "-" ---------------------------------------


def flag(name: str, value: bool) -> List[str]:
    return [name] if value else []


def option(name: str, value: object, between: str = ",") -> List[str]:
    if value is None:
        return []
    if isinstance(value, bool):
        return [f"{name}={'on' if value else 'off'}"]
    if isinstance(value, os.PathLike):
        return [f"{name}={os.fspath(value)}"]
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [f"{name}={between.join(str(part) for part in value)}"]
    return [f"{name}={value}"]


def each(name: str, value: Union[str, Sequence[str], None]) -> List[str]:
    """An option that may be given again."""
    values = [value] if isinstance(value, str) else value or []
    return [f"{name}={part}" for part in values]


def command_line(command: str, file: Path, output: Optional[Path], words: Sequence[str]) -> List[str]:
    """Files come last, after "--", as their names may begin with "-"."""
    files = [os.fspath(file)]
    options = [*words, "--json"]
    if output is not None and command == "optimize":
        files.append(os.fspath(output))
    elif output is not None:
        options += [f"--output={os.fspath(output)}"]
    return [executable(), command, *options, "--", *files]


# -- progress ----------------------------------------------------------------------------------------------------------


class _Bar:
    """A bar by tqdm, one a stage; where it is not installed, a line per stage on standard error."""

    def __init__(self) -> None:
        self.stage = ""
        self.bar: Any = None
        self.make: Any = None
        with contextlib.suppress(ImportError):
            self.make = importlib.import_module("tqdm.auto").tqdm

    def __call__(self, stage: str, share: float) -> None:
        if stage != self.stage:
            self.close()
            self.stage = stage
            if self.make is None:
                print(f"halflight: {stage}", file=sys.stderr)
            else:
                self.bar = self.make(total=100, desc=stage, bar_format="{desc}: {percentage:3.0f} %|{bar}| {elapsed}")
        if self.bar is not None:
            self.bar.update(round(100 * share) - self.bar.n)

    def close(self) -> None:
        if self.bar is not None:
            self.bar.close()
            self.bar = None


def _steps(lines: IO[str], said: List[str]) -> Iterator[Tuple[str, float]]:
    """Stage and share of each line of progress; all other lines are kept in `said`."""
    last = ""
    for line in lines:
        if not line.startswith("progress: ") or not line.endswith(" %\n"):
            said.append(line)
        elif line != last:
            last = line
            stage, percent = line[len("progress: ") : -len(" %\n")].rsplit(" ", 1)
            yield stage, float(percent) / 100


def _sentence(said: Sequence[str]) -> str:
    """Why the program failed: what it said, without its warnings."""
    errors = [line for line in said if not line.startswith("halflight: warning: ")]
    return "".join(errors).strip().replace("halflight: ", "", 1)


# -- Windows ---------------------------------------------------------------------------------------------------------------


def hidden() -> Dict[str, Any]:
    """For Popen: no console flashes up on Windows."""
    if sys.platform == "win32":
        return {"creationflags": subprocess.CREATE_NO_WINDOW}
    return {}


def cancel(process: "subprocess.Popen[str]") -> None:
    """As Ctrl-C does: the program ends and leaves nothing half-written. Windows has no such signal without a console; the
    program waits for an event instead."""
    if sys.platform != "win32":
        process.terminate()
        return
    kernel = ctypes.WinDLL("kernel32")
    kernel.OpenEventW.restype = ctypes.c_void_p
    may_set = 2  # EVENT_MODIFY_STATE
    event = kernel.OpenEventW(may_set, False, f"Local\\halflight-cancel-{process.pid}")
    if event:
        kernel.SetEvent(ctypes.c_void_p(event))
        kernel.CloseHandle(ctypes.c_void_p(event))
    else:  # it has not begun
        process.terminate()


# -- the program -------------------------------------------------------------------------------------------------------


def run(
    command: str, file: Path, output: Optional[Path], words: Sequence[str], progress: Progress = None
) -> Dict[str, Any]:
    """Runs one command of the program and returns its JSON. Ctrl-C and exceptions of `progress` end the program, too.
    Its output is not written then."""
    if command == "bake":
        if output is None:
            source = pathlib.Path(file)
            output = source.with_name(source.stem + "-baked.glb")
        words = [*words, "--progress=lines" if progress else "--quiet"]
    call = _Bar() if progress is True else progress or None
    said: List[str] = []
    with tempfile.TemporaryFile("w+", encoding="utf-8") as result:
        process = subprocess.Popen(
            command_line(command, file, output, words),
            stdin=subprocess.DEVNULL, stdout=result, stderr=subprocess.PIPE, encoding="utf-8", errors="replace",
            **hidden(),
        )  # fmt: skip
        assert process.stderr is not None
        try:
            for stage, share in _steps(process.stderr, said):
                if call is not None:
                    call(stage, share)
            code = process.wait()
        except BaseException:
            cancel(process)
            process.stderr.close()
            process.wait()
            raise
        finally:
            if isinstance(call, _Bar):
                call.close()
        process.stderr.close()
        if code != 0:
            raise Error(_sentence(said), code)
        result.seek(0)
        report: Dict[str, Any] = json.load(result)
    if command == "bake":
        report["output"] = os.fspath(output) if output is not None else ""
    return report
