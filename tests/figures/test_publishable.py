"""Every figure can be printed: no text over text or data, none too small, fonts that stay fonts."""

import io
import re
import warnings
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import casadi as ca
import matplotlib
import numpy as np
import pytest
from figure_audit import DEFICIENT, drawn, faults, lab, linear
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

import stability as st
from stability.atlas.build import atlas
from stability.base.errors import ParameterError
from stability.figures.canvas import COLUMN, save_figure
from stability.figures.shading import DIVERGING, Strip, linear_part
from stability.figures.styled_figure import StyledFigure, signed_ticks


def test_the_measure_finds_what_overlaps_and_what_is_small() -> None:
    figure = Figure()
    axes = figure.subplots()
    axes.plot([0, 1], label="a line")
    for where, word, size in ((0.5, "one", 9), (0.51, "two", 9), (0.2, "small", 5)):
        axes.text(where, where, word, fontsize=size)
    axes.text(0.8, 0.2, "pale", color="#a0a0a0")
    axes.legend(loc="upper left")
    assert sorted(f.split(" ")[0] for f in faults(figure)) == ["'one'", "'pale'", "'small'", "the"]
    # text of 10 pt in a figure of 6.4 in has 5.3 pt in a column
    assert sum("has 5.3 pt" in f for f in faults(figure, 3.39)) > 8


# --- figures of the atlas, of motions, of a user's system ---


@pytest.fixture(scope="module", params=[pytest.param("atlas", marks=pytest.mark.long)])
def pictures(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Figure]:
    """Every figure of the atlas, drawn from coarse maps and not saved: half a minute."""
    found: dict[str, Figure] = {}

    def save(figure: Figure, stem: Path, *_: object) -> list[Path]:
        found[stem.name] = figure
        return []

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("stability.figures.canvas.save", save)
        atlas(tmp_path_factory.mktemp("atlas") / "atlas", resolution=24, draft=False, workers=1)
    return found


def test_no_text_of_the_atlas_overlaps_or_is_too_small(pictures: dict[str, Figure]) -> None:
    assert len(pictures) == 31  # where nearly all launches end alike stands a sentence
    assert {name: said for name, f in pictures.items() if (said := faults(f))} == {}


def test_every_zone_of_an_atlas_diagram_has_its_word(pictures: dict[str, Figure]) -> None:
    rough, _, smooth, *_ = pictures["rolling-disk"].axes
    assert [t.get_text() for t in smooth.texts] == ["unstable", "neutral"]
    # a word that does not fit into its zone is left out, and not written into another
    assert [t.get_text() for t in rough.texts] == ["neutral"]
    assert rough.texts[0].get_position()[0] > 0.58


@pytest.fixture(scope="module")
def run() -> Any:
    start = [1.12, -0.31, 1.18, -1.45, -0.49, 0.46]
    return st.simulate(st.Disk(k=0.3), st.Coulomb(0.15), start, np.linspace(0, 10, 201), pose=True)


@pytest.fixture(scope="module")
def coin() -> Any:
    start = {"theta": 1.4, "omega3": 60.0}
    return st.simulate(st.Disk.named("quarter"), st.Viscous(0.3), start, 0.5, pose=True)


@pytest.mark.parametrize(
    ("which", "show"),
    [("run", "states"), ("coin", "paths"), ("run", "energy")]
    + [
        pytest.param(which, show, marks=pytest.mark.long)
        for which, show in (
            ("run", None),
            ("run", "paths"),
            ("coin", None),
            ("coin", "states"),
            ("coin", "energy"),
        )
    ],
)
def test_no_text_of_a_motion_overlaps_or_is_too_small(
    run: Any, coin: Any, which: str, show: Any
) -> None:
    assert faults(st.plot_motion({"run": run, "coin": coin}[which], show=show)) == []


@pytest.mark.long
def test_a_whole_motion_is_readable_in_a_column(run: Any) -> None:
    figure = st.plot_motion(run, width=COLUMN)
    assert faults(figure, COLUMN) == []
    left = {round(a.get_position().x0, 2) for a in figure.axes}
    assert len(figure.axes) == 8 and max(left) < 0.9
    # the parts stand one below the other, so that no panel is half as wide as the column
    assert min(a.bbox.width for a in figure.axes[:5]) > 0.5 * figure.bbox.width


@pytest.fixture(scope="module")
def quarter() -> Any:
    return st.stability_map(
        "spinning", x=("at", 40, 200, 10), y=("mu", 0.05, 3, 8), disk=st.Disk.named("quarter")
    )


def test_texts_of_a_map_keep_clear_at_another_size(quarter: Any) -> None:
    _clear_at([st.plot_map(quarter, width=5.0, fontsize=10)], 5.0, 10)


@pytest.mark.long
@pytest.mark.parametrize(("width", "fontsize"), [(None, None), (3.35, 7), (5.0, 10), (7.0, 12)])
def test_texts_keep_clear_at_any_size(quarter: Any, coin: Any, width: Any, fontsize: Any) -> None:
    size: dict[str, Any] = {"width": width, "fontsize": fontsize}
    spectra = st.spectrum(
        "spinning",
        at=np.linspace(40, 200, 50),
        disk=st.Disk.named("quarter"),
        contact=st.Viscous(0.3),
    )
    _clear_at([st.plot_map(quarter, **size), st.plot_locus(spectra, **size)], width, fontsize)
    assert st.plot_motion(coin, show="paths", **size).get_figwidth() == (width or 3.39)


def _clear_at(figures: list[Figure], width: float | None, fontsize: float | None) -> None:
    for figure in figures:
        texts = drawn(figure)
        assert faults(figure, texts=texts) == []
        assert figure.get_figwidth() == (width or 3.39)
        sizes = {t.get_fontsize() for t, _ in texts}
        assert min(sizes) == (fontsize or 7.5) - 1


@pytest.mark.long
def test_a_certified_map_shows_its_boxes_and_its_strip() -> None:
    found = st.stability_map(
        "spinning", x=("at", 1, 4, 24), y=("mu", 0.1, 2, 18), certify=True, levels=5
    )
    figure = st.plot_map(found)
    assert faults(figure) == []
    legend = figure.axes[0].get_legend()
    words = [t.get_text() for t in legend.get_texts()]  # type: ignore[union-attr]
    assert {"proved box", "strip that encloses it", "flutter boundary"} <= set(words)
    lines = [ln for ln in figure.axes[0].lines if len(ln.get_xdata()) > 2]  # type: ignore[arg-type]
    strip = [c for c in figure.axes[0].collections if c.get_zorder() == 2.2]
    # the strip is wider than the line on it
    assert max(ln.get_linewidth() for ln in lines) < strip[0].get_linewidth()[0]  # type: ignore[index]


def test_every_crossing_of_an_atlas_locus_has_its_circle(pictures: dict[str, Figure]) -> None:
    """The spinning disk has a real eigenvalue that crosses zero at 1/√k = 2, under any friction."""
    found = {}
    for name in ("locus-spinning-disk-mu3", "locus-tumbling-hoop-mu0_3", "locus-tumbling-disk-mu3"):
        [line] = [ln for ln in pictures[name].axes[0].lines if ln.get_marker() == "o"]
        found[name] = np.asarray(line.get_xdata(), dtype=float)
        assert set(line.get_ydata()) == {0.0}  # type: ignore[arg-type]
    step = 5 / 47
    assert found["locus-spinning-disk-mu3"][-1] == pytest.approx(2, abs=step)
    assert len(found["locus-spinning-disk-mu3"]) == 2
    for name, at, disk, mu in (
        ("hoop-mu0_3", 0.1, st.Disk.hoop(), 0.3),
        ("disk-mu3", 0.5, st.Disk(), 3.0),
    ):
        [proved] = st.boundaries(
            "tumbling", axis=("at", at, 1.5, 101), disk=disk, contact=st.Viscous(mu)
        )
        [circle] = found[f"locus-tumbling-{name}"]
        assert circle == pytest.approx(proved.value, abs=1.6 / 47)


def test_every_arc_of_a_locus_can_be_seen(pictures: dict[str, Figure]) -> None:
    """Growth up to 6.5e-6 between flat and 0.26, next to decay of 0.5, has a visible height."""
    axes = pictures["locus-tumbling-hoop-mu0_3"].axes[0]
    arcs = [np.max(ln.get_ydata()) for ln in axes.lines if len(ln.get_xdata()) > 9]  # type: ignore[arg-type]
    height = max(arcs)
    assert 1e-6 < height < 1e-5
    zero, top = (
        axes.transAxes.inverted().transform(axes.transData.transform((1.0, v)))[1]
        for v in (0.0, height)
    )
    assert top - zero > 0.05 and axes.get_yscale() == "asinh"


def test_no_two_modes_of_a_locus_share_a_name(pictures: dict[str, Figure]) -> None:
    for name, figure in pictures.items():
        if name.startswith("locus"):
            legend = figure.axes[0].get_legend()
            entries = [t.get_text() for t in legend.get_texts()]  # type: ignore[union-attr]
            modes = [e.split(": ")[1] for e in entries if ": " in e]
            assert len(modes) >= 2 and len(set(modes)) == len(modes), name


@pytest.mark.long
def test_many_parameters_of_a_system_keep_within_the_figure() -> None:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 9)
    names = ("k", "c", *(f"length of part {i}" for i in range(7)))
    rhs = ca.vertcat(x[1], -p[0] * x[0] - p[1] * x[1] + 0 * ca.sum1(p))
    system = st.System(
        "made of parts",
        x,
        p,
        rhs,
        states=("u", "v"),
        parameters=names,
        units=dict.fromkeys(names[2:], "mm"),
    )
    family = st.Family(system, "rest", at=("k",), held={"u": 0.0, "v": 0.0})
    held = {name: 1234.5 + i for i, name in enumerate(names[2:])}
    found = st.stability_map(family, x=("k", -1, 2, 9), y=("c", -1, 1, 9), **held)
    figure = st.plot_map(found)
    assert faults(figure) == []
    [note] = [t.get_text() for t in figure.texts]
    assert all(f"{name} = {held[name]:.5g} mm" in note for name in names[2:])
    assert faults(st.plot_locus(st.spectrum(family, at=np.linspace(-1, 2, 9), c=0.1, **held))) == []


# --- axes of a user ---


@pytest.mark.long
def test_a_user_gives_axes(run: Any, quarter: Any) -> None:
    spectra = st.spectrum("rolling", at=np.linspace(1, 2, 20), contact=st.Viscous(0.3))
    figure = Figure(figsize=(9, 8), layout="constrained")
    grid: Any = figure.subplots(2, 2)
    assert st.plot_map(quarter, ax=grid[0, 0]) is figure
    assert st.plot_locus(spectra, ax=grid[:, 1]) is figure
    st.plot_motion(run, show="paths", ax=grid[1, 0], fontsize=9)
    assert faults(figure) == []
    assert grid[0, 1].get_ylabel().startswith("growth") and grid[1, 1].lines
    sizes = {t.get_fontsize() for t in grid[1, 0].get_xticklabels()}
    assert sizes == {8.5}  # 9 pt less a half
    notes = [t.get_text() for axes in grid.flat for t in axes.texts]
    assert any("quarter" not in t and "kg" in t for t in notes)  # mass of the coin, in its unit
    lone = Figure().subplots()
    st.plot_locus(spectra, ax=lone)
    assert lone.get_xlabel().startswith("axial")


@pytest.mark.long
@pytest.mark.parametrize("layout", ["tight", "constrained"])
def test_maps_on_neighbouring_axes_leave_room_for_each_other(quarter: Any, layout: Any) -> None:
    figure = Figure(figsize=(6.7, 3), layout=layout)
    left, right = figure.subplots(1, 2)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # Matplotlib warns of axes that a layout does not know
        for ax in (left, right):
            st.plot_map(quarter, ax=ax)
        assert faults(figure) == []


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda m, _: st.plot_map(m, ax=Figure().subplots(), width=5), "width belongs to"),
        (lambda m, _: st.plot_map(m, fontsize=5), "fontsize is 5; give 7 to 40 points"),
        (lambda m, _: st.plot_map(m, width=0.5), "width is 0.5; give 2 to 40 inches"),
        (lambda m, _: st.plot_map(m, ax="here"), "ax is 'here'; give axes"),
        (lambda _, r: st.plot_motion(r, show="all"), "show is 'all'; give one of"),
        (lambda _, r: st.plot_motion(r, ax=Figure().subplots()), "give show"),
        (lambda _, r: st.plot_motion(r, show="energy", ax=Figure().subplots()), "holds 1 axes"),
    ],
)
def test_what_cannot_be_drawn_is_refused(
    call: Callable[[Any, Any], Any], said: str, quarter: Any, run: Any
) -> None:
    with pytest.raises(ParameterError, match=said):
        call(quarter, run)


def test_strips_need_a_figure_of_their_own(quarter: Any) -> None:
    strip = Strip("limit", np.arange(3.0), np.zeros(3), (), np.ones(3, dtype=np.int8))
    with pytest.raises(ParameterError, match="figure of their own"):
        st.plot_map(quarter, ax=Figure().subplots(), above=strip)


# --- fonts of PDFs ---


def fonts(content: bytes) -> set[bytes]:
    """Subtypes of all font objects of a PDF, in streams too."""
    parts = [content]
    for stream in re.findall(rb"stream\r?\n(.*?)endstream", content, re.DOTALL):
        try:
            parts.append(zlib.decompress(stream.rstrip(b"\r\n")))
        except zlib.error:
            parts.append(stream)
    found = set()
    for part in parts:
        for one in re.findall(
            rb"<<(?:[^<>]|<<[^<>]*>>|<[^<>]*>)*?/Type\s*/Font\b.*?>>", part, re.S
        ):
            found |= set(re.findall(rb"/Subtype\s*/(\w+)", one))
    return found


def _of_words(*_: Any) -> list[Figure]:
    figure = StyledFigure()
    figure.text(0.5, 0.5, "x")
    return [figure]


def _of_every_kind(quarter: Any, run: Any) -> list[Figure]:
    spectra = st.spectrum("rolling", at=np.linspace(1, 2, 20), contact=st.Viscous(0.3))
    return [st.plot_map(quarter), spectra.plot(), st.plot_motion(run)]


@pytest.mark.parametrize(
    "figures", [_of_words, pytest.param(_of_every_kind, marks=pytest.mark.long)]
)
def test_a_pdf_holds_fonts_of_type_42_alone(
    quarter: Any, run: Any, tmp_path: Path, figures: Callable[..., list[Figure]]
) -> None:
    """Type 42 is TrueType: in a PDF a `Type0` font whose descendant is a `CIDFontType2`."""
    for i, figure in enumerate(figures(quarter, run)):
        save_figure(figure, tmp_path / f"{i}.pdf")
        figure.savefig(tmp_path / f"own-{i}.pdf")  # as a user saves it
    for path in tmp_path.glob("*.pdf"):
        assert fonts(path.read_bytes()) == {b"Type0", b"CIDFontType2"}, path
    plain = Figure()
    plain.text(0.5, 0.5, "x")
    with matplotlib.rc_context({"pdf.fonttype": 3}):
        plain.savefig(tmp_path / "plain.pdf")
    assert b"Type3" in fonts((tmp_path / "plain.pdf").read_bytes())  # the reader can tell


# --- colours ---


@pytest.mark.parametrize("kind", DEFICIENT)
def test_growth_and_decay_have_two_colours_for_every_reader(kind: str) -> None:
    share = np.linspace(0.15, 0.5, 15)
    growth, decay = (linear(DIVERGING(0.5 + s * share)[:, :3]) for s in (1, -1))
    seen = [lab(np.clip(c @ np.array(DEFICIENT[kind]).T, 0, 1)) for c in (growth, decay)]
    # 2.3 is a difference that is just noticed; decay alone from grey has about 20 here
    assert np.linalg.norm(seen[0] - seen[1], axis=-1).min() > 18


def shades(figure: Figure) -> Iterator[tuple[int, float]]:
    """Verdict and spread of lightness of small squares of the main panel, printed in grey."""
    figure.set_dpi(300)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    rgb = np.asarray(canvas.buffer_rgba())[::-1, :, :3] / 255
    grey = lab(linear(rgb))[..., 0]
    box, side = figure.axes[0].bbox, 14  # the lines of the hatching are 12 pixels apart
    for i in range(int(box.y0) + 6, int(box.y1) - side - 6, side):
        for j in range(int(box.x0) + 6, int(box.x1) - side - 6, side):
            tile = grey[i : i + side, j : j + side]
            middle = figure.axes[0].transData.inverted().transform((j + side / 2, i + side / 2))
            yield middle, float(tile.max() - tile.min())


@pytest.mark.long
def test_growth_is_hatched_in_grey_on_every_shade_and_decay_is_not() -> None:
    found = st.stability_map("rolling", x=("at", 0.5, 2.5, 60), y=("mu", 0.01, 100, 60, "log"))
    figure = st.plot_map(found)
    for text in figure.axes[0].texts:
        text.set_visible(False)
    spreads: dict[bool, list[float]] = {True: [], False: []}
    for (x, _), spread in shades(figure):
        if abs(x - 2**0.5) > 0.1:  # away from the line of the boundary
            spreads[x < 2**0.5].append(spread)
    assert min(len(v) for v in spreads.values()) > 200
    assert np.quantile(spreads[True], 0.01) > 25  # of 100, on every shade of growth
    assert np.quantile(spreads[False], 0.99) < 8


# --- scales ---


def test_the_scale_of_colours_follows_the_data() -> None:
    hoop = st.stability_map(
        "tumbling", x=("at", 0.02, 1.5, 20), y=("mu", 0.01, 100, 15, "log"), disk=st.Disk.hoop()
    )
    rates = np.abs(hoop.abscissa.values)
    least, largest = linear_part(hoop.abscissa.values)
    assert largest == rates.max()
    assert (rates < least).mean() < 0.021 and (rates < 1e-4).mean() > 0.1


def test_labels_of_ticks_keep_their_distance() -> None:
    norm: Any = matplotlib.colors.SymLogNorm(1e-4, linscale=0.3, vmin=-1, vmax=1)
    ticks, labels = signed_ticks(lambda v: 170 * float(norm(v)), -1, 1, 1e-4, 10)
    places = 170 * np.asarray(norm(ticks))
    assert np.diff(places).min() >= 10 and 0 in ticks and len(ticks) == len(labels)
    assert [-t for t in reversed(ticks)] == ticks and max(ticks) == 1


def test_a_figure_is_a_sharp_picture_in_a_notebook(quarter: Any) -> None:
    """Also where pyplot, which makes figures pictures there, was never imported."""
    figure = st.plot_map(quarter)
    data, shown = figure._repr_mimebundle_()
    assert isinstance(figure, Figure)
    with Image.open(io.BytesIO(data["image/png"])) as image:
        size = shown["image/png"]
        assert image.size == (2 * size["width"], 2 * size["height"])
        assert 450 < size["width"] < 550  # a phone shows it whole


# --- titles ---


def _titled() -> list[Callable[[Any], Figure]]:
    chart = st.stability_map("spinning", x=("at", 1, 4, 9), y=("mu", 0.1, 2, 9))
    along = st.spectrum("rolling", at=[1.5, 2.0], contact=st.Viscous(0.3))
    return [
        lambda title: st.plot_map(chart, title=title),
        lambda title: st.plot_locus(along, title=title),
    ]


def test_a_long_title_is_broken_into_lines_that_the_figure_holds() -> None:
    for draw in _titled():
        assert faults(draw("a title of many words that says which question this one answers")) == []


@pytest.mark.parametrize(
    ("title", "why"),
    [(r"$\frac{x$", r"cannot read as a formula \(Expected"), (5, "title is 5; give a text")],
)
def test_a_title_that_cannot_be_drawn_is_refused(title: Any, why: str) -> None:
    for draw in _titled():
        with pytest.raises(ParameterError, match=why):
            draw(title)
