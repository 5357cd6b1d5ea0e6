"""A family of the disk is one record: two more records go through every table and command.

`edge-on` is spinning under a name of its own; `coning` is tumbling named by its precession rate.
Neither has a stored polynomial.  The oracles share no code with the package: spectra to 25 digits,
Newton's and Euler's laws in fixed axes, a motion by quaternions.
"""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import kane_disk
import numpy as np
import pytest
import reference
from numpy.typing import NDArray
from proofs import stored as kept
from proofs.disk_polynomials import derive

import stability as st
from stability.algebra.upright import UPRIGHT
from stability.base.errors import StabilityError
from stability.bodies.families import FAMILIES, SteadyFamily
from stability.cli import main
from stability.tables.registry import definition

EDGE_ON = SteadyFamily(
    "edge-on",
    ("phi_dot",),
    held={"theta": UPRIGHT},
    unknown={"omega3": 0.0},
    motion="on its edge, turning on the spot",
    symbols="θ = π/2",
    searched=(0.1, 5.0),
    drawn=(0.5, 3.0),
    flutter=(0.1, 10.0),
    sampled=(0.5, 3.0),
)
CONING = SteadyFamily(
    "coning",
    ("phi_dot",),
    held={"omega3": 0.0},
    unknown={"theta": 0.7},
    motion="inclined, its axis on a cone",
    searched=(2.05, 4.0),
    flutter=(1.7, 8.0),
    solution=lambda functions, at, k, unit: functions.asin(unit * unit / (k * at * at)),
)
# where the graph is not rational the axis is scanned, and a warning says so
pytestmark = pytest.mark.filterwarnings("ignore::stability.StabilityWarning")
OF = {"edge-on": "spinning", "coning": "tumbling"}
"""What the package calls the same motions."""


@pytest.fixture(params=[EDGE_ON, CONING], ids=lambda record: record.name)
def family(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """The name of one more record in the table."""
    record: SteadyFamily = request.param
    monkeypatch.setitem(FAMILIES, record.name, record)
    return record.name


def member(family: str, at: float, k: float) -> list[float]:
    """The six states, from the definition of the motion."""
    theta = math.pi / 2 if family == "edge-on" else math.asin(1 / (k * at * at))
    return [theta, 0, at, 0, 0, 0]


def eigenvalues(family: str, at: float, k: float, mu: float) -> NDArray[np.complex128]:
    """Without the one that is zero, from Newton's and Euler's laws in fixed axes."""
    x, step = np.array(member(family, at, k)), 1e-6 * np.eye(6)
    ends = [kane_disk.fixed_axes("viscous", x + s * step, (k, mu)).rates for s in (1, -1)]
    found = np.linalg.eigvals((ends[0] - ends[1]).T / 2e-6)
    return np.sort_complex(found[np.argsort(abs(found))[1:]])


def given(family: str) -> list[tuple[dict[str, Any], float]]:
    """Spectra to 25 digits of the same motions, with what names each here."""
    found = [e for e in reference.spectra() if e["family"] == OF[family]]
    if family == "edge-on":
        return [(e, e["at"]) for e in found]
    return [(e, 1 / math.sqrt(e["k"] * math.sin(e["at"]))) for e in found if e["at"] > 0.1]


@pytest.mark.parametrize("certify", [False, True])
def test_spectra_are_those_to_25_digits(family: str, certify: bool) -> None:
    for known, at in given(family):
        disk, contact = st.Disk(k=known["k"]), st.Viscous(known["mu"])
        mine = st.spectrum(family, at=at, disk=disk, contact=contact, certify=certify)
        values = [float(re) + 1j * float(im) for re, im in known["eigenvalues"]]
        assert mine.structural_zeros == known["structural_zeros"]
        assert np.abs(mine.eigenvalues - np.sort_complex(values)).max() < 1e-9 * known["mu"] + 1e-9
        assert (mine.verdict is st.Verdict.STABLE) == known["stable"]


@pytest.mark.few(1)
@pytest.mark.parametrize("disk", [st.Disk(), st.Disk(mass=2.0, radius=0.3, gravity=9.81)])
def test_boundaries_are_where_the_rates_in_fixed_axes_turn(family: str, disk: st.Disk) -> None:
    rate, speed = float(np.asarray(disk.rate)), float(np.asarray(disk.speed))
    mu = 0.97 if family == "edge-on" else 1.5
    low, high = (0.5, 3.0) if family == "edge-on" else (2.05, 4.0)
    axis, contact = ("at", low * rate, high * rate, 40), st.Viscous(mu / speed)
    found = st.boundaries(family, axis=axis, disk=disk, contact=contact)
    assert len(found) == (2 if family == "edge-on" else 1)
    for boundary in found:
        at = boundary.value / rate
        tops = [eigenvalues(family, at * (1 + s), 0.25, mu).real.max() for s in (-1e-3, 1e-3)]
        assert (tops[0] < 0) == boundary.stable_below
        assert tops[0] * tops[1] < 0
    if family == "edge-on":  # Przybylska & Rauch-Wojciechowski 2016: k phi_dot² = 1
        assert found[0].value == pytest.approx(2 * rate, rel=1e-12)


def test_maps_have_the_verdicts_of_fixed_axes(family: str) -> None:
    low = 1.1 if family == "edge-on" else 2.1
    found = st.stability_map(family, x=("at", low, 4.0, 9), y=("mu", 0.1, 4.0, 5), disk=st.Disk())
    assert "AD Jacobian" in found.attrs["method"]
    seen = set()
    for i, mu in enumerate(found.mu.values):
        for j, at in enumerate(found["at"].values):
            top = eigenvalues(family, at, 0.25, mu).real.max()
            assert float(found.abscissa[i, j]) == pytest.approx(top, abs=1e-6)
            word = found.verdict.attrs["flag_meanings"].split()[int(found.verdict[i, j])]
            assert word == ("stable" if top < 0 else "unstable")
            seen.add(word)
    assert seen == {"stable", "unstable"}


def test_a_launch_settles_on_it(family: str) -> None:
    if family == "edge-on":
        motion = reference.trajectories()[2]
        disk, mu = st.Disk(k=motion["k"]), motion["mu"]
        start = st.launch("edge-on", at=2.5, tilt=0.05)
        assert start.tolist() == motion["start"]
        run = st.simulate(disk, st.Viscous(mu), start, [0.0, *motion["times"], 400.0])
        for i, state in enumerate(motion["states"], start=1):
            assert float(run.phi_dot[i]) == pytest.approx(state[2], abs=1e-7)
        end = motion["states"][-1][2]
    else:
        disk, mu, end = st.Disk(k=0.25), 0.3, 3.0
        start = st.launch("coning", at=end, tilt=0.02, disk=disk)
        assert start[:3].tolist() == [math.asin(4 / end**2) - 0.02, 0, end]
        run = st.simulate(disk, st.Viscous(mu), start, [0.0, 2000.0])
    assert run.attrs["outcome"] == "settled"
    assert str(run.nearest_family.values) == family
    at = float(run.nearest_at)
    assert at == pytest.approx(end, abs=0.1 if family == "coning" else 1e-4)
    assert eigenvalues(family, at, 0.25, mu).real.max() < 0
    last = [float(run[n][-1]) for n in ("theta", "theta_dot", "phi_dot", "omega3")]
    assert last == pytest.approx(member(family, at, 0.25)[:4], abs=2e-3)


@pytest.mark.parametrize("name", ["coning", "tumbling"])
def test_the_mirror_image_settles_too(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    if name == "coning":
        monkeypatch.setitem(FAMILIES, "coning", CONING)
    at = 3.0 if name == "coning" else math.asin(4 / 9)
    start = st.launch(name, at=at, tilt=0.02, disk=st.Disk()) * [1, 1, -1, 1, 1, 1]
    run = st.simulate(st.Disk(), st.Viscous(0.3), start, [0.0, 2000.0])
    assert run.attrs["outcome"] == "settled"
    assert str(run.nearest_family.values) == name
    assert float(run.nearest_at) == pytest.approx(-3.0 if name == "coning" else at, abs=0.1)
    assert float(run.phi_dot[-1]) == pytest.approx(-3.0, abs=0.1)


def test_a_launch_has_the_units_of_the_disk(family: str) -> None:
    disk = st.Disk(k=0.4, mass=2.0, radius=0.3, gravity=9.81)
    rate = math.sqrt(9.81 / 0.3)
    start = st.launch(family, at=2.5 * rate, tilt=0.0, disk=disk)
    assert start == pytest.approx(np.array(member(family, 2.5, 0.4)) * [1, 0, rate, 0, 0, 0])


def test_the_command_line_takes_it(family: str, capsys: pytest.CaptureFixture[str]) -> None:
    known, at = given(family)[0]
    words = ["--at", repr(at), "--mu", str(known["mu"]), "--k", str(known["k"])]
    assert main(["spectrum", family, *words, "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    top = max(float(re) for re, _ in known["eigenvalues"])
    assert record["abscissa"] == pytest.approx(top, abs=1e-9)
    with pytest.raises(SystemExit):
        main(["spectrum", "--help"])
    assert family in capsys.readouterr().out
    assert main(["spectrum", family, *words[2:], "--lean", "0.1"]) == 2
    assert "lean names a member of tumbling" in capsys.readouterr().err


@pytest.mark.long
def test_tables_hold_it(family: str) -> None:
    [row] = [r for r in definition("families").rows() if r["family"] == family]
    assert (row["at"], row["motion"]) == ("phi_dot", FAMILIES[family].motion)
    if family == "coning":
        assert row["condition"] == "theta = asin(1/(k*phi_dot**2))"
    assert row["structural_zeros"]["viscous"] == 1
    disk = st.Disk(mass=2.0, radius=0.3, gravity=9.81)
    rate, speed = float(np.asarray(disk.rate)), float(np.asarray(disk.speed))
    table = st.table("conditions", k=0.25, mu=0.97 / speed, contact="viscous", disk=disk)
    rows = table.rows
    assert f"phi_dot ({family})" in table.to_text()
    mine = [r for r in rows if r["family"] == family]
    for r in mine:
        if r["at"] is not None:
            tops = [
                eigenvalues(family, r["at"] / rate * s, 0.25, 0.97).real.max()
                for s in (0.999, 1.001)
            ]
            assert (tops[0] < 0) == (r["below"] == "stable")
            assert tops[0] * tops[1] < 0
    assert len(mine) == (2 if family == "edge-on" else 1)


def test_launches_end_as_its_linear_theory_says(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(FAMILIES, "edge-on", EDGE_ON)
    at = (1.0, 2.4)
    assert [eigenvalues("edge-on", w, 0.25, 0.3).real.max() < 0 for w in at] == [False, True]
    run = st.simulate(st.Disk(), st.Viscous(0.3), st.launch("edge-on", at=at, tilt=0.1), 1000.0)
    assert run.nearest_family.values.tolist() == ["tumbling", "edge-on"]
    assert run.outcome.values.tolist() == [1, 1]


def test_figures_mark_the_member_that_was_settled_on(family: str) -> None:

    at = 2.5 if family == "edge-on" else 3.0
    start = st.launch(family, at=at, tilt=0.02, disk=st.Disk())
    run = st.simulate(st.Disk(), st.Viscous(0.3), start, np.linspace(0, 2000, 11))
    panels = st.plot_motion(run, show="states").axes
    steady = [[line for line in panel.lines if line.get_label() == "steady"] for panel in panels]
    assert [len(lines) for lines in steady] == [int(family == "coning"), 1, 0, 0]
    ends = member(family, float(run.nearest_at), 0.25)
    assert [float(lines[0].get_ydata()[0]) for lines in steady if lines] == pytest.approx(
        ends[2:3] if family == "edge-on" else [ends[0], ends[2]]
    )


@pytest.mark.long
def test_the_atlas_draws_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from stability.atlas import build, page

    monkeypatch.setattr(build, "LOCUS_FRICTION", ())
    monkeypatch.setattr("stability.figures.canvas.save", lambda *_: None)  # it takes the most time
    monkeypatch.setitem(FAMILIES, "edge-on", EDGE_ON)
    assert [*page.drawn()] == ["rolling", "spinning", "tumbling", "edge-on"]
    monkeypatch.setattr(page, "drawn", lambda: {"edge-on": EDGE_ON.drawn})
    drawn = build._job(("disk", "edge-on", None), str(tmp_path), 8, draft=True)
    pages = [build._page("disk", "edge-on", {("disk", "edge-on", None): drawn}, ())]
    assert st.read_map(tmp_path / "edge-on-disk.nc").attrs["family"] == "edge-on"
    at = [row[6] for row in pages[0].rows if row[3] == "rough"]
    assert at == pytest.approx([2 / math.sqrt(5)])  # phi_dot² = 1/(1 + k)
    assert '<h2 id="edge-on">Edge-on</h2>\n<p>θ = π/2</p>' in page._html(pages, (), 8, draft=True)


@pytest.mark.long
def test_flutter_points_are_those_of_the_same_motion(family: str) -> None:
    disk, contact = st.Disk(k=0.375), st.Viscous(0.9)
    mine = st.hopf(family, contact=contact, disk=disk)
    for point in mine:
        tops = [eigenvalues(family, point.at * s, 0.375, 0.9).real.max() for s in (0.999, 1.001)]
        assert (tops[0] < 0) == point.stable_below
        assert tops[0] * tops[1] < 0
    same = st.hopf(OF[family], contact=contact, disk=disk)
    assert sorted(p.kind.word for p in mine) == sorted(p.kind.word for p in same)


def test_what_has_no_polynomial_says_so(family: str) -> None:
    with pytest.raises(st.StabilityError, match="has no polynomial; there is one for rolling"):
        st.exact_polynomial(family, "viscous")
    with pytest.raises(st.StabilityError, match="no exact polynomials"):
        st.stream_map(family, x=("at", 2.1, 3, 9), y=("mu", 1, 2, 9), out="never.nc")


def test_a_polynomial_is_derived_from_the_record(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(FAMILIES, "edge-on", EDGE_ON)
    found = derive("edge-on", "rough")
    assert [str(f.as_expr()) for f in found.factors] == ["k*lam**2 + k*z + lam**2 + z - 1"]


def test_a_stored_polynomial_makes_its_answers_exact(
    monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    from stability.bodies import disk_polynomials

    monkeypatch.setitem(FAMILIES, "edge-on", EDGE_ON)
    stored = dict(disk_polynomials._catalogue())
    stored["edge-on viscous"] = replace(stored["spinning viscous"], family="edge-on")
    monkeypatch.setattr(disk_polynomials, "_catalogue", lambda: stored)
    disk_polynomials.disk_polynomial.cache_clear()
    request.addfinalizer(disk_polynomials.disk_polynomial.cache_clear)
    found = st.boundaries("edge-on", axis=("at", 0.5, 3.0, 9), contact=st.Viscous(0.97))
    assert found.complete
    # k phi_dot² = 1; the other to 20 digits in tests/boundary/test_boundaries.py
    assert [b.value for b in found] == pytest.approx([2.0, 2.0451355787], abs=1e-10)
    drawn = st.stability_map("edge-on", x=("at", 1.5, 3, 5), y=("mu", 0.3, 1.5, 3))
    assert "exact polynomials" in drawn.attrs["method"]


def test_a_family_whose_graph_has_another_form_gets_no_polynomial(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(FAMILIES, "coning", CONING)
    monkeypatch.setattr(kept, "LAWS", {"rough": None})
    monkeypatch.setattr(kept, "families_under", lambda _: [CONING, FAMILIES["rolling"]])
    assert list(kept.of_disk()["cases"]) == ["rolling rough"]


def test_a_condition_with_several_roots_names_them_all(monkeypatch: pytest.MonkeyPatch) -> None:
    from stability.tables.families import condition

    monkeypatch.setitem(FAMILIES, "nodding", replace(CONING, name="nodding", solution=None))
    roots = condition("nodding").split(" or ")
    assert "theta = asin(1/(k*phi_dot**2))" in roots and len(roots) > 1


def test_methods_are_compared_on_it(family: str) -> None:
    from stability.compare.spectrum.points import Points
    from stability.compare.spectrum.routes import ManyDigits

    known, at = given(family)[0]
    one = np.ones(1)
    points = Points(family, "viscous", known["k"] * one, known["mu"] * one, at * one)
    top = max(float(re) for re, _ in known["eigenvalues"])
    assert ManyDigits().answer(points).abscissa[0] == pytest.approx(top, abs=1e-12)
    assert points.states[0] == pytest.approx(member(family, at, known["k"]), abs=1e-15)


def test_the_condition_of_a_family_at_a_fixed_inclination(monkeypatch: pytest.MonkeyPatch) -> None:
    """A record that holds theta at a double and has a closed form, which holds the double too."""
    from stability.tables.families import condition

    theta = 1.0
    leaning = SteadyFamily(
        "leaning-circle",
        ("phi_dot",),
        held={"theta": theta},
        unknown={"omega3": 1.0},
        law="rough",
        motion="circling at an inclination of one radian",
        # Euler about the level axis: (2k + 1) phi_dot omega3 s = (k phi_dot² s - 1) c
        solution=lambda _, at, k, unit: (
            (k * at**2 * math.sin(theta) - unit**2)
            * math.cos(theta)
            / ((2 * k + 1) * at * math.sin(theta))
        ),
    )
    monkeypatch.setitem(FAMILIES, leaning.name, leaning)
    start = st.launch(leaning.name, at=1.3, tilt=0.0, disk=st.Disk())
    [same] = st.disk_family("circling", "rough").member([[theta, 1.3]], [0.25])
    assert start[:4] == pytest.approx(same)
    name, _, formula = condition(leaning.name).partition(" = ")
    value = eval(formula, {"k": 0.25, "phi_dot": 1.3, "sin": math.sin, "cos": math.cos})
    assert (name, value) == ("omega3", pytest.approx(same[3], rel=1e-14))


def test_a_wrong_closed_form_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    from stability.tables.families import condition

    wrong = replace(
        CONING,
        name="wrong-cone",
        solution=lambda functions, at, k, unit: functions.acos(unit * unit / (k * at * at)),
    )
    monkeypatch.setitem(FAMILIES, wrong.name, wrong)
    with pytest.raises(st.StabilityError, match="solution of wrong-cone is no root of its eq"):
        condition(wrong.name)
    disk = st.Disk(mass=2.0, radius=0.3, gravity=9.81)
    at = 3.0 * float(np.asarray(disk.rate))
    said = "solution of wrong-cone gives theta = 1.11024 at phi_dot = 3, k = 0.25"
    with pytest.raises(st.StabilityError, match=said):
        st.launch(wrong.name, at=at, disk=disk)


def test_a_family_of_one_law_alone_is_refused_under_others(monkeypatch: Any) -> None:
    held = SteadyFamily(
        "banking",
        ("phi_dot",),
        held={"theta": 1.0},
        unknown={"omega3": 1.0},
        law="rough",
        motion="circling at an inclination of one radian",
    )
    monkeypatch.setitem(FAMILIES, "banking", held)
    with pytest.raises(StabilityError, match="banking holds theta at 1.0, whose sine"):
        derive("banking", "rough")  # `make derive` ended in a TypeError
    mine = st.spectrum("banking", at=1.3, contact=st.Rough())
    same = st.spectrum("circling", at=[1.0, 1.3], contact=st.Rough())
    nonzero = same.eigenvalues[np.abs(same.eigenvalues) > 1e-9]
    assert np.sort_complex(mine.eigenvalues)[-1] == pytest.approx(np.sort_complex(nonzero)[-1])
    with pytest.raises(st.StabilityError, match="known are rolling, spinning, tumbling"):
        st.launch("banking", at=1.3)
    with pytest.raises(st.StabilityError, match="banking is a family of the rough disk"):
        st.spectrum("banking", at=1.3, contact=st.Smooth())


def test_a_family_under_one_law_is_neither_drawn_nor_sampled() -> None:
    with pytest.raises(st.StabilityError, match="under the smooth law alone"):
        replace(EDGE_ON, law="smooth")


def test_a_family_without_a_polynomial_is_not_said_to_be_searched_over_q(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(FAMILIES, "edge-on", EDGE_ON)
    notes = "\n".join(st.table("conditions", k=0.25).notes)
    assert "edge-on 0.1…5: no polynomial is stored" in notes
    assert "rolling 0.02…50, spinning" in notes.split("completely")[0]
