"""Table of a disk that rolls in a circle without slip: Le Saux, Leine & Glocker's relations."""

from __future__ import annotations

import math
from dataclasses import asdict
from decimal import Decimal
from functools import partial

import numpy as np
from flint import arb

from ...algebra.balls import precision
from ...base.citation.used import cited
from ...base.types import Floats, Progress
from ...base.verdict import Verdict
from ...bodies.contact_laws import Rough
from ...bodies.disk import Disk
from ...bodies.thin_disk import disk_family
from ...boundary.changes import boundaries
from ...motion.simulate import simulate
from ...spectra.spectrum import spectrum
from ..benchmarks.catalogue import COLUMNS, benchmark_lines, benchmark_notes
from ..benchmarks.row import (
    CLOSED,
    SIDE,
    BenchmarkRow,
    Source,
    Threshold,
    at_threshold,
    compared,
)
from ..formats.about import About, Standing
from ..formats.plain import framed
from ..formats.table import Definition
from .rough_circles import BITS, circle, degrees, digits, edges

RELATION = Source(
    "circle without slip",
    "Le Saux, Leine & Glocker, J. Nonlinear Sci. 15 (2005), eq. (5.10)-(5.12)",
)
BALANCE = Source("nutation in a circle", "balance of moments about the contact point")
DISK = Disk(mass=0.3048, radius=0.05, gravity=9.81)
"""The paper's radius and gravity; its mass does not matter here."""
K = float(DISK.k)
"""Its inertia factor [-]."""
EXAMPLE = (5, "0.1")
"""Lean [°] and radius over the circle's, of the paper's example."""
CIRCLES = (EXAMPLE, (20, "0.1"), (20, "0.5"), (45, "0.5"), (60, "1"))
"""Leans and ratios of the rows."""
LEANS = (5, 10, 15)
"""Leans [°] at which the unstable precessions are compared."""


def circular_rows(progress: Progress | None = None) -> list[BenchmarkRow]:
    """Spin, precession and nutation in circles, and the precessions that are unstable.

    Parameters
    ----------
    progress
        Called with (parts done, parts in all).

    Returns
    -------
    list of BenchmarkRow

    Source: tests/tables/test_literature.py.

    Examples
    --------
    >>> rows = circular_rows()
    >>> rows[0].quantity, rows[0].known, rows[0].origin
    ('relative spin, lean 5°, r/Rc = 0.1', '10.7364981632612', 'closed form')
    """
    parts = [
        *(partial(_circle, *c) for c in CIRCLES),
        *(partial(edge_rows, DISK, b, BALANCE) for b in LEANS),
    ]
    rows: list[BenchmarkRow] = []
    for done, part in enumerate(parts, start=1):
        rows += part()
        if progress is not None:
            progress(done, len(parts))
    return sorted(rows, key=lambda row: row.system)


def _circle(lean: int, ratio: str) -> list[BenchmarkRow]:
    """Rows of one circle: its spin by the paper's relation, and its nutation or growth."""
    with precision(BITS):
        known = circle(K, degrees(lean), arb(ratio))
        rate = (arb(DISK.gravity) / arb(DISK.radius)).sqrt()
        spin, nodding = digits(known.spin * rate), digits(abs(known.nodding).sqrt() * rate)
        turn = float(known.precession)
    theta = math.pi / 2 - math.radians(lean)
    rolling = disk_family("circling", "rough").member([theta, turn], [K])
    relative = abs(rolling[3] - turn * math.cos(theta)) * DISK.rate
    at = (theta, turn * float(DISK.rate))
    found = spectrum("circling", at=at, disk=DISK, contact=Rough(), certify=True)
    where = f"lean {lean}°, r/Rc = {ratio}"
    verdict = found.verdict.word if found.certified else Verdict.UNDECIDED.word
    rate_of = "growth rate" if known.nodding < 0 else "frequency of nutation"
    rows = [
        compared(
            RELATION, f"relative spin, {where}", spin, float(relative), origin=CLOSED, unit="rad/s"
        ),
        compared(
            BALANCE,
            f"{rate_of} ({verdict}, certified), {where}",
            nodding,
            float(abs(found.eigenvalues).max()),
            origin=CLOSED,
            unit="1/s",
        ),
    ]
    return rows + ([_path(at, rolling, ratio)] if (lean, ratio) == EXAMPLE else [])


def _path(at: tuple[float, float], rolling: Floats, ratio: str) -> BenchmarkRow:
    """The circle of the contact point, from a simulated turn."""
    start = {"theta": at[0], "phi_dot": at[1], "omega3": rolling[3] * DISK.rate}
    run = simulate(DISK, Rough(), start, np.linspace(0, 2 * math.pi / at[1], 5), pose=True)
    x, y = run.contact_x.values[:4], run.contact_y.values[:4]  # a quarter of a turn apart
    found = float(np.hypot(x[2] - x[0], y[2] - y[0]) / 2)
    radius = str(Decimal(str(DISK.radius)) / Decimal(ratio))
    return compared(
        RELATION,
        "radius of the contact point's circle, from a simulated turn",
        radius,
        found,
        origin=CLOSED,
        unit="m",
    )


def edge_rows(disk: Disk, lean: int, about: Source) -> list[BenchmarkRow]:
    """Rows of the precessions at which the verdict on a rough disk changes.

    Parameters
    ----------
    disk
        The disk.
    lean
        Lean [°].
    about
        System and source of the rows.

    Returns
    -------
    list of BenchmarkRow
    """
    with precision(BITS):
        rate = (arb(disk.gravity) / arb(disk.radius)).sqrt()
        both = edges(float(disk.k), degrees(lean))
        known = [digits(edge * rate) for edge in both]
        ends = [float(edge) * float(rate) for edge in both]
    theta = math.pi / 2 - math.radians(lean)
    axis = ("phi_dot", ends[0] / 2, 2 * ends[1], 9)
    found = boundaries("circling", axis=axis, at=theta, disk=disk, contact=Rough())
    rows = []
    for word, value, point in zip(("lower", "upper"), known, found, strict=True):
        sides = [_verdict(disk, theta, point.value * (1 + side)) for side in (-SIDE, SIDE)]
        change = Threshold(point.value, point.frequency, (sides[0], sides[1]), "")
        quantity = f"{word} end of the precessions that are unstable, lean {lean}°"
        rows.append(
            at_threshold(about, change, value, origin=CLOSED, unit="rad/s", quantity=quantity)
        )
    return rows


def _verdict(disk: Disk, theta: float, precession: float) -> str:
    found = spectrum("circling", at=(theta, precession), disk=disk, contact=Rough(), certify=True)
    return str((found.verdict if found.certified else Verdict.UNDECIDED).word)


TABLE = Definition(
    "a disk that rolls in a circle without slip: spin, nutation, and unstable precessions",
    COLUMNS,
    lambda **options: [asdict(row) for row in circular_rows(**options)],
    ("progress",),
    lambda table: benchmark_notes(table.rows),
    lambda table: framed(table, benchmark_lines(table.rows)),
    about=About(
        "Le Saux, Leine & Glocker, J. Nonlinear Sci. 15 (2005) 27-61",
        "the relations (5.10)-(5.12) and the numbers put into them; no printed result",
        "members and spectra of the rough disk, a simulated turn, and boundaries with certified "
        "verdicts; known values by the relations and the balance of moments, in balls",
        Standing.RECOMPUTED,
        largest=2e-10,
    ),
    cites=cited("coulomb", eigenvalues=True, proofs=True),
    home=f"{__name__}:TABLE",
)
"""The table for the registry."""
