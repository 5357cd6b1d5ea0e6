"""Systems from SymPy: its own test models, each linearisation equal to SymPy's to 1e-12."""

import importlib
import runpy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import casadi as ca
import mpmath
import numpy as np
import pytest
import sympy as sm
from sympy import Rational, cos, sin, sqrt, symbols, tan
from sympy.physics import mechanics as me
from sympy.physics.mechanics import dynamicsymbols
from sympy.physics.mechanics.models import multi_mass_spring_damper, n_link_pendulum_on_cart
from sympy_models import harvest, linearised

import stability as st

ROOT = Path(__file__).resolve().parents[2]
CLOSE = 1e-12


def agrees(model: Any, *, dependent: Any = (), **how: Any) -> st.System:
    """The package's linearisation is SymPy's, at a random state on the constraints."""
    system = st.System.from_sympy(model, dependent=dependent)
    point = linearised(model, tuple(dependent), **how)
    x = [point.place[n] for n in system.states]
    ours = system.linearise(x, [point.place.get(n, 1.0) for n in system.parameters])
    where = [system.index(n) for n in point.names]
    size = max(1.0, np.abs(point.matrix).max())
    assert np.abs(ours[np.ix_(where, where)] - point.matrix).max() <= CLOSE * size
    return system


def harvested(module: str, test: str) -> list[Any]:
    with harvest() as found:
        getattr(importlib.import_module(f"sympy.physics.mechanics.tests.{module}"), test)()
    assert found
    return found


QUICK = [
    ("test_kane", "test_one_dof"),
    ("test_kane", "test_two_dof"),
    ("test_kane", "test_pend"),
    ("test_kane", "test_input_format"),
    ("test_kane", "test_parallel_axis"),
    ("test_lagrange", "test_simp_pen"),
    ("test_lagrange2", "test_lagrange_2forces"),
    ("test_models", "test_multi_mass_spring_damper_inputs"),
]
SLOW = [
    ("test_kane4", "test_replace_qdots_in_force"),
    ("test_kane", "test_rolling_disc"),
    ("test_kane2", "test_non_central_inertia"),
    ("test_kane2", "test_sub_qdot"),
    ("test_lagrange", "test_dub_pen"),
    ("test_lagrange", "test_rolling_disc"),
    ("test_models", "test_n_link_pendulum_on_cart_inputs"),
    ("test_models", "test_n_link_pendulum_on_cart_higher_order"),
    ("test_models", "test_multi_mass_spring_damper_higher_order"),
]


@pytest.mark.few(2)
@pytest.mark.parametrize(("module", "test"), QUICK, ids=lambda v: v.removeprefix("test_"))
def test_a_model_of_sympys_tests_has_sympys_linearisation(module: str, test: str) -> None:
    for model in harvested(module, test)[:2]:
        agrees(model)


@pytest.mark.long
@pytest.mark.parametrize(("module", "test"), QUICK + SLOW, ids=lambda v: v.removeprefix("test_"))
@pytest.mark.parametrize("seed", [1, 2])
def test_all_models_of_sympys_tests_have_sympys_linearisation(
    module: str, test: str, seed: int
) -> None:
    for model in harvested(module, test):
        agrees(model, seed=seed)


def test_constraints_of_lagranges_method_need_dependent_coordinates() -> None:
    (model,) = harvested("test_lagrange", "test_nonminimal_pendulum")
    with pytest.raises(st.StabilityError, match=r"1 constraint; name as many dependent"):
        st.System.from_sympy(model)


def pendulum_kane() -> tuple[Any, Any, Any]:
    """The nonminimal pendulum of sympy/physics/mechanics/tests/test_linearize.py."""
    q1, q2, u1, u2 = dynamicsymbols("q1 q2 u1 u2")
    length, m = symbols("L m")
    n, fixed = me.ReferenceFrame("N"), me.Point("O")
    fixed.set_vel(n, 0)
    p = fixed.locatenew("P", q1 * n.x + q2 * n.y)
    kinematics = [q1.diff() - u1, q2.diff() - u2]
    p.set_vel(n, u1 * n.x + u2 * n.y)
    kane = me.KanesMethod(
        n,
        [q2],
        [u2],
        kinematics,
        q_dependent=[q1],
        u_dependent=[u1],
        configuration_constraints=[sqrt(q1**2 + q2**2) - length],
        velocity_constraints=[q1 * u1 + q2 * u2],
    )
    kane.kanes_equations([me.Particle("P", p, m)], [(p, Rational(49, 5) * m * n.x)])
    return kane, q1, sqrt(length**2 - q2**2)


def test_a_dependent_coordinate_is_eliminated_by_its_expression() -> None:
    kane, q1, given = pendulum_kane()
    point = linearised(kane)
    system = st.System.from_sympy(kane, dependent={q1: given})
    assert system.states == ("q2", "u2")
    ours = system.linearise(
        [point.place[n] for n in system.states], [point.place[n] for n in system.parameters]
    )
    assert np.abs(ours - point.matrix).max() <= CLOSE * np.abs(point.matrix).max()
    assert system.parameters == ("L", "m")
    seen = system.observe([0.3, 0.2], [0.5, 1.0])
    assert seen["u1"] == pytest.approx(-0.3 * 0.2 / 0.4, rel=1e-14)


def test_an_expression_that_does_not_solve_the_constraint_is_refused() -> None:
    kane, q1, given = pendulum_kane()
    with pytest.raises(st.StabilityError, match="not at zero"):
        st.System.from_sympy(kane, dependent={q1: 2 * given})


def test_a_dependent_coordinate_without_expression_stays_a_state_and_is_watched() -> None:
    kane, _, _ = pendulum_kane()
    system = st.System.from_sympy(kane)
    assert system.states == ("q2", "q1", "u2")
    # det(λ - A) is λ (λ² + g/L): the constraint's own zero, and the pendulum
    values = np.linalg.eigvals(system.linearise([0.0, 2.0, 0.0], [2.0, 1.0]))
    assert np.sort_complex(values.round(12)) == pytest.approx(
        np.array([-1j, 0, 1j]) * np.sqrt(4.9), abs=1e-11
    )
    with pytest.raises(st.StabilityError, match="constraint_1 is not met"):
        system.rates([0.0, 1.9, 0.0], [2.0, 1.0])


def test_lagranges_multipliers_are_eliminated() -> None:
    q1, q2 = dynamicsymbols("q1 q2")
    length, m = symbols("L m")
    n, fixed = me.ReferenceFrame("N"), me.Point("O")
    fixed.set_vel(n, 0)
    p = fixed.locatenew("P", q1 * n.x + q2 * n.y)
    p.set_vel(n, q1.diff() * n.x + q2.diff() * n.y)
    bob = me.Particle("P", p, m)
    method = me.LagrangesMethod(
        me.Lagrangian(n, bob),
        [q1, q2],
        hol_coneqs=[q1**2 + q2**2 - length**2],
        forcelist=[(p, 10 * m * n.x)],
        frame=n,
    )
    method.form_lagranges_equations()
    system = agrees(method, dependent={q1: sqrt(length**2 - q2**2)})
    assert system.states == ("q2", "q2_dot")
    assert system.linearise([0, 0], [5, 3]) == pytest.approx(np.array([[0, 1], [-2, 0]]))
    place = {q1: 5, q2: 0, q1.diff(): 0, q2.diff(): 0, length: 5, m: 3}
    (lam,) = method.solve_multipliers(op_point=place).values()
    assert float(system.observe([0, 0], [5, 3])["lam1"]) == pytest.approx(float(lam), rel=1e-14)


@pytest.mark.long  # SymPy derives it in a second; the one with three speeds is asked each time
def test_the_rolling_disc_with_six_speeds_has_sympys_published_matrix() -> None:
    """The 8 x 8 matrix A_sol of test_linearize_rolling_disc_kane, at q3' = 7/4."""
    with harvest() as found, pytest.MonkeyPatch.context() as patch:

        class Enough(Exception):  # noqa: N818
            pass

        def stop(*_: Any, **__: Any) -> None:
            raise Enough

        patch.setattr(me.KanesMethod, "to_linearizer", stop)  # its checks take long
        with pytest.raises(Enough):
            harvested_test = importlib.import_module("sympy.physics.mechanics.tests.test_linearize")
            harvested_test.test_linearize_rolling_disc_kane()
    system = st.System.from_sympy(found[0])
    q1, w = 0.6, 1.75
    state = {"q1": q1, "q3": 0.4, "u2": w}
    ours = system.linearise([state.get(n, 0.0) for n in system.states], [1.0, 1.0, 1.0])
    s, c = np.sin(q1), np.cos(q1)
    true = np.array(
        [
            [0, 0, 0, 0, 0, 0, 0, 1],
            [0, 0, 0, 0, 0, 1, 0, 0],
            [0, 0, 0, 0, 0, 0, 1, 0],
            [s * w, 0, 0, 0, 0, -s, -c, 0],
            [-c * w, 0, 0, 0, 0, c, -s, 0],
            [0, 4 / 5, 0, 0, 0, 0, 0, 6 * w / 5],
            [0] * 8,
            [0, 0, 0, 0, 0, -2 * w, 0, 0],
        ]
    )
    assert system.states == ("q1", "q2", "q3", "q4", "q5", "u1", "u2", "u3")
    assert ours == pytest.approx(true, abs=CLOSE)


def test_the_threshold_of_the_rolling_disc(capsys: pytest.CaptureFixture[str]) -> None:
    """Straight rolling: λ² = 4 g/(5 r) - 12 u2²/5, so neutral above u2² = g/(3 r)."""
    space = runpy.run_path(str(ROOT / "examples" / "rolling_disc.py"))
    assert capsys.readouterr().out == "1.0 unstable\n2.0 neutral\n"
    family = space["straight"]
    for speed, radius in ((0.5, 0.25), (2.0, 0.5), (4.0, 0.75)):
        found = st.spectrum(family, at=speed, m=2.0, r=radius, g=9.75, certify=True)
        with mpmath.workdps(30):
            square = mpmath.mpf("9.75") * 4 / (5 * radius) - mpmath.mpf(12) * speed**2 / 5
            root = complex(mpmath.sqrt(square))
        assert found.verdict.word == ("unstable" if square > 0 else "neutral")
        assert np.sort_complex(found.eigenvalues) == pytest.approx(
            np.sort_complex([-root, root]), abs=CLOSE
        )
    # exactly on the threshold, with doubles: u2² = 1/4 = g/(3 r)
    assert st.spectrum(family, at=0.5, m=1.0, r=1.0, g=0.75, certify=True).verdict.word == "neutral"


@pytest.mark.long
def test_a_mechanics_system_is_read_through_its_method() -> None:
    """The cart with a pendulum of test_system_class.py, by Kane and by Lagrange, constrained."""
    g, l, mc, mp, k = symbols("g l mc mp k")  # noqa: E741
    qp, qc, up, uc, push = dynamicsymbols("qp qc up uc F")
    rail, cart, bob = (
        me.RigidBody("rail"),
        me.RigidBody("cart", mass=mc),
        me.Particle("bob", mass=mp),
    )
    frame = me.ReferenceFrame("frame")
    system = me.System.from_newtonian(rail)
    system.add_joints(
        me.PrismaticJoint("slider", rail, cart, qc, uc, joint_axis=rail.x),
        me.PinJoint(
            "pin",
            cart,
            bob,
            qp,
            up,
            joint_axis=cart.z,
            child_interframe=frame,
            child_point=l * frame.y,
        ),
    )
    system.apply_uniform_gravity(-g * system.y)
    system.add_loads((cart.masscenter, push * rail.x))
    with pytest.raises(st.StabilityError, match=r"call its form_eoms\(\) first"):
        st.System.from_sympy(system)
    system.form_eoms()
    free = st.System.from_sympy(system, parameters=["F", g, l, mc, mp])
    assert free.parameters == ("F", "g", "l", "mc", "mp")
    agrees(system.eom_method)
    system.add_holonomic_constraints(
        sm.sympify(bob.masscenter.pos_from(rail.masscenter).dot(system.x))
    )
    system.q_ind, system.q_dep, system.u_ind, system.u_dep = qp, qc, up, uc
    system.form_eoms()
    bound = st.System.from_sympy(system)
    assert bound.states == ("qp", "up")  # the constraint is linear in qc
    # solved by hand in test_system_class.py, without the spring k
    place = {"g": 9.0, "l": 0.5, "mc": 2.0, "mp": 0.75, "F": 0.3}
    q, u = 0.4, 0.7
    s, c = np.sin(q), np.cos(q)
    true = -9.0 * 0.75 * s + 0.5 * 2.0 * np.sin(2 * q) * u**2 / 2
    true -= 0.5 * 0.75 * np.sin(2 * q) * u**2 / 2 + 0.3 * c
    true /= 0.5 * (2.0 * c**2 + 0.75 * s**2)
    found = bound.rates([q, u], [place[n] for n in bound.parameters])
    assert found == pytest.approx([u, true], rel=1e-13)
    agrees(system.eom_method)


def test_inputs_are_parameters_and_b_is_their_slope() -> None:
    kane = n_link_pendulum_on_cart(1, cart_force=True)
    system = st.System.from_sympy(kane)
    assert "F" in system.parameters
    matrix, forcing = kane.mass_matrix_full, kane.forcing_full
    point = {s: Rational(i + 2, 3) for i, s in enumerate(sorted(matrix.free_symbols, key=str))}
    point |= dict.fromkeys([*kane.q, *kane.u], 0) | {symbols("g"): 9}
    push = dynamicsymbols("F")
    true = matrix.subs(point).LUsolve(forcing.diff(push).subs(point))
    slope = ca.Function("B", [system.x, system.p], [ca.jacobian(system.rhs, system.p)])
    p = [float(point.get(symbols(n), 0)) for n in system.parameters]
    ours = np.array(slope(np.zeros(4), p))[:, system.parameters.index("F")]
    assert ours == pytest.approx(np.array(true.tolist(), dtype=float)[:, 0], rel=CLOSE)


def test_matrices_and_rates_make_the_same_system() -> None:
    q, u = dynamicsymbols("q u")
    m, k, c = symbols("m k c")
    whole = sm.Matrix([[2, 0], [0, m]]), sm.Matrix([2 * u, -k * sin(q) - c * u]), [q], [u]
    short = sm.Matrix([m]), sm.Matrix([-k * sin(q) - c * u]), [q], [u]
    rates = {q: u, u: (-k * sin(q) - c * u) / m}
    for model in (whole, short, rates):
        system = st.System.from_sympy(model, parameters=[m, k, c])
        found = system.linearise([0.5, 0.0], [2.0, 3.0, 0.25])
        assert found == pytest.approx(np.array([[0, 1], [-1.5 * np.cos(0.5), -0.125]]), rel=1e-14)


def test_common_subexpressions_are_built_once() -> None:
    x, a = symbols("x a")
    part = sm.log(sin(a * x) + cos(a * x))
    system = st.System.from_sympy({x: part**2 + part + 1 / part})
    ops = [system.function.instruction_id(i) for i in range(system.function.n_instructions())]
    assert ops.count(ca.OP_LOG) == ops.count(ca.OP_SIN) == ops.count(ca.OP_COS) == 1


def test_a_third_stays_a_third() -> None:
    """With k = 3 the trace is exactly zero; with a third rounded to a double it is not."""
    x, y, k = symbols("x y k")
    thirds = {x: Rational(1, 3) * k * x + y, y: -2 * x - y}
    for model, word in ((thirds, "neutral"), (thirds | {x: sm.Float(1 / 3) * k * x + y}, "stable")):
        system = st.System.from_sympy(model)
        family = st.Family(system, "rest", at=("k",), held={"x": 0.0, "y": 0.0})
        # A = [[k/3, 1], [-2, -1]]: trace 0 and determinant 1 at k = 3; the double is below 1/3
        assert st.spectrum(family, at=3.0, certify=True).verdict.word == word


def test_a_third_survives_the_mass_matrix() -> None:
    """M = [[1, 1/3], [1/3, 1]] and a damping that cancels exactly: λ = ± i on one mode."""
    q1, q2, u1, u2 = dynamicsymbols("q1 q2 u1 u2")
    c = symbols("c")
    third = Rational(1, 3)
    mass = sm.Matrix([[1, third], [third, 1]])
    rate = sm.Matrix([third * c * u1 - u1 - q1, -u2 - q2])  # at c = 3 the first is undamped
    model = mass, mass * rate, [q1, q2], [u1, u2]
    system = st.System.from_sympy(model)
    family = st.Family(system, "rest", at=("c",), held=dict.fromkeys(system.states, 0.0))
    found = st.spectrum(family, at=3.0, certify=True)
    assert found.verdict.word == "neutral"
    assert found.abscissa == 0.0


def test_the_angle_of_two_numbers_is_imported_exactly() -> None:
    """The slope of atan2(x + v, 1/3) / 5 at 0 is 3/5 in x and v: λ² + (c - 3/5) λ + 2/5."""
    x, v, c = symbols("x v c")
    angle = sm.atan2(x + v, Rational(1, 3)) / 5
    system = st.System.from_sympy({x: v, v: -x - c * v + angle}, parameters=[c])
    family = st.Family(system, "rest", at=("c",), held={"x": 0.0, "v": 0.0})
    edges = st.boundaries(family, axis=("c", 0.1, 2, 9))
    assert edges.complete
    assert [abs(e.value - 0.6) <= e.error < 1e-15 for e in edges] == [True]
    found = st.spectrum(family, at=Rational(3, 5), certify=True)
    assert found.verdict.word == "neutral"  # exactly at 3/5: a third has stayed a third
    assert found.eigenvalues[1] == pytest.approx(1j * np.sqrt(0.4))


def test_the_angle_has_the_quadrant_of_its_point() -> None:
    x, v = symbols("x v")
    system = st.System.from_sympy({x: sm.atan2(x, v), v: sm.atan2(v, -2) + sm.atan2(5, x)})
    for place in ((1.0, 2.0), (1.0, -2.0), (-1.0, 2.0), (-1.0, -2.0)):
        a, b = place
        expected = [np.arctan2(a, b), np.arctan2(b, -2) + np.arctan2(5, a)]
        assert system.rates(place, []) == pytest.approx(expected)


def test_a_function_that_no_graph_has_goes_in_as_a_plain_function() -> None:
    """The slope of erf at 0 is 2/√π."""

    def rates(x: Any, p: Any) -> Any:
        return np.array([x[1], -x[0] - p[0] * x[1] + mpmath.erf(x[1])], dtype=float)

    system = st.System.from_function(rates, name="s", states=("x", "v"), parameters=("c",))
    family = st.Family(system, "rest", at=("c",), held={"x": 0.0, "v": 0.0})
    assert [st.spectrum(family, at=c).verdict.word for c in (1.12, 1.13)] == ["unstable", "stable"]


@pytest.mark.parametrize(
    "number",
    [sm.pi, sm.E, sqrt(2), sm.log(2), 1 / sm.log(10), sm.GoldenRatio, sm.sin(1), 2**sm.pi],
)
def test_a_number_that_is_no_fraction_is_the_nearest_double_and_said(number: Any) -> None:
    x, p = symbols("x p")
    system = st.System.from_sympy({x: (p - number) * x})
    rest = st.Family(system, "rest", at=("p",), held={"x": 0})
    double = float(number)
    found = st.spectrum(rest, at=sm.Rational(double), certify=True)
    assert found.verdict is st.Verdict.NEUTRAL  # of the equations with the double
    assert f"{number} as {double!r}" in found.reason
    [edge] = st.boundaries(rest, axis=("p", 0, 40, 9))
    with mpmath.workdps(30):
        true = mpmath.mpf(str(number.evalf(30)))
        assert abs(edge.value - true) < 4e-16 * true
    assert system.approximation.endswith(f"{number} as {double!r}")


@pytest.mark.parametrize(
    ("rate", "said"),
    [
        (lambda x: sm.zoo * (x + 1), "no finite real number"),
        (lambda x: sm.I * x, "no finite real number"),
        (lambda x: sm.Piecewise((x, x > 0), (-x, x < -1)), "end it with a piece"),
        (lambda x: sm.gamma(x), "use SymPy's gamma"),
        (lambda x: sm.erf(x), "SymPy's erf;.*System.from_function as a plain Python function, for"),
        (lambda x: sm.atan2(x, 2**60 + 1), "which no double is exactly"),
        (lambda x: dynamicsymbols._t * x, "time itself is none"),
        (lambda x: sm.Function("f")(dynamicsymbols._t).diff() + x, "neither a state nor"),
    ],
)
def test_what_a_graph_does_not_have_is_refused(rate: Callable[[Any], Any], said: str) -> None:
    x = symbols("x")
    with pytest.raises(st.StabilityError, match=said) as told:
        st.System.from_sympy({x: rate(x)})
    assert "\n" not in str(told.value)


def test_a_symbol_that_is_not_listed_is_refused() -> None:
    x, a, b = symbols("x a b")
    with pytest.raises(st.StabilityError, match="'b', which is neither a state nor listed"):
        st.System.from_sympy({x: a * x + b}, parameters=[a])
    assert st.System.from_sympy({x: a * x + b}, parameters=[b, a, "c"]).parameters == (
        "b",
        "a",
        "c",
    )
    assert st.System.from_sympy({x: a * x + b}).parameters == ("a", "b")


@pytest.mark.parametrize("model", [3, None, (1, 2), "kane", (sm.eye(3), sm.ones(3, 1), [1], [2])])
def test_what_is_no_model_is_refused(model: Any) -> None:
    with pytest.raises(st.StabilityError, match=r"give a KanesMethod|mass matrix is 3 x 3"):
        st.System.from_sympy(model)


def test_equations_that_are_not_formed_and_wrong_names_are_refused() -> None:
    q, u = dynamicsymbols("q u")
    n = me.ReferenceFrame("N")
    with pytest.raises(st.StabilityError, match="kanes_equations"):
        st.System.from_sympy(me.KanesMethod(n, [q], [u], [q.diff() - u]))
    with pytest.raises(st.StabilityError, match="form_lagranges_equations"):
        st.System.from_sympy(me.LagrangesMethod(q.diff() ** 2, [q]))
    model = sm.Matrix([1]), sm.Matrix([-u]), [q], [u]
    with pytest.raises(st.StabilityError, match="dependent names 'w'"):
        st.System.from_sympy(model, dependent=[symbols("w")])
    with pytest.raises(st.StabilityError, match="u is no cyclic coordinate|hold it"):
        st.System.from_sympy(model, cyclic=[u])
    with pytest.raises(st.StabilityError, match="cyclic names 'w'"):
        st.System.from_sympy(model, cyclic=["w"])
    with pytest.raises(st.StabilityError, match="singular"):
        st.System.from_sympy((sm.zeros(1, 1), sm.Matrix([-u]), [q], [u]))
    assert st.System.from_sympy(model, cyclic=[q]).states == ("u",)


def test_pivots_avoid_a_zero_that_the_natural_order_meets() -> None:
    """[[sin q, 1], [1, 0]]: natural order divides by sin q, which is 0 at rest."""
    q1, q2, u1, u2 = dynamicsymbols("q1 q2 u1 u2")
    mass = sm.Matrix([[sin(q1), 1], [1, 0]])
    system = st.System.from_sympy((mass, sm.Matrix([-q2, -q1 - u1]), [q1, q2], [u1, u2]))
    found = system.linearise([0, 0, 0, 0], [])
    true = np.zeros((4, 4))
    true[0, 2] = true[1, 3] = 1
    true[2, 0] = true[2, 2] = -1
    true[3, 1] = -1
    assert found == pytest.approx(true, abs=1e-15)


def test_functions_of_sympy_keep_their_values() -> None:
    x, a = symbols("x a")
    rate = sm.sec(x) + sm.cot(a) + sm.Abs(a) + x ** Rational(5, 3) + sm.exp(-x) * tan(x) ** -2
    rate += sm.sech(x) * a ** Rational(-1, 2) + sm.atan(x) / 7 + Rational(2, 3) + a**x
    system = st.System.from_sympy({x: rate})
    place = {x: Rational(3, 4), a: Rational(5, 4)}
    assert system.rates([0.75], [1.25])[0] == pytest.approx(float(rate.subs(place)), rel=1e-14)
    slope = float(rate.diff(x).subs(place))
    assert system.linearise([0.75], [1.25])[0, 0] == pytest.approx(slope, rel=1e-13)


def test_a_chain_of_sympys_models_is_judged() -> None:
    kane = multi_mass_spring_damper(3)
    system = st.System.from_sympy(kane)
    family = st.Family(system, "rest", at=("c0",), held=dict.fromkeys(system.states, 0.0))
    given = {n: 1.0 + 0.25 * i for i, n in enumerate(family.parameters)}
    assert st.spectrum(family, at=0.5, certify=True, **given).verdict.word == "stable"


def test_observables_are_read_too() -> None:
    q, u = dynamicsymbols("q u")
    m = symbols("m")
    model = sm.Matrix([m]), sm.Matrix([-q]), [q], [u]
    system = st.System.from_sympy(model, observables={"energy": m * u**2 / 2 + q**2 / 2})
    assert float(system.observe([0.5, 2.0], [3.0])["energy"]) == 6.125
