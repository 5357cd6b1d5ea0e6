"""Uncertainty exponent: how the share of uncertain launches falls with the error of a launch.

A share f(ε) of launches has another label after a displacement by ε.  Near ε = 0, f ~ ε^α.  The
border then has the box dimension D = d - α in d dimensions, and α = 1 for a smooth border.  With
α < 1 a better knowledge of the start makes the outcome little more certain: *final state
sensitivity* (Grebogi, McDonald, Ott & Yorke, Phys. Lett. A 99 (1983) 415; McDonald, Grebogi, Ott &
Yorke, Physica D 17 (1985) 125).

The share is a power law of maximum likelihood, of counts on the same base points.  Counts at
different displacements are dependent, since the same base points serve all.  The
likelihood as if they were independent gives a consistent estimate (a composite likelihood).  Its
curvature is not the precision.  The profile is therefore scaled by the spread between base points
(Chandler & Bate, Biometrika 94 (2007) 167).  The quantile is Fisher's, with the degrees of freedom
that the fourth moment of the influences leaves (Satterthwaite): few base points lie near a border.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from ...base.checks import checked, whole_number
from ...base.citation import joined
from ...base.errors import ParameterError, warned
from ...base.types import Floats
from ..labels import Ints, Label, asked
from .fractions import LEVEL, checked_level, wilson
from .samples import on_sphere, shares

WORKS = "stability, grebogi1983, wilson1927"
"""Keys of the works on the exponent."""
POINTS = 2000
"""Base points, unless the caller wants another number."""
DOUBTFUL = 1e-3
"""Probability of the misfit below which the power law is called into question.

With few events the statistic has heavy tails: up to 1 % of true power laws fall below."""
EXPECTED = 5.0
"""Least expected number of events of a cell of Pearson's statistic."""
STEEPEST = 20.0
"""Largest size of an exponent that is looked for."""


@dataclass(frozen=True, eq=False)
class UncertaintyExponent:
    """Power law of the share of uncertain launches over a range of displacements."""

    exponent: float
    """α of f(ε) ~ ε^α, by maximum likelihood."""
    interval: tuple[float, float]
    """Confidence interval of α."""
    level: float
    """Its level."""
    dimensions: int
    """Dimension d of the launches."""
    epsilons: Floats
    """Displacements, as shares of the range of each coordinate, shape (m,)."""
    counts: Ints
    """Base points whose label differs after each displacement, shape (m,)."""
    points: int
    """Base points, the same for all displacements."""
    fit: float
    """Probability of a misfit at least this large if the power law holds."""
    note: str
    """What the interval counts, and whether the power law is in question."""

    citation: str = WORKS
    """Keys of the works to cite, for `stability.citation`, those of the labels too."""

    @property
    def dimension(self) -> float:
        """Box dimension D = d - α of the border."""
        return self.dimensions - self.exponent

    @property
    def dimension_interval(self) -> tuple[float, float]:
        """Confidence interval of D."""
        return self.dimensions - self.interval[1], self.dimensions - self.interval[0]

    @property
    def shares(self) -> tuple[Floats, Floats, Floats]:
        """f(ε) with the low and high ends of its Wilson intervals, each of shape (m,)."""
        return self.counts / self.points, *wilson(self.counts, self.points, self.level)


def uncertainty_exponent(
    label: Label,
    low: ArrayLike,
    high: ArrayLike,
    epsilons: ArrayLike,
    *,
    points: int = POINTS,
    seed: int = 0,
    level: float = LEVEL,
    chunk: int | None = None,
) -> UncertaintyExponent:
    """Uncertainty exponent of the borders within a box.

    Each base point is displaced in one random direction by every ε.  A displacement that leaves
    the box is mirrored at its wall.

    Parameters
    ----------
    label
        Function of launches, shape (n, d), that returns their labels, n whole numbers.
    low, high
        Corners of the box, shape (d,).
    epsilons
        At least three displacements, as shares of the range of each coordinate, in (0, 1/2].
    points
        Base points.  The call takes points × (1 + number of displacements) labels.
    seed
        Seed of the base points and directions, by index.
    level
        Confidence level.
    chunk
        Most launches of one call of `label`; None for all in one call.

    Returns
    -------
    UncertaintyExponent
        The exponent with its interval, and the counts behind it.

    Raises
    ------
    ParameterError
        If an argument is not accepted, or labels differ at fewer than two displacements.

    Warns
    -----
    StabilityWarning
        If the shares do not fit a power law over this range.

    Source: C. Grebogi et al., Phys. Lett. A 99 (1983) 415; tests/basin/test_statistics.py.

    Examples
    --------
    >>> import numpy as np
    >>> import stability as st
    >>> def above(points):
    ...     return points[:, 1] > points[:, 0] ** 2
    >>> sizes = np.geomspace(1e-3, 0.1, 8)
    >>> exponent = st.statistics.uncertainty_exponent(above, [0, 0], [1, 1], sizes)
    >>> bool(exponent.interval[0] < 1 < exponent.interval[1]), exponent.dimensions
    (True, 2)
    """
    box = _box(low, high)
    steps = np.asarray(checked("epsilons", epsilons))
    if steps.ndim != 1 or len(steps) < 3 or (steps <= 0).any() or (steps > 0.5).any():
        raise ParameterError("epsilons: give at least three numbers in (0, 1/2].")
    points = whole_number("points", points, least=2)
    unlike = disagreements(label, box, steps, points=points, seed=seed, chunk=chunk)
    exponent = exponent_of(unlike, steps, len(box), level)
    return replace(exponent, citation=joined([str(getattr(label, "citation", WORKS)), WORKS]))


def disagreements(
    label: Label, box: Floats, epsilons: Floats, *, points: int, seed: int, chunk: int | None
) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Whether each base point has another label after each displacement, shape (points, m)."""
    d = len(box)
    numbers = shares(2 * d, 0, points, seed)
    base, towards = numbers[:, :d], on_sphere(numbers[:, d:])
    moved = base[:, None, :] + epsilons[None, :, None] * towards[:, None, :]
    moved = 1 - np.abs(1 - np.abs(moved))  # mirrored at 0 and 1
    launches = np.concatenate([base[:, None, :], moved], axis=1).reshape(-1, d)
    flat = asked(label, box[:, 0] + (box[:, 1] - box[:, 0]) * launches, chunk)
    labels = flat.reshape(points, -1)
    return np.asarray(labels[:, 1:] != labels[:, :1])


def exponent_of(
    unlike: ArrayLike, epsilons: ArrayLike, dimensions: int, level: float = LEVEL
) -> UncertaintyExponent:
    """The power law of a table of disagreements.

    Parameters
    ----------
    unlike
        Whether the label of base point i differs after displacement j, shape (n, m).
    epsilons
        The displacements, shape (m,).
    dimensions
        Dimension d of the launches.
    level
        Confidence level.

    Returns
    -------
    UncertaintyExponent

    Raises
    ------
    ParameterError
        If labels differ at fewer than two displacements, or everywhere.

    Warns
    -----
    StabilityWarning
        If the shares do not fit a power law over this range.

    Examples
    --------
    >>> distance = (np.arange(1000) + 0.5) / 1000  # of a base point from the border
    >>> steps = np.geomspace(0.01, 0.2, 6)
    >>> print(f"{exponent_of(distance[:, None] < steps, steps, 1).exponent:.2f}")
    1.00
    """
    table = np.asarray(unlike, dtype=bool)
    steps = np.asarray(epsilons, dtype=float)
    law = _fit_power_law(table, steps, checked_level(level))
    low, high = (min(max(end, 0.0), float(dimensions)) for end in law.interval)
    span = f"{steps.min():.2g} to {steps.max():.2g}"
    note = (
        f"Maximum likelihood of {len(table)} base points, each displaced by the same {len(steps)} "
        f"shares from {span}; the interval counts that these are dependent."
    )
    if law.fit < DOUBTFUL:
        doubt = f"the shares from {span} do not fit a power law (probability {law.fit:.1g})"
        note += f"  But {doubt}: take the exponent over a smaller range."
        warned(f"{doubt}; take a smaller range.")
    return UncertaintyExponent(
        law.exponent,
        (low, high),
        level,
        dimensions,
        steps,
        table.sum(axis=0),
        len(table),
        law.fit,
        note,
    )


def _box(low: ArrayLike, high: ArrayLike) -> Floats:
    """The ranges of a box, shape (d, 2)."""
    ends = [np.atleast_1d(np.asarray(checked(n, v))) for n, v in (("low", low), ("high", high))]
    if ends[0].shape != ends[1].shape or ends[0].ndim != 1 or not (ends[0] < ends[1]).all():
        raise ParameterError("low and high: give two corners of one length, low below high.")
    return np.stack(ends, axis=1)


@dataclass(frozen=True)
class PowerLaw:
    """Share = constant · ε^exponent."""

    exponent: float
    """Estimate of the exponent."""
    interval: tuple[float, float]
    """Its confidence interval."""
    fit: float
    """Probability of a misfit at least this large if the law holds."""


class _Likelihood:
    """Composite binomial likelihood of ln p = a + b x, with x = ln ε from a weighted mean."""

    def __init__(self, table: Floats, epsilons: Floats) -> None:
        self.table, self.points = table, len(table)
        self.counts = table.sum(axis=0)
        x = np.log(epsilons)
        self.x = x - self.counts @ x / self.counts.sum()

    def level(self, b: float) -> float:
        """The best constant for an exponent."""
        shape = np.exp(b * self.x)
        top = -math.log(float(shape.max())) - 1e-12  # no share is above 1
        a = min(top - 1e-3, math.log(float(self.counts.sum() / (self.points * shape.sum()))))
        missing = self.points - self.counts
        for _ in range(200):  # the score falls and is concave: each step ends to its right
            p = shape * math.exp(a)
            odds = p / (1 - p)
            score = float((self.counts - missing * odds).sum())
            step = score / float((missing * odds / (1 - p)).sum())
            a = min(a + step, (a + top) / 2)
            if abs(step) < 1e-13:
                break
        return a

    def profile(self, b: float) -> float:
        """Log likelihood of an exponent with its best constant."""
        q = self.level(b) + b * self.x
        return float((self.counts * q + (self.points - self.counts) * np.log(-np.expm1(q))).sum())


def _fit_power_law(
    table: Floats | np.ndarray[tuple[int, ...], np.dtype[np.bool_]], epsilons: Floats, level: float
) -> PowerLaw:
    """The power law of a table of events.

    Examples
    --------
    >>> distance = (np.arange(500) + 0.5) / 500
    >>> steps = np.geomspace(0.01, 0.2, 6)
    >>> law = _fit_power_law(distance[:, None] ** 2 < steps, steps, 0.95)
    >>> print(f"{law.exponent:.2f}")
    0.50
    """
    from scipy.optimize import minimize_scalar
    from scipy.stats import f as fisher

    counts = np.asarray(table).sum(axis=0)
    if (counts > 0).sum() < 2 or len(counts) < 3:
        raise ParameterError(
            f"labels differ at {(counts > 0).sum()} of {len(counts)} displacements; "
            "take at least three, larger ones, or more base points."
        )
    if (counts == len(table)).any():
        raise ParameterError("all base points differ at one displacement; take smaller ones.")
    law = _Likelihood(np.asarray(table, dtype=float), epsilons)
    minimum = minimize_scalar(
        lambda b: -law.profile(b),
        bounds=(-STEEPEST, STEEPEST),
        method="bounded",
        options={"xatol": 1e-9},
    )
    b = float(minimum.x)
    p = np.exp(law.level(b) + b * law.x)
    design = np.stack([np.ones_like(p), law.x], axis=1)
    inverse = np.linalg.inv(design.T @ ((p / (1 - p))[:, None] * design))
    influence = ((law.table - p) / (1 - p)) @ design @ inverse
    scale = float((influence[:, 1] ** 2).mean() / inverse[1, 1])
    freedom = 2 * float((influence[:, 1] ** 2).sum() ** 2 / (influence[:, 1] ** 4).sum())
    critical = float(fisher.ppf(level, 1, freedom)) * scale / 2
    best = law.profile(b)
    ends = (_end(lambda t: best - law.profile(t) - critical, b, side) for side in (-1, 1))
    return PowerLaw(b, (next(ends), next(ends)), _misfit(law, p, design, inverse))


def _end(excess: Callable[[float], float], middle: float, side: int) -> float:
    """Where the profile has fallen by the critical amount, on one side."""
    from scipy.optimize import brentq

    width = 1e-3
    while excess(middle + side * width) < 0:
        width *= 2
        if width > STEEPEST:
            return side * STEEPEST
    return float(brentq(excess, middle, middle + side * width))


def _misfit(law: _Likelihood, p: Floats, design: Floats, inverse: Floats) -> float:
    """Probability of Pearson's statistic, corrected for dependent counts.

    Rao & Scott, Ann. Statist. 12 (1984) 46: two moments of the weighted sum of chi squares.
    """
    from scipy.stats import chi2

    spread = np.cov(law.table.T, bias=True)
    slope = p[:, None] * design
    left = np.eye(len(p)) - slope @ inverse @ (slope / (p * (1 - p))[:, None]).T
    group = _groups(law.points * p)
    weight = 1 / np.sqrt(group @ (p * (1 - p)))
    matrix = weight[:, None] * (group @ left @ spread @ left.T @ group.T) * weight
    misfit = law.points * float(((weight * (group @ (law.counts / law.points - p))) ** 2).sum())
    first, second = float(np.trace(matrix)), float((matrix**2).sum())
    return float(chi2.sf(misfit * first / second, first**2 / second)) if second > 0 else 1.0


def _groups(expected: Floats) -> Floats:
    """Sums of neighbouring counts that reach an expected number each, as rows of 0 and 1."""
    number = np.zeros(len(expected), dtype=int)
    cell, total = 0, 0.0
    for j in np.argsort(expected):  # the last cell has the largest count, so it needs no more
        number[j] = cell
        total += expected[j]
        if total >= EXPECTED:
            cell, total = cell + 1, 0.0
    return np.asarray(np.unique(number)[:, None] == number, dtype=float)
