"""Starts near steady motions: the forces there, and what is refused."""

import math

import numpy as np
import pytest

import stability as st


def test_the_normal_force_at_the_start_is_that_of_a_closed_form() -> None:
    """Positive for every angular velocity, so that each launch begins in contact."""
    rng = np.random.default_rng(1)
    for _ in range(20):
        k, tilt, w = rng.uniform(0.05, 0.5), rng.uniform(0.01, 0.5), rng.uniform(0, 9)
        s, c = math.cos(tilt), math.sin(tilt)
        for name, expected in (
            ("rolling", k / (k + c * c)),
            ("spinning", k * (1 + w * w * s * c * c) / (k + c * c)),
        ):
            six = st.launch(name, at=w, tilt=tilt)
            seen = st.disk_system("viscous").observe(six, [k, 0.7])["normal_force"]
            assert float(seen) == pytest.approx(expected, rel=1e-12)


def test_tumbling_is_launched_at_its_own_disks_rate_or_not_at_all() -> None:
    # without a disk it once took k = 1/4: 2.888 for a hoop's 2.042
    with pytest.raises(st.StabilityError, match="disk is missing"):
        st.launch("tumbling", at=0.5)
    hoop = st.launch("tumbling", at=0.5, disk=st.Disk.hoop(), tilt=0.0)
    assert hoop[2] == pytest.approx((0.5 * math.sin(0.5)) ** -0.5, rel=1e-15)
    run = st.simulate(st.Disk.hoop(), st.Viscous(0.3), hoop, 5.0)
    assert float(run.theta[-1]) == pytest.approx(0.5, abs=1e-9)


def test_launches_refuse_what_they_do_not_know() -> None:
    for call in (
        lambda: st.launch("circling", at=1.0),
        lambda: st.launch("tumbling", at=4.0, disk=st.Disk()),
        lambda: st.launch("rolling", at=math.nan),
    ):
        with pytest.raises(st.StabilityError) as caught:
            call()
        assert str(caught.value).endswith(".")
