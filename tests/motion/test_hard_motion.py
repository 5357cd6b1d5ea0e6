"""Where methods fail: each case here once went wrong, or would without its remedy."""

import math
import subprocess
import sys
import warnings
from typing import Any

import numpy as np
import pytest

import stability as st
from stability.bodies.newton_euler import STATES
from stability.integrators import taylor
from stability.integrators.selection import METHODS
from stability.motion.result import BY_CODE

HERE = [m for m in METHODS if m != "heyoka" or taylor.available()]
DISK = st.Disk()


def word(run: Any) -> str:
    return BY_CODE[int(run.outcome)].word


def states(run: Any) -> Any:
    return np.stack([run[name].values for name in STATES], axis=-1)


@pytest.mark.parametrize("counts", [(11,), pytest.param((1001, 20001), marks=pytest.mark.long)])
def test_dry_motions_do_not_depend_on_how_many_samples_are_asked(counts: tuple[int, ...]) -> None:
    start = [2.0093469918125275, 0.11927949030651858, -0.5571632300902981, 0.7718031625756856, 0, 0]
    runs = [
        st.simulate(DISK, st.Coulomb(0.8828571814570496), start, times, check=counts != (11,))
        for times in ([5.0], *(np.linspace(0, 5, n) for n in counts))
    ]
    assert runs[0].sizes["event"] == 6
    for run in runs[1:]:
        assert np.array_equal(run.event_time, runs[0].event_time)
        assert np.allclose(states(run)[-1], states(runs[0])[-1], rtol=0, atol=1e-13)
        assert float(run.energy_error) < 1e-8


def test_onsets_build_nothing_anew() -> None:
    # each onset once made a flow of its own, compiled it, and kept it for ever
    from stability.integrators.flow import _THREAD

    start = [1.12, -0.31, 1.18, -1.45, -0.49, 0.46]
    st.simulate(st.Disk(k=0.3), st.Coulomb(0.15), start, [10.0], check=False)
    held = len(_THREAD.held)
    run = st.simulate(st.Disk(k=0.3), st.Coulomb(0.15), start, [10.0], check=False)
    assert run.event_kind.values.tolist().count("slip") == 3
    assert len(_THREAD.held) == held


def test_samples_within_an_onset_slip_and_lie_on_the_cone() -> None:
    mu = 1.0795174012565514
    start = [
        0.7414505072044283,
        -0.006918804467769243,
        3.552821799036498,
        0.19502827019144214,
        0,
        0,
    ]
    coarse = st.simulate(st.Disk(k=0.5), st.Coulomb(mu), start, [5.0], check=False)
    onset = float(coarse.event_time[coarse.event_kind == "slip"][0])
    times = onset + np.linspace(-1e-4, 3e-4, 9)
    run = st.simulate(st.Disk(k=0.5), st.Coulomb(mu), start, times, tolerance=1e-12, check=False)
    force = np.hypot(run.force_x, run.force_y).values
    assert (force <= mu * run.normal_force.values * (1 + 1e-9)).all()
    slipping = run["mode"].values == 0
    assert np.array_equal(slipping, times > onset)
    slip = np.hypot(run.slip_x, run.slip_y).values[slipping]
    # |vA| = c t²/2
    since = times[slipping] - onset
    assert np.allclose(slip / since**2, slip[-1] / since[-1] ** 2, rtol=2e-2)
    assert float(run.energy_error) < 1e-10


@pytest.mark.few(1)
@pytest.mark.parametrize(
    "method", [pytest.param(m, marks=[pytest.mark.long] * (m == "idas")) for m in HERE]
)
def test_a_run_into_d_zero_ends_without_contact_by_every_method(method: str) -> None:
    # gn grows without bound and changes sign beyond D = 0: that is no lift-off
    start = [
        1.194342144719987,
        0.05028019174563288,
        1.3684831699890794,
        -0.8596387383846306,
        -1.7912308228410456,
        -0.531255658935443,
    ]
    with warnings.catch_warnings():  # its neighbours may part just before the end
        warnings.simplefilter("ignore", st.StabilityWarning)
        run = st.simulate(
            st.Disk(k=0.11943337346011837),
            st.Coulomb(0.9491648016576573),
            start,
            30.0,
            method=method,
        )
    assert word(run) == "no-contact"
    assert float(run.end_time) == pytest.approx(0.6442598376, abs=1e-7)
    assert "D" in str(run.evidence.values)


@pytest.mark.long
@pytest.mark.parametrize("quick", [True, pytest.param(False, marks=pytest.mark.long)])
def test_near_d_zero_a_batch_is_its_launches(quick: bool) -> None:
    start = [1.037367615109367, -0.2099645361027279, 0.47017042240614987, 2.406940800413374, 0, 0]
    law = st.RegularisedCoulomb(2.084348406755412, 0.002197486180596758)
    one = st.simulate(DISK, law, start, [5.0])
    many = st.simulate(DISK, law, [start, start], [5.0])
    assert word(one) == "no-contact"
    for method in ("dop853", "cvodes") if quick else HERE:  # gn D and D are zero together there
        other = st.simulate(DISK, law, start, [5.0], method=method)
        assert word(other) == "no-contact"
        assert other.event_kind.values[-1] == "no-contact"
        assert float(other.end_time) == pytest.approx(1.438305765, abs=2e-6)
    assert (many.outcome == int(one.outcome)).all()
    assert np.allclose(many.end_time, float(one.end_time), atol=1e-7)


def test_a_start_within_rounding_of_flat_is_refused_and_beyond_it_falls() -> None:
    for theta in (np.nextafter(1e-6, 1), 1e-6 * (1 + 1e-13), math.pi - 1e-6 * (1 - 1e-14)):
        with pytest.raises(st.StabilityError, match="flat within flat"):
            st.simulate(DISK, st.Rough(), [theta, 0, 0, 0, 0, 0], 10.0)
    for law in (st.Rough(), st.Smooth(), st.Viscous(0.3)):
        run = st.simulate(DISK, law, [1.00001e-6, 0, 0, 0, 0, 0], 10.0)
        assert word(run) == "flat"
        assert float(run.theta.min()) > 0.99e-6


def test_dry_contact_that_is_barely_pressed_lifts_off_without_a_negative_force() -> None:
    start = [1.2, 1.035816768405444 - 1e-9, 0, 1.0, 0, 0]
    run = st.simulate(DISK, st.Coulomb(0.3), start, 2.0)
    assert word(run) == "lift-off"
    assert float(run.normal_force.min()) > -1e-12
    assert float(run.end_time) < 1e-8


@pytest.mark.parametrize("method", [*HERE, "auto"])
def test_steps_are_bounded_by_every_method(method: str) -> None:
    run = st.simulate(
        DISK,
        st.Viscous(0.3),
        [1.4, 0, 0, 1.2, 0, 0],
        np.linspace(0, 50, 500),
        max_steps=3,
        method=method,
    )
    assert word(run) == "unresolved"
    method = run.attrs["method"]
    # CasADi bounds the steps of an interval, of which up to nine are taken at once
    assert int(run.steps) <= (3 if method not in ("cvodes", "idas") else 30)
    assert np.isfinite(states(run)).all()


@pytest.mark.long
def test_an_interrupt_reaches_the_user_while_cvodes_runs() -> None:
    code = """
import os, signal, threading, time
import stability as st
signal.signal(signal.SIGINT, signal.default_int_handler)
st.simulate(st.Disk(), st.Viscous(0.3), [1.5, 0, 0, 1.0, 0, 0], 1.0, method='cvodes')
threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
try:
    for _ in range(100):
        st.simulate(st.Disk(), st.Viscous(0.3), [1.5, 0, 0, 3e4, 0, 0], 1.0, method='cvodes')
except KeyboardInterrupt:
    print('interrupted')
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert done.stdout == "interrupted\n"


def test_numbers_beyond_double_precision_are_refused_not_returned_as_nan() -> None:
    for contact, start in (
        (st.Viscous(0.3), [1.4, 0, 0, 1e150, 0, 0]),
        (st.Viscous(0.3), [1.4, 1e200, 0, 0, 0, 0]),
        (st.Viscous(1e12), [1.4, 0, 0, 1.2, 0, 0]),
        (st.Coulomb(1e300), [1.4, 0, 0, 1.2, 0, 0]),
    ):
        with pytest.raises(st.StabilityError, match="double"):
            st.simulate(DISK, contact, start, 1.0)
    for times in (5e-324, 1e308):
        with pytest.raises(st.StabilityError, match="times end at"):
            st.simulate(DISK, st.Viscous(0.3), [1.4, 0, 0, 1.2, 0, 0], times)
    run = st.simulate(DISK, st.Coulomb(0.05), [1.3, 0.1, 0.5, 1.0, 1e-300, 0], [0.0, 1.0])
    assert all(np.isfinite(run[n].values).all() for n in ("normal_force", "force_x", "power"))


@pytest.mark.parametrize("method", ["cvodes", "auto"])
@pytest.mark.parametrize(
    ("last", "count"), [(1e-4, 11), pytest.param(1e-3, 101, marks=pytest.mark.long)]
)
def test_a_fast_spin_keeps_its_normal_force(method: str, last: float, count: int) -> None:
    # forces hold products of rates: their error is that of a rate times the other, 1e6 here
    run = st.simulate(
        DISK, st.Smooth(), [1.5, 0, 0, 1e6, 0, 0], np.linspace(0, last, count), method=method
    )
    assert word(run) == "moving"
    assert np.abs(run.normal_force.values - 1).max() < 0.05


def test_a_run_whose_account_fails_has_no_outcome(monkeypatch: pytest.MonkeyPatch) -> None:
    from stability.motion import dataset as trajectory

    monkeypatch.setattr(trajectory, "ACCOUNT", 1e-30)
    run = st.simulate(DISK, st.Viscous(0.3), [1.4, 0, 0, 1.2, 0, 0], 20.0)
    assert word(run) == "unresolved"
    assert "energy account fails" in str(run.evidence.values)


@pytest.mark.parametrize(
    "methods",
    [
        [m for m in HERE if m in ("heyoka", "dop853", "lsoda")],
        pytest.param(HERE, marks=pytest.mark.long),
    ],
    ids=["quick", "all"],
)
def test_nothing_but_the_answer_is_printed(
    methods: list[str], capfd: pytest.CaptureFixture[str]
) -> None:
    for method in methods:
        st.simulate(DISK, st.Viscous(3.0), [1.0, 0, 5.0, -5.0, 0, 0], 3.0, method=method)
    st.simulate(DISK, st.Rough(), [1.00001e-6, 0, 0, 0, 0, 0], 10.0)
    seen = capfd.readouterr()
    assert seen.out == ""
    assert seen.err == ""


def test_settings_of_the_wrong_kind_get_a_sentence() -> None:
    start = [1.4, 0, 0, 1.2, 0, 0]
    for options in ({"pose": 2}, {"pose": "no"}, {"progress": 3}, {"method": ["lsoda"]}):
        with pytest.raises(st.StabilityError) as caught:
            st.simulate(DISK, st.Smooth(), start, 1.0, **options)  # type: ignore[arg-type]
        assert str(caught.value).endswith(".")
    for call in (
        lambda: st.launch("rolling", at=[1, 2], tilt=[1, 2, 3]),
        lambda: st.launch("rolling", at=1.0, disk=3),  # type: ignore[arg-type]
        lambda: st.launch("tumbling", at=1.0, tilt=2.0, disk=st.Disk()),
    ):
        with pytest.raises(st.StabilityError):
            call()


@pytest.mark.long
def test_calls_from_several_threads_take_turns() -> None:
    # CasADi's objects are not for several threads at once: this once ended the process
    code = """
from concurrent.futures import ThreadPoolExecutor
import stability as st
def ask(job):
    method, omega = job
    start = st.launch('rolling', at=omega)
    run = st.simulate(st.Disk(), st.Viscous(30.0), start, [1.0, 4.0], method=method)
    dry = [1.12, -0.31, 1.18, -1.45, -0.49, 0.4 + omega / 100]
    slid = st.simulate(st.Disk(k=0.3), st.Coulomb(0.15), dry, [3.0])
    return float(run.theta[-1]), float(slid.theta[-1])
jobs = [(m, w) for m in ('cvodes', 'idas', 'lsoda', 'auto') for w in (1.0, 1.1, 1.2, 1.3)]
with ThreadPoolExecutor(4) as pool:
    many = list(pool.map(ask, jobs))
print(many == [ask(job) for job in jobs])
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=300)
    assert done.stdout == "True\n", done.stderr[-300:]


@pytest.mark.few(1)
@pytest.mark.parametrize("last", [5.0, 50.0, pytest.param(400.0, marks=pytest.mark.long)])
def test_an_early_lift_off_does_not_depend_on_how_long_a_run_is_asked(last: float) -> None:
    # CVODES once looked at its guards 200 times a run of any length, and saw the next one
    k, mu = 0.36516325782292336, 2327.347048953263
    start = [0.17455928494788384, 0.088886895424144, -1.1466736692731412, -1.662955988936166, 0, 0]
    for method in ("auto", "cvodes", "idas"):
        run = st.simulate(
            st.Disk(k=k), st.LinearViscous(mu), start, last, method=method, check=last > 50
        )
        assert word(run) == "lift-off"
        assert float(run.end_time) == pytest.approx(5.080957e-4, abs=1e-8)


@pytest.mark.long
def test_a_launch_whose_neighbours_cannot_be_run_is_not_said_to_last() -> None:
    law = st.RegularisedCoulomb(5.753758471817282, 0.00028800461614589425)
    start = [1.0525640005202301, 0.6767085152932947, 0, 0, 0, -0.3436609788816844]
    disk = st.Disk(k=0.2556196142891559)
    assert word(st.simulate(disk, law, start, 5.0, tolerance=1e-6)) in (
        "undetermined",
        "no-contact",
        "unresolved",
    )
    assert word(st.simulate(disk, law, start, 5.0)) == "no-contact"
