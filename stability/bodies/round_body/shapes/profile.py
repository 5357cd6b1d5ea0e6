"""A body of revolution from its meridian and density: height and moments by quadrature.

The height is the support function of the surface about the centre of mass.  For a smooth meridian
it is a cosine series in θ whose terms fall geometrically.  It is computed at equally spaced angles,
each by the point of the meridian whose normal is vertical, and cut where the terms reach rounding.
Mass, centre and moments are integrals over the body by Gauss' rule, doubled until they agree.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from ....base.checks import known, one_number, real_numbers
from ....base.errors import ParameterError, one_line, shown
from ....base.types import Floats
from ..body import Body
from ..shape import SCALES

Curve = Callable[[Any], tuple[Any, Any]]
GRID = 2001
"""Points of the meridian from which its lowest point is searched."""
MOST_NODES = 1024
"""Largest number of nodes of a rule, and of angles of the series."""
TIGHT = 1e-13
"""Relative size at which integrals agree."""
TOLERANCE = 1e-11
"""Relative size at which terms of the second slope's series end, where none is given."""
FINEST = 1e-16
"""Least such size: just above the rounding of the terms."""
LOOSE = 1e-9
"""Largest relative error of a body that is handed out."""


def from_profile(
    curve: Curve,
    *,
    density: Callable[[Any, Any], Any] | None = None,
    name: str = "profile",
    tolerance: float = TOLERANCE,
    **scales: Any,
) -> Body:
    """A solid of revolution from its meridian, convex and smooth, with any density.

    Parameters
    ----------
    curve
        Function of u in [0, π] with (r, z) of the meridian: distance from the axis and place along
        it, over `length`.  It starts and ends on the axis (r = 0), z rises, and it works on arrays.
    density
        Function (r, z) → density, up to a factor; uniform when left out.
    name
        Name in messages and files.
    tolerance
        Size over the largest term of the height's series below which terms of the series of its
        second slope are cut; from 1e-16 to 1e-9 [-].  A smaller one gives more terms: slower maps,
        and eigenvalues with more digits of the true body's.
    **scales
        `mass`, `gravity`, `length`, as for `Body`.

    Returns
    -------
    Body
        The height is a fit.  `error` is an estimated bound of the difference of it and its two
        slopes from those of the meridian, and of the moments from their integrals.  Verdicts, error
        discs and boundaries are proved of the fit, and their reasons say so.

    Raises
    ------
    ParameterError
        If the meridian does not start and end on the axis, is not convex and smooth enough, or the
        tolerance is out of range.

    Source: tests/bodies/test_profiles.py compares spheroids with their closed forms.

    Examples
    --------
    >>> import numpy as np
    >>> import stability as st
    >>> ball = st.from_profile(lambda u: (np.sin(u), -np.cos(u)))
    >>> [round(float(m), 12) for m in ball.moments()], ball.error < 1e-12
    ([0.4, 0.4], True)
    """
    for key in scales:
        known("keyword", key, SCALES)
    tolerance = one_number("tolerance", tolerance)
    if not FINEST <= tolerance <= LOOSE:
        raise ParameterError(f"tolerance is {tolerance:g}; it must lie in [{FINEST:g}, {LOOSE:g}].")
    meridian, mass = _Meridian(curve), _Density(density)
    with np.errstate(all="ignore"):  # what is not finite is refused
        meridian.check()
        moments, doubt = _agreed(lambda n: _moments(meridian, mass, n), "moments")
        axial, transverse, centre = moments
        terms, error = _series(meridian, centre, tolerance)
    numbers = [float(t) for t in terms]
    return Body(
        lambda theta: sum((a * ca.cos(n * theta) for n, a in enumerate(numbers) if n), numbers[0]),
        axial=axial,
        transverse=transverse,
        name=name,
        error=max(error, doubt),
        **scales,
    )


FLATTEST = 1e-3
"""Least aspect of an egg; beyond it no fit is fine."""


def Egg(  # noqa: N802
    taper: float = 0.2, *, aspect: float = 1.3, tolerance: float = TOLERANCE, **scales: Any
) -> Body:
    """A solid egg of uniform density: r = sin u (1 + taper·cos u), z = -aspect·cos u.

    Its blunt end lies at negative z: at θ = 0 the egg stands on it.

    Parameters
    ----------
    taper
        Difference of the two ends, in [0, 0.4]; 0 for a spheroid [-].
    aspect
        Half length over the radius at the middle, which is `length` [-].
    tolerance
        As for `from_profile` [-].
    **scales
        `mass`, `gravity`, `length`, as for `Body`.

    Returns
    -------
    Body
        The egg as a body of revolution, its height a fit, as for `from_profile`.

    Raises
    ------
    ParameterError
        If a number is outside its range, or a keyword is unknown.

    Source: docs/explanation/bodies.md; quadratures of the solid: tests/bodies/test_profiles.py.

    Examples
    --------
    >>> import numpy as np
    >>> import stability as st
    >>> egg = st.Egg(0.2)
    >>> bool(egg.height_at(0.0) < egg.height_at(np.pi))  # its centre lies nearer to the blunt end
    True
    """
    for key in scales:
        known("keyword", key, SCALES)
    taper, aspect = one_number("taper", taper), one_number("aspect", aspect)
    if not 0 <= taper <= 0.4:
        raise ParameterError(f"taper is {taper:g}; it must lie in [0, 0.4].")
    if not FLATTEST <= aspect <= 1 / FLATTEST:
        raise ParameterError(
            f"aspect is {aspect:g}; it must lie in [{FLATTEST:g}, {1 / FLATTEST:g}]."
        )
    egg = from_profile(
        lambda u: (np.sin(u) * (1 + taper * np.cos(u)), -aspect * np.cos(u)),
        name="egg",
        tolerance=tolerance,
        **scales,
    )
    return replace(egg, constants={"taper": taper, "aspect": aspect})


@dataclass(frozen=True)
class _Meridian:
    """The meridian that a user gives, each answer checked."""

    curve: Curve

    def __call__(self, u: Any) -> tuple[Floats, Floats]:
        """Distance from the axis and place along it, two arrays of the shape of u."""
        points = np.asarray(u, dtype=float)
        if not callable(self.curve):
            raise ParameterError(f"curve is {shown(self.curve)}; give a function of u.")
        values = _called("curve", self.curve, points)
        try:
            r, z = values
            pair = real_numbers("r", r), real_numbers("z", z)
            return np.broadcast_to(pair[0], points.shape), np.broadcast_to(pair[1], points.shape)
        except Exception:  # what a user's function gives may raise anything
            raise ParameterError(
                f"curve gives {shown(values)} at {shown(points)}; give a function of u made of "
                "NumPy's with a pair (r, z), such as lambda u: (np.sin(u), -np.cos(u))."
            ) from None

    def rise(self, u: Floats) -> Floats:
        """Slope of z, by a complex step or, where complex numbers are not taken, by differences."""
        step = 1e-30
        with suppress(Exception):  # as above
            slope = np.asarray(self.curve(u + 1j * step)[1])
            if slope.dtype.kind == "c":
                return np.broadcast_to(slope.imag / step, u.shape)
        h = 1e-3  # eighth order
        weights = (4 / 5, -1 / 5, 4 / 105, -1 / 280)
        total = sum(c * (self(u + k * h)[1] - self(u - k * h)[1]) for k, c in enumerate(weights, 1))
        return np.asarray(total / h, dtype=float)

    def check(self) -> None:
        """Refuse a meridian that is not finite, leaves the axis at its ends, or goes down."""
        u = np.linspace(0, math.pi, GRID)
        r, z = self(u)
        bad = ~(np.isfinite(r) & np.isfinite(z))
        if bad.any():
            raise ParameterError(f"the meridian has no finite point at u = {u[bad][0]:.6g}.")
        size = max(np.abs(r).max(), np.ptp(z))
        if max(abs(r[0]), abs(r[-1])) > 1e-9 * size:
            raise ParameterError(
                f"the meridian is at r = {r[0]:.3g} and {r[-1]:.3g} at its ends; both must be 0."
            )
        low = r < -1e-9 * size
        if low.any():
            raise ParameterError(
                f"r is {r[low][0]:.3g} at u = {u[low][0]:.3g}; a distance from the axis is not "
                "negative."
            )
        if not (np.diff(z) > -1e-9 * size).all() or not z[-1] > z[0]:
            at = int(np.argmin(np.diff(z)))
            raise ParameterError(
                f"z goes from {z[at]:.6g} to {z[at + 1]:.6g} near u = {u[at]:.3g}; along the "
                "meridian of a convex body, from its lower end, it rises."
            )


@dataclass(frozen=True)
class _Density:
    """The density that a user gives, each answer checked; uniform for None."""

    density: Callable[[Any, Any], Any] | None

    def __call__(self, r: Floats, z: Floats) -> Floats:
        """Densities at points, an array of their shape."""
        if self.density is None:
            return np.ones(r.shape)
        if not callable(self.density):
            raise ParameterError(
                f"density is {shown(self.density)}; give a function of r and z, or nothing."
            )
        values = _called("density", self.density, r, z)
        try:
            densities = np.broadcast_to(real_numbers("it", values), r.shape)
        except Exception:  # what a user's function gives may raise anything
            raise ParameterError(
                f"density gives {shown(values)} at {shown(r)}; give a function of r and z made of "
                "NumPy's with one number at each."
            ) from None
        bad = ~(np.isfinite(densities) & (densities >= 0))
        if bad.any() or not densities.any():
            at = tuple(np.argwhere(bad)[0]) if bad.any() else (0, 0)
            raise ParameterError(
                f"density is {densities[at]:.3g} at r = {r[at]:.3g} and z = {z[at]:.3g}; it must "
                "be finite and nowhere negative, and above 0 somewhere."
            )
        return densities


def _called(what: str, function: Callable[..., Any], *arrays: Floats) -> Any:
    """What a user's function gives at arrays, or a refusal with what it raises."""
    try:
        return function(*arrays)
    except Exception as error:  # a user's function may raise anything
        raise ParameterError(
            f"{what} has no value at {', '.join(map(shown, arrays))} ({type(error).__name__}: "
            f"{one_line(str(error), 80).rstrip('.')}); give a function made of NumPy's."
        ) from None


def _agreed(rule: Callable[[int], Floats], what: str) -> tuple[Floats, float]:
    """Values of a rule that agree with those of half as many nodes, and the relative difference."""
    before = rule(16)
    nodes = 32
    while nodes <= MOST_NODES:
        here = rule(nodes)
        gap = float(np.abs(here - before).max() / np.abs(here).max())
        if gap < TIGHT:
            return here, max(gap, 2e-16)
        before, nodes = here, 2 * nodes
    if gap < LOOSE:
        return here, gap
    raise ParameterError(
        f"the {what} of the meridian do not settle with {MOST_NODES} nodes (relative change "
        f"{gap:.2g}); give a smooth curve and density."
    )


def _moments(meridian: _Meridian, density: _Density, nodes: int) -> Floats:
    """Axial and transverse moment about the centre of mass over the mass, and the centre's z."""
    x, w = np.polynomial.legendre.leggauss(nodes)
    u, wu = (x + 1) * math.pi / 2, w * math.pi / 2
    r, z = meridian(u)
    part, wp = (x + 1) / 2, w / 2  # distance from the axis over r
    rho = r[:, None] * part
    height = np.broadcast_to(z[:, None], rho.shape)
    weight = 2 * np.pi * rho * (r * meridian.rise(u) * wu)[:, None] * wp * density(rho, height)
    mass = weight.sum()
    centre = (weight * height).sum() / mass
    axial = (weight * rho**2).sum() / mass
    across = (weight * (rho**2 / 2 + (height - centre) ** 2)).sum() / mass
    return np.array([axial, across, centre])


def _series(curve: _Meridian, centre: float, tolerance: float) -> tuple[Floats, float]:
    """Terms of the cosine series of the height; estimated error of it and its two slopes."""
    count = 16
    while count <= MOST_NODES:
        theta = np.pi * np.arange(count + 1) / count
        values = _support(curve, centre, theta)
        folded = np.concatenate([values, values[-2:0:-1]])
        terms = np.fft.rfft(folded).real / count
        terms[[0, -1]] /= 2
        size = np.abs(terms).max()
        tail = np.abs(terms[3 * count // 4 :]).max() / size
        if tail < max(tolerance / (2 * count) ** 2, 2 * FINEST):
            break
        count *= 2
    if tail > LOOSE:
        raise ParameterError(
            f"the height of the meridian is no smooth function of theta: its series ends at "
            f"{tail:.2g} after {MOST_NODES} terms; give a smooth convex curve."
        )
    order = np.arange(count + 1)
    small = np.abs(terms) < np.maximum(tolerance / np.maximum(order, 1) ** 2, FINEST) * size
    last = int(np.flatnonzero(~small).max()) + 1
    between = np.pi * (np.arange(4 * count) + 0.5) / (4 * count)
    known_ = np.cos(np.outer(between, np.arange(last))) @ terms[:last]
    gap = np.abs(known_ - _support(curve, centre, between)).max() / size
    left = np.abs(terms[last:]) / size
    error = float(gap + left.sum())
    if error > LOOSE:
        raise ParameterError(
            f"the series of the height is off by {error:.2g} between its angles; give a smooth "
            "convex curve."
        )
    # what is off by gap with waves up to last has slopes off by as many times that (Bernstein)
    return terms[:last], float(gap * last**2 + (order[last:] ** 2 * left).sum())


def _support(curve: _Meridian, centre: float, theta: ArrayLike) -> Floats:
    """Largest r sinθ - (z - centre) cosθ over the meridian, by Newton from the best of a grid."""
    theta = np.asarray(theta, dtype=float)
    s, c = np.sin(theta), np.cos(theta)

    def depth(u: Any) -> Any:
        r, z = curve(u)
        return r * s - (z - centre) * c

    grid = np.linspace(0, np.pi, GRID)
    r, z = curve(grid)
    u = grid[np.argmax(np.outer(s, r) - np.outer(c, z - centre), axis=1)]
    best = depth(u)
    for width in (1e-3, 1e-4, 1e-5, 1e-5):  # the maximum of a parabola through three points
        middle = np.clip(u, width, np.pi - width)  # next to a pole it lies aside of all three
        below, here, above = (depth(middle + step) for step in (-width, 0.0, width))
        bend = below - 2 * here + above
        move = np.where(bend < 0, width * (below - above) / (2 * bend), 0.0)
        trial = np.clip(middle + np.clip(np.nan_to_num(move), -2e-3, 2e-3), 0, np.pi)
        value = depth(trial)
        better = value > best
        u, best = np.where(better, trial, u), np.where(better, value, best)
    if not np.isfinite(best).all():
        raise ParameterError(f"the meridian has no finite point at u = {shown(float(u[0]))}.")
    return np.asarray(best, dtype=float)
