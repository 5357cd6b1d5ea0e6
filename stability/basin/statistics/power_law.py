"""Maximum-likelihood power law of shares that were counted on the same base points.

Counts at different displacements are dependent, since the same base points serve all.  The
likelihood as if they were independent gives a consistent estimate (a composite likelihood).  Its
curvature is not the precision.  The profile is therefore scaled by the spread between base points
(Chandler & Bate, Biometrika 94 (2007) 167).  The quantile is Fisher's, with the degrees of freedom
that the fourth moment of the influences leaves (Satterthwaite): few base points lie near a border.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq, minimize_scalar
from scipy.stats import chi2
from scipy.stats import f as fisher

from ...base.errors import ParameterError
from ...base.types import Floats

EXPECTED = 5.0
"""Least expected number of events of a cell of Pearson's statistic."""
STEEPEST = 20.0
"""Largest size of an exponent that is looked for."""


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


def fitted(
    table: Floats | np.ndarray[tuple[int, ...], np.dtype[np.bool_]], epsilons: Floats, level: float
) -> PowerLaw:
    """The power law of a table of events.

    Parameters
    ----------
    table
        Whether the event holds for base point i at ε_j, shape (n, m).
    epsilons
        Values above zero, shape (m,).
    level
        Confidence level.

    Returns
    -------
    PowerLaw

    Raises
    ------
    ParameterError
        If fewer than two of three or more values have events, or one has nothing else.

    Examples
    --------
    >>> distance = (np.arange(500) + 0.5) / 500
    >>> steps = np.geomspace(0.01, 0.2, 6)
    >>> law = fitted(distance[:, None] ** 2 < steps, steps, 0.95)
    >>> print(f"{law.exponent:.2f}")
    0.50
    """
    counts = np.asarray(table).sum(axis=0)
    if (counts > 0).sum() < 2 or len(counts) < 3:
        raise ParameterError(
            f"labels differ at {(counts > 0).sum()} of {len(counts)} displacements; "
            "take at least three, larger ones, or more base points."
        )
    if (counts == len(table)).any():
        raise ParameterError("all base points differ at one displacement; take smaller ones.")
    law = _Likelihood(np.asarray(table, dtype=float), epsilons)
    found = minimize_scalar(
        lambda b: -law.profile(b),
        bounds=(-STEEPEST, STEEPEST),
        method="bounded",
        options={"xatol": 1e-9},
    )
    b = float(found.x)
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
