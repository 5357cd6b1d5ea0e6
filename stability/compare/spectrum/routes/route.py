"""Base class of routes to a verdict, and their answer.

A route is one class with `matrices` if it goes through LAPACK, or with `answer` otherwise.  All
routes get the members as doubles, the equations of motion, and the number of structural zeros,
which is more than people know.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ....base.types import Complexes, Floats
from ....base.verdict import CODES, Verdict
from ..points import Points

SMALL = 1e-9
"""Real parts up to this count as zero in people's scripts."""


@dataclass(frozen=True, eq=False)
class Answer:
    """Answer of a route at N points."""

    codes: NDArray[np.int8]
    """Verdict flags, shape (N,)."""
    eigenvalues: Complexes | None = None
    """Eigenvalues without structural zeros, shape (N, n); None if the route has none."""
    abscissa: Floats | None = None
    """Largest real part, shape (N,); None if the route has none."""
    bound: Floats | None = None
    """The route's own bound on the error of the abscissa, shape (N,); None if it states none."""


def check(points: Points, answer: Answer) -> None:
    """Refuse an answer of a wrong shape or type.

    Parameters
    ----------
    points
        Points of the answer.
    answer
        Answer of a route.

    Raises
    ------
    ArithmeticError
        If a shape or type is wrong, or a number is not finite.
    """
    count, codes = len(points), np.asarray(answer.codes)
    if codes.shape != (count,) or codes.dtype.kind not in "iu":
        raise ArithmeticError(f"verdicts of shape {codes.shape} for {count} points")
    if not np.isin(codes, list(CODES.values())).all():
        raise ArithmeticError("verdict flags that mean nothing")
    wide = points.member.system.x.numel() - points.zeros
    for name, shape in (("eigenvalues", (count, wide)), ("abscissa", (count,))):
        values = getattr(answer, name)
        if values is not None and (
            np.shape(values) != shape or not np.isfinite(np.asarray(values, dtype=complex)).all()
        ):
            raise ArithmeticError(f"{name} of a wrong shape, or not finite")


class Route:
    """Base class of routes to spectra.

    `matrices` returns the linearisation at each point.  The rest follows as in people's scripts:
    LAPACK, the smallest moduli dropped as structural zeros, the largest real part compared with
    `small`.  A route of another kind overrides `answer`.
    """

    name: ClassVar[str]
    """Name in tables and on the command line."""
    title: ClassVar[str]
    """Description in a few words."""
    flaw: ClassVar[str] = ""
    """Why it crashes where it does, in sentences; empty for a route that does not."""
    own: ClassVar[bool] = False
    """Whether the route belongs to the package."""
    default: ClassVar[bool] = False
    """Whether the package uses the route by default."""
    arrays: ClassVar[bool] = True
    """Whether it takes many points at once, which makes the time per point shorter."""
    small: ClassVar[float] = SMALL
    """Real parts up to this count as zero."""

    def matrices(self, points: Points) -> Floats:
        """The linearisation, shape (N, n, n)."""
        raise NotImplementedError

    def answer(self, points: Points) -> Answer:
        """Eigenvalues and verdicts at points."""
        return self.judged(points, np.linalg.eigvals(self.matrices(points)).astype(complex))

    def at_state(self, points: Points) -> Answer:
        """The answer at states that may not be steady: most routes do not check."""
        return self.answer(points)

    def judged(self, points: Points, values: Complexes) -> Answer:
        """The answer from all eigenvalues, structural zeros included."""
        order = np.argsort(np.abs(values), axis=1, kind="stable")[:, points.zeros :]
        kept = np.take_along_axis(values, order, axis=1)
        abscissa = kept.real.max(axis=1)
        codes = np.full(len(points), CODES[Verdict.NEUTRAL], dtype=np.int8)
        codes[abscissa > self.small] = CODES[Verdict.UNSTABLE]
        codes[abscissa < -self.small] = CODES[Verdict.STABLE]
        return Answer(codes, kept, abscissa)
