"""Maps of one's own families: verdicts against exact fractions, growth rates against NumPy.

The oracle is Routh's array over `fractions.Fraction`, from the coefficients of SymPy's determinant.
"""

from __future__ import annotations

import pickle
import random
from concurrent.futures import ProcessPoolExecutor
from fractions import Fraction
from math import comb
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
import sympy
from flint import arb, fmpq
from own_systems import system_of

import stability as st
from stability.algebra.exact.number_fields import NotExact
from stability.algebra.real_factors import enclose
from stability.base.axis import Axis
from stability.base.errors import ParameterError
from stability.maps import cells as cells_module
from stability.maps import engine as own_cells
from stability.maps import slices
from stability.maps.rates import coarse_to_fine
from stability.maps.slices import slice_of
from stability.maps.surfaces import Box, Surface, Window, _double, powers
from stability.maps.verdicts import ELSEWHERE, slice_verdicts
from stability.spectra.axes import swept
from stability.spectra.certificate import verdict

STABLE, UNSTABLE, NEUTRAL, NO_MEMBER = 1, 2, 3, 4


def routh(coefficients: list[Fraction]) -> bool:
    """Whether all roots have Re < 0; highest coefficient first, no zero in the first column."""
    above, below = coefficients[::2], coefficients[1::2]
    signs = [above[0]]
    while below:
        signs.append(below[0])
        if below[0] == 0:
            return False
        ratio = above[0] / below[0]
        padded = [*below[1:], Fraction(0)]
        rest = [a - ratio * b for a, b in zip(above[1:], padded, strict=False)]
        above, below = below, rest
    return all(s * signs[0] > 0 for s in signs)


def family(
    rows: list[list[Any]], names: tuple[str, ...], p: Any, *, at: int = 1, **more: Any
) -> st.Family:
    """A linear system x' = A x at rest."""
    size = len(rows)
    x = ca.SX.sym("x", size)
    rhs = ca.vertcat(
        *[sum((rows[i][j] * x[j] for j in range(size)), ca.SX(0)) for i in range(size)]
    )
    states = tuple(f"s{i}" for i in range(size))
    system = st.System("own", x, p, rhs, states=states, parameters=names)
    return st.Family(system, "rest", at=names[:at], held=dict.fromkeys(states, 0.0), **more)


def entries(x: Any, y: Any) -> list[list[Any]]:
    """A matrix of four states that is rational in two numbers."""
    return [
        [0, 0, 1, 0],
        [0, 0, 0, 1],
        [-2 - y, x * x - 1, -1 + x * y, x / (3 + y * y)],
        [1 - x, -3 * y, -x, -0.5 - y],
    ]


@pytest.fixture(scope="module")
def rational() -> st.Family:
    p = ca.SX.sym("p", 2)
    return family(entries(p[0], p[1]), ("a", "b"), p)


@pytest.fixture(scope="module")
def polynomial() -> Any:
    """Coefficients of det(λ - A) by SymPy, as a function of fractions, highest first."""
    x, y, lam = sympy.symbols("x y lam")
    matrix = sympy.Matrix(entries(x, y)).applyfunc(sympy.nsimplify)
    rows = [sympy.lambdify((x, y), c) for c in matrix.charpoly(lam).all_coeffs()]
    return lambda a, b: [Fraction(r(Fraction(a), Fraction(b))) for r in rows]


AXES: dict[str, Any] = {"x": ("a", -1.5, 2.0, 40), "y": ("b", -1.0, 1.7, 30)}


@pytest.fixture(scope="module")
def mapped(rational: st.Family) -> Any:
    return st.stability_map(rational, **AXES, modes=True, boundaries=False)


def judge(some: st.Family, x: Any, y: Any, **fixed: float) -> tuple[Any, Any, Any]:
    axes = Axis.of(x, "x"), Axis.of(y, "y")
    question = swept(some, {a.name: a for a in axes}, parameters=fixed)[0]
    return slice_verdicts(question, axes), question, axes


def test_every_cell_has_the_verdict_of_exact_fractions(mapped: Any, polynomial: Any) -> None:
    for i, b in enumerate(mapped.b.values):
        for j, a in enumerate(mapped.a.values):
            wanted = STABLE if routh(polynomial(a, b)) else UNSTABLE
            assert mapped.verdict.values[i, j] == wanted, (a, b)
    assert {STABLE, UNSTABLE} <= set(mapped.verdict.values.ravel().tolist())
    assert mapped.attrs["method"].startswith("characteristic polynomial of the family over Q")
    assert " of 1200 cells there)" in mapped.attrs["method"]


def test_cells_agree_with_certified_spectra(mapped: Any, rational: st.Family) -> None:
    chance = random.Random(1)
    for _ in range(25):
        i, j = chance.randrange(30), chance.randrange(40)
        a, b = float(mapped.a[j]), float(mapped.b[i])
        found = st.spectrum(rational, at=a, b=b, certify=True)
        assert mapped.verdict.values[i, j] == found.verdict.code
        off = abs(found.abscissa - mapped.abscissa.values[i, j])
        assert off <= mapped.abscissa_error.values[i, j] + found.abscissa_error


def test_growth_rates_are_those_of_numpy_within_their_bounds(mapped: Any) -> None:
    a, b = np.meshgrid(mapped.a.values, mapped.b.values)
    full = np.empty((*a.shape, 4, 4))
    for i, row in enumerate(entries(a, b)):
        for j, value in enumerate(row):
            full[..., i, j] = value
    values = np.linalg.eigvals(full)
    lead = values.real.max(axis=-1)
    assert (np.abs(lead - mapped.abscissa.values) <= mapped.abscissa_error.values + 1e-9).all()
    assert np.median(mapped.abscissa_error.values) < 1e-12
    sums = mapped.eigenvalues.values.sum(axis=-1), np.trace(full, axis1=-2, axis2=-1)
    assert np.abs(sums[0] - sums[1]).max() < 1e-9
    top = mapped.eigenvalues.values[..., -1]
    assert np.abs(np.abs(top.imag) - mapped.frequency.values).max() < 1e-9


def oscillator() -> st.Family:
    """λ² + (a - b) λ + 1: stable for a > b, neutral for a = b."""
    p = ca.SX.sym("p", 2)
    return family([[0, 1], [-1, p[1] - p[0]]], ("a", "b"), p)


def test_cells_on_a_boundary_are_neutral() -> None:
    """A = b on the diagonal of a grid of quarters, so doubles lie on the boundary itself."""
    axes = {"x": ("a", -8, 8, 65), "y": ("b", -8, 8, 65)}
    found = st.stability_map(oscillator(), **axes, boundaries=False)
    a, b = np.meshgrid(found.a.values, found.b.values)
    wanted = np.where(a > b, STABLE, np.where(a == b, NEUTRAL, UNSTABLE))
    assert (found.verdict.values == wanted).all()
    assert "65 of 4225 cells there" in found.attrs["method"]


@pytest.mark.parametrize("apart", [1e-6, 1e-12, 1.5e-14])
def test_cells_beside_a_boundary_are_decided(apart: float) -> None:
    judged, _, axes = judge(
        oscillator(), ("a", 3 * (1 - apart), 3 * (1 + apart), 65), ("b", 2.9, 3.1, 3)
    )
    xs, ys = axes[0].values, np.array([2.9, 3.0, 3.1])
    codes, exact = judged(xs, ys)
    wanted = [[STABLE if a > b else NEUTRAL if a == b else UNSTABLE for a in xs] for b in ys]
    assert codes.tolist() == wanted
    assert exact == sum(a == 3 for a in xs)  # the filter leaves only the boundary itself


def test_beside_a_boundary_of_the_rational_family(rational: st.Family, polynomial: Any) -> None:
    """A bisection over fractions finds the boundary; cells lie 1e-12 around it."""
    low, high, b = 1.0, 2.0, 0.25
    assert routh(polynomial(low, b)) != routh(polynomial(high, b))
    start = routh(polynomial(low, b))
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if routh(polynomial(middle, b)) == start else (low, middle)
    judged, question, axes = judge(
        rational, ("a", low * (1 - 1e-12), low * (1 + 1e-12), 41), ("b", 0.25, 0.2500001, 2)
    )
    codes, _ = judged(axes[0].values, np.array([b]))
    wanted = [STABLE if routh(polynomial(a, b)) else UNSTABLE for a in axes[0].values]
    assert codes[0].tolist() == wanted
    assert {STABLE, UNSTABLE} == set(wanted)
    values = {n: float(v) for n, v in question.values.items()} | {"a": axes[0].values[7], "b": b}
    assert verdict(question, values).code == wanted[7]


def test_a_random_polynomial_has_no_wrong_sign_near_its_zeros() -> None:
    """Products of lines: cells on the lines and next to them, verdicts from fractions."""
    p = ca.SX.sym("p", 2)
    a, b = p[0], p[1]
    factor = (a - 2 * b) * (a + b - 1) * (3 * a - b)
    some = family([[0, 1], [-1, factor]], ("a", "b"), p)
    judged, _, axes = judge(some, ("a", -2, 2, 65), ("b", -2, 2, 65))
    codes, _ = judged(axes[0].values, axes[1].values)
    for i, y in enumerate(map(Fraction, axes[1].values)):
        for j, x in enumerate(map(Fraction, axes[0].values)):
            damping = -(x - 2 * y) * (x + y - 1) * (3 * x - y)
            wanted = STABLE if damping > 0 else UNSTABLE if damping < 0 else NEUTRAL
            assert codes[i, j] == wanted


def test_reversible_families_are_decided_by_the_square() -> None:
    """λ⁴ + a λ² + b: neutral where both roots λ² are real and negative."""
    p = ca.SX.sym("p", 2)
    rows = [[0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1], [-p[1], 0, -p[0], 0]]
    for conservative in (False, True):
        some = family(rows, ("a", "b"), p, conservative=conservative)
        axes = {"x": ("a", -2, 6, 65), "y": ("b", -2, 6, 65)}
        found = st.stability_map(some, **axes, boundaries=False)
        a, b = np.meshgrid(found.a.values, found.b.values)
        neutral = (a >= 0) & (b >= 0) & (a * a - 4 * b >= 0)
        assert (found.verdict.values == np.where(neutral, NEUTRAL, UNSTABLE)).all()
        inside = (a > 0.1) & (b > 0.1) & (a * a - 4 * b > 0.1)
        assert (found.abscissa.values[inside] == 0).all()
        assert (found.abscissa_error.values[inside] == 0).all()


@pytest.mark.parametrize("count", [9, 40])  # below LEAST cells, and above it without a polynomial
def test_the_graph_too_decides_reversible_families_by_the_square(count: int) -> None:
    """A bead on a turning hoop, q'' = e^q W² q - sinh q: neutral for W < 1, with W² = e^w."""
    q, v, w, k = (ca.SX.sym(n) for n in ("q", "v", "w", "k"))
    rates = ca.vertcat(v, (ca.exp(w) * ca.cos(q) - ca.cosh(k * q)) * ca.sinh(q))
    system = system_of("bead", [q, v], [w, k], rates)
    bottom = st.Family(system, "bottom", at=("w",), held={"q": 0.0, "v": 0.0})
    axes = {"x": ("w", -2, 1.93, count), "y": ("k", 0.5, 3, count)}
    found = st.stability_map(bottom, **axes, boundaries=False)
    wanted = np.where(found.w.values < 0, NEUTRAL, UNSTABLE)
    assert (found.verdict.values == wanted[None, :]).all()


def test_an_angle_that_is_fixed_may_stand_in_a_sine() -> None:
    """λ² + (a sin t - b) λ + 1 with t = 1: the boundary is b = a sin 1, which no double is on."""
    p = ca.SX.sym("p", 3)
    some = family([[0, 1], [-1, p[1] - p[0] * ca.sin(p[2])]], ("a", "b", "t"), p)
    found = st.stability_map(
        some, x=("a", 0.5, 3, 60), y=("b", 0.1, 3, 50), t=1.0, boundaries=False
    )
    a, b = np.meshgrid(found.a.values, found.b.values)
    assert (found.verdict.values == np.where(a * np.sin(1.0) > b, STABLE, UNSTABLE)).all()
    assert found.attrs["method"].startswith("characteristic polynomial of the family over Q")


def test_members_solved_from_linear_equations_and_conditions_that_fail() -> None:
    """X' = v, v' = -k x - c v + f with x as unknown; members exist for k > 0.5 by a condition."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    k, c = p[0], p[1]
    system = st.System(
        "spring",
        x,
        p,
        ca.vertcat(x[1], -k * x[0] - c * x[1] + 3),
        states=("x", "v"),
        parameters=("k", "c"),
        conditions=(st.Condition(k - 0.5, "k is {value}, below 0.5"),),
    )
    some = st.Family(
        system,
        "rest",
        at=("k",),
        held={"v": 0.0},
        unknown={"x": 1.0},
        equations=("v",),
        positive=("x",),
    )
    found = st.stability_map(some, x=("k", 0.25, 4, 61), y=("c", -1, 1, 41), boundaries=False)
    k_, c_ = np.meshgrid(found.k.values, found.c.values)
    wanted = np.where(c_ > 0, STABLE, np.where(c_ < 0, UNSTABLE, NEUTRAL))
    assert (found.verdict.values == np.where(k_ > 0.5, wanted, NO_MEMBER)).all()
    assert np.isnan(found.abscissa.values[found.verdict.values == NO_MEMBER]).all()
    assert found.attrs["method"].startswith("characteristic polynomial")


def transcendental() -> st.Family:
    p = ca.SX.sym("p", 2)
    a, b = p[0], p[1]
    rows = [
        [0, 0, 1, 0],
        [0, 0, 0, 1],
        [-ca.exp(a), ca.sin(b), -0.2 * ca.tanh(a + b), 0],
        [ca.cos(a), -2 - b, 0.3, -0.4 * ca.sin(b)],
    ]
    return family(rows, ("a", "b"), p)


def test_a_family_that_is_not_algebraic(monkeypatch: pytest.MonkeyPatch) -> None:
    some = transcendental()
    axes: dict[str, Any] = {"x": ("a", -1, 2, 60), "y": ("b", -1, 2, 50)}
    found = st.stability_map(some, **axes, boundaries=False)
    assert found.attrs["method"].startswith("eigenvalues of the AD Jacobian")
    monkeypatch.setattr(own_cells, "MOST_STATES", 1)  # the eigensolver alone
    plain = st.stability_map(some, **axes, boundaries=False)
    decided = (found.verdict.values != 0) & (plain.verdict.values != 0)
    assert decided.mean() > 0.999
    assert (found.verdict.values == plain.verdict.values)[decided].all()
    off = np.abs(found.abscissa.values - plain.abscissa.values)
    assert (off <= found.abscissa_error.values + plain.abscissa_error.values).all()
    assert (found.abscissa.values != plain.abscissa.values).any()  # two routes indeed
    _, question, _ = judge(some, axes["x"], axes["y"])
    assert slice_of(question, "a", "b") is None


def test_the_limits_lead_to_the_graph(rational: st.Family, monkeypatch: pytest.MonkeyPatch) -> None:
    slices._cached.cache_clear()
    monkeypatch.setattr(slices, "MOST_DEGREE", 1)
    try:
        found = st.stability_map(rational, **AXES, boundaries=False)
    finally:
        slices._cached.cache_clear()
    assert found.attrs["method"].startswith("eigenvalues of the AD Jacobian")
    small = st.stability_map(rational, x=("a", -1, 1, 9), y=("b", -1, 1, 9), boundaries=False)
    assert small.attrs["method"].startswith("eigenvalues of the AD Jacobian")


def test_boxes_of_an_algebraic_family_hold_one_verdict(
    rational: st.Family, polynomial: Any
) -> None:
    found = st.stability_map(rational, **AXES, certify=True, levels=7, boundaries=False)
    assert 0.9 < found.attrs["box_proved"] < 1
    chance = random.Random(3)
    for n in range(0, found.sizes["box"], 5):
        if found.box_verdict.values[n]:
            a, b = (
                chance.uniform(*ends) for ends in (found.box_a.values[n], found.box_b.values[n])
            )
            wanted = STABLE if routh(polynomial(a, b)) else UNSTABLE
            assert found.box_verdict.values[n] == wanted


def test_own_verdicts_are_streamed_and_others_refused(
    rational: st.Family, mapped: Any, tmp_path: Path
) -> None:
    path = st.stream_map(rational, **AXES, out=tmp_path / "own.nc")
    assert (st.read_map(path).verdict.values == mapped.verdict.values).all()
    with pytest.raises(ParameterError, match=r"no polynomial over Q in a and b"):
        st.stream_map(transcendental(), **AXES, out=tmp_path / "no.nc")


def test_a_slice_travels_to_other_processes(rational: st.Family, mapped: Any) -> None:
    judged, _, axes = judge(rational, AXES["x"], AXES["y"])
    again = pickle.loads(pickle.dumps(judged))
    assert (again(axes[0].values, axes[1].values)[0] == mapped.verdict.values).all()
    with ProcessPoolExecutor(1) as pool:
        found = st.stability_map(rational, **AXES, boundaries=False, executor=pool, workers=1)
    assert (found.verdict.values == mapped.verdict.values).all()


@pytest.mark.parametrize("degree", [2, 4, 5, 6, 7])
def test_discs_hold_the_roots_of_polynomials_with_known_ones(degree: int) -> None:
    """Coefficients from fractions of known roots, some of them close together."""
    chance = random.Random(5)
    roots, rows = [], []
    for _ in range(300):
        own = [Fraction(chance.randint(-40, 40), 8) for _ in range(degree)]
        if chance.random() < 0.3:
            own[1] = own[0] + Fraction(1, 2**10)
        poly = [Fraction(1)]
        for r in own:
            poly = [
                a - r * b for a, b in zip([Fraction(0), *poly], [*poly, Fraction(0)], strict=True)
            ]
        roots.append([float(r) for r in own])
        rows.append(poly[:-1])
    a = np.array([[float(c) for c in row] for row in rows]).T
    error = np.array([[abs(float(Fraction(float(c)) - c)) for c in row] for row in rows]).T
    with np.errstate(all="ignore"):
        found = enclose(a, error, coarse_to_fine(a, (1, a.shape[1])))
    values = np.array(found.real) + 1j * np.array(found.imag)
    radius = np.array(found.radius)
    apart = np.isfinite(radius).all(axis=0)
    for n, exact in enumerate(roots):
        if apart[n]:
            for z, r in zip(values[:, n], radius[:, n], strict=True):
                assert sum(abs(z - e) <= r for e in exact) == 1
    distinct = np.array([len(set(r)) == degree for r in roots])
    assert apart[distinct].mean() > 0.9
    assert not apart[~distinct].any()


def test_cells_that_a_slice_leaves_open_are_marked() -> None:
    """Where the mass 1 + a vanishes there is no linearisation: the slice says nothing."""
    p = ca.SX.sym("p", 2)
    some = family([[0, 1], [-1 / (1 + p[0]), -p[1]]], ("a", "b"), p)
    judged, _, _ = judge(some, ("a", -2, 2, 65), ("b", 1, 2, 3))
    codes, _ = judged(np.array([-2.0, -1.0, 0.0]), np.array([1.0, 2.0]))
    assert codes.tolist() == [[UNSTABLE, ELSEWHERE, STABLE]] * 2
    assert not judged.everywhere


def test_no_sign_is_taken_from_a_rounded_sum() -> None:
    """(3x - y)⁷ in powers of x and y: next to its zeros most of its digits cancel."""
    windows = Window(Axis.of(("x", 0.1, 2.0, 9), "x")), Window(Axis.of(("y", 0.1, 6.0, 9), "y"))
    terms = {(k, 7 - k): fmpq(comb(7, k) * 3**k * (-1) ** (7 - k)) for k in range(8)}
    one = Surface(terms, windows)
    random_ = np.random.default_rng(2)
    x = random_.uniform(0.1, 1.6, 4000)
    y = 3 * x * (1 + random_.uniform(-1, 1, 4000) * 10.0 ** random_.uniform(-6, -0.5, 4000))
    y = np.clip(y, 0.1, 6.0)
    wanted = np.array(
        [
            1 if 3 * Fraction(u) > Fraction(v) else -1 if 3 * Fraction(u) < Fraction(v) else 0
            for u, v in zip(x, y, strict=True)
        ]
    )
    t, s = powers(windows[0](x), 7), powers(windows[1](y), 7)
    found = [one.at(t, s)]
    for share in (0.2, 0.001):
        ends = [windows[0](x), windows[0](x + share * x)]
        box = Box(ends, [windows[1](y), windows[1](y)], (7, 7))
        over = one.over(box)
        beyond = (3 * (1 + share) * x - y) * wanted > 0  # the other end of the box
        assert beyond[over != 0].all()
        offsets = [windows[k](v)[:, None] - box.middle[k][:, None] for k, v in ((0, x), (1, y))]
        found += [over, one.inside(box, *offsets)[:, 0, 0]]
    for signs in found:
        assert (signs[signs != 0] == wanted[signs != 0]).all()
    shares = [(signs != 0).mean() for signs in found]
    assert 0.05 < min(shares[0], shares[3], shares[4]) and max(shares) < 1, shares


def test_a_coefficient_in_a_ball_that_is_wide_is_no_double() -> None:
    exact = fmpq(3, 8)
    assert _double(exact, 1) == _double(arb(3) / 8, 1) == 3 / 16
    with pytest.raises(NotExact, match="not narrow"):
        _double(arb(1, 1e-9), 1)


def test_a_small_map_takes_no_polynomial() -> None:
    assert cells_module.LEAST > 100


@pytest.mark.few(1)
@pytest.mark.parametrize("count", [5, 41])
@pytest.mark.parametrize(
    ("stiffness", "fixed", "solved"),
    [
        (lambda k, _: 1 + k, {}, False),
        (lambda k, t: 1 + k * ca.sin(t), {"t": 0.5}, False),  # the sine of a number: no polynomial
        (lambda k, _: 1 + ca.exp(k), {}, False),
        (lambda k, _: 2 + k, {}, True),
    ],
)
def test_cells_exactly_on_a_boundary_are_neutral_by_proof(
    count: int, stiffness: Any, fixed: dict[str, float], solved: bool
) -> None:
    """Damping c = 0 leaves a pair on the axis: λ² + c λ + k with k > 0, in every cell of a row."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 3)
    push = p[0] if solved else 0  # the equilibrium is then a root of a cubic, at k = p[0]
    rates = ca.vertcat(x[1], push - stiffness(p[0], p[2]) * x[0] - x[0] ** 3 - p[1] * x[1])
    system = st.System("oscillator", x, p, rates, states=("u", "v"), parameters=("k", "c", "t"))
    options: Any = (
        {
            "held": {"v": 0},
            "unknown": {"u": 0.1},
            "equations": ("v",),
            "typical": {"k": 0.5, "c": 1, "t": 1},
        }
        if solved
        else {"held": {"u": 0, "v": 0}}
    )
    family = st.Family(system, "rest", at=("k",), **options)
    found = st.stability_map(
        family, x=("k", -0.5, 0.5, count), y=("c", -1, 1, count), **({"t": 0.25} | fixed)
    )
    half = count // 2
    words = found.verdict.values
    assert (words[half] == st.Verdict.NEUTRAL.code).all()
    assert (words[:half] == st.Verdict.UNSTABLE.code).all()
    assert (words[half + 1 :] == st.Verdict.STABLE.code).all()
    assert found.boundary_unresolved == 0 and (abs(found.boundary_c) <= found.boundary_error).all()


def test_bounds_of_values_hold_over_random_polynomials_and_are_not_idle() -> None:
    """Values over grids and in pairs of doubles, against exact fractions."""
    chance = np.random.default_rng(1)
    worst = 0.0
    for trial in range(90):
        degrees = chance.integers(0, 5, 2)
        terms = {
            (i, j): Fraction(int(chance.integers(1, 50)) * (-1) ** (i + j), 1 + 2 * (trial % 3))
            for i in range(degrees[0] + 1)
            for j in range(degrees[1] + 1)
            if chance.random() < 0.6
        } or {(1, 0): Fraction(1)}
        low = chance.uniform(-2, 2)
        high = low + (1e-3 if trial % 3 else 1.0) * abs(low)
        windows = (
            Window(Axis("x", low, high, 9), "", 1 + trial % 2),
            Window(Axis("y", 0.01, 5.0, 9)),
        )
        one = Surface({e: fmpq(*c.as_integer_ratio()) for e, c in terms.items()}, windows)
        xs, ys = chance.uniform(low, high, 9), chance.uniform(0.01, 5, 9)
        value, error = one.product(
            *(powers(w(v), d) for w, v, d in zip(windows, (xs, ys), one.degrees, strict=True))
        )
        rows, columns = (v.ravel() for v in np.indices((9, 9)))
        first, second, bound = one.twice(windows[0].pairs(xs), windows[1].pairs(ys), rows, columns)
        for n, (i, j) in enumerate(zip(rows, columns, strict=True)):
            x, y = Fraction(float(xs[j])) ** windows[0].power, Fraction(float(ys[i]))
            exact = (
                sum(c * x**a * y**b for (a, b), c in terms.items()) / Fraction(2) ** one.exponent
            )
            off = abs(Fraction(float(value[i, j])) - exact)
            assert off <= Fraction(float(error[i, j]))
            worst = max(worst, float(off) / float(error[i, j]))
            pair = Fraction(float(first[n])) + Fraction(float(second[n]))
            assert abs(pair - exact) <= Fraction(float(bound[n]))
            assert bound[n] < 1e-9 * max(float(error[i, j]), 1e-17)
    assert worst > 0.5


def test_unknowns_that_follow_one_from_another_have_a_slice() -> None:
    """Selkov's glycolysis: u = b and v = b/(a + b²) solve no linear system, but are quotients."""
    u, v, a, b = (ca.SX.sym(n) for n in "uvab")
    used = a * v + u**2 * v
    rates = ca.vertcat(used - u, b - used)
    system = st.System("sugar", ca.vertcat(u, v), ca.vertcat(a, b), rates, ("u", "v"), ("a", "b"))
    steady = system.steady("a", guess={"u": 0.6, "v": 1.3, "a": 0.1, "b": 0.6})
    axes: dict[str, Any] = {"x": ("a", 0.02, 0.14, 9), "y": ("b", 0.2, 1.1, 9)}
    _, question, _ = judge(steady, axes["x"], axes["y"])
    assert slice_of(question, "a", "b") is not None
    found = st.stability_map(steady, **axes, boundaries=False)
    assert {STABLE, UNSTABLE} == set(found.verdict.values.ravel().tolist())
    for i, second in enumerate(found.b.values):
        for j, first in enumerate(found.a.values):
            total, product = first + second**2, second**2 - first
            trace = product / total - total  # of the Jacobian; its determinant is a + b² > 0
            assert found.verdict.values[i, j] == (UNSTABLE if trace > 0 else STABLE)
