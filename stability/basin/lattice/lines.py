"""Lines between regions of different labels, from the labels at the corners of cells."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...base.types import Floats
from .labels import Ints

NODES = np.array([[1, 0], [2, 1], [1, 2], [0, 1]])
"""Middles of the edges of a cell, in half cells: below, right, above, left."""
CENTRE = np.array([1, 1])


@dataclass(frozen=True, eq=False)
class BorderLine:
    """A line between the regions of two labels."""

    labels: tuple[int, int]
    """The two labels, the smaller first."""
    points: Floats
    """Points of the line, shape (n, 2): the middles of pairs of neighbours with different labels.

    Ends where more than two labels meet are centres of cells."""
    closed: bool
    """Whether the last point is joined to the first."""


def segments(cells: Ints, corners: Ints) -> tuple[Ints, Ints]:
    """Segments of the border in cells of a lattice (marching squares for any number of labels).

    A cell with two changes along its edge has one segment.  Where three or more regions meet, or
    two regions cross, the segments meet at its centre.  Two different labels at opposite corners
    of a third one are cut off separately.

    Parameters
    ----------
    cells
        Lower left corner of each cell in lattice units, shape (n, 2).
    corners
        Labels, shape (n, 4), anticlockwise from the lower left corner.

    Returns
    -------
    ends : ndarray
        Both ends of each segment in half lattice units, shape (m, 2, 2).
    labels : ndarray
        The two labels of each, the smaller first, shape (m, 2).

    Examples
    --------
    >>> ends, labels = segments(np.array([[0, 0]]), np.array([[0, 1, 1, 0]]))
    >>> ends.tolist(), labels.tolist()
    ([[[1, 0], [1, 2]]], [[0, 1]])
    """
    following = np.roll(corners, -1, axis=1)
    pairs = np.sort(np.stack([corners, following], axis=2), axis=2)
    changes = corners != following
    count = changes.sum(axis=1)
    even = corners[:, 0] == corners[:, 2]
    odd = corners[:, 1] == corners[:, 3]
    ends: list[Ints] = []
    labels: list[Ints] = []

    def add(chosen: NDArray[np.bool_], first: Ints, second: Ints, edge: int) -> None:
        ends.append(np.stack([2 * cells[chosen] + first, 2 * cells[chosen] + second], axis=1))
        labels.append(pairs[chosen, edge])

    for a in range(4):
        for b in range(a + 1, 4):
            add((count == 2) & changes[:, a] & changes[:, b], NODES[a], NODES[b], a)
    for lone, opposite in ((even & ~odd, (0, 1, 2, 3)), (odd & ~even, (3, 0, 1, 2))):
        for a, b in (opposite[:2], opposite[2:]):
            add((count == 4) & lone, NODES[a], NODES[b], a)
    central = (count == 3) | ((count == 4) & (even == odd))
    for a in range(4):
        add(central & changes[:, a], NODES[a], CENTRE, a)
    return np.concatenate(ends), np.concatenate(labels)


def chained(ends: Ints) -> list[tuple[Ints, bool]]:
    """Segments of one pair of labels, joined to lines that end where other than two meet.

    Parameters
    ----------
    ends
        Both ends of each segment, shape (m, 2, 2).

    Returns
    -------
    list of (ndarray, bool)
        Nodes of each line, shape (n, 2), and whether it is closed.

    Examples
    --------
    >>> [(nodes, closed)] = chained(np.array([[[1, 0], [1, 2]], [[2, 3], [1, 2]]]))
    >>> nodes.tolist(), closed
    ([[1, 0], [1, 2], [2, 3]], False)
    """
    nodes, index = np.unique(ends.reshape(-1, 2), axis=0, return_inverse=True)
    joined = index.reshape(-1, 2).tolist()
    at: list[list[int]] = [[] for _ in nodes]
    for number, (a, b) in enumerate(joined):
        at[a].append(number)
        at[b].append(number)
    used = [False] * len(joined)

    def line(node: int, segment: int) -> list[int]:
        found = [node]
        while not used[segment]:
            used[segment] = True
            a, b = joined[segment]
            found.append(b if found[-1] == a else a)
            here = at[found[-1]]
            if len(here) != 2:
                break
            segment = here[0] if used[here[1]] else here[1]
        return found

    lines: list[tuple[Ints, bool]] = []
    loose = [n for n, here in enumerate(at) if len(here) != 2]
    for node in (*loose, *range(len(nodes))):  # what is left after the loose ends are loops
        for segment in at[node]:
            if not used[segment]:
                found = line(node, segment)
                closed = found[0] == found[-1] and len(at[node]) == 2
                lines.append((nodes[found[:-1] if closed else found], closed))
    return lines


def by_pair(ends: Ints, labels: Ints) -> Sequence[tuple[tuple[int, int], Ints, bool]]:
    """The lines of every pair of labels, in order of the labels.

    Parameters
    ----------
    ends, labels
        As `segments` gives them.

    Returns
    -------
    sequence of (labels, nodes, closed)
    """
    found = []
    for a, b in np.unique(labels, axis=0).tolist():
        own = (labels == (a, b)).all(axis=1)
        found += [((a, b), nodes, closed) for nodes, closed in chained(ends[own])]
    return found
