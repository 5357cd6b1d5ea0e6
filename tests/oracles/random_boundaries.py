"""Random systems with planted changes of verdict along one axis, and what a search says of them."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import casadi as ca
from exact_oracle import Graph, Irrational, Kink, Meaningless, Rationals, exact, sloped, spectrum_of
from flint import fmpq
from planted_spectra import Draw, Expr, Plan, background, flow, hidden, names

import stability as st

LOW, HIGH = -1.0, 3.0


@dataclass
class Search:
    """A family, its axis, and every point at which an eigenvalue meets the imaginary axis."""

    seed: int
    family: st.Family
    axis: tuple[str, float, float, int]
    meets: list[float]
    rational: bool
    faults: list[str] = field(default_factory=list)


def _crossing(draw: Draw, p: ca.SX, meets: list[float]) -> Expr:
    """A real part with one to three zeros on the axis, which are recorded."""
    scan = [LOW + i * (HIGH - LOW) / 8 for i in range(9)]
    value: Expr = draw.choice([-1, 1]) * draw.choice([1.0, 0.25, 2.0**-20, 2.0**10])
    for _ in range(draw.choice([1, 1, 2, 3])):
        near = meets[-1] if meets and draw.random() < 0.3 else draw.uniform(LOW, HIGH)
        root = draw.choice(
            [
                round(near, 2),
                near + draw.choice([1e-3, 1e-6, 1e-9, 1e-12]),
                math.nextafter(near, 9),
                draw.choice(scan),
                draw.choice([LOW, HIGH]),
                draw.uniform(LOW, HIGH),
            ]
        )
        if not LOW <= root <= HIGH:
            continue
        meets.append(root)
        value = value * (p - root) ** draw.choice([1, 1, 1, 1, 2, 3])
    return value * draw.choice([1.0, 1 + p * p, 5 - p])


def search(seed: int) -> Search:
    """A system with planted boundaries; rational in p, or with a function that is not."""
    draw = Draw(f"boundaries {seed}")
    p, plan = ca.SX.sym("p"), Plan()
    meets: list[float] = []
    undamped = draw.random() < 0.25
    for _ in range(draw.choice([1, 1, 2])):
        value = _crossing(draw, p, meets)
        roll = draw.random()
        if undamped:
            plan.square(value)
        elif roll < 0.5:
            plan.real(value)
        elif roll < 0.85:
            plan.pair(value, draw.constant())
        else:
            plan.jordan(value, 2)
    if draw.random() < 0.25:
        plan.real(hidden(draw, p))
    if undamped:
        plan.square(-draw.constant() * draw.even(p + 1.5))
    else:
        background(draw, plan, p + 1.5, plan.size + draw.randint(0, 3))
        plan.blocks, plan.shapes = _tame(plan)
    x = ca.SX.sym("x", plan.size)
    rates = flow(draw, plan, x, p)
    rational = draw.random() < 0.8
    if not rational:
        rates = rates * draw.choice([ca.exp(p / 4), 2 + ca.sin(p), ca.sqrt(p + 3)])
    words = names(plan.size)
    system = st.System("crossings", x, p, rates, words, ("p",))
    conservative = undamped and draw.random() < 0.5
    family = st.Family(
        system, "fixed", ("p",), held=dict.fromkeys(words, 0.0), conservative=conservative
    )
    axis = ("p", LOW, HIGH, draw.choice([9, 9, 5, 17]))
    return Search(seed, family, axis, sorted(set(meets)), rational)


def _tame(plan: Plan) -> tuple[list[Any], list[Any]]:
    """The plan without safely unstable blocks, for those hide every change."""
    one = ca.SX.sym("one")
    kept = []
    for block in plan.blocks:
        free = ca.symvar(block[0, 0])
        start = ca.evalf(ca.substitute(block[0, 0], free[0] if free else one, 0.123))
        if free or float(start) <= 0:
            kept.append(block)
    return kept, []


class Verdicts:
    """Exact verdicts along the axis; a positive factor of the rates changes none of them."""

    def __init__(self, one: Search) -> None:
        self.graph = Graph(one.family.system.x, one.family.system.p, one.family.system.rhs)
        self.size = len(one.family.system.states)
        self.zeros: int | None = None

    def spectrum(self, p: fmpq) -> Any:
        try:
            out = sloped(self.graph(Rationals(), [fmpq(0)] * self.size, [p]))
        except (Irrational, Kink, Meaningless):
            return None
        return spectrum_of([d.slope for d in out])

    def __call__(self, p: fmpq) -> str:
        roots, zeros = self.spectrum(p)
        assert self.zeros is not None
        if any(r.side > 0 for r in roots):
            return "unstable"
        loose = zeros > self.zeros or any(r.side == 0 for r in roots)
        return "neutral" if loose else "stable"


def judge_search(one: Search) -> tuple[str, list[str]]:
    """How the search ended (a word), and what is wrong with what it said."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", st.StabilityWarning)
            found = st.boundaries(one.family, axis=one.axis)
    except st.StabilityError as error:
        return "refused", [] if "even" in str(error) else [f"refused: {error}"]
    except Exception as error:
        return "crashed", [f"{type(error).__name__}: {error}"[:300]]
    return ("complete" if found.complete else "open"), _faults(one, found)


def _faults(one: Search, found: Any) -> list[str]:
    truth = Verdicts(one)
    if not one.rational:
        # the factor is positive: verdicts are those of the system without it, read at its zeros
        return _only_claims(one, found)
    ends = [exact(LOW), *map(exact, one.meets), exact(HIGH)]
    middles = [(a + b) / 2 for a, b in zip(ends, ends[1:], strict=False) if a < b]
    truth.zeros = min(truth.spectrum(m)[1] for m in middles)
    wrong = []
    changes, touches = [], []
    for root in one.meets:
        at = exact(root)
        around = [m for m in middles if m < at][-1:] + [m for m in middles if m > at][:1]
        words = [truth(m) for m in around]
        if len(words) == 2 and words[0] != words[1]:
            changes.append((root, words))
        elif truth(at) != words[0] != "unstable":
            touches.append(root)
    taken: set[int] = set()
    for root, words in changes:
        near = [
            i
            for i, b in enumerate(found)
            if abs(exact(b.value) - exact(root)) <= exact(b.error) and i not in taken
        ]
        if near:
            taken.add(near[0])
            b = found[near[0]]
            if "unstable" in words and b.stable_below != (words[1] == "unstable"):
                wrong.append(f"stable_below is {b.stable_below} at {root}")
        elif found.complete or not any(u.low <= root <= u.high for u in found.unresolved):
            wrong.append(f"the change at {root!r} ({words}) is missed, complete={found.complete}")
    for i, b in enumerate(found):
        left, right = truth(exact(b.value) - exact(b.error)), truth(exact(b.value) + exact(b.error))
        at_end = not LOW + b.error < b.value < HIGH - b.error
        if left == right and not at_end and truth(exact(b.value)) == left:
            wrong.append(f"{b} is no change: {left} on both sides")
        elif i not in taken and not at_end and b.value not in touches:
            wrong.append(f"{b} is found twice or is no change")
    return wrong + _touches(found, touches)


def _touches(found: Any, touches: Sequence[float]) -> list[str]:
    inner = [t for t in touches if LOW < t < HIGH]
    said = [*found.touching, *[b.value for b in found]]
    return [
        f"the touching point {t!r} is missed"
        for t in inner
        if found.complete and not any(abs(t - s) < 1e-9 for s in said)
    ]


def _only_claims(one: Search, found: Any) -> list[str]:
    return [
        f"{b} is where no eigenvalue meets the axis"
        for b in found
        if not any(abs(exact(b.value) - exact(r)) <= exact(b.error) for r in one.meets)
    ]
