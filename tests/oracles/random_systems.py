"""Random small systems with planted spectra, for claims that exact arithmetic judges.

Truth is what `exact_oracle` reads from the CasADi graph that the package is given; the plan's own
eigenvalues are compared with it (`judged_systems`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import casadi as ca
import numpy as np
from planted_spectra import (
    KINDS,
    REAL,
    Draw,
    Plan,
    Shape,
    accident,
    background,
    close,
    flags,
    flow,
    hidden,
    jumping,
    names,
    nearby,
    scaled,
    typical,
)

import stability as st


@dataclass
class Case:
    """A family of a random system, and what is asked of it."""

    kind: str
    seed: int
    family: st.Family
    asked: list[dict[str, float]]
    planned: list[Shape] | None = None
    branches: list[dict[str, ca.SX]] = field(default_factory=list)
    implicit: ca.SX | None = None
    lines: int = 0
    planned_lines: int | None = None
    honest: bool = True
    smooth: bool = True

    @property
    def system(self) -> st.System:
        return self.family.system

    def names(self) -> tuple[str, ...]:
        return (*self.family.at, *self.family.parameters)


# --- systems, by kind -------------------------------------------------------------------------


def assemble(
    draw: Draw, kind: str, seed: int, p: ca.SX, p0: float, plan: Plan, **more: Any
) -> Case:
    """A family of fixed points at a held state."""
    n = plan.size
    x, q = ca.SX.sym("x", n), ca.SX.sym("q")
    home = [draw.choice([0.0, 0.0, 0.0, 1.0, -0.5, 0.1]) for _ in range(n)]
    rates = flow(draw, plan, x - ca.DM(home), p)
    words = names(n)
    held = dict(zip(words, home, strict=True))
    kinky = more.pop("kinky", None)
    if kinky is not None:
        rates[0] += kinky(x[0] - home[0])
    options = {"typical": typical(draw, p0), **flags(draw), **more.pop("options", {})}
    if draw.random() < 0.3:
        system = st.System(kind, x, ca.vertcat(p, q), rates * (1 + q * q), words, ("p", "q"))
        family = st.Family(system, "fixed", ("q",), held=held, **options)
        planned = scaled(plan.shapes, 1 + q * q) or None
        asked = [{"p": value, "q": draw.choice([0.0, 1.0, 0.3])} for value in nearby(draw, p0)]
    else:
        system = st.System(kind, x, p, rates, words, ("p",))
        family = st.Family(system, "fixed", ("p",), held=held, **options)
        planned = plan.shapes or None
        asked = [{"p": value} for value in nearby(draw, p0)]
    return Case(kind, seed, family, asked, planned=planned, **more)


def planted(kind: str, seed: int) -> Case:
    """Real parts of one kind, alone, in pairs or in Jordan blocks, among stable ones."""
    draw = Draw(f"{kind} {seed}")
    p, p0, plan = ca.SX.sym("p"), draw.point(), Plan()
    size = draw.randint(2, 8 if kind == "zeros" else 6)
    for _ in range(draw.choice([1, 1, 2, 3])):
        value = REAL[draw.choice(KINDS[kind])](draw, p, p0)
        roll = draw.random()
        if roll < 0.6 or plan.size + 2 > size:
            plan.real(value)
        elif roll < 0.8:
            plan.pair(value, draw.constant())
        elif roll < 0.9:
            plan.square(value)
        else:
            plan.jordan(value, 2)
    background(draw, plan, p, size)
    return assemble(draw, kind, seed, p, p0, plan, smooth=kind not in ("graphs", "functions"))


def symmetric(seed: int, kind: str = "symmetric") -> Case:
    """Spectra that are mirrored in the imaginary axis, with the claim `conservative` or without."""
    draw = Draw(f"{kind} {seed}")
    p, p0, plan = ca.SX.sym("p"), draw.point(), Plan()
    for _ in range(draw.randint(1, 3)):
        roll = draw.random()
        if roll < 0.35:
            plan.square(-draw.constant() * draw.even(p))
        elif roll < 0.5:
            plan.pair(0.0, draw.constant() * draw.even(p))
        elif roll < 0.65:
            plan.quadruple(draw.choice([draw.constant(), draw.tiny() * (1 + p * p)]), 1.0)
        elif roll < 0.8:
            plan.square(accident(draw, p, p0))
        else:
            plan.square(hidden(draw, p))
    if draw.random() < 0.3:
        plan.real(hidden(draw, p))
    honest = True
    while plan.size > 6:
        plan.blocks.pop()
        plan.shapes.pop()
    if kind == "claimed":
        a = draw.choice([jumping, close, accident, lambda d, q, _: d.negative(q)])(draw, p, p0)
        (plan.real if draw.random() < 0.6 else lambda v: plan.pair(v, 1.0))(a)
        honest = False
    conservative = kind == "claimed" or draw.random() < 0.6
    if not conservative and draw.random() < 0.4:
        background(draw, plan, p, plan.size + 1)
    options = {"conservative": conservative}
    smooth = kind != "claimed"
    return assemble(draw, kind, seed, p, p0, plan, options=options, honest=honest, smooth=smooth)


def kinks(seed: int) -> Case:
    """A corner of the graph exactly at the member, where no linearisation exists."""
    draw = Draw(f"kinks {seed}")
    p, p0, plan = ca.SX.sym("p"), draw.point(), Plan()
    background(draw, plan, p, draw.randint(2, 5))
    c = draw.choice([-1, 1]) * draw.choice([0.5, 2.0, 20.0])
    corner = draw.choice(
        [
            lambda d: c * ca.fabs(d),
            lambda d: c * ca.fmax(d, 0),
            lambda d: c * ca.sqrt(d * d),
            lambda d: c * ca.sqrt(d**4 + d * d),
            lambda d: c * ca.if_else(d > 0, d, 2 * d),
            lambda d: c * ca.sign(d) * d,
            lambda d: c * d * d / ca.sqrt(d * d),
        ]
    )
    return assemble(draw, "kinks", seed, p, p0, plan, kinky=corner, smooth=False)


def folding(seed: int) -> Case:
    """Constants whose sums or products, rounded at each step, are not what they are exactly."""
    draw = Draw(f"folding {seed}")
    p, p0, n = ca.SX.sym("p"), draw.point(), draw.randint(2, 4)
    x = ca.SX.sym("x", n)
    rates = ca.SX.zeros(n)
    for i in range(n):
        if i and draw.random() < 0.6:
            rates[i] = -draw.choice([0.1, 0.3, 0.7, 3e-7]) * draw.even(p) * x[i]
            continue
        sign = draw.choice([-1, 1])
        terms = draw.choice(
            [
                (1.0, 1e-30, -1.0),
                (0.1, 0.2, -0.3),
                (1.0, 2.0**-60, -1.0),
                (3.0, 1e-17, -3.0),
                (1e16, 1.0, -1e16),
                (0.7, 0.1, -0.8),
                (1.0, -1.0),
                (-0.3, -0.1),
                (-1.0, -1e-20),
            ]
        )
        for c in terms:
            rates[i] += sign * c * x[i]
    if draw.random() < 0.3:
        rates = draw.choice([0.1, 1e-20, 1e-6, 0.3]) * rates
    system = st.System("folding", x, p, rates, names(n), ("p",))
    family = st.Family(system, "fixed", ("p",), held=dict.fromkeys(names(n), 0.0))
    return Case("folding", seed, family, [{"p": p0}])


def branches(seed: int) -> Case:
    """An equation with several roots: the member may lie on another branch than was looked at."""
    draw = Draw(f"branches {seed}")
    p, p0, plan = ca.SX.sym("p"), draw.point(), Plan()
    x = ca.SX.sym("x", draw.randint(2, 5))
    y, w = x[0], x[1:]
    roots = draw.sample(
        [ca.SX(1.0), ca.SX(0.0), p, 1 + p, p * p, p / 2, 2 - p, -p, ca.SX(-2.0), 1 / (2 + p * p)],
        draw.choice([2, 2, 3]),
    )
    c = draw.choice([1.0, -1.0, 2.0, -2.0, 0.125])
    implicit = None
    roll = draw.random()
    if roll < 0.65:
        equation, coefficients = c, None
        for r in roots:
            equation = equation * (y - r)
    else:
        coefficients = draw.choice(
            [[p, 0, -1], [0, p, 0, -1], [-p, -1, 0, 1], [p, 1, 0, -1], [p - 2, 0, 1], [p, 0, -1, 1]]
        )
        equation = sum(c * a * y**k for k, a in enumerate(coefficients))
        implicit = ca.vertcat(*[ca.SX(a) for a in coefficients])
    for _ in range(draw.choice([1, 1, 2])):
        away = draw.choice([*roots[:2], ca.SX(0.0), ca.SX(1.0)])
        plan.real(draw.choice([0.125, 1.0, -1.0, 0.5]) * draw.choice([1.0, p, y]) * (y - away))
    plan.blocks, plan.shapes = plan.blocks[: w.numel()], plan.shapes[: w.numel()]
    background(draw, plan, p, w.numel())
    rates = ca.vertcat(equation, flow(draw, plan, w, p))
    planned: list[Shape] | None = [*plan.shapes, ("re", ca.jacobian(equation, y))]
    if not plan.shapes:
        planned = None
    if draw.random() < 0.4:
        i = draw.randrange(1, x.numel())
        rates[i] += draw.choice([-1.0, 2.0]) * equation
        if draw.random() < 0.3:
            rates[0] += w[i - 1]
            planned = None
    guess = draw.choice([p0, 1 + p0, 1.3, 0.1, -1.0, 1.0, 0.5, 2.0, -2.0])
    words = names(x.numel())
    system = st.System("branches", x, p, rates, words, ("p",))
    family = st.Family(
        system,
        "steady",
        ("p",),
        held=dict.fromkeys(words[1:], 0.0),
        unknown={"a": guess},
        equations=("a",),
        typical=typical(draw, p0),
    )
    known = [] if implicit is not None else [{"a": r} for r in roots]
    asked = [{"p": v} for v in nearby(draw, p0)]
    return Case("branches", seed, family, asked, planned=planned, branches=known, implicit=implicit)


def lines(seed: int) -> Case:
    """Lines and surfaces of steady motions, curved or straight, with further zeros or without."""
    draw = Draw(f"lines {seed}")
    p, p0, plan = ca.SX.sym("p"), draw.point(), Plan()
    along = draw.choice([1, 1, 2])
    x = ca.SX.sym("x", along + draw.randint(1, 5))
    s, w = x[:along], x[along:]
    n = w.numel()
    s0 = draw.point()
    curved = draw.random() < 0.4
    source = draw.choice(["hidden", "accident", "close", "jumping", "vanishing"])
    smooth = source != "jumping"
    if draw.random() < 0.75 and not (curved and source == "hidden"):
        name, value = draw.choice([(s[0], s0), (p, p0)])
        plan.real(REAL[source](draw, name, value))
    if draw.random() < 0.3 and plan.size + 2 <= n:
        plan.square(draw.choice([-1.0, -1.0, 1.0]) * draw.constant() * (1 + s[0] * s[0]))
    background(draw, plan, p, n)
    h = ca.SX.zeros(n)
    if curved:
        for i in range(n):
            h[i] = draw.choice([0.0, s[0], s[0] ** 2 / 2, s[-1] * p, 1 - s[0]])
    z = w - h
    push = ca.SX([[draw.choice([0.0, 0.0, 1.0, -1.0]) for _ in range(n)] for _ in range(along)])
    slide = push @ z
    rates = ca.vertcat(slide, flow(draw, plan, z, p) + ca.jacobian(h, s) @ slide)
    words = names(x.numel())
    system = st.System("lines", x, p, rates, words, ("p",))
    at = words[:along]
    own = words[along:]
    where: Mapping[str, Any] = (
        {"unknown": {v: draw.choice([0.0, 0.5, 1.0]) for v in own}, "equations": own}
        if curved
        else {"held": dict.fromkeys(own, 0.0)}
    )
    family = st.Family(system, "line", at, **where, typical=typical(draw, p0), **flags(draw))
    asked = []
    for value in nearby(draw, s0):
        asked.append({at[0]: value, **({at[1]: draw.point()} if along == 2 else {}), "p": p0})
    planned = [*plan.shapes, *[("re", ca.SX(0))] * along] if plan.shapes else None
    known = [{v: h[i] for i, v in enumerate(own)}] if curved else []
    return Case(
        "lines", seed, family, asked, planned=planned, branches=known, lines=along, smooth=smooth
    )


def products(seed: int) -> Case:
    """Right-hand sides with a common factor that vanishes, or that is divided out again."""
    draw = Draw(f"products {seed}")
    p, p0, plan = ca.SX.sym("p"), draw.point(), Plan()
    size = draw.randint(2, 5)
    if draw.random() < 0.5:
        plan.real(draw.choice([hidden(draw, p), accident(draw, p, p0), draw.constant()]))
    background(draw, plan, p, size)
    x = ca.SX.sym("x", size)
    linear = flow(draw, plan, x, p)
    a = draw.choice([p0, 0.0, 1.0, math.nextafter(p0, 9), p0 * (1 + 1e-12)])
    factor = draw.choice(
        [
            p - a,
            (p - a) ** 2,
            p / p,
            p / (p - a),
            (p - a) * 2.0**-66,
            p**9,
            ca.fabs(p) - p,
            ca.fmax(p - a, 0),
            2.0**-66,
            ca.if_else(p == a, 0.0, 1.0),
            (p * p - a * p) / p,
        ]
    )
    if draw.random() < 0.6:
        rates = factor * linear
    else:
        rates = ca.vertcat(factor * linear[0], linear[1:])
    words = names(size)
    system = st.System("products", x, p, rates, words, ("p",))
    held = dict.fromkeys(words, 0.0)
    family = st.Family(system, "fixed", ("p",), held=held, typical=typical(draw, p0))
    return Case("products", seed, family, [{"p": v} for v in nearby(draw, p0)], smooth=False)


def hop() -> Case:
    """Two branches, y = 1 and y = 1 + p; on the first there is a zero that the other has not."""
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p")
    y = x[0] - 1
    system = st.System(
        "hop", x, p, ca.vertcat(y * (p - y), 0.1 * y * x[1], -x[2]), ("y", "z", "w"), ("p",)
    )
    family = st.Family(
        system, "steady", ("p",), held={"z": 0.0, "w": 0.0}, unknown={"y": 1.3}, equations=("y",)
    )
    return Case("hop", 0, family, [{"p": 0.31}], branches=[{"y": ca.SX(1)}, {"y": 1 + p}])


MAKERS: dict[str, Callable[[int], Case]] = {
    "zeros": lambda seed: planted("zeros", seed),
    "graphs": lambda seed: planted("graphs", seed),
    "factors": lambda seed: planted("factors", seed),
    "functions": lambda seed: planted("functions", seed),
    "symmetric": symmetric,
    "claimed": lambda seed: symmetric(seed, "claimed"),
    "branches": branches,
    "lines": lines,
    "products": products,
    "folding": folding,
    "kinks": kinks,
}


def case(kind: str, seed: int) -> Case:
    """The system of a kind that a seed names."""
    return MAKERS[kind](seed)


def point(chosen: Case, values: Sequence[dict[str, float]]) -> dict[str, Any]:
    """Arguments of `st.spectrum` for one asked point, or for several at once."""
    family = chosen.family
    at = np.array([[v[name] for name in family.at] for v in values])
    if len(family.at) == 1:
        at = at[:, 0]
    keys = {name: np.array([v[name] for v in values]) for name in family.parameters}
    if len(values) == 1:
        return {"at": at[0], **{k: float(v[0]) for k, v in keys.items()}}
    return {"at": at, **keys}
