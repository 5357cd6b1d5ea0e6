"""Systems from CasADi functions, live or from a file."""

import runpy
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import stability as st

ROOT = Path(__file__).resolve().parents[2]


def swing(kind: type) -> ca.Function:
    x, p = kind.sym("x", 2), kind.sym("p", 2)
    rates = ca.vertcat(x[1], -p[0] * ca.sin(x[0]) - p[1] * x[1])
    energy = x[1] ** 2 / 2 - p[0] * ca.cos(x[0])
    return ca.Function("swing", [x, p], [rates, energy], ["x", "p"], ["rates", "energy"])


NAMES = {"states": ("angle", "rate"), "parameters": ("g", "c")}


@pytest.mark.parametrize("kind", [ca.SX, ca.MX])
@pytest.mark.parametrize("stored", [False, True])
def test_a_casadi_function_becomes_a_system(kind: type, stored: bool, tmp_path: Path) -> None:
    function: ca.Function | Path = swing(kind)
    if stored:
        path = tmp_path / "swing.casadi"
        swing(kind).save(str(path))
        function = path
    system = st.System.from_function(function, **NAMES)
    assert isinstance(system, st.System)
    assert system.name == "swing"
    place = [0.5, 0.25], [9.0, 0.5]
    assert system.rates(*place) == pytest.approx([0.25, -9 * np.sin(0.5) - 0.125], rel=1e-15)
    true = [[0, 1], [-9 * np.cos(0.5), -0.5]]
    assert system.linearise(*place) == pytest.approx(np.array(true), rel=1e-15)
    assert float(system.observe(*place)["energy"]) == pytest.approx(1 / 32 - 9 * np.cos(0.5))
    family = st.Family(system, "rest", at=("c",), held={"angle": 0.0, "rate": 0.0})
    # λ² + λ/2 + 9: a proof from the file's graph
    found = st.spectrum(family, at=0.5, g=9.0, certify=True)
    assert found.verdict.word == "stable"
    assert found.eigenvalues.imag.max() == pytest.approx(np.sqrt(9 - 1 / 16), rel=1e-15)


def test_names_come_from_the_inputs() -> None:
    x, g = ca.SX.sym("a", 2), ca.SX.sym("b")
    function = ca.Function("f", [x, g], [ca.vertcat(x[1], -g * x[0])], ["x", "g"], ["rates"])
    system = st.System.from_function(function, name="spring", units={"g": "1/s2"})
    assert (system.states, system.parameters) == (("x_0", "x_1"), ("g",))
    assert system.name == "spring"
    alone = ca.Function("f", [x], [ca.vertcat(x[1], -x[0])], ["x"], ["rates"])
    assert st.System.from_function(alone).parameters == ()


def test_constants_of_the_function_are_not_joined() -> None:
    """0.1 (3 x) - 0.3 x over Q; CasADi may join 0.1 · 3 to another double."""
    x = ca.SX.sym("x")
    before = ca.GlobalOptions.getSimplificationOnTheFly()
    ca.GlobalOptions.setSimplificationOnTheFly(False)
    try:
        function = ca.Function("f", [x], [0.1 * (3 * x) - 0.3 * x])
    finally:
        ca.GlobalOptions.setSimplificationOnTheFly(before)
    system = st.System.from_function(function)
    assert ca.GlobalOptions.getSimplificationOnTheFly() == before
    family = st.Family(system, "rest", at=("i0",), held={})
    found = st.spectrum(family, at=0.0, certify=True)
    true = 3 * Fraction(0.1) - Fraction(0.3)
    assert found.verdict.word == "unstable"
    assert found.abscissa == float(true)
    assert float(true) != 0.1 * 3 - 0.3


def test_functions_that_do_not_fit_are_refused() -> None:
    x, y, z = (ca.MX.sym(n, 2) for n in "xyz")
    for function, said in (
        (ca.Function("f", [x, y, z], [x]), r"3 inputs \(i0, i1, i2\)"),
        (ca.Function("f", [x], [x[0]]), "rates of 1 x 1 for 2 states"),
        (ca.Function("f", [x], []), "0 outputs"),
        (ca.Function("f", [ca.SX.sym("m", 2, 2)], [ca.SX(2, 1)]), "i0 .*is 2 x 2"),
    ):
        with pytest.raises(st.StabilityError, match=said):
            st.System.from_function(function)
    with pytest.raises(st.StabilityError, match="x has 2 entries but the names are"):
        st.System.from_function(swing(ca.SX), states=("a",))
    with pytest.raises(st.StabilityError, match="give a CasADi Function"):
        st.System.from_function(3)


X, P = ca.MX.sym("x", 2), ca.MX.sym("p")
MASS = ca.blockcat([[2 + X[0] ** 2, 1], [0.5, 3 + P]])
SQUARE = ca.Function("square", [s := ca.MX.sym("s")], [s**2])
PULL = ca.Function("pull", [X, P], [-P * X[0] * X[1]])
MX_RATES: dict[str, Callable[[], ca.MX]] = {
    "if_else": lambda: -ca.if_else(X[0] > 1, X[1], 2 * X[1]) * X,
    "if_else that calls": lambda: X * ca.if_else(P > 0.5, PULL(X, P), -X[1], True),
    "conditional on a comparison": lambda: -ca.conditional(P > 0.5, [X[1]], 2 * X[1], True) * X,
    "conditional on a number": lambda: -ca.conditional(2 * P, [X[1], 3 * X[0]], 2 * X[1]) * X,
    "map": lambda: -ca.sum2(SQUARE.map(2)(X.T)) * X,
    "call": lambda: X * PULL(X, P),
    "sparse": lambda: -(ca.MX(ca.DM(ca.Sparsity.lower(2), [1.0, 2, 3])) @ X),
    "solve": lambda: -ca.solve(MASS, X),
    "solve transposed": lambda: -ca.solve(MASS.T, X),
    "inverse": lambda: -(ca.inv(MASS) @ X),
    "determinant": lambda: -ca.det(MASS) * X,
    "norms": lambda: -ca.norm_2(X) * X - ca.norm_inf(X) - ca.norm_1(X),
    "reshape": lambda: ca.reshape(ca.horzcat(-X[0], -P * X[1]), 2, 1),
    "sumsqr": lambda: -ca.sumsqr(X) * X,
    "maxima": lambda: -ca.fmin(P, X[0]) * X - ca.mmax(X) * ca.fmax(X[1], 0.125),
    "logsumexp": lambda: -ca.logsumexp(X) * X,
    "split": lambda: ca.vertcat(*ca.vertsplit(-X)[::-1]),
    "diagonal blocks": lambda: -(ca.diagcat(X[0], MASS)[1:, 1:] @ X),
}


@pytest.mark.parametrize("name", MX_RATES)
def test_mx_graphs_have_the_values_and_slopes_of_casadi(name: str) -> None:
    rates = MX_RATES[name]()
    function = ca.Function("rates", [X, P], [rates, ca.jacobian(rates, X)])
    system = st.System.from_function(ca.Function("f", [X, P], [rates], ["x", "p"], ["rates"]))
    chance = np.random.default_rng(8)
    for _ in range(20):
        place = chance.uniform(0.1, 2, 2), [chance.uniform(0.1, 0.9)]
        value, slope = (np.array(ca.densify(v)) for v in function(*place))
        assert system.rates(*place) == pytest.approx(value.ravel(), rel=1e-12, abs=1e-13)
        assert system.linearise(*place) == pytest.approx(slope, rel=1e-11, abs=1e-12)


@pytest.mark.parametrize("mass", [[[0.1, 3.0], [7.0, 0.0]], [[0.1, 0.3], [0.7, 0.2]]])
def test_a_solution_by_mx_is_exact_or_says_that_it_is_rounded(mass: list[list[float]]) -> None:
    """M⁻¹ M x - x vanishes for all x, if no quotient is rounded."""
    x = ca.MX.sym("x", 3)
    matrix = ca.MX(ca.DM(mass))
    rates = ca.vertcat(ca.solve(matrix, matrix @ x[:2]) - x[:2], -x[2])
    system = st.System.from_function(ca.Function("f", [x], [rates], ["x"], ["rates"]))
    assert np.abs(system.rates([0.5, 0.25, 1.0], [])[:2]).max() < 1e-15
    if "rounded to doubles" in system.approximation:
        assert mass[1][1]
        return
    family = st.Family(system, "rest", at=("x_2",), held={"x_0": 0.5, "x_1": 0.25})
    found = st.spectrum(family, at=0.0, certify=True)
    assert found.structural_zeros == 2 and found.eigenvalues.tolist() == [-1]


def test_functions_without_a_scalar_graph_are_refused() -> None:
    x = ca.MX.sym("x")
    solver = ca.integrator("I", "cvodes", {"x": x, "ode": -x}, 0, 1)
    knots, coefficients = [[0, 0, 0, 0, 1, 2, 3, 3, 3, 3]], ca.DM([1, 2, 3, 4, 5, 6])
    for rate, said in (
        (solver(x0=x)["xf"], "it is an integrator, a root-finder or outside code"),
        (ca.bspline(x, coefficients, knots, [3], 1, {}), "an operation that CasADi does not write"),
        (ca.low(ca.DM([0, 1, 2]), x), "an operation that CasADi does not write out"),
    ):
        with pytest.raises(st.StabilityError, match="is no graph of smooth elementary.*" + said):
            st.System.from_function(ca.Function("g", [x], [rate]))
    with pytest.raises(st.StabilityError, match="x is a MX; .* Function of MX to System.from_"):
        st.System("mx", x, x, -x, states=("x",))  # type: ignore[arg-type]


def test_wrong_files_are_refused_in_one_sentence(tmp_path: Path) -> None:
    good = tmp_path / "good.casadi"
    swing(ca.MX).save(str(good))
    cut = good.read_bytes()
    for name, content in {
        "text": b"hello",
        "empty": b"",
        "cut": cut[: len(cut) // 2],
        "zeros": bytes(200),
    }.items():
        path = tmp_path / name
        path.write_bytes(content)
        with pytest.raises(st.StabilityError, match="is no file of a CasADi function") as told:
            st.System.from_function(str(path))
        assert "\n" not in str(told.value)
    for path in (tmp_path, tmp_path / "none"):
        with pytest.raises(st.StabilityError, match="cannot be read"):
            st.System.from_function(path)


def test_the_example_runs(capsys: pytest.CaptureFixture[str]) -> None:
    runpy.run_path(str(ROOT / "examples" / "from_functions.py"))
    first, second = capsys.readouterr().out.splitlines()
    assert first.startswith("largest real part -0.25")
    assert "not proved" in second
