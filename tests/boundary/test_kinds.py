"""One kind for one boundary: the search along an axis, and the curves of a map.

Oracle: eigenvalues that are planted as blocks, real or in pairs, once or twice, with zeros of order
one to three in the axis, under a linear transformation of whole numbers.
"""

from __future__ import annotations

import warnings
from typing import Any

import casadi as ca
import numpy as np
import pytest
from own_systems import system_of

import stability as st
from stability.boundary.brackets import Crossing
from stability.boundary.curves import KINDS

STATES = "abcdefgh"


def block(kind: str, f: Any, w: int) -> list[list[Any]]:
    return {
        "real": [[f]],
        "reals": [[f, 1], [0, f]],
        "pair": [[f, -w], [w, f]],
        "pairs": [[f, -w, 1, 0], [w, f, 0, 1], [0, 0, f, -w], [0, 0, w, f]],
        "both": [[f, 0, 0], [0, f, -w], [0, w, f]],
    }[kind]


def hidden(blocks: list[list[list[Any]]], rng: np.random.Generator) -> Any:
    """A block diagonal matrix under a transformation of determinant 1."""
    n, start = sum(map(len, blocks)), 0
    whole = ca.SX(n, n)
    for rows in blocks:
        for i, row in enumerate(rows):
            for j, value in enumerate(row):
                whole[start + i, start + j] = value
        start += len(rows)
    low = np.tril(rng.integers(-1, 2, (n, n)), -1) + np.eye(n)
    turn = low @ (np.triu(rng.integers(-1, 2, (n, n)), 1) + np.eye(n))
    return ca.DM(turn) @ whole @ ca.DM(np.round(np.linalg.inv(turn)))


@pytest.mark.parametrize(
    "seed", [1, *(pytest.param(k, marks=pytest.mark.long) for k in range(2, 40))]
)
def test_a_search_and_a_map_name_the_same_kind_and_it_is_what_was_planted(seed: int) -> None:
    rng = np.random.default_rng(seed)
    seen = 0
    for _ in range(3):
        p, q, x = ca.SX.sym("p"), ca.SX.sym("q"), None
        kinds = rng.choice(["real", "reals", "pair", "pairs", "both"], 2, replace=False)
        places = rng.choice(np.arange(-3, 4), 2, replace=False) / 4
        orders, ways, rate = rng.choice([1, 1, 3], 2), rng.choice([-1, 1], 2), rng.integers(1, 4)
        blocks = [
            block(str(k), int(s) * (p - float(a)) ** int(e) * (2 + q**2), int(rate))
            for k, a, e, s in zip(kinds, places, orders, ways, strict=True)
        ]
        matrix = hidden(blocks, rng)
        n = matrix.shape[0]
        x = ca.SX.sym("x", n)
        system = st.System(
            "planted",
            x,
            ca.vertcat(p, q),
            matrix @ x,
            states=tuple(STATES[:n]),
            parameters=("p", "q"),
        )
        family = st.Family(system, "rest", at=("p",), held=dict.fromkeys(STATES[:n], 0))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = st.boundaries(family, axis=("p", -1.03, 1.11, 8), q=0.5)
        drawn = st.stability_map(family, x=("p", -1.03, 1.11, 8), y=("q", 0.25, 0.5, 2))
        true = {
            float(a): Crossing.FLUTTER if str(k).startswith("pair") else Crossing.STATIC
            for k, a in zip(kinds, places, strict=True)
        }
        both = {float(a) for k, a in zip(kinds, places, strict=True) if k == "both"}
        for b in found:
            place = round(4 * b.value) / 4
            wanted = Crossing.STATIC_AND_FLUTTER if place in both else true[place]
            assert b.crossing is wanted, (kinds, b)  # curves of maps know one kind at a place
            assert (b.frequency == 0) == (b.crossing is Crossing.STATIC)
        codes = {code: kind for kind, code in KINDS.items()}
        for value, code in zip(drawn.boundary_p.values, drawn.boundary_kind.values, strict=True):
            assert codes[int(code)] is true[round(4 * float(value)) / 4], (kinds, value)
            seen += 1
    assert seen


def test_a_pair_that_crosses_upright_is_no_static_boundary() -> None:
    """At the double next to π/2 the constant term is its distance squared: small, but not zero.

    Oracle: at θ = π/2 the disk flutters at mu = 1 with frequency √3, for k = 1/4.
    """
    drawn = st.stability_map("tumbling", x=("at", 1.4, np.pi - 1.4, 3), y=("mu", 0.9, 1.05, 3))
    upright = np.flatnonzero(np.abs(drawn.boundary_at.values - np.pi / 2) < 1e-12)
    assert len(upright)
    for i in upright:
        assert float(drawn.boundary_mu[i]) == pytest.approx(1, rel=1e-12)
        assert int(drawn.boundary_kind[i]) == KINDS[Crossing.FLUTTER]
        assert float(drawn.boundary_frequency[i]) == pytest.approx(3**0.5, rel=1e-9)


def _crossing_lines(slopes: tuple[float, float], turned: bool) -> st.Family:
    """A pair with the real part -(v - s u)(v - t u): unstable between two lines that cross."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    u, v = (p[1] - 0.013, p[0] - 0.017) if turned else (p[0] - 0.017, p[1] - 0.013)
    rate = -(v - slopes[0] * u) * (v - slopes[1] * u)
    rates = ca.vertcat(rate * x[0] - x[1], x[0] + rate * x[1])
    system = st.System("cross", x, p, rates, states=("a", "b"), parameters=("p", "q"))
    return st.Family(system, "rest", at=("p",), held={"a": 0, "b": 0})


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("slopes", "turned"),
    [
        ((0.75, 1.25), False),
        ((0.1, 0.4), True),
        ((-0.2, 0.2), False),
    ],
)
def test_no_corridor_is_drawn_where_two_boundaries_cross(
    slopes: tuple[float, float], turned: bool
) -> None:
    """Where a curve goes over from one line to the other, it passes the crossing closely."""
    family = _crossing_lines(slopes, turned)
    drawn = st.stability_map(family, x=("p", -1, 1, 41), y=("q", -1, 1, 41))
    u, v = drawn.boundary_p.values - 0.017, drawn.boundary_q.values - 0.013
    if turned:
        u, v = v, u
    off = np.min([np.abs(v - s * u) for s in slopes], axis=0)
    assert off.max() < 1e-12
    over = 0
    for curve in np.unique(drawn.boundary_curve.values):
        mine = drawn.boundary_curve.values == curve
        a, b = u[mine], v[mine]
        for i in np.flatnonzero(np.diff((np.abs(b - slopes[0] * a) < 1e-12).astype(int))):
            if np.hypot(a[i], b[i]) < 0.5:
                length = np.hypot(a[i + 1] - a[i], b[i + 1] - b[i])
                passed = abs(a[i] * b[i + 1] - a[i + 1] * b[i]) / length
                assert passed < 0.05 / 4  # a quarter of a cell
                over += 1
    assert over >= 2


@pytest.mark.parametrize(
    ("blocks", "word", "frequency", "frequencies"),
    [
        ([(1, 4), (1, 4)], "flutter", 2.0, (2.0, 2.0)),
        ([(1, 4), (3, 9)], "flutter", 2.0, (2.0, 3.0)),
        ([(1, 5), ()], "static_and_flutter", 5**0.5, (0.0, 5**0.5)),
        ([(1, 3), (1, 3), ()], "static_and_flutter", 3**0.5, (0.0, 3**0.5, 3**0.5)),
        ([(), ()], "static", 0.0, (0.0, 0.0)),
        ([(1, 5)], "flutter", 5**0.5, ()),
        ([()], "static", 0.0, ()),
    ],
)
def test_all_that_crosses_at_once_is_named(
    blocks: list[tuple[float, ...]], word: str, frequency: float, frequencies: tuple[float, ...]
) -> None:
    """Oscillators q'' + c p q' + k q = 0, and q' = -p q for (): all cross at p = 0."""
    p, rows, names = ca.SX.sym("p"), [], []
    for i, block in enumerate(blocks):
        q, v = ca.SX.sym(f"q{i}"), ca.SX.sym(f"v{i}")
        rows += [(q, v), (v, -block[0] * p * v - block[1] * q)] if block else [(q, -p * q)]
        names += [f"q{i}", f"v{i}"] if block else [f"q{i}"]
    x, rates = (ca.vertcat(*column) for column in zip(*rows, strict=True))
    system = st.System("blocks", x, p, rates, states=tuple(names), parameters=("p",))
    rest = st.Family(system, "rest", at=("p",), held=dict.fromkeys(names, 0.0))
    [found] = st.boundaries(rest, axis=("p", -1, 1.25, 9))
    assert (found.value, found.crossing.word) == (0.0, word)
    assert found.frequency == pytest.approx(frequency)
    assert found.frequencies == pytest.approx(frequencies)


@pytest.mark.parametrize(
    ("touching", "crossing", "word", "frequency", "frequencies"),
    [
        ("-p**2", "p, 1", "flutter", 1.0, ()),
        ("-fabs(p)", "p, 1", "flutter", 1.0, ()),
        ("-p**2, 1", "p, 3", "flutter", 3.0, ()),
        ("-p**2, 1", "p", "static", 0.0, ()),
        ("p, p", "", "static", 0.0, (0.0, 0.0)),
    ],
)
def test_what_touches_the_axis_is_not_what_crosses(
    touching: str, crossing: str, word: str, frequency: float, frequencies: tuple[float, ...]
) -> None:
    """Eigenvalues a, or a ± b i, by blocks; at p = 0 the first touches the axis, if it does."""
    p, blocks = ca.SX.sym("p"), []
    for text in filter(None, (touching, crossing)):
        a, *b = (eval(part, {"p": p, "fabs": ca.fabs}) for part in text.split(","))  # noqa: S307
        blocks.append(ca.blockcat([[a, b[0]], [-b[0], a]]) if b else ca.SX(a))
    matrix = ca.diagcat(*blocks)
    x = ca.SX.sym("x", matrix.shape[0])
    names = [f"x{i}" for i in range(x.numel())]
    system = st.System("blocks", x, p, ca.mtimes(matrix, x), states=names, parameters=("p",))
    rest = st.Family(system, "rest", at=("p",), held=dict.fromkeys(names, 0.0))
    [found] = st.boundaries(rest, axis=("p", -1, 1.25, 9))
    assert (found.value, found.crossing.word, found.frequencies) == (0.0, word, frequencies)
    assert found.frequency == pytest.approx(frequency)
    assert len(st.hopf(rest, axis=("p", -1, 1.25, 9))) == (word == "flutter")


def test_points_of_a_rest_with_quadratic_drag() -> None:
    """-v|v| has the slope 0 at rest: x'' = p x' - k x, with a double zero at p = k = 0."""
    x, v, p, k = (ca.SX.sym(n) for n in ("x", "v", "p", "k"))
    rates = ca.vertcat(v, -k * x + p * v - v * ca.fabs(v))
    system = system_of("drag", [x, v], [p, k], rates)
    rest = st.Family(system, "rest", at=("p",), held={"x": 0, "v": 0})
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", st.StabilityWarning)
        found = st.codimension_two(rest, x=("p", -1, 1, 4), y=("k", -1, 1, 4))
    [point] = [d for d in found if d.kind is st.PointKind.DOUBLE_ZERO]
    assert (point.x, point.y) == (0.0, 0.0)
    [birth] = st.hopf(rest, axis=("p", -1, 1, 5), k=1.0)
    assert birth.kind is st.Onset.UNDECIDED
    assert birth.reason.endswith("or the rates have no second derivative")


def test_a_crossing_next_to_another_is_not_one_with_it() -> None:
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p")
    rates = ca.vertcat(x[1], -p * x[1] - 5 * x[0], -(p + 1e-14) * x[2])
    system = st.System("near", x, p, rates, states=("q", "v", "w"), parameters=("p",))
    rest = st.Family(system, "rest", at=("p",), held=dict.fromkeys(system.states, 0.0))
    [found] = st.boundaries(rest, axis=("p", -1, 1.25, 9))
    assert (found.crossing.word, found.frequencies) == ("flutter", ())
