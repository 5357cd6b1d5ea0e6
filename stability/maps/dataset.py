"""A map as a labelled dataset: units, flag meanings, points of codimension two, provenance."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.citation import cited, joined
from ..base.types import Floats
from ..base.verdict import NO_MEMBER, Evidence
from ..boundary.two_parameters.point_records import (
    CodimensionTwo,
    DegeneratePoint,
    PointKind,
    UnresolvedBox,
)
from ..spectra.labels import (
    axis_attributes,
    of_package,
    origin,
    rate_attributes,
    verdict_attributes,
)
from ..spectra.problem import Problem
from ..storage.datasets import labelled
from ..systems.sources.numeric import NumericSystem
from ..systems.structure.structural_zeros import Structure, structure

if TYPE_CHECKING:
    import xarray

    from ..base.axis import Axis
    from ..boundary.curves import Curves
    from .boxes import ProvedBoxes


BY_FLOATS = Evidence.BY_FLOATS
KINDS = {kind: code for code, kind in enumerate(PointKind)}
"""Flag value of each kind in files."""
OTHERS = {"open": 0, "stable": 1, "unstable": -1}
"""Flag value of the other eigenvalues in files."""
PAIRS = 2
"""Most pairs of a point."""


def flag_attributes(codes: Mapping[str, int], **words: str) -> dict[str, Any]:
    """Attributes of a variable that holds flags: values, meanings, and further words."""
    values = np.array(list(codes.values()), dtype=np.int8)
    return {"flag_values": values, "flag_meanings": " ".join(codes), **words}


def point_variables(
    points: CodimensionTwo, axes: Mapping[str, Mapping[str, str]], rate: Mapping[str, str]
) -> dict[str, Any]:
    """Variables along the dimension `point`.

    Returns
    -------
    dict
        Variables by name, as for `xarray.Dataset`.
    """
    d = ("point",)
    pairs = np.full((len(points), PAIRS), np.nan)
    for row, point in zip(pairs, points, strict=True):
        row[: len(point.frequencies)] = point.frequencies
    kinds = flag_attributes(
        {k.name.lower(): code for k, code in KINDS.items()},
        comment="; ".join(str(k.value) for k in KINDS),
        long_name="kind of point of codimension two; each is proved to exist",
    )
    others = flag_attributes(OTHERS, long_name="eigenvalues other than those that meet")
    out: dict[str, Any] = {
        "point_kind": (d, np.array([KINDS[p.kind] for p in points], dtype=np.int8), kinds),
        "point_others": (d, np.array([OTHERS[p.others] for p in points], dtype=np.int8), others),
        "point_frequency": (
            ("point", "point_pair"),
            pairs,
            dict(rate) | {"long_name": "|Im| of the pairs that meet, in increasing order"},
        ),
    }
    for (name, words), value, bound in zip(
        axes.items(), ("x", "y"), ("x_error", "y_error"), strict=True
    ):
        out[f"point_{name}"] = (d, np.array([getattr(p, value) for p in points]), dict(words))
        out[f"point_{name}_error"] = (
            d,
            np.array([getattr(p, bound) for p in points]),
            dict(words) | {"long_name": f"proved bound on the error of point_{name}"},
        )
    return out


def point_attributes(points: CodimensionTwo) -> dict[str, Any]:
    """How points were sought, and what stays open, as attributes of a dataset."""
    return {
        "points_axes": json.dumps(points.axes),
        "points_how": points.how,
        "points_vanishing": points.vanishing,
        "points_complete": int(points.complete),
        "points_vanishing_complete": int(points.vanishing_complete),
        "points_unresolved": json.dumps(
            [[b.kind.name.lower(), b.x, b.y, b.reason] for b in points.unresolved]
        ),
    }


def points_of(dataset: xarray.Dataset) -> CodimensionTwo | None:
    """The points that a map holds; None where none were sought.

    Parameters
    ----------
    dataset
        From `stability_map(..., points=True)`, or read from its file.

    Examples
    --------
    >>> import stability as st
    >>> m = st.stability_map("spinning", x=("at", 1, 4, 5), y=("mu", 0.1, 2, 5), points=True)
    >>> [(p.kind.word, p.x, p.y) for p in points_of(m)]
    [('zero hopf', 2.0, 1.0)]
    """
    if "point_kind" not in dataset:
        return None
    x, y = ((str(n), float(a), float(b)) for n, a, b in json.loads(dataset.points_axes))
    kinds = {code: kind for kind, code in KINDS.items()}
    others = {code: word for word, code in OTHERS.items()}
    columns = (f"point_{x[0]}", f"point_{x[0]}_error", f"point_{y[0]}", f"point_{y[0]}_error")
    numbers = [dataset[name].values.tolist() for name in columns]
    points = tuple(
        DegeneratePoint(
            kinds[int(dataset.point_kind[i])],
            a,
            a_error,
            b,
            b_error,
            tuple(float(w) for w in dataset.point_frequency[i].values if w == w),
            others[int(dataset.point_others[i])],
        )
        for i, (a, a_error, b, b_error) in enumerate(zip(*numbers, strict=True))
    )
    boxes = tuple(
        UnresolvedBox(PointKind[kind.upper()], (a[0], a[1]), (b[0], b[1]), reason)
        for kind, a, b, reason in json.loads(dataset.points_unresolved)
    )
    return CodimensionTwo(
        points,
        (x, y),
        boxes,
        str(dataset.points_how),
        str(dataset.points_vanishing),
        bool(dataset.points_vanishing_complete),
    )


GRAPH = (
    "eigenvalues of the AD Jacobian with structural zeros removed through null vectors "
    "(LAPACK), or roots of its polynomial where their discs are small; error discs by running "
    "error analysis and Gershgorin's theorem"
)

POLYNOMIAL = "; verdicts that these leave open from the family's polynomial, exactly or in balls"
"""Added to `GRAPH` where a user's family has an exact polynomial."""

SINGLE = "; verdicts that these leave open over Q or in balls, cell by cell"
"""Added to `GRAPH` where cells of a user's family were decided in this way."""

NONE = "no_member: no steady motion of the family that continuation or the root-finder reaches"
"""What the flag of a cell without a member means."""


def provenance(problem: Problem, axes: tuple[Axis, Axis], route: str) -> dict[str, Any]:
    """Origin of a result: versions, parameters, method, tolerances.

    Parameters
    ----------
    problem
        Family with values in the user's units.
    axes
        Axes of a map, whose names are not fixed parameters.
    route
        Method of computation of the numbers, in words.

    Returns
    -------
    dict
        Strings and numbers that fit in a file's attributes.
    """
    family = problem.family
    swept = {g.name for g in axes}
    fixed = {n: v for n, v in problem.values.items() if n not in swept}
    numeric = isinstance(family.system, NumericSystem)
    how = Structure(0, False, "a Python function has none", True) if numeric else structure(family)
    if family.conservative:
        route += "; conservative law, decided by the sign of λ²"
    law = problem.law.name if problem.law else None
    return origin(
        problem,
        fixed,
        citation=cited(
            law,
            model=of_package(problem),
            eigenvalues=route.startswith((GRAPH, "eigenvalues of numerical")),
            proofs=not numeric,
        ),
        axes=" ".join(g.text for g in axes),
        structural_zeros=how.zeros,
        structural_zeros_how=how.how,
        method=route,
        tolerances="verdicts only where the error discs decide; each boundary point is a "
        "bracket of half-width boundary_error "
        + (BY_FLOATS.value if numeric else "proved in ball arithmetic (Routh's array)"),
        **({"evidence": BY_FLOATS.value} if numeric else {}),
    )


def assemble(
    problem: Problem,
    axes: tuple[Axis, Axis],
    cells: Any,
    curves: Curves | None,
    boxes: ProvedBoxes | None = None,
    points: CodimensionTwo | None = None,
    counts: Mapping[str, Any] | None = None,
) -> xarray.Dataset:
    """The dataset of a map."""
    dims = axes[1].name, axes[0].name
    words = rate_attributes(problem)
    flags = verdict_attributes()
    missing = int((cells.codes == NO_MEMBER).sum())
    arrays = {
        "verdict": cells.codes,
        "abscissa": cells.abscissa,
        "abscissa_error": cells.error,
        "frequency": cells.frequency,
    }
    variables: dict[str, Any] = {
        name: (dims, arrays[name], attributes)
        for name, attributes in cell_attributes(problem, missing=bool(missing)).items()
    }
    if cells.values is not None:
        variables["eigenvalues"] = (
            (*dims, "mode"),
            cells.values,
            words | {"long_name": "eigenvalues, structural zeros removed, sorted by real part"},
        )
    variables |= counts or {}
    if curves is not None:
        variables |= _boundary_variables(problem, axes, curves, words)
    if boxes is not None:
        variables |= _box_variables(problem, axes, boxes, flags)
    if points is not None:
        named = {g.name: axis_attributes(problem, g.name) for g in axes}
        variables |= point_variables(points, named, words)
    attributes = provenance(problem, axes, cells.route)
    if missing:
        attributes["no_member"] = f"{missing} of {cells.codes.size} cells have no member"
    if curves is not None:
        attributes["boundary_unresolved"] = curves.unresolved
    if points is not None:
        attributes |= point_attributes(points)
        attributes["citation"] = joined([attributes["citation"], points.citation])
    if boxes is not None:
        attributes |= {
            "box_levels": boxes.levels,
            "box_proved": boxes.proved,
            "box_comment": f"share {boxes.proved:.6f} of the map's area is proved; the strip that "
            f"encloses every change of verdict is made of boxes 2^-{boxes.levels} of each axis "
            "wide; a logarithmic axis is measured in its logarithm",
        }
    return labelled(variables, coordinates(problem, axes), attributes)


def coordinates(problem: Problem, axes: tuple[Axis, Axis]) -> dict[str, tuple[str, Floats, Any]]:
    """Axis, values and attributes of each coordinate, by its name or its second name."""
    return {
        name: (grid.name, grid.values, axis_attributes(problem, grid.name))
        for grid in axes
        for name in filter(None, (grid.name, grid.alias))
    }


def cell_attributes(problem: Problem, *, missing: bool) -> dict[str, dict[str, Any]]:
    """Attributes of the variables that have a number in each cell, by name."""
    words, flags = rate_attributes(problem), verdict_attributes()
    error = "error bound of abscissa"
    if isinstance(problem.family.system, NumericSystem):
        flags["long_name"] += f", {BY_FLOATS.word}"
        error = "estimated error of abscissa, by floats"
    return {
        "abscissa": words | {"long_name": "largest growth rate"},
        "abscissa_error": words | {"long_name": error},
        "frequency": words
        | {"long_name": "frequency of the eigenvalue with the largest real part"},
        "verdict": _with_no_member(flags) if missing else flags,
    }


def _with_no_member(flags: Mapping[str, Any]) -> dict[str, Any]:
    """The flags of verdicts, and that of a cell without a member."""
    return dict(flags) | {
        "flag_values": np.append(flags["flag_values"], np.int8(NO_MEMBER)),
        "flag_meanings": f"{flags['flag_meanings']} no_member",
        "comment": f"{flags['comment']}; {NONE}; numbers are missing there (_FillValue in a file)",
    }


def _box_variables(
    problem: Problem, axes: tuple[Axis, Axis], boxes: ProvedBoxes, flags: Mapping[str, Any]
) -> dict[str, Any]:
    long = {"long_name": "verdict proved everywhere in the box, 0 in the enclosing strip"}
    out: dict[str, Any] = {"box_verdict": (("box",), boxes.codes, dict(flags) | long)}
    for axis, ends in zip(axes, (boxes.x, boxes.y), strict=True):
        words = axis_attributes(problem, axis.name)
        words["long_name"] += ", low and high end of the box"
        out[f"box_{axis.name}"] = (("box", "end"), ends, words)
    return out


def _boundary_variables(
    problem: Problem, axes: tuple[Axis, Axis], curves: Curves, words: Mapping[str, str]
) -> dict[str, Any]:
    from ..boundary.curves import KINDS

    d = ("boundary_point",)
    bracket = "half-width of the proved bracket"
    if isinstance(problem.family.system, NumericSystem):
        bracket = f"half-width of the bracket, {BY_FLOATS.word}"
    kinds = flag_attributes(
        {k.word: code for k, code in KINDS.items()},
        comment="; ".join(str(k.value) for k in KINDS),
    )
    along_axis = flag_attributes(
        {g.name.replace(" ", "_"): i for i, g in enumerate(axes)},
        long_name="axis along which the point was refined",
    )
    return {
        f"boundary_{axes[0].name}": (d, curves.x, axis_attributes(problem, axes[0].name)),
        f"boundary_{axes[1].name}": (d, curves.y, axis_attributes(problem, axes[1].name)),
        "boundary_axis": (d, curves.axis, along_axis),
        "boundary_error": (
            d,
            curves.error,
            {
                "long_name": f"{bracket}, in the unit of boundary_axis; "
                "where curves cross, distance at which verdicts alternate"
            },
        ),
        "boundary_kind": (d, curves.kind, kinds),
        "boundary_frequency": (
            d,
            curves.frequency,
            dict(words) | {"long_name": "frequency of the crossing pair"},
        ),
        "boundary_curve": (d, curves.curve, {"long_name": "polyline that the point belongs to"}),
    }
