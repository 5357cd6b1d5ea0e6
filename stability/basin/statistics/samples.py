"""Random launches by index: launch i is the same in any order and any chunk.

Each launch has its own blocks of a counter-based generator (Philox 4x64-10; Salmon, Moraes, Dror &
Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC'11), with the seed as key and its index as
counter.  Its random words depend on nothing else.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from ...base.checks import one_number, positive, whole_number
from ...base.errors import ParameterError, shown
from ...base.types import Floats, Record

BLOCK = 4
"""Words of 64 bits that the generator gives for each value of its counter."""
LARGEST_SEED = 2**128 - 1


class QuantityDistribution(Protocol):
    """Distribution of one quantity."""

    def at(self, share: Floats) -> Floats:
        """Quantiles: the values below which the given shares of the quantity lie."""
        ...


@dataclass(frozen=True)
class _Interval:
    low: float
    """Least value, in the quantity's unit."""
    high: float
    """Largest value."""

    def __post_init__(self) -> None:
        kind = type(self).__name__
        low = one_number(f"the low end of {kind}", self.low)
        high = one_number(f"the high end of {kind}", self.high)
        if not low < high:
            raise ParameterError(
                f"{kind} runs from {low:g} to {high:g}; the low end must be below the high end."
            )


class Uniform(_Interval):
    """Even distribution between two values.

    Source: Philox 4x64-10 of Salmon, Moraes, Dror & Shaw 2011: tests/basin/test_samples.py.

    Examples
    --------
    >>> import numpy as np
    >>> import stability as st
    >>> st.statistics.Uniform(1, 3).at(np.array([0.25]))
    array([1.5])
    """

    def at(self, share: Floats) -> Floats:
        """Quantiles at shares in (0, 1)."""
        return self.low + (self.high - self.low) * share


class LogUniform(_Interval):
    """Distribution whose logarithm is even, between two values above zero.

    Source: Philox 4x64-10 of Salmon, Moraes, Dror & Shaw 2011: tests/basin/test_samples.py.

    Examples
    --------
    >>> import numpy as np
    >>> import stability as st
    >>> st.statistics.LogUniform(0.01, 100).at(np.array([0.5])).round(12)
    array([1.])
    """

    def __post_init__(self) -> None:
        positive("the low end of LogUniform", self.low, "it must be above zero")
        super().__post_init__()

    def at(self, share: Floats) -> Floats:
        """Quantiles at shares in (0, 1)."""
        return np.asarray(self.low * np.exp(np.log(self.high / self.low) * share))


@dataclass(frozen=True)
class Normal:
    """Normal distribution.

    Source: Philox 4x64-10 of Salmon, Moraes, Dror & Shaw 2011: tests/basin/test_samples.py.

    Examples
    --------
    >>> import numpy as np
    >>> import stability as st
    >>> st.statistics.Normal(2.0, 0.1).at(np.array([0.5, 0.975])).round(3)
    array([2.   , 2.196])
    """

    mean: float
    """Mean, in the quantity's unit."""
    deviation: float
    """Standard deviation, same unit."""

    def __post_init__(self) -> None:
        one_number("the mean of Normal", self.mean)
        positive("the deviation of Normal", self.deviation)

    def at(self, share: Floats) -> Floats:
        """Quantiles at shares in (0, 1)."""
        from scipy.special import ndtri

        return np.asarray(self.mean + self.deviation * ndtri(share))


class Distribution(Protocol):
    """Joint distribution of named quantities."""

    @property
    def names(self) -> tuple[str, ...]:
        """The quantities, in the order of columns."""
        ...

    @property
    def words(self) -> int:
        """Random numbers that one launch takes."""
        ...

    def values(self, shares: Floats) -> Floats:
        """Launches, shape (n, number of names), from even numbers in (0, 1), shape (n, words)."""
        ...


@dataclass(frozen=True, eq=False)
class Independent(Record):
    """Independent quantities by name; a box if all are `Uniform`.

    Examples
    --------
    >>> Independent({"theta": Uniform(0.1, 1.5), "omega3": Normal(2, 0.1)}).names
    ('theta', 'omega3')
    """

    quantities: Mapping[str, QuantityDistribution]
    """Distribution of each quantity."""

    def __post_init__(self) -> None:
        _named(self.quantities)
        for name, quantity in self.quantities.items():
            if not callable(getattr(quantity, "at", None)):
                raise ParameterError(
                    f"the distribution of {name} is {shown(quantity)}; "
                    "give Uniform, LogUniform or Normal."
                )

    @property
    def names(self) -> tuple[str, ...]:
        """The quantities, in the order of columns."""
        return tuple(self.quantities)

    @property
    def words(self) -> int:
        """Random numbers that one launch takes."""
        return len(self.quantities)

    def values(self, shares: Floats) -> Floats:
        """Launches from even numbers in (0, 1)."""
        columns = zip(self.quantities.values(), shares.T, strict=True)
        return np.stack([quantity.at(share) for quantity, share in columns], axis=1)


@dataclass(frozen=True, eq=False)
class Ball(Record):
    """Even distribution in a ball, whose radius each quantity measures in its own unit.

    Source: Philox 4x64-10 of Salmon, Moraes, Dror & Shaw 2011: tests/basin/test_samples.py.

    Examples
    --------
    >>> import stability as st
    >>> st.statistics.Ball({"theta": 1.2, "omega3": 2.0}, {"theta": 0.01, "omega3": 0.1}).words
    3
    """

    centre: Mapping[str, float]
    """Centre of each quantity."""
    radius: Mapping[str, float]
    """Largest deviation of each quantity."""

    def __post_init__(self) -> None:
        _named(self.centre)
        if set(self.centre) != set(self.radius):
            raise ParameterError(
                f"the ball has a centre of {', '.join(self.centre)} and a radius of "
                f"{', '.join(self.radius)}; give the same names."
            )
        for name in self.centre:
            one_number(f"the centre of {name}", self.centre[name])
            positive(f"the radius of {name}", self.radius[name])

    @property
    def names(self) -> tuple[str, ...]:
        """The quantities, in the order of columns."""
        return tuple(self.centre)

    @property
    def words(self) -> int:
        """Random numbers that one launch takes: a direction, and a distance."""
        return len(self.centre) + 1

    def values(self, shares: Floats) -> Floats:
        """Launches from even numbers in (0, 1)."""
        unit = in_ball(shares)
        centre, radius = (np.array([m[n] for n in self.names]) for m in (self.centre, self.radius))
        return np.asarray(centre + radius * unit)


DistributionLike = Distribution | Mapping[str, QuantityDistribution]
"""A distribution, or independent quantities by name."""


def sample(distribution: DistributionLike, first: int, count: int, seed: int = 0) -> Floats:
    """Launches `first` to `first + count - 1` of a random sample.

    Parameters
    ----------
    distribution
        `Independent`, `Ball`, your own `Distribution`, or quantities by name.
    first
        Index of the first launch, from 0.
    count
        Number of launches.
    seed
        Whole number from 0 to 2^128 - 1.  Another seed gives an independent sample.

    Returns
    -------
    ndarray
        Shape (count, number of names), columns in the order of `names`.

    Raises
    ------
    ParameterError
        If an argument is not accepted.

    Examples
    --------
    >>> spread = {"theta": Uniform(0.1, 1.5), "omega3": Normal(2.0, 0.1)}
    >>> whole = sample(spread, 0, 1000, seed=3)
    >>> bool((sample(spread, 400, 5, seed=3) == whole[400:405]).all())
    True
    """
    joint = Independent(distribution) if isinstance(distribution, Mapping) else distribution
    check_distribution(joint)
    return joint.values(shares(joint.words, first, count, seed))


def check_distribution(joint: Any) -> None:
    """Refuse what is no joint distribution.

    Parameters
    ----------
    joint
        Anything.

    Raises
    ------
    ParameterError
        If it has no names or no values.
    """
    if not callable(getattr(joint, "values", None)) or not hasattr(joint, "names"):
        raise ParameterError(
            f"the distribution is {shown(joint)}; give Ball, or distributions by name."
        )


def shares(words: int, first: int, count: int, seed: int = 0) -> Floats:
    """Even random numbers in (0, 1) by index.

    Parameters
    ----------
    words
        Numbers for each index.
    first, count
        First index, and how many.
    seed
        Key of the generator.

    Returns
    -------
    ndarray
        Shape (count, words): middles of 2^53 equal parts of (0, 1), so never 0 or 1.

    Examples
    --------
    >>> bool((shares(5, 7, 2) == shares(5, 0, 9)[7:]).all())
    True
    """
    first = whole_number("first", first, least=0)
    count = whole_number("count", count, least=0)
    seed = whole_number("seed", seed, 0, LARGEST_SEED)
    blocks = -(-words // BLOCK)
    if first > (2**255) // blocks:
        raise ParameterError(f"first is {shown(first)}; the generator has fewer numbers.")
    generator = np.random.Philox(key=seed, counter=first * blocks)
    raw = generator.random_raw(count * blocks * BLOCK).reshape(count, blocks * BLOCK)
    return ((raw[:, :words] >> np.uint64(11)).astype(float) + 0.5) * 2.0**-53


def on_sphere(shares: Floats) -> Floats:
    """Points that are evenly distributed on the unit sphere, one for each row of numbers.

    Parameters
    ----------
    shares
        Even random numbers in (0, 1), shape (n, d).

    Returns
    -------
    ndarray
        Shape (n, d).

    Source: Muller, Commun. ACM 2 (1959) 19: the direction of normal deviates.

    Examples
    --------
    >>> np.linalg.norm(on_sphere(shares(6, 0, 2)), axis=1).round(12)
    array([1., 1.])
    """
    from scipy.special import ndtri

    normal = ndtri(shares)
    return np.asarray(normal / np.linalg.norm(normal, axis=1, keepdims=True))


def in_ball(shares: Floats) -> Floats:
    """Points that are evenly distributed in the unit ball; the last number gives the distance.

    Parameters
    ----------
    shares
        Even random numbers in (0, 1), shape (n, d + 1).

    Returns
    -------
    ndarray
        Shape (n, d).

    Examples
    --------
    >>> bool((np.linalg.norm(in_ball(shares(3, 0, 99)), axis=1) < 1).all())
    True
    """
    size = shares.shape[1] - 1
    return np.asarray(on_sphere(shares[:, :-1]) * shares[:, -1:] ** (1 / size))


def _named(quantities: Any) -> None:
    """Refuse anything but values by name."""
    if not isinstance(quantities, Mapping) or not quantities:
        raise ParameterError(
            f"the quantities are {shown(quantities)}; give at least one, as name: distribution."
        )
