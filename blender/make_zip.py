#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Packs the extension: one zip for Blender 4.2 and newer, and for 3.4 to 4.1 as an add-on.

    make_zip.py OUT.zip [--wheel halflight-….whl]

With --wheel, Blender 4.2 and newer install the program with the extension. Times in the zip are fixed, so that the same
files give the same bytes.
"""

import argparse
import pathlib
import zipfile

FOLDER = pathlib.Path(__file__).resolve().parent / "halflight_blender"
WHEN = (2026, 1, 1, 0, 0, 0)


def platform_of(wheel):
    """Blender's name of a wheel's platform."""
    names = {"x86_64.whl": "linux-x64", "win_amd64.whl": "windows-x64", "macosx_11_0_arm64.whl": "macos-arm64"}
    for end, name in names.items():
        if wheel.endswith(end):
            return name
    raise SystemExit(f"make_zip.py: blender.org has no Blender for the system of {wheel}")


def add(archive, name, data, compression=zipfile.ZIP_DEFLATED):
    item = zipfile.ZipInfo(f"{FOLDER.name}/{name}", WHEN)
    item.external_attr = 0o644 << 16
    item.compress_type = compression
    archive.writestr(item, data)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--wheel", type=pathlib.Path)
    options = parser.parse_args()
    with zipfile.ZipFile(options.out, "w") as archive:
        for path in sorted(FOLDER.rglob("*")):
            if not path.is_file() or path.suffix not in {".py", ".toml"} and path.name != "LICENSE":
                continue
            text = path.read_text(encoding="utf-8")
            if path.suffix == ".toml" and options.wheel:
                lines = f'wheels = ["./wheels/{options.wheel.name}"]\nplatforms = ["{platform_of(options.wheel.name)}"]'
                text = text.replace("wheels = []", lines)
            add(archive, path.relative_to(FOLDER).as_posix(), text)
        if options.wheel:
            add(archive, f"wheels/{options.wheel.name}", options.wheel.read_bytes(), zipfile.ZIP_STORED)


if __name__ == "__main__":
    main()
