"""A family with values: its possible axes, units, and dimensionless numbers.

All computations are dimensionless.  Only a `Problem` knows how a user's numbers (`at`, `k`, `mu`,
`mass`, `radius`, `gravity`, or the parameters of a user's system) become the family's parameters.
A `Problem` converts any number type, so that balls start from the exact doubles.

`problem_of` makes one from a `Subject`: for a disk with units, exact data and roundings.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import lru_cache, partial
from typing import Any

import numpy as np
from flint import arb, arb_series, fmpq, fmpq_poly
from numpy.typing import ArrayLike

from ..algebra.exact.number_fields import EXACT, NotExact, rational
from ..algebra.exact.routh import product
from ..algebra.number_types import MIXED, balls, precision
from ..algebra.polynomial import ExactPolynomial
from ..base.checks import checked
from ..base.errors import (
    NameUnknownError,
    NoMemberError,
    ParameterError,
    absent,
    listing,
    shown,
)
from ..base.exact_numbers import double, no_double, warn_rounded
from ..base.quantities import Kind, Units, without_dimension
from ..base.types import Floats
from ..bodies.contact_laws import Contact
from ..bodies.disk import Disk
from ..bodies.disk_polynomials import disk_polynomial
from ..bodies.quantities import PHYSICAL, QUANTITIES
from ..bodies.subject import LEAN, Subject, subject_of
from ..polynomials.identities import certain
from ..polynomials.zero_blocks import semisimple
from ..systems.closed_form import ClosedForm
from ..systems.family import Family
from ..systems.graph.sides import continuous, on_sides, switches_at
from ..systems.structure.enclosure import characteristic
from ..systems.structure.structural_zeros import SAMPLE_BITS, SAMPLES, sampled, structure

DERIVED = ("conditions", "scale")
"""Methods that only a derived polynomial may override."""
MOST_SIGNS = 4
"""Largest number of parameters that are sampled with both signs."""
CLOSE = 2.0**-100
"""Largest relative difference of two balls for one coefficient, as wide balls overlap too."""


def _plain(_: Mapping[str, Any]) -> Units:
    return Units()


@dataclass(frozen=True, eq=False)
class Problem:
    """A family with the values of everything it depends on, in the user's units."""

    family: Family
    """The family."""
    values: Mapping[str, Any]
    """Value or array by name: at (or its parts), parameters, physical quantities."""
    dimensionless: bool
    """Whether the numbers have no unit by choice of the units; False where a system has its own."""
    reduce: Callable[[Mapping[str, Any], Callable[[Any], Any]], tuple[list[Any], list[Any], Any]]
    """(values, square root) → family parameters, parameters, unit of rate; over any number type."""
    units: Callable[[Mapping[str, Any]], Units] = _plain
    """Units from the values."""
    roundings: tuple[int, ...] = ()
    """Number of roundings in each dimensionless number of (family parameters, parameters)."""
    law: Contact | None = None
    """The contact law, for the disk."""
    exact: ExactPolynomial | None = None
    """The characteristic polynomial, or None where it is not known."""
    plain: bool = False
    """Whether the family's numbers are the caller's as they are, without a conversion."""
    ratios: Mapping[str, Fraction] = field(default_factory=dict)
    """Values that are given exactly and are no doubles; `values` has their nearest doubles."""

    def rationals(self, values: Mapping[str, float]) -> dict[str, Any]:
        """Exact rationals of values: the user's own where these are no doubles.

        Returns
        -------
        dict
            By name, for exact work.
        """
        return {n: self._rational(n, float(v)) for n, v in values.items()}

    def _rational(self, name: str, value: float) -> Any:
        ratio = self.ratios.get(name)
        return (
            rational(value)
            if ratio is None or double(ratio) != value
            else fmpq(ratio.numerator, ratio.denominator)
        )

    def rounded(self) -> Problem:
        """The same with doubles for numbers that are given exactly; a warning says so."""
        for name, ratio in self.ratios.items():
            warn_rounded(name, [ratio])
        none = (0,) * len(self.roundings)
        return replace(self, ratios={}, roundings=none) if self.ratios else self

    @property
    def names(self) -> tuple[str, ...]:
        """Names that may be an axis."""
        return tuple(self.values)

    @property
    def may_drift(self) -> bool:
        """Whether zeros by structure are not proved to be semisimple at every member."""
        return not self.derived and not semisimple(self.family, structure(self.family).zeros)

    @property
    def derived(self) -> bool:
        """Whether an exact polynomial is proved for every member of the family."""
        return self.exact is not None and self.exact.derived

    def arrays(self, values: Mapping[str, Any]) -> tuple[Floats, Floats, Floats, tuple[int, ...]]:
        """Dimensionless rows for broadcast values.

        Returns
        -------
        a, q, rate, shape
            Family parameters (N, ·), parameters (N, ·), unit of rate (N,), and the broadcast shape.
        """
        shape = broadcast_shape(values)
        with np.errstate(all="ignore"):
            a, q, rate = self.reduce(values, np.sqrt)
        flat = [np.broadcast_to(v, shape).reshape(-1) for v in (*a, *q, rate)]
        count = math.prod(shape)
        columns = np.column_stack(flat).astype(float).reshape(count, -1)
        cut = len(a)
        if not (np.isfinite(columns).all() and (columns[:, -1] > 0).all()):
            raise ParameterError(
                "the dimensionless numbers overflow double precision; give values nearer to 1."
            )
        return columns[:, :cut], columns[:, cut:-1], columns[:, -1], shape

    def balls(self, values: Mapping[str, Any]) -> tuple[list[Any], list[Any]]:
        """Family parameters and parameters as balls around the exact numbers, or as series.

        Returns
        -------
        a, q
        """
        plain = {n: v for n, v in values.items() if not isinstance(v, (arb, arb_series))}
        exact = dict(values) | {n: arb(v) for n, v in self.rationals(plain).items()}
        a, q, _ = self.reduce(exact, lambda v: v.sqrt())
        return a, q


def broadcast_shape(values: Mapping[str, Any]) -> tuple[int, ...]:
    """The common shape of arrays.

    Returns
    -------
    tuple of int

    Raises
    ------
    ParameterError
        If they do not broadcast.
    """
    shapes = {n: np.shape(v) for n, v in values.items() if np.shape(v)}
    try:
        return np.broadcast_shapes(*shapes.values())
    except ValueError:
        listed = ", ".join(f"{n} {s}" for n, s in shapes.items())
        raise ParameterError(
            f"the arrays do not broadcast: their shapes are {listed}; make them fit."
        ) from None


def known_numbers(family: Family, values: Mapping[str, Any]) -> dict[str, float]:
    """The states that a family holds, and single numbers that a call gives, by name."""
    found = {n: v for n, v in family.fixed.items() if isinstance(v, float)}
    for name, value in values.items():
        with suppress(TypeError, ValueError, OverflowError):  # an array is no single number
            found[family.meaning(name)] = float(value)
    return found


def through_switches(subject: Subject) -> Subject:
    """A subject of which all members lie on switches of states, by the equations of one side.

    It is the same subject where the slopes are not proved the same on all sides.  What lies beyond
    the linearisation differs from side to side.
    """
    system = subject.family.system
    numbers = known_numbers(subject.family, {**subject.numbers, **subject.member})
    here = [pair for pair in switches_at(system, numbers) if pair[0] in system.states]
    if not here or not continuous(system, numbers):
        return subject
    sided = on_sides(system, dict(here), dict.fromkeys(here, 1))
    return replace(subject, family=replace(subject.family, system=sided))


def problem_of(subject: Subject) -> Problem:
    """The problem of a subject, whose member may be open where an axis takes it.

    Parameters
    ----------
    subject
        What the question is asked about.

    Returns
    -------
    Problem

    Examples
    --------
    >>> from stability.bodies.contact_laws import Viscous
    >>> disk = Disk(mass=1.0, radius=0.3, gravity=9.81)
    >>> problem_of(subject_of("rolling", at=5.0, disk=disk, contact=Viscous(0.2))).names
    ('at', 'k', 'mass', 'radius', 'gravity', 'mu')
    """
    family = subject.family
    if subject.disk is not None:
        assert subject.law
        return _of_disk(subject, subject.disk, subject.law)
    numbers = {**subject.numbers, **subject.member}
    ratios = {
        n: r for n, v in numbers.items() if type(v) is not float and (r := no_double(v)) is not None
    }
    return Problem(
        family,
        {n: double(ratios[n]) if n in ratios else checked(n, v) for n, v in numbers.items()},
        without_dimension(family.system.quantities, family.system.units),
        partial(_reduce, family),
        roundings=tuple(int(n in ratios) for n in (*family.at, *family.parameters)),
        exact=_compared(family),
        plain=True,
        ratios=ratios,
    )


def _of_disk(subject: Subject, disk: Disk, law: Contact) -> Problem:
    parts, leans = subject.family.at, subject.keys == LEAN
    return Problem(
        subject.family,
        {**subject.member, "k": disk.k, **{n: getattr(disk, n) for n in PHYSICAL}, **law.given},
        disk.dimensionless,
        partial(_reduce_disk, parts, ("at",) if leans else subject.keys, type(law)),
        _units,
        disk_roundings(parts, law, si=not disk.dimensionless, lean=leans),
        law,
        disk_polynomial(subject.family.name, type(law)),  # type: ignore[arg-type]  # a class is hashable
    )


def disk_problem(
    family: str,
    disk: Disk,
    contact: Contact,
    at: ArrayLike | None = None,
    lean: ArrayLike | None = None,
) -> Problem:
    """The problem of a disk's family, from its objects."""
    return problem_of(subject_of(family, at=at, lean=lean, disk=disk, contact=contact))


@lru_cache(maxsize=64)
def _compared(family: Family) -> ExactPolynomial | None:
    """The exact polynomial of a family, after a comparison with the equations of motion."""
    exact = family.exact
    if exact is None or exact.derived:
        return exact
    zeros, said = structure(family).zeros, ""
    if exact.zeros != zeros:
        said = f"leaves out {exact.zeros} zeros, and {zeros} eigenvalues vanish by structure"
    elif not certain(family):
        said = "is not taken, since structural zeros are not proved for every member"
    elif family.unknown and not family.closed:
        said = "is not taken, since its members are solved for and may be others than it means"
    elif any(getattr(type(exact), n) is not getattr(ExactPolynomial, n) for n in DERIVED):
        said = f"has {' or '.join(DERIVED)} without a proof; leave out all but coefficients in λ"
    if said:
        raise ParameterError(f"the exact polynomial of {family.name} {said}.")
    for number in range(SAMPLES + 2 ** min(MOST_SIGNS, len(family.at) + len(family.parameters))):
        _compare(family, number)
    return exact


@lru_cache(maxsize=64)
def formulas_of(family: Family) -> ClosedForm | None:
    """The formulas of a family; None where it has none, or they are not those of its graph.

    A graph whose numbers CasADi has rounded on the way may differ in its last digits.
    """
    formulas, cut = family.formulas, len(family.at)
    if formulas is None:
        return None
    for number in range(SAMPLES):
        with precision(SAMPLE_BITS):
            point = sampled(family, number)
            a, q = point[:cut], point[cut:]
            try:
                true = characteristic(family, a, q)
            except NoMemberError:
                continue
            coefficients, _, _ = formulas(balls(), a, q)
            monic = [arb(0)] * formulas.zeros + [c / coefficients[-1] for c in coefficients]
            same = [
                c.overlaps(t) and abs(c - t) < CLOSE * (1 + abs(t))
                for c, t in zip(monic, true, strict=False)
            ]
        if not all(same) or len(monic) != len(true):
            return None
    return formulas


def _compare(family: Family, number: int) -> None:
    """Refuse a polynomial that is not det(λ - A) at a sample; later samples take all signs."""
    names, cut = (*family.at, *family.parameters), len(family.at)
    flips = max(0, number - SAMPLES)
    with precision(SAMPLE_BITS):
        point = [-v if flips >> i & 1 else v for i, v in enumerate(sampled(family, number))]
        true = characteristic(family, point[:cut], point[cut:])
        if flips and not all(t.is_finite() for t in true):
            return
        coefficients = _monic(family, dict(zip(names, point, strict=True)))
        zeros = [arb(0)] * structure(family).zeros
        same = [
            c.overlaps(t) and abs(c - t) < CLOSE * (1 + abs(t))
            for c, t in zip(zeros + coefficients, true, strict=False)
        ]
    if not all(same) or len(zeros + coefficients) != len(true):
        power = same.index(False) if False in same else len(same)
        ours, theirs = (
            float(p[power]) if power < len(p) else 0.0 for p in (zeros + coefficients, true)
        )
        raise ParameterError(
            f"the exact polynomial of {family.name} is not that of its equations: at "
            f"{listing(names, [float(v) for v in point])} the coefficient of λ^{power} is "
            f"{ours:.6g}, that of det(λ - A) {theirs:.6g}."
        )


def _monic(family: Family, values: Mapping[str, Any]) -> list[Any]:
    """The monic polynomial without structural zeros, from a family's exact polynomial."""
    exact = family.exact
    assert exact is not None
    try:
        with suppress(NotExact):  # the doubles next to these numbers, over Q
            near = {n: rational(float(v)) for n, v in values.items()}
            for factor in exact.coefficients(near, EXACT):
                fmpq_poly(list(factor))
        return product(exact.coefficients(values, MIXED))
    except Exception as error:  # a user's code may raise anything
        raise ParameterError(
            f"the exact polynomial of {family.name} has no value in rational numbers and balls "
            f"({type(error).__name__}: {error}); write it with + - * /, whole numbers and "
            "algebra.functions."
        ) from None


def _reduce(
    family: Family,
    v: Mapping[str, Any],
    root: Callable[[Any], Any],  # noqa: ARG001
) -> tuple[list[Any], list[Any], Any]:
    missing = [n for n in (*family.at, *family.parameters) if n not in v]
    if missing:
        needs = "its value" if len(missing) == 1 else "their values"
        raise NameUnknownError(f"{absent(map(shown, missing))}; {family.name} needs {needs}.")
    return [v[k] for k in family.at], [v[n] for n in family.parameters], 1.0


def _reduce_disk(
    parts: Sequence[str],
    keys: Sequence[str],
    law: type[Contact],
    v: Mapping[str, Any],
    root: Callable[[Any], Any],
) -> tuple[list[Any], list[Any], Any]:
    time = root(v["radius"] / v["gravity"])
    if "lean" in v:
        # no double is π/2, so the right angle has the type of the lean
        upright = v["lean"].pi() / 2 if hasattr(v["lean"], "pi") else np.pi / 2
        v = dict(v) | {"at": upright - v["lean"]}
    a = [
        v[k] if QUANTITIES[p].kind is Kind.ANGLE else v[k] * time
        for k, p in zip(keys, parts, strict=True)
    ]
    # under the linear law mu means c = mu m g
    q = [v["k"], *law.arguments(v, _units(v, root)).values()]
    return a, q, 1 / time


def _units(v: Mapping[str, Any], root: Callable[[Any], Any] = np.sqrt) -> Units:
    return Units(v["mass"], v["radius"], v["gravity"], root)


def disk_roundings(
    parts: Sequence[str], contact: Contact, *, si: bool, lean: bool = False
) -> tuple[int, ...]:
    """Number of roundings in each dimensionless number: none for k and for a given angle."""
    some = 4 if si else 0
    angle = 2 if lean else 0
    turns = (angle if QUANTITIES[p].kind is Kind.ANGLE else some for p in parts)
    return (*turns, 0, *((some,) * len(contact.symbols())))
