"""Spectra by floats: the linearisation of a numeric system is a numerical derivative.

Its discs rest on an estimated error, so that nothing here is proved.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..algebra.eigensolver import chosen
from ..base.errors import ParameterError
from ..base.types import Floats
from ..systems.family import Family
from ..systems.sources.numeric import newton_step
from .deflation import MemberNumbers, Reduced
from .eigenvalues import decide, eigenvalues
from .problem import Problem
from .result import Spectrum

NOTE = (
    "not proved: the linearisation is a numerical derivative of a Python function, and the discs "
    "rest on an estimate of its error"
)


@dataclass(frozen=True, eq=False)
class NumericPlace(MemberNumbers):
    """Members of a family of a numeric system, with the linearisation that is known there."""

    found: Reduced
    """Numerical derivative and its estimated error."""

    def reduced(self, family: Family, zeros: int, *, watch: bool = False) -> Reduced:  # noqa: ARG002
        """The linearisation; a numeric system has no structural zeros."""
        return self.found


def numeric_linearised(family: Family, a: Floats, q: Floats, u: Floats) -> Reduced:
    """The numerical derivative at members, with an estimate of its error.

    Parameters
    ----------
    family
        A family of a numeric system.
    a, q, u
        Family parameters, parameters and unknowns, shapes (N, ·).
    """
    system: Any = family.system
    states, given = family.states(a, u, q), family._system_parameters(a, u, q)
    where = [system.index(n) for n in family.unknown]
    matrices, errors = [], []
    for x, p in zip(states, given, strict=True):
        value, error = system.derivative(x, p)
        if where:  # a root is known to a Newton step; the derivative moves with it
            moved = x.copy()
            try:
                moved[where] += 2 * np.abs(newton_step(family, x, p, value))
                if (moved != x).any():
                    error = error + np.abs(value - system.derivative(moved, p).value)
            except np.linalg.LinAlgError:  # where branches meet nothing bounds the root
                error = np.full_like(error, np.inf)
        matrices.append(value)
        errors.append(error)
    shape = len(a), len(system.states), len(system.states)
    found = np.reshape(matrices, shape), np.reshape(errors, shape)
    return Reduced(*found, [], np.zeros(len(a), dtype=np.intp))


def numeric_spectrum(problem: Problem, *, certify: bool) -> Spectrum:
    """The spectrum of a numeric system, with discs from the estimated error of its derivative.

    Parameters
    ----------
    problem
        Family with values.
    certify
        Whether a proof is asked for, which is refused.

    Raises
    ------
    ParameterError
        If a proof is asked for.
    NoMemberError
        If Newton's method does not converge, or the motion is not steady.
    """
    family = problem.family
    if certify:
        raise ParameterError(family.system.no_graph)  # type: ignore[attr-defined]  # numeric
    a, q, rate, shape = problem.arrays(problem.values)
    u = family.solve(a, q)
    found = numeric_linearised(family, a, q, u)
    values, radius, pairs = eigenvalues(found, even=False)
    n = values.shape[1]
    return Spectrum(
        family,
        a.reshape(*shape, -1),
        values.reshape(*shape, n),
        radius.reshape(*shape, n),
        0,
        decide(values, radius, even=False).reshape(shape),
        family.states(a, u, q).reshape(*shape, n),
        NumericPlace(a, q, u, rate, (0,) * (a.shape[1] + q.shape[1]), found),
        rate.reshape(shape),
        np.ones((*shape, n)),
        note=NOTE,
        pairs=pairs,
        solver=chosen(),
        values=dict(problem.values),
    )
