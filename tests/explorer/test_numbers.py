"""Numbers of the page's scripts against those of the package, and of independent references."""

import re
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
import reference
from node import Engine
from page_numbers import ASK, FAMILIES, LAWS, LOOKED, NEAR, OPEN, spectrum
from towed_wheel import GIVEN, towed_wheel

import stability as st
from stability.bodies.newton_euler import STATES

LAUNCHES, SEED = 48, 20


def drawn(generator: Any, family: str, law: str, count: int) -> np.ndarray:
    """Random points (at, mu where there is one, k), far beyond the sliders of the page."""
    at = generator.uniform(0.02, 1.57 if family == "tumbling" else 8.0, count)
    mu = np.exp(generator.uniform(np.log(0.01), np.log(30.0), count))
    k = generator.uniform(0.02, 0.5, count)
    return np.stack([at, mu, k] if LAWS[law] else [at, k], axis=1)


@pytest.mark.parametrize("total", [180, pytest.param(10_000, marks=pytest.mark.long)])
def test_random_points_have_the_verdicts_and_eigenvalues_of_the_package(
    disk: Engine, total: int
) -> None:
    generator, sets = np.random.default_rng(SEED), []
    count = -(-total // (len(FAMILIES) * len(LAWS)))
    for family in FAMILIES:
        for law in LAWS:
            sets.append((family, law, drawn(generator, family, law, count)))
    asked = [{"key": f"{f} {law}", "points": p.tolist()} for f, law, p in sets]
    answers = disk.page.evaluate(ASK, asked)
    compared, verdicts, worst = 0, set(), 0.0
    for (family, law, points), answer in zip(sets, answers, strict=True):
        known = spectrum(family, law, points)
        for place, verdict, values, one in zip(
            points.tolist(), known.verdict, known.eigenvalues, answer, strict=True
        ):
            same = one["verdict"] == verdict.word
            assert same or one["near"] < NEAR, (family, law, place, one, verdict)
            found = np.array([complex(*z) for z in one["values"]])
            gaps = np.abs(found[:, None] - values[None, :])
            size = np.abs(values).max()
            worst = max(worst, gaps.min(axis=1).max() / size, gaps.min(axis=0).max() / size)
            compared += same
            verdicts.add(verdict.word)
    assert compared >= total
    assert verdicts == {"stable", "unstable", "neutral"}
    assert worst < 1e-9


def test_eigenvalues_are_those_of_the_25_digit_spectra(disk: Engine) -> None:
    known = [r for r in reference.spectra() if r["family"] in FAMILIES]
    asked = [
        {"key": f"{r['family']} viscous", "points": [[r["at"], r["mu"], r["k"]]]} for r in known
    ]
    answers = disk.page.evaluate(ASK, asked)
    assert len(known) >= 9
    for record, [answer] in zip(known, answers, strict=True):
        true = np.array([complex(float(a), float(b)) for a, b in record["eigenvalues"]])
        found = np.array([complex(*z) for z in answer["values"]])
        gaps = np.abs(found[:, None] - true[None, :])
        assert gaps.min(axis=1).max() < 1e-13 * np.abs(true).max()
        assert (answer["verdict"] == "stable") == record["stable"]


RUN = """(runs) => runs.map(({key, q, start, tilt, times}) => {
  const {view, launched} = stabilityExplorer, subject = view.subjects.get(key);
  const motion = view.data.motions[subject.model];
  const padded = start && [...start, ...new Array(motion.names.length - start.length).fill(0)];
  const until = times[times.length - 1];
  const run = launched(subject, motion, q, [-tilt], until, {start: padded, times, seconds: 60});
  return {outcome: run.outcome, time: run.until, states: run.states.map((y) => Array.from(y)),
    energy: run.series.energy, normal: run.series["normal force"]};
})"""


def test_roots_are_those_of_random_polynomials(disk: Engine) -> None:
    generator, polynomials, roots = np.random.default_rng(SEED), [], []
    for _ in range(400):
        degree = int(generator.integers(1, 7))
        pairs = generator.normal(0, 3, degree // 2) + 1j * generator.normal(0, 3, degree // 2)
        true = np.concatenate([pairs, pairs.conj(), generator.normal(0, 3, degree % 2)])
        if len(pairs) and generator.random() < 0.3:  # two real roots in place of a pair
            true[0], true[len(pairs)] = generator.normal(0, 3, 2)
        polynomials.append(np.poly(true).real[::-1].tolist())
        roots.append(true)
    answers = disk.page.evaluate(
        "(all) => all.map((c) => stabilityExplorer.polynomialRoots(c))", polynomials
    )
    for true, answer in zip(roots, answers, strict=True):
        found = np.array([complex(*z) for z in answer])
        gaps = np.abs(found[:, None] - true[None, :])
        assert max(gaps.min(axis=0).max(), gaps.min(axis=1).max()) < 1e-9 * np.abs(true).max()
        assert sorted(found.tolist(), key=lambda z: (z.real, z.imag)) == found.tolist()


def test_motions_are_those_of_the_inertial_formulation(disk: Engine) -> None:
    known = reference.trajectories()
    asked = [
        {
            "key": "rolling viscous",
            "q": [1.0, m["mu"], m["k"]],
            "start": m["start"],
            "tilt": 0,
            "times": [0, *m["times"]],
        }
        for m in known
    ]
    answers = disk.page.evaluate(RUN, asked)
    for motion, answer in zip(known, answers, strict=True):
        found = np.array(answer["states"])[1:, :6]
        assert found == pytest.approx(np.array(motion["states"]), abs=1e-9)


def launches(count: int) -> list[tuple[str, str, list[float], float, float]]:
    """(family, law, point, tilt, time): random ones, and some that fall flat or lift off."""
    generator, found = np.random.default_rng(SEED), []
    pairs = [(f, law) for f in FAMILIES for law in LAWS]
    for family, law in pairs * (count // len(pairs)):
        point = drawn(generator, family, law, 1)[0]
        point[0] = min(point[0], 4.0)
        if LAWS[law]:
            point[1] = min(max(point[1], 0.05), 3.0)
        found.append((family, law, point.tolist(), float(generator.uniform(0.01, 0.3)), 15.0))
    return [
        *found,
        ("rolling", "smooth", [0.0, 0.25], 0.3, 15.0),
        ("rolling", "rough", [0.0, 0.25], 0.3, 15.0),
        ("spinning", "viscous", [5.0, 0.3, 0.25], 0.6, 15.0),
        ("spinning", "rough", [4.5, 0.3], 0.7, 15.0),
    ]


@pytest.mark.parametrize("count", [12, pytest.param(LAUNCHES, marks=pytest.mark.long)])
def test_launches_end_as_in_python(disk: Engine, count: int) -> None:
    scenes = launches(count)
    times = np.linspace(0.0, 15.0, 31)
    asked = [
        {"key": f"{f} {law}", "q": q, "start": None, "tilt": tilt, "times": times.tolist()}
        for f, law, q, tilt, _ in scenes
    ]
    answers = disk.page.evaluate(RUN, asked)
    outcomes = set()
    for (family, law, q, tilt, _), answer in zip(scenes, answers, strict=True):
        body = st.Disk(k=q[-1])
        friction: dict[str, Any] = {"mu": q[1]} if LAWS[law] else {}
        start = st.launch(family, at=q[0], tilt=tilt, disk=body)
        run = st.simulate(body, law, start, times, tolerance=1e-13, check=False, **friction)
        outcome = run.attrs["outcome"]
        assert answer["outcome"] == ("moving" if outcome == "settled" else outcome), (
            family,
            law,
            q,
        )
        assert answer["time"] == pytest.approx(float(run.end_time), abs=1e-6)
        count = 4 if law == "rough" else 6
        ours = np.array(answer["states"])[:, :count]
        theirs = np.stack([run[n].values for n in STATES[:count]], axis=1)
        # where a disk falls flat its rates grow without bound: there the time is compared
        sound = slice(None, -1) if answer["outcome"] == "flat" else slice(None)
        assert ours[sound] == pytest.approx(theirs[sound], abs=1e-6), (family, law, q)
        assert answer["energy"][0] == pytest.approx(float(run.energy[0]), abs=1e-12)
        assert answer["normal"][0] == pytest.approx(float(run.normal_force[0]), abs=1e-12)
        outcomes.add(answer["outcome"])
    assert outcomes == {"moving", "flat", "lift-off"}


def test_modes_are_eigenvectors_of_the_linearised_equations(disk: Engine) -> None:
    for key, q in (("spinning viscous", [2.2, 0.3, 0.25]), ("tumbling rough", [0.7, 0.4])):
        found = disk.page.evaluate(
            "([key, q]) => { const s = stabilityExplorer.view.subjects.get(key);"
            "return s.eigenvalues(q).map((z) => [z, s.mode(q, z)]); }",
            [key, q],
        )
        family, law = key.split()
        system = st.disk_system(law)
        slopes = ca.Function("f", [system.x, system.p], [ca.jacobian(system.rhs, system.x)])
        member = st.disk_family(family, law).member(q[:1], q[:0:-1])
        matrix = np.array(slopes(member, q[:0:-1]))
        for value, vector in found:
            ours = np.array([complex(*v) for v in vector])
            left = matrix @ ours - complex(*value) * ours
            assert np.abs(left).max() < 1e-11 * np.abs(matrix).max()
            assert np.abs(ours).max() == pytest.approx(1.0)


WIDE = {"at": 8.0, "mu": (1e-3, 1e3)}
"""Largest member and coefficients of friction that are typed, far beyond the sliders."""


@pytest.mark.parametrize("total", [1200, pytest.param(20_400, marks=pytest.mark.long)])
def test_a_picture_has_the_sign_and_the_decade_of_every_rate(disk: Engine, total: int) -> None:
    """Over the whole range of every slider, and beyond: k to its end at 1/2, mu to 1000."""
    generator, words, open_ = np.random.default_rng(SEED), set(), 0
    count = -(-total // (len(FAMILIES) * len(LAWS)))
    for family in FAMILIES:
        for law in LAWS:
            at = generator.uniform(0.02, 1.57 if family == "tumbling" else WIDE["at"], count)
            mu = np.exp(generator.uniform(*np.log(WIDE["mu"]), count))
            k = generator.uniform(0.05, 0.5, count)
            k[::5] = 0.5
            points = np.stack([at, mu, k] if LAWS[law] else [at, k], axis=1)
            known, key = spectrum(family, law, points), f"{family} {law}"
            answers = disk.evaluate(LOOKED, [key, points.tolist()])
            for point, verdict, values, one in zip(
                points, known.verdict, known.eigenvalues, answers, strict=True
            ):
                growth, sign, member = one["found"]
                rate, size = values.real.max(), np.abs(values).max()
                assert member > 0
                word = "unstable" if sign < -1 else "good" if sign > 1 else "open"
                good = verdict.word in ("stable", "neutral")
                assert word in ("good" if good else verdict.word, "open"), (key, point)
                open_ += word == "open"
                # a decade of the colours is a decade of the rate; next to zero they are linear
                assert abs(growth - rate) < 1e-6 * abs(rate) + 1e-7 * size, (key, point)
                words.add((family, verdict.word))
    assert open_ <= total // 1000
    assert {word for _, word in words} == {"stable", "unstable", "neutral"}


def test_boundary_curves_lie_on_the_boundaries_of_the_package(disk: Engine) -> None:
    curves = disk.page.evaluate(
        "() => { const { view, diagram } = stabilityExplorer; view.choose('spinning viscous');"
        "view.move({k: 0.25}); return diagram.curves; }"
    )
    kinds = {c["kind"] for c in curves}
    assert kinds == {"static", "flutter"}
    for mu in (0.2, 0.75, 0.9):
        known = st.boundaries("spinning", axis=("at", 0.05, 4.9, 9), contact=st.Viscous(mu))
        crossed = []
        for curve in curves:
            x, y = np.array(curve["points"]).T
            for i in np.flatnonzero((y[1:] - mu) * (y[:-1] - mu) <= 0):
                share = (mu - y[i]) / (y[i + 1] - y[i]) if y[i + 1] != y[i] else 0.0
                crossed.append(x[i] + share * (x[i + 1] - x[i]))
        # straight between points of the curve: as exact as the grid is fine
        assert sorted(crossed) == pytest.approx([p.value for p in known], abs=2e-3)
    ends = [p for c in curves if c["kind"] == "static" for p in c["points"]]
    assert ends and all(abs(p[0] - 2.0) < 1e-14 for p in ends)


def test_proved_rectangles_hold(disk: Engine) -> None:
    generator = np.random.default_rng(SEED)
    for key, low, high in (
        ("spinning viscous", [0.02, 0.02], [5.0, 3.0]),
        ("tumbling viscous", [0.02, 0.02], [1.57, 3.0]),
    ):
        family, law = key.split()
        points = generator.uniform(low, high, (300, 2))
        found = disk.page.evaluate(
            "([key, points]) => { const { view } = stabilityExplorer; view.choose(key);"
            "return points.map(([at, mu]) => { view.move({at, mu, k: 0.25});"
            "return view.certificate().verdict; }); }",
            [key, points.tolist()],
        )
        known = st.spectrum(family, at=points[:, 0], contact=law, mu=points[:, 1]).verdict
        wrong = [
            (p, a)
            for p, a, b in zip(points, found, known, strict=True)
            if a not in ("undecided", b.word)
        ]
        assert not wrong
        assert sum(a != "undecided" for a in found) > 250


def test_a_family_of_ones_own_has_the_numbers_of_the_package(tmp_path: Path) -> None:
    family = towed_wheel()
    path = st.explore(
        family, at=0.3, x=("v", 0.1, 20), y=("trail", 0.02, 0.3), out=tmp_path / "own.html", **GIVEN
    )
    generator = np.random.default_rng(SEED)
    names = (*family.at, *family.parameters)
    points = np.array(
        [
            generator.uniform(0.1, 20, 200),
            *[generator.uniform(0.5, 1.5, 200) * GIVEN[n] for n in names[1:]],
        ]
    ).T
    [answer] = Engine(path).evaluate(ASK, [{"key": family.name, "points": points.tolist()}])
    known = st.spectrum(family, at=points[:, 0], **dict(zip(names[1:], points.T[1:], strict=True)))
    for values, verdict, one in zip(known.eigenvalues, known.verdict, answer, strict=True):
        assert one["verdict"] == verdict.word or one["near"] < NEAR
        found = np.array([complex(*z) for z in one["values"]])
        gaps = np.abs(found[:, None] - values[None, :])
        assert gaps.min(axis=1).max() < 1e-9 * np.abs(values).max()
    assert {v.word for v in known.verdict} == {"stable", "unstable"}


def test_paths_of_eigenvalues_have_no_jumps(page_of_disk: Path) -> None:
    """A pair that turns real leaves the imaginary axis at a right angle, not along a chord."""
    page = Engine(page_of_disk)
    page.evaluate(OPEN, "#show=rolling-smooth&at=0.5&k=0.25")
    paths = page.evaluate("stabilityExplorer.plane.paths(2, 2, 1)")
    # λ² is real: every point lies on one of the axes, and steps are short
    apart = [
        abs(complex(*a) - complex(*b))
        for path in paths
        for a, b in zip(path, path[1:], strict=False)
        if max(map(abs, (*a, *b))) < 2
    ]
    assert len(apart) > 100 and max(apart) < 0.2


def test_the_text_of_the_polynomial_and_of_the_conditions_has_the_numbers(disk: Engine) -> None:
    """The printed coefficients are those of the eigenvalues of the package, to four digits."""
    generator = np.random.default_rng(SEED)
    for family in FAMILIES:
        for law in LAWS:
            [q] = drawn(generator, family, law, 1)
            text, filled = disk.evaluate(TEXTS, [f"{family} {law}", q.tolist()])
            found = printed_polynomial(text)
            known = np.poly(np.asarray(spectrum(family, law, q[None]).eigenvalues)[0]).real
            assert len(found) == len(known)
            assert found == pytest.approx(known, rel=5.1e-4, abs=1e-9 * np.abs(known).max())
            assert not any(re.search(r"[{}]|undefined|NaN", one) for one in filled), filled


TEXTS = """([key, q]) => {
  const {view, polynomial, conditions} = stabilityExplorer, subject = view.subjects.get(key);
  const values = Object.fromEntries(subject.names.map((n, i) => [n, q[i]]));
  const shown = {subject, state: {values}, point: () => q}, filled = conditions.filled;
  const rows = subject.conditionsAt(q).filter((row) => row.filled);
  return [polynomial(subject, q), rows.map((row) => filled.call({view: shown}, row))];
}"""
"""The characteristic polynomial and the conditions as text, with the numbers of a point."""


def printed_polynomial(text: str) -> np.ndarray:
    """The coefficients of the product of printed factors, the highest power first."""
    plain = text.replace("<i>λ</i>", "x").replace("−", "-")
    plain = re.sub(r"<sup>(\d+)</sup>", r"^\1", plain)
    plain = re.sub(r"·10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)", lambda m: "e" + m[1].translate(RAISED), plain)
    product = np.poly1d([1.0])
    for factor in re.findall(r"\(([^)]*)\)", plain) or [plain]:
        terms = re.findall(r"([+-]?) ?([\d.]+(?:e-?\d+)?)? ?(x(?:\^(\d+))?)?", factor)
        one: dict[int, float] = {}
        for sign, size, letter, power in terms:
            if size or letter:
                degree = int(power or 1) if letter else 0
                one[degree] = float(f"{sign}{size or 1}")
        product *= np.poly1d([one.get(n, 0.0) for n in range(max(one), -1, -1)])
    return np.asarray(product.coeffs)


RAISED = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
