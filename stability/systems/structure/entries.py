"""Polynomials of matrices whose entries are large expressions, with a symbol for each entry.

An identity in these symbols holds for the expressions too.  Entries that are equal up to a rational
factor share their symbol: this is enough for the symmetric stiffness of the restricted three-body
problem, whose entries are too large to be multiplied out.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from ...algebra.exact.function_field import Expression, FunctionField


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
