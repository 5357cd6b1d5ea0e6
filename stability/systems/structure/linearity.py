"""Whether a system's rates are linear in its states, proved from the graph."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from ...algebra.exact.function_field import Expression, FunctionField
from ...algebra.exact.number_fields import EXACT
from ...algebra.program import Program, operations
from ...base.errors import StabilityError
from ..equations import Equations

CLEAR = 1e-6
"""Relative change of a slope from which it is taken as no constant, and no proof is tried."""


def kept(slopes: Any) -> list[int]:
    """Indices of the states without those on which no rate of the others depends, in turn.

    Parameters
    ----------
    slopes
        Jacobian of the rates by the states.
    """
    pattern = {
        (int(i), int(j)) for i, j in zip(*ca.SX(slopes).sparsity().get_triplet(), strict=True)
    }
    left = set(range(slopes.size1()))
    while True:
        idle = {j for j in left if not any((i, j) in pattern for i in left)}
        if not idle:
            return sorted(left)
        left -= idle


@lru_cache(maxsize=64)
def linear(system: Equations) -> bool:
    """Whether the rates are proved to be linear in the states, those that others depend on.

    All terms of order two and higher then vanish identically.  The proof is by the places of the
    graph, or, where terms cancel, over the field of rational functions.

    Examples
    --------
    >>> from stability.systems.system import System
    >>> x = ca.SX.sym("x")
    >>> p = ca.SX.sym("p", 0)
    >>> [linear(System("s", x, p, f, states=("x",))) for f in (3 * x, (x + 1)**2 - x**2, x**2)]
    [True, True, False]
    """
    if system.coefficients is not None:
        return True
    try:
        some = kept(system.jacobian)
        states = ca.vertcat(*[system.x[i] for i in some])
        rates = ca.densify(ca.vertcat(*[system.rhs[i] for i in some]))
        program = Program(ca.Function("rates", [system.x, system.p], [rates]))
    except StabilityError:  # no graph, or one with branches
        return False
    slopes = system.jacobian[some, some]
    if not some or (not _signs(rates) and not ca.depends_on(slopes, states)):
        return True
    return not _changes(system, slopes) and _affine(system, program, some)


def _signs(rates: ca.SX) -> bool:
    """Whether the rates hold a sign, whose slope is zero wherever it has one."""
    graph = ca.Function("rates", [ca.vertcat(*ca.symvar(rates))], [rates])
    return ca.OP_SIGN in operations(graph)


def _changes(system: Equations, slopes: ca.SX) -> bool:
    """Whether a slope differs clearly between two points, or has no value there."""
    value = ca.Function("slopes", [system.x, system.p], [slopes])
    rng = np.random.default_rng(3)
    p = rng.uniform(0.4, 1.2, system.p.numel())
    first, second = (np.array(value(rng.uniform(0.4, 1.2, system.x.numel()), p)) for _ in range(2))
    return not bool((np.abs(first - second) <= CLEAR * (1 + np.abs(first))).all())


def _affine(system: Equations, program: Program, some: list[int]) -> bool:
    """Whether each rate is a polynomial of degree one in some states, over the other symbols."""
    count = len(system.states)
    names = [*system.states, *system.parameters]
    field = FunctionField(names)
    try:
        rates = program.run(EXACT, [field.symbols[:count], field.symbols[count:]])[0]
    except (ArithmeticError, StabilityError):
        return False
    return all(_degree_one(rate, some, len(names)) for rate in rates)


def _degree_one(rate: Any, some: list[int], count: int) -> bool:
    if not isinstance(rate, Expression):
        return True
    # an indeterminate beyond the symbols is a function, which may hold a state
    below, above = rate.den.degrees(), rate.num.to_dict()
    if any(below[i] for i in some) or any(below[count:]):
        return False
    return all(sum(e[i] for i in some) <= 1 and not any(e[count:]) for e in above)
