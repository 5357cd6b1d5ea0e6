"""Figures of the report, drawn from the example report's numbers, can be read in a column."""

import csv
import re
from collections import Counter
from collections.abc import Callable
from itertools import combinations
from pathlib import Path
from typing import Any

import matplotlib.colors as colours
import numpy as np
import pytest
import xarray
from figure_audit import faults, seen
from matplotlib.figure import Figure

from stability.base.looks import LOOKS as VERDICT_LOOKS
from stability.compare import failures as catalogue
from stability.compare import page
from stability.compare.figures import (
    LOOKS,
    OPEN,
    OWN,
    PALE,
    PEOPLE,
    SOLID,
    _shares_figure,
    boundary_figure,
    calls_figure,
    failure_figure,
    first_call_figure,
    ladder_figure,
    motion_figure,
    spectrum_figure,
    verdict_figure,
)
from stability.compare.marks import Mark
from stability.compare.motion.drivers import DRIVERS
from stability.compare.motion.reference_motions import scene
from stability.compare.plan import FAILURES, Part
from stability.compare.spectrum.cases import by_steps
from stability.compare.spectrum.routes import ROUTES
from stability.figures.canvas import COLUMN

EXAMPLE = Path(__file__).parents[2] / "docs" / "report"


def chart(name: str) -> xarray.Dataset:
    with xarray.open_dataset(EXAMPLE / f"{name}.nc", engine="h5netcdf") as data:
        return data.load()


@pytest.fixture(scope="module", params=["few", pytest.param("whole", marks=pytest.mark.long)])
def whole(request: pytest.FixtureRequest) -> bool:
    """Whether charts have all of their panels, or a few."""
    return bool(request.param == "whole")


@pytest.fixture(scope="module")
def motion(whole: bool) -> xarray.Dataset:
    data = chart("motion")
    timed = [bool(scene(s).ends or scene(s).events) for s in data.scene.values.tolist()]
    few = sorted({timed.index(True), timed.index(False)})
    return data if whole else data.isel(scene=few)


@pytest.fixture(scope="module")
def spectrum(whole: bool) -> xarray.Dataset:
    data = chart("spectrum")
    return data if whole else data.isel(hardness=[0, 6])


@pytest.fixture(scope="module")
def rows() -> list[dict[str, str]]:
    return list(csv.DictReader((EXAMPLE / "failures.csv").read_text().splitlines()))


@pytest.fixture(scope="module")
def cases() -> list[catalogue.Entry]:
    return catalogue.from_csv((EXAMPLE / "failures.csv").read_text())


def measured_calls() -> list[dict[str, Any]]:
    """The rows of the example report."""
    rows = csv.DictReader((EXAMPLE / "calls.csv").read_text().splitlines())
    return [r | {"error": float(r["error"]), "time [s]": float(r["time [s]"])} for r in rows]


class Drawn(dict[str, Figure]):
    """Figures by name, each drawn when it is first asked for."""

    def __init__(self, draw: dict[str, Callable[[], Figure]]) -> None:
        super().__init__()
        self.draw = draw

    def __missing__(self, name: str) -> Figure:
        self[name] = self.draw[name]()
        return self[name]


@pytest.fixture(scope="module")
def figures(
    spectrum: xarray.Dataset,
    motion: xarray.Dataset,
    cases: list[catalogue.Entry],
) -> Drawn:
    """Every figure of the report but those of scenes."""
    names = list(catalogue.ROUTE_NAMES)
    share = np.random.default_rng(1).dirichlet([3, 1, 1], size=(len(names), 15))
    heads = [str(d) for d in range(15)]
    draw: dict[str, Callable[[], Figure]] = {
        "verdict": lambda: verdict_figure(spectrum),
        "eigenvalues": lambda: spectrum_figure(spectrum),
        "boundary": lambda: boundary_figure(spectrum),
        "calls": lambda: calls_figure(measured_calls()),
        "path": lambda: motion_figure(motion, "path"),
        "event": lambda: motion_figure(motion, "event"),
        "first": lambda: first_call_figure(motion),
        "linear": lambda: failure_figure([e for e in cases if e.part == "linear"]),
        "motion": lambda: failure_figure([e for e in cases if e.part == "motion"]),
        "ladder": lambda: ladder_figure(cases),
        "other": lambda: _shares_figure(names, heads, share, marks=catalogue.STEPS, label="d"),
    }
    return Drawn(draw)


@pytest.mark.few(1)
@pytest.mark.parametrize(
    "name",
    [
        "verdict",
        "eigenvalues",
        "boundary",
        "calls",
        "path",
        "event",
        "first",
        "linear",
        "motion",
        "ladder",
        "other",
    ],
)
def test_no_text_overlaps_leaves_the_figure_or_is_small(figures: Drawn, name: str) -> None:
    assert faults(figures[name]) == []
    assert figures[name].get_figwidth() == COLUMN


def elsewhere(data: xarray.Dataset, rng: np.random.Generator, *names: str) -> xarray.Dataset:
    """A chart as measured on another machine: all times by a factor, and each by some more."""
    speed = rng.uniform(-1.5, 1.5)
    times = {n: 10 ** (speed + 0.5 * rng.normal(size=data[n].shape[:2])) for n in names}
    return data.assign(
        {
            n: data[n].copy(
                data=data[n].values * f.reshape(f.shape + (1,) * (data[n].ndim - f.ndim))
            )
            for n, f in times.items()
        }
    )


@pytest.mark.few(1)
@pytest.mark.parametrize("seed", [140, 157, 160, *range(200, 300)])
def test_no_text_overlaps_on_a_machine_of_another_speed(
    spectrum: xarray.Dataset, motion: xarray.Dataset, seed: int, whole: bool
) -> None:
    rng = np.random.default_rng(seed)
    kinds = rng.permutation(spectrum.hardness.values)[: rng.integers(1, 5)]
    of_spectra = elsewhere(spectrum, rng, "one", "many", "boundary_seconds").sel(hardness=kinds)
    scenes = rng.permutation(motion.scene.values)[: rng.integers(1, 5)]
    of_motion = elsewhere(motion, rng, "seconds", "first").sel(scene=scenes)
    draw: list[Callable[[], Figure]] = [
        lambda: motion_figure(of_motion.isel(scene=slice(None if whole else 1)), "path"),
        lambda: first_call_figure(of_motion),
        lambda: spectrum_figure(of_spectra),
        lambda: boundary_figure(of_spectra),
    ]
    for one in draw if whole else draw[:2]:
        assert faults(one()) == []


def test_every_method_is_known_by_its_shape_and_every_mark_by_its_shade() -> None:
    """So that nothing is lost in grey or with a deficiency of colour vision."""
    shapes = [(look["marker"], look.get("mfc", "")) for look in LOOKS.values()]
    assert len(set(shapes)) == len(shapes)
    for (one, hatch), (other, another) in combinations(
        [VERDICT_LOOKS[m.word].cell for m in Mark], 2
    ):
        if hatch == another:
            a, b = seen(one), seen(other)
            assert all(np.linalg.norm(a[kind] - b[kind]) > 20 for kind in a), (one, other)
    for colour in (OWN, PEOPLE):  # named routes stand out from the grey of all others
        a, b = seen(colour), seen(PALE)
        assert all(abs(a[kind][0] - b[kind][0]) > 15 for kind in a)


def test_scenes_without_the_error_have_no_panel(motion: xarray.Dataset, figures: Drawn) -> None:
    timed = [s for s in motion.scene.values.tolist() if scene(s).ends or scene(s).events]
    assert 0 < len(timed) < motion.sizes["scene"]
    assert len(figures["event"].axes) == len(timed)
    for name in ("path", "event", "eigenvalues"):
        assert all(len(axes.lines) > 2 for axes in figures[name].axes)


def test_colour_is_for_the_front_and_the_references(motion: xarray.Dataset, figures: Drawn) -> None:
    for which, axes in zip(motion.scene.values.tolist(), figures["path"].axes, strict=True):
        here = motion.sel(scene=which)
        right = here.outcome.values == str(here.true_outcome.values)
        runs = [
            (name, np.nanmin(here.seconds.values[i, j]), max(here.path.values[i, j], 1e-16))
            for i, name in enumerate(here.driver.values.tolist())
            for j in np.flatnonzero(right[i] & np.isfinite(here.path.values[i]))
        ]
        front = {n for n, t, e in runs if e < 0.1 and not any(s < t and f <= e for _, s, f in runs)}
        expected = (front | {"simulate", "rk45"}) & {n for n, _, _ in runs}
        grey = [ln for ln in axes.lines if colours.same_color(ln.get_color(), PALE)]
        assert len(axes.lines) - len(grey) - 1 == len(expected), which  # one is the front
        assert len(grey) + len(expected) == len({n for n, _, _ in runs})


def test_a_share_of_a_row_is_a_share_of_the_cases(
    rows: list[dict[str, str]], figures: Drawn
) -> None:
    axes = figures["linear"].axes[0]
    names = [t.get_text() for t in axes.get_yticklabels()]
    heads = [re.sub(r"\s+", " ", t.get_text()) for t in axes.get_xticklabels()]
    place = axes.get_yticks()[names.index("sympy-solved")]
    mine = [r for r in rows if r["method"] == "sympy-solved"]
    asked, crashed = (
        Counter(r["group"] for r in some)
        for some in (mine, [r for r in mine if r["mark"] == "crashed"])
    )
    assert heads == [f"{group} ({count})" for group, count in asked.items()]
    for column, group in enumerate(asked):
        black = sum(
            p.get_width()
            for p in axes.patches
            if tuple(p.get_facecolor()) == (0, 0, 0, 1)
            and abs(p.get_x() + p.get_width() / 2 - column) < 0.5
            and abs(p.get_y() + p.get_height() / 2 - place) < 0.1
        )
        assert black == pytest.approx(0.92 * crashed[group] / asked[group])


def test_the_page_says_why_a_method_crashes(cases: list[catalogue.Entry], tmp_path: Path) -> None:
    text = page.write(tmp_path, [Part(FAILURES, (), {}, cases)]).read_text()
    found = dict(re.findall(r"<dt>([\w-]+): (\d+ of \d+) cases</dt>", text))
    crashed = Counter(e.method for e in cases if e.mark is Mark.CRASHED)
    asked = Counter(e.method for e in cases if e.mark is not None)
    assert found == {name: f"{n} of {asked[name]}" for name, n in crashed.items()}
    assert "divides by cos θ and by μ v_y" in text
    methods: dict[str, Any] = {**ROUTES, **DRIVERS}
    assert all(methods[name].flaw for name in crashed)


def test_sympy_divides_by_what_the_page_names() -> None:
    """The pivots of the elimination, in an exact decomposition of the same equations."""
    import sympy

    from stability.compare.spectrum.sympy_disk import K, X, residual

    equations, unknowns, _ = residual("viscous")
    mass, _ = sympy.linear_eq_to_matrix(list(equations), unknowns)
    _, upper, _ = mass.LUdecomposition()
    pivots = [sympy.factor(upper[i, i]) for i in range(len(unknowns))]
    assert pivots[0] == sympy.cos(X[0])
    assert [p for p in pivots[:-1] if p.subs({X[4]: 0, X[5]: 0}) == 0] == [
        sympy.factor(sympy.Symbol("mu") * X[5] * (1 + 2 * K))
    ]


def test_letters_of_every_boundary_say_what_its_remark_says(cases: list[catalogue.Entry]) -> None:
    asked = [c for c in cases if c.steps]
    assert len(asked) > 200 and {len(c.steps) for c in asked} == {15}
    for one in asked:
        held, first = len(one.steps) - len(one.steps.lstrip("r")), one.steps.find("w") + 1
        assert one.note.startswith(f"right to 1e-{held}" if held else "right at no distance")
        told = f"wrong at {one.steps.count('w')} of 15 distances, the farthest 1e-{first}"
        assert (told in one.note) == bool(first) == ("wrong" in one.note), one
    counts = catalogue.ladder(cases)
    edges = len({c.case for c in asked})
    assert [c["right"] for c in counts["spectrum"]] == [edges] * 15
    assert sum(c["wrong"] for row in counts.values() for c in row) == sum(
        c.steps.count("w") for c in asked
    )


def test_a_method_has_one_colour_in_every_chart() -> None:
    """What people use is blue, the package's default vermilion; no mark of an answer is either."""
    assert {LOOKS[name]["color"] for name in ("rk45", "rk4")} == {PEOPLE}
    assert {LOOKS[name]["color"] for name in ("simulate", "unchecked")} == {OWN}
    others = {look["color"].lower() for look in LOOKS.values()} - {OWN, PEOPLE}
    assert len(others) == len(LOOKS) - 4
    marks = {VERDICT_LOOKS[m.word].cell[0] for m in Mark}
    assert not marks & {OWN, PEOPLE}
    assert OWN not in (SOLID["mec"], OPEN["mec"])


def test_misses_at_the_last_digits_are_told_by_how_often_and_how_far() -> None:
    far = by_steps(["right"] * 3 + ["wrong"] + ["right"] * 11)
    assert far.mark is Mark.WRONG and far.note.endswith(
        "wrong at 1 of 15 distances, the farthest 1e-4"
    )
    near = by_steps(["right"] * 13 + ["wrong", "wrong"])
    assert near.mark is Mark.DEGRADED and near.digits == 13
    assert near.note.endswith("wrong at 2 of 15 distances, the farthest 1e-14")
    assert by_steps(["right"] * 15).mark is Mark.RIGHT
    assert by_steps(["undecided"] * 15).mark is Mark.UNDECIDED
