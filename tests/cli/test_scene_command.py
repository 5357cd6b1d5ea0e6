"""`stability scene`: the examples, one JSON object, whole files, one sentence."""

import io
import json
import math
import re
from contextlib import redirect_stdout
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray
from command_line import output, refused
from matplotlib.text import Text
from random_body_scenes import columns

import stability as st
from stability.bodies.newton_euler import STATES
from stability.cli import main
from stability.figures.canvas import save_figure
from stability.scene.toml_file import titled

FOLDER = Path(__file__).parents[2] / "examples" / "scenes"
EXAMPLES = sorted(FOLDER.glob("*.toml"))
SMALL = """
[contact]
law = "viscous"
mu = 0.3
[start]
theta = 1.57
omega3 = 1.8
[question]
horizon = 2.0
tolerance = 1e-5
"""
"""A scene whose linear motion is enough."""
LINEAR = SMALL + 'quantities = ["growth_rate", "verdict"]\n'
NO_CONTACT = SMALL.replace("omega3 = 1.8", "theta_dot = 5.0")


def written(folder: Path, text: str) -> str:
    path = folder / "small.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


def strict(token: str) -> None:
    raise AssertionError(token)


def ask(capsys: pytest.CaptureFixture[str], *words: str) -> Any:
    return json.loads(output(capsys, "scene", *words, "--json"), parse_constant=strict)


@cache
def example(stem: str) -> Any:
    """The object that the command prints for an example, once for all tests."""
    with redirect_stdout(io.StringIO()) as text:
        assert main(["scene", str(FOLDER / f"{stem}.toml"), "--json"]) == 0
    return json.loads(text.getvalue(), parse_constant=strict)


def _same(found: Any, value: Any) -> bool:
    """Whether JSON gives a value of Python, where null is a number without bound or None."""
    if isinstance(value, dict):
        return set(found) == set(value) and all(_same(found[n], v) for n, v in value.items())
    if value is None or isinstance(value, str):
        return bool(found == value)
    return bool(found is None and not math.isfinite(value)) or bool(found == value)


@pytest.mark.few(1)
@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_an_example_prints_the_answer_of_python_in_both_forms(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, path: Path
) -> None:
    monkeypatch.setattr("time.perf_counter", lambda: 0.0)  # so that all three cost the same
    answer = st.Scene.from_toml(path).answer()
    found = ask(capsys, str(path))
    assert found["title"] == titled(path)[0]
    assert _same(found["value"], answer.value)
    assert _same(found["estimate"], answer.estimate)
    assert (found["model"], found["sentence"]) == (answer.model, answer.sentence)
    assert (found["until"], found["tolerance"]) == (answer.until, answer.tolerance)
    rungs = [(r["name"], r["chosen"], r["why"]) for r in found["rungs"]]
    assert rungs == [(r.name, r.chosen, r.why) for r in answer.rungs]
    text = output(capsys, "scene", str(path))
    head = "\n".join([found["title"], *answer.setting])
    assert text.startswith(f"{head}\n\n{answer.sentence}\n")
    for name, part in (answer.parts or {"": answer}).items():
        assert part.ladder().strip() in text
        if answer.parts:
            assert f"\n{name}: {part.sentence}\n" in text
            assert found["laws"][name]["model"] == part.model
    if answer.spread is not None:
        assert found["spread"]["contrary"] == list(answer.spread.contrary)
        assert found["spread"]["size"] == answer.spread.size


def _simulated(scene: st.Scene, law: Any) -> Any:
    return st.simulate(scene.disk, law, scene.start, scene.horizon, tolerance=1e-12, check=False)


@pytest.mark.few(1)
@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_an_example_is_answered_as_simulate_does_within_its_tolerance(path: Path) -> None:
    scene, found = st.Scene.from_toml(path), example(path.stem)
    several = isinstance(scene.contact, dict)
    disk = scene.disk
    length = float(disk.length if isinstance(disk, st.Body) else disk.radius)
    rate, speed = math.sqrt(disk.gravity / length), math.sqrt(disk.gravity * length)
    fixed = path.stem == "tippe-top"
    scale = np.array([1.0] * (3 if fixed else 1) + [rate] * 3 + [speed] * 2)
    for name, law in (scene.contact if several else {"": scene.contact}).items():
        value = found["value"][name] if several else found["value"]
        run = _simulated(scene, law)
        if "final" in value:
            truth = columns(run)[-1] / scale
            mine = np.array(list(value["final"].values())) / scale
            far = np.abs(mine - truth) / np.maximum(1.0, np.abs(truth))
            assert far.max() <= scene.tolerance
        if "outcome" in value:
            assert value["outcome"] == run.attrs["outcome"]
        if "lift_off_time" in value:
            end = float(run.end_time)
            assert value["lift_off_time"] == pytest.approx(end, rel=scene.tolerance)
            assert found["until"] == value["lift_off_time"]


def test_the_examples_show_what_their_comments_say(capsys: pytest.CaptureFixture[str]) -> None:
    """The numbers in the comments of the files, which nobody else checks."""
    coin = example("rolled-coin")["value"]
    rate = {n: v["final"]["theta_dot"] for n, v in coin.items()}
    unit = st.Disk.named("quarter").rate
    tolerance = example("rolled-coin")["tolerance"]
    for one, other in (("viscous", "linear"), ("dry", "rough")):
        assert abs(rate[one] - rate[other]) / unit < tolerance
    assert unit == pytest.approx(28.4, abs=0.05)
    assert abs(rate["viscous"] - rate["rough"]) == pytest.approx(0.06, abs=0.001)
    assert abs(rate["viscous"] - rate["rough"]) / unit == pytest.approx(0.0021, abs=5e-5)
    assert 8 < coin["smooth"]["largest_tilt"] / coin["rough"]["largest_tilt"] < 9
    models = {n: law["model"] for n, law in example("rolled-coin")["laws"].items()}
    assert models == {
        "viscous": "linearised",
        "linear": "linearised",
        "dry": "coulomb",
        "rough": "linearised",
        "smooth": "smooth",
    }
    spun = ask(capsys, str(FOLDER / "spun-coin.toml"), "--verify")
    assert spun["model"] == "linearised"
    assert spun["value"]["largest_tilt"] == pytest.approx(0.005, abs=1e-12)
    assert abs(math.pi / 2 - spun["value"]["final"]["theta"]) == pytest.approx(5e-5, rel=0.1)
    assert spun["true_error"]["final"] <= spun["estimate"]["final"]
    euler = example("eulers-disk")
    assert euler["model"] == "viscous"
    assert euler["value"]["largest_tilt"] == pytest.approx(0.97, abs=0.005)
    assert euler["value"]["settling_time"] == pytest.approx(35, abs=0.5)
    assert math.pi / 2 - euler["value"]["final"]["theta"] == pytest.approx(0.94, abs=0.005)
    assert euler["value"]["final"]["phi_dot"] == pytest.approx(42, abs=0.5)
    hoop = example("hoop-on-a-rough-floor")
    assert math.pi / 2 - hoop["value"]["final"]["theta"] == pytest.approx(0.227, abs=0.0005)
    assert abs(hoop["value"]["final"]["phi_dot"]) == pytest.approx(0.25, abs=0.005)
    assert hoop["model"] == "creep-2"
    assert hoop["spread"]["wasted"]
    assert hoop["spread"]["moves"]["final"]["omega3"] > 10 * hoop["spread"]["moves"]["final"]["mu"]
    near = example("near-threshold-roll")
    assert near["value"]["lift_off_time"] == pytest.approx(56.2, abs=0.05)
    assert near["spread"]["contrary"] == ["omega3"]
    assert near["spread"]["outcomes"]["omega3"] == ["lift-off", "moving"]
    top = example("tippe-top")["value"]
    assert (top["outcome"], round(top["final"]["axis_Z"], 6)) == ("settled", -1.0)
    assert top["final"]["omega_Z"] == pytest.approx(75, abs=2)
    slow, fast = (
        replace(st.Scene.from_toml(FOLDER / "tippe-top.toml"), start={"theta": 0.1, "omega3": w})
        for w in (20.0, 250.0)
    )
    assert slow.answer().value["final"]["axis_Z"] > 0.9
    assert fast.answer().value["outcome"] == "lift-off"
    stiff = example("stiff-launch")
    assert stiff["until"] == pytest.approx(0.134, abs=0.0005)
    assert stiff["estimate"]["lift_off_time"] < 1e-7


def test_numbers_have_their_units_and_no_more_digits_than_are_known(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = written(tmp_path, SMALL + 'quantities = ["final", "largest_tilt", "settling_time"]\n')
    text, found = output(capsys, "scene", path), ask(capsys, path)
    assert found["unit"].startswith("dimensionless")
    assert found["units"]["omega3"] == "√(g/R)"
    assert "omega3 [√(g/R)]" in text
    [row] = [line.split() for line in text.splitlines() if line.startswith("theta [rad]")]
    assert row[2] == f"{found['value']['final']['theta']:.7g}"  # the tolerance is 1e-5
    coin = written(tmp_path, SMALL.replace("1.8", "60.0") + '[disk]\nname = "quarter"\n')
    found = ask(capsys, coin)
    assert (found["unit"], found["units"]["slip_x"]) == ("SI", "m/s")
    row = rf"^omega3 \[rad/s\] +{found['value']['omega3']:.7g}$"
    assert re.search(row, output(capsys, "scene", coin), re.MULTILINE)


def test_one_rung_is_run_where_it_is_asked_for(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = written(tmp_path, SMALL)
    least, full = ask(capsys, path), ask(capsys, path, "--only", "viscous")
    assert (least["model"], full["model"]) == ("linearised", "viscous")
    assert [r["name"] for r in full["rungs"]] == ["viscous"]
    assert least["value"]["theta"] == pytest.approx(full["value"]["theta"], abs=1e-5)


def test_the_true_error_is_told_where_it_is_asked_for(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = written(tmp_path, SMALL)
    found, scene = ask(capsys, path, "--verify"), st.Scene.from_toml(path)
    assert found["true_error"] == scene.verify().true_error
    assert "true_error" not in ask(capsys, path)
    assert f"true error of final  {found['true_error']:.1e}" in output(
        capsys, "scene", path, "--verify"
    )


def test_a_start_that_no_rung_can_take_is_answered_so(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = written(tmp_path, NO_CONTACT)
    found = ask(capsys, path)
    assert (found["model"], found["value"], found["estimate"]) == ("none", None, None)
    assert found["sentence"].startswith("No rung can answer")
    head, _, said = output(capsys, "scene", path).partition("\n\n")
    assert (head.split("\n")[0], said) == ("small", f"{found['sentence']}\n")
    assert "theta_dot = 5 √(g/R)" in head


def test_the_page_begins_with_the_question(capsys: pytest.CaptureFixture[str]) -> None:
    head = output(capsys, "scene", str(FOLDER / "rolled-coin.toml")).split("\n")[1:4]
    assert head == [
        "disk: mass = 0.00567 kg, radius = 0.01213 m, gravity = 9.81 m/s², k = 0.25",
        "law viscous (F = -μ N v), mu = 20 s/m; law linear: linear-viscous "
        "(F = -c v, c = μ m g), mu = 20 s/m; law dry: coulomb (|F| = μ N), mu = 0.3; "
        "law rough (v = 0); law smooth (F = 0)",
        "start: theta = 1.56079633 rad, omega3 = 30 rad/s, all others 0; horizon 0.5 s; "
        "tolerance 0.001",
    ]


def test_a_word_is_certain_or_doubted_from_the_first_line_on(
    capsys: pytest.CaptureFixture[str],
) -> None:
    near = output(capsys, "scene", str(FOLDER / "near-threshold-roll.toml"))
    told = next(line for line in near.split("\n") if "answers" in line)
    assert "lift-off" in told
    assert "But the outcome is not determined" in told
    assert re.search(r"error of outcome +certain, for the inputs as given\n", near)
    stiff = output(capsys, "scene", str(FOLDER / "stiff-launch.toml"))
    assert re.search(r"error of outcome +certain\n", stiff)


# --- files ---


def test_the_motion_is_written_with_units_and_its_error(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path, target = written(tmp_path, SMALL), tmp_path / "motion.nc"
    found = ask(capsys, path, "--out", str(target))
    assert found["files"] == {"out": str(target)}
    assert found["value"] == ask(capsys, path)["value"]
    with xarray.open_dataset(target, engine="h5netcdf") as file:
        motion = file.load()
    assert motion.time.values[[0, -1]].tolist() == [0.0, 2.0]
    assert len(motion.time) > 100
    assert motion.omega3.attrs["unit_in_words"] == "√(g/R)"
    assert output(capsys, "cite", str(target)) == st.citation(motion).text + "\n"
    scene = st.Scene.from_toml(path)
    run = st.simulate(
        scene.disk, scene.contact, scene.start, motion.time.values[1:], tolerance=1e-12, check=False
    )
    for name in STATES:
        far = np.abs(motion[name].values[1:] - run[name].values)
        assert far.max() <= motion.error.values.max() <= scene.tolerance
    assert sorted(p.name for p in tmp_path.iterdir()) == ["motion.nc", "small.toml"]


def test_motions_under_several_laws_are_one_file(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    target = tmp_path / "laws.nc"
    text = output(capsys, "scene", str(FOLDER / "rolled-coin.toml"), "--out", str(target))
    assert text.endswith(f"\nwrote {target}\n")
    with xarray.open_dataset(target, engine="h5netcdf") as file:
        motion = file.load()
    assert motion.law.values.tolist() == ["viscous", "linear", "dry", "rough", "smooth"]
    assert "przybylska2016" in motion.attrs["citation"]
    parts = st.Scene.from_toml(FOLDER / "rolled-coin.toml").answer().parts
    for name, part in parts.items():
        assert part.path is not None
        assert np.array_equal(motion.sel(law=name).theta.values, part.path.theta.values)


def test_a_path_that_is_asked_for_is_columns_of_json(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = written(tmp_path, SMALL + 'quantities = ["path", "outcome"]\n')
    found, answer = ask(capsys, path)["value"], st.Scene.from_toml(path).answer()
    assert found["outcome"] == answer.value["outcome"]
    assert list(found["path"]) == ["time", *STATES, "error"]
    assert found["path"]["theta"] == answer.value["path"].theta.values.tolist()
    samples = len(answer.value["path"].time)
    assert f"\npath                {samples} samples\n" in output(capsys, "scene", path)


def test_a_file_is_whole_or_not_there(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, target = written(tmp_path, SMALL), tmp_path / "motion.nc"

    def full(*_: Any) -> bytes:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("stability.storage.netcdf.write", full)
        assert "No space left on device" in refused(capsys, "scene", path, "--out", str(target))
    assert not target.exists()
    target.write_text("mine")
    assert "exists" in refused(capsys, "scene", path, "--out", str(target))
    assert target.read_text() == "mine"
    output(capsys, "scene", path, "--out", str(target), "--force")
    assert target.read_bytes().startswith(b"\x89HDF")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["motion.nc", "small.toml"]


@pytest.fixture
def brief(monkeypatch: pytest.MonkeyPatch) -> None:
    """Charts without other laws and with few repeats: times are not looked at here."""
    monkeypatch.setattr("stability.scene.chart.other_laws", lambda *_: {})
    monkeypatch.setattr("stability.scene.chart.LEAST", 1)
    monkeypatch.setattr("stability.scene.chart.BUDGET", 0.0)


@pytest.mark.long
@pytest.mark.usefixtures("brief")
def test_the_chart_is_written_next_to_the_motion_and_shows_the_models_of_python(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, names = written(tmp_path, SMALL), [str(tmp_path / n) for n in ("run.nc", "run.svg")]
    figures: list[Any] = []

    def keep(figure: Any, draft: Path, **named: Any) -> None:
        figures.append(figure)
        save_figure(figure, draft, **named)

    monkeypatch.setattr("stability.figures.canvas.save_figure", keep)
    found = ask(capsys, path, "--out", names[0], "--plot", names[1])
    assert found["files"] == {"out": names[0], "plot": names[1]}
    assert sorted(p.name for p in tmp_path.iterdir()) == ["run.nc", "run.svg", "small.toml"]
    assert Path(names[1]).read_text(encoding="utf-8").startswith("<?xml")
    [drawn] = [{text.get_text() for text in figure.findobj(Text)} for figure in figures]
    assert {"steady", "linearised, chosen", "second-order", "viscous"} <= drawn
    assert "tolerance\n1e-05" in drawn


@pytest.mark.long
@pytest.mark.usefixtures("brief")
def test_the_motion_and_the_chart_are_both_written_or_neither(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, names = written(tmp_path, SMALL), [str(tmp_path / n) for n in ("run.nc", "run.png")]
    words = ["--out", names[0], "--plot", names[1]]

    def full(*_: Any, **__: Any) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("stability.figures.canvas.save_figure", full)
        assert "No space left on device" in refused(capsys, "scene", path, *words)
    assert [p.name for p in tmp_path.iterdir()] == ["small.toml"]
    Path(names[1]).write_text("mine")
    assert "exists" in refused(capsys, "scene", path, *words)
    assert Path(names[1]).read_text() == "mine"
    text = output(capsys, "scene", path, *words, "--force")
    assert text.endswith(f"\nwrote {names[0]}\nwrote {names[1]}\n")
    assert Path(names[1]).read_bytes().startswith(b"\x89PNG")


# --- what is refused ---


@pytest.mark.parametrize(
    ("text", "words", "sentence"),
    [
        (SMALL, ["--only", "magic"], "--only is 'magic'; known are steady, linearised"),
        (SMALL, ["--only", "rough"], "--only is 'rough'; known are"),
        (SMALL, ["--only", "viscous", "--verify"], "--verify and --only are both given"),
        (SMALL, ["--out", "a.png"], "the name must end in .nc"),
        (SMALL, ["--out", "no/such/a.nc"], "does not exist"),
        (SMALL, ["--plot", "a.nc"], "the name must end in .png, .pdf or .svg"),
        (SMALL, ["--plot", "no/such/a.png"], "does not exist"),
        (LINEAR, ["--plot", "a.png"], "the scene asks for growth_rate and verdict, of linear"),
        (NO_CONTACT, ["--plot", "a.png"], "the disk is not in contact"),
        (SMALL, ["--colour"], "--colour is not an option here"),
        (SMALL, ["more.toml"], "more.toml belongs to no option"),
        (SMALL + "[contact.rough]\n", [], "small.toml: [contact] has 'law' and the table 'rough'"),
        (SMALL + "nu = 1\n", [], "small.toml: [question] has 'nu'; known are horizon"),
        (SMALL + "horizon = 1\n", [], "Cannot overwrite a value (at line 11"),
        (SMALL.replace("1e-5", "3"), [], "tolerance is 3; give one from"),
        (SMALL.replace("1.57", "nan"), [], "theta of [start] is nan; a finite number"),
        (NO_CONTACT, ["--out", "a.nc"], "--out has no motion to write: No rung can answer"),
        ("", [], "small.toml is empty"),
    ],
)
def test_bad_questions_get_one_sentence_and_no_file(
    capsys: pytest.CaptureFixture[str],
    text: str,
    words: list[str],
    sentence: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    path = written(tmp_path, text)
    assert sentence in refused(capsys, "scene", path, *words)
    assert [p.name for p in tmp_path.iterdir()] == ["small.toml"]


@pytest.mark.parametrize("words", [["--verify"], ["--only", "rough"]])
def test_several_laws_are_neither_verified_nor_run_by_one_rung(
    capsys: pytest.CaptureFixture[str], words: list[str]
) -> None:
    told = refused(capsys, "scene", str(FOLDER / "rolled-coin.toml"), *words)
    assert words[0] in told
    assert "5 laws" in told


def test_no_file_is_a_refusal(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert "is not a file" in refused(capsys, "scene", str(tmp_path / "none.toml"))
    assert "required: FILE.toml" in refused(capsys, "scene")


def test_resistances_of_the_command_replace_those_of_the_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    resisted = "[resistance]\nrolling_resistance = 0.5\npivoting_resistance = 0.02\n"
    file = written(tmp_path, SMALL + resisted)
    found = ask(capsys, file, "--rolling-resistance", "0.05", "--air-torque", "0.01")
    against = [st.PivotingResistance(0.02), st.RollingResistance(0.05), st.AirTorque(0.01)]
    scene = st.Scene(
        contact=st.Viscous(0.3),
        start={"theta": 1.57, "omega3": 1.8},
        horizon=2.0,
        tolerance=1e-5,
        resistance=against,
    )
    assert found["value"] == pytest.approx(scene.answer().value, abs=1e-9)
    plain = ask(capsys, written(tmp_path, SMALL))
    assert plain["value"]["omega3"] > found["value"]["omega3"] + 1e-2
    said = refused(capsys, "scene", file, "--max-seconds", "0")
    assert "max_seconds is 0" in said
