"""Zeros and symmetry of a family's spectrum at all members, by places, vectors and identities.

The center of a free chain may lie anywhere and move at any constant speed: vectors without
parameters say so.  If A maps V₁ to 0, V₂ to V₁, and so on, then A is nilpotent on the last of these
spaces, so λ = 0 has at least its dimension as multiplicity.  No polynomial is multiplied out.

An identity in a symbol for each entry holds for the entries too.  Entries that are equal up to a
rational factor share their symbol: this is enough for the symmetric stiffness of the restricted
three-body problem, whose entries are too large to be multiplied out.

Source: tests/systems/test_null_chains.py, tests/systems/test_symmetric.py.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property, lru_cache, reduce
from typing import Any

import numpy as np
from flint import fmpq, fmpq_mat

from ..algebra.exact.function_field import SPARE, Expression, FunctionField, counted
from ..algebra.exact.number_fields import NotExact, characteristic, vanishes
from ..algebra.exact.routh import times
from ..base.errors import StabilityError
from ..systems.family import Family
from ..systems.structure.places import Pattern, blocks_of, mirrored, nonzero, sparse_zeros
from ..systems.structure.structural_zeros import structure
from .characteristic import CharacteristicPolynomial

# --- coefficients that vanish ---


def known_coefficients(size: int, count: int, *, even: bool) -> list[bool]:
    """Whether each coefficient of det(λ - A), lowest first, is zero for these reasons.

    Returns
    -------
    list of bool
        n + 1 entries.

    Examples
    --------
    >>> known_coefficients(3, 0, even=True)  # λ³ + a λ
    [True, False, True, False]
    """
    return [i < count or (even and (size - i) % 2 == 1) for i in range(size + 1)]


# --- a symbol for each large entry ---


def with_symbols(
    blocks: Sequence[Sequence[Sequence[Any]]], zero: Callable[[Any], bool]
) -> list[list[list[Any]]]:
    """Matrices with a symbol in place of each expression; all share their symbols.

    Parameters
    ----------
    blocks
        Matrices of rationals and of expressions of one function field.
    zero
        Test whether an entry is zero.

    Returns
    -------
    list
        The matrices, of rationals and of rational multiples of symbols.

    Examples
    --------
    >>> a, b = FunctionField(["a", "b"]).symbols
    >>> one, two = with_symbols([[[a + b]], [[-2 * a - 2 * b, a - a]]], lambda v: bool(v == 0))
    >>> two[0][0] == -2 * one[0][0], two[0][1]
    (True, 0)
    """
    keys: dict[tuple[str, str], int] = {}
    parts = [[[_split(entry, zero) for entry in row] for row in block] for block in blocks]
    for block in parts:
        for row in block:
            for _, key in row:
                if key is not None:
                    keys.setdefault(key, len(keys))
    # one field for all: the same symbol in two fields would mean two expressions
    symbols = FunctionField([f"e{i}" for i in range(len(keys))]).symbols
    return [
        [[c if key is None else symbols[keys[key]] * c for c, key in row] for row in block]
        for block in parts
    ]


def _split(entry: Any, zero: Callable[[Any], bool]) -> tuple[Any, tuple[str, str] | None]:
    """An entry as a rational factor, and the name of the rest; None where there is no rest."""
    if zero(entry):
        return 0, None
    if not isinstance(entry, Expression):
        return entry, None
    if entry.num.is_constant() and entry.den.is_constant():
        return entry.plain(), None
    top, bottom = entry.num.leading_coefficient(), entry.den.leading_coefficient()
    return top / bottom, (str(entry.num / top), str(entry.den / bottom))


# --- chains of constant vectors ---


SAMPLES = 2
"""Values of the indeterminates at which vectors are sought; each vector is then proved."""


def constant_zeros(matrix: Sequence[Sequence[Any]], zero: Callable[[Any], bool]) -> int:
    """Number of zero eigenvalues that chains of constant vectors prove, from right or left.

    Examples
    --------
    >>> from stability.algebra.exact.function_field import FunctionField
    >>> [k] = FunctionField(["k"]).symbols
    >>> free = [[0, 0, 1, 0], [0, 0, 0, 1], [-k, k, 0, 0], [k, -k, 0, 0]]
    >>> constant_zeros(free, lambda v: bool(v == 0))
    2
    """
    return max(constant_kernels(matrix, zero), default=0)


def constant_kernels(matrix: Sequence[Sequence[Any]], zero: Callable[[Any], bool]) -> list[int]:
    """Dimensions of the kernels of A, A², … that chains of constant vectors prove.

    Parameters
    ----------
    matrix
        Rationals, and expressions of one function field.
    zero
        Test whether an entry is zero.

    Examples
    --------
    >>> constant_kernels([[0, 1], [0, 0]], lambda v: bool(v == 0))
    [1, 2]
    """
    try:
        samples = [_sample(matrix, number) for number in range(SAMPLES)]
    except (NotExact, ZeroDivisionError):
        return []
    turned = [list(column) for column in zip(*matrix, strict=True)]
    right = _chain(matrix, samples, zero)
    left = _chain(turned, [m.transpose() for m in samples], zero)
    longer = max(len(right), len(left))  # a chain that has ended keeps its dimension
    right, left = ([*s, *s[-1:] * (longer - len(s))] for s in (right, left))
    return list(map(max, right, left)) if right and left else right or left


def _sample(matrix: Sequence[Sequence[Any]], number: int) -> Any:
    """The matrix with a rational in place of each indeterminate, related or not."""

    def value(entry: Any) -> Any:
        if not isinstance(entry, Expression):
            if not isinstance(entry, (int, fmpq)):
                raise NotExact("an algebraic entry")
            return fmpq(entry)
        count = entry.num.context().nvars()
        point = [
            fmpq(3 + 2 * ((i + 7 * number) % 11) + i, 5 + (i + number) % 3) for i in range(count)
        ]
        return fmpq(entry.num(*point)) / fmpq(entry.den(*point))

    return fmpq_mat([[value(entry) for entry in row] for row in matrix])


def _chain(
    matrix: Sequence[Sequence[Any]], samples: Sequence[Any], zero: Callable[[Any], bool]
) -> list[int]:
    """Dimensions of the spaces of the chain."""
    size, dimensions = len(matrix), list[int]()
    space: list[list[Any]] = []
    while True:
        if len(space) == size:
            return dimensions
        checks = _kernel(space, size)  # rows that vanish on the space
        shadow = fmpq_mat(checks)
        rows = [row for m in samples for row in (shadow * m).tolist()]
        wider = _kernel(rows, size)
        if len(wider) <= len(space) or not _mapped(matrix, wider, checks, zero):
            return dimensions
        space = wider
        dimensions.append(len(space))


def _kernel(rows: list[list[Any]], size: int) -> list[list[Any]]:
    """A basis of the vectors on which all rows vanish."""
    if not rows:
        return [[fmpq(int(i == j)) for j in range(size)] for i in range(size)]
    table, rank = fmpq_mat(rows).rref()
    pivots = [next(j for j in range(size) if table[i, j] != 0) for i in range(rank)]
    out = []
    for free in (j for j in range(size) if j not in pivots):
        vector = [fmpq(0)] * size
        vector[free] = fmpq(1)
        for i, j in enumerate(pivots):
            vector[j] = -table[i, free]
        out.append(vector)
    return out


def _mapped(
    matrix: Sequence[Sequence[Any]],
    vectors: list[list[Any]],
    checks: list[list[Any]],
    zero: Callable[[Any], bool],
) -> bool:
    """Whether the matrix maps vectors to where all checks vanish, identically."""
    for vector in vectors:
        image = [_dot(row, vector) for row in matrix]
        if not all(zero(_dot(image, check)) for check in checks):
            return False
    return True


def _dot(entries: Sequence[Any], vector: Sequence[Any]) -> Any:
    total: Any = fmpq(0)
    for entry, c in zip(entries, vector, strict=True):
        if c != 0 and not (isinstance(entry, (int, fmpq)) and entry == 0):
            total = total + entry * c
    return total


# --- identities of expressions ---


FUNCTIONS = 4
"""Functions of a family's numbers that a field over them has room for, for each state."""
MOST_STATES = 16
"""States of the largest block whose polynomial is multiplied out, in expressions or in balls."""


@dataclass(frozen=True)
class Identity:
    """Properties of a family's characteristic polynomial at every member, on every branch."""

    zeros: int
    """Number of eigenvalues that are zero identically in parameters and unknowns."""
    even: bool
    """Whether the spectrum is symmetric under λ → -λ identically: det(λ - A) is even or odd."""


class FreePolynomial(CharacteristicPolynomial):
    """The polynomial with every number free, on no branch: its identities hold at every member."""

    constants = True

    def __init__(self, family: Family) -> None:
        functions = max(SPARE, FUNCTIONS * len(family.system.states))
        super().__init__(family, {}, counted(), spare=functions)

    def zero(self, value: Any) -> bool:
        """Whether an entry is zero at every member: identically, or by the only equation."""
        if vanishes(value) or not isinstance(value, Expression):
            return bool(vanishes(value))
        equation = self.equations[0].num if len(self.places) == 1 else None
        return equation is not None and bool(divmod(value.num, equation)[1] == 0)

    @cached_property
    def tangents(self) -> int:
        """Number of tangents of the family that are null vectors at every isolated root.

        The rates outside the solved equations must vanish identically.  All rates then vanish along
        the branch, and the chain rule gives A·∂x/∂at = 0.  Ignorable states stand apart: the block
        of the other states has these tangents, and each ignorable state one zero of its own.
        """
        family = self.family
        states = family.system.states
        equations = () if family.closed else family.equations
        solved = {states.index(n) for n in equations if n in states}
        with suppress(ArithmeticError):
            rates = self.rows(family.graph.rates)
            if all(i in solved or self.zero(rates[i][0]) for i in family.resting):
                return family.tangents + len(family.idle)
        return 0


@lru_cache(maxsize=64)
def identity(family: Family) -> Identity:
    """Zeros of the characteristic polynomial that are identities of expressions.

    Returns
    -------
    Identity
        A lower bound: an expression that is too large to compute counts as not proved.
    """
    tangents, zeros, even = 0, 0, False
    places = stored(family)  # sparsity needs no arithmetic, at any size
    with suppress(ArithmeticError, StabilityError):
        free, sampled = FreePolynomial(family), structure(family)
        tangents = free.tangents
        zeros, even = _zero_pattern(free.matrix, free.zero, (sampled.zeros, sampled.even))
    zeros = max(zeros, tangents, sparse_zeros(places), len(family.idle))
    return Identity(zeros, even or mirrored(places))


def stored(family: Family) -> Pattern:
    """Whether the graph holds each entry of the linearisation."""
    graph = family.graph.matrix
    out = np.zeros(graph.shapes[0], dtype=bool)
    for i, j in graph.places[0]:
        out[i, j] = True
    return out


def certain(family: Family) -> bool:
    """Whether the sampled structure is proved for every member."""
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


def whole_polynomial(matrix: list[list[Any]]) -> list[Any]:
    """det(λ - A) by powers of λ, lowest first."""
    return reduce(times, map(characteristic, blocks_of(matrix)))


def _zero_pattern(
    matrix: list[list[Any]], zero: Callable[[Any], bool], wanted: tuple[int, bool]
) -> tuple[int, bool]:
    """Zeros of the product of the blocks' polynomials, and whether the rest is even.

    The places of zero entries cost nothing, constant vectors and symbols in place of the others
    little.  What samples do not show is not tried.
    """
    blocks = blocks_of(matrix, zero)
    places = [nonzero(block, zero) for block in blocks]
    count, even = sum(map(sparse_zeros, places)), all(map(mirrored, places))
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
            zeros += sparse_zeros(places)
            even = even and mirrored(places)
            continue
        low = next(i for i, c in enumerate(poly) if not zero(c))
        zeros += low
        rest = poly[low:]
        if not _is_even(rest, zero):
            mixed.append(rest)
    if mixed and even:  # a product may be even where no single block is: (λ - a)(λ + a)
        with suppress(NotExact):
            return zeros, _is_even(reduce(times, mixed), zero)
    return zeros, even and not mixed


def _is_even(poly: Sequence[Any], zero: Callable[[Any], bool]) -> bool:
    return len(poly) % 2 == 1 and all(zero(c) for c in poly[1::2])
