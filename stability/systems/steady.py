"""A family of steady motions from the equations alone: unknowns, equations, a first member."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np

from ..algebra.upright import Upright
from ..base.checks import known, one_number
from ..base.errors import (
    NameUnknownError,
    NoMemberError,
    ParameterError,
    StabilityError,
    listed,
    listing,
    shown,
)
from ..base.types import Floats
from .equations import Equations
from .family import Family
from .graph.ignorable import acting_on, ignorable
from .members import Anchor, accepted, newton_step, roots
from .system_checks import mapping, names

STARTS = 64
"""Number of first guesses about the given one."""
SPREADS = (0.1, 1.0, 10.0)
"""Distances of the first guesses, relative to 1 or to the number."""
MORE = 256
"""Number of further first guesses where none of these leads to a member."""
SIZES = (-6, 9)
"""Powers of ten between which their sizes lie, as those of quantities in SI units do."""
STEPS = 60
"""Most damped Newton steps from one guess."""
POINTS = 5
"""Points at which ranks are looked at."""
SAME = 1e-9
"""Relative size below which a singular value counts as zero where equations are chosen."""


def steady(
    system: Equations,
    at: Sequence[str] | str,
    *,
    held: Mapping[str, float | Upright] | None,
    unknown: Sequence[str] | str,
    guess: Mapping[str, float] | None,
    equations: Sequence[str] | None,
    positive: Sequence[str],
    name: str | None,
    **options: Any,
) -> Family:
    """The family through the steady motion nearest to a guess; see `System.steady`.

    Parameters
    ----------
    system
        The equations of motion.
    at, held, unknown, guess, equations, positive, name
        As in `System.steady`.
    **options
        Values of parameters at the guess, and `typical`, `conservative`, `integrals`, `drifts`
        of `Family`.
    """
    guessed = mapping("guess", guess or {})
    of_family = {
        n: options.pop(n)
        for n in ("typical", "conservative", "integrals", "drifts")
        if n in options
    }
    twice = [n for n in options if n in guessed]
    if twice:
        raise ParameterError(f"{shown(twice[0])} is given in guess and by name; give it once.")
    guessed |= options
    for what in guessed:
        if what not in (*system.states, *system.parameters):
            raise NameUnknownError(
                f"guess names {shown(what)}; known are "
                f"{', '.join((*system.states, *system.parameters))}."
            )
    guessed = {n: one_number(f"guess {n}", v) for n, v in guessed.items()}
    where = (at,) if isinstance(at, str) else names("at", at)
    fixed: dict[str, Any] = mapping("held", held or {})
    for what in fixed:
        system.index(what)
    moving = moving_states(system, {*fixed, *where, *(equations or ())})
    trimmed = (unknown,) if isinstance(unknown, str) else names("unknown", unknown)
    for what in trimmed:
        known("unknown", what, system.parameters)
    sought = [n for n in system.states if n not in fixed and n not in where]
    solved = names("equations", equations) if equations is not None else None
    for what in [n for n in sought if n in moving or (n not in guessed and _ignorable(system, n))]:
        sought.remove(what)
    if solved is None:
        for what in _resting(system, fixed, sought, guessed):
            fixed[what] = 0.0
            sought.remove(what)
        every = [*sought, *trimmed]
        try:
            solved = independent_rates(system, fixed, every, guessed, moving)
        except ParameterError:  # an ignorable state that rests decides what the others leave open
            if not moving:
                raise
            solved, moving = independent_rates(system, fixed, every, guessed, ()), ()
    for what in system.states:
        if what not in (*fixed, *where, *sought, *moving):
            fixed[what] = 0.0  # no rate depends on it, so any value is as good
    missing = [n for n in (*where, *system.parameters) if n not in guessed]
    sought += trimmed
    if missing and sought:
        raise ParameterError(
            f"the guess needs a value of {listed(list(dict.fromkeys(missing)))}; name it in guess, "
            "so that the first member is found there."
        )
    first = {n: guessed.get(n, 0.0) for n in sought}
    typical = {n: guessed[n] or 1.0 for n in (*where, *system.parameters) if n in guessed}
    typical = {n: v for n, v in typical.items() if n not in trimmed}
    of_family.setdefault("typical", typical)
    family = Family(
        system,
        name or f"steady {system.name}",
        where,
        held=fixed,
        unknown=first,
        equations=solved,
        positive=tuple(positive),
        **of_family,
    )
    if not sought or (family.closed and _exists(family, guessed)):
        return family
    if family.closed:  # CasADi folds ∞ - ∞ to 0, and other rates need not vanish
        moved = {n: v + 1 + i / 8 for i, (n, v) in enumerate(first.items())}
        family = replace(family, unknown=moved)
    return _anchored(family, guessed)


def _exists(family: Family, guessed: Mapping[str, float]) -> bool:
    """Whether the first guess is a member at the given numbers."""
    a, q = ([[guessed[n] for n in names]] for names in (family.at, family.parameters))
    try:
        family.member(a, q)
    except StabilityError:
        return False
    return True


def moving_states(system: Equations, named: Collection[str]) -> tuple[str, ...]:
    """Ignorable states that need not rest: those that act on none that is named."""
    out = [n for n in ignorable(system) if n not in named]
    while acting := [n for n in out if acting_on(system, n, [s for s in named if s not in out])]:
        out = [n for n in out if n not in acting]
        named = {*named, *acting}
    return tuple(out)


def _ignorable(system: Equations, state: str) -> bool:
    """Whether no rate and no condition depends on a state."""
    symbol = system.x[system.index(state)]
    values = ca.vertcat(system.rhs, *[c.value for c in system.conditions])
    return not ca.depends_on(values, symbol)


# --- the equations ---


def independent_rates(
    system: Equations,
    held: Mapping[str, Any],
    unknown: Sequence[str],
    guessed: Mapping[str, float],
    moving: Collection[str],
) -> tuple[str, ...]:
    """What is to vanish: independent residuals and rates, as many as there are unknowns."""
    if not unknown:
        return ()
    resting = [n for n in system.states if n not in moving]
    rates = {n: v for n, v in rates_by_name(system).items() if n not in moving}
    values = _with_held(system, held, ca.vertcat(*rates.values()))
    symbols = dict(
        zip(
            (*system.states, *system.parameters),
            ca.vertsplit(ca.vertcat(system.x, system.p)),
            strict=True,
        )
    )
    sought = ca.vertcat(*[symbols[n] for n in unknown])
    rows = [
        n
        for i, n in enumerate(rates)
        if not values[i].is_zero() and ca.depends_on(values[i], sought)
    ]
    # a rate of an ignorable state comes last: where others suffice, it is checked but not solved
    rows.sort(key=lambda n: n in resting and _ignorable(system, n))
    table = dict(zip(rates, ca.vertsplit(values), strict=True))
    slopes = ca.jacobian(ca.vertcat(*[table[n] for n in rows]), sought) if rows else ca.SX(0, 0)
    chosen = _independent(_sampled(system, slopes, guessed)) if rows else []
    if len(chosen) < len(unknown):
        open_ = [n for i, n in enumerate(unknown) if not rows or not slopes[:, i].nnz()]
        which = (
            f"{listed(open_)} open"
            if open_
            else f"{len(unknown) - len(chosen)} of the unknowns {listed(list(unknown))} open"
        )
        raise ParameterError(
            f"the rates of {system.name} that do not vanish identically leave {which}; name "
            "in at or held as many states more."
        )
    order = list(rates)
    return tuple(sorted((rows[i] for i in chosen), key=order.index))


def rates_by_name(system: Equations) -> dict[str, ca.SX]:
    """Residuals of constraints on places, then the rates of the states."""
    rates = zip(system.states, ca.vertsplit(system.rhs), strict=True)
    return {**_places(system), **dict(rates)}


def _places(system: Equations) -> dict[str, ca.SX]:
    """Residuals of constraints on places; with these the rates are dependent at the members."""
    return {
        n: v
        for n, v in system.observables.items()
        if n.startswith("residual_")
        and n.replace("residual_", "residual_rate_", 1) in system.observables
    }


def _resting(
    system: Equations, held: Mapping[str, Any], unknown: Sequence[str], guessed: Mapping[str, float]
) -> list[str]:
    """Velocities of a system with constraints that rates force to be exactly zero."""
    out = [n for n in unknown if not guessed.get(n)] if _places(system) else []
    while out:
        zero = dict.fromkeys(out, 0.0)
        rates = _with_held(system, held, system.rhs)
        still = _with_held(system, {**held, **zero}, system.rhs)
        rows = [i for i in range(len(system.states)) if still[i].is_zero()]
        sought = ca.vertcat(*[system.x[system.index(n)] for n in out])
        slopes = ca.jacobian(rates[rows], sought)
        table = _sampled(system, slopes, guessed)[:, : len(out)]
        felt = [n for n, column in zip(out, table.T, strict=True) if column.any()]
        if len(felt) == len(out):
            return out if np.linalg.matrix_rank(table) == len(out) else []
        out = felt
    return out


def _with_held(system: Equations, held: Mapping[str, Any], rates: ca.SX) -> ca.SX:
    """Rates with the held values in place."""
    if not held:
        return rates
    symbols = ca.vertcat(*[system.x[system.index(n)] for n in held])
    values = [
        np.pi / 2 if isinstance(v, Upright) else one_number(f"held {n}", v) for n, v in held.items()
    ]
    return ca.substitute(rates, symbols, ca.DM(values))


def _sampled(system: Equations, slopes: ca.SX, guessed: Mapping[str, float]) -> Floats:
    """Slopes at a few points, side by side: ranks there are typical ranks.

    The first point is the guess, since rows that are independent elsewhere may not be so at a
    member.  Of the others half have states near the guess, half near 0: far away a slope may
    underflow.
    """
    function = ca.Function("slopes", [system.x, system.p], [ca.densify(slopes)])
    rng = np.random.default_rng(5)
    blocks = []
    for block in range(POINTS):
        about = {n: v for n, v in guessed.items() if block < 3 or n in system.parameters}
        away = 0.1 if block else 0.0
        points = [
            [
                about.get(n, 0.0) + away * (1 + abs(about.get(n, 0.0))) * rng.uniform(-1, 1)
                for n in its
            ]
            for its in (system.states, system.parameters)
        ]
        blocks.append(np.array(function(*points)))
    table = np.hstack(blocks)
    return np.where(np.isfinite(table), table, 0.0)


def _independent(table: Floats) -> list[int]:
    """Rows, in order of preference, that are linearly independent at a sampled point.

    Each block of columns is one point; rows that are independent at one are so at almost all.
    """
    size = table.shape[1] // POINTS
    best: list[int] = []
    for block in range(POINTS):
        part = table[:, block * size : (block + 1) * size]
        scale = np.abs(part).max(axis=1, keepdims=True)
        part = part / np.where(scale > 0, scale, 1.0)
        chosen: list[int] = []
        basis = np.zeros((0, size))
        for row in range(len(part)):
            rest = part[row] - basis.T @ (basis @ part[row])
            rest = rest - basis.T @ (basis @ rest)
            length = float(np.linalg.norm(rest))
            if length > SAME * (1 + float(np.linalg.norm(part[row]))):
                chosen.append(row)
                basis = np.vstack([basis, rest / length])
        if len(chosen) > len(best):
            best = chosen
    return best


# --- the first member ---


def _anchored(family: Family, guessed: Mapping[str, float]) -> Family:
    """The family with the member nearest to the guess as its anchor."""
    a = np.array([[guessed[n] for n in family.at]])
    q = np.array([[guessed[n] for n in family.parameters]]).reshape(1, -1)
    guess = np.array(list(family.unknown.values()))
    family.search(a, q, guess)  # refuses equations that are singular for all numbers
    refusal: StabilityError | None = None
    for starts in _starts(family, guess):
        for u in _different(_reached(family, a, q, guess, starts)):
            try:
                family.checked_states(a, u[None], q)
            except StabilityError as error:
                refusal = refusal or error
                continue
            anchor = Anchor(tuple(a[0].tolist()), tuple(q[0].tolist()), tuple(u.tolist()))
            return replace(
                family, unknown=dict(zip(family.unknown, u.tolist(), strict=True)), anchor=anchor
            )
    if refusal is not None:
        raise refusal
    raise NoMemberError(
        f"{family.name} has no member that damped Newton steps reach at "
        f"{listing((*family.at, *family.parameters), (*a[0], *q[0]))}, neither from {STARTS} first "
        f"guesses about {listing(tuple(family.unknown), guess)} (within about {SPREADS[-1]:g} of "
        f"it, relative to 1 or to the number) nor from {MORE} of sizes from 1e{SIZES[0]} to "
        f"1e{SIZES[1]}; give another guess."
    )


def _starts(family: Family, guess: Floats) -> Iterator[Floats]:
    """First guesses about the given one, then of all sizes."""
    rng = np.random.default_rng(11)
    size, n = 1 + np.abs(guess), len(guess)
    spread = np.resize(SPREADS, STARTS - 1)[:, None]
    near = np.vstack([guess, guess + size * spread * rng.normal(size=(STARTS - 1, n))])
    far = rng.choice((-1.0, 1.0), (MORE, n)) * 10 ** rng.uniform(*SIZES, (MORE, n))
    positive = [i for i, name in enumerate(family.unknown) if name in family.positive]
    for starts in (near, far):
        starts[:, positive] = np.abs(starts[:, positive])
        yield starts


def _reached(family: Family, a: Floats, q: Floats, guess: Floats, starts: Floats) -> Floats:
    """Roots from first guesses, the nearest to the given one first."""
    positive = [i for i, n in enumerate(family.unknown) if n in family.positive]
    many = np.repeat(a, len(starts), axis=0), np.repeat(q, len(starts), axis=0)
    u = _damped(family, *many, starts)
    near = np.isfinite(u).all(axis=1)
    if not near.any():
        return u[near]
    u, good = roots(family.graph, many[0][near], many[1][near], u[near], positive)
    u = u[good]
    way = np.linalg.norm((u - guess) / (1 + np.abs(guess)), axis=1)
    return u[np.argsort(way, kind="stable")]


def _damped(family: Family, a: Floats, q: Floats, u: Floats) -> Floats:
    """Newton's method from many guesses, each step halved until the next step is shorter."""
    step = newton_step(family.graph, a, u, q)
    share = np.ones(len(u))
    for _ in range(STEPS):
        with np.errstate(all="ignore"):
            new = u - share[:, None] * np.where(np.isfinite(step), step, 0.0)
            following = newton_step(family.graph, a, new, q)
            size = 1 + np.abs(u)
            shorter = (np.abs(following) / size).max(axis=1) <= (
                (1 - share / 4) * (np.abs(step) / size).max(axis=1)
            )
        take = shorter | (share < 1e-4)
        u = np.where(take[:, None], new, u)
        step = np.where(take[:, None], following, step)
        share = np.where(take, np.minimum(2 * share, 1.0), share / 2)
        if accepted(family.graph, a, u, q, []).all():
            break
    return u


def _different(solutions: Floats) -> Iterable[Floats]:
    """Roots without repetition, in order."""
    seen: list[Floats] = []
    for u in solutions:
        if not any(np.allclose(u, v, rtol=1e-8, atol=1e-10) for v in seen):
            seen.append(u)
            yield u
