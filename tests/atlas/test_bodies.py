"""The atlas of bodies holds what its page shows, and goes on where it was interrupted."""

import html
import json
import math
import re
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stability as st
from stability.atlas.bodies import (
    BODIES,
    CLOSE,
    MU,
    _across,
    absence,
    atlas_of_bodies,
    draw,
    drawn,
    kinds,
    names,
    pages,
)
from stability.cli import main

KEYS = ("eccentric", "thick")
KINDS = {"eccentric": "offset", "thick": "thickness"}
FAMILIES = {
    "eccentric": ("tumbling", "vertical", "vertical-pi"),
    "thick": ("rolling", "tumbling"),
}
STEMS = {
    f"{name}-{key}-{kind}"
    for key, every in FAMILIES.items()
    for name in every
    for kind in ("mu", KINDS[key], "rough", "smooth")
} | {f"{name}-{key}" for key in KEYS for name in ("circling", "precession")}
"""Maps of the two bodies."""
WHOLE = pytest.param(12, marks=pytest.mark.long)


def undraw(patch: pytest.MonkeyPatch, asked: list[str]) -> None:
    """Files in place of figures; `asked` gets their names."""

    def save(_: None, stem: Path) -> None:
        asked.append(stem.name)
        for suffix in (".png", ".pdf"):
            (stem.parent / (stem.name + suffix)).write_text(stem.name)

    patch.setattr("stability.figures.canvas.save", save)
    patch.setattr("stability.figures.diagram.plot_map", lambda *_, **__: None)


def test_inclinations_are_all_of_a_body_up_to_its_mirror_images() -> None:
    """A body whose ends are alike looks upside down at π - theta as it does at theta."""
    for key, shown in BODIES.items():
        last = math.pi if shown.ends else math.pi / 2
        assert _across(shown, "precession", 9)[2] == pytest.approx(last - CLOSE, abs=1e-12), key


@pytest.fixture(scope="module", params=[8, WHOLE])
def resolution(request: pytest.FixtureRequest) -> int:
    """At the lower one: one body, rolling and pairs of numbers alone, and no figure is drawn."""
    return int(request.param)


@pytest.fixture(scope="module")
def keys(resolution: int) -> tuple[str, ...]:
    return KEYS[1:] if resolution == 8 else KEYS


@pytest.fixture(scope="module")
def stems(resolution: int) -> set[str]:
    few = ("rolling-thick", "circling-thick", "precession-thick")
    return {s for s in STEMS if resolution == 12 or s.startswith(few)}


@pytest.fixture(scope="module")
def folder(
    resolution: int,
    keys: tuple[str, ...],
    stems: set[str],
    tmp_path_factory: pytest.TempPathFactory,
) -> Path:
    out = tmp_path_factory.mktemp("bodies") / "atlas"
    told: list[tuple[int, int]] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("stability.atlas.bodies.BODIES", {k: BODIES[k] for k in keys})
        if resolution == 8:
            undraw(patch, [])
            few = {name: drawn()[name] for name in ("rolling", "spinning")}
            patch.setattr("stability.atlas.bodies.drawn", lambda: few)
        page = atlas_of_bodies(
            out, resolution=resolution, workers=1, progress=lambda *pair: told.append(pair)
        )
    assert page == out / "index.html"
    assert (told[0], told[-1]) == ((0, len(stems)), (len(stems), len(stems)))
    return out


@cache
def read(path: Path) -> Any:
    return st.read_map(path)


def conservative_and_neutral(folder: Path) -> set[str]:
    """Maps whose every cell is neutral or without a member."""
    codes = {p.stem: read(p).verdict.values for p in folder.glob("*.nc")}
    return {stem for stem, code in codes.items() if ((code == 3) | (code == 4)).all()}


def text(folder: Path, name: str) -> str:
    return html.unescape((folder / f"{name}.html").read_text())


def test_it_has_every_diagram_and_nothing_else(
    folder: Path, keys: tuple[str, ...], stems: set[str]
) -> None:
    plain = conservative_and_neutral(folder)
    neutral = {"tumbling-eccentric-rough", "vertical-pi-eccentric-rough"} & stems
    assert plain & neutral == neutral - {"vertical-pi-eccentric-rough"} and plain < stems
    expected = {f"{s}.nc" for s in stems} | {f"{k}.html" for k in (*keys, "index")}
    expected |= {f"{s}.{kind}" for s in stems - plain for kind in ("png", "pdf")}
    assert {p.name for p in folder.iterdir()} == expected
    assert [p.name for p in folder.parent.iterdir()] == ["atlas"]


def test_the_index_has_a_picture_and_a_page_of_each_body(
    folder: Path, keys: tuple[str, ...], stems: set[str]
) -> None:
    page = text(folder, "index")
    links = re.findall(r'(?:src|href)="([^"]+)"', page)
    assert all((folder / link).is_file() for link in links)
    assert {f"{k}.html" for k in keys} <= set(links)
    count = len(stems) - len(conservative_and_neutral(folder))
    counts = [int(n) for n in re.findall(r"\): (\d+) diagram", page)]
    assert len(counts) == len(keys) and sum(counts) == count
    assert "Thick disk</strong></a> (thickness = 0.3)" in page


def test_each_page_says_what_was_computed_and_what_does_not_exist(
    folder: Path, resolution: int, keys: tuple[str, ...], stems: set[str]
) -> None:
    page = {key: text(folder, key) for key in keys}
    for words in page.values():
        links = re.findall(r'(?:src|href)="([^"#]+)"', words)
        assert all((folder / link).is_file() for link in links)
        assert 'href="index.html"' in words
    captions = {
        key: re.findall(r"<figcaption>(.*?)</figcaption>", words, re.DOTALL)
        for key, words in page.items()
    }
    assert "No spinning: thick disk has no spinning" in page["thick"]
    assert "No vertical spin: thick disk is not smooth at theta = 0" in page["thick"]
    if tops := page.get("eccentric"):
        assert "No rolling: eccentric sphere rolls nowhere" in tops
        assert "No spinning: eccentric sphere has no spinning" in tops
        assert "the moments of inertia are 0.32 (about the axis) and 0.48 (across it)" in tops
        assert "Vertical spin, centre of mass below" in tops
        assert "spin, centre of mass above" in tops
        first = "Tumbling of the eccentric sphere (offset = 0.2) under viscous friction. Colour:"
        assert captions["eccentric"][0].startswith(first)
    plain = conservative_and_neutral(folder)
    assert sum(map(len, captions.values())) == len(stems) - len(plain)
    for path in folder.glob("*.nc"):
        found, stem = read(path), path.stem
        [key] = [k for k in keys if k in stem]
        law = str(found.attrs["system"]).rpartition(", ")[2]
        words = {
            "rough": "on a rough plane, without slip",
            "smooth": "on a smooth plane, without friction",
        }
        blank = int((found.verdict == 4).sum())
        if stem in plain:
            [said] = re.findall(
                rf'<p>([^<]*) <a href="{stem}.nc">NetCDF</a></p>', text(folder, key)
            )
            points = f"{resolution} × {3 * resolution // 4} points"
            assert f"neutral at all {points} of" in said and words[law] in said
            assert (f"but for {blank} without a member" in said) == (blank > 0)
            continue
        [caption] = [c for c in captions[key] if f'href="{stem}.nc"' in c]
        assert words.get(law, "under viscous friction") in caption
        assert (f"{blank} without a member, left blank" in caption) == (blank > 0)
        for code, word in ((1, "stable"), (2, "unstable"), (3, "neutral")):
            count = int((found.verdict == code).sum())
            assert (f" {count} {word}" in caption) == (count > 0)


def test_its_numbers_are_those_of_single_spectra(folder: Path) -> None:
    found = st.read_map(folder / "rolling-thick-thickness.nc")
    for j, i in ((0, 0), (-1, 3), (4, -1)):
        body = st.ThickDisk(float(found.thickness[j]))
        one = st.spectrum("rolling", at=float(found.omega3[i]), body=body, contact=st.Viscous(MU))
        assert found.verdict.values[j, i] == one.verdict.code
        assert found.abscissa.values[j, i] == pytest.approx(one.abscissa, rel=1e-9)


@pytest.mark.parametrize(
    ("resolution", "stem", "family", "law", "more"),
    [
        (8, "rolling-thick-rough", "rolling", "rough", {}),
        (8, "rolling-thick-smooth", "rolling", "smooth", {}),
        pytest.param(
            12,
            "vertical-pi-eccentric-smooth",
            "vertical",
            "smooth",
            {"pole": "pi"},
            marks=pytest.mark.long,
        ),
    ],
    indirect=["resolution"],
)
def test_maps_without_a_coefficient_are_those_of_single_spectra(
    folder: Path, stem: str, family: str, law: str, more: dict[str, str]
) -> None:
    found = st.read_map(folder / f"{stem}.nc")
    own, at = (str(d) for d in found.verdict.dims)
    make = {"thickness": st.ThickDisk, "offset": st.EccentricSphere}[own]
    for j, i in ((0, 0), (4, 3), (-1, -1)):
        one = st.spectrum(
            family, at=float(found[at][i]), body=make(float(found[own][j])), contact=law, **more
        )
        assert found.verdict.values[j, i] == one.verdict.code


@pytest.mark.long
def test_an_egg_has_a_page_with_both_ends_and_planes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("stability.atlas.bodies._save", lambda *_: None)
    shown, found, absent = BODIES["egg"], {}, {}
    for name in names(shown):
        if absence(shown, name):
            absent["egg", name] = absence(shown, name)
            continue
        for kind in kinds(shown, name):
            found["egg", name, kind] = draw("egg", name, kind, str(tmp_path), 8)
    assert list(absent) == [("egg", "spinning")]
    page = html.unescape(pages({"egg": shown}, found, absent, 8)["egg.html"])
    assert "Vertical spin, blunt end below" in page and "Vertical spin, sharp end below" in page
    assert "At taper = 0.2, aspect = 1.3 the moments of inertia are 0.4105 (about" in page
    assert (
        "Vertical spin of the egg (sharp end below, taper = 0.2, aspect = 1.3, μ = 0.3/√(gR))"
        in page
    )
    for family, law in (("circling", "rough"), ("precession", "smooth")):
        plane = st.read_map(tmp_path / f"{family}-egg.nc")
        assert plane.verdict.dims == ("phi_dot", "theta")
        for j, i in ((0, 0), (1, 1), (5, 7)):
            at = float(plane.theta[i]), float(plane.phi_dot[j])
            one = st.spectrum(family, at=at, body=st.Egg(0.2), contact=law)
            assert plane.verdict.values[j, i] == one.verdict.code
    spin = st.read_map(tmp_path / "vertical-pi-egg-axial.nc")
    for j, i in ((0, 0), (5, 7)):
        body = replace(st.Egg(0.2), axial=float(spin.axial[j]))
        one = st.spectrum(
            "vertical", at=float(spin.omega_Z[i]), body=body, contact=st.Viscous(MU), pole="pi"
        )
        assert spin.verdict.values[j, i] == one.verdict.code


@pytest.mark.parametrize("resolution", [WHOLE], indirect=True)
def test_vertical_spin_changes_at_the_tippe_tops_limit_on_each_end(folder: Path) -> None:
    """ω² = e(1 ∓ e)²/(±(A - C(1 ∓ e))) upright and inverted, for every mu (Ebenfeld & Scheck)."""
    axial, across, e = 0.32, 0.48, 0.2
    for stem, end in (("vertical-eccentric-mu", 1), ("vertical-pi-eccentric-mu", -1)):
        found = st.read_map(folder / f"{stem}.nc")
        square = e * (1 - end * e) ** 2 / (end * (across - axial * (1 - end * e)))
        verdict = found.verdict.values
        if square < 0:  # no limit: the same verdict everywhere
            assert (verdict == verdict[0, 0]).all() and verdict[0, 0] == 2
            assert found.sizes["boundary_point"] == 0
        else:
            np.testing.assert_allclose(found.boundary_omega_Z, square**0.5, rtol=1e-9)
            assert ((verdict == 1) == (found.omega_Z.values < square**0.5)).all()


@pytest.mark.long
def test_an_interrupted_atlas_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("stability.atlas.bodies.BODIES", {"eccentric": BODIES["eccentric"]})
    asked: list[str] = []
    undraw(monkeypatch, asked)

    def stop(done: int, _: int) -> None:
        if done == 1:
            raise KeyboardInterrupt

    out = tmp_path / "atlas"
    with pytest.raises(KeyboardInterrupt, match=r"figures are kept in .*atlas\.parts"):
        atlas_of_bodies(out, resolution=8, workers=1, progress=stop)
    assert not out.exists()
    assert asked == ["tumbling-eccentric-mu"]
    atlas_of_bodies(out, resolution=8, workers=1)
    every = [
        f"{f}-eccentric-{axis}"
        for f in ("tumbling", "vertical", "vertical-pi")
        for axis in ("mu", "offset")
    ]
    every += [f"vertical-pi-eccentric-{law}" for law in ("rough", "smooth")]  # the rest is neutral
    assert asked == every
    assert [p.name for p in tmp_path.iterdir()] == ["atlas"]

    with pytest.raises(KeyboardInterrupt):
        atlas_of_bodies(out, resolution=8, workers=1, progress=stop, overwrite=True)
    atlas_of_bodies(out, resolution=9, workers=1, overwrite=True)  # of another grid: drawn again
    assert asked[len(every) + 1 :] == every
    assert st.read_map(out / "tumbling-eccentric-mu.nc").abscissa.shape == (6, 9)


def test_folders_of_others_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("stability.atlas.bodies.BODIES", {"thick": BODIES["thick"]})
    (tmp_path / "atlas.parts").mkdir()
    (tmp_path / "atlas.parts" / "mine.txt").write_text("mine")
    assert main(["atlas", "--bodies", "--out", str(tmp_path / "atlas")]) == 2
    assert "holds other files; move it aside." in capsys.readouterr().err
    assert main(["atlas", "--bodies", "--out", str(tmp_path)]) == 2
    assert "not empty" in capsys.readouterr().err
    with pytest.raises(st.StabilityError, match="resolution is 4"):
        atlas_of_bodies(tmp_path / "new", resolution=4)


def test_the_command_line_writes_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def write(out: str, **options: object) -> Path:
        Path(out).mkdir()
        page = Path(out) / "index.html"
        page.write_text(json.dumps(sorted(set(options) - {"progress"})))
        return page

    monkeypatch.setattr("stability.atlas.bodies.atlas_of_bodies", write)
    out = tmp_path / "atlas"
    assert main(["atlas", "--bodies", "--out", str(out), "--resolution", "9", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["page"] == str(out / "index.html")
    assert json.loads((out / "index.html").read_text()) == ["overwrite", "resolution"]
