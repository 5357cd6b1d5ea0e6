"""How often a scene takes the cheapest rung that is truly fine enough.

`benchmarks/scenes.py --choice N` runs it on N random scenes.  Every rung runs alone, in turns with
the answer, so that a busy machine hits all alike.  The least of three times or more counts; times
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
LEAST, MOST, BUDGET, SLOW = 3, 9, 0.15, 2.0
"""Repeats: least, most; time after which no further one begins, and none of the least [s]."""
WORST = 3
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

    def best(self) -> tuple[str, Run]:
        """The cheapest rung whose true error is within the tolerance."""
        fine = {n: r for n, r in self.runs.items() if r.error <= 1}
        name = min(fine or {self.law: self.full}, key=lambda n: self.runs[n].time)
        return name, self.runs[name]

    @property
    def loss(self) -> float:
        """Time of the chosen rung over that of the best; infinite if it is not fine itself."""
        return self.chosen.time / self.best()[1].time if self.chosen.error <= 1 else math.inf

    @property
    def open(self) -> bool:
        """Whether a rung next to the full model is fine, so that there is a choice."""
        return any(r.error <= 1 for n, r in self.runs.items() if n != self.law)


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
    needed = {scene.contact.name, answer.model, "creep"}
    names = [n for n, (error, _) in found.items() if error <= 1 or n in needed]
    times = _times([scene.answer, *(lambda n=n: scene.answer(only=n) for n in names)])
    runs = {n: Run(t, *found[n]) for n, t in zip(names, times[1:], strict=True)}
    return Choice(number, _kind(scene), scene, answer, times[0], runs)


def _alone(scene: st.Scene, quantity: str, run: Any) -> dict[str, tuple[float, float]]:
    """True and estimated error of every rung that applies, over the tolerance."""
    found: dict[str, tuple[float, float]] = {}
    creep_holds, creep = True, scene.contact.name in ("viscous", "linear-viscous")
    for name in rungs_of(scene._problem(scene.contact), ()):
        order = creep and (name == "rough" or name.startswith("creep-"))
        if order and not creep_holds:
            continue
        mine = scene.answer(only=name)
        if name == "creep" or order:  # the orders after the last one are all the same
            creep_holds = mine.model == name or (name == "creep" and mine.model != "none")
        if mine.model == "none" or (order and mine.model != name):
            continue
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


def _rung(row: Choice) -> str:
    """Kind of the rung that answers."""
    name = row.answer.model
    if name == row.law:
        return "the law itself"
    return "creep of any order" if name == "rough" or name.startswith("creep") else name


# --- what is printed ---


def _share(losses: Iterable[float]) -> str:
    """How many ratios are small, and the largest three quantiles."""
    some = np.array(list(losses))
    good = int((some <= FACTOR).sum())
    return f"{good:4} of {len(some):4}  {100 * good / max(1, len(some)):5.1f} %   " + _spread(some)


def _spread(ratios: Iterable[float]) -> str:
    some = sorted(ratios)
    if not some:
        return ""
    return f"{statistics.median(some):8.3f} {np.quantile(some, 0.9):8.3f} {some[-1]:8.3f}"


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
    print(
        f"{len(rows)} random scenes, seed {seed}: how many take a rung that costs at most "
        f"{FACTOR} times the cheapest\nwhose true error is within the tolerance; the ratio: "
        "median, 90 %, largest"
    )
    choosy = [r for r in rows if r.open]
    print(f"  {'all':<28}{_share(r.loss for r in rows)}")
    print(f"  {'a smaller model is fine':<28}{_share(r.loss for r in choosy)}")
    always = _share(r.full.time / r.best()[1].time for r in choosy)
    print(f"  {'  with the full model always':<28}{always}")
    for kind, some in _grouped(rows, lambda r: r.kind).items():
        print(f"  {kind:<28}{_share(r.loss for r in some)}")
    missed = sum(not r.chosen.error <= 1 and r.chosen.estimate <= 1 for r in rows)
    print(f"  true error above the tolerance and estimate below it: {missed}")
    print("time of answer() over that of the full model alone: median, 90 %, largest")
    by = {"all": rows, **_grouped(rows, _rung)}
    for model, some in by.items():
        print(f"  {model:<28}{len(some):4} {_spread(r.whole / r.full.time for r in some)}")
    print("the worst choices")
    for row in sorted(rows, key=lambda r: -r.loss)[:WORST]:
        _show(row)


def _show(row: Choice) -> None:
    name, best = row.best()
    print(
        f"\nscene {row.number}, {row.kind}: {row.answer.model} {1e3 * row.chosen.time:.2f} ms, "
        f"{name} {1e3 * best.time:.2f} ms at a true error of {best.error:.2g} and an estimate of "
        f"{best.estimate:.2g} times the tolerance"
    )
    print(
        f"  horizon {row.scene.horizon:.3g}, tolerance {row.scene.tolerance:.2g}, "
        f"{row.scene.quantities[0]}, {row.scene.contact}"
    )
    print("  " + row.answer.report().replace("\n", "\n  "))
