"""Painlevé's limit of a body: the slip up to which the plane can hold it at every inclination.

D = I1 + h′² - mu vx h h′ > 0 for every θ exactly where mu |vx| is below the least value of
(I1 + h′²)/(h |h′|).  The greatest value of its inverse is enclosed by bisection in balls.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np
from flint import arb, fmpq

from ..algebra.number_types import balls, precision
from ..algebra.program import Program
from ..base.citation import cited
from ..base.errors import ParameterError
from .disk import Disk
from .round_body.body import Body
from .round_body.shape import RoundShape, of_fit
from .round_body.thin import round_shape

WIDTH = 1e-13
"""Largest width of an enclosure, over its value."""
FLAT = 1e-6
"""Where the greatest value is below this, only that is proved: a ball has no limit."""
MOST = 200_000
"""Largest number of intervals."""


@dataclass(frozen=True)
class PainleveLimit:
    """An enclosure of Painlevé's limit of mu |vx|, which has no unit.

    mu is the viscous coefficient [s/m], vx the slip along the horizontal part of the axis [m/s].

    Source: `painleve_limit`.

    Examples
    --------
    >>> import stability as st
    >>> limit = st.painleve_limit(st.Torus(0.2))
    >>> limit.low <= limit.middle <= limit.high, round(limit.theta, 3)
    (True, 1.017)
    """

    low: float
    """Proved lower end: below it D > 0 at every inclination."""
    high: float
    """Proved upper end: at it D ≤ 0 at some inclination."""
    theta: float
    """Inclination near which D vanishes first [rad]."""
    approximation: str = ""
    """Of what the enclosure speaks where the height is a fit; empty for a formula."""
    citation: str = cited("viscous", model=True, proofs=True)
    """Keys of the works to cite, for `stability.citation`."""

    @property
    def middle(self) -> float:
        """Middle of the enclosure."""
        return (self.low + self.high) / 2


def painleve_limit(body: Body | Disk) -> PainleveLimit:
    """Painlevé's limit of the slip of a body under viscous friction, enclosed.

    The plane can hold the body at every inclination exactly where mu |vx| is below the limit: then
    D > 0 for every θ.  Above it there is an inclination at which no contact force does
    (Painlevé's paradox).

    Parameters
    ----------
    body
        The body or disk, each number a single one; mass, gravity and length do not matter.

    Returns
    -------
    PainleveLimit
        The upper end is infinite for a ball; the lower end may then be about 1e6 only.

    Raises
    ------
    ParameterError
        If this is no body, a number of it is an array, or the height defies enclosure.

    Source: the definition of D in docs/explanation/bodies.md; for the disk 2√(k(k+1)) in closed
    form.  tests/bodies/test_painleve_limit.py minimises by another route.

    Examples
    --------
    >>> import stability as st
    >>> print(round(st.painleve_limit(st.Disk(k=0.25)).middle, 12))  # 2√(k(k+1))
    1.11803398875
    >>> egg = st.painleve_limit(st.Egg(0.2))
    >>> print(f"mu |vx| < {egg.middle:.12f}, first reached at theta = {egg.theta:.3f}")
    mu |vx| < 1.307568805424, first reached at theta = 2.531
    """
    shape = round_shape(body)
    if any(np.ndim(v) for v in shape.given.values()):
        raise ParameterError("Painlevé's limit needs one number for each quantity of the body.")
    with precision(128):
        low, high = (_exact(v) for v in shape.between)
        limit = _enclosed(_program(shape), low, high, shape)
    return replace(limit, approximation=of_fit(shape.name, getattr(shape.height, "error", 0.0)))


def _exact(value: float) -> arb:
    return arb.pi() if value == np.pi else arb(value)


def _program(body: RoundShape) -> Any:
    """G = h h′/(I1 + h′²) and its slope, as a function of a ball."""
    theta, *symbols = (ca.SX.sym(n) for n in ("theta", *body.shape))
    h = ca.SX(body.height(theta, *symbols))
    slope = ca.jacobian(h, theta)
    moment = body.transverse
    inertia = ca.SX(moment(*symbols)) if callable(moment) else ca.SX(float(moment))
    g = h * slope / (inertia + slope**2)
    program = Program(ca.Function("g", [ca.vertcat(theta, *symbols)], [g, ca.jacobian(g, theta)]))
    numbers = [arb(fmpq(*float(v).as_integer_ratio())) for v in body.shape.values()]

    def values(place: arb) -> tuple[arb, arb]:
        outputs = program.run(balls(), [[place, *numbers]])
        value, slope = (arb(f[0]) if f else arb(0) for f in outputs)
        return value, slope

    return values


def _enclosed(values: Any, low: arb, high: arb, body: RoundShape) -> PainleveLimit:
    """Bisection: an interval is dropped where |g| stays below the best value found so far."""
    best, place = arb(0), float(low)
    boxes = [
        ((low + (high - low) * i / 64), (low + (high - low) * (i + 1) / 64)) for i in range(64)
    ]
    top, done = arb(0), 0
    while boxes:
        done += len(boxes)
        if done > MOST:
            raise ParameterError(f"the height of {body.name} is enclosed too widely for a limit.")
        kept = []
        for a, b in boxes:
            middle = (a + b) / 2
            value = abs(values(middle)[0])
            if value.is_finite() and value.lower() > best:
                best, place = value.lower(), float(middle)
            kept.append((a, middle, b, _bound(values, a, b, middle)))
        goal = (best * (1 + arb(WIDTH) / 2)).max(arb(FLAT))
        boxes = []
        for a, middle, b, bound in kept:
            if bound.is_finite() and bound < goal:
                top = bound.max(top)
            else:
                boxes += [(a, middle), (middle, b)]
    top = top.max(best)
    if top == 0:
        return PainleveLimit(np.inf, np.inf, place)
    return PainleveLimit(_down(1 / top), _up(1 / best) if best > 0 else np.inf, place)


def _bound(values: Any, a: arb, b: arb, middle: arb) -> arb:
    """Upper bound of |g| on an interval, by the mean value form where it is finite."""
    whole = a.union(b)
    rough, slope = values(whole)
    centre = values(middle)[0]
    half = (b - a).upper() / 2
    near = abs(centre).upper() + abs(slope).upper() * half
    bounds = [x for x in (abs(rough).upper(), near) if x.is_finite()]
    return min(bounds, key=float) if bounds else arb("nan")


def _down(value: arb) -> float:
    return float(np.nextafter(float(value.lower()), -np.inf))


def _up(value: arb) -> float:
    return float(np.nextafter(float(value.upper()), np.inf))
