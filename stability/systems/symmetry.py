"""A family of symmetric members in coordinates in which the symmetry holds some states at zero.

At a symmetric pitchfork the equations of the members are singular, so that no member is proved next
to it.  Where a signed permutation S of the states with S f(S x) = f(x) leaves the members in place
and turns the crossing branch round, means of states that S exchanges stay unknown, and their half
differences are held at zero.  The equations of the means are regular there, and the spectrum is the
same.

Source: M. Golubitsky, I. Stewart & D. Schaeffer, Singularities and Groups in Bifurcation Theory II,
ch. XIII; tests/boundary/test_pitchforks.py.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import islice

import casadi as ca
import numpy as np

from ..algebra.exact.function_field import FunctionField
from ..algebra.exact.number_fields import EXACT, vanishes
from ..algebra.program import Program
from ..base.errors import StabilityError
from ..base.types import Floats
from .equations import Equations
from .family import Family

MOST_TRIED = 64
"""Most signed permutations that are tried."""
SAME = 1e-5
"""Relative difference up to which two numbers of a branch point count as equal."""
AGREES = 1e-9
"""The same for rates at a random point, before an exact proof is tried."""

Reflection = tuple[tuple[int, int], ...]
"""(index, sign) of the image of each state under S: (S x)_i = sign x_index."""


def symmetric_family(family: Family, state: Floats, way: Floats) -> Family | None:
    """The family in coordinates in which an exact symmetry holds some states at zero.

    Parameters
    ----------
    family
        A family that is solved for by rates of its unknowns.
    state, way
        A branch point, and the direction of the crossing branch, shapes (n,).

    Returns
    -------
    Family or None
        None where no symmetry is proved that leaves the state in place and turns the direction.
    """
    if set(family.equations) != set(family.unknown) or family.idle or not family.anchor:
        return None
    for images in islice(_matching(family, state, way), MOST_TRIED):
        if _commutes(family.system, images):
            return _reduced(family, images)
    return None


def _matching(family: Family, state: Floats, way: Floats) -> Iterator[Reflection]:
    """Involutions that leave a state in place, turn a direction, and exchange unknowns alone."""
    states = family.system.states
    room = SAME * (1 + np.abs(state).max()), SAME * np.abs(way).max()
    named = [n not in family.unknown for n in states]

    def fits(i: int, j: int, sign: int) -> bool:
        if named[i] or named[j]:
            return i == j and (sign > 0 or family.held.get(states[i]) == 0)
        return bool(
            abs(state[i] - sign * state[j]) <= room[0] and abs(way[i] + sign * way[j]) <= room[1]
        )

    def extended(images: dict[int, tuple[int, int]]) -> Iterator[dict[int, tuple[int, int]]]:
        left = [i for i in range(len(states)) if i not in images]
        if not left:
            yield images
            return
        i = left[0]
        for j in left:
            for sign in (1, -1):
                if fits(i, j, sign):
                    yield from extended(images | {i: (j, sign), j: (i, sign)})

    for images in extended({}):
        yield tuple(images[i] for i in range(len(states)))


def _commutes(system: Equations, images: Reflection) -> bool:
    """Whether S f(S x) = f(x), seen at a random point and then proved."""
    program = Program(ca.Function("rates", [system.x, system.p], [ca.densify(system.rhs)]))
    rng = np.random.default_rng(7)
    x, p = (rng.uniform(0.3, 0.9, len(n)) for n in (system.states, system.parameters))
    rates = ca.Function("rates", [system.x, system.p], [system.rhs])
    here, there = (
        np.array(rates(v, p)).ravel() for v in (x, np.array([s * x[j] for j, s in images]))
    )
    if not np.allclose([s * there[j] for j, s in images], here, rtol=AGREES, atol=AGREES):
        return False
    field = FunctionField([*system.states, *system.parameters])
    states, parameters = field.symbols[: len(system.states)], field.symbols[len(system.states) :]
    try:
        first, second = (
            program.run(EXACT, [v, parameters])[0]
            for v in (states, [states[j] * s for j, s in images])
        )
        return all(vanishes(first[i] - second[j] * s) for i, (j, s) in enumerate(images))
    except (ArithmeticError, StabilityError):  # too large, or no exact numbers
        return False


def _reduced(family: Family, images: Reflection) -> Family:
    """The family in means and half differences of the states that are exchanged."""
    system = family.system
    old, rates = ca.vertsplit(system.x), ca.vertsplit(ca.densify(system.rhs))
    place, turned = list(old), list(rates)
    still = {i for i, (j, sign) in enumerate(images) if j == i and sign < 0}
    for i, (j, sign) in enumerate(images):
        if i < j:  # state i is the mean, state j the half difference
            place[i], place[j] = old[i] + old[j], sign * (old[i] - old[j])
            turned[i] = (rates[i] + sign * rates[j]) / 2
            turned[j] = (rates[i] - sign * rates[j]) / 2
            still.add(j)

    def moved(some: Sequence[ca.SX]) -> list[ca.SX]:
        return list(ca.substitute(list(some), [system.x], [ca.vertcat(*place)])) if some else []

    other = Equations(
        system.name,
        system.x,
        system.p,
        ca.vertcat(*moved(turned)),
        states=system.states,
        parameters=system.parameters,
        conditions=tuple(
            replace(c, value=v)
            for c, v in zip(
                system.conditions, moved([c.value for c in system.conditions]), strict=True
            )
        ),
        approximation=system.approximation,
    )
    gone = {system.states[i] for i in still}
    unknown = {n: v for n, v in family.unknown.items() if n not in gone}
    anchor = family.anchor
    assert anchor is not None
    near = dict(zip(family.unknown, anchor.unknown, strict=True))
    return replace(
        family,
        system=other,
        held={**family.held, **dict.fromkeys(sorted(gone), 0.0)},
        unknown=unknown,
        equations=tuple(n for n in family.equations if n not in gone),
        positive=tuple(n for n in family.positive if n not in gone),
        anchor=replace(anchor, unknown=tuple(near[n] for n in unknown)),
        exact=None,
        formulas=None,
    )
