#!/usr/bin/env python3
"""Checks the documents: relative links lead somewhere, lines and the guide's pages are short.

    docs_links.py ROOT          exit 1 and one line per fault
    docs_links.py --self-test   shows that each rule can fail

The table of systems (SYSTEMS is its first row's beginning) says the same wherever it stands. A page of docs/guide has
at most 200 lines. Lines of the root's documents and of docs/ have at most 120 columns, but for
the lab notes and their tables.
"""

import os
import pathlib
import re
import sys
import tempfile
import urllib.parse

MOST_LINES, MOST_COLUMNS = 200, 120
SYSTEMS = "| system | command line |"
IGNORED = {"build", "out", "node_modules", "shared"}  # besides folders that begin with a dot


def documents_of(root):
    for folder, folders, names in os.walk(root):
        folders[:] = sorted(f for f in folders if f not in IGNORED and not f.startswith("."))
        yield from (pathlib.Path(folder, name).resolve() for name in sorted(names) if name.endswith(".md"))


def without_code(text):
    """Code blocks become empty lines."""
    return re.sub(r"^( *)```.*?^ *```$", lambda block: "\n" * block[0].count("\n"), text, flags=re.M | re.S)


def anchors_of(text):
    slugs = []
    for heading in re.findall(r"^#+ +(.*?) *$", without_code(text), flags=re.M):
        heading = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading).lower()  # a link counts by its text
        slugs.append(re.sub(r"[^\w\- ]", "", heading).replace(" ", "-"))
    numbered = {f"{slug}-{slugs[:i].count(slug)}" for i, slug in enumerate(slugs) if slug in slugs[:i]}
    return set(slugs) | numbered | set(re.findall(r'<a id="([^"]+)">', text))


def systems_in(path, text):
    """The rows of the table of systems, with links as whole paths; none where there is no such table."""
    rows = re.search(rf"^{re.escape(SYSTEMS)}(?:.*\n\|)*.*$", text, flags=re.M)
    whole = lambda link: f"]({(path.parent / link[1]).resolve()})"  # noqa: E731
    return re.sub(r"\]\(([^)#]+)\)", whole, rows[0]) if rows else None


def problems_of(root):
    texts = {path: path.read_text(encoding="utf-8") for path in documents_of(root)}
    tables = {path: rows for path, text in texts.items() if (rows := systems_in(path, text))}
    for path, rows in tables.items():
        if rows != next(iter(tables.values())):
            yield f"{path.relative_to(root.resolve())}: its table of systems differs from {next(iter(tables)).name}'s"
    for path, text in texts.items():
        name = path.relative_to(root.resolve()).as_posix()
        prose = re.sub(r"`[^`\n]*`", "", without_code(text))
        for link in re.findall(r"\]\(\s*<?([^)\s>]+)|^\[[^]]+\]: +(\S+)", prose, flags=re.M):
            link = "".join(link)
            file, _, anchor = urllib.parse.unquote(link).partition("#")
            target = (path.parent / file).resolve() if file else path
            if re.match(r"[a-z]+:", file):
                continue
            if not target.exists() or (anchor and target in texts and anchor not in anchors_of(texts[target])):
                yield f"{name}: {link}: there is no such {'heading' if target.exists() else 'file'}"
        if name.startswith("docs/guide/") and text.count("\n") > MOST_LINES:
            yield f"{name}: {text.count(chr(10))} lines, at most {MOST_LINES}"
        if "/" not in name or (name.startswith("docs/") and not name.startswith("docs/lab/")):
            for i, line in enumerate(text.split("\n")):
                if len(line) > MOST_COLUMNS:
                    yield f"{name}:{i + 1}: {len(line)} columns, at most {MOST_COLUMNS}"


def self_test():
    good = '[a](page.md#one-pages-name) [b](#a-1) [c](..) [d](https://x.y/z) <a id="w"></a>[e](#w) `[f](g)`\n'
    good += "x" * MOST_COLUMNS + "\n```\n[a](none.md)\n```\n[g]: #w\n"
    faults = ("[a](none.md)", "[a]: none.md", "[a](#none)", "[a](page.md#a-2)", "\n" * MOST_LINES, "x" * (MOST_COLUMNS + 1))
    for fault, count in [("", 0)] + [(fault, 1) for fault in faults]:
        with tempfile.TemporaryDirectory() as folder:
            page = pathlib.Path(folder, "docs/guide/page.md")
            page.parent.mkdir(parents=True)
            page.write_text("# One Page's `name`\n\n## A\n\n## A\n" + good + fault, encoding="utf-8")
            problems = list(problems_of(pathlib.Path(folder)))
            assert len(problems) == count, (fault, problems)
            table = SYSTEMS + "\n|---|---|\n| [A](%spage.md) | %s |\n\ntext\n"
            for word, others in (("built", 0), ("tested", 1)):
                pathlib.Path(folder, "README.md").write_text(table % ("docs/guide/", "built"), encoding="utf-8")
                pathlib.Path(folder, "docs/packages.md").write_text(table % ("guide/", word), encoding="utf-8")
                assert len(list(problems_of(pathlib.Path(folder)))) == count + others


if __name__ == "__main__":
    if sys.argv[1:] == ["--self-test"]:
        sys.exit(self_test())
    found = list(problems_of(pathlib.Path(sys.argv[1])))
    print("\n".join(found) or "every link leads somewhere")
    sys.exit(1 if found else 0)
