"""Every equilibrium of a system in a box: planted ones, those of closed forms, and refusals."""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import casadi as ca
import mpmath
import numpy as np
import pytest
from own_systems import system_of

import stability as st
from stability.cli import main

NO_PARAMETERS = ca.SX(0, 1)
MOST_STARTS = 60
"""Starts of Newton's method that look for equilibria of a system by another way."""
DIGITS = 50
EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


# --- planted equilibria ---


class Planted(NamedTuple):
    """Rates with equilibria by construction, as a function for any library of functions."""

    rates: Callable[[Any, Any], list[Any]]
    """(library, unknowns) → rates; the library has sin, exp and tanh."""
    roots: list[np.ndarray]
    """Doubles at which each rate vanishes exactly."""
    low: np.ndarray
    high: np.ndarray


def _zero(rng: np.random.Generator, root: np.ndarray) -> Callable[[Any, Any], Any]:
    """A random function of the unknowns that vanishes exactly at a root."""
    n = len(root)
    j, k, m = rng.integers(0, n, 3)
    kind = rng.integers(0, 6)
    c, w, v, d = rng.uniform(0.3, 2, 4) * rng.choice((-1.0, 1.0), 4)
    if kind == 0:
        return lambda _, x: c * (x[j] - root[j]) + w * (x[k] - root[k])
    if kind == 1:
        return lambda _, x: c * (x[j] - root[j]) * (x[k] + d)
    if kind == 2:
        return lambda _, x: c * (x[j] - root[j]) * (x[k] * x[m] + d)
    if kind == 3:
        return lambda f, x: c * f.sin(2 * w * (x[j] - root[j]) + v * (x[k] - root[k]))
    if kind == 4:
        return lambda f, x: c * (f.exp(w * (x[j] - root[j])) - 1)
    return lambda f, x: c * f.tanh(w * (x[j] - root[j]) + v * (x[k] - root[k]))


def planted(seed: int) -> Planted:
    """A random system with one equilibrium, or with two where each rate is a sum of products."""
    rng = np.random.default_rng(seed)
    n = 1 + seed % 6
    roots = [rng.uniform(-1.5, 1.5, n) for _ in range(2 if n < 5 and rng.random() < 0.4 else 1)]
    rows: list[list[list[Callable[[Any, Any], Any]]]] = []
    for i in range(n):
        terms = [[_zero(rng, root) for root in roots] for _ in range(rng.integers(1, 3))]
        slope = float(rng.uniform(0.5, 2) * rng.choice((-1, 1)))

        def own(_: Any, x: Any, i: int = i, slope: float = slope) -> Any:
            return slope * (x[i] - roots[0][i])

        terms.append([own, *(_zero(rng, root) for root in roots[1:])])
        rows.append(terms)

    def rates(library: Any, x: Any) -> list[Any]:
        out = []
        for terms in rows:
            total: Any = 0.0
            for factors in terms:
                product: Any = 1.0
                for factor in factors:
                    product = product * factor(library, x)
                total = total + product
            out.append(total)
        return out

    low = np.minimum(rng.uniform(-3, -1.5, n), np.min(roots, axis=0) - 0.01)
    high = np.maximum(rng.uniform(1.5, 3, n), np.max(roots, axis=0) + 0.01)
    return Planted(rates, roots, low, high)


def newton_roots(problem: Planted, seed: int) -> list[np.ndarray]:
    """Equilibria in the box by Newton's method in doubles, with differences for slopes."""
    rng = np.random.default_rng(seed)
    n = len(problem.low)
    x = rng.uniform(problem.low, problem.high, (MOST_STARTS, n)).T

    def rates(at: np.ndarray) -> np.ndarray:
        values = problem.rates(np, list(at))
        return np.array([np.broadcast_to(v, at.shape[1:]) for v in values])

    with np.errstate(all="ignore"):
        for _ in range(40):
            f = rates(x)
            slopes = np.empty((n, n, x.shape[1]))
            for j in range(n):
                h = 1e-7 * (1 + np.abs(x[j]))
                moved = x.copy()
                moved[j] += h
                slopes[:, j] = (rates(moved) - f) / h
            table = np.nan_to_num(slopes.transpose(2, 0, 1), posinf=0, neginf=0)
            step = (np.linalg.pinv(table) @ np.nan_to_num(f.T)[..., None])[..., 0].T
            x = x - step
        small = (np.abs(step) < 1e-9).all(axis=0) & (np.abs(rates(x)) < 1e-9).all(axis=0)
        regular = np.linalg.cond(table) < 1e5
    inside = (x.T > problem.low + 1e-6) & (x.T < problem.high - 1e-6)
    return list(x.T[small & regular & inside.all(axis=1)])


def refined(problem: Planted, start: list[Any]) -> list[Any]:
    """The equilibrium near a state, to many digits."""
    if len(start) == 1:
        near = start[0], start[0] + mpmath.mpf(10) ** -8
        return [mpmath.findroot(lambda x: problem.rates(mpmath, [x])[0], near, tol=1e-60)]
    return list(mpmath.findroot(lambda *x: problem.rates(mpmath, x), start, tol=1e-60))


class Counts(NamedTuple):
    systems: int
    complete: int
    equilibria: int
    planted: int


def campaign(seeds: Sequence[int]) -> Counts:
    """Search systems with planted equilibria, and compare with other ways to find them."""
    complete = count = sown = 0
    for seed in seeds:
        problem = planted(seed)
        n = len(problem.low)
        x = ca.SX.sym("x", n)
        names = [f"x{i}" for i in range(n)]
        rates = ca.vertcat(*problem.rates(ca, [x[i] for i in range(n)]))
        system = st.System("planted", x, NO_PARAMETERS, rates, states=names)
        box = {s: (a, b) for s, a, b in zip(names, problem.low, problem.high, strict=True)}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", st.StabilityWarning)
            found = system.equilibria(box)
        complete += found.complete
        count += len(found)
        sown += len(problem.roots)
        # none missed
        expected = [*((r, 0.0) for r in problem.roots)]
        expected += [(r, 1e-6) for r in newton_roots(problem, seed)]
        for root, room in expected:
            hits = (np.abs(found.states - root) <= found.errors + room).all(axis=1)
            open_ = any(
                all(
                    part.low[s] - room <= v <= part.high[s] + room
                    for s, v in zip(names, root, strict=True)
                )
                for part in found.unresolved
            )
            assert hits.sum() == 1 or (open_ and not hits.any()), (seed, root)
        # none invented: more digits lead to it, and to no other of them
        with mpmath.workdps(DIGITS):
            for state, error in zip(found.states, found.errors, strict=True):
                start = [mpmath.mpf(v) for v in state]
                more = refined(problem, start)
                for a, b, e in zip(more, state, error, strict=True):
                    assert abs(a - mpmath.mpf(b)) <= e * (1 + 1e-9) + mpmath.mpf(10) ** -45, seed
        # none twice
        for i, (a, e) in enumerate(zip(found.states, found.errors, strict=True)):
            others = np.delete(found.states, i, axis=0), np.delete(found.errors, i, axis=0)
            assert (np.abs(others[0] - a) > e + others[1]).any(axis=1).all(), seed
    return Counts(len(seeds), complete, count, sown)


def test_planted_equilibria_are_found_and_none_is_invented() -> None:
    counts = campaign(range(24))
    assert counts.complete == 24
    assert counts.equilibria > counts.planted >= 24


@pytest.mark.long
def test_planted_equilibria_of_two_thousand_systems() -> None:
    counts = campaign(range(2000))
    assert counts.complete >= 1950  # others have double equilibria, or lines of them


# --- closed forms ---


def pitchfork() -> st.System:
    x, p = ca.SX.sym("x"), ca.SX.sym("p")
    return st.System("pitchfork", x, p, p * x - x**3, states=("x",), parameters=("p",))


def rivals() -> st.System:
    x, y, p = (ca.SX.sym(n) for n in "xyp")
    rates = ca.vertcat(x * (1 - x - p * y), y * (1 - y - p * x))
    return system_of("rivals", [x, y], [p], rates)


def wells(count: int) -> st.System:
    """Coupled double wells with friction: 2^count minima where the coupling is weak."""
    q, v = ca.SX.sym("q", count), ca.SX.sym("v", count)
    forces = [
        q[i] - q[i] ** 3 - 0.1 * sum(q[i] - q[j] for j in range(count)) - 0.3 * v[i]
        for i in range(count)
    ]
    names = [f"q{i}" for i in range(count)] + [f"v{i}" for i in range(count)]
    state = ca.vertcat(q, v)
    return st.System("wells", state, NO_PARAMETERS, ca.vertcat(v, *forces), states=names)


def test_eight_wells_have_all_their_equilibria() -> None:
    system = wells(3)
    found = system.equilibria({n: (-3, 3) for n in system.states})
    assert found.complete and len(found) == 27
    assert [v.word for v in found.verdicts].count("stable") == 8
    # each with the others' signs is one too
    rows = {tuple(row) for row in found.states.round(9) + 0.0}
    assert rows == {tuple(-v + 0.0 for v in row) for row in rows}


@pytest.mark.parametrize(("p", "count"), [(0.09, 3), (0.1, 3), (0.12, 1)])
def test_a_stirred_tank_reactor(p: float, count: int) -> None:
    u, w, rate = (ca.SX.sym(n) for n in ("u", "w", "p"))
    heat = rate * (1 - u) * ca.exp(w)
    rates = ca.vertcat(heat - u, 14 * heat - 3 * w)
    tank = system_of("tank", [u, w], [rate], rates)
    found = tank.equilibria({"u": (0, 1), "w": (0, 20)}, p=p)
    assert found.complete and len(found) == count
    # 14 u = 3 w, so that one equation in w is left; its changes of sign are counted
    grid = np.linspace(0, 14 / 3, 100_001)
    left = p * (1 - 3 * grid / 14) * np.exp(grid) - 3 * grid / 14
    changes = np.flatnonzero(np.sign(left[1:]) != np.sign(left[:-1]))
    np.testing.assert_allclose(found.states[:, 1], grid[changes], atol=1e-4)


def test_equilibria_on_the_border_are_proved_to_be_in_the_box() -> None:
    found = rivals().equilibria({"x": (0, 1), "y": (0, 1)}, p=0.5)
    assert found.complete
    np.testing.assert_allclose(found.states, [[0, 0], [0, 1], [2 / 3, 2 / 3], [1, 0]], atol=1e-15)


def test_an_equilibrium_on_the_border_is_left_open_without_a_proof() -> None:
    x = ca.SX.sym("x")
    root = float(np.sqrt(2))  # above √2 by 1e-16
    system = st.System("root", x, NO_PARAMETERS, (x**2 - 2) * (x - 1), states=("x",))
    found = system.equilibria({"x": (0, root)})
    assert found.complete and len(found) == 2
    found = system.equilibria({"x": (0, np.nextafter(root, 0))})
    assert found.complete and len(found) == 1
    # the cosine of no double is zero, but that of half a turn less a double may be
    wave = st.System("wave", x, NO_PARAMETERS, ca.sin(x - 0.5) * (x + 1), states=("x",))
    assert wave.equilibria({"x": (0, 0.5)}).states.tolist() == [[0.5]]


@pytest.mark.parametrize("p", [0.0, 1e-300])
def test_a_double_equilibrium_is_never_called_complete(p: float) -> None:
    with pytest.warns(st.StabilityWarning, match="double"):
        found = pitchfork().equilibria({"x": (-2, 2)}, p=p)
    assert not found.complete and not len(found)
    [part] = found.unresolved
    assert part.low["x"] < 0 < part.high["x"] and part.high["x"] - part.low["x"] < 1e-6


def test_a_line_of_equilibria_is_left_open() -> None:
    x, y = ca.SX.sym("x"), ca.SX.sym("y")
    rates = ca.vertcat(x * y, x * (y - 1))
    system = st.System("line", ca.vertcat(x, y), NO_PARAMETERS, rates, states=("x", "y"))
    with pytest.warns(st.StabilityWarning, match="boxes were used up"):
        assert not system.equilibria({"x": (-1, 2), "y": (-1, 2)}).complete


def test_poles_and_edges_of_domains_hide_no_equilibrium() -> None:
    x, p = ca.SX.sym("x"), ca.SX.sym("p")

    def states(rate: ca.SX, low: float, high: float) -> list[float]:
        system = st.System("s", x, p, rate, states=("x",), parameters=("p",))
        found = system.equilibria({"x": (low, high)}, p=3)
        assert found.complete
        return [round(float(v), 12) for v in found.states[:, 0]]

    assert states(1 / x - x / 4, -5, 5) == [-2, 2]
    assert states(ca.tan(x) - 1, -2, 2) == [round(np.pi / 4, 12)]
    assert states(ca.sqrt(x) - p, -5, 20) == [9]
    assert states(ca.log(x) + 1, -5, 5) == [round(float(np.exp(-1)), 12)]
    assert states(ca.atan2(p, x) - np.pi / 2, -5, 5) == [0]
    assert states(ca.fabs(x) - p, -5, 5) == [-3, 3]
    assert states(x**p - 8, -5, 5) == [2]
    assert states(8 * x**p / (1 + x**p) - 4 * x, 0, 5) == [0, 1, round((1 + 5**0.5) / 2, 12)]


def test_conditions_leave_out_equilibria_without_a_meaning() -> None:
    x, p = ca.SX.sym("x"), ca.SX.sym("p")
    positive = st.Condition(x, "x is {value:g}, which must be positive")
    system = st.System(
        "guarded", x, p, p * x - x**3, states=("x",), parameters=("p",), conditions=(positive,)
    )
    found = system.equilibria({"x": (-2, 2)}, p=1)
    assert found.complete and found.states.tolist() == [[1.0]]


# --- states that move, or are held ---


def cart() -> st.System:
    place, speed, heading, k = (ca.SX.sym(n) for n in ("place", "speed", "heading", "k"))
    rates = ca.vertcat(speed * ca.cos(heading), k - speed**2, speed - 1)
    return system_of("cart", [place, speed, heading], [k], rates)


def test_ignorable_states_are_left_out_and_may_move() -> None:
    found = cart().equilibria({"speed": (-3, 3)}, k=1)
    assert list(found) == [{"speed": -1.0}, {"speed": 1.0}]
    assert found.complete


def test_a_held_state_has_to_rest() -> None:
    assert list(cart().equilibria({"speed": (-3, 3), "heading": 0.5}, k=1)) == [
        {"speed": 1.0, "heading": 0.5}
    ]


def test_families_go_through_each_equilibrium() -> None:
    families = rivals().equilibria({"x": (0, 2), "y": (0, 2)}, p=0.5).families(at="p")
    assert [st.spectrum(f, at=0.75).verdict.word for f in families] == [
        "unstable",
        "unstable",
        "stable",
        "unstable",
    ]
    np.testing.assert_allclose(families[2].member([0.75], []), [4 / 7, 4 / 7], atol=1e-12)


# --- what is refused ---


@pytest.mark.parametrize(
    ("box", "numbers", "said"),
    [
        ({"x": (-1, 1)}, {}, "p is missing; give a number for each of the parameters"),
        ({"x": (-1, 1)}, {"p": 1, "q": 1}, "parameter is 'q'; known are p"),
        ({"y": (-1, 1)}, {"p": 1}, "box names 'y', which is no state; states are x"),
        ({"x": (1, 1)}, {"p": 1}, "box x from 1 to 1 is empty; give .low, high. with low < high"),
        ({"x": (0, np.inf)}, {"p": 1}, "box x is inf; a finite number is needed"),
        ({"x": (0, 1, 2)}, {"p": 1}, "box x is .0, 1, 2.; give .low, high., or one number"),
        ({}, {"p": 1}, "box lacks x; give .low, high., or a number at which a state is held"),
        ({"x": 1}, {"p": 1}, "box has no state with a low and a high end"),
    ],
)  # fmt: skip
def test_a_bad_question_is_refused_in_a_sentence(
    box: Any, numbers: dict[str, float], said: str
) -> None:
    with pytest.raises(st.StabilityError, match=said):
        pitchfork().equilibria(box, **numbers)


def test_a_conserved_sum_is_named() -> None:
    a, b, k = (ca.SX.sym(n) for n in "abk")
    rates = ca.vertcat(-2 * a**2 + k * b, a**2 - k * b / 2)
    pair = system_of("pair", [a, b], [k], rates)
    with pytest.raises(st.StabilityError, match="1/2 a [+] b is constant in every motion of pair"):
        pair.equilibria({"a": (0, 1), "b": (0, 1)}, k=1)


def test_other_systems_are_refused() -> None:
    x, p = ca.SX.sym("x"), ca.SX.sym("p")
    jump = st.System("jump", x, p, p - ca.sign(x), states=("x",), parameters=("p",))
    with pytest.raises(st.StabilityError, match="hold a sign, a maximum or a branch"):
        jump.equilibria({"x": (-1, 1)}, p=1)
    with pytest.raises(st.StabilityError, match="heading, so a steady motion has any value of it"):
        cart().equilibria({"speed": (0, 1), "heading": (0, 1)}, k=1)
    numeric = st.System.from_function(lambda x, _: [x[1], -x[0]], name="n", states=("q", "v"))
    with pytest.raises(st.StabilityError, match="a Python function gives numbers and no graph"):
        numeric.equilibria({"q": (0, 1)})  # type: ignore[attr-defined]


def test_the_command_prints_what_the_call_returns(capsys: pytest.CaptureFixture[str]) -> None:
    system = f"{EXAMPLES}/watt_governor.py:governor"
    words = ["equilibria", "--system", system, "--box", "x=0.1:3", "--box", "y=-1:1", "--box"]
    words += ["z=0.1:5", "--set", "e=0.4", "--set", "a=0.5", "--set", "b=0.5", "--json"]
    assert main(words) == 0
    record = json.loads(capsys.readouterr().out)
    [one] = record["equilibria"]
    assert record["complete"] and one["verdict"] == "stable"
    # cos x = b, and z² cos x = 1
    assert abs(one["state"]["x"] - np.pi / 3) <= one["error"]["x"] + 1e-15
    assert abs(one["state"]["z"] - np.sqrt(2)) <= one["error"]["z"] + 1e-15
    assert main([*words[:4], "x=0:1:2", *words[5:]]) == 2
    assert "--box x is '0:1:2'; give LO:HI, or one number" in capsys.readouterr().err
