"""Every change of verdict along an axis: by exact roots where possible, otherwise in pieces."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from ..algebra.exact.number_fields import NotExact
from ..algebra.exact.roots import UnclearError
from ..base.axis import Axis, AxisLike
from ..base.citation import cited
from ..base.errors import ParameterError, StabilityError
from ..base.quantities import unit_of
from ..base.verdict import Verdict
from ..bodies.contact_laws import Contact
from ..bodies.disk import Disk
from ..bodies.round_body.body import Body
from ..spectra.axes import swept
from ..spectra.certificate import verdict as certified
from ..spectra.labels import axis_attributes, of_package, rate_attributes
from ..spectra.problem import Problem
from ..systems.family import Family
from .algebraic.exact_search import searched
from .brackets import AxisScan, Boundaries, BoundaryPoint, crossed
from .interval_search.pieces import meaningful, proved

POINT = 1e-9
"""Width of a part that the exact search leaves open, over the interval, up to which it is a point.
"""
SHARES = (0.382, 0.618)
"""Places, as shares of an axis, at which the verdict is asked that nothing changes."""
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
    verdict, which is `.throughout`, does not change, but at the single values in `.touching`.
    Pieces without such a proof are scanned.  The result then says where a change is not excluded,
    and a `StabilityWarning` repeats this.

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
        throughout=_throughout(problem, fixed, grid.name, found, (grid.low, grid.high)),
        unit=unit_of(axis_attributes(problem, grid.name)),
        rate_unit=unit_of(rate_attributes(problem)),
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


def _throughout(
    problem: Problem,
    fixed: Mapping[str, float],
    axis: str,
    found: Boundaries,
    ends: tuple[float, float],
) -> Verdict | None:
    """The verdict on the whole axis, where it is proved not to change and to be known."""
    if found.points or not found.complete:
        return None
    low, high = ends
    for share in SHARES:
        value = low + share * (high - low)
        if value in found.touching:
            continue
        with suppress(StabilityError):
            verdict = certified(problem, {**fixed, axis: value})
            if verdict is not Verdict.UNDECIDED:
                return verdict
    return None


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
    """By exact numbers where possible, otherwise in pieces; how says why."""
    exact, reason = None, ""
    try:
        exact = searched(line, low, high)
    except (NotExact, UnclearError) as error:
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
