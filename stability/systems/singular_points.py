"""Folds and branch points of a curve of members, to double precision by extended systems."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ..algebra.running_error import RunningError, running_error_arrays
from ..base.types import Floats, Record
from .graph.family_graph import FamilyGraph

DIFFERENCE = 6e-6
"""Step of central differences of the exact slopes, relative to 1 or to the number."""
MOST = 40
"""Most Newton steps of an extended system; its slopes of slopes are differences."""
RESOLVED = 1e-9
"""Largest last step of a resolved point, relative to 1 or to the number."""
GENUINE = 8
"""Largest unfolding of a branch point, relative to the rounding of the equations there."""
TINY = 1e-32
"""Unfolding that counts as none, for equations that are exact at the point."""
FLAT = 1e-5
"""Share of the parameter in a direction below which the direction is a pitchfork's."""
UPRIGHT = 1e-5
"""Curvature of the line's parameter over the unknowns at a fold, both over 1 or their size, below
which it is a cusp: there the parameter does not turn."""
NEAR = 1e-2
"""Longest way in the unknowns to the point that ended a line, relative to 1 or to the unknown."""


@dataclass(frozen=True, eq=False)
class Curve(Record):
    """Members as points z = (unknowns, share) on r(z) = 0, along a line of given numbers.

    The share counts from `start`, in units of `turn`; both hold (family parameters, parameters).
    """

    graph: FamilyGraph = field(compare=False)
    """The family's graph."""
    cut: int
    """Number of family parameters."""
    start: Floats
    """Numbers at the share 0; of several lines a row for each."""
    turn: Floats
    """Change of the numbers over a share of 1."""

    def given(self, z: Floats) -> Floats:
        """Numbers at points, shape (N, m)."""
        out: Floats = self.start + z[:, -1:] * self.turn
        return out

    def at(self, z: Floats) -> tuple[Floats, Floats]:
        """Residuals and slopes.

        Returns
        -------
        r, slope
            Shapes (N, u) and (N, u, u + 1).
        """
        numbers = list(self.given(z).T)
        arguments = [numbers[: self.cut], list(z.T[:-1]), numbers[self.cut :]]
        r, r_u, r_g = self.graph.along.arrays(arguments, z.shape[:1])
        return r[..., 0], np.concatenate([r_u, r_g @ self.turn[..., None]], axis=2)

    def noise(self, z: Floats) -> Floats:
        """Bound on the rounding of the residual at one point, shape (u,)."""
        exact = [RunningError(np.array([v]), np.zeros(1)) for v in (*self.given(z[None])[0], *z)]
        m = len(self.start)
        arguments = [exact[: self.cut], exact[m:-1], exact[self.cut : m]]
        bounds: Floats = running_error_arrays(self.graph.residual, arguments, (1,))[0][1][0, :, 0]
        return bounds

    def turning(self, z: Floats) -> Floats:
        """Derivatives of the slope by each part of z, shape (u + 1, u, u + 1)."""
        h = DIFFERENCE * (1 + np.abs(z))
        shifts = np.diag(h)
        _, slopes = self.at(np.vstack([z + shifts, z - shifts]))
        out: Floats = (slopes[: len(z)] - slopes[len(z) :]) / (2 * h)[:, None, None]
        return out


class Located(NamedTuple):
    """A singular point of a curve."""

    z: Floats
    """Unknowns and parameter, shape (u + 1,)."""
    step: Floats
    """Size of the last step of each, shape (u + 1,)."""
    resolved: bool
    """Whether Newton's method settled on a genuine point."""
    left: Floats
    """Left null vector of the slope, shape (u,)."""


@np.errstate(all="ignore")  # what is not finite is no singular point
def locate_fold(curve: Curve, z: Floats) -> Located:
    """The fold near a point: r = 0 and r_u φ = 0 with φ of length 1.

    Parameters
    ----------
    curve
        The curve.
    z
        A point near the fold, shape (u + 1,).

    Source: Seydel, Practical Bifurcation and Stability Analysis (2010), section 5.4;
    closed forms in tests/systems/test_continuation.py.
    """
    n = len(z) - 1
    slope = curve.at(z[None])[1][0]
    if not np.isfinite(slope).all():
        return _nowhere(z)
    phi = c = np.linalg.svd(slope[:, :n])[2][-1]
    last = np.full(n + 1, np.inf)
    for _ in range(MOST):
        r, slope = (v[0] for v in curve.at(z[None]))
        second = curve.turning(z)[:, :, :n] @ phi  # (u + 1, u)
        block = np.zeros((2 * n + 1, 2 * n + 1))
        block[:n, : n + 1] = slope
        block[n : 2 * n, : n + 1] = second.T
        block[n : 2 * n, n + 1 :] = slope[:, :n]
        block[-1, n + 1 :] = c
        step = _step(block, np.concatenate([r, slope[:, :n] @ phi, [c @ phi - 1]]))
        if step is None:
            break
        z, phi = z - step[: n + 1], phi - step[n + 1 :]
        if _settled(z, last, last := np.abs(step[: n + 1])):
            break
    if not np.isfinite(slope).all():
        return _nowhere(z)
    left = np.linalg.svd(slope[:, :n])[0][:, -1]
    terms = np.abs(slope) * (1 + np.abs(z))
    bent = abs(float(left @ slope[:, -1])) * (1 + abs(z[-1])) > FLAT * float(terms.max())
    return Located(z, last, bool((last <= RESOLVED * (1 + np.abs(z))).all() and bent), left)


@np.errstate(all="ignore")
def locate_branch_point(curve: Curve, z: Floats) -> Located:
    """The branch point near a point: r + μ c = 0 and ψ (r_u, r_p) = 0 with c ψ = 1, where μ = 0.

    Returns
    -------
    Located
        Not resolved where μ is not zero: two curves then only pass close to each other.

    Source: Moore, Numer. Funct. Anal. Optim. 2 (1980) 441; closed forms in
    tests/systems/test_continuation.py.
    """
    n = len(z) - 1
    slope = curve.at(z[None])[1][0]
    if not np.isfinite(slope).all():
        return _nowhere(z)
    psi = c = np.linalg.svd(slope)[0][:, -1]
    mu, last = 0.0, np.full(n + 1, np.inf)
    for _ in range(MOST):
        r, slope = (v[0] for v in curve.at(z[None]))
        second = np.einsum("kij,i->jk", curve.turning(z), psi)
        block = np.zeros((2 * n + 2, 2 * n + 2))
        block[:n, : n + 1], block[:n, n + 1] = slope, c
        block[n : 2 * n + 1, : n + 1] = second
        block[n : 2 * n + 1, n + 2 :] = slope.T
        block[-1, n + 2 :] = c
        step = _step(block, np.concatenate([r + mu * c, slope.T @ psi, [c @ psi - 1]]))
        if step is None:
            break
        z, mu, psi = z - step[: n + 1], mu - float(step[n + 1]), psi - step[n + 2 :]
        rest = _settled(z, last, last := np.abs(step[: n + 1]))
        # μ may lag by a step: it is quadratic in the last error of z
        if rest and (abs(float(step[n + 1])) <= abs(mu) or abs(mu) <= _least(curve, z)):
            break
    near = bool((last <= RESOLVED * (1 + np.abs(z))).all())
    return Located(z, last, near and abs(mu) <= _least(curve, z), psi)


def _nowhere(z: Floats) -> Located:
    """What is located where the equations have no finite slope."""
    return Located(z, np.full(len(z), np.inf), False, np.zeros(len(z) - 1))


def _least(curve: Curve, z: Floats) -> float:
    """Largest unfolding that rounding of the equations accounts for."""
    return GENUINE * float(np.linalg.norm(curve.noise(z))) + TINY


def directions(curve: Curve, point: Located) -> Floats | None:
    """Both directions through a branch point, from the algebraic bifurcation equation.

    Returns
    -------
    ndarray or None
        Shape (2, u + 1), each of length 1; None where they are not two and different.
    """
    slope = curve.at(point.z[None])[1][0]
    plane = np.linalg.svd(slope)[2][-2:]
    second = np.einsum("kij,i->jk", curve.turning(point.z), point.left)
    a, b, c = (float(plane[i] @ second @ plane[j]) for i, j in ((0, 0), (0, 1), (1, 1)))
    size = max(abs(a), abs(b), abs(c))
    inside = b * b - a * c
    if not inside > 1e-8 * size**2:
        return None
    # a α² + 2 b α β + c β² = 0, by the larger of the two outer coefficients
    far = -b - np.copysign(np.sqrt(inside), b)
    pairs = np.array([[far, a], [c, far]])  # (α, β) with both quotients free of cancellation
    both = pairs @ plane
    unit: Floats = both / np.linalg.norm(both, axis=1, keepdims=True)
    return unit


def kind_of_crossing(both: Floats | None) -> str:
    """`pitchfork`, `transcritical`, or `unresolved` where no direction leads along the axis."""
    if both is None or (flat := np.abs(both[:, -1]) <= FLAT).all():
        return "unresolved"
    return "pitchfork" if flat.any() else "transcritical"


def singular_point(curve: Curve, end: Floats, reach: float) -> tuple[str, Located] | None:
    """The point at which members that were followed along a curve end.

    Parameters
    ----------
    curve
        The curve.
    end
        Its last member, shape (u + 1,).
    reach
        Longest way from it to the point, in the parameter.

    Returns
    -------
    word, Located
        `fold`, `cusp`, `pitchfork`, `transcritical point`, or `branch point` where its directions
        are not resolved; None where no such point is.
    """

    def near(candidate: Located) -> bool:
        way = np.abs(candidate.z - end)
        close = bool((way[:-1] <= NEAR * (1 + np.abs(end[:-1]))).all())
        return candidate.resolved and close and bool(way[-1] <= reach)

    # the equations of a fold hold at a pitchfork too, those of a branch point at no fold
    located = locate_branch_point(curve, end)
    if near(located):
        kind = kind_of_crossing(directions(curve, located))
        words = {"transcritical": "transcritical point", "unresolved": "branch point"}
        return words.get(kind, kind), located
    located = locate_fold(curve, end)
    if near(located):
        return "cusp" if _upright(curve, located) else "fold", located
    return None


@np.errstate(all="ignore")
def _upright(curve: Curve, fold: Located) -> bool:
    """Whether the curve's parameter does not turn at a fold: ψ r_uu φ φ = 0."""
    z, left = fold.z, fold.left
    n = len(z) - 1
    slope = curve.at(z[None])[1][0]
    _, sizes, ways = np.linalg.svd(slope[:, :n])
    if n > 1 and not sizes[-2] > UPRIGHT * np.abs(slope).max():
        return False  # φ is not the only direction
    phi = ways[-1]
    bend = np.einsum("i,kij,k,j->", left, curve.turning(z)[:n, :, :n], phi, phi)
    size = float(np.max(1 + np.abs(z[:n]))) ** 2 / (1 + abs(float(z[-1])))
    return bool(abs(bend) * size <= UPRIGHT * abs(left @ slope[:, -1]))


def _step(block: Floats, right: Floats) -> Floats | None:
    if not (np.isfinite(block).all() and np.isfinite(right).all()):
        return None
    try:
        step: Floats = np.asarray(np.linalg.solve(block, right), dtype=float)
    except np.linalg.LinAlgError:
        return None
    return step if np.isfinite(step).all() else None


def _settled(z: Floats, before: Floats, now: Floats) -> bool:
    """Whether steps are rounding: tiny, and no longer shrinking."""
    size = 1 + np.abs(z)
    largest, earlier = float((now / size).max()), float((before / size).max())
    return largest <= 1e-15 or (largest <= 1e-12 and largest >= earlier / 2)


def crossings(curve: Curve, z: Floats) -> list[tuple[Located, Floats]]:
    """Branch points between members, where the determinant of the slope changes sign.

    Parameters
    ----------
    curve
        The curve of the members.
    z
        Members in order, shape (N, u + 1).

    Returns
    -------
    list of (Located, array)
        Each point, and the way from the member before it to the one after, shape (u + 1,).
    """
    if z.shape[1] == 1:
        return []
    slope = curve.at(z)[1][:, :, :-1]
    sign = np.linalg.slogdet(slope)[0]
    kept = np.flatnonzero(sign)  # a member on the very point has no sign
    located = []
    for i, j in zip(kept[:-1], kept[1:], strict=True):
        if sign[i] != sign[j]:
            middle, way = (z[i] + z[j]) / 2, z[j] - z[i]
            point = locate_branch_point(curve, middle)
            if not np.linalg.norm(point.z - middle) <= np.linalg.norm(way):
                point = Located(middle, np.abs(way) / 2, False, point.left)
            located.append((point, way))
    return located
