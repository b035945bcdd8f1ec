"""Names of headings as GitHub makes them, so that links hold on the site too (mkdocs.yml)."""

import re


def slug(heading, separator):
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", separator)
