"""Each route integrates and stops at guards alike, and `auto` takes the cheaper one."""

import math
from typing import Any

import numpy as np
import pytest

import stability as st
from stability import integrators, taylor
from stability.flow import flow
from stability.integrators import METHODS, choose, stiffness
from stability.route import UNRESOLVED, Leg, Path

LAUNCH = np.array([math.pi / 2 - 0.1, 0, 0, 1.2, 0, 0])


def leg(mu: float, start: Any = LAUNCH, last: float = 20.0, tolerance: float = 1e-9) -> Leg:
    which = flow("viscous")
    return Leg(
        which, np.array([0.25, mu, 1e-6]), which.pack(np.asarray(start, dtype=float)),
        np.linspace(0, last, 9), tolerance, 10**6,
    )  # fmt: skip


@pytest.mark.parametrize("method", [m for m in METHODS if m != "heyoka" or taylor.available()])
def test_every_route_gives_the_same_motion(method: str) -> None:
    tolerance = 1e-8 if method in ("radau", "bdf") else 1e-10
    question = leg(0.5, last=5.0, tolerance=tolerance)
    exact = METHODS["dop853"](leg(0.5, last=5.0, tolerance=1e-13))
    path = METHODS[method](question)
    assert path.end is None
    assert path.steps > 0
    assert np.abs(path.states - exact.states).max() < 1e-5
    assert np.abs(path.states - exact.states).max() > 0 or method == "dop853"


@pytest.mark.parametrize("method", [m for m in METHODS if m != "heyoka" or taylor.available()])
def test_every_route_stops_at_the_same_guard(method: str) -> None:
    question = leg(3.0, start=[1.0, 0, 5.0, -5.0, 0, 0], last=3.0, tolerance=1e-9)
    path = METHODS[method](question)
    assert path.end is not None
    assert path.end.kind == "lift-off"
    assert path.end.time == pytest.approx(0.1302615, abs=1e-5)
    assert len(path.states) == 1


def test_a_shallow_dip_of_the_normal_force_is_not_stepped_over() -> None:
    # where gn dips below zero between two samples and comes back, the run must end; find such a
    # dip by bisection on the launch and approach it from the side where it still stays positive
    def lowest(omega: float) -> float:
        start = np.array([math.pi / 2 - 0.1, 0, 0, omega, 0, 0])
        run = st.simulate(st.Disk(), st.Viscous(0.3), start, np.linspace(0, 40, 4001),
                          tolerance=1e-11, method="dop853")  # fmt: skip
        return -1.0 if len(run.time) < 4001 else float(run.normal_force.min())

    low, high = 1.2, 1.4
    assert lowest(low) > 0 > lowest(high)
    while high - low > 1e-6:
        middle = (low + high) / 2
        low, high = (middle, high) if lowest(middle) > 0 else (low, middle)
    for method in ("dop853", "lsoda", "cvodes", *(["heyoka"] if taylor.available() else [])):
        over, under = (
            st.simulate(st.Disk(), st.Viscous(0.3), [math.pi / 2 - 0.1, 0, 0, w, 0, 0], [40.0],
                        tolerance=1e-11, method=method)
            for w in (high + 1e-5, low - 1e-5)
        )  # fmt: skip
        assert over.attrs["outcome"] == "lift-off"
        assert under.attrs["outcome"] == "moving"


def test_stiffness_grows_with_friction_and_auto_turns_with_it() -> None:
    stiff = stiffness([leg(mu) for mu in (1.0, 10.0, 100.0, 1000.0)])
    assert np.allclose(np.diff(np.log10(stiff)), 1.0, atol=0.05)
    assert choose([leg(0.3)])[0].method == ("heyoka" if taylor.available() else "cvodes")
    assert choose([leg(300.0)])[0].method == "cvodes"
    assert "implicit is cheaper" in choose([leg(300.0)])[0].reason


def test_a_tighter_tolerance_puts_off_the_implicit_route() -> None:
    turn = [
        min(mu for mu in np.geomspace(1, 1e4, 81)
            if "implicit is cheaper" in choose([leg(mu, tolerance=t)])[0].reason)
        for t in (1e-6, 1e-9, 1e-12)
    ]  # fmt: skip
    assert turn[0] < turn[1] < turn[2]


def test_stiffness_is_seen_behind_a_fast_slide() -> None:
    # while it slides fast with D large, gn is small and so is the Jacobian at the start
    start = [math.pi / 2 - 0.1, 0, 0.1, 1.2, -0.3, 0.3]
    assert choose([leg(1e4, start=start)])[0].method == "cvodes"


def test_auto_tries_another_route_where_one_gives_up(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = []

    def gives_up(question: Leg) -> Path:
        calls.append(question)
        from stability.route import End

        return Path(question.start[None], End(UNRESOLVED, 0.0, question.start, "no"), 1)

    first = choose([leg(0.3)])[0].method
    monkeypatch.setitem(integrators.METHODS, first, gives_up)
    run = st.simulate(st.Disk(), st.Viscous(0.3), LAUNCH, [1.0, 2.0])
    assert len(calls) == 1
    assert run.attrs["outcome"] == "moving"
    assert f"{first} gave up" in run.attrs["method_reason"]
    for name in integrators.METHODS:
        monkeypatch.setitem(integrators.METHODS, name, gives_up)
    lost = st.simulate(st.Disk(), st.Viscous(0.3), LAUNCH, [1.0, 2.0])
    assert lost.attrs["outcome"] == "unresolved"
    assert lost.time.values.tolist() == [0.0]


def test_heyoka_is_refused_in_a_sentence_where_it_is_not_installed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(taylor, "available", lambda: False)
    with pytest.raises(st.StabilityError, match=r"install stability\[heyoka\]"):
        st.simulate(st.Disk(), st.Viscous(0.3), LAUNCH, 1.0, method="heyoka")
    run = st.simulate(st.Disk(), st.Viscous(0.3), LAUNCH, 1.0)
    assert run.attrs["method"] == "cvodes"
    tight = st.simulate(st.Disk(), st.Viscous(0.3), LAUNCH, 1.0, tolerance=1e-12)
    assert tight.attrs["method"] == "dop853"


def test_a_failed_lane_is_run_again_by_itself() -> None:
    if not taylor.available():
        pytest.skip("heyoka is an extra")
    legs = [leg(0.3, start=LAUNCH + 0.01 * i) for i in range(5)]
    from dataclasses import replace

    starved = [replace(one, max_steps=30) for one in legs]
    paths = taylor.integrate_many(starved, 1)
    assert all(p.end is not None and p.end.kind == UNRESOLVED for p in paths)
    whole = taylor.integrate_many(legs, 1)
    assert all(p.end is None for p in whole)
    for one, path in zip(legs, whole, strict=True):
        assert np.abs(taylor.integrate(one).states - path.states).max() < 1e-7
