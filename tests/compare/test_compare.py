"""Charts and catalogue: their truths hold, their judgements are just, and they can fail."""

import csv
import io
import math
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from reference import spectra

import stability as st
from stability.base.verdict import CODES, Verdict
from stability.compare import calls
from stability.compare import failures as catalogue
from stability.compare.cost import places
from stability.compare.failures import Entry, attempt
from stability.compare.marks import HONEST, Judgement, Mark, by_error
from stability.compare.motion.cases import MOTION_CASES, MotionCase
from stability.compare.motion.chart import judged
from stability.compare.motion.drivers import DRIVERS, Driver, MotionAnswer, driver, simulated
from stability.compare.motion.reference_motions import ReferenceMotion, scene, scenes
from stability.compare.spectrum import chart as spectrum_chart
from stability.compare.spectrum import routes as routes
from stability.compare.spectrum.cases import CASES, LADDERS, Case, NonSteady
from stability.compare.spectrum.points import (
    EDGES,
    MEETINGS,
    Points,
    classes,
    coalescence,
    points_of,
)
from stability.compare.spectrum.routes import (
    OWN,
    AutomaticJacobian,
    AutomaticRaw,
    Certified,
    Deflated,
    ExactVerdict,
    ManyDigits,
    Route,
)
from stability.compare.spectrum.sympy_disk import kept_mass
from stability.jobs.measured_cells import DONE, Cell

# --- truths of spectra ---


@pytest.fixture(autouse=True)
def _digits() -> Any:
    with mpmath.workdps(40):
        yield


WHOLE = [False, pytest.param(True, marks=pytest.mark.long)]


def points(family: str, k: float, mu: float, at: Any) -> Points:
    at = np.atleast_1d(np.asarray(at, dtype=float))
    return Points(family, "viscous", np.full(len(at), k), np.full(len(at), mu), at)


@pytest.mark.parametrize("number", range(16))
def test_the_truth_is_that_of_the_reference_spectra(number: int) -> None:
    record = spectra()[number]
    it = points(record["family"], record["k"], record["mu"], record["at"])
    mine = [
        mpmath.mpc(complex(v)) + mpmath.mpc(complex(w))
        for v, w in zip(it.truth.eigenvalues[0], it.truth.rest[0], strict=True)
    ]
    exact = [mpmath.mpc(re, im) for re, im in record["eigenvalues"]]
    exact = sorted(exact, key=abs)[len(exact) - len(mine) :]
    size = max(abs(v) for v in exact)
    for value in exact:
        assert min(abs(value - other) for other in mine) < 1e-23 * size
    stable = it.truth.codes[0] == CODES[Verdict.STABLE]
    assert bool(stable) == record["stable"]


SOME = ("open", "very-near", "large-mu", "small-mu", "flat-hoop", "conservative")
"""Classes that are soon made."""


class Digits(ManyDigits):
    """QR in 200 digits: nothing in common with roots of a polynomial in balls."""

    name, title, digits = "digits", "200 digits", 200


@pytest.mark.few(3)
@pytest.mark.parametrize(
    "hardness",
    [
        "open",
        "near",
        "very-near",
        "large-mu",
        "flat-hoop",
        pytest.param("meeting", marks=pytest.mark.long),
    ],
)
@pytest.mark.parametrize("step", [5, pytest.param(2, marks=pytest.mark.long)])
def test_the_truth_is_that_of_mpmath(hardness: str, step: int) -> None:
    for group in points_of(hardness)[::step]:
        few = group[:: max(1, len(group) // 2)]
        values = _exact(few)
        for row, truth, rest in zip(values, few.truth.eigenvalues, few.truth.rest, strict=True):
            size = max(abs(v) for v in row)
            for v, w in zip(truth, rest, strict=True):
                whole = mpmath.mpc(complex(v)) + mpmath.mpc(complex(w))
                assert min(abs(whole - other) for other in row) < 1e-26 * size
        tops = [float(max(v.real for v in row)) for row in values]
        assert tops == pytest.approx(few.truth.abscissa.tolist(), rel=1e-15)
        signs = [Verdict.UNSTABLE if top > 0 else Verdict.STABLE for top in tops]
        assert few.truth.codes.tolist() == [CODES[v] for v in signs]


def _exact(few: Points) -> list[list[Any]]:
    route = Digits()
    with mpmath.workdps(200):
        return [
            route._spectrum(few, x, p)
            for x, p in zip(route._states(few), few.parameters, strict=True)
        ]


@pytest.mark.parametrize("whole", WHOLE)
def test_boundaries_are_those_of_published_formulas(whole: bool) -> None:
    for where in EDGES if whole else [EDGES[0], EDGES[2], EDGES[7], *EDGES[9:]]:
        family, law, k = where[:3]
        square = {
            ("rolling", "viscous"): 1 / (2 * k),
            ("rolling", "linear-viscous"): 1 / (2 * k),
            ("rolling", "rough"): 1 / (2 * (2 * k + 1)),
            ("rolling", "smooth"): 1 / (4 * k),
            ("spinning", "rough"): 1 / (1 + k),
            ("spinning", "smooth"): 1 / k,
        }.get((family, law))
        value, rest = spectrum_chart.exact_edge(*where)
        if square is not None:
            with mpmath.workdps(40):
                exact = mpmath.sqrt(mpmath.mpf(1) / (1 / mpmath.mpf(square)))
            assert value**2 == pytest.approx(square, rel=1e-15)
            assert abs(float(exact - value) - rest) < 2e-16 * value
        low, high = (
            Points(
                family,
                law,
                np.array([k]),
                None if where[3] is None else np.array([where[3]]),
                np.array([value * (1 + s)]),
            )
            for s in (-1e-9, 1e-9)
        )
        assert low.truth.codes[0] != high.truth.codes[0]


@pytest.mark.parametrize("whole", WHOLE)
def test_eigenvalues_meet_where_they_are_said_to(whole: bool) -> None:
    for family, k, mu, low, high in MEETINGS if whole else MEETINGS[1:3]:
        at = coalescence(family, k, mu, low, high)
        values = points(family, k, mu, at).truth.eigenvalues[0]
        gap = min(abs(a - b) for i, a in enumerate(values) for b in values[:i])
        assert 0 < gap < 1e-6 * np.abs(values).max()


def test_sympy_and_casadi_agree_on_jacobians_at_any_state() -> None:
    rng = np.random.default_rng(3)
    for law in ("viscous", "linear-viscous", "smooth", "rough"):
        system = st.disk_system(law)
        x = rng.uniform(-1, 1, (20, len(system.states))) * 0.5
        x[:, 0] += 1.2
        p = np.column_stack([rng.uniform(0.1, 0.5, 20), rng.uniform(0.1, 0.5, 20)])
        p = p[:, : len(system.parameters)]
        assert np.allclose(kept_mass(law)(x, p), system.linearise(x, p), rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("whole", WHOLE)
def test_every_class_has_points_of_more_than_one_verdict(whole: bool) -> None:
    assert len(classes()) == 8
    for name in classes() if whole else SOME:
        groups = points_of(name) if whole else [g[::3] for g in points_of(name)[::3]]
        seen = {int(c) for g in groups for c in g.truth.codes}
        assert len(seen) > 1
        assert CODES[Verdict.UNDECIDED] not in seen


# --- routes ---


@pytest.mark.few(4)
@pytest.mark.parametrize("name", list(routes.ROUTES))
def test_every_route_is_right_in_the_open_field(name: str) -> None:
    if name == "sympy-solved":  # 0/0 upright, which is what it is there to show
        return
    for group in points_of("open"):
        few = group[:3]
        answer = routes.route(name).answer(few)
        if name != "ad-raw":
            assert answer.codes.tolist() == few.truth.codes.tolist()
        _, abscissa = spectrum_chart.errors(few, answer)
        if abscissa is not None and name != "ad-raw":
            rough = {"forward": 1e-5, "forward-1e-4": 1e-1, "forward-1e-12": 1e-1, "central": 1e-7}
            assert abscissa.max() < rough.get(name, 1e-8)


@pytest.mark.parametrize("whole", WHOLE)
def test_routes_state_no_less_than_their_error(whole: bool) -> None:
    for name in classes() if whole else SOME:
        for group in points_of(name) if whole else [g[::3] for g in points_of(name)[::3]]:
            for route in (Deflated(), *([Certified()] if name == "very-near" else [])):
                few = group[:4] if route.name == "certified" else group
                answer = route.answer(few)
                assert answer.bound is not None and answer.abscissa is not None
                truth = few.truth
                off = np.abs(answer.abscissa - truth.abscissa - truth.abscissa_rest)
                # the truth is known to a part in 1e30, the difference to an ulp of the abscissa
                assert (off <= answer.bound + 1e-25 * np.abs(truth.abscissa)).all()


def test_an_error_is_counted_after_the_best_matching() -> None:
    it = points("rolling", 0.25, 0.3, 1.8)
    exact = it.truth.eigenvalues
    none = np.zeros(1, np.int8)
    turned = routes.SpectrumAnswer(none, exact[:, ::-1], exact.real.max(axis=1))
    off, _ = spectrum_chart.errors(it, turned)
    assert off is not None and off[0] < 1e-15
    moved = routes.SpectrumAnswer(none, exact + 1e-3, exact.real.max(axis=1) + 1e-3)
    off, abscissa = spectrum_chart.errors(it, moved)
    assert off is not None and abscissa is not None
    assert off[0] == pytest.approx(1e-3 / np.abs(exact).max(), rel=1e-9)
    assert abscissa[0] == pytest.approx(1e-3 / abs(exact.real.max()), rel=1e-9)


def test_cells_of_a_chart_hold_every_timing() -> None:
    cell = spectrum_chart.measure("conservative", "ad")
    assert cell["count"] == 40 == len(cell["eigenvalues"])
    assert cell["wrong"] > 0
    assert min(len(cell["one"]), len(cell["many"])) >= 3
    cell = spectrum_chart.measure("conservative", "certified")
    assert (cell["wrong"], cell["undecided"], cell["many"]) == (0, 0, [])


@pytest.mark.parametrize("whole", WHOLE)
def test_boundaries_by_lapack_are_off_and_those_of_the_package_are_not(
    whole: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not whole:  # the nearly flat hoop is the seventh
        monkeypatch.setattr(spectrum_chart, "EDGES", (*EDGES[:7:2], EDGES[11]))
    people, own = spectrum_chart.locate("ad-1e-9"), spectrum_chart.locate("spectrum")
    assert max(e for e in own["error"] if e is not None) < 3e-16
    assert all(w is not None and w < 1e-15 for w in own["width"])
    assert None in people["error"]  # the nearly flat hoop: 1e-9 hides the growth
    assert max(e for e in people["error"] if e is not None) > 1e-8


# --- fronts ---


def test_the_front_is_what_nothing_beats() -> None:
    rng = np.random.default_rng(1)
    panel = {str(i): (float(t), float(e)) for i, (t, e) in enumerate(rng.uniform(1, 2, (60, 2)))}
    found = places(panel)
    for name, place in found.items():
        beaten = [n for n, (t, e) in panel.items() if t < place.time and e <= place.error]
        assert place.on_front == (not beaten)
        assert place.factor == pytest.approx(place.time / panel[place.rival][0])
        assert panel[name] == (place.time, place.error)


# --- marks ---


def test_a_stated_error_makes_a_poor_answer_honest() -> None:
    assert by_error(0.5, 1e-6).mark is Mark.WRONG
    assert by_error(0.5, 1e-6, 0.9).mark is Mark.UNDECIDED
    assert by_error(1e-4, 1e-6, 1e-4).mark is Mark.DEGRADED
    assert by_error(1e-4, 1e-6, 1e-9).mark is Mark.WRONG  # it states more than it has
    assert by_error(1e-4, 1e-6).digits == 4
    assert by_error(math.nan, 1e-6).mark is Mark.CRASHED
    assert by_error(1e-3, 1e-6, math.nan).mark is Mark.CRASHED
    assert by_error(2e-7, 1e-6, 1e-9).mark is Mark.WRONG  # good enough, but not what it states
    assert by_error(-1e-9, 1e-6).mark is Mark.RIGHT


# --- the check can fail ---


class WrongSign(AutomaticJacobian):
    """A Jacobian with its sign turned."""

    name, title = "wrong-sign", "broken"

    def matrices(self, points: Points) -> Any:
        return -super().matrices(points)


class Loose(AutomaticJacobian):
    """Anything below 1e-3 counts as zero."""

    name, title, small = "loose", "broken", 1e-3


class Lying(Certified):
    """A proved verdict, turned."""

    name, title = "lying", "broken"

    def answer(self, points: Points) -> routes.SpectrumAnswer:
        found = super().answer(points)
        turned = np.where(found.codes == 1, 2, 1).astype(np.int8)
        return routes.SpectrumAnswer(turned, found.eigenvalues, found.abscissa, found.bound)


def marks(route: Route, names: Any = None) -> dict[str, Mark]:
    found = {}
    for name in names or CASES:
        judgement = attempt(lambda n=name: CASES[n]().judge(route))  # type: ignore[misc]
        if judgement is not None:
            found[name] = judgement.mark
    return found


TWO_ZEROS = "two structural zeros"
OPEN = ["rolling, viscous, k = 0.25, mu = 0.3", "spinning, viscous, k = 0.25, mu = 0.3"]


@pytest.mark.parametrize("broken", [WrongSign, Loose, AutomaticRaw, Lying])
def test_a_broken_route_is_caught_as_wrong(broken: type[Route]) -> None:
    names = [*OPEN, TWO_ZEROS, "hoop at 1° from flat: verdict"]
    assert Mark.WRONG in marks(broken(), names).values()


def test_each_break_is_caught_where_it_should_be() -> None:
    assert marks(WrongSign(), OPEN) == dict.fromkeys(OPEN, Mark.WRONG)
    assert marks(AutomaticJacobian(), [TWO_ZEROS]) == {TWO_ZEROS: Mark.RIGHT}
    assert marks(AutomaticRaw(), [TWO_ZEROS]) == {TWO_ZEROS: Mark.WRONG}
    far = LADDERS[0]().steps(Loose())
    assert far[0] == "right" and "wrong" in far[:5]
    # the same ladder, for a route that holds
    assert LADDERS[0]().steps(Certified()) == ["right"] * 15


def test_a_spectrum_of_no_steady_motion_is_wrong_and_a_refusal_is_not() -> None:
    assert attempt(lambda: NonSteady().judge(AutomaticJacobian())).mark is Mark.WRONG  # type: ignore[union-attr]
    assert attempt(lambda: NonSteady().judge(Deflated())).mark is Mark.REFUSED  # type: ignore[union-attr]
    assert attempt(lambda: NonSteady().judge(ExactVerdict())) is None


def test_one_over_cosine_crashes_or_is_wrong_where_the_disk_is_upright() -> None:
    found = marks(routes.route("sympy-solved"), ["1/cosθ left by computer algebra"])
    assert set(found.values()) <= {Mark.CRASHED, Mark.WRONG}
    assert marks(routes.route("sympy"), ["1/cosθ left by computer algebra"]) == {
        "1/cosθ left by computer algebra": Mark.RIGHT
    }


def of_each_group(seed: int) -> list[str]:
    """Two cases of each group, by a seeded draw."""
    groups: dict[str, list[str]] = {}
    for name, case in CASES.items():
        groups.setdefault(case().group, []).append(name)
    draw = np.random.default_rng(seed)
    return [str(n) for names in groups.values() for n in draw.choice(names, 2, replace=False)]


@pytest.mark.parametrize("route", [r for r in OWN if r.default])
@pytest.mark.parametrize("whole", WHOLE)
def test_no_default_route_misleads(route: type[Route], whole: bool) -> None:
    for name, mark in marks(route(), None if whole else of_each_group(1)).items():
        assert mark in HONEST, name


@pytest.mark.parametrize("whole", WHOLE)
def test_proved_routes_are_right_in_every_case(whole: bool) -> None:
    names = [n for n in (CASES if whole else of_each_group(2)) if n != NonSteady.name]
    for name, mark in marks(Certified(), names).items():
        assert mark is Mark.RIGHT, name


class Shaped(AutomaticJacobian):
    """An answer of any shape."""

    name, title = "shaped", "broken"
    change: Any = None

    def answer(self, points: Points) -> routes.SpectrumAnswer:
        return self.change(super().answer(points))  # type: ignore[no-any-return]


@pytest.mark.few(2)
@pytest.mark.parametrize(
    "change",
    [
        lambda a: routes.SpectrumAnswer(a.codes[:0], a.eigenvalues, a.abscissa),
        lambda a: routes.SpectrumAnswer(a.codes[:1], a.eigenvalues, a.abscissa),
        lambda a: routes.SpectrumAnswer(a.codes.astype(bool), a.eigenvalues, a.abscissa),
        lambda a: routes.SpectrumAnswer(a.codes + 40, a.eigenvalues, a.abscissa),
        lambda a: routes.SpectrumAnswer(a.codes, a.eigenvalues[:, :1], a.abscissa),
        lambda a: routes.SpectrumAnswer(a.codes, a.eigenvalues * np.nan, a.abscissa),
        lambda a: routes.SpectrumAnswer(a.codes, a.eigenvalues, a.abscissa[:1]),
    ],
)
def test_an_answer_of_a_wrong_shape_is_no_answer(change: Any) -> None:
    route = Shaped()
    route.change = change
    assert set(marks(route, [OPEN[0], TWO_ZEROS, "coalescing eigenvalues"]).values()) == {
        Mark.CRASHED
    }


def test_the_truth_holds_where_growth_is_tiny() -> None:
    # near flat the hoop's growth goes as theta⁴: 1.667e-21 at 1e-5, 1.667e-141 at 1e-35
    small = [points("tumbling", 0.5, 3.0, theta).truth.abscissa[0] for theta in (1e-5, 1e-35)]
    assert small[1] / small[0] == pytest.approx(1e-120, rel=1e-3)


# --- motion ---


@pytest.mark.parametrize("step", [12, pytest.param(5, marks=pytest.mark.long)])
def test_truths_of_motions_keep_what_is_conserved(step: int) -> None:
    # energy of the rough disk, and its two Legendre integrals, from the states alone
    for name in ("rough-long", "near-flat", "double-upright-rough"):
        it = scene(name)
        seen = st.disk_system("rough").observe(it.states[:, :4], [it.k])["energy"]
        assert np.allclose(seen, seen[0], rtol=0, atol=3e-14)
        nu = (-1 + mpmath.sqrt(1 - mpmath.mpf(8) / (2 * it.k + 1) + 0j)) / 2

        def wave(z: Any, sign: int, nu: Any = nu) -> Any:
            return mpmath.legenp(nu, 0, sign * z, type=2)

        constants = []
        for theta, _, phi_dot, omega3, *_ in it.states[::step].tolist():
            z = mpmath.cos(theta)
            rows = [
                [wave(z, s) for s in (1, -1)],
                [mpmath.diff(lambda v, s=s: wave(v, s), z) for s in (1, -1)],  # type: ignore[misc]
            ]
            # ω₃ = C1 P_ν(cosθ) + C2 P_ν(−cosθ), dω₃/d cosθ = −φ̇/(2k + 1)
            right = mpmath.matrix([omega3, -phi_dot / (2 * it.k + 1)])
            constants.append([complex(v) for v in mpmath.lu_solve(mpmath.matrix(rows), right)])
        assert len(constants) > 1
        assert np.allclose(constants, constants[0], rtol=1e-11, atol=1e-11)


@pytest.mark.few(2)
@pytest.mark.parametrize(
    "name",
    ["gentle", "lift-off"]
    + [
        pytest.param(n, marks=pytest.mark.long)
        for n in ("slow-drift", "near-flat-viscous", "spin-down")
    ],
)
def test_truths_are_met_by_an_integrator_that_made_none_of_them(name: str) -> None:
    it = scene(name)
    row = judged(
        it, simulated(it, it.contact(), it.asked, method="dop853", tolerance=1e-13, check=False)
    )
    assert row["outcome"] == it.outcome
    assert row["path"] is not None and row["path"] < 2e-8
    if it.ends:
        assert row["event"] is not None and row["event"] < 1e-7


def test_every_scene_is_known_well_and_none_is_undetermined() -> None:
    for it in scenes().values():
        assert it.error < 1e-10
        assert it.outcome in ("moving", "lift-off", "flat")
        if it.times[0] == 0:
            assert np.allclose(it.states[0], it.start, rtol=0, atol=1e-15)


@pytest.mark.few(2)
@pytest.mark.parametrize("case", list(MOTION_CASES))
def test_simulate_never_misleads(case: str) -> None:
    for name in ("simulate", "simulate-fine"):
        found = attempt(lambda n=name: MOTION_CASES[case]().judge(driver(n)))  # type: ignore[misc]
        assert found is not None and found.mark in HONEST, found


class Blind(Driver):
    """An integrator at a tolerance of 1e-2 that watches for nothing."""

    name, title, usual = "blind", "broken", 1e-2

    def run(self, scene: ReferenceMotion, times: Any, tolerance: float) -> MotionAnswer:
        return driver("rk45").run(scene, times, tolerance)


@pytest.mark.parametrize("case", ["lifts off", "falls flat", "gn dips to -1.3e-2", "mu = 1e4"])
def test_a_broken_driver_is_caught(case: str) -> None:
    found = attempt(lambda: MOTION_CASES[case]().judge(Blind()))
    assert found is not None and found.mark in (Mark.WRONG, Mark.CRASHED)


def test_where_truth_is_undetermined_only_that_answer_is_right(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from dataclasses import replace

    open_ = replace(scene("lift-off"), outcome="undetermined")
    case = MOTION_CASES["lifts off"]()
    monkeypatch.setattr(type(case), "it", lambda _: open_)
    times, states = open_.times, open_.states
    for outcome, mark in (
        ("undetermined", Mark.RIGHT),
        ("lift-off", Mark.WRONG),
        ("moving", Mark.WRONG),
        ("unresolved", Mark.RIGHT),
    ):
        assert case.weigh(MotionAnswer(times, states, outcome, 16.1)).mark is mark


def test_a_model_has_an_error_that_no_tolerance_mends() -> None:
    it = scene("stiff-10000")
    rows = [judged(it, driver("rough-model").run(it, it.asked, t))["path"] for t in (1e-6, 1e-12)]
    assert rows[0] == pytest.approx(rows[1], rel=0.05)
    assert 1e-5 < rows[1] < 1e-2  # of order 1/mu


def test_the_error_of_the_rough_model_falls_as_one_over_mu() -> None:
    off = []
    for name in ("stiff-10000", "stiff-100000"):
        it = scene(name)
        early = (it.times > 0) & (it.times <= 2)
        run = driver("rough-model").run(it, it.times, 1e-11)
        off.append(np.abs(run.states[early, :4] - it.states[early, :4]).max())
    assert off[0] / off[1] == pytest.approx(10, rel=0.3)


# --- the catalogue as text ---


def entry(mark: Mark | None, digits: float = math.nan, method: str = "spectrum") -> Entry:
    return Entry("linear", "g", "two structural zeros", method, mark, digits, 'a, "note"')


def test_the_catalogue_is_written_as_csv_and_markdown() -> None:
    found = [
        entry(Mark.DEGRADED, 7.0),
        entry(Mark.WRONG, method="ad"),
        entry(None, method="certified"),
    ]
    rows = list(csv.DictReader(io.StringIO(catalogue.as_csv(found))))
    assert [r["mark"] for r in rows] == ["degraded", "wrong", ""]
    assert rows[0]["digits"] == "7" and rows[0]["note"] == 'a, "note"'
    text = catalogue.as_markdown(found)
    assert "| two structural zeros | degraded (7) | wrong |  |" in text
    assert "how the truth is known" in text


def test_a_default_route_that_is_wrong_is_told() -> None:
    assert catalogue.misleading([entry(Mark.WRONG, method="ad"), entry(Mark.UNDECIDED)]) == []
    assert len(catalogue.misleading([entry(Mark.WRONG), entry(Mark.CRASHED)])) == 2


def test_the_readme_counts_cases_and_methods() -> None:
    readme = (Path(__file__).parents[2] / "README.md").read_text()
    cases, methods = len(CASES) + len(MOTION_CASES), len(routes.ROUTES) + len(DRIVERS)
    assert f"{cases} hard cases to {methods} methods" in readme
    assert readme.count("hard cases") == readme.count(f"{cases} hard cases")


def test_every_case_and_method_is_documented_and_has_a_name_of_its_own() -> None:
    assert len({r.title for r in routes.ROUTES.values()}) == len(routes.ROUTES)
    assert len({d.title for d in DRIVERS.values()}) == len(DRIVERS)
    assert set(catalogue.ROUTE_NAMES) == set(routes.ROUTES)
    assert set(catalogue.DRIVER_NAMES) == set(DRIVERS)
    for case in (*CASES.values(), *MOTION_CASES.values()):
        it: Case | MotionCase = case()
        assert it.__doc__ and it.physics and it.source and it.group
    assert isinstance(attempt(lambda: Judgement(Mark.RIGHT)), Judgement)


def test_every_public_name_of_the_comparison_is_there() -> None:
    import stability.compare

    assert all(getattr(stability.compare, name) is not None for name in stability.compare.__all__)


def test_an_integrator_with_the_name_of_another_driver_is_compared_too() -> None:
    from stability.compare.motion.drivers import FixedStep, _single

    assert _single("dop853", [FixedStep.name]).name == "dop853"
    named_alike = _single("dop853", ["dop853"])
    assert (named_alike.name, named_alike().method) == ("simulate-dop853", "dop853")


# --- whole calls ---


@pytest.mark.parametrize("question", calls.QUESTIONS)
def test_whole_calls_are_right_and_their_errors_are_those_of_what_is_returned(
    question: str,
) -> None:
    """The error of an answer that is moved on purpose is what it was moved by."""
    asked = calls.QUESTIONS[question]
    size = asked.sizes[0]
    for way in asked.ways.values():
        answer = way.call(size)
        if way.own:
            assert asked.error(size, answer) < 1e-8
        if isinstance(answer, float | np.ndarray):
            assert asked.error(size, answer * (1 + 1e-3)) == pytest.approx(1e-3, rel=1e-2)


def test_an_answer_that_is_missing_has_no_error() -> None:
    value = {"first": 1.0, "size": [1], "error": [None], "seconds": [[2.0, 3.0]]}
    cell = Cell("calls/spectrum/eigvals", DONE, value, "", 0.0)
    [row] = calls.rows({"calls/spectrum/eigvals": cell})
    assert row["error"] is None and row["time [s]"] == 2.0 and not row["own"]
