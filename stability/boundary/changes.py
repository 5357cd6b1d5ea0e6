"""Every change of verdict along an axis: by exact roots where possible, otherwise in pieces."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from ..algebra.exact.number_fields import NotExact, rational
from ..algebra.exact.roots import UnclearError
from ..algebra.number_types import precision
from ..base.axis import Axis, AxisLike
from ..base.citation import cited
from ..base.errors import ParameterError, StabilityError
from ..base.verdict import Verdict
from ..bodies.contact_laws import Contact
from ..bodies.disk import Disk
from ..bodies.round_body.body import Body
from ..spectra.axes import swept
from ..spectra.certificate import verdict as certified
from ..spectra.labels import of_package
from ..spectra.problem import Problem
from ..spectra.verdict_routes import BITS, Point, decided
from ..systems.family import Family
from ..systems.structure.structural_zeros import structure
from .algebraic.exact_search import algebraic
from .brackets import (
    HERE,
    LATE,
    AxisScan,
    Boundaries,
    BoundaryPoint,
    Crossing,
    Unresolved,
    bracket,
    crossed,
    crossing_rate,
)
from .interval_search.pieces import meaningful, proved
from .search import Characteristic, Conditions, Mark, Search, search, single

POINT = 1e-9
"""Width of a part that the exact search leaves open, over the interval, up to which it is a point.
"""
MOST_SCAN = 1_000_000
"""Most points of a scan for boundaries along an axis."""


def boundaries(
    family: str | Family,
    *,
    axis: AxisLike,
    disk: Disk | None = None,
    body: Body | Disk | None = None,
    contact: Contact | type[Contact] | str | None = None,
    at: ArrayLike | None = None,
    **parameters: ArrayLike,
) -> Boundaries:
    """Every change of verdict along one axis, proved, with the kind of crossing.

    For the disk, and for a user's family whose graph is rational in the axis, every real root of
    every condition is isolated exactly, so that the result is complete.  So it is for a family that
    is algebraic along the axis, with sines, roots or unknowns.  For any other family the axis is
    cut into pieces, and each piece is proved in ball arithmetic to hold no eigenvalue on
    the imaginary axis, or a single crossing.  An empty result that is complete states that the
    verdict does not change, but at the single values in `.touching`.  Pieces without such a proof
    are scanned.  The result then says where a change is not excluded, and a `StabilityWarning`
    repeats this.

    Parameters
    ----------
    family
        As for `stability_map`.
    axis
        (name, low, high, n) or (name, low, high, n, "log"); both ends belong to it.  n is the
        number of points of a scan, where pieces stay without proof.
    disk, body, contact, at, **parameters
        As for `stability_map`, with one number for every quantity but the axis.  Where the axis is
        circling's theta or phi_dot, `at` is the other of the two.

    Returns
    -------
    Boundaries
        A sequence of `BoundaryPoint` in increasing order, with `.complete` (whether these are
        proved to be all) and `.unresolved` (pieces of the axis, each with a reason).

    Raises
    ------
    StabilityError
        One sentence that says what is wrong and what is accepted.

    Warns
    -----
    StabilityWarning
        If the search was not complete.

    Source: published thresholds in tests/spectra/test_published.py; all roots counted by another
    route in tests/boundary/test_boundaries.py; planted boundaries of algebraic
    families in tests/boundary/test_algebraic_boundaries.py, of others in
    tests/boundary/test_interval_search.py.

    Examples
    --------
    >>> import stability as st
    >>> found = st.boundaries("spinning", axis=("at", 0.1, 5, 9), contact=st.Viscous(0.97))
    >>> [(round(b.value, 10), b.crossing.word) for b in found], found.complete
    ([(2.0, 'static'), (2.0451355787, 'flutter')], True)
    """
    problem, (grid,) = swept(
        family, {"axis": axis}, disk, body, contact, at, parameters, exact=True, most=MOST_SCAN
    )
    found = along(problem, grid.name, grid.low, grid.high, points=grid.count, log=grid.log)
    law = problem.law.name if problem.law else None
    works = cited(law, model=of_package(problem), proofs=True)
    fixed = {n: float(v) for n, v in problem.values.items() if n != grid.name}
    found = replace(
        found,
        points=tuple(replace(b, good=_good(problem, fixed, grid.name, b)) for b in found),
        how=problem.family.system.qualified(found.how),
        searched=(grid.name, grid.low, grid.high),
        citation=works,
    )
    found.warn(grid.name)
    return found


def _good(problem: Problem, fixed: Mapping[str, float], axis: str, point: BoundaryPoint) -> Verdict:
    """The verdict next to a boundary, on the side that is not unstable."""
    side = -1.0 if point.stable_below else 1.0
    end = float(np.nextafter(point.value + side * point.error, side * np.inf))
    with suppress(StabilityError):
        return certified(problem, {**fixed, axis: end})
    return Verdict.UNDECIDED


EXACT = "every real root of every condition that decides the verdict was isolated exactly"
OWN = "from the family's polynomial"
CROSSINGS = {"static": Crossing.STATIC, "flutter": Crossing.FLUTTER}


def along(
    problem: Problem, axis: str, low: float, high: float, *, points: int = 201, log: bool = False
) -> Boundaries:
    """Every change of verdict along one axis, each as a proved bracket.

    Parameters
    ----------
    problem
        Family with a value for every quantity but the axis.
    axis
        Name of the axis.
    low, high
        Ends of its interval, both included.
    points
        Number of points of a scan, where pieces of the axis stay without proof.
    log
        Whether the points of the scan have equal ratios.

    Returns
    -------
    Boundaries
        Changes in increasing order, with the pieces of the axis that stay unresolved.

    Raises
    ------
    ParameterError
        If the interval is empty, or there are fewer than two points.

    Examples
    --------
    >>> from stability.spectra.problem import disk_problem
    >>> from stability.bodies.contact_laws import Rough
    >>> from stability.bodies.disk import Disk
    >>> [b] = along(disk_problem("rolling", Disk(), Rough()), "at", 0.1, 2.0)
    >>> b.value**2, b.crossing.word
    (0.3333333333333333, 'static')
    """
    if points < 2 or not low < high:
        raise ParameterError(f"the scan from {low} to {high} with {points} points is empty.")
    fixed = {n: float(v) for n, v in problem.values.items() if n != axis}
    line = AxisScan(problem, axis, fixed)
    found = None
    if line.formulas is not None:  # a piece that is proved has members that are proved
        found = proved(line, Axis(axis, low, high, points, log).values, log=log)
    if found is None or not found.complete:
        found = meaningful(line, low, high, _along(line, low, high, points, log=log))
    return replace(found, points=tuple(crossed(line, point) for point in found))


def _along(line: AxisScan, low: float, high: float, points: int, *, log: bool) -> Boundaries:
    """By exact roots where possible, then with algebraic numbers, otherwise in pieces."""
    with suppress(NotExact, UnclearError):
        return located(line, search(line.problem, line.axis, low, high))
    exact, reason = None, ""
    try:
        exact = algebraic(line, low, high)
    except NotExact as error:
        reason = f"; no exact search, since {error}"
    if exact is not None:
        widest = max((part.high - part.low for part in exact.unresolved), default=0.0)
        if widest <= POINT * (high - low):
            return exact  # single points stay open in pieces too
    line.__dict__["formulas"] = None
    found = proved(line, Axis(line.axis, low, high, points, log).values, log=log)
    if exact is not None and not found.complete:
        return exact
    return replace(found, how=found.how + reason)


# --- by exact roots ---


def located(line: AxisScan, found: Search) -> Boundaries:
    """The changes of verdict among the marks of a search, each as a proved bracket."""
    if line.problem.exact is None:
        structure(line.problem.family)  # refuses a family that is declared conservative and is not
    sign = _proof(line, found)
    changes = [m for m in found.marks if m.kind != "pole" and m.below != m.above]
    places = [m.value for m in changes]
    points: list[BoundaryPoint] = []
    left = [_pole(line, m) for m in found.marks if m.kind == "pole"]
    left += [
        Unresolved(v, v, f"{line.problem.family.name} has no member at this value of {line.axis}.")
        for v in found.gaps
    ]
    for i, mark in enumerate(changes):
        others = [p for j, p in enumerate(places) if abs(i - j) == 1]
        room = min((float(abs(p - mark.value).mid()) for p in others), default=np.inf)
        root = float(mark.value.mid())
        proof = bracket(sign, root, room)
        if proof is None:
            ends = float(np.nextafter(root, -np.inf)), float(np.nextafter(root, np.inf))
            left.append(Unresolved(*ends, f"{LATE}."))
            continue
        crossing = CROSSINGS[mark.kind]
        rate = _rate(line, found, mark, root, crossing)
        points.append(BoundaryPoint(root, proof[0], crossing, rate, proof[1]))
    touching, unclear = _touching(line, found)
    open_ = HERE.format(family=line.problem.family.name, sides="unstable")
    left += [Unresolved(v, v, f"{open_}.") for v in unclear]
    left = list(dict.fromkeys(left))
    how = EXACT + (f", {OWN}" if line.problem.family.exact else "")
    return Boundaries(tuple(points), tuple(sorted(left)), tuple(touching), how)


def _touching(line: AxisScan, found: Search) -> tuple[list[float], list[float]]:
    """Single values at which the verdict is neutral, and those where this is not decided."""

    def proved(value: float) -> Verdict:
        return certified(line.problem, line.fixed | {line.axis: value})

    neutral: list[float] = []
    unclear: list[float] = []
    for mark in found.marks:
        if mark.kind == "pole" or mark.below != mark.above:
            continue
        if mark.below > 0 and not found.source.dissipative:
            continue  # neutral on both sides too
        verdict = single(found, mark, proved)
        if verdict is not Verdict.UNSTABLE:
            (neutral if verdict is Verdict.NEUTRAL else unclear).append(float(mark.value.mid()))
    return neutral, unclear


def _proof(line: AxisScan, found: Search) -> Callable[[float], int]:
    """The proved verdict at a double: from the graph, by Routh's array or over Q."""
    source, exact = found.source, line.problem.exact

    def exactly(value: float) -> int:
        if isinstance(source, Conditions):
            proof = decided(Point(line.problem, line.fixed | {line.axis: value}))
            return line.sign_of(proof.verdict, proof.nearby)
        return 0 if found.angle else source.sign(rational(value))

    def by_graph(value: float) -> int:
        try:
            return line.sign(value)
        except StabilityError:  # outside the range of the body's values
            return 0

    if exact is None:
        return exactly
    if isinstance(source, Characteristic):  # balls cannot see an eigenvalue that stays on the axis
        return lambda value: exactly(value) or by_graph(value)
    return lambda value: by_graph(value) or exactly(value)


def _rate(line: AxisScan, found: Search, mark: Mark, root: float, crossing: Crossing) -> float:
    if crossing is Crossing.STATIC:
        return 0.0
    if line.problem.exact is None and isinstance(found.source, Characteristic):
        with precision(BITS):  # more digits than a frequency in doubles needs slow the roots down
            return found.source.frequency((mark.root * 1).mid().fmpq())
    return crossing_rate(line, root, crossing)


def _pole(line: AxisScan, mark: Mark) -> Unresolved:
    value = float(mark.value.mid())
    said = "differs on the two sides" if mark.below != mark.above else "is the same on both sides"
    return Unresolved(
        value,
        value,
        f"the linearisation of {line.problem.family.name} has no value there; the verdict {said}.",
    )
