"""How far a motion is determined: each launch is run again, twice, a little off and less finely.

Two shadows start on either side of the launch, its nonzero numbers off by the tolerance (zeros
stay, so that a motion in a plane of symmetry keeps its plane), with another tolerance.  Where all
stay close, their distance, scaled down by the ratio of the tolerances, estimates the error.  Where
they part, two more are as fine as the launch itself; if one of these ends otherwise, the launch's
outcome is not determined at its tolerance, and is not given.  This is evidence, not proof: a border
between outcomes that runs along the line of the three starts is not seen.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .flow import Floats
from .outcome import Outcome

if TYPE_CHECKING:
    from .motion import Result

LOOSER = 1e3
"""The first shadow's tolerance over that of the launch, up to `LOOSEST`."""
LOOSEST = 1e-6
"""Where no scaling holds any more, and a stiff motion is lost: a launch that is asked less than ten
times as finely has a finer shadow instead."""
FINER = 1e-2
"""That shadow's tolerance over that of the launch."""
ROUNDING = 1e-15
"""Below this an error no longer falls with the tolerance."""
MARGIN = 10.0
"""Factor on a scaled distance, since an error falls a little more slowly than the tolerance."""
CLOSE = 0.03
"""Distance of states up to which the scaling is trusted."""
NOTHING = 0.3
"""Estimate from which on nothing is known of the final state: its error is without bound then."""
APART = 1e-2
"""Relative difference of the times of an early end that makes it another end."""
LASTING = (Outcome.MOVING, Outcome.SETTLED)
SIGNS = np.array([1.0, -0.83, 0.71, -0.91, 0.77, 0.87])
"""Direction of the start's change: fixed, and of no symmetry."""
COMPARED = 17
"""Times at which two shadows are compared."""

Rerun = Callable[[Sequence[int], Floats, Floats], "list[Result]"]
"""Runs launches (by number) again from starts off by a relative size, at tolerances."""


@dataclass(frozen=True)
class Doubt:
    """What a shadow says of a launch."""

    final_error: float
    """Estimated error of the final state: the largest, each over 1 or the state's own size."""
    time_error: float
    """Estimated error of the end's time, dimensionless; 0 where the run lasted to the last time."""
    contrary: str = ""
    """How the launch's neighbour ends, where it ends otherwise; then the outcome is open."""


def doubts(found: Sequence[Result], finest: Sequence[float], rerun: Rerun) -> list[Doubt | None]:
    """Judge each launch by its shadows.

    Parameters
    ----------
    found
        The launches after their runs.
    finest
        The smallest tolerance that the integrator of each accepts.
    rerun
        Runs some of them again.

    Returns
    -------
    list of Doubt or None
        None where the launch itself has no outcome.

    Examples
    --------
    >>> import stability as st
    >>> run = st.simulate(st.Disk(), st.Viscous(0.3), {"theta": 1.47, "omega3": 1.0}, 20.0)
    >>> bool(run.final_error < 1e-6)
    True
    """
    out: list[Doubt | None] = [None] * len(found)
    asked = np.array([r.tolerance for r in found])
    where = [i for i, r in enumerate(found) if r.outcome is not Outcome.UNRESOLVED]
    looser = 10 * asked <= LOOSEST
    coarse = np.minimum(LOOSER * asked, LOOSEST)
    shadow = np.maximum(np.where(looser, coarse, FINER * asked), finest)
    own = np.maximum(asked, ROUNDING)  # what rounds away is no change of a start
    scale = np.where(looser, MARGIN * own / shadow, 2.0)
    off = np.where(looser, shadow, own)
    again: list[int] = []
    for i, pair in zip(where, _pairs(rerun, where, shadow[where], off[where]), strict=True):
        doubt, spread = _judged(found[i], pair)
        if doubt.contrary or not max(doubt.final_error, doubt.time_error, spread) <= CLOSE:
            again.append(i)
        else:
            out[i] = Doubt(doubt.final_error * scale[i], doubt.time_error * scale[i])
    if again:
        fine = np.maximum(asked / 10, finest)[again]
        for i, pair in zip(again, _pairs(rerun, again, fine, own[again]), strict=True):
            doubt, spread = _judged(found[i], pair)
            # where neighbours part on the way, that they meet at the end is chance
            size = 2 * max(doubt.final_error, spread if spread > CLOSE else 0.0)
            bound = size if size < NOTHING else np.inf
            out[i] = Doubt(bound, 2 * doubt.time_error, doubt.contrary)
    return out


def _pairs(
    rerun: Rerun, which: Sequence[int], tolerances: Floats, off: Floats
) -> list[tuple[Result, Result]]:
    """Both shadows of each launch."""
    return list(
        zip(rerun(which, tolerances, off), rerun(which, tolerances, -off), strict=True)
    )  # fmt: skip


def _judged(one: Result, pair: tuple[Result, Result]) -> tuple[Doubt, float]:
    """Distances of the ends, the contrary if there is one, and the spread of the shadows."""
    if any(other.outcome is Outcome.UNRESOLVED for other in pair):
        # where the launch itself lasted, its neighbour has met something that it has not
        return Doubt(np.inf, np.inf, _contrary(one, pair) if one.outcome in LASTING else ""), np.inf
    final = max(_distance(one.final, other.final) for other in pair)
    late = max(abs(one.time - other.time) for other in pair)
    unlike = [other for other in pair if not _alike(one, other)]
    count = min(len(other.path.states) for other in pair)
    spread = _distance(pair[0].path.states[:count], pair[1].path.states[:count]) / 2
    return Doubt(final, late, _contrary(one, unlike) if unlike else ""), spread


def _distance(a: Floats, b: Floats) -> float:
    """Largest difference of states, each over 1 or its own size."""
    n = min(a.shape[-1], 6)
    a, b = a[..., :n], b[..., :n]
    return float((np.abs(a - b) / np.maximum(1.0, np.abs(a))).max())


def _alike(one: Result, other: Result) -> bool:
    if one.outcome in LASTING and other.outcome in LASTING:
        both = one.outcome is other.outcome is Outcome.SETTLED
        return not both or one.near.family == other.near.family
    return one.outcome is other.outcome and abs(one.time - other.time) <= APART * max(1.0, one.time)


def _contrary(one: Result, others: Sequence[Result]) -> str:
    other = next((o for o in others if o.outcome is Outcome.UNRESOLVED), others[0])

    def told(result: Result) -> str:
        if result.outcome is Outcome.SETTLED:
            return f"{result.outcome.word} to {result.near.family}"
        at = "" if result.outcome in LASTING else f" at {result.time:.9g}"
        return f"{result.outcome.word}{at}"

    return (
        f"two runs within the tolerance {one.tolerance:g} of each other end differently: "
        f"{told(one)}, and {told(other)}"
    )
