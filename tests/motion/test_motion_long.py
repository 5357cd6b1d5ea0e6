"""Campaigns of minutes: thousands of launches of every law, each ends and accounts for itself."""

from collections import Counter
from typing import Any

import numpy as np
import pytest

import stability as st
from stability.bodies.newton_euler import STATES
from stability.motion.result import BY_CODE, Outcome
from stability.motion.round_starts import gather_round as gather

pytestmark = pytest.mark.long
LAUNCH = np.array([np.pi / 2 - 0.1, 0, 0, 1.2, 0, 0])


def attached(law: Any, starts: Any, k: Any) -> Any:
    """Those starts that `simulate` takes."""
    kept = []
    for start, inertia in zip(starts, k, strict=True):
        try:
            gather(st.Disk(k=inertia), law, start, 1.0)
        except st.StabilityError:
            continue
        kept.append((start, inertia))
    return [np.array(column) for column in zip(*kept, strict=True)]


def test_1024_neighbours_end_alike_by_two_methods() -> None:
    rng = np.random.default_rng(20161)
    starts = LAUNCH + rng.uniform(-0.1, 0.1, (1024, 6))
    times = np.linspace(0, 40, 41)
    one = st.simulate(st.Disk(), st.Viscous(0.3), starts, times, tolerance=1e-12)
    two = st.simulate(st.Disk(), st.Viscous(0.3), starts, times, tolerance=1e-12, method="dop853")
    same = one.outcome.values == two.outcome.values
    counts = Counter(BY_CODE[int(o)].word for o in one.outcome.values)
    print(f"1024 neighbours to T = 40: {dict(counts)}; two methods differ on {int((~same).sum())}")
    assert same.all()
    assert np.abs(one.end_time - two.end_time).max() < 1e-6
    assert counts["lift-off"] > 50


@pytest.mark.parametrize(
    "law",
    [
        st.Smooth(),
        st.Rough(),
        st.Viscous(0.3),
        st.Viscous(30.0),
        st.LinearViscous(0.5),
        st.RegularisedCoulomb(0.3, 1e-3),
    ],
    ids=lambda law: f"{law.name} {law.given}",
)
def test_thousands_of_launches_account_for_themselves(law: Any) -> None:
    rng = np.random.default_rng(7)
    starts = rng.uniform([0.3, -1, -2, -2, -0.5, -0.5], [2.8, 1, 2, 2, 0.5, 0.5], (3000, 6))
    if law.name == "rough":
        starts[:, 4:] = 0
    starts, k = attached(law, starts, rng.uniform(0.05, 0.5, 3000))
    run = st.simulate(st.Disk(k=k), law, starts, np.linspace(0, 20, 101), tolerance=1e-10)
    counts = Counter(BY_CODE[int(o)].word for o in run.outcome.values)
    print(
        f"{law.name} {law.given}: {len(starts)} launches, {dict(counts)}, worst audit "
        f"{float(run.energy_error.max()):.1e}"
    )
    for name in (*STATES, "energy", "normal_force", "power", "audit"):
        assert np.isfinite(run[name].values).all()
    running = run.running.values == 1
    assert (run.normal_force.values[running] > 0).all()
    rise = np.diff(run.energy.values, axis=-1)
    assert rise.max() < 1e-6
    assert counts["unresolved"] == 0
    assert np.quantile(run.energy_error, 0.99) < 1e-6


def test_dry_launches_stay_in_the_cone_and_alternate() -> None:
    rng = np.random.default_rng(11)
    transitions, words, worst = 0, Counter[str](), 0.0
    for _ in range(400):
        k, mu = rng.uniform(0.05, 0.5), rng.uniform(0.02, 0.9)
        mu *= 2 * np.sqrt(k * (k + 1))
        start = rng.uniform([0.4, -1, -2, -2, -0.5, -0.5], [2.7, 1, 2, 2, 0.5, 0.5])
        if rng.uniform() < 0.3:
            start[4:] = 0
        try:
            run = st.simulate(st.Disk(k=k), st.Coulomb(mu), start, np.linspace(0, 10, 201))
        except st.StabilityError:
            continue
        outcome = BY_CODE[int(run.outcome)]
        words[outcome.word] += 1
        assert outcome in (Outcome.MOVING, Outcome.LIFT_OFF, Outcome.FLAT)
        kinds = [k for k in run.event_kind.values.tolist() if k in ("stick", "slip")]
        assert all(a != b for a, b in zip(kinds, kinds[1:], strict=False))
        transitions += len(kinds)
        force = np.hypot(run.force_x, run.force_y).values
        inside = force <= mu * run.normal_force.values * (1 + 1e-9) + 1e-9
        assert inside.all()
        sticking = run["mode"].values == 1
        assert (run.slip_x.values[sticking] == 0).all()
        assert (np.diff(run.energy.values) < 1e-7).all()
        worst = max(worst, float(run.energy_error))
    print(f"dry friction: {dict(words)}, {transitions} transitions, worst audit {worst:.1e}")
    assert transitions > 300
    assert worst < 1e-7
