"""Spectra of numeric systems: a Python function, its numerical derivative, discs without proof."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..algebra.eigensolver import chosen
from ..algebra.upright import Upright
from ..base.errors import NoMemberError, ParameterError, listing
from ..base.types import Floats
from ..systems.family import Family
from ..systems.sources.numeric import Derivative, NumericSystem
from .deflation import Place, Reduced
from .eigenvalues import decide, eigenvalues
from .problem import Problem
from .result import Spectrum

NOTE = (
    "not proved: the linearisation is a numerical derivative of a Python function, and the discs "
    "rest on an estimate of its error"
)
MOST_STEPS = 50
"""Largest number of Newton steps."""
STEADY = 1e-10
"""Largest rate that counts as zero, in units of the linearisation."""


@dataclass(frozen=True, eq=False)
class NumericPlace(Place):
    """Members of a family of a numeric system, with the linearisation that is known there."""

    found: Reduced
    """Numerical derivative and its estimated error."""

    def reduced(self, family: Family, zeros: int, *, watch: bool = False) -> Reduced:  # noqa: ARG002
        """The linearisation; a numeric system has no structural zeros."""
        return self.found


def numeric_spectrum(problem: Problem, system: NumericSystem, *, certify: bool) -> Spectrum:
    """The spectrum of a numeric system, with discs from the estimated error of its derivative.

    Parameters
    ----------
    problem
        Family with values.
    system
        The family's system.
    certify
        Whether a proof is asked for, which is refused.

    Returns
    -------
    Spectrum

    Raises
    ------
    ParameterError
        If a proof is asked for.
    NoMemberError
        If Newton's method does not converge, or the motion is not steady.
    """
    if certify:
        raise ParameterError(system.no_graph)
    family = problem.family
    a, q, rate, shape = problem.arrays(problem.values)
    members = [_member(family, system, a[i], q[i]) for i in range(len(a))]
    states, matrices, errors, unknowns = (np.array(part) for part in zip(*members, strict=True))
    found = Reduced(matrices, errors, [], np.zeros(len(a), dtype=np.intp))
    values, radius, pairs = eigenvalues(found, even=False)
    n = states.shape[1]
    roundings = (0,) * (a.shape[1] + q.shape[1])
    place = NumericPlace(a, q, unknowns.reshape(len(a), -1), rate, roundings, found)
    return Spectrum(
        family,
        a.reshape(*shape, -1),
        values.reshape(*shape, n),
        radius.reshape(*shape, n),
        0,
        decide(values, radius, even=False).reshape(shape),
        states.reshape(*shape, n),
        place,
        rate.reshape(shape),
        np.ones((*shape, n)),
        note=NOTE,
        pairs=pairs,
        solver=chosen(),
        values=dict(problem.values),
    )


def _member(
    family: Family, system: NumericSystem, a: Floats, q: Floats
) -> tuple[Floats, Floats, Floats, Floats]:
    """State, linearisation, its estimated error, and unknowns of one member."""
    given = dict(zip((*family.at, *family.parameters), (*a, *q), strict=True))
    p = np.array([given[n] for n in system.parameters], dtype=float)
    x = np.array([_value(family, given, n) for n in system.states])
    where = [system.index(n) for n in family.unknown]
    rows = [system.index(n) for n in family.equations]
    doubt = np.zeros_like(x)
    if where:
        doubt[where] = np.abs(_solve(family, system, x, p, where, rows, given))
    found = system.derivative(x, p)
    rates = np.abs(system.call(x, p))
    scale = 1 + np.abs(found.value).max() * (1 + np.abs(x).max())
    if not (rates <= STEADY * scale).all():
        worst = int(rates.argmax())
        raise NoMemberError(
            f"{family.name} is not steady: {system.states[worst]} still changes at "
            f"{rates[worst]:.2g} at {listing(tuple(given), list(given.values()))}; add its rate to "
            "the family's equations, or give what is held to all its digits."
        )
    # a root is known to its last Newton step; the derivative moves with it
    moved = (
        system.derivative(x + 2 * doubt, p) if where else Derivative(found.value, 0 * found.value)
    )
    error: Floats = found.error + np.abs(found.value - moved.value)
    return x, found.value, np.asarray(error), x[where]


def _value(family: Family, given: dict[str, float], name: str) -> float:
    if name in given:
        return float(given[name])
    if name in family.unknown:
        return float(family.unknown[name])
    held = family.held[name]
    return np.pi / 2 if isinstance(held, Upright) else float(held)


def _solve(
    family: Family,
    system: NumericSystem,
    x: Floats,
    p: Floats,
    where: list[int],
    rows: list[int],
    given: dict[str, float],
) -> Floats:
    """Newton's method on the unknowns within x; returns the last step."""
    step: Floats = np.full(len(where), np.inf)
    for _ in range(MOST_STEPS):
        slope = system.derivative(x, p).value[np.ix_(rows, where)]
        try:
            new: Floats = np.asarray(-np.linalg.solve(slope, system.call(x, p)[rows]))
        except np.linalg.LinAlgError:
            break
        done = np.abs(new).max() <= 1e-13 * (1 + np.abs(x[where]).max())
        if done or (np.abs(new).max() <= 1e-9 and np.abs(new).max() >= np.abs(step).max() / 2):
            step = new
            good = all(x[system.index(n)] > 0 for n in family.positive)
            if good:
                return step
            break
        x[where] += new
        step = new
    raise NoMemberError(
        f"{family.name} has no member that Newton's method reaches at "
        f"{listing(tuple(given), list(given.values()))}; choose another point or another guess."
    )
