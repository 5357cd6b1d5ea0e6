"""The form of a theorem: a statement, and steps that code has checked."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ..base.errors import StabilityError


@dataclass(frozen=True)
class Step:
    """One step of a proof, as it was checked.

    Examples
    --------
    >>> Step("2 is even", "division", True).proved
    True
    """

    claim: str
    """What the step states."""
    method: str
    """How the computation checks it."""
    proved: bool
    """Whether the computation confirms it."""
    detail: str = ""
    """Result of the computation, such as a polynomial or a number of roots."""


@dataclass(frozen=True)
class Theorem:
    """A statement with its proof and with the tests that try to refute it."""

    name: str
    """Short name."""
    statement: tuple[str, ...]
    """Sentences that the steps prove together."""
    assumptions: tuple[str, ...]
    """Assumptions of the statement."""
    steps: tuple[Step, ...]
    """Steps of the proof, as checked."""
    refuters: tuple[str, ...]
    """Tests that try to refute the statement, as `file::test`."""

    @property
    def proved(self) -> bool:
        """Whether every step is proved; a theorem with a failed step is not proved."""
        return bool(self.steps) and all(step.proved for step in self.steps)


class Proof:
    """Steps in order; a step that cannot be computed is not proved.

    Examples
    --------
    >>> proof = Proof()
    >>> proof.step("1 + 1 = 2", "addition", lambda: (1 + 1 == 2, "2"))
    >>> proof.steps[0].proved, proof.steps[0].detail
    (True, '2')
    """

    def __init__(self) -> None:
        self.steps: list[Step] = []

    def step(self, claim: str, method: str, check: Callable[[], Any]) -> None:
        """Compute one step and keep it.

        Parameters
        ----------
        claim, method
            Words of the step.
        check
            Returns whether the claim is confirmed, or a pair of this and the detail.
        """
        try:
            found = check()
        except (StabilityError, ArithmeticError, ValueError, TypeError) as error:
            found = False, f"the computation failed: {error}"
        proved, detail = found if isinstance(found, tuple) else (found, "")
        self.steps.append(Step(claim, method, proved is True, str(detail)))

    def conclude(self, claim: str, method: str) -> None:
        """Add a conclusion from the steps so far, which is proved if all of them are.

        Parameters
        ----------
        claim, method
            Words of the conclusion.
        """
        self.steps.append(Step(claim, method, all(step.proved for step in self.steps)))
