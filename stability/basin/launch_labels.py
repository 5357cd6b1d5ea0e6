"""Labels of launches by outcome and family: what borders, exponents and shocks ask."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from contextlib import closing
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.errors import ParameterError, shown
from ..base.types import Floats
from ..integrators.flow import CASADI
from ..integrators.taylor import CORES
from ..jobs.pipeline import check_run, ordered, threads
from ..jobs.shared import shared
from ..motion.result import BY_CODE
from .borders import Borders, borders
from .lattice.labels import Ints
from .launches import Launches, prepare
from .outcomes import Judging, judged_by, last_time, outcomes

if TYPE_CHECKING:
    import xarray

FAMILIES = 64
"""Most families of one question: a label is the outcome's code times this, plus the family's."""
PIECE = 2048
"""Launches of a piece of work, about."""


@dataclass(frozen=True, eq=False)
class LaunchLabels:
    """A function of launches, shape (n, d), that gives their labels, shape (n,).

    Two launches have the same label if they have the same outcome and settle on the same family.

    Examples
    --------
    >>> import stability as st
    >>> ends = st.launch_labels(contact="viscous", mu=0.3, family="spinning",
    ...                         varied=("phi_dot", "tilt"), horizon=300.0)
    >>> [ends.words(label) for label in ends(np.array([[2.5, 0.1], [3.9, 0.6]]))]
    ['settled on spinning', 'lift-off']
    """

    launches: Launches
    """What is launched; columns of a call are the numbers that vary."""
    horizon: float
    """Last time."""
    judging: Judging
    """Settings of the runs."""
    executor: Executor | None = None
    """Executor of the runs; None for threads of this process."""
    workers: int | None = None
    """Number of workers; one for each core when left out."""

    def __call__(self, points: Floats) -> Ints:
        """The labels of launches."""
        table = np.asarray(points, dtype=float)
        if table.ndim != 2 or table.shape[1] != len(self.launches.varied):
            raise ParameterError(
                f"launches are {shown(points)}; give shape (n, {len(self.launches.varied)}): "
                f"{', '.join(self.launches.varied)}."
            )
        workers = self.workers or CORES
        size = min(PIECE, max(256, -(-len(table) // workers)))
        mine = shared(replace(self, executor=None), self.executor)
        pieces = [table[n : n + size] for n in range(0, len(table), size)]
        found = [np.zeros(0, dtype=np.int64)]
        with closing(ordered(
            range(len(pieces)), lambda i: partial(_labels, mine, pieces[i]),
            executor=self.executor, workers=workers, own=threads,
        )) as results:  # fmt: skip
            found += [labels for _, labels in results]
        return np.concatenate(found)

    def words(self, label: int) -> str:
        """A label in words."""
        outcome, family = divmod(int(label), FAMILIES)
        word = BY_CODE[outcome].word
        return f"{word} on {self.names[family - 1]}" if family else word

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the families that launches may settle on."""
        point = {n: np.array([1.0]) for n in self.launches.varied}
        with CASADI:
            return self.launches.starts(point, self.horizon).settling.names


def _labels(labels: Any, points: Floats) -> Ints:
    """Labels of some launches, by a worker."""
    mine: LaunchLabels = labels()
    table = dict(zip(mine.launches.varied, points.T, strict=True))
    with CASADI:
        launches = mine.launches.starts(table, mine.horizon)
    found = outcomes(launches, mine.judging)
    return coded(found.outcome, found.family + 1)


def coded(outcome: Any, family: Any) -> Ints:
    """Labels from flag values of outcome and family.

    Parameters
    ----------
    outcome, family
        Flag values, as in a dataset of `basins`.

    Returns
    -------
    ndarray
        Shape of the flag values.
    """
    return np.asarray(outcome, dtype=np.int64) * FAMILIES + np.asarray(family, dtype=np.int64)


def launch_labels(
    disk: Any = None, contact: Any = None, *, varied: Sequence[str], horizon: float,
    held: Mapping[str, float] | None = None, family: str = "", families: Any = (),
    body: Any = None, tolerance: float = 1e-9, check: bool = True,
    executor: Executor | None = None, workers: int | None = None, **parameters: Any,
) -> LaunchLabels:  # fmt: skip
    """Labels of launches by outcome and family, for `uncertainty_exponent` and `fatal_shock`.

    Parameters
    ----------
    disk, contact, horizon, held, family, families, body, tolerance, check
        As for `basins`.
    varied
        Names of the numbers that vary, in the order of the columns.
    executor, workers
        Where the launches run.
    **parameters
        As for `basins`.

    Returns
    -------
    LaunchLabels

    Raises
    ------
    StabilityError
        In one sentence, if something is not accepted.

    Source: tests/basin/test_launch_labels.py.

    Examples
    --------
    >>> import stability as st
    >>> ends = st.launch_labels(contact="viscous", mu=0.3, family="spinning", varied=("phi_dot",),
    ...                         held={"tilt": 0.5}, horizon=5.0)
    >>> shock = st.fatal_shock(ends, [3.0], reach=2.0, budget=64)
    >>> ends.words(shock.label), round(shock.size, 2)
    ('lift-off', 0.7)
    """
    if isinstance(varied, str):
        raise ParameterError(f"varied is {shown(varied)}; give a list of names.")
    thing = body if disk is None else disk
    asked = prepare(thing, contact, tuple(varied), held, family, families, parameters)
    check_run(workers, None, executor)
    judging = judged_by(tolerance, check)
    return LaunchLabels(asked, last_time(horizon), judging, executor, workers)


def refined(
    dataset: xarray.Dataset, labels: LaunchLabels, axes: tuple[Any, Any], levels: int
) -> xarray.Dataset:
    """A map with the borders between its outcomes, refined where neighbours differ.

    Parameters
    ----------
    dataset
        The map.
    labels
        Labels of launches over x and y.
    axes
        x and y.
    levels
        Halvings of the steps of the map.

    Returns
    -------
    xarray.Dataset
        Along `border_point`: `border_X` for each axis X, the end points of each line in turn
        (`border_curve`), and the flag values of the outcomes on both sides.
    """
    known = coded(dataset.outcome.values, dataset.family.values)
    found = borders(labels, *((a.name, a.low, a.high, a.count, *(["log"] * a.log)) for a in axes),
                    levels=levels, known=known)  # fmt: skip
    return dataset.assign(_variables(found, axes)).assign_attrs(
        border_width=[float(w) for w in found.widths[-1]], border_launches=found.asked,
        border_note=found.note, border_cells=[int(n) for n in found.counts],
    )  # fmt: skip


def _variables(found: Borders, axes: tuple[Any, Any]) -> dict[str, Any]:
    lines = found.lines
    points = np.concatenate([_closed(line) for line in lines]) if lines else np.zeros((0, 2))
    lengths = [len(_closed(line)) for line in lines]
    sides = np.repeat(np.array([line.labels for line in lines]).reshape(-1, 2), lengths, axis=0)
    made: dict[str, Any] = {
        f"border_{a.name}": ("border_point", points[:, i], {
            "long_name": f"{a.name} of the border, off the true one by less than border_width"})
        for i, a in enumerate(axes)
    }  # fmt: skip
    made["border_curve"] = ("border_point", np.repeat(np.arange(len(lines)), lengths),
                            {"long_name": "number of the line"})  # fmt: skip
    for side, column in (("low", 0), ("high", 1)):
        for name, part in (("outcome", sides[:, column] // FAMILIES),
                           ("family", sides[:, column] % FAMILIES)):  # fmt: skip
            made[f"border_{name}_{side}"] = (
                "border_point", part.astype(np.int8),
                {"long_name": f"{name} on the {side} side, a flag value of {name}"},
            )  # fmt: skip
    return made


def _closed(line: Any) -> Floats:
    points: Floats = np.vstack([line.points, line.points[:1]]) if line.closed else line.points
    return points
