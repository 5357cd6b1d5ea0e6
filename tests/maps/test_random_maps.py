"""Random maps cell by cell against exact signs, and their curves against them on either side."""

from __future__ import annotations

import random
from fractions import Fraction
from itertools import islice
from typing import Any

import numpy as np
import pytest
from exact_oracle import exact
from flint import fmpq
from random_maps import NEUTRAL, RandomMap, maps

import stability as st

NARROW = 16
"""Largest half-width of a bracket that is looked at, in units in the last place."""
POINTS = 6
"""Boundary points of a map that are looked at."""
OPEN = {0, 4}
"""Codes of a cell that says nothing: undecided, and no member."""


def judged(some: RandomMap, draw: random.Random) -> tuple[Any, dict[str, int], list[str]]:
    """The map, what was compared, and what was wrong."""
    counts = dict.fromkeys(("cells", "neutral", "open", "points"), 0)
    wrong: list[str] = []
    found = some.call()
    x, y = (str(n) for n in reversed(found.abscissa.dims))
    xs, ys = found[x].values, found[y].values
    for (i, j), code in np.ndenumerate(found.verdict.values):
        wanted = some.truth(exact(xs[j]), exact(ys[i]))
        counts["cells"] += 1
        counts["neutral"] += wanted == NEUTRAL
        counts["open"] += int(code) in OPEN
        if int(code) not in OPEN and code != wanted:
            wrong.append(f"{some.text}: {x}={xs[j]!r} {y}={ys[i]!r}: {code} for {wanted}")
        off = float(found.abscissa.values[i, j]), float(found.abscissa_error.values[i, j])
        if abs(off[0]) > off[1] and (off[0] > 0) != (wanted == 2):
            wrong.append(f"{some.text}: {x}={xs[j]!r} {y}={ys[i]!r}: {off} for {wanted}")
    points = range(found.sizes["boundary_point"])
    for k in draw.sample(points, min(POINTS, len(points))):
        place = [float(found[f"boundary_{n}"].values[k]) for n in (x, y)]
        axis, error = int(found.boundary_axis.values[k]), float(found.boundary_error.values[k])
        if not error <= NARROW * np.spacing(abs(place[axis])):
            continue  # where curves cross, verdicts alternate at this distance in other directions
        ends = []
        for side in (-1, 1):
            at: list[Any] = [exact(v) for v in place]
            moved = Fraction(place[axis]) + side * Fraction(error)
            at[axis] = fmpq(moved.numerator, moved.denominator)
            ends.append(some.truth(*at))
        counts["points"] += 1
        if (ends[0] == 2) == (ends[1] == 2):
            wrong.append(f"{some.text}: boundary at {place} ± {error} along {axis}: {ends}")
    return found, counts, wrong


@pytest.mark.parametrize(
    ("count", "seed"), [(40, 1), *(pytest.param(500, s, marks=pytest.mark.long) for s in range(10))]
)
def test_every_cell_of_random_maps_has_the_exact_sign(count: int, seed: int) -> None:
    total, wrong, done = dict.fromkeys(("cells", "neutral", "open", "points"), 0), [], 0
    draw = random.Random(seed)
    for some in maps(seed):
        if done >= count:
            break
        found, counts, faults = judged(some, draw)
        asked = [(counts, faults)]
        if found.sizes["boundary_point"]:  # once more, next to a boundary
            k = draw.randrange(found.sizes["boundary_point"])
            names = [str(n) for n in reversed(found.abscissa.dims)]
            place = [float(found[f"boundary_{n}"].values[k]) for n in names]
            asked.append(judged(some.near(draw, (place[0], place[1])), draw)[1:])
        for part, more in asked:
            done += 1
            wrong += more
            total = {n: total[n] + part[n] for n in total}
    print(f"{done} maps: {total}, {len(wrong)} wrong")
    assert not wrong, "\n".join(wrong[:5])
    assert total["points"] > done and total["open"] < total["cells"] / 100


def test_a_flag_that_is_turned_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    def turned(*given: Any, **named: Any) -> Any:
        found = real(*given, **named)
        found.verdict.values[0, 0] = 3 - min(int(found.verdict.values[0, 0]), 2)
        return found

    real = st.stability_map
    monkeypatch.setattr(st, "stability_map", turned)
    assert any(judged(some, random.Random(1))[2] for some in islice(maps(1), 3))
