"""The order in which Sphinx reads pages, so that each of its processes has as much to run."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from sphinx.util.parallel import make_chunks

KERNEL, CELL, COMMAND, FIGURE = 3.0, 0.8, 2.0, 4.0
"""About how long a page's kernel takes to start, a cell, a command, and a figure [s]."""


def weight(text: str) -> float:
    """About how long a page takes to read, from its text [s].

    Parameters
    ----------
    text
        The page in Markdown.

    Examples
    --------
    >>> weight("words"), weight("```{code-cell} python"), weight("![a map](../map.png)")
    (0.0, 3.8, 4.0)
    """
    cells = len(re.findall(r"^`{3,}(?:\{code-cell\}|python)", text, re.MULTILINE))
    blocks = re.findall(r"^```\{run\}(.*?)^```", text, re.DOTALL | re.MULTILINE)
    commands = sum(len(re.findall(r"^(?:stability|python)\b", b, re.MULTILINE)) for b in blocks)
    figures = len(re.findall(r"^!\[", text, re.MULTILINE))
    return KERNEL * bool(cells) + CELL * cells + COMMAND * commands + FIGURE * figures


def dealt(names: list[str], weights: dict[str, float], processes: int) -> list[str]:
    """Pages in an order whose first chunks, one a process, share the heavy pages evenly.

    Parameters
    ----------
    names
        Pages.
    weights
        Weight of each.
    processes
        Number of processes that read.

    Examples
    --------
    >>> pages = [f"p{i}" for i in range(12)]
    >>> dealt(pages, {p: float(i % 4 == 0) for i, p in enumerate(pages)}, 3)[::4]
    ['p0', 'p4', 'p8']
    """
    sizes = [len(c) for c in make_chunks(names, processes)]
    chunks: list[list[str]] = [[] for _ in sizes]
    sums = [0.0] * len(sizes)
    for name in sorted(names, key=lambda n: -weights[n]):
        first = range(min(processes, len(sizes))) if weights[name] else range(len(sizes))
        open_ = [i for i in first if len(chunks[i]) < sizes[i]] or [
            i for i in range(len(sizes)) if len(chunks[i]) < sizes[i]
        ]
        place = min(open_, key=lambda i: sums[i])
        chunks[place].append(name)
        sums[place] += weights[name]
    return [name for chunk in chunks for name in chunk]


def ordered(app: Any, env: Any, docnames: list[str]) -> None:
    """Put the pages in this order before Sphinx cuts the list into chunks."""
    if app.parallel > 1 and docnames:
        weights = {n: weight(Path(env.doc2path(n)).read_text(encoding="utf-8")) for n in docnames}
        docnames[:] = dealt(docnames, weights, app.parallel)
