"""A body that rolls at several inclinations: the page shows the one that is meant, or none."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from chromium import Visit, visit
from edged_body import edged, zeros
from node import Engine
from page_numbers import ASK

import stability as st
from stability.base.errors import ParameterError

BENDS = np.linspace(0.2, 0.3, 21)
ASKED = np.linspace(0.02, 0.6, 40)
"""Values of `bend` over its whole slider."""
STEADY = """([key, points]) => { const s = stabilityExplorer.view.subjects.get(key);
  return points.map((q) => (s.exists(q) ? s.steady(q)[0] : null)); }"""


@pytest.fixture(
    scope="module", params=[1, *(pytest.param(i, marks=pytest.mark.long) for i in (0, 2))]
)
def written(request: Any, tmp_path_factory: pytest.TempPathFactory) -> tuple[float, Path]:
    """A page that begins at one of the three inclinations."""
    at = zeros(0.25)[request.param]
    path = tmp_path_factory.mktemp("page") / "edged.html"
    st.explore(
        "rolling",
        body=edged(),
        contact="rough",
        at=0.3,
        theta=round(at, 3),
        certify=False,
        out=path,
    )
    return round(at, 3), path


@pytest.fixture(scope="module")
def asked(written: tuple[float, Path]) -> tuple[float, Engine]:
    """Its scripts."""
    theta, path = written
    return theta, Engine(path)


@pytest.fixture(scope="module")
def seen(browser: Any, written: tuple[float, Path]) -> Iterator[tuple[float, Visit]]:
    """The page itself."""
    theta, path = written
    with visit(browser, path) as found:
        yield theta, found
        assert not found.said and not found.asked


def points(view: Visit | Engine, bends: np.ndarray) -> list[list[float]]:
    names = view.page.evaluate("stabilityExplorer.view.subjects.get('rolling rough').names")
    given = {"omega3": 0.3, "axial": 0.5, "transverse": 0.3}
    return [[given.get(n, bend) for n in names] for bend in bends.tolist()]


@pytest.mark.parametrize("every", [4, pytest.param(1, marks=pytest.mark.long)])
def test_every_member_of_the_page_is_at_the_inclination_that_is_meant(
    asked: tuple[float, Engine], every: int
) -> None:
    """Over the whole slider; near its first value the page finds every one."""
    theta, view = asked
    bends = ASKED[::every]
    found = view.page.evaluate(STEADY, ["rolling rough", points(view, bends)])
    there = 0
    for bend, one in zip(bends.tolist(), found, strict=True):
        if one is not None:
            near = min(zeros(bend), key=lambda t: abs(t - theta))
            assert one == pytest.approx(near, abs=1e-9), bend
            there += 1
    assert there > 10 / every
    near_first = view.page.evaluate(STEADY, ["rolling rough", points(view, BENDS)])
    assert all(one is not None for one in near_first)


@pytest.mark.parametrize(
    "bends", [BENDS[::5], pytest.param(BENDS, marks=pytest.mark.long)], ids=["five", "all"]
)
def test_verdicts_are_those_of_that_inclination(
    asked: tuple[float, Engine], bends: np.ndarray
) -> None:
    theta, view = asked
    sets = points(view, bends)
    [answers] = view.page.evaluate(ASK, [{"key": "rolling rough", "points": sets}])
    for bend, one in zip(bends.tolist(), answers, strict=True):
        body = replace(edged(), shape={"bend": bend})
        known = st.spectrum("rolling", at=0.3, body=body, contact="rough", theta=theta)
        assert one["verdict"] == known.verdict.word, bend


def test_where_another_inclination_is_met_there_is_no_member(asked: tuple[float, Engine]) -> None:
    theta, view = asked
    sets = points(view, ASKED)
    found = view.evaluate(STEADY, ["rolling rough", sets])
    lost = [q for q, one in zip(sets, found, strict=True) if one is None]
    assert bool(lost) == (theta < 1.6)
    [answers] = view.evaluate(ASK, [{"key": "rolling rough", "points": lost}])
    assert all(one["verdict"] == "absent" for one in answers)


def test_where_another_inclination_is_met_the_page_says_that_it_is_not_sure(
    seen: tuple[float, Visit],
) -> None:
    theta, view = seen
    page = view.page
    found = page.evaluate(STEADY, ["rolling rough", points(view, ASKED)])
    lost = [b for b, one in zip(ASKED.tolist(), found, strict=True) if one is None]
    assert bool(lost) == (theta < 1.6)
    if not lost:
        return
    page.evaluate(
        "(bend) => { const {view} = stabilityExplorer;"
        "view.set({values: {...view.state.values, bend}}); }",
        lost[0],
    )
    page.wait_for_timeout(60)
    assert page.locator(".badge").inner_text().endswith("no member")
    assert "finds no member here" in page.locator(".point-panel .sentence").inner_text()


def test_a_float_has_no_bound_beside_it_and_blank_is_explained(seen: tuple[float, Visit]) -> None:
    _, view = seen
    said = view.page.locator(".conditions-card").inner_text()
    assert "(float)" in said and "±" not in said
    assert "Blank: no member found." in view.page.locator("body").inner_text()


def test_the_python_call_names_the_inclination(asked: tuple[float, Engine]) -> None:
    theta, view = asked
    assert view.evaluate("stabilityExplorer.python()").count(f"theta={theta:g}") == 3


def test_theta_without_a_body_or_for_another_family_is_one_sentence(tmp_path: Path) -> None:
    out = tmp_path / "page.html"
    with pytest.raises(ParameterError, match="theta belongs to rolling of a body"):
        st.explore("rolling", theta=1.5, out=out)
    with pytest.raises(ParameterError, match="theta chooses where a body rolls"):
        st.explore("tumbling", body=edged(), theta=1.5, out=out)
    assert not out.exists()
