"""Every statement about bodies of revolution, with what stands behind it."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from ..proof import Theorem
from .completeness import branches, rough_and_smooth, steady_motions
from .pole.steady import steady_at_poles
from .pole.vertical import vertical_conservative, vertical_viscous
from .rim import INCLINED, shifts
from .rolling import rolling_conservative, rolling_viscous
from .spinning import spinning_conservative, spinning_low, spinning_viscous
from .statements.entry import Entry
from .statements.known_results import known_results
from .statements.limits import bodies, limit, painleve
from .statements.polynomials import polynomial, polynomials
from .statements.rounded_rim import shifted, tumbling
from .tumbling import energy_decides, surfaces_neutral, tumbling_static

PROOFS: dict[str, Callable[[], Theorem]] = {
    "steady-motions": steady_motions,
    "steady-at-poles": steady_at_poles,
    "rough-smooth": rough_and_smooth,
    "branches": branches,
    "rolling-conservative": rolling_conservative,
    "rolling-viscous": rolling_viscous,
    "spinning-conservative": spinning_conservative,
    "spinning-viscous": spinning_viscous,
    "spinning-low": spinning_low,
    "vertical-conservative": vertical_conservative,
    "vertical-viscous": vertical_viscous,
    "tumbling-static": tumbling_static,
    "surfaces": surfaces_neutral,
    "energy": energy_decides,
    "painleve": painleve,
}
"""Functions that prove a theorem about every body, in the order of the table."""


def entries(progress: Callable[[int, int], None] | None = None) -> tuple[Entry, ...]:
    """Every statement, derived and proved again.

    Parameters
    ----------
    progress
        Called with (statements done, statements in all).

    Returns
    -------
    tuple of Entry
    """
    made: list[Callable[[], Entry]] = [partial(_theorem, prove) for prove in PROOFS.values()]
    made += [partial(polynomial, *names) for names in polynomials()]
    made += known_results()
    made += [partial(shifted, shift) for shift in shifts()]
    made += [partial(tumbling, rounded) for rounded in INCLINED]
    made += [partial(limit, *row) for row in bodies()]
    out = []
    for done, make in enumerate(made, start=1):
        out.append(make())
        if progress:
            progress(done, len(made))
    return tuple(out)


def _theorem(prove: Callable[[], Theorem]) -> Entry:
    t = prove()
    status = "proved" if t.proved else "not proved: a conjecture"
    return Entry("theorem", t.name, status, t.statement, None, t.assumptions, t.steps, t.refuters)
