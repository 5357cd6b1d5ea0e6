"""Members over pieces of an axis: enclosed in one ball for each unknown, and found many at once."""

from typing import Any

import casadi as ca
import mpmath as mp
import numpy as np
import pytest
from flint import arb
from own_systems import system_of

import stability as st
from stability.algebra.number_types import precision
from stability.systems.structure.enclosure import ball_unknowns


def reactor() -> st.Family:
    """A stirred tank, dx/dt = -x + φ, dT/dt = -T + B φ - β T with φ = D (1 - x) exp T."""
    x, t, d, b, beta = (ca.SX.sym(n) for n in ("x", "T", "D", "B", "beta"))
    heat = d * (1 - x) * ca.exp(t)
    system = system_of("reactor", [x, t], [d, b, beta], [-x + heat, -t + b * heat - beta * t])
    guess = {"x": 0.1, "T": 0.1, "D": 0.02, "B": 14.0, "beta": 3.0}
    return system.steady("D", guess=guess, name="reactor")


def burning(x: Any) -> Any:
    """D of the steady motion with conversion x, since T = B x/(1 + β)."""
    return x / ((1 - x) * mp.exp(mp.mpf(14) / 4 * x))


def converted(d: float) -> Any:
    """The only x with a given D: D grows with x, since B < 4 (1 + β)."""
    with mp.workdps(40):
        return mp.findroot(lambda x: burning(x) - d, (0.001, 0.999), solver="anderson")


@pytest.mark.few(3)
@pytest.mark.parametrize(
    ("middle", "half"), [(0.5, 0.004), (0.9, 0.01), (0.138, 0.001), (0.05, 0.005)]
)
def test_a_wide_ball_holds_the_members_of_a_piece_and_little_else(
    middle: float, half: float
) -> None:
    family = reactor()
    near = family.member([middle], [14.0, 3.0])
    with precision(128):
        x, t = ball_unknowns(family, [arb(middle, half)], [arb(14), arb(3)], near)
    inside = [converted(d) for d in np.linspace(middle - half, middle + half, 9)]
    for value in inside:
        assert float(x.lower()) <= value <= float(x.upper())
        assert float(t.lower()) <= 14 * value / 4 <= float(t.upper())
    assert float(2 * x.rad()) <= 4 * float(inside[-1] - inside[0])


@pytest.mark.long
def test_both_ends_of_the_oscillation_of_a_reactor_are_found_and_no_other() -> None:
    """On the branch x: det > 0, and the trace -(2 + β) + B x - x/(1 - x) vanishes twice."""
    trace = [mp.mpf(-14), mp.mpf(14 + 2 + 3 - 1), mp.mpf(-5)]  # times 1 - x
    wanted = sorted(burning(x) for x in mp.polyroots(trace))
    found = st.boundaries(reactor(), axis=("D", 0.02, 1.0, 9), B=14.0, beta=3.0)
    assert found.complete
    assert [b.crossing.word for b in found] == ["flutter", "flutter"]
    assert [b.value for b in found] == pytest.approx([float(w) for w in wanted], rel=1e-13)


def nerve() -> st.Family:
    """Hodgkin and Huxley's axon (J. Physiol. 117 (1952) 500), depolarisation positive."""
    v, m, h, n, current = (ca.SX.sym(k) for k in ("V", "m", "h", "n", "I"))
    am = 0.1 * (25 - v) / (ca.exp((25 - v) / 10) - 1)
    an = 0.01 * (10 - v) / (ca.exp((10 - v) / 10) - 1)
    bm, bn, ah = 4 * ca.exp(-v / 18), 0.125 * ca.exp(-v / 80), 0.07 * ca.exp(-v / 20)
    bh = 1 / (ca.exp((30 - v) / 10) + 1)
    ionic = 120 * m**3 * h * (v - 115) + 36 * n**4 * (v + 12) + 0.3 * (v - 10.6)
    system = system_of(
        "nerve",
        [v, m, h, n],
        [current],
        [current - ionic, am * (1 - m) - bm * m, ah * (1 - h) - bh * h, an * (1 - n) - bn * n],
    )
    return system.steady("I", guess={"V": 0.01, "m": 0.05, "h": 0.6, "n": 0.32, "I": 0.0})


def growth(v: Any) -> tuple[Any, Any]:
    """Current and largest real part at the steady motion with a given V, by mpmath."""
    am = lambda v: mp.mpf(0.1) * (25 - v) / (mp.exp((25 - v) / 10) - 1)  # noqa: E731
    an = lambda v: mp.mpf(0.01) * (10 - v) / (mp.exp((10 - v) / 10) - 1)  # noqa: E731
    bm = lambda v: 4 * mp.exp(-v / 18)  # noqa: E731
    bn = lambda v: mp.exp(-v / 80) / 8  # noqa: E731
    ah = lambda v: mp.mpf(0.07) * mp.exp(-v / 20)  # noqa: E731
    bh = lambda v: 1 / (mp.exp((30 - v) / 10) + 1)  # noqa: E731
    m, h, n = (a(v) / (a(v) + b(v)) for a, b in ((am, bm), (ah, bh), (an, bn)))
    leak, rest = mp.mpf(0.3), mp.mpf(10.6)
    current = 120 * m**3 * h * (v - 115) + 36 * n**4 * (v + 12) + leak * (v - rest)
    rows = [
        [
            -120 * m**3 * h - 36 * n**4 - leak,
            -360 * m**2 * h * (v - 115),
            -120 * m**3 * (v - 115),
            -144 * n**3 * (v + 12),
        ]
    ]
    for i, (a, b, y) in enumerate(((am, bm, m), (ah, bh, h), (an, bn, n))):
        row = [mp.diff(a, v) * (1 - y) - mp.diff(b, v) * y, 0, 0, 0]
        row[i + 1] = -a(v) - b(v)
        rows.append(row)
    return current, max(mp.re(e) for e in mp.eig(mp.matrix(rows), left=False, right=False))


@pytest.mark.long
def test_the_onset_of_firing_of_a_nerve_is_found_and_no_other() -> None:
    with mp.workdps(40):
        at = mp.findroot(lambda v: growth(v)[1], (5.2, 5.5), solver="anderson", tol=1e-30)
        wanted = float(growth(at)[0])
    found = st.boundaries(nerve(), axis=("I", 5, 15, 9))
    assert found.complete
    assert [b.value for b in found] == pytest.approx([wanted], rel=1e-13)


@pytest.mark.long
def test_members_along_an_axis_are_followed_many_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each search from the anchor costs the same for one member as for a hundred."""
    counts: list[int] = []
    search = st.Family.search

    def counted(self: st.Family, a: Any, *rest: Any) -> Any:
        counts.append(len(a))
        return search(self, a, *rest)

    monkeypatch.setattr(st.Family, "search", counted)
    st.boundaries(reactor(), axis=("D", 0.02, 1.0, 9), B=14.0, beta=3.0)
    assert sum(counts) > 5 * len(counts)


@pytest.mark.long
@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_conditions_of_a_reactor_warn_of_no_arithmetic() -> None:
    assert st.conditions(reactor()).rule
