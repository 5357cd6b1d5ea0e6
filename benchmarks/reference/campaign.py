"""Random launches against a reference code that shares nothing with the package.

`motion.cpp` next to this file integrates the disk in the inertial frame in long double or quadruple
precision.  This driver launches disks at random under every law, tolerance and method, asks
`simulate` for the motion and its stated error, and the reference for the truth, twice.

    python benchmarks/reference/campaign.py --seed 1 --launches 300 --out found.jsonl

Each line of the file is one launch; a run that is started again resumes behind the last line.
"""

from __future__ import annotations

import argparse
import json
import math
import shutil
import subprocess
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import stability as st
from stability.bodies.newton_euler import STATES
from stability.motion.result import BY_CODE
from stability.motion.round_starts import gather_round as gather

SOURCE = Path(__file__).with_name("motion.cpp")
STAGES = ((14, 14.0), (10, 14.5))
"""Stages and digits of both reference runs."""
DRY = ((6, 11.0), (5, 10.5))
"""The same for dry friction, where steps are short."""
WIDTHS = (1e-6, 3e-6)
"""Slip speeds of regularised friction by which the reference approaches dry friction; what is left
is of their order, and seen as the difference of both runs."""
LAWS = ("viscous", "stiff", "linear", "stiff-linear", "smooth", "rough", "regularised", "coulomb")
SHARES = (0.28, 0.24, 0.1, 0.1, 0.06, 0.06, 0.08, 0.08)
METHODS = ("auto", "heyoka", "dop853", "lsoda", "radau", "bdf", "cvodes", "idas")
WEIGHTS = (0.58, 0.1, 0.08, 0.06, 0.02, 0.02, 0.12, 0.02)
ENDS = ("lift-off", "flat", "no-contact")
LASTING = ("moving", "settled")
EVALUATIONS = 400_000
"""Evaluations after which the reference gives a launch up."""


@dataclass(frozen=True)
class Launch:
    """One random launch; dimensionless."""

    number: int
    """In its campaign."""
    law: str
    """A member of `LAWS`."""
    k: float
    """Inertia factor."""
    mu: float
    """Friction."""
    epsilon: float
    """Slip speed of regularised friction."""
    start: list[float]
    """Six states."""
    last: float
    """Last time."""
    tolerance: float
    """Asked of `simulate`."""
    method: str
    """Asked of `simulate`."""
    samples: int
    """Number of times asked."""

    def contact(self) -> st.Contact:
        """The law."""
        kind = self.law.removeprefix("stiff-")
        if kind in ("viscous", "stiff"):
            return st.Viscous(self.mu)
        if kind == "linear":
            return st.LinearViscous(self.mu)
        if kind == "coulomb":
            return st.Coulomb(self.mu)
        if kind == "regularised":
            return st.RegularisedCoulomb(self.mu, self.epsilon)
        return st.Smooth() if kind == "smooth" else st.Rough()

    def line(self, stages: int, digits: float, width: float = 0.0) -> str:
        """The launch as the reference reads it; dry friction is regularised with a width."""
        kind = self.law.removeprefix("stiff-").replace("stiff", "viscous")
        kind, epsilon = ("regularised", width) if kind == "coulomb" else (kind, self.epsilon)
        numbers = [self.k, self.mu, epsilon, 1e-6, self.last, stages, digits, *self.start]
        return " ".join([kind, *map(repr, numbers), str(EVALUATIONS)])


@dataclass(frozen=True)
class Truth:
    """What the reference says of a launch."""

    outcome: str
    """moving, lift-off, flat, stuck (D falls to zero), exhausted, or lost (two runs disagree)."""
    time: Any
    """Of the end, in long double."""
    state: Any = field(repr=False)
    """Then, shape (6,), in long double."""
    error: float
    """Difference of both runs, each entry over 1 or its size."""


class Reference:
    """The compiled reference code, as a process that answers line by line.

    Parameters
    ----------
    folder
        Where the compiled code is put, or found.
    quadruple
        Whether quadruple precision is used in place of long double.
    """

    def __init__(self, folder: Path, *, quadruple: bool = False) -> None:
        compiler = shutil.which("g++")
        if compiler is None:
            raise FileNotFoundError("g++ is not installed; the reference code needs it.")
        code = folder / ("motion-quadruple" if quadruple else "motion-long")
        if not code.exists() or code.stat().st_mtime < SOURCE.stat().st_mtime:
            flags = ["-O3", "-std=gnu++17", *(["-DQUAD"] if quadruple else [])]
            subprocess.run(
                [compiler, *flags, str(SOURCE), "-o", str(code), "-lquadmath"], check=True
            )
        self.process = subprocess.Popen(
            [str(code)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def ask(self, line: str) -> tuple[str, Any, Any]:
        """Outcome, time and state of one run."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()
        words = self.process.stdout.readline().split()
        numbers = np.array([np.longdouble(w) for w in words[1:8]])
        return words[0], numbers[0], numbers[1:]

    def truth(self, launch: Launch) -> Truth:
        """Both runs, and how far they agree."""
        one, two = (
            self.ask(launch.line(*setting, width))
            for setting, width in zip(
                DRY if launch.law == "coulomb" else STAGES, WIDTHS, strict=True
            )
        )
        error = max(distance(one[2], two[2]), float(abs(one[1] - two[1])))
        agree = one[0] == two[0] and error < 1e-3
        return Truth(one[0] if agree else "lost", one[1], one[2], error)

    def close(self) -> None:
        """End the process."""
        self.process.communicate()


def distance(a: Any, b: Any) -> float:
    """Largest difference of two states, each entry over 1 or its size."""
    return float((np.abs(a - b) / np.maximum(1, np.abs(a))).max())


def random_launch(seed: int, number: int) -> Launch:
    """A launch that `simulate` takes, the same for the same seed and number."""
    # one law for a hundred launches, since heyoka compiles for each
    law = str(np.random.default_rng([seed, number // 100, 1]).choice(LAWS, p=SHARES))
    rng = np.random.default_rng([seed, number])
    while True:
        stiff = law.startswith("stiff")
        mu = 10.0 ** (rng.uniform(2, 5) if stiff else rng.uniform(-2, 1.5))
        epsilon = 10.0 ** rng.uniform(-5, -1)
        if law in ("regularised", "coulomb"):
            mu = 10.0 ** rng.uniform(-2, 0)
        k = float(rng.choice([0.25, 0.5, float(rng.uniform(0.2, 0.5))]))
        start = rng.normal(0.0, 1.0, 6) * [0, 1, 1.2, 1.2, 1, 1]
        start[0] = rng.uniform(0.4, math.pi - 0.4)
        start[4:] *= 10.0 ** rng.uniform(-2, 0) / (mu if stiff else max(1.0, mu))
        if law == "rough":
            start[4:] = 0
        last = 10.0 ** (rng.uniform(-0.5, 1.0) if stiff else rng.uniform(-0.3, 1.5))
        # whole decades, since heyoka compiles for each tolerance
        digits = int(rng.integers(2, 17)) if rng.random() < 0.6 else 9
        if law == "coulomb":  # the reference knows no more
            digits = min(digits, 5)
        launch = Launch(
            number,
            law,
            k,
            float(mu),
            float(epsilon),
            [float(v) for v in start],
            float(last),
            10.0**-digits,
            str(rng.choice(METHODS, p=WEIGHTS)),
            int(rng.choice([1, 11, 201])),
        )
        fast = max(1.0, *(abs(v) for v in start[1:4])) * last
        if launch.method in ("dop853", "heyoka") and stiff and mu * last > 1e4:
            continue  # an explicit method takes minutes
        if launch.method in ("radau", "bdf") and (digits > 8 or fast > 10):
            continue
        if launch.method in ("dop853", "lsoda") and fast > 60:
            continue
        try:
            gather(st.Disk(k=k), launch.contact(), launch.start, last)
        except st.StabilityError:
            continue
        return launch


def judged(launch: Launch, truth: Truth) -> dict[str, Any]:
    """What `simulate` says of a launch, and the truth."""
    began = time.perf_counter()
    run = st.simulate(
        st.Disk(k=launch.k),
        launch.contact(),
        launch.start,
        np.linspace(0, launch.last, launch.samples + 1)[1:],
        method=launch.method,
        tolerance=launch.tolerance,
    )
    took = time.perf_counter() - began
    outcome = BY_CODE[int(run.outcome)].word
    final = np.array([np.longdouble(run[name].values[-1]) for name in STATES])
    found: dict[str, Any] = {
        **asdict(launch),
        "outcome": outcome,
        "truth": truth.outcome,
        "used": str(run.method.values),
        "truth_error": truth.error,
        "seconds": took,
        "end": float(run.end_time),
        "true_end": float(truth.time),
        "stated": float(run.get("final_error", math.inf)),
        "stated_time": float(run.get("end_time_error", math.inf)),
        "steps": int(run.steps),
        "evidence": str(run.evidence.values),
    }
    found["error"] = distance(truth.state, final)
    found["late"] = float(abs(np.longdouble(float(run.end_time)) - truth.time))
    found["verdict"] = verdict(found)
    return found


def verdict(found: dict[str, Any]) -> str:
    """right, wrong (another outcome), below (stated error too small), open, or lost."""
    said, truly, slack = found["outcome"], found["truth"], 4 * found["truth_error"] + 1e-17
    if truly in ("lost", "exhausted"):
        return "lost"
    if said in ("undetermined", "unresolved", "non-unique"):
        return "open"
    truly = "no-contact" if truly == "stuck" else truly
    if truly != ("moving" if said in LASTING else said):
        return "wrong"
    if truly in ENDS and not found["late"] <= found["stated_time"] + slack:
        return "below"
    if truly != "no-contact" and not found["error"] <= found["stated"] + slack:
        return "below"
    return "right"


def campaign(
    seed: int, launches: int, out: Path | None, folder: Path, *, quadruple: bool = False
) -> Iterator[dict[str, Any]]:
    """Launches one by one; with a file, those that it does not hold.

    Parameters
    ----------
    seed, launches
        Which ones, and how many.
    out
        A file to which each is appended as one line of JSON.
    folder
        For the compiled reference code.
    quadruple
        Whether the truth is computed in quadruple precision.
    """
    first = sum(1 for _ in out.open()) if out is not None and out.exists() else 0
    reference = Reference(folder, quadruple=quadruple)
    try:
        for number in range(first, launches):
            launch = random_launch(seed, number)
            found = judged(launch, reference.truth(launch))
            if out is not None:
                with out.open("a") as file:
                    file.write(json.dumps(found) + "\n")
            yield found
    finally:
        reference.close()


def summary(found: list[dict[str, Any]]) -> str:
    """Counts, and how far stated errors lie above true ones."""
    lines = [f"{len(found)} launches: {dict(Counter(f['verdict'] for f in found))}"]
    lines.append(f"outcomes: {dict(Counter(f['outcome'] for f in found))}")
    factors = np.array(
        [
            f["stated"] / max(f["error"], 1e-18)
            for f in found
            if f["verdict"] in ("right", "below")
            and f["outcome"] in LASTING
            and math.isfinite(f["stated"])
        ]
    )
    if factors.size:
        at = [0, 0.1, 1, 10, 50, 90, 99]
        text = ", ".join(
            f"{p:g} %: {v:.3g}" for p, v in zip(at, np.percentile(factors, at), strict=True)
        )
        lines.append(f"stated over true error, {factors.size} lasting: {text}")
    for bad in found:
        if bad["verdict"] in ("wrong", "below"):
            lines.append(
                f"  {bad['verdict']} {bad['number']} {bad['law']} mu {bad['mu']:.3g} "
                f"{bad['method']}/{bad['used']} tolerance {bad['tolerance']:.2g}: "
                f"{bad['outcome']}, truth {bad['truth']} at {bad['true_end']:.9g}; "
                f"error {bad['error']:.2e} stated {bad['stated']:.2e}, "
                f"late {bad['late']:.1e} stated {bad['stated_time']:.1e}, "
                f"truth known to {bad['truth_error']:.0e}"
            )
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--launches", type=int, default=300)
    parser.add_argument("--out", type=Path, default=None)
    parser.add_argument("--folder", type=Path, default=Path("/tmp"))
    parser.add_argument("--quadruple", action="store_true")
    options = parser.parse_args()
    for found in campaign(
        options.seed, options.launches, options.out, options.folder, quadruple=options.quadruple
    ):
        if found["verdict"] in ("wrong", "below", "lost"):
            print(summary([found]).splitlines()[-1], found["verdict"], flush=True)
    if options.out is not None:
        print(summary([json.loads(line) for line in options.out.open()]))


if __name__ == "__main__":
    main()
