"""First members from poor guesses, or none: the steady states are known in closed form."""

import math
from typing import Any

import casadi as ca
import numpy as np
import pytest

import stability as st
from stability.base.errors import NoMemberError

Rates = Any


def built(rates: Rates, states: str, **values: float) -> Any:
    x, p = ca.SX.sym("x", len(states)), ca.SX.sym("p", len(values))
    given = rates(*ca.vertsplit(x), *ca.vertsplit(p))
    return st.System(
        "own", x, p, ca.vertcat(*given), states=tuple(states), parameters=tuple(values)
    )


KNOWN: dict[str, tuple[Rates, str, dict[str, float], list[tuple[float, ...]]]] = {
    "Brusselator": (
        lambda u, v, a, b: (a - (b + 1) * u + u * u * v, b * u - u * u * v),
        "uv",
        {"a": 1.5, "b": 3.0},
        [(1.5, 2.0)],
    ),
    "Van der Pol with bias": (
        lambda x, y, a, m: (m * (y + x - x**3 / 3), (a - x) / m),
        "xy",
        {"a": 0.7, "m": 5.0},
        [(0.7, 0.7**3 / 3 - 0.7)],
    ),
    "prey and predator": (
        lambda x, y, a, d: (x * (a - 0.5 * y), y * (d * x - 0.25)),
        "xy",
        {"a": 1.25, "d": 0.125},
        [(0, 0), (2, 2.5)],
    ),
    "Duffing": (
        lambda x, v, a: (v, a * x - x**3 / 4 - v / 10),
        "xv",
        {"a": 1.0},
        [(0, 0), (2, 0), (-2, 0)],
    ),
    "Roessler": (
        lambda x, y, z, c: (-y - z, x + y / 4, 0.25 + z * (x - c)),
        "xyz",
        {"c": 4.25},
        [(z / 4, -z, z) for z in (8.5 + math.sqrt(71.25), 8.5 - math.sqrt(71.25))],
    ),
    "machine on a grid": (
        lambda d, w, p: (w, p - w / 2 - ca.sin(d)),
        "dw",
        {"p": 0.5},
        [(math.pi / 6, 0), (5 * math.pi / 6, 0)],
    ),
    "epidemic": (
        lambda s, i, b: (0.125 - 0.125 * s - b * s * i, b * s * i - 0.25 * i),
        "si",
        {"b": 0.5},
        [(1, 0), (0.5, 0.25)],
    ),
    "diode": (
        lambda v, u: (u - v - (ca.exp(40 * v) - 1) * 1e-9,),
        "v",
        {"u": 0.5 + (math.exp(20) - 1) * 1e-9},
        [(0.5,)],
    ),
    "orbit in SI units": (
        lambda r, v, h: (v, h * h / r**3 - 3.986e14 / r**2),
        "rv",
        {"h": 5.3e10},
        [(5.3e10**2 / 3.986e14, 0)],
    ),
    "exponential": (lambda x, a: (ca.exp(x) - a,), "x", {"a": 1e30}, [(math.log(1e30),)]),
    "radiation": (
        lambda t, p: (p - 5.67e-8 * t**4,),
        "t",
        {"p": 1e4},
        [((1e4 / 5.67e-8) ** 0.25,), (-((1e4 / 5.67e-8) ** 0.25),)],
    ),
}


@pytest.mark.few(3)
@pytest.mark.parametrize("name", KNOWN)
def test_a_member_is_found_without_a_guess_and_from_poor_ones(name: str) -> None:
    rates, states, values, known = KNOWN[name]
    system, rng = built(rates, states, **values), np.random.default_rng(3)
    guesses: list[dict[str, float]] = [{}]
    for state in known:
        guesses.append(
            {
                n: v * rng.uniform(0.3, 2) + rng.normal() / 2
                for n, v in zip(states, state, strict=True)
            }
        )
    for guess in guesses:
        at, *others = values
        family = system.steady(at, guess={**guess, **values})
        found = family.member([values[at]], [values[n] for n in others])
        if name == "machine on a grid":  # whole turns of an angle are the same state
            found[0] -= 2 * math.pi * round((found[0] - 1) / (2 * math.pi))
        assert any(np.allclose(found, k, rtol=1e-9, atol=1e-9) for k in known), guess


def test_equations_are_chosen_where_slopes_do_not_underflow() -> None:
    """A stirred reactor: at y = -300 the rate of reaction is below every double next to 1."""
    reactor = built(
        lambda x, y, d: (-x + d * (1 - x) * ca.exp(y), 14 * d * (1 - x) * ca.exp(y) - 2 * y),
        "xy",
        d=0.06,
    )
    family = reactor.steady("d", guess={"x": 30.0, "y": -300.0, "d": 0.06})
    assert family.equations == ("x", "y")
    x, y = family.anchor.unknown
    assert y == pytest.approx(7 * x, rel=1e-12)
    assert x == pytest.approx(0.06 * (1 - x) * math.exp(7 * x), rel=1e-12)


@pytest.mark.parametrize("least", [1.0, 1e-6, 1e-12])
def test_where_the_rate_only_comes_near_zero_the_search_is_told_and_no_iterate(
    least: float,
) -> None:
    nothing = built(lambda x, p: (p + x**2,), "x", p=least)
    with pytest.raises(NoMemberError) as caught:
        nothing.steady("p", guess={"x": 1.0, "p": least})
    assert str(caught.value) == (
        f"steady own has no member that damped Newton steps reach at p = {least:.6g}, neither from "
        "64 first guesses about x = 1 (within about 10 of it, relative to 1 or to the number) nor "
        "from 256 of sizes from 1e-6 to 1e9; give another guess."
    )
