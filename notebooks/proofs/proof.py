"""The form of a theorem: a statement, and steps that code has checked; `shown` prints it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from textwrap import wrap
from typing import Any

from stability.base.errors import StabilityError

DISK_TESTS = "tests/derivation/test_theorems.py"
BODY_TESTS = "tests/derivation/bodies/test_bodies_theorems.py"
POLE_TESTS = "tests/derivation/bodies/test_vertical.py"
WIDTH = 100
"""Columns of what is printed."""


@dataclass(frozen=True)
class Step:
    """One step of a proof, as it was checked."""

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
    """Steps in order; a step that cannot be computed is not proved."""

    def __init__(self) -> None:
        self.steps: list[Step] = []

    def step(self, claim: str, method: str, check: Callable[[], Any]) -> None:
        """Compute one step and keep it."""
        try:
            found = check()
        except (StabilityError, ArithmeticError, ValueError, TypeError) as error:
            found = False, f"the computation failed: {error}"
        proved, detail = found if isinstance(found, tuple) else (found, "")
        self.steps.append(Step(claim, method, proved is True, str(detail)))

    def conclude(self, claim: str, method: str) -> None:
        """Add a conclusion from the steps so far, which is proved if all of them are."""
        self.steps.append(Step(claim, method, all(step.proved for step in self.steps)))


def shown(theorem: Theorem) -> None:
    """Print a theorem with its steps as checked; a step that failed raises an AssertionError."""
    lines = [theorem.name, "=" * len(theorem.name)]
    lines += [line for text in theorem.statement for line in paragraph(text)]
    for title, texts in (("Assumptions:", theorem.assumptions), ("Steps:", ())):
        lines += ["", title] + [line for text in texts for line in paragraph(text, "- ")]
    for place, step in enumerate(theorem.steps, start=1):
        lines += paragraph(f"{step.claim}  [{'proved' if step.proved else 'FAILS'}]", f"{place}. ")
        lines += paragraph(f"by {step.method}", "   ")
        lines += paragraph(f"-> {step.detail}", "   ") if step.detail else []
    lines += ["", "Tests that try to refute it:", *(f"- {name}" for name in theorem.refuters)]
    print("\n".join(lines))
    failed = [step.claim for step in theorem.steps if not step.proved]
    if not theorem.proved:
        raise AssertionError(f"not proved, a conjecture: {theorem.name}; steps that fail: {failed}")


def paragraph(text: str, mark: str = "") -> list[str]:
    """A text as lines of at most `WIDTH` columns, the first after a mark."""
    return wrap(
        text,
        WIDTH,
        initial_indent=mark,
        subsequent_indent=" " * len(mark),
        break_long_words=False,
        break_on_hyphens=False,
    )
