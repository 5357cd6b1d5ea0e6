"""How far uncertain inputs move an answer, by the model that gave it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from .rungs.track import relative

VAIN_WORDS = "a tenth of what the uncertain inputs allow to know"
"""Why a tolerance is raised."""
VAIN = 0.5
"""Share of that at which a tolerance is called wasted."""
WASTED = 0.1
"""Share of the spread below which a finer model or tolerance is wasted."""


@dataclass(frozen=True)
class Spread:
    """The answers at the ends of each uncertain input, the others held."""

    inputs: Mapping[str, float]
    """Half-width of each input: relative for a parameter, absolute for a state."""
    moves: Mapping[str, Mapping[str, float]]
    """Largest change of each quantity, over 1 or its size, by quantity and input."""
    outcomes: Mapping[str, tuple[str, ...]]
    """Outcomes at the two ends of each input."""
    outcome: str
    """Outcome of the scene itself."""
    contrary: tuple[str, ...]
    """Inputs within whose uncertainty the outcome changes."""
    tolerance: float
    """Tolerance of the scene."""
    labels: Mapping[str, str]
    """Each input with its half-width and unit, in words."""

    @property
    def size(self) -> float:
        """The root of the sum of squares of all changes, the largest over the quantities."""
        every = [
            math.sqrt(sum(v**2 for v in moved.values() if math.isfinite(v)))
            for moved in self.moves.values()
        ]
        return max(every, default=0.0)

    @property
    def wasted(self) -> bool:
        """Whether the tolerance is finer than a tenth of what the inputs allow to know."""
        return self.tolerance < VAIN * WASTED * self.size

    def lines(self) -> list[str]:
        """The spread in words, one line for each fact."""
        found = [
            f"  {self.labels[given]} moves {name} by {size:.2g}, over 1 or its size"
            for name, moved in self.moves.items()
            for given, size in moved.items()
            if math.isfinite(size)
        ]
        for given in self.contrary:
            for sign, word in zip("-+", self.outcomes[given], strict=True):
                if word != self.outcome:
                    label = self.labels[given].replace("±", sign)
                    found.append(f"  {label} gives {word} in place of {self.outcome}")
        if self.contrary:
            found.append(
                "  the outcome is not determined by what is known: it changes within the "
                f"uncertainty of {' and of '.join(self.contrary)}"
            )
        elif self.wasted:
            found.append(
                f"  a tolerance of {self.tolerance:g} is wasted: the inputs alone move the answer "
                f"by {self.size:.2g}, and {WASTED * self.size:.2g} is enough"
            )
        return found


Ask = Callable[[str, float], tuple[dict[str, Any], str]]
"""(input, change) → values of numbers and states by quantity, and the outcome."""


def spread(
    inputs: Mapping[str, float], base: dict[str, Any], word: str, ask: Ask, tolerance: float,
    labels: Mapping[str, str],
) -> Spread:  # fmt: skip
    """Ask again at both ends of each input.

    Parameters
    ----------
    inputs
        Half-widths by name.
    base
        The values of the scene itself.
    word
        Its outcome.
    ask
        Function that answers with one input changed.
    tolerance
        Tolerance of the scene.
    labels
        Each input with its half-width and unit, in words.

    Returns
    -------
    Spread
    """
    moves: dict[str, dict[str, float]] = {name: {} for name in base}
    outcomes, contrary = {}, []
    for name, width in inputs.items():
        ends = [ask(name, sign * width) for sign in (-1.0, 1.0)]
        for quantity, value in base.items():
            far = [apart(value, other[quantity]) for other, _ in ends]
            moves[quantity][name] = max(far)
        outcomes[name] = tuple(told for _, told in ends)
        if any(told != word for told in outcomes[name]):
            contrary.append(name)
    return Spread(dict(inputs), moves, outcomes, word, tuple(contrary), tolerance, labels)


def apart(value: Any, other: Any) -> float:
    """Distance of two values of a quantity, over 1 or their size.

    Parameters
    ----------
    value, other
        Two numbers, two arrays of states along the last axis, two words, or None.

    Returns
    -------
    float
        Infinite where one is missing, or two words differ.

    Examples
    --------
    >>> apart(2.0, 2.5), apart("moving", "moving"), apart(1.0, None)
    (0.25, 0.0, inf)
    """
    if value is None or other is None:
        return 0.0 if value is other else math.inf
    if isinstance(value, str):
        return 0.0 if value == other else math.inf
    if isinstance(value, float):
        return float(abs(value - other) / max(1.0, abs(value)))
    a, b = np.asarray(value, dtype=float), np.asarray(other, dtype=float)
    count = min(len(a), len(b)) if a.ndim > 1 else len(a)
    return float(np.max(relative(b[:count] - a[:count], a[:count])))
