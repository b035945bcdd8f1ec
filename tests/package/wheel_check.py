"""The wheel's module, in a Python that has it: wheel_check.py SCENE OUTPUT OPTIONS… (each --name value, and --quiet)."""

import pathlib
import subprocess
import sys

import halflight


def main():
    scene, output = sys.argv[1:3]
    words = [word for word in sys.argv[3:] if word != "--quiet"]
    settings = {name[2:].replace("-", "_"): value for name, value in zip(words[::2], words[1::2])}
    report = halflight.bake(scene, output, **settings)
    assert report["output"] == output and report["lightmap"]["pages"] >= 1, report
    assert report.seconds == report["seconds"] > 0 and halflight.info(output).baked, report
    assert pathlib.Path(halflight.__file__).with_name("py.typed").is_file()
    try:
        halflight.bake(scene, output, quality="best")
    except halflight.Error as error:
        assert error.code == 2 and "must be one of preview" in str(error), error
    else:
        raise AssertionError("a wrong setting is an error")
    said = subprocess.run([sys.executable, "-m", "halflight", "--version"], capture_output=True, text=True).stdout
    assert said.startswith("halflight " + halflight.__version__), said


main()
