"""Borders of known curves: within a step, complete, cheap, and the same however they are asked."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from stability.base.errors import ParameterError
from stability.basin.borders import Borders, borders

X, Y = ("x", -1.013, 1.027, 9), ("y", -1.041, 0.987, 7)
Label = Callable[[np.ndarray], np.ndarray]


def disc(points: np.ndarray) -> np.ndarray:
    return (np.hypot(points[:, 0] - 0.1, points[:, 1] + 0.05) < 0.7).astype(int)


def thirds(points: np.ndarray) -> np.ndarray:
    """Three sectors that meet in one point."""
    turn = np.arctan2(points[:, 1] - 0.123, points[:, 0] - 0.057) % (2 * np.pi)
    return (turn // (2 * np.pi / 3)).astype(int)


def snake(points: np.ndarray) -> np.ndarray:
    """A spiral arm that is thinner than a coarse cell."""
    radius, turn = np.hypot(*points.T), np.arctan2(points[:, 1], points[:, 0])
    phase = (radius - 0.1 * turn / np.pi) / 0.2 % 1
    return (phase < 0.15).astype(int) * (radius < 0.95)


class Counted:
    """A labelling function that records its points."""

    def __init__(self, label: Label) -> None:
        self.label, self.batches = label, []

    def __call__(self, points: np.ndarray) -> np.ndarray:
        self.batches.append(points.copy())
        return self.label(points)

    @property
    def points(self) -> np.ndarray:
        return np.concatenate(self.batches)


def full_map(label: Label, found: Borders) -> np.ndarray:
    """Labels of the whole finest lattice, [x, y]."""
    lines = [
        np.linspace(a.low, a.high, (a.count - 1) * 2**found.levels + 1) for a in (found.x, found.y)
    ]
    grid = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1)
    return label(grid.reshape(-1, 2)).reshape(grid.shape[:2])


def mixed_cells(labels: np.ndarray) -> np.ndarray:
    """Cells of a full lattice whose corners differ."""
    a, b, c, d = labels[:-1, :-1], labels[1:, :-1], labels[1:, 1:], labels[:-1, 1:]
    return (a != b) | (b != c) | (c != d)


@pytest.mark.parametrize("label", [disc, thirds])
def test_the_finest_mixed_cells_are_those_of_the_full_map(label: Label) -> None:
    found = borders(label, X, Y, levels=5)
    wanted = np.argwhere(mixed_cells(full_map(label, found)))
    assert sorted(found.cells.tolist()) == wanted.tolist()
    whole = mixed_cells(full_map(label, found))
    for level in range(6):
        size = 2 ** (5 - level)
        assert found.counts[level] == mixed_cells(full_map(label, found)[::size, ::size]).sum()
        # boxes that hold a mixed finest cell
        boxes = whole.reshape(whole.shape[0] // size, size, whole.shape[1] // size, size)
        assert found.mixed[level] == boxes.any(axis=(1, 3)).sum()


def test_a_border_that_is_found_is_followed_to_its_ends() -> None:
    """A connected border of the full map is found whole or not at all."""
    found = borders(snake, X, Y, levels=6)
    labels = full_map(snake, found)
    whole = mixed_cells(labels)
    got = np.zeros_like(whole)
    got[tuple(found.cells.T)] = True
    assert not (got & ~whole).any()
    # a border goes on into the next cell where the ends of their common edge differ
    number = np.arange(whole.size).reshape(whole.shape)
    right = labels[1:-1, :-1] != labels[1:-1, 1:]
    above = labels[:-1, 1:-1] != labels[1:, 1:-1]
    first = np.concatenate([number[:-1][right], number[:, :-1][above]])
    second = np.concatenate([number[1:][right], number[:, 1:][above]])
    joined = coo_array((np.ones(len(first)), (first, second)), shape=(whole.size,) * 2)
    _, piece = connected_components(joined, directed=False)
    share = np.bincount(piece[whole.ravel()], got[whole], piece.max() + 1)
    size = np.bincount(piece[whole.ravel()], minlength=piece.max() + 1)
    assert ((share == 0) | (share == size)).all()
    assert got.sum() > 0.9 * whole.sum()
    ways = [line for line in found.lines if not line.closed]
    for line in ways:  # an open line ends on the rim of the map
        for x, y in (line.points[0], line.points[-1]):
            assert x in X[1:3] or y in Y[1:3]


def test_no_launch_is_asked_twice_and_the_record_holds_them_all() -> None:
    ask = Counted(snake)
    found = borders(ask, X, Y, levels=4)
    assert len(np.unique(ask.points, axis=0)) == len(ask.points) == found.asked
    assert sum(found.calls) == found.asked
    assert len(found.calls) == len(ask.batches)
    order = np.lexsort(ask.points.T[::-1])
    assert (found.points == ask.points[order]).all()
    assert (found.labels == snake(found.points)).all()


@pytest.mark.long
def test_cost_is_that_of_a_curve() -> None:
    cost = [borders(disc, X, Y, levels=n).asked for n in (6, 7, 8, 9, 10)]
    slope = np.diff(np.log2(cost))
    assert (np.abs(slope - 1) < 0.05).all()  # a full map has 2
    assert cost[-1] < 0.004 * borders(disc, X, Y, levels=10).full


def test_pairs_are_one_step_apart_with_the_labels_they_say() -> None:
    found = borders(thirds, X, Y, width=(0.01, 0.02))
    apart = np.abs(found.pairs[:, 1] - found.pairs[:, 0])
    assert ((apart > 0).sum(axis=1) == 1).all()
    assert (apart.max(axis=0) <= (0.01, 0.02)).all()
    assert (apart.max(axis=0) >= found.widths[-1] * (1 - 1e-9)).all()
    for end in (0, 1):
        assert (thirds(found.pairs[:, end]) == found.pair_labels[:, end]).all()
    assert (found.pair_labels[:, 0] != found.pair_labels[:, 1]).all()


def test_the_line_of_a_circle_is_closed_and_within_half_a_step() -> None:
    found = borders(disc, X, Y, levels=7)
    (line,) = found.lines
    assert line.closed
    assert line.labels == (0, 1)
    radius = np.hypot(*(line.points - [0.1, -0.05]).T)
    assert np.abs(radius - 0.7).max() <= found.widths[-1].max() / 2
    closed = np.vstack([line.points, line.points[:1]])
    x, y = closed.T
    area = abs(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1])) / 2
    assert area == pytest.approx(np.pi * 0.49, rel=1e-3)


def test_three_regions_meet_in_one_point() -> None:
    found = borders(thirds, X, Y, levels=8)
    assert sorted(line.labels for line in found.lines) == [(0, 1), (0, 2), (1, 2)]
    ends = np.array([end for line in found.lines for end in line.points[[0, -1]]])
    meeting = ends[np.abs(ends).max(axis=1) < 0.98]
    assert len(meeting) == 3
    assert (meeting == meeting[0]).all()
    assert (np.abs(meeting[0] - (0.057, 0.123)) <= found.widths[-1]).all()


@pytest.mark.parametrize("levels", [(3, 1), pytest.param((7, 4), marks=pytest.mark.long)])
def test_fewer_levels_are_the_beginning_of_more(levels: tuple[int, int]) -> None:
    deep = Counted(snake)
    shallow = Counted(snake)
    borders(deep, X, Y, levels=levels[0])
    few = borders(shallow, X, Y, levels=levels[1])
    assert (deep.points[: few.asked] == shallow.points).all()


@pytest.mark.parametrize("levels", [(3, 1), pytest.param((7, 4), marks=pytest.mark.long)])
def test_a_known_result_is_resumed_to_the_same_result(levels: tuple[int, int]) -> None:
    whole = borders(snake, X, Y, levels=levels[0])
    few = borders(snake, X, Y, levels=levels[1])
    more = Counted(snake)
    resumed = borders(more, X, Y, levels=levels[0], known=few)
    assert resumed.asked == whole.asked - few.asked
    for name in ("points", "labels", "cells", "pairs", "pair_labels"):
        assert (getattr(resumed, name) == getattr(whole, name)).all()
    less = borders(disc, X, Y, levels=2, known=borders(disc, X, Y, levels=3))
    assert less.asked == 0
    assert less.counts == borders(disc, X, Y, levels=2).counts


def test_labels_of_the_coarse_map_are_taken_over() -> None:
    x, y = np.linspace(*X[1:]), np.linspace(*Y[1:])
    grid = np.stack(np.meshgrid(x, y), axis=-1)
    known = thirds(grid.reshape(-1, 2)).reshape(7, 9)
    ask = Counted(thirds)
    found = borders(ask, X, Y, levels=5, known=known)
    assert found.asked == borders(thirds, X, Y, levels=5).asked - 63
    assert (found.cells == borders(thirds, X, Y, levels=5).cells).all()


def test_chunks_change_nothing() -> None:
    ask = Counted(snake)
    found = borders(ask, X, Y, levels=3, chunk=17)
    assert max(map(len, ask.batches)) == 17
    assert (found.points == borders(snake, X, Y, levels=3).points).all()


@pytest.mark.parametrize(("level", "asked"), [(2, 4), pytest.param(5, 9, marks=pytest.mark.long)])
def test_too_few_labels_leave_the_last_complete_level(level: int, asked: int) -> None:
    cost = borders(snake, X, Y, levels=level).asked
    ask = Counted(snake)
    found = borders(ask, X, Y, levels=asked, most=cost + 20)
    wanted = borders(snake, X, Y, levels=level)
    assert not found.complete
    assert f"{level} of {asked}" in found.note
    assert found.levels == level
    assert len(ask.points) <= cost + 20
    assert (found.counts, found.mixed) == (wanted.counts, wanted.mixed)
    assert (found.cells == wanted.cells).all()
    assert (found.pairs == wanted.pairs).all()
    assert len(found.lines) == len(wanted.lines)


def test_a_logarithmic_axis_has_even_ratios() -> None:
    found = borders(
        lambda p: p[:, 0] * p[:, 1] > 1,
        ("mu", 0.01, 100, 5, "log"),
        ("k", 0.01, 100, 5, "log"),
        levels=6,
    )
    for line in found.lines:
        assert np.abs(np.log10(line.points.prod(axis=1))).max() <= 2**-6 * (1 + 1e-9)
    assert np.unique(found.pairs.reshape(-1, 2)[:, 0]).min() == 0.01


def test_maps_without_a_border() -> None:
    found = borders(lambda p: np.zeros(len(p), int), X, Y, levels=4)
    assert (found.asked, found.mixed, found.lines) == (63, (0,) * 5, ())
    assert found.pairs.shape == (0, 2, 2)


def test_a_checkerboard_of_crossing_regions_has_lines_that_end_where_they_cross() -> None:
    found = borders(lambda p: (p[:, 0] > 0.03).astype(int) ^ (p[:, 1] > 0.02), X, Y, levels=6)
    assert len(found.lines) == 4
    inner = [e for n in found.lines for e in n.points[[0, -1]] if np.abs(e).max() < 0.98]
    assert len(inner) == 4
    assert (np.array(inner) == inner[0]).all()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({}, "levels or width"),
        ({"levels": 3, "width": 0.1}, "levels or width"),
        ({"levels": -1}, "levels"),
        ({"levels": 29}, "2\\^30"),
        ({"width": 0.0}, "width"),
        ({"width": (0.1, 0.1, 0.1)}, "one number or two"),
        ({"levels": 3, "known": np.zeros((9, 7), int)}, "shape \\(7, 9\\)"),
        ({"levels": 3, "most": 10}, "63 launches"),
        ({"levels": 3, "chunk": 0}, "chunk"),
    ],
)
def test_refusals_say_what_is_wrong(options: dict[str, object], words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        borders(disc, X, Y, **options)


def test_a_label_that_is_no_number_is_refused() -> None:
    with pytest.raises(ParameterError, match="whole number for each"):
        borders(lambda p: p[:, 0], X, Y, levels=2)
    with pytest.raises(ParameterError, match="63 launches"):
        borders(lambda p: np.zeros(3, int), X, Y, levels=2)  # noqa: ARG005
