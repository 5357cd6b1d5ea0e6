"""A user's own exact polynomial: verdicts are proved from it, and a wrong one is noticed."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import casadi as ca
import numpy as np
import pytest

import stability as st
from stability.algebra.exact.number_fields import EXACT, rational
from stability.algebra.number_types import Algebra
from stability.bodies.disk_polynomials import DiskPolynomial
from stability.polynomials.characteristic import CharacteristicPolynomial
from stability.polynomials.identities import identity
from stability.spectra import verdict_routes
from stability.spectra.problem import Problem, disk_problem

OWN = "from the family's polynomial"


class Damped(st.ExactPolynomial):
    """λ² + d λ + g/l cos(tilt), by hand."""

    def coefficients(self, values: Mapping[str, Any], _: Algebra) -> Sequence[Sequence[Any]]:
        return [[values["g"] / values["l"], values["d"], 1]]


def pendulum(exact: Any = None) -> st.Family:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 3)
    rhs = ca.vertcat(x[1], -p[0] / p[2] * ca.sin(x[0]) - p[1] * x[1])
    system = st.System("pendulum", x, p, rhs, states=("angle", "rate"), parameters=("g", "d", "l"))
    return st.Family(system, "hanging", at=("g",), held={"angle": 0, "rate": 0}, exact=exact)


class Sleeping(st.ExactPolynomial):
    """(A λ² - m)² + (C n)² λ²: the upright top, with A, C, m = weight times length."""

    def coefficients(self, values: Mapping[str, Any], _: Algebra) -> Sequence[Sequence[Any]]:
        a, m, spin = values["A"], values["m"], values["C"] * values["n"]
        return [[m * m, 0, spin * spin - 2 * a * m, 0, a * a]]


def top(exact: Any = None) -> st.Family:
    """Both tilts of the sleeping top, small: A x'' + C n y' - m x = 0, A y'' - C n x' - m y = 0."""
    x, p = ca.SX.sym("x", 4), ca.SX.sym("p", 4)
    a, c, n, m = (p[i] for i in range(4))
    rhs = ca.vertcat(
        x[2:], (m * ca.sin(x[0]) - c * n * x[3]) / a, (m * ca.sin(x[1]) + c * n * x[2]) / a
    )
    names = ("x", "y", "x_dot", "y_dot")
    system = st.System("top", x, p, rhs, states=names, parameters=("A", "C", "n", "m"))
    held = dict.fromkeys(names, 0.0)
    return st.Family(
        system, "sleeping", at=("n",), held=held, conservative=True, exact=exact, typical={"n": 3.0}
    )


@pytest.fixture
def no_graph(monkeypatch: pytest.MonkeyPatch) -> None:
    """The route to proofs that takes the polynomial from the graph, out of order."""

    def broken(*_: Any, **__: Any) -> Any:
        raise AssertionError("the proof comes from the graph")

    monkeypatch.setattr(verdict_routes, "member_at", broken)


TOP = {"A": 1.0, "C": 0.5, "m": 1.0}


@pytest.mark.usefixtures("no_graph")
def test_a_spectrum_is_proved_from_the_users_polynomial() -> None:
    found = st.spectrum(pendulum(Damped()), at=2.0, d=2.0, l=1.0, certify=True)
    assert found.verdict is st.Verdict.STABLE and f"rational arithmetic {OWN}" in found.reason
    assert np.allclose(found.eigenvalues, [-1 - 1j, -1 + 1j], rtol=1e-15)
    undamped = st.spectrum(pendulum(Damped()), at=[2.0, -1.0], d=0.0, l=3.0)
    assert [v.word for v in undamped.verdict] == ["neutral", "unstable"]
    on = st.spectrum(top(Sleeping()), at=[3.999, 4.0, 4.001], **TOP, certify=True)
    assert [v.word for v in on.verdict] == ["unstable", "neutral", "neutral"]
    assert np.all(on.certified)


def test_its_answers_are_those_of_the_graph() -> None:
    rng = np.random.default_rng(4)
    n, m = rng.uniform(1, 6, 40), rng.uniform(-1, 2, 40)
    both = [
        st.spectrum(top(exact), at=n, A=1.0, C=0.5, m=m, certify=True)
        for exact in (None, Sleeping())
    ]
    assert np.array_equal(both[0].codes, both[1].codes) and len(set(both[0].codes)) == 2
    assert np.all(
        np.abs(both[0].eigenvalues - both[1].eigenvalues) <= both[0].radius + both[1].radius
    )
    assert all(OWN in st.spectrum(top(e), at=4.5, **TOP, certify=True).reason for e in [Sleeping()])
    assert OWN not in st.spectrum(top(), at=4.5, **TOP, certify=True).reason


@pytest.mark.parametrize(
    ("family", "axis", "given", "values"),
    [
        (lambda: pendulum(Damped()), ("d", -1.0, 2.0, 9), {"at": 1.0, "l": 1.0}, [0.0]),
        (lambda: pendulum(Damped()), ("g", -1.0, 2.0, 9), {"d": 0.5, "l": 1.0}, [0.0]),
        (lambda: pendulum(Damped()), ("l", -1.0, 2.0, 8), {"at": 1.0, "d": 0.5}, []),
        (lambda: top(Sleeping()), ("n", 0.1, 9.0, 9), TOP, [4.0]),
        (lambda: top(Sleeping()), ("m", -2.0, 9.0, 9), {"at": 6.0, "A": 1.0, "C": 0.5}, [2.25]),
    ],
)
def test_boundaries_are_exact_roots_of_it(family, axis, given, values, monkeypatch) -> None:
    own = family()
    identity(own)  # zeros and symmetry are proved from the graph in any case, and kept

    def broken(*_: Any) -> Any:
        raise AssertionError("the polynomial comes from the graph")

    monkeypatch.setattr(CharacteristicPolynomial, "__init__", broken)
    if axis[0] == "l":
        with pytest.warns(st.StabilityWarning, match="no value there"):
            found = st.boundaries(own, axis=axis, **given)
    else:
        found = st.boundaries(own, axis=axis, **given)
        assert found.complete
    assert [b.value for b in found] == values
    assert found.how.endswith(OWN)


def test_a_map_takes_what_is_open_from_it() -> None:
    ask: dict[str, Any] = {"x": ("d", -1, 1, 3), "y": ("g", -1, 1, 3), "l": 1.0}
    plain, found = (st.stability_map(pendulum(e), **ask) for e in (None, Damped()))
    flags = {
        v: k
        for k, v in zip(found.verdict.flag_values, found.verdict.flag_meanings.split(), strict=True)
    }

    def expected(g: float, d: float) -> str:
        if g < 0 or d < 0:
            return "unstable"
        return "stable" if g > 0 and d > 0 else "neutral"

    decided = found.verdict.values != flags["undecided"]
    assert decided.all()
    assert plain.verdict.equals(found.verdict)  # decided from the graph alone
    for g in found.g.values:
        for d in found.d.values:
            assert found.verdict.sel(g=g, d=d) == flags[expected(g, d)]
    assert "from the family's polynomial" in found.attrs["method"]
    assert "family's" not in plain.attrs["method"]
    st.stability_map(top(Sleeping()), x=("n", 1, 6, 6), y=("m", 0.5, 2, 5), A=1.0, C=0.5)


def test_functions_that_are_not_rational_go_through_balls() -> None:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    system = st.System(
        "swing",
        x,
        p,
        ca.vertcat(x[1], -ca.cos(p[0]) * x[0] - p[1] * x[1]),
        states=("angle", "rate"),
        parameters=("tilt", "d"),
    )

    class Swing(st.ExactPolynomial):
        def coefficients(self, values: Mapping[str, Any], algebra: Algebra) -> Any:
            return [[algebra.functions["cos"](values["tilt"]), values["d"], 1]]

    family = st.Family(system, "rest", at=("tilt",), held={"angle": 0, "rate": 0}, exact=Swing())
    found = [st.spectrum(family, at=t, d=0.25, certify=True) for t in (0.0, 1.5, 2.0, math.pi / 2)]
    assert [f.verdict.word for f in found] == ["stable", "stable", "unstable", "stable"]
    assert "rational arithmetic" in found[0].reason and f"bits {OWN}" in found[1].reason
    assert np.allclose(found[1].eigenvalues.prod(), math.cos(1.5))
    every = st.boundaries(family, axis=("tilt", 0.1, 3.0, 9), d=0.25)
    [edge] = every
    assert every.complete
    assert abs(edge.value - math.pi / 2) < 1e-12


class Carried(st.ExactPolynomial):
    """λ (λ² + d λ + g): the pendulum carries a clock that it turns."""

    zeros = 1

    def coefficients(self, values: Mapping[str, Any], _: Algebra) -> Sequence[Sequence[Any]]:
        return [[values["g"], values["d"], 1]]


def carried(exact: Any = None) -> st.Family:
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p", 2)
    rhs = ca.vertcat(x[2], x[2], -p[0] * ca.sin(x[1]) - p[1] * x[2])
    names = ("clock", "angle", "rate")
    system = st.System("clock", x, p, rhs, states=names, parameters=("g", "d"))
    return st.Family(system, "at rest", at=("clock",), held={"angle": 0, "rate": 0}, exact=exact)


def test_structural_zeros_are_left_out() -> None:
    given: dict[str, Any] = {"at": 0.7, "g": [2.0, -3.0, 0.0625], "d": 0.5}
    both = [st.spectrum(carried(e), **given, certify=True) for e in (None, Carried())]
    assert [v.word for v in both[1].verdict] == ["stable", "unstable", "stable"]
    assert np.array_equal(both[0].codes, both[1].codes) and both[1].structural_zeros == 1
    assert np.array_equal(both[0].eigenvalues, both[1].eigenvalues)
    [edge] = st.boundaries(carried(Carried()), axis=("g", -1, 1, 5), at=0.0, d=0.5)
    assert edge.value == 0 and edge.crossing.word == "static"


def _pendulum(formula: Any, **members: Any) -> Any:
    def coefficients(_: Any, values: Mapping[str, Any], __: Algebra) -> Any:
        return [formula(values["g"] / values["l"], values["d"])]

    return lambda: pendulum(type("Wrong", (Damped,), {"coefficients": coefficients} | members)())


WRONG: dict[str, tuple[Any, str]] = {
    "a sign": (
        _pendulum(lambda g, d: [g, -d, 1]),
        r"is not that of its equations: at g = .* the coefficient of λ\^1 is -",
    ),
    "a factor": (_pendulum(lambda g, d: [2 * g, d, 1]), r"the coefficient of λ\^0 is"),
    "a digit": (
        _pendulum(lambda g, d: [g * (1 + rational(1e-30)), d, 1]),
        "is not that of its equations",
    ),
    "the degree": (_pendulum(lambda g, d: [g, d]), "is not that of its equations"),
    "one too many": (_pendulum(lambda g, d: [0, g, d, 1]), r"coefficient of λ\^0 is 0, that of"),
    "no leading one": (_pendulum(lambda g, d: [g, d, 0]), "is not that of its equations"),
    "zeros": (
        _pendulum(lambda g, d: [g, d, 1], zeros=1),
        "leaves out 1 zeros, and 0 eigenvalues vanish",
    ),
    "no number": (
        _pendulum(lambda g, d: [g, 1.0 * d, 1]),
        "has no value in rational numbers and balls",
    ),
    "conditions": (
        _pendulum(lambda g, d: [g, d, 1], conditions=lambda *_: [("static", 1)]),
        "has conditions or scale without a proof",
    ),
    "a unit": (
        _pendulum(lambda g, d: [g, d, 1], scale=lambda *_: (-1, None)),
        "has conditions or scale without a proof",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_polynomial_is_noticed(name: str) -> None:
    family, said = WRONG[name]
    wrong = family()
    given = {"d": 0.5, "l": 1.0}
    for ask in (
        lambda: st.spectrum(wrong, at=2.0, **given),
        lambda: st.boundaries(wrong, axis=(wrong.at[0], 1.0, 2.0, 5), **given),
        lambda: st.stability_map(
            wrong, x=(wrong.at[0], 1, 2, 3), y=(given.popitem()[0], 1, 2, 3), **given
        ),
    ):
        with pytest.raises(st.StabilityError, match=said):
            ask()


def test_a_polynomial_of_another_sign_or_of_solved_members_is_refused() -> None:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)

    class Plain(st.ExactPolynomial):
        def coefficients(self, values: Mapping[str, Any], _: Algebra) -> Any:
            return [[values["g"], values["d"], 1]]

    rhs = ca.vertcat(x[1], -p[0] * ca.sin(x[0]) - ca.fabs(p[1]) * x[1])
    system = st.System("drag", x, p, rhs, states=("angle", "rate"), parameters=("g", "d"))
    family = st.Family(system, "rest", at=("g",), held={"angle": 0, "rate": 0}, exact=Plain())
    with pytest.raises(st.StabilityError, match=r"d = -.* coefficient of λ\^1 is -"):
        st.spectrum(family, at=1.0, d=0.5)
    family = st.Family(
        system,
        "rest",
        at=("g",),
        held={"rate": 0},
        unknown={"angle": 0.1},
        equations=("rate",),
        exact=Plain(),
    )
    with pytest.raises(st.StabilityError, match="its members are solved for"):
        st.spectrum(family, at=1.0, d=0.5)


def test_what_is_no_polynomial_is_refused() -> None:
    with pytest.raises(st.StabilityError, match=r"exact is 3; give an object"):
        pendulum(3)


def test_it_is_compared_once_for_each_family() -> None:
    calls = []

    class Counted(Damped):
        def coefficients(self, values: Mapping[str, Any], algebra: Algebra) -> Any:
            calls.append(algebra.name)
            return super().coefficients(values, algebra)

    family = pendulum(Counted())
    st.spectrum(family, at=2.0, d=1.0, l=1.0)
    first = len(calls)
    st.spectrum(family, at=3.0, d=1.0, l=1.0)
    assert first == len(calls) > 5


# --- the disk's ---


@pytest.mark.parametrize("law", [st.Viscous(0.3), st.LinearViscous(0.7), st.Smooth(), st.Rough()])
@pytest.mark.parametrize("family", ["rolling", "spinning", "tumbling"])
def test_the_disk_brings_its_own_in_the_users_units(family: str, law: Any) -> None:
    disk = st.Disk(mass=0.3, radius=0.013, gravity=9.81, k=0.27)
    question = disk_problem(family, disk, law, 1.1)
    assert isinstance(question.exact, DiskPolynomial) and not hasattr(question, "point")
    assert question.exact.known.even == question.family.conservative
    given = {n: rational(float(v)) for n, v in question.values.items()}
    if family != "tumbling":
        assert {kind for kind, _ in question.exact.conditions(given, EXACT)} <= {
            "static",
            "flutter",
        }
        degree = sum(len(f) - 1 for f in question.exact.coefficients(given, EXACT))
        assert degree + question.exact.zeros == len(question.family.system.states)


def test_a_problem_knows_no_variables_of_a_body() -> None:
    assert not {"point", "scale"} & set(dir(Problem))
