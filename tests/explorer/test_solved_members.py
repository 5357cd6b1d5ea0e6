"""Families whose members are solved for: the page finds the members that the package finds."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
from chromium import WITHOUT_WEBGL, Visit, visit
from node import Engine
from own_families import governor
from page_numbers import ASK, LOOKED

import stability as st
from stability.base.errors import NoMemberError

POINTS, SEED = 150, 23
SAME = 1e-9
"""Largest difference of eigenvalues over the largest modulus."""
NEAR = 1e-6
"""Distance from a boundary, over the largest modulus, at which verdicts may differ."""


def bead() -> st.Family:
    """A bead on a turning hoop, raised; its angle is found from one guess."""
    angle, rate, turn, drag = (ca.SX.sym(n) for n in ("angle", "rate", "turn", "drag"))
    force = ca.sin(angle) * (turn**2 * ca.cos(angle) - 1) - drag * rate
    system = st.System(
        "bead",
        ca.vertcat(angle, rate),
        ca.vertcat(turn, drag),
        ca.vertcat(rate, force),
        states=("angle", "rate"),
        parameters=("turn", "drag"),
    )
    return st.Family(
        system,
        "raised",
        at=("turn",),
        held={"rate": 0},
        unknown={"angle": 1.0},
        equations=("rate",),
        positive=("angle",),
        typical={"turn": 2.0, "drag": 0.1},
    )


def fold() -> st.Family:
    """The upper root of p + c x = x²; it ends at a fold, and the page follows it that far."""
    x, y, p, c = (ca.SX.sym(n) for n in ("x", "y", "p", "c"))
    system = st.System(
        "fold",
        ca.vertcat(x, y),
        ca.vertcat(p, c),
        ca.vertcat(y, p + c * x - x**2 - y),
        states=("x", "y"),
        parameters=("p", "c"),
    )
    near = {"x": 1.5, "p": 2.0, "c": 0.2}
    return system.steady("p", held={"y": 0.0}, guess=near, equations=("y",), name="upper")


def cusp() -> st.Family:
    """The upper sheet of p + c x = x³; beyond its edge lies another one, which is not reached."""
    x, y, p, c = (ca.SX.sym(n) for n in ("x", "y", "p", "c"))
    system = st.System(
        "cusp",
        ca.vertcat(x, y),
        ca.vertcat(p, c),
        ca.vertcat(y, p + c * x - x**3 - y),
        states=("x", "y"),
        parameters=("p", "c"),
    )
    near = {"x": 1.5, "p": 2.0, "c": 1.0}
    return system.steady("p", held={"y": 0.0}, guess=near, equations=("y",), name="upper")


FAMILIES: dict[str, tuple[Any, dict[str, float], dict[str, tuple[float, float]]]] = {
    "governor": (
        governor,
        {"e": 0.4, "a": 0.5, "b": 0.5},
        {"e": (0.05, 1.0), "a": (0.05, 1.5), "b": (0.1, 0.9)},
    ),
    "bead": (bead, {"turn": 2.0, "drag": 0.1}, {"turn": (1.05, 4.0), "drag": (-0.2, 0.4)}),
    "fold": (fold, {"p": 2.0, "c": 0.2}, {"p": (-1.0, 4.0), "c": (-1.0, 1.0)}),
    "cusp": (cusp, {"p": 1.0, "c": 1.0}, {"p": (-2.0, 2.0), "c": (-1.0, 2.0)}),
}
"""Family, values at first, ranges of random points."""


Written = tuple[str, st.Family, Path]


MORE = [pytest.param(name, marks=pytest.mark.long) for name in ("bead", "cusp")]


@pytest.fixture(scope="module", params=["governor", "fold", *MORE])
def written(request: Any, tmp_path_factory: pytest.TempPathFactory) -> Written:
    make, values, ranges = FAMILIES[request.param]
    family, given = make(), dict(values)
    at = given.pop(family.at[0])
    (x, y, *_) = ranges.items()
    path = st.explore(
        family,
        at=at,
        x=(x[0], *x[1]),
        y=(y[0], *y[1]),
        certify=False,
        **given,
        out=tmp_path_factory.mktemp("page") / "own.html",
    )
    return request.param, family, path


@pytest.fixture(scope="module")
def asked(written: Written) -> tuple[str, st.Family, Engine]:
    """Its scripts."""
    name, family, path = written
    return name, family, Engine(path)


@pytest.fixture(scope="module")
def seen(browser: Any, written: Written) -> Iterator[tuple[str, st.Family, Visit]]:
    """The page itself."""
    name, family, path = written
    with visit(browser, path) as found:
        yield name, family, found
        assert not found.said and not found.asked


def points(name: str, family: st.Family) -> np.ndarray:
    generator, ranges = np.random.default_rng(SEED), FAMILIES[name][2]
    order = (*family.at, *family.parameters)
    return np.stack([generator.uniform(*ranges[n], POINTS) for n in order], axis=1)


@pytest.mark.parametrize("count", [15, pytest.param(POINTS, marks=pytest.mark.long)])
def test_random_points_have_the_members_verdicts_and_eigenvalues_of_the_package(
    asked: tuple[str, st.Family, Engine], count: int
) -> None:
    name, family, view = asked
    sets = points(name, family)[:count]
    [answers] = view.page.evaluate(ASK, [{"key": f"{family.name}", "points": sets.tolist()}])
    members = view.page.evaluate(
        "(points) => { const [s] = stabilityExplorer.view.subjects.values();"
        "return points.map((q) => s.steady(q)); }",
        sets.tolist(),
    )
    words, absent = set(), 0
    for q, one, states in zip(sets, answers, members, strict=True):
        given = dict(zip(family.parameters, q[1:], strict=True))
        try:
            known = st.spectrum(family, at=q[0], **given)
        except NoMemberError:
            assert one["verdict"] == "absent", q
            absent += 1
            continue
        assert one["verdict"] != "absent", q
        true = family.member([q[0]], list(q[1:]))
        assert np.array(states) == pytest.approx(true, abs=1e-10)
        values = np.asarray(known.eigenvalues)
        found = np.array([complex(*z) for z in one["values"]])
        gaps, size = np.abs(found[:, None] - values[None, :]), np.abs(values).max()
        assert max(gaps.min(axis=0).max(), gaps.min(axis=1).max()) < SAME * size, q
        word = known.verdict.word
        assert one["verdict"] == word or np.abs(values.real).min() < NEAR * size, (q, one, known)
        words.add(word)
    sheet = name in ("fold", "cusp")
    assert (len(words) > 1) != sheet and (absent > count // 15) == sheet


def test_the_lines_of_a_picture_give_the_growth_rates_at_members(
    asked: tuple[str, st.Family, Engine],
) -> None:
    """Next to the scripts of a point; no member, no colour."""
    name, family, view = asked
    answers = view.evaluate(LOOKED, [family.name, points(name, family).tolist()])
    clear = 0
    for one in answers:
        growth, sign, member = one["found"]
        if one["verdict"] == "absent":
            assert not member > 0
            continue
        assert member > 0
        assert abs(growth - one["growth"]) < 1e-7 * one["size"]
        assert (sign > 1, sign < -1) == (one["verdict"] == "stable", one["verdict"] == "unstable")
        clear += abs(sign) > 1
    assert clear > 0.5 * len(answers)


def test_the_picture_draws_the_members_that_exist_with_their_verdicts(
    seen: tuple[str, st.Family, Visit],
) -> None:
    """Colours of the diagram on a grid: transparent without a member, warm where it grows."""
    name, family, view = seen
    found = view.page.evaluate(GRID)
    assert found["counted"] > 500 and found["wrong"] <= 0.01 * found["counted"], found


GRID = """() => {
  const {view, diagram} = stabilityExplorer, {subject} = view, c = diagram.canvas;
  const copy = document.createElement("canvas"), pen = copy.getContext("2d"), [n, m] = [90, 60];
  copy.width = n;
  copy.height = m;
  pen.drawImage(c, 0, 0, n, m);
  const d = pen.getImageData(0, 0, n, m).data, x = view.axis("x"), y = view.axis("y");
  let counted = 0, wrong = 0;
  for (let j = 1; j < m - 1; j++) for (let i = 1; i < n - 1; i++) {
    const words = [[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]].map(([a, b]) => {
      const v = {...view.state.values};
      v[x.name] = x.value((i + 0.5 + a) / n);
      v[y.name] = y.value(1 - (j + 0.5 + b) / m);
      return subject.judge(subject.array(v)).verdict;
    });
    const at = 4 * (j * n + i), [red, , blue, alpha] = d.slice(at, at + 4);
    if (words.some((w) => w !== words[0])) continue; // next to a border
    if (words[0] === "absent") { counted++; wrong += alpha > 100; continue; }
    if (Math.abs(red - blue) < 12 && alpha > 200) continue; // no clear colour
    counted++;
    wrong += alpha < 200 || (red > blue) !== (words[0] === "unstable");
  }
  return {counted, wrong};
}"""


WALK = """(points) => {
  const [s] = stabilityExplorer.view.subjects.values(), found = [];
  const step = (a, b, t) => a.map((v, i) => v + t * (b[i] - v));
  for (let n = 1; n < points.length; n++) {
    const way = Array.from({length: 30}, (_, i) => step(points[n - 1], points[n], (i + 1) / 30));
    const exact = way.map((q) => [...s.solved(q)]);
    s.hurry(true);
    found.push(...way.map((q, i) => [exact[i], [...s.solved(q)]]));
    s.hurry(false);
  }
  return [found, s.finder.hasty];
}"""
"""Members along lines between points, each by itself and each next to the one before."""
MOVED = """() => {
  const {diagram, view} = stabilityExplorer, said = [], [s] = view.subjects.values(), {hurry} = s;
  s.hurry = (on) => { said.push(on); hurry.call(s, on); };
  view.moving = true;
  diagram.renewal.content = "";
  diagram.draw();
  view.moving = false;
  diagram.draw();
  delete s.hurry;
  return [said, s.finder.hasty];
}"""
"""What a picture in motion, and then one at rest, say of the search."""


def test_members_next_to_each_other_are_those_of_the_package(
    asked: tuple[str, st.Family, Engine],
) -> None:
    name, family, view = asked
    found, hasty = view.evaluate(WALK, points(name, family)[:12].tolist())
    edge = name in ("fold", "cusp")
    exact, quick = (np.array(column) for column in zip(*found, strict=True))
    there = np.isfinite(exact).all(axis=1)
    assert there.sum() > 30 and not hasty
    assert quick[there] == pytest.approx(exact[there], abs=1e-6)
    assert there.all() != edge
    assert np.isnan(quick[~there]).all() or name == "cusp"  # there another branch is met


def test_members_are_sought_from_those_next_to_them_while_a_picture_moves(
    seen: tuple[str, st.Family, Visit],
) -> None:
    """But only if all are there."""
    name, _, view = seen
    said, hasty = view.page.evaluate(MOVED)
    assert said == [name not in ("fold", "cusp"), False, False, False] and not hasty


@pytest.mark.parametrize("written", ["fold"], indirect=True)
def test_beyond_the_fold_the_scripts_have_no_member(asked: tuple[str, st.Family, Engine]) -> None:
    _, _, view = asked
    there, beyond = view.evaluate(BEYOND)
    assert there["verdict"] != "absent" and there["outcome"] != "absent" and there["shown"] >= 2
    assert "motion" in there["code"] and beyond["verdict"] == beyond["outcome"] == "absent"
    assert "motion" not in beyond["code"] and beyond["polynomial"].startswith("none")


BEYOND = """() => [2, -0.5].map((p) => {
  const {view, motion, python, polynomial} = stabilityExplorer, {values} = view.state;
  view.set({values: {...values, p}});
  motion.run();
  const {launch} = motion, q = view.point(), {verdict} = view.subject.judge(q);
  const answer = {verdict, outcome: launch.outcome, shown: launch.times.length,
    code: python(), polynomial: polynomial(view.subject, q)};
  view.set({values});
  return answer;
})"""


@pytest.mark.parametrize("written", ["governor"], indirect=True)
def test_the_boundary_of_the_governor_is_that_of_its_theory(
    asked: tuple[str, st.Family, Engine],
) -> None:
    """L. S. Pontryagin: stable where e > 2 a b^(3/2)."""
    _, _, view = asked
    curves = view.page.evaluate(
        "stabilityExplorer.diagram.curves.filter((c) => c.kind === 'flutter').map((c) => c.points)"
    )
    e, a = np.array([p for points in curves for p in points]).T
    assert len(e) > 50
    assert e == pytest.approx(2 * a * 0.5**1.5, abs=1e-12)


def test_the_page_says_what_was_solved_for_and_proves_nothing_of_it(
    seen: tuple[str, st.Family, Visit],
) -> None:
    name, family, view = seen
    page = view.page
    page.wait_for_function("!stabilityExplorer.motion.waits")
    said = page.locator(".verdict").inner_text()
    for unknown in family.unknown:
        assert re.search(rf"; {unknown} = [\d.]+", said)
    proof = page.locator(".proof").inner_text()
    assert proof.startswith("Float") and "Proved in this page" not in proof
    assert page.locator(".trace").count() >= 2  # a launch starts at the member


def test_beyond_the_fold_the_page_has_no_member(browser: Any, tmp_path: Path) -> None:
    family = fold()
    path = st.explore(
        family, at=2.0, c=0.2, x=("p", -1.0, 4.0), certify=False, out=tmp_path / "fold.html"
    )
    for script in ("", WITHOUT_WEBGL):
        with visit(browser, path, "#show=upper&p=-0.5&c=0.2", script=script) as found:
            assert found.page.locator(".badge").inner_text().endswith("no member")
            assert "reaches no member" in found.page.locator(".point-panel .sentence").inner_text()
            assert not found.said


def test_a_start_without_a_member_is_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(st.StabilityError, match="no member"):
        st.explore(fold(), at=-2.0, c=0.2, out=tmp_path / "page.html")
    assert not (tmp_path / "page.html").exists()
