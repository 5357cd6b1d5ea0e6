"""Table of thresholds of As's disk: where rolling, spinning and circling change verdict."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

from flint import arb

from ..algebra.number_types import precision
from ..base.citation import cited
from ..base.types import Progress
from ..base.verdict import Verdict
from ..bodies.contact_laws import Rough
from ..bodies.disk import Disk
from ..bodies.subject import disk_family
from ..boundary.changes import boundaries
from ..spectra.spectrum import spectrum
from .benchmarks.row import (
    QUOTED,
    SIDE,
    BenchmarkRow,
    Source,
    Threshold,
    at_threshold,
    compared,
    of_known_values,
    rows_of,
    threshold,
)
from .table import About, Standing

BITS = 200
"""Working precision of the closed forms."""
SHOWN = 15
"""Significant digits of a known value."""
REPORT = "Y. As, student report, Technion 2017"
LINEAR = "linearised balance of moments; the report's value was not at hand"
DISK = Disk(mass=1.0, radius=0.5, gravity=9.81)
"""The report's disk: uniform, k = 1/4 [m, m/s²]."""
LEAN, PRECESSION = 10, 0.5
"""Lean [°] and precession [rad/s] of the report's circling disk."""
SPIN = "-4.6851"
"""Its spin relative to the turning frame, quoted from the report at second hand [rad/s]."""

FORMULAS: tuple[tuple[str, str, str, Callable[[arb], arb]], ...] = (
    ("rolling", "rough", "g/(2(2k+1)R)", lambda k: 1 / (2 * (2 * k + 1))),
    ("rolling", "smooth", "g/(4kR)", lambda k: 1 / (4 * k)),
    ("rolling", "viscous", "g/(2kR)", lambda k: 1 / (2 * k)),
    ("spinning", "rough", "g/((k+1)R)", lambda k: 1 / (k + 1)),
    ("spinning", "smooth", "g/(kR)", lambda k: 1 / k),
)
"""Family, law, and square of the threshold, as text and without dimension."""
MU = 1.0
"""Friction of the viscous disk, without dimension; the threshold does not depend on it."""


def threshold_rows(progress: Progress | None = None) -> list[BenchmarkRow]:
    """Thresholds of the disk under three contact laws, and its spin at the report's lean.

    Source: tests/tables/test_literature.py.

    Examples
    --------
    >>> first = threshold_rows()[0]
    >>> first.known, round(first.recomputed, 4), first.origin
    ('-4.6851', -4.6851, 'quoted at second hand')
    """
    changes = (partial(_change, *formula) for formula in FORMULAS)
    return rows_of([_relative_spin, *changes, _circling], progress)


def _relative_spin() -> list[BenchmarkRow]:
    theta = math.pi / 2 - math.radians(LEAN)
    at = [theta, PRECESSION * float(DISK.time)]
    state = disk_family("circling", "rough").member(at, [float(DISK.k)])
    spin = state[3] * DISK.rate - PRECESSION * math.cos(theta)
    what = f"relative spin, no slip, lean {LEAN}°, precession {PRECESSION} rad/s"
    about = Source("disk of 0.5 m, no slip", REPORT, QUOTED)
    return [compared(about, what, SPIN, float(spin), unit="rad/s")]


def _change(
    family: str, law: str, formula: str, square: Callable[[arb], arb]
) -> list[BenchmarkRow]:
    with precision(BITS):
        rate = (arb(DISK.gravity) / arb(DISK.radius)).sqrt()
        reference = _digits(square(arb(DISK.k)).sqrt() * rate)
        near = float(square(arb(DISK.k)).sqrt())
    values: dict[str, Any] = {"k": float(DISK.k)} | ({"mu": MU} if law == "viscous" else {})
    change = threshold(disk_family(family, law), near / 2, 2 * near, **values)
    quantity = {"rolling": "omega3", "spinning": "phi_dot"}[family]
    about = Source(f"{family} of the disk of 0.5 m", LINEAR)
    what = f"{quantity} of {family}, {law}: the root of {formula}"
    return [at_threshold(about, what, reference, change, unit="rad/s", scale=float(DISK.rate))]


def _circling() -> list[BenchmarkRow]:
    """Rows of the precessions between which the rough disk is unstable at the report's lean."""
    with precision(BITS):
        rate = (arb(DISK.gravity) / arb(DISK.radius)).sqrt()
        both = edges(float(DISK.k), arb(LEAN) * arb.pi() / 180)
        references = [_digits(edge * rate) for edge in both]
        ends = [float(edge) * float(rate) for edge in both]
    theta = math.pi / 2 - math.radians(LEAN)
    axis = ("phi_dot", ends[0] / 2, 2 * ends[1], 9)
    changes = boundaries("circling", axis=axis, at=theta, disk=DISK, contact=Rough())
    about = Source("circling of the disk of 0.5 m, no slip", LINEAR)
    rows = []
    for word, value, point in zip(("lower", "upper"), references, changes, strict=True):
        sides = [_verdict(theta, point.value * (1 + side)) for side in (-SIDE, SIDE)]
        change = Threshold(point.value, point.frequency, (sides[0], sides[1]), "")
        quantity = f"{word} end of the precessions that are unstable, lean {LEAN}°"
        rows.append(at_threshold(about, quantity, value, change, unit="rad/s"))
    return rows


def _verdict(theta: float, precession: float) -> str:
    result = spectrum("circling", at=(theta, precession), disk=DISK, contact=Rough(), certify=True)
    return str((result.verdict if result.certified else Verdict.UNDECIDED).word)


def edges(k: float, lean: arb) -> tuple[arb, arb]:
    """The precessions between which rolling in a circle is unstable: zeros of the nutation.

    With s, c = cos b, sin b and z the square of the precession, the balance of moments
    (k + 1) theta'' = k phi'^2 s c - (2k + 1) phi' omega3 s - c, with
    phi'' = 2 (omega3 - phi' c) theta'/s and (2k + 1) omega3' = s phi' theta', has at a circle
    (k + 1) w^2 = (k + 1) z s^2 - 1/s + 2 c^2 (1 + k z s)(1 + (k + 1) z s) / ((2k + 1) s^2 z).

    Parameters
    ----------
    k
        Inertia factor [-].
    lean
        Angle b between the disk and the vertical [rad].

    Returns
    -------
    tuple of arb
        The lower and the upper one [√(g/R)]; not finite where every precession is neutral.

    Examples
    --------
    >>> [round(float(edge), 12) for edge in edges(0.25, arb("0.1"))]
    [0.117770189136, 0.882831191459]
    """
    i, s, c = arb(k), lean.cos(), lean.sin()
    quadratic = (i + 1) * s**2 * ((2 * i + 1) * s**2 + 2 * i * c**2)
    linear, constant = (2 * i + 1) * s * (2 * c**2 - 1), 2 * c**2
    root = (linear**2 - 4 * quadratic * constant).sqrt()
    lower, upper = (-linear - root) / (2 * quadratic), (-linear + root) / (2 * quadratic)
    return lower.sqrt(), upper.sqrt()


def _digits(value: arb) -> str:
    """A ball as a decimal with `SHOWN` digits, all of them right."""
    return str(value.str(SHOWN, radius=False))


TABLE = of_known_values(
    "thresholds of a disk of 0.5 m, by contact law",
    threshold_rows,
    about=About(
        REPORT,
        "nothing; the disk and one spin are quoted at second hand",
        "thresholds as proved changes of the certified verdict; known values by closed forms, in "
        "balls",
        Standing.RECOMPUTED,
        largest=8e-6,
    ),
    cites=cited(eigenvalues=True, proofs=True, theory=["as2017"]),
    home=f"{__name__}:TABLE",
)
"""The table for the registry."""
