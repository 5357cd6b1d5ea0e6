"""Certified verdicts and eigenvalues against 200-digit arithmetic: none wrong, none undecided."""

from typing import Any

import casadi as ca
import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as s
from spectrum_oracle import DIGITS, random_points, reduced_truth, truth

import stability as st
from stability.algebra.exact.number_fields import rational
from stability.base.verdict import Verdict
from stability.bodies.subject import subject_of
from stability.spectra.certificate import certify, verdict
from stability.spectra.problem import disk_problem, problem_of

FAMILIES = ["rolling", "spinning", "tumbling"]


def mine(family: str, at: float, k: float, mu: float) -> Verdict:
    question = disk_problem(family, st.Disk(k=k), st.Viscous(mu), at)
    return verdict(question, {n: float(v) for n, v in question.values.items()})


def campaign(family: str, count: int, seed: int) -> tuple[int, int]:
    at, q = random_points(family, count, seed)
    wrong = undecided = 0
    for (a,), (k, mu) in zip(at.tolist(), q.tolist(), strict=True):
        found = mine(family, a, k, mu)
        undecided += found is Verdict.UNDECIDED
        wrong += found is not truth(family, a, k, mu)
    return wrong, undecided


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("count", [30, pytest.param(120, marks=pytest.mark.long)])
def test_no_verdict_is_wrong_or_undecided_at_random_points(family: str, count: int) -> None:
    assert campaign(family, count, seed=21) == (0, 0)


@pytest.mark.long
@pytest.mark.parametrize("family", FAMILIES)
def test_no_verdict_is_wrong_or_undecided_at_ten_thousand_points(family: str) -> None:
    wrong, undecided = campaign(family, 10_000, seed=22)
    print(f"{family}: 10000 points against {DIGITS} digits, {wrong} wrong, {undecided} undecided")
    assert (wrong, undecided) == (0, 0)


BOUNDARIES = [
    ("rolling", 0.25, 0.3, (1.0, 2.0)),
    ("rolling", 0.5, 300.0, (0.5, 2.0)),
    ("rolling", 0.001, 1e-5, (10.0, 40.0)),
    ("spinning", 0.25, 0.3, (1.0, 3.0)),
    ("spinning", 0.3125, 0.9, (2.0, 9.0)),
    ("spinning", 0.5, 1.05, (1.42, 1.5)),
    ("tumbling", 0.25, 3.0, (0.3, 1.5)),
    ("tumbling", 0.5, 0.1, (0.01, 0.1)),
    ("tumbling", 0.5, 0.003, (1e-6, 1e-3)),
    ("tumbling", 0.375, 0.9, (0.4, 0.6)),
    ("tumbling", 0.375, 0.9, (0.7, 1.0)),
    ("tumbling", 0.3125, 10.0, (0.001, 0.1)),
]


@pytest.mark.few(1)
@pytest.mark.parametrize(("family", "k", "mu", "ends"), BOUNDARIES)
def test_verdicts_beside_every_boundary_are_right_down_to_the_last_digits(
    family: str, k: float, mu: float, ends: tuple[float, float]
) -> None:
    [point] = st.boundaries(
        family, axis=("at", *ends, 40), disk=st.Disk(k=k), contact=st.Viscous(mu)
    )
    seen = set()
    for digits in range(2, 16):
        for side in (-1, 1):
            at = point.value * (1 + side * 10.0**-digits)
            found = mine(family, at, k, mu)
            assert found is truth(family, at, k, mu)
            seen.add(found)
            if digits < 15:
                right = (side < 0) == point.stable_below
                assert found is (Verdict.STABLE if right else Verdict.UNSTABLE)
    assert seen == {Verdict.STABLE, Verdict.UNSTABLE}


def test_the_hoop_nearly_flat_is_truly_unstable() -> None:
    for theta in (1e-4, 1e-3, 0.0017, 0.0175, 0.08):
        s_ = st.spectrum(
            "tumbling", at=theta, disk=st.Disk.hoop(), contact=st.Viscous(3.0), certify=True
        )
        assert s_.verdict is truth("tumbling", theta, 0.5, 3.0) is Verdict.UNSTABLE
        assert 0 < s_.abscissa < 1e-4
        assert s_.abscissa_error < 1e-15 * s_.abscissa


# --- eigenvalues ---


@pytest.mark.few(3)
@pytest.mark.parametrize(
    ("family", "at", "k", "mu"),
    [
        ("rolling", 1.3, 0.25, 0.3),
        ("rolling", 1.3, 0.25, 1e6),
        ("spinning", 2.5, 0.3, 1e4),
        ("spinning", 0.4, 0.1, 0.01),
        ("tumbling", 0.0003, 0.5, 2.0),
        ("tumbling", 1.1, 0.01, 1e5),
        ("tumbling", 0.0001, 0.5, 0.02),
    ],
)
def test_certified_eigenvalues_lie_in_their_discs_and_the_abscissa_is_sharp(
    family: str, at: float, k: float, mu: float
) -> None:
    found = st.spectrum(family, at=at, disk=st.Disk(k=k), contact=st.Viscous(mu), certify=True)
    with mpmath.workdps(DIGITS):
        coefficients = reduced_truth(family, "viscous", at, k, mu)
        roots = mpmath.polyroots(coefficients[::-1], maxsteps=2000, extraprec=2000)
        for value, radius in zip(found.eigenvalues, found.radius, strict=True):
            assert min(abs(mpmath.mpc(value) - r) for r in roots) <= radius
        exact_abscissa = max(mpmath.re(r) for r in roots)
        assert abs(exact_abscissa - found.abscissa) <= found.abscissa_error
        assert found.abscissa_error <= 1e-11 * abs(found.abscissa)
        assert found.abscissa_error < 4e-16 * abs(found.abscissa)


def test_growth_rates_of_1e_14_have_eleven_digits_and_more() -> None:
    found = st.spectrum(
        "tumbling", at=1.2e-4, disk=st.Disk.hoop(), contact=st.Viscous(0.02), certify=True
    )
    assert abs(found.abscissa) < 1e-12
    assert found.abscissa_error <= 1e-15 * abs(found.abscissa)


@pytest.mark.parametrize("examples", [8, pytest.param(60, marks=pytest.mark.long)])
def test_double_precision_and_certified_spectra_agree(examples: int) -> None:
    ask = given(s.floats(0.05, 0.5), s.floats(-3, 3), s.floats(-1.2, 1.2))(double_and_certified)
    settings(max_examples=examples, deadline=None)(ask)()


def double_and_certified(k: float, mu: float, at: float) -> None:
    for family, point in (("rolling", 10**at), ("spinning", 10**at), ("tumbling", 0.7 + at / 2)):
        question = {"at": point, "disk": st.Disk(k=k), "contact": st.Viscous(10**mu)}
        plain = st.spectrum(family, **question, escalate=False)
        proved = st.spectrum(family, **question, certify=True)
        assert plain.verdict in (proved.verdict, Verdict.UNDECIDED)
        near = np.abs(plain.eigenvalues[:, None] - proved.eigenvalues[None, :])
        assert (near <= plain.radius[:, None] + proved.radius[None, :]).any(axis=1).all()


# --- exactly on a boundary ---


def test_points_on_a_boundary_are_neutral() -> None:
    hoop = st.Disk.hoop()
    for mu in (1e-3, 0.3, 1.0, 77.0):  # omega3² = 1/(2k) = 1
        found = st.spectrum("rolling", at=1.0, disk=hoop, contact=st.Viscous(mu), certify=True)
        assert found.verdict is Verdict.NEUTRAL
        assert (found.abscissa, found.abscissa_error) == (0.0, 0.0)
        assert found.nonlinear is st.Nonlinear.OPEN
    found = st.spectrum("spinning", at=2.0, contact=st.Viscous(0.5), certify=True)
    assert found.verdict is Verdict.NEUTRAL  # phi_dot² = 1/k
    beyond = st.spectrum("spinning", at=2.0, contact=st.Viscous(1.5), certify=True)
    assert beyond.verdict is Verdict.UNSTABLE  # static zero, but and flutter: mu* > 1


def test_boundaries_are_met_in_si_units_too() -> None:
    # at² R / g = 36 · 0.5 / 9 = 2 = 1/(2k), exactly in doubles
    disk = st.Disk(mass=0.3, radius=0.5, gravity=9.0, k=0.25)
    for law in (st.Viscous(0.7), st.LinearViscous(0.13)):
        found = st.spectrum("rolling", at=6.0, disk=disk, contact=law, certify=True)
        assert found.verdict is Verdict.NEUTRAL
        up = st.spectrum("rolling", at=np.nextafter(6.0, 7), disk=disk, contact=law, certify=True)
        down = st.spectrum("rolling", at=np.nextafter(6.0, 5), disk=disk, contact=law, certify=True)
        assert (up.verdict, down.verdict) == (Verdict.STABLE, Verdict.UNSTABLE)
        assert 0 < down.abscissa < 1e-14
        assert down.abscissa_error < 1e-11 * down.abscissa


SCALES = (s.floats(-3, 3), s.floats(-2, 2), s.floats(-2, 2), s.floats(0.02, 0.5), s.floats(-2, 2))


@pytest.mark.long
@given(*SCALES)
@settings(max_examples=8, deadline=None)
def test_si_units_and_dimensionless_numbers_are_certified_alike(
    mass: float, radius: float, gravity: float, k: float, mu: float
) -> None:
    alike(mass, radius, gravity, k, mu)


@pytest.mark.long
@given(*SCALES)
@settings(max_examples=25, deadline=None)
def test_more_si_units_and_dimensionless_numbers_are_certified_alike(
    mass: float, radius: float, gravity: float, k: float, mu: float
) -> None:
    alike(mass, radius, gravity, k, mu)


def alike(mass: float, radius: float, gravity: float, k: float, mu: float) -> None:
    disk = st.Disk(mass=10**mass, radius=10**radius, gravity=10**gravity, k=k)
    rate, speed, drag = float(disk.rate), float(disk.speed), 10**mu
    for family, at in (("rolling", 1.7), ("spinning", 2.3), ("tumbling", 0.8)):
        here = at if family == "tumbling" else at * rate
        laws = [
            (st.Viscous(drag / speed), st.Viscous(drag)),
            (st.LinearViscous(drag * 10**mass * rate), st.LinearViscous(drag)),
            (st.LinearViscous(mu=drag / speed), st.Viscous(drag)),
            (st.Rough(), st.Rough()),
            (st.Smooth(), st.Smooth()),
        ]
        for si, plain in laws:
            one = st.spectrum(family, at=here, disk=disk, contact=si, certify=True)
            other = st.spectrum(family, at=at, disk=st.Disk(k=k), contact=plain, certify=True)
            size = np.abs(other.eigenvalues).max()
            assert np.abs(one.eigenvalues / rate - other.eigenvalues).max() < 1e-9 * size
            double = st.spectrum(family, at=here, disk=disk, contact=si)
            near = np.abs(one.eigenvalues[:, None] - double.eigenvalues[None, :])
            assert (near <= one.radius[:, None] + double.radius[None, :]).any(axis=1).all()


@pytest.mark.parametrize("law", [st.Smooth(), st.Rough()], ids=["smooth", "rough"])
def test_conservative_verdicts_go_by_the_square_of_lambda(law: Any) -> None:
    k = 0.25
    square = {"smooth": 1 / (4 * k), "rough": 1 / (2 * (2 * k + 1))}[law.name]
    threshold = square**0.5
    for step, wanted in ((2, Verdict.NEUTRAL), (-2, Verdict.UNSTABLE)):
        at = threshold * (1 + step * 2.0**-52)
        found = st.spectrum("rolling", at=at, contact=law, certify=True)
        assert found.verdict is wanted
    if law.name == "smooth":  # the threshold 1 is a double
        found = st.spectrum("rolling", at=threshold, contact=law, certify=True)
        assert found.verdict is Verdict.NEUTRAL
        assert (found.eigenvalues == 0).all() and (found.radius == 0).all()
        assert found.nonlinear is st.Nonlinear.OPEN
    above = st.spectrum("rolling", at=2.0, contact=law, certify=True)
    assert (above.eigenvalues.real == 0).all()
    assert above.nonlinear is st.Nonlinear.BY_INTEGRALS


def test_upright_is_a_symbol_and_the_lean_is_carried() -> None:
    for mu, wanted in ((0.6, Verdict.NEUTRAL), (1.5, Verdict.UNSTABLE)):
        found = st.spectrum("tumbling", lean=0.0, contact=st.Viscous(mu), certify=True)
        assert found.verdict is wanted
        spin = st.spectrum("spinning", at=2.0, contact=st.Viscous(mu), certify=True)
        assert np.abs(found.eigenvalues - spin.eigenvalues).max() < 1e-15  # the branch point
    with mpmath.workdps(DIGITS):
        for lean in (1e-3, 1e-25, -1e-25):
            found = st.spectrum("tumbling", lean=lean, contact=st.Viscous(0.6), certify=True)
            theta = mpmath.pi / 2 - mpmath.mpf(lean)
            roots = mpmath.polyroots(
                reduced_truth("tumbling", "viscous", theta, 0.25, 0.6)[::-1],
                maxsteps=2000,
                extraprec=2000,
            )
            top = max(mpmath.re(r) for r in roots)
            assert abs(top - found.abscissa) <= found.abscissa_error < 1e-15 * abs(found.abscissa)
            assert found.verdict is Verdict.STABLE


def test_lean_and_theta_name_the_same_motion() -> None:
    one = st.spectrum("tumbling", lean=0.5, contact=st.Viscous(0.4))
    other = st.spectrum("tumbling", at=np.pi / 2 - 0.5, contact=st.Viscous(0.4))
    assert np.abs(one.eigenvalues - other.eigenvalues).max() < 1e-14
    assert one.at == pytest.approx(other.at)


# --- the arithmetic itself ---


@given(s.lists(s.integers(-4, 4), min_size=1, max_size=5), s.integers(0, 2), s.integers(0, 3))
@settings(max_examples=80, deadline=None)
def test_verdicts_of_polynomials_over_q_are_those_of_their_roots(
    real: list[int], zeros: int, pairs: int
) -> None:
    """Known roots: some real, some at zero, some pairs a ± 2i with a = -1, 0, 1."""
    from flint import fmpq_poly

    from stability.algebra.exact.roots import split
    from stability.algebra.exact.routh import on_the_axis

    kept = [r for r in real if r]
    p = fmpq_poly([1])
    for r in kept:
        p = p * fmpq_poly([-r, 1])
    parts = [-1, 0, 1][:pairs]
    for a in parts:
        p = p * fmpq_poly([a * a + 4, -2 * a, 1])
    p = p * fmpq_poly([0] * zeros + [1])
    if p.degree() < 1:
        return
    top = max([*kept, *parts, *([0] if zeros else [])])
    wanted = Verdict.UNSTABLE if top > 0 else Verdict.STABLE if top < 0 else Verdict.NEUTRAL
    assert on_the_axis([p]) is wanted
    count, symmetric, rest = split(p)
    assert count == zeros
    assert fmpq_poly([0] * count + [1]) * symmetric * rest == p


def test_the_budget_ends_in_undecided_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    import stability.spectra.verdict_routes as module

    monkeypatch.setattr(module, "MOST_BITS", 64)
    found = st.spectrum("tumbling", at=1.0, contact=st.Viscous(0.6), certify=True)
    assert found.verdict is Verdict.UNDECIDED
    assert not found.certified
    assert "budget" in found.reason


def test_a_users_family_is_certified() -> None:
    import casadi as ca

    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    system = st.System(
        "damped",
        x,
        p,
        ca.vertcat(x[1], -ca.sin(x[0]) - p[0] * x[1] + p[1] * x[0]),
        states=("angle", "rate"),
        parameters=("drag", "push"),
    )
    rest = st.Family(system, "rest", at=("drag",), held={"angle": 0, "rate": 0})
    for push, wanted in ((1 - 1e-15, Verdict.STABLE), (1 + 1e-15, Verdict.UNSTABLE)):
        found = st.spectrum(rest, at=0.3, push=push, certify=True)
        assert found.verdict is wanted
        assert found.certified
        assert 1e-16 < abs(found.abscissa) < 1e-13
        assert found.abscissa_error < 1e-14 * abs(found.abscissa)
    question = problem_of(subject_of(rest, at=0.3, parameters={"push": 1.0}))
    here = verdict(question, {"drag": 0.3, "push": 1.0})
    assert here is Verdict.NEUTRAL  # eigenvalues 0 and -0.3, over Q


def test_circling_is_certified() -> None:
    found = st.spectrum("circling", at=(1.0, 0.7), contact=st.Rough(), certify=True)
    plain = st.spectrum("circling", at=(1.0, 0.7), contact=st.Rough())
    assert found.verdict is plain.verdict
    assert np.abs(found.eigenvalues - plain.eigenvalues).max() < 1e-14


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("family", "at", "k", "mu"),
    [
        ("spinning", 13.231696706442328, 0.5, 1.2898585826377468e-09),
        ("rolling", 30.0, 0.3, 1e-7),
        ("spinning", 40.0, 0.5, 1e-10),
    ],
)
def test_the_abscissa_error_covers_eigenvalues_that_share_one_double(
    family: str, at: float, k: float, mu: float
) -> None:
    found = st.spectrum(family, at=at, disk=st.Disk(k=k), contact=st.Viscous(mu), certify=True)
    with mpmath.workdps(300):
        coefficients = reduced_truth(family, "viscous", at, k, mu)
        roots = mpmath.polyroots(coefficients[::-1], maxsteps=5000, extraprec=4000)
        off = abs(max(mpmath.re(r) for r in roots) - mpmath.mpf(found.abscissa))
        assert off <= found.abscissa_error < 1e-15 * abs(found.abscissa)


def test_rational_is_the_double_itself() -> None:
    assert rational(0.1) != rational(0.1 + 2e-17 + 1e-17)
    assert float(rational(0.1).p) / float(rational(0.1).q) == 0.1


def test_a_batch_is_what_its_points_are() -> None:
    at = np.array([[1.2, 1.5], [2.0, 0.3]])
    batch = st.spectrum("rolling", at=at, contact=st.Viscous(0.3), certify=True)
    assert batch.certified.all()
    for index in np.ndindex(at.shape):
        one = st.spectrum("rolling", at=at[index], contact=st.Viscous(0.3), certify=True)
        assert (batch.eigenvalues[index] == one.eigenvalues).all()
        assert batch.verdict[index] is one.verdict
        assert batch.abscissa_error[index] == one.abscissa_error


@pytest.mark.parametrize("own", [False, True], ids=["disk", "own"])
def test_a_repeated_point_is_proved_once(own: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    proofs = []

    def counted(*args: Any, **options: Any) -> Any:
        proofs.append(args[1])
        return certify(*args, **options)

    monkeypatch.setattr("stability.spectra.certificate.certify", counted)
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    system = st.System(
        "pendulum",
        x,
        p,
        ca.vertcat(x[1], p * ca.sin(x[0]) - x[1]),
        states=("a", "b"),
        parameters=("p",),
    )
    held = st.Family(system, "upright", at=("p",), held={"a": 0.0, "b": 0.0})
    family, law = (held, {}) if own else ("rolling", {"contact": st.Viscous(0.3)})
    values = [0.7, -1.2, 1.7, 0.0]
    at = np.array(values * 50 + [-0.0])
    batch = st.spectrum(family, at=at, certify=True, **law)
    assert len(proofs) == len(values) + 1
    for value, repeat in zip(values, range(4), strict=True):
        one = st.spectrum(family, at=value, certify=True, **law)
        for place in range(repeat, 200, 4):
            assert (batch.eigenvalues[place] == one.eigenvalues).all()
            assert batch.verdict[place] is one.verdict
            assert batch.abscissa_error[place] == one.abscissa_error


def test_certify_returns_what_it_says() -> None:
    question = disk_problem("rolling", st.Disk(), st.Viscous(0.3), 1.8)
    found = certify(question, {n: float(v) for n, v in question.values.items()})
    assert found.how == "rational arithmetic"
    assert sorted(found.eigenvalues, key=lambda v: (v.real, v.imag)) == list(found.eigenvalues)
