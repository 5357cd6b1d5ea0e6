"""Hard cases of the linear analysis.

A case is one class with its physics, the source of its truth, its points and its question.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np

from ...base.verdict import CODES, Verdict
from ..marks import HardCase, Judgement, Mark, by_error
from .chart import errors
from .points import DEGREES, EDGES, MEETINGS, Points, _points, close_to, coalescence
from .routes import Route, SpectrumAnswer, check

ASKED = 1e-6
"""Required relative error of a growth rate."""
ASKED_EIGENVALUES = 1e-9
"""Required error of eigenvalues, over the largest modulus."""
IN_BALLS = "the graph's characteristic polynomial in balls of 1024 bits"


class Case(HardCase):
    """A hard case of the linear analysis.

    Subclasses define `name`, `group`, `physics` and `points`, and `source` and `question` where the
    defaults do not fit.
    """

    source: ClassVar[str] = IN_BALLS
    """How the truth is known."""
    question: ClassVar[str] = "verdict"
    """Question: verdict, growth (the abscissa) or eigenvalues."""

    def points(self) -> Points:
        """Points at which a route is asked."""
        raise NotImplementedError

    def ask(self, route: Route) -> SpectrumAnswer:
        """The route's answer at the points."""
        return route.answer(self.points())

    def judge(self, route: Route) -> Judgement | None:
        """The route's mark; None where the route has no such answer.

        Parameters
        ----------
        route
            The route.
        """
        points, answer = self.points(), self.ask(route)
        check(points, answer)
        if self.question == "verdict":
            return self.judge_verdicts(points, answer)
        eigenvalues, abscissa = errors(points, answer)
        if self.question == "eigenvalues":
            return (
                None
                if eigenvalues is None
                else by_error(float(eigenvalues.max()), ASKED_EIGENVALUES)
            )
        if abscissa is None:
            return None
        worst = int(abscissa.argmax())
        stated = None
        if answer.bound is not None:
            scale = np.abs(points.truth.abscissa)
            share = np.asarray(answer.bound) / np.where(scale > 0, scale, 1.0)
            worst = int(np.maximum(abscissa, share * (share >= 0.1)).argmax())
            stated = float(share[worst])
        return by_error(float(abscissa[worst]), ASKED, stated)

    def judge_verdicts(self, points: Points, answer: SpectrumAnswer) -> Judgement:
        """Judge verdicts: right only if each of them is right."""
        codes, true = answer.codes, points.truth.codes
        open_ = codes == CODES[Verdict.UNDECIDED]
        wrong = ~open_ & (codes != true)
        note = f"{int((codes == true).sum())} of {len(points)} right"
        if wrong.any():
            return Judgement(Mark.WRONG, note=f"{note}, {int(wrong.sum())} wrong")
        if not open_.any():
            return Judgement(Mark.RIGHT, note=note)
        return Judgement(Mark.UNDECIDED if open_.all() else Mark.DEGRADED, note=note)


DECADES = tuple(range(1, 16))
"""Distances from a boundary, as powers of a tenth."""


class Ladder(Case):
    """Verdicts on both sides of a boundary, at relative distances 1e-1 to 1e-15."""

    group = "verdict at 10⁻¹…10⁻¹⁵ from a boundary"
    physics = "the growth rate vanishes there: its sign hangs on its last digits"
    where: ClassVar[tuple[Any, ...]]

    def points(self) -> Points:
        """Points on both sides of the boundary, at each distance."""
        return _ladder(self.where)

    def steps(self, route: Route) -> list[str]:
        """The mark at each distance, from far to near: right, undecided or wrong."""
        points, answer = self.points(), self.ask(route)
        check(points, answer)
        open_ = (answer.codes == CODES[Verdict.UNDECIDED]).reshape(-1, 2)
        right = (answer.codes == points.truth.codes).reshape(-1, 2)
        wrong = (~open_ & ~right).any(axis=1)
        return [
            "wrong" if w else ("undecided" if o else "right")
            for w, o in zip(wrong, open_.any(axis=1), strict=True)
        ]

    def judge(self, route: Route) -> Judgement:
        """Judge the ladder; its digits are the decades down to which the route is right."""
        return by_steps(self.steps(route))


NEAR = 12
"""Decades of distance down to which a route is right that is not called wrong for misses nearer."""


def by_steps(steps: Sequence[str]) -> Judgement:
    """Judge a ladder by its marks, from far to near: how often it is wrong, and how far away.

    Examples
    --------
    >>> by_steps(["right"] * 12 + ["wrong", "right", "right"]).note
    'right to 1e-12, wrong at 1 of 15 distances, the farthest 1e-13'
    """
    held = next((i for i, s in enumerate(steps) if s != "right"), len(steps))
    note = f"right to 1e-{held}" if held else "right at no distance"
    if misses := [i + 1 for i, s in enumerate(steps) if s == "wrong"]:
        note += f", wrong at {len(misses)} of {len(steps)} distances, the farthest 1e-{misses[0]}"
        mark = Mark.DEGRADED if held >= NEAR else Mark.WRONG
    elif held == len(steps):
        mark = Mark.RIGHT
    else:
        mark, note = Mark.DEGRADED if held else Mark.UNDECIDED, note + ", then undecided"
    return Judgement(mark, held, note, tuple(steps))


@lru_cache(maxsize=32)
def _ladder(where: tuple[Any, ...]) -> Points:
    return close_to(where, [10.0**-d for d in DECADES])


def _rung(where: Sequence[Any]) -> type[Case]:
    family, law, k, mu = where[:4]
    friction = "" if mu is None else f", mu = {mu:g}"
    return Ladder.variant(name=f"{family}, {law}, k = {k:g}{friction}", where=tuple(where))


LADDERS: tuple[type[Case], ...] = tuple(_rung(e) for e in EDGES)


def _case(
    name: str,
    group: str,
    physics: str,
    points: Callable[[], Points],
    question: str = "verdict",
    source: str = IN_BALLS,
) -> type[Case]:
    """A case whose points are all there is to it."""
    fields = {"name": name, "group": group, "physics": physics, "question": question}
    return Case.variant(**fields, source=source, points=staticmethod(points))


def _meeting(which: int) -> Points:
    """Doubles on both sides of a place at which two eigenvalues meet."""
    family, k, mu, low, high = MEETINGS[which]
    at = coalescence(family, k, mu, low, high)
    return _points(family, "viscous", k, mu, [at, math.nextafter(at, math.inf)])


STRUCTURE = "structure and coalescence"
DOUBLE = "double, with one eigenvector: it moves by the root of any change, 1e-16 → 1e-8"
STRUCTURES: tuple[type[Case], ...] = (
    _case(
        "two structural zeros",
        STRUCTURE,
        "stable rolling: two eigenvalues are zero by structure, and computed as ±1e-17",
        lambda: _points("rolling", "viscous", 0.25, [0.3, 1.0, 3.0, 10.0], [2.0, 2.5, 3.0, 5.0]),
    ),
    _case(
        "Jordan block, smooth disk",
        STRUCTURE,
        "exactly at omega3² = 1/(4k) two further zeros join in a Jordan block",
        lambda: _points("rolling", "smooth", [0.25, 0.0625], None, [1.0, 2.0]),
        source="exact: k = 1/4, omega3 = 1, where the reduced polynomial is λ²",
    ),
    _case(
        "Jordan block, smooth disk spinning",
        STRUCTURE,
        "exactly at phi_dot² = 1/k",
        lambda: _points("spinning", "smooth", [0.25, 0.0625], None, [2.0, 4.0]),
        source="exact: k = 1/4, phi_dot = 2",
    ),
    _case(
        "Jordan block, rough disk",
        STRUCTURE,
        "a hoop exactly at omega3² = 1/(2(2k+1)) = 1/4",
        lambda: _points("rolling", "rough", 0.5, None, [0.5]),
        source="exact: k = 1/2, omega3 = 1/2",
    ),
    _case(
        "viscous rolling at the rough threshold",
        STRUCTURE,
        "a third zero joins the two by structure in a Jordan block; the others are asked",
        lambda: _points("rolling", "viscous", 0.5, [0.1, 1.0, 10.0], [0.5, 0.5, 0.5]),
        question="eigenvalues",
    ),
    _case("coalescing eigenvalues", STRUCTURE, DOUBLE, lambda: _meeting(0), "eigenvalues"),
    _case(
        "coalescing eigenvalues, tumbling", STRUCTURE, DOUBLE, lambda: _meeting(3), "eigenvalues"
    ),
    _case(
        "branch point, on spinning",
        STRUCTURE,
        "spinning at phi_dot² = 1/k, where tumbling leaves it: one more zero",
        lambda: _points(
            "spinning", "viscous", [0.25, 0.25, 0.0625], [0.3, 4.0, 1.0], [2.0, 2.0, 4.0]
        ),
        source="exact: k = 1/4, phi_dot = 2; and k = 1/16, phi_dot = 4",
    ),
    _case(
        "branch point, on tumbling",
        STRUCTURE,
        "tumbling that leans by 1e-3 to 1e-7: an eigenvalue of order lean² next to the zero",
        lambda: _points("tumbling", "viscous", 0.25, 4.0, np.pi / 2 - np.array([1e-3, 1e-5, 1e-7])),
    ),
)


def _limit(family: str, at: float, question: str, *, large: bool) -> type[Case]:
    """A limit of friction: points over many decades of mu."""
    mus = [10.0**d for d in (range(2, 9) if large else range(-10, -1))]
    limit = "mu → ∞ (1e2…1e8)" if large else "mu → 0 (1e-2…1e-10)"
    physics = (
        "growth rates O(1/mu) next to decay rates O(mu): they look like round-off"
        if large
        else "the limit is singular: the smooth disk's zeros split by O(mu)"
    )
    return _case(
        f"{family}, {limit}: {question}",
        "limits of friction",
        physics,
        lambda: _points(family, "viscous", 0.3, mus, np.full(len(mus), at)),
        question,
    )


LIMITS: tuple[type[Case], ...] = tuple(
    _limit(family, at, question, large=large)
    for large in (False, True)
    for family, at in (("rolling", 1.2), ("spinning", 2.5), ("tumbling", 0.7))
    for question in ("verdict", "growth")
)


def _flat(degrees: float, question: str) -> type[Case]:
    """A hoop that tumbles nearly flat, at several mu, for many of which it is truly unstable."""
    theta = math.radians(degrees)
    return _case(
        f"hoop at {degrees:g}° from flat: {question}",
        "tumbling hoop",
        "growth rates down to 1e-12 next to frequencies of 30: real, not round-off",
        lambda: _points("tumbling", "viscous", 0.5, [0.1, 1.0, 3.0], [theta] * 3),
        question,
    )


FLATS: tuple[type[Case], ...] = tuple(_flat(d, q) for d in DEGREES for q in ("verdict", "growth"))


JACOBIAN = "how the Jacobian is made"
JACOBIANS: tuple[type[Case], ...] = (
    _case(
        "1/cosθ left by computer algebra",
        JACOBIAN,
        "rolling is upright, where cosθ/cosθ is 0/0, and the double π/2 is not upright",
        lambda: _points("rolling", "viscous", 0.25, [0.3, 1.0], [1.2, 2.0]),
        question="eigenvalues",
    ),
    _case(
        "step of a finite difference",
        JACOBIAN,
        "tumbling 1e-3 rad from flat: growth of 4e-7 next to rates of 60, and no step suits both",
        lambda: _points("tumbling", "viscous", 0.25, [1.0], [1e-3]),
        question="growth",
    ),
)


class NonSteady(Case):
    """A state that is no steady motion."""

    name = "non-steady operating point"
    group = JACOBIAN
    physics = "rolling with a tilt and slip: a Jacobian exists, a spectrum of a motion does not"
    source = "its rates do not vanish: the right answer is to refuse"

    def points(self) -> Points:
        """One state."""
        state = np.array([[np.pi / 2 - 0.05, 0.0, 0.1, 1.2, 0.01, 0.0]])
        ones = np.ones(1)
        return Points("rolling", "viscous", 0.25 * ones, 0.3 * ones, 1.2 * ones, free_states=state)

    def ask(self, route: Route) -> SpectrumAnswer:
        """The answer at the state, not at a member of a family."""
        return route.at_state(self.points())

    def judge(self, route: Route) -> Judgement | None:
        """Any decided verdict is wrong; a refusal arrives as an exception."""
        if route.own and type(route).at_state is Route.at_state:
            return None  # the route takes members of families only
        answer = self.ask(route)
        if (answer.codes == CODES[Verdict.UNDECIDED]).all():
            return Judgement(Mark.UNDECIDED)
        return Judgement(Mark.WRONG, note="a verdict of a motion that is not steady")


_EVERY: tuple[type[Case], ...] = (*LADDERS, *STRUCTURES, *FLATS, *LIMITS, *JACOBIANS, NonSteady)
CASES = {c.name: c for c in _EVERY}
"""Every case of the linear analysis by name."""
