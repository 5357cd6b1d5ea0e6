"""Points of codimension two on families with folds: published ones, and planted ones."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
import pytest
from own_systems import symbols, system_of

import stability as st

DOUBLE_ZERO, ZERO_HOPF, DOUBLE_HOPF, VANISHING, CUSP = st.PointKind


def points(found: st.CodimensionTwo, kind: st.PointKind) -> list[tuple[float, float]]:
    return [(p.x, p.y) for p in found if p.kind is kind]


def bazykin() -> st.Family:
    x, y, a, d = symbols("x", "y", "a", "d")
    eaten = x * y / (1 + a * x)
    rates = ca.vertcat(x - eaten - x**2 / 100, -y + eaten - d * y**2)
    system = system_of("Bazykin", [x, y], [a, d], rates)
    return system.steady(("a", "d"), guess={"x": 6.27, "y": 3.6, "a": 0.45, "d": 0.1745})


@pytest.mark.filterwarnings("ignore::stability.StabilityWarning")
def test_a_double_zero_on_a_fold_is_proved() -> None:
    """Bazykin's: Kuznetsov, and trace = det = 0 by Newton's method."""
    found = st.codimension_two(bazykin(), x=("a", 0.44, 0.47, 5), y=("d", 0.17, 0.18, 5))
    [point] = found
    assert point.kind is DOUBLE_ZERO
    assert (point.x, point.y) == pytest.approx((0.453624327778, 0.175127592950), abs=1e-12)
    assert max(point.x_error, point.y_error) < 1e-14
    assert point.member == pytest.approx({"x": 6.265765528962, "y": 3.601553936836}, abs=1e-11)
    assert not found.complete and "folds" in found.statement
    assert {b.kind for b in found.unresolved} == {DOUBLE_ZERO, CUSP}  # two states: no two pairs


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::stability.StabilityWarning")
def test_every_sheet_of_the_members_is_searched() -> None:
    found = st.codimension_two(bazykin(), x=("a", 0.1, 1.2, 5), y=("d", 0.001, 0.4, 5))
    first, second = points(found, DOUBLE_ZERO)
    assert first == pytest.approx((0.453624327778, 0.175127592950), abs=1e-12)
    assert second == pytest.approx((0.860704459310, 0.006058794394), abs=1e-12)
    [cusp] = points(found, CUSP)
    assert cusp == pytest.approx((0.901232691939, 0.003568419361), abs=1e-12)


@pytest.mark.filterwarnings("ignore::stability.StabilityWarning")
def test_a_cusp_in_closed_form_is_proved_where_folds_meet() -> None:
    """exp(x) - 1 - x - x²/2 has a triple zero at 0."""
    x, a, b = symbols("x", "a", "b")
    rate = -(ca.exp(x) - 1 - x - x**2 / 2) + (a - 0.25) + (b - 0.5) * x
    system = st.System("cusp", x, ca.vertcat(a, b), rate, states=("x",), parameters=("a", "b"))
    family = system.steady(("a", "b"), guess={"x": 0.3, "a": 0.3, "b": 0.4})
    found = st.codimension_two(family, x=("a", 0, 0.6, 5), y=("b", 0, 1, 5))
    [point] = found
    assert (point.kind, point.x, point.y) == (CUSP, 0.25, 0.5)
    assert abs(point.member["x"]) < 1e-30 and point.others == "stable" and not found.complete


@pytest.mark.filterwarnings("ignore::stability.StabilityWarning")
def test_curves_of_folds_and_of_pairs_are_proved_at_every_point() -> None:
    """X' = y, y' = m + n y + x² - x y: folds on m = 0, pairs on n = x = -√-m."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    rates = ca.vertcat(x[1], p[0] + p[1] * x[1] + x[0] ** 2 - x[0] * x[1])
    system = st.System("Takens", x, p, rates, states=("q", "v"), parameters=("m", "n"))
    family = system.steady(("m", "n"), guess={"q": -0.5, "v": 0, "m": -0.25, "n": 0.3})
    axes = {"x": ("m", -0.5, 0.25, 5), "y": ("n", -1.0, 0.5, 5)}
    found = st.codimension_two(family, **axes, curves=True)
    assert points(found, DOUBLE_ZERO) == [(0, 0)]
    assert {c.crossing for c in found.curves} == {st.Crossing.STATIC, st.Crossing.FLUTTER}
    for curve in found.curves:
        static = curve.crossing is st.Crossing.STATIC
        for m, n, error, frequency in zip(
            curve.x, curve.y, curve.error, curve.frequency, strict=True
        ):
            room = 2 * error + 1e-15
            assert abs(m if static else m + n * n) <= room
            assert abs(frequency**2 - (0 if static else -2 * n)) <= 1e-12
    figure = st.plot_map(st.stability_map(family, **axes), points=found)
    legends = [*figure.legends, *(ax.get_legend() for ax in figure.axes if ax.get_legend())]
    words = [text.get_text() for legend in legends for text in legend.get_texts()]
    assert {"curve of zeros", "curve of pairs"} <= set(words)


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::stability.StabilityWarning")
def test_the_oxidation_of_carbon_monoxide_has_its_printed_double_zeros() -> None:
    """BifurcationKit.jl, test/hopf_codim_2/COModel.jl, prints six digits."""
    x, y, s, q, k = symbols("x", "y", "s", "q", "k")
    z = 1 - x - y - s
    rates = ca.vertcat(
        5 * z**2 - 2 * x**2 - 10 * x * y, q * z - 0.1 * y - 10 * x * y, 0.0675 * (z - k * s)
    )
    system = system_of("oxidation", [x, y, s], [q, k], rates)
    guess = {"x": 0.001137, "y": 0.891483, "s": 0.062345, "q": 1.0, "k": 0.4}
    family = system.steady(("q", "k"), guess=guess)
    found = st.codimension_two(family, x=("q", 0.8, 2, 8), y=("k", 0.2, 1.2, 8))
    first, second = points(found, DOUBLE_ZERO)
    assert first == pytest.approx((1.161199, 0.722339), abs=1e-6)
    assert second == pytest.approx((1.417628, 0.971397), abs=1e-6)
    assert len(points(found, CUSP)) == 1 and len(points(found, VANISHING)) == 2


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::stability.StabilityWarning")
def test_lorenz_84_has_every_kind_and_its_mirror_images() -> None:
    x, y, z, u, f, t = symbols("x", "y", "z", "u", "f", "t")
    rates = ca.vertcat(
        -(y**2) - z**2 - x / 4 + f / 4 - 0.987 * u**2,
        x * y - x * z - y + 0.25,
        x * y + x * z - z,
        -1.04 * u + 0.987 * u * x + t,
    )
    system = st.System(
        "Lorenz-84",
        ca.vertcat(x, y, z, u),
        ca.vertcat(f, t),
        rates,
        states=("x", "y", "z", "u"),
        parameters=("F", "T"),
    )
    guess = {"x": 2.9787, "y": -0.0982, "z": 0.3711, "u": 0.1, "F": 3.0, "T": 0.04}
    family = system.steady(("F", "T"), guess=guess)
    found = st.codimension_two(family, x=("F", -4, 5.5, 8), y=("T", -0.25, 0.25, 8))
    for kind in (DOUBLE_ZERO, ZERO_HOPF, DOUBLE_HOPF, VANISHING):
        low, high = points(found, kind)
        assert low[0] == high[0] and low[1] == -high[1] < 0
    [cusp] = points(found, CUSP)
    assert cusp[1] == 0


def moved(core: Any, size: int, point: tuple[float, float], seed: int) -> st.Family:
    """A family with a planted point, in coordinates bent and turned at random."""
    rng = np.random.default_rng(seed)
    x, p = ca.SX.sym("x", size), ca.SX.sym("p", 2)
    turn, place = rng.normal(size=(size, size)) + 2 * np.eye(size), rng.uniform(-1, 1, size)
    straight = ca.mtimes(np.linalg.inv(turn), x - place)
    bent = [straight[0]]
    for i in range(1, size):
        bent.append(straight[i] + rng.uniform(-0.3, 0.3) * ca.sin(bent[0]) * bent[i - 1])
    y = ca.vertcat(*bent)
    inner = ca.SX.sym("y", size)
    rates = ca.substitute(core(ca.vertsplit(inner), p[0] - point[0], p[1] - point[1]), inner, y)
    names = tuple(f"x{i}" for i in range(size))
    rates = ca.solve(ca.jacobian(y, x), rates)
    system = st.System("planted", x, p, rates, states=names, parameters=("a", "b"))
    guess = dict(zip(names, place + 0.05, strict=True)) | {"a": point[0] - 0.02, "b": point[1]}
    return system.steady(("a", "b"), guess=guess)


def takens(y: Any, m: Any, n: Any) -> Any:
    return ca.vertcat(y[1], m + n * y[1] + y[0] ** 2 - y[0] * y[1])


def cusp(y: Any, m: Any, n: Any) -> Any:
    return ca.vertcat(m + n * y[0] - y[0] ** 3, -y[1] + y[0] ** 2)


def zero_and_pair(y: Any, m: Any, n: Any) -> Any:
    r = y[1] ** 2 + y[2] ** 2
    return ca.vertcat(
        m + y[0] ** 2 - r, n * y[1] - 1.3 * y[2] + y[0] * y[1], 1.3 * y[1] + n * y[2] + y[0] * y[2]
    )


@pytest.mark.few(3)
@pytest.mark.filterwarnings("ignore::stability.StabilityWarning")
@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize(
    ("core", "size", "kind"),
    [(takens, 2, DOUBLE_ZERO), (cusp, 2, CUSP), (zero_and_pair, 3, ZERO_HOPF)],
)
def test_a_planted_point_on_a_fold_is_found(core: Any, size: int, kind: Any, seed: int) -> None:
    family = moved(core, size, (0.3, -0.2), seed)
    found = st.codimension_two(family, x=("a", 0, 0.5, 5), y=("b", -0.5, 0.15, 5))
    [point] = found  # and no change of sign at the pole of a coefficient next to it
    assert point.kind is kind and (point.x, point.y) == pytest.approx((0.3, -0.2), abs=1e-12)
    assert max(point.x_error, point.y_error) < 1e-12
