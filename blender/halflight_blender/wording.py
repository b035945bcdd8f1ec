# SPDX-License-Identifier: GPL-3.0-or-later
"""What the program says, in Blender's terms: the panel's names in place of command-line options."""

import re

# Nobody in Blender can do anything about these.
UNSHOWN = (
    r"kept in the file but not read, as baked light does not need them",
    r"objects have no name of their own, so that the sidecar tells them",
    r"normal-mapped primitives got generated tangents",
)
# The view reads one mask layer, so that a bake of it has no more.
LEFT_OUT = r"; or bake with --mask-layers auto"
# Options that are no property of the bake's settings by their name.
OTHERS = {"only": "Bake Selected", "padding": "the page's padding", "uv": "the layout"}


def in_blender(text, labels):
    """The sentence to show, or None. `labels`: names of the bake's settings in the panel, by the option's name."""
    if any(re.search(pattern, text) for pattern in UNSHOWN):
        return None

    def name_of(match):
        name = match[1]
        return labels.get(name) and f"*{labels[name]}*" or OTHERS.get(name, name.replace("-", " "))

    return re.sub(r"--([a-z][a-z-]*[a-z])", name_of, re.sub(LEFT_OUT, "", text))


def wrapped(text, width):
    """Lines of at most `width` characters, where words allow."""
    lines = [""]
    for word in text.split():
        if lines[-1] and len(lines[-1]) + 1 + len(word) > width:
            lines.append(word)
        else:
            lines[-1] += (" " if lines[-1] else "") + word
    return lines
