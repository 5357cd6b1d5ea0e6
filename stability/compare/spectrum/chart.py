"""Routes to a spectrum on every hardness class: time for each point against error, as a dataset."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ...base.errors import StabilityError
from ...base.types import Floats
from ...base.verdict import CODES, Verdict
from ...jobs.measured_cells import Cell, Task
from ..chart import Line, attributes, csv_of, methods, numbers, padded, variable, words
from ..cost import Place, least, places, timed, timings
from .points import EDGES, Points, classes, edge, points_of
from .routes import ROUTES, Route, SpectrumAnswer, check, route

if TYPE_CHECKING:
    import xarray

    from ...boundary.brackets import Boundaries

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
CHARTED = tuple(r.name for r in ROUTES.values() if r.charted)
"""Names of the routes in the charts."""


def tasks() -> list[list[Task]]:
    """Tasks of the chart, grouped by route: a process for each, so that none disturbs another."""
    return [
        [
            *(Task(f"spectrum/{c}/{name}", measure, (c, name)) for c in classes()),
            Task(f"boundary/{name}", locate, (name,)),
        ]
        for name in CHARTED
    ]


def errors(points: Points, answer: SpectrumAnswer) -> tuple[Floats | None, Floats | None]:
    """Errors of eigenvalues and abscissa at each point.

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
    cell: dict[str, Any] = {"eigenvalues": [], "abscissa": [], "wrong": 0, "undecided": 0}
    for points in groups:
        start = time.perf_counter()
        answer = mine.answer(points)
        first = time.perf_counter() - start if first is None else first
        check(points, answer)
        eigenvalues, abscissa = errors(points, answer)
        for key, values in (("eigenvalues", eigenvalues), ("abscissa", abscissa)):
            cell[key] = None if values is None else [*cell[key], *values.tolist()]
        open_ = answer.codes == CODES[Verdict.UNDECIDED]
        cell["undecided"] += int(open_.sum())
        cell["wrong"] += int(((answer.codes != points.truth.codes) & ~open_).sum())
    cell |= {"count": sum(len(p) for p in groups), "first": first}
    return cell | _times(mine, groups)


def _share(points: Points, hardness: str) -> int:
    """Number of a group's points for a slow route: about `FEW` in the whole class."""
    total = sum(len(p) for p in points_of(hardness))
    return max(1, round(FEW * len(points) / total))


def _times(mine: Route, groups: Sequence[Points]) -> dict[str, list[float]]:
    """Seconds per point of each repeat: at one point, and at many for a route with arrays."""
    alone: list[float] = []
    for points in groups[:2]:
        single = points[:1]
        least, budget = (5, 0.06) if mine.arrays else (2, 0.06)
        alone += timed(lambda p=single: mine.answer(p), least=least, most=40, budget=budget)  # type: ignore[misc]
    if not mine.arrays:
        return {"one": alone, "many": []}
    many: list[float] = []
    for points in groups[:2]:
        tiled = points[np.arange(MANY) % len(points)]
        repeats = timed(lambda p=tiled: mine.answer(p), least=3, most=20, budget=0.1)  # type: ignore[misc]
        many += [seconds / MANY for seconds in repeats]
    return {"one": alone, "many": many}


# --- boundaries ---


def locate(name: str) -> dict[str, Any]:
    """One cell: each boundary, searched by bisection on a route's verdict from 1 % off.

    For the package's routes, its function `boundaries` replaces the bisection.

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
        value, width = _searched(mine, where, exact[0])
        out["seconds"].append(time.perf_counter() - start)
        error = None if value is None else abs((value - exact[0]) - exact[1]) / exact[0]
        out["error"].append(error)
        out["width"].append(width)
    return out


def exact_edge(
    family: str, law: str, k: float, mu: float | None, low: float, high: float
) -> tuple[float, float]:
    """A boundary to 22 digits, by bisection on the sign of Hurwitz's determinants in balls.

    Returns
    -------
    value, rest
        The boundary rounded to double, and the exact boundary less that, as a double.
    """
    from fractions import Fraction

    from flint import arb, fmpq

    from ...algebra.exact.routh import hurwitz_sign, verdict_polynomial
    from ...algebra.number_types import precision
    from ...bodies.subject import disk_family
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


def _searched(mine: Route, where: Any, near: float) -> tuple[float | None, float | None]:
    low, high = near * (1 - BRACKET), near * (1 + BRACKET)
    return _proved(where, low, high) if mine.own else (bisected(mine, where, low, high), None)


def bisected(mine: Route, where: Any, low: float, high: float) -> float | None:
    """Bisection on whether a route says unstable; None where the ends are not distinguished."""
    family, law, k, mu = where[:4]

    def unstable(at: float) -> bool:
        friction = None if mu is None else np.array([mu])
        code = mine.answer(Points(family, law, np.array([k]), friction, np.array([at]))).codes[0]
        return bool(code == CODES[Verdict.UNSTABLE])

    first = unstable(low)
    if unstable(high) == first:
        return None
    while low < (middle := (low + high) / 2) < high:
        if unstable(middle) == first:
            low = middle
        else:
            high = middle
    return (low + high) / 2


def proved(where: Any, low: float, high: float, values: int) -> Boundaries:
    """Boundaries by the package's `boundaries`."""
    from ...bodies.contact_laws import law_named
    from ...bodies.disk import Disk
    from ...boundary.changes import boundaries

    family, law, k, mu = where[:4]
    return boundaries(
        family,
        axis=("at", low, high, values),
        disk=Disk(k=k),
        contact=law_named(law, mu),
    )


def _proved(where: Any, low: float, high: float) -> tuple[float | None, float | None]:
    """A boundary by the package, and its proved relative half-width."""
    try:
        changes = proved(where, low, high, 4)
    except StabilityError:
        return None, None
    if len(changes) != 1:
        return None, None
    return changes[0].value, changes[0].error / changes[0].value


# --- the chart as data ---


FORMAT = "stability chart spectrum 1"
"""Attribute `format` of a file of this chart."""


def dataset(cells: Mapping[str, Cell]) -> xarray.Dataset:
    """Numbers of the spectrum chart, with every raw timing.

    Returns
    -------
    xarray.Dataset
        Over (route, hardness, point | call) and, if asked, (route, boundary).  NaN marks
        missing numbers: a route without that answer, fewer points or calls than another's, or a
        cell whose `status` is not done.
    """
    import xarray

    names = [n for n in CHARTED if any(key.endswith(f"/{n}") for key in cells)]
    kinds = [c for c in classes() if any(key.startswith(f"spectrum/{c}/") for key in cells)]
    grid = [cells[f"spectrum/{c}/{n}"] for n in names for c in kinds]
    edges = [cell for n in names if (cell := cells.get(f"boundary/{n}")) is not None]
    shape = (len(names), len(kinds))

    def rows(key: str) -> list[Any]:
        return [c.value and c.value[key] for c in grid]

    two = ("route", "hardness")
    data: dict[str, Any] = {}
    for key, last, text, unit in (
        (
            "eigenvalues",
            "point_eigenvalues",
            "error of the eigenvalues over the largest modulus, best matching",
            "1",
        ),
        (
            "abscissa",
            "point_abscissa",
            "error of the abscissa over the abscissa, over the largest modulus where 0",
            "1",
        ),
        ("one", "call_one", "time of a call with one point", "s"),
        ("many", "call_many", "time a point of a call with many points", "s"),
    ):
        data[key] = variable((*two, last), padded(rows(key), shape), text, unit)
    for key, text, unit in (
        ("wrong", "wrong verdicts", "1"),
        ("undecided", "verdicts said to be undecided", "1"),
        ("count", "points asked", "1"),
        ("first", "time of the first call", "s"),
    ):
        data[key] = variable(two, numbers(rows(key), shape), text, unit)
    data["status"] = (two, words([c.status for c in grid], shape, 10))
    data["message"] = (two, words([c.message for c in grid], shape, 200))
    coordinates = methods("route", ROUTES, names) | {
        "hardness": kinds,
        "class_title": ("hardness", [classes()[c] for c in kinds]),
    }
    if edges:
        data |= _boundaries(edges)
        coordinates["boundary"] = [" ".join(str(part) for part in e[:4]) for e in EDGES]
    truth = "characteristic polynomial of the graph in balls of 1024 bits and more"
    title = "routes to a spectrum: time against error"
    return xarray.Dataset(data, coordinates, attributes(FORMAT, title, truth))


def _boundaries(edges: Sequence[Cell]) -> dict[str, Any]:
    """Variables over (route, boundary)."""
    two, shape = ("route", "boundary"), (len(edges),)
    data: dict[str, Any] = {}
    for key, text, unit in (
        ("error", "relative error of a boundary found", "1"),
        ("seconds", "time to find it", "s"),
        ("width", "stated half-width, relative", "1"),
    ):
        values = padded([c.value and c.value[key] for c in edges], shape, len(EDGES))
        data[f"boundary_{key}"] = variable(two, values, text, unit)
    asked = [
        [r is not None for r in c.value["seconds"]] if c.value else [True] * len(EDGES)
        for c in edges
    ]
    data["boundary_asked"] = (two, np.array(asked))
    return data


def seconds(chart: xarray.Dataset, route: str, hardness: str) -> tuple[float, float]:
    """Least times per point [s]: of calls with many points, if any, and with one point.

    Other work on the machine only adds to a time.

    Returns
    -------
    best, single
        Equal without calls with many points; NaN where the cell is not done.
    """
    here = chart.sel(route=route, hardness=hardness)
    single, many = (_least(here[key].values) for key in ("one", "many"))
    return (many if np.isfinite(many) else single), single


def _least(values: Any) -> float:
    finite = values[np.isfinite(values)]
    return float(finite.min()) if finite.size else float("nan")


def _median(values: Any) -> float:
    finite = values[np.isfinite(values)]
    return float(np.median(finite)) if finite.size else float("nan")


def _worst(values: Any) -> float:
    finite = values[np.isfinite(values)]
    return float(finite.max()) if finite.size else float("nan")


def standing(chart: xarray.Dataset, quantity: str, hardness: str = "") -> dict[str, Place]:
    """Standing of every route in a panel; routes with a wrong verdict have none."""
    panel: dict[str, tuple[float, float]] = {}
    for name in chart.route.values.tolist():
        if quantity == "boundary":
            here = chart.sel(route=name)
            asked = here.boundary_asked.values
            error = here.boundary_error.values[asked]
            if not error.size or not np.isfinite(error).all():
                continue
            panel[name] = (_median(here.boundary_seconds.values[asked]), float(error.max()))
            continue
        cell = chart.sel(route=name, hardness=hardness)
        if str(cell.status.values) != "done" or float(cell.wrong) > 0:
            continue
        time = seconds(chart, name, hardness)[0]
        if quantity == "verdict":
            panel[name] = (time, float(cell.undecided / cell["count"]))
        elif np.isfinite(error := _worst(cell[quantity].values)):
            panel[name] = (time, error)
    return places(panel)


# --- as text ---


def spectrum_csv(cells: Mapping[str, Cell]) -> str:
    """CSV of the spectra: one line for each route and hardness class."""
    return csv_of("spectrum", cells, _spectrum_lines)


def _spectrum_lines(names: Sequence[str], cell: Cell) -> list[Line]:
    hardness, route = names
    value = cell.value or {}
    return [
        {
            "hardness": hardness,
            "route": route,
            "status": cell.status,
            "points": value.get("count"),
            "wrong": value.get("wrong"),
            "undecided": value.get("undecided"),
            "worst_eigenvalue_error": max(value.get("eigenvalues") or [None]),
            "worst_abscissa_error": max(value.get("abscissa") or [None]),
            "first_call_s": value.get("first"),
            "one_point_s": least(value.get("one")),
            "a_point_of_many_s": least(value.get("many")),
            "one_point_timings_s": timings(value.get("one")),
            "many_timings_s": timings(value.get("many")),
            "message": "" if value else cell.message,
        }
    ]


def boundary_csv(cells: Mapping[str, Cell]) -> str:
    """CSV of the boundaries: one line for each route and each boundary that it is asked."""
    return csv_of("boundary", cells, _boundary_lines)


def _boundary_lines(names: Sequence[str], cell: Cell) -> list[Line]:
    none = [None] * len(EDGES)
    value = cell.value or {"error": none, "width": none, "seconds": none}
    columns = (EDGES, value["error"], value["width"], value["seconds"])
    return [
        {
            "route": names[0],
            "family": edge[0],
            "contact": edge[1],
            "k": edge[2],
            "mu": edge[3],
            "relative_error": error,
            "stated_half_width": width,
            "seconds": took,
            "status": cell.status if not cell.value else "not found" if error is None else "found",
        }
        for edge, error, width, took in zip(*columns, strict=True)
        if took is not None or not cell.value
    ]
