"""Blocks of commands on a plain page, and the comments above them; needs no Sphinx.

A comment above a block says what the build does otherwise::

    <!-- run with 1000 -> 20; 2001 -> 101 -->    the same commands with these words replaced
    <!-- not run: the reason -->                 shown with its reason
    <!-- file wheel.py: the first 2 -->          the page's first two Python blocks are this file
"""

from __future__ import annotations

import re

BLOCK = re.compile(
    r"(?:^<!-- (not run: |run with )([^\n]*) -->\n)?^```sh\n(.*?)^```$", re.DOTALL | re.MULTILINE
)
"""A block of commands, with the comment above it."""
FILE = re.compile(r"^<!-- file (\S+): the first (\d+) -->$", re.MULTILINE)
PYTHON = re.compile(r"^```(?:\{code-cell\} )?python\n(.*?)^```$", re.DOTALL | re.MULTILINE)


def replacements(words: str) -> list[tuple[str, str]]:
    """Pairs of a comment `run with`."""
    pairs = [pair.split("->") for pair in words.split(";")]
    if any(len(pair) != 2 for pair in pairs):
        raise ValueError(f"run with {words!r}: say old -> new; old -> new")
    return [(old.strip(), new.strip()) for old, new in pairs]


def changed(text: str, words: str) -> str:
    """Commands with words replaced; each of these words must be there."""
    for old, new in replacements(words):
        if old not in text:
            raise ValueError(f"run with {words!r}: {old!r} is not in the commands {text!r}")
        text = text.replace(old, new)
    return text


def files(text: str) -> dict[str, str]:
    """Files that are the first blocks of Python of a page, by name."""
    return {
        name: "\n".join(PYTHON.findall(text)[: int(count)]) for name, count in FILE.findall(text)
    }
