"""Numbers of equilibria in the cells of a map, on all sheets of a family."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..base.axis import Axis
from ..base.errors import ParameterError, listed
from ..spectra.problem import Problem
from ..systems.equations import Equations
from ..systems.equilibria import box_ends, counts
from ..systems.family import Family
from ..systems.system_checks import mapping


def sheet_box(family: Family, box: Any) -> dict[str, tuple[float, float]]:
    """The box of a map; refused where it does not name exactly the unknowns of the family."""
    ends = mapping("box", box)
    if not family.unknown or not isinstance(family.system, Equations):
        raise ParameterError(
            f"{family.name} has no states that are solved for, so a box counts nothing; leave it "
            "out."
        )
    if set(ends) != set(family.unknown):
        wrong = listed(list(ends)) if ends else "no state"
        raise ParameterError(
            f"box names {wrong}; give (low, high) for each state that "
            f"{family.name} is solved for: {listed(list(family.unknown))}."
        )
    return {name: box_ends(name, ends[name]) for name in family.unknown}


def sheet_counts(
    problem: Problem, axes: tuple[Axis, Axis], box: Mapping[str, tuple[float, float]]
) -> dict[str, Any]:
    """Variables with the numbers of equilibria in each cell, as for `xarray.Dataset`."""
    family, (across, up) = problem.family, axes
    x, y = np.meshgrid(across.values, up.values)
    a, q, _, _ = problem.arrays(dict(problem.values) | {across.name: x, up.name: y})
    names = (*family.at, *family.parameters)
    numbers = dict(zip(names, np.hstack([a, q]).T, strict=True))
    states = family.states(a, np.tile([low for low, _ in box.values()], (x.size, 1)), q)
    numbers |= {n: states[:, family.system.index(n)] for n in family.held}
    where = ", ".join(f"{n} from {low:g} to {high:g}" for n, (low, high) in box.items())
    words = {
        "equilibria": "equilibria in the box, on all sheets",
        "stable_equilibria": "stable equilibria in the box, on all sheets",
    }
    variables = {}
    for (name, meaning), count in zip(
        words.items(), counts(family.system, box, numbers), strict=True
    ):
        comment = (
            f"proved numbers in {where}; -1 where the number is not proved, in "
            f"{int((count < 0).sum())} of {count.size} cells"
        )
        attributes = {"long_name": meaning, "units": "1", "comment": comment}
        variables[name] = ((up.name, across.name), count.reshape(x.shape), attributes)
    return variables
