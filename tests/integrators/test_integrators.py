"""Each route integrates and stops at guards alike, and `auto` takes the cheaper one."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from simulation import simulate

import stability as st
from stability.cli.commands import main
from stability.compare.figures import _driver_handles
from stability.compare.motion.drivers import _single
from stability.integrators import lanes, taylor
from stability.integrators import selection as integrators
from stability.integrators.flow import flow
from stability.integrators.leg import UNRESOLVED, Leg, Path
from stability.integrators.registry import PLACES
from stability.integrators.scipy_methods import of_scipy
from stability.integrators.selection import METHODS, choose, stiffness

LAUNCH = np.array([math.pi / 2 - 0.1, 0, 0, 1.2, 0, 0])


def leg(mu: float, start: Any = LAUNCH, last: float = 20.0, tolerance: float = 1e-9) -> Leg:
    which = flow("viscous")
    return Leg(
        which,
        np.array([0.25, mu, 1e-6]),
        which.pack(np.asarray(start, dtype=float)),
        np.linspace(0, last, 9),
        tolerance,
        10**6,
    )


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


@pytest.mark.parametrize("sought", [False, pytest.param(True, marks=pytest.mark.long)])
def test_a_shallow_dip_of_the_normal_force_is_not_stepped_over(sought: bool) -> None:
    # a launch whose gn touches zero and comes back, found without any event detection: CVODES on
    # the bare equations, gn at 4001 samples, its lowest point by a parabola
    times = np.linspace(0, 24, 4801)

    def lowest(omega: float) -> float:
        six = simulate(0.25, 0.3, [math.pi / 2 - 0.1, 0, 0, omega, 0, 0], times[1:], 1e-12)
        gn = st.disk_system("viscous").observe(six, [0.25, 0.3])["normal_force"]
        i = int(np.clip(np.argmin(gn), 1, len(gn) - 2))
        left, middle, right = gn[i - 1 : i + 2]
        return float(middle - (right - left) ** 2 / (8 * (left - 2 * middle + right)))

    low, high = (1.2, 1.35) if sought else (1.2749966751784083, 1.2749966762959954)
    assert not sought or lowest(low) > 0 > lowest(high)
    for _ in range(27 * sought):
        middle = (low + high) / 2
        low, high = (middle, high) if lowest(middle) > 0 else (low, middle)
    step = 2e-7
    assert -2e-5 < lowest(high + step) < 0  # it dips by very little
    assert lowest(low - step) > 0
    methods = ["lsoda", "cvodes", *(["heyoka"] if taylor.available() else [])]
    last = 25.0 if sought else 17.0  # the dip is at 16.56
    for method in ["dop853"] * sought + methods:
        over, under = (
            st.simulate(
                st.Disk(),
                st.Viscous(0.3),
                [math.pi / 2 - 0.1, 0, 0, w, 0, 0],
                [last],
                tolerance=1e-11,
                method=method,
                check=sought,
            )
            for w in (high + step, low - step)
        )
        assert over.attrs["outcome"] == "lift-off", method
        assert under.attrs["outcome"] == "moving", method


def test_stiffness_grows_with_friction_and_auto_turns_with_it() -> None:
    stiff = stiffness([leg(mu) for mu in (1.0, 10.0, 100.0, 1000.0)])
    assert np.allclose(np.diff(np.log10(stiff)), 1.0, atol=0.05)
    assert choose([leg(0.3)])[0].method == ("heyoka" if taylor.available() else "cvodes")
    assert choose([leg(3000.0)])[0].method == "cvodes"
    assert "implicit is cheaper" in choose([leg(3000.0)])[0].reason


def test_a_tighter_tolerance_puts_off_the_implicit_route() -> None:
    turn = [
        min(
            mu
            for mu in np.geomspace(1, 1e4, 81)
            if "implicit is cheaper" in choose([leg(mu, tolerance=t)])[0].reason
        )
        for t in (1e-6, 1e-9, 1e-12)
    ]
    assert turn[0] < turn[1] < turn[2]


def test_one_record_is_an_integrator_for_all_who_read_one(monkeypatch: pytest.MonkeyPatch) -> None:
    record = of_scipy("rk23", "RK23", "explicit Runge-Kutta, order 3", "hairer1993")
    monkeypatch.setitem(METHODS, "rk23", record)
    asked: Any = {"method": "rk23", "tolerance": 1e-8}
    run = st.simulate(st.Disk(), st.Viscous(0.3), LAUNCH, 2.0, **asked)
    fine = st.simulate(st.Disk(), st.Viscous(0.3), LAUNCH, 2.0, tolerance=1e-12)
    off = max(abs(float((run[n] - fine[n])[-1])) for n in ("theta", "phi_dot", "omega3"))
    assert off <= float(run.final_error) < 1e-4
    assert [work.key for work in st.citation(run).works][-2:] == ["scipy", "hairer1993"]
    assert "explicit Runge-Kutta, order 3" in _single("rk23").title
    assert "rk23" in [handle.get_label() for handle in _driver_handles(["simulate", "rk23"])]
    with pytest.raises(st.StabilityError, match="rk23"):
        st.simulate(st.Disk(), st.Viscous(0.3), LAUNCH, 2.0, method="rk24")
    monkeypatch.setitem(METHODS, "rk23", replace(record, refuses=lambda _: "which is tired"))
    with pytest.raises(st.StabilityError, match="method is 'rk23', which is tired"):
        st.simulate(st.Disk(), st.Viscous(0.3), LAUNCH, 2.0, **asked)


def test_the_list_for_commands_is_that_of_the_records(capsys: pytest.CaptureFixture[str]) -> None:
    assert list(PLACES) == list(METHODS) == [method.name for method in METHODS.values()]
    with pytest.raises(SystemExit):
        main(["simulate", "--help"])
    assert f"auto, {', '.join(PLACES)}" in " ".join(capsys.readouterr().out.split())


def test_stiffness_is_seen_behind_a_fast_slide() -> None:
    # while it slides fast with D large, gn is small and so is the Jacobian at the start
    start = [math.pi / 2 - 0.1, 0, 0.1, 1.2, -0.3, 0.3]
    assert choose([leg(1e4, start=start)])[0].method == "cvodes"


def test_auto_tries_another_route_where_one_gives_up(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = []

    def gives_up(question: Leg) -> Path:
        calls.append(question)
        from stability.integrators.leg import End

        return Path(question.start[None], End(UNRESOLVED, 0.0, question.start, "no"), 1)

    first = choose([leg(0.3)])[0].method
    useless = replace(integrators.METHODS[first], run=gives_up)
    monkeypatch.setitem(integrators.METHODS, first, useless)
    run = st.simulate(st.Disk(), st.Viscous(0.3), LAUNCH, [1.0, 2.0])
    assert len(calls) == 1
    assert run.attrs["outcome"] == "moving"
    assert f"{first} gave up" in run.attrs["method_reason"]
    for name, method in integrators.METHODS.items():
        monkeypatch.setitem(integrators.METHODS, name, replace(method, run=gives_up))
    lost = st.simulate(st.Disk(), st.Viscous(0.3), LAUNCH, [1.0, 2.0])
    assert lost.attrs["outcome"] == "unresolved"
    assert lost.time.values.tolist() == [0.0]


def test_heyoka_is_refused_in_a_sentence_where_it_is_not_installed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(taylor, "available", lambda: False)
    with pytest.raises(st.StabilityError, match=r"pip install '\.\[heyoka\]'"):
        st.simulate(st.Disk(), st.Viscous(0.3), LAUNCH, 1.0, method="heyoka")
    run = st.simulate(st.Disk(), st.Viscous(0.3), LAUNCH, 1.0)
    assert run.attrs["method"] == "cvodes"
    tight = st.simulate(st.Disk(), st.Viscous(0.3), LAUNCH, 1.0, tolerance=1e-12)
    assert tight.attrs["method"] == "dop853"


def test_a_failed_lane_is_run_again_by_itself() -> None:
    if not taylor.available():
        pytest.skip("heyoka is an extra")
    legs = [leg(0.3, start=LAUNCH + 0.01 * i) for i in range(5)]
    starved = [replace(one, max_steps=30) for one in legs]
    paths = lanes.integrate_many(starved, 1)
    assert all(p.end is not None and p.end.kind == UNRESOLVED for p in paths)
    whole = lanes.integrate_many(legs, 1)
    assert all(p.end is None for p in whole)
    for one, path in zip(legs, whole, strict=True):
        assert np.abs(taylor.integrate(one).states - path.states).max() < 1e-7


def test_a_launch_is_judged_by_its_own_tolerance_whatever_leads_the_batch() -> None:
    mu = 500.0 if taylor.available() else 120.0  # between the turns of the two tolerances
    fast, slow = leg(mu, tolerance=1e-12), leg(mu, tolerance=1e-6)
    alone = [choose([one])[0].method for one in (fast, slow)]
    assert alone[1] == "cvodes"
    assert alone[0] != "cvodes"
    assert [c.method for c in choose([fast, slow])] == alone
    assert [c.method for c in choose([slow, fast])] == alone[::-1]


def test_the_file_records_the_tolerance_that_a_fast_spin_was_given() -> None:
    run = st.simulate(st.Disk(), st.Smooth(), [1.5, 0, 0, 1e4, 0, 0], [1e-3], tolerance=1e-9)
    assert run.attrs["tolerance"] == 1e-9
    assert run.attrs["tolerance_used"] == pytest.approx(1e-12)


@pytest.mark.skipif(not taylor.available(), reason="heyoka is an extra")
@pytest.mark.parametrize("count", [1, lanes.ALONE + 1])
def test_optimised_code_goes_on_where_quickly_made_code_stops(
    count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A run of many steps changes its code on the way, a batch begins again; the motion is one."""
    start = np.array([1.0, 0.0, 5.0, -5.0, 0.0, 0.0])  # its contact is lost at 0.13
    starts = start + 0.01 * np.arange(count)[:, None]
    given: dict[str, Any] = {"tolerance": 1e-13, "method": "heyoka", "check": False}
    known = st.simulate(st.Disk(), st.Viscous(3.0), starts, 3.0, **given)
    made: list[int] = []
    single, batch = taylor._single, lanes._batch
    for module, name, plain in ((taylor, "_single", single), (lanes, "_batch", batch)):
        monkeypatch.setattr(module, "QUIET", 5)
        monkeypatch.setattr(module, name, lambda *a, plain=plain: made.append(a[-1]) or plain(*a))
    found = st.simulate(st.Disk(), st.Viscous(3.0), starts, 3.0, **given)
    assert made == [taylor.QUICK, taylor.OPTIMISED]
    assert (found.outcome.values == known.outcome.values).all()
    assert found.end_time.values == pytest.approx(known.end_time.values, abs=1e-11)
    for name in ("theta", "omega3", "slip_x"):
        np.testing.assert_allclose(found[name].values, known[name].values, atol=1e-11)
