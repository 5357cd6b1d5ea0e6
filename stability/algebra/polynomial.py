"""Polynomials over Q in several variables, evaluated in any algebra.

`Exact` and `ExactPolynomial` are characteristic polynomials that are known exactly, of a body or of
a user's family.  Verdicts are then proved from the known coefficients instead of the graph's.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

from ..base.citation import cited
from ..base.errors import ParameterError, shown
from ..base.types import content, fields_of
from ..base.user_code import arithmetic
from .number_types import Algebra

MOST = 1000
"""Largest exponent."""


@dataclass(frozen=True)
class Polynomial:
    """A polynomial with integer coefficients in named variables, evaluated over any number type.

    Examples
    --------
    >>> p = Polynomial(("k", "z"), ((2, (1, 1)), (-1, (0, 0))))  # 2kz - 1
    >>> from fractions import Fraction
    >>> p(Fraction(1, 4), 2), p(0.25, 4.0), str(p)
    (Fraction(0, 1), 1.0, '2*k*z - 1')
    """

    variables: tuple[str, ...]
    """Names of the variables."""
    terms: tuple[tuple[int, tuple[int, ...]], ...]
    """(coefficient, exponents) of each monomial."""

    __getstate__ = fields_of

    def __post_init__(self) -> None:
        """Refuse other terms: the terms become the source of a function."""
        for c, e in self.terms:
            whole = type(c) is int and all(type(p) is int and 0 <= p <= MOST for p in e)
            if not whole or len(e) != len(self.variables):
                raise ParameterError(
                    f"a term is {shown((c, e))}; give an integer and {len(self.variables)} "
                    f"exponents from 0 to {MOST}."
                )

    def __call__(self, *values: Any) -> Any:
        """The value by nested Horner schemes, with the last variable outermost."""
        return self._compiled(*values)

    @cached_property
    def _compiled(self) -> Any:
        names = [f"x{i}" for i in range(len(self.variables))]
        body = _horner(list(self.terms), names)
        space: dict[str, Any] = {}
        exec(f"def value({', '.join(names)}):\n    return {body}\n", space)
        return space["value"]

    def factored(self, values: Mapping[str, Any], outer: Sequence[str] = ()) -> Any:
        """The value with few products: each Horner scheme is in the variable that most terms share.

        Parameters
        ----------
        values
            Values of the variables, by name.
        outer
            Variables of the outermost schemes, outermost first: over broadcast arrays, those that
            vary most.

        Examples
        --------
        >>> p = Polynomial(("x", "y", "z"), ((1, (1, 2, 0)), (2, (0, 1, 1)), (-3, (0, 0, 1))))
        >>> p.factored({"x": 2, "y": 3, "z": 5})  # y (x y + 2z) - 3z
        33
        """
        ahead = tuple(self.variables.index(n) for n in outer if n in self.variables)
        return _factored(list(self.terms), [values[n] for n in self.variables], ahead)

    @cached_property
    def parts(self) -> tuple[Polynomial, Polynomial]:
        """(P⁺, P⁻) with P = P⁺ - P⁻, both with positive coefficients."""
        plus = tuple(t for t in self.terms if t[0] > 0)
        minus = tuple((-c, e) for c, e in self.terms if c < 0)
        return Polynomial(self.variables, plus), Polynomial(self.variables, minus)

    @property
    def degrees(self) -> tuple[int, ...]:
        """Degree in each variable."""
        return tuple(
            max((e[i] for _, e in self.terms), default=0) for i in range(len(self.variables))
        )

    def roundings(self, behind: Mapping[str, int]) -> int:
        """Largest number of roundings of any monomial in the Horner schemes.

        Parameters
        ----------
        behind
            Number of roundings in the value of each variable, by name.
        """
        return _roundings(list(self.terms), [behind[n] for n in self.variables])

    def derivative(self, variable: str) -> Polynomial:
        """The derivative by one variable."""
        i = self.variables.index(variable)
        terms = tuple((c * e[i], (*e[:i], e[i] - 1, *e[i + 1 :])) for c, e in self.terms if e[i])
        return Polynomial(self.variables, terms)

    def __str__(self) -> str:
        words = []
        for c, e in self.terms:
            powers = [
                f"{n}**{p}" if p > 1 else n for n, p in zip(self.variables, e, strict=True) if p
            ]
            size = [str(abs(c))] if abs(c) != 1 or not powers else []
            words.append(("-" if c < 0 else "+") + " " + "*".join([*size, *powers]))
        text = " ".join(words) or "0"
        return text[2:] if text.startswith("+") else text.replace("- ", "-", 1)


def _horner(terms: list[tuple[int, tuple[int, ...]]], names: list[str]) -> str:
    """Source of the value; constants stay integers, which every number type accepts."""
    if not terms:
        return "0"
    if not names:
        return repr(sum(c for c, _ in terms))
    groups: dict[int, list[tuple[int, tuple[int, ...]]]] = {}
    for c, e in terms:
        groups.setdefault(e[-1], []).append((c, e[:-1]))
    powers = sorted(groups, reverse=True)
    text = ""
    x = names[-1]
    for place, power in enumerate(powers):
        inner = _horner(groups[power], names[:-1])
        text = f"({text} + {inner})" if text else f"({inner})"
        following = powers[place + 1] if place + 1 < len(powers) else 0
        text += f" * {x}" * (power - following)
    return text


def _factored(
    terms: list[tuple[int, tuple[int, ...]]], values: list[Any], ahead: tuple[int, ...]
) -> Any:
    """The value, first in the variables at the places `ahead`, then in those that most share."""
    while ahead and not any(e[ahead[0]] for _, e in terms):
        ahead = ahead[1:]
    shared = [sum(e[i] > 0 for _, e in terms) for i in range(len(values))]
    if not any(shared):
        return sum(c for c, _ in terms)
    i = ahead[0] if ahead else max(range(len(values)), key=shared.__getitem__)
    least = min(e[i] for _, e in terms if e[i])
    inner = [(c, (*e[:i], e[i] - least, *e[i + 1 :])) for c, e in terms if e[i]]
    rest = [(c, e) for c, e in terms if not e[i]]
    power = values[i]  # powers are shared by many terms
    for _ in range(least - 1):
        power = power * values[i]
    value = _factored(inner, values, ahead)
    value = power if isinstance(value, int) and value == 1 else power * value
    return value + _factored(rest, values, ahead) if rest else value


def _roundings(terms: list[tuple[int, tuple[int, ...]]], behind: list[int]) -> int:
    """Roundings in `_horner`: one for each product and sum, and those of each factor."""
    if not terms or not behind:
        return 0
    groups: dict[int, list[tuple[int, tuple[int, ...]]]] = {}
    for c, e in terms:
        groups.setdefault(e[-1], []).append((c, e[:-1]))
    count, last = -1, 0
    for power in sorted(groups, reverse=True):
        inner = _roundings(groups[power], behind[:-1])
        if count < 0:
            count = inner
        else:
            count = max(count + (last - power) * (1 + behind[-1]), inner) + 1
        last = power
    return count + last * (1 + behind[-1])


@dataclass(frozen=True)
class Exact:
    """Polynomial and conditions of a family under a law, over Q.

    Source: docs/explanation/method.md; tests/spectra/test_exact_polynomial.py.

    Examples
    --------
    >>> import stability as st
    >>> polynomial = st.export.exact_polynomial("spinning", "viscous")
    >>> polynomial.variables, polynomial.zeros
    (('k', 'M', 'z'), 1)
    """

    family: str
    """Name of the family."""
    law: str
    """Name of the contact law."""
    variables: tuple[str, ...]
    """For the disk: k, then M = mu*² (laws with mu), then z = at*² or s = sinθ (both for circling
    and precession, z = φ̇*²)."""
    zeros: int
    """Number of structural zeros."""
    even: bool
    """Whether the polynomial without its structural zeros is even in λ."""
    factors: tuple[tuple[Polynomial, ...], ...]
    """Factors over Q; each by powers of σ, lowest first.  λ = σ mu*, or λ = σ without mu."""
    conditions: tuple[tuple[str, Polynomial], ...]
    """(kind, polynomial): all positive means stable (or neutral), some negative means unstable."""

    @property
    def citation(self) -> str:
        """Keys of the works to cite, for `stability.citation`."""
        return cited(self.law, model=True, proofs=True)

    @arithmetic("give numbers of one type")
    def coefficients(self, values: Sequence[Any]) -> list[list[Any]]:
        """Coefficients of each factor at a point, lowest power of σ first.

        Parameters
        ----------
        values
            Values of `variables`, of any number type.

        Returns
        -------
        list of list
        """
        if isinstance(values, (str, bytes)) or len(values) != len(self.variables):
            raise ParameterError(
                f"values is {shown(values)}; give one number for each of "
                f"{', '.join(self.variables)}."
            )
        return [[c(*values) for c in factor] for factor in self.factors]


class ExactPolynomial:
    """The characteristic polynomial of a family, from the numbers that name a member.

    A subclass for your family has one method, `coefficients`, and `zeros` where eigenvalues vanish
    by structure.  `Family` takes an instance as `exact`, if no unknown is solved for.  At first
    use the package compares the polynomial with the equations of motion at random members.

    Source: docs/explanation/method.md; tests/spectra/test_exact_polynomial.py.

    Examples
    --------
    >>> import stability as st
    >>> import casadi as ca, stability as st
    >>> class Damped(st.results.ExactPolynomial):
    ...     def coefficients(self, values, algebra):  # λ² + d λ + g
    ...         return [[values["g"], values["d"], 1]]
    >>> x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    >>> system = st.System("pendulum", x, p, ca.vertcat(x[1], -p[0] * ca.sin(x[0]) - p[1] * x[1]),
    ...                    states=("angle", "rate"), parameters=("g", "d"))
    >>> hanging = st.Family(system, "hanging", at=("g",), held={"angle": 0, "rate": 0},
    ...                     exact=Damped())
    >>> st.spectrum(hanging, at=1.0, d=0.0).reason
    ... # doctest: +ELLIPSIS
    "double precision left it open; proved in rational arithmetic from the family's polynomial; ..."
    """

    zeros: int = 0
    """Number of eigenvalues that vanish by structure; the coefficients leave them out."""
    derived: ClassVar[bool] = False
    """Whether polynomial and conditions are proved for every member and a member's unknowns are
    unique.  The comparison at first use is then left out."""

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and content(vars(self)) == content(vars(other))

    def __hash__(self) -> int:
        return hash((type(self), content(vars(self))))

    def __init__(self) -> None:
        """Nothing to keep; a subclass may have numbers of its own."""

    def coefficients(
        self,
        values: Mapping[str, Any],  # noqa: ARG002
        algebra: Algebra,  # noqa: ARG002
    ) -> Sequence[Sequence[Any]]:
        """Coefficients of the factors of the polynomial in λ, lowest power first.

        Parameters
        ----------
        values
            Numbers of one type by name, in the user's units: rational, ball, ratio in an axis.
        algebra
            Functions of this number type: `algebra.functions["sqrt"](x)`.

        Returns
        -------
        sequence of sequence
            For each factor its coefficients, real, the last one not zero.
        """
        raise ParameterError(f"the polynomial {type(self).__name__} states no coefficients.")

    def conditions(
        self,
        values: Mapping[str, Any],  # noqa: ARG002
        algebra: Algebra,  # noqa: ARG002
    ) -> list[tuple[str, Any]] | None:
        """Numbers whose signs give the verdict; only for a polynomial that is `derived`.

        Parameters
        ----------
        values, algebra
            As for `coefficients`.

        Returns
        -------
        list or None
            (kind, number): all positive means stable (or neutral), some negative means unstable.
            Kinds are static, flutter and auxiliary.  None: the verdict comes from the coefficients.
        """
        return None

    def scale(self, values: Mapping[str, Any]) -> tuple[Any, Any]:  # noqa: ARG002
        """Unit of the polynomial's variable in the user's unit of rate.

        Parameters
        ----------
        values
            Numbers by name, as for `coefficients`.

        Returns
        -------
        scale, square
            λ = σ · scale with a positive scale; where it is None, λ² = σ² · square.
        """
        return 1, None


class TabulatedPolynomial(ExactPolynomial, ABC):
    """An exact polynomial stored as `Polynomial`s in a few positive variables, proved offline.

    Maps take them as polynomials in two axes, so each variable is a number times powers of the
    user's numbers, or the sine of an angle.
    """

    derived = True
    borders: bool = False
    """Whether the verdict can change where the sine of the angle is 1."""

    def __init__(self, exact: Exact) -> None:
        self.known, self.zeros = exact, exact.zeros

    @abstractmethod
    def point(self, values: Mapping[str, Any], algebra: Algebra) -> list[Any]:
        """Values of `known.variables`."""

    @abstractmethod
    def sine(self, values: Mapping[str, Any], algebra: Algebra) -> Any:
        """The sine on which the polynomials depend."""

    @abstractmethod
    def roundings(self, *, dimensionless: bool) -> Mapping[str, int]:
        """Largest number of roundings in the value of each variable, in floating point, by name.

        Parameters
        ----------
        dimensionless
            Whether the user's numbers are dimensionless.
        """

    @abstractmethod
    def natural(self, point: Sequence[Any]) -> Any:
        """Square of the unit of σ in the family's own unit of rate."""

    @abstractmethod
    def angle(self, axis: str) -> str:
        """Angle through whose sine the polynomials depend on an axis: theta, lean or empty."""

    @abstractmethod
    def edge(self, values: Mapping[str, Any]) -> bool:
        """Whether a member lies on the edge of the domain on which the conditions are proved."""

    def coefficients(self, values: Mapping[str, Any], algebra: Algebra) -> list[list[Any]]:
        """Coefficients of the factors, as for every exact polynomial."""
        return self.known.coefficients(self.point(values, algebra))

    def conditions(self, values: Mapping[str, Any], algebra: Algebra) -> list[tuple[str, Any]]:
        """Conditions, as for every exact polynomial; on the edge one number is zero."""
        point = self.point(values, algebra)
        edge = [("static", 0)] if self.edge(values) else []
        return [(kind, p(*point)) for kind, p in self.known.conditions] + edge
