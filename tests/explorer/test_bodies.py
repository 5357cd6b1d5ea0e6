"""Bodies of revolution in the page: verdicts, eigenvalues, launches, surface and 3-D view."""

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from chromium import Visit, visit
from flint import arb, ctx
from node import Engine
from page_numbers import ASK, NEAR, POSE, SHARE_OF_BLUE, VERDICT

import stability as st
from stability.base.errors import NoMemberError, ParameterError
from stability.bodies.round_body.inclinations import tumbling_rates

BODIES = {
    "torus": (st.Torus(0.2), "tumbling", {"tube": (0.05, 0.45)}, {}),
    "spheroid": (st.Spheroid(0.7), "vertical", {"aspect": (0.4, 1.8)}, {}),
    "eccentric": (
        st.EccentricSphere(0.15, axial=0.4, transverse=0.4),
        "vertical",
        {"offset": (0.02, 0.35), "axial": (0.3, 0.45), "transverse": (0.3, 0.45)},
        {"pole": "pi"},
    ),
    "thick": (st.ThickDisk(0.1), "rolling", {"thickness": (0.05, 0.5)}, {}),
}
"""Body, family at first, ranges of its numbers, further arguments."""
POINTS, SEED, TIMES = 60, 11, np.linspace(0.0, 12.0, 25)
EIGENVALUES = 1e-9
"""Largest difference of eigenvalues over the largest modulus."""


@pytest.fixture(
    scope="module",
    params=[
        "torus",
        *(pytest.param(n, marks=pytest.mark.long) for n in ("spheroid", "eccentric", "thick")),
    ],
)
def written(request: Any, tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Path]:
    body, family, _, more = BODIES[request.param]
    path = tmp_path_factory.mktemp("page") / "body.html"
    st.explore(family, body=body, mu=0.3, certify=False, out=path, **more)
    assert Path(path).stat().st_size < 1_500_000
    return request.param, path


@pytest.fixture(scope="module")
def asked(written: tuple[str, Path]) -> tuple[str, Engine]:
    """Its scripts."""
    name, path = written
    return name, Engine(path)


@pytest.fixture(scope="module")
def seen(browser: Any, written: tuple[str, Path]) -> Iterator[tuple[str, Visit]]:
    """The page itself."""
    name, path = written
    with visit(browser, path) as found:
        yield name, found


def subjects(page: Any) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = page.evaluate(
        "[...stabilityExplorer.view.subjects.values()].map((s) => ({key: s.key, names: s.names,"
        "call: s.call, low: s.quantities[0].low, high: s.quantities[0].high, proved: s.proved}))"
    )
    return found


def points(name: str, subject: dict[str, Any], generator: Any) -> np.ndarray:
    ranges = {"mu": (0.05, 2.0), **BODIES[name][2]}
    columns = [generator.uniform(subject["low"], subject["high"], POINTS)]
    columns += [generator.uniform(*ranges[n], POINTS) for n in subject["names"][1:]]
    return np.stack(columns, axis=1)


def body_with(name: str, numbers: dict[str, Any]) -> st.Body:
    make = {
        "torus": st.Torus,
        "spheroid": st.Spheroid,
        "eccentric": st.EccentricSphere,
        "thick": st.ThickDisk,
    }[name]
    return make(**numbers)


def where(subject: dict[str, Any]) -> dict[str, Any]:
    return {} if subject["call"]["pole"] is None else {"pole": subject["call"]["pole"]}


def physics(name: str, subject: dict[str, Any], q: list[float]) -> tuple[st.Body, Any]:
    given = dict(zip(subject["names"][1:], q[1:], strict=True))
    law = {"smooth": st.Smooth, "rough": st.Rough}.get(subject["call"]["law"])
    contact = law() if law else st.Viscous(given.pop("mu"))
    return body_with(name, given), contact


@pytest.mark.parametrize(
    ("every", "count"), [(2, 3), pytest.param(1, POINTS, marks=pytest.mark.long)]
)
def test_random_points_have_the_verdicts_and_eigenvalues_of_the_package(
    asked: tuple[str, Engine], every: int, count: int
) -> None:
    name, view = asked
    generator, families = np.random.default_rng(SEED), set()
    words = set()
    for subject in subjects(view.page)[::every]:
        sets = points(name, subject, generator)[:count]
        [answers] = view.page.evaluate(ASK, [{"key": subject["key"], "points": sets.tolist()}])
        families.add(subject["call"]["family"])
        for q, one in zip(sets.tolist(), answers, strict=True):
            body, contact = physics(name, subject, q)
            try:
                known = st.spectrum(
                    subject["call"]["family"], at=q[0], body=body, contact=contact, **where(subject)
                )
            except NoMemberError:  # also where the samples of the structure are no members
                with np.errstate(all="ignore"):
                    rates = tumbling_rates(body, q[0])
                assert (one["verdict"] == "absent") != np.isfinite(rates).all(), (subject["key"], q)
                continue
            values = np.asarray(known.eigenvalues)
            found = np.array([complex(*z) for z in one["values"]])
            gaps = np.abs(found[:, None] - values[None, :])
            size = np.abs(values).max()
            assert max(gaps.min(axis=0).max(), gaps.min(axis=1).max()) < EIGENVALUES * size, (
                subject["key"],
                q,
            )
            same = one["verdict"] == known.verdict.word
            assert same or abs(values.real).min() < NEAR * size, (subject["key"], q, one, known)
            words.add(one["verdict"])
    assert {"stable", "unstable", "neutral"} <= words
    wanted = {"torus": "tumbling", "spheroid": "vertical", "eccentric": "vertical"}.get(name)
    assert wanted is None or {"tumbling", wanted} <= families


@pytest.mark.parametrize("written", ["torus"], indirect=True)
def test_bounds_of_the_signs_hold_in_balls(asked: tuple[str, Engine]) -> None:
    """The sign of each condition differs from that in balls by less than the page's bound.

    One body is enough: the bound is of the number type.
    """
    name, view = asked
    from stability.algebra.number_types import balls
    from stability.explorer.quantities import PageQuantity
    from stability.explorer.verdicts import closed_formulas

    generator, wide = np.random.default_rng(SEED), 0
    for law in ("viscous", "rough"):
        family = st.Torus(0.2).family("tumbling", law)
        names, key = (*family.at, *family.parameters), f"tumbling {law}"
        quantities = {n: PageQuantity(n, n, "", "", 0.0, 1.0, 0.5) for n in names}
        closed = closed_formulas(family, quantities)
        [subject] = [s for s in subjects(view.page) if s["key"] == key]
        for q in points(name, subject, generator).tolist():
            rows = view.page.evaluate(
                "([key, q]) => stabilityExplorer.view.subjects.get(key).conditionsAt(q)"
                ".map((r) => [r.value, r.error])",
                [key, q],
            )
            before, ctx.prec = ctx.prec, 300
            try:
                true = [v for v, _ in closed.signs(balls(), [arb(v) for v in q])]
            finally:
                ctx.prec = before
            for (value, error), exact in zip(rows, true, strict=True):
                assert abs(float(exact) - value) <= error
                assert error < 1e-6 * max(1.0, abs(value))
                wide += abs(float(exact) - value) > 0
    assert wide > 20  # the two do differ


NEAR_MEMBER = """([at, tilt, until]) => {
  const {view, motion} = stabilityExplorer;
  view.choose("spinning viscous");
  view.move({phi_dot: at});
  view.set({tilt, until});
  motion.run();
  return motion.near(motion.launch);
}"""
"""What the page says of the steady motion near which a launch has come."""


@pytest.mark.parametrize("written", ["torus"], indirect=True)
def test_a_launch_names_the_member_that_it_has_come_near(asked: tuple[str, Engine]) -> None:
    name, view = asked
    told = view.page.evaluate(NEAR_MEMBER, [2.0, 0.1, 200.0])
    body = body_with(name, {"tube": 0.2})
    start = st.launch("spinning", at=2.0, tilt=0.1, body=body)
    run = st.simulate(body, st.Viscous(0.3), start, 200.0)
    assert f"of spinning with φ̇ = {float(run.phi_dot[-1]):.4g} (float" in told


RUN = """(runs) => runs.map(({key, q, tilt, times}) => {
  const {view, launched} = stabilityExplorer, subject = view.subjects.get(key);
  const motion = view.data.motions[subject.model];
  const run = launched(subject, motion, q, [-tilt], times[times.length - 1], {times, seconds: 60});
  if (run.refused) return null;
  const frame = new Function(`return ${motion.frame}`)();
  return {outcome: run.outcome, time: run.until, energy: run.series.energy,
    frames: run.states.map((y) => Array.from(frame(y, run.p)))};
})"""


def placed(body: st.Body, run: Any) -> np.ndarray:
    """Axis, centre and contact point of a run with pose, from its angles."""
    theta, phi = run.theta.values, run.phi.values
    return np.stack(
        [
            np.sin(theta) * np.cos(phi),
            np.sin(theta) * np.sin(phi),
            np.cos(theta),
            run.centre_x.values,
            run.centre_y.values,
            np.asarray(body.height_at(theta)),
        ],
        axis=1,
    )


@pytest.mark.parametrize("every", [2, pytest.param(1, marks=pytest.mark.long)])
def test_launches_end_and_move_as_in_python(asked: tuple[str, Engine], every: int) -> None:
    name, view = asked
    generator, scenes = np.random.default_rng(SEED), []
    for subject in subjects(view.page)[::every]:
        q = points(name, subject, generator)[0].tolist()
        q[0] = min(q[0], 3.0)
        scenes.append((subject, q, float(generator.uniform(0.02, 0.2))))
    runs = [
        {"key": s["key"], "q": q, "tilt": tilt, "times": TIMES.tolist()} for s, q, tilt in scenes
    ]
    compared = 0
    for (subject, q, tilt), answer in zip(scenes, view.page.evaluate(RUN, runs), strict=True):
        body, contact = physics(name, subject, q)
        try:
            start = st.launch(
                subject["call"]["family"], at=q[0], tilt=tilt, body=body, **where(subject)
            )
        except ParameterError:  # no member, or the tilt leaves the range of the height
            assert answer is None, (subject["key"], q, tilt)
            continue
        run = st.simulate(body, contact, start, TIMES, tolerance=1e-13, check=False, pose=True)
        outcome = run.attrs["outcome"]
        where_ = subject["key"], q, tilt
        assert answer["outcome"] == ("moving" if outcome == "settled" else outcome) or (
            outcome == "domain-end" and "end of theta" in answer["outcome"]
        ), where_
        assert answer["time"] == pytest.approx(float(run.end_time), abs=1e-6), where_
        frames, known = np.array(answer["frames"]), placed(body, run)
        ours = frames[:, [0, 1, 2, 6, 7, 8]]
        sound = slice(None, -1) if outcome in ("flat", "domain-end") else slice(None)
        assert ours[sound] == pytest.approx(known[sound], abs=1e-6), where_
        contact_point = (
            np.stack([run.contact_x.values, run.contact_y.values], axis=1)
            if ("contact_x" in run)
            else frames[:, 9:11]
        )
        assert frames[sound, 9:11] == pytest.approx(contact_point[sound], abs=1e-6), where_
        assert answer["energy"][0] == pytest.approx(float(run.energy[0]), abs=1e-12)
        compared += 1
    assert compared >= 5 // every


def test_a_mode_starts_at_the_member_and_moves_the_contact_point_in_the_plane(
    asked: tuple[str, Engine],
) -> None:
    """The path of the centre in a mode agrees with the linear motion: rates by differences."""
    name, view = asked
    for subject in subjects(view.page):
        found = view.page.evaluate(POSE, subject["key"])
        assert found["exists"], subject["key"]
        now = np.array(found["now"])
        axis, mark = now[:3], now[3:6]
        assert np.dot(axis, axis) == pytest.approx(1) and np.dot(mark, mark) == pytest.approx(1)
        assert abs(np.dot(axis, mark)) < 1e-12 and now[11] == 0.0
        speed = (np.array(found["later"]) - np.array(found["before"])) / (2 * found["h"])
        turns = np.cross(mark, speed[3:6])  # ω less its part along the mark
        arm = now[9:12] - now[6:9]
        omega = turns + mark * _along(mark, axis, speed)
        slip = speed[6:9] + np.cross(omega, arm)
        if subject["call"]["law"] != "smooth":  # nothing slips at a member
            assert np.abs(slip).max() < 1e-6, (subject["key"], slip)


def _along(mark: np.ndarray, axis: np.ndarray, speed: np.ndarray) -> float:
    """The part of ω along the mark, from the rate of the axis across it."""
    side = np.cross(axis, mark)
    return float(-np.dot(speed[:3], side))


def test_the_surface_is_that_of_the_body(asked: tuple[str, Engine]) -> None:
    name, view = asked
    rows = np.array(view.page.evaluate("stabilityExplorer.motion.outline()[1].rows"))
    r, z = rows[:, 0], rows[:, 1]
    if name == "torus":  # the hull of a tube of radius 0.2 round a circle of radius 1
        inner = r > 1
        assert np.hypot(r[inner] - 1, z[inner]) == pytest.approx(0.2, abs=1e-9)
    elif name == "spheroid":
        assert r**2 + (z / 0.7) ** 2 == pytest.approx(1.0, abs=1e-9)
    elif name == "eccentric":
        assert r**2 + (z - 0.15) ** 2 == pytest.approx(1.0, abs=1e-9)
    else:
        known = {(0.0, -0.05), (1.0, -0.05), (1.0, 0.05), (0.0, 0.05)}
        assert {(round(a, 6), round(b, 6)) for a, b in zip(r, z, strict=True)} == known


def test_the_view_draws_every_family_without_an_error(seen: tuple[str, Visit]) -> None:
    name, view = seen
    page = view.page
    for subject in subjects(page):
        for picture in ("steady", "mode", "launch"):
            page.evaluate(
                "([key, show]) => { const {view} = stabilityExplorer; view.choose(key);"
                "view.set({show, mode: 0}); }",
                [subject["key"], picture],
            )
            page.wait_for_function("!stabilityExplorer.motion.waits")
            page.wait_for_timeout(60)
            blue = page.locator(".motion-stage canvas").evaluate(SHARE_OF_BLUE)
            assert 0.005 < blue < 0.6, (subject["key"], picture)
    assert not view.said and not view.asked


@pytest.mark.parametrize("count", [1, pytest.param(None, marks=pytest.mark.long)])
def test_the_python_call_gives_the_verdict_of_the_page(
    asked: tuple[str, Engine], count: int | None
) -> None:
    name, view = asked
    for subject in subjects(view)[::2][:count]:
        view.evaluate("(key) => stabilityExplorer.view.choose(key)", subject["key"])
        code = view.evaluate("stabilityExplorer.python()")
        space: dict[str, Any] = {}
        exec(code.replace(", 300)", ", 4)").replace(", 200)", ", 3)"), space)  # noqa: S102
        assert view.evaluate(VERDICT) == space["point"].verdict.word
        assert math.isfinite(float(space["motion"].end_time))


@pytest.mark.long
def test_a_body_of_many_terms_has_a_page_of_what_fits(tmp_path: Path) -> None:
    path = st.explore(
        "tumbling", body=st.Egg(0.2), contact="rough", certify=False, out=tmp_path / "egg.html"
    )
    assert path.stat().st_size < 1_500_000
    page = Engine(path)
    [shown] = subjects(page)
    assert shown["key"] == "tumbling rough"
    foot = page.evaluate("stabilityExplorer.view.data.foot")
    assert "Left out for size: Rolling, Vertical" in foot
    assert "Tumbling (smooth) and Tumbling (viscous); name the family and the contact" in foot
    sets = [[t, 0.37, 0.5] for t in (1.1, 1.3, 1.5)]
    assert shown["names"] == ["theta", "axial", "transverse"]
    [answers] = page.evaluate(ASK, [{"key": shown["key"], "points": sets}])
    for (at, axial, transverse), one in zip(sets, answers, strict=True):
        body = replace(st.Egg(0.2), axial=axial, transverse=transverse)
        known = st.spectrum("tumbling", at=at, contact="rough", body=body)
        assert one["verdict"] == known.verdict.word
