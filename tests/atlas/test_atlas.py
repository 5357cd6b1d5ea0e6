"""The atlas holds what its page shows, whole."""

import csv
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
import xarray

import stability as st
from stability.atlas.build import COLUMNS, LAUNCHED, TIME, _diagram, atlas, zeros_of_rates
from stability.atlas.page import BODIES, drawn
from stability.atlas.page import LOCUS_FRICTION as EVERY_FRICTION
from stability.storage.html import STYLE


@pytest.fixture(
    scope="module",
    params=["undrawn", *[pytest.param(n, marks=pytest.mark.long) for n in ("hoop", "all")]],
)
def kind(request: pytest.FixtureRequest) -> str:
    """One body without its figures, one body, or all."""
    return str(request.param)


@pytest.fixture(scope="module")
def bodies(kind: str) -> tuple[str, ...]:
    return tuple(BODIES) if kind == "all" else ("hoop",)


@pytest.fixture(scope="module")
def resolution(kind: str) -> int:
    return 8 if kind == "undrawn" else 16


@pytest.fixture(scope="module")
def launched(kind: str) -> tuple[tuple[str, ...], float]:
    """Families near which launches start, and the last time."""
    return (LAUNCHED[:1], 20.0) if kind == "undrawn" else (LAUNCHED, TIME)


def frictions(bodies: tuple[str, ...]) -> tuple[float, ...]:
    """Of the loci: one for one body, which saves three figures."""
    return EVERY_FRICTION if len(bodies) > 1 else EVERY_FRICTION[:1]


@pytest.fixture(scope="module")
def folder(
    kind: str,
    bodies: tuple[str, ...],
    resolution: int,
    launched: tuple[tuple[str, ...], float],
    tmp_path_factory: pytest.TempPathFactory,
) -> Path:
    out = tmp_path_factory.mktemp("atlas") / "atlas"
    told: list[tuple[int, int]] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("stability.atlas.build.BODIES", {name: BODIES[name] for name in bodies})
        patch.setattr("stability.atlas.build.LOCUS_FRICTION", frictions(bodies))
        patch.setattr("stability.atlas.build.LAUNCHED", launched[0])
        patch.setattr("stability.atlas.build.TIME", launched[1])
        if kind == "undrawn":
            undraw(patch)
        page = atlas(
            out,
            resolution=resolution,
            draft=False,
            workers=1,
            progress=lambda *pair: told.append(pair),
        )
    assert page == out / "index.html"
    figures = 3 * len(bodies) * (1 + len(frictions(bodies))) + 1  # launches are one piece of work
    assert told[0] == (0, figures)
    assert told[-1] == (figures, figures)
    return out


def told_apart(folder: Path) -> list[Path]:
    """Data of launches that do not nearly all end alike, which have a figure."""
    found = []
    for path in sorted(folder.glob("basins-*.nc")):
        data = xarray.open_dataset(path, engine="h5netcdf")
        ends = list(zip(data.outcome.values.ravel(), data.family.values.ravel(), strict=True))
        if max(map(ends.count, ends)) <= 0.95 * len(ends):
            found.append(path)
    return found


def test_it_has_every_diagram_locus_map_and_the_boundaries(
    folder: Path, bodies: tuple[str, ...], launched: tuple[tuple[str, ...], float]
) -> None:
    expected = {"index.html", "boundaries.csv"}
    for body in bodies:
        for family in drawn():
            stems = [f"{family}-{body}"]
            expected.add(f"{family}-{body}.nc")
            of = frictions(bodies)
            stems += [f"locus-{family}-{body}-mu{m:g}".replace(".", "_") for m in of]
            expected |= {f"{s}.{kind}" for s in stems for kind in ("png", "pdf")}
        expected |= {f"basins-{f}-{body}.nc" for f in launched[0]}
    expected |= {path.with_suffix(".png").name for path in told_apart(folder)}
    assert {p.name for p in folder.iterdir()} == expected
    assert all(p.stat().st_size > 500 for p in folder.iterdir())


def test_the_page_points_only_at_what_is_there_and_says_what_was_computed(
    folder: Path,
    bodies: tuple[str, ...],
    resolution: int,
    launched: tuple[tuple[str, ...], float],
) -> None:
    shown = len(told_apart(folder))
    count = 3 * (1 + len(frictions(bodies))) * len(bodies) + shown
    page = (folder / "index.html").read_text()
    links = re.findall(r'(?:src|href)="([^"#]+)"', page)
    assert len(links) > 2 * count
    assert all((folder / link).is_file() for link in links)
    images = re.findall(r'<img [^>]*alt="([^"]+)"', page)
    assert len(images) == len(set(images)) == count
    captions = re.findall(r"<figcaption>(.*?)</figcaption>", page, re.DOTALL)
    assert len(captions) == count
    assert max(len(c.partition(" <span")[0]) for c in captions) < 100  # two lines of a column
    assert page.count("no figure, since of 24 nearly all end alike") == (
        len(launched[0]) * len(bodies) - shown
    )
    ends = captions[count - shown :]
    for caption in captions[: count - shown]:
        assert "structural zero" in caption  # of which the spectrum is free
        assert "√(g/R)" in caption
    for caption in ends:
        assert "Ends of 24 launches" in caption
        assert "Strip: linear verdict" in caption
    assert "recomputed" in page
    assert f"{resolution} × {3 * resolution // 4} points" in captions[0]


def test_diagrams_of_a_row_have_one_scale_of_colours(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whose ends are the largest rates of all its bodies, far from those of the hoop alone."""
    scales: list[tuple[float, float]] = []
    monkeypatch.setattr(
        "stability.figures.diagram.plot_map", lambda *_, scale, **__: scales.append(scale)
    )
    monkeypatch.setattr("stability.maps.files.write_map", lambda *_, **__: None)
    for body in BODIES:
        _diagram(Path(), body, "rolling", 12)
    assert len(set(scales)) == 1 < len(BODIES)
    low, high = drawn()["rolling"]
    x, y = ("at", low, high, 12), ("mu", 0.01, 100.0, 9, "log")
    largest = [
        np.abs(st.stability_map("rolling", x=x, y=y, disk=make()).abscissa.values).max()
        for make, _, _ in BODIES.values()
    ]
    assert scales[0][1] == max(largest) > 1.3 * min(largest)


def test_pages_are_readable_on_a_dark_screen() -> None:
    """Each colour of words against its page has the contrast that the guidelines ask, 4.5."""
    rules = re.findall(r"--(\w+): (#\w+)", STYLE)
    assert [name for name, _ in rules[:5]] == [name for name, _ in rules[5:]]

    def luminance(colour: str) -> float:
        wide = colour[1:] if len(colour) == 7 else "".join(2 * c for c in colour[1:])
        parts = [int(wide[i : i + 2], 16) / 255 for i in (0, 2, 4)]
        linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
        return float(np.dot(linear, [0.2126, 0.7152, 0.0722]))

    for mode in (dict(rules[:5]), dict(rules[5:])):
        for name in ("ink", "quiet", "link"):
            light, dark = sorted(map(luminance, (mode[name], mode["page"])), reverse=True)
            assert (light + 0.05) / (dark + 0.05) > 4.5
    assert "background: #fff" in STYLE.partition("figure img")[2].partition("}")[0]


def test_maps_behind_the_figures_can_be_read(folder: Path, resolution: int) -> None:
    for path in folder.glob("*.nc"):
        if path.name.startswith("basins"):
            continue
        found = st.read_map(path)
        assert found.abscissa.shape == (3 * resolution // 4, resolution)
        assert np.isfinite(found.abscissa.values).all()


def test_launches_behind_the_figures_are_those_of_the_function(
    folder: Path, launched: tuple[tuple[str, ...], float]
) -> None:
    paths = sorted(folder.glob("basins-*-hoop.nc"))
    assert len(paths) == len(launched[0])
    for path in paths:
        family = path.name.split("-")[1]
        found = xarray.open_dataset(path, engine="h5netcdf")
        true = st.basins(
            st.Disk.hoop(),
            "viscous",
            mu=0.3,
            family=family,
            horizon=launched[1],
            x=("at", 0.1, 3.0, 6),
            y=("tilt", 0.01, 1.2, 4),
        )
        for name in ("outcome", "family", "linear_verdict"):
            np.testing.assert_array_equal(found[name].values, true[name].values)


def test_boundaries_are_those_of_the_maps_and_the_limit_laws(folder: Path) -> None:
    with (folder / "boundaries.csv").open() as handle:
        rows = list(csv.DictReader(handle))
    assert tuple(rows[0]) == COLUMNS
    maps = [p for p in folder.glob("*.nc") if not p.name.startswith("basins")]
    count = sum(st.read_map(p).sizes["boundary_point"] for p in maps)
    assert sum(r["contact"] == "viscous" for r in rows) == count
    smooth = [
        r for r in rows if (r["contact"], r["family"], r["body"]) == ("smooth", "rolling", "hoop")
    ]
    assert float(smooth[0]["omega3 [√(g/R)]"]) ** 2 == pytest.approx(0.5, rel=1e-13)
    rolling = [r for r in rows if (r["contact"], r["family"]) == ("viscous", "rolling")]
    for row in rolling:
        assert float(row["omega3 [√(g/R)]"]) ** 2 == pytest.approx(
            1 / (2 * float(row["k"])), rel=1e-13
        )


def undraw(patch: pytest.MonkeyPatch) -> None:
    """Files in place of figures, for tests that are about files and numbers."""

    def save(figure: None, stem: Path, formats: tuple[str, ...]) -> list[Path]:
        paths = [stem.parent / (stem.name + suffix) for suffix in formats]
        for path in paths:
            path.write_text(f"{figure} of {stem.name}\n" * 40)
        return paths

    patch.setattr("stability.figures.canvas.save", save)
    patch.setattr("stability.figures.diagram.plot_map", lambda *_, **__: None)
    patch.setattr("stability.figures.loci.plot_locus", lambda *_, **__: None)
    patch.setattr("stability.figures.basins.plot_basins", lambda *_, **__: None)


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """An atlas of one body, without its figures."""
    monkeypatch.setattr("stability.atlas.build.BODIES", {"disk": BODIES["disk"]})
    undraw(monkeypatch)


@pytest.fixture
def brief(monkeypatch: pytest.MonkeyPatch, undrawn: None) -> None:  # noqa: ARG001
    """And of rolling alone."""
    few = {"rolling": drawn()["rolling"]}
    for module in ("build", "page"):
        monkeypatch.setattr(f"stability.atlas.{module}.drawn", lambda: few)
    monkeypatch.setattr("stability.atlas.build.LOCUS_FRICTION", EVERY_FRICTION[:1])
    monkeypatch.setattr("stability.atlas.build.LAUNCHED", LAUNCHED[:1])
    monkeypatch.setattr("stability.atlas.build.TIME", 5.0)


@pytest.mark.usefixtures("brief")
def test_force_replaces_its_own_files_and_leaves_others(folder: Path, tmp_path: Path) -> None:
    target = tmp_path / "atlas"
    shutil.copytree(folder, target)  # the folder itself is for every test
    (target / "notes.txt").write_text("mine")
    with pytest.raises(st.StabilityError, match="not empty"):
        atlas(target, resolution=8, workers=1)
    before = (target / "index.html").read_text()
    atlas(target, resolution=8, workers=1, overwrite=True)
    assert (target / "notes.txt").read_text() == "mine"
    assert (target / "index.html").read_text() != before
    assert [p.name for p in tmp_path.iterdir()] == ["atlas"]


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(
    ("points", "draft", "command"),
    [(8, None, "--resolution 8")]
    + [
        pytest.param(*case, marks=pytest.mark.long)
        for case in (
            (100, True, "--resolution 100 --draft"),
            (100, None, "--resolution 100"),
            (8, False, "--resolution 8 --no-draft"),
        )
    ],
)
def test_a_draft_has_every_diagram_and_says_what_it_leaves_out(
    tmp_path: Path, points: int, draft: bool | None, command: str
) -> None:
    out = tmp_path / "atlas"
    page = atlas(out, resolution=points, draft=draft, workers=1).read_text()
    diagrams = {f"{family}-disk.png" for family in drawn()}
    made = {p.name for p in out.iterdir()}
    links = set(re.findall(r'(?:src|href)="([^"#]+)"', page))
    assert made == links | {"index.html"}
    assert diagrams <= made
    assert f"Made by <code>stability atlas {command}</code>" in page
    short = draft or (draft is None and points < 100)
    assert short == (f"--resolution {points} --no-draft</code> adds" in page)
    assert short == ({n for n in made if n.endswith((".png", ".pdf"))} == diagrams)


@pytest.mark.usefixtures("brief")
def test_a_folder_in_the_way_stops_it_before_anything_is_moved(tmp_path: Path) -> None:
    target = tmp_path / "atlas"
    (target / "rolling-disk.png").mkdir(parents=True)
    with pytest.raises(st.StabilityError, match="in the way"):
        atlas(target, resolution=8, workers=1, overwrite=True)
    assert [p.name for p in target.iterdir()] == ["rolling-disk.png"]
    assert [p.name for p in tmp_path.iterdir()] == ["atlas"]


def test_figures_use_colours_that_differ_in_lightness_and_mark_growth_without_colour() -> None:
    """Luminance of decay and growth ends differ from neutral, and growth is hatched."""
    from stability.figures.shading import DIVERGING

    light = [float(np.dot(DIVERGING(v)[:3], [0.2126, 0.7152, 0.0722])) for v in (0.0, 0.5, 1.0)]
    assert light[1] - max(light[0], light[2]) > 0.5
    found = st.stability_map("spinning", x=("at", 1, 4, 5), y=("mu", 0.1, 2, 4))
    figure = st.plot_map(found)
    hatches = [h for c in figure.axes[0].collections for h in (getattr(c, "hatches", None) or [])]
    assert hatches == ["////"]
    labels = [
        figure.axes[0].get_xlabel(),
        figure.axes[0].get_ylabel(),
        figure.axes[-1].get_ylabel(),
    ]
    assert all("[" in label for label in labels)


@pytest.mark.parametrize("mu", EVERY_FRICTION)
def test_zeros_of_growth_rates_are_exact_however_coarse_the_sweep(mu: float) -> None:
    """Rolling of the uniform disk: rates vanish at omega3² = 1/3 and 2 under every friction."""
    at = np.linspace(0.2, 3.0, 31)
    found = zeros_of_rates(st.spectrum("rolling", at=at, contact=st.Viscous(mu)))
    assert found == pytest.approx([3**-0.5, 2**0.5], rel=1e-14)
