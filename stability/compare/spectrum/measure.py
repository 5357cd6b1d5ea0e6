"""Routes to a spectrum on every hardness class: time for each point against error."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...base.errors import NameUnknownError, StabilityError, shown
from ...base.types import Floats
from ...base.verdict import CODES, Verdict
from ...jobs.measured_cells import Task
from ..timing import timed
from .hardness import EDGES, classes, points_of
from .points import Points, edge
from .routes.jacobians import (
    AutomaticJacobian,
    AutomaticRaw,
    AutomaticTolerance,
    CentralDifferences,
    ComplexStep,
    ForwardDifferences,
    Hurwitz,
    LongForwardDifferences,
    PolynomialRoots,
    ShortForwardDifferences,
    SolvedSymbolically,
    SymbolicJacobian,
)
from .routes.mpmath_routes import ManyDigits, MoreDigits, MostDigits
from .routes.package_routes import OWN
from .routes.route import Answer, Route, check

FEW = 12
"""Points of a class, about, for a route that takes one point at a time."""
MANY = 960
"""Points of a timed call of a route that takes arrays."""
BRACKET = 1e-2
"""Relative half-width of the bracket in which a boundary is searched for."""
HALVINGS = 32
"""Halvings from 1e-13 to below 1e-22, which is far below the rounding of a double."""
SPARSE = 4
"""A slow route is asked one boundary in this many."""
PEOPLE: tuple[type[Route], ...] = (
    ForwardDifferences,
    CentralDifferences,
    ComplexStep,
    AutomaticJacobian,
    AutomaticTolerance,
    SymbolicJacobian,
    PolynomialRoots,
    Hurwitz,
    ManyDigits,
    MoreDigits,
    MostDigits,
)
"""Routes that people use, in the charts."""
STEPS: tuple[type[Route], ...] = (
    LongForwardDifferences,
    ShortForwardDifferences,
    AutomaticRaw,
    SolvedSymbolically,
)
"""Further routes that people use, in the catalogue of failures only."""
ROUTES: dict[str, type[Route]] = {r.name: r for r in (*PEOPLE, *STEPS, *OWN)}
"""Every route by name."""
CHARTED = tuple(r.name for r in (*PEOPLE, *OWN))
"""Names of the routes in the charts."""


def route(name: str) -> Route:
    """A route by its name.

    Parameters
    ----------
    name
        A key of `ROUTES`.

    Returns
    -------
    Route

    Raises
    ------
    NameUnknownError
        If there is none.

    Examples
    --------
    >>> route("complex-step").title
    'Jacobian by complex steps of 1e-30; LAPACK'
    """
    if name not in ROUTES:
        raise NameUnknownError(f"route is {shown(name)}; known are {', '.join(ROUTES)}.")
    return ROUTES[name]()


def tasks() -> list[list[Task]]:
    """Tasks of the chart, grouped by route: a process for each, so that none disturbs another."""
    return [
        [
            *(Task(f"spectrum/{c}/{name}", measure, (c, name)) for c in classes()),
            Task(f"boundary/{name}", locate, (name,)),
        ]
        for name in CHARTED
    ]


def errors(points: Points, answer: Answer) -> tuple[Floats | None, Floats | None]:
    """Errors of eigenvalues and abscissa at each point.

    Parameters
    ----------
    points
        The points.
    answer
        Answer of a route.

    Returns
    -------
    eigenvalues
        Largest error over the largest modulus, after the best matching; shape (N,), or None.
    abscissa
        Error over the abscissa itself, over the largest modulus where that is zero; (N,) or None.
    """
    truth = points.truth
    size = np.abs(truth.eigenvalues).max(axis=1)
    size = np.where(size > 0, size, 1.0)
    eigenvalues = None
    if answer.eigenvalues is not None:
        eigenvalues = (
            np.array(
                [
                    _matched(mine, exact, rest)
                    for mine, exact, rest in zip(
                        answer.eigenvalues, truth.eigenvalues, truth.rest, strict=True
                    )
                ]
            )
            / size
        )
    if answer.abscissa is None:
        return eigenvalues, None
    scale = np.where(truth.abscissa != 0, np.abs(truth.abscissa), size)
    off = np.abs((answer.abscissa - truth.abscissa) - truth.abscissa_rest)
    return eigenvalues, off / scale


def _matched(mine: Any, exact: Any, rest: Any) -> float:
    from scipy.optimize import linear_sum_assignment

    distance = np.abs((mine[:, None] - exact[None, :]) - rest[None, :])
    rows, columns = linear_sum_assignment(distance)
    return float(distance[rows, columns].max())


def measure(hardness: str, name: str) -> dict[str, Any]:
    """One cell: the errors of a route on a class, and its times.

    Parameters
    ----------
    hardness, name
        Names of the hardness class and of the route.

    Returns
    -------
    dict
        eigenvalues, abscissa: errors at each point, or None; wrong, undecided: numbers of
        verdicts; count: number of points; first: seconds of the first call; one, many: seconds per
        point of each timed call, at one point and at many.
    """
    import time

    mine = route(name)
    groups = [p if mine.arrays else p[: _share(p, hardness)] for p in points_of(hardness)]
    first = None
    found: dict[str, Any] = {"eigenvalues": [], "abscissa": [], "wrong": 0, "undecided": 0}
    for points in groups:
        start = time.perf_counter()
        answer = mine.answer(points)
        first = time.perf_counter() - start if first is None else first
        check(points, answer)
        eigenvalues, abscissa = errors(points, answer)
        for key, values in (("eigenvalues", eigenvalues), ("abscissa", abscissa)):
            found[key] = None if values is None else [*found[key], *values.tolist()]
        open_ = answer.codes == CODES[Verdict.UNDECIDED]
        found["undecided"] += int(open_.sum())
        found["wrong"] += int(((answer.codes != points.truth.codes) & ~open_).sum())
    found |= {"count": sum(len(p) for p in groups), "first": first}
    return found | _times(mine, groups)


def _share(points: Points, hardness: str) -> int:
    """Number of a group's points for a slow route: about `FEW` in the whole class."""
    total = sum(len(p) for p in points_of(hardness))
    return max(1, round(FEW * len(points) / total))


def _times(mine: Route, groups: Sequence[Points]) -> dict[str, list[float]]:
    """Seconds per point of each repeat: at one point, and at many for a route with arrays."""
    one: list[float] = []
    for points in groups[:2]:
        single = points[:1]
        least, budget = (5, 0.06) if mine.arrays else (2, 0.06)
        one += timed(lambda p=single: mine.answer(p), least=least, most=40, budget=budget)  # type: ignore[misc]
    if not mine.arrays:
        return {"one": one, "many": []}
    many: list[float] = []
    for points in groups[:2]:
        tiled = points[np.arange(MANY) % len(points)]
        repeats = timed(lambda p=tiled: mine.answer(p), least=3, most=20, budget=0.1)  # type: ignore[misc]
        many += [seconds / MANY for seconds in repeats]
    return {"one": one, "many": many}


# --- boundaries ---


def locate(name: str) -> dict[str, Any]:
    """One cell: each boundary, searched by bisection on a route's verdict from 1 % off.

    For the package's routes, its function `boundaries` replaces the bisection.

    Parameters
    ----------
    name
        The route.

    Returns
    -------
    dict
        Lists along `EDGES`, None where a slow route is not asked.  error: relative, None where not
        found; seconds; width: the stated relative half-width, or None.
    """
    import time

    mine = route(name)
    out: dict[str, Any] = {"error": [], "seconds": [], "width": []}
    slow = not mine.own and not mine.arrays
    for number, where in enumerate(EDGES):
        if slow and number % SPARSE:
            for key in out:
                out[key].append(None)
            continue
        exact = exact_edge(*where)
        start = time.perf_counter()
        found, width = _found(mine, where, exact[0])
        out["seconds"].append(time.perf_counter() - start)
        error = None if found is None else abs((found - exact[0]) - exact[1]) / exact[0]
        out["error"].append(error)
        out["width"].append(width)
    return out


def exact_edge(
    family: str, law: str, k: float, mu: float | None, low: float, high: float
) -> tuple[float, float]:
    """A boundary to 22 digits, by bisection on the sign of Hurwitz's determinants in balls.

    Parameters
    ----------
    family, law, k, mu, low, high
        As in `EDGES`.

    Returns
    -------
    value, rest
        The boundary rounded to double, and the exact boundary less that, as a double.
    """
    from fractions import Fraction

    from flint import arb, fmpq

    from ...algebra.exact.routh import hurwitz_sign, verdict_polynomial
    from ...algebra.number_types import precision
    from ...bodies.thin_disk import disk_family
    from ...systems.structure.enclosure import characteristic
    from ...systems.structure.structural_zeros import structure

    near = edge(family, law, k, mu, low, high)
    member = disk_family(family, law)
    zeros = structure(member).zeros
    q = [fmpq(*v.as_integer_ratio()) for v in ((k,) if mu is None else (k, mu))]

    def sign(at: Fraction) -> int:
        with precision(512):
            a = [arb(fmpq(at.numerator, at.denominator))]
            c = characteristic(member, a, [arb(v) for v in q])
            return hurwitz_sign(verdict_polynomial(c, zeros, member.conservative))

    a, b = (Fraction(near) * (1 + Fraction(s, 10**13)) for s in (-1, 1))
    below = sign(a)
    if below * sign(b) != -1:
        raise ArithmeticError(f"{family}, {law}: no boundary near {near}")
    for _ in range(HALVINGS):
        middle = (a + b) / 2
        here = sign(middle)
        if here == 0:  # the boundary itself
            a = b = middle
            break
        a, b = (middle, b) if here == below else (a, middle)
    middle = (a + b) / 2
    return float(middle), float(middle - Fraction(float(middle)))


def _found(mine: Route, where: Any, near: float) -> tuple[float | None, float | None]:
    return _proved(where, near) if mine.own else (_bisected(mine, where, near), None)


def _bisected(mine: Route, where: Any, near: float) -> float | None:
    """Bisection on whether a route says unstable; None where the ends are not distinguished."""
    family, law, k, mu = where[:4]

    def unstable(at: float) -> bool:
        friction = None if mu is None else np.array([mu])
        code = mine.answer(Points(family, law, np.array([k]), friction, np.array([at]))).codes[0]
        return bool(code == CODES[Verdict.UNSTABLE])

    low, high = near * (1 - BRACKET), near * (1 + BRACKET)
    first = unstable(low)
    if unstable(high) == first:
        return None
    while low < (middle := (low + high) / 2) < high:
        if unstable(middle) == first:
            low = middle
        else:
            high = middle
    return (low + high) / 2


def _proved(where: Any, near: float) -> tuple[float | None, float | None]:
    """A boundary by the package's `boundaries`, and its proved relative half-width."""
    from ...bodies.disk import Disk
    from ...bodies.law_names import law_named
    from ...boundary.changes import boundaries

    family, law, k, mu = where[:4]
    try:
        found = boundaries(
            family,
            axis=("at", near * (1 - BRACKET), near * (1 + BRACKET), 4),
            disk=Disk(k=k),
            contact=law_named(law, mu),
        )
    except StabilityError:
        return None, None
    if len(found) != 1:
        return None, None
    return found[0].value, found[0].error / found[0].value
