"""The basin diagram shows every launch by its end, in colour and in grey."""

import itertools
from typing import Any

import matplotlib
import numpy as np
import pytest
import xarray
from figure_audit import faults, lab, linear, seen
from matplotlib.collections import LineCollection, QuadMesh
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

import stability as st
from stability.base.errors import ParameterError
from stability.basin.borders import borders
from stability.figures.basins import basins_caption, cell_edges
from stability.figures.fates import PLAIN, RAMPS, fates, kinds
from stability.motion.result import Outcome


@pytest.fixture(scope="module")
def found() -> xarray.Dataset:
    return st.basins(
        st.Disk.hoop(),
        "viscous",
        mu=0.3,
        family="spinning",
        x=("at", 0.1, 3.0, 14),
        y=("tilt", 0.01, 1.2, 10),
        horizon=200.0,
    )


@pytest.fixture(scope="module")
def every(found: xarray.Dataset) -> xarray.Dataset:
    """All outcomes, and members of three families: data of no motion."""
    dataset = found.copy(deep=True)
    codes = dataset.outcome.values
    codes[:] = np.arange(codes.size).reshape(codes.shape) % len(Outcome)
    settled = codes == Outcome.SETTLED.code
    number = np.arange(codes.size).reshape(codes.shape)
    dataset.family.values[:] = np.where(settled, 1 + number % 3, 0)
    dataset.member.values[:] = np.where(settled, 0.3 + 0.01 * number, np.nan)
    return dataset


@pytest.fixture(scope="module")
def plain(found: xarray.Dataset) -> Figure:
    return st.plot_basins(found)


def mesh(figure: Figure) -> Any:
    [main] = [a for a in figure.axes if a.get_ylabel().startswith("tilt")]
    return next(c for c in main.collections if isinstance(c, QuadMesh))


def test_nothing_keeps_it_from_being_printed(every: xarray.Dataset) -> None:
    title = "launches near spinning: hoop"
    assert faults(st.plot_basins(every, title=title, width=6.9, fontsize=9)) == []
    quarter = st.basins(
        st.Disk.named("quarter"),
        "viscous",
        mu=0.3,
        horizon=0.3,
        x=("omega3", 1, 90, 5, "log"),
        y=("theta", 0.3, 1.5, 4),
    )
    figure = st.plot_basins(quarter)
    assert faults(figure) == []
    assert [a.get_xlabel() for a in figure.axes if a.get_xlabel()] == [
        r"axial angular velocity $\omega_3$  [rad/s]"
    ]
    assert figure.axes[0].get_xscale() == "log"


@pytest.mark.long
def test_nor_at_the_other_size(found: xarray.Dataset, every: xarray.Dataset) -> None:
    assert faults(st.plot_basins(every)) == []
    assert faults(st.plot_basins(found, title="launches near spinning: hoop")) == []
    assert faults(st.plot_basins(found, width=6.9, fontsize=9)) == []


def test_each_launch_has_the_colour_of_its_end_and_its_member(
    found: xarray.Dataset, plain: Figure
) -> None:
    drawn = np.asarray(mesh(plain).get_array()).reshape(*found.outcome.shape, 3)
    moving = found.outcome.values == Outcome.MOVING.code
    colours = drawn[moving]
    np.testing.assert_allclose(
        colours, np.tile(to_rgb(PLAIN[Outcome.MOVING][0]), (len(colours), 1))
    )
    words = found.family.attrs["flag_meanings"].split()
    for name in ("spinning", "tumbling"):
        mine = found.family.values == words.index(name)
        assert mine.sum() > 5
        members, light = found.member.values[mine], lab(linear(drawn[mine]))[:, 0]
        order = np.argsort(members)
        assert (np.diff(light[order]) <= 1e-9).all()
        assert light.max() - light.min() > 15


def test_ends_differ_by_hatching_and_by_hue_for_every_reader() -> None:
    looks = [("settled", ramp, texture) for ramp, texture, _ in RAMPS]
    looks += [
        (o.word, (c, c), texture)
        for o, (c, texture, _) in PLAIN.items()
        if o is not Outcome.DOMAIN_END
    ]
    textures = [texture for _, _, texture in looks]
    assert len(set(textures)) == len(textures)
    for (_, a, _), (_, b, _) in itertools.combinations(looks, 2):
        if a == b == ("#ffffff", "#ffffff"):  # no outcome: distinguished by hatching alone
            continue
        middle = [np.mean([to_rgb(c) for c in pair], axis=0) for pair in (a, b)]
        one, other = (lab(linear(np.array(m))) for m in middle)
        assert np.linalg.norm(one - other) > 12
    for _, pair, _ in looks:  # hatching is dark on every shade, in grey too
        dark = seen(matplotlib.rcParamsDefault["text.color"])["grey"][0]
        assert min(seen(c)["grey"][0] for c in pair) - dark > 45


def test_borders_run_between_cells_of_different_ends_and_nowhere_else(
    found: xarray.Dataset,
) -> None:
    drawn = kinds(found)
    x, y = found.phi_dot.values, found.tilt.values
    lines = cell_edges(x, y, drawn)
    step = (x[1] - x[0], y[1] - y[0])
    length = sum(abs(b[0] - a[0]) / step[0] + abs(b[1] - a[1]) / step[1] for a, b in lines)
    inner = [drawn[:, 1:] != drawn[:, :-1], (drawn[1:] != drawn[:-1]).T]
    # cells at the margin are half as wide
    weight = [np.r_[0.5, np.ones(len(v) - 2), 0.5] for v in (y, x)]
    assert length == pytest.approx(
        sum(float(w @ i.sum(axis=1)) for w, i in zip(weight, inner, strict=True))
    )
    for (x0, y0), (x1, y1) in lines:
        side = 1e-3 * np.array(step)
        for cut in np.linspace(0.01, 0.99, 7):
            at = np.array([x0 + cut * (x1 - x0), y0 + cut * (y1 - y0)])
            off = side * ([1, 0] if x0 == x1 else [0, 1])
            cells = [
                drawn[round((q[1] - y[0]) / step[1]), round((q[0] - x[0]) / step[0])]
                for q in (at - off, at + off)
            ]
            assert cells[0] != cells[1]


def test_refined_borders_are_drawn_where_the_dataset_holds_them(found: xarray.Dataset) -> None:
    lines = borders(
        lambda p: (np.hypot(p[:, 0] - 1.5, p[:, 1] - 0.6) < 0.4).astype(int),
        ("phi_dot", 0.1, 3, 14),
        ("tilt", 0.01, 1.2, 10),
        levels=3,
    ).lines
    points = np.concatenate([line.points for line in lines])
    curve = np.repeat(np.arange(len(lines)), [len(line.points) for line in lines])
    refined = found.assign(
        border_curve=("border_point", curve),
        border_phi_dot=("border_point", points[:, 0]),
        border_tilt=("border_point", points[:, 1]),
    )
    [main] = [a for a in st.plot_basins(refined).axes if a.get_ylabel().startswith("tilt")]
    drawn = [c for c in main.collections if isinstance(c, LineCollection)][-1].get_segments()
    np.testing.assert_array_equal(np.concatenate(drawn), points)
    assert "refined" in basins_caption(refined)
    assert "edges between cells" in basins_caption(found)


def test_the_strip_has_the_proved_thresholds(plain: Figure) -> None:
    above = plain.axes[0]
    [line] = [li for li in above.lines if len(li.get_xdata()) == 2]
    true = st.boundaries(
        "spinning", axis=("at", 0.1, 3, 5), disk=st.Disk.hoop(), contact=st.Viscous(0.3)
    )
    assert line.get_xdata()[0] == pytest.approx(true[0].value, rel=1e-11)
    assert [t.get_text() for t in above.texts] == ["unstable", "stable"]


@pytest.mark.long
def test_a_user_draws_on_axes_of_their_own(found: xarray.Dataset) -> None:
    figure = Figure(figsize=(7, 3.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    assert st.plot_basins(found, ax=left) is figure
    st.plot_basins(found, ax=right, fontsize=8)
    assert len([a for a in figure.axes if a.get_ylabel().startswith("tilt")]) == 2
    assert not [said for said in faults(figure) if "leaves" in said]


def test_the_caption_counts_every_launch(found: xarray.Dataset, every: xarray.Dataset) -> None:
    for dataset in (found, every):
        said = basins_caption(dataset)
        for fate in fates(dataset):
            assert f"{int(fate.where.sum())} {fate.label}" in said
        assert sum(int(f.where.sum()) for f in fates(dataset)) == dataset.outcome.size
    some = found.copy(deep=True)
    some.outcome.values[0] = -1  # a chunk that is not there yet
    assert "14 not computed yet (white)" in basins_caption(some)
    drawn = np.asarray(mesh(st.plot_basins(some)).get_array()).reshape(*some.outcome.shape, 3)
    assert (drawn[0] == 1).all()


def test_what_is_no_map_is_refused(found: xarray.Dataset) -> None:
    with pytest.raises(ParameterError, match="give what basins returns"):
        st.plot_basins(xarray.Dataset())
    with pytest.raises(ParameterError, match=r"choose two, such as dataset.isel\(k=0\)"):
        st.plot_basins(found.expand_dims("k"))
    with pytest.raises(ParameterError, match="fontsize"):
        st.plot_basins(found, fontsize=3)


def test_sensitive_blocks_have_dashes_and_a_sentence(found: xarray.Dataset) -> None:
    ends = np.array([[[0.5, 1.0], [0.2, 0.4]], [[1.0, 1.5], [0.2, 0.4]], [[2.0, 2.5], [0.5, 0.7]]])
    marked = found.assign(
        border_block_phi_dot=(("border_block", "edge"), ends[:, 0]),
        border_block_tilt=(("border_block", "edge"), ends[:, 1]),
        border_sensitive=("border_block", np.array([1, 1, 0], dtype=np.int8)),
    ).assign_attrs(
        border_exponent=0.61, border_exponent_interval=[0.5, 0.72], border_exponent_level=0.95
    )
    figure = st.plot_basins(marked)
    assert faults(figure) == []
    [main] = [a for a in figure.axes if a.get_ylabel().startswith("tilt")]
    dashed = [c for c in main.collections if isinstance(c, LineCollection)][-1].get_segments()
    sides = sorted(np.asarray(s).tolist() for s in dashed)  # one rectangle about both blocks
    assert sides == [
        [[0.5, 0.2], [0.5, 0.4]],
        [[0.5, 0.2], [1.5, 0.2]],
        [[0.5, 0.4], [1.5, 0.4]],
        [[1.5, 0.2], [1.5, 0.4]],
    ]
    entries = [
        t.get_text() for a in figure.axes if a.get_legend() for t in a.get_legend().get_texts()
    ]  # type: ignore[union-attr]
    assert entries[-1] == "sensitive"
    words = basins_caption(marked)
    assert "2 of 3 blocks along the borders are sensitive" in words
    assert "0.61 [0.50, 0.72], 95 % confidence" in words
    strips = basins_caption(marked.assign(border_sensitive=2 * marked.border_sensitive))
    assert "2 blocks are open" in strips and "None of the 3 blocks" in strips
    smooth = marked.assign(border_sensitive=0 * marked.border_sensitive)
    assert "None of the 3 blocks" in basins_caption(smooth)
    assert "sensitive" not in basins_caption(found)


def test_launches_that_are_not_computed_have_no_border(found: xarray.Dataset) -> None:
    half = found.copy(deep=True)
    half.outcome.values[:, 7:] = -1
    whole = found.copy(deep=True)
    whole.outcome.values[:], whole.family.values[:] = Outcome.MOVING.code, 0
    whole.outcome.values[:, 7:] = -1
    [main] = [a for a in st.plot_basins(whole).axes if a.get_ylabel().startswith("tilt")]
    [lines] = [c for c in main.collections if isinstance(c, LineCollection)]
    assert lines.get_segments() == []
    [main] = [a for a in st.plot_basins(half).axes if a.get_ylabel().startswith("tilt")]
    [lines] = [c for c in main.collections if isinstance(c, LineCollection)]
    edge = (found.phi_dot.values[6] + found.phi_dot.values[7]) / 2
    assert lines.get_segments()
    assert max(np.asarray(s)[:, 0].max() for s in lines.get_segments()) <= edge
    upright = [s for s in lines.get_segments() if np.ptp(np.asarray(s)[:, 0]) == 0]
    assert max(float(np.asarray(s)[0, 0]) for s in upright) < edge


def test_a_body_is_named_with_its_numbers_and_a_map_of_states_has_a_caption() -> None:
    torus = st.basins(
        body=st.Torus(0.3),
        contact="viscous",
        mu=0.3,
        horizon=1.0,
        check=False,
        x=("phi_dot", 0.5, 3, 3),
        y=("theta", 0.6, 1.2, 3),
    )
    figure = st.plot_basins(torus)
    [words] = [t.get_text() for t in figure.texts if "until" in t.get_text()]
    assert words.startswith("torus, viscous contact, ") and "$b$ = 0.3" in words
    assert "length" not in words
    said = basins_caption(torus)
    assert said.startswith("Ends of 9 launches of a torus under viscous contact, over phi_dot and")
