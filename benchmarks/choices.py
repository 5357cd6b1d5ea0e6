"""How often a scene takes the cheapest rung that is truly fine enough.

`benchmarks/scenes.py --choice N` runs it on N random scenes.  Every rung runs alone, in turns with
the answer, so that a busy machine hits all alike.  The least of five times or more counts; times
are those of the processor.  The truth is `simulate` at a tolerance 1e5 times finer.
"""

from __future__ import annotations

import math
import statistics
import sys
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import stability as st
from stability.scene.ladder import rungs_of

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "oracles"))
from random_scenes import STATES, random_scene, truth

LONGEST, ASKED = 100.0, ("final", "path")
"""Horizon and quantities of the scenes that are taken."""
SAMPLES, FACTOR = 201, 1.5
"""Samples of a path; time over that of the cheapest rung that counts as the same."""
LEAST, MOST, BUDGET, SLOW = 5, 15, 0.4, 2.0
"""Repeats: least, most; time after which no further one begins, and none of the least [s]."""
WORST = 8
"""Worst choices that are shown."""


@dataclass
class Run:
    """One rung, run alone."""

    time: float
    """Least time of the repeats [s]."""
    error: float
    """True error over the tolerance."""
    estimate: float
    """Its estimate over the tolerance."""


@dataclass
class Choice:
    """One scene: what was chosen, and what every rung would have given."""

    number: int
    kind: str
    scene: st.Scene
    answer: st.Answer
    whole: float
    """Least time of the answer [s]."""
    runs: dict[str, Run]

    @property
    def chosen(self) -> Run:
        """The rung of the answer; creep that chooses its order is what the answer ran."""
        name = self.answer.model
        creeps = name.startswith("creep") or (name == "rough" and name != self.law)
        return self.runs["creep" if creeps else name]

    @property
    def law(self) -> str:
        return str(self.scene.contact.name)

    @property
    def full(self) -> Run:
        return self.runs[self.law]

    def best(self, *, told: bool = False) -> tuple[str, Run]:
        """The cheapest rung whose true error is within the tolerance; told: its estimate too."""
        fine = {n: r for n, r in self.runs.items()
                if r.error <= 1 and (r.estimate <= 1 or not told)}  # fmt: skip
        name = min(fine or {self.law: self.full}, key=lambda n: self.runs[n].time)
        return name, self.runs[name]

    def loss(self, *, told: bool = False) -> float:
        """Time of the chosen rung over that of the best."""
        return self.chosen.time / self.best(told=told)[1].time


def choices(count: int, seed: int) -> Iterator[Choice]:
    """The first random scenes that fit, each with all its rungs."""
    number = found = 0
    while found < count:
        one = _choice(number, seed)
        number += 1
        if one is not None:
            found += 1
            yield one


def _choice(number: int, seed: int) -> Choice | None:
    """One scene with all its rungs; None where it does not fit or its truth is not known."""
    try:
        scene, quantity = random_scene(number, seed)
        if quantity not in ASKED or scene.horizon > LONGEST or scene.contact.name == "coulomb":
            return None
        answer = scene.answer()
        run = truth(scene, np.linspace(0.0, scene.horizon, SAMPLES))
    except st.StabilityError:
        return None
    if answer.model == "none" or not float(run.final_error) < 0.1 * scene.tolerance:
        return None
    found = _alone(scene, quantity, run)
    names = [n for n, (error, _) in found.items() if error < math.inf or n == scene.contact.name]
    times = _times([scene.answer, *(lambda n=n: scene.answer(only=n) for n in names)])
    runs = {n: Run(t, *found[n]) for n, t in zip(names, times[1:], strict=True)}
    return Choice(number, _kind(scene), scene, answer, times[0], runs)


def _alone(scene: st.Scene, quantity: str, run: Any) -> dict[str, tuple[float, float]]:
    """True and estimated error of every rung over the tolerance; infinite where none applies."""
    found = {}
    for name in rungs_of(scene._problem(scene.contact), ()):
        mine = scene.answer(only=name)
        if mine.model == "none":
            continue
        if name.startswith("creep-") and mine.model != name:
            continue  # the orders end before
        error = _error(quantity, mine, run)
        found[name] = error / scene.tolerance, float(mine.chosen.estimate)
    return found


def _error(quantity: str, mine: st.Answer, run: Any) -> float:
    """Largest error of the states, over 1 or their size; of the time of an early end too."""
    track = mine.motion[1]
    lasts = run.attrs["outcome"] in ("moving", "settled")
    if lasts != (track.finish is None):
        return math.inf
    clock = float(mine.motion[0].launches.scales["time"])
    end = float(run.end_time) / clock
    late = 0.0 if lasts else abs(track.finish.time - end) / max(1.0, end)
    ours, theirs = (np.stack([v[n].values for n in STATES], -1) for v in (mine.path, run))
    both = min(len(theirs), len(ours)) - 1 if quantity == "path" else 0  # samples before the end
    ours, theirs = (np.vstack([v[:both], v[-1:]]) for v in (ours, theirs))
    gap = np.abs(ours - theirs) / np.maximum(1, np.abs(theirs))
    return max(late, float(gap.max()))


def _times(calls: list[Any]) -> list[float]:
    """The least time of each call, all in turns."""
    least, began = [math.inf] * len(calls), time.perf_counter()
    for turn in range(MOST):
        if turn >= LEAST and time.perf_counter() - began > BUDGET:
            break
        for i, call in enumerate(calls):
            if least[i] == math.inf or least[i] < SLOW:
                start = time.process_time()
                call()
                least[i] = min(least[i], time.process_time() - start)
    return least


def _kind(scene: st.Scene) -> str:
    """Kind of a scene: law, friction, and whether the start is near a steady motion."""
    problem = scene._problem(scene.contact)
    size = problem.launches.settling.closest(problem.start, problem.p).distance
    law = scene.contact.name
    if law not in ("rough", "smooth"):
        mu = float(problem.p[1])
        law = "viscous, " + ("mu < 1" if mu < 1 else "mu < 100" if mu < 100 else "mu ≥ 100")
    return f"{law}, {'near' if size < 0.1 else 'far'}"


# --- what is printed ---


def _share(rows: list[Choice], *, told: bool = False) -> str:
    good = sum(row.loss(told=told) <= FACTOR for row in rows)
    return f"{good:4} of {len(rows):4}  {100 * good / len(rows):5.1f} %"


def _grouped(rows: Iterable[Choice], key: Any) -> dict[str, list[Choice]]:
    found: dict[str, list[Choice]] = {}
    for row in rows:
        found.setdefault(key(row), []).append(row)
    return dict(sorted(found.items()))


def report(count: int, seed: int) -> None:
    """Run the scenes, and print how often the choice is the best, and what it costs."""
    rows: list[Choice] = []
    for row in choices(count, seed):
        rows.append(row)
        if len(rows) % 20 == 0:
            print(f"{len(rows)} of {count} scenes", file=sys.stderr)
    table(rows, seed)


def table(rows: list[Choice], seed: int) -> None:
    """Print what the scenes have shown."""
    print(f"{len(rows)} random scenes, seed {seed}: the rung taken costs at most {FACTOR} times "
          "the cheapest whose true error is within the tolerance")  # fmt: skip
    print(f"  {'all':<26}{_share(rows)}")
    print(f"  {'of those that claim it':<26}{_share(rows, told=True)}")
    print(f"  {'true error above':<26}{sum(not r.chosen.error <= 1 for r in rows):4} of "
          f"{len(rows):4}")  # fmt: skip
    for kind, some in _grouped(rows, lambda r: r.kind).items():
        print(f"  {kind:<26}{_share(some)}")
    print("time of answer() over that of the full model alone: median, 90 %, largest")
    by = {"all": rows, **_grouped(rows, lambda r: r.answer.model)}
    for model, some in by.items():
        ratio = sorted(r.whole / r.full.time for r in some)
        print(f"  {model:<26}{len(some):4} {statistics.median(ratio):8.3f} "
              f"{np.quantile(ratio, 0.9):8.3f} {ratio[-1]:8.3f}")  # fmt: skip
    print("the worst choices")
    for row in sorted(rows, key=lambda r: -r.loss())[:WORST]:
        if row.loss() > FACTOR:
            _show(row)


def _show(row: Choice) -> None:
    name, best = row.best()
    print(f"\nscene {row.number}, {row.kind}: {row.answer.model} {1e3 * row.chosen.time:.2f} ms, "
          f"{name} {1e3 * best.time:.2f} ms at a true error of {best.error:.2g} and an estimate of "
          f"{best.estimate:.2g} times the tolerance")  # fmt: skip
    print(f"  horizon {row.scene.horizon:.3g}, tolerance {row.scene.tolerance:.2g}, "
          f"{row.scene.quantities[0]}, {row.scene.contact}")  # fmt: skip
    print("  " + row.answer.report().replace("\n", "\n  "))
