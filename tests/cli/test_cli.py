"""The command line: what it prints, what it refuses, and that it leaves nothing half-written."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from argparse import ArgumentParser, _SubParsersAction
from contextlib import suppress
from functools import cache
from pathlib import Path

import pytest
from command_line import output, refused

from stability.cli import main

COMMANDS = (
    "spectrum",
    "map",
    "boundaries",
    "branch",
    "equilibria",
    "atlas",
    "table",
    "scene",
    "simulate",
    "basins",
    "explore",
    "export",
    "cite",
)
OWN = ("spectrum", "map", "boundaries", "table", "simulate", "basins", "explore")
MAP = ["map", "rolling", "--x", "at:1:2:6", "--y", "mu:0.1:1:5"]


def run(*words: str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "stability", *words], capture_output=True, text=True, cwd=cwd
    )


# --- what it prints ---


def test_spectrum_prints_the_object_of_the_contract(capsys: pytest.CaptureFixture[str]) -> None:
    found = json.loads(
        output(capsys, "spectrum", "rolling", "--at", "1.2", "--mu", "0.3", "--json")
    )
    assert list(found)[:9] == [
        "family",
        "contact",
        "parameters",
        "at",
        "eigenvalues",
        "structural_zeros",
        "abscissa",
        "verdict",
        "nonlinear",
    ]
    assert found["family"] == "rolling"
    assert found["contact"] == "viscous"
    assert found["verdict"] == "unstable"
    assert found["structural_zeros"] == 2
    assert found["parameters"] == {"mass": 1, "radius": 1, "k": 0.25, "gravity": 1, "mu": 0.3}
    assert found["eigenvalues"][0] == pytest.approx([-1.7739083457715993, 0], abs=1e-12)
    assert found["abscissa"] == found["eigenvalues"][-1][0]


@pytest.mark.few(3)
@pytest.mark.parametrize("contact", ["smooth", "viscous", "linear-viscous", "rough"])
@pytest.mark.parametrize(
    ("family", "at"), [("rolling", "0.57735026918962584"), ("spinning", "2"), ("tumbling", "0.5")]
)
def test_json_is_strict_for_every_family_and_law(
    capsys: pytest.CaptureFixture[str], family: str, at: str, contact: str
) -> None:
    mu = ["--mu", "0.3"] if "viscous" in contact else []
    text = output(capsys, "spectrum", family, "--at", at, "--contact", contact, *mu, "--json")

    def strict(token: str) -> None:
        raise AssertionError(token)

    found = json.loads(text, parse_constant=strict)
    assert found["verdict"] in ("stable", "unstable", "neutral", "undecided")


def test_circling_takes_a_pair(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["spectrum", "circling", "--at", "1.2,0.5", "--contact", "rough", "--json"]
    found = json.loads(output(capsys, *words))
    assert found["at"] == [1.2, 0.5]
    assert found["verdict"] == "neutral"


def test_si_units_are_named(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["spectrum", "rolling", "--at", "40", "--mu", "0.3", "--disk", "quarter"]
    text = output(capsys, *words)
    assert "[1/s]" in text
    same = ["--mass", "0.00567", "--radius", "0.01213", "--gravity", "9.81"]
    assert output(capsys, *words[:6], *same) == text


def test_every_number_of_boundaries_has_its_name_and_unit(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """`at` was no name that a reader knows, and what --at holds was not printed."""
    coin = ["boundaries", "rolling", "--disk", "quarter"]
    text = output(capsys, *coin, "--axis", "at:1:90:9", "--mu", "0.3")
    assert "along omega3 from 1 to 90 rad/s, at mass = 0.00567 kg, radius = 0.01213 m" in text
    assert "gravity = 9.81 m/s², mu = 0.3 s/m\nviscous: F = -μ N v" in text
    assert "\n  omega3 = 40.21787" in text
    assert " rad/s   flutter, stable above, frequency 56.8766618032 1/s\n" in text
    plain = ["boundaries", "spinning", "--axis", "mu:0.1:5:9", "--at", "2.5"]
    text = output(capsys, *plain)
    assert "along mu from 0.1 to 5 1/√(gR), at phi_dot = 2.5 √(g/R), k = 0.25\n" in text
    assert json.loads(output(capsys, *plain, "--json"))["at"] == 2.5
    heavy = ["boundaries", "rolling", "--axis", "mass:1:2:9", "--at", "2", "--mu", "1"]
    heavy += ["--radius", "1", "--gravity", "1"]
    assert "from 1 to 2 kg, at omega3 = 2 rad/s, radius = 1 m" in output(capsys, *heavy)


@pytest.mark.parametrize(
    ("words", "number"),
    [
        (("spectrum", "rolling", "--at", "2"), "mu = 0.3 1/√(gR)"),
        (("boundaries", "rolling", "--axis", "at:1:2:5"), "mu = 0.3 1/√(gR)"),
        (("simulate", "--theta", "1.5", "--omega3", "1", "--time", "0.1"), "mu = 0.3 1/√(gR)"),
        (("spectrum", "rolling", "--at", "2", "--disk", "quarter"), "mu = 0.3 s/m"),
        (("simulate", "--theta", "1", "--time", "0.1", "--disk", "quarter"), "mu = 0.3 s/m"),
    ],
)
def test_mu_has_its_unit_and_its_law_and_is_said_to_be_no_dry_friction(
    capsys: pytest.CaptureFixture[str], words: tuple[str, ...], number: str
) -> None:
    text = output(capsys, *words, "--mu", "0.3")
    assert number in text
    assert text.count("viscous: F = -μ N v") == text.count("dry friction is --contact coulomb") == 1
    named = output(capsys, *words, "--mu", "0.3", "--contact", "viscous")
    assert "viscous: F = -μ N v" in named and "dry friction" not in named


@pytest.mark.parametrize(
    ("fraction", "decimal"),
    [
        (["spectrum", "rolling", "--at", "9/4", "--mu", "3/8", "--k", "1/4"],
         ["spectrum", "rolling", "--at", "2.25", "--mu", "0.375", "--k", "0.25"]),
        (["spectrum", "tumbling", "--lean", "1/2", "--mu", "1"],
         ["spectrum", "tumbling", "--lean", "0.5", "--mu", "1"]),
        (["spectrum", "rolling", "--body", "torus", "--tube", "1/8", "--at", "2", "--mu", "1"],
         ["spectrum", "rolling", "--body", "torus", "--tube", ".125", "--at", "2", "--mu", "1"]),
        (["boundaries", "rolling", "--axis", "at:1/8:5/2:9", "--mu", "1"],
         ["boundaries", "rolling", "--axis", "at:0.125:2.5:9", "--mu", "1"]),
        (["spectrum", "rolling", "--at", "2", "--contact", "viscous", "--set", "mu=-1/-3"], None),
        (["spectrum", "rolling", "--at", "2", "--mu", "1/0"], None),
    ],
)  # fmt: skip
def test_a_number_may_be_a_fraction(
    capsys: pytest.CaptureFixture[str], fraction: list[str], decimal: list[str] | None
) -> None:
    if decimal is None:
        assert "number" in refused(capsys, *fraction)
        return
    assert output(capsys, *fraction, "--json") == output(capsys, *decimal, "--json")


def test_the_states_of_a_motion_have_their_units(capsys: pytest.CaptureFixture[str]) -> None:
    launch = ["simulate", "--theta", "1.5", "--omega3", "1", "--mu", "0.3", "--time", "0.1"]
    text = output(capsys, *launch)
    assert "time      0.1 √(R/g)\n" in text
    for name, unit in (("omega3", "√(g/R)"), ("slip_x", "√(gR)"), ("theta", "rad")):
        assert re.search(rf"{name} = [-+.e0-9]+ {re.escape(unit)}", text)


@pytest.mark.parametrize("command", ["spectrum", "boundaries", "simulate", "map", "basins"])
def test_the_help_of_mu_says_its_law_its_unit_and_what_it_is_not(
    capsys: pytest.CaptureFixture[str], command: str
) -> None:
    with pytest.raises(SystemExit):
        main([command, "--help"])
    words = " ".join(capsys.readouterr().out.split())
    assert "friction coefficient of F = -mu N v [s/m]" in words
    assert "no dry friction: its mu [-] is that of --contact coulomb" in words


def test_map_writes_its_files_and_says_what_they_hold(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    nc, png = tmp_path / "a map.nc", tmp_path / "a map.png"
    found = json.loads(output(capsys, *MAP, "--out", str(nc), "--plot", str(png), "--json"))
    assert sum(found["verdicts"].values()) == 30
    assert found["boundary_points"] == 5
    assert png.read_bytes().startswith(b"\x89PNG")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a map.nc", "a map.png"]


@pytest.mark.long
def test_tables_are_headed_recomputed(capsys: pytest.CaptureFixture[str]) -> None:
    text = output(capsys, "table", "families")
    assert "(recomputed)" in text.splitlines()[0]
    assert "phi_dot**2 = 1/(k*sin(theta))" in text


@pytest.mark.parametrize("derived", [False, pytest.param(True, marks=pytest.mark.long)])
def test_table_of_conditions_has_the_known_thresholds(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, derived: bool
) -> None:
    if not derived:  # without the formulas, which take seconds
        monkeypatch.setattr("stability.derivation.formulas.rows", lambda *_: [])
    words = ["table", "conditions", "--k", "0.25", "--mu", "0.3,3", "--json"]
    rows = json.loads(output(capsys, *words))["rows"]
    at = {(r["family"], r["contact"], r["mu"]): r["at"] for r in rows}
    assert at["rolling", "smooth", None] == pytest.approx(1, rel=1e-14)
    assert at["rolling", "rough", None] ** 2 == pytest.approx(1 / 3, rel=1e-14)
    assert at["rolling", "viscous", 3.0] ** 2 == pytest.approx(2, rel=1e-14)
    assert at["spinning", "viscous", 0.3] ** 2 == pytest.approx(4, rel=1e-14)
    assert at["spinning", "viscous", 3.0] is None
    for row in rows:
        assert {row["below"], row["above"]} <= {"stable", "unstable", "neutral"}


@cache
def whole_parser() -> ArgumentParser:
    """The parser of every command."""
    from stability.cli.commands import _parser

    return _parser()


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help_with_an_example_that_parses(
    capsys: pytest.CaptureFixture[str], command: str
) -> None:
    with pytest.raises(SystemExit) as stop:
        main([command, "--help"])
    assert stop.value.code == 0
    text = " ".join(capsys.readouterr().out.split())
    examples = text.split("example: stability ")[1:]
    assert len(examples) >= (2 if command in OWN else 1)
    for example in examples:
        assert whole_parser().parse_args(example.rstrip("; ").split()).run


@pytest.mark.parametrize("command", [*COMMANDS, "chart", "failures", "report"])
def test_no_option_is_read_from_a_part_of_its_name(
    capsys: pytest.CaptureFixture[str], command: str
) -> None:
    """`--a 1` was read as `--at 1`, and `--ver` as `--version`."""
    [commands] = [a for a in whole_parser()._actions if isinstance(a, _SubParsersAction)]
    parser = commands.choices[command]
    options = [n for n in parser._option_string_actions if n.startswith("--")]
    for option in options:
        part = option[:-1]
        if part in ("--", *options):
            continue
        said = refused(capsys, command, part, "1")
        assert f"{part} is not an option here; " in said
        assert option in said.split("; ")[1]
    assert "--ver is not an option here; --version is" in refused(capsys, "--ver", command)


def test_a_part_of_several_names_is_answered_with_all_of_them(
    capsys: pytest.CaptureFixture[str],
) -> None:
    said = refused(capsys, "spectrum", "rolling", "--c", "rough", "--at", "1")
    assert "--c is not an option here; --contact, --certify or --csv is" in said
    said = refused(capsys, "map", "spinning", "--o", "m.nc")  # before the axes are asked for
    assert "--o is not an option here; --out, --overwrite or --overwrite-same is" in said


def test_lists_in_help_are_those_of_the_registries(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from own_law import Weakening

    from stability.bodies.contact_laws import MOTION_LAWS
    from stability.bodies.disk import REAL_DISKS
    from stability.bodies.families import FAMILIES, SteadyFamily
    from stability.bodies.round_body.shapes.named import NAMED
    from stability.integrators.registry import PLACES as INTEGRATORS
    from stability.tables.registry import PLACES

    def cone(slope: float, tip: float = 0.25) -> None:
        """A body that is never made."""

    monkeypatch.setitem(MOTION_LAWS, "weakening", Weakening)
    monkeypatch.setitem(REAL_DISKS, "penny", REAL_DISKS["quarter"])
    monkeypatch.setitem(NAMED, "cone", cone)
    monkeypatch.setitem(INTEGRATORS, "leapfrog", "scipy_methods")
    monkeypatch.setitem(PLACES, "ghosts", "drift")
    record = SteadyFamily("gliding", ("omega3",), {}, {"phi_dot": 1.0}, "gliding")
    monkeypatch.setitem(FAMILIES, "gliding", record)
    for command, words in {
        "spectrum": ("weakening", "penny", "gliding", "cone --slope X [--tip 0.25]"),
        "simulate": ("weakening", "coulomb-regularised", "penny", "leapfrog", "cone"),
        "basins": ("weakening", "penny", "launch near rolling, spinning, tumbling"),
        "table": ("weakening", "ghosts"),
        "export": ("weakening", "gliding", "cone"),
    }.items():
        with pytest.raises(SystemExit):
            main([command, "--help"])
        text = " ".join(capsys.readouterr().out.split())
        assert all(word in text for word in words), command


def test_help_of_table_names_every_table_and_what_each_axis_belongs_to(
    capsys: pytest.CaptureFixture[str],
) -> None:
    from stability.tables.registry import PLACES

    with pytest.raises(SystemExit):
        main(["table", "--help"])
    text = " ".join(capsys.readouterr().out.split())
    named = text.split("NAME families")[1].split("options:")[0]
    assert {*PLACES, "codimension"} == {"families", *named.replace(",", "").split()} - {"or"}
    x, y = text.split("--x NAME:LO:HI:N[:log]")[2], text.split("--y NAME:LO:HI:N[:log]")[2]
    assert "hopf" in x.split(" --")[0]
    assert "hopf" not in y.split(" --")[0]
    assert main(["table", "hopf", "--system", UPRIGHT, "--y", "v:1:2:3"]) == 2


# --- a family of one's own ---

UPRIGHT = "examples/bicycle.py:upright"


def test_spectrum_of_ones_own_system(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["spectrum", "--system", UPRIGHT, "--set", "g=9.81"]
    text = output(capsys, *words, "--at", "5")
    assert text.startswith("bicycle, upright, at v = 5 m/s, g = 9.81 m/s²\nverdict     stable")
    assert "disk" not in text
    body = json.loads(output(capsys, *words, "--set", "v=5", "--certify", "--json"))
    assert body["system"] == "bicycle"
    assert body["at"] == {"v": 5.0}
    assert body["parameters"] == {"g": 9.81}
    assert body["certified"] is True
    assert "contact" not in body
    weave = complex(*body["eigenvalues"][1])  # Meijaard et al. 2007, table 2
    assert abs(weave - complex(-0.77534188219585, -4.46486771378823)) < 1e-12


def test_every_number_may_be_set_by_name(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["spectrum", "rolling", "--at", "1.2", "--json"]
    known = json.loads(output(capsys, *words, "--mu", "0.4", "--k", "0.5"))
    assert json.loads(output(capsys, *words, "--set", "mu=0.4", "--set", "k=0.5")) == known
    said = refused(capsys, *words, "--parameter", "mu=0.4")
    assert "--parameter is not an option here; --set is" in said
    tyre = ["boundaries", "rolling", "--body", "torus", "--axis", "at:0.1:3:9", "--json"]
    known = json.loads(output(capsys, *tyre, "--tube", "0.2", "--mu", "0.3"))
    assert json.loads(output(capsys, *tyre, "--set", "tube=0.2", "--set", "mu=0.3")) == known
    for more, sentence in (
        (["--mu", "1", "--set", "mu=2"], "mu is given as --mu and by --set"),
        (["--set", "mu=1", "--set", "mu=2"], "mu is given twice"),
        (["--set", "mu"], "give NAME=NUMBER"),
        (["--mu", "1", "--set", "h=2"], "h is given but the viscous law has none"),
    ):
        assert main([*words, *more]) == 2
        assert sentence in capsys.readouterr().err


def test_export_takes_the_options_of_every_command(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """It took --set alone, no law of one's own, and no k that is left out."""

    def written(name: str, *words: str) -> dict[str, str]:
        folder = tmp_path / name
        ask = ["export", "auto", "spinning", "--axis", "phi_dot:5:1.8", "--out", str(folder)]
        output(capsys, *ask, *words)
        return {p.name: p.read_text().replace(str(folder), "") for p in folder.iterdir()}

    known = written("one/spin", "--set", "mu=0.8", "--set", "k=1/4")
    assert written("two/spin", "--mu", "0.8", "--k", "0.25") == known
    assert written("three/spin", "--mu", "0.8") == known
    assert written("four/spin", "--mu", "0.8", "--k", "0.5") != known
    ask = ["export", "c", "spinning", "--out", str(tmp_path / "c")]
    output(capsys, *ask, "--contact", "own_law:Weakening")
    more = ["export", "auto", "spinning", "--axis", "phi_dot:5:1.8", "--out", str(tmp_path / "n")]
    for words, sentence in (
        (["--mu", "1", "--set", "mu=2"], "mu is given as --mu and by --set"),
        (["--mu", "1", "--disk", "quarter"], "the disk is exported without units"),
        (["--mu", "1", "--contact", "rough"], "mu is given but the rough law has no coefficient"),
    ):
        assert sentence in refused(capsys, *more, *words)


def test_numbers_of_ones_own_system_are_exact_as_they_are_written(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """q̈ = -(a - 3 b) q - q̇ is neutral at a = 0.9, b = 0.3, and not at their doubles."""
    (tmp_path / "own.py").write_text(
        "import casadi as ca, stability as st\n"
        "x, p = ca.SX.sym('x', 2), ca.SX.sym('p', 2)\n"
        "s = st.System('own', x, p, ca.vertcat(x[1], -(p[0] - 3 * p[1]) * x[0] - x[1]),\n"
        "              states=('q', 'v'), parameters=('a', 'b'), units={'a': '1/s2', 'b': 'm'})\n"
        "rest = st.Family(s, 'rest', at=('a',), held={'q': 0.0, 'v': 0.0})\n"
    )
    place = f"{tmp_path / 'own.py'}:rest"
    words = ["spectrum", "--system", place, "--at", "0.9", "--set", "b=3/10", "--certify"]
    text = output(capsys, *words)
    assert text.startswith("own, rest, at a = 0.9 1/s², b = 0.3 m\nverdict     neutral")


@pytest.mark.long
def test_map_of_ones_own_system(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    import stability as st

    words = ["map", "--system", UPRIGHT, "--x", "v:1:10:8", "--y", "g:5:15:6"]
    out = tmp_path / "map.nc"
    assert "stable" in output(capsys, *words, "--out", str(out), "--json")
    dataset = st.read_map(out)
    assert dataset.verdict.dims == ("g", "v")
    assert dataset.attrs["system"] == "bicycle"
    streamed = tmp_path / "verdicts.nc"
    output(capsys, *words, "--verdict-only", "--out", str(streamed))
    assert (st.read_map(streamed).verdict.values == dataset.verdict.values).all()


@pytest.mark.few(6)
@pytest.mark.parametrize(
    ("words", "part"),
    [
        (["spectrum", "--at", "5"], "FAMILY is missing"),
        (["spectrum", UPRIGHT, "--at", "5"], "give --system examples/bicycle.py:upright instead"),
        (["spectrum", "rolling", "--system", UPRIGHT, "--at", "5"], "give one of them"),
        (["spectrum", "--system", UPRIGHT, "--at", "5"], "g is missing; give --set g=NUMBER"),
        (["spectrum", "--system", UPRIGHT, "--set", "g=9"], "v is missing"),
        (["spectrum", "--system", UPRIGHT], "v and g are missing; give --set v=NUMBER --set"),
        (["spectrum", "--system", UPRIGHT, "--at", "1,2"], "upright takes v, 1 number"),
        (["spectrum", "--system", UPRIGHT, "--at", "x"], "v is 'x'; a number such as 9.81"),
        (["spectrum", "--system", UPRIGHT, "--at", "inf"], "a finite number"),
        (["spectrum", "--system", UPRIGHT, "--at", "5", "--mu", "1"], "--mu belongs to the disk"),
        (["spectrum", "--system", UPRIGHT, "--lean", "0"], "--lean belongs to the disk"),
        (["spectrum", "--system", UPRIGHT, "--contact", "rough"], "--contact belongs to the disk"),
        (["spectrum", "--system", UPRIGHT, "--at", "5", "--set", "v=5"], "v is given by --at"),
        (["spectrum", "--system", UPRIGHT, "--at", "5", "--set", "h=5"], "upright has v, g"),
        (
            ["map", "--system", UPRIGHT, "--x", "v:1:2:3", "--y", "k:1:2:3", "--out", "m.nc"],
            "axis is 'k'; known for upright are v, g",
        ),
        (
            [
                "map",
                "--system",
                UPRIGHT,
                "--x",
                "v:1:2:3",
                "--y",
                "g:1:2:3",
                "--at",
                "1",
                "--out",
                "m.nc",
            ],
            "--at means v here",
        ),
        (
            [
                "map",
                "--system",
                UPRIGHT,
                "--x",
                "v:1:2:3",
                "--y",
                "g:1:2:3",
                "--set",
                "g=1",
                "--out",
                "m.nc",
            ],
            "g is given as a number and as an axis",
        ),
    ],
)
def test_bad_input_for_ones_own_system_ends_with_one_sentence(
    words: list[str], part: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(words) == 2
    said = capsys.readouterr().err
    assert part in said
    assert said.count("\n") == 1
    assert not Path("m.nc").exists()


def test_python_m_stability_is_the_same_program() -> None:
    done = run("spectrum", "tumbling", "--at", "0.5", "--mu", "0.3")
    assert done.returncode == 0
    assert done.stderr == ""
    assert "verdict     stable" in done.stdout


def test_the_version_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    from stability.base.version import __version__

    with pytest.raises(SystemExit) as stop:
        main(["--version"])
    assert stop.value.code == 0
    assert capsys.readouterr().out == f"stability {__version__}\n"


@pytest.mark.long
def test_a_terminal_without_unicode_is_no_obstacle() -> None:
    environment = dict(os.environ, PYTHONIOENCODING="ascii")
    done = subprocess.run(
        [sys.executable, "-m", "stability", "spectrum", "rolling", "--at", "-1e0", "--mu", "1"],
        capture_output=True,
        env=environment,
    )
    assert (done.returncode, done.stderr) == (0, b"")


@pytest.mark.long
def test_a_full_standard_output_is_said_so() -> None:
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "stability", *ASK], stdout=full, stderr=subprocess.PIPE
        )
    assert done.returncode == 2
    assert b"the output cannot be written" in done.stderr
    assert b"Traceback" not in done.stderr


# --- what it refuses ---

ASK = ["spectrum", "rolling", "--at", "1.2", "--mu", "0.3"]


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["spectrum", "rolling", "--at", "nan", "--mu", "0.3"], "at is nan; a finite number"),
        (["spectrum", "rolling", "--at", "inf", "--mu", "0.3"], "at is inf; a finite number"),
        (["spectrum", "rolling", "--at", "x", "--mu", "0.3"], "at is 'x'; a number is needed"),
        ([*ASK, "--k", "nan"], "k is nan"),
        ([*ASK, "--k", "0.6"], "(0, 1/2]"),
        ([*ASK, "--k", "0"], "(0, 1/2]"),
        ([*ASK, "--mass", "0"], "mass is 0; it must be positive"),
        ([*ASK, "--radius", "-1"], "radius is -1; it must be positive"),
        ([*ASK, "--gravity", "-9.81"], "gravity is -9.81; it must be positive"),
        (["spectrum", "rolling", "--at", "1", "--mu", "0"], "--contact smooth"),
        (["spectrum", "rolling", "--at", "1", "--mu", "-1"], "mu is -1"),
        (["spectrum", "rolling", "--at", "1"], "mu is missing"),
        (
            ["spectrum", "rolling", "--at", "1", "--mu", "1", "--disc", "quarter"],
            "--disc is not an option here; --disk is; see `stability spectrum --help`",
        ),
        (
            [
                "map",
                "tumbling",
                "--lean",
                "0",
                "--x",
                "mu:1:2:3",
                "--y",
                "k:.1:.2:3",
                "--out",
                "a.nc",
            ],
            "or --x lean:LO:HI:N; see `stability map --help`",
        ),
        ([*ASK, "--contact", "rough"], "has no coefficient"),
        ([*ASK, "--contact", "smooth"], "has no coefficient"),
        ([*ASK, "--contact", "glue"], "known are smooth, viscous, linear-viscous, rough"),
        ([*ASK, "--contact", "coulomb"], "inside the friction cone it is `rough`"),
        ([*ASK, "--lean", "0.1"], "not both"),
        (["spectrum", "rolling", "--lean", "0.1", "--mu", "1"], "lean names a member of tumbling"),
        (["spectrum", "tumbling", "--lean", "1.6", "--mu", "1"], "between -π/2 and π/2"),
        ([*ASK, "--disk", "penny"], "known are quarter"),
        ([*ASK, "--disk", "quarter", "--k", "0.3"], "give one of them"),
        (["spectrum", "hopping", "--at", "1", "--mu", "1"], "known are rolling, spinning"),
        (["spectrum", "tumbling", "--at", "0", "--mu", "1"], "strictly between 0 and π"),
        (["spectrum", "tumbling", "--at", "3.2", "--mu", "1"], "strictly between 0 and π"),
        (["spectrum", "circling", "--at", "1,1", "--mu", "1"], "rough disk"),
        (["spectrum", "circling", "--at", "1", "--contact", "rough"], "it holds (theta, phi_dot)"),
        (["spectrum", "circling", "--at", "1.2,0", "--contact", "rough"], "no admissible"),
        (["spectrum", "rolling", "--at", "1,2", "--mu", "1"], "rolling takes omega3, 1 number"),
        (["spectrum", "rolling", "--at", "-inf", "--mu", "1"], "at is -inf"),
        ([*ASK[:4], "--mu", "-1e-3"], "mu is -0.001"),
        (["table", "conditions", "--contact", "rough", "--mu", "0.3"], "no coefficient"),
        (["spectrum", "rolling"], "--at"),
        (
            ["table", "charts"],
            "known are families, conditions, drift, hopf, painleve, benchmarks, ",
        ),
        (["table", "families", "--k", "0.3"], "table conditions"),
        (["table", "conditions", "--k", "0.3,x"], "comma-separated"),
        (["table", "conditions", "--k", "0.7"], "(0, 1/2]"),
        (["table", "conditions", "--mu", "0"], "--contact smooth"),
        (["fly"], "invalid choice: 'fly'"),
    ],
)
def test_bad_questions_get_one_sentence(
    capsys: pytest.CaptureFixture[str], words: list[str], sentence: str
) -> None:
    assert sentence in refused(capsys, *words)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"--x": "at:1:2:1"}, "at least 2"),
        ({"--x": "at:2:1:5"}, "low end must be below"),
        ({"--x": "at:1:1:5"}, "low end must be below"),
        ({"--x": "at:nan:2:5"}, "finite"),
        ({"--x": "at:1:inf:5"}, "finite"),
        ({"--x": "at:1:2:5.5"}, "whole number"),
        ({"--x": "at:1:2"}, "NAME:LO:HI:N"),
        ({"--x": "at:1:2:5:log:x"}, "NAME:LO:HI:N"),
        ({"--x": "at:1:2:5:cubic"}, "'linear' or 'log'"),
        ({"--x": "at:-1:2:5:log"}, "starts above zero"),
        ({"--x": "depth:1:2:5"}, "known for rolling are at, omega3, k, mass"),
        ({"--x": "mu:1:2:5"}, "two different"),
        ({"--y": "mu:0:2:5"}, "--contact smooth"),
        ({"--y": "k:0.1:0.7:5", "--mu": "1"}, "(0, 1/2]"),
        ({"--y": "gravity:-1:3:5", "--mu": "1"}, "the disk has gravity and no mass"),
        ({"--y": "k:0.1:0.5:5"}, "mu is missing"),
        ({"--mu": "1"}, "given as --mu and as an axis"),
        ({"--at": "1"}, "given as --at and as an axis"),
        ({"--y": "k:0.1:0.5:5", "--mu": "1", "--k": "0.3"}, "given as --k and as an axis"),
        ({"--x": "k:0.1:0.5:5"}, "at is missing"),
        ({"--contact": "rough"}, "known for rolling are at, omega3, k, mass, radius, gravity"),
        ({"--plot": "map.txt"}, "must end in .png"),
        ({"--out": "map.png", "--plot": "map.png"}, "must end in .nc"),
        ({"--out": "."}, "is a folder"),
        ({"--out": "nowhere/map.nc"}, "does not exist"),
        ({"--levels": "99", "--certify": None}, "levels is 99"),
        ({"--levels": "9"}, "--levels belongs to --certify"),
        ({"--out": "/dev/full", "--force": None}, "not a regular file"),
        ({"--out": "/proc/map.nc"}, "cannot be written"),
    ],
)
def test_bad_maps_get_one_sentence_and_write_nothing(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    changes: dict[str, str | None],
    sentence: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    options = {"--x": "at:1:2:6", "--y": "mu:0.1:1:5", "--out": "map.nc"} | changes
    words = [w for pair in options.items() for w in pair if w is not None]
    assert sentence in refused(capsys, "map", "rolling", *words)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.long
def test_an_interrupted_map_is_gone_on_with(tmp_path: Path) -> None:
    words = [
        "map",
        "rolling",
        "--x",
        "at:0.5:3:2000",
        "--y",
        "mu:0.1:5:1500",
        "--out",
        str(tmp_path / "m.nc"),
        "--checkpoint",
        str(tmp_path / "kept"),
    ]
    process = subprocess.Popen(
        [sys.executable, "-m", "stability", *words], stderr=subprocess.PIPE, text=True
    )
    while process.poll() is None and len(list(tmp_path.glob("kept/*.npz"))) < 3:
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=300)
    assert process.returncode == 130
    assert "give the same command again" in errors
    assert [p.name for p in tmp_path.iterdir()] == ["kept"]


def test_tumbling_maps_end_before_the_disk_is_flat(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    words = [
        "map",
        "tumbling",
        "--x",
        "at:0:2:5",
        "--y",
        "mu:1:2:5",
        "--out",
        str(tmp_path / "m.nc"),
    ]
    assert "strictly between 0 and π" in refused(capsys, *words)


def test_nothing_is_overwritten_without_force(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    target = tmp_path / "map.nc"
    target.write_text("precious")
    assert "--overwrite" in refused(capsys, *MAP, "--out", str(target))
    assert target.read_text() == "precious"
    output(capsys, *MAP, "--out", str(target), "--force")
    folder = tmp_path / "atlas"
    folder.mkdir()
    (folder / "mine.txt").write_text("precious")
    assert "--overwrite" in refused(capsys, "atlas", "--out", str(folder))
    assert [p.name for p in folder.iterdir()] == ["mine.txt"]


def test_a_draft_of_the_atlas_of_bodies_is_refused(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    told = refused(capsys, "atlas", "--bodies", "--draft", "--out", str(tmp_path / "a"))
    assert "--draft belongs to the atlas of the disk" in told
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("resolution", ["0", "7", "x"])
def test_a_bad_resolution_is_refused(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, resolution: str
) -> None:
    out = str(tmp_path / "atlas")
    refused(capsys, "atlas", "--out", out, "--resolution", resolution)
    assert list(tmp_path.iterdir()) == []


def test_an_interruption_leaves_nothing(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ctrl-C while the picture is half written, and the map wholly."""
    whole = Path.write_bytes

    def half(draft: Path, content: bytes) -> int:
        written = whole(draft, content[:100])
        if draft.suffix == ".png":
            os.kill(os.getpid(), signal.SIGINT)
        return written

    monkeypatch.setattr(Path, "write_bytes", half)
    code = main([*MAP, "--out", str(tmp_path / "m.nc"), "--plot", str(tmp_path / "m.png")])
    errors = capsys.readouterr().err
    assert code == 130
    assert "interrupted; nothing was written" in errors
    assert "Traceback" not in errors
    assert list(tmp_path.iterdir()) == []


@pytest.mark.long
@pytest.mark.parametrize(
    "words", [["map", "tumbling", "--x", "at:0.01:1.5:400", "--y", "mu:0.1:5:400"], ["atlas"]]
)
def test_an_interruption_leaves_nothing_behind(tmp_path: Path, words: list[str]) -> None:
    for attempt in range(5):
        out = tmp_path / f"{attempt}" / ("out.nc" if words[0] == "map" else "out")
        out.parent.mkdir()
        process = subprocess.Popen(
            [sys.executable, "-m", "stability", *words, "--out", str(out)],
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        while process.poll() is None and not any(out.parent.iterdir()):
            time.sleep(0.02)  # what is written first shows that the work has begun
        if words == ["atlas"]:
            time.sleep(3)  # so that its workers are at work
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGINT)
        _, errors = process.communicate(timeout=300)
        if not out.exists():  # on a loaded machine the file may be whole before the signal comes
            break
    assert process.returncode == 130
    assert "interrupted; nothing was written" in errors
    assert "Traceback" not in errors
    assert list(out.parent.iterdir()) == []


def test_boundaries_of_a_system_are_printed_with_the_statement_that_they_are_all(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """λ² + (c - 1/10) λ + 1: the only change is at c = 1/10."""
    (tmp_path / "swing.py").write_text(
        "import casadi as ca, stability as st\n"
        "x, p = ca.SX.sym('x', 2), ca.SX.sym('p', 2)\n"
        "f = ca.vertcat(x[1], -x[0] - (p[0] - p[1]) * x[1])\n"
        "s = st.System('swing', x, p, f, states=('q', 'v'), parameters=('c', 'd'))\n"
        "rest = st.Family(s, 'rest', at=('c',), held={'q': 0, 'v': 0})\n"
    )
    words = ["boundaries", "--system", f"{tmp_path / 'swing.py'}:rest", "--axis", "c:-1:2:9"]
    found = json.loads(output(capsys, *words, "--set", "d=0.1", "--json"))
    [one] = found["boundaries"]
    assert abs(one["value"] - 0.1) <= one["error"] < 1e-15
    assert (one["crossing"], one["stable_below"]) == ("flutter", False)
    assert found["complete"]
    assert found["statement"].startswith("every change of verdict along c was found")
    text = output(capsys, *words, "--set", "d=0.1")
    assert "c = 0.1" in text
    assert found["statement"] in text
    assert main(words) == 2
    assert "'d' is missing" in capsys.readouterr().err
