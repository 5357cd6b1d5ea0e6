"""Cells are kept, processes may fail, and a report is whole or not there."""

import csv
import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import pytest
from figure_audit import faults
from matplotlib.figure import Figure

import stability as st
from stability.cli import main
from stability.compare import calls, plan, report, scenes
from stability.compare import failures as catalogue
from stability.compare.motion import chart as motion_chart
from stability.compare.spectrum import chart as spectrum_chart
from stability.compare.spectrum.points import classes
from stability.figures.canvas import COLUMN, save_figure
from stability.jobs import measured_cells as journal
from stability.jobs.measured_cells import CRASHED, DONE, LATE, REFUSED, Journal, Task, run

# functions of a task must be found by name in another process
SQUARE = "operator"


@pytest.fixture(scope="module", autouse=True)
def _soon_started() -> Iterator[None]:
    """Processes that are not made to import the integrator of an extra, which nothing here asks."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("stability.jobs.measured_cells.find_spec", lambda _: None)
        yield


def tasks(*rows: tuple[str, Any, tuple[Any, ...]], limit: float = 20.0) -> list[Task]:
    return [Task(key, function, arguments, limit) for key, function, arguments in rows]


def test_a_task_that_fails_takes_no_other_with_it(tmp_path: Path) -> None:
    import operator

    group = tasks(
        ("good", operator.add, (1, 2)),
        ("raises", operator.truediv, (1, 0)),
        ("dies", os._exit, (3,)),
        ("refuses", st.Viscous, (-1.0,)),
        ("after", operator.mul, (6, 7)),
    )
    group.insert(3, Task("sleeps", time.sleep, (60,), 0.3))
    cells = run([group], Journal(tmp_path / "a"))
    assert {k: c.status for k, c in cells.items()} == {
        "good": DONE,
        "raises": CRASHED,
        "dies": CRASHED,
        "sleeps": LATE,
        "refuses": REFUSED,
        "after": DONE,
    }
    assert (cells["good"].value, cells["after"].value) == (3, 42)
    assert cells["raises"].message == "ZeroDivisionError: division by zero"
    assert cells["dies"].message == "its process ended with code 3"
    assert "mu is -1" in cells["refuses"].message


def test_finished_cells_are_kept_and_not_done_again(tmp_path: Path) -> None:
    clock = [[Task("one", time.time, ()), Task("two", time.time, ())]]
    first = run(clock, Journal(tmp_path / "a"))
    path = tmp_path / "a" / journal.JOURNAL
    lines = path.read_text().splitlines()
    path.write_text("\n".join(lines[:2]) + '\n{"key": "tw')  # stopped in the middle of a line
    again = run(clock, Journal(tmp_path / "a"))
    assert again["one"].value == first["one"].value
    assert again["two"].value > first["two"].value


def test_a_line_cut_short_costs_that_cell_and_no_other(tmp_path: Path) -> None:
    clock = [[Task(n, time.time, ()) for n in ("one", "two", "three")]]
    first = run(clock, Journal(tmp_path / "a"))
    path = tmp_path / "a" / journal.JOURNAL
    path.write_text(path.read_text()[:-20])
    again = run(clock, Journal(tmp_path / "a"))
    assert {n: again[n].value == first[n].value for n in again} == {
        "one": True,
        "two": True,
        "three": False,
    }
    assert set(Journal(tmp_path / "a").pieces) == {"one", "two", "three"}


def test_a_journal_that_is_none_of_ours_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "r").mkdir()
    mine = tmp_path / "r" / journal.JOURNAL
    mine.write_text("my precious data")
    for force in (False, True):
        with pytest.raises(st.StabilityError, match="holds other files|is not a journal of ours"):
            report.report(tmp_path / "r", ["failures"], overwrite=force)
    assert mine.read_text() == "my precious data"
    mine.unlink()
    (tmp_path / "target").write_text("precious")
    mine.symlink_to(tmp_path / "target")
    with pytest.raises(st.StabilityError):
        report.report(tmp_path / "r", ["failures"])
    assert (tmp_path / "target").read_text() == "precious"


@pytest.mark.usefixtures("small")
def test_a_cell_that_cannot_be_read_gets_a_sentence(tmp_path: Path) -> None:
    groups = catalogue.tasks()
    for value in (5, [1], {}, {"mark": "odd", "digits": 1, "note": ""}):
        kept = Journal(tmp_path / "r")
        for task in (task for group in groups for task in group):
            kept.add(task.key, journal.Cell(task.key, DONE, value, "", 0.0))
        with pytest.raises(st.StabilityError, match="holds a cell that cannot be read"):
            report.report(tmp_path / "r", ["failures"])


@pytest.mark.long
def test_a_script_without_a_guard_gets_a_sentence(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text('import stability as st\nst.report("d", ["spectrum"])\n')
    done = subprocess.run(
        [sys.executable, str(script)],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        timeout=120,
        check=False,
    )
    assert done.returncode == 1
    assert "put that line under `if __name__ == '__main__':`" in done.stderr
    assert not Journal(tmp_path / "d").pieces


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ({"out": "a\0b"}, "leave out NUL"),
        ({"out": 5}, "give a string or a path"),
        ({"out": "x" * 300}, "cannot be used: File name too long"),
        ({"parts": "spectrum"}, "give a list of"),
        ({"parts": [5]}, "part is 5"),
        ({"parts": []}, "give a list of"),
        ({"workers": -1}, "workers is -1"),
        ({"workers": True}, "workers is True"),
        ({"progress": 5}, "progress is 5"),
    ],
)
def test_bad_arguments_get_a_sentence(
    arguments: dict[str, Any], expected: str, tmp_path: Path
) -> None:
    given: dict[str, Any] = {"out": tmp_path / "r"} | arguments
    with pytest.raises(st.StabilityError, match=expected):
        report.report(**given)
    assert not (tmp_path / "r").exists()


def test_a_journal_of_other_sources_is_begun_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = [[Task("one", time.time, ())]]
    first = run(clock, Journal(tmp_path / "a"))
    monkeypatch.setattr(journal, "fingerprint", lambda: "another")
    assert run(clock, Journal(tmp_path / "a"))["one"].value > first["one"].value


def test_groups_run_side_by_side_and_progress_is_told(tmp_path: Path) -> None:
    groups = [[Task(str(i), time.sleep, (0.02,))] for i in range(4)]
    seen: list[tuple[int, int]] = []
    run(groups, Journal(tmp_path / "a"), workers=2, progress=lambda d, t: seen.append((d, t)))
    assert seen[-1] == (4, 4)
    assert [d for d, _ in seen] == sorted(d for d, _ in seen)


def test_processes_are_fresh_for_each_group_alone(tmp_path: Path) -> None:
    groups = [[Task("a", os.getpid, ()), Task("b", os.getpid, ())], [Task("c", os.getpid, ())]]
    cells = {k: c.value for k, c in run(groups, Journal(tmp_path / "j")).items()}
    assert cells["a"] == cells["b"] != cells["c"]


def test_the_fingerprint_knows_the_sources_and_not_the_figures(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import shutil

    root = Path(st.__file__).parent
    copy = tmp_path / "stability"
    shutil.copytree(root, copy, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(journal, "__file__", str(copy / "jobs" / "measured_cells.py"))
    before = journal.fingerprint()
    (copy / "compare" / "page.py").write_text("# another page")
    assert journal.fingerprint() == before
    (copy / "maps" / "rates.py").write_text("# another kernel")
    assert journal.fingerprint() != before


# --- reports of a few cells ---


@pytest.fixture(params=["few", pytest.param("more", marks=pytest.mark.long)])
def small(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """A report of few routes, classes, scenes and cases, or of some more."""
    few = request.param == "few"
    routes = ("ad-1e-9", "spectrum") if few else ("ad-1e-9", "certified", "spectrum")
    names = ("open", "meeting") if few else tuple(classes())
    some = {name: classes()[name] for name in names}
    monkeypatch.setattr(spectrum_chart, "CHARTED", routes)
    monkeypatch.setattr(spectrum_chart, "classes", lambda: some)
    charted = {n: motion_chart.CHARTED[n] for n in ("gentle", "stiff-10000")[: 1 if few else 2]}
    drivers = ("simulate", "rk4", "rough-model")[: 2 if few else 3]
    monkeypatch.setattr(motion_chart, "CHARTED", charted)
    monkeypatch.setattr(motion_chart, "NAMES", drivers)
    if few:
        monkeypatch.setattr("stability.figures.canvas.FORMATS", (".png",))
        for module in (plan, report):  # each metric is one more figure
            monkeypatch.setattr(module, "METRICS", {"path": plan.METRICS["path"]})
        monkeypatch.setattr(motion_chart, "LIMIT", 2.0)  # what a cell has by then is kept
    some_calls = {n: calls.QUESTIONS[n] for n in ("spectrum", "boundaries")}
    monkeypatch.setattr(calls, "QUESTIONS", some_calls)
    monkeypatch.setattr(catalogue, "LIMIT", 60.0)  # a loaded machine is no fault of a method
    monkeypatch.setattr(catalogue, "ROUTE_NAMES", ("ad-raw", "sympy-solved", "spectrum"))
    monkeypatch.setattr(catalogue, "DRIVER_NAMES", ("rk4", "regularised", "simulate"))
    cases = {
        n: catalogue.CASES[n]
        for n in list(catalogue.CASES)[:1]
        + ["two structural zeros", "1/cosθ left by computer algebra", "non-steady operating point"]
    }
    motion = {n: catalogue.MOTION_CASES[n] for n in ("lifts off", "slides, then sticks")}
    if few:
        monkeypatch.setattr(scenes, "SCENES", {"sticky": scenes.SCENES["sticky"]})
    monkeypatch.setattr(catalogue, "CASES", cases)
    monkeypatch.setattr(catalogue, "MOTION_CASES", motion)


@pytest.mark.long
@pytest.mark.usefixtures("small")
def test_a_report_holds_figures_numbers_and_a_page(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "report"
    drawn: list[Figure] = []

    def keep(figure: Figure, path: Path, **named: Any) -> None:
        if path.suffix == ".png":  # the form that the page shows
            drawn.append(figure)
        save_figure(figure, path, **named)

    monkeypatch.setattr("stability.figures.canvas.save_figure", keep)
    assert main(["report", "--out", str(out), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["failures"]["misleading"] == []
    assert found["failures"]["marks"]["ad-raw"]["wrong"] >= 2
    page = (out / "index.html").read_text()
    for name in ("spectrum", "motion", "calls", "scenes", "failures"):
        for file in found[name]["files"]:
            assert Path(file).stat().st_size > 100
            assert Path(file).name in page
    assert found["scenes"]["models"]["sticky"]["chosen"] == "creep-2"
    for name, title in (("spectrum", "discs about eigenvalues"), ("rk4", "RK4 with a fixed step")):
        assert re.search(rf"<dt[^>]*>{name}</dt><dd>[^<]*{title}", page)
    # what may be wider than a phone scrolls within its box; figures are as wide as the page
    assert page.count("<table>") == page.count('<div class="scroll"><table>') > 0
    assert page.count("<img ") == page.count("<figure><img ") == len(drawn) > 8
    assert "figure img { width: 100%" in page
    assert {f.get_figwidth() for f in drawn} == {COLUMN}
    assert [said for f in drawn for said in faults(f)] == []
    assert found["machine"]["processor"] in page.replace("&amp;", "&")
    assert "stability " + st.__version__ in page
    assert not [p for p in out.iterdir() if p.name.startswith(".")]
    rows = list(csv.DictReader((out / "failures.csv").read_text().splitlines()))
    assert len(rows) == 4 * 3 + 2 * 3
    marks = {(r["case"], r["method"]): r["mark"] for r in rows}
    assert marks["two structural zeros", "ad-raw"] == "wrong"
    assert marks["non-steady operating point", "spectrum"] == "refused"
    assert marks["1/cosθ left by computer algebra", "sympy-solved"] in ("crashed", "wrong")
    assert marks["slides, then sticks", "rk4"] == ""
    assert marks["slides, then sticks", "simulate"] == "right"
    chart = motion_data_of(out / "motion.nc")
    # how many rungs and repeats a measurement has time for depends on what else runs
    assert chart.seconds.sel(scene="gentle", driver="rk4").notnull().sum() > 1
    assert plt.get_fignums() == []
    # told again, nothing is done again
    monkeypatch.setattr(
        "stability.figures.canvas.save_figure", lambda _, path, **__: path.write_text("x")
    )
    before = (out / journal.JOURNAL).read_text()
    assert main(["failures", "--out", str(out)]) == 0
    text = capsys.readouterr().out
    assert "default routes that mislead: 0" in text
    assert (out / journal.JOURNAL).read_text() == before
    assert main(["chart", "spectrum", "--out", str(out)]) == 0
    assert "on the Pareto front in" in capsys.readouterr().out


def motion_data_of(path: Path) -> Any:
    import xarray

    with xarray.open_dataset(path, engine="h5netcdf") as data:
        return data.load()


@pytest.mark.long
def test_scenes_are_charted_and_the_page_says_which_model_answers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(scenes, "SCENES", {"sticky": scenes.SCENES["sticky"]})
    monkeypatch.setattr("stability.figures.canvas.FORMATS", (".png",))
    monkeypatch.setattr("stability.scene.chart.LEAST", 1)
    monkeypatch.setattr("stability.scene.chart.BUDGET", 0.0)
    cell = journal.Cell("scenes/sticky", DONE, scenes.measure("sticky"), "", 0.0)
    Journal(tmp_path / "r").add(cell.key, cell)
    page = report.report(tmp_path / "r", ["scenes"]).read_text()
    rows = {
        row["model"]: row
        for row in csv.DictReader((tmp_path / "r" / "scenes.csv").read_text().splitlines())
    }
    assert [n for n, row in rows.items() if row["chosen"] == "yes"] == ["creep-2"]
    told = scenes.SCENES["sticky"][1].verify()
    assert float(rows["creep-2"]["true error"]) == pytest.approx(told.true_error, rel=1e-2)
    assert float(rows["rough"]["true error"]) > 1e-6  # the tolerance
    assert rows["linearised"]["true error"] == ""
    assert "slip follows the motion" in page and "sticky: creep-2" in page
    assert 'src="scenes-sticky.png"' in page


def test_the_cheapest_fine_model_is_named_where_it_is_not_taken() -> None:
    import numpy as np
    import xarray

    def made(costs: list[float], errors: list[float], chosen: int) -> xarray.Dataset:
        names, kinds = ["steady", "full", "rough law"], ["closed form", "full model", "other law"]
        return xarray.Dataset(
            {
                "cost": ("model", costs),
                "true_error": ("model", errors),
                "tolerance": 1e-3,
                "chosen": ("model", np.arange(3) == chosen),
            },
            {"model": names, "kind": ("model", kinds)},
        )

    good = made([1.0, 5.0, 0.1], [1e-4, 1e-9, 1e-9], 0)  # another law is no rung
    rash = made([1.0, 5.0, 0.1], [1e-2, 1e-9, 1e-2], 1)
    slow = made([1.0, 5.0, 0.1], [1e-4, 1e-9, 1e-2], 1)
    assert scenes.choice(good) == ("steady", "steady", 1.0)
    assert scenes.choice(rash) == ("full", "full", 1.0)
    assert scenes.choice(slow) == ("full", "steady", 5.0)
    said = scenes.sentence({"a": good, "b": rash, "c": slow})
    assert said.startswith("In 2 of 3 scenes")
    assert "c: full (5 times the time of steady)" in said


@pytest.mark.long
def test_a_subset_of_cases_and_methods_is_asked_and_shown(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("stability.figures.canvas.FORMATS", (".png",))
    out = tmp_path / "r"
    hoop = "hoop at 5° from flat: verdict"
    few = ["--cases", f"Lifts off: when,{hoop}", "--methods", "rk4,ad-1e-9,spectrum"]
    assert main(["failures", "--out", str(out), *few, "--json"]) == 0
    marks = json.loads(capsys.readouterr().out)["failures"]["marks"]
    assert {name: sum(m.values()) for name, m in marks.items()} == {
        "ad-1e-9": 1,
        "spectrum": 1,
        "rk4": 1,
    }
    rows = list(csv.DictReader((out / "failures.csv").read_text().splitlines()))
    assert [(r["case"], r["method"]) for r in rows] == [
        (hoop, "ad-1e-9"),
        (hoop, "spectrum"),
        ("lifts off: when", "rk4"),
    ]
    page = (out / "index.html").read_text()
    assert "<dt>rk4</dt>" in page and "<dt>radau</dt>" not in page
    assert "failures-ladder" not in page and "dips" not in (out / "failures.md").read_text()
    assert (
        main(["chart", "motion", "--out", str(out), "--cases", "gentle", "--methods", "rk4"]) == 0
    )
    assert capsys.readouterr().out.startswith("open ")  # no default route has a standing
    chart = motion_data_of(out / "motion.nc")
    assert (chart.scene.values.tolist(), chart.driver.values.tolist()) == (["gentle"], ["rk4"])
    st.report(out, ["spectrum"], cases="near", methods=["hurwitz"])
    lines = (out / "spectrum.csv").read_text().splitlines()
    assert [line.split(",")[:3] for line in lines[1:]] == [["near", "hurwitz", "done"]]
    page = (out / "index.html").read_text()
    assert "spectrum-verdict.png" in page and "spectrum-boundary" not in page


def test_names_of_a_subset_are_refused_with_those_known(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for words, expected in (
        (["chart", "spectrum", "--cases", "far"], "case is 'far'; known are open, near, very-near"),
        (["chart", "motion", "--methods", "ad"], "method is 'ad'; known are simulate, unchecked"),
        (["failures", "--cases", "fire"], "case is 'fire'; known are verdict at 10⁻¹…10⁻¹⁵ from"),
        (["failures", "--methods", "magic"], "method is 'magic'; known are mpmath, rk45, radau"),
        (["failures", "--methods", "rk4", "--cases", "Jordan"], "none of these methods is asked"),
    ):
        assert main([*words, "--out", str(tmp_path / "r")]) == 2
        said = capsys.readouterr().err
        assert said.startswith(f"stability: {expected}") or expected in said
        assert said.count("\n") == 1 and " … " not in said
    with pytest.raises(st.StabilityError, match=r"case is \[\]; give a list of names"):
        st.report(tmp_path / "r", cases=[])
    assert not (tmp_path / "r").exists()


@pytest.mark.few(1)
@pytest.mark.usefixtures("small")
@pytest.mark.parametrize("name", ["spectrum", "motion", "scenes", "failures"])
def test_a_part_of_which_no_cell_has_ended_has_a_page(name: str, tmp_path: Path) -> None:
    from stability.compare.page import write

    none = report.part(name, {})
    assert not none.plates
    report._write(tmp_path, none)
    text = write(tmp_path, [none]).read_text("utf-8")
    assert ("No cell of this part has ended" in text) is (name != "scenes")
    assert {path.name for path in tmp_path.iterdir()} == {"index.html", *none.data}


@pytest.mark.usefixtures("small")
def test_a_part_alone_makes_a_page_of_that_part(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(catalogue, "ROUTE_NAMES", ("ad-raw", "spectrum"))
    monkeypatch.setattr(catalogue, "DRIVER_NAMES", ("rk4", "simulate"))
    asked = ("two structural zeros", "non-steady operating point")
    monkeypatch.setattr(catalogue, "CASES", {n: catalogue.CASES[n] for n in asked})
    kept = Journal(tmp_path / "r")
    for task in (task for group in catalogue.tasks() for task in group):
        try:  # here, not in a process that must start
            cell = journal.Cell(task.key, DONE, task.function(*task.arguments), "", 0.0)
        except st.StabilityError as error:
            cell = journal.Cell(task.key, REFUSED, None, str(error), 0.0)
        kept.add(task.key, cell)
    page = st.report(tmp_path / "r", ["failures"])
    text = page.read_text()
    assert "Where methods fail" in text and "Work against precision" not in text
    rows = list(csv.DictReader((tmp_path / "r" / "failures.csv").read_text().splitlines()))
    marks = {(r["case"], r["method"]): r["mark"] for r in rows}
    assert marks["two structural zeros", "ad-raw"] == "wrong"
    assert marks["two structural zeros", "spectrum"] == "right"
    assert marks["non-steady operating point", "spectrum"] == "refused"
    assert marks["slides, then sticks", "simulate"] == "right"


def test_bad_input_gets_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("x")
    other = tmp_path / "other"
    other.mkdir()
    (other / "mine.txt").write_text("x")
    for words, expected in (
        (["chart", "spectra", "--out", "r"], "chart is 'spectra'; known are spectrum, motion."),
        (["chart", "spectrum"], "the following arguments are required: --out"),
        (["report", "--out", str(tmp_path / "file")], "is a file; give the name of a folder."),
        (["report", "--out", str(tmp_path / "no" / "r")], "does not exist; create it first."),
        (["failures", "--out", str(other)], "holds other files; choose another folder, or use"),
        (["failures", "--out", "r", "--workers", "0"], "--workers is 0; give a whole number"),
    ):
        try:
            code = main(words)
        except SystemExit as stop:
            code = int(str(stop.code))
        said = capsys.readouterr().err
        assert code == 2
        assert expected in said
        assert said.count("\n") == 1
    assert [p.name for p in other.iterdir()] == ["mine.txt"]
    with pytest.raises(st.StabilityError, match="part is 'all'; known are spectrum, motion"):
        report.report(tmp_path / "r", ["all"])
    assert not (tmp_path / "r").exists()


def test_an_interruption_names_its_folder_in_printable_characters(tmp_path: Path) -> None:
    def interrupt(*_: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt, match="finished cells are kept in") as caught:
        run([tasks(("one", time.time, ()))], Journal(tmp_path / "\x1b[31m"), progress=interrupt)
    assert str(caught.value).isprintable()


@pytest.mark.long
def test_an_interrupted_report_is_gone_on_with(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "stability", "chart", "spectrum", "--out", str(tmp_path / "r")]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, start_new_session=True)
    kept = tmp_path / "r" / journal.JOURNAL
    while process.poll() is None and (not kept.exists() or kept.read_text().count("\n") < 3):
        time.sleep(0.1)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does
    _, said = process.communicate(timeout=300)
    assert process.returncode == 130
    assert "finished cells are kept in" in said and "Traceback" not in said
    cells = Journal(tmp_path / "r").pieces
    assert len(cells) >= 2
    assert all(c.status == DONE for c in cells.values())
    assert [p.name for p in (tmp_path / "r").iterdir()] == [journal.JOURNAL]
