#!/usr/bin/env python3
"""Checks a static site: links inside it lead somewhere, and its pages fetch nothing from elsewhere.

    check_site.py SITE          exit 1 and one line per fault
    check_site.py --self-test   shows that each rule can fail

Links to other sites are allowed, but not pictures, scripts, style sheets, fonts or frames from there.
"""

import html.parser
import pathlib
import re
import sys
import tempfile
import urllib.parse

FETCHED = {"script", "img", "iframe", "source", "video", "audio", "embed", "input", "track"}  # by src
LINKS_ONLY = {"canonical", "prev", "next", "author", "license", "alternate"}  # rel of <link> that fetches nothing
ELSEWHERE = re.compile(r"(https?:)?//", re.I)


class Page(html.parser.HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.anchors, self.links, self.fetches, self.in_style = set(), [], [], False
        self.feed(text)

    def handle_starttag(self, tag, pairs):
        values = {name: value or "" for name, value in pairs}
        self.anchors.update(value for name, value in values.items() if name == "id" or (tag == "a" and name == "name"))
        if tag in ("a", "area") and values.get("href"):
            self.links.append(values["href"])
        if tag == "link" and values.get("rel", "").lower() not in LINKS_ONLY and "href" in values:
            self.fetches.append(values["href"])
        if tag in FETCHED and values.get("src"):
            self.fetches.append(values["src"])
        self.fetches += [part.split()[0] for part in values.get("srcset", "").split(",") if part.strip()]
        self.fetches += fetches_of_css(values.get("style", ""))
        self.in_style = tag == "style"

    def handle_endtag(self, tag):
        self.in_style = False

    def handle_data(self, data):
        if self.in_style:
            self.fetches += fetches_of_css(data)


def fetches_of_css(text):
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.S)
    found = re.findall(r"url\(\s*[\"']?([^\"')]+)|@import\s+[\"']([^\"']+)", text)
    return [a or b for a, b in found]


def problems_of(site):
    pages = {p.resolve(): Page(p.read_text(encoding="utf-8", errors="replace")) for p in site.rglob("*.html")}
    fetches = {path: page.fetches for path, page in pages.items()}
    fetches |= {p.resolve(): fetches_of_css(p.read_text(encoding="utf-8")) for p in site.rglob("*.css")}

    def missing(path, link):
        """What a link inside the site lacks, if anything."""
        parts = urllib.parse.urlsplit(link)
        if parts.path.startswith("/"):
            return "is not relative"
        target = (path.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else path
        if target.is_dir():
            return "leads to a folder"
        if not target.exists():
            return "leads nowhere"
        fragment = urllib.parse.unquote(parts.fragment)
        if fragment and target in pages and fragment not in pages[target].anchors | {"top"}:
            return "has an anchor that its page lacks"
        return None

    for path, links in fetches.items():
        for link in links:
            if ELSEWHERE.match(link):
                yield path, link, "is fetched from elsewhere"
            elif not re.match(r"data:|javascript:|#", link) and (fault := missing(path, link)):
                yield path, link, fault
    for path, page in pages.items():
        for link in page.links:
            if not re.match(r"[a-z]+:|//", link, re.I) and (fault := missing(path, link)):
                yield path, link, fault


def self_test():
    good = '<h1 id="a">A</h1><a href="#a">b</a> <a href="https://x.y/z">c</a><img src="data:,"><a href="page.html#a">'
    faults = ['<a href="none.html">', '<a href="#none">', '<a href="/page.html">', '<img src="https://x.y/z.png">',
              '<link rel="stylesheet" href="//x.y/z.css">', "<style>@import 'http://x.y/z'</style>",
              '<script src="none.js">',
              '<p style="background: url(https://x.y/z)">', '<a href=".">']
    for fault, count in [("", 0)] + [(fault, 1) for fault in faults]:
        with tempfile.TemporaryDirectory() as folder:
            pathlib.Path(folder, "page.html").write_text(good + fault, encoding="utf-8")
            found = list(problems_of(pathlib.Path(folder)))
            assert len(found) == count, (fault, found)


if __name__ == "__main__":
    if sys.argv[1:] == ["--self-test"]:
        sys.exit(self_test())
    site = pathlib.Path(sys.argv[1]).resolve()
    found = sorted({(path.relative_to(site).as_posix(), link, fault) for path, link, fault in problems_of(site)})
    for path, link, fault in found:
        print(f"{path}: {link} {fault}")
    print(f"site: {sum(1 for _ in site.rglob('*.html'))} pages, {len(found)} faults")
    sys.exit(1 if found else 0)
