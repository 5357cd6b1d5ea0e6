"""Characteristic polynomials of the disk's families over Q, kept as package data.

They were derived from the graph (`stability.derivation`, `stability.hurwitz`) and are read here
without SymPy, to be evaluated over any number type: exact rationals, balls, intervals, arrays.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from importlib.resources import files
from typing import Any

from .checks import arithmetic
from .contact import Contact
from .errors import NameUnknownError, ParameterError, StabilityError, shown

DATA = "exact.json"
"""The file of derived polynomials, in stability/data."""
DIGEST = "d60731b19cd4d14caabd9d683c1229d5ee419c736590ce8994c1b54211caac27"
"""SHA-256 of that file, written by `make derive`; another content is refused."""


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
    """Names."""
    terms: tuple[tuple[int, tuple[int, ...]], ...]
    """(coefficient, exponents) of each monomial."""

    def __post_init__(self) -> None:
        """Refuse what is no polynomial over Z: the terms become the source of a function."""
        for c, e in self.terms:
            whole = type(c) is int and all(type(p) is int and 0 <= p <= MOST for p in e)
            if not whole or len(e) != len(self.variables):
                raise ParameterError(
                    f"a term is {shown((c, e))}; give an integer and {len(self.variables)} "
                    f"exponents from 0 to {MOST}."
                )

    def __call__(self, *values: Any) -> Any:
        """The value, by nested Horner schemes, the last variable outermost."""
        return self._compiled(*values)

    @cached_property
    def _compiled(self) -> Any:
        names = [f"x{i}" for i in range(len(self.variables))]
        body = _horner(list(self.terms), names)
        space: dict[str, Any] = {}
        exec(f"def value({', '.join(names)}):\n    return {body}\n", space)
        return space["value"]

    @cached_property
    def parts(self) -> tuple[Polynomial, Polynomial]:
        """(P⁺, P⁻), both with positive coefficients, whose difference this is."""
        plus = tuple(t for t in self.terms if t[0] > 0)
        minus = tuple((-c, e) for c, e in self.terms if c < 0)
        return Polynomial(self.variables, plus), Polynomial(self.variables, minus)

    @property
    def degrees(self) -> tuple[int, ...]:
        """Degree in each variable."""
        return tuple(max((e[i] for _, e in self.terms), default=0)
                     for i in range(len(self.variables)))  # fmt: skip

    def ordered(self) -> tuple[Polynomial, list[int]]:
        """The same with the variable of least degree outermost, and the order of its arguments.

        Over broadcast arrays the outermost scheme is the one that runs over the full shape.
        """
        order = sorted(range(len(self.variables)), key=lambda i: -self.degrees[i])
        terms = tuple((c, tuple(e[i] for i in order)) for c, e in self.terms)
        return Polynomial(tuple(self.variables[i] for i in order), terms), order

    def roundings(self, behind: Mapping[str, int]) -> int:
        """Most roundings on the way of any monomial through the Horner schemes.

        Parameters
        ----------
        behind
            Roundings already behind each variable.
        """
        return _roundings(list(self.terms), [behind[n] for n in self.variables])

    def derivative(self, variable: str) -> Polynomial:
        """The derivative by one variable.

        Parameters
        ----------
        variable
            Its name.
        """
        i = self.variables.index(variable)
        terms = tuple((c * e[i], (*e[:i], e[i] - 1, *e[i + 1 :])) for c, e in self.terms if e[i])
        return Polynomial(self.variables, terms)

    def __str__(self) -> str:
        words = []
        for c, e in self.terms:
            powers = [f"{n}**{p}" if p > 1 else n
                      for n, p in zip(self.variables, e, strict=True) if p]  # fmt: skip
            size = [str(abs(c))] if abs(c) != 1 or not powers else []
            words.append(("-" if c < 0 else "+") + " " + "*".join([*size, *powers]))
        text = " ".join(words) or "0"
        return text[2:] if text.startswith("+") else text.replace("- ", "-", 1)


def _horner(terms: list[tuple[int, tuple[int, ...]]], names: list[str]) -> str:
    """Source of the value; constants stay integers, so that no number type is forced."""
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


def _roundings(terms: list[tuple[int, tuple[int, ...]]], behind: list[int]) -> int:
    """Mirrors `_horner`: one for each product and sum, and those behind each factor."""
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
    """What is known of a family under a law over Q."""

    family: str
    """Name of the family."""
    law: str
    """Name of the contact law."""
    variables: tuple[str, ...]
    """k, then M = mu*² (laws with mu), then z = at*² or s = sinθ (both for circling and
    precession, z = φ̇*²)."""
    zeros: int
    """Structural zeros."""
    even: bool
    """Whether the rest is even in λ."""
    factors: tuple[tuple[Polynomial, ...], ...]
    """Factors over Q; each by powers of σ, lowest first.  λ = σ mu* for a law with mu, else σ."""
    conditions: tuple[tuple[str, Polynomial], ...]
    """(kind, polynomial): all positive means stable (or neutral), some negative unstable."""

    @arithmetic("give numbers of one type")
    def coefficients(self, values: Sequence[Any]) -> list[list[Any]]:
        """Coefficients of each factor at a point, lowest power of σ first.

        Parameters
        ----------
        values
            Of `variables`, any number type.

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


def exact_polynomial(family: str, law: str | Contact) -> Exact:
    """The characteristic polynomial and the conditions of a family under a law.

    Parameters
    ----------
    family
        rolling, spinning, tumbling, circling (rough) or precession (smooth).
    law
        A contact law or its name.

    Returns
    -------
    Exact

    Raises
    ------
    NameUnknownError
        If there is no such family or law.

    Source: derived from the graph; tests/test_exact.py derives it anew.

    Examples
    --------
    >>> found = exact_polynomial("rolling", "viscous")
    >>> found.zeros, [str(p) for _, p in found.conditions]
    (2, ['2*k*z - 1'])
    """
    name = law.name if isinstance(law, Contact) else law
    known = _catalogue()
    if not isinstance(family, str) or not isinstance(name, str):
        bad = name if isinstance(family, str) else family
        raise NameUnknownError(f"{shown(bad)} is no name; give a family and a law by their names.")
    key = f"{family} {name}"
    if key not in known:
        raise NameUnknownError(
            f"{shown(key)} has no polynomial; there is one for rolling, spinning and tumbling "
            "under each law of spectra, for circling under rough and for precession under smooth."
        )
    return known[key]


@lru_cache(maxsize=1)
def _catalogue() -> dict[str, Exact]:
    content = (files("stability") / "data" / DATA).read_bytes()
    if digest(content) != DIGEST:
        raise StabilityError(
            f"stability/data/{DATA} is not the file that was derived with this version; it is "
            "damaged or was edited. Install the package again, or derive it (make derive)."
        )
    cases = json.loads(content)["cases"]
    return {key: _read(key, record) for key, record in cases.items()}


def digest(content: bytes) -> str:
    """SHA-256 of the file of polynomials, the same for every kind of line end.

    Parameters
    ----------
    content
        The file.

    Returns
    -------
    str
    """
    return hashlib.sha256(content.replace(b"\r\n", b"\n")).hexdigest()


def _read(key: str, record: Mapping[str, Any]) -> Exact:
    family, law = key.split()
    names = tuple(record["variables"])

    def polynomial(terms: Sequence[Sequence[int]]) -> Polynomial:
        return Polynomial(names, tuple((c, tuple(e)) for c, *e in terms))

    return Exact(
        family, law, names, record["zeros"], record["even"],
        tuple(tuple(polynomial(c) for c in factor) for factor in record["factors"]),
        tuple((c["kind"], polynomial(c["terms"])) for c in record["conditions"]),
    )  # fmt: skip
