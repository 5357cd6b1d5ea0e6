"""Random systems with planted boundaries along an axis in which they are not rational.

Real parts of eigenvalues are functions whose zeros have closed forms.  Integer matrices with
determinant one hide them.  In some families the functions take an unknown u that is solved for, and
the axis p is a known function of u.  Truth comes from mpmath to sixty digits.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import casadi as ca
import mpmath
from planted_spectra import Draw, Plan, flow, names

import stability as st
from stability.base.errors import NoMemberError

DIGITS = 60
ZERO = mpmath.mpf(10) ** -40
Function = Callable[[Any, Any], Any]
"""(argument, module of functions) → value: CasADi's or mpmath's."""


class Mp:
    """mpmath under the names of CasADi."""

    def __getattr__(self, name: str) -> Any:
        return getattr(mpmath, name)


MP = Mp()


@dataclass
class Planted:
    """A function and its zeros."""

    function: Function
    zeros: list[Any]


@dataclass
class Question:
    """A family, its axis, and the planted real parts (or squares) as functions of v."""

    family: st.Family
    axis: tuple[Any, ...]
    values: list[Function]
    meets: list[Any]
    """Values of p at which a planted function vanishes, mpmath, in increasing order."""
    inverse: Callable[[Any], Any]
    """v from p."""
    even: bool
    kind: str = ""
    words: list[str] = field(default_factory=list)


def _simple(draw: Draw, low: Any, high: Any, *, kinks: bool) -> Planted:
    """A function with simple zeros; `kinks` where it does not depend on a state."""
    c = draw.uniform(0.3, 4)
    r = draw.uniform(float(low), float(high))
    w = draw.choice([1.0, 2.0, 3.5])
    half, sine = draw.choice([0.5, -0.25, 0.75]), draw.choice([0.3, -0.7, 0.0, 0.99])
    which = draw.randrange(9 if kinks else 8)
    pi = mpmath.pi
    if which == 0:
        return Planted(lambda v, f: f.exp(v) - c, [mpmath.log(c)])
    if which == 1:
        return Planted(lambda v, f: f.tanh(v - r) - half, [r + mpmath.atanh(half)])
    if which == 2:
        base = mpmath.asin(sine)
        zeros = [(b + 2 * k * pi) / w for k in range(-8, 9) for b in (base, pi - base)]
        return Planted(lambda v, f: f.sin(w * v) - sine, zeros)
    if which == 3:
        zeros = [mpmath.mpf(r), *(pi / 2 + k * pi for k in range(-8, 8))]
        return Planted(lambda v, f: (v - r) * f.cos(v), zeros)
    if which == 4:
        return Planted(
            lambda v, f: f.sqrt(v * v + 1 + v) - 1.25,
            [(-1 + s * mpmath.sqrt(1 + 2.25)) / 2 for s in (1, -1)],
        )
    if which == 5:
        return Planted(lambda v, f: f.atan(v) - half, [mpmath.tan(half)])
    if which == 6:
        return Planted(lambda v, f: f.exp(-v) - c, [-mpmath.log(c)])
    if which == 8:
        return Planted(lambda v, f: f.fabs(v) - c, [mpmath.mpf(c), -mpmath.mpf(c)])
    return Planted(
        lambda v, f: f.log(v * v + c) - 1,
        [s * mpmath.sqrt(mpmath.e - c) for s in (1, -1) if mpmath.e > c],
    )


def _function(draw: Draw, low: Any, high: Any, ends: Sequence[float]) -> Planted:
    """A function of the plan; `ends` are those of the axis where it is a function of the axis."""
    roll = draw.random()
    sign, size = draw.choice([-1, 1]), draw.choice([1.0, 1.0, 0.25, 8.0, 2.0**-20])
    one = _simple(draw, low, high, kinks=bool(ends))
    if roll < 0.1:  # a pair close together
        c, gap = draw.uniform(0.6, 3), draw.choice([1e-2, 1e-4, 1e-6, 1e-8])
        one = Planted(
            lambda v, f: (f.exp(v) - c) * (f.exp(v) - c - gap),
            [mpmath.log(c), mpmath.log(mpmath.mpf(c) + mpmath.mpf(gap))],
        )
    elif roll < 0.2:  # a touching zero
        inner = one.function
        one = Planted(lambda v, f: inner(v, f) * inner(v, f), one.zeros)
    elif roll < 0.3 and ends:  # a zero at an end
        end = draw.choice(ends)
        one = Planted(
            draw.choice([lambda v, f: f.tanh(v - end), lambda v, f: f.exp(v - end) - 1]),
            [mpmath.mpf(end)],
        )
    elif roll < 0.4:
        one = Planted(lambda v, f: f.exp(-v * v) * (2 + f.sin(3 * v)), [])
        sign = -1 if draw.random() < 0.8 else 1
    plain = one.function
    return Planted(lambda v, f: sign * size * plain(v, f), one.zeros)


AXES: dict[str, Function] = {
    "plain": lambda u, _: u,
    "tanh": lambda u, f: u + f.tanh(u),
    "exp": lambda u, f: u + f.exp(u),
    "cos": lambda u, f: u - f.cos(u),
}
"""p as an increasing function of the unknown u; the slope of the last is zero at 3π/2."""


def question(seed: int) -> Question:
    """A random question."""
    draw = Draw(f"transcendental {seed}")
    kind = draw.choice(["plain", "plain", "tanh", "exp", "cos"])
    low, high = draw.choice([(-1.0, 3.0), (0.0, 2.5), (-1.25, 0.0), (0.25, 6.0)])
    forward = AXES[kind]
    with mpmath.workdps(DIGITS):
        ends = [_solved(forward, mpmath.mpf(v)) for v in (low, high)]
        parts = [
            _function(draw, *ends, [low, high] if kind == "plain" else [])
            for _ in range(draw.choice([1, 1, 2]))
        ]
        meets = {forward(v, MP) for part in parts for v in part.zeros}
        inside = sorted(z for z in meets if low <= z <= high)
    even = kind == "plain" and draw.random() < 0.3
    family, axis = _family(draw, kind, parts, low, high, even)
    return Question(
        family, axis, [p.function for p in parts], inside, lambda p: _solved(forward, p), even, kind
    )


def _solved(forward: Function, p: Any) -> Any:
    """The u of a p: bisection, since p increases with u."""
    low, high = mpmath.mpf(-9), mpmath.mpf(9)
    if forward(mpmath.mpf(1.5), MP) == 1.5:
        return p
    for _ in range(220):
        middle = (low + high) / 2
        low, high = (middle, high) if forward(middle, MP) < p else (low, middle)
    return (low + high) / 2


def _family(
    draw: Draw, kind: str, parts: Sequence[Planted], low: float, high: float, even: bool
) -> tuple[st.Family, tuple[Any, ...]]:
    p, u = ca.SX.sym("p"), ca.SX.sym("u")
    v = p if kind == "plain" else u
    plan = Plan()
    for part in parts:
        value, roll = part.function(v, ca), draw.random()
        if even:
            plan.square(value)
        elif roll < 0.5:
            plan.real(value)
        elif roll < 0.93:
            plan.pair(value, draw.constant())
        else:
            plan.jordan(value, 2)
    if even:
        plan.square(-draw.constant() * (7 + ca.tanh(v)))
    for _ in range(0 if even else draw.randint(0, 2)):
        stable = -draw.constant() * draw.choice([ca.exp(v / 4), 2 + ca.sin(v), 1 + v * v])
        draw.choice([plan.real, lambda a: plan.pair(a, 1.5), lambda a: plan.jordan(a, 2)])(stable)
    words = names(plan.size)
    d = ca.SX.sym("x", plan.size)
    rates = flow(draw, plan, d, v)
    axis = ("p", low, high, draw.choice([2, 5, 9]))
    if kind == "plain":
        if draw.random() < 0.2 and low > 0:
            axis = (*axis, "log")
        system = st.System("planted", d, p, rates, words, ("p",))
        held = dict.fromkeys(words, 0.0)
        return st.Family(system, "fixed", ("p",), held=held, conservative=even), axis
    forward = AXES[kind]
    own = p - forward(u, ca) + d[0]
    both = ca.vertcat(d, u), p, ca.vertcat(rates, own)
    system = st.System("planted", *both, (*words, "u"), ("p",))
    family = st.Family(
        system,
        "solved",
        ("p",),
        held=dict.fromkeys(words, 0.0),
        unknown={"u": 0.3},
        equations=("u",),
    )
    return family, axis


# --- truth ---


def verdict(one: Question, p: Any) -> str:
    """stable, neutral or unstable at a p, from the planted functions."""
    v = one.inverse(p)
    values = [f(v, MP) for f in one.values]
    if any(x > ZERO for x in values):
        return "unstable"
    return "neutral" if any(abs(x) <= ZERO for x in values) else "stable"


def judge(one: Question) -> tuple[str, list[str], float]:
    """How the search ended (a word), what is wrong, and the share of the axis left unresolved."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", st.StabilityWarning)
            found = st.boundaries(one.family, axis=one.axis)
    except NoMemberError:
        return "refused", [], 0.0
    except Exception as error:
        return "crashed", [f"{type(error).__name__}: {error}"[:300]], 0.0
    low, high = one.axis[1], one.axis[2]
    share = sum(u.high - u.low for u in found.unresolved) / (high - low)
    with mpmath.workdps(DIGITS):
        return ("complete" if found.complete else "open"), _faults(one, found), share


def _faults(one: Question, found: Any) -> list[str]:
    low, high = mpmath.mpf(one.axis[1]), mpmath.mpf(one.axis[2])
    step = mpmath.mpf(10) ** -9
    distinct: list[Any] = []
    for z in one.meets:
        if not distinct or z - distinct[-1] > ZERO:
            distinct.append(z)
    wrong, taken = [], set()
    for i, z in enumerate(distinct):
        before = distinct[i - 1] if i else min(low, z - step)
        after = distinct[i + 1] if i + 1 < len(distinct) else max(high, z + step)
        sides = [verdict(one, (before + z) / 2), verdict(one, (z + after) / 2)]
        near = [k for k, b in enumerate(found) if k not in taken and abs(b.value - z) <= b.error]
        open_ = any(u.low <= z <= u.high for u in found.unresolved)
        if "unstable" in sides and sides[0] != sides[1]:
            if near:
                taken.add(near[0])
                if found[near[0]].stable_below != (sides[1] == "unstable"):
                    wrong.append(f"wrong side at {z}")
            elif not open_:
                wrong.append(f"missed {mpmath.nstr(z, 20)} {sides}, complete={found.complete}")
        elif verdict(one, z) != sides[0] and not near and not open_:
            if not any(abs(t - z) < 1e-9 for t in found.touching):
                wrong.append(f"missed the single point {mpmath.nstr(z, 20)}")
        elif near and not open_:
            wrong.append(f"{found[near[0]]} is no change: {sides}")
        else:
            taken |= set(near)
    wrong += [f"{b} is no change" for k, b in enumerate(found) if k not in taken]
    return wrong
