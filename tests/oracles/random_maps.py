"""Random small maps and the exact verdict of each cell; the truth takes nothing from the package.

For the disk the characteristic polynomial is the one of Kane's equations (`boundary_oracle`); for
a random system of one's own it is FLINT's of a matrix of rationals.  The roots on either side of
the imaginary axis are counted by a Sturm chain over Q.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import boundary_oracle
import casadi as ca
import mpmath
from exact_oracle import exact, sides, strip
from flint import fmpq, fmpq_mat, fmpq_poly

import stability as st

STABLE, UNSTABLE, NEUTRAL = 1, 2, 3
DIGITS = 120
"""Digits of a sine; no sign in these maps needs as many."""
LAWS: dict[str, Any] = {
    "viscous": st.Viscous,
    "linear-viscous": st.LinearViscous,
    "smooth": st.Smooth,
    "rough": st.Rough,
}
RANGES = {
    "k": (0.01, 0.5),
    "mass": (0.1, 10.0),
    "radius": (0.1, 10.0),
    "gravity": (0.5, 20.0),
    "mu": (1e-2, 1e2),
    "c": (1e-2, 1e2),
    "at": (0.05, 8.0),
    "theta": (0.05, 1.55),
    "phi_dot": (0.2, 6.0),
}
"""Values that are drawn, evenly in their logarithms."""


@dataclass
class RandomMap:
    """A call of `stability_map`, and the exact verdict at any two values of its axes."""

    family: Any
    axes: tuple[Any, Any]
    """(name, low, high, count, …) of x and y."""
    more: dict[str, Any]
    """Other arguments of the call."""
    truth: Callable[[Any, Any], int]
    """Code of the verdict from exact values along x and y."""
    text: str = field(default="")

    def call(self) -> Any:
        """The map."""
        return st.stability_map(self.family, x=self.axes[0], y=self.axes[1], **self.more)

    def near(self, draw: random.Random, place: tuple[float, float]) -> RandomMap:
        """The same in a narrow window about a place."""
        width = 10.0 ** draw.uniform(-14, -2)
        ends = []
        for (name, low, high, count, *_), value in zip(self.axes, place, strict=True):
            way = width * abs(value) or width
            below, above = (value + s * way * draw.uniform(0.3, 1) for s in (-1, 1))
            ends.append((name, max(below, low), min(above, high), count))
        return RandomMap(self.family, (ends[0], ends[1]), self.more, self.truth, self.text)


def code_of(polynomial: fmpq_poly) -> int:
    """The verdict of a polynomial."""
    rest, zeros = strip(polynomial)
    _, on, right = sides(rest)
    return UNSTABLE if right else NEUTRAL if on or zeros else STABLE


def maps(seed: int) -> Iterator[RandomMap]:
    """Random maps, four of five of the disk."""
    draw = random.Random(seed)
    while True:
        yield disk_map(draw) if draw.random() < 0.8 else own_map(draw)


def _span(draw: random.Random, name: str) -> tuple[Any, ...]:
    low, high = RANGES[name]
    ends = sorted(low * (high / low) ** draw.random() for _ in range(2))
    if ends[1] < 1.01 * ends[0]:
        ends = [low, high]
    log = draw.random() < 0.3
    return (name, *ends, draw.randint(5, 13), *(["log"] if log else []))


# --- the disk ---


def disk_map(draw: random.Random) -> RandomMap:
    """A family under a law, over two of all its numbers."""
    family, law = draw.choice(boundary_oracle.CASES)
    numbers = ["k", "mass", "radius", "gravity"]
    numbers += {"viscous": ["mu"], "linear-viscous": ["c"]}.get(law, [])
    members = ["theta", "phi_dot"] if family == "circling" else ["at"]
    first = draw.choice(members)
    second = draw.choice([n for n in (*members, *numbers) if n != first])
    axes = [first, second] if draw.random() < 0.5 else [second, first]
    spans = []
    for n in axes:
        kind = "theta" if (family, n) == ("tumbling", "at") else n
        spans.append((n, *_span(draw, kind)[1:]))
    fixed = {
        n: RANGES[n][0] * (RANGES[n][1] / RANGES[n][0]) ** draw.random()
        for n in (*members, *numbers)
    }
    if draw.random() < 0.5:
        fixed |= {"mass": 1.0, "radius": 1.0, "gravity": 1.0}
    if family == "tumbling":
        fixed["at"] = draw.uniform(*RANGES["theta"])
    disk = {n: fixed[n] for n in numbers[:4]}
    more: dict[str, Any] = {"disk": st.Disk(**disk)}
    if law == "viscous":
        more["contact"] = LAWS[law] if "mu" in axes else st.Viscous(fixed["mu"])
    elif law == "linear-viscous":
        more["contact"] = LAWS[law] if "c" in axes else st.LinearViscous(fixed["c"])
    else:
        more["contact"] = LAWS[law]()
    for n in members:
        if n not in axes:
            more[n] = fixed[n]
    names = f"{family} {law}"

    def truth(x: Any, y: Any) -> int:
        values = {n: exact(v) for n, v in fixed.items()} | dict(zip(axes, (x, y), strict=True))
        return code_of(_disk_polynomial(names, values))

    text = f"{names} {spans} {fixed}"
    return RandomMap(family, (spans[0], spans[1]), more, truth, text)


def _disk_polynomial(names: str, v: dict[str, Any]) -> fmpq_poly:
    family, law = names.split()
    turn = v.get("phi_dot", v["at"] if "at" in v else None)
    place = {"k": v["k"], "M": fmpq(1), "z": turn * turn * v["radius"] / v["gravity"], "s": fmpq(1)}
    if law == "viscous":
        place["M"] = v["mu"] ** 2 * v["gravity"] * v["radius"]
    elif law == "linear-viscous":
        place["M"] = (v["c"] / v["mass"]) ** 2 * v["radius"] / v["gravity"]
    if family in ("tumbling", "circling"):
        place["s"] = sine(v["theta"] if family == "circling" else v["at"])
    point = [place[n] for n in boundary_oracle.NAMES]
    coefficients = []
    for terms in boundary_oracle.polynomials()[names]:
        total = fmpq(0)
        for coefficient, *powers in terms:
            product = fmpq(coefficient)
            for value, power in zip(point, powers, strict=True):
                product *= value**power
            total += product
        coefficients.append(total)
    return fmpq_poly(coefficients)


@lru_cache(maxsize=4096)
def sine(angle: Any) -> Any:
    """A sine as a rational."""
    with mpmath.workdps(DIGITS + 10):
        value = mpmath.sin(mpmath.mpf(int(angle.p)) / int(angle.q))
        return fmpq(int(mpmath.nint(value * 10**DIGITS)), 10**DIGITS)


# --- systems of one's own ---


def own_map(draw: random.Random) -> RandomMap:
    """A linear system whose matrix is a polynomial or a ratio of such in two numbers."""
    size = draw.randint(2, 5)
    terms = [[_entry(draw) for _ in range(size)] for _ in range(size)]
    for i in range(size):
        terms[i][i] = [(draw.randint(-12, -1), 4, 0, 0), *terms[i][i]]
    p, states = ca.SX.sym("p", 2), ca.SX.sym("s", size)

    def matrix(x: Any, y: Any, ratio: Callable[[int, int], Any]) -> list[list[Any]]:
        return [
            [sum((ratio(n, d) * x**i * y**j for n, d, i, j in e), ratio(0, 1)) for e in row]
            for row in terms
        ]

    rows = matrix(p[0], p[1], lambda n, d: ca.SX(n) / d)  # quarters are doubles
    rates = ca.vertcat(*[sum(e * states[j] for j, e in enumerate(row)) for row in rows])
    names = tuple(f"s{i}" for i in range(size))
    system = st.System("random", states, p, rates, states=names, parameters=("a", "b"))
    family = st.Family(system, "rest", at=("a",), held=dict.fromkeys(names, 0.0))
    spans = []
    for n in ("a", "b"):
        low = draw.uniform(-3, 2)
        spans.append((n, low, low + 10 ** draw.uniform(-2, 0.6), draw.randint(5, 13)))

    def truth(x: Any, y: Any) -> int:
        return code_of(fmpq_mat(matrix(x, y, fmpq)).charpoly())

    text = f"own {terms} {spans}"
    return RandomMap(family, (spans[0], spans[1]), {}, truth, text)


def _entry(draw: random.Random) -> list[tuple[int, int, int, int]]:
    """Terms of an entry: numerator, denominator, powers of both numbers."""
    return [
        (draw.randint(-8, 8), 4, draw.randint(0, 2), draw.randint(0, 2))
        for _ in range(draw.choice((0, 1, 1, 2)))
    ]
