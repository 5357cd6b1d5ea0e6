"""The lean route's outcomes are those of `simulate` with all its neighbours."""

from typing import Any

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import stability as st
from stability.basin import outcomes as engine
from stability.basin.launches import prepare
from stability.basin.outcomes import Outcomes, outcomes
from stability.motion.result import BY_CODE, CODES, Outcome, Settings
from stability.settling.settling import SETTLE

STATES = ("theta", "theta_dot", "phi_dot", "omega3", "slip_x", "slip_y")
DISKS = {"uniform": 0.25, "annulus": 0.4, "hoop": 0.5}


def launched(family: str, own: str, count: int, seed: int, horizon: float, k: float = 0.25) -> Any:
    rng = np.random.default_rng(seed)
    asked = prepare(
        st.Disk(k=k),
        "viscous",
        (own, "tilt"),
        {},
        horizon,
        Settings(),
        family=family,
        parameters={"mu": 0.3},
    )
    points = {own: rng.uniform(0.3, 4, count), "tilt": rng.uniform(0.0, 0.6, count)}
    return asked.starts(points)


def compared(found: Outcomes, run: Any, open_: int) -> int:
    """Launches that end differently although neither calls itself undetermined.

    A launch that is proved to settle may wobble about the distance that counts at its last time.
    """
    unsure = {CODES[Outcome.UNDETERMINED], CODES[Outcome.UNRESOLVED]}
    sure = ~np.isin(found.outcome, list(unsure)) & ~np.isin(run.outcome.values, list(unsure))
    assert (~sure).sum() <= open_
    wobbles = (
        (found.outcome == CODES[Outcome.SETTLED])
        & (run.outcome.values == CODES[Outcome.MOVING])
        & (run.nearest_distance.values < 2 * SETTLE)
    )
    assert wobbles.sum() <= len(wobbles) / 200
    sure &= ~wobbles
    return int((found.outcome != run.outcome.values)[sure].sum())


@pytest.mark.parametrize(("family", "own"), [("spinning", "phi_dot"), ("rolling", "omega3")])
@pytest.mark.parametrize(
    ("body", "count"),
    [("uniform", 24), *(pytest.param(b, 1700, marks=pytest.mark.long) for b in DISKS)],
)
@pytest.mark.filterwarnings("ignore::stability.StabilityWarning")
def test_outcomes_are_those_of_the_checked_single_run(
    family: str, own: str, body: str, count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    horizon = 400.0 if count < 100 else 1000.0
    launches = launched(family, own, count, len(body), horizon, DISKS[body])
    alone: list[int] = []
    single = engine._singly
    monkeypatch.setattr(
        engine,
        "_singly",
        lambda found, some, rows, judging: (
            alone.extend(rows.tolist()),
            single(found, some, rows, judging),
        ),
    )
    found = outcomes(launches, Settings())
    assert len(alone) <= count / 20  # these are compared with the route that decided them
    fit = np.array([i not in (launches.unfit or {}) for i in range(count)])
    run = st.simulate(st.Disk(k=DISKS[body]), st.Viscous(0.3), launches.starts[fit], horizon)
    part = Outcomes(**{n: getattr(found, n)[fit] for n in Outcomes.__dataclass_fields__})
    assert compared(part, run, count // 50) == 0
    settled = part.outcome == CODES[Outcome.SETTLED]
    if (body, family) == ("hoop", "rolling"):  # next to nothing settles by then: these wobble on
        assert settled.mean() < 0.1 and (part.outcome == CODES[Outcome.MOVING]).sum() > 0.85 * count
    else:
        assert settled.sum() > count / 5
    # the proved member, and the one that the last state of the single run converges to
    last = np.stack([run[n].values[:, -1] for n in STATES], axis=-1)
    near = launches.settling.many(last, launches.p[fit], np.inf)
    late = np.abs(part.member - near.settled.limit[:, 0])
    stated = part.error + run.final_error.values  # not finite where neighbouring runs part
    allowed = part.member_error + near.settled.error + stated
    told = settled & near.settled.proved & np.isfinite(stated)
    np.testing.assert_array_equal(part.family[told], near.family[told])
    assert told.sum() >= 0.9 * settled.sum()
    assert (late <= allowed + 1e-12)[told].all(), list(zip(late[told], allowed[told], strict=True))
    if not told.any():
        return
    # a bound that says something: it is narrow, and a member off by thrice its error breaks it
    # (the few that settle by then next to a hoop are at the edge of wide tubes)
    assert np.quantile(allowed[told], 0.9) < (
        5e-3 if (body, family) == ("hoop", "rolling") else 1e-3
    )
    assert np.median((late / allowed)[told]) < 0.01  # the limit is better than the nearest member
    off = 3 * (part.member_error + part.error)
    for moved in (part.member + off, part.member - off):
        wrong = np.abs(moved - near.settled.limit[:, 0]) > allowed + 1e-12
        assert wrong[told].mean() > 0.6


def test_outcomes_do_not_depend_on_the_company() -> None:
    launches = launched("spinning", "phi_dot", 24, 8, 150.0)
    whole = outcomes(launches, Settings())
    rows = np.random.default_rng(1).permutation(24)[:11]
    some = outcomes(launches.some(rows), Settings())
    for name in Outcomes.__dataclass_fields__:
        np.testing.assert_array_equal(getattr(some, name), getattr(whole, name)[rows])
    assert (whole.outcome == CODES[Outcome.SETTLED]).sum() > 7


def test_a_start_without_contact_has_ended_already() -> None:
    asked = prepare(
        st.Disk(),
        "viscous",
        ("theta", "theta_dot", "slip_x"),
        {},
        1.0,
        Settings(),
        parameters={"mu": 3.0},
    )
    points = {
        "theta": np.array([1.5, 1.0, 1e-7, 4.0, 1.0]),
        "theta_dot": np.array([0.0, 3, 0, 0, 0]),
        "slip_x": np.array([0.0, 0, 0, 0, 5.0]),
    }
    found = outcomes(asked.starts(points), Settings())
    words = [BY_CODE[c].word for c in found.outcome.tolist()]
    assert words == ["moving", "lift-off", "flat", "flat", "no-contact"]
    assert (found.time[1:] == 0).all() and found.time[0] == 1.0


def test_what_the_two_runs_leave_open_is_decided_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    launches = launched("spinning", "phi_dot", 12, 3, 60.0)
    usual = outcomes(launches, Settings())
    alone: list[int] = []
    single = engine._singly

    def counted(found: Any, launches: Any, rows: Any, *rest: Any) -> None:
        alone.extend(rows.tolist())
        single(found, launches, rows, *rest)

    plain = engine._judged
    calls: list[float] = []

    def other(flow: Any, starts: Any, p: Any, horizon: Any, tolerance: float, *rest: Any) -> Any:
        run = plain(flow, starts, p, horizon, tolerance, *rest)
        calls.append(tolerance)
        if len(calls) == 2:  # the looser run contradicts the first one in two launches
            run.outcome[[2, 5]] = CODES[Outcome.FLAT]
        return run

    monkeypatch.setattr(engine, "_singly", counted)
    monkeypatch.setattr(engine, "_judged", other)
    found = outcomes(launches, Settings())
    assert calls == pytest.approx([1e-9, 1e-7]) and len(alone) == 2
    assert (found.outcome == usual.outcome).all()


def pendulum() -> Any:
    x, c = ca.SX.sym("x", 2), ca.SX.sym("c")
    system = st.System(
        "pendulum",
        x,
        c,
        ca.vertcat(x[1], -ca.sin(x[0]) - c * x[1]),
        states=("angle", "rate"),
        parameters=("c",),
    )
    turns = {
        n: st.Family(system, f"rest {n}", at=("c",), held={"angle": a, "rate": 0.0})
        for n, a in (("a", 0.0), ("b", 2 * np.pi), ("c", -2 * np.pi))
    }
    return system, tuple(turns.values())


def late_departure() -> tuple[Any, Any]:
    """A system that leaves an unstable motion, and the time that it then spends away.

    s = u² leaves s = 0 as s' = 2 s (1 - s), from u = 2⁻⁵³, and w' = 10⁻⁴ s.  The circle
    x² + y² = 1 is exact for the motion alone: its numerical error drives s too, which leaves early.
    """
    x = ca.SX.sym("x", 4)
    circle = x[0] ** 2 + x[1] ** 2 - 1
    rates = ca.vertcat(20 * x[1], -20 * x[0], 2 * x[2] * (1 - x[2]) + circle**2, 1e-4 * x[2])
    system = st.System("late", x, ca.SX.sym("none", 0), rates, states=("x", "y", "s", "w"))

    def away(time: float) -> float:
        return float(0.5e-4 * np.log1p((np.exp(2 * time) - 1) * 2.0**-106))

    return system, away


@pytest.mark.parametrize("horizon", [55.0, 70.0])
def test_the_error_of_a_late_departure_reaches_down_to_rounding(
    horizon: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    system, away = late_departure()
    asked = prepare(system, None, ("x", "y", "s", "w"), {}, horizon, Settings())
    points = {n: np.full(1, v) for n, v in zip("xysw", (1.0, 0.0, 2.0**-106, 0.0), strict=True)}
    runs, judged = [], engine._judged
    monkeypatch.setattr(engine, "_judged", lambda *a: runs.append(judged(*a)) or runs[-1])
    found = outcomes(asked.starts(points), Settings())
    assert found.outcome[0] == CODES[Outcome.MOVING]
    first, second = (run.state[0] for run in runs)
    late = abs(first[3] - away(horizon))  # w, in closed form
    assert late > 5e-4  # it has left too early, by five units of time
    assert np.abs(first - second).max() < late  # so that the difference of two runs is no bound
    assert late <= found.error[0] < 10 * late


def test_launches_whose_two_runs_part_are_decided_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    launches, alone = launched("rolling", "omega3", 24, 5, 60.0), []
    single = engine._singly
    monkeypatch.setattr(
        engine,
        "_singly",
        lambda found, some, rows, judging: (
            alone.extend(rows.tolist()),
            single(found, some, rows, judging),
        ),
    )
    usual = outcomes(launches, Settings())
    assert not alone
    worst = int(np.argmax(np.where(usual.outcome == 0, usual.error, 0.0)))
    monkeypatch.setattr(engine, "PARTED", 0.99 * usual.error[worst])
    again = outcomes(launches, Settings())
    assert worst in alone and (again.outcome == usual.outcome).all()


@pytest.mark.parametrize(
    ("count", "last", "seed"), [(6, 50.0, 0), pytest.param(24, 100.0, 4, marks=pytest.mark.long)]
)
def test_a_systems_launches_settle_where_an_independent_integration_ends(
    count: int, last: float, seed: int
) -> None:
    system, rests = pendulum()
    asked = prepare(
        system, None, ("angle", "rate"), {"c": 0.3}, 2 * last, Settings(), families=rests
    )
    rng = np.random.default_rng(seed)
    points = {"angle": rng.uniform(-3, 3, count), "rate": rng.uniform(-4, 4, count)}
    found = outcomes(asked.starts(points), Settings())
    for row in range(count):
        end = solve_ivp(
            lambda _, y: [y[1], -np.sin(y[0]) - 0.3 * y[1]],
            (0, last),
            [points["angle"][row], points["rate"][row]],
            rtol=1e-9,
            atol=1e-11,
        ).y[0, -1]
        turn = round(end / (2 * np.pi))
        name = {0: 0, 1: 1, -1: 2}.get(turn, -1)
        settled = found.outcome[row] == CODES[Outcome.SETTLED]
        assert settled == (name >= 0) and (not settled or found.family[row] == name)
    assert {0, 1, 2} <= set(found.family.tolist())


@pytest.mark.few(1)
@pytest.mark.parametrize("contact", [st.Rough(), st.Smooth(), st.Coulomb(0.3)])
def test_laws_that_settle_on_nothing_give_the_outcomes_of_simulate(contact: Any) -> None:
    asked = prepare(st.Disk(), contact, ("phi_dot", "tilt"), {}, 8.0, Settings(), family="spinning")
    points = {"phi_dot": np.array([0.5, 1.5, 2.5, 3.4]), "tilt": np.array([0.5, 0.3, 0.2, 0.5])}
    launches = asked.starts(points)
    found = outcomes(launches, Settings())
    fit = np.array([i not in (launches.unfit or {}) for i in range(4)])
    run = st.simulate(st.Disk(), contact, launches.starts[fit], 8.0)
    assert (found.outcome[fit] == run.outcome.values).all()


def test_a_body_that_passes_its_pole_is_launched_too() -> None:
    top = st.EccentricSphere(0.2)
    asked = prepare(top, st.Viscous(0.3), ("theta", "phi_dot"), {}, 20.0, Settings())
    points = {"theta": np.array([0.1, 0.5, 2.8]), "phi_dot": np.array([0.5, 2.0, 1.0])}
    launches = asked.starts(points)
    found = outcomes(launches, Settings())
    run = st.simulate(top, st.Viscous(0.3), launches.starts, 20.0)
    assert (found.outcome == run.outcome.values).all()
