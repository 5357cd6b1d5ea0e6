"""Labels of launches by outcome and family: what borders, exponents and shocks ask."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from contextlib import closing
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from ..base.errors import ParameterError, shown
from ..base.types import Floats
from ..integrators.taylor import CORES
from ..jobs.pipeline import check_run, ordered, shared, threads
from ..motion.gather import moving
from ..motion.result import BY_CODE, Settings
from .dataset import works
from .labels import Ints
from .launches import Launches, prepare
from .outcomes import outcomes

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
    >>> ends = st.statistics.launch_labels(
    ...     contact="viscous", mu=0.3, family="spinning", varied=("phi_dot", "tilt"), horizon=300.0)
    >>> [ends.words(label) for label in ends(np.array([[2.5, 0.1], [3.9, 0.6]]))]
    ['settled on spinning', 'lift-off']
    """

    launches: Launches
    """What is launched; columns of a call are the numbers that vary."""
    executor: Executor | None = None
    """Executor of the runs; None for threads of this process."""
    workers: int | None = None
    """Number of workers; one for each core when left out."""

    @property
    def citation(self) -> str:
        """Keys of the works to cite, for `stability.citation`."""
        single = {name: np.ones(1) for name in self.launches.varied}
        return works(self.launches.starts(single), linear=False)

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
        parts = [np.zeros(0, dtype=np.int64)]
        with closing(
            ordered(
                range(len(pieces)),
                lambda i: partial(_labels, mine, pieces[i]),
                executor=self.executor,
                workers=workers,
                start_pool=threads,
            )
        ) as results:
            parts += [labels for _, labels in results]
        return np.concatenate(parts)

    def of(self, points: Floats) -> Ints:
        """The labels of some launches, computed at once and here."""
        table = dict(zip(self.launches.varied, points.T, strict=True))
        result = outcomes(self.launches.starts(table), self.launches.settings)
        return coded(result.outcome, result.family + 1)

    def words(self, label: int) -> str:
        """A label in words."""
        outcome, family = divmod(int(label), FAMILIES)
        word = BY_CODE[outcome].word
        return f"{word} on {self.names[family - 1]}" if family else word

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the families that launches may settle on."""
        point = {n: np.array([1.0]) for n in self.launches.varied}
        return self.launches.starts(point).settling.names


def _labels(labels: Any, points: Floats) -> Ints:
    """Labels of some launches, by a worker."""
    mine: LaunchLabels = labels()
    return mine.of(points)


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
    disk: Any = None,
    contact: Any = None,
    *,
    varied: Sequence[str],
    horizon: float,
    held: Mapping[str, float] | None = None,
    family: str = "",
    theta: float | None = None,
    pole: Any = None,
    families: Any = (),
    body: Any = None,
    tolerance: float = Settings.tolerance,
    check: bool = Settings.check,
    executor: Executor | None = None,
    workers: int | None = None,
    **parameters: Any,
) -> LaunchLabels:
    """Labels of launches by outcome and family, for `uncertainty_exponent` and `fatal_shock`.

    Parameters
    ----------
    disk, contact
        As for `basins`.
    varied
        Names of the numbers that vary, in the order of the columns.
    horizon, held, family, theta, pole, families, body, tolerance, check
        As for `basins`.
    executor, workers
        Where the launches run.
    **parameters
        As for `basins`.

    Returns
    -------
    LaunchLabels
        A function of launches, shape (n, d), that gives labels, shape (n,).

    Raises
    ------
    StabilityError
        In one sentence, if something is not accepted.

    Source: tests/basin/test_launch_labels.py.

    Examples
    --------
    >>> import stability as st
    >>> ends = st.statistics.launch_labels(
    ...     contact="viscous", mu=0.3, family="spinning", varied=("phi_dot",), held={"tilt": 0.5},
    ...     horizon=5.0)
    >>> shock = st.statistics.fatal_shock(ends, [3.0], reach=2.0, budget=64)
    >>> ends.words(shock.label), round(shock.size, 2)
    ('lift-off', 0.7)
    """
    if isinstance(varied, str):
        raise ParameterError(f"varied is {shown(varied)}; give a list of names.")
    check_run(workers, None, executor)
    launches = prepare(
        moving(disk, body),
        contact,
        tuple(varied),
        held,
        horizon,
        Settings(tolerance=tolerance, check=check),
        family=family,
        families=families,
        parameters=parameters,
        theta=theta,
        pole=pole,
    )
    return LaunchLabels(launches, executor, workers)
