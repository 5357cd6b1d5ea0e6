"""SymPy expressions as CasADi graphs: each different subexpression once, rationals exact."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import reduce
from typing import Any

import casadi as ca

from ...algebra.number_types import MORE, UNARY
from ...base.errors import ParameterError, shown
from .exact_terms import ONE, ZERO, Term, graph, over, plus, power, times

RECIPROCAL = {
    "sec": "cos",
    "csc": "sin",
    "cot": "tan",
    "sech": "cosh",
    "csch": "sinh",
    "coth": "tanh",
}
"""Functions that are one over a function of the graph."""
DIRECT: dict[str, Callable[[Any], Any]] = {n: getattr(ca, n) for n in (*UNARY, *MORE)} | {
    "Abs": ca.fabs
}
"""Functions of one number in SymPy that a graph has, by SymPy's name."""
ANGLE = "atan2"
"""The one function of two numbers."""


class Translation:
    """SymPy expressions with known symbols, as terms of a graph; each expression is read once.

    Parameters
    ----------
    known
        Terms by SymPy symbol, function of time or derivative.

    Examples
    --------
    >>> import sympy
    >>> a = sympy.Symbol("a")
    >>> Translation({a: ca.SX.sym("a")})(sympy.sin(a) / 3)
    SX((sin(a)/3))
    """

    def __init__(self, known: Mapping[Any, Term]) -> None:
        self._found: dict[Any, Term] = dict(known)

    def add(self, known: Mapping[Any, Term]) -> None:
        """Further symbols, before an expression that holds them is read.

        Parameters
        ----------
        known
            As in the constructor.
        """
        self._found |= known

    def __call__(self, expression: Any) -> Term:
        """The term of one expression.

        Parameters
        ----------
        expression
            A SymPy expression.

        Raises
        ------
        ParameterError
            If the graph has no such number or function; the sentence names it.
        """
        stack = [expression]  # no recursion: expressions may be deeper than Python's stack
        while stack:
            one = stack[-1]
            open_ = [a for a in _parts(one) if a not in self._found] if self._new(one) else []
            if open_:
                stack += open_
                continue
            stack.pop()
            if one not in self._found:
                self._found[one] = _term(one, [self._found[a] for a in _parts(one)])
        return self._found[expression]

    def _new(self, one: Any) -> bool:
        return one not in self._found

    def rows(self, matrix: Any) -> list[list[Term]]:
        """The entries of a SymPy matrix as rows of terms.

        Parameters
        ----------
        matrix
            A SymPy matrix.
        """
        return [[self(matrix[i, j]) for j in range(matrix.cols)] for i in range(matrix.rows)]


def _parts(one: Any) -> tuple[Any, ...]:
    """Arguments that are read first; a rational exponent is no term."""
    if one.is_Pow:
        return tuple(one.args[:1] if one.exp.is_Rational else one.args)
    known = one.is_Function and type(one).__name__ in (*DIRECT, *RECIPROCAL, ANGLE)
    return tuple(one.args) if one.is_Add or one.is_Mul or known else ()


def _term(one: Any, parts: list[Term]) -> Term:
    if one.is_Rational:
        return Fraction(int(one.p), int(one.q))
    if one.is_Float and one.is_finite:
        sign, mantissa, exponent, _ = one._mpf_
        return Fraction((-1) ** sign * int(mantissa)) * Fraction(2) ** exponent
    if one.is_Add:
        return reduce(plus, parts, ZERO)
    if one.is_Mul:
        return reduce(times, parts, ONE)
    if one.is_Pow:
        return _power(one, parts)
    if type(one).__name__ == ANGLE and len(parts) == 2:
        return _angle(one, *parts)
    if one.is_Function and len(parts) == 1:
        return _function(one, parts[0])
    raise _refusal(one)


def _power(one: Any, parts: list[Term]) -> Term:
    base, exponent = parts[0], one.exp
    if exponent.is_Integer:
        if abs(int(exponent)) > 64 and not isinstance(base, Fraction):
            return ca.power(base, float(exponent))
        return power(base, int(exponent))
    if isinstance(base, Fraction) and (exponent.is_Rational or isinstance(parts[1], Fraction)):
        raise _irrational(one)
    if exponent.is_Rational and exponent.q == 2:
        return power(ca.sqrt(base), int(exponent.p))
    if exponent.is_Rational:  # a third is no double: the logarithm keeps the power exact
        return ca.exp(times(Fraction(int(exponent.p), int(exponent.q)), ca.log(base)))
    if isinstance(base, Fraction) and Fraction(float(base)) != base:
        raise _irrational(one)
    if isinstance(parts[1], Fraction) and Fraction(float(parts[1])) != parts[1]:
        return ca.exp(times(parts[1], ca.log(base)))
    return ca.power(graph(base), graph(parts[1]))


def _function(one: Any, part: Term) -> Term:
    name = type(one).__name__
    if name not in DIRECT and name not in RECIPROCAL:
        raise _refusal(one)
    if isinstance(part, Fraction):
        raise _irrational(one)
    if name in RECIPROCAL:
        return over(ONE, DIRECT[RECIPROCAL[name]](part))
    return DIRECT[name](part)


def _angle(one: Any, y: Term, x: Term) -> Term:
    """The angle of (x, y); that of (c x, c y) with c > 0 is the same, so a fraction stays exact."""
    for part in (y, x):
        if isinstance(part, Fraction):
            scale = Fraction(part.denominator)
            y, x = times(scale, y), times(scale, x)
    if any(isinstance(v, Fraction) and Fraction(float(v)) != v for v in (y, x)) or (
        isinstance(y, Fraction) and isinstance(x, Fraction)
    ):
        raise _irrational(one)
    return ca.atan2(graph(y), graph(x))


def _irrational(one: Any) -> ParameterError:
    return ParameterError(
        f"the equations hold the number {shown(str(one))}, which no double is exactly; put a "
        "symbol in its place and give its value as a parameter."
    )


def _refusal(one: Any) -> ParameterError:
    if one.is_number and not one.is_Function:
        if one.is_NumberSymbol:
            return _irrational(one)
        return ParameterError(
            f"the equations hold {shown(str(one))}, which is no finite real number; SymPy divided "
            "by zero or left the real numbers."
        )
    if one.is_Derivative:
        return ParameterError(
            f"the equations hold {shown(str(one))}, which is neither a state nor the rate of one; "
            "solve for it, or leave it out."
        )
    if one.is_Symbol:
        return ParameterError(
            f"the equations hold the symbol {shown(str(one))}, which is neither a state nor a "
            "parameter; time itself is none, so the equations must not name it."
        )
    return ParameterError(
        f"the equations use SymPy's {type(one).__name__}; a graph has + - * /, powers, abs, sqrt, "
        "exp, log, sin, sinh and their like, and the inverses, atan2 too: write it by these, or "
        "give the rates to System.from_function as a plain Python function, for spectra without "
        "proofs."
    )
