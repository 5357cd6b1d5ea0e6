"""A run that keeps its own steps, so that the path is known at any time: by heyoka, or DOP853."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..algebra.number_types import heyoka
from ..base.types import Floats
from . import taylor
from .flow import Evaluator
from .leg import Leg
from .selection import HEYOKA, explicit


@dataclass(frozen=True, eq=False)
class DensePath:
    """A path as a function of time, up to its last step or to a guard's zero."""

    steps: Floats
    """Times of the steps, the start and the end among them, shape (s,)."""
    at: Callable[[Floats], Floats]
    """y at times between the first and the last step, shape (t,) to (t, n)."""
    whole: bool
    """Whether the path reaches the leg's last time."""


def dense(leg: Leg) -> DensePath:
    """Run a leg by an explicit method and keep its steps; the leg's own times are only its span.

    Parameters
    ----------
    leg
        Leg to run; without stiffness.

    Returns
    -------
    DensePath
        A run that gives up ends at its last good step.

    Examples
    --------
    >>> from stability.integrators.flow import flow
    >>> f = flow("rough")
    >>> start = f.pack(np.array([1.3, 0.1, 0.4, 1.1]))
    >>> path = dense(Leg(f, np.array([0.25, 1e-6]), start, np.array([0.0, 2.0]), 1e-12, 1000))
    >>> path.whole, path.at(np.array([0.0]))[0, :4].tolist()
    (True, [1.3, 0.1, 0.4, 1.1])
    """
    return _by_heyoka(leg) if explicit(leg.flow) == HEYOKA else _by_dop853(leg)


def _by_heyoka(leg: Leg) -> DensePath:
    """A run for the steps and one for the values: heyoka's own continuous output costs more.

    The path ends at the last whole step before a guard's zero.
    """
    hy = heyoka()
    steps = [float(leg.times[0])]

    def note(ta: Any) -> bool:
        steps.append(float(ta.time))
        return True

    with taylor.lent(leg) as ta:
        outcome, *_ = ta.propagate_until(
            float(leg.times[-1]), max_steps=leg.max_steps, callback=note
        )
    whole = outcome == hy.taylor_outcome.time_limit

    def at(times: Floats) -> Floats:
        grid, places = np.unique(np.append(times, leg.times[0]), return_inverse=True)
        with taylor.lent(leg) as ta:
            states = np.array(ta.propagate_grid(grid, max_steps=leg.max_steps)[5])
        found: Floats = states[places[:-1]]
        return found

    return DensePath(np.array(steps if whole else steps[:-1]), at, whole)


def _by_dop853(leg: Leg) -> DensePath:
    from scipy.integrate import solve_ivp

    ask = Evaluator(leg.flow, leg.p)

    def ended(_t: float, y: Floats) -> float:
        return float(ask.watch(y)[0].min(initial=1.0))

    ended.terminal = True  # type: ignore[attr-defined]  # as SciPy reads it
    run = solve_ivp(
        ask.rates,
        (leg.times[0], leg.times[-1]),
        leg.start,
        method="DOP853",
        dense_output=True,
        rtol=max(leg.tolerance, 3e-14),
        atol=leg.absolute,
        events=ended,
    )
    return DensePath(run.sol.ts, lambda times: run.sol(times).T, run.status == 0)
