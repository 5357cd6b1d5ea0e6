"""Compiled loops invert a leading coefficient once a row where no column changes it."""

from importlib.util import find_spec
from typing import Any

import numpy as np
import pytest

import stability as st
from stability.maps.compiled import loops, rates
from stability.maps.growth_rates import GrowthKernel
from stability.maps.verdicts import point
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
        first: np.linspace(*ends[first], COLUMNS)[None, :],
        second: np.linspace(*ends[second], ROWS)[:, None],
    }


@pytest.mark.skipif(find_spec("numba") is None, reason="numba is not installed")
@pytest.mark.parametrize(("family", "law", "across"), CASES)
def test_rows_in_pieces_have_the_same_rates_and_flags(family: str, law: Any, across: bool) -> None:
    """In pieces of one block each nothing is kept from one block to the next."""
    asked = disk_problem(family, st.Disk(k=0.3), law, 1.0)
    kernel, own = GrowthKernel(asked, quick=True), lines(law, across)
    whole = kernel(dict(asked.values) | own)
    shape = (ROWS, COLUMNS)
    for low in range(0, COLUMNS, loops.SIDE):
        some = slice(low, min(COLUMNS, low + loops.SIDE))
        piece = kernel(
            dict(asked.values) | {n: v[:, some] if v.shape[0] == 1 else v for n, v in own.items()}
        )
        for name in ("abscissa", "error", "frequency"):
            ours = getattr(whole, name).reshape(shape)[:, some]
            theirs = getattr(piece, name).reshape(ours.shape)
            if law.name == "smooth":  # no correction starts from another cell
                np.testing.assert_array_equal(ours, theirs)
            elif name == "abscissa":
                bound = whole.error.reshape(shape)[:, some] + piece.error.reshape(ours.shape)
                assert (np.abs(ours - theirs) <= bound).all()
        if law.name == "smooth":
            np.testing.assert_array_equal(
                whole.codes.reshape(shape)[:, some], piece.codes.reshape(ours.shape)
            )


@pytest.mark.skipif(find_spec("numba") is None, reason="numba is not installed")
def test_some_of_these_leads_are_steady_and_some_are_not() -> None:
    found = set()
    for family, law, across in CASES:
        asked = disk_problem(family, st.Disk(k=0.3), law, 1.0)
        kernel = GrowthKernel(asked, quick=True)
        values = dict(asked.values) | lines(law, across)
        at, known = point(asked, values), kernel._loops
        assert known is not None
        table = known.tables
        where, _ = rates._lines([*(at[i] for i in table.order), 1.0])
        first, n = table.factors[0]
        steady = loops.steady_lead(table.steps, table.parts, first + n, where)
        found.add((law.name, steady))
    assert found >= {("smooth", True), ("smooth", False)}
