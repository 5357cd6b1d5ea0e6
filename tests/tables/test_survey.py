"""The table of launches: its numbers are those of single runs, its words those of linear theory."""

import math

import numpy as np
import pytest

import stability as st
from stability.bodies.families import FAMILIES
from stability.bodies.launch import launch
from stability.motion.result import BY_CODE
from stability.tables.families import condition
from stability.tables.launches import contact_lines, launch_rows


def test_rows_are_single_runs_beside_linear_theory() -> None:
    rows = launch_rows(k=(0.5,), mu=(0.3,), at=(0.6, 1.6), time=200.0)
    names = [name for name, family in FAMILIES.items() if family.launch]
    assert [(r.launch, r.at) for r in rows] == [(n, a) for n in names for a in (0.6, 1.6)]
    disk = st.Disk(k=0.5)
    for row in rows:
        start = launch(row.launch, at=row.at, tilt=0.1, disk=disk)
        run = st.simulate(disk, st.Viscous(0.3), start, np.linspace(0, 200, 501))
        assert row.outcome == BY_CODE[int(run.outcome)].word
        assert row.energy == pytest.approx(float(run.energy[-1] / run.energy[0]), rel=1e-5)
        assert row.normal_force == pytest.approx(float(run.normal_force.min()), rel=1e-4)
        linear = st.spectrum(row.launch, at=row.at, disk=disk, contact=st.Viscous(0.3))
        assert row.linear == linear.verdict.word
        assert row.rate == pytest.approx(linear.abscissa, abs=1e-12)


def test_spinning_settles_where_linear_theory_says_it_is_stable() -> None:
    rows = launch_rows(launches=("spinning",), k=(0.25,), mu=(0.3,), at=(1.0, 1.9, 2.1, 3.0))
    assert [(r.linear, r.final) for r in rows] == [
        ("unstable", "tumbling"),
        ("unstable", "tumbling"),
        ("stable", "spinning"),
        ("stable", "spinning"),
    ]
    assert all(r.why.startswith("agrees") for r in rows)


def test_stable_rolling_is_lost_by_its_drift_and_the_table_says_so() -> None:
    rows = launch_rows(launches=("rolling",), k=(0.25,), mu=(0.3,), at=(2.4, 4.8))
    assert rows[0].linear == rows[1].linear == "stable"
    assert rows[0].final == "tumbling"
    assert "drifts through its threshold" in rows[0].why
    assert rows[1].final == "~rolling"
    assert rows[1].why.startswith("agrees")


def test_the_normal_force_at_the_start_is_the_formula_under_the_table() -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        k, tilt, w = rng.uniform(0.05, 0.5), rng.uniform(0.01, 0.5), rng.uniform(0, 9)
        s, c = math.cos(tilt), math.sin(tilt)
        for name, expected in (
            ("rolling", k / (k + c * c)),
            ("spinning", k * (1 + w * w * s * c * c) / (k + c * c)),
        ):
            six = launch(name, at=w, tilt=tilt)
            seen = st.disk_system("viscous").observe(six, [k, 0.7])["normal_force"]
            assert float(seen) == pytest.approx(expected, rel=1e-12)


def test_si_bodies_give_the_same_table_in_their_units() -> None:
    disk = st.Disk(mass=0.3, radius=0.2, gravity=9.81)
    rate, speed, clock = float(disk.rate), float(disk.speed), float(disk.time)
    plain = launch_rows(launches=("spinning",), k=(0.25,), mu=(0.3,), at=(1.0, 2.5), time=300.0)
    si = launch_rows(
        launches=("spinning",),
        k=(0.25,),
        mu=(0.3 / speed,),
        at=(rate, 2.5 * rate),
        time=300.0 * clock,
        disk=disk,
    )
    for a, b in zip(plain, si, strict=True):
        assert (a.outcome, a.final, a.linear) == (b.outcome, b.final, b.linear)
        assert b.time == pytest.approx(a.time * clock, rel=1e-6)
        assert b.energy == pytest.approx(a.energy, rel=1e-4)


def test_the_text_is_headed_recomputed_and_says_where_contact_is_lost() -> None:
    table = st.table("launches", k=0.25, mu=0.3, at=(1.2, 1.4))
    rows, printed = table.rows, table.to_text()
    assert "(recomputed)" in printed.splitlines()[0]
    assert "rolling, k = 0.25, mu = 0.3: gn reaches zero from at = 1.4" in printed
    assert contact_lines(rows[:1]) == [
        "rolling, k = 0.25, mu = 0.3: gn > 0 throughout from every at, 1.2 to 1.2"
    ]


def test_tumbling_is_launched_at_its_own_disks_rate_or_not_at_all() -> None:
    # without a disk it once took k = 1/4: 2.888 for a hoop's 2.042
    with pytest.raises(st.StabilityError, match="disk is missing"):
        launch("tumbling", at=0.5)
    hoop = launch("tumbling", at=0.5, disk=st.Disk.hoop(), tilt=0.0)
    assert hoop[2] == pytest.approx((0.5 * math.sin(0.5)) ** -0.5, rel=1e-15)
    run = st.simulate(st.Disk.hoop(), st.Viscous(0.3), hoop, 5.0)
    assert float(run.theta[-1]) == pytest.approx(0.5, abs=1e-9)


def test_a_table_with_a_tilt_too_large_for_the_drift_says_so() -> None:
    rows = launch_rows(launches=("rolling",), k=(0.25,), mu=(0.3,), at=(1.8,), tilt=1.5, time=20.0)
    assert "too large for the slow drift" in rows[0].why


def test_launches_refuse_what_they_do_not_know() -> None:
    for call in (
        lambda: launch("circling", at=1.0),
        lambda: launch("tumbling", at=4.0, disk=st.Disk()),
        lambda: launch("rolling", at=math.nan),
        lambda: launch_rows(law="rough", k=(0.25,), mu=(0.3,), at=(1.0,)),
    ):
        with pytest.raises(st.StabilityError) as caught:
            call()
        assert str(caught.value).endswith(".")


@pytest.mark.parametrize("name", ["rolling", "spinning"])
def test_a_family_that_exists_everywhere_has_no_condition(name: str) -> None:
    assert condition(name) == f"none: every {FAMILIES[name].at[0]}"
