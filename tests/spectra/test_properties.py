"""What must hold for all numbers: symmetry, scaling, inertia, derivatives, error bounds."""

from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as some

import stability as st
from stability.algebra.number_types import balls, numpy_algebra, sympy_algebra
from stability.algebra.program import Program
from stability.algebra.running_error import RunningError, running_error_arrays
from stability.bodies.contact_laws import LAWS

inertias = some.floats(0.02, 0.5)
frictions = some.floats(-3, 3).map(lambda e: 10.0**e)
tilts = some.floats(0.05, 1.5)
rates = some.floats(0.1, 6)


def tumbling_and_its_mirror_image_have_one_spectrum(theta: float, k: float, mu: float) -> None:
    pair = [
        st.spectrum("tumbling", at=angle, disk=st.Disk(k=k), contact=st.Viscous(mu))
        for angle in (theta, np.pi - theta)
    ]
    size = np.abs(pair[0].eigenvalues).max()
    reach = pair[0].radius.max() + pair[1].radius.max() + 1e-14 * size
    distance = np.abs(pair[0].eigenvalues[:, None] - pair[1].eigenvalues)
    assert distance.min(axis=1).max() <= reach
    assert pair[0].verdict is pair[1].verdict


def turning_the_other_way_has_the_same_spectrum(
    family: str, at: float, k: float, mu: float
) -> None:
    one, other = (
        st.spectrum(family, at=s * at, disk=st.Disk(k=k), contact=st.Viscous(mu)) for s in (1, -1)
    )
    distance = np.abs(one.eigenvalues[:, None] - other.eigenvalues).min(axis=1).max()
    assert distance <= one.radius.max() + other.radius.max()


def si_units_and_dimensionless_numbers_say_the_same(
    family: str,
    law: str,
    mass: float,
    radius: float,
    gravity: float,
    k: float,
    at: float,
    mu: float,
) -> None:
    disk, unit = st.Disk(mass, radius, k, gravity), st.Disk(k=k)
    physical, plain = {
        "smooth": lambda: (st.Smooth(), st.Smooth()),
        "rough": lambda: (st.Rough(), st.Rough()),
        "viscous": lambda: (st.Viscous(mu / disk.speed), st.Viscous(mu)),
        "linear-viscous": lambda: (st.LinearViscous(mu * mass * disk.rate), st.LinearViscous(mu)),
    }[law]()
    scale = 1.0 if family == "tumbling" else disk.rate
    found = st.spectrum(family, at=at * scale, disk=disk, contact=physical)
    expected = st.spectrum(family, at=at, disk=unit, contact=plain)
    reach = found.radius.max() / disk.rate + expected.radius.max()
    distance = np.abs(found.eigenvalues[:, None] / disk.rate - expected.eigenvalues)
    assert distance.min(axis=1).max() <= reach
    # modes are given in the user's units, shares without
    assert found.modes.participation.shape == expected.modes.participation.shape


SYMMETRIES: list[tuple[Callable[..., None], dict[str, Any]]] = [
    (
        tumbling_and_its_mirror_image_have_one_spectrum,
        {"theta": tilts, "k": inertias, "mu": frictions},
    ),
    (
        turning_the_other_way_has_the_same_spectrum,
        {
            "family": some.sampled_from(["rolling", "spinning"]),
            "at": rates,
            "k": inertias,
            "mu": frictions,
        },
    ),
    (
        si_units_and_dimensionless_numbers_say_the_same,
        {
            "family": some.sampled_from(["rolling", "spinning", "tumbling"]),
            "law": some.sampled_from(sorted(LAWS)),
            "mass": some.floats(1e-3, 1e3),
            "radius": some.floats(1e-3, 1e2),
            "gravity": some.floats(0.1, 100),
            "k": inertias,
            "at": some.floats(0.2, 1.4),
            "mu": frictions,
        },
    ),
]


@pytest.mark.parametrize("examples", [10, pytest.param(100, marks=pytest.mark.long)])
@pytest.mark.parametrize(("ask", "of"), SYMMETRIES, ids=lambda v: getattr(v, "__name__", ""))
def test_spectra_keep_a_symmetry(
    ask: Callable[..., None], of: dict[str, Any], examples: int
) -> None:
    settings(max_examples=examples, deadline=None, derandomize=True)(given(**of)(ask))()


@given(ratio=some.floats(0, 1))
def test_inertia_of_an_annulus_is_the_integral_over_its_area(ratio: float) -> None:
    """I₁/(m R²) = ∫ r² sin²φ dA / ∫ dA, by Gauss-Legendre on the ring."""
    nodes, weights = np.polynomial.legendre.leggauss(8)
    r = ratio + (1 - ratio) * (nodes + 1) / 2
    if ratio < 1:
        k = 0.5 * (weights * r**3).sum() / (weights * r).sum()
    else:
        k = 0.5
    assert st.Disk.annulus(ratio).k == pytest.approx(k, rel=1e-12)
    assert st.Disk.annulus(0.3 * ratio, mass=1.0, radius=0.3, gravity=1.0).k == pytest.approx(
        k, rel=1e-12
    )


def test_uniform_and_hoop_are_the_ends_of_the_annulus() -> None:
    assert st.Disk.annulus(0).k == st.Disk.uniform().k == 0.25
    assert st.Disk.annulus(1).k == st.Disk.hoop().k == 0.5


@pytest.mark.parametrize("law", LAWS)
def test_automatic_jacobian_is_the_limit_of_differences_of_order_two(law: str) -> None:
    system = st.disk_system(law)
    n = len(system.states)
    random = np.random.default_rng(7)
    x = np.concatenate([[1.1], random.uniform(-1, 1, n - 1)])
    p = [0.3, 0.4][: len(system.parameters)]
    exact = system.linearise(x, p)
    errors = []
    for step in (1e-2, 5e-3, 2.5e-3):
        shift = step * np.eye(n)
        found = (system.rates(x + shift, p) - system.rates(x - shift, p)).T / (2 * step)
        errors.append(np.abs(found - exact).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx([2, 2], abs=0.02)


@pytest.mark.parametrize("law", LAWS)
def test_the_implicit_form_holds_where_the_rates_were_solved_from_it(law: str) -> None:
    system = st.disk_system(law)
    random = np.random.default_rng(2)
    n = len(system.states)
    x = np.concatenate([[0.8], random.uniform(-1, 1, n - 1)])
    p = [0.3, 0.4][: len(system.parameters)]
    form = ca.Function("form", [system.x, system.p], [system.mass, system.forcing])
    mass, forcing = (np.array(v) for v in form(x, p))
    unknowns = np.linalg.solve(mass, forcing)[:, 0]
    rates = dict(zip(system.states, system.rates(x, p), strict=True))
    observed = system.observe(x, p)
    for name, value in zip(system.unknowns, unknowns, strict=True):
        if name.startswith("d_"):
            assert rates[name[2:]] == pytest.approx(value, abs=1e-13)
        elif name == "normal":
            assert observed["normal_force"] == pytest.approx(value, abs=1e-13)


def test_no_reading_of_the_graph_divides_by_the_cosine() -> None:
    """Exactly upright, and an ulp to either side, rates and Jacobians are finite and continuous."""
    system = st.disk_system("viscous")
    rest = [0.3, -0.4, 0.7, 0.2, -0.1]
    angles = [np.nextafter(np.pi / 2, 0), np.pi / 2, np.nextafter(np.pi / 2, 2)]
    rates = [system.rates([t, *rest], [0.25, 0.3]) for t in angles]
    slopes = [system.linearise([t, *rest], [0.25, 0.3]) for t in angles]
    assert np.ptp(rates, axis=0).max() < 1e-14
    assert np.ptp(slopes, axis=0).max() < 1e-13


@pytest.mark.parametrize("theta", [0.0, np.pi, -0.1, 3.5])
def test_a_flat_disk_is_refused_with_the_reason(theta: float) -> None:
    with pytest.raises(st.StabilityError, match="disk is flat"):
        st.disk_system("viscous").rates([theta, 0, 1, 0, 0, 0], [0.25, 0.3])


def test_a_painleve_start_is_refused_with_the_reason() -> None:
    """D = k + cos²θ - mu slip_x sinθ cosθ ≤ 0; D > 0 for every θ iff |mu slip_x| < 2√(k(k+1))."""
    system, k = st.disk_system("viscous"), 0.25
    limit = 2 * np.sqrt(k * (k + 1))
    theta = np.linspace(0.01, 3.13, 2001)[:, None]
    for product, fine in ((0.999 * limit, True), (1.001 * limit, False)):
        slip = np.full_like(theta, product / 0.5)
        states = np.hstack([theta, np.zeros((2001, 3)), slip, np.zeros_like(theta)])
        if fine:
            assert system.observe(states, [k, 0.5])["determinant"].min() > 0
        else:
            with pytest.raises(st.StabilityError, match="Painlevé"):
                system.rates(states, [k, 0.5])


# --- the graph in other algebras, on random graphs ---


def random_graph(seed: int) -> ca.Function:
    random = np.random.default_rng(seed)
    x = ca.SX.sym("x", 3)
    pool = [x[i] for i in range(3)] + [ca.SX(0.75), ca.SX(-1.25)]
    unary: list[Any] = [ca.sin, ca.cos, ca.tanh, ca.atan]
    unary += [lambda v: ca.sqrt(1 + v * v), lambda v: v * v, lambda v: -v]
    unary += [lambda v: ca.exp(ca.sin(v)), lambda v: 1 / (2 + ca.cos(v))]
    binary: list[Any] = [lambda a, b: a + b, lambda a, b: a - b, lambda a, b: a * b]
    binary += [lambda a, b: a / (3 + ca.sin(b))]
    for _ in range(25):
        if random.random() < 0.4:
            pool.append(unary[random.integers(len(unary))](pool[random.integers(len(pool))]))
        else:
            a, b = random.integers(len(pool), size=2)
            pool.append(binary[random.integers(len(binary))](pool[a], pool[b]))
    return ca.Function("g", [x], [ca.vertcat(*pool[-4:]), ca.jacobian(pool[-1], x)])


@pytest.mark.parametrize("seed", range(12))
def test_random_graphs_read_alike_in_every_algebra(seed: int) -> None:
    function = random_graph(seed)
    program = Program(function)
    point = np.random.default_rng(seed + 100).uniform(-1, 1, 3)
    expected = [np.array(v).ravel() for v in function(point)]
    plain = program.arrays([[np.array(v) for v in point]], ())
    for found, value in zip(plain, expected, strict=True):
        assert found.ravel() == pytest.approx(value, rel=1e-12, abs=1e-12)
    enclosed = program.run(balls(), [[balls().constant(v) for v in point]])
    tracked = running_error_arrays(program, [[RunningError(np.array(v), 0.0) for v in point]], ())
    for index, places in enumerate(program.places):
        for (row, column), ball in zip(places, enclosed[index], strict=True):
            value, error = (part[row, column] for part in tracked[index])
            ball = balls().constant(0) + ball
            assert abs(float(ball.mid()) - value) <= error + float(ball.rad()) + 1e-300


def test_running_errors_cover_the_truth_and_are_not_idle() -> None:
    """√(1 + x) - 1 at x = 1e-13: three digits are left, and the bound says so."""
    x = ca.SX.sym("x")
    program = Program(ca.Function("f", [x], [ca.sqrt(1 + x) - 1]))
    [(value, error)] = running_error_arrays(program, [[RunningError(np.array(1e-13), 0.0)]], ())
    true_error = abs(float(value[0, 0]) - 1e-13 / (1 + np.sqrt(1 + 1e-13)))
    assert 0 < true_error <= float(error[0, 0]) < 1e3 * true_error


def test_sympy_reads_constants_exactly() -> None:
    x = ca.SX.sym("x")
    program = Program(ca.Function("f", [x], [0.1 * x]))
    import sympy

    assert program.run(sympy_algebra(), [[sympy.Integer(1)]])[0][0] == sympy.Rational(0.1)


def test_an_operation_that_is_not_smooth_is_refused() -> None:
    x = ca.SX.sym("x")
    with pytest.raises(st.StabilityError, match="smooth elementary"):
        Program(ca.Function("f", [x], [ca.if_else(x > 0, x, -x)]))
    assert Program(ca.Function("f", [x], [ca.fabs(x)])).run(numpy_algebra(), [[-2.0]]) == [[2.0]]


# --- systems of a user's own: bad input ---


@pytest.mark.parametrize(
    ("build", "sentence"),
    [
        (lambda x, _: {"rhs": x[0]}, "one each"),
        (lambda _x, _p: {"states": ("a", "a")}, "name of its own"),
        (lambda x, _: {"rhs": ca.vertcat(x[1], ca.SX.sym("z"))}, "symbol z"),
        (lambda _x, _p: {"parameters": ()}, "name of its own"),
    ],
)
def test_a_system_that_does_not_fit_is_refused(build: Any, sentence: str) -> None:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    arguments = {"rhs": ca.vertcat(x[1], -p * x[0]), "states": ("a", "b"), "parameters": ("p",)}
    arguments |= build(x, p)
    with pytest.raises(st.StabilityError, match=sentence):
        st.System("oscillator", x, p, **arguments)


@pytest.mark.parametrize("operation", ["+", "-", "*", "/"])
def test_tracked_operations_bound_their_own_rounding(operation: str) -> None:
    """Against exact fractions: each bound holds, and for some pair the error is half of it."""
    import operator
    from fractions import Fraction

    act = {"+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv}[
        operation
    ]
    random = np.random.default_rng(9)
    sharpest = 0.0
    for a, b in random.normal(size=(300, 2)):
        found = act(RunningError(float(a), 0.0), RunningError(float(b), 0.0))
        exact = act(Fraction(float(a)), Fraction(float(b)))
        error = abs(Fraction(float(found.value)) - exact)
        assert error <= Fraction(float(found.error))
        sharpest = max(sharpest, float(error) / float(found.error))
    assert sharpest > 0.5


def test_tracked_arguments_pass_their_errors_on() -> None:
    """First-order propagation through each elementary function, against mpmath."""
    import mpmath

    from stability.algebra.running_error import TRACKED

    for name in ("sin", "cos", "tan", "sqrt", "exp", "log", "atan", "tanh", "sinh", "asin"):
        x, e = 0.7, 1e-6
        found = TRACKED.functions[name](RunningError(np.array(x), np.array(e)))
        function = getattr(mpmath, name)
        spread = max(abs(function(x + s * e) - function(x)) for s in (-1, 1))
        assert float(spread) <= 1.0001 * float(found.error) <= 1.01 * float(spread)
