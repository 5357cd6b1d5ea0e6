"""Points of codimension two in a map: values with bounds, kinds, and what stays open."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ..boundary.two_parameters.point_records import (
    CodimensionTwo,
    DegeneratePoint,
    PointKind,
    UnresolvedBox,
)

if TYPE_CHECKING:
    import xarray

KINDS = {kind: code for code, kind in enumerate(PointKind)}
"""Flag value of each kind in files."""
OTHERS = {"open": 0, "stable": 1, "unstable": -1}
"""Flag value of the other eigenvalues in files."""
PAIRS = 2
"""Most pairs of a point."""


def point_variables(
    found: CodimensionTwo, axes: Mapping[str, Mapping[str, str]], rate: Mapping[str, str]
) -> dict[str, Any]:
    """Variables along the dimension `point`.

    Parameters
    ----------
    found
        The points.
    axes
        Attributes of each axis by name.
    rate
        Attributes of rates.

    Returns
    -------
    dict
        Variables by name, as for `xarray.Dataset`.
    """
    d = ("point",)
    pairs = np.full((len(found), PAIRS), np.nan)
    for row, point in zip(pairs, found, strict=True):
        row[: len(point.frequencies)] = point.frequencies
    kinds = {
        "flag_values": np.array(list(KINDS.values()), dtype=np.int8),
        "flag_meanings": " ".join(k.name.lower() for k in KINDS),
        "comment": "; ".join(str(k.value) for k in KINDS),
        "long_name": "kind of point of codimension two; each is proved to exist",
    }
    others = {
        "flag_values": np.array(list(OTHERS.values()), dtype=np.int8),
        "flag_meanings": " ".join(OTHERS),
        "long_name": "eigenvalues other than those that meet",
    }
    out: dict[str, Any] = {
        "point_kind": (d, np.array([KINDS[p.kind] for p in found], dtype=np.int8), kinds),
        "point_others": (d, np.array([OTHERS[p.others] for p in found], dtype=np.int8), others),
        "point_frequency": (
            ("point", "point_pair"),
            pairs,
            dict(rate) | {"long_name": "|Im| of the pairs that meet, in increasing order"},
        ),
    }
    for (name, words), value, bound in zip(
        axes.items(), ("x", "y"), ("x_error", "y_error"), strict=True
    ):
        out[f"point_{name}"] = (d, np.array([getattr(p, value) for p in found]), dict(words))
        out[f"point_{name}_error"] = (
            d,
            np.array([getattr(p, bound) for p in found]),
            dict(words) | {"long_name": f"proved bound on the error of point_{name}"},
        )
    return out


def point_attributes(found: CodimensionTwo) -> dict[str, Any]:
    """How points were sought, and what stays open, as attributes of a dataset."""
    return {
        "points_axes": json.dumps(found.axes),
        "points_how": found.how,
        "points_vanishing": found.vanishing,
        "points_complete": int(found.complete),
        "points_vanishing_complete": int(found.vanishing_complete),
        "points_unresolved": json.dumps(
            [[b.kind.name.lower(), b.x, b.y, b.reason] for b in found.unresolved]
        ),
    }


def points_of(dataset: xarray.Dataset) -> CodimensionTwo | None:
    """The points that a map holds; None where none were sought.

    Parameters
    ----------
    dataset
        From `stability_map(..., points=True)`, or read from its file.

    Returns
    -------
    CodimensionTwo or None

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
