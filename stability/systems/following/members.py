"""The unknowns of many members: from a first guess, or followed from a known member."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...base.errors import NameUnknownError, NoMemberError, ParameterError, listing, shown
from ...base.types import Floats
from ..graph.family_graph import FamilyGraph
from ..graph.ignorable import ignorable
from .roots import accepted, newton_step, roots
from .sheet import follow
from .singular_points import Curve, singular_point
from .steadiness import given_noise, rate_noise

UNKNOWN = 1e-10
"""Largest rate that counts as zero, in units of the linearisation, if its rounding has no bound."""

NEXT = 1e-4
"""Longest way from the end of a line to the fold or branch point that ended it, as a share."""
LAST = 1e-2
"""Largest correction of an unknown at the end of a line, relative to 1 or to the unknown."""
TINY = 1e-6
"""Largest correction after three Newton steps there."""
CROSSES = (
    ", where another branch crosses; branch lists this point in branch_points, and its switch "
    "follows the other branch"
)
BEYOND = {
    "cusp": ", through which this line runs: lines on one side of it go on, and those on the other "
    "end at a fold; take a known member from which the line does not meet it",
    "fold": ", where this branch turns; branch with arclength=True goes round it",
    "pitchfork": CROSSES,
    "transcritical point": CROSSES,
    "branch point": CROSSES,
}
"""What is on the other side of each singular point, and how to get there."""
STEEP = ", where it changes too fast to follow; a known member closer by may reach it"
"""The same where no singular point is resolved."""


class Found(NamedTuple):
    """Unknowns row by row, and where there are none."""

    u: Floats
    """Unknowns, shape (N, u); of no meaning where not good."""
    good: NDArray[np.bool_]
    """Whether a member was found, shape (N,)."""
    why: Callable[[int], str]
    """The sentence that says why a row has no member."""


def find(family: Any, a: Floats, q: Floats, start: Floats | None) -> Found:
    """The unknowns of each row, from first guesses or from the family's known member.

    Parameters
    ----------
    family
        A `Family` with unknowns and a root-finder.
    a, q
        Family parameters and parameters, shapes (N, ·).
    start
        First guesses, shape (N, u); None to follow from the family's anchor.

    Returns
    -------
    Found
    """
    # members that differ only in numbers outside the equations (mu, for the disk) share a root
    given = np.hstack([a, q])
    key = (
        given[:, family.graph.used]
        if start is None
        else np.hstack([given[:, family.graph.used], start])
    )
    inverse = np.zeros(1, dtype=int)
    if len(key) > 1:
        inverse = np.unique(key, axis=0, return_inverse=True)[1].ravel()
    first = np.zeros(inverse.max(initial=-1) + 1, dtype=int)
    first[inverse] = np.arange(len(a))
    positive = [i for i, name in enumerate(family.unknown) if name in family.positive]
    if start is None:
        found = _followed(family, a[first], q[first], positive)
    else:
        u, good = _rooted(family, a[first], q[first], start[first], positive)
        found = Found(u, good, lambda row: _unreached(family, a[first][row], q[first][row]))
    return Found(found.u[inverse], found.good[inverse], lambda row: found.why(inverse[row]))


def _rooted(
    family: Any, a: Floats, q: Floats, start: Floats, positive: Sequence[int]
) -> tuple[Floats, NDArray[np.bool_]]:
    """Roots next to those of the family's formulas; where it has none, next to first guesses."""
    u, good, left = start.copy(), np.zeros(len(a), dtype=bool), np.ones(len(a), dtype=bool)
    known = family.formulas.guess(a, q) if family.formulas is not None else None
    if known is not None:
        near, lacking = known
        some = np.flatnonzero(np.isfinite(near).all(axis=1) & ~lacking)
        if len(some):
            u[some] = near[some]
            good[some] = accepted(family.graph, a[some], u[some], q[some], positive)
        left = ~good & ~lacking
    rows = np.flatnonzero(left)
    if len(rows):
        u[rows], good[rows] = roots(family.graph, a[rows], q[rows], u[rows], positive)
    return u, good


def _unreached(family: Any, a: Floats, q: Floats) -> str:
    return (
        f"{family.name} has no member that the root-finder reaches at "
        f"{listing((*family.at, *family.parameters), (*a, *q))}: the equation for "
        f"{', '.join(family.unknown)} has no admissible isolated solution there; "
        "choose another point of the family or give a guess."
    )


def _followed(family: Any, a: Floats, q: Floats, positive: Sequence[int]) -> Found:
    """Members on the smooth sheet of the anchor, each along a straight line."""
    given, anchor = np.hstack([a, q]), family.anchor
    start = np.tile(anchor.given, (len(a), 1)), np.tile(anchor.unknown, (len(a), 1))
    # each row from the anchor itself: a member next to another may lie beyond the end of the sheet
    u, good, share = _ended(family.graph, a.shape[1], (*start, given), positive)
    return Found(u, good, lambda row: _stopped(family, given[row], u[row], share[row], positive))


def _ended(
    graph: FamilyGraph, cut: int, line: tuple[Floats, Floats, Floats], positive: Sequence[int]
) -> tuple[Floats, NDArray[np.bool_], Floats]:
    """Members at the ends of lines, polished; whether each was reached; shares of the lines."""
    start, u, stop = line
    found, share = follow(graph, cut, start, u, stop)
    good = share == 1
    if good.any():
        a, q, near = stop[good][:, :cut], stop[good][:, cut:], found[good]
        steps = []
        for _ in range(3):  # the last correction on the way need not be small
            steps.append(newton_step(graph, a, near, q))
            near = near - np.where(np.isfinite(steps[-1]), steps[-1], 0.0)
        size = 1 + np.abs(near)
        way = [np.abs(s / size).max(axis=1) for s in steps]
        fine = (way[0] <= LAST) & (way[1] <= way[0] / 4 + TINY) & (way[2] <= way[1] / 4 + TINY)
        polished, root = roots(graph, a, q, near, positive)
        # the polish moves by rounding alone, or it went to another root
        fine &= root & (np.abs(polished - near) <= TINY * size).all(axis=1)
        found[good] = np.where(fine[:, None], polished, near)
        good[good] = fine
    return found, good, share


def _stopped(family: Any, asked: Floats, u: Floats, share: float, positive: Sequence[int]) -> str:
    """The sentence that says where continuation stopped."""
    names = (*family.at, *family.parameters)
    anchor = family.anchor.given
    moved = [i for i in family.graph.used if asked[i] != anchor[i]] or list(range(len(names)))
    stop = anchor + share * (asked - anchor)
    place, start = (listing([names[i] for i in moved], p[moved]) for p in (stop, anchor))
    wrong = [n for i, n in enumerate(family.unknown) if i in positive and not u[i] > 0]
    if share == 1 and wrong:
        return f"{family.name} has no member at {place}: {wrong[0]} is not positive there."
    curve = Curve(family.graph, len(family.at), anchor, asked - anchor)
    point = singular_point(curve, np.array([*u, share]), NEXT)
    what, beyond = "", STEEP if share < 1 else ""
    if point is not None:
        what, beyond, share = f"a {point[0]} at ", BEYOND[point[0]], float(point[1].z[-1])
    stop = anchor + share * (asked - anchor)
    stop[np.abs(stop) < 1e-12 * np.abs(asked - anchor)] = 0.0
    return (
        f"{family.name} has no member at "
        f"{listing([names[i] for i in moved], asked[moved])} that continuation from {start} "
        f"reaches: it stopped at {what}{listing([names[i] for i in moved], stop[moved])}"
        f"{beyond}."
    )


def require_steady(family: Any, a: Floats, u: Floats, q: Floats, states: Floats) -> None:
    """Refuse members at which a rate does not vanish within its rounding.

    Parameters
    ----------
    family
        A `Family`.
    a, u, q
        Family parameters, unknowns and parameters, shapes (N, ·).
    states
        States of the members, shape (N, n).

    Raises
    ------
    NoMemberError
        If a rate does not vanish, or has no value.
    """
    arguments = [list(block.T) for block in (a, u, q)]
    rates = family.graph.rates.arrays(arguments, a.shape[:1])[0][..., 0]
    rates[:, [family.system.index(n) for n in family.left_out]] = 0.0
    if not rates.any():
        return
    with np.errstate(all="ignore"):
        matrix = family.matrix(a, u, q)
        size = np.abs(matrix).max(axis=(1, 2))
        scale = 1 + size * (1 + np.abs(u).max(axis=1, initial=0))
    if not (np.isfinite(rates).all() and np.isfinite(scale).all()):
        raise NoMemberError(
            f"{family.name}: the rates have no value there, such as the sign of 0, or overflow "
            "double precision; give values nearer to 1."
        )
    if (np.abs(rates) <= given_noise(states, matrix)).all():  # nothing else has to be counted
        return
    bound = rate_noise(family.graph, a, u, q, states, matrix)
    bound = np.where(np.isfinite(bound), bound, UNKNOWN * scale[:, None])
    over = ~(np.abs(rates) <= bound)
    if over.any():
        row = int(np.argmax(over.any(axis=1)))
        which = int(np.argmax(np.where(over[row], np.abs(rates[row]), -1.0)))
        raise NoMemberError(
            f"{family.name} at {listing(family.at, a[row])} is not steady: "
            f"{family.system.states[which]} still changes at {abs(rates[row, which]):.3g}, and "
            f"rounding accounts for {bound[row, which]:.1g} of that at most; "
            f"{_remedy(family.system, family.system.states[which])}."
        )


def _remedy(system: Any, state: str) -> str:
    if state in ignorable(system):
        return "it is ignorable, so leave it out of the family"
    return "add its rate to the family's equations, or give what is held to all its digits"


def check_states(family: Any) -> None:
    """Refuse a family that does not name each state of its system once.

    Parameters
    ----------
    family
        A `Family` with checked parts.

    Raises
    ------
    ParameterError, NameUnknownError
        If a name is unknown, a state is missing or named twice, or the equations are not as many
        as the unknowns.
    """
    system, whose = family.system, f"family {family.name}"
    for name in (*family.held, *family.unknown, *family.equations):
        seen = system.observables.get(name) if name in family.equations else None
        if seen is None or seen.shape != (1, 1):
            system.index(name)
    for name in family.at:
        if name not in (*system.states, *system.parameters):
            raise NameUnknownError(
                f"at is {shown(name)}, neither a state nor a parameter of {system.name}."
            )
    given = family.named
    for state in system.states:
        if given.count(state) != 1 and (state in given or state not in family.left_out):
            raise ParameterError(
                f"state {shown(state)} of {whose} is given {given.count(state)} "
                "times; name each state once, in at, held or unknown."
            )
    if len(family.unknown) != len(family.equations):
        raise ParameterError(
            f"{whose} has {len(family.unknown)} unknowns and {len(family.equations)} "
            "equations; give as many of one as of the other."
        )
