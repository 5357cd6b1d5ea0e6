"""A height is proved to be that of a convex body, or refused, between samples too.

1 + ε cos nθ is the height of a convex body exactly where ε (n² - 1) ≤ 1.  The same height is
written in three ways, for the three ways in which a graph is read.
"""

import math
from collections.abc import Callable
from typing import Any

import casadi as ca
import mpmath as mp
import numpy as np
import pytest

import stability as st
from stability.bodies.round_body.height import convexity as proofs
from stability.bodies.round_body.height.expression import expression
from stability.bodies.round_body.shape import SAMPLES

Height = Callable[[Any], Any]
WAYS: dict[str, Callable[[Any], Any]] = {
    "waves": lambda wave: wave,
    "doubles": lambda wave: ca.sqrt(wave * wave),
    "balls": lambda wave: ca.exp(ca.log(wave)),
}


def body(height: Height, **more: Any) -> st.Body:
    return st.Body(height, axial=0.4, transverse=0.4, **more)


def rippled(way: str, share: float, n: int) -> Height:
    """1 + ε cos nθ with ε this share of the largest one of a convex body."""
    return lambda t: WAYS[way](1 + share / (n * n - 1) * ca.cos(n * t))


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("n", [2, 3, 7])
def test_both_sides_of_the_threshold_of_a_ripple_are_told_apart(way: str, n: int) -> None:
    assert body(rippled(way, 1 - 1e-6, n)).unproved == ()
    with pytest.raises(st.StabilityError, match=r"height \+ height'' is -"):
        body(rippled(way, 1 + 1e-5, n))


@pytest.mark.parametrize("way", ["waves", "doubles"])
def test_a_ripple_between_the_samples_is_seen(way: str) -> None:
    """Its waves are as long as two samples are apart: at every one of them it is 0."""
    theta = (np.arange(SAMPLES) + 0.5) * math.pi / SAMPLES
    assert np.abs(np.cos(SAMPLES * theta)).max() < 1e-9
    assert body(rippled(way, 0.5, SAMPLES)).unproved == ()
    with pytest.raises(st.StabilityError, match=r"height \+ height'' is -0\.0[0-9]*"):
        body(rippled(way, 1.02, SAMPLES))


@pytest.mark.parametrize("way", ["waves", "doubles"])
def test_a_ripple_that_is_highest_in_the_middle_of_every_piece_is_seen(way: str) -> None:
    n = 2 * proofs.FIRST
    middle = (np.arange(proofs.FIRST) + 0.5) * math.pi / proofs.FIRST
    assert np.cos(n * middle) == pytest.approx(-1)
    assert body(rippled(way, 0.9, n)).unproved == ()
    with pytest.raises(st.StabilityError, match=r"height \+ height'' is -0\.0[0-9]*"):
        body(rippled(way, 1.05, n))


def test_a_narrow_dent_between_two_samples_is_seen() -> None:
    middle = 200 * math.pi / SAMPLES

    def dented(depth: float) -> Height:
        return lambda t: 1 + depth * 1e-8 * ca.exp(-(((t - middle) / 1e-4) ** 2))

    assert body(dented(0.4)).unproved == ()  # the radius is 1 - 2 depth at the deepest
    with pytest.raises(st.StabilityError, match=r"at theta = 0\.87"):
        body(dented(0.6))


def test_a_height_that_is_negative_between_samples_is_refused() -> None:
    middle = 200 * math.pi / SAMPLES
    with pytest.raises(st.StabilityError, match="must lie above the plane"):
        body(lambda t: ((t - middle) ** 2 - 1e-6) * 1e3, between=(0.5, 1.2))


@pytest.mark.parametrize(
    "made",
    [
        st.Torus(1e-6),
        st.Spheroid(0.02),
        st.EccentricSphere(0.99),
        st.ThickDisk(2.0),
        st.Egg(0.4),
        st.Egg(0.1, aspect=3.0),
        st.Spheroid([0.2, 1.0, 3.0]),
        st.from_profile(lambda u: (np.sin(u), -0.3 * np.cos(u))),
    ],
    ids=lambda b: f"{b.name}-{list(b.shape.values())}",
)
def test_named_bodies_are_proved_everywhere(made: st.Body) -> None:
    assert made.unproved == ()


def test_corners_and_infinite_curvature_stay_open_and_a_corner_inwards_is_refused() -> None:
    [span] = body(lambda t: 1 + 0.3 * ca.fabs(ca.cos(t))).unproved
    assert span[0] < math.pi / 2 < span[1] < span[0] + 1e-4
    with pytest.raises(st.StabilityError, match=r"at theta = 1\.57"):
        body(lambda t: 1 - 0.3 * ca.fabs(ca.cos(t)))

    def super_(t: Any) -> Any:
        return (ca.fabs(ca.sin(t)) ** 1.5 + ca.fabs(0.8 * ca.cos(t)) ** 1.5) ** (2 / 3)

    spans = body(super_).unproved
    assert [round((a + b) / 2, 4) for a, b in spans] == [0.0, 1.5708, 3.1416]
    assert sum(b - a for a, b in spans) < 1e-4
    many = st.Spheroid(np.linspace(0.3, 2.0, 100))
    assert many.unproved == ((0.0, math.pi),)  # at samples alone


@pytest.mark.parametrize("way", WAYS)
def test_bounds_on_pieces_hold_the_true_values(way: str) -> None:
    """h, h', ρ, ρ', ρ'' of 2 + a sin²θ cos 3θ - cos θ/4 to 30 digits, at points of each piece."""
    number = 0.15

    def height(t: Any, a: Any) -> Any:
        return WAYS[way](2 + a * ca.sin(t) ** 2 * ca.cos(3 * t) - ca.cos(t) / 4)

    def true(t: Any) -> Any:
        return 2 + number * mp.sin(t) ** 2 * mp.cos(3 * t) - mp.cos(t) / 4

    read = proofs._enclosure(expression("height", height, ["theta", "a"], 1), ("a",), ((number,),))
    assert read is not None and (read[1] == proofs.FEWER) == (way == "balls")
    chance = np.random.default_rng(7)
    middle, half = chance.uniform(0.1, 3.0, 12), 10 ** chance.uniform(-9, -1.5, 12)
    half[:3] = 0.0
    mid, rad = read[0](middle, half, np.zeros(12, dtype=int))
    assert np.isfinite(mid).all() and (rad[:, :3] < 1e-11).all()
    with mp.workdps(40):
        for i in range(12):
            for share in (-1.0, chance.uniform(-1, 1), 1.0):
                at = mp.mpf(middle[i]) + mp.mpf(share) * mp.mpf(half[i])
                d = [mp.diff(true, at, k) for k in range(5)]
                for row, value in enumerate([d[0], d[1], d[0] + d[2], d[1] + d[3], d[2] + d[4]]):
                    assert abs(mp.mpf(mid[row, i]) - value) <= mp.mpf(rad[row, i]), (row, i)


def test_waves_cancel_exactly() -> None:
    """The height sin 2θ cos θ - sin θ cos 2θ is sin θ: its radius of curvature is exactly 0."""
    found = body(lambda t: ca.sin(2 * t) * ca.cos(t) - ca.sin(t) * ca.cos(2 * t))
    assert found.unproved == ()
    read = proofs._enclosure(found.height, (), ((),))  # type: ignore[arg-type]
    assert read is not None
    mid, rad = read[0](np.array([0.3, 1.0]), np.array([0.1, 0.0]), np.zeros(2, dtype=int))
    assert mid[2].tolist() == [0.0, 0.0] and (rad[2] < 1e-13).all()
