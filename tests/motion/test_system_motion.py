"""`simulate` on a user's system: pendulum, spinning top and Chaplygin sleigh by closed forms."""

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
from own_systems import BLADE, SLEIGH, hanging, pendulum, sleigh, top
from scipy.special import ellipj, ellipk

import stability as st

METHODS = ("auto", "heyoka", "dop853", "lsoda", "cvodes")


def outcome(run: Any) -> str:
    return str(run.attrs["outcome"])


# --- closed forms ---


@pytest.mark.few(3)
@pytest.mark.parametrize("method", METHODS)
def test_a_pendulum_follows_jacobis_functions(method: str) -> None:
    g, amplitude = 9.81, 2.5
    modulus = math.sin(amplitude / 2) ** 2
    times = np.linspace(0, 7, 36)
    run = st.simulate(
        pendulum(), {"g": g, "c": 0}, {"angle": amplitude, "rate": 0}, times, method=method
    )
    sn = ellipj(ellipk(modulus) - math.sqrt(g) * times, modulus)[0]
    exact = 2 * np.arcsin(math.sin(amplitude / 2) * sn)
    error = abs(run.angle.values - exact).max()
    assert error < 1e-6
    assert abs(run.angle.values[-1] - exact[-1]) <= float(run.final_error) * max(1, amplitude)
    assert float(run.energy_error) < 1e-7
    assert outcome(run) == "moving"


def test_a_top_precesses_and_nods_as_jacobi_says() -> None:
    """The inclination by elliptic functions: let go at rest, the axis falls to a cusp and back.

    With spin momentum L along the axis (I₁ = m g l = 1), u = c obeys u'² = f(u), a cubic; between
    its roots u₁ ≤ u ≤ u₂ < u₃: u = u₁ + (u₂ - u₁) sn²(√((u₃ - u₁)/2) t, m).
    """
    spin, tilt = 2.4, 1.1
    axis = np.array([math.sin(tilt), 0.0, math.cos(tilt)])
    start = np.concatenate([axis, spin * axis])  # let go at rest: a cuspidal motion
    u0 = axis[2]
    cubic = np.poly1d([-1, 0, 1]) * np.poly1d([-2.0, 2 * u0]) - np.poly1d([-spin, spin * u0]) ** 2
    low, high, beyond = np.sort(cubic.roots.real)
    times = np.linspace(0, 12, 61)
    run = st.simulate(top(), [spin], start, times)
    modulus = (high - low) / (beyond - low)
    sn = ellipj(ellipk(modulus) - math.sqrt((beyond - low) / 2) * times, modulus)[0]
    exact = low + (high - low) * sn**2
    assert abs(run.c.values - exact).max() < 1e-9
    assert abs(run.momentum_up.values - spin * u0).max() < 1e-10
    assert abs(run["size"].values - 1).max() < 1e-10
    assert float(run.energy_error) < 1e-9


def test_a_sleigh_turns_round_and_settles_on_running_straight() -> None:
    """Its speed is v∞ tanh(k (t - t₀)); energy is kept, and yet straight running attracts."""
    system = sleigh()
    straight = st.Family(system, "straight", at=("v",), held={"w": 0.0})
    v0, w0 = -1.0, 0.05
    last = math.sqrt(v0**2 + BLADE * w0**2)
    k = 0.3 * last / BLADE
    shift = math.atanh(v0 / last) / k
    times = np.linspace(0, 30, 61)
    run = st.simulate(system, SLEIGH, [v0, w0], times, families=[straight])
    exact = last * np.tanh(k * times + k * shift)
    assert abs(run.v.values - exact).max() < 1e-8
    assert last == pytest.approx(1.0003624343206, abs=1e-12)  # 13 digits of two other routes
    assert outcome(run) == "settled"
    assert str(run.nearest_family.values) == "straight"
    limit = float(str(run.evidence.values).split("straight at v = ")[2].split()[0])
    assert limit == pytest.approx(last, abs=1e-5)
    assert "falling at the rate 1.03" in str(run.evidence.values)  # m a v / (I + m a²)
    assert float(run.nearest_member[0]) == pytest.approx(float(run.v[-1]))


def test_a_limit_named_by_two_states_is_told_in_their_order() -> None:
    """ẋ = ẏ = 0, ż = -z: every (x, y, 0) attracts; `at` names y before x."""
    x = ca.SX.sym("x", 3)
    s = st.System("plane", x, ca.SX(0, 1), ca.vertcat(0, 0, -x[2]), states=("x", "y", "z"))
    family = st.Family(s, "floor", at=("y", "x"), held={"z": 0.0})
    run = st.simulate(s, None, [1.25, 7.5, 0.5], 20.0, families=family)
    assert outcome(run) == "settled"
    said = str(run.evidence.values).split("converges to floor at ")[1]
    assert said.startswith("x = 1.25, y = 7.5 within")


def test_backwards_nothing_settles() -> None:
    """The same family with v < 0 repels: a slow passage is not settling."""
    system = sleigh()
    straight = st.Family(system, "straight", at=("v",), held={"w": 0.0})
    run = st.simulate(system, SLEIGH, [-1.0, 1e-9], 5.0, families=straight)
    assert outcome(run) == "moving"
    assert "not proved" in str(run.evidence.values)


# --- settling ---


def test_damped_pendulum_settles_and_time_is_that_of_the_samples() -> None:
    system = pendulum()
    run = st.simulate(
        system, {"g": 1.0, "c": 0.2}, {"angle": 1.0, "rate": 0.0}, 120.0, families=hanging(system)
    )
    assert outcome(run) == "settled"
    since = float(run.settled_time)
    far = np.hypot(run.angle.values, run.rate.values)
    assert (far[run.time.values >= since] <= 1e-3).all()
    assert (far[run.time.values < since][-1:] > 1e-3).all()
    assert float(run.audit.max()) < 1e-8


def test_an_undamped_pendulum_near_rest_is_not_settled() -> None:
    system = pendulum()
    run = st.simulate(system, {"g": 1.0, "c": 0.0}, [1e-4, 0.0], 30.0, families=hanging(system))
    assert outcome(run) == "moving"
    assert float(run.nearest_distance) < 2e-4


def test_a_member_that_is_solved_for_attracts_too() -> None:
    """ẋ = p - x³, ẏ = x - y: the member (∛p, ∛p) stands alone, known by its root-finder."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    s = st.System(
        "cube", x, p, ca.vertcat(p - x[0] ** 3, x[0] - x[1]), states=("x", "y"), parameters=("p",)
    )
    family = st.Family(s, "rest", at=("p",), unknown={"x": 1.0, "y": 1.0}, equations=("x", "y"))
    run = st.simulate(s, [2.0], [0.5, -1.0], 20.0, families=family)
    assert outcome(run) == "settled"
    assert run.nearest_member.values == pytest.approx([2 ** (1 / 3)] * 2, abs=1e-12)


def test_a_family_found_along_a_state_is_near_but_never_settled_on() -> None:
    """ẋ = 0, ẏ = x² + 1 - y: members (x, x² + 1) found by a root-finder along x."""
    x = ca.SX.sym("x", 2)
    s = st.System(
        "slide", x, ca.SX(0, 1), ca.vertcat(0 * x[0], x[0] ** 2 + 1 - x[1]), states=("x", "y")
    )
    family = st.Family(s, "floor", at=("x",), unknown={"y": 1.0}, equations=("y",))
    run = st.simulate(s, None, [0.5, 3.0], 40.0, families=family)
    assert outcome(run) == "moving"
    assert "found by a root-finder along x" in str(run.evidence.values)
    assert float(run.nearest_distance) < 1e-10


def test_a_basin_is_never_claimed_beyond_its_border() -> None:
    """ẋ = x (x - h): 0 attracts from below h alone; settled states within `settle` of 0 only."""
    x, h = ca.SX.sym("x"), ca.SX.sym("h")
    s = st.System("fold", x, h, x * (x - h), states=("x",), parameters=("h",))
    family = st.Family(s, "rest", at=("h",), held={"x": 0.0})
    rng = np.random.default_rng(3)
    for gap in 10.0 ** rng.uniform(-6, -2, 30):
        share = rng.uniform(-2, 2)
        run = st.simulate(s, [gap], [gap * share], 1e-3, families=family, settle=0.1, check=False)
        if outcome(run) == "settled":
            assert share < 1
        elif abs(share) < 0.2:  # well within: the proof must not be empty
            pytest.fail(f"not settled at {share} of {gap}")


# --- ends, dataset, refusals ---


@pytest.mark.parametrize("method", METHODS)
def test_a_condition_ends_a_run_where_it_reaches_zero(method: str) -> None:
    """A falling body over a floor: z = 1 - t²/2 reaches 0.2 at √1.6."""
    x = ca.SX.sym("x", 2)
    floor = st.Condition(x[0] - 0.2, "z - 0.2 = {value:.3g} is not positive")
    s = st.System(
        "fall", x, ca.SX(0, 1), ca.vertcat(x[1], -1), states=("z", "w"), conditions=(floor,)
    )
    run = st.simulate(s, None, [1.0, 0.0], 3.0, method=method)
    assert outcome(run) == "domain-end"
    assert abs(float(run.end_time) - math.sqrt(1.6)) <= float(run.end_time_error) + 1e-12
    assert float(run.end_time_error) < 1e-6
    assert float(run.z[-1]) == pytest.approx(0.2, abs=1e-7)
    assert "is not positive" in str(run.evidence.values)
    assert run.event_kind.values.tolist() == ["domain-end"]


def test_a_dip_between_steps_is_seen() -> None:
    """A spring's guard that is negative for 2 % of a period, between samples and steps."""
    x, h = ca.SX.sym("x", 2), ca.SX.sym("h")
    lowest = st.Condition(x[0] + h, "x + h = {value:.3g} is not positive")
    s = st.System(
        "spring",
        x,
        h,
        ca.vertcat(x[1], -x[0]),
        states=("x", "v"),
        parameters=("h",),
        conditions=(lowest,),
    )
    h0 = math.cos(0.02 * math.pi)
    for method in ("heyoka", "dop853", "lsoda", "cvodes"):
        run = st.simulate(s, [h0], [1.0, 0.0], [6.0], method=method, tolerance=1e-6)
        assert outcome(run) == "domain-end", method
        assert float(run.end_time) == pytest.approx(0.98 * math.pi, abs=1e-3)


def test_many_launches_agree_with_each_alone_and_hold_their_parameters() -> None:
    system = pendulum()
    g = np.array([[1.0, 2.0, 3.0]])
    start = {"angle": np.array([[0.5], [1.5]]), "rate": 0.0}
    run = st.simulate(system, {"g": g, "c": 0.1}, start, [1.0, 4.0], families=hanging(system))
    assert run.angle.shape == (2, 3, 2)
    assert run.g.values[0].tolist() == [1.0, 2.0, 3.0]
    for i in range(2):
        for j in range(3):
            own = st.simulate(
                system,
                {"g": g[0, j], "c": 0.1},
                {"angle": start["angle"][i, 0], "rate": 0.0},
                [1.0, 4.0],
            )
            assert np.allclose(own.angle.values, run.angle.values[i, j], atol=1e-9)


def test_labels_and_units_are_those_of_the_system(tmp_path: Path) -> None:
    system = pendulum()
    run = st.simulate(system, {"g": 9.81, "c": 0.1}, [1.0, 0.0], 2.0, families=hanging(system))
    assert run.angle.attrs["units"] == "rad"
    assert run.time.attrs["units"] == "s"
    assert run.audit.attrs["units"] == "J/kg"
    assert run.attrs["system"] == "pendulum"
    text = str(run.attrs) + str({n: v.attrs for n, v in run.variables.items()})
    for word in ("disk", "theta", "omega3", "Przybylska", "√"):
        assert word not in text
    back = st.read_motion(st.write_motion(run, tmp_path / "p.nc"))
    assert back.identical(run)


def test_no_name_of_a_dataset_can_be_a_systems_own() -> None:
    from stability.bodies.model import TAKEN

    system = pendulum()
    run = st.simulate(system, [[9.81, 0.5]], [1.0, 0.0], 60.0, families=hanging(system))
    own = {*system.states, *system.parameters, *system.observables}
    assert {*map(str, run.variables), *map(str, run.dims)} - own <= set(TAKEN)


def test_a_system_without_energy_has_no_account() -> None:
    run = st.simulate(pendulum(observed=False), [1.0, 0.0], [1.0, 0.0], 2.0)
    assert "audit" not in run
    assert "energy_error" not in run
    assert "nearest_family" not in run


def test_a_wrong_power_is_noticed() -> None:
    x, c = ca.SX.sym("x", 2), ca.SX.sym("c")
    s = st.System(
        "spring",
        x,
        c,
        ca.vertcat(x[1], -x[0] - c * x[1]),
        states=("q", "v"),
        parameters=("c",),
        observables={"energy": ca.sumsqr(x) / 2, "power": 2 * c * x[1] ** 2},
    )
    run = st.simulate(s, [0.5], [1.0, 0.0], 5.0)
    assert outcome(run) == "unresolved"
    assert "energy account fails" in str(run.evidence.values)


def test_an_energy_of_zero_is_no_failure() -> None:
    """From rest at the height from which energy is counted: E = 0 all along."""
    run = st.simulate(pendulum(), {"g": 1.0, "c": 0.0}, [math.pi / 2, 0.0], 20.0)
    assert float(run.energy_error) < 1e-8
    assert outcome(run) == "moving"


def test_a_function_without_taylor_series_goes_another_way() -> None:
    x = ca.SX.sym("x", 2)
    s = st.System(
        "bounce", x, ca.SX(0, 1), ca.vertcat(x[1], -ca.fabs(x[0]) * x[0]), states=("x", "v")
    )
    run = st.simulate(s, None, [1.0, 0.0], 5.0)
    assert str(run.method.values) != "heyoka"
    with pytest.raises(st.StabilityError, match="method is 'heyoka', but"):
        st.simulate(s, None, [1.0, 0.0], 5.0, method="heyoka")


PENDULUM = pendulum()
OTHER = replace(PENDULUM, name="other")
REFUSED: list[tuple[str, Callable[[], Any], str]] = [
    ("unnamed state", lambda: st.simulate(PENDULUM, [1, 0], {"angle": 1.0}, 1.0), "not name rate"),
    ("stranger", lambda: st.simulate(PENDULUM, {"g": 1, "mu": 1}, [1, 0], 1.0), "known are g, c"),
    ("law", lambda: st.simulate(PENDULUM, st.Viscous(1.0), [1, 0], 1.0), "parameters"),
    ("nan", lambda: st.simulate(PENDULUM, [1, 0], [1, np.nan], 1.0), "NaN"),
    ("width", lambda: st.simulate(PENDULUM, [1, 0], [1, 0, 0], 1.0), "must hold 2 values"),
    ("pose", lambda: st.simulate(PENDULUM, [1, 0], [1, 0], 1.0, pose=True), "only a disk"),
    ("mass", lambda: st.simulate(PENDULUM, [1, 0], [1, 0], 1.0, method="idas"), "mass matrix"),
    (
        "other's",
        lambda: st.simulate(PENDULUM, [1, 0], [1, 0], 1.0, families=hanging(OTHER)),
        "another system",
    ),
    ("no family", lambda: st.simulate(PENDULUM, [1, 0], [1, 0], 1.0, families=[3]), "families is"),
    (
        "disk",
        lambda: st.simulate(
            st.Disk(), st.Smooth(), {"theta": 1.0}, 1.0, families=[hanging(PENDULUM)]
        ),
        "leave them",
    ),
    (
        "shapes",
        lambda: st.simulate(PENDULUM, {"g": [1, 2], "c": 0}, {"angle": [1, 2, 3], "rate": 0}, 1.0),
        "shape",
    ),
    (
        "outside",
        lambda: st.simulate(
            st.System(
                "half",
                PENDULUM.x,
                PENDULUM.p,
                PENDULUM.rhs,
                states=("q", "v"),
                parameters=("g", "c"),
                conditions=(st.Condition(PENDULUM.x[0], "q = {value}"),),
            ),
            [1, 0],
            [-1.0, 0],
            1.0,
        ),
        "start: q = -1.0",
    ),
    (
        "taken",
        lambda: st.simulate(
            st.System(
                "t",
                PENDULUM.x,
                PENDULUM.p,
                PENDULUM.rhs,
                states=("time", "v"),
                parameters=("g", "c"),
            ),
            [1, 0],
            [1.0, 0],
            1.0,
        ),
        "called 'time'",
    ),
]


@pytest.mark.parametrize(("call", "words"), [c[1:] for c in REFUSED], ids=[c[0] for c in REFUSED])
def test_it_is_refused_in_one_sentence(call: Callable[[], Any], words: str) -> None:
    with pytest.raises(st.StabilityError) as caught:
        call()
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 300


# --- figures ---


def test_figures_show_the_states_of_the_system_and_no_word_of_a_disk() -> None:
    from stability.figures.motion import caption

    system = pendulum()
    run = st.simulate(system, {"g": 9.81, "c": 0.5}, [1.5, 0.0], 60.0, families=hanging(system))
    figure = st.plot_motion(run)
    labels = [a.get_ylabel() for a in figure.axes]
    assert labels == ["angle\n[rad]", "rate\n[rad/s]", "energy\n[J/kg]", "|audit| over\nenergy"]
    assert [line.get_label() for line in figure.axes[0].lines] == ["angle", "steady"]
    assert (
        len(st.plot_motion(run, show="states").axes)
        == len(st.plot_motion(run, show="energy").axes)
        == 2
    )
    said = caption(run)
    assert said.startswith("Motion of pendulum (c = 0.5 1/s, g = 9.81 1/s²) from angle = 1.5 rad,")
    assert "disk" not in said + "".join(t.get_text() for t in figure.findobj(match=_is_text))
    with pytest.raises(st.StabilityError, match="pendulum has no theta; this figure needs a disk"):
        st.animate(run, "never.gif")


def _is_text(artist: Any) -> bool:
    return hasattr(artist, "get_text")


def test_a_figure_of_a_system_without_account_shows_its_states_alone() -> None:

    run = st.simulate(pendulum(observed=False), [1.0, 0.0], [1.0, 0.0], 2.0)
    assert len(st.plot_motion(run).axes) == 2


# --- what a hostile user found ---


def bare(rhs: Callable[[Any], Any], *names: str, **words: Any) -> st.System:
    x = ca.SX.sym("x", len(names))
    if "watched" in words:
        words["conditions"] = (st.Condition(words.pop("watched")(x), "c = {value}"),)
    return st.System("bare", x, ca.SX(0, 1), ca.SX(ca.vertcat(*rhs(x))), states=names, **words)


@pytest.mark.parametrize(
    ("centre", "width", "last", "tolerance"),
    [
        (10, 0.1, 20.0, 1e-9),
        (50, 1.0, 75.0, 1e-4),
        (20, 0.5, 30.0, 1e-4),
        (50, 0.5, 75.0, 1e-12),
    ],
)
def test_a_pulse_that_is_flat_at_the_start_is_not_stepped_over(
    centre: float, width: float, last: float, tolerance: float
) -> None:
    """A Taylor series sees nothing of exp(-((t - c)/w)²) from afar: 0 for w √π, and all agreed."""
    s = bare(lambda x: (1, ca.exp(-(((x[0] - centre) / width) ** 2))), "t", "y")
    run = st.simulate(s, None, [0.0, 0.0], [last], tolerance=tolerance)
    true = width * math.sqrt(math.pi)
    assert abs(float(run.y[-1]) - true) <= float(run.final_error) + 1e-12
    assert float(run.y[-1]) == pytest.approx(true, abs=1e-2)


def test_a_condition_that_is_flat_at_the_start_is_not_stepped_over() -> None:
    s = bare(lambda _: (1,), "t", watched=lambda x: 1 - 2 * ca.exp(-(((x[0] - 50) / 0.5) ** 2)))
    for times in ([75.0], 75.0):
        run = st.simulate(s, None, [0.0], times)
        assert outcome(run) == "domain-end"
        assert float(run.end_time) == pytest.approx(50 - 0.5 * math.sqrt(math.log(2)), abs=1e-8)


@pytest.mark.parametrize("method", METHODS)
def test_the_first_of_many_brief_dips_ends_the_run(method: str) -> None:
    s = bare(lambda _: (1,), "s", watched=lambda x: 0.999 + ca.cos(30 * x[0]))
    run = st.simulate(s, None, [0.0], [10.3], method=method)
    assert float(run.end_time) == pytest.approx(math.acos(-0.999) / 30, abs=1e-8)


@pytest.mark.few(3)
@pytest.mark.parametrize("method", ["dop853", "lsoda", "radau", "bdf", "cvodes"])
def test_a_condition_without_value_beyond_its_zero_ends_the_run(method: str) -> None:
    s = bare(lambda x: (x[1], -x[0]), "q", "v", watched=lambda x: ca.sqrt(x[0] + 0.5))
    run = st.simulate(s, None, [1.0, 0.0], [6.0], method=method, tolerance=1e-6)
    if outcome(run) != "undetermined":
        assert outcome(run) == "domain-end"
        assert float(run.end_time) == pytest.approx(2 * math.pi / 3, abs=1e-3)


@pytest.mark.parametrize("method", METHODS)
def test_a_multiple_zero_of_a_condition_is_found(method: str) -> None:
    s = bare(lambda x: (x[1], -x[0]), "q", "v", watched=lambda x: (x[0] + 0.5) ** 3)
    run = st.simulate(s, None, [1.0, 0.0], [6.0], method=method)
    if outcome(run) == "domain-end":
        assert abs(float(run.end_time) - 2 * math.pi / 3) <= float(run.end_time_error) + 1e-6
    else:
        assert outcome(run) in ("undetermined", "unresolved")


@pytest.mark.parametrize("method", ["radau", "bdf", "lsoda", "dop853", "auto"])
def test_equations_that_lose_their_value_are_unresolved(method: str) -> None:
    run = st.simulate(bare(lambda x: (-ca.sqrt(x[0]),), "a"), None, [1.0], [4.0], method=method)
    assert outcome(run) in ("unresolved", "undetermined", "moving")
    assert np.isfinite(run.a.values).all()


def test_absurd_sizes_and_observables_without_value_are_refused() -> None:
    spring = bare(lambda x: (x[1], -x[0]), "q", "v")
    with pytest.raises(st.StabilityError, match="1e\\+155, above 1e\\+100"):
        st.simulate(spring, None, [1e155, 0.0], [1.0])
    x = ca.SX.sym("x")
    seen = {"energy": ca.sqrt(x - 0.5), "power": ca.SX(0)}
    decay = st.System("decay", x, ca.SX(0, 1), -x, states=("x",), observables=seen)
    with pytest.raises(st.StabilityError, match="decay: energy has no value somewhere"):
        st.simulate(decay, None, [1.0], [1.0, 5.0])
    with pytest.raises(st.StabilityError, match="which no file can hold"):
        st.simulate(bare(lambda x: (-x[0],), "/slash/"), None, [1.0], [1.0])
