#!/usr/bin/env python3
"""Makes a Python wheel of a relocatable installation (bundle_libraries.py).

    make_wheel.py PREFIX VERSION PLATFORM OUT      prints the wheel's path

PLATFORM is what pip calls the systems that shall take it: manylinux_2_31_x86_64 (2.31: the oldest glibc), win_amd64.

A wheel is a zip with three files of metadata (PEP 427); times are fixed, so that the same files give the same bytes.
"""

import base64
import hashlib
import pathlib
import sys
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
WHEN = (2026, 1, 1, 0, 0, 0)


class Wheel:
    def __init__(self, path, info):
        self.archive = zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED)
        self.info = info
        self.record = []

    def add(self, name, data, executable=False):
        item = zipfile.ZipInfo(name, WHEN)
        item.external_attr = (0o100755 if executable else 0o100644) << 16
        item.compress_type = zipfile.ZIP_DEFLATED
        self.archive.writestr(item, data)
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        self.record.append(f"{name},sha256={digest},{len(data)}")

    def close(self):
        name = f"{self.info}/RECORD"
        self.archive.writestr(zipfile.ZipInfo(name, WHEN), "\n".join([*self.record, f"{name},,", ""]))
        self.archive.close()


def metadata(version):
    return f"""Metadata-Version: 2.1
Name: halflight
Version: {version}
Summary: Mixed lighting for any engine: bake lightmaps, shadowmasks and probes into glTF
License: MIT
Requires-Python: >=3.8
Description-Content-Type: text/markdown

The `halflight` program, and a thin module that runs it:

    import halflight
    report = halflight.bake("scene.glb", "baked.glb", quality="preview")
"""


def main():
    prefix, version, platform, out = pathlib.Path(sys.argv[1]), sys.argv[2], sys.argv[3], pathlib.Path(sys.argv[4])
    tag = f"py3-none-{platform}"
    info = f"halflight-{version}.dist-info"
    path = out / f"halflight-{version}-{tag}.whl"
    wheel = Wheel(path, info)
    for file in sorted((HERE / "python" / "halflight").glob("*py*")):
        if file.is_file():  # modules, and py.typed
            wheel.add(f"halflight/{file.name}", file.read_bytes().replace(b"@VERSION@", version.encode()))
    for part in ("bin", "lib", "share/doc/halflight/licences"):
        for file in sorted((prefix / part).rglob("*")):
            if file.is_file():
                name = file.relative_to(prefix).as_posix()
                wheel.add(f"halflight/program/{name}", file.read_bytes(), executable=part != "share/doc/halflight/licences")
    wheel.add(f"{info}/METADATA", metadata(version).encode())
    wheel.add(f"{info}/WHEEL", f"Wheel-Version: 1.0\nGenerator: halflight\nRoot-Is-Purelib: false\nTag: {tag}\n".encode())
    wheel.add(f"{info}/entry_points.txt", b"[console_scripts]\nhalflight = halflight:main\n")
    # The project's licence and those of the code of others in the program.
    wheel.add(f"{info}/LICENSE", (prefix / "share/doc/halflight/copyright").read_bytes())
    wheel.close()
    print(path)


if __name__ == "__main__":
    main()
