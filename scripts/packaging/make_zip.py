#!/usr/bin/env python3
"""Packs a folder into a zip, under the folder's name; times are fixed, so that the same files give the same bytes.

    make_zip.py FOLDER OUT.zip
"""

import pathlib
import sys
import zipfile

WHEN = (2026, 1, 1, 0, 0, 0)


def main():
    folder, out = pathlib.Path(sys.argv[1]), sys.argv[2]
    with zipfile.ZipFile(out, "w") as archive:
        for path in sorted(folder.rglob("*")):
            if path.is_file():
                item = zipfile.ZipInfo(path.relative_to(folder.parent).as_posix(), WHEN)
                item.external_attr = 0o644 << 16
                item.compress_type = zipfile.ZIP_DEFLATED
                archive.writestr(item, path.read_bytes())


if __name__ == "__main__":
    main()
