"""Every change of verdict along an axis: by exact roots where possible, otherwise in pieces."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import cache, partial
from typing import Literal, TypeVar, overload

import numpy as np
from numpy.typing import ArrayLike

from ..algebra.exact.number_fields import NotExact
from ..algebra.exact.roots import UnclearError
from ..algebra.number_types import precision
from ..base.axis import Axis, AxisLike
from ..base.checks import flag
from ..base.citation import cited
from ..base.errors import ParameterError, StabilityError
from ..base.quantities import unit_of
from ..base.types import Floats
from ..base.verdict import Verdict
from ..bodies.contact_laws import TAKEN, Contact
from ..bodies.disk import Disk
from ..bodies.round_body.body import Body
from ..spectra.axes import swept
from ..spectra.certificate import verdict as certified
from ..spectra.labels import axis_attributes, of_package, rate_attributes
from ..spectra.problem import Problem
from ..spectra.verdict_routes import BITS
from ..systems.family import Family
from ..systems.singular_points import Curve, crossings, directions, kind_of_crossing
from ..systems.sources.numeric import NumericSystem
from ..systems.symmetry import symmetric_family
from .algebraic.exact_search import MOST_DIGITS, searched
from .brackets import AxisScan, Boundaries, BoundaryPoint, Crossings, Unresolved, crossed
from .by_floats import float_boundaries, float_crossings
from .every_crossing import crossings_in_pieces, every_crossing
from .interval_search.pieces import meaningful, proved
from .switched import joined, met_by_members, passings, switched

Points = TypeVar("Points", Boundaries, Crossings)
SYMMETRIC = "; members are symmetric, which is proved, and were solved for in symmetric coordinates"
ZERO = 1e-12
"""Value of a branch point, over the interval, up to which it is 0 within rounding."""
CROSSED = (
    "another branch of steady motions crosses at {axis} = {value:.12g}, {kind} as far as double "
    "precision shows, and no symmetry is known by which this is proved"
)
SINGULAR = (
    "det ∂g/∂y of the algebraic equations of {} changes its sign here (a singularity-induced "
    "point): their index is above 1 there, and an eigenvalue may pass through infinity."
)
KINDS = {
    "pitchfork": "a pitchfork",
    "transcritical": "a transcritical point",
    "unresolved": "a branch point",
}
POINT = 1e-9
"""Width of a part that the exact search leaves open, over the interval, up to which it is a point.
"""
SHARES = (0.382, 0.618)
"""Places, as shares of an axis, at which the verdict is asked that nothing changes."""
MOST_SCAN = 1_000_000
"""Most points of a scan for boundaries along an axis."""


@overload
def boundaries(
    family: str | Family,
    *,
    axis: AxisLike,
    disk: Disk | None = None,
    body: Body | Disk | None = None,
    contact: Contact | type[Contact] | str | None = None,
    at: ArrayLike | None = None,
    every: Literal[False] = False,
    **parameters: ArrayLike,
) -> Boundaries: ...
@overload
def boundaries(
    family: str | Family,
    *,
    axis: AxisLike,
    disk: Disk | None = None,
    body: Body | Disk | None = None,
    contact: Contact | type[Contact] | str | None = None,
    at: ArrayLike | None = None,
    every: Literal[True],
    **parameters: ArrayLike,
) -> Crossings: ...
def boundaries(
    family: str | Family,
    *,
    axis: AxisLike,
    disk: Disk | None = None,
    body: Body | Disk | None = None,
    contact: Contact | type[Contact] | str | None = None,
    at: ArrayLike | None = None,
    every: bool = False,
    **parameters: ArrayLike,
) -> Boundaries | Crossings:
    """Every change of verdict along one axis, proved, with the kind of crossing.

    For the disk, and for a user's family whose graph is rational in the axis, every real root of
    every condition is isolated exactly, so that the result is complete.  So it is for a family that
    is algebraic along the axis, with sines, roots or unknowns.  For any other family the axis is
    cut into pieces, and each piece is proved in ball arithmetic to hold no eigenvalue on
    the imaginary axis, or a single crossing.  An empty result that is complete states that the
    verdict, which is `.throughout`, does not change, but at the single values in `.touching`.
    Pieces without such a proof are scanned.  The result then says where a change is not excluded,
    and a `StabilityWarning` repeats this.  A Python function is scanned by floats: each point says
    so, and the result is never complete.

    Parameters
    ----------
    family
        As for `stability_map`.
    axis
        (name, low, high, n) or (name, low, high, n, "log"); both ends belong to it.  n is the
        number of points of a scan, where pieces stay without proof.
    disk, body, contact, at
        As for `stability_map`, with one number for every quantity but the axis.  Where the axis is
        circling's theta or phi_dot, `at` is the other of the two.
    every
        Whether each crossing of the imaginary axis is listed, also where other eigenvalues stay
        unstable.
    **parameters
        As for `stability_map`, one number each.

    Returns
    -------
    Boundaries
        A sequence of `BoundaryPoint` in increasing order, with `.complete` (whether these are
        proved to be all) and `.unresolved` (pieces of the axis, each with a reason).  With `every`
        a sequence of crossings instead, each with `value`, `error`, `crossing`, `frequencies`, and
        the proved numbers `unstable_below` and `unstable_above` of unstable eigenvalues.

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
    >>> changes = st.boundaries("spinning", axis=("at", 0.1, 5, 9), contact=st.Viscous(0.97))
    >>> [(round(b.value, 10), b.crossing.word) for b in changes], changes.complete
    ([(2.0, 'static'), (2.0451355787, 'flutter')], True)

    >>> law = st.Viscous(1)
    >>> crossings = st.boundaries("rolling", axis=("at", 0.1, 5, 9), contact=law, every=True)
    >>> [(c.crossing.word, c.unstable_below, c.unstable_above) for c in crossings]
    [('static', 1, 2), ('flutter', 2, 0)]
    """
    every = flag("every", every)
    problem, (grid,) = swept(
        family,
        {"axis": axis},
        disk,
        body,
        contact,
        at,
        parameters,
        exact=True,
        linear=True,
        most=MOST_SCAN,
    )
    numeric = isinstance(problem.family.system, NumericSystem)
    if every:
        search = float_crossings if numeric else every_along
        crossings = _described(problem, grid, search(problem, grid))
        crossings.warn(grid.name)
        return crossings
    if numeric:
        scanned = _described(problem, grid, float_boundaries(problem, grid))
        scanned.warn(grid.name)
        return scanned
    fixed = {n: float(v) for n, v in problem.values.items() if n != grid.name}
    changes = along(problem, grid.name, grid.low, grid.high, points=grid.count, log=grid.log)

    @cache
    def regular() -> Problem:
        line = AxisScan(problem, grid.name, fixed)
        return _past_branch_points(line, grid.values)[0].problem

    changes = replace(
        _described(problem, grid, changes),
        points=tuple(
            replace(b, good=_good(regular, problem, fixed, grid.name, b)) for b in changes
        ),
        throughout=_throughout(problem, fixed, grid.name, changes, (grid.low, grid.high)),
    )
    changes.warn(grid.name)
    return changes


def every_along(problem: Problem, grid: Axis) -> Crossings:
    """Every crossing of the imaginary axis along one axis, each as a proved bracket."""
    return _piecewise(problem, grid.name, grid.low, grid.high, partial(_every, grid=grid))


def _every(problem: Problem, axis: str, low: float, high: float, *, grid: Axis) -> Crossings:
    fixed = {n: float(v) for n, v in problem.values.items() if n != axis}
    line = AxisScan(problem, axis, fixed)
    searches = every_crossing, crossings_in_pieces
    crossings = _along(line, low, high, grid.count, log=grid.log, searches=searches)
    return meaningful(line, low, high, crossings)


def _piecewise(
    problem: Problem,
    axis: str,
    low: float,
    high: float,
    search: Callable[[Problem, str, float, float], Points],
) -> Points:
    """The search, on each smooth piece where there are switches along the axis."""
    places: tuple[float, ...] = switched(problem.family, axis)
    if any(low <= place <= high for place in places):
        return joined(problem, axis, [low, *(v for v in places if low < v < high), high], search)
    return search(problem, axis, low, high)


def _described(problem: Problem, grid: Axis, result: Points) -> Points:
    """A result with what was searched, units, and what to cite."""
    if problem.family.system.algebraic:
        fixed = {n: float(v) for n, v in problem.values.items() if n != grid.name}
        line = AxisScan(problem, grid.name, fixed)
        left = tuple(_singularity_named(line, part) for part in result.unresolved)
        result = replace(result, unresolved=left)
    law = problem.law.name if problem.law else None
    proofs = not isinstance(problem.family.system, NumericSystem)
    formula = problem.law.formula if problem.law else ""
    return replace(
        result,
        how=problem.family.system.qualified(result.how),
        searched=(grid.name, grid.low, grid.high),
        citation=cited(law, model=of_package(problem), eigenvalues=not proofs, proofs=proofs),
        note=formula if formula.endswith(TAKEN) else "",
        unit=unit_of(axis_attributes(problem, grid.name)),
        rate_unit=unit_of(rate_attributes(problem)),
    )


def _singularity_named(line: AxisScan, part: Unresolved) -> Unresolved:
    """A piece with the reason that algebraic equations lose index 1 in it, where that is so."""
    signs = set()
    for end in (np.nextafter(part.low, -np.inf), np.nextafter(part.high, np.inf)):
        with suppress(StabilityError, ArithmeticError), precision(BITS):
            value = line.determinant(float(end))
            signs |= {1} if value > 0 else {-1} if value < 0 else set()
    if signs != {1, -1}:
        return part
    return part._replace(reason=SINGULAR.format(line.problem.family.system.name))


def _good(
    regular: Callable[[], Problem],
    problem: Problem,
    fixed: Mapping[str, float],
    axis: str,
    point: BoundaryPoint,
) -> Verdict:
    """The verdict next to a boundary, on the side that is not unstable."""
    side = -1.0 if point.stable_below else 1.0
    end = float(np.nextafter(point.value + side * point.error, side * np.inf))
    verdict = Verdict.UNDECIDED
    with suppress(StabilityError):
        verdict = certified(problem, {**fixed, axis: end})
    if verdict is Verdict.UNDECIDED:  # next to a pitchfork no member is proved in other coordinates
        with suppress(StabilityError):
            verdict = certified(regular(), {**fixed, axis: end})
    return verdict


def _throughout(
    problem: Problem,
    fixed: Mapping[str, float],
    axis: str,
    changes: Boundaries,
    ends: tuple[float, float],
) -> Verdict | None:
    """The verdict on the whole axis, where it is proved not to change and to be known."""
    if changes.points or not changes.complete:
        return None
    low, high = ends
    for share in SHARES:
        value = low + share * (high - low)
        if value in changes.touching:
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
    return _piecewise(problem, axis, low, high, partial(_smooth, points=points, log=log))


def _smooth(
    problem: Problem, axis: str, low: float, high: float, *, points: int, log: bool
) -> Boundaries:
    """The same where no switch is known along the axis."""
    fixed = {n: float(v) for n, v in problem.values.items() if n != axis}
    line = AxisScan(problem, axis, fixed)
    changes = None
    if line.formulas is not None:  # a piece that is proved has members that are proved
        changes = proved(line, Axis(axis, low, high, points, log).values, log=log)
    if changes is None or not changes.complete:
        again = partial(_smooth, points=2, log=False)

        def in_pieces(
            line: AxisScan, grid: Floats, *, log: bool, singular: Mapping[float, str]
        ) -> Boundaries:
            known = {**passings(line, grid), **singular}
            return met_by_members(line, proved(line, grid, log=log, singular=known), again)

        whole = _along(line, low, high, points, log=log, searches=(searched, in_pieces))
        changes = met_by_members(line, meaningful(line, low, high, whole), again)
    return replace(changes, points=tuple(crossed(line, point) for point in changes))


def _along(
    line: AxisScan,
    low: float,
    high: float,
    points: int,
    *,
    log: bool,
    searches: tuple[Callable[..., Points], Callable[..., Points]],
) -> Points:
    """By exact numbers where possible, otherwise in pieces; how says why."""
    exact: Points | None = None
    reason = ""
    try:
        exact = searches[0](line, low, high)
    except (NotExact, UnclearError) as error:
        reason = f"; no exact search, since {error}"
    if exact is not None:
        widest = max((part.high - part.low for part in exact.unresolved), default=0.0)
        if widest <= POINT * (high - low):
            return exact  # single points stay open in pieces too
    line.__dict__["formulas"] = None
    values = Axis(line.axis, low, high, points, log).values
    other, said, near = _past_branch_points(line, values)
    result = searches[1](other, values, log=log, singular=near)
    reason = said + reason
    if not result.complete:
        if exact is None:
            with suppress(NotExact, UnclearError):
                exact = searches[0](line, low, high, MOST_DIGITS)
        if exact is not None:
            return exact
    return replace(result, how=result.how + reason)


def _past_branch_points(line: AxisScan, values: Floats) -> tuple[AxisScan, str, dict[float, str]]:
    """The line in symmetric coordinates where another branch crosses a symmetric one.

    Returns
    -------
    line, how, singular
        The line, how it was changed, and what crosses it at values that it stays singular at.
    """
    singular: dict[float, str] = {}
    problem = line.problem
    family = problem.family
    if not problem.plain or not family.unknown or family.closed or family.anchor is None:
        return line, "", singular
    *numbers, _, _ = problem.arrays({**line.fixed, line.axis: values})
    parameters = np.hstack(numbers)
    members = family.search(*numbers)
    rows = np.flatnonzero(members.good)
    if len(rows) < 2:
        return line, "", singular
    cut, turn = len(family.at), (parameters[-1] - parameters[0]) / (values[-1] - values[0])
    curve = Curve(family.graph, cut, parameters[0] - values[0] * turn, turn)
    z = np.column_stack([members.u[rows], values[rows]])
    for point, _ in crossings(curve, z):
        both = directions(curve, point) if point.resolved else None
        if both is None:
            continue
        kind = kind_of_crossing(both)
        other = both[int(np.argmin(np.abs(both[:, -1])))]
        if family.trimmed:
            continue
        places = [family.system.index(n) for n in family.unknown]
        here = curve.given(point.z[None])
        state = family.states(here[:, :cut], point.z[None, :-1], here[:, cut:])[0]
        way = np.zeros(len(state))
        way[places] = other[:-1]
        reduced = symmetric_family(family, state, way)
        if reduced is not None:
            moved = replace(problem, family=reduced, exact=None)
            again, _, left = _past_branch_points(AxisScan(moved, line.axis, line.fixed), values)
            return again, SYMMETRIC, left
        value = float(point.z[-1])
        value = value if abs(value) > ZERO * (values[-1] - values[0]) else 0.0
        singular[value] = CROSSED.format(axis=line.axis, value=value, kind=KINDS[kind])
    return line, "", singular
