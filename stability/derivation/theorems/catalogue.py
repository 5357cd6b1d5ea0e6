"""The theorems by short name, each proved at first use."""

from __future__ import annotations

from collections.abc import Callable

from ..proof import Theorem
from .boundary_shape import boundary_shape
from .dry_friction import dry_friction
from .settling import settling
from .spinning import spinning
from .steady_motions import any_law, dry_rough_smooth
from .tumbling import tumbling

PROOFS: dict[str, Callable[[], Theorem]] = {
    "any-law": any_law,
    "dry-rough-smooth": dry_rough_smooth,
    "settling": settling,
    "spinning": spinning,
    "tumbling": tumbling,
    "tumbling-shape": boundary_shape,
    "dry-friction": dry_friction,
}
"""Functions that prove a theorem, in the order of the table."""


def theorems(progress: Callable[[int, int], None] | None = None) -> tuple[Theorem, ...]:
    """Every theorem with its steps as checked now.

    Parameters
    ----------
    progress
        Called with (theorems done, theorems in all).

    Returns
    -------
    tuple of Theorem

    Examples
    --------
    >>> PROOFS["any-law"]().proved
    True
    """
    out = []
    for done, prove in enumerate(PROOFS.values(), start=1):
        out.append(prove())
        if progress:
            progress(done, len(PROOFS))
    return tuple(out)
