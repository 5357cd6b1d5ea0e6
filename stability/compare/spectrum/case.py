"""A hard case of the linear analysis, and the judgement of an answer."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from ...base.verdict import CODES, Verdict
from ..marks import Judgement, Mark, by_error
from .measure import errors
from .points import Points
from .routes.route import Answer, Route, check

ASKED = 1e-6
"""Required relative error of a growth rate."""
ASKED_EIGENVALUES = 1e-9
"""Required error of eigenvalues, over the largest modulus."""
IN_BALLS = "the graph's characteristic polynomial in balls of 1024 bits"


class Case:
    """A hard case of the linear analysis.

    Subclasses define `name`, `group`, `physics` and `points`, and `known` and `question` where the
    defaults do not fit.
    """

    name: ClassVar[str]
    """Name in tables."""
    group: ClassVar[str]
    """Heading of its group in tables."""
    physics: ClassVar[str]
    """Physics of the case."""
    known: ClassVar[str] = IN_BALLS
    """How the truth is known."""
    question: ClassVar[str] = "verdict"
    """Question: verdict, growth (the abscissa) or eigenvalues."""

    def points(self) -> Points:
        """Points at which a route is asked."""
        raise NotImplementedError

    def ask(self, route: Route) -> Answer:
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

    def judge_verdicts(self, points: Points, answer: Answer) -> Judgement:
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
