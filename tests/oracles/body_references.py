"""Reference motions of convex bodies to 18 digits, for tests/data/body_motions.json.

Each is integrated from exact doubles with 25 digits by extrapolation (`body_motion.extrapolated`),
and kept with the sum of the steps' error estimates.  Run as a script to write the file.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import body_profiles as bodies
import mpmath as mp
import numpy as np
from body_motion import derivative, extrapolated, pose_of, standing, unknowns
from convex_body import ConvexBody, Law, Pose
from jets import Array, plain, precise

PLACE = Path(__file__).parents[1] / "data" / "body_motions.json"
SOURCE = (
    "tests/oracles/body_references.py: Newton-Euler in inertial axes, contact from the geometry, "
    "25 digits, extrapolated midpoint rule; vectors in inertial axes, m = g = 1; "
    "error is the sum of estimates of each step"
)
SEEN = ("axis", "spin", "centre", "slip")
"""What is kept of a motion: (n, 3) each, in inertial axes."""

SLIP = (0.125, 0.25)


@dataclass(frozen=True)
class Reference:
    """A motion to compute: body, law, start, times, and steps in each unit of time."""

    name: str
    body: ConvexBody
    law: Law
    axis: Sequence[float]
    """Direction of the axis at the start: any length."""
    spin: Sequence[float]
    slip: Sequence[float]
    times: Sequence[float]
    steps: int = 12
    back: int = 0
    """The time of the pose that is given, if it is not the start."""

    def start(self, exactly: bool = False) -> Pose:
        """The pose at time zero, in doubles or in mpmath numbers."""
        read = precise if exactly else np.asarray
        return standing(self.body, *(read(v) for v in (self.spin, self.slip, self.axis)))


def through_pole(
    name: str, body: ConvexBody, law: Law, pole: int, spin: Sequence[float], slip: Sequence[float]
) -> Reference:
    """A motion that is at a pole after one unit of time; see `traced`.

    pole: 1 where the axis points up, -1 where it points down.
    """
    times = (0.0, 0.5, 1.0, 2.0)
    return Reference(name, body, law, [0, 0, pole], spin, slip, times, back=1)


def traced(reference: Reference) -> Reference:
    """The same motion from its start, as doubles, where it is given at a later time."""
    if not reference.back:
        return reference
    with mp.workdps(25):
        rates = derivative(reference.body, reference.law)
        at = unknowns(reference.start(exactly=True))
        pose = pose_of(reference.body, extrapolated(rates, at, mp.mpf(-reference.back), 14)[0])
        axis, spin, slip = ([float(e) for e in v] for v in (pose.axis, pose.spin, pose.slip[:2]))
    return replace(reference, axis=axis, spin=spin, slip=slip, back=0)


def references() -> list[Reference]:
    """The motions of the file."""
    top = bodies.eccentric_sphere(0.25, 0.375, 0.4375)
    inverting = bodies.eccentric_sphere(0.3, 0.4, 0.375)
    prolate = bodies.spheroid(0.75, 1.25, 0.25, 0.4375)
    oval = bodies.egg(0.125, 0.125, 0.0625, 0.375, 0.5)
    ring = bodies.torus(0.75, 0.25, 0.6, 0.35)
    coin = bodies.thick_disk(1.0, 0.125, 0.5, 0.26)
    bowl = bodies.lens(1.5, 0.7, 0.4, 0.25)
    return [
        through_pole("tippe top, through 0", top, Law("viscous", 0.3), 1, [0.75, 1.5, 0.5], SLIP),
        through_pole("tippe top, through pi", top, Law("viscous", 0.3), -1, [0.5, 1.0, 2], SLIP),
        through_pole("spheroid, through 0", prolate, Law("rough"), 1, [0.25, -0.5, 1.0], [0, 0]),
        through_pole("egg, through pi", oval, Law("linear-viscous", 0.25), -1, [1, 0.5, 2], SLIP),
        through_pole("egg, smooth", oval, Law("smooth"), 1, [0.25, 1.0, 1.0], SLIP),
        Reference(
            "torus",
            ring,
            Law("coulomb", 0.25),
            [1, 0.25, 0.25],
            [0.25, 0.5, 1.0],
            [0.75, -1.0],
            (0.0, 0.5, 1.0),
        ),
        Reference(
            "thick disk",
            coin,
            Law("rough"),
            [1, 0, 0.75],
            [-1.0, 0.0, 1.5],
            [0, 0],
            (0.0, 0.5, 1.0),
        ),
        Reference(
            "lens on its edge",
            bowl,
            Law("viscous", 0.25),
            [1, 0, 0.25],
            [1.5, 0.25, 1.0],
            [0.1, 0.2],
            (0.0, 0.5, 1.0),
        ),
        Reference(
            "tippe top, turning over",
            inverting,
            Law("viscous", 0.3),
            [0.05, 0, 1],
            [0, 0, 8.0],
            [0, 0],
            (0.0, 10.0, 20.0, 30.0, 40.0),
            8,
        ),
    ]


def computed(reference: Reference) -> tuple[list[Array], Any]:
    """The unknowns at each time, and the sum of the error estimates."""
    rates = derivative(reference.body, reference.law)
    values = unknowns(reference.start(exactly=True))
    path, doubt = [values], mp.mpf(0)
    for begin, end in zip(reference.times[:-1], reference.times[1:], strict=True):
        steps = round((end - begin) * reference.steps)
        values, more = extrapolated(rates, values, mp.mpf(end) - mp.mpf(begin), steps)
        path.append(values)
        doubt += more
    return path, doubt


def record(reference: Reference) -> dict[str, Any]:
    """One entry of the file."""
    reference = traced(reference)
    with mp.workdps(25):
        path, error = computed(reference)
        poses = [pose_of(reference.body, values) for values in path]
        seen = {n: [[mp.nstr(e, 18) for e in getattr(p, n)] for p in poses] for n in SEEN}
    body, law = reference.body, reference.law
    start = {n: list(map(float, getattr(reference, n))) for n in ("axis", "spin", "slip")}
    return {
        "name": reference.name,
        "body": body.name,
        "parameters": dict(body.parameters),
        "axial": body.axial,
        "transverse": body.transverse,
        "law": law.name,
        "coefficient": law.coefficient,
        "start": start,
        "times": list(reference.times),
        "error": float(error),
        **seen,
    }


def stored() -> list[tuple[Reference, dict[str, Any]]]:
    """The motions of the file with their entries; vectors as arrays of the nearest doubles."""
    entries: list[dict[str, Any]] = json.loads(PLACE.read_text(encoding="utf-8"))["motions"]
    return [
        (replace(reference, **entry["start"], back=0), entry | {n: plain(entry[n]) for n in SEEN})
        for reference, entry in zip(references(), entries, strict=True)
    ]


def main() -> int:
    """Compute and write the file: minutes."""
    motions = []
    for reference in references():
        motions.append(record(reference))
        print(reference.name, motions[-1]["error"], motions[-1]["axis"][-1], flush=True)
    text = json.dumps({"source": SOURCE, "motions": motions}, indent=1)
    PLACE.write_text(text + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
