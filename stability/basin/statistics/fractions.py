"""Fractions of a sample by label, each with Wilson's interval.

The fraction of random starts that settle on one motion is its basin stability (Menck, Heitzig,
Marwan & Kurths, Nature Physics 9 (2013) 89).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ...base.checks import one_number
from ...base.errors import ParameterError, shown
from ...base.types import Floats

LEVEL = 0.95
"""Usual confidence level."""


@dataclass(frozen=True)
class Fraction:
    """Share of one label in a random sample."""

    label: int
    """The label."""
    count: int
    """Launches with this label."""
    of: int
    """Launches of the sample."""
    low: float
    """Low end of Wilson's interval."""
    high: float
    """High end."""
    level: float
    """Confidence level of the interval, for this label alone."""

    @property
    def citation(self) -> str:
        """Keys of the works to cite, for `stability.citation`."""
        return "stability, wilson1927"

    @property
    def value(self) -> float:
        """The share in the sample."""
        return self.count / self.of


def wilson(count: ArrayLike, of: ArrayLike, level: float = LEVEL) -> tuple[Floats, Floats]:
    """Wilson's score interval of a probability.

    Parameters
    ----------
    count
        Successes, any shape.
    of
        Independent trials, a shape that broadcasts with it.
    level
        Confidence level, in (0, 1).

    Returns
    -------
    low : ndarray
        Lower ends of the intervals, within [0, 1].
    high : ndarray
        Upper ends.

    Raises
    ------
    ParameterError
        If counts are not whole numbers from 0 to `of`, or `level` is not in (0, 1).

    Source: Wilson, J. Am. Stat. Assoc. 22 (1927) 209; coverage in Brown, Cai & DasGupta,
    Statist. Sci. 16 (2001) 101.

    Examples
    --------
    >>> import stability as st
    >>> low, high = st.statistics.wilson(15, 100)
    >>> print(f"{low:.4f} {high:.4f}")
    0.0931 0.2328
    """
    k, n = (np.asarray(value) for value in (count, of))
    if k.dtype.kind not in "iu" or n.dtype.kind not in "iu" or ((k < 0) | (k > n) | (n < 1)).any():
        raise ParameterError(
            f"the counts are {shown(count)} of {shown(of)}; "
            "whole numbers from 0 to the number of trials are needed."
        )
    z = quantile(level)
    share, spread = k / n, z * z / n
    middle = (share + spread / 2) / (1 + spread)
    half = np.sqrt(share * (1 - share) * spread + spread * spread / 4) / (1 + spread)
    low = np.where(k == 0, 0.0, middle - half)
    high = np.where(k == n, 1.0, middle + half)
    return low, high


def fractions(labels: ArrayLike, level: float = LEVEL) -> tuple[Fraction, ...]:
    """Fractions of every label of a random sample, in order of the labels.

    Parameters
    ----------
    labels
        Whole numbers, shape (n,), of independent launches; leave out those of a store that are not
        computed yet, whose outcome is -1.
    level
        Confidence level of each interval by itself.

    Returns
    -------
    tuple of Fraction
        One for each label, with an interval of confidence.

    Raises
    ------
    ParameterError
        If the labels are not whole numbers, or there are none.

    Source: E. B. Wilson (1927); tests/basin/test_statistics.py.

    Examples
    --------
    >>> import stability as st
    >>> for fraction in st.statistics.fractions([0, 0, 1, 0, 2, 0, 0, 1, 0, 0]):
    ...     print(fraction.label, fraction.value, f"{fraction.low:.3f} {fraction.high:.3f}")
    0 0.7 0.397 0.892
    1 0.2 0.057 0.510
    2 0.1 0.018 0.404
    """
    sample = np.asarray(labels)
    if sample.dtype.kind not in "iub" or sample.ndim != 1 or not sample.size:
        raise ParameterError(f"the labels are {shown(labels)}; give whole numbers, shape (n,).")
    names, counts = np.unique(sample.astype(np.int64), return_counts=True)
    low, high = wilson(counts, sample.size, level)
    rows = zip(names.tolist(), counts.tolist(), low.tolist(), high.tolist(), strict=True)
    return tuple(Fraction(n, k, sample.size, a, b, level) for n, k, a, b in rows)


def quantile(level: float) -> float:
    """Half width of a central interval of the normal distribution, in deviations.

    Parameters
    ----------
    level
        Confidence level, in (0, 1).

    Examples
    --------
    >>> round(quantile(0.95), 4)
    1.96
    """
    from scipy.special import ndtri

    return float(ndtri(0.5 + checked_level(level) / 2))


def checked_level(level: float) -> float:
    """A confidence level, or a refusal."""
    level = one_number("level", level)
    if not 0 < level < 1:
        raise ParameterError(f"level is {level:g}; a confidence level is between 0 and 1.")
    return level
