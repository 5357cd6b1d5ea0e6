"""Verdicts that are proved on whole rectangles of a diagram, packed for the page."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..base.axis import Axis
from ..base.verdict import CODES
from ..bodies.contact_laws import LAWS
from ..bodies.disk import Disk
from ..maps.proved_boxes import Boxes, prove_boxes
from ..spectra.arguments import prepare
from .subject import Subject

LEVELS = 7
"""Halvings of a diagram in both directions."""
SPLIT, LETTERS = "+", {code: verdict.name[0] for verdict, code in CODES.items()} | {0: "?"}
"""A rectangle that is halved, and the letter of each proved verdict by its flag."""


def certificate(subject: Subject, held: Mapping[str, float], levels: int = LEVELS) -> Any:
    """What is proved over the axes of a diagram of the disk at fixed other quantities.

    Parameters
    ----------
    subject
        The family under its law.
    held
        Values of the quantities that are not on an axis.
    levels
        Halvings.

    Returns
    -------
    dict
        Axes, held values, and the tree of rectangles.
    """
    known = {q.name: q for q in subject.quantities}
    axes = [
        Axis(n, known[n].low, known[n].high, (1 << levels) + 1, log=False) for n in subject.axes
    ]
    law: Any = LAWS[subject.law]
    contact = law(held["mu"]) if "mu" in held else subject.law
    disk = Disk(k=held["k"]) if "k" in held else None
    problem = prepare(subject.family, axes, disk, contact, held.get("at"), {})
    boxes = prove_boxes(problem, (axes[0], axes[1]), levels)
    return {
        "axes": [[a.name, a.low, a.high] for a in axes], "held": dict(held), "levels": levels,
        "proved": boxes.proved, "tree": packed(boxes, axes[0], axes[1]),
    }  # fmt: skip


def packed(boxes: Boxes, x: Axis, y: Axis) -> str:
    """The rectangles as a tree, the first corner first: `+` for one that is cut in four.

    Parameters
    ----------
    boxes
        Rectangles that cover the axes.
    x, y
        The axes.

    Examples
    --------
    >>> axis = Axis("at", 0.0, 2.0, 3)
    >>> low, high = [0, 1], [1, 2]
    >>> x, y = np.array([low, high, low, high]), np.array([low, low, high, high])
    >>> packed(Boxes(x, y, np.array([1, 2, 0, 3], dtype=np.int8), 1, 0.75), axis, axis)
    '+SU?N'
    """
    found: dict[tuple[int, int, int], int] = {}
    for (x0, x1), (y0, _), code in zip(boxes.x, boxes.y, boxes.codes.tolist(), strict=True):
        level = round(float(np.log2((x.high - x.low) / (x1 - x0))))
        i = round((x0 - x.low) / (x.high - x.low) * 2**level)
        j = round((y0 - y.low) / (y.high - y.low) * 2**level)
        found[level, i, j] = code
    letters: list[str] = []
    waiting = [(0, 0, 0)]
    while waiting:
        level, i, j = place = waiting.pop()
        if place in found:
            letters.append(LETTERS[found[place]])
            continue
        letters.append(SPLIT)
        corners = ((0, 0), (1, 0), (0, 1), (1, 1))
        waiting += [(level + 1, 2 * i + a, 2 * j + b) for a, b in reversed(corners)]
    return "".join(letters)
