"""Characteristic polynomials of the disk's families over Q, kept as package data.

They are derived from the graph by notebooks/proofs/stored.py.  This module reads them without
SymPy.  They are evaluated over any number type: exact rationals, balls, intervals, arrays.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from functools import lru_cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from typing import Any

import numpy as np

from ..algebra.number_types import Algebra
from ..algebra.polynomial import Exact, Polynomial, TabulatedPolynomial
from ..base.checks import known
from ..base.errors import NameUnknownError, NoMemberError, StabilityError, shown
from .contact_laws import MOTION_LAWS, Contact, law_class
from .families import FAMILIES

DATA = "disk_polynomials.json"
"""The file of derived polynomials, next to this module."""
DIGEST = "d60731b19cd4d14caabd9d683c1229d5ee419c736590ce8994c1b54211caac27"
"""SHA-256 of that file, written by `make derive`; a file with another digest is refused."""


INPUT = {"k": 0, "M": 5, "z": 5, "s": 2}
"""Most roundings in each variable: mu·mu·(g·R), at·at·(R/g), the sine within one unit in the last
place."""
PLAIN = INPUT | {"M": 1, "z": 1}
"""The same with m = R = g = 1."""


class DiskPolynomial(TabulatedPolynomial):
    """The polynomial of a disk's family, from numbers in a user's units.

    Parameters
    ----------
    exact
        Polynomial from `exact_polynomial`.
    """

    def __init__(self, exact: Exact) -> None:
        super().__init__(exact)
        self.by_angle = FAMILIES[exact.family].by_angle
        self.borders = self.by_angle and not exact.even

    def point(self, values: Mapping[str, Any], algebra: Algebra) -> list[Any]:
        """Values of those of k, M, z and s that the polynomial depends on."""
        v = values
        length = v["radius"] / v["gravity"]
        numbers = {"k": v["k"], "M": 1}
        if "mu" in v:
            numbers["M"] = v["mu"] * v["mu"] * (v["gravity"] * v["radius"])
        elif "c" in v:
            drag = v["c"] / v["mass"]
            numbers["M"] = drag * drag * length
        turn = next((n for n in ("phi_dot", "at") if n in v), None)
        if turn and "z" in self.known.variables:
            if turn == "phi_dot" and np.any(v[turn] == 0):
                raise NoMemberError(
                    f"{self.known.family} has no member at phi_dot = 0; give another phi_dot."
                )
            numbers["z"] = v[turn] * v[turn] * length
        if "s" in self.known.variables:
            numbers["s"] = self.sine(v, algebra)
        return [numbers[n] for n in self.known.variables]

    def sine(self, values: Mapping[str, Any], algebra: Algebra) -> Any:
        """Sine of theta, or of π/2 - lean."""
        if "lean" in values:
            return algebra.functions["cos"](values["lean"])
        return algebra.functions["sin"](values["theta"] if "theta" in values else values["at"])

    def scale(self, values: Mapping[str, Any]) -> tuple[Any, Any]:
        """(scale, None) with scale mu g or c/m; without friction (None, square) with square g/R."""
        if "mu" in values:
            return values["mu"] * values["gravity"], None
        if "c" in values:
            return values["c"] / values["mass"], None
        return None, values["gravity"] / values["radius"]

    def natural(self, point: Sequence[Any]) -> Any:
        """M, because λ = σ mu*; 1 without friction."""
        return 1 if self.known.even else point[self.known.variables.index("M")]

    def roundings(self, *, dimensionless: bool) -> Mapping[str, int]:
        """Most roundings in each value of `point`."""
        return PLAIN if dimensionless else INPUT

    def angle(self, axis: str) -> str:
        """Theta (also for the axis `at` if theta alone names a member), lean, or empty."""
        theta = self.by_angle and axis == "at"
        return "theta" if theta or axis == "theta" else "lean" if axis == "lean" else ""

    def edge(self, values: Mapping[str, Any]) -> bool:
        """Whether a member is upright: s = 1, by a lean of 0."""
        return "s" in self.known.variables and "lean" in values and bool(values["lean"] == 0)


def exact_polynomial(family: str, law: str | Contact | type[Contact] | None = None) -> Exact:
    """The characteristic polynomial and the conditions of a family under a law.

    Parameters
    ----------
    family
        A key of `stability.bodies.families.FAMILIES`.
    law
        A contact law, its name or its class; its numbers do not matter.

    Returns
    -------
    Exact
        Polynomial and conditions, over the rational functions of the parameters.

    Raises
    ------
    NameUnknownError, ParameterError
        If no polynomial is stored for this family and law, or the law is missing.

    Source: derived from the graph; tests/derivation/test_exact.py derives it again.

    Examples
    --------
    >>> import stability as st
    >>> polynomial = st.export.exact_polynomial("rolling", "viscous")
    >>> polynomial.zeros, [str(p) for _, p in polynomial.conditions]
    (2, ['2*k*z - 1'])
    """
    family = known("family", family, FAMILIES)
    kind, polynomial = law_class(law, motion=False), None
    if stored(kind):
        polynomial = known_polynomial(family, kind.name)
    if polynomial is None:
        cases = ", ".join(key.replace(" ", " under ") for key in _catalogue())
        raise NameUnknownError(
            f"{shown(f'{family} {kind.name}')} has no polynomial; there is one for {cases}."
        )
    return polynomial


def stored_laws() -> list[str]:
    """Names of the contact laws with a stored polynomial, in the order of the list of laws."""
    names = {key.split()[1] for key in _catalogue()}
    return [name for name in MOTION_LAWS if name in names]


def stored(law: type[Contact]) -> bool:
    """Whether a polynomial is stored under a law; false for every law of a user."""
    return MOTION_LAWS.get(law.name) is law and law.name in stored_laws()


@lru_cache(maxsize=64)
def disk_polynomial(family: str, law: type[Contact]) -> DiskPolynomial | None:
    """The stored polynomial of a family in a user's units; None where there is none."""
    exact = known_polynomial(family, law.name) if stored(law) else None
    return None if exact is None else DiskPolynomial(exact)


def known_polynomial(family: str, law: str) -> Exact | None:
    """The stored polynomial by names; None where none is stored and the graph is used."""
    return _catalogue().get(f"{family} {law}")


@lru_cache(maxsize=1)
def _catalogue() -> dict[str, Exact]:
    cases = stored_cases(files(__package__) / DATA, DIGEST)
    return {key: _read(key, record) for key, record in cases.items()}


def stored_cases(path: Traversable, derived: str) -> dict[str, Any]:
    """Polynomials of a file by family and law; a file with another digest is refused."""
    content = path.read_bytes()
    if digest(content) != derived:
        raise StabilityError(
            f"{path.name} is not the file that was derived with this version; it is damaged or was "
            "edited. Install the package again, or derive it (make derive)."
        )
    cases: dict[str, Any] = json.loads(content)["cases"]
    return cases


def digest(content: bytes) -> str:
    """SHA-256 of the file of polynomials, the same for every kind of line end.

    Parameters
    ----------
    content
        Bytes of the file.

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
        family,
        law,
        names,
        record["zeros"],
        record["even"],
        tuple(tuple(polynomial(c) for c in factor) for factor in record["factors"]),
        tuple((c["kind"], polynomial(c["terms"])) for c in record["conditions"]),
    )
