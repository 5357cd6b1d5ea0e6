"""Intervals cover the truth as often as they say; exponents of known borders."""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np
import pytest
from scipy import stats
from scipy.integrate import solve_ivp

from stability.base.errors import ParameterError, StabilityWarning
from stability.basin.borders import Borders, borders
from stability.basin.statistics.box_counting import box_dimension, sensitive
from stability.basin.statistics.exponent import exponent_of, uncertainty_exponent
from stability.basin.statistics.fractions import fractions, wilson
from stability.basin.statistics.samples import Uniform, sample

Label = Callable[[np.ndarray], np.ndarray]


def weierstrass(wide: int, high: float) -> Label:
    """Basins of y -> ±inf of x -> wide x mod 1, y -> high y + cos 2πx (McDonald et al. 1985)."""

    def label(points: np.ndarray) -> np.ndarray:
        x, y = points.T.copy()
        for _ in range(60):
            x, y = wide * x % 1, high * y + np.cos(2 * np.pi * x)
        return (y > 0).astype(int)

    return label


def newton(points: np.ndarray) -> np.ndarray:
    """The root of z³ = 1 that Newton's method finds: three basins with one common border."""
    z = points[:, 0] + 1j * points[:, 1]
    for _ in range(60):
        z = np.where(z == 0, 1.0, z - (z**3 - 1) / np.where(z == 0, 1.0, 3 * z**2))
    roots = np.exp(2j * np.pi * np.arange(3) / 3)
    return np.argmin(np.abs(z[:, None] - roots), axis=1)


def circle(points: np.ndarray) -> np.ndarray:
    return (np.hypot(points[:, 0] - 0.5, points[:, 1]) < 0.4).astype(int)


def line(points: np.ndarray) -> np.ndarray:
    return (points[:, 1] > 0.3 * points[:, 0] + 0.1).astype(int)


def escaping(points: np.ndarray) -> np.ndarray:
    """Middle thirds of [0, 1], those of odd and of even order; their border is Cantor's set."""
    x, label = points[:, 0].copy(), np.zeros(len(points), int)
    inside = np.ones(len(x), bool)
    for order in range(40):
        digit = np.floor(3 * x)
        gone = inside & (digit == 1)
        label[gone] = order % 2
        inside &= ~gone
        x = 3 * x - digit
    return label


def dimension_of(wide: int, high: float) -> float:
    return 2 - np.log(high) / np.log(wide)


# --- fractions ---


@pytest.mark.parametrize(("k", "n", "level"), [(0, 10, 0.95), (3, 17, 0.9), (40, 40, 0.99)])
def test_wilsons_interval_inverts_the_score_test(k: int, n: int, level: float) -> None:
    """Its ends are the probabilities p with |k - n p| = z √(n p (1 - p)), and 0 and 1 count."""
    low, high = wilson(k, n, level)
    z = stats.norm.ppf(0.5 + level / 2)
    for p, at_wall in ((float(low), k == 0), (float(high), k == n)):
        assert at_wall or abs(k - n * p) == pytest.approx(z * np.sqrt(n * p * (1 - p)))
        assert not at_wall or p == k / n


def test_fractions_are_those_of_scipy() -> None:
    labels = np.repeat([-1, 4, 7], [13, 70, 17])
    found = fractions(labels)
    assert [(f.label, f.count, f.of) for f in found] == [(-1, 13, 100), (4, 70, 100), (7, 17, 100)]
    for one in found:
        wanted = stats.binomtest(one.count, 100).proportion_ci(0.95, "wilson")
        assert (one.low, one.high) == pytest.approx((wanted.low, wanted.high))


def pendulum(points: np.ndarray, damping: float = 0.2, time: float = 30.0) -> np.ndarray:
    """Turns over of a damped pendulum before it rests, by SciPy alone; start (angle, rate)."""
    n = len(points)

    def rates(_: float, x: np.ndarray) -> np.ndarray:
        return np.concatenate([x[n:], -np.sin(x[:n]) - damping * x[n:]])

    end = solve_ivp(rates, (0, time), points.T.ravel(), method="DOP853", rtol=1e-9, atol=1e-9)
    return np.rint(end.y[:n, -1] / (2 * np.pi)).astype(int)


def test_fractions_of_a_damped_pendulum_cover_those_of_a_dense_grid() -> None:
    n = 40
    angle, rate = (-np.pi, np.pi), (-3.0, 3.0)
    middles = [low + (high - low) * (np.arange(n) + 0.5) / n for low, high in (angle, rate)]
    grid = np.stack(np.meshgrid(*middles), axis=-1).reshape(-1, 2)
    dense = pendulum(grid)
    spread = {"angle": Uniform(*angle), "rate": Uniform(*rate)}
    found = {f.label: f for f in fractions(pendulum(sample(spread, 0, 800, seed=6)), 0.99)}
    assert len(found) >= 3
    for label in np.unique(dense):
        area = (dense == label).mean()
        if area > 0.01:
            assert found[int(label)].low < area < found[int(label)].high


def test_the_border_of_a_damped_pendulum_is_its_separatrix() -> None:
    """The saddle's stable manifold, integrated backwards in time from the saddle."""
    found = borders(pendulum, ("angle", -3, 3, 7), ("rate", -1.5, 3, 7), levels=3)

    def past(_: float, x: np.ndarray) -> list[float]:
        return [-x[1], np.sin(x[0]) + 0.2 * x[1]]

    value = (-0.2 - np.sqrt(0.04 + 4)) / 2  # of the saddle's stable direction
    curve = solve_ivp(
        past, (0, 16), [np.pi - 1e-6, -1e-6 * value], rtol=1e-10, atol=1e-12, max_step=0.01
    ).y.T
    (line,) = [n for n in found.lines if n.labels == (0, 1)]
    for point in line.points[np.abs(line.points[:, 0]) < 2.9]:
        apart = np.abs(curve - point) / found.widths[-1]
        assert apart.max(axis=1).min() < 1.05


# --- exponents ---


@pytest.mark.long
@pytest.mark.parametrize("nested", [True, False])
@pytest.mark.parametrize(
    ("alpha", "constant", "points"),
    [
        (1.0, 2.0, 300),
        (0.37, 0.6, 500),
        (0.1, 0.6, 300),
    ],
)
def test_intervals_of_exponents_cover(
    alpha: float, constant: float, points: int, nested: bool
) -> None:
    """Events of one base point are nested (one near border) or independent (a rough one)."""
    steps = np.geomspace(1e-3, 0.1, 8)
    random = np.random.default_rng(17)
    hits, fits = 0, []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", StabilityWarning)
        for _ in range(400):
            even = random.random((points, 1 if nested else len(steps)))
            found = exponent_of(even < constant * steps**alpha, steps, 2)
            hits += found.interval[0] <= alpha <= found.interval[1]
            fits.append(found.fit)
    assert 0.92 <= hits / 400 <= 0.98
    assert 0.02 <= np.mean(np.array(fits) < 0.05) <= 0.09  # the misfit has its size too
    assert np.mean(np.array(fits) < 1e-3) <= 0.02


@pytest.mark.parametrize("share", [lambda e: 0.05 + e, lambda e: 0.8 * (1 - np.exp(-20 * e))])
def test_shares_that_are_no_power_law_are_called_so(share: Label) -> None:
    even = np.random.default_rng(3).random((3000, 1))
    steps = np.geomspace(1e-4, 0.1, 10)
    with pytest.warns(StabilityWarning, match="do not fit a power law"):
        found = exponent_of(even < share(steps), steps, 2)
    assert found.fit < 1e-3
    assert "smaller range" in found.note


@pytest.mark.few(1)
@pytest.mark.parametrize("label", [circle, line])
def test_smooth_borders_have_exponent_one(label: Label) -> None:
    found = uncertainty_exponent(
        label, [0, -0.5], [1, 0.5], np.geomspace(3e-3, 0.1, 8), points=4000
    )
    assert found.interval[0] < 1 < found.interval[1]
    assert found.interval[1] - found.interval[0] < 0.4
    boxes = box_dimension(borders(label, ("x", 0, 1, 9), ("y", -0.5, 0.5, 9), levels=9))
    assert boxes.interval[0] < 1 < boxes.interval[1]
    assert boxes.interval[1] - boxes.interval[0] < 0.15


@pytest.mark.long
@pytest.mark.parametrize(("wide", "high"), [(3, 1.5), (2, 1.5)])
def test_a_weierstrass_border_has_its_dimension_by_both_routes(wide: int, high: float) -> None:
    label, truth = weierstrass(wide, high), dimension_of(wide, high)
    steps = 0.03 * float(wide) ** -np.linspace(0, 5, 11)  # whole periods of its structure
    found = uncertainty_exponent(label, [0, -3], [1, 3], steps, points=4000)
    assert found.dimension_interval[0] < truth < found.dimension_interval[1]
    assert found.dimension_interval[1] - found.dimension_interval[0] < 0.3
    boxes = box_dimension(borders(label, ("x", 0, 1, 9), ("y", -3, 3, 9), levels=7))
    assert boxes.interval[0] < truth < boxes.interval[1]
    assert boxes.interval[1] - boxes.interval[0] < 0.2


def test_a_cantor_set_of_intervals_has_its_exponent() -> None:
    """f(ε) of the ternary set falls with 1 - ln 2 / ln 3."""
    steps = 0.03 * 3.0 ** -np.arange(7)  # once a period of its structure
    found = uncertainty_exponent(escaping, [0], [1], steps, points=6000)
    assert found.dimension_interval[0] < np.log(2) / np.log(3) < found.dimension_interval[1]
    assert found.dimension_interval[1] - found.dimension_interval[0] < 0.1


def test_one_seed_gives_one_answer_however_it_is_asked() -> None:
    steps = np.geomspace(0.01, 0.2, 5)
    a, b, c = (
        uncertainty_exponent(circle, [0, -0.5], [1, 0.5], steps, seed=s, chunk=n)
        for s, n in ((4, None), (4, 131), (5, None))
    )
    assert (a.counts == b.counts).all()
    assert a.exponent == b.exponent != c.exponent


def test_displacements_stay_in_the_box_and_have_their_size() -> None:
    seen = []

    def label(points: np.ndarray) -> np.ndarray:
        seen.append(points)
        return (points[:, 0] > 0).astype(int)

    uncertainty_exponent(label, [-1, 0], [1, 10], [0.01, 0.1, 0.5], points=300)
    launches = seen[0].reshape(300, 4, 2)
    assert (launches >= [-1, 0]).all()
    assert (launches <= [1, 10]).all()
    apart = np.linalg.norm((launches[:, 1:] - launches[:, :1]) / [2, 10], axis=2)
    assert (apart <= np.array([0.01, 0.1, 0.5]) * (1 + 1e-9)).all()  # mirrored ones are nearer
    assert (np.isclose(apart, [0.01, 0.1, 0.5]).mean(axis=0) > [0.97, 0.8, 0.3]).all()


# --- sensitive cells ---


def _map(label: Label, x: tuple[float, float], y: tuple[float, float]) -> Borders:
    return borders(label, ("x", *x, 9), ("y", *y, 9), levels=7)


def test_smooth_borders_and_where_they_meet_are_not_sensitive() -> None:
    def sectors(points: np.ndarray) -> np.ndarray:
        turn = np.arctan2(points[:, 1] - 0.1, points[:, 0] - 0.45) / (2 * np.pi)
        return np.floor(3 * turn).astype(int)

    def wavy(points: np.ndarray) -> np.ndarray:
        return (points[:, 1] > 0.3 * np.sin(9 * points[:, 0])).astype(int)

    for label in (circle, line, sectors, wavy):
        found = sensitive(_map(label, (0, 1), (-0.5, 0.5)))
        assert found.share == 0
        assert len(found.cells) > 1000


@pytest.mark.long
@pytest.mark.parametrize(
    ("label", "x", "y"),
    [
        (newton, (-0.51, 0.5), (-0.51, 0.5)),
        (weierstrass(3, 1.5), (0, 1), (-3, 3)),
    ],
)
def test_fractal_borders_are_sensitive(
    label: Label, x: tuple[float, float], y: tuple[float, float]
) -> None:
    assert sensitive(_map(label, x, y)).share > 0.85


@pytest.mark.long
def test_the_sensitive_part_of_a_border_is_marked_and_the_smooth_part_is_not() -> None:
    rough = weierstrass(3, 1.5)

    def half(points: np.ndarray) -> np.ndarray:
        return np.where(points[:, 0] < 1, rough(points), points[:, 1] > 0.1)

    found = _map(half, (0, 2), (-3, 3))
    marked = sensitive(found)
    left = found.cells[:, 0] < 4 * 2**7 - 64  # of 8 coarse cells; one block is at the change
    right = found.cells[:, 0] >= 4 * 2**7 + 64
    assert marked.cells[left].mean() > 0.8
    assert right.sum() > 100
    assert not marked.cells[right].any()


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: wilson(3, 2), "whole numbers from 0"),
        (lambda: wilson(1, 2, 1.0), "level"),
        (lambda: fractions([]), "whole numbers"),
        (lambda: fractions([0.5]), "whole numbers"),
        (lambda: uncertainty_exponent(circle, [0, 0], [1], [0.1] * 3), "corners"),
        (lambda: uncertainty_exponent(circle, [0, 0], [1, 1], [0.1, 0.2]), "at least three"),
        (lambda: uncertainty_exponent(line, [0, 5], [1, 6], [0.1, 0.2, 0.3]), "differ at 0 of 3"),
        (lambda: exponent_of(np.ones((9, 3)), [0.1, 0.2, 0.3], 1), "all base points differ"),
        (lambda: box_dimension(borders(line, ("x", 0, 1, 3), ("y", 0, 1, 3), levels=3)), "refine"),
        (lambda: sensitive(borders(line, ("x", 0, 1, 3), ("y", 0, 1, 3), levels=3)), "3 levels"),
    ],
)
def test_refusals_say_what_is_wrong(call: Callable[[], object], words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        call()
