"""Hard cases of motion: a scene, a question about it, and the judgement of an answer."""

from __future__ import annotations

from typing import ClassVar

from ..marks import HardCase, Judgement, Mark, by_error
from .chart import judged
from .drivers import Driver, MotionAnswer
from .reference_motions import UNDETERMINED, ReferenceMotion, scene

ASKED = 1e-6
"""Required error of a state or a time."""
NO_ANSWER = ("undetermined", "unresolved", "non-unique")
"""Outcomes by which a driver says that it has no answer."""


class MotionCase(HardCase):
    """A hard case of motion.

    Subclasses name the scene and the question: `outcome`, `final` (the last state), `time` (of the
    end) or `events` (of dry friction).
    """

    scene: ClassVar[str]
    """A key of `stability.compare.motion.reference_motions.scenes()`."""
    question: ClassVar[str]
    """Question: outcome, final, time or events."""

    def it(self) -> ReferenceMotion:
        """The scene with its truth."""
        return scene(self.scene)

    @property
    def source(self) -> str:
        """How the truth is known."""
        return f"two independent integrations, which agree to {self.it().error:.0e}"

    def judge(self, driver: Driver) -> Judgement | None:
        """The driver's mark; None where the driver does not take the scene.

        Parameters
        ----------
        driver
            The driver, at its usual tolerance.
        """
        it = self.it()
        if not driver.takes(it):
            return None
        return self.weigh(driver.run(it, it.asked, driver.usual))

    def weigh(self, motion: MotionAnswer) -> Judgement:
        """Judge a motion.

        Parameters
        ----------
        motion
            Answer of a driver.
        """
        it = self.it()
        if motion.outcome in NO_ANSWER:
            open_ = it.outcome == UNDETERMINED
            return Judgement(Mark.RIGHT if open_ else Mark.UNDECIDED, note=motion.outcome)
        if it.outcome == UNDETERMINED:
            return Judgement(Mark.WRONG, note=f"{motion.outcome}, but nobody knows")
        if motion.outcome != it.outcome:
            note = f"{motion.outcome} at {motion.end_time:.6g}, in truth {it.outcome}"
            return Judgement(Mark.WRONG, note=note)
        if self.question == "outcome":
            return Judgement(Mark.RIGHT, note=motion.outcome)
        row = judged(it, motion)
        if self.question == "final":
            return by_error(row["final"], ASKED, motion.stated)
        if row["event"] is None:
            return Judgement(Mark.WRONG, note="other events than in truth")
        return by_error(row["event"], ASKED)


def _case(name: str, group: str, question: str, which: str, physics: str) -> type[MotionCase]:
    return MotionCase.variant(
        name=name, group=group, question=question, scene=which, physics=physics
    )


FLAT, STIFF, LONG = "near-flat passage", "stiff decay", "long runs"
EVENTS, DRY, EDGE = "lift-off and other events", "dry friction", "sensitive launches"
DIP = "gn dips to {0} and comes back"

MOTION_CASES: dict[str, type[MotionCase]] = {
    c.name: c
    for c in (
        _case(
            "passes 6e-4 rad from flat",
            FLAT,
            "final",
            "near-flat",
            "a rough hoop: phi_dot rises to 3000 for a thousandth of a unit of time",
        ),
        _case(
            "passes 5e-4 rad from flat, viscous",
            FLAT,
            "final",
            "near-flat-viscous",
            "a hoop that slips: the same with friction",
        ),
        _case(
            "falls flat",
            FLAT,
            "outcome",
            "falls-flat",
            "a hoop let go: it is flat at t = 2.1665, and the equations end there",
        ),
        _case("falls flat: when", FLAT, "time", "falls-flat", "the time at which 1e-6 rad is left"),
        _case("mu = 300", STIFF, "final", "stiff-300", "the slip decays at a rate of 900"),
        _case("mu = 1e4", STIFF, "final", "stiff-10000", "at a rate of 3e4"),
        _case("mu = 1e5", STIFF, "final", "stiff-100000", "at a rate of 3e5"),
        _case("rough disk, T = 1000", LONG, "final", "rough-long", "phase errors add up"),
        _case(
            "near the threshold of rolling, T = 200",
            LONG,
            "final",
            "near-threshold",
            "omega3 = 1.4142, just below √2: growth of 1e-5",
        ),
        _case("settles on spinning, T = 400", LONG, "final", "spin-down", "two time scales"),
        _case(
            "rolling drifts to its threshold",
            LONG,
            "outcome",
            "slow-drift",
            "stable by its spectrum; drifts for 120, is unstable after, lifts off at 304.87",
        ),
        _case("rolling drifts: when", LONG, "time", "slow-drift", "the time of that lift-off"),
        _case("rolling drifts longer: when", LONG, "time", "slower-drift", "at 790.10"),
        _case("lifts off", EVENTS, "outcome", "lift-off", "gn reaches zero at t = 16.1165"),
        _case("lifts off: when", EVENTS, "time", "lift-off", "the time of it"),
        _case(
            "gn dips to -1.3e-2",
            EVENTS,
            "outcome",
            "graze-plus-1e-3",
            "and comes back: a step may pass over the event",
        ),
        _case("gn dips to +1.8e-2", EVENTS, "outcome", "graze-minus-1e-3", "and comes back"),
        _case("gn dips to -1.6e-5", EDGE, "outcome", "graze-plus-1e-6", DIP.format("-1.6e-5")),
        _case("gn dips to +1.6e-5", EDGE, "outcome", "graze-minus-1e-6", DIP.format("+1.6e-5")),
        _case("gn dips to -1.6e-8", EDGE, "outcome", "graze-plus-1e-9", DIP.format("-1.6e-8")),
        _case("gn dips to +1.6e-8", EDGE, "outcome", "graze-minus-1e-9", DIP.format("+1.6e-8")),
        _case("gn dips to -1.6e-11", EDGE, "outcome", "graze-plus-1e-12", DIP.format("-1.6e-11")),
        _case("gn dips to +1.6e-11", EDGE, "outcome", "graze-minus-1e-12", DIP.format("+1.6e-11")),
        _case(
            "gn dips to +1.8e-15",
            EDGE,
            "outcome",
            "graze-plus-ulp",
            "the next double of omega3 lifts off: below any double's rounding",
        ),
        _case("gn dips to +5.3e-15", EDGE, "outcome", "graze-minus-ulp", "one double further"),
        _case(
            "rolls from the double nearest π/2",
            EDGE,
            "final",
            "double-upright",
            "unstable rolling 6e-17 from upright: that lean grows to one in 26 units of time",
        ),
        _case(
            "the same, rough",
            EDGE,
            "final",
            "double-upright-rough",
            "grows, falls, and rises again to near upright",
        ),
        _case(
            "slides, then sticks",
            DRY,
            "events",
            "slides_then_sticks",
            "the slip ends at a point, not on a surface",
        ),
        _case(
            "sticks, slips, sticks, …",
            DRY,
            "events",
            "many_transitions_through_upright",
            "six transitions",
        ),
        _case(
            "at rest outside the cone",
            DRY,
            "events",
            "starts_stuck_then_slips",
            "slip sets in against the force of sticking",
        ),
        _case(
            "sticks, slips, reverses",
            DRY,
            "events",
            "planar_sticks_slips_reverses",
            "in a plane of symmetry",
        ),
        _case("dry friction lifts off", DRY, "time", "lifts_off_sliding", "while it slides"),
    )
}
"""Every case of motion by name."""
