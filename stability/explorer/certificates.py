"""Verdicts that are proved on whole rectangles of a diagram, packed for the page."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ..base.axis import Axis
from ..base.errors import StabilityError, StabilityWarning
from ..base.verdict import CODES
from ..maps.boxes import ProvedBoxes, prove_boxes
from ..spectra.axes import swept
from ..spectra.problem import Problem
from .subject import PageSubject

OWN_LEVELS = 5
"""Halvings of a diagram in both directions where the verdict is proved from a graph."""
SPLIT, LETTERS = "+", {code: verdict.name[0] for verdict, code in CODES.items()} | {0: "?"}
"""A rectangle that is halved, and the letter of each proved verdict by its flag."""


def certificate(
    subject: PageSubject,
    held: Mapping[str, float],
    levels: int,
    problem: Callable[[list[Axis], dict[str, float]], Problem],
) -> Any:
    """What is proved over the axes of a diagram at fixed other quantities.

    Parameters
    ----------
    subject
        The family under its law.
    held
        Values of the quantities that are not on an axis.
    levels
        Halvings.
    problem
        Function of the axes and of these values to what `stability_map` would be asked.

    Returns
    -------
    dict
        Axes, held values, and the tree of rectangles.
    """
    quantities = subject.called
    axes = [
        Axis(n, quantities[n].low, quantities[n].high, (1 << levels) + 1, log=False)
        for n in subject.axes
    ]
    boxes = prove_boxes(problem(axes, dict(held)), (axes[0], axes[1]), levels)
    return {
        "axes": [[a.name, a.low, a.high] for a in axes],
        "held": dict(held),
        "levels": levels,
        "proved": boxes.proved,
        "tree": packed(boxes, axes[0], axes[1]),
    }


def own_certificates(subject: PageSubject) -> list[Any]:
    """What is proved over the first axes of a family by its graph; none where nothing is.

    Its quantities have in calls the names that they have in the family.
    """
    family = subject.family

    def problem(axes: list[Axis], held: dict[str, float]) -> Problem:
        at = [held.pop(n) for n in family.at if n in held]
        member = at[0] if len(at) == 1 else None
        return swept(family, {a.name: a for a in axes}, at=member, parameters=held)[0]

    held = {n: float(q.value) for n, q in subject.called.items() if n not in subject.axes}
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", StabilityWarning)
            return [certificate(subject, held, OWN_LEVELS, problem)]
    except StabilityError:
        return []


def packed(boxes: ProvedBoxes, x: Axis, y: Axis) -> str:
    """The rectangles as a tree, the first corner first: `+` for one that is cut in four.

    Examples
    --------
    >>> axis = Axis("at", 0.0, 2.0, 3)
    >>> low, high = [0, 1], [1, 2]
    >>> x, y = np.array([low, high, low, high]), np.array([low, low, high, high])
    >>> packed(ProvedBoxes(x, y, np.array([1, 2, 0, 3], dtype=np.int8), 1, 0.75), axis, axis)
    '+SU?N'
    """
    codes: dict[tuple[int, int, int], int] = {}
    for (x0, x1), (y0, _), code in zip(boxes.x, boxes.y, boxes.codes.tolist(), strict=True):
        level = round(float(np.log2((x.high - x.low) / (x1 - x0))))
        i = round((x0 - x.low) / (x.high - x.low) * 2**level)
        j = round((y0 - y.low) / (y.high - y.low) * 2**level)
        codes[level, i, j] = code
    letters: list[str] = []
    waiting = [(0, 0, 0)]
    while waiting:
        level, i, j = place = waiting.pop()
        if place in codes:
            letters.append(LETTERS[codes[place]])
            continue
        letters.append(SPLIT)
        corners = ((0, 0), (1, 0), (0, 1), (1, 1))
        waiting += [(level + 1, 2 * i + a, 2 * j + b) for a, b in reversed(corners)]
    return "".join(letters)
