"""Zeros and symmetry of a family's spectrum as identities of expressions, for all members."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache, reduce
from typing import Any

import numpy as np

from ...algebra.exact.function_field import FunctionField
from ...algebra.exact.number_fields import EXACT, NotExact, characteristic, vanishes
from ...base.errors import StabilityError
from ..family import Family
from . import pattern
from .entries import with_symbols
from .null_chains import constant_zeros
from .structural_zeros import structure

MOST_STATES = 16
"""States of the largest block whose symmetry is sought by multiplying expressions out."""


@dataclass(frozen=True)
class Identity:
    """Properties of a family's characteristic polynomial at every member, on every branch."""

    zeros: int
    """Number of eigenvalues that are zero identically in parameters and unknowns."""
    even: bool
    """Whether the spectrum is symmetric under λ → -λ identically: det(λ - A) is even or odd."""


@lru_cache(maxsize=64)
def identity(family: Family) -> Identity:
    """Zeros of the characteristic polynomial that are identities of expressions.

    Parameters
    ----------
    family
        The family.

    Returns
    -------
    Identity
        A lower bound: an expression that is too large to compute counts as not proved.
    """
    symbols = FunctionField([*family.at, *family.unknown, *family.parameters]).symbols
    cut = len(family.at), len(family.at) + len(family.unknown)
    parts = symbols[: cut[0]], symbols[cut[0] : cut[1]], symbols[cut[1] :]
    tangents, zeros, even = 0, 0, False
    places = stored(family)  # sparsity needs no arithmetic, at any size
    with suppress(ArithmeticError):
        zero = on_the_branch(family, parts)
        tangents = fixed_directions(family, parts, zero)
        sampled = structure(family)
        zeros, even = _zero_pattern(
            exact_matrix(family, *parts), zero, (sampled.zeros, sampled.even)
        )
    zeros = max(zeros, tangents, pattern.zeros(places), len(family.left_out))
    return Identity(zeros, even or pattern.mirrored(places))


def stored(family: Family) -> pattern.Pattern:
    """Whether the graph holds each entry of the linearisation."""
    graph = family.graph.matrix
    out = np.zeros(graph.shapes[0], dtype=bool)
    for i, j in graph.places[0]:
        out[i, j] = True
    return out


def on_the_branch(family: Family, parts: Sequence[Sequence[Any]]) -> Callable[[Any], bool]:
    """Test whether an expression is zero at every member: identically, or by the equation."""
    if family.closed or len(family.unknown) != 1:
        return vanishes
    residual, _ = family.graph.residual.run(EXACT, parts)
    equation = residual[0].num

    def zero(value: Any) -> bool:
        if vanishes(value) or not hasattr(value, "num"):
            return bool(vanishes(value))
        return bool(divmod(value.num, equation)[1] == 0)

    return zero


def certain(family: Family) -> bool:
    """Whether the sampled structure is proved for every member.

    Parameters
    ----------
    family
        The family.
    """
    sampled = structure(family)
    if not sampled.steady:
        return False
    if not sampled.zeros and not family.conservative:
        return True
    proved = identity(family)
    return proved.zeros >= sampled.zeros and (proved.even or not family.conservative)


def symmetric(family: Family) -> bool:
    """Whether the spectrum without structural zeros is proved even in λ at every member.

    Parameters
    ----------
    family
        The family; it need not be declared conservative.
    """
    # samples first: they cost little, and a spectrum that is not even shows it
    return structure(family).even and certain(family) and identity(family).even


def exact_matrix(
    family: Family, a: Sequence[Any], u: Sequence[Any], q: Sequence[Any]
) -> list[list[Any]]:
    """The linearisation in exact numbers or expressions.

    Parameters
    ----------
    family, a, u, q
        The family with its parameters, unknowns and the system's other parameters.

    Raises
    ------
    NotExact
        If an entry has no exact value, or is too large.
    """
    try:
        return family.graph.matrix.dense(EXACT, [list(a), list(u), list(q)])
    except (ZeroDivisionError, StabilityError) as error:
        raise NotExact(str(error)) from None


def blocks_of(
    matrix: list[list[Any]], zero: Callable[[Any], bool] = vanishes
) -> list[list[list[Any]]]:
    """Diagonal blocks of the block triangular form: their polynomials multiply to the whole."""
    members = pattern.components(nonzero(matrix, zero))
    return [[[matrix[i][j] for j in some] for i in some] for some in members]


def nonzero(matrix: list[list[Any]], zero: Callable[[Any], bool] = vanishes) -> pattern.Pattern:
    """Whether each entry is not proved to be zero."""
    return np.array([[not zero(entry) for entry in row] for row in matrix])


def whole_polynomial(matrix: list[list[Any]]) -> list[Any]:
    """det(λ - A) by powers of λ, lowest first."""
    return reduce(_product, map(characteristic, blocks_of(matrix)))


def _zero_pattern(
    matrix: list[list[Any]], zero: Callable[[Any], bool], wanted: tuple[int, bool]
) -> tuple[int, bool]:
    """Zeros of the product of the blocks' polynomials, and whether the rest is even.

    The places of zero entries cost nothing, constant vectors and symbols in place of the others
    little.  What samples do not show is not tried.
    """
    blocks = blocks_of(matrix, zero)
    places = [nonzero(block, zero) for block in blocks]
    count, even = sum(map(pattern.zeros, places)), all(map(pattern.mirrored, places))
    if count < wanted[0]:
        count = max(count, constant_zeros(matrix, zero))
    large = max(map(len, blocks)) > MOST_STATES

    def enough() -> bool:
        return count >= wanted[0] and (even or large or not wanted[1])

    if not enough() and not large:
        more = zeros_and_parity(with_symbols(blocks, zero), vanishes)
        count, even = max(count, more[0]), even or more[1]
    if not enough():
        more = zeros_and_parity(blocks, zero)
        count, even = max(count, more[0]), even or more[1]
    return count, even


def zeros_and_parity(
    blocks: list[list[list[Any]]], zero: Callable[[Any], bool]
) -> tuple[int, bool]:
    """Zeros of the product of the blocks' polynomials, and whether the rest is even.

    Parameters
    ----------
    blocks
        Diagonal blocks, all over one field.
    zero
        Test whether an entry or a coefficient is zero.

    Returns
    -------
    zeros, even
        Proved: a block that is too large counts with what the places of its zeros prove.
    """
    zeros, even = 0, True
    mixed: list[list[Any]] = []
    for block in blocks:
        try:
            poly = characteristic(block)
        except NotExact:  # too large: the places of its zero entries still prove something
            places = nonzero(block, zero)
            zeros += pattern.zeros(places)
            even = even and pattern.mirrored(places)
            continue
        low = next(i for i, c in enumerate(poly) if not zero(c))
        zeros += low
        rest = poly[low:]
        if not _is_even(rest, zero):
            mixed.append(rest)
    if mixed and even:  # a product may be even where no single block is: (λ - a)(λ + a)
        with suppress(NotExact):
            return zeros, _is_even(reduce(_product, mixed), zero)
    return zeros, even and not mixed


def _is_even(poly: Sequence[Any], zero: Callable[[Any], bool]) -> bool:
    return len(poly) % 2 == 1 and all(zero(c) for c in poly[1::2])


def _product(p: Sequence[Any], q: Sequence[Any]) -> list[Any]:
    out: list[Any] = [0] * (len(p) + len(q) - 1)
    for i, x in enumerate(p):
        for j, y in enumerate(q):
            out[i + j] = out[i + j] + x * y
    return out


def fixed_directions(
    family: Family, parts: Sequence[Sequence[Any]], zero: Callable[[Any], bool]
) -> int:
    """Number of tangents of the family that are null vectors at every isolated root.

    The rates outside the solved equations must vanish identically.  All rates then vanish along
    the branch, and the chain rule gives A·∂x/∂at = 0.  Ignorable states stand apart: the block of
    the other states has these tangents, and each ignorable state one zero of its own.
    """
    states = family.system.states
    solved = set() if family.closed else {states.index(n) for n in family.equations if n in states}
    with suppress(ArithmeticError):
        rates = family.graph.rates.dense(EXACT, parts)
        if all(i in solved or zero(rates[i][0]) for i in family.resting):
            return family.tangents + len(family.left_out)
    return 0
