"""`codimension_two`: every point of a parameter plane at which two conditions meet."""

from __future__ import annotations

from typing import Any

import numpy as np
from flint import arb
from numpy.typing import ArrayLike

from ...algebra.exact.number_fields import NotExact
from ...algebra.number_types import precision
from ...base.axis import Axis, AxisLike
from ...base.checks import flag
from ...base.citation import cited
from ...base.errors import ParameterError
from ...bodies.contact_laws import Contact
from ...bodies.disk import Disk
from ...bodies.round_body.body import Body
from ...spectra.axes import swept
from ...spectra.labels import of_package
from ...spectra.problem import Problem
from ...systems.family import Family
from ...systems.structure.structural_zeros import structure
from ..hopf import rounded, zeros_left
from .bautin import SECONDS, ExactSearch, Vanishing
from .curve_search import CurveSearch, ProvedPoint, lines_of
from .plane_search import BITS, SPECTRAL, BoxSearch, Rectangle, SpectralPoint, isolated, joined
from .planes import GraphPlane, exact_plane
from .point_records import CodimensionTwo, DegeneratePoint, PointKind, UnresolvedBox

MOST_LINES = 2000
"""Most lines of an axis."""
RESULTANTS = (
    "double zeros, zeros with a pair, and two pairs: every solution of their equations was "
    "isolated over Q by resultants, and proved by interval Newton's method"
)
BOXES = (
    "double zeros, zeros with a pair, and two pairs: each of {count} boxes of the rectangle was "
    "proved in ball arithmetic to hold none, or one that is listed"
)
ON_BRANCH = ", on the branch of steady motions that the root-finder reaches"
CURVES = (
    "double zeros, zeros with a pair, two pairs, and cusps: each that is listed is proved by "
    "Krawczyk's test; members were followed along {x} lines of {x_name} and {y} of {y_name}, and "
    "curves of folds and pairs from where they cross these"
)
ELSEWHERE = (
    "the steady motions have folds here, so that a box of parameters holds no single member; "
    "curves of folds and pairs were followed, and points on other curves are not excluded"
)
PAIRS = (
    "vanishing first Lyapunov coefficients: each that is listed is proved; curves of pairs were "
    "followed from {x} lines along {x_name} and {y} along {y_name}, so others are not excluded"
)
EXACT = (
    "vanishing first Lyapunov coefficients: every change of sign along a flutter boundary was "
    "isolated over Q by resultants, and proved at the member"
)
FLAT = "; on some boundary the coefficient is zero all along, where no point is listed"
NONE_ON_CURVES = (
    "vanishing first Lyapunov coefficients were not sought, since the rates have no derivatives "
    "that are read exactly, or the family's equations are no rates"
)
NONE_ON_LINES = (
    "vanishing first Lyapunov coefficients were not sought, since eigenvalues vanish by structure"
)
FOLDED_SECONDS = 3.0
"""Longest time of the exact search for vanishing coefficients where members have folds [s]."""
OTHERS = {1: "stable", -1: "unstable", 0: "open"}


def codimension_two(
    family: str | Family,
    *,
    x: AxisLike,
    y: AxisLike,
    disk: Disk | None = None,
    body: Body | Disk | None = None,
    contact: Contact | type[Contact] | str | None = None,
    at: ArrayLike | None = None,
    curves: bool = False,
    **parameters: ArrayLike,
) -> CodimensionTwo:
    """Points of a parameter plane at which two conditions meet: the ends and turns of boundaries.

    Sought are double zeros (Bogdanov-Takens), a zero with a pair (zero-Hopf), two pairs (double
    Hopf), points of flutter boundaries with a vanishing first Lyapunov coefficient (Bautin), and
    cusps of folds.
    Where the linearisation is rational in both axes, or in their sine and cosine, the first three
    are isolated over Q by resultants.  Elsewhere the rectangle is cut into boxes, each with a
    proof.  Where the derivatives up to the third are algebraic too, vanishing coefficients are
    isolated over Q as well.  Elsewhere curves of pairs are followed, and `.vanishing` says why.
    Points at which other eigenvalues are unstable are listed too, and marked as such.

    A double zero of a family that is solved for lies on a fold, about which no box of parameters
    has one member.  There curves of folds and of pairs are followed on every sheet that they reach,
    and points on them, cusps among them, are proved with member and parameters unknown.  The
    result is then not complete.

    Parameters
    ----------
    family
        As for `stability_map`.
    x, y
        (name, low, high, n) or (name, low, high, n, "log").  n is the number of lines from which
        curves of folds and of pairs are followed, at least 8 and at most 24.
    disk, body, contact, at
        As for `stability_map`, with one number for every quantity but the axes.
    curves
        Whether the result holds the curves of folds and of pairs too, each with a proof at every
        point; `plot_map` draws them.  For a user's family without structural zeros.
    **parameters
        As for `stability_map`, with one number for every quantity but the axes.

    Returns
    -------
    CodimensionTwo
        A sequence of `DegeneratePoint`, with `.complete` for the first three kinds,
        `.vanishing_complete`, `.unresolved` and `.statement`.

    Raises
    ------
    ParameterError
        If the family is conservative, so that pairs stay on the imaginary axis.

    Warns
    -----
    StabilityWarning
        If the search for the first three kinds was not complete.

    Source: Yu. A. Kuznetsov, Elements of Applied Bifurcation Theory, ch. 8;
    tests/boundary/test_codimension_two.py, tests/boundary/test_bautin.py.

    Examples
    --------
    >>> import casadi as ca, stability as st
    >>> x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    >>> rates = ca.vertcat(x[1], -p[0] * x[0] - p[1] * x[1] - x[0] ** 3)
    >>> system = st.System("oscillator", x, p, rates, states=("q", "v"), parameters=("k", "c"))
    >>> rest = st.Family(system, "rest", at=("k",), held={"q": 0, "v": 0})
    >>> points = st.codimension_two(rest, x=("k", -1, 1, 5), y=("c", -1, 1, 5))
    >>> [(p.kind.word, p.x, p.y) for p in points], points.complete
    ([('double zero', 0.0, 0.0)], True)
    """
    problem, (first, second) = swept(
        family, {"x": x, "y": y}, disk, body, contact, at, parameters, most=MOST_LINES
    )
    result = in_plane(problem, (first, second), curves=flag("curves", curves))
    result.warn()
    return result


def in_plane(problem: Problem, axes: tuple[Axis, Axis], *, curves: bool = False) -> CodimensionTwo:
    """As `codimension_two`, without a warning.

    Parameters
    ----------
    problem
        Family with a value for every quantity but the axes.
    axes
        x and y.
    curves
        Whether to list curves too.
    """
    _accept(problem)
    rectangle: Rectangle = ((axes[0].low, axes[0].high), (axes[1].low, axes[1].high))
    isolated_ = problem.plain and zeros_left(problem.family) == 0
    search = CurveSearch(problem, axes) if isolated_ else None
    spectral, left, how = _spectral(problem, axes, rectangle, search)
    units = [_point(problem, axes, f) for f in spectral]
    said, every = NONE_ON_LINES, False
    if search is not None:
        some, open_, said, every = _vanishing(problem, axes, rectangle, search)
        units += some
        left += open_
    order = list(PointKind)
    points = tuple(sorted(units, key=lambda p: (order.index(p.kind), p.x, p.y)))
    ends = tuple((g.name, g.low, g.high) for g in axes)
    law = problem.law.name if problem.law else None
    works = cited(law, model=of_package(problem), proofs=True, theory=["kuznetsov2004"])
    how = problem.family.system.qualified(how)
    lines = tuple(search.proved_curves()) if curves and search is not None else ()
    return CodimensionTwo(points, (ends[0], ends[1]), tuple(left), how, said, every, works, lines)


def _accept(problem: Problem) -> None:
    family = problem.family
    how = structure(family)
    if family.conservative or how.even:
        raise ParameterError(
            f"{family.name} is conservative, where pairs stay on the imaginary axis; points of "
            "codimension two are those of families with damping."
        )
    if not how.steady:
        raise ParameterError(
            f"{family.name}: a rate does not vanish at its typical members; give a family of "
            "steady motions."
        )


def _spectral(
    problem: Problem, axes: tuple[Axis, Axis], rectangle: Rectangle, curves: CurveSearch | None
) -> tuple[list[SpectralPoint | ProvedPoint], list[UnresolvedBox], str]:
    names = axes[0].name, axes[1].name
    points: list[SpectralPoint | ProvedPoint] = []
    left: list[UnresolvedBox] = []
    try:
        plane = exact_plane(problem, names)
        for kind in SPECTRAL:
            some, open_ = isolated(plane, kind, rectangle)
            points += some
            left += open_
    except NotExact:
        return _searched(problem, axes, rectangle, curves)
    return points, left, RESULTANTS


def _searched(
    problem: Problem, axes: tuple[Axis, Axis], rectangle: Rectangle, curves: CurveSearch | None
) -> tuple[list[SpectralPoint | ProvedPoint], list[UnresolvedBox], str]:
    """Points by boxes; where members have folds, or boxes stay open, along curves."""
    family, names = problem.family, (axes[0].name, axes[1].name)
    solved = bool(family.unknown) and not family.closed
    if curves is not None and solved and curves.run() and not curves.covered:
        kinds = [kind for kind in (*SPECTRAL, PointKind.CUSP) if curves.possible(kind)]
        left = [UnresolvedBox(kind, *rectangle, ELSEWHERE) for kind in kinds]
        return [*curves.listed(*SPECTRAL, PointKind.CUSP)], left, _lines(CURVES, axes)
    search = BoxSearch(GraphPlane(problem, names), rectangle, len(family.system.states))
    search.run()
    points: list[SpectralPoint | ProvedPoint] = list(search.points)
    how = BOXES.format(count=search.count + 1) + (ON_BRANCH if solved else "")
    if search.left and curves is not None and curves.run():
        points += [
            p
            for p in curves.listed(*SPECTRAL)
            if not any(f.kind is p.kind and f.x.overlaps(p.x) and f.y.overlaps(p.y) for f in points)
        ]
    return points, search.left, how


def _lines(said: str, axes: tuple[Axis, Axis]) -> str:
    counts = [len(lines_of(g)) for g in axes]
    return said.format(x=counts[0], y=counts[1], x_name=axes[1].name, y_name=axes[0].name)


def _vanishing(
    problem: Problem, axes: tuple[Axis, Axis], rectangle: Rectangle, curves: CurveSearch
) -> tuple[list[DegeneratePoint], list[UnresolvedBox], str, bool]:
    """Vanishing coefficients: points, what stays open, how they were sought, and whether all."""
    names = axes[0].name, axes[1].name
    # of a sheet with folds an unknown remains, but for square roots
    seconds = SECONDS if curves.covered else FOLDED_SECONDS
    try:
        search = ExactSearch(problem, names, rectangle, seconds)
        places, left = search.run()
    except (NotExact, ZeroDivisionError) as error:
        if isinstance(error, ZeroDivisionError):  # as of v|v|, whose slope at v = 0 is read as 0/0
            error = NotExact("derivatives of the rates are read as 0/0 at the members")
        said = f"{_lines(PAIRS, axes)} (no exact search, since {error})"
        if not curves.run():
            said = NONE_ON_CURVES
        some = [_point(problem, axes, p) for p in curves.listed(PointKind.VANISHING)]
        return some, [], said, False
    said = EXACT + (FLAT if search.flat else "")
    return [_bautin(v) for v in places], joined(left), said, not left


def _point(
    problem: Problem, axes: tuple[Axis, Axis], point: SpectralPoint | ProvedPoint
) -> DegeneratePoint:
    with precision(BITS):
        place = [rounded(v) for v in (point.x, point.y)]
        here = dict(zip((g.name for g in axes), (p[0] for p in place), strict=True))
        values: dict[str, Any] = {n: float(v) for n, v in problem.values.items()} | here
        *_, rate, _ = problem.arrays(values)
        pairs: tuple[float, ...] = tuple(
            float(w.mid()) * float(np.asarray(rate)[0]) for w in point.nature.frequencies
        )
    member = point.unknowns if isinstance(point, ProvedPoint) else {}
    others = OTHERS[point.nature.others]
    return DegeneratePoint(point.kind, *place[0], *place[1], pairs, others, member)


def _bautin(point: Vanishing) -> DegeneratePoint:
    place = [rounded(v) for v in point.place]
    frequency = (float(arb(point.frequency).mid()),)
    others = OTHERS[point.others]
    return DegeneratePoint(PointKind.VANISHING, *place[0], *place[1], frequency, others)
