"""Exact conditions of systems with known answers: against hand formulas and exact matrices."""

import random
from collections.abc import Callable
from fractions import Fraction
from functools import cache
from typing import Any

import casadi as ca
import numpy as np
import pytest
import sympy

import stability as st
from stability.base.errors import DomainError, NameUnknownError, ParameterError

F = Fraction
Case = tuple[st.Conditions, Callable[..., list[list[Any]]]]


def at_rest(
    name: str, states: str, parameters: str, rhs: Callable[..., list[Any]], at: str
) -> st.Family:
    """A linear system at rest, from its rates."""
    x, p = ca.SX.sym("x", len(states.split())), ca.SX.sym("p", len(parameters.split()))
    rates = ca.vertcat(*rhs(*ca.vertsplit(x), *ca.vertsplit(p)))
    system = st.System(
        name, x, p, rates, states=tuple(states.split()), parameters=tuple(parameters.split())
    )
    return st.Family(system, "rest", at=(at,), held=dict.fromkeys(system.states, 0.0))


# --- systems with their linearisation by hand, as matrices of exact numbers ---


@cache
def ziegler(*, damped: bool = True) -> Case:
    """O. N. Kirillov & F. Verhulst, ZAMM 90 (2010): masses 2m and m; M⁻¹ = [[1, -1], [-1, 3]]/2."""

    def rates(q: Any, s: Any, u: Any, v: Any, load: Any, b: Any = 0) -> list[Any]:
        first = (2 - load) * q + (load - 1) * s + b * (2 * u - v)
        second = -q + s + b * (v - u)
        return [u, v, -(first - second) * 0.5, -(-first + 3 * second) * 0.5]

    def matrix(P: F, b: Any = 0) -> list[list[Any]]:  # noqa: N803
        h = F(1, 2)
        stiff, damp = [[2 - P, P - 1], [-1, 1]], [[2 * b, -b], [-b, b]]
        inverse = [[h, -h], [-h, 3 * h]]
        low = [
            [
                -sum(inverse[i][k] * part[k][j] for k in (0, 1))
                for part in (stiff, damp)
                for j in (0, 1)
            ]
            for i in (0, 1)
        ]
        return [[0, 0, 1, 0], [0, 0, 0, 1], *low]

    names = "P b" if damped else "P"
    family = at_rest("column", "q s u v", names, rates, "P")
    return st.conditions(family, positive=("b",) if damped else ()), matrix


@cache
def jeffcott() -> Case:
    """A rotor with outer and inner damping; flutter at W = w (1 + de/di)."""

    def rates(x: Any, y: Any, u: Any, v: Any, de: Any, di: Any, w: Any, W: Any) -> list[Any]:  # noqa: N803
        return [
            u,
            v,
            -(de + di) * u - w**2 * x - W * di * y,
            -(de + di) * v - w**2 * y + W * di * x,
        ]

    def matrix(W: F, de: F, di: F, w: F) -> list[list[Any]]:  # noqa: N803
        d = de + di
        return [[0, 0, 1, 0], [0, 0, 0, 1], [-(w**2), -W * di, -d, 0], [W * di, -(w**2), 0, -d]]

    family = at_rest("rotor", "x y u v", "de di w W", rates, "W")
    return st.conditions(family, positive=("de", "di", "w", "W")), matrix


@cache
def saddle() -> Case:
    """A ball on a rotating saddle of curvatures ±k, in the rotating frame: stable iff W² > k."""

    def rates(x: Any, y: Any, u: Any, v: Any, W: Any, k: Any) -> list[Any]:  # noqa: N803
        return [u, v, 2 * W * v + (W**2 - k) * x, -2 * W * u + (W**2 + k) * y]

    def matrix(W: F, k: F) -> list[list[Any]]:  # noqa: N803
        return [[0, 0, 1, 0], [0, 0, 0, 1], [W**2 - k, 0, 0, 2 * W], [0, W**2 + k, -2 * W, 0]]

    family = at_rest("saddle", "x y u v", "W k", rates, "W")
    return st.conditions(family, positive=("W", "k")), matrix


@cache
def top() -> Case:
    """A sleeping top, tilts p and q: A p'' + C W q' = G p and so on; neutral iff C² W² > 4 A G."""

    def rates(p: Any, q: Any, u: Any, v: Any, W: Any, A: Any, C: Any, G: Any) -> list[Any]:  # noqa: N803
        return [u, v, (G * p - C * W * v) / A, (G * q + C * W * u) / A]

    def matrix(W: F, A: F, C: F, G: F) -> list[list[Any]]:  # noqa: N803
        return [[0, 0, 1, 0], [0, 0, 0, 1], [G / A, 0, 0, -C * W / A], [0, G / A, C * W / A, 0]]

    family = at_rest("top", "p q u v", "W A C G", rates, "W")
    return st.conditions(family, positive=("W", "A", "C", "G")), matrix


@cache
def wheelset() -> Case:
    """Hunting of a railway wheelset (J. K. Moore, course EME 134, lab 1), all numbers symbols."""

    def rates(y: Any, s: Any, u: Any, v: Any, *p: Any) -> list[Any]:
        V, m, i, k, f, a, b, e = p  # noqa: N806
        return [
            u,
            v,
            -k / m * y + 2 * f / m * s - 2 * f / (V * m) * u,
            -a * f / i * y - b / i * s - e * f / (V * i) * v,
        ]

    def matrix(V: F, m: F, i: F, k: F, f: F, a: F, b: F, e: F) -> list[list[Any]]:  # noqa: N803
        return [
            [0, 0, 1, 0],
            [0, 0, 0, 1],
            [-k / m, 2 * f / m, -2 * f / (V * m), 0],
            [-a * f / i, -b / i, 0, -e * f / (V * i)],
        ]

    names = "V m i k f a b e"
    family = at_rest("wheelset", "y s u v", names, rates, "V")
    return st.conditions(family, positive=tuple(names.split())), matrix


BIKE = {
    "M": [[80.81722, 2.31941332208709], [2.31941332208709, 0.29784188199686]],
    "C": [[0, 33.86641391492494], [-0.85035641456978, 1.68540397397560]],
    "K0": [[-80.95, -2.59951685249872], [-2.59951685249872, -0.80329488458618]],
    "K2": [[0, 76.59734589573222], [0, 2.65431523794604]],
}
"""J. P. Meijaard et al., Proc. R. Soc. A 463 (2007) 1955-1982, Table 1."""


@cache
def bicycle() -> Case:
    """The bicycle benchmark q'' = v D q' + (g S0 + v² S2) q, its numbers exact doubles."""
    inverse = np.linalg.inv(np.array(BIKE["M"]))
    parts = {n: -inverse @ np.array(BIKE[n]) for n in ("C", "K0", "K2")}

    def low(v: Any, g: Any, number: Callable[[float], Any]) -> list[list[Any]]:
        d, s0, s2 = (
            [[number(float(e)) for e in row] for row in parts[n]] for n in ("C", "K0", "K2")
        )
        return [
            [*(g * s0[i][j] + v**2 * s2[i][j] for j in (0, 1)), *(v * d[i][j] for j in (0, 1))]
            for i in (0, 1)
        ]

    def rates(*given: Any) -> list[Any]:
        rows = low(*given[4:], float)
        return [
            given[2],
            given[3],
            *(sum(c * x for c, x in zip(r, given[:4], strict=True)) for r in rows),
        ]

    def matrix(v: Any, g: Any, number: Any = F) -> list[list[Any]]:
        return [[0, 0, 1, 0], [0, 0, 0, 1], *low(v, g, number)]

    family = at_rest("bicycle", "lean steer lean_rate steer_rate", "v g", rates, "v")
    return st.conditions(family, positive=("v", "g")), matrix


@cache
def lorenz() -> Case:
    """The steady state C+ of Lorenz's equations; x² = b (r - 1)."""
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p", 3)
    s, b, r = ca.vertsplit(p)
    rates = ca.vertcat(s * (x[1] - x[0]), x[0] * (r - x[2]) - x[1], x[0] * x[1] - b * x[2])
    system = st.System(
        "lorenz", x, p, rates, states=("x", "y", "z"), parameters=("sigma", "b", "r")
    )
    family = st.Family(
        system,
        "C+",
        at=("r",),
        unknown={"x": 8.0, "y": 8.0, "z": 27.0},
        equations=("x", "y", "z"),
        positive=("x",),
        typical={"r": 28.0, "sigma": 10.0, "b": 8 / 3},
    )

    def matrix(r: F, x: F, sigma: F, b: F) -> list[list[Any]]:  # noqa: ARG001
        return [[-sigma, sigma, 0], [1, -1, -x], [x, x, -b]]  # r - z = 1

    return st.conditions(family, positive=("sigma", "b")), matrix


@cache
def governor() -> Case:
    """Watt's governor (Sotomayor, Mello & Braga, arXiv math/0606230)."""
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p", 3)
    a, b, e = ca.vertsplit(p)
    swing = x[2] ** 2 * ca.sin(x[0]) * ca.cos(x[0]) - ca.sin(x[0]) - e * x[1]
    system = st.System(
        "governor",
        x,
        p,
        ca.vertcat(x[1], swing, a * (ca.cos(x[0]) - b)),
        states=("x", "y", "z"),
        parameters=("a", "b", "e"),
    )
    family = st.Family(
        system,
        "running",
        at=("e",),
        held={"y": 0.0},
        unknown={"x": 1.0, "z": 1.4},
        equations=("y", "z"),
        positive=("x", "z"),
        typical={"a": 0.5, "b": 0.5, "e": 0.5},
    )

    def matrix(**v: F) -> list[list[Any]]:
        s, z, b = v["sin(x)"], v["z"], v["b"]
        return [[0, 1, 0], [z**2 * (b**2 - s**2) - b, -v["e"], 2 * z * s * b], [-v["a"] * s, 0, 0]]

    return st.conditions(family, positive=("a",)), matrix


@cache
def three_bodies() -> Case:
    """The triangular point of the restricted three-body problem, solved for in full."""
    x, m = ca.SX.sym("x", 4), ca.SX.sym("m")
    X, Y = x[0], x[1]  # noqa: N806
    r1, r2 = ca.sqrt((X + m) ** 2 + Y**2), ca.sqrt((X - 1 + m) ** 2 + Y**2)
    pull = [
        2 * x[3] + X - (1 - m) * (X + m) / r1**3 - m * (X - 1 + m) / r2**3,
        -2 * x[2] + Y - (1 - m) * Y / r1**3 - m * Y / r2**3,
    ]
    system = st.System(
        "three-body",
        x,
        m,
        ca.vertcat(x[2], x[3], *pull),
        states=("X", "Y", "U", "V"),
        parameters=("m",),
    )
    family = st.Family(
        system,
        "L4",
        at=("m",),
        held={"U": 0.0, "V": 0.0},
        unknown={"X": 0.47, "Y": 0.866},
        equations=("U", "V"),
        positive=("Y",),
        typical={"m": 0.03},
    )

    def matrix(m: F, Y: Any) -> list[list[Any]]:  # noqa: N803, ARG001
        # V. Szebehely, Theory of Orbits (1967), ch. 5: second derivatives 3/4, 9/4, ±√27/4 (1 - 2m)
        mixed = sympy.sqrt(27) / 4 * (1 - 2 * sympy.Rational(m.numerator, m.denominator))
        return [[0, 0, 1, 0], [0, 0, 0, 1], [F(3, 4), mixed, 0, 2], [mixed, F(9, 4), -2, 0]]

    return st.conditions(family, between={"m": (0, 1)}), matrix


CASES: dict[str, Callable[[], Case]] = {
    "ziegler": ziegler,
    "ziegler without damping": lambda: ziegler(damped=False),
    "jeffcott": jeffcott,
    "saddle": saddle,
    "top": top,
    "wheelset": wheelset,
    "bicycle": bicycle,
    "lorenz": lorenz,
    "governor": governor,
    "three bodies": three_bodies,
}


# --- hand formulas ---


def wheel_formula() -> sympy.Expr:
    """Routh's a1 (a2 a3 - a1 a4) - a0 a3² of (m λ² + 2f/V λ + k)(i λ² + e f/V λ + b) + 2 a f²."""
    V, m, i, k, f, a, b, e, lam = sympy.symbols("V m i k f a b e lam", positive=True)  # noqa: N806
    whole = (m * lam**2 + 2 * f / V * lam + k) * (i * lam**2 + e * f / V * lam + b) + 2 * a * f**2
    a4, a3, a2, a1, a0 = sympy.Poly(sympy.expand(whole), lam).all_coeffs()
    return a1 * (a2 * a3 - a1 * a4) - a0 * a3**2


HAND = {
    "ziegler": ["Rational(41, 28) + b**2/2 - P"],
    "ziegler without damping": ["7 - 2*P", "(7 - 2*P)**2 - 8"],
    "jeffcott": ["w*(1 + de/di) - W"],
    "saddle": ["W**2 - k"],
    "top": ["C**2*W**2 - 4*A*G"],
    "lorenz": ["sigma*(sigma + b + 3) - r*(sigma - b - 1)"],
    "governor": ["e - 2*a*b**2*z"],  # z = b^(-1/2)
    "three bodies": ["1 - 27*m*(1 - m)"],
}
"""What decides, from the literature named above."""


def same(one: Any, other: Any) -> bool:
    """Whether two expressions in positive symbols are equal up to a positive factor."""
    names = {str(s) for s in (*one.free_symbols, *other.free_symbols)}
    positive = {n: sympy.Symbol(n, positive=True) for n in names}
    ratio = sympy.factor(
        sympy.cancel(
            (one / other).subs(
                {s: positive[str(s)] for s in (*one.free_symbols, *other.free_symbols)}
            )
        )
    )
    return bool(ratio.is_positive)


def read(text: str) -> Any:
    """A polynomial in SymPy, no letter being a function or constant of SymPy."""
    plain = {n: sympy.Symbol(n) for n in "ACGWPVXYabefgikmrvwz"} | {"beta": sympy.Symbol("beta")}
    plain |= {"sigma": sympy.Symbol("sigma")}
    return sympy.sympify(text, locals=plain)


@pytest.mark.few(4)
@pytest.mark.parametrize("name", HAND)
def test_what_decides_is_the_hand_formula(name: str) -> None:
    found, _ = CASES[name]()
    asked = [read(str(c.polynomial)) for c in found.deciding]
    assert len(asked) == len(HAND[name])
    for text in HAND[name]:
        assert any(same(one, read(text)) for one in asked), (text, asked)


def test_hunting_of_a_wheelset_is_decided_by_one_routh_determinant() -> None:
    found, _ = wheelset()
    (asked,) = found.deciding
    assert asked.kind == "flutter"
    assert same(read(str(asked.whole)), wheel_formula())


def test_conditions_of_the_bicycle_are_capsize_and_weave() -> None:
    """The determinant of the stiffness for capsize; the published speeds at g = 9.81."""
    found, matrix = bicycle()
    static, flutter = found.boundaries
    v, g = sympy.symbols("v g", positive=True)
    low = sympy.Matrix([row[:2] for row in matrix(v, g, sympy.Rational)[2:]])
    assert same(read(str(static.whole)), sympy.expand(low.det()))
    weave, capsize = 4.292382536, 6.024262015  # m/s, § 5 of the paper
    for condition, speed in ((flutter, weave), (static, capsize)):
        one, other = (condition.polynomial(F(speed + d), F(9.81)) for d in (-1e-8, 1e-8))
        assert one * other < 0


def test_the_governor_and_the_steady_lorenz_state_are_reduced_by_their_equations() -> None:
    found, _ = governor()
    assert dict(found.solved)["cos(x)"] == "b"
    shown = {name: sympy.sympify(str(p)) for name, p in found.relations}
    b, z = sympy.symbols("b z")
    assert sympy.expand(shown["z"] - (b * z**2 - 1)) == 0
    assert lorenz()[0].solved == (("y", "x"), ("z", "r - 1"))


# --- the verdict against exact matrices ---


def oracle(matrix: list[list[Any]]) -> str | None:
    """The verdict in fractions: Routh's array, or the roots of a quadratic in λ²."""
    a = [[F(e) for e in row] for row in matrix]
    poly = charpoly(a)
    if not any(poly[1::2]):
        linear, constant = poly[2], poly[4]
        neutral = linear >= 0 and constant >= 0 and linear**2 >= 4 * constant
        return "neutral" if neutral else "unstable"
    return routh(poly)


def routh(poly: list[F]) -> str | None:
    """Stable or unstable by Routh's array; None where a leading entry is zero."""
    width = len(poly) // 2 + 1
    rows = [(part + [F(0)] * width)[:width] for part in (poly[::2], poly[1::2])]
    while len(rows) < len(poly):
        one, two = rows[-2:]
        if not two[0]:
            return None
        rows.append(
            [(two[0] * one[j + 1] - one[0] * two[j + 1]) / two[0] for j in range(width - 1)]
            + [F(0)]
        )
    first = [row[0] for row in rows]
    if not all(first):
        return None
    return "stable" if all(x > 0 for x in first) else "unstable"


def lyapunov(a: list[list[F]]) -> str | None:
    """Stable exactly where aᵀ P + P a = -1 has a positive definite solution; in fractions."""
    size = len(a)
    pairs = [(i, j) for i in range(size) for j in range(i, size)]
    place = {p: n for n, p in enumerate(pairs)} | {(j, i): n for n, (i, j) in enumerate(pairs)}
    rows = []
    for i, j in pairs:  # aᵀ P + P a = -1
        row = [F(0)] * len(pairs) + [F(-(i == j))]
        for k in range(size):
            row[place[k, j]] += a[k][i]
            row[place[i, k]] += a[k][j]
        rows.append(row)
    solution = solved(rows)
    if solution is None:
        return None  # on a boundary
    p = [[solution[place[i, j]] for j in range(size)] for i in range(size)]
    good = all(determinant([r[:n] for r in p[:n]]) > 0 for n in range(1, size + 1))
    return "stable" if good else "unstable"


def charpoly(a: list[list[F]]) -> list[F]:
    """Coefficients of det(λ - a), highest first (Faddeev & Leverrier)."""
    size, out = len(a), [F(1)]
    m = [[F(0)] * size for _ in a]
    for k in range(1, size + 1):
        for i in range(size):
            m[i][i] += out[-1]
        m = [
            [sum((a[i][n] * m[n][j] for n in range(size)), F(0)) for j in range(size)]
            for i in range(size)
        ]
        out.append(-sum((m[i][i] for i in range(size)), F(0)) / k)
    return out


def solved(rows: list[list[F]]) -> list[F] | None:
    """The solution of linear equations, or None where the matrix is singular."""
    for k in range(len(rows)):
        pivot = next((i for i in range(k, len(rows)) if rows[i][k]), None)
        if pivot is None:
            return None
        rows[k], rows[pivot] = rows[pivot], rows[k]
        for i in range(len(rows)):
            if i != k and rows[i][k]:
                ratio = rows[i][k] / rows[k][k]
                rows[i] = [x - ratio * y for x, y in zip(rows[i], rows[k], strict=True)]
    return [row[-1] / row[k] for k, row in enumerate(rows)]


def determinant(a: list[list[F]]) -> F:
    """A determinant from the constant term of the characteristic polynomial."""
    return charpoly(a)[-1] * (-1) ** len(a)


def sample(name: str, chance: random.Random) -> dict[str, Any]:
    """Random rational values of the variables, on the branch."""

    def number() -> F:
        return F(chance.randrange(1, 60), chance.randrange(1, 20))

    found, _ = CASES[name]()
    point: dict[str, Any] = {v.name: number() for v in found.variables}
    if name.startswith("ziegler"):
        point["P"] = F(chance.randrange(-40, 100), 20)
    if name == "bicycle":
        point |= {"v": F(chance.randrange(1, 90), 10), "g": F(981, 100)}
    if name == "lorenz":
        point["r"] = 1 + point["x"] ** 2 / point["b"]
    if name == "governor":  # 1/√b and √(1 - b²) are both rational
        t = F(chance.randrange(1, 30), chance.randrange(31, 60))
        root = 2 * t / (1 + t * t)
        point |= {"z": 1 / root, "b": root**2, "e": number() / 8, "a": number() / 8}
        point["sin(x)"] = None
    if name == "three bodies":
        point["m"] = F(chance.randrange(1, 300), 300)
    return point


ALGEBRAIC = ("governor", "three bodies")
"""Members with irrational numbers; other tests have these."""


@pytest.mark.few(2)
@pytest.mark.parametrize("name", [n for n in CASES if n not in ALGEBRAIC])
@pytest.mark.parametrize("points", [50, pytest.param(200, marks=pytest.mark.long)])
def test_the_verdict_is_that_of_the_exact_matrix(name: str, points: int) -> None:
    chance = random.Random(name)
    found, matrix = CASES[name]()
    words: dict[str, int] = {}
    for number in range(points):
        point = sample(name, chance)
        expected = oracle(matrix(**point))
        word = found.decide(point).word
        words[word] = words.get(word, 0) + 1
        assert expected is None or word == expected, point
        if 25 * number < points and expected in ("stable", "unstable"):
            rows = [[F(e) for e in row] for row in matrix(**point)]
            assert any(charpoly(rows)[1::2]) is False or lyapunov(rows) in (expected, None)
    assert len(words) == 2
    assert 25 * min(words.values()) > points, words


@pytest.mark.few(2)
@pytest.mark.parametrize("name", ["governor", "lorenz", "three bodies", "bicycle", "jeffcott"])
@pytest.mark.parametrize("count", [12, pytest.param(25, marks=pytest.mark.long)])
def test_the_verdict_is_that_of_certified_spectra(name: str, count: int) -> None:
    chance = random.Random(name)
    found, _ = CASES[name]()
    family = found.family
    words = set()
    wide = (0.4, 2.5) if name == "jeffcott" else (0.7, 1.6)
    for turn in range(2 if name == "three bodies" else count):
        numbers = {
            n: float(family.typical.get(n, 1.0)) * chance.uniform(*wide)
            for n in (*family.at, *family.parameters)
        }
        if name == "bicycle":
            numbers = {"v": chance.uniform(1, 9), "g": 9.81}
        if name == "three bodies":  # a certified spectrum takes a second
            numbers = {"m": (0.036, 0.041)[turn]}
        at, others = numbers.pop(family.at[0]), numbers
        spectrum = st.spectrum(family, at=at, certify=True, **others)
        word = found.verdict(at, **others).word
        words.add(word)
        assert word == spectrum.verdict.word
    assert len(words) == 2


def test_the_governor_agrees_with_the_hand_formula_at_random_members() -> None:
    chance = random.Random(3)
    found, _ = governor()
    for _ in range(60):
        a, b, e = (chance.uniform(0.1, 0.9) for _ in range(3))
        stable = e > 2 * a * b**1.5
        assert found.verdict(e, a=a, b=b).word == ("stable" if stable else "unstable")


def test_a_point_on_the_boundary_is_exactly_neutral() -> None:
    found, _ = ziegler()
    for b in (F(1, 3), F(2)):
        load = F(41, 28) + b**2 / 2
        assert found.decide({"P": load, "b": b}).word == "neutral"
        assert found.decide({"P": load - F(1, 10**30), "b": b}).word == "stable"
        assert found.decide({"P": load + F(1, 10**30), "b": b}).word == "unstable"


# --- statuses, proofs, witnesses ---


@pytest.mark.few(4)
@pytest.mark.parametrize("name", CASES)
def test_every_status_holds_at_random_points_and_witnesses(name: str) -> None:
    chance = random.Random(5)
    found, _ = CASES[name]()
    names = [v.name for v in found.variables]
    for _ in range(50):
        point = sample(name, chance)
        if name in ALGEBRAIC:
            continue
        values = [point[n] for n in names]
        for c in found.conditions:
            if c.status == "positive":
                assert c.whole(*values) > 0, c
    for c in found.conditions:
        if c.status == "changes":
            assert {w.sign for w in c.witnesses} == {1, -1}
        for w in c.witnesses:
            family = found.family
            at = [float(w.point[n]) for n in family.at]
            others = {n: float(w.point[n]) for n in family.parameters}
            values = [
                float(v) if not hasattr(v, "p") else int(v.p) / int(v.q)
                for v in found.values(at, **others).values()
            ]
            assert c.polynomial(*values) * w.sign > 0


def test_a_domain_makes_conditions_follow_and_its_absence_leaves_them() -> None:
    family = ziegler()[0].family
    assert len(st.conditions(family).deciding) > len(ziegler()[0].deciding)
    turned = st.conditions(family, between={"b": (-1, 0)})
    assert turned.rule == "Unstable at every member of the domain."
    with pytest.raises(DomainError, match="outside the domain"):
        turned.decide({"P": 1, "b": 1})


def test_the_disk_as_any_family_gives_the_thresholds_of_its_own_derivation() -> None:
    found = st.conditions(st.disk_family("rolling", "viscous"), positive=("k", "mu"))
    (asked,) = found.deciding
    assert str(asked.polynomial) == "2*omega3**2*k - 1"
    assert found.zeros == 2


# --- refusals and limits ---


def companion(size: int) -> st.Family:
    """x⁽ⁿ⁾ + a_{n-1} x⁽ⁿ⁻¹⁾ + … + a_0 x = 0, every coefficient a parameter."""

    def rates(*given: Any) -> list[Any]:
        x, a = given[:size], given[size:]
        return [*x[1:], -sum(c * s for c, s in zip(a, x, strict=True))]

    states = " ".join(f"x{i}" for i in range(size))
    return at_rest("chain", states, " ".join(f"a{i}" for i in range(size)), rates, "a0")


def test_what_is_too_large_says_degree_terms_and_time_and_the_rest_works() -> None:
    family = companion(6)
    with pytest.raises(st.StabilityError, match=r"degree 6 in λ, is too large: .* terms= and"):
        st.conditions(family, terms=3)
    partly = st.conditions(family, terms=15)
    assert "degree 6" in partly.left_out[0]
    assert "limits: 15 terms, 60 s" in partly.left_out[0]
    assert partly.rule.startswith("The conditions are incomplete")
    whole = st.conditions(family)
    assert not whole.left_out
    chance = random.Random(1)
    words: list[str | None] = []
    for _ in range(40):
        a = [1, 12, 60, 160, 240, 192, 64][::-1]  # (λ + 2)⁶
        point = {f"a{i}": F(c * chance.randrange(4, 16), 10) for i, c in enumerate(a[:6])}
        rows: list[list[Any]] = [[int(j == i + 1) for j in range(6)] for i in range(5)]
        words.append(oracle([*rows, [-point[f"a{i}"] for i in range(6)]]))
        assert partly.decide(point).word == whole.decide(point).word == words[-1]
    assert set(words) == {"stable", "unstable"}
    assert st.spectrum(family, at=1.0, **dict.fromkeys(family.parameters, 1.0)).verdict


@pytest.mark.parametrize(
    ("arguments", "error", "part"),
    [
        ({"positive": ("q9",)}, NameUnknownError, "q9"),
        ({"positive": "P"}, ParameterError, "tuple"),
        ({"between": {"P": (2, 1)}}, ParameterError, "low, high"),
        ({"between": {"P": 3}}, ParameterError, "low, high"),
        ({"b": float("nan")}, ParameterError, "b is"),
        ({"P": 1.0}, NameUnknownError, "P"),
        ({"terms": 0}, ParameterError, "terms"),
        ({"seconds": -1}, ParameterError, "seconds"),
    ],
)
def test_bad_input_is_refused_in_one_sentence(
    arguments: dict[str, Any], error: type, part: str
) -> None:
    with pytest.raises(error, match=part) as caught:
        st.conditions(ziegler()[0].family, **arguments)
    assert str(caught.value).endswith(".")


def test_members_outside_are_refused_and_missing_numbers_are_named() -> None:
    found, _ = lorenz()
    with pytest.raises(ParameterError, match="x is missing"):
        found.decide({"r": 28, "sigma": 10, "b": 1})
    with pytest.raises(DomainError, match="does not obey"):
        found.decide({"r": 28, "sigma": 10, "b": 1, "x": 1})
    with pytest.raises(ParameterError, match="contact is missing; give Smooth"):
        st.conditions("rolling")
    with pytest.raises(ParameterError, match="b is missing"):
        found.verdict(28.0, sigma=10.0)
