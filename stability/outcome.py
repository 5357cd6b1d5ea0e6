"""What becomes of a launched disk; the value of each outcome is the sentence a user reads."""

from __future__ import annotations

from .checks import Sentences
from .flow import FLAT, LIFT_OFF, NO_CONTACT
from .route import UNRESOLVED
from .sticking import NON_UNIQUE


class Outcome(Sentences):
    """How a run ended; exactly one of these, each with its time and evidence.

    Examples
    --------
    >>> Outcome.LIFT_OFF.word
    'lift-off'
    >>> Outcome.MOVING.code
    0
    """

    MOVING = "moving: contact lasted and no motion was settled on; ask for later times to see more"
    SETTLED = (
        "settled: the state lies so close to an asymptotically stable steady motion that its "
        "motion is proved, in ball arithmetic, to converge to that one or to a neighbour of the "
        "same family"
    )
    FLAT = "flat: the disk has fallen on its side, where a thin disk's equations of motion end"
    LIFT_OFF = "lift-off: the normal force has reached zero and the disk leaves the plane"
    NO_CONTACT = (
        "no-contact: no contact force continues the motion (D ≤ 0 or no admissible slip, "
        "Painlevé's paradox); take a smaller mu"
    )
    NON_UNIQUE = (
        "non-unique: dry friction allows more than one continuation from here, and none is chosen; "
        "take a smaller mu, or RegularisedCoulomb to have one picked"
    )
    UNRESOLVED = (
        "unresolved: the integrator gave up and what came after is not shown; ask for another "
        "method, a larger max_steps, max_seconds or tolerance"
    )
    UNDETERMINED = (
        "undetermined: neighbours within the tolerance end differently; ask for a finer tolerance "
        "or an earlier last time"
    )

    @property
    def word(self) -> str:
        """The outcome as one word: the part of the sentence before the colon."""
        return str(self.value).split(":")[0]

    @property
    def code(self) -> int:
        """The flag value in files."""
        return CODES[self]


CODES = {outcome: code for code, outcome in enumerate(Outcome)}
"""Flag value of each outcome, in arrays and files."""
BY_CODE = {code: outcome for outcome, code in CODES.items()}
"""Outcome of each flag value."""
OF_END = {
    LIFT_OFF: Outcome.LIFT_OFF,
    FLAT: Outcome.FLAT,
    NO_CONTACT: Outcome.NO_CONTACT,
    NON_UNIQUE: Outcome.NON_UNIQUE,
    UNRESOLVED: Outcome.UNRESOLVED,
}
"""The outcome of each kind of end."""
