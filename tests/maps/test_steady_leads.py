"""Compiled loops invert a leading coefficient once a row where no column changes it."""

from importlib.util import find_spec
from typing import Any

import numpy as np
import pytest

import stability as st
from stability.base.axis import Axis
from stability.maps.compiled import loops
from stability.maps.compiled.rates import CompiledRates
from stability.maps.engine import SliceCells, slice_cells
from stability.spectra.problem import disk_problem

COLUMNS, ROWS = 2 * loops.SIDE + 50, 30
CASES = [
    (f, law, x)
    for f in ("rolling", "spinning", "tumbling")
    for law in (st.Smooth(), st.Viscous(0.7))
    for x in (True, False)
]


def lines(law: Any, across: bool) -> dict[str, Any]:
    """The family's number across and k or mu up, or the other way round."""
    other = "k" if law.name == "smooth" else "mu"
    ends = {"at": (0.2, 1.5), "k": (0.05, 0.5), "mu": (0.05, 3.0)}
    first, second = ("at", other) if across else (other, "at")
    return {
        first: np.linspace(*ends[first], COLUMNS),
        second: np.linspace(*ends[second], ROWS),
    }


def cells(family: str, law: Any, lines: dict[str, Any]) -> SliceCells:
    asked = disk_problem(family, st.Disk(k=0.3), law, 1.0)
    axes = [Axis(n, float(v[0]), float(v[-1]), len(v)) for n, v in lines.items()]
    found = slice_cells(asked, (axes[0], axes[1]), False)
    assert found is not None
    rows = [row for row, _, _ in found._factors]
    found.loops = CompiledRates.of(rows, even=found.verdicts.slice.even)
    return found


@pytest.mark.skipif(find_spec("numba") is None, reason="numba is not installed")
@pytest.mark.parametrize(("family", "law", "across"), CASES)
def test_rows_in_pieces_have_the_same_rates_and_flags(family: str, law: Any, across: bool) -> None:
    """In pieces of one block each nothing is kept from one block to the next."""
    xs, ys = lines(law, across).values()
    known = cells(family, law, lines(law, across))
    whole, shape = known._swept(xs, ys, None), (ROWS, COLUMNS)
    for low in range(0, COLUMNS, loops.SIDE):
        some = slice(low, min(COLUMNS, low + loops.SIDE))
        piece = known._swept(xs[some], ys, None)
        assert whole is not None and piece is not None
        for name in ("abscissa", "error", "frequency", "codes"):
            ours = getattr(whole, name).reshape(shape)[:, some]
            theirs = getattr(piece, name).reshape(ours.shape)
            if law.name == "smooth":  # no correction starts from another cell
                np.testing.assert_array_equal(ours, theirs)
            elif name == "abscissa":
                bound = whole.error.reshape(shape)[:, some] + piece.error.reshape(ours.shape)
                assert (np.abs(ours - theirs) <= bound).all()


def test_some_of_these_leads_are_steady_and_some_are_not() -> None:
    found = set()
    for family, law, across in CASES:
        loops_ = cells(family, law, lines(law, across)).loops
        assert loops_ is not None
        _, degrees, _, starts = loops_.table
        found.add((law.name, bool(degrees[sum(starts[0])] == 0)))
    assert found >= {("smooth", True), ("smooth", False)}
