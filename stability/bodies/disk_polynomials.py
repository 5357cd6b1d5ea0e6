"""Characteristic polynomials of the disk's families over Q, kept as package data.

They were derived from the graph (`stability.derivation.characteristic`,
`stability.derivation.hurwitz`) and are read here without SymPy, to be evaluated over any number
type: exact rationals, balls, intervals, arrays.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from typing import Any

from ..algebra.polynomial import Polynomial
from ..base.checks import arithmetic
from ..base.errors import NameUnknownError, ParameterError, StabilityError, shown
from .contact import Contact

DATA = "disk_polynomials.json"
"""The file of derived polynomials, in stability/data."""
DIGEST = "d60731b19cd4d14caabd9d683c1229d5ee419c736590ce8994c1b54211caac27"
"""SHA-256 of that file, written by `make derive`; another content is refused."""


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
        A key of `stability.bodies.disk_families.FAMILIES`.
    law
        A contact law or its name.

    Returns
    -------
    Exact

    Raises
    ------
    NameUnknownError
        If there is no such family or law.

    Source: derived from the graph; tests/test_exact.py derives it again.

    Examples
    --------
    >>> found = exact_polynomial("rolling", "viscous")
    >>> found.zeros, [str(p) for _, p in found.conditions]
    (2, ['2*k*z - 1'])
    """
    name = law.name if isinstance(law, Contact) else law
    if not isinstance(family, str) or not isinstance(name, str):
        bad = name if isinstance(family, str) else family
        raise NameUnknownError(f"{shown(bad)} is no name; give a family and a law by their names.")
    found = known_polynomial(family, name)
    if found is None:
        cases = ", ".join(key.replace(" ", " under ") for key in _catalogue())
        raise NameUnknownError(
            f"{shown(f'{family} {name}')} has no polynomial; there is one for {cases}."
        )
    return found


def known_polynomial(family: str, law: str) -> Exact | None:
    """The same by names, or None where no polynomial is stored: there the graph is the route."""
    return _catalogue().get(f"{family} {law}")


@lru_cache(maxsize=1)
def _catalogue() -> dict[str, Exact]:
    content = (files(__package__) / DATA).read_bytes()
    if digest(content) != DIGEST:
        raise StabilityError(
            f"stability/bodies/{DATA} is not the file that was derived with this version; it is "
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
