"""Structural zeros of a family: eigenvalues that vanish at every typical member."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from flint import arb

from ...algebra.exact.routh import ROUGH
from ...algebra.linear_systems import contraction, inverse_of
from ...algebra.number_types import balls, precision
from ...algebra.running_error import UNIT, ball_arrays
from ...base.errors import StabilityError
from ...base.types import Floats
from ..family import Family
from .enclosure import ball_unknowns, matrix_polynomial
from .places import LARGE, components, mirrored

SAMPLES = 3
"""Random members at which the structure of a spectrum is established."""

SAMPLE_BITS = 400
"""Precision at the samples; a coefficient below half as many bits at each one is structural."""

MOST_HALVINGS = 30
"""Most halvings of the way from a known member to a sample, where its sheet ends on the way."""
CLEAR = 1e-9
"""Value of a condition from which it is clear at a sample."""
DIRECTIONS = 4
"""Directions from the middle in which a member is looked for: at the middle a family may end."""


@dataclass(frozen=True)
class Structure:
    """Properties of a family's characteristic polynomial that hold at typical members."""

    zeros: int
    """Multiplicity of the factor λ over the rational functions of the parameters."""
    even: bool
    """Whether the polynomial without this factor is even in λ."""
    how: str
    """A phrase that says how the structure was established."""
    steady: bool
    """Whether the sampled members are steady motions; if not, the count holds for them alone."""


@lru_cache(maxsize=64)
def structure(family: Family) -> Structure:
    """The structural zeros of a family's spectrum, established once.

    Coefficients of the characteristic polynomial are analytic in the parameters.  A coefficient
    that vanishes identically vanishes at random members; any other is proved nonzero at almost
    all of these.  For the disk the count is derived exactly over Q(k, mu, at) in
    tests/systems/test_structure.py.

    Parameters
    ----------
    family
        The family; samples lie near its `typical` sizes.

    Raises
    ------
    StabilityError
        If the family is called conservative but its polynomial is not even.

    Examples
    --------
    >>> from stability.bodies.subject import disk_family
    >>> structure(disk_family("rolling", "viscous")).zeros
    2
    """
    if len(family.system.states) > LARGE and (by_places := _by_places(family)) is not None:
        return by_places
    vanishing, steady = [True] * (len(family.system.states) + 1), True
    for sample in _samples(family):
        flags, rests = _vanishing(family, sample)
        steady = steady and rests
        vanishing = [v and f for v, f in zip(vanishing, flags, strict=True)]
    zeros = vanishing.index(False)
    rest = vanishing[zeros:]
    even = all(rest[1::2]) and len(rest) > 1
    if family.conservative and not even:
        raise StabilityError(
            f"family {family.name} is called conservative, but its characteristic polynomial is "
            "not even in λ; leave conservative out."
        )
    how = (
        f"vanishing to {SAMPLE_BITS // 2} bits at {SAMPLES} random members, the next proved nonzero"
    )
    return Structure(zeros, even, how, steady)


def steady_where(family: Family, values: Mapping[str, Any]) -> Family:
    """The family, with typical size 0 of inputs that are given as 0 if it is steady only there.

    Examples
    --------
    >>> import casadi as ca, stability as st
    >>> x, k = ca.SX.sym("x"), ca.SX.sym("k", 2)
    >>> pushed = st.System("pushed", x, k, k[1] - k[0] * x, states=("x",), parameters=("k", "F"))
    >>> rest = st.Family(pushed, "rest", at=("k",), held={"x": 0})
    >>> steady_where(rest, {"F": 0}).typical, steady_where(rest, {"F": 1}).typical
    ({'F': 0.0}, {})
    """
    names = (*family.at, *family.parameters)
    zero = {n: 0.0 for n, v in values.items() if n in names and np.ndim(v) == 0 and v == 0}
    if not zero or structure(family).steady:
        return family
    other = replace(family, typical={**family.typical, **zero})
    return other if structure(other).steady else family


@lru_cache(maxsize=256)
def sampled(family: Family, sample: int) -> tuple[arb, ...]:
    """Random family parameters and parameters near the typical ones, away from special values.

    A family that is followed from a known member is sampled about this member.  Where the
    root-finder reaches no member at a sample, one nearer to the middle is taken.
    """
    names = (*family.at, *family.parameters)
    with precision(SAMPLE_BITS):
        size = [arb(family.typical.get(n, 1.0)) for n in names]
        first = [(s * (1 + w)).mid() for s, w in zip(size, _away(sample, len(names)), strict=True)]
        if family.anchor is None and (not family.unknown or family.closed):
            return tuple(first)
        middle = size if family.anchor is None else [arb(float(v)) for v in family.anchor.given]
        point = first
        for turn in range(DIRECTIONS if family.anchor is None else 1):
            away = _away(sample + turn * SAMPLES, len(names))
            way = [s * w for s, w in zip(size, away, strict=True)]
            for halvings in range(0, MOST_HALVINGS, 2):
                point = [(m + w / 2**halvings).mid() for m, w in zip(middle, way, strict=True)]
                row = np.array([[float(v) for v in point]])
                if _has_member(family, row[:, : len(family.at)], row[:, len(family.at) :]):
                    return tuple(point)
        return tuple(point if family.anchor else first)


def _has_member(family: Family, a: Floats, q: Floats) -> bool:
    """Whether there is a member, and not where a condition is about to fail.

    There coordinates may end, as at a pole of a body, and the count of zeros is another one.
    """
    roots = family.search(a, q)
    if not roots.good[0]:
        return False
    states, p = family.states(a, roots.u, q), family._system_parameters(a, roots.u, q)
    return bool(family.system.valid(states, p, CLEAR)[0])


def _away(sample: int, count: int) -> list[arb]:
    """Shares by which numbers are moved: incommensurable ones, which avoid special values."""
    spread = [arb(2 + 7 * sample + 3 * i).sqrt() for i in range(count)]
    return [(s - s.floor()) / 4 - arb(1) / 8 for s in spread]


def _samples(family: Family) -> range:
    return range(SAMPLES if family.at or family.parameters else 1)


def _by_places(family: Family) -> Structure | None:
    """The structure of a large family without its polynomial, or None.

    Zeros are states of their own that no entry moves; all other blocks have a determinant that is
    not zero at a sample.  The spectrum is even by the places of the entries; it is not where the
    sum of the eigenvalues is not zero at the sample.
    """
    with precision(SAMPLE_BITS):
        places = [_placed(family, sampled(family, sample)) for sample in _samples(family)]
        steady = all(_rest(family, place) for place in places)
        matrix, error = (part[0] for part in ball_arrays(family.graph.matrix, places[0])[0])
    pattern = (matrix != 0) | (error != 0)
    blocks = [i for i in components(pattern) if len(i) > 1 or pattern[i, i]]
    for i in blocks:
        block, doubt = (some[None][:, i[:, None], i] for some in (matrix, error))
        if not contraction(inverse_of(block), block, doubt).sum(axis=-1).max() < 0.5:
            return None
    even = bool(blocks) and mirrored(pattern)
    total, wide = np.trace(matrix), np.trace(error) + len(matrix) * UNIT * np.abs(matrix).trace()
    if not even and (family.conservative or (blocks and abs(total) <= 1.01 * wide)):
        return None
    zeros = len(matrix) - sum(map(len, blocks))
    return Structure(zeros, even, "no entry; the determinant of the rest proved nonzero", steady)


def _placed(family: Family, point: Sequence[Any]) -> list[Sequence[Any]]:
    """A point in balls with its unknowns: family parameters, unknowns, parameters."""
    a, q = point[: len(family.at)], point[len(family.at) :]
    return [a, ball_unknowns(family, a, q), q]


def _rest(family: Family, place: Sequence[Sequence[Any]]) -> bool:
    """Whether no rate is proved to differ from zero at a sample.

    Held values may be rounded: rates vanish to a few digits only.
    """
    rates = family.graph.rates.dense(balls(), place)
    solved = family.unknown and not family.closed  # another root may be arbitrarily close
    return all(
        arb(rates[i][0]).contains(0) if solved else arb(rates[i][0]).abs_lower() < ROUGH
        for i in family.resting
    )


def _vanishing(family: Family, sample: int) -> tuple[list[bool], bool]:
    """Whether each coefficient vanishes to 200 bits at a random member, and whether its rates do.

    Large entries need more bits.
    """
    least = 2.0 ** (-SAMPLE_BITS // 2)
    point = sampled(family, sample)
    for bits in (SAMPLE_BITS, 4 * SAMPLE_BITS, 16 * SAMPLE_BITS):
        with precision(bits):
            place = _placed(family, point)
            coefficients = matrix_polynomial(family, *place)
            rests = _rest(family, place)
        near = [bool(c.contains(0)) for c in coefficients]
        small = [float(c.abs_upper()) < least for c in coefficients]
        if all(s for s, n in zip(small, near, strict=True) if n):
            break
    return [n and s for n, s in zip(near, small, strict=True)], rests
