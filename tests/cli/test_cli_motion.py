"""`stability simulate`: the contract's object, whole files, one sentence."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
import reference
from command_line import output, refused

import stability as st
from stability.bodies.newton_euler import STATES
from stability.motion.result import Outcome

ASK = ["simulate", "--theta", "1.4707963267948966", "--omega3", "1.2", "--mu", "0.3"]


def test_simulate_prints_the_object_of_the_contract(capsys: pytest.CaptureFixture[str]) -> None:
    case = reference.trajectories()[0]
    found = json.loads(output(capsys, *ASK, "--time", "20", "--tolerance", "1e-12", "--json"))
    assert list(found)[:4] == ["final", "time", "outcome", "energy_error"]
    assert list(found["final"]) == list(STATES)
    assert found["time"] == 20.0
    assert found["outcome"] in {o.word for o in Outcome}
    assert found["energy_error"] < 1e-11
    final = np.array(list(found["final"].values()))
    assert np.abs(final - np.array(case["states"][-1])).max() < 1e-9


@pytest.mark.few(3)
@pytest.mark.parametrize(
    ("words", "outcome"),
    [
        (["--contact", "smooth", "--theta", "1", "--time", "5"], "flat"),
        (
            ["--theta", "1", "--omega3", "-5", "--phi-dot", "5", "--mu", "3", "--time", "3"],
            "lift-off",
        ),
        (["--theta", "1.5", "--phi-dot", "2.5", "--mu", "0.3", "--time", "300"], "settled"),
        (["--theta", "1.2", "--contact", "rough", "--omega3", "1", "--time", "3"], "moving"),
        (
            [
                "--theta",
                ".8653",
                "--theta-dot",
                ".3",
                "--phi-dot",
                ".6318",
                "--omega3",
                "1.59",
                "--k",
                ".05",
                "--mu",
                ".947",
                "--contact",
                "coulomb",
                "--time",
                "1",
            ],
            "non-unique",
        ),
        (
            [*ASK[1:], "--contact", "coulomb-regularised", "--epsilon", "1e-3", "--time", "2"],
            "moving",
        ),
    ],
)
def test_each_outcome_is_told_with_its_evidence(
    capsys: pytest.CaptureFixture[str], words: list[str], outcome: str
) -> None:
    found = json.loads(output(capsys, "simulate", *words, "--json"))
    assert found["outcome"] == outcome
    assert found["evidence"]
    text = output(capsys, "simulate", *words)
    assert text.startswith(f"outcome   {outcome}:")
    assert "energy    audited to" in text


def test_files_are_whole_and_say_what_was_printed(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    names = [str(tmp_path / n) for n in ("run.nc", "run.png", "run.html")]
    found = json.loads(
        output(
            capsys,
            *ASK,
            "--time",
            "1",
            "--points",
            "21",
            "--contact",
            "coulomb",
            "--slip-x",
            "0.2",
            "--out",
            names[0],
            "--plot",
            names[1],
            "--film",
            names[2],
            "--json",
        )
    )
    run = st.read_motion(names[0])
    assert len(run.time) == 21
    assert found["final"]["theta"] == float(run.theta[-1])
    assert [e["kind"] for e in found["events"]] == run.event_kind.values.tolist()
    assert found["files"] == {"out": names[0], "plot": names[1], "film": names[2]}
    assert sorted(p.name for p in tmp_path.iterdir()) == ["run.html", "run.nc", "run.png"]
    assert Path(names[1]).stat().st_size > 10_000


def test_si_numbers_go_in_and_come_out(capsys: pytest.CaptureFixture[str]) -> None:
    disk = st.Disk.named("quarter")
    rate = float(disk.rate)
    si = json.loads(
        output(
            capsys,
            "simulate",
            "--disk",
            "quarter",
            "--theta",
            "1.4",
            "--omega3",
            str(1.2 * rate),
            "--mu",
            str(0.3 / float(disk.speed)),
            "--time",
            str(5 / rate),
            "--tolerance",
            "1e-12",
            "--json",
        )
    )
    plain = json.loads(
        output(
            capsys,
            "simulate",
            "--theta",
            "1.4",
            "--omega3",
            "1.2",
            "--mu",
            "0.3",
            "--time",
            "5",
            "--tolerance",
            "1e-12",
            "--json",
        )
    )
    assert si["unit"] == "SI"
    assert si["final"]["omega3"] == pytest.approx(plain["final"]["omega3"] * rate, rel=1e-8)
    assert si["final"]["theta"] == pytest.approx(plain["final"]["theta"], abs=1e-8)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["simulate", "--mu", "1", "--time", "1"], "--theta is missing"),
        ([*ASK], "--time is missing"),
        ([*ASK, "--time", "0"], "times is 0"),
        ([*ASK, "--time", "nan"], "times is nan"),
        ([*ASK, "--time", "x"], "'x' is no number; give one such as 0.25 or 1/4"),
        ([*ASK, "--time", "1", "--points", "1"], "at least 2 points"),
        ([*ASK, "--time", "-1", "--points", "9"], "a finite time above 0"),
        ([*ASK, "--time", "1", "--method", "euler"], "method is 'euler'"),
        ([*ASK, "--time", "1", "--tolerance", "2"], "tolerance is 2"),
        ([*ASK, "--time", "1", "--contact", "glue"], "known are smooth, viscous, linear-viscous"),
        ([*ASK, "--time", "1", "--contact", "rough"], "has no coefficient"),
        ([*ASK, "--time", "1", "--epsilon", "1e-3"], "epsilon is given but"),
        ([*ASK, "--time", "1", "--contact", "coulomb-regularised"], "epsilon is missing"),
        (["simulate", "--theta", "1", "--time", "1"], "mu is missing"),
        (["simulate", "--theta", "0", "--mu", "1", "--time", "1"], "strictly between 0 and π"),
        (["simulate", "--theta", "1", "--mu", "3", "--slip-x", "30", "--time", "1"], "Painlevé"),
        (
            ["simulate", "--theta", "1", "--theta-dot", "5", "--mu", "1", "--time", "1"],
            "not in contact",
        ),
        ([*ASK, "--time", "1", "--plot", "run.txt"], "must end in .png, .pdf or .svg"),
        ([*ASK, "--time", "1", "--film", "run.avi"], "must end in .gif, .mp4 or .html"),
        ([*ASK, "--time", "1", "--out", "a.nc", "--plot", "./a.nc"], "must end in"),
        ([*ASK, "--time", "1", "--out", "no/such/run.nc"], "does not exist"),
        ([*ASK, "--time", "1", "--family", "rolling"], "--family is not an option here; give the"),
        ([*ASK, "--time", "1", "--points", "2.5"], "'2.5' is no whole number"),
        (["table", "launches"], "table is 'launches'; known are families"),
        (["table", "families", "--at", "3"], "at belongs to `table codimension` only"),
    ],
)
def test_bad_questions_get_one_sentence_and_no_file(
    capsys: pytest.CaptureFixture[str],
    words: list[str],
    sentence: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert sentence in refused(capsys, *words)
    assert list(tmp_path.iterdir()) == []


# --- a system of one's own ---

SWING = """
import casadi as ca, stability as st
x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
swing = st.System(
    "swing", x, p, ca.vertcat(x[1], -p[0] * x[0] - p[1] * x[1]), states=("q", "v"),
    parameters=("k", "c"), units={"q": "m", "v": "m/s"},
    observables={"energy": (p[0] * x[0] ** 2 + x[1] ** 2) / 2, "power": p[1] * x[1] ** 2},
)
rest = st.Family(swing, "rest", at=("k",), held={"q": 0, "v": 0})
alone = st.System("alone", x[0], p[0], -p[0] * x[0], states=("q",), parameters=("k",))
plain = st.System.from_function(lambda x, p: -x, name="plain", states=("q",))
number = 3
"""


@pytest.fixture
def swing(tmp_path: Path) -> str:
    (tmp_path / "swing.py").write_text(SWING)
    return str(tmp_path / "swing.py")


def start_swing(place: str) -> list[str]:
    return [
        "simulate",
        "--system",
        place,
        "--start",
        "q=1/10,v=0",
        "--set",
        "k=4",
        "--set",
        "c=0.4",
    ]


@pytest.mark.long
@pytest.mark.parametrize("name", ["swing", "rest"])
def test_simulate_takes_ones_own_system_or_a_family_of_it(
    capsys: pytest.CaptureFixture[str], swing: str, tmp_path: Path, name: str
) -> None:
    """The closed form: q = e^(-ct/2) (cos wt + c/(2w) sin wt) / 10 with w² = k - c²/4."""
    words = [*start_swing(f"{swing}:{name}"), "--time", "10", "--tolerance", "1e-12"]
    files = [str(tmp_path / n) for n in ("run.nc", "run.png")]
    found = json.loads(output(capsys, *words, "--out", files[0], "--plot", files[1], "--json"))
    w = math.sqrt(4 - 0.04)
    q = math.exp(-2) * (math.cos(10 * w) + 0.2 / w * math.sin(10 * w)) / 10
    assert found["final"]["q"] == pytest.approx(q, abs=1e-12)
    assert list(found)[:4] == ["final", "time", "outcome", "energy_error"]
    assert found["energy_error"] < 1e-11
    assert (found["system"], found["parameters"]) == ("swing", {"k": 4.0, "c": 0.4})
    assert found["units"] == {"time": "s", "q": "m", "v": "m/s"}
    assert (found["nearest"]["family"], found["nearest"]["member"]) == ("rest", {"q": 0, "v": 0})
    assert float(st.read_motion(files[0]).q[-1]) == found["final"]["q"]
    assert Path(files[1]).stat().st_size > 10_000
    assert found["files"] == {"out": files[0], "plot": files[1]}
    text = output(capsys, *start_swing(f"{swing}:{name}"), "--time", "60")
    assert text.startswith("outcome   settled:")
    assert "time      60 s\nfinal     q = " in text
    assert " from rest at k = 4" in text


def test_a_system_without_families_runs_without_a_nearest_motion(
    capsys: pytest.CaptureFixture[str], swing: str
) -> None:
    words = ["simulate", "--system", f"{swing}:alone", "--start", "q=1", "--set", "k=1"]
    found = json.loads(output(capsys, *words, "--time", "2", "--points", "3", "--json"))
    assert found["final"]["q"] == pytest.approx(math.exp(-2), rel=1e-8)
    assert found["nearest"] is None
    assert found["energy_error"] is None
    assert "energy " not in output(capsys, *words, "--time", "2")


@pytest.mark.parametrize(
    ("name", "words", "sentence"),
    [
        ("rest", ["--time", "1"], "--start is missing; give NAME=NUMBER for each state"),
        ("rest", [], "--start and --time are missing; give NAME=NUMBER for each state, and a last"),
        (
            "rest",
            ["--start", "q=1,v=0", "--time", "1"],
            "k and c are missing; give --set k=NUMBER --set c=NUMBER",
        ),
        ("rest", ["--start", "q=0.1,v=0"], "--time is missing"),
        (
            "rest",
            ["--start", "q=0.1", "--time", "1", "--set", "k=4", "--set", "c=1"],
            "start does not name v; give q, v",
        ),
        ("rest", ["--start", "q=0.1,w=0", "--time", "1"], "--start names 'w'; swing has q, v"),
        ("rest", ["--start", "q=0.1,q=0", "--time", "1"], "q is given twice"),
        ("rest", ["--start", "q=x,v=0", "--time", "1"], "q is 'x'; a number such as"),
        ("rest", ["--start", "0.1,0", "--time", "1"], "--start is '0.1'; give NAME=NUMBER"),
        (
            "rest",
            ["--start", "q=0.1,v=0", "--time", "1", "--set", "k=4"],
            "c is missing; give --set c=NUMBER",
        ),
        (
            "rest",
            ["--start", "q=0.1,v=0", "--time", "1", "--set", "m=4"],
            "--set names 'm'; swing has k, c",
        ),
        (
            "rest",
            ["--start", "q=0.1,v=0", "--theta-dot", "0", "--time", "1"],
            "--theta-dot belongs to the disk",
        ),
        (
            "rest",
            ["--start", "q=0.1,v=0", "--time", "1", "--film", "f.html"],
            "--film belongs to the disk",
        ),
        ("number", ["--start", "q=1", "--time", "1"], "'number' is no system and no family of"),
        ("number", ["--start", "q=1", "--time", "1"], "these are alone, plain, rest, swing"),
        (
            "plain",
            ["--start", "q=1", "--time", "1", "--method", "heyoka"],
            "which takes no Python function; give dop853",
        ),
    ],
)
def test_bad_launches_of_ones_own_system_get_one_sentence(
    capsys: pytest.CaptureFixture[str], swing: str, name: str, words: list[str], sentence: str
) -> None:
    assert sentence in refused(capsys, "simulate", "--system", f"{swing}:{name}", *words)


def test_start_by_name_is_for_a_system(capsys: pytest.CaptureFixture[str]) -> None:
    assert "--start belongs to --system" in refused(capsys, *ASK, "--start", "q=1", "--time", "1")


def test_an_existing_file_is_kept_unless_forced(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    target = tmp_path / "run.nc"
    target.write_text("mine")
    assert "exists" in refused(capsys, *ASK, "--time", "1", "--out", str(target))
    assert target.read_text() == "mine"
    output(capsys, *ASK, "--time", "1", "--out", str(target), "--force")
    assert st.read_motion(target).attrs["outcome"] == "moving"
