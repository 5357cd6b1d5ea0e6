"""The diagram of a random sample: a mark for each launch, and fractions with intervals."""

from typing import Any

import numpy as np
import pytest
import xarray
from figure_audit import faults
from matplotlib.collections import PathCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from scipy.stats import binomtest

import stability as st
from stability.base.errors import NameUnknownError, ParameterError
from stability.figures.basins import basins_caption
from stability.figures.fates import MARKS, MOST, fates
from stability.motion.result import Outcome

SPREAD = {"at": st.Uniform(0.1, 3.0), "tilt": st.LogUniform(0.01, 1.2), "k": st.Uniform(0.2, 0.5)}

COUNT = 120


@pytest.fixture(scope="module")
def found() -> xarray.Dataset:
    return st.basins(
        contact="viscous",
        mu=0.3,
        family="spinning",
        distribution=SPREAD,
        count=COUNT,
        horizon=200.0,
    )


@pytest.fixture(scope="module")
def plain(found: xarray.Dataset) -> Figure:
    return st.plot_basins(found)


def points(figure: Figure) -> np.ndarray[Any, Any]:
    """Places of all marks, in any order."""
    marks = [c for c in figure.axes[0].collections if isinstance(c, PathCollection)]
    every = np.concatenate([np.asarray(c.get_offsets()) for c in marks])
    return every[np.lexsort(every.T)]


def ordered(x: Any, y: Any) -> np.ndarray[Any, Any]:
    every = np.column_stack([x, y])
    return every[np.lexsort(every.T)]


@pytest.mark.long
def test_nothing_keeps_it_from_being_printed(found: xarray.Dataset) -> None:
    assert faults(st.plot_basins(found, title="a sample near spinning")) == []
    assert faults(st.plot_basins(found, x="k", y="end_time")) == []
    assert faults(st.plot_basins(found, width=6.9, fontsize=9)) == []


@pytest.mark.long
def test_every_launch_has_a_mark_at_its_numbers(found: xarray.Dataset) -> None:
    figure = st.plot_basins(found)
    assert np.array_equal(points(figure), ordered(found.phi_dot, found.tilt))
    main = figure.axes[0]
    assert (main.get_xscale(), main.get_yscale()) == ("linear", "log")
    assert main.get_xlabel().startswith("precession rate")
    wide = found.assign_attrs(sample="Independent(quantities={'tilt': Uniform(low=0, high=1)})")
    assert st.plot_basins(wide).axes[0].get_yscale() == "linear"
    other = st.plot_basins(found, x="tilt", y="at")
    assert np.array_equal(points(other), ordered(found.tilt, found.phi_dot))
    last = st.plot_basins(found, y="end_time")
    assert np.array_equal(points(last), ordered(found.phi_dot, found.end_time))
    assert last.axes[0].get_ylabel().startswith("time of the end")


def test_marks_of_an_end_have_its_shape_and_its_member_s_colour(
    found: xarray.Dataset, plain: Figure
) -> None:
    [fate] = [f for f in fates(found) if f.family == "spinning"]
    mine = np.column_stack([found.phi_dot.values, found.tilt.values])[fate.where]
    shades = fate.shades(found.member.values[fate.where])
    colours = dict(zip(map(tuple, mine), shades, strict=True))
    seen = 0
    for marks in plain.axes[0].collections:
        assert isinstance(marks, PathCollection)
        for place, colour in zip(marks.get_offsets(), marks.get_facecolor(), strict=False):
            if tuple(place) in colours:
                assert np.allclose(to_rgb(colour), colours[tuple(place)], atol=1e-6)
                assert len(marks.get_paths()[0]) == 5  # a square
                seen += 1
    assert seen == fate.where.sum() > 8


def test_the_legend_has_each_fraction_with_wilson_s_interval(
    found: xarray.Dataset, plain: Figure
) -> None:
    legend = plain.axes[0].get_legend()
    assert legend is not None
    said = [t.get_text() for t in legend.get_texts()]
    wanted = []
    for fate in fates(found):
        one = binomtest(int(fate.where.sum()), COUNT)
        ends = one.proportion_ci(method="wilson")
        wanted.append(
            f"{fate.label}, {100 * one.statistic:.0f} % "
            f"({100 * ends.low:.0f}–{100 * ends.high:.0f})"
        )
    assert said == wanted and len(said) == 3
    caption = basins_caption(found)
    assert all(w.replace(", ", " ") in caption for w in wanted)
    assert f"{COUNT} launches of a disk near spinning under viscous contact, drawn at" in caption
    assert "drawn at random over phi_dot, tilt, k, shown over phi_dot and tilt." in caption


@pytest.mark.long
def test_one_number_is_drawn_over_the_time_of_the_end() -> None:
    one = st.basins(
        contact="viscous",
        mu=0.3,
        count=40,
        horizon=30.0,
        distribution={"theta": st.Uniform(0.3, 1)},
    )
    figure = st.plot_basins(one)
    assert np.array_equal(points(figure), ordered(one.theta, one.end_time))
    assert faults(figure) == []


@pytest.mark.long
def test_a_large_sample_is_drawn_in_part_and_says_so(found: xarray.Dataset) -> None:
    many = xarray.concat([found] * (3600 // COUNT), "launch", combine_attrs="override")
    figure = st.plot_basins(many)
    assert len(points(figure)) == MOST < many.sizes["launch"]
    words = " ".join(t.get_text().replace("\n", " ") for t in figure.findobj(match=_is_text))
    assert f"the first {MOST} of 3600 launches shown" in words
    assert f"(the first {MOST} of 3600 launches are drawn)" in basins_caption(many)
    assert faults(figure) == []


def _is_text(artist: Any) -> bool:
    return hasattr(artist, "get_text") and not hasattr(artist, "get_texts")


@pytest.mark.long
def test_every_end_has_a_mark_of_its_own(found: xarray.Dataset) -> None:
    every = found.copy(deep=True)
    codes = every.outcome.values
    codes[:] = np.arange(codes.size) % len(Outcome)
    figure = st.plot_basins(every)
    assert faults(figure) == []
    legend = figure.axes[0].get_legend()
    assert legend is not None and len(legend.get_texts()) == len(fates(every)) >= 8
    marks = [
        MARKS[f.way][0]
        for f in fates(every)
        if f.label not in ("flat", "domain end", "left the domain")
    ]
    assert len(set(marks)) == len(marks)


def test_launches_that_are_not_there_yet_count_in_no_fraction(found: xarray.Dataset) -> None:
    some = found.copy(deep=True)
    some.outcome.values[:50] = -1
    assert len(points(st.plot_basins(some))) == COUNT - 50
    assert "50 launches are not computed yet" in basins_caption(some)
    some.outcome.values[:] = -1
    for draw in (st.plot_basins, basins_caption):
        with pytest.raises(ParameterError, match=f"none of the {COUNT} launches is computed yet"):
            draw(some)


def test_what_does_not_fit_is_refused(found: xarray.Dataset) -> None:
    with pytest.raises(NameUnknownError, match="x is 'mu'; give one of phi_dot, tilt, k, end_time"):
        st.plot_basins(found, x="mu")
    with pytest.raises(ParameterError, match="x and y are both k"):
        st.plot_basins(found, x="k", y="k")
    small = st.basins(
        contact="viscous", mu=0.3, horizon=1.0, x=("theta", 0.3, 1, 2), y=("omega3", 1, 2, 2)
    )
    with pytest.raises(ParameterError, match="leave them out for a map"):
        st.plot_basins(small, x="theta")
