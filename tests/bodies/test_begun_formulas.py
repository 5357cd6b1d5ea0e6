"""Formulas of which a part is computed once: the same numbers as without; members next to them."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from flint import arb

import stability as st
from stability.algebra.number_types import precision
from stability.algebra.running_error import TRACKED, RunningError
from stability.base.errors import NoMemberError
from stability.spectra.problem import formulas_of
from stability.systems import members as following
from stability.systems.closed_form import ClosedForm, RepeatedBalls

FAMILIES = ("torus", "egg", "leaning")
MIDDLE = {"theta": 1.2, "omega3": 1.1, "tube": 0.2, "thickness": 0.1, "mu": 0.4}


@cache
def family_of(name: str) -> st.Family:
    if name == "egg":
        return egg().family("tumbling", "rough")
    if name == "torus":
        return st.Torus(0.2).family("tumbling", "viscous")
    return st.ThickDisk(0.1).family("rolling", "viscous")  # θ is solved for


@cache
def egg() -> st.Body:
    return st.Egg(0.2, tolerance=1e-10)


def middle(family: st.Family) -> tuple[list[float], list[float]]:
    """The numbers of one member."""
    known = MIDDLE | {"axial": egg().axial, "transverse": egg().transverse}
    return [known[n] for n in family.at], [known[n] for n in family.parameters]


def formulas(name: str) -> tuple[ClosedForm, list[float], list[float]]:
    """Formulas of a family, and the numbers of one member."""
    family = family_of(name)
    found = formulas_of(family)
    assert found is not None
    return found, *middle(family)


@pytest.mark.parametrize("name", ["torus", "leaning", pytest.param("egg", marks=pytest.mark.long)])
def test_a_begun_formula_has_the_same_bounds(name: str) -> None:
    form, a, q = formulas(name)
    places = [(0, i) for i in range(len(a))] + [(1, i) for i in range(len(q))]
    for moving in (frozenset(places[-1:]), frozenset(places[:1]), frozenset(places)):

        def spread(factor: float, moving: Any = moving) -> list[list[RunningError]]:
            return [
                [
                    RunningError(np.asarray(v * (factor if (i, j) in moving else 1.0)), 0.0)
                    for j, v in enumerate(some)
                ]
                for i, some in enumerate((a, q))
            ]

        begun = form.begun(TRACKED, *spread(1.0), moving)
        for factor in (0.97, 1.0, 1.05):
            given = spread(factor)
            for one, other in zip(begun(*given), form(TRACKED, *given), strict=True):
                for v, w in zip(one, other, strict=True):
                    if isinstance(v, RunningError):
                        assert (float(v.value), float(v.error)) == (float(w.value), float(w.error))
                    else:
                        assert v == w


@pytest.mark.parametrize("name", FAMILIES)
def test_balls_are_those_of_each_member_whatever_has_moved(name: str) -> None:
    """One number changes, then another one, then all; and the first member comes back."""
    form, a, q = formulas(name)
    count = len(a) + len(q)
    changes = [[], [0], [0], [count - 1], [count - 1, 0], list(range(count)), [], [1]]
    with precision(128):
        repeated = RepeatedBalls(form)
        for number, changed in enumerate(changes):
            point = [
                arb(v) + (arb(number + 1) / 1024 if i in changed else 0)
                for i, v in enumerate([*a, *q])
            ]
            given = point[: len(a)], point[len(a) :]
            ours, true = form.polynomial(*given, repeated), form.polynomial(*given)
            for v, w in zip(ours, true, strict=True):
                assert v.overlaps(w)
                assert v.rad() <= 2 * w.rad() + 1e-30


def test_numbers_that_failed_once_leave_nothing_behind() -> None:
    """Where no member is proved at a point, the next point is not computed with its numbers."""
    form, a, q = formulas("leaning")
    with precision(128):
        good, far, other = ([arb(v) for v in q] for _ in range(3))
        place = family_of("leaning").parameters.index("thickness")
        far[place], other[place] = arb("nan"), arb(0.15)
        at = [arb(v) for v in a]
        repeated = RepeatedBalls(form)
        form.polynomial(at, good, repeated)
        form.polynomial([at[0] + 1], good, repeated)
        with pytest.raises((NoMemberError, ValueError)):
            form.polynomial(at, far, repeated)
        ours, true = form.polynomial(at, other, repeated), form.polynomial(at, other)
        assert all(v.overlaps(w) and v.is_finite() for v, w in zip(ours, true, strict=True))


def test_members_next_to_a_long_formula_are_those_of_the_root_finder(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    family = family_of("egg")
    at = np.linspace(0.05, 3.1, 75)[:, None]
    q = np.tile([middle(family)[1]], (len(at), 1))
    true = replace(family, formulas=None).search(at, q)
    asked: list[int] = []
    finder = following.roots

    def counted(*given: Any) -> Any:
        asked.append(len(given[1]))
        return finder(*given)

    monkeypatch.setattr(following, "roots", counted)
    ours = family.search(at, q)
    assert (ours.good == true.good).all()
    assert 10 < ours.good.sum() < 65
    assert np.allclose(ours.u[ours.good], true.u[ours.good], rtol=1e-12, atol=1e-13)
    assert sum(asked) <= 3  # members at which the formula is not proved to have none
    assert "no admissible isolated solution" in ours.why(int(np.argmin(ours.good)))
