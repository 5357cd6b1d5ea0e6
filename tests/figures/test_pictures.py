"""Figures of a motion show its data, its units and its events, and refuse what they cannot."""

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import casadi as ca
import matplotlib
import numpy as np
import pytest
import xarray
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

import stability as st
from stability.base.errors import NameUnknownError, ParameterError
from stability.figures.motion import UNKNOWN, caption

DRY = [1.12, -0.31, 1.18, -1.45, -0.49, 0.46]
LIFTS = [2.2, 0.64, 1.54, 1.44, 0.62, 0.04]
states, paths, energy = (partial(st.plot_motion, show=s) for s in ("states", "paths", "energy"))
FIGURES: tuple[Callable[[xarray.Dataset], Figure], ...] = (states, paths, energy, st.plot_motion)


@pytest.fixture(scope="module")
def dry() -> xarray.Dataset:
    times = np.linspace(0, 10, 201)
    return st.simulate(st.Disk(k=0.3), st.Coulomb(0.15), DRY, times, pose=True)


@pytest.fixture(scope="module")
def coin() -> xarray.Dataset:
    start = {"theta": 1.4, "omega3": 60.0}
    return st.simulate(st.Disk.named("quarter"), st.Viscous(0.3), start, 0.5, pose=True)


@pytest.fixture(scope="module")
def several() -> xarray.Dataset:
    """Neither stays: the first lifts off, the second sticks and slips."""
    disk = st.Disk(k=np.array([0.25, 0.3]))
    law = st.Coulomb(np.array([0.05, 0.15]))
    return st.simulate(disk, law, np.array([LIFTS, DRY]), np.linspace(0, 10, 201), pose=True)


_DRAWN: dict[tuple[int, int], Figure] = {}


def once(draw: Callable[[xarray.Dataset], Figure], run: xarray.Dataset) -> Figure:
    """The figure of a fixture of this module, which nobody changes."""
    key = id(run), id(draw)
    if key not in _DRAWN:
        _DRAWN[key] = draw(run)
    return _DRAWN[key]


def lines(axes: Any) -> dict[str, Any]:
    return {str(line.get_label()): line for line in axes.get_lines()}


def shaded(axes: Any) -> list[tuple[float, float]]:
    found = [p for p in axes.patches if isinstance(p, Rectangle)]
    assert not any(p.get_hatch() for p in found)  # hatching is for verdicts and outcomes
    return [(p.get_x(), p.get_x() + p.get_width()) for p in found]


def words(figure: Figure) -> list[str]:
    return [t.get_text() for t in figure.axes[0].texts if "pi" not in t.get_text()]


def uprights(axes: Any) -> list[float]:
    drawn = [np.asarray(line.get_xdata(), dtype=float) for line in axes.get_lines()]
    return sorted(float(x[0]) for x in drawn if len(x) == 2 and x[0] == x[1])


@pytest.mark.long
def test_the_lines_over_time_are_the_series_of_the_dataset(dry: xarray.Dataset) -> None:
    panels = once(states, dry).axes
    shown = {
        0: ["theta"],
        1: ["theta_dot", "phi_dot", "omega3"],
        2: ["slip_x", "slip_y"],
        3: ["normal_force"],
    }
    for i, names in shown.items():
        for line, name in zip(panels[i].get_lines(), names, strict=False):
            np.testing.assert_array_equal(line.get_xdata(), dry.time)
            np.testing.assert_array_equal(line.get_ydata(), dry[name])


def test_sticking_is_grey_from_stick_to_slip(dry: xarray.Dataset) -> None:
    expected = dry.event_time.values.reshape(-1, 2)
    assert dry.event_kind.values.tolist() == ["stick", "slip"] * 3
    for axes in once(states, dry).axes:
        np.testing.assert_allclose(shaded(axes), expected, rtol=1e-12)


def test_every_event_is_a_line_and_has_its_word(dry: xarray.Dataset) -> None:
    figure = once(states, dry)
    assert sorted(words(figure)) == ["slip"] * 3 + ["stick"] * 3
    for axes in figure.axes:
        np.testing.assert_array_equal(uprights(axes), dry.event_time)


def test_a_run_that_begins_by_sticking_is_grey_from_its_start() -> None:
    start = {"theta": 1.3, "phi_dot": 0.5, "omega3": 1.0}
    run = st.simulate(st.Disk(), st.Coulomb(0.9), start, 1.0)
    assert (run["mode"].values == 1).all() and run.sizes["event"] == 0
    assert shaded(st.plot_motion(run, show="states").axes[0]) == [(0.0, 1.0)]


def test_labels_carry_dimensionless_units(dry: xarray.Dataset) -> None:
    labels = [a.get_ylabel() for a in once(states, dry).axes]
    units = ["[rad]", r"[$\sqrt{g/R}$]", r"[$\sqrt{gR}$]", "[$mg$]"]
    assert all(label.endswith(unit) for label, unit in zip(labels, units, strict=True))
    assert once(states, dry).axes[-1].get_xlabel() == r"time $t$  [$\sqrt{R/g}$]"
    plane, bar = once(paths, dry).axes
    assert plane.get_xlabel() == "$X$  [$R$]" and bar.get_ylabel().endswith(r"[$\sqrt{R/g}$]")
    assert once(energy, dry).axes[0].get_ylabel().endswith("[$mgR$]")


def test_labels_carry_si_units(coin: xarray.Dataset) -> None:
    labels = [a.get_ylabel() for a in once(states, coin).axes]
    assert [label.split("[")[1] for label in labels] == ["rad]", "rad/s]", "m/s]", "N]"]
    plane, bar = once(paths, coin).axes
    assert plane.get_ylabel() == "$Y$  [m]" and bar.get_ylabel() == "time $t$  [s]"
    assert once(energy, coin).axes[0].get_ylabel().endswith("[J]")


def test_the_paths_go_through_the_points_of_the_dataset(dry: xarray.Dataset) -> None:
    axes = once(paths, dry).axes[0]
    found = [c for c in axes.collections if isinstance(c, LineCollection)]
    for collection, name in zip(found, ("contact", "centre"), strict=True):
        first = np.array([piece[0] for piece in collection.get_segments()])
        expected = np.column_stack([dry[f"{name}_x"], dry[f"{name}_y"]])
        np.testing.assert_array_equal(first, expected[:-1])
        colours = collection.get_array()
        assert colours is not None and (np.diff(colours) > 0).all()
    assert axes.get_aspect() == 1


def test_the_contact_path_is_broken_where_it_sticks(dry: xarray.Dataset) -> None:
    gaps = [line for line in once(paths, dry).axes[0].get_lines() if line.get_label() == "gaps"]
    ends = dry.event_time.values.reshape(-1, 2)
    assert len(gaps) == 3 and all(line.is_dashed() for line in gaps)
    for line, pair in zip(gaps, ends, strict=True):
        x = np.asarray(line.get_xdata())
        np.testing.assert_allclose(x[[0, -1]], np.interp(pair, dry.time, dry.contact_x))


def test_the_energy_stacks_to_the_total_at_the_start(dry: xarray.Dataset) -> None:
    stacked = [np.asarray(line.get_ydata()) for line in once(energy, dry).axes[0].get_lines()]
    np.testing.assert_array_equal(stacked[0], dry.potential)
    np.testing.assert_allclose(stacked[1], dry.energy, rtol=1e-14)
    np.testing.assert_allclose(stacked[2], float(dry.energy[0]), rtol=1e-8)


def test_the_audit_is_on_a_log_axis_with_the_tolerance(dry: xarray.Dataset) -> None:
    axes = once(energy, dry).axes[1]
    assert axes.get_yscale() == "log"
    audit = np.abs(dry.audit.values) / float(dry.energy[0])
    shown = np.asarray(lines(axes)["audit"].get_ydata())
    np.testing.assert_array_equal(shown[audit > 0], audit[audit > 0])
    assert audit[0] == 0 and np.isnan(shown[audit == 0]).all()
    assert set(lines(axes)["tolerance of a step"].get_ydata()) == {1e-9}


def test_an_audit_of_zeros_alone_can_be_drawn(dry: xarray.Dataset) -> None:
    low, high = st.plot_motion(dry.assign(audit=0 * dry.audit), show="energy").axes[1].get_ylim()
    assert 0 < low < 1e-9 < high


def test_the_steady_motion_settled_on_is_dotted() -> None:
    run = st.simulate(st.Disk(), st.Viscous(0.3), {"theta": 1.52, "phi_dot": 2.5}, 200.0)
    steady = lines(st.plot_motion(run, show="states").axes[1])["steady"]
    assert steady.get_linestyle() == ":" and set(steady.get_ydata()) == {float(run.nearest_at)}


def test_tumbling_is_dotted_in_both_its_panels(dry: xarray.Dataset) -> None:
    theta, k = 0.8, float(dry.k)
    run = dry.assign(outcome=1, nearest_family="tumbling", nearest_at=theta)
    panels = st.plot_motion(run, show="states").axes
    assert set(lines(panels[0])["steady"].get_ydata()) == {theta}
    rate = -1 / math.sqrt(k * math.sin(theta))
    assert lines(panels[1])["steady"].get_ydata()[0] == pytest.approx(rate)


def test_nothing_is_dotted_where_nothing_was_settled_on(dry: xarray.Dataset) -> None:
    assert "steady" not in lines(once(states, dry).axes[1])


def test_a_slice_is_cut_at_its_end_and_shows_its_own_event(several: xarray.Dataset) -> None:
    figure = st.plot_motion(several.isel(launch=0), show="states")
    times = np.asarray(figure.axes[0].get_lines()[0].get_xdata())
    end = float(several.end_time[0])
    assert times[-1] == end < 1.2 and (np.diff(times) > 0).all()
    assert words(figure) == ["lift-off"] and uprights(figure.axes[1]) == [end]


def test_a_slice_that_lasts_shows_its_own_events(several: xarray.Dataset) -> None:
    figure = st.plot_motion(several.isel(launch=1), show="states")
    own = several.event_time.values[several.event_launch.values == 1]
    assert len(own) == 6
    np.testing.assert_array_equal(uprights(figure.axes[0]), own)


def test_a_slice_without_events_does_not_show_those_of_its_neighbour() -> None:
    """The log has one owner, and it is the other launch."""
    start = np.array([LIFTS, [1.5, 0, 0.1, 0.2, 1.0, 0.5]])
    runs = st.simulate(st.Disk(), st.Coulomb(0.05), start, np.linspace(0, 1.5, 31))
    assert set(runs.event_launch.values) == {0}
    figure = st.plot_motion(runs.isel(launch=1), show="states")
    assert words(figure) == [] and uprights(figure.axes[0]) == []


@pytest.mark.parametrize("draw", [*FIGURES, caption])
def test_several_launches_are_refused_with_the_remedy(
    draw: Callable[[xarray.Dataset], Any], several: xarray.Dataset
) -> None:
    with pytest.raises(ParameterError, match=r"2 launches; take one by \.isel\(launch=i\)"):
        draw(several)


@pytest.mark.parametrize("draw", [*FIGURES, caption])
def test_what_is_no_motion_is_refused(draw: Callable[[Any], Any], dry: xarray.Dataset) -> None:
    with pytest.raises(ParameterError, match=r"dataset is \[1, 2\]"):
        draw([1, 2])
    with pytest.raises(ParameterError, match="fewer than two samples"):
        draw(dry.isel(time=[0]))
    with pytest.raises(ParameterError, match="dataset has no"):
        draw(dry.drop_vars("evidence"))
    with pytest.raises(ParameterError, match="give what simulate returns"):
        draw(xarray.Dataset({"time": [0.0, 1.0]}))


@pytest.mark.long
def test_paths_without_a_pose_are_refused_and_left_out_of_the_page(dry: xarray.Dataset) -> None:
    bare = dry.drop_vars(["centre_x", "centre_y", "contact_x", "contact_y"])
    with pytest.raises(ParameterError, match="pose=True"):
        st.plot_motion(bare, show="paths")
    assert len(st.plot_motion(bare).axes) == 6
    assert len(st.plot_motion(dry).axes) == 8
    assert st.plot_motion(dry).get_figwidth() == 7.0


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("draw", "suffix"),
    [
        (states, "png"),
        (paths, "pdf"),
        (energy, "svg"),
        (st.plot_motion, "png"),
        *(
            pytest.param(d, s, marks=pytest.mark.long)
            for d in FIGURES
            for s in ("png", "pdf", "svg")
        ),
    ],
)
def test_every_figure_can_be_saved(
    draw: Callable[[xarray.Dataset], Figure], suffix: str, coin: xarray.Dataset, tmp_path: Path
) -> None:
    with matplotlib.rc_context({"svg.hashsalt": "same"}):
        once(draw, coin).savefig(tmp_path / f"figure.{suffix}")
    assert (tmp_path / f"figure.{suffix}").stat().st_size > 5000


def test_the_caption_says_what_was_computed_and_what_came_of_it(
    dry: xarray.Dataset, coin: xarray.Dataset
) -> None:
    text = caption(dry)
    for part in (
        "coulomb contact",
        "k = 0.3",
        "μ = 0.15",
        "theta = 1.12",
        "tolerance 1e-09",
        str(dry.method.values),
        "Outcome: moving",
        str(dry.evidence.values),
    ):
        assert part in text
    assert "R = 0.01213 m" in caption(coin) and "μ = 0.3 s/m" in caption(coin)


# --- samples that draw a run, what is not known, and what a note holds ---


def test_a_run_that_ends_early_is_sampled_up_to_its_end() -> None:
    """It ends after 3 of the 201 evenly spaced times that were drawn as a zig-zag."""
    start = {"theta": 1.0, "theta_dot": -0.2}
    run = st.simulate(st.Disk(), st.Smooth(), start, 100.0)
    end = float(run.end_time)
    assert run.attrs["outcome"] == "flat" and end < 2.0
    assert run.time.values == pytest.approx(np.linspace(0, end, 201), rel=1e-12, abs=0)
    asked = [*run.time.values[:-1], 100.0]
    other = st.simulate(st.Disk(), st.Smooth(), start, asked)
    for name in ("theta", "theta_dot", "normal_force"):
        assert run[name].values == pytest.approx(other[name].values, rel=1e-6, abs=1e-7)
    assert float(other.end_time) == pytest.approx(end, rel=1e-12)
    # times that the user gives stay as they are
    assert st.simulate(st.Disk(), st.Smooth(), start, np.linspace(0, 100, 201)).time.size < 5


def test_a_path_is_drawn_without_corners() -> None:
    """60 rad/s for 3 s: three turns of the path in four samples before."""
    coin = st.Disk(mass=0.0058, radius=0.012125, gravity=9.81)
    run = st.simulate(coin, st.Viscous(3.0), {"theta": 1.2, "phi_dot": 60.0}, 3.0, pose=True)
    steps = np.diff(run.contact_x.values + 1j * run.contact_y.values)
    turns = np.abs(np.angle(steps[1:] / steps[:-1]))
    assert np.quantile(turns, 0.99) < 0.15 and run.time.size < 4000
    assert (np.diff(run.time) > 0).all() and float(run.time[-1]) == 3.0
    drawn = st.plot_motion(run, show="paths").axes[0].collections[0]
    assert len(drawn.get_array()) == run.time.size - 1  # type: ignore[arg-type]


def test_the_note_of_a_motion_holds_every_law_and_number() -> None:
    coin = st.Disk(mass=0.0058, radius=0.012125, gravity=9.81)
    against = [st.RollingResistance(1e-5), st.PivotingResistance(2e-5), st.AirTorque(3e-9)]
    run = st.simulate(coin, st.Viscous(0.3), {"theta": 1.2}, 0.1, resistance=against)
    note = st.plot_motion(run, show="states").texts[-1].get_text().replace("\n", " ")
    for words in (
        r"rolling resistance $\rho$ = 1e-05 m s",
        r"pivoting resistance $\sigma$ = 2e-05 m s",
        "air torque $d$ = 3e-09 N m s",
        r"$\mu$ = 0.3 s/m",
    ):
        assert words in note
    assert "rolling resistance rho = 1e-05 m s" in caption(run)


def lorenz(times: Any, **settings: Any) -> Any:
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p")
    rates = (10 * (x[1] - x[0]), x[0] * (p - x[2]) - x[1], x[0] * x[1] - 8 / 3 * x[2])
    system = st.System(
        "Lorenz", x, p, ca.vertcat(*rates), states=("x", "y", "z"), parameters=("r",)
    )
    start = {"x": 1, "y": 1, "z": 1}
    return st.simulate(system, start=start, times=times, r=28, **settings)


def test_a_motion_fades_where_it_is_not_known() -> None:
    with pytest.warns(st.StabilityWarning, match="the error of the final state has no bound"):
        run = lorenz(60.0)
    known = float(run.trusted_time)
    assert 15 < known < 45
    axes = st.plot_motion(run, show="states").axes
    for panel in axes:
        [veil] = [p for p in panel.patches if p.get_alpha()]
        assert veil.get_x() == known and veil.get_x() + veil.get_width() == 60.0
    assert UNKNOWN in [t.get_text() for t in axes[-1].texts]
    assert f"Faded after {known:.4g}: runs within the tolerance part there." in caption(run)
    # a finer run from the same start parts from it after that time, and not before
    finer = lorenz(run.time.values, tolerance=1e-13, check=False)
    apart = np.abs(run.x.values - finer.x.values)
    assert apart[run.time.values < 0.9 * known].max() < 1 < apart[run.time.values > known].max()
    short = lorenz(5.0)
    assert float(short.trusted_time) == 5.0
    patches = [p for a in st.plot_motion(short, show="states").axes for p in a.patches]
    assert not [p for p in patches if p.get_alpha()]


def test_series_of_a_motion_are_those_that_are_asked_for() -> None:
    run = st.simulate(st.Disk(), st.Viscous(0.3), {"theta": 1.2, "phi_dot": 1.0}, 5.0)
    axes = st.plot_motion(run, show="states", series=("theta", "power")).axes
    assert [a.get_ylabel().split("\n")[0] for a in axes] == ["theta", "power"]
    np.testing.assert_array_equal(axes[1].get_lines()[0].get_ydata(), run.power.values)
    with pytest.raises(NameUnknownError, match="series names 'energi'; the dataset has theta, "):
        st.plot_motion(run, series=["energi"])
    with pytest.raises(ParameterError, match="series is 'theta'; give a list of names"):
        st.plot_motion(run, series="theta")
