"""The error that `simulate` states, and launches whose neighbours end otherwise."""

import math
import warnings
from typing import Any

import numpy as np
import pytest

import stability as st
from stability.base.errors import StabilityWarning
from stability.bodies.newton_euler import STATES
from stability.compare.motion.chart import distance
from stability.compare.motion.reference_motions import ReferenceMotion, scene, scenes
from stability.motion.result import BY_CODE
from stability.motion.simulate import simulate

SMOOTH = [n for n, s in scenes().items() if s.law != "coulomb"]


def launched(it: ReferenceMotion, **options: Any) -> Any:
    with warnings.catch_warnings():  # an error without a bound is part of what is tested here
        warnings.simplefilter("ignore", StabilityWarning)
        return simulate(it.disk(), it.contact(), list(it.start), it.asked, **options)


def word(run: Any) -> str:
    return BY_CODE[int(run.outcome)].word


def last(run: Any) -> Any:
    return np.stack([run[name].values for name in STATES], axis=-1)[-1]


@pytest.mark.few(8)
@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-12])
@pytest.mark.parametrize("name", SMOOTH)
def test_no_error_is_larger_than_is_stated(name: str, tolerance: float) -> None:
    it = scene(name)
    run = launched(it, tolerance=tolerance)
    if word(run) == "undetermined":
        assert name.startswith("graze")
        assert "end differently" in str(run.evidence.values)
        return
    truly = "moving" if word(run) == "settled" else word(run)
    assert truly == it.outcome
    if it.ends:
        assert abs(float(run.end_time) - it.end_time) <= float(run.end_time_error)
    else:
        assert distance(last(run), it.states[-1]) <= float(run.final_error)


def test_the_stated_error_falls_with_the_tolerance() -> None:
    stated = [float(launched(scene("gentle"), tolerance=10.0**-d).final_error) for d in (8, 10, 12)]
    assert stated[0] / stated[1] == pytest.approx(100, rel=0.9)
    assert stated[1] / stated[2] == pytest.approx(100, rel=0.9)


@pytest.mark.few(1)
@pytest.mark.parametrize("sign", ["plus", "minus"])
def test_a_launch_beside_the_border_of_outcomes_is_undetermined_until_asked_finely(
    sign: str,
) -> None:
    it = scene(f"graze-{sign}-1e-9")
    assert word(launched(it, tolerance=1e-9)) == "undetermined"
    assert word(launched(it, tolerance=1e-13)) == it.outcome
    assert word(launched(scene(f"graze-{sign}-ulp"), tolerance=1e-16)) == "undetermined"


def test_recurrence_is_no_agreement() -> None:
    # the shadows part on the way and meet again at the end
    run = launched(scene("double-upright-rough"))
    assert float(run.final_error) > 0.1


def test_the_check_changes_no_number_and_can_be_left_out() -> None:
    it = scene("lift-off")
    with_, without = launched(it), launched(it, check=False)
    assert np.array_equal(last(with_), last(without))
    assert "final_error" in with_ and "final_error" not in without
    assert float(with_.end_time) == float(without.end_time)


def test_launches_of_a_batch_are_judged_one_by_one() -> None:
    omega = np.array([scene(n).start[3] for n in ("lift-off", "graze-minus-1e-12", "gentle")])
    start = np.zeros((3, 6))
    start[:, 0], start[:, 3] = math.pi / 2 - 0.1, omega
    run = simulate(st.Disk(), st.Viscous(0.3), start, [40.0])
    assert [BY_CODE[c].word for c in run.outcome.values] == ["lift-off", "undetermined", "moving"]
    assert run.final_error.shape == (3,)
    alone = [simulate(st.Disk(), st.Viscous(0.3), s, [40.0]) for s in start]
    for one, error, code in zip(alone, run.final_error.values, run.outcome.values, strict=True):
        assert int(one.outcome) == code
        if word(one) == "moving":
            assert 0.2 < float(one.final_error) / error < 5


def test_a_plane_of_symmetry_is_kept() -> None:
    # the exact start stays in its plane, and so do its shadows
    run = launched(scene("falls-flat"))
    assert word(run) == "flat"
    assert float(run.end_time_error) < 1e-6


@pytest.mark.few(3)
@pytest.mark.parametrize("name", [n for n, s in scenes().items() if s.law == "coulomb"])
def test_dry_friction_is_checked_too(name: str) -> None:
    it = scene(name)
    run = launched(it)
    assert word(run) in ("moving", "settled", "lift-off", "undetermined")
    if word(run) == "moving":
        assert distance(last(run), it.states[-1]) <= float(run.final_error) + it.error


def test_si_units_scale_the_time_and_not_the_relative_error() -> None:
    disk = st.Disk(mass=1.0, radius=0.05, gravity=9.81)
    it = scene("lift-off")
    rate, speed = float(disk.rate), float(disk.speed)
    start = np.array(it.start)
    start[1:4] *= rate
    run = simulate(disk, st.Viscous(0.3 / speed), start, [40.0 / rate])
    plain = launched(it)
    assert float(run.end_time_error) == pytest.approx(float(plain.end_time_error) / rate, rel=0.2)
    assert float(run.final_error) == pytest.approx(float(plain.final_error), rel=0.2)


def test_check_is_true_or_false() -> None:
    with pytest.raises(st.StabilityError, match="check is 1; give True or False"):
        simulate(st.Disk(), st.Rough(), {"theta": 1.2}, 1.0, check=1)  # type: ignore[arg-type]


def test_a_looser_launch_has_a_finer_shadow() -> None:
    it = scene("stiff-300")
    for tolerance, most in ((1e-3, math.inf), (1e-5, 0.3), (1e-7, 0.01)):
        run = launched(it, tolerance=tolerance)
        assert distance(last(run), it.states[-1]) <= float(run.final_error) <= most
