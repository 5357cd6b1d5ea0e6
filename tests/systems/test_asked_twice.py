"""Random systems with irrational numbers or several branches: every question twice, in any order.

Their eigenvalues are planted.  So each answer is judged by mpmath and NumPy alone, and the second
answer to a question must be the first one, with any others in between.
"""

from __future__ import annotations

import random
import warnings
from collections import Counter
from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Any

import casadi as ca
import mpmath
import numpy as np
import pytest

import stability as st
from stability.base.verdict import BY_CODE

Planted = Callable[[float, float, float], list[complex]]

NUMBERS: list[Callable[[Any, Any, Any], Any]] = [
    lambda s, _, f: f.sqrt(2 + s),
    lambda s, *_: (2 + s) ** (1 / 3),
    lambda s, _, f: (1 + f.sqrt(5 + s)) / 2,
    lambda s, _, f: f.sqrt(2 + f.sqrt(2 + s)),
    lambda s, _, f: f.sqrt(3 + s) / f.sqrt(2 + 3 * s),
    lambda s, _, f: f.sqrt(3 + s) - f.sqrt(2 - s),
    lambda s, _, f: f.exp(s) * f.sqrt(2),
    lambda _, q, f: f.sqrt(2 + q * q),
    lambda s, q, f: f.sqrt(2 + q + q * q + s),
]
"""Positive numbers at a state s = 0 and a parameter q, by the functions of CasADi or mpmath."""


@dataclass(frozen=True)
class Case:
    """A family with planted eigenvalues."""

    family: st.Family
    at: float | None
    """Value of a family parameter that is a state; None where p names the members."""
    planted: Planted
    """Eigenvalues at (unknown, p, q), without those that are zero by structure."""
    rate: Callable[[float, float, float], float]
    """What vanishes at the unknown."""

    def given(self, p: float, q: float) -> dict[str, Any]:
        """Arguments for a member."""
        return {"at": p, "q": q} if self.at is None else {"at": self.at, "p": p, "q": q}

    def there(self, p: float, q: float) -> list[complex]:
        """The planted eigenvalues at the member; empty where there is none."""
        try:
            found = st.spectrum(self.family, **self.given(p, q))
        except st.StabilityError:
            return []
        y = float(found.states[0]) if self.family.unknown else 0.0
        assert abs(self.rate(y, p, q)) < 1e-8
        return self.planted(y, p, q)

    def growth(self, p: float, q: float) -> float | None:
        """The largest planted real part at the member; None where there is none."""
        return max((v.real for v in self.there(p, q)), default=None)

    def kind(self, p: float, q: float) -> str:
        """What an unstable member next to a boundary has crossed."""
        found = {abs(v.imag) > 1e-6 for v in self.there(p, q) if v.real > ROUNDING}
        return "static and flutter" if len(found) > 1 else "flutter" if True in found else "static"


def pair(trace: float, stiffness: float) -> list[complex]:
    """Roots of λ² - trace λ + stiffness."""
    return list(map(complex, np.roots([1, -trace, stiffness])))


def with_a_number(rng: random.Random) -> Case:
    """States held at zero, mixed by whole numbers; roots of numbers in each eigenvalue."""
    one, two = rng.choices(NUMBERS, k=2)
    lift, tilt, off = (rng.randint(-4, 4) / 4 for _ in range(3))
    stiffness, line = rng.choice([1, 2, 3]), rng.random() < 0.5
    x, p = ca.SX.sym("x", 3), ca.SX.sym("P", 2)
    mix = np.eye(3)
    for _ in range(3):
        i, j = rng.sample(range(3), 2)
        mix[i] += rng.choice([-1, 1]) * mix[j]
    a, u, v = ca.vertsplit(ca.mtimes(ca.DM(mix), x))
    own = ca.vertcat(
        one(a, p[1], ca) * (p[0] - lift) * a,
        v,
        -stiffness * u + two(a, p[1], ca) * (p[1] - tilt * p[0] - off) * v + a * u - v**3,
    )
    rates, states = ca.mtimes(ca.DM(np.rint(np.linalg.inv(mix))), own), ca.SX(x)
    names = ("x", "y", "z")
    if line:  # a zero by structure
        c = ca.SX.sym("c")
        rates, states, names = ca.vertcat(rates, a**2), ca.vertcat(x, c), (*names, "c")
    system = st.System("asked", states, p, rates, states=names, parameters=("p", "q"))
    family = st.Family(
        system, "rest", at=("c",) if line else ("p",), held=dict.fromkeys(names[:3], 0.0)
    )

    def planted(_: float, p_: float, q: float) -> list[complex]:
        first, second = (float(k(mpmath.mpf(0), mpmath.mpf(q), mpmath)) for k in (one, two))
        return [complex(first * (p_ - lift)), *pair(second * (q - tilt * p_ - off), stiffness)]

    return Case(family, 0.5 if line else None, planted, lambda *_: 0.0)


def with_branches(rng: random.Random, guess: float | None) -> Case:
    """An unknown with several branches, and a pair that it damps; from above, the largest one."""
    lines = [
        (rng.choice([-1, 0.5, 1]), rng.choice([-1, 0, 0.5, 1]), rng.choice([0, 0, 1]))
        for _ in range(rng.choice([2, 3]))
    ]
    curved, sign, off = rng.random() < 0.5, rng.choice([-1, 1]), rng.choice([0.25, 1.0])
    x, p = ca.SX.sym("x", 3), ca.SX.sym("P", 2)

    def rate(y: Any, p_: Any, q: Any) -> Any:
        out = sign
        for a, b, c in lines:
            out = out * (y - a * p_ - b - c * q)
        return out * (y * y - p_ * p_ - 1) if curved else out

    y, u, v = ca.vertsplit(x)
    rates = ca.vertcat(rate(y, p[0], p[1]), v, -2 * u + (y - off) * v - v**3)
    system = st.System("asked", x, p, rates, states=("y", "u", "v"), parameters=("p", "q"))
    family = st.Family(
        system,
        "m",
        at=("p",),
        held={"u": 0.0, "v": 0.0},
        equations=("y",),
        unknown={"y": 5.0 if guess is None else guess},
        typical={"p": 0.7, "q": 0.4},
    )

    def planted(y_: float, p_: float, q: float) -> list[complex]:
        slope = mpmath.diff(lambda w: rate(w, p_, q), mpmath.mpf(y_))
        return [complex(slope), *pair(y_ - off, 2)]

    return Case(family, None, planted, rate)


def wrong_word(word: str, growth: float | None) -> bool:
    """Whether a verdict contradicts a planted growth rate that is clearly not zero."""
    if growth is None or abs(growth) < 1e-7:
        return False
    return word == ("stable" if growth > 0 else "unstable")


ROUNDING = 1e-12
"""Largest planted growth rate that counts as zero."""
LOW, HIGH = -1.5, 1.75
"""Ends of the axis p."""


def questions(case: Case, p: float, q: float) -> dict[str, tuple[Callable[[], Any], Any]]:
    """Each question with its judge, which says whether the answer is wrong."""
    family, given = case.family, case.given(p, q)
    others = {k: v for k, v in given.items() if k != "p" and (k != "at" or case.at is not None)}
    plane = {"at": case.at} if case.at is not None else {}

    def spectrum(found: Any) -> bool:
        y = float(found.states[0]) if family.unknown else 0.0
        right = case.planted(y, p, q)
        near = [min(abs(complex(v) - r) for v in found.eigenvalues) for r in right]
        bad = max(near) > 1e-7 or len(found.eigenvalues) != len(right)
        return bad or wrong_word(found.verdict.word, max(v.real for v in right))

    def places(found: Any) -> bool:
        step = 1e-7
        for point in found:
            sides = [case.growth(float(point.value) + s, q) for s in (-step, step)]
            # a pair may stay on the axis: one side is then neutral, its rate 0 but for rounding
            if None in sides or (sides[0] > ROUNDING) == (sides[1] > ROUNDING):
                return True
            way = step if point.stable_below else -step
            if point.crossing.word.replace("_", " ") != case.kind(float(point.value) + way, q):
                return True
        ends = [LOW, *(float(b.value) for b in found), HIGH]
        for low, high in zip(ends, ends[1:], strict=False) if found.complete else ():
            inner = [case.growth(low + (high - low) * s / 8, q) for s in range(1, 8)]
            if len({g > 0 for g in inner if g is not None and abs(g) > 1e-7}) > 1:
                return True
        return False

    def births(found: Any) -> bool:
        growths = [(case.growth(float(one.at), q), one.unstable) for one in found]
        # another eigenvalue may be unstable where a pair crosses
        return any(g is None or (abs(g) > 1e-6) != (n > 0) for g, n in growths)

    def cells(found: Any) -> bool:
        return any(
            code in (1, 2) and wrong_word(BY_CODE[int(code)].word, case.growth(float(a), float(b)))
            for b, row in zip(found.q.values, found.verdict.values, strict=True)
            for a, code in zip(found.p.values, row, strict=True)
        )

    def doubles(found: Any) -> bool:
        return any(
            abs(case.growth(d.x, d.y) or 0.0) > 1e-6 for d in found if d.kind.word != "Bautin"
        )

    x, y = ("p", LOW, HIGH, 3), ("q", -1.0, 1.0, 3)
    return {
        "spectrum": (lambda: st.spectrum(family, **given), spectrum),
        "certified": (lambda: st.spectrum(family, **given, certify=True), spectrum),
        "boundaries": (lambda: st.boundaries(family, axis=("p", LOW, HIGH, 5), **others), places),
        "hopf": (lambda: st.hopf(family, axis=("p", LOW, HIGH, 5), **others), births),
        "conditions": (
            lambda: st.conditions(family).verdict(**given),
            lambda word: wrong_word(word.word, case.growth(p, q)),
        ),
        "latex": (lambda: st.latex(family), lambda _: False),
        "map": (lambda: st.stability_map(family, x=x, y=y, boundaries=True, **plane), cells),
        "codimension two": (lambda: st.codimension_two(family, x=x, y=y, **plane), doubles),
    }


def written(answer: Any) -> str:
    """An answer without the time at which it was given."""
    if hasattr(answer, "verdict") and hasattr(answer, "data_vars"):
        return repr({n: v.values.tolist() for n, v in answer.data_vars.items()})
    return repr(answer)


def campaign(cases: list[Case], rng: random.Random, without: Collection[str]) -> Counter[str]:
    """Counts of what was asked of some systems that live at the same time."""
    count: Counter[str] = Counter()
    asked = []
    for number, case in enumerate(cases):
        p, q = (rng.randint(-11, 13) / 8 for _ in range(2))
        some = questions(case, p, q)
        asked += [
            (number, name, *some[name]) for name in some if name not in without for _ in range(2)
        ]
    rng.shuffle(asked)
    first: dict[tuple[int, str], str] = {}
    for number, name, ask, wrong in asked:
        count["questions"] += 1
        try:
            answer = ask()
        except st.StabilityError as refusal:
            answer = str(refusal)
            count["refused"] += 1
        else:
            if (number, name) not in first and wrong(answer):
                count["wrong"] += 1
                rates = cases[number].family.system.rhs
                count[f"wrong {name} of {number}: {rates} {written(answer)}"] += 1
        if first.setdefault((number, name), written(answer)) != written(answer):
            count["other answers"] += 1
            answers = f"{first[number, name]} and {written(answer)}"
            count[f"other answers to {name} of {number}: {answers}"] += 1
    return count


def cases_of(seed: int, numbers: int, branches: int) -> tuple[list[Case], random.Random]:
    """Seeded systems."""
    rng = random.Random(seed)
    found = [with_a_number(rng) for _ in range(numbers)]
    return found + [with_branches(rng, None) for _ in range(branches)], rng


def asked(cases: list[Case], rng: random.Random, without: Collection[str] = ()) -> Counter[str]:
    """As `campaign`, without the warnings that a search is not complete."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", st.StabilityWarning)
        count = campaign(cases, rng, without)
    assert count["wrong"] == count["other answers"] == 0, count
    return count


@pytest.mark.parametrize("seed", range(3))
def test_questions_on_numbers_have_the_planted_answer_twice_in_any_order(seed: int) -> None:
    count = asked(*cases_of(seed, 2, 0), without=("hopf", "map", "codimension two"))
    assert count["questions"] == 20
    assert count["refused"] <= 8  # conditions and LaTeX have no exact form of a root of a number


@pytest.mark.parametrize("seed", range(3, 6))
def test_questions_on_branches_have_the_planted_answer_twice_in_any_order(seed: int) -> None:
    count = asked(*cases_of(seed, 0, 2), without=("boundaries", "hopf", "map", "codimension two"))
    assert count["questions"] == 16
    assert count["refused"] <= 8  # members on another branch than the conditions


def test_a_pair_that_stays_on_the_axis_is_not_what_crosses() -> None:
    """Its real part is 0 for all p, and 3e-309 by rounding: another eigenvalue is irrational."""
    case = cases_of(20074, 5, 0)[0][3]
    [found] = st.boundaries(case.family, axis=("p", LOW, HIGH, 5), q=-0.25, at=case.at)
    assert case.planted(0.0, 1.0, -0.25)[1].real == 0
    assert (found.value, found.crossing.word, found.frequencies) == (0.0, "static", ())


@pytest.mark.long
@pytest.mark.parametrize("seed", range(100, 108))
def test_a_campaign_of_questions_in_any_order(seed: int) -> None:
    """As above with more systems, and with guesses from which the root-finder changes branches."""
    cases, rng = cases_of(seed, 3, 1)
    cases.append(with_branches(rng, rng.uniform(-2, 2)))
    print(dict(asked(cases, rng)))
