"""Bodies of revolution on the command line: the numbers are those of the library."""

import json
from pathlib import Path
from typing import Any

import casadi as ca
import pytest
from command_line import output, refused

import stability as st
from stability.bodies.round_body.shapes.named import NAMED
from stability.cli import main
from stability.cli.commands import _parser

FILE = """
import casadi as ca
import stability as st

def egg(a, sharp=0.08):
    return st.Body(lambda t, a, sharp: 1 + a * ca.cos(t) + sharp * ca.cos(2 * t), axial=0.3,
                   transverse=0.4, shape={"a": a, "sharp": sharp}, name="egg")

coin = st.Body(lambda t, rim: rim + ca.sin(t), axial=0.5, transverse=0.25, shape={"rim": 0.02},
               name="coin")
seven = 7

def fails():
    raise RuntimeError("no egg today")

def nothing():
    return 3
"""
NUMBERS = {
    "torus": ["--tube", "0.2"],
    "spheroid": ["--aspect", "0.6"],
    "eccentric-sphere": ["--offset", "0.2"],
    "thick-disk": ["--thickness", "0.3"],
    "egg": ["--taper", "0.15"],
}
ASK = ["--at", "1", "--mu", "0.3"]
TORUS = ["--body", "torus", "--tube", "0.2"]


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "egg.py").write_text(FILE)
    monkeypatch.chdir(tmp_path)


def spectrum(capsys: pytest.CaptureFixture[str], *words: str) -> dict[str, object]:
    found: dict[str, object] = json.loads(output(capsys, "spectrum", *words, "--json"))
    return found


@pytest.mark.long
@pytest.mark.parametrize("name", NAMED)
def test_every_named_body_has_the_spectrum_of_the_library(
    capsys: pytest.CaptureFixture[str], name: str
) -> None:
    body = NAMED[name](float(NUMBERS[name][1]))
    family, at = (
        ("rolling", "2") if name in ("torus", "spheroid", "thick-disk") else ("tumbling", "1")
    )
    found = spectrum(capsys, family, "--body", name, *NUMBERS[name], "--at", at, "--mu", "0.3")
    own = st.spectrum(family, at=float(at), body=body, contact=st.Viscous(0.3))
    assert found["body"] == body.name
    assert found["abscissa"] == own.abscissa
    assert found["verdict"] == own.verdict.word
    told = found["parameters"]
    assert isinstance(told, dict)
    assert (told["axial"], told["transverse"]) == body.moments()
    assert {n: told[n] for n in body.shape} == dict(body.shape)
    assert {n: told[n] for n in body.constants} == dict(body.constants)


def test_units_hollowness_and_moments_reach_the_body(capsys: pytest.CaptureFixture[str]) -> None:
    si = ["--mass", "0.5", "--gravity", "9.81", "--length", "0.3"]
    text = output(capsys, "spectrum", "rolling", *TORUS, "--hollow", *si, "--at", "9", "--mu", ".2")
    own = st.spectrum(
        "rolling",
        at=9.0,
        contact=st.Viscous(0.2),
        body=st.Torus(0.2, solid=False, mass=0.5, gravity=9.81, length=0.3),
    )
    assert "rolling of hollow torus, viscous contact, at omega3 = 9 rad/s, mass = 0.5 kg" in text
    assert "[1/s]" in text
    assert f"{own.eigenvalues[-1].real:+.12e}" in text
    ball = [
        "--body",
        "eccentric-sphere",
        "--offset",
        "0.2",
        "--axial",
        "0.3",
        "--transverse",
        "0.4",
    ]
    found = spectrum(capsys, "tumbling", *ball, "--at", "1.0", "--contact", "smooth")
    assert found["parameters"] == {
        "mass": 1,
        "gravity": 1,
        "length": 1,
        "offset": 0.2,
        "axial": 0.3,
        "transverse": 0.4,
    }


@pytest.mark.usefixtures("file")
def test_a_users_body_takes_the_numbers_of_its_function_or_shape(
    capsys: pytest.CaptureFixture[str],
) -> None:
    text = output(capsys, "spectrum", "rolling", "--body", "egg.py:egg", "--a", "0.1", *ASK)
    assert "rolling of egg, viscous contact, at omega3 = 1 √(g/R), a = 0.1, sharp = 0.08," in text
    other = output(capsys, "spectrum", "rolling", "--body=egg.py:egg", "--a=0.1", *ASK)
    assert other == text
    named = output(capsys, "spectrum", "rolling", "--body", "egg.py:egg", "--set", "a=0.1", *ASK)
    assert named == text
    found = spectrum(capsys, "rolling", "--body", "egg:coin", "--rim", "0.1", *ASK)
    same = spectrum(capsys, "rolling", "--body", "egg:coin", *ASK)
    told = found["parameters"], same["parameters"]
    assert [p["rim"] for p in told if isinstance(p, dict)] == [0.1, 0.02]


def test_boundaries_and_maps_are_those_of_the_library(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    words = ["--body", "spheroid", "--axis", "aspect:0.1:3:9", "--at", "0.5", "--contact", "rough"]
    found = json.loads(output(capsys, "boundaries", "rolling", *words, "--json"))
    # at rest on its side an oblate body falls over; spin holds it up above the threshold
    own = st.boundaries(
        "rolling", axis=("aspect", 0.1, 3, 9), at=0.5, body=st.Spheroid(1.0), contact=st.Rough()
    )
    assert [b["value"] for b in found["boundaries"]] == [b.value for b in own]
    assert found["body"] == "spheroid"
    assert found["parameters"] == {"mass": 1, "gravity": 1, "length": 1}  # aspect is the axis
    text = output(
        capsys,
        "boundaries",
        "rolling",
        "--body",
        "spheroid",
        "--aspect",
        "0.5",
        "--axis",
        "omega3:0.1:3:9",
        "--contact",
        "rough",
    )
    assert "rolling of spheroid, rough contact, along omega3" in text
    assert "aspect = 0.5, axial = 0.4, transverse = 0.25" in text

    target = tmp_path / "torus.nc"
    told = output(
        capsys,
        "map",
        "spinning",
        "--body",
        "torus",
        "--x",
        "at:0.5:5:8",
        "--y",
        "tube:0.05:0.5:6",
        "--mu",
        "0.3",
        "--out",
        str(target),
        "--json",
    )
    assert json.loads(told)["body"] == "torus"
    chart = st.stability_map(
        "spinning",
        x=("at", 0.5, 5, 8),
        y=("tube", 0.05, 0.5, 6),
        body=st.Torus(0.1),
        contact=st.Viscous(0.3),
    )
    assert (st.read_map(target).verdict == chart.verdict).all()


def test_help_lists_the_bodies_with_an_example(capsys: pytest.CaptureFixture[str]) -> None:
    for command in ("spectrum", "map", "boundaries"):
        with pytest.raises(SystemExit):
            main([command, "--help"])
        text = " ".join(capsys.readouterr().out.split())
        assert all(name in text for name in NAMED)
        assert "--body torus --tube 0.2" in text
        assert "--offset X" in text
    assert _parser().parse_args(["spectrum", "rolling", *TORUS]).numbers == {"tube": 0.2}


@pytest.mark.usefixtures("file")
@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["rolling", "--body", "tori", *ASK], "known are torus, spheroid, eccentric-sphere"),
        (["rolling", "--body", "torus", *ASK], "--tube is missing; torus needs it"),
        (["rolling", "--body", "torus", "--tube", "2", *ASK], "tube of the torus is 2; it must"),
        (["rolling", *TORUS, "--aspect", "2", *ASK], "it takes --tube or --solid or --hollow"),
        (["rolling", *TORUS, "--k", "0.2", *ASK], "--k does not go with --body"),
        (["rolling", *TORUS, "--lean", "0.2", *ASK], "--lean does not go with --body"),
        (["rolling", *TORUS, "--at", "1,2", "--mu", "1"], "rolling takes omega3, 1 number"),
        ([*TORUS, *ASK], "FAMILY is missing; name one of rolling"),
        (["tipping", *TORUS, *ASK], "known for torus are rolling"),
        (["rolling", *TORUS, "--mu", "1"], "at is missing"),
        (["rolling", *TORUS, "--at", "1"], "mu is missing"),
        (["rolling", "--tube", "0.2", *ASK], "--tube is not an option here"),
        (["rolling", *TORUS, "--bulge", "0.2", *ASK], "--bulge is no number of torus; it takes"),
        (["spinning", "--body", "thick-disk", "--thickness", "0.2", *ASK], "has no spinning"),
        (["rolling", "--body", "egg.py:seven", *ASK], "its bodies are coin"),
        (["rolling", "--body", "egg.py:ovo", *ASK], "its bodies are coin"),
        (["rolling", "--body", "ovo.py:egg", *ASK], "cannot be imported"),
        (["rolling", "--body", "egg.py:egg", *ASK], "--a is missing; egg.py:egg needs it"),
        (["rolling", "--body", "egg.py:egg", "--c", "1", *ASK], "it takes --a or --sharp"),
        (["rolling", "--body", "egg.py:egg", "--a", "x", *ASK], "a is 'x'; a number is needed"),
        (["rolling", "--body", "egg.py:egg", "--a", "3", *ASK], "must lie above the plane"),
        (["rolling", "--body", "egg.py:coin", "--a", "3", *ASK], "it takes --rim"),
        (["rolling", "--body", "egg.py:egg", "3", *ASK], "3 belongs to no option"),
        (["rolling", *TORUS, "--bulge", *ASK], "bulge is '--at'; a number is needed"),
        (["rolling", *TORUS, "--conta", "rough", *ASK], "an option of the command is --contact"),
        (["rolling", *TORUS, "--certif", "1", *ASK], "an option of the command is --certify"),
        (["rolling", "--solid", *ASK], "--solid or --hollow is given without --body"),
        (["rolling", "--length", "2", *ASK], "--length is given without --body"),
        (["rolling", "--body", "egg.py:fails", *ASK], "RuntimeError: no egg today"),
        (["rolling", "--body", "egg.py:nothing", *ASK], "returns 3; a stability.Body is needed"),
        (["rolling", "--body", "egg", "--taper", "0.5", *ASK], "it must lie in [0, 0.4]"),
        (["rolling", "--body", "egg", "--aspect", "0", *ASK], "aspect is 0; it must lie in"),
        (["rolling", "--body", "egg", "--tube", "1", *ASK], "it takes --taper or --aspect"),
        (["rolling", *TORUS, "--taper", "0.1", *ASK], "--taper is no number of torus"),
    ],
)
def test_bad_input_gets_one_sentence(
    capsys: pytest.CaptureFixture[str], words: list[str], said: str
) -> None:
    assert said in refused(capsys, "spectrum", *words)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--tube", ".2", "--axis", "tube:.1:.5:9", "--at", "1"], "given as --tube and as an axis"),
        (["--tube", ".2", "--axis", "mu:.1:.5:9", "--at", "1"], "given as --mu and as an axis"),
        (["--tube", ".2", "--axis", "k:.1:.5:9", "--at", "1"], "known for rolling are omega3"),
        (["--axis", "omega3:.1:.5:9"], "--tube is missing"),
    ],
)
def test_bad_axes_get_one_sentence(
    capsys: pytest.CaptureFixture[str], words: list[str], said: str
) -> None:
    found = refused(capsys, "boundaries", "rolling", "--body", "torus", "--mu", "1", *words)
    assert said in found


HEN = ["--body", "egg", "--taper", "0.25", "--aspect", "1.4"]


@pytest.mark.long
def test_every_command_takes_an_egg(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    egg = st.Egg(0.25, aspect=1.4)
    told = {"taper": 0.25, "aspect": 1.4, "axial": egg.moments()[0], "transverse": egg.moments()[1]}

    def ask(*words: str) -> dict[str, Any]:
        found: dict[str, Any] = json.loads(output(capsys, *words, "--mu", "0.3", "--json"))
        return found

    found = ask("boundaries", "vertical", *HEN, "--pole", "pi", "--axis", "omega_Z:0.1:6:9")
    own = st.boundaries(
        "vertical", axis=("omega_Z", 0.1, 6, 9), body=egg, contact=st.Viscous(0.3), pole="pi"
    )
    assert [b["value"] for b in found["boundaries"]] == [b.value for b in own]
    assert told.items() <= found["parameters"].items()

    found = ask(
        "map", "vertical", *HEN, "--x", "omega_Z:1:5:4", "--y", "axial:0.3:0.5:3", "--out", "egg.nc"
    )
    assert (found["body"], found["parameters"]["taper"]) == ("egg", 0.25)
    chart = st.stability_map(
        "vertical",
        x=("omega_Z", 1, 5, 4),
        y=("axial", 0.3, 0.5, 3),
        body=egg,
        contact=st.Viscous(0.3),
    )
    assert (st.read_map("egg.nc").verdict == chart.verdict).all()

    launch = ["--theta", "0.3", "--omega3", "2", "--time", "3"]
    found = ask("simulate", *HEN, *launch)
    run = st.simulate(egg, st.Viscous(0.3), {"theta": 0.3, "omega3": 2}, 3.0)
    assert found["final"]["theta"] == pytest.approx(float(run.theta[-1]), abs=1e-7)
    assert told.items() <= found["parameters"].items()

    found = ask(
        "basins",
        *HEN,
        "--x",
        "theta:0.3:1:2",
        "--y",
        "omega3:1:2:2",
        "--time",
        "3",
        "--out",
        "egg.zarr",
    )
    assert found["launches"] == 4
    output(capsys, "explore", "vertical", *HEN, "--mu", "0.3", "--out", "egg.html")
    assert "st.Egg" not in (tmp_path / "egg.html").read_text()
    output(capsys, "export", "c", "tumbling", *HEN, "--out", "code")
    assert any((tmp_path / "code").iterdir())

    (tmp_path / "egg.toml").write_text(
        '[body]\nname = "egg"\ntaper = 0.25\naspect = 1.4\n[contact]\nlaw = "viscous"\nmu = 0.3\n'
        "[start]\ntheta = 0.3\nomega3 = 2.0\n[question]\nhorizon = 3.0\n"
    )
    found = json.loads(output(capsys, "scene", "egg.toml", "--json"))
    scene = st.Scene(
        body=egg, contact=st.Viscous(0.3), start={"theta": 0.3, "omega3": 2.0}, horizon=3.0
    )
    assert scene.answer().model == found["model"]


@pytest.mark.few(1)
@pytest.mark.parametrize("axis", ["taper", "aspect"])
def test_a_number_of_a_quadrature_is_no_axis(capsys: pytest.CaptureFixture[str], axis: str) -> None:
    axis_of = f"{axis}:0.1:0.3:4"
    for words in (
        ["boundaries", "tumbling", "--axis", axis_of, "--at", "1"],
        ["map", "tumbling", "--x", axis_of, "--y", "mu:1:2:3", "--at", "1", "--out", "egg.nc"],
        [
            "map",
            "tumbling",
            "--x",
            axis_of,
            "--y",
            "mu:1:2:3",
            "--at",
            "1",
            "--verdict-only",
            "--out",
            "egg.nc",
        ],
        ["basins", "--x", axis_of, "--y", "theta:1:2:3", "--time", "1", "--out", "egg.zarr"],
        ["explore", "tumbling", "--x", f"{axis}:0.1:0.3", "--out", "egg.html"],
    ):
        mu = [] if "mu:1:2:3" in words else ["--mu", "1"]
        said = refused(capsys, *words, "--body", "egg", *mu)
        assert f"{axis} is no axis of egg: its height and moments are computed for one" in said
    for call in (
        lambda: st.boundaries(
            "tumbling", axis=(axis, 0.1, 0.3, 4), at=1.0, body=st.Egg(), contact="rough"
        ),
        lambda: st.basins(
            st.Egg(), "rough", x=(axis, 0.1, 0.3, 4), y=("theta", 1, 2, 3), horizon=1.0
        ),
    ):
        with pytest.raises(st.StabilityError, match=f"{axis} is no axis of egg"):
            call()


OVAL = """
import numpy as np
import stability as st

def oval(bulge=0.1):
    return st.from_profile(lambda u: (np.sin(u) * (1 + bulge * np.cos(u)), -1.2 * np.cos(u)))
"""


@pytest.mark.long
def test_numbers_of_a_users_quadrature_are_recorded_and_no_axes(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "oval.py").write_text(OVAL)
    monkeypatch.chdir(tmp_path)
    found = spectrum(capsys, "tumbling", "--body", "oval.py:oval", "--bulge", "0.2", *ASK)
    told = found["parameters"]
    assert isinstance(told, dict) and told["bulge"] == 0.2
    said = refused(
        capsys,
        "boundaries",
        "tumbling",
        "--body",
        "oval.py:oval",
        "--axis",
        "bulge:0.1:0.2:3",
        *ASK,
    )
    assert "bulge is no axis of profile" in said


@pytest.mark.long
def test_a_launched_body_moves_as_in_the_library_and_is_filmed(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    si = ["--mass", "0.02", "--gravity", "9.81", "--length", "0.03"]
    start = ["--theta", "0.4", "--omega3", "60", "--slip-y", "0.01"]
    against = ["--rolling-resistance", "1e-5", "--pivoting-resistance", "2e-5"]
    rest = ["--mu", "0.5", "--time", "0.4", "--points", "81", "--air-torque", "1e-9"]
    film, file = tmp_path / "top.gif", tmp_path / "top.nc"
    words = ["--body", "eccentric-sphere", "--offset", "0.15", *si, *start, *against, *rest]
    text = output(capsys, "simulate", *words, "--out", str(file), "--film", str(film), "--json")
    found = json.loads(text)
    top = st.EccentricSphere(0.15, mass=0.02, gravity=9.81, length=0.03)
    own = st.simulate(
        body=top,
        contact=st.Viscous(0.5),
        start={"theta": 0.4, "omega3": 60, "slip_y": 0.01},
        times=0.4,
        resistance=[st.RollingResistance(1e-5), st.PivotingResistance(2e-5), st.AirTorque(1e-9)],
    )
    assert found["final"]["theta"] == pytest.approx(float(own.theta[-1]), abs=1e-7)
    assert found["final"]["omega3"] == pytest.approx(float(own.omega3[-1]), rel=1e-7)
    assert (found["body"], found["unit"]) == ("eccentric sphere", "SI")
    told = found["parameters"]
    assert (told["offset"], told["rho"], told["sigma"], told["drag"]) == (0.15, 1e-5, 2e-5, 1e-9)
    assert (told["axial"], told["transverse"]) == top.moments()
    assert film.stat().st_size > 1000
    assert st.read_motion(file).attrs["body"] == "eccentric sphere"


@pytest.mark.usefixtures("file")
@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([*TORUS, "--k", "0.3"], "--k does not go with --body"),
        ([*TORUS, "--system", "a.py:b"], "--system does not go with --body"),
        ([*TORUS, "--air-torque", "-1"], "drag is -1"),
        (["--body", "egg.py:coin", "--rim", "x"], "rim is 'x'; a number is needed"),
    ],
)
def test_a_launch_that_is_not_accepted_gets_one_sentence(
    capsys: pytest.CaptureFixture[str], words: list[str], said: str
) -> None:
    launch = ["--theta", "1.2", "--mu", "0.3", "--time", "1"]
    assert said in refused(capsys, "simulate", *words, *launch)


@pytest.mark.long
@pytest.mark.usefixtures("file")
def test_the_command_prints_painleves_limit_of_a_body(capsys: pytest.CaptureFixture[str]) -> None:
    def limit(*words: str) -> list[dict[str, float]]:
        rows: list[dict[str, float]] = json.loads(
            output(capsys, "table", "painleve", *words, "--json")
        )["rows"]
        return rows

    [torus] = limit(*TORUS)
    own = st.painleve_limit(st.Torus(0.2))
    assert (torus["limit"], torus["at_most"], torus["theta"]) == (own.low, own.high, own.theta)
    [coin] = limit("--body", "egg.py:coin", "--rim", "0.1")
    body = st.Body(lambda t: 0.1 + ca.sin(t), axial=0.5, transverse=0.25)
    assert coin["limit"] == pytest.approx(st.painleve_limit(body).low, rel=1e-12)
    every = limit()
    assert [r["body"] for r in every][-1] == "egg, taper 0.2" and len(every) == 11
    assert "body belongs to `table painleve` only" in refused(capsys, "table", "drift", *TORUS)
    assert "--tube is missing" in refused(capsys, "table", "painleve", "--body", "torus")
    assert "does not go with --body" in refused(
        capsys, "table", "painleve", *TORUS, "--system", "egg.py:coin"
    )
