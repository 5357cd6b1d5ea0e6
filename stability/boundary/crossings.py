"""Result of a search for changes of verdict: the changes, and the pieces that stay unresolved."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, overload

import numpy as np

from ..base.errors import warned
from ..base.types import Sentences
from ..base.verdict import Verdict


class Crossing(Sentences):
    """Kind of crossing at a boundary; the value of each member is the sentence a user reads.

    A static boundary is that of divergence.

    Source: docs/explanation/method.md; planted boundaries: tests/boundary/test_boundaries.py.

    Examples
    --------
    >>> import stability as st
    >>> st.Crossing("static").word
    'static'
    """

    STATIC = "static boundary: a real eigenvalue (or λ² of a conservative law) passes through zero"
    FLUTTER = "flutter boundary: a pair of eigenvalues crosses the imaginary axis"
    TOUCHING = (
        "boundary without a sign change of either determinant: found by bisection of verdicts"
    )
    STATIC_AND_FLUTTER = (
        "static and flutter boundary: a zero and pairs of eigenvalues cross at once"
    )

    @property
    def word(self) -> str:
        """One lower-case word."""
        return self.name.lower()

    @property
    def code(self) -> int:
        """The flag value in files."""
        return list(type(self)).index(self)


@dataclass(frozen=True)
class BoundaryPoint:
    """One point at which the verdict changes along an axis.

    Source: docs/explanation/method.md; planted boundaries: tests/boundary/test_boundaries.py.

    Examples
    --------
    >>> import stability as st
    >>> [edge] = st.boundaries("rolling", axis=("at", 1, 2, 9), contact=st.Viscous(0.3))
    >>> edge.value, edge.crossing.word
    (1.4142135623730951, 'flutter')
    """

    value: float
    """Value of the axis, in the user's unit."""
    error: float
    """Half-width of the proved bracket, same unit: the verdicts at value ± error differ."""
    crossing: Crossing
    """Kind of crossing."""
    frequency: float
    """|Im λ| of the crossing pair, in the user's unit of rate; 0 at a static boundary."""
    stable_below: bool
    """Whether the side that is not unstable has the smaller value."""
    good: Verdict = Verdict.UNDECIDED
    """Verdict on this side, next to the boundary: stable, neutral, drifting, or undecided which."""
    frequencies: tuple[float, ...] = ()
    """Where several cross at once: |Im λ| of each, 0 for a real one, in increasing order."""


class Unresolved(NamedTuple):
    """A piece of an axis on which a change of verdict was not excluded, or not located.

    Source: docs/explanation/method.md; planted boundaries: tests/boundary/test_boundaries.py.

    Examples
    --------
    >>> import stability as st
    >>> st.boundaries("rolling", axis=("at", 1, 2, 9), contact=st.Viscous(0.3)).unresolved
    ()
    """

    low: float
    """Low end, in the user's unit."""
    high: float
    """High end; equal to `low` for one point."""
    reason: str
    """Reason, in one sentence."""


@dataclass(frozen=True, eq=False)
class Boundaries(Sequence[BoundaryPoint]):
    """Every change of verdict that a search found, in increasing order, and the unresolved pieces.

    A sequence that equals the list of its points, and is false if empty.

    Source: docs/explanation/method.md; planted boundaries: tests/boundary/test_boundaries.py.

    Examples
    --------
    >>> import stability as st
    >>> found = st.boundaries("rolling", axis=("at", 0.1, 1, 9), contact=st.Smooth())
    >>> len(found), found[0].value, found.complete, found.unresolved
    (1, 1.0, True, ())
    >>> found == [found[0]], bool(found)
    (True, True)
    """

    points: tuple[BoundaryPoint, ...]
    """The changes."""
    unresolved: tuple[Unresolved, ...] = ()
    """Pieces on which a change was not excluded, or not bracketed; each with a reason."""
    touching: tuple[float, ...] = ()
    """Values at which alone the verdict is neutral: stable on both sides, or unstable on both."""
    how: str = ""
    """One sentence on how the axis was searched."""
    searched: tuple[str, float, float] | None = None
    """Name of the axis, and the closed interval that was searched; None where nobody said."""
    citation: str = ""
    """Keys of the works to cite, for `stability.citation`."""

    @property
    def complete(self) -> bool:
        """Whether the points are proved to be all changes on the closed interval."""
        return not self.unresolved

    def __len__(self) -> int:
        return len(self.points)

    @overload
    def __getitem__(self, index: int) -> BoundaryPoint: ...
    @overload
    def __getitem__(self, index: slice) -> list[BoundaryPoint]: ...
    def __getitem__(self, index: int | slice) -> BoundaryPoint | list[BoundaryPoint]:
        return list(self.points)[index]

    def __iter__(self) -> Iterator[BoundaryPoint]:
        return iter(self.points)

    def __eq__(self, other: object) -> bool:
        if isinstance(other, Boundaries):
            return (self.points, self.unresolved) == (other.points, other.unresolved)
        if isinstance(other, (list, tuple)):
            return list(self.points) == list(other)
        return NotImplemented

    def __hash__(self) -> int:
        return hash(self.points)

    def __add__(self, other: Any) -> list[BoundaryPoint]:
        return [*self.points, *other]

    def __radd__(self, other: Any) -> list[BoundaryPoint]:
        return [*other, *self.points]

    def __repr__(self) -> str:
        where = ""
        if self.searched:
            axis, low, high = self.searched
            where = f" along {axis} from {low:.10g} to {high:.10g}"
        state = f"; complete: {self.how}" if self.how else "; complete"
        if self.unresolved:
            state = f"; not complete, {len(self.unresolved)} unresolved: {self._first()}"
        points = f": {list(self.points)!r}" if self.points else ""
        points += "".join(f"; at {value:.10g} alone it is neutral" for value in self.touching)
        count = f"{len(self.points)} boundar{'y' if len(self.points) == 1 else 'ies'}"
        return f"<{count}{where}{points}{state}>"

    def _first(self) -> str:
        first, more = self.unresolved[0], len(self.unresolved) - 1
        said = f"from {first.low:.10g} to {first.high:.10g}: {first.reason}"
        return said + (f" (and {more} more in .unresolved)" if more else "")

    def statement(self, axis: str) -> str:
        """One sentence on how the axis was searched and what was not excluded.

        Parameters
        ----------
        axis
            Name of the axis.
        """
        if self.complete:
            alone = "".join(f"; at {value:.10g} alone it is neutral" for value in self.touching)
            return f"every change of verdict along {axis} was found: {self.how}{alone}."
        return f"the search along {axis} is not complete; {self._first()}"

    def warn(self, axis: str) -> None:
        """Issue a `StabilityWarning` where the search was not complete.

        Parameters
        ----------
        axis
            Name of the axis.
        """
        if not self.complete:
            warned(self.statement(axis))


def bracket(
    sign: Callable[[float], int], root: float, room: float = np.inf
) -> tuple[float, bool] | None:
    """The narrowest bracket about a root, of a few tried, whose verdicts are proved to differ.

    Parameters
    ----------
    sign
        The proved verdict at a value of the axis: 1, -1, or 0 where none is proved.
    root
        Value of the axis.
    room
        Distance to the next root.

    Returns
    -------
    width, stable_below
        Half-width, and whether the stable side is below; None if no bracket is proved.
    """
    width = float(np.spacing(abs(root))) if root else 1e-300
    while width <= min(1e-6 * max(abs(root), 1e-3), 0.9 * room):
        below, above = sign(root - width), sign(root + width)
        if below and above and below != above:
            return width, below > 0
        width *= 2 if root else 1024
    return None
