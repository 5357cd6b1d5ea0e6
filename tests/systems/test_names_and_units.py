"""Names and units come from the user's system: in records, sentences, tables and files.

Every expected text and number is written down here from the definition of each system; eigenvalues
of the systems below are roots of linear or quadratic equations.
"""

import json
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
import xarray

import stability as st
from stability.base.errors import NameUnknownError, ParameterError
from stability.base.quantities import rate_unit, time_unit
from stability.derivation.latex import symbol
from stability.figures.motion import caption
from stability.tables.system_conditions import latex, lines

DISK_WORDS = (
    "theta",
    "phi",
    "omega3",
    "slip",
    "friction",
    "disk",
    "√(g",
    "mu*",
    "rolling",
    "spinning",
    "contact",
    "tilt",
    "lift",
)


def decay(
    names: tuple[str, ...] = ("rate",),
    units: dict[str, str] | None = None,
    state: str = "level",
    name: str = "tank",
) -> st.Family:
    """dx/dt = (first - others) x: the eigenvalue is the first parameter less the others."""
    x, p = ca.SX.sym("x"), ca.SX.sym("p", len(names))
    slope = p[0] - sum(p[i] for i in range(1, len(names)))
    system = st.System(name, x, p, slope * x, states=(state,), parameters=names, units=units or {})
    return st.Family(system, "empty", at=names[:1], held={state: 0.0})


def oscillator(units: dict[str, str] | None = None, **observables: Any) -> st.System:
    """d²q/dt² = c dq/dt - k q: λ² - c λ + k = 0."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    seen = {n: f(x, p) for n, f in observables.items()}
    return st.System(
        "beam",
        x,
        p,
        ca.vertcat(x[1], -p[0] * x[0] + p[1] * x[1]),
        states=("q", "v"),
        parameters=("k", "c"),
        units=units or {},
        observables=seen,
    )


def rest(system: st.System, **options: Any) -> st.Family:
    return st.Family(system, "rest", at=("k",), held={"q": 0.0, "v": 0.0}, **options)


# --- the unit of time ---


@pytest.mark.parametrize(
    ("units", "time", "rate"),
    [
        ({}, "1", "1"),
        ({"q": "mm"}, "1", "1"),
        ({"v": "mm/s"}, "s", "1/s"),
        ({"beta": "1/day"}, "day", "1/day"),
        ({"pump": "1/ns"}, "ns", "1/ns"),
        ({"k": "N/m", "m": "kg"}, "s", "1/s"),
        ({"v": "m/s", "w": "1/h"}, "1", "1"),
        ({"v": "m/s", "time": "ms"}, "ms", "1/ms"),
        ({"a": "m s^-2"}, "s", "1/s"),
        ({"x": "m", "mass": "g"}, "1", "1"),
    ],
)
def test_the_unit_of_time_is_that_of_the_units_given(
    units: dict[str, str], time: str, rate: str
) -> None:
    assert (time_unit(units), rate_unit(units)) == (time, rate)
    others = dict.fromkeys((n for n in units if n != "time"), 0.0)
    spectrum = st.spectrum(decay(("rate", *others), units), at=-1.0, **others)
    assert spectrum.rate_unit == rate


def test_a_unit_of_a_name_that_the_system_does_not_have_is_refused() -> None:
    with pytest.raises(NameUnknownError, match="units names 'c'; known are level, rate, time"):
        decay(units={"c": "m"})
    with pytest.raises(NameUnknownError, match="units names 'c'; known are q, time"):
        st.System.from_function(lambda x, _: [-x[0]], states=("q",), units={"c": "m"})
    q, u = ca.SX.sym("q", 2), ca.SX.sym("u", 2)
    energy = (u[0] ** 2 + u[1] ** 2 + q[0] ** 2) / 2
    units = {"q_1": "m", "u_1": "m/s"}  # a coordinate that is left out has a unit all the same
    left = st.mechanics(q, u, kinetic=energy, ignorable=("q_1",), units=units)
    assert dict(left.units) == {"u_1": "m/s"}
    with pytest.raises(NameUnknownError, match="units names 'c'; known are q_0"):
        st.mechanics(q, u, kinetic=energy, ignorable=("q_1",), units={"c": "m"})


def test_rates_of_a_map_have_the_unit_of_the_system() -> None:
    for units, expected in (({"gain": "1/day"}, "1/day"), ({}, "1")):
        found = st.stability_map(
            decay(("gain", "loss"), units), x=("gain", 1, 2, 3), y=("loss", 1.1, 3, 3)
        )
        rates = ("abscissa", "abscissa_error", "frequency", "boundary_frequency")
        assert {found[n].attrs["units"] for n in rates} == {expected}
        assert found.gain.attrs["units"] == units.get("gain", "1")
        assert not {"contact", "dimensionless"} & set(found.attrs)


def test_the_time_of_a_motion_has_the_unit_of_the_system() -> None:
    family = decay(units={"rate": "1/day"})
    run = st.simulate(family.system, {"rate": -1.0}, {"level": 1.0}, 5.0)
    assert run.time.attrs["units"] == run.end_time.attrs["units"] == "day"
    assert "at time 0 to 5 day" in caption(run)


def test_units_are_raised_for_a_reader_and_kept_as_typed_in_files() -> None:
    system = oscillator(units={"q": "m", "v": "m/s", "c": "kg*m2/s^3"})
    family = rest(system)
    loci = st.spectrum(family, at=1.0, c=np.linspace(-1.0, -0.2, 2)).plot()
    assert loci.axes[-1].get_xlabel() == "c  [kg·m²/s³]"
    plane = st.spectrum(family, at=1.0, c=-0.2).plot()
    assert "c = -0.2 kg·m²/s³" in plane.texts[-1].get_text()
    grid = st.stability_map(family, x=("k", 1, 2, 2), y=("c", -1, -0.1, 2))
    assert st.plot_map(grid).axes[0].get_ylabel() == "c  [kg·m²/s³]"
    assert grid.c.attrs["units"] == "kg*m2/s^3"
    table = st.table("hopf", family, x=("c", -1, 1, 9), k=1.0)
    assert "c = 0 [kg·m²/s³]" in table.to_text() and "at [kg·m²/s³]" in table._repr_html_()
    assert r"[kg$\cdot$m$^{2}$/s$^{3}$]" in table.to_latex()
    assert table.to_csv().startswith("at [kg*m2/s^3]")
    run = st.simulate(system, {"k": 1.0, "c": -0.2}, {"q": 0.3, "v": 0.0}, [0.0, 1.0])
    assert "c = -0.2 kg·m²/s³" in caption(run)
    conditions = st.table("conditions", family)
    assert "c: parameter of beam [kg·m²/s³]" in conditions.to_text()
    assert r"[kg$\cdot$m$^{2}$/s$^{3}$]" in conditions.to_latex()


# --- names ---


def test_a_growing_oscillation_says_so() -> None:
    family = rest(oscillator())
    assert st.spectrum(family, at=1.0, c=0.2).modes.labels == ("growing oscillation of q, v",) * 2
    assert st.spectrum(family, at=1.0, c=-0.2).modes.labels == ("decaying oscillation of q, v",) * 2
    assert st.spectrum(decay(), at=2.0).modes.labels == ("growing mode of level",)


def test_a_parameter_with_the_name_of_an_argument_is_given_in_parameters() -> None:
    family = decay(("gain", "at", "axis", "x"))
    given = {"at": 0.25, "axis": 0.5}
    one = st.spectrum(family, at=2.0, x=0.0, parameters=given)
    assert one.eigenvalues.tolist() == [1.25] and one.at.tolist() == [2.0]
    [found] = st.boundaries(family, axis=("gain", 0, 2, 9), parameters=given | {"x": 0.0})
    assert found.value == 0.75
    [found] = st.boundaries(family, axis=("axis", 0, 2, 9), at=2.0, parameters={"at": 0.5, "x": 0})
    assert found.value == 1.5
    found_map = st.stability_map(
        family, x=("gain", 1, 3, 3), y=("at", 0.5, 2.5, 3), parameters={"axis": 0.0, "x": 0.25}
    )
    assert found_map.abscissa.values == pytest.approx(
        np.array([[g - a - 0.25 for g in (1, 2, 3)] for a in (0.5, 1.5, 2.5)])
    )
    assert found_map["at"].attrs["quantity"] == "at"
    with pytest.raises(ParameterError, match="x is given by name and in parameters"):
        st.spectrum(family, at=2.0, x=0.0, parameters=given | {"x": 0.0})
    family = decay(("gain", "lean"))
    assert st.spectrum(family, at=2.0, parameters={"lean": 3.0}).abscissa == -1.0
    assert st.spectrum(family, parameters={"gain": 2.0, "lean": 3.0}).abscissa == -1.0
    with pytest.raises(ParameterError, match="parameters"):
        st.spectrum(family, at=2.0, lean=3.0)


@pytest.mark.parametrize("name", ["axis", "error", "kind", "curve", "point", "verdict"])
def test_a_map_refuses_an_axis_that_would_hide_its_own_variable(name: str) -> None:
    family = decay(("gain", name))
    with pytest.raises(NameUnknownError, match="a name that the map needs for itself"):
        st.stability_map(family, x=("gain", 1, 2, 3), y=(name, 1.1, 3, 3))


def test_maps_of_odd_names_survive_the_file(tmp_path: Path) -> None:
    family = decay(("x y", "θ"), {"x y": "1/s", "θ": "1/s"}, state="$n", name="disk, viscous")
    found = st.stability_map(family, x=("x y", 1, 2, 2), y=("θ", 1.1, 3, 2, "log"))
    st.write_map(found, tmp_path / "odd.nc")
    again = st.read_map(tmp_path / "odd.nc")
    assert again.abscissa.dims == ("θ", "x y")
    assert again.boundary_axis.attrs["flag_meanings"].split() == ["x_y", "θ"]
    assert again["x y"].attrs["units"] == "1/s"
    np.testing.assert_array_equal(again.abscissa, found.abscissa)


def test_records_count_in_the_singular_and_the_plural() -> None:
    family = decay(("gain", "loss"))
    assert repr(st.spectrum(family, at=1.0, loss=2.0)).endswith("stable; 1 eigenvalue: -1>")
    grid = st.spectrum(family, at=np.ones((2, 3)), loss=2.0)
    assert "2 x 3 points: 6 stable; 1 eigenvalue each" in repr(grid)
    assert repr(st.boundaries(family, axis=("gain", 0, 1, 5), loss=0.5)).startswith("<1 boundary ")
    assert repr(st.boundaries(family, axis=("gain", 0, 1, 5), loss=5.0)).startswith(
        "<0 boundaries "
    )


def test_records_do_not_print_the_graph() -> None:
    family = decay(("gain", "loss"))
    assert repr(family.system) == "<System tank: 1 state (level), 2 parameters (gain, loss)>"
    assert repr(family) == "<Family empty of tank, named by gain>"
    assert repr(st.conditions(family)) == (
        "<Conditions of empty of tank: Stable where -gain + loss > 0; unstable where it is "
        "negative.>"
    )
    x = ca.SX.sym("x", 60)
    many = st.System("chain", x, ca.SX.sym("p", 0), -x, states=tuple(f"q{i}" for i in range(60)))
    assert (
        repr(many) == "<System chain: 60 states (q0, q1, q2, q3, q4, q5, q6, q7, …), 0 parameters>"
    )


def test_a_users_drifting_family_is_not_told_how_a_disk_drifts() -> None:
    family = rest(oscillator(), drifts=True)
    found = st.spectrum(family, at=1.0, c=-0.2).nonlinear
    assert found is st.Nonlinear.CARRIED and not any(w in found.value for w in DISK_WORDS)
    disk = st.spectrum("rolling", at=1.8, contact=st.Viscous(0.3))
    assert disk.nonlinear is st.Nonlinear.DRIFTS


# --- sentences ---


def scene(system: st.System, **options: Any) -> st.Scene:
    given: dict[str, Any] = {"start": {"q": 0.3, "v": 0.0}, "horizon": 1.0}
    return st.Scene(system, {"k": 1.0, "c": -0.2}, **(given | options))


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"start": None}, "q and v"),
        ({"uncertain": 3}, "'c': 0.2"),
        ({"quantities": ("speed",)}, "settling_time"),
        ({"quantities": ("verdict",)}, "final"),
    ],
)
def test_a_refused_scene_of_a_system_names_what_the_system_has(
    wrong: dict[str, Any], said: str
) -> None:
    with pytest.raises(ValueError, match=said) as refused:
        scene(oscillator(), **wrong)
    told = str(refused.value).replace("which only a disk has", "")
    assert not [w for w in DISK_WORDS if w in told]


def test_a_time_in_the_answer_of_a_scene_has_its_unit() -> None:
    x = oscillator({"v": "m/s"})
    ends = st.System(
        "jump",
        x.x,
        x.p,
        ca.vertcat(x.x[1], -1 + 0 * x.x[0]),
        states=("q", "v"),
        parameters=("k", "c"),
        units={"v": "m/s"},
        conditions=(st.Condition(x.x[0], "the ball is on the floor, at height {value:g}"),),
    )
    found = scene(ends, start={"q": 0.5, "v": 0.0}, horizon=3.0).answer()
    assert "until 1 s" in found.sentence  # q = 1/2 - t²/2


def test_evidence_of_a_settled_run_has_units_and_claims_no_limit_within_zero() -> None:
    system = oscillator({"k": "1/s2", "v": "m/s"})
    run = st.simulate(
        system, {"k": 1.0, "c": -1.0}, {"q": 0.1, "v": 0.0}, 60.0, families=rest(system)
    )
    said = run.attrs["evidence"]
    assert run.attrs["outcome"] == "settled" and "rest at k = 1 1/s2" in said
    assert "within 0" not in said and "converges to rest, its deviation" in said
    assert said.endswith("1/s at least")


def test_a_motion_of_a_system_has_no_direction_of_slip() -> None:
    run = st.simulate(oscillator(), {"k": 1.0, "c": -1.0}, {"q": 0.1, "v": 0.0}, 1.0)
    words = json.dumps({str(n): v.attrs for n, v in run.variables.items()}, default=str)
    assert not [w for w in DISK_WORDS if w in words]
    assert isinstance(run, xarray.Dataset) and "event_direction" not in run


def test_figures_of_energy_and_path_say_what_a_system_lacks() -> None:
    half = oscillator(energy=lambda x, p: p[0] * x[0] ** 2 / 2 + x[1] ** 2 / 2)
    run = st.simulate(half, {"k": 1.0, "c": -1.0}, {"q": 0.1, "v": 0.0}, 1.0)
    with pytest.raises(ParameterError, match="beam has no dissipated.*observes energy and power"):
        st.plot_motion(run, show="energy")
    with pytest.raises(ParameterError, match="beam has no contact_x; this figure needs a disk"):
        st.plot_motion(run, show="paths")


def test_a_start_on_a_switch_is_refused_without_an_internal_name() -> None:
    x, p = ca.SX.sym("x"), ca.SX.sym("p")
    system = st.System("os_cill 1%", x, p, ca.fmin(p, x), states=("x",), parameters=("p",))
    with pytest.raises(ValueError, match="at x = 1, p = 1: .* on a switch of a maximum or branch"):
        st.simulate(system, {"p": 1.0}, {"x": 1.0}, 1.0)


# --- tables ---


def test_the_table_of_conditions_has_units_and_counts() -> None:
    family = decay(("gain", "loss"), {"gain": "1/µs"})
    told = "\n".join(lines(st.conditions(family)))
    assert "gain: parameter of tank [1/µs]\n" in told and "loss: parameter of tank\n" in told
    assert "det(λ - A) ~ 1 factor:" in told
    assert r"[1/$\mu$s]" in latex(st.conditions(family))
    assert "has 1 factor." in latex(st.conditions(family))


def test_latex_tells_unicode_names_apart() -> None:
    family = decay(("β", "γ"), name="épidémie")
    told = latex(st.conditions(family))
    assert r"\paragraph{épidémie, empty}" in told
    assert r"$\beta$ &" in told and r"- \beta + \gamma > 0" in told
    assert [symbol(n) for n in ("θ", "x y", "größe", "Ω_1")] == [
        r"\theta",
        r"\text{x y}",
        r"\text{größe}",
        r"\Omega_{1}",
    ]
