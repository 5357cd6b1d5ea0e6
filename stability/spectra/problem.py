"""A family with values: its possible axes, units, and dimensionless numbers.

All computations are dimensionless.  Only a `Problem` knows how a user's numbers (`at`, `k`, `mu`,
`mass`, `radius`, `gravity`, or the parameters of a user's system) become the family's parameters.
A `Problem` converts any number type, so that balls start from the exact doubles.

`disk_problem` makes one about a family of the disk: its units, exact data and roundings.
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
from flint import arb, fmpq, fmpq_poly
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
    if_degrees,
    listing,
    shown,
)
from ..base.exact_numbers import double, no_double, warn_rounded
from ..base.quantities import Units, without_dimension
from ..base.types import Floats
from ..bodies.contact_laws import LAWS, Contact, spelled
from ..bodies.disk import Disk
from ..bodies.disk_polynomials import disk_polynomial, stored
from ..bodies.families import FAMILIES, leaning
from ..bodies.quantities import PHYSICAL, is_angle
from ..bodies.thin_disk import disk_family
from ..systems.closed_form import ClosedForm
from ..systems.family import Family
from ..systems.structure.enclosure import characteristic
from ..systems.structure.identities import certain
from ..systems.structure.structural_zeros import SAMPLE_BITS, SAMPLES, sampled, structure
from ..systems.structure.zero_blocks import semisimple

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
        """Family parameters and parameters as balls around the exact numbers.

        Returns
        -------
        a, q
        """
        plain = {n: v for n, v in values.items() if not isinstance(v, arb)}
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


def system_problem(
    family: Family, at: ArrayLike | None, parameters: Mapping[str, ArrayLike]
) -> Problem:
    """The problem of a family of a user's system; numbers are not converted.

    Parameters
    ----------
    family
        The family.
    at
        Family parameter (last axis its parts, if there are several), or None where it varies.
    parameters
        The system's other parameters by name.

    Returns
    -------
    Problem

    Raises
    ------
    NameUnknownError
        If a parameter is missing or unknown.
    """
    for name in parameters:
        if at is not None and name in family.at:
            raise ParameterError(f"{name} is given as at and by name; give it once.")
        if name not in (*family.parameters, *family.at):
            raise NameUnknownError(
                f"{shown(name)} is not a parameter of {family.name}; known are "
                f"{', '.join((*family.parameters, *family.at)) or 'none'}."
            )
    if at is not None and not family.at:
        raise ParameterError(f"{family.name} has one member alone; leave at out.")
    keys = family.at
    several = isinstance(at, (tuple, list)) and len(at) == len(keys) > 1
    parts: list[Any] = list(at) if several else [at]  # type: ignore[arg-type]
    own = dict(zip(keys, parts, strict=False)) if len(parts) == len(keys) else {}
    ratios = {
        n: r for n, v in (*parameters.items(), *own.items()) if (r := no_double(v)) is not None
    }
    values: dict[str, Any] = {
        n: double(ratios[n]) if n in ratios else checked(n, v) for n, v in parameters.items()
    }
    if at is not None:
        if own and ratios.keys() & own.keys():
            parts = [double(ratios[n]) if n in ratios else v for n, v in own.items()]
            at = parts if several else parts[0]
        given = np.asarray(checked("at", at), dtype=float)
        if len(keys) > 1 and (given.ndim == 0 or given.shape[-1] != len(keys)):
            raise ParameterError(
                f"at has shape {given.shape}; for {family.name} its last axis must hold "
                f"{len(keys)} values ({', '.join(keys)})."
            )
        columns = [given] if len(keys) == 1 else list(np.moveaxis(given, -1, 0))
        values |= {key: _scalar(c) for key, c in zip(keys, columns, strict=True)}

    roundings = tuple(int(n in ratios) for n in (*family.at, *family.parameters))
    reduce = partial(_reduce, family)
    return Problem(
        family,
        values,
        without_dimension(family.system.quantities, family.system.units),
        reduce,
        roundings=roundings,
        exact=_compared(family),
        plain=True,
        ratios=ratios,
    )


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
            given, _, _ = formulas(balls(), a, q)
            monic = [arb(0)] * formulas.zeros + [c / given[-1] for c in given]
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
        given = _monic(family, dict(zip(names, point, strict=True)))
        zeros = [arb(0)] * structure(family).zeros
        same = [
            c.overlaps(t) and abs(c - t) < CLOSE * (1 + abs(t))
            for c, t in zip(zeros + given, true, strict=False)
        ]
    if not all(same) or len(zeros + given) != len(true):
        power = same.index(False) if False in same else len(same)
        ours, theirs = (float(p[power]) if power < len(p) else 0.0 for p in (zeros + given, true))
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


def _scalar(value: Any) -> Any:
    return float(value) if np.ndim(value) == 0 else value


def disk_problem(
    family: str,
    disk: Disk,
    contact: Contact,
    at: ArrayLike | None = None,
    lean: ArrayLike | None = None,
) -> Problem:
    """The problem of one of the disk's families.

    Parameters
    ----------
    family
        A key of `FAMILIES`.
    disk, contact
        The body and the law; their fields may be arrays.
    at
        Family parameter; several numbers that name a member lie along the last axis.  None where
        the parameter is an axis.
    lean
        Angle π/2 - theta [rad] instead of `at`, where theta alone names a member; 0 is exactly
        upright.

    Returns
    -------
    Problem

    Raises
    ------
    StabilityError
        If the family, the law or a number is not accepted.

    Examples
    --------
    >>> from stability.bodies.contact_laws import Viscous
    >>> disk_problem("rolling", Disk(radius=0.3, gravity=9.81), Viscous(0.2), 5.0).names
    ('at', 'k', 'mass', 'radius', 'gravity', 'mu')
    """
    if not isinstance(family, str):
        raise NameUnknownError(f"family is {shown(family)}; give a name or a stability.Family.")
    if not isinstance(contact, Contact) or not contact.name:
        raise NameUnknownError(f"contact is {shown(contact)}; give one of {spelled(LAWS)}.")
    law = type(contact)
    if not law.linearises:
        raise NameUnknownError(
            f"contact is {shown(contact)}, dry friction, which has no linearisation of its own; "
            "inside the friction cone it is Rough()."
        )
    if not isinstance(disk, Disk):
        raise ParameterError(f"disk is {shown(disk)}; give a stability.Disk.")
    resolved = disk_family(family, law)
    parts = resolved.at
    keys = ("at",) if len(parts) == 1 else parts
    values: dict[str, Any] = {}
    if at is not None:
        given = np.asarray(checked("at", at), dtype=float)
        if len(keys) > 1 and (given.ndim == 0 or given.shape[-1] != len(keys)):
            raise ParameterError(
                f"at has shape {given.shape}; for {family} it is the pair ({', '.join(keys)}) "
                "along the last axis."
            )
        columns = [given] if len(keys) == 1 else list(np.moveaxis(given, -1, 0))
        values |= {key: _scalar(c) for key, c in zip(keys, columns, strict=True)}
        for part, column in zip(parts, columns, strict=True):
            _check_theta(family, part, column)
    if lean is not None:
        values |= {"lean": checked_lean(family, at, lean)}
    values |= {"k": disk.k} | {n: getattr(disk, n) for n in PHYSICAL}
    values |= contact.given

    return Problem(
        resolved,
        values,
        disk.dimensionless,
        partial(_reduce_disk, parts, keys, law),
        _units,
        disk_roundings(parts, contact, si=not disk.dimensionless, lean=lean is not None),
        contact,
        disk_polynomial(family, law.name) if stored(law) else None,
    )


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
    a = [v[k] if is_angle(p) else v[k] * time for k, p in zip(keys, parts, strict=True)]
    # under the linear law mu means c = mu m g
    q = [v["k"], *law.arguments(v, _units(v, root)).values()]
    return a, q, 1 / time


def _units(v: Mapping[str, Any], root: Callable[[Any], Any] = np.sqrt) -> Units:
    return Units(v["mass"], v["radius"], v["gravity"], root)


def checked_lean(family: str, at: ArrayLike | None, lean: ArrayLike) -> Any:
    """The lean as finite numbers strictly between -π/2 and π/2, or a refusal."""
    if not FAMILIES[family].by_angle:
        raise ParameterError(f"lean names a member of {leaning()}; for {family} give at.")
    if at is not None:
        raise ParameterError("at and lean are both given; give one of them.")
    value = checked("lean", lean)
    bad = np.asarray(value)[np.abs(value) >= np.pi / 2]
    if bad.size:
        worst = float(bad.flat[np.abs(bad).argmax()])
        raise ParameterError(
            f"lean is {worst:g}; it must lie strictly between -π/2 and π/2, 0 is upright"
            f"{if_degrees(worst)}."
        )
    return value


def disk_roundings(
    parts: Sequence[str], contact: Contact, *, si: bool, lean: bool = False
) -> tuple[int, ...]:
    """Number of roundings in each dimensionless number: none for k and for a given angle."""
    some = 4 if si else 0
    angle = 2 if lean else 0
    turns = (angle if is_angle(p) else some for p in parts)
    return (*turns, 0, *((some,) * len(contact.symbols())))


def _check_theta(family: str, part: str, values: Any) -> None:
    """Refuse an inclination at which the disk is flat; a guess at degrees says so."""
    if part != "theta":
        return
    bad = values[(values <= 0) | (values >= math.pi)]
    if bad.size:
        worst = float(bad.flat[np.abs(bad).argmax()])
        raise NoMemberError(
            f"{family} does not exist there: theta is {worst:g}; theta must lie strictly "
            "between 0 and π, because the disk is flat at both and its equations of motion end "
            f"there{if_degrees(worst)}."
        )


def check_axis(problem: Problem, name: str, values: Floats) -> None:
    """Refuse an axis with values that the body or the law does not accept."""
    if problem.law is None:
        return
    part = problem.family.at[0] if name == "at" else name
    _check_theta(problem.family.name, part, values)
    if name == "lean":
        checked_lean(problem.family.name, None, values)
    if problem.law.alternatives(name):
        problem.law.accepted(name, values)
    elif name in ("k", *PHYSICAL):
        Disk(**{name: values})
