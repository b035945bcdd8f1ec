#!/usr/bin/env python3
"""Doxygen's input filter: turns the comments of a header into ones that Doxygen reads.

The comment at a header's beginning describes the file. A comment of whole lines describes what follows it, unless an
empty line does. Comments inside functions stay as they are. Numbers of the specification's parts (`S1.`) go from their
beginnings. Lines after the first comment keep their numbers.
"""

import re
import sys

FUNCTION = re.compile(r"(    )?[^ ].*\)( const)?( noexcept)?( override)?$")


def begin_file_comment(lines):
    """Puts @file before the first comment, in the place of `#pragma once` or of the first empty line."""
    if lines[0].startswith("#pragma once"):
        lines[0] = "/// @file"
    else:
        lines.remove("")
        lines.insert(0, "/// @file")


def comments_of(lines):
    """Yields first line and end of each comment of whole lines that is not in a function."""
    in_function, i = False, 1
    while i < len(lines):
        if re.match(r"\s*//( |$)", lines[i]) and not in_function:
            first = i
            while re.match(r"\s*//( |$)", lines[i]):
                i += 1
            yield first, i
            continue
        if FUNCTION.match(lines[i]) and lines[i + 1].strip() == "{":
            in_function = True
        elif re.match(r"(    )?}", lines[i]):
            in_function = False
        i += 1


lines = open(sys.argv[1], encoding="utf-8").read().split("\n")
begin_file_comment(lines)
for first, end in list(comments_of(lines)):
    if first == 1 or lines[end].strip():
        lines[first] = re.sub(r"// S\d+(, S\d+)*\. ", "// ", lines[first])
        lines[first:end] = [line.replace("//", "///", 1) for line in lines[first:end]]
print("\n".join(lines), end="")
