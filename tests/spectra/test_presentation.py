"""Spectra for a reader: text, HTML, labelled datasets, reasons, figures, and names in calls."""

import enum
import html.parser
import inspect
import json
import re
from pathlib import Path
from typing import Any

import casadi as ca
import h5py
import numpy as np
import pytest
from figure_audit import faults
from matplotlib.figure import Figure

import stability as st
from stability.base.lazy import HOMES
from stability.cli.commands import main

LAW = st.Viscous(0.3)


def oscillator(
    names: tuple[str, str] = ("k", "c"),
    units: dict[str, str] | None = None,
    states: tuple[str, str] = ("q", "v"),
) -> Any:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    rates = ca.vertcat(x[1], -p[0] * x[0] - p[1] * x[1])
    system = st.System(
        "oscillator", x, p, rates, states=states, parameters=names, units=units or {}
    )
    return st.Family(system, "rest", at=(names[0],), held=dict.fromkeys(states, 0.0))


# --- text ---


def test_repr_shows_every_eigenvalue_and_its_unit() -> None:
    assert repr(st.spectrum(oscillator(units={"v": "m/s"}), at=25.0, c=6.0)) == (
        "<Spectrum of rest at k = 25: stable; 2 eigenvalues [1/s]: -3 ± 4i>"
    )
    found = st.spectrum("rolling", at=1.8, contact=LAW)
    said = repr(found)
    law = "viscous contact (F = -μ N v), mu = 0.3 1/√(gR)"
    assert f"at omega3 = 1.8 √(g/R), {law}: stable" in said and "[√(g/R)]" in said
    body = repr(st.spectrum("rolling", at=1.8, contact=LAW, body=st.Torus(0.2)))
    assert f"at omega3 = 1.8 √(g/R), {law}: stable" in body
    coin = st.spectrum("rolling", at=90.0, contact=LAW, disk=st.Disk.named("quarter"))
    assert "at omega3 = 90 rad/s, viscous contact (F = -μ N v), mu = 0.3 s/m: " in repr(coin)
    assert "viscous contact (F = -μ N v), " in coin._repr_html_()
    given = [float(v) for v in re.findall(r"[-+]?\d+\.\d+(?=[,> ])", said.split("[√(g/R)]: ")[1])]
    assert np.allclose(given, found.eigenvalues.real[:3], rtol=1e-5)  # a pair has one entry


def test_repr_of_many_counts_verdicts() -> None:
    said = repr(st.spectrum(oscillator(), at=1.0, c=np.array([-1.0, -0.5, 0.5])))
    assert "3 points: 2 unstable, 1 stable; 2 eigenvalues each" in said
    assert "from -0.25 to 0.5" in said


class Cells(html.parser.HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.rows: list[list[str]] = []
        self.open: list[str] = []

    def handle_starttag(self, tag: str, attrs: Any) -> None:  # noqa: ARG002
        self.open.append(tag)
        if tag == "tr":
            self.rows.append([])

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] == "td":
            self.rows[-1].append(data)


@pytest.mark.parametrize("at", [1.8, [1.2, 1.8]])
def test_html_is_a_table_with_a_row_for_each_eigenvalue_or_point(at: Any) -> None:
    spectrum = st.spectrum("rolling", at=at, contact=LAW)
    page = Cells()
    page.feed(spectrum._repr_html_())
    assert not page.open
    rows = page.rows[1:]
    if np.ndim(at):
        assert [r[1] for r in rows] == [v.word for v in spectrum.verdict]
    else:
        assert [float(r[0]) + 1j * float(r[1]) for r in rows] == pytest.approx(
            spectrum.eigenvalues.tolist(), rel=1e-5
        )
        assert [r[3] for r in rows] == list(spectrum.modes.labels)


def test_html_takes_a_users_names_as_text() -> None:
    family = oscillator(("<b>", "c&"), states=("<q>", "</td>"))
    page = Cells()
    page.feed(st.spectrum(family, at=1.0, **{"c&": 1.0})._repr_html_())
    assert not page.open and page.rows[1][3].endswith("of <q>, </td>")


def test_reasons_of_an_array_are_those_of_its_points() -> None:
    at = np.array([[1.2, np.sqrt(2)], [1.5, 1.8]])
    many = st.spectrum("rolling", at=at, contact=LAW)
    assert many.reason.shape == (2, 2)
    for index in np.ndindex(2, 2):
        assert many.reason[index] == st.spectrum("rolling", at=at[index], contact=LAW).reason
    assert len(set(many.reason.flat)) == 4 and "double precision left it open" in many.reason[0, 1]


def test_frequencies_are_the_imaginary_parts_without_sign() -> None:
    found = st.spectrum(oscillator(), at=[25.0, 5.0], c=6.0).frequencies
    assert np.allclose(found, [[4, 4], [0, 0]], atol=1e-12)


def test_every_mode_says_whether_it_grows_or_decays() -> None:
    for at, c in ((25.0, -6.0), (25.0, 6.0), (-1.0, 0.0), (25.0, 0.0), (0.0, 1.0)):
        spectrum = st.spectrum(oscillator(), at=at, c=c)
        for value, label in zip(spectrum.eigenvalues, spectrum.modes.labels, strict=True):
            assert (value.real > 0) == label.startswith("growing "), label
            assert (value.real < 0) == label.startswith("decaying "), label


# --- datasets ---


def test_a_dataset_has_names_units_numbers_and_provenance() -> None:
    disk = st.Disk(mass=1.0, radius=0.2, gravity=9.81)
    spectrum = st.spectrum(
        "spinning", at=np.array([[8.0], [9.0], [14.0]]), disk=disk, contact=st.Viscous([0.3, 0.4])
    )
    data = spectrum.to_xarray()
    assert data.eigenvalues.dims == ("at", "mu", "mode")
    assert data.at.attrs["long_name"] == "precession rate" and data.at.attrs["units"] == "rad/s"
    assert data.radius.attrs["units"] == "m" and data.eigenvalues.attrs["units"] == "1/s"
    assert np.array_equal(data.eigenvalues, spectrum.eigenvalues)
    assert np.array_equal(data.error_radius, spectrum.radius)
    assert np.array_equal(data.sel(at=9.0, mu=0.4).abscissa, spectrum.abscissa[1, 1])
    words = data.verdict.attrs["flag_meanings"].split()
    assert [words[c] for c in data.verdict.values.flat] == [v.word for v in spectrum.verdict.flat]
    assert data.attrs["contact"] == "viscous" and st.Verdict(data.verdict.values[0, 0])
    assert json.loads(data.attrs["parameters"])["radius"] == 0.2


@pytest.mark.parametrize(
    ("given", "dims"),
    [
        ({"at": 1.0, "c": 2.0}, ()),
        ({"at": [1.0, 2.0], "c": 2.0}, ("k",)),
        ({"at": [1.0, 2.0], "c": [2.0, 3.0]}, ("point",)),
        ({"at": [[1.0], [2.0]], "c": [[2.0, 3.0], [4.0, 5.0]]}, ("k", "point_1")),
        ({"at": [[1.0], [2.0]], "c": [2.0, 3.0]}, ("k", "c")),
    ],
)
def test_an_axis_has_the_name_of_the_one_quantity_along_it(given: Any, dims: Any) -> None:
    data = st.spectrum(oscillator(), **given).to_xarray()
    assert data.abscissa.dims == dims
    for name, value in (("k", given["at"]), ("c", given["c"])):
        assert np.array_equal(data[name].squeeze(), np.squeeze(value))


@pytest.mark.few(2)
@pytest.mark.parametrize("certify", [False, True])
@pytest.mark.parametrize("at", [1.8, [1.2, 1.8]])
def test_a_dataset_survives_a_file(tmp_path: Path, at: Any, certify: bool) -> None:
    data = st.spectrum("rolling", at=at, contact=LAW, certify=certify).to_xarray()
    path = st.write_map(data, tmp_path / "s.nc")
    assert st.read_map(path).identical(data)
    with h5py.File(path) as file:  # by another reader
        parts = np.asarray(file["eigenvalues"])
        assert np.array_equal(parts[..., 0] + 1j * parts[..., 1], data.eigenvalues)
        assert "axial" in str(file["at"].attrs["long_name"])


def test_a_parameter_with_the_name_of_a_variable_gets_another() -> None:
    data = st.spectrum(oscillator(("mode", "verdict")), at=[1.0, 2.0], verdict=1.0).to_xarray()
    assert data.abscissa.dims == ("parameter_mode",) and float(data.parameter_verdict) == 1.0


def test_plot_draws_the_loci() -> None:
    spectrum = st.spectrum("rolling", at=[1.2, 1.8], contact=LAW)
    top = spectrum.plot(title="here").axes[0]
    assert top.get_title() == "here" and "growth rate" in top.get_ylabel()


@pytest.mark.long
def test_a_single_spectrum_is_drawn_in_the_plane_with_its_verdict() -> None:
    spectrum = st.spectrum("rolling", at=1.8, contact=LAW)
    figure = spectrum.plot()
    [axes] = figure.axes
    assert axes.get_title() == "rolling: stable"
    assert axes.get_xlabel() == "growth rate Re $\\lambda$  [$\\sqrt{g/R}$]"
    spots = [line.get_xydata() for line in axes.lines if line.get_marker() == "o"]
    drawn = {complex(*spot) for xy in spots for spot in np.asarray(xy)}
    assert drawn == set(spectrum.eigenvalues.tolist())
    entries = [text.get_text() for text in axes.get_legend().get_texts()]
    assert entries[0] == "1: decaying, $v_x$" and entries[-1] == "2 zeros by structure"
    assert "k$ = 0.25" in figure.texts[-1].get_text()
    assert faults(figure) == []
    row = st.spectrum("rolling", at=[1.8], contact=LAW).plot(title="here")
    assert row.axes[0].get_title() == "here: stable"
    with pytest.raises(st.StabilityError, match="ax holds 2 axes; a single spectrum is drawn on"):
        spectrum.plot(ax=Figure().subplots(2))
    with pytest.raises(st.StabilityError, match="thresholds belongs to a spectrum along a"):
        spectrum.plot(thresholds=[1.0])
    with pytest.raises(st.StabilityError, match=r"has shape \(1, 2\); give a single one, or one"):
        st.spectrum("rolling", at=[[1.2, 1.8]], contact=LAW).plot()


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("at", "c", "markers", "scale"),
    [
        (25.0, -6.0, "^", "linear"),
        (25.0, 0.0, "D", "linear"),
        (-1.0, 0.0, "o^", "linear"),
        (1e-4, 10.0, "o", "asinh"),
        (0.0, 1.0, "Do", "linear"),
    ],
)
def test_a_marker_says_what_a_mode_does_and_no_rate_lies_on_the_axis_unseen(
    at: float, c: float, markers: str, scale: str
) -> None:
    figure = st.spectrum(oscillator(), at=at, c=c).plot()
    [axes] = figure.axes
    found = {str(line.get_marker()) for line in axes.lines} - {"None", "+"}
    assert found == set(markers)
    assert axes.get_xscale() == scale
    assert faults(figure) == []
    low, high = axes.get_xlim()
    assert low < 0 < high
    (left, _), (zero, _), (right, _) = (axes.transData.transform((x, 0)) for x in (low, 0, high))
    assert min(zero - left, right - zero) > 0.1 * (right - left)


# --- names in calls ---


def test_a_law_is_given_by_name_class_or_instance() -> None:
    asked: list[dict[str, Any]] = [
        {"contact": "viscous", "mu": 0.3},
        {"contact": st.Viscous, "mu": 0.3},
        {"mu": 0.3},
    ]
    plain = st.spectrum("rolling", at=1.8, contact=LAW)
    for words in asked:
        assert st.spectrum("rolling", at=1.8, **words) == plain
        found = st.boundaries("rolling", axis=("at", 1, 2, 5), **words)
        assert found == st.boundaries("rolling", axis=("at", 1, 2, 5), contact=LAW) and len(found)
        start = {"theta": 1.5, "omega3": 1.0}
        run = st.simulate(start=start, times=1.0, **words)
        assert run.theta.identical(st.simulate(st.Disk(), LAW, start, 1.0).theta)
    one = st.stability_map("rolling", x=("at", 1, 2, 3), y=("mu", 1, 2, 3), contact="viscous")
    own = st.stability_map("rolling", x=("omega3", 1, 2, 3), y=("mu", 1, 2, 3)).abscissa
    assert one.abscissa.equals(own) and "omega3" in one.coords  # two names for one number


SPINS = {"x": ("at", 1, 3, 4), "y": ("k", 0.2, 0.3, 3)}
TILTS = {"x": ("theta", 1.3, 1.5, 2), "y": ("phi_dot", 0.5, 1.0, 2)}
CALLS: dict[str, Any] = {
    "spectrum": lambda **law: st.spectrum("rolling", at=1.8, **law),
    "boundaries": lambda **law: st.boundaries("rolling", axis=("at", 1, 2, 5), **law),
    "hopf": lambda **law: st.hopf("spinning", **law),
    "drift": lambda **law: st.drift(at=1.8, tilt=0.01, **law),
    "codimension_two": lambda **law: st.codimension_two("spinning", **SPINS, **law),
    "stability_map": lambda **law: st.stability_map("spinning", **SPINS, **law).abscissa,
    "stream_map": lambda **law: st.stream_map("spinning", **SPINS, **law),
    "simulate": lambda **law: st.simulate(start={"theta": 1.5}, times=1.0, **law).theta,
    "Scene": lambda **law: st.Scene(start={"theta": 1.5}, horizon=1.0, **law),
    "basins": lambda **law: st.basins(**TILTS, horizon=1.0, **law).end_time,
    "launch_labels": lambda **law: st.launch_labels(varied=("theta",), horizon=1.0, **law)(
        np.array([[1.5], [1.2]])
    ).tolist(),
}
"""A call of every public name that takes a contact law."""


def test_every_function_that_takes_a_law_is_called_here() -> None:
    named = {name: getattr(st, name) for name in HOMES}
    no_call = (enum.Enum, Exception)
    takes = {
        name
        for name, one in named.items()
        if callable(one)
        and not (isinstance(one, type) and issubclass(one, no_call))
        and "contact" in inspect.signature(one).parameters
    }
    # a table takes the name alone, with mu as numbers of its rows; on a page mu is a slider;
    # slow_flow is for other bodies; numbers of a law stay variables of conditions and formulas
    assert takes == {*CALLS, "conditions", "explore", "latex", "slow_flow", "table"}


@pytest.mark.few(5)
@pytest.mark.parametrize("name", CALLS)
def test_a_law_by_name_or_class_gives_what_the_law_gives(name: str, tmp_path: Path) -> None:
    def result(**law: Any) -> Any:
        if name != "stream_map":
            return CALLS[name](**law)
        path = CALLS[name](**law, out=tmp_path / "map.nc", overwrite=True)
        return st.read_map(path).verdict

    plain = result(contact=LAW)
    for law in ("viscous", st.Viscous):
        found = result(contact=law, mu=0.3)
        assert found.equals(plain) if hasattr(plain, "equals") else found == plain
    with pytest.raises(st.StabilityError, match="mu is missing; give Viscous"):
        result(contact="viscous")
    with pytest.raises(st.StabilityError, match="mu is given, and contact is Viscous"):
        result(contact=LAW, mu=0.3)


@pytest.mark.parametrize(
    ("words", "part"),
    [
        ({"contact": "viscous"}, "give Viscous(mu), or contact='viscous' with mu="),
        ({"contact": "viscos", "mu": 1}, "known are smooth, viscous"),
        ({"contact": LAW, "mu": 1}, "mu is given, and contact is Viscous(mu=0.3)"),
        ({"contact": "rough", "mu": 1}, "mu is given, and contact is Rough()"),
        ({"contact": "viscous", "mu": -1}, "friction must be positive"),
    ],
)
def test_a_law_that_is_named_wrongly_is_refused_with_the_spelling(words: Any, part: str) -> None:
    with pytest.raises(st.StabilityError, match=re.escape(part)):
        st.spectrum("rolling", at=1.8, **words)
    with pytest.raises(st.StabilityError, match=re.escape(part)):
        st.simulate(start={"theta": 1.5}, times=1.0, **words)


@pytest.mark.parametrize(
    ("family", "own", "low"),
    [("rolling", "omega3", 1), ("spinning", "phi_dot", 1), ("tumbling", "theta", 0.5)],
)
def test_an_axis_takes_the_members_own_name(family: str, own: str, low: float) -> None:
    one, two = (
        st.boundaries(family, axis=(n, low, 1.5, 5), contact=st.Viscous(0.97)) for n in ("at", own)
    )
    assert one == two
    with pytest.raises(st.StabilityError, match=f"at is missing; .* family, here {own}"):
        st.spectrum(family, contact=LAW)
    part = f"axis is 'omga3'; known for {family} are at, {own}"
    with pytest.raises(st.StabilityError, match=part):
        st.stability_map(family, x=("omga3", 1, 2, 3), y=("mu", 1, 2, 3))
    with pytest.raises(st.StabilityError, match="axis is 'nu'"):  # before mu, which is missing too
        st.stability_map(family, x=(own, 1, 2, 3), y=("nu", 1, 2, 3))


def test_a_users_axis_may_be_called_at() -> None:
    one, two = (st.boundaries(oscillator(), axis=(n, -1, 2, 5), c=1.0) for n in ("at", "k"))
    assert one == two and len(one) == 1 and one.searched == ("k", -1.0, 2.0)


def test_simulate_takes_a_systems_parameters_by_name() -> None:
    system, start = oscillator().system, {"q": 1.0, "v": 0.0}
    by_name = st.simulate(system, start=start, times=1.0, k=4.0, c=0.5)
    assert by_name.q.identical(st.simulate(system, {"k": 4.0, "c": 0.5}, start, 1.0).q)
    for wrong in ({"k": 4.0}, {"k": 4.0, "c": 1.0, "z": 1.0}):
        with pytest.raises(st.StabilityError, match="parameters"):
            st.simulate(system, start=start, times=1.0, **wrong)
    with pytest.raises(st.StabilityError, match="give all in one place"):
        st.simulate(system, {"k": 4.0}, start, 1.0, c=0.5)
    with pytest.raises(st.StabilityError, match="start is missing"):
        st.simulate(system, times=1.0, k=4.0, c=0.5)
    with pytest.raises(st.StabilityError, match="times is missing"):
        st.simulate(system, start=start, k=4.0, c=0.5)


def test_branch_takes_numbers_by_name() -> None:
    family = st.disk_family("tumbling", "viscous")
    in_order = st.branch(family, 1.5, 0.5, [0.25, 0.3], points=5)
    assert in_order == st.branch(family, 1.5, 0.5, k=0.25, mu=0.3, points=5)
    assert in_order == st.branch(family, 1.5, 0.5, {"mu": 0.3, "k": 0.25}, points=5)
    for words, part in (({"k": 0.25}, "mu is missing"), ({"z": 1.0}, "parameter is 'z'")):
        with pytest.raises(st.StabilityError, match=part):
            st.branch(family, 1.5, 0.5, points=5, **words)
    with pytest.raises(st.StabilityError, match="k is given by name and in parameters"):
        st.branch(family, 1.5, 0.5, [0.25, 0.3], points=5, k=0.25)
    with pytest.raises(st.StabilityError, match="family is 'tumbling'; give a"):
        st.branch("tumbling", 1.5, 0.5, k=0.25, mu=0.3)  # type: ignore[arg-type]


# --- messages ---


@pytest.mark.parametrize(
    "ask",
    [
        lambda: st.drift(at=1.5, tilt=85, contact=LAW),
        lambda: st.launch("rolling", at=1.2, tilt=85),
        lambda: st.launch("tumbling", at=85, disk=st.Disk()),
        lambda: st.simulate(st.Disk(), LAW, {"theta": 85}, 10.0),
        lambda: st.spectrum("tumbling", at=[1.0, 85], contact=LAW),
        lambda: st.spectrum("tumbling", lean=85, contact=LAW),
        lambda: st.spectrum("circling", at=[85, 1.0], contact=st.Rough()),
        lambda: st.stability_map("tumbling", x=("theta", 1, 85, 4), y=("mu", 1, 2, 3)),
        lambda: st.boundaries("tumbling", axis=("lean", 0, 85, 4), contact=LAW),
    ],
)
def test_degrees_are_guessed(ask: Any) -> None:
    with pytest.raises(st.StabilityError, match=r"85 degrees are 1\.48353") as told:
        ask()
    assert "…" not in str(told.value)  # nothing is cut out


def test_an_angle_that_is_only_a_little_out_of_range_is_not_called_degrees() -> None:
    with pytest.raises(st.StabilityError) as told:
        st.launch("rolling", at=1.2, tilt=1.6)
    assert "degrees" not in str(told.value)


def test_the_command_line_points_to_at_and_bare_prints_help(capsys: Any) -> None:
    for word in ("--omega3", "--omega3=1.8", "--phi-dot", "--theta"):
        assert main_code(["spectrum", "rolling", word, "1.8", "--mu", "0.3"]) == 2
        assert "--at takes " + word[2:].split("=")[0].replace("-", "_") in capsys.readouterr().err
    assert main_code([]) == 0
    assert "usage: stability" in capsys.readouterr().out
    words = ["--x", "omega3:1:a:3", "--y", "mu:1:2:3", "--out", "m.nc"]
    assert main_code(["map", "rolling", *words]) == 2
    assert "'omega3:1:a:3'" in capsys.readouterr().err


def test_overwriting_has_one_word(tmp_path: Path, capsys: Any) -> None:
    words = ["map", "rolling", "--x", "omega3:1:2:2", "--y", "mu:1:2:2", "--out"]
    target = str(tmp_path / "m.nc")
    assert main_code([*words, target]) == 0
    assert main_code([*words, target]) == 2
    assert "--overwrite (overwrite=True)" in capsys.readouterr().err
    for word in ("--overwrite", "--force"):
        assert main_code([*words, target, word]) == 0


def main_code(words: list[str]) -> int:
    try:
        return main(words)
    except SystemExit as end:
        return int(end.code or 0)
