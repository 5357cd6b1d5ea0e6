"""Loci and diagrams take names, units and textures from the system and from the verdicts."""

import math
from typing import Any

import casadi as ca
import numpy as np
import pytest
from figure_audit import faults
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure

import stability as st
from stability.base.errors import ParameterError
from stability.base.looks import LOOKS
from stability.figures.diagram import colour_scale
from stability.figures.loci import swept
from stability.figures.modes import mode_groups
from stability.figures.shading import Strip

UNITS = {"lean": "rad", "lean_rate": "rad/s", "k": "1/s2", "c": "1/s", "x y": "mm"}


def pendulum(units: dict[str, str] | None = None) -> st.Family:
    """λ² - c λ + k - x = 0 for the two states, with odd names."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 3)
    rhs = ca.vertcat(x[1], (p[2] - p[0]) * x[0] + p[1] * x[1])
    system = st.System(
        "disk, viscous",
        x,
        p,
        rhs,
        states=("lean", "lean_rate"),
        parameters=("k", "c", "x y"),
        units=units or {},
    )
    return st.Family(system, "up right", at=("k",), held={"lean": 0.0, "lean_rate": 0.0})


def texts(figure: Figure) -> list[str]:
    found = [t.get_text() for a in figure.axes for t in a.texts]
    found += [t for a in figure.axes for t in (a.get_xlabel(), a.get_ylabel())]
    legends = [*figure.legends, *(a.get_legend() for a in figure.axes if a.get_legend())]
    return found + [t.get_text() for one in legends for t in one.get_texts()]


def written(axes: Any) -> list[str]:
    """Words on the panel; the note below the figure is not among them."""
    return [t.get_text() for t in axes.texts if t.get_text() and "=" not in t.get_text()]


# --- loci ---


def test_a_locus_has_the_units_and_names_of_the_system() -> None:
    sweep = np.linspace(1, 2, 5)
    found = texts(st.plot_locus(st.spectrum(pendulum(UNITS), at=sweep, c=-0.1, **{"x y": 0.0})))
    assert {
        "growth rate\nRe $\\lambda$  [1/s]",
        "frequency\n|Im $\\lambda$|  [1/s]",
        "k  [1/s²]",
        "1: lean, lean_rate",
    } <= set(found)
    assert not [t for t in found if "sqrt" in t or "theta" in t]
    bare = texts(st.plot_locus(st.spectrum(pendulum(), at=sweep, c=-0.1, **{"x y": 0.0})))
    assert {"growth rate\nRe $\\lambda$", "frequency\n|Im $\\lambda$|", "k"} <= set(bare)


def test_a_locus_of_the_disk_has_its_units() -> None:
    disk = st.Disk(mass=0.3, radius=0.2, gravity=9.81)
    found = st.spectrum("rolling", at=np.linspace(3, 9, 4), disk=disk, contact=st.Viscous(0.3))
    assert {
        "growth rate\nRe $\\lambda$  [1/s]",
        r"axial angular velocity $\omega_3$  [rad/s]",
    } <= set(texts(st.plot_locus(found)))


@pytest.mark.long
def test_a_locus_is_drawn_against_what_was_swept() -> None:
    sweep = np.linspace(-1, 1, 9)
    figure = st.plot_locus(st.spectrum(pendulum(UNITS), at=1.0, c=sweep, **{"x y": 0.0}))
    assert figure.axes[1].get_xlabel() == "c  [1/s]" and figure.axes[1].get_xlim() == (-1, 1)
    line = next(ln for ln in figure.axes[0].get_lines() if len(ln.get_xdata()) == 9)
    np.testing.assert_array_equal(line.get_xdata(), sweep)
    # λ² - c λ + 1 = 0 has the real part c/2 for |c| < 2
    np.testing.assert_allclose(line.get_ydata(), sweep / 2, atol=1e-12)
    disk = st.Disk(k=np.linspace(0.2, 0.5, 5))
    figure = st.plot_locus(st.spectrum("rolling", at=1.0, disk=disk, contact=st.Viscous(0.3)))
    assert figure.axes[1].get_xlabel() == "inertia factor $k$"
    law = st.Viscous(np.linspace(0.2, 0.5, 5))
    figure = st.plot_locus(st.spectrum("rolling", at=1.0, contact=law))
    label = r"friction coefficient $\mu$ of $F = -\mu\,N\,v$  [$1/\sqrt{gR}$]"
    assert figure.axes[1].get_xlabel() == label


def test_a_circle_lies_on_the_threshold_that_is_given() -> None:
    found = st.spectrum("rolling", at=np.linspace(1, 2, 4), contact=st.Viscous(0.3))
    figure = st.plot_locus(found, thresholds=[2**0.5])
    [ring] = [n for n in figure.axes[0].get_lines() if n.get_label() == r"Re $\lambda$ = 0"]
    assert list(ring.get_xdata()) == [2**0.5]


def test_a_locus_marks_proved_boundaries_and_nothing_between_its_points() -> None:
    """At 12 points a straight line would put the mark far from the curve and from the boundary."""
    law = st.Viscous(0.8)
    found = st.spectrum("spinning", at=np.linspace(0.5, 4, 12), contact=law)
    proved = st.boundaries("spinning", axis=("at", 0.5, 4, 60), contact=law)
    values = [p.value for p in proved]
    assert values[0] == 2.0 and len(values) == 2

    def marks(**known: Any) -> list[float]:
        lines = st.plot_locus(found, **known).axes[0].get_lines()
        return [float(x) for n in lines if n.get_marker() == "o" for x in n.get_xdata()]

    assert marks() == []
    assert marks(thresholds=proved) == marks(thresholds=values) == values
    assert marks(thresholds=proved[1:], zeros=[2.0]) == values
    assert marks(thresholds=[1.0]) == []  # no growth rate changes its sign there
    with pytest.raises(ParameterError, match="zeros belongs to a spectrum along a quantity"):
        st.plot_locus(st.spectrum("spinning", at=1.0, contact=law), zeros=[2.0])


def test_a_mode_of_a_locus_has_one_line_and_dots_mean_one_thing() -> None:
    """The disk tumbles with a pair that splits and meets a third eigenvalue: one mode of three."""
    found = st.spectrum("tumbling", at=np.linspace(0.1, 1.5, 60), contact=st.Viscous(3.0))
    figure = st.plot_locus(found, thresholds=[0.74])
    styles: dict[str, set[Any]] = {}
    for axes in figure.axes:
        for line in axes.get_lines():
            known = str(line.get_label())
            word = str(line.get_color()) if len(line.get_xdata()) == 60 else known
            styles.setdefault(word, set()).add(str(line._unscaled_dash_pattern))  # type: ignore[attr-defined]
    assert all(len(each) == 1 for each in styles.values()), styles
    changes = styles.pop("change of verdict")
    assert all(not (changes & each) for each in styles.values())


def test_long_names_of_a_legend_stay_in_the_figure() -> None:
    x, p = ca.SX.sym("x", 5), ca.SX.sym("p")
    names = [f"a_rather_long_name_of_state_{i}" for i in range(5)]
    rates = ca.vertcat(*[-(i + 1) * x[i] + p * x[(i + 1) % 5] for i in range(5)])
    system = st.System("long", x, p, rates, states=names, parameters=("p",))
    family = st.Family(system, "rest", at=("p",), held=dict.fromkeys(names, 0.0))
    assert faults(st.plot_locus(st.spectrum(family, at=np.linspace(0.1, 4, 9)))) == []


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("sweep", "scale"),
    [
        (np.geomspace(0.1, 50, 9), "log"),
        (np.linspace(0.1, 50, 9), "linear"),
        ([0.1, 50], "linear"),
    ],
)
def test_a_sweep_of_equal_ratios_has_a_logarithmic_axis(sweep: Any, scale: str) -> None:
    figure = st.plot_locus(st.spectrum("spinning", at=3.0, contact=st.Viscous(np.asarray(sweep))))
    assert [a.get_xscale() for a in figure.axes] == [scale, scale]


def test_a_spectrum_and_a_map_are_told_apart() -> None:
    chart = st.stability_map("spinning", x=("at", 1, 4, 3), y=("mu", 0.1, 2, 3))
    found = st.spectrum("rolling", at=[1.2, 1.8], contact=st.Viscous(0.3))
    with pytest.raises(ParameterError, match="dataset is a spectrum; give what stability_map"):
        st.plot_map(found)
    with pytest.raises(ParameterError, match="or plot_map for a map"):
        st.plot_locus(chart)


def test_a_spectrum_that_is_no_sweep_is_refused() -> None:
    family, other = pendulum(), {"x y": 0.0}
    for at, c, said in (
        (np.ones((2, 2)), 0.1, "shape"),
        ([1.0, 1.0], 0.1, "nothing changes"),
        ([1.0, 2.0], [0.1, 0.2], "c and k changes|k and c changes"),
    ):
        with pytest.raises(ParameterError, match=said):
            st.plot_locus(st.spectrum(family, at=at, c=c, **other))
    name, values = swept(st.spectrum(family, at=[2.0, 2.0, 2.0], c=[0.1, 0.2, 0.3], **other))
    assert name == "c" and values.tolist() == [0.1, 0.2, 0.3]


def test_a_locus_without_oscillation_says_so() -> None:
    found = st.spectrum(pendulum(), at=np.linspace(0.1, 0.2, 5), c=-1.0, **{"x y": 0.0})
    figure = st.plot_locus(found)
    assert "no oscillation: every eigenvalue is real" in texts(figure)
    assert not len(figure.axes[1].get_yticks())


def test_no_pair_has_two_colours() -> None:
    """Halves of a pair share a mode at every point; the uniform disk tumbles with such a change."""
    spectra = st.spectrum("tumbling", at=np.linspace(0.02, 1.57, 400), contact=st.Viscous(3.0))
    values = np.take_along_axis(spectra.eigenvalues, spectra.tracked(), axis=-1)
    groups = mode_groups(values)
    mode = {column: i for i, columns in enumerate(groups) for column in columns}
    assert sorted(mode) == [0, 1, 2, 3, 4]
    split = 0
    for row in values:
        for i, j in np.argwhere(np.abs(row[:, None] - row.conj()) == 0):
            if i < j and row[i].imag:
                assert mode[int(i)] == mode[int(j)]
                split += 1
    assert split > 500  # two pairs over much of the axis


# --- diagrams ---


@pytest.fixture(scope="module")
def crossed() -> Any:
    """Unstable for c > 0, and on the row c = 0 an exact centre."""
    return st.stability_map(pendulum(UNITS), x=("k", 1, 2, 7), y=("c", -1, 1, 9), **{"x y": 0.0})


@pytest.fixture(scope="module")
def plain(crossed: Any) -> Figure:
    return st.plot_map(crossed)


def hatched(figure: Figure) -> dict[str, Any]:
    sets = [c for c in figure.axes[0].collections if getattr(c, "hatches", [None])[0]]
    return {c.hatches[0]: c for c in sets}


def inside(collection: Any, x: float, y: float) -> bool:
    return any(path.contains_point((x, y)) for path in collection.get_paths())


def test_hatching_follows_the_verdict_and_not_the_sign(crossed: Any) -> None:
    moved = crossed.copy(deep=True)
    moved["abscissa"][:] = 1e-3  # every cell grows by its number
    codes = np.ones((9, 7), dtype=np.int8)  # stable
    codes[6:], codes[3], codes[4], codes[5] = 2, 5, 0, 3
    moved["verdict"][:] = codes
    found = hatched(st.plot_map(moved))
    textured = {v: LOOKS[v.word].hatching for v in st.Verdict if LOOKS[v.word].hatching}
    assert set(found) == {*textured.values()}
    by_code = {v.code: found[hatch] for v, hatch in textured.items()}
    for i, c in enumerate(moved.c.values[:-1]):
        for code, drawn in by_code.items():
            assert inside(drawn, 1.5, c + 1e-3) == (codes[i, 0] == code), (i, code)


def test_the_scale_says_which_rates_are_grey(crossed: Any, plain: Figure) -> None:
    """Colours with nearly equal channels are grey: those within the linear part, alone."""
    linear, _ = colour_scale(crossed)
    mesh = next(c for c in plain.axes[0].collections if isinstance(c, QuadMesh))
    for share, grey in ((0.0, True), (0.9, True), (-0.9, True), (100.0, False), (-100.0, False)):
        red, green, blue, _ = mesh.cmap(mesh.norm(share * linear))
        assert (max(red, green, blue) - min(red, green, blue) < 0.1) == grey, share


def test_a_thin_region_is_named_in_the_legend(crossed: Any) -> None:
    moved = crossed.copy(deep=True)
    codes = np.ones((9, 7), dtype=np.int8)
    codes[:, 3] = 0  # a column is narrower than the word
    moved["verdict"][:] = codes
    axes = st.plot_map(moved).axes[0]
    assert written(axes) == ["stable"]
    legend = axes.get_legend()
    assert legend is not None and "undecided" in [t.get_text() for t in legend.get_texts()]


def test_a_diagram_has_the_units_of_the_system_under_any_name(plain: Figure) -> None:
    found = texts(plain)
    assert {"k  [1/s²]", "c  [1/s]", r"largest growth rate max Re $\lambda$  [1/s]"} <= set(found)


def test_an_axis_with_a_space_keeps_its_logarithm() -> None:
    found = st.stability_map(
        pendulum(UNITS), x=("k", 3, 4, 3), y=("x y", 0.01, 1, 4, "log"), c=-0.5
    )
    axes = st.plot_map(found).axes[0]
    assert axes.get_yscale() == "log" and axes.get_xscale() == "linear"
    assert axes.get_ylabel() == "x y  [mm]"


@pytest.mark.long
def test_a_dollar_in_a_name_is_drawn_as_it_is() -> None:
    x, p = ca.SX.sym("x"), ca.SX.sym("p", 2)
    system = st.System("$", x, p, (p[0] - p[1]) * x, states=("$n$",), parameters=("$a$", "b_{"))
    family = st.Family(system, "zero", at=("$a$",), held={"$n$": 0.0})
    found = st.stability_map(family, x=("$a$", 1, 2, 3), y=("b_{", 1.1, 3, 3))
    st.plot_map(found).canvas.draw()
    figure = st.plot_locus(st.spectrum(family, at=[1.0, 2.0], **{"b_{": 3.0}))
    figure.canvas.draw()
    assert r"\$a\$" in texts(figure) and r"1: \$n\$" in texts(figure)


@pytest.mark.long
def test_the_legend_lists_no_boundary_of_one_point() -> None:
    """Tumbling meets spinning at upright, where an eigenvalue is zero: one point on the frame."""
    hoop = st.stability_map(
        "tumbling",
        x=("at", 0.02, math.pi / 2, 40),
        y=("mu", 0.01, 100, 30, "log"),
        disk=st.Disk.hoop(),
    )
    assert hoop.sizes["boundary_point"] > 20
    spinning = st.stability_map("spinning", x=("at", 0.5, 5, 40), y=("mu", 0.01, 10, 30, "log"))
    both = ["flutter boundary", "static boundary"]
    for found, said in ((hoop, both[:1]), (spinning, both)):
        axes = st.plot_map(found).axes[0]
        entries = (text.get_text() for text in axes.get_legend().get_texts())
        assert sorted(words for words in entries if words.endswith("boundary")) == said
        for line in axes.lines:  # each is long enough to be seen
            if "boundary" in str(line.get_label()):
                assert (
                    np.ptp(
                        axes.transAxes.inverted().transform(
                            axes.transData.transform(line.get_xydata())
                        ),
                        axis=0,
                    ).max()
                    > 0.1
                )


def test_a_strip_is_hatched_by_its_verdicts(crossed: Any) -> None:
    k = np.linspace(1, 2, 21)
    codes = np.where(k < 1.5, 2, 3).astype(np.int8)
    strip = Strip("limit", k, np.zeros(21), (1.5,), codes)
    axes = st.plot_map(crossed, above=strip).axes[0]
    assert written(axes) == ["unstable", "neutral"]
    drawn = {c.hatches[0]: c for c in axes.collections if getattr(c, "hatches", [None])[0]}
    assert inside(drawn["////"], 1.2, 0.5) and not inside(drawn["////"], 1.8, 0.5)
    assert inside(drawn["...."], 1.8, 0.5) and not inside(drawn["...."], 1.2, 0.5)


def test_a_word_of_a_strip_stands_in_its_own_zone_or_not_at_all(crossed: Any) -> None:
    k = np.linspace(1, 2, 101)
    for edge in (1.1, 1.5):
        codes = np.where(k < edge, 2, 3).astype(np.int8)
        figure = st.plot_map(crossed, above=Strip("limit", k, np.zeros(101), (edge,), codes))
        figure.canvas.draw()
        axes = figure.axes[0]
        zones = {"unstable": (1.0, edge + 0.01), "neutral": (edge - 0.01, 2.0)}
        for text in axes.texts:
            box = text.get_window_extent().transformed(axes.transData.inverted())
            low, high = zones[text.get_text()]
            assert low < box.x0 < box.x1 < high
        assert written(axes) == ["unstable", "neutral"][int(edge == 1.1) :]


def test_axes_have_a_tick_at_both_ends() -> None:
    chart = st.stability_map("spinning", x=("at", 0.02, 5, 9), y=("k", 0.2501, 0.5, 9), mu=0.3)
    axes = st.plot_map(chart).axes[0]
    axes.figure.canvas.draw()
    for axis, ends, words in (
        (axes.xaxis, (0.02, 5), ("0.02", "5")),
        (axes.yaxis, (0.2501, 0.5), ("0.25", "0.50")),
    ):
        ticks = axis.get_majorticklocs()
        assert (ticks[0], ticks[-1]) == ends and 4 <= len(ticks) <= 8
        labels = [t.get_text() for t in axis.get_majorticklabels()]
        assert (labels[0], labels[-1]) == words
        assert len({len(t.partition(".")[2]) for t in labels[1:-1]}) == 1


def test_a_long_label_of_friction_leaves_the_names_of_strips_free() -> None:
    chart = st.stability_map("spinning", x=("at", 0.02, 5, 9), y=("mu", 0.01, 100, 9, "log"))
    k = np.linspace(0.02, 5, 41)
    codes = np.where(k < 2, 2, 3).astype(np.int8)
    strip = Strip("smooth", k, np.zeros(41), (2.0,), codes)
    assert faults(st.plot_map(chart, above=strip, below=strip, title="spinning")) == []


def test_maps_of_one_scale_have_the_same_colours_for_the_same_rate() -> None:
    axes = {"x": ("at", 1, 4, 9), "y": ("mu", 0.1, 2, 9)}
    charts = [st.stability_map("spinning", **axes, disk=d) for d in (st.Disk(), st.Disk.hoop())]
    scale = colour_scale(*charts)
    norms = [st.plot_map(c, scale=scale).axes[0].collections[0].norm for c in charts]
    assert len({(n.vmin, n.vmax, n.linthresh) for n in norms}) == 1
    assert norms[0].vmax == max(float(np.abs(c.abscissa).max()) for c in charts)
    for wrong in ((1.0, 0.5), (0.0, 1.0), (-1.0, 1.0)):
        with pytest.raises(st.StabilityError, match="scale"):
            st.plot_map(charts[0], scale=wrong)
