"""`overwrite="same"` replaces what the same call wrote, and nothing else."""

import json
import os
import re
import struct
import zlib
from collections.abc import Callable
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import casadi as ca
import numpy as np
import pytest
from PIL import Image

from stability.figures.canvas import save_figure  # isort: skip
from stability.figures.styled_figure import StyledFigure, remembered  # isort: skip

import stability as st
from stability.cli.commands import main
from stability.storage import origin
from stability.storage.files import atomic_write, together
from stability.storage.targets import check_target

DISK, AXES = st.Disk(), {"x": ("at", 1, 2, 4), "y": ("mu", 0.1, 3, 4)}
START = {"theta": 1.4}


@cache
def stability_map(mu: float = 3.0) -> Any:
    return st.stability_map("rolling", x=AXES["x"], y=("mu", 0.1, mu, 4))


@cache
def motion(mu: float = 0.3) -> Any:
    return st.simulate(DISK, st.Viscous(mu), START, 3.0, pose=True)


def sketch(dataset: Any, *, title: str = "", width: float = 1.0, fontsize: float = 7.0) -> Any:
    """A figure that is drawn faster than the package's own."""
    figure = StyledFigure(figsize=(width, 1.0))
    figure.add_subplot().plot(dataset.abscissa.values.ravel())
    figure.text(0.1, 0.1, title, fontsize=fontsize)
    return figure


drawn_by_a_user = remembered(sketch)
sketch.__module__ = "stability.figures.sketch"
sketch = remembered(sketch)


def figure(path: Path, mu: float = 3.0, **options: Any) -> None:
    sketch(stability_map(mu), **options).savefig(path, dpi=50, overwrite="same")


def film(path: Path, mu: float = 0.3, **options: Any) -> None:
    st.animate(motion(mu), path, fps=2, overwrite="same", **{"seconds": 1.0} | options)


def page(path: Path, mu: float = 0.3, **options: Any) -> None:
    st.explore("spinning", mu=mu, out=path, certify=False, overwrite="same", **options)


def table(path: Path, k: float = 0.25, **options: Any) -> None:
    st.table("drift", k=k, mu=0.3, **options).write(path, overwrite="same")


CALLS: dict[str, tuple[Callable[..., None], dict[str, Any], dict[str, Any]]] = {
    "a.png": (figure, {"title": "B"}, {"mu": 3.5}),
    "a.pdf": (figure, {"width": 5.0}, {"mu": 3.5}),
    "a.svg": (figure, {"fontsize": 8.0}, {"mu": 3.5}),
    "a.gif": (film, {"seconds": 1.5}, {"mu": 0.31}),
    "film.html": (film, {"contact_path": False}, {"mu": 0.31}),
    "page.html": (page, {"at": 1.5}, {"mu": 0.31}),
    "a.csv": (table, {"k": 0.3}, {"k": 0.35}),
    "a.tex": (table, {"k": 0.3}, {"k": 0.35}),
}
"""By name of a file: a call that writes it, another option, and other data."""


def refused(call: Callable[[], object], path: Path, why: str) -> None:
    """Whether a call is refused in one sentence, and the file and its folder are as before."""
    before, names = path.read_bytes(), os.listdir(path.parent)
    with pytest.raises(st.StabilityError, match=why) as caught:
        call()
    assert str(caught.value).count(". ") == 0 and str(caught.value).endswith(".")
    assert path.read_bytes() == before and os.listdir(path.parent) == names


@pytest.mark.parametrize("name", CALLS)
def test_a_file_is_replaced_by_the_call_that_wrote_it_and_by_no_other(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write, option, data = CALLS[name]
    path = tmp_path / name
    write(path)
    first = path.stat().st_ino
    write(path)
    assert path.stat().st_ino != first and os.listdir(tmp_path) == [name]
    for other in (option, data):
        refused(lambda other=other: write(path, **other), path, "is not what this call wrote")
    whole = path.read_bytes()
    for content, why in (
        (b"", "it is empty"),
        (whole[: len(whole) // 2], "changed|no record|bytes differ"),
        (whole[:-1], "changed|no record|bytes differ"),
        (
            bytes([*whole[:40], whole[40] ^ 1, *whole[41:]]),
            "changed|no record|bytes differ",
        ),
        (whole.replace(b"the call", b"the cell"), "changed"),
        (b"notes of my own", "no record|bytes"),
    ):
        if content != whole:
            path.write_bytes(content)
            refused(lambda: write(path), path, why)
    path.write_bytes(whole)
    write(path)
    if not name.endswith((".csv", ".tex")):
        monkeypatch.setattr(origin, "__version__", "9.9")
        refused(lambda: write(path), path, 'version: "0.5.0" there, "9.9" here')


def stamped(path: Path) -> dict[str, Any]:
    """The entries of a record, from the text that a foreign reader finds."""
    text = {
        ".png": lambda: Image.open(path).text["stability"],  # type: ignore[attr-defined]
        ".svg": lambda: path.read_text().rpartition("<!--")[2].rpartition("-->")[0],
    }[path.suffix]()
    entries = json.loads(re.fullmatch(r"\s*stability origin [0-9a-f]{64} (.*)\s*", text)[1])  # type: ignore[index]
    return {name: json.loads(entry) for name, entry in entries.items()}


def test_foreign_readers_read_the_record_and_the_file(tmp_path: Path) -> None:
    """Pillow, an XML parser, the tables of PDF, and the chunks of PNG by their specification."""
    for suffix in ("png", "svg", "pdf"):
        figure(tmp_path / f"a.{suffix}", title="one -- two --> three")
    told = stamped(tmp_path / "a.png")
    assert told["the call"] == "sketch" and told["its title"] == "one -- two --> three"
    assert stamped(tmp_path / "a.svg") == told
    content, place, kinds = (tmp_path / "a.png").read_bytes(), 8, []
    while place < len(content):
        size, kind = struct.unpack(">I4s", content[place : place + 8])
        body = content[place + 4 : place + 8 + size]
        assert struct.unpack(">I", content[place + 8 + size :][:4]) == (zlib.crc32(body),)
        kinds.append(kind)
        place += 12 + size
    assert kinds[0] == b"IHDR" and kinds[-2:] == [b"tEXt", b"IEND"]
    ElementTree.parse(tmp_path / "a.svg")
    content = (tmp_path / "a.pdf").read_bytes()
    end = re.search(rb"startxref\s+(\d+)\s+%%EOF\s*$", content)
    assert end is not None and content[int(end[1]) :].startswith(b"xref")


def test_films_and_pages_play_with_their_record(tmp_path: Path) -> None:
    for name in ("a.gif", "a.html"):
        film(tmp_path / name)
    with Image.open(tmp_path / "a.gif") as frames:
        assert frames.n_frames == 2  # type: ignore[attr-defined]
        frames.seek(1)
        frames.load()

    class Reader(HTMLParser):
        comments: list[str] = []  # noqa: RUF012

        def handle_comment(self, data: str) -> None:
            self.comments.append(data)

    reader = Reader()
    reader.feed((tmp_path / "a.html").read_text(encoding="utf-8"))
    assert '"animate' in reader.comments[-1].replace("\\", "")
    # a box of ISO/IEC 14496-12 holds its size and its kind
    film_file = tmp_path / "a.mp4"
    film_file.write_bytes(b"\0\0\0\x10ftypisom\0\0\0\0")
    origin.stamp(film_file, {"the call": '"animate"'})
    content = film_file.read_bytes()
    size, kind = struct.unpack(">I4s", content[16:24])
    assert kind == b"free" and 16 + size == len(content)
    assert origin.record_of(film_file) == {"the call": '"animate"'}


@pytest.mark.parametrize("suffix", ["png", "pdf", "svg"])
def test_what_is_changed_in_a_figure_counts(suffix: str, tmp_path: Path) -> None:
    """A picture that is shown in a notebook, drawn and measured is still that of its call."""
    path = tmp_path / f"a.{suffix}"

    def write(word: str = "", **options: Any) -> None:
        drawn = sketch(stability_map())
        drawn.canvas.draw()
        if word:
            drawn.text(0.1, 0.5, word)
        drawn.savefig(path, overwrite="same", **options)

    save_figure(sketch(stability_map()), path)
    assert f"its {origin.LATER}" not in origin.record_of(path)
    write()
    refused(lambda: write("mine"), path, "later changes: missing there")
    refused(lambda: write(facecolor="0.9"), path, 'facecolor: missing there, "0.9" here')
    path.unlink()
    write("mine")
    write("mine")
    assert st.citation(path).made.endswith(", and by code of the user.")
    refused(lambda: write("other"), path, "the later changes differ")


def test_of_a_function_of_the_user_the_drawing_is_compared(tmp_path: Path) -> None:
    path, drawn = tmp_path / "a.png", drawn_by_a_user(stability_map(), title="A")
    drawn.savefig(path, overwrite="same")
    drawn.savefig(path, overwrite="same")
    assert st.citation(path).made.endswith(", and by code of the user.")
    drawn.axes[0].set_facecolor("0.5")  # as another version of the function draws it
    refused(lambda: drawn.savefig(path, overwrite="same"), path, "the later changes differ")


def test_every_figure_knows_its_call() -> None:
    spectrum = st.spectrum("rolling", at=[1.0, 1.5, 2.0], contact=st.Viscous(0.3))
    data = {st.plot_map: stability_map(), st.plot_locus: spectrum, st.plot_motion: motion()}
    for call, one in data.items():
        drawn = call(one)
        assert json.loads(drawn.origin["the call"]) == call.__name__ and not drawn.changed
        assert st.citation(drawn) == st.citation(one)


def test_a_figure_on_the_axes_of_another_is_a_changed_one() -> None:
    both = st.plot_map(stability_map(), width=2.5)
    works = len(st.citation(both).works)
    st.plot_motion(motion(), show="paths", ax=both.axes[0])
    assert both.changed and len(st.citation(both).works) > works


def test_a_file_says_what_made_it_and_what_to_cite(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    names = ["a.png", "film.html", "page.html"]
    with monkeypatch.context() as patch:
        patch.setattr(origin, "__version__", "0.4.9")
        for name in names:
            CALLS[name][0](tmp_path / name)
    for name, call in zip(names, ("sketch", "animate", "explore"), strict=True):
        cited = st.citation(tmp_path / name)
        assert cited.made.startswith(f"{name} was made by {call} with stability 0.4.9")
        assert [w.key for w in cited.works][:3] == ["stability", "przybylska2016", "casadi"]
        assert "note = {version 0.4.9}" in cited.bibtex.split("@")[1]
        assert main(["cite", str(tmp_path / name)]) == 0
        assert capsys.readouterr().out == cited.text + "\n"
    keys = [w.key for w in st.citation(str(tmp_path / "a.png")).works]
    assert keys == [w.key for w in st.citation(stability_map()).works]
    changed = (tmp_path / "a.png").read_bytes().replace(b"IDAT", b"iDAT", 1)
    (tmp_path / "a.png").write_bytes(changed)
    Image.new("RGB", (2, 2)).save(tmp_path / "b.png")
    for name, why in (("a", "it has been changed since"), ("b", "give a figure"), ("c", "No such")):
        assert main(["cite", str(tmp_path / f"{name}.png")]) == 2
        said = capsys.readouterr().err
        assert why in said and said.count("\n") == 1


def test_a_dataset_is_the_same_up_to_its_date(tmp_path: Path) -> None:
    path, run = tmp_path / "run.nc", motion()
    st.write_motion(run, path)
    whole = path.read_bytes()
    st.write_motion(run.assign_attrs(created="2001-01-01T00:00:00"), path, overwrite="same")
    assert path.read_bytes() != whole
    other = run.copy(deep=True)
    other.theta.values[-1] = np.nextafter(other.theta.values[-1], 2)

    def write() -> None:
        st.write_motion(other, path, overwrite="same")

    refused(write, path, "the numbers of its dataset differ")
    for content, why in ((whole[:-1], "damaged"), (whole[:5000], "damaged"), (b"", "empty")):
        path.write_bytes(content)
        refused(write, path, why)


def test_a_map_of_other_equations_is_another_map(tmp_path: Path) -> None:
    """Attributes name a user's system, and do not hold its equations."""

    def own(stiffness: float) -> Any:
        x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
        rates = ca.vertcat(x[1], -stiffness * p[0] * x[0] - p[1] * x[1])
        names = {"states": ("x", "v"), "parameters": ("k", "c")}
        family = st.Family(
            st.System("own", x, p, rates, **names), "rest", at=("k",), held={"x": 0, "v": 0}
        )
        return st.stability_map(family, x=("k", 1, 2, 4), y=("c", -1, 1, 5))

    path = tmp_path / "own.nc"
    st.write_map(own(1.0), path)
    st.write_map(own(1.0), path, overwrite="same")
    refused(
        lambda: st.write_map(own(1.5), path, overwrite="same"), path, "not what this call wrote"
    )


def test_what_a_class_of_the_user_computes_is_not_compared(tmp_path: Path) -> None:
    from dataclasses import dataclass

    @dataclass(frozen=True)
    class Mine:
        value: float = 1.0

    assert origin.origin_of("call", {"law": st.Viscous(0.3)}) is not None
    assert origin.origin_of("call", {"law": Mine()}) is None
    path = tmp_path / "a.svg"
    for _ in range(2):
        with atomic_write(path, overwrite=True) as draft:
            draft.write_text("<svg/>")

    def same() -> None:
        with atomic_write(path, overwrite="same") as draft:
            draft.write_text("<svg/>")

    refused(same, path, "it has no record of a call of this package")


def test_an_interrupted_call_loses_nothing(tmp_path: Path) -> None:
    paths = [tmp_path / "a.svg", tmp_path / "b.svg"]
    asked = origin.origin_of("call", {"n": 1})

    def write(stop: bool) -> None:
        with together():
            for path in paths:
                with atomic_write(path, overwrite="same", origin=asked) as draft:
                    draft.write_text("<svg/>")
                    if stop and path is paths[1]:
                        raise KeyboardInterrupt

    write(stop=False)
    before = [path.read_bytes() for path in paths]
    with pytest.raises(KeyboardInterrupt):
        write(stop=True)
    assert [path.read_bytes() for path in paths] == before
    assert sorted(os.listdir(tmp_path)) == ["a.svg", "b.svg"]


def test_all_files_of_a_call_are_the_same_or_none_is_replaced(tmp_path: Path) -> None:
    def write(stop: float) -> object:
        family = st.disk_family("spinning", "viscous")
        options = {"free": "phi_dot", "start": 5.0, "k": 0.25, "mu": 0.8}
        return st.auto_input(family, tmp_path, stop=stop, overwrite="same", **options)

    write(1.8)
    write(1.8)
    refused(lambda: write(1.7), tmp_path / "spinning.c", "c.spinning is not what this call wrote")


def test_a_store_of_the_same_call_goes_on_and_another_is_refused(tmp_path: Path) -> None:
    def write(most: float) -> object:
        axes = {"x": ("at", 1, 4, 5), "y": ("mu", 0.1, most, 4)}
        return st.stream_map("spinning", out=tmp_path / "a.zarr", overwrite="same", **axes)

    write(2)
    write(2)
    head = tmp_path / "a.zarr" / "zarr.json"
    refused(lambda: write(3), head, "was made with other arguments")


def test_the_command_line_has_a_flag(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, plot = tmp_path / "a.nc", tmp_path / "a.png"

    def run(*more: str, mu: str = "mu:0.1:2:4") -> int:
        words = ["map", "spinning", "--x", "at:1:3:5", "--y", mu, "--out", out, "--plot", plot]
        return main([*map(str, words), *more])

    assert run("--overwrite-same") == run("--overwrite-same") == 0
    assert run() == 2
    capsys.readouterr()
    before = out.read_bytes(), plot.read_bytes()
    assert run("--overwrite-same", mu="mu:0.1:3:4") == 2
    assert (out.read_bytes(), plot.read_bytes()) == before
    assert "is not what this call wrote (axes of attributes" in capsys.readouterr().err
    with pytest.raises(SystemExit, match="2"):
        run("--overwrite-same", "--overwrite")
    assert "not allowed with" in capsys.readouterr().err
    assert run("--overwrite", mu="mu:0.1:3:4") == 0


def test_a_foreign_file_is_refused_before_anything_is_computed(tmp_path: Path) -> None:
    picture, dataset = tmp_path / "a.png", tmp_path / "a.nc"
    Image.new("RGB", (2, 2)).save(picture)
    stability_map().abscissa.to_netcdf(dataset, engine="h5netcdf")
    for path in (picture, dataset):
        refused(lambda path=path: check_target(path, overwrite="same"), path, "it has no record")


@pytest.mark.parametrize("value", ["no", "Same", 3, None])
def test_another_value_is_refused_in_a_sentence(value: Any, tmp_path: Path) -> None:
    with pytest.raises(st.StabilityError, match="give True, False or 'same'"):
        st.write_map(stability_map(), tmp_path / "a.nc", overwrite=value)
