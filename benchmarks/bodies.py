"""Maps and boundaries of bodies of revolution against those of the disk, side by side in one run.

The disk and the body take turns, since machines are shared and noisy.  Processor time of all
threads counts.  The first call derives what later calls find again; it is stated by itself.  Two
ratios follow.  *new*: each call has another number of the body, and the disk another k, so that
neither finds a stored answer: a user who asks along a body's own number pays this.  *same*: each
call repeats the first one: a user who asks one body many times pays this.  The disk has no vertical
spin, so that of a body is compared with the disk's spinning.

Usage: python benchmarks/bodies.py [--json] [WORD ...]
(rows whose family, law or body contains one of the words; all without any)
"""

from __future__ import annotations

import json
import statistics
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from timing import seconds

import stability as st

NX, NY = 400, 300
REPEATS = 3
MU = ("mu", 0.05, 3.0)
EGG = st.Egg(0.2)
BODIES: dict[str, tuple[Callable[[float], st.Body], tuple[str, float, float]]] = {
    "torus": (lambda x: st.Torus(0.2 * x), ("tube", 0.05, 0.5)),
    "spheroid": (lambda x: st.Spheroid(0.6 * x), ("aspect", 0.3, 0.9)),
    "eccentric sphere": (lambda x: st.EccentricSphere(0.2 * x), ("offset", 0.05, 0.5)),
    "thick disk": (lambda x: st.ThickDisk(0.1 * x), ("thickness", 0.05, 0.3)),
    "egg": (lambda x: replace(EGG, axial=EGG.axial * x), ("axial", 0.35, 0.45)),
}
"""Each body with a number times x, and the number that is an axis under laws without one."""
K = 0.25
"""The disk's number times x."""
STEP = 1e-3
"""Change of that number from call to call, so that no call finds the numbers of another."""
AXES = {
    "rolling": (0.2, 3.0),
    "spinning": (0.5, 5.0),
    "tumbling": (0.05, 1.55),
    "vertical": (0.5, 5.0),
    "circling": (0.3, 1.3),
    "precession": (0.3, 1.3),
}
"""Interval of `at` of each family."""
RANGES = {
    ("tumbling", "spheroid"): (1.6, 3.0),
    ("tumbling", "eccentric sphere"): (0.1, 1.5),
    ("tumbling", "egg"): (1.0, 1.7),
    ("tumbling", "thick disk"): (0.2, 1.3),
}
"""Intervals of bodies that tumble elsewhere."""
PAIRS = {"circling": "rough", "precession": "smooth"}
"""Families named by two numbers, and their one law."""


@dataclass(frozen=True)
class Case:
    """One question about a body and the same about the disk."""

    family: str
    law: str
    body: str

    def arguments(self, body: st.Body | None) -> tuple[str, dict[str, Any], dict[str, Any]]:
        """Family, and what `stability_map` and `boundaries` take."""
        family = "spinning" if body is None and self.family == "vertical" else self.family
        at = AXES[family]
        if body is not None:
            at = RANGES.get((self.family, self.body), AXES[self.family])
        held: dict[str, Any] = {} if body is None else {"body": body}
        if family in PAIRS:
            x, y = ("theta", *at, NX), ("phi_dot", 0.5, 3.0, NY)
            return family, {"x": x, "y": y, **held}, {"axis": (*x[:3], 50), "at": 1.7, **held}
        x = ("at", *at, NX)
        if self.law == "viscous":
            return (
                family,
                {"x": x, "y": (*MU, NY), **held},
                {"axis": (*x[:3], 50), "mu": 0.3, **held},
            )
        number = ("k", 0.25, 0.5) if body is None else BODIES[self.body][1]
        return family, {"x": x, "y": (*number, NY), **held}, {"axis": (*x[:3], 50), **held}

    def runs(self, body: st.Body | None, x: float) -> dict[str, Callable[[], Any]]:
        """A map and boundaries; x is a new number of the disk too, which has k alone."""
        family, chart, line = self.arguments(body)
        if body is None and "k" not in (chart["y"][0], chart["x"][0]):
            chart["disk"] = st.Disk(k=K * x)
        if body is None:
            line["disk"] = st.Disk(k=K * x)
        return {
            "map": lambda: st.stability_map(family, contact=self.law, **chart),
            "boundaries": lambda: st.boundaries(family, contact=self.law, **line),
        }


spent = partial(seconds, clock=time.process_time)
"""Processor time of a call, of all threads [s]."""


def cases() -> Iterator[Case]:
    """Every family that a body has under every law with a polynomial."""
    for name, (make, _) in BODIES.items():
        for family in AXES:
            for law in ("viscous", "rough", "smooth"):
                if PAIRS.get(family, law) != law:
                    continue
                try:
                    make(1.0).family(family, law)
                except st.StabilityError:
                    continue
                yield Case(family, law, name)


def measured(case: Case) -> dict[str, Any]:
    """First and median times of both, and the ratios of the medians, with new and with old numbers.

    With old numbers body and disk both ask what they have asked before, and find stored answers.
    """
    row: dict[str, Any] = {"family": case.family, "law": case.law, "body": case.body}
    make = BODIES[case.body][0]
    for what in ("map", "boundaries"):
        try:
            first = [spent(case.runs(make(1.0), 1.0)[what]), spent(case.runs(None, 1.0)[what])]
            found: dict[str, Any] = {"body_first_s": first[0], "disk_first_s": first[1]}
            for name, step in (("new", STEP), ("same", 0.0)):
                pairs = []
                for i in range(1, REPEATS + 1):
                    x = 1 + step * i
                    pairs.append([spent(case.runs(b, x)[what]) for b in (make(x), None)])
                ours, theirs = (statistics.median(t) for t in zip(*pairs, strict=True))
                found[name] = {"body_s": ours, "disk_s": theirs, "ratio": ours / theirs}
        except st.StabilityError as error:
            found = {"refused": str(error)}
        row[what] = found
    return row


def line(row: dict[str, Any]) -> str:
    """A row as text."""
    words = [f"{row['family']:10s} {row['law']:8s} {row['body']:17s}"]
    for what in ("map", "boundaries"):
        found = row[what]
        if "refused" in found:
            words.append(f"{what}: refused")
            continue
        new, same = found["new"], found["same"]
        words.append(
            f"{what} {new['ratio']:5.2f} new {same['ratio']:5.2f} same "
            f"({1e3 * new['body_s']:6.1f} ms against {1e3 * new['disk_s']:6.1f}; "
            f"first {found['body_first_s']:5.2f} s)"
        )
    return "  ".join(words)


def main() -> None:
    words = [w for w in sys.argv[1:] if not w.startswith("--")]
    for case in cases():
        if words and not all(w in (case.family, case.law, case.body) for w in words):
            continue
        row = measured(case)
        print(json.dumps(row) if "--json" in sys.argv else line(row), flush=True)


if __name__ == "__main__":
    main()
