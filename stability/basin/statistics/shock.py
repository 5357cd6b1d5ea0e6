"""Minimal fatal shock: the smallest disturbance of a launch that changes its label.

The smallest shock that was found is an upper bound of the true one, with its launch.  Random
launches are drawn in the ball below the bound; a launch with another label, and the point where its
ray leaves the label, give a smaller bound.  Between these draws the border near the best launch is
bracketed along a few rays, and the foot of the perpendicular to the plane through these points is
tried.

The name and the question are those of Halekotte & Feudel, Sci. Rep. 10 (2020) 11783.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...base.checks import checked, one_number, positive, whole_number
from ...base.errors import ParameterError, shown
from ...base.types import Floats
from ..labels import Ints, Label, asked
from .samples import in_ball, shares

BUDGET = 2000
"""Labels, unless the caller wants another number."""
DRAWS = 32
"""Random launches of a round."""
SECTIONS = 4
"""Launches on a ray in one step of a bracket, which it makes five times shorter."""
SHARPEST, WIDEST = 1e-4, 0.5
"""Range of the angle of local rays to the best one [rad]."""
CLOSEST = 4
"""Random launches of a round whose rays are bracketed, those with the smallest disturbances."""
REFUSED = 100
"""Draws for each label of the budget at which a search ends: most launches are out of range."""
RISK = 0.05
"""Risk that the share of the ball that is not excluded is larger than stated."""


@dataclass(frozen=True, eq=False)
class Shock:
    """The smallest disturbance that was found to change a label, or that none was found."""

    size: float
    """Its size, an upper bound of the smallest one: the norm of (launch - start) / scale.

    Infinite if no launch with another label was found."""
    launch: Floats
    """The disturbed launch, shape (d,); the start itself if none was found."""
    label: int
    """Its label."""
    start: Floats
    """The launch that was disturbed, shape (d,)."""
    start_label: int
    """Its label."""
    inner: float
    """Size of a shock in the same direction, below `size`, that keeps the label."""
    searched: int
    """Labels that were computed."""
    clear: int
    """Random launches in the ball below the bound since it was found; all kept the label."""
    excluded: float
    """Largest share of this ball that can have another label, at a risk of 5 %."""
    note: str
    """What was searched and what is not excluded, in sentences."""

    citation: str = "stability"
    """Keys of the works to cite, for `stability.citation`, those of the labels too."""

    @property
    def found(self) -> bool:
        """Whether a launch with another label was found."""
        return math.isfinite(self.size)


def fatal_shock(
    label: Label,
    start: ArrayLike,
    *,
    scale: ArrayLike = 1.0,
    reach: float = 1.0,
    low: ArrayLike | None = None,
    high: ArrayLike | None = None,
    budget: int = BUDGET,
    tolerance: float = 1e-4,
    seed: int = 0,
) -> Shock:
    """Smallest disturbance that changes the label of a launch: an upper bound.

    A larger budget continues the same search, so that the bound never increases with it.

    Parameters
    ----------
    label
        Function of launches, shape (n, d), that returns their labels, n whole numbers.
    start
        The launch, shape (d,).
    scale
        Disturbance of each coordinate that counts as 1, one number or shape (d,).
    reach
        Largest size of a disturbance that is tried.
    low, high
        Ends of the range of each coordinate; launches outside are not tried.
    budget
        Most labels to compute.
    tolerance
        Width at which a bracket along a ray ends, as a share of the bound.
    seed
        Seed of the random launches.

    Returns
    -------
    Shock
        The disturbed launch, its size and label, and what was searched.

    Raises
    ------
    ParameterError
        If an argument or what `label` returns is not accepted.

    Source: the least distance found by a search; planted ends: tests/basin/test_shock.py.

    Examples
    --------
    >>> import math
    >>> import numpy as np
    >>> import stability as st
    >>> def over(points):
    ...     return points.sum(axis=1) > 3  # at the distance √3 from the origin
    >>> shock = st.statistics.fatal_shock(over, [0, 0, 0], reach=5)
    >>> bool(math.sqrt(3) < shock.size < 1.001 * math.sqrt(3)), shock.label
    (True, 1)
    >>> bool(np.linalg.norm(shock.launch) == shock.size)
    True
    """
    budget = whole_number("budget", budget)
    reach, tolerance = (
        float(positive(n, one_number(n, v)))
        for n, v in (("reach", reach), ("tolerance", tolerance))
    )
    search = _ShockSearch(label, _Ball.of(start, scale, low, high), budget, reach, tolerance, seed)
    search.run()
    return search.result()


@dataclass(frozen=True, eq=False)
class _Ball:
    """Disturbances as dimensionless vectors, and the launches that they make."""

    start: Floats
    scale: Floats
    low: Floats
    high: Floats

    @classmethod
    def of(
        cls, start: ArrayLike, scale: ArrayLike, low: ArrayLike | None, high: ArrayLike | None
    ) -> _Ball:
        """From what the user gives."""
        point = np.asarray(checked("start", start))
        if point.ndim != 1:
            raise ParameterError(f"start is {shown(start)}; give one launch, shape (d,).")
        ranges = (
            ("scale", np.asarray(positive("scale", scale))),
            ("low", np.asarray(-np.inf if low is None else checked("low", low))),
            ("high", np.asarray(np.inf if high is None else checked("high", high))),
        )
        for name, value in ranges:
            if value.shape not in ((), point.shape):
                raise ParameterError(
                    f"{name} has shape {value.shape}; give one number, or one for each of the "
                    f"{len(point)} coordinates."
                )
        size, least, most = (np.broadcast_to(v, point.shape) for _, v in ranges)
        if (point < least).any() or (point > most).any():
            raise ParameterError("the start is outside its range; give low ≤ start ≤ high.")
        return cls(point, size, least, most)

    def launches(self, shocks: Floats) -> Floats:
        """The disturbed launches."""
        return np.asarray(self.start + self.scale * shocks)

    def inside(self, shocks: Floats) -> NDArray[np.bool_]:
        """Which disturbances are within the range."""
        launches = self.launches(shocks)
        return np.asarray(((launches >= self.low) & (launches <= self.high)).all(axis=1))


class _SpentError(Exception):
    """The budget is spent."""


class _ShockSearch:
    """The state of a search; the questions depend on the answers before alone."""

    def __init__(
        self, label: Label, ball: _Ball, budget: int, reach: float, tolerance: float, seed: int
    ) -> None:
        self.label, self.ball, self.budget = label, ball, budget
        self.reach, self.tolerance, self.seed = reach, tolerance, seed
        self.searched = self.drawn = self.clear = 0
        self.size, self.inner = math.inf, 0.0
        self.best: Floats | None = None
        self.angle = WIDEST
        self.own = int(self.ask(np.zeros((1, len(ball.start))))[0])
        self.found = self.own

    def ask(self, shocks: Floats) -> Ints:
        """Labels of disturbed launches; those beyond the range or the budget count as unchanged."""
        labels = np.full(len(shocks), getattr(self, "own", 0))
        inside = np.flatnonzero(self.ball.inside(shocks))
        spent = len(inside) > self.budget - self.searched
        inside = inside[: self.budget - self.searched]
        if len(inside):
            labels[inside] = asked(self.label, self.ball.launches(shocks[inside]))
            self.searched += len(inside)
        self.note(shocks, labels)
        if spent:
            raise _SpentError
        return labels

    def note(self, shocks: Floats, labels: Ints) -> None:
        """Keep the smallest disturbance that changes the label."""
        if self.searched <= 1:
            return
        sizes = np.where(labels != self.own, np.linalg.norm(shocks, axis=1), np.inf)
        if len(sizes) and (n := int(sizes.argmin())) >= 0 and sizes[n] < self.size:
            self.size, self.best, self.found = float(sizes[n]), shocks[n], int(labels[n])
            self.clear, self.inner = 0, 0.0

    # --- rounds ---

    def run(self) -> None:
        """Draw and polish in turn until the budget is spent."""
        try:
            while self.drawn < REFUSED * self.budget:
                before = self.size
                self.draw()
                if self.size < before:
                    self.angle = WIDEST
                if self.best is not None and self.angle > SHARPEST:
                    self.polish()
        except _SpentError:
            pass

    def draw(self) -> None:
        """Random disturbances below the bound; those that change the label are bracketed."""
        d = len(self.ball.start)
        numbers = shares(d + 1, self.drawn, DRAWS, self.seed)
        self.drawn += DRAWS
        before = min(self.size, self.reach)
        shocks = before * in_ball(numbers)
        start, bound = self.searched, self.size
        try:
            changed = np.flatnonzero(self.ask(shocks) != self.own)
        finally:  # the budget may end here
            if self.size == bound:
                self.clear += self.searched - start
        order = np.argsort(np.linalg.norm(shocks[changed], axis=1), kind="stable")
        self.bracket(shocks[changed[order[:CLOSEST]]], self.tolerance)

    def polish(self) -> None:
        """Try the foot of the perpendicular to the border's plane near the best disturbance."""
        assert self.best is not None
        before, d = self.size, len(self.best)
        towards = self.best / self.size
        turn = shares(2 * d * d, self.drawn, 1, self.seed ^ 1)[0].reshape(2 * d, d) - 0.5
        turn -= (turn @ towards)[:, None] * towards
        length = np.linalg.norm(turn, axis=1, keepdims=True)
        rays = towards + math.tan(self.angle) * turn / np.where(length > 0, length, 1)
        rays /= np.linalg.norm(rays, axis=1, keepdims=True)
        far = min(self.size * (1 + self.angle), max(self.reach, self.size))
        changed = self.ask(far * rays) != self.own
        near = self.bracket(far * rays[changed], max(self.tolerance, 0.01 * self.angle))
        border = np.concatenate([self.best[None], near])
        normal = np.asarray(np.linalg.lstsq(border, np.ones(len(border)), rcond=None)[0], float)
        foot = before * normal[None] / np.linalg.norm(normal)
        self.bracket(foot[self.ask(foot) != self.own], self.tolerance)
        gained = self.size < before * (1 - self.tolerance)
        self.angle = min(WIDEST, 1.5 * self.angle) if gained else max(SHARPEST, 0.5 * self.angle)

    def bracket(self, ends: Floats, tolerance: float) -> Floats:
        """Shorten rays whose ends change the label to a border near the start.

        Parameters
        ----------
        ends
            Ends of the rays, shape (n, d).
        tolerance
            Share of a ray at which its bracket ends.

        Returns
        -------
        ndarray
            Disturbances at the border that change the label, shape (n, d).
        """
        low, high = np.zeros(len(ends)), np.ones(len(ends))
        steps = np.arange(1, SECTIONS + 1) / (SECTIONS + 1)
        while ((high - low) > tolerance * high).any():
            cuts = low[:, None] + (high - low)[:, None] * steps
            shocks = (cuts[:, :, None] * ends[:, None, :]).reshape(-1, ends.shape[1])
            changed = (self.ask(shocks) != self.own).reshape(cuts.shape)
            first = np.where(changed.any(axis=1), changed.argmax(axis=1), SECTIONS)
            edges = np.concatenate([low[:, None], cuts, high[:, None]], axis=1)
            rows = np.arange(len(ends))
            low, high = edges[rows, first], edges[rows, first + 1]
        border = ends * high[:, None]
        sizes = np.linalg.norm(border, axis=1)
        if len(sizes) and math.isclose(float(sizes.min()), self.size, rel_tol=1e-12):
            n = int(sizes.argmin())
            self.inner = float(low[n] * np.linalg.norm(ends[n]))
        return np.asarray(border)

    def result(self) -> Shock:
        """The record."""
        best = np.zeros_like(self.ball.start) if self.best is None else self.best
        share = 1 - RISK ** (1 / self.clear) if self.clear else 1.0
        radius = min(self.size, self.reach)
        what = (
            f"A disturbance of size {self.size:.4g} changes the label: the smallest one is no "
            "larger."
            if self.best is not None
            else f"No disturbance up to {self.reach:g} that was tried changes the label."
        )
        note = (
            f"{what}  {self.searched} labels were computed.  A smaller one is not excluded: "
            f"{self.clear} random launches below {radius:.4g} keep the label, so that others "
            f"have at most {share:.2g} of this ball within the ranges, at a risk of {RISK:g}."
        )
        return Shock(
            self.size,
            self.ball.launches(best),
            self.found,
            self.ball.start,
            self.own,
            self.inner,
            self.searched,
            self.clear,
            share,
            note,
            str(getattr(self.label, "citation", "stability")),
        )
