#!/usr/bin/env python3
"""Copies the documents that README.md leads to into a folder for MkDocs: stage_pages.py ROOT OUT

Pages keep their places, so relative links between them hold. Other targets of links:

- a public header becomes its page of the API reference
- docs/site.md#live-demo, #api and #conformance-pack become what they speak of
- a folder becomes its README.md, or a list of its files
- any other file is copied; source text gets `.txt` at its end, so that browsers show it
"""

import os
import pathlib
import re
import shutil
import sys
import urllib.parse

HEADERS = "include/halflight/"
MADE_PAGES = {"live-demo": "viewer/index.html", "api": "api/index.html", "conformance-pack": "conformance.zip"}
SHOWN_BY_BROWSERS = {".png", ".jpg", ".webp", ".svg", ".json"}
DOWNLOADS = {".glb", ".exr"}
LINK = re.compile(r"(\]\(\s*<?|^\[[^]\n]+\]: +)([^)\s>]+)", re.M)
CODE = re.compile(r"^( *)```.*?^ *```$|`[^`\n]*`", re.M | re.S)


class Stage:
    def __init__(self, root, out):
        self.root, self.out = root.resolve(), out.resolve()
        self.waiting, self.seen = [], set()

    def page(self, path):
        """Notes that a page is needed, and returns its path."""
        if path not in self.seen:
            self.seen.add(path)
            self.waiting.append(path)
        return path

    def copy(self, path):
        """Copies a file and returns the path of the copy in the site."""
        suffix = pathlib.Path(path).suffix
        copied = path if suffix in SHOWN_BY_BROWSERS | DOWNLOADS else path + ".txt"
        (self.out / copied).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(self.root / path, self.out / copied)
        return copied

    def listing(self, folder):
        """A page with links to the files of a folder that has no README.md."""
        page = f"{folder}/README.md"
        if page not in self.seen:
            self.seen.add(page)
            files = sorted(f for f in (self.root / folder).glob("[!.]*") if f.is_file())
            copies = [self.copy(f.relative_to(self.root).as_posix()) for f in files]
            names = [(f.name, pathlib.Path(c).name, f.stat().st_size) for f, c in zip(files, copies)]
            lines = [f"- [{name}]({copy}) ({size:,} bytes)\n" for name, copy, size in names]
            self.write(page, f"# {folder}\n\n" + "".join(lines))
        return page

    def target(self, page, link):
        """The link that a link of a page becomes."""
        path, mark, anchor = link.partition("#")
        if not path or re.match(r"[a-z]+:", path):
            return link
        place = os.path.relpath((self.root / page).parent / urllib.parse.unquote(path), self.root)
        if place == "docs/site.md" and anchor in MADE_PAGES:
            place, anchor = MADE_PAGES[anchor], ""
        elif place.startswith(HEADERS):
            name = pathlib.Path(place).name.replace("_", "__").replace(".", "_8")
            place = f"api/{name}.html"
        elif (self.root / place).is_dir():
            has_page = (self.root / place / "README.md").exists()
            place = self.page(f"{place}/README.md") if has_page else self.listing(place)
        elif place.endswith(".md"):
            self.page(place)
        else:
            place = self.copy(place)
        return os.path.relpath(place, os.path.dirname(page)) + (f"#{anchor}" if anchor else "")

    def write(self, page, text):
        (self.out / page).parent.mkdir(parents=True, exist_ok=True)
        (self.out / page).write_text(text, encoding="utf-8")

    def run(self):
        self.page("README.md")
        self.page("docs/site.md")
        while self.waiting:
            page = self.waiting.pop()
            text = (self.root / page).read_text(encoding="utf-8")
            codes = []
            text = CODE.sub(lambda code: codes.append(code[0]) or f"\0{len(codes) - 1}\0", text)
            text = LINK.sub(lambda link: link[1] + self.target(page, link[2]), text)
            text = re.sub(r"\0(\d+)\0", lambda number: codes[int(number[1])], text)
            self.write(page, for_python_markdown(text))


def for_python_markdown(text):
    """Python-Markdown wants an empty line before a list, and four blanks before a list in a list."""
    lines, in_code = [], False
    for line in text.split("\n"):
        if line.startswith("```"):
            in_code = not in_code
        item = re.match(r"( *)([-*]|\d+\.) ", line)
        if item and not in_code:
            before = lines[-1] if lines else ""
            if before and not re.match(r" *([-*]|\d+\.) |  ", before):
                lines.append("")
            line = " " * len(item[1]) + line
        lines.append(line)
    return "\n".join(lines)


if __name__ == "__main__":
    Stage(pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])).run()
