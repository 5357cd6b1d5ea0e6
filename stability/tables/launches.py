"""Table of launches: the linear prediction next to the motion, and why the two differ."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from ..base.checks import checked, positive
from ..base.citation.used import cited
from ..base.errors import NameUnknownError, ParameterError, listed, shown
from ..base.quantities import Kind
from ..base.types import Floats
from ..base.verdict import Nonlinear, Verdict
from ..bodies.contact import Contact
from ..bodies.disk import Disk
from ..bodies.families import FAMILIES
from ..bodies.launch import TILT, TIME, disk_of, near_steady
from ..boundary.drift import drift
from ..motion.result import BY_CODE, Outcome
from ..motion.simulate import simulate
from ..spectra.spectrum import spectrum
from .conditions import MU, K, member
from .drift import law_of
from .formats.about import About, Standing
from .formats.column import Column, word
from .formats.plain import units_note
from .formats.table import Definition

VELOCITIES = tuple(float(v) for v in np.round(np.linspace(0.4, 4.8, 12), 6))
"""Initial angular velocities [√(g/R)]."""
SAMPLES = 501
"""Samples of a run, at which the least normal force is read."""
NOTES = (
    "Launch: a steady motion with its axis tilted from level, no slip and no other motion.",
    "linear: spectral verdict of the steady motion launched near; rate: its",
    "largest growth rate. final: the nearest steady motion at the end and its parameter (a tilde:",
    "near, not settled). energy: final over initial. normal_force: the least over m g.",
    "At the start gn = "
    + listed([f"{f.launch} for {f.name}" for f in FAMILIES.values() if f.launch]),
    "(s, c: sine and cosine of theta), positive for every angular velocity.",
)


@dataclass(frozen=True)
class LaunchRow:
    """One launch: its linear prediction and its outcome."""

    launch: str
    """Family of the steady motion that the launch starts near."""
    k: float
    """Inertia factor [-]."""
    mu: float
    """Friction coefficient in the user's unit."""
    at: float
    """Initial omega3 or phi_dot."""
    linear: str
    """Spectral verdict of the steady motion."""
    rate: float
    """Abscissa of the steady motion."""
    outcome: str
    """Outcome of the launch."""
    final: str
    """Family of the nearest steady motion at the end; a tilde marks a run that has not settled."""
    final_at: float
    """Parameter of that steady motion: omega3, phi_dot or theta."""
    time: float
    """Time from which the run has settled, otherwise time of its end."""
    energy: float
    """Final over initial energy [-]."""
    normal_force: float
    """Least normal force over m g, at the samples and the end."""
    why: str
    """Reason why prediction and outcome agree or differ."""


def contact_lines(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """For each launch, k and mu, the velocities from which the normal force reaches zero.

    Parameters
    ----------
    rows
        Rows of the table as records.

    Returns
    -------
    list of str

    Examples
    --------
    >>> row = {"launch": "rolling", "k": 0.25, "mu": 1.0, "at": 1.6, "outcome": "lift-off"}
    >>> contact_lines([row])
    ['rolling, k = 0.25, mu = 1: gn reaches zero from at = 1.6']
    """
    blocks: dict[tuple[Any, ...], list[Mapping[str, Any]]] = {}
    for row in rows:
        blocks.setdefault((row["launch"], row["k"], row["mu"]), []).append(row)
    lines = []
    for (name, k, mu), block in blocks.items():
        lost = [f"{row['at']:g}" for row in block if row["outcome"] == Outcome.LIFT_OFF.word]
        first, last = block[0]["at"], block[-1]["at"]
        what = (
            f"gn reaches zero from at = {', '.join(lost)}"
            if lost
            else f"gn > 0 throughout from every at, {first:g} to {last:g}"
        )
        lines.append(f"{name}, k = {k:g}, mu = {mu:g}: {what}")
    return lines


def _list(name: str, values: Any) -> list[float]:
    """Numbers along one axis, at least one."""
    found = np.asarray(checked(name, values), dtype=float)
    if found.ndim != 1:
        raise ParameterError(f"{name} has shape {found.shape}; give a list of numbers.")
    return [float(v) for v in found]


def launch_rows(
    *,
    launches: Sequence[str] | None = None,
    k: Sequence[float] = (0.25, 0.5),
    mu: Sequence[float] = (0.1, 0.3, 1.0, 3.0),
    at: Sequence[float] | None = None,
    tilt: float = TILT,
    time: float | None = None,
    disk: Disk | None = None,
    law: str = "viscous",
    progress: Callable[[int, int], None] | None = None,
) -> list[LaunchRow]:
    """The reference launches by initial angular velocity, for several bodies and frictions.

    Parameters
    ----------
    launches
        Families that the launches start near; rolling and spinning when left out.
    k, mu
        Inertia factors [-] and friction coefficients.
    at
        Initial angular velocities; 0.4 to 4.8 in units of √(g/R) when left out.
    tilt
        Tilt of the symmetry axis at the start [rad].
    time
        Length of a run; 1000 √(R/g) when left out.
    disk
        Gives mass, radius, gravity.
    law
        viscous or linear-viscous.
    progress
        Called with (blocks done, blocks in all).

    Returns
    -------
    list of LaunchRow

    Source: recomputed after Przybylska & Rauch-Wojciechowski 2016, Section 5.

    Examples
    --------
    >>> rows = launch_rows(launches=("spinning",), k=(0.25,), mu=(0.3,), at=(1.0, 2.4))
    >>> [(r.linear, r.outcome, r.final) for r in rows]
    [('unstable', 'settled', 'tumbling'), ('stable', 'settled', 'spinning')]
    """
    scale = disk_of(disk)
    if np.ndim(scale.rate) or np.ndim(scale.mass):
        raise ParameterError("disk holds arrays; the table takes one mass, radius and gravity.")
    launched = [name for name, family in FAMILIES.items() if family.launch]
    launches = launched if launches is None else launches
    if isinstance(launches, str) or not launches or not set(launches) <= set(launched):
        raise NameUnknownError(
            f"launches is {shown(launches)}; give a list of {', '.join(launched)}."
        )
    values = np.asarray(VELOCITIES) * float(scale.rate) if at is None else _list("at", at)
    last = TIME * float(scale.time) if time is None else positive("time", time)
    lean = checked("tilt", tilt)
    if not isinstance(lean, float) or not isinstance(last, float):
        raise ParameterError("tilt and time are single numbers in this table.")
    frictions = _list("mu", mu)
    blocks = [
        (n, inertia, value) for n in launches for inertia in _list("k", k) for value in frictions
    ]
    rows: list[LaunchRow] = []
    for done, (name, inertia, value) in enumerate(blocks, start=1):
        body = Disk(mass=scale.mass, radius=scale.radius, gravity=scale.gravity, k=inertia)
        rows += _block(name, body, law_of(law, value), value, np.asarray(values), lean, last)
        if progress is not None:
            progress(done, len(blocks))
    return rows


def _block(
    name: str, body: Disk, contact: Contact, mu: float, values: Floats, tilt: float, last: float
) -> list[LaunchRow]:
    """Rows of one body and friction, all velocities in one batch."""
    starts = near_steady(name, at=values, tilt=tilt, disk=body)
    runs = simulate(body, contact, starts, np.linspace(0.0, last, SAMPLES))
    linear = spectrum(name, at=values, disk=body, contact=contact, certify=True)
    rows = []
    for i, value in enumerate(values):
        run = runs.isel(launch=i)
        outcome = BY_CODE[int(run.outcome)]
        verdict, rate = linear.verdict[i], float(linear.abscissa[i])
        final = str(run.nearest_family.values)
        family = final if outcome is Outcome.SETTLED else f"~{final}"
        settled = outcome is Outcome.SETTLED
        why = _why(
            name,
            verdict,
            linear.nonlinear[i],
            rate,
            outcome,
            final,
            float(value),
            tilt,
            body,
            contact,
            float(run.end_time),
        )
        rows.append(
            LaunchRow(
                name,
                float(body.k),
                mu,
                float(value),
                verdict.word,
                rate,
                outcome.word,
                family,
                float(run.nearest_at),
                float(run.settled_time if settled else run.end_time),
                float(run.energy[-1] / run.energy[0]),
                float(run.normal_force.min()) / float(body.force),
                why,
            )
        )
    return rows


def _why(
    name: str,
    verdict: Verdict,
    nonlinear: Nonlinear,
    rate: float,
    outcome: Outcome,
    final: str,
    at: float,
    tilt: float,
    body: Disk,
    contact: Contact,
    end: float,
) -> str:
    """Reason in one sentence why linear prediction and outcome agree or differ."""
    stayed = final == name and outcome in (Outcome.SETTLED, Outcome.MOVING)
    if verdict is Verdict.UNSTABLE:
        if stayed and outcome is Outcome.MOVING and rate * end < 3:
            return "agrees so far: the growth is slower than the run is long"
        if stayed and outcome is Outcome.SETTLED:
            return f"agrees: it left, and came back to {name} where it is stable"
        if outcome is Outcome.SETTLED:
            return f"agrees: it leaves, and settles on {final}"
        return "agrees: it leaves" + (f", and ends in {outcome.word}" if not stayed else "")
    if verdict is not Verdict.STABLE:
        return "open: exactly on a boundary, where linear theory is silent"
    if nonlinear is Nonlinear.DRIFTS:
        try:
            crossing = float(drift(at=at, tilt=tilt, disk=body, contact=contact).time)
        except ParameterError:  # the tilt would reach flat on the way
            return "differs: the tilt is too large for the slow drift that linear theory leaves"
        if crossing > end:
            if stayed:
                return f"agrees: it drifts, and would cross its threshold at {crossing:.3g}"
            return "differs: the tilt is too large for the slow drift that linear theory leaves"
        if stayed:
            return f"differs: it has drifted through its threshold at about {crossing:.3g}"
        return f"differs: it drifts through its threshold at about {crossing:.3g}, then leaves"
    if stayed:
        return "agrees" if outcome is Outcome.SETTLED else "agrees so far: it has not settled yet"
    return "differs: the tilt is beyond the reach of the stable motion"


_LAUNCHED = listed([f.name for f in FAMILIES.values() if f.launch])
TABLE = Definition(
    f"what becomes of {_LAUNCHED} launched with a tilt, compared with linear theory",
    (
        word("launch", "family of the steady motion launched near", "group"),
        replace(K, place="group"),
        replace(MU, place="group"),
        Column("at", "omega3 or phi_dot at the start", Kind.ANGULAR_VELOCITY, form="{:.6g}"),
        word("linear", "spectral verdict of the steady motion"),
        Column("rate", "its largest growth rate", Kind.GROWTH_RATE, r"\alpha", "{:+.3g}"),
        word("outcome", "outcome of the launch"),
        word("final", "nearest steady motion at the end; a tilde: near, not settled"),
        Column("final_at", "member of that family", member, "", "{:.6g}", "final"),
        Column(
            "time", "time from which it has settled, otherwise of the end", Kind.TIME, "T", "{:.4g}"
        ),
        Column("energy", "final over initial energy", latex="E/E_{0}", form="{:.4f}"),
        Column("normal_force", "least normal force over m g", latex="N/mg", form="{:.3f}"),
        word("why", "reason why prediction and outcome agree or differ", "below"),
    ),
    lambda **options: [asdict(row) for row in launch_rows(**options)],
    ("k", "mu", "contact", "disk", "tilt", "at", "time", "progress"),
    lambda table: [*contact_lines(table.rows), "", *NOTES, units_note(table)],
    about=About(
        "Przybylska & Rauch-Wojciechowski, Regul. Chaotic Dyn. 21 (2016) 204-231",
        "no value of its simulations",
        "outcomes of simulated motions with stated errors",
        Standing.RECOMPUTED,
    ),
    cites=cited(model=True, eigenvalues=True),
    home=f"{__name__}:TABLE",
)
"""The table for the registry."""
