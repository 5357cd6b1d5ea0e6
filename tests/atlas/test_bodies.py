"""The atlas of bodies holds what its page shows, and goes on where it was interrupted."""

import html
import json
import re
from pathlib import Path

import numpy as np
import pytest

import stability as st
from stability.atlas.bodies import BODIES, MU, atlas_of_bodies
from stability.cli import main

KEYS = ("eccentric", "thick")
STEMS = {
    "vertical-eccentric-mu", "vertical-eccentric-offset", "vertical-pi-eccentric-mu",
    "vertical-pi-eccentric-offset", "tumbling-eccentric-mu", "tumbling-eccentric-offset",
    "rolling-thick-mu",
    "rolling-thick-thickness", "tumbling-thick-mu", "tumbling-thick-thickness",
}  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("bodies") / "atlas"
    told: list[tuple[int, int]] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("stability.atlas.bodies.BODIES", {k: BODIES[k] for k in KEYS})
        page = atlas_of_bodies(
            out, resolution=12, workers=1, progress=lambda *pair: told.append(pair)
        )
    assert page == out / "index.html"
    assert (told[0], told[-1]) == ((0, 10), (10, 10))
    return out


def test_it_has_every_diagram_and_nothing_else(folder: Path) -> None:
    expected = {f"{s}.{kind}" for s in STEMS for kind in ("png", "pdf", "nc")} | {"index.html"}
    assert {p.name for p in folder.iterdir()} == expected
    assert [p.name for p in folder.parent.iterdir()] == ["atlas"]


def test_the_page_says_what_was_computed_and_what_does_not_exist(folder: Path) -> None:
    page = html.unescape((folder / "index.html").read_text())
    links = re.findall(r'(?:src|href)="([^"#]+)"', page)
    assert all((folder / link).is_file() for link in links)
    assert "No rolling: eccentric sphere rolls nowhere" in page
    assert "No spinning: eccentric sphere has no spinning" in page
    assert "No spinning: thick disk has no spinning" in page
    assert "the moments of inertia are 0.32 (about the axis) and 0.48 (across it)" in page
    assert "No vertical spin: thick disk is not smooth at theta = 0" in page
    captions = re.findall(r"<figcaption>(.*?)</figcaption>", page, re.DOTALL)
    assert len(captions) == len(STEMS)
    assert "Tumbling of the eccentric sphere (offset = 0.2) under viscous friction" in captions[0]
    for path in folder.glob("*.nc"):
        found = st.read_map(path)
        blank = int(np.isnan(found.abscissa.values).sum())
        stem = path.stem
        [caption] = [c for c in captions if f'href="{stem}.nc"' in c]
        assert (f"{blank} without a member, left blank" in caption) == (blank > 0)
        stable = int((found.verdict == 1).sum())
        assert (f"{stable} stable" in caption) == (stable > 0)


def test_its_numbers_are_those_of_single_spectra(folder: Path) -> None:
    found = st.read_map(folder / "rolling-thick-thickness.nc")
    for j, i in ((0, 0), (8, 3), (4, 11)):
        body = st.ThickDisk(float(found.thickness[j]))
        one = st.spectrum("rolling", at=float(found.omega3[i]), body=body, contact=st.Viscous(MU))
        assert found.verdict.values[j, i] == one.verdict.code
        assert found.abscissa.values[j, i] == pytest.approx(one.abscissa, rel=1e-9)


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


def test_an_interrupted_atlas_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("stability.atlas.bodies.BODIES", {"eccentric": BODIES["eccentric"]})
    monkeypatch.setattr("stability.figures.diagram.plot_map", lambda *_, **__: None)
    asked: list[str] = []

    def save(_: None, stem: Path) -> None:
        asked.append(stem.name)
        for suffix in (".png", ".pdf"):
            (stem.parent / (stem.name + suffix)).write_text(stem.name)

    monkeypatch.setattr("stability.figures.canvas.save", save)

    def stop(done: int, _: int) -> None:
        if done == 1:
            raise KeyboardInterrupt

    out = tmp_path / "atlas"
    with pytest.raises(KeyboardInterrupt, match=r"figures are kept in .*atlas\.parts"):
        atlas_of_bodies(out, resolution=8, workers=1, progress=stop)
    assert not out.exists()
    assert asked == ["tumbling-eccentric-mu"]
    atlas_of_bodies(out, resolution=8, workers=1)
    every = [f"{f}-eccentric-{axis}" for f in ("tumbling", "vertical", "vertical-pi")
             for axis in ("mu", "offset")]  # fmt: skip
    assert asked == every
    assert [p.name for p in tmp_path.iterdir()] == ["atlas"]

    with pytest.raises(KeyboardInterrupt):
        atlas_of_bodies(out, resolution=8, workers=1, progress=stop, overwrite=True)
    atlas_of_bodies(out, resolution=9, workers=1, overwrite=True)  # of another grid: drawn again
    assert asked[len(every) + 1 :] == every
    assert st.read_map(out / "tumbling-eccentric-mu.nc").abscissa.shape == (6, 9)


def test_folders_of_others_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
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
