"""The mean path of a thin ring that rolls without slip: which way it turns under resistance.

The velocity of the centre is -ω₃ ŷ + h' θ̇ x̂, along axes that turn with φ̇.  A small nutation of
frequency Ω about circling adds terms that turn with φ̇ + Ω and with φ̇ - Ω.  The second is slow: the
mean path turns at φ̇ - Ω.  It turns *back*, against the ring's own turning, where Ω > φ̇.
Resistance moves the ring along the plane of circling motions (θ, φ̇), by the slow flow of
`slow_flow`; to first order the path there depends on the ratio of the coefficients alone.
tests/boundary/test_mean_path.py compares with closed forms by hand and with integrated motions.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import one_number, real_numbers
from ..base.citation import cited
from ..base.errors import ParameterError, shown
from ..base.types import Floats
from ..base.version import __version__
from ..bodies.contact_laws import Rough
from ..bodies.resistance import AirTorque, RollingResistance
from ..bodies.round_body.body import Body
from .slow_flow import SlowFlow, slow_flow

if TYPE_CHECKING:
    import xarray


FORMAT = "stability retrograde map 1"
STARTS = ((80.0, 1.0), (60.0, 1.0), (80.0, 1.5))
"""Starts of the map: inclination [°], and φ̇ over that of the motion whose centre rests."""
FLAT, UPRIGHT_END = 0.05, math.pi / 2 - 0.01
"""Inclinations at which a motion is followed no further [rad]."""
STEP, MOST_STEPS = 0.04, 600
"""Relative change of θ or φ̇ in a step; most steps."""


class _Circling:
    """Slow flow and nutation on the plane of circling motions, for many rings at once."""

    def __init__(self) -> None:
        body = Body(lambda theta: ca.sin(theta), axial=0.5, transverse=0.25, name="thin ring")
        self.flows: list[SlowFlow] = [
            slow_flow("circling", body=body, contact=Rough(), resistance=kind)
            for kind in (RollingResistance(1.0), AirTorque(1.0))
        ]
        self.family = self.flows[0].family

    def __call__(self, at: Floats, k: Floats, share: Floats) -> tuple[Floats, Floats]:
        """Rates of (θ, φ̇) for the coefficients (1 - share, share), and the nutation frequency."""
        count = len(at)
        table = {"axial": 2 * k, "transverse": k}
        q = np.array([table[n] for n in self.family.parameters]).T
        u = self.family.solve(at, q)
        x, matrix = self.family.states(at, u, q), self.family.matrix(at, u, q)
        tangent = self.family.tangent(at, u, q)[..., :2]
        push = np.zeros((count, 4))
        for flow, part in zip(self.flows, (1 - share, share), strict=True):
            push += part[:, None] * flow.push(x, table | {flow.small: np.zeros(count)})
        # the family spans the null space, so M dx + push = T y with Tᵀ dx = 0 has one solution
        bordered = np.zeros((count, 6, 6))
        bordered[:, :4, :4], bordered[:, :4, 4:] = matrix, -tangent
        bordered[:, 4:, :4] = tangent.transpose(0, 2, 1)
        right = np.concatenate([-push, np.zeros((count, 2))], axis=1)
        rates = np.linalg.solve(bordered, right[..., None])[:, 4:, 0]
        # the characteristic polynomial is λ²(λ² + Ω²)
        trace = np.trace(matrix, axis1=1, axis2=2)
        square = (trace**2 - np.trace(matrix @ matrix, axis1=1, axis2=2)) / 2
        return rates, np.sqrt(np.maximum(square, 0.0))


def retrograde_map(
    inner: ArrayLike | None = None,
    share: ArrayLike | None = None,
    *,
    starts: Sequence[tuple[float, float]] = STARTS,
) -> xarray.Dataset:
    """Where the mean path of a ring turns back, over its inner radius and the kind of resistance.

    Parameters
    ----------
    inner
        Inner radii over the outer radius, in [0, 1], rising; 33 when left out.
    share
        Shares of air, d*/(d* + ρ*), in [0, 1], rising; 33 when left out.  d* = d/(m R² √(g/R)) is
        the coefficient of `AirTorque`, and ρ* = ρ √(g/R)/R that of `RollingResistance`.
    starts
        Pairs of inclination [°] and φ̇ over that of the motion whose centre rests.

    Returns
    -------
    xarray.Dataset
        Dimensions `start`, `inner`, `share`: `largest_ratio` of Ω to φ̇ on the way down to
        θ = 0.05, above 1 where the path turns back; `theta_back` and `theta_on`, where it begins
        and ends to turn back [rad]; `backward`, the angle through which it turns back, times the
        sum of the coefficients [rad].  NaN where a motion loses its nutation or rises upright.

    Raises
    ------
    ParameterError
        If an argument is not accepted.

    Source: the module's text; compare Jalali, Sarebangholi & Alam, Phys. Rev. E 92 (2015) 032913,
    and Borisov, Kilin & Karavaev, Phys. Usp. 60 (2017) 931-934.

    Examples
    --------
    >>> import stability as st
    >>> chart = st.retrograde_map([0.0, 1.0], [0.0], starts=[(80.0, 1.0)])
    >>> (chart.largest_ratio > 1).values.ravel().tolist()  # a coin does not, a hoop does
    [False, True]
    """
    import xarray

    radii, shares = _points("inner", inner), _points("share", share)
    if not isinstance(starts, (tuple, list)) or not starts:
        raise ParameterError(
            f"starts is {shown(starts)}; give a list of pairs (theta in degrees, speed)."
        )
    pairs = [_start(pair) for pair in starts]
    grid = np.meshgrid(np.arange(len(pairs), dtype=float), radii, shares, indexing="ij")
    which, r, s = (a.ravel() for a in grid)
    k = (1 + r**2) / 4
    theta = np.array([math.radians(a) for a, _ in pairs])[which.astype(int)]
    speed = np.array([b for _, b in pairs])[which.astype(int)]
    at = np.stack([theta, speed / np.sqrt(k * np.sin(theta))], axis=1)
    results = {n: v.reshape(grid[0].shape) for n, v in _follow(at, k, s).items()}
    words = {
        "largest_ratio": ("largest nutation frequency over precession rate", "1"),
        "theta_back": ("inclination where the mean path begins to turn back", "rad"),
        "theta_on": ("inclination where the mean path turns forward again", "rad"),
        "backward": ("angle turned back times the sum of the coefficients", "rad"),
    }
    dims = ("start", "inner", "share")
    return xarray.Dataset(
        {
            n: (dims, v, {"long_name": words[n][0], "units": words[n][1]})
            for n, v in results.items()
        },
        coords={
            "inner": ("inner", radii, {"long_name": "inner over outer radius", "units": "1"}),
            "share": ("share", shares, {"long_name": "share of air", "units": "1"}),
            "start_theta": ("start", [a for a, _ in pairs], {"units": "degree"}),
            "start_speed": ("start", [b for _, b in pairs], {"units": "1"}),
        },
        attrs={
            "format": FORMAT,
            "contact": "rough",
            "end": FLAT,
            "stability": __version__,
            "citation": cited("rough", model=True),
        },
    )


def _points(name: str, numbers: ArrayLike | None) -> Floats:
    values = np.linspace(0, 1, 33) if numbers is None else real_numbers(name, numbers)
    if values.ndim != 1 or not values.size or not (np.diff(values) > 0).all():
        raise ParameterError(f"{name} is {shown(numbers)}; give rising numbers.")
    if not (values[0] >= 0 and values[-1] <= 1):
        raise ParameterError(f"{name} is {shown(numbers)}; its numbers must lie in [0, 1].")
    return values


def _start(pair: Any) -> tuple[float, float]:
    if not isinstance(pair, Sequence) or len(pair) != 2:
        raise ParameterError(f"a start is {shown(pair)}; give (theta in degrees, speed).")
    theta, speed = one_number("theta", pair[0]), one_number("speed", pair[1])
    if not (math.radians(theta) > FLAT and math.radians(theta) < UPRIGHT_END and speed > 0):
        raise ParameterError(
            f"a start is ({theta:g}, {speed:g}); theta must lie between 3 and 89 degrees, and the "
            "speed above 0."
        )
    return theta, speed


def _follow(at: Floats, k: Floats, share: Floats) -> dict[str, Floats]:
    """What is seen on the way from circling motions down to `FLAT`, by Runge and Kutta."""
    flow, count = _Circling(), len(at)
    largest, backward = np.zeros(count), np.zeros(count)
    back, on = np.full(count, math.nan), np.full(count, math.nan)
    alive, lost = np.ones(count, dtype=bool), np.zeros(count, dtype=bool)
    before, height = np.full(count, math.nan), at[:, 0].copy()
    for _ in range(MOST_STEPS):
        i = np.flatnonzero(alive)
        if not i.size:
            break
        y, args = at[i], (k[i], share[i])
        first, nutation = flow(y, *args)
        ratio, was = nutation / y[:, 1], before[i]
        largest[i] = np.fmax(largest[i], ratio)
        turn = height[i] + (y[:, 0] - height[i]) * (1 - was) / (ratio - was)
        back[i] = np.where(np.isnan(back[i]) & (ratio > 1) & (was <= 1), turn, back[i])
        on[i] = np.where((ratio <= 1) & (was > 1), turn, on[i])
        before[i], height[i] = ratio, y[:, 0]
        step = STEP / np.abs(first / y).max(axis=1)
        backward[i] += np.maximum(nutation - y[:, 1], 0) * step
        h = step[:, None]
        second, _ = flow(y + h / 2 * first, *args)
        third, _ = flow(y + h / 2 * second, *args)
        fourth, _ = flow(y + h * third, *args)
        at[i] = y + h / 6 * (first + 2 * second + 2 * third + fourth)
        lost[i] = (nutation <= 0) | (at[i, 0] >= UPRIGHT_END)
        alive[i] = ~lost[i] & (at[i, 0] > FLAT)
    lost |= alive
    results = {"largest_ratio": largest, "theta_back": back, "theta_on": on, "backward": backward}
    return {n: np.where(lost, math.nan, v) for n, v in results.items()}
