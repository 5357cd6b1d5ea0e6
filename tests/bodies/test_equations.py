"""The disk's equations of motion against derivations of their own: Kane's method and fixed axes.

Two kinds of evidence.  Exact: the package's graph is read as rational functions of
t = tan(theta/2) and of the other states, and must satisfy Kane's equations (SymPy's KanesMethod)
with remainder zero, for all four contact laws; no tolerance is involved.  Numerical: both oracles
of `kane_disk` at random states, complex-step Jacobians, and five motions computed elsewhere.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
import sympy as sp
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from kane_disk import LAWS, ORACLES, Solution, kane_system
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from stability.algebra.number_types import Algebra, sympy_algebra
from stability.algebra.program import Program
from stability.base.errors import DomainError
from stability.bodies.thin_disk import disk_system
from stability.systems.system import System

Array = NDArray[np.float64]
LONG = [pytest.param(law, marks=pytest.mark.long) for law in ("smooth", "linear-viscous")]
EXACT = ["viscous", "rough", *LONG]
"""Laws; Kane's equations of two are derived in the fast tests, those in fixed axes of all four."""
PAIRS = [(law, "fixed axes") for law in LAWS] + [
    pytest.param(law, "kane", marks=pytest.mark.long if law in ("smooth", "linear-viscous") else ())
    for law in LAWS
]
"""A law, and the oracle that judges it."""
TRAJECTORIES = Path(__file__).parents[1] / "data" / "trajectories.json"

# --------------------------------------------------------------------------- exact identities

FIELD = sp.QQ.frac_field(*sp.symbols("t f theta_dot phi_dot omega3 slip_x slip_y k mu"))
HALF, TURN, THETA_DOT, PHI_DOT, OMEGA3, SLIP_X, SLIP_Y, K, MU = FIELD.gens
SIN, COS = 2 * HALF / (1 + HALF**2), (1 - HALF**2) / (1 + HALF**2)
"""sin theta and cos theta; t in (0, oo) is theta in (0, pi), and t = 1 is the disk upright."""
SIN_PHI, COS_PHI = 2 * TURN / (1 + TURN**2), (1 - TURN**2) / (1 + TURN**2)
THETA = object()
STATES = (THETA, THETA_DOT, PHI_DOT, OMEGA3, SLIP_X, SLIP_Y)


def _number(value: float) -> Any:
    return FIELD.from_QQ(sp.QQ(*float(value).as_integer_ratio()), sp.QQ)


RATIONAL = Algebra("rational functions", _number, {"sin": lambda _: SIN, "cos": lambda _: COS})


def slope(value: Any, state: int) -> Any:
    """Exact partial derivative of a field element; dt/dtheta = (1 + t^2)/2."""
    if state == 0:
        return FIELD(value).diff(HALF) * (1 + HALF**2) / 2
    return FIELD(value).diff(STATES[state])


@dataclass(frozen=True)
class Exact:
    """The package's graph of one law as field elements; `full` has the two slip rates as well."""

    system: System
    rates: list[Any]
    full: list[Any]
    seen: dict[str, list[Any]]
    slip: tuple[Any, Any]


def arguments(system: System) -> list[list[Any]]:
    """Symbols for the states and parameters of a system."""
    return [list(STATES[: len(system.states)]), [K, MU][: len(system.parameters)]]


def read(system: System) -> tuple[list[Any], dict[str, list[Any]]]:
    """Rates and observables of a system as rational functions."""
    rates, *seen = [
        [FIELD(entry) for column in zip(*rows, strict=True) for entry in column]
        for rows in _dense(system.function, arguments(system))
    ]
    return rates, dict(zip(system.observables, seen, strict=True))


def _dense(function: ca.Function, values: Sequence[Sequence[Any]]) -> list[list[list[Any]]]:
    program = Program(function)
    return [program.dense(RATIONAL, values, output) for output in range(function.n_out())]


@lru_cache
def exact(law: str) -> Exact:
    """Read one law; a smooth disk's slip rates are those of its six-state form."""
    system = disk_system(law)
    rates, seen = read(system)
    zero = FIELD.zero
    if law == "smooth":
        full, _ = read(disk_system(law, slip_states=True))
        return Exact(system, rates, full, seen, (SLIP_X, SLIP_Y))
    if law == "rough":
        return Exact(system, rates, [*rates, zero, zero], seen, (zero, zero))
    return Exact(system, rates, rates, seen, (SLIP_X, SLIP_Y))


def point(graph: Exact, k: Any = K) -> list[Any]:
    """Arguments of the Kane functions, at any yaw."""
    return [SIN, COS, SIN_PHI, COS_PHI, THETA_DOT, PHI_DOT, OMEGA3, *graph.slip, k, MU]


def remainders(law: str, k: Any = K) -> list[Any]:
    """Kane's equations with the package's accelerations and forces put in; k is Kane's k."""
    graph, system = exact(law), kane_system(law)
    at = point(graph, k)
    unknowns = [*system.unknown(*at, *graph.full), *graph.seen["normal_force"]]
    unknowns += graph.seen["contact_force"]
    return [
        sum((entry * value for entry, value in zip(row, unknowns, strict=True)), FIELD.zero) - right
        for row, right in zip(system.matrix(*at), system.forcing(*at), strict=True)
    ]


@pytest.mark.parametrize("law", EXACT)
def test_rates_and_forces_satisfy_kanes_equations_identically(law: str) -> None:
    """All eight of SymPy's equations, at every state and yaw: remainder exactly zero."""
    found = remainders(law)
    assert len(found) == 8
    assert all(value == 0 for value in found)
    assert exact(law).rates[0] == THETA_DOT


@pytest.mark.parametrize("law", EXACT)
def test_kanes_matrix_is_singular_only_where_the_determinant_is_zero(law: str) -> None:
    """So the solution of Kane's equations is unique: det = +- 2 k^2 D (k + 1 when rough)."""
    drag = MU * SLIP_X * SIN * COS if law == "viscous" else 0
    value = K + 1 if law == "rough" else K + COS**2 - drag
    expected = value * (K * (2 * K + 1) if law == "rough" else 2 * K**2)
    rows = kane_system(law).matrix(*point(exact(law)))
    assert determinant(rows) in (expected, -expected)
    assert exact(law).seen["determinant"] == [value]


def determinant(rows: Sequence[Sequence[Any]]) -> Any:
    """Exact determinant of field elements by elimination."""
    left, value = [[FIELD(entry) for entry in row] for row in rows], FIELD.one
    while left:
        pivot = next((i for i, row in enumerate(left) if row[0] != 0), None)
        if pivot is None:
            return FIELD.zero
        top = left.pop(pivot)
        value *= top[0] * (-1) ** pivot
        left = [
            [b - row[0] / top[0] * a for a, b in zip(top[1:], row[1:], strict=True)] for row in left
        ]
    return value


@pytest.mark.parametrize("law", EXACT)
def test_the_smooth_and_rough_four_states_need_no_slip(law: str) -> None:
    """The four-state rates are those of the six-state form, and no slip enters them."""
    graph = exact(law)
    if len(graph.system.states) == 4:
        assert graph.rates == graph.full[:4]
        assert all(slope(value, j) == 0 for value in graph.rates for j in (4, 5))
    else:
        assert any(slope(value, 4) != 0 for value in graph.rates)


@pytest.mark.long
@pytest.mark.parametrize("law", EXACT)
def test_energy_is_the_rigid_bodys_identically(law: str) -> None:
    """SymPy's RigidBody.kinetic_energy plus height; the smooth four-state disk's centre rests."""
    graph = exact(law)
    at = point(graph)
    if law == "smooth":
        at[7:9] = [-THETA_DOT * SIN, OMEGA3]
    assert graph.seen["energy"] == [kane_system(law).energy(*at)]


@pytest.mark.parametrize("law", EXACT)
def test_energy_falls_at_the_dissipated_power_identically(law: str) -> None:
    """dE/dt + P = 0 as rational functions, P the power of the contact force on the slip."""
    graph = exact(law)
    (energy,), (power,) = graph.seen["energy"], graph.seen["power"]
    flow = [slope(energy, j) * rate for j, rate in enumerate(graph.rates)]
    assert sum(flow, FIELD.zero) + power == 0
    law_power = {
        "smooth": FIELD.zero,
        "viscous": MU * graph.seen["normal_force"][0] * (SLIP_X**2 + SLIP_Y**2),
        "linear-viscous": MU * (SLIP_X**2 + SLIP_Y**2),
        "rough": FIELD.zero,
    }
    assert power == law_power[law]


@pytest.mark.long
def test_energy_falls_at_the_dissipated_power_in_sympys_own_calculus() -> None:
    """The same for the paper's law through `sympy_algebra` and sympy.diff, sin and cos replaced."""
    system = disk_system("viscous")
    states, parameters = sp.symbols("theta td pd w3 vx vy"), sp.symbols("k mu")
    outputs = Program(system.function).run(sympy_algebra(), [states, parameters])
    rates, *seen = outputs
    named = dict(zip(system.observables, seen, strict=True))
    energy, power = named["energy"][0], named["power"][0]
    balance = sum(sp.diff(energy, x) * rate for x, rate in zip(states, rates, strict=True)) + power
    t = sp.Symbol("t")
    rational = {sp.sin(states[0]): 2 * t / (1 + t**2), sp.cos(states[0]): (1 - t**2) / (1 + t**2)}
    assert balance.has(sp.sin)
    field = sp.QQ.frac_field(t, *states[1:], *parameters)
    assert field.from_sympy(balance.subs(rational)) == 0
    assert field.from_sympy((balance + power / 10**9).subs(rational)) != 0


@pytest.mark.parametrize("law", ["rough", pytest.param("viscous", marks=pytest.mark.long), *LONG])
def test_jacobian_graph_is_the_exact_derivative_identically(law: str) -> None:
    """CasADi's Jacobian = the derivative of the rates that Kane's equations fix, entry by entry.

    At t = 1 this is the Jacobian at theta = pi/2 exactly, where no double is.
    """
    graph = exact(law)
    system = graph.system
    function = ca.Function("jacobian", [system.x, system.p], [system.jacobian])
    (rows,) = _dense(function, arguments(system))
    for rate, row in zip(graph.rates, rows, strict=True):
        for j, entry in enumerate(row):
            assert entry == slope(rate, j)


def test_viscous_mass_determinant_is_two_k_squared_sine_times_d() -> None:
    """det(mass) = +- 2 k^2 sin theta (k + cos^2 - mu slip_x sin cos), the shared fact, exactly."""
    system = disk_system("viscous")
    assert system.mass is not None
    (rows,) = _dense(ca.Function("mass", [system.x, system.p], [system.mass]), arguments(system))
    expected = 2 * K**2 * SIN * (K + COS**2 - MU * SLIP_X * SIN * COS)
    assert determinant(rows) in (expected, -expected)


def test_rolling_disc_at_sympys_critical_spin_has_all_eigenvalues_zero() -> None:
    """SymPy's own Kane test (rolling disc): zero eigenvalues at spin 1/sqrt(3), k = 1/4, rough.

    Exact matrix at theta = pi/2; for any k and spin w the polynomial is z^4 + b z^2 with b zero
    just at w^2 = 1/(2 (2k+1)), and it is z^4 at the published point.
    """
    system = disk_system("rough")
    program = Program(ca.Function("jacobian", [system.x, system.p], [system.jacobian]))
    k, w, z = sp.symbols("k w z", positive=True)

    def polynomial(spin: Any, inertia: Any) -> sp.Poly:
        state = [sp.pi / 2, sp.Integer(0), sp.Integer(0), spin]
        matrix = sp.Matrix(program.dense(sympy_algebra(), [state, [inertia]]))
        return sp.Poly(sp.expand((z * sp.eye(4) - matrix).det(method="berkowitz")), z)

    assert polynomial(1 / sp.sqrt(3), sp.Rational(1, 4)) == sp.Poly(z**4, z)
    assert polynomial(1 / sp.sqrt(3), sp.Rational(1, 3)) != sp.Poly(z**4, z)
    assert polynomial(sp.Rational(1, 2), sp.Rational(1, 4)) != sp.Poly(z**4, z)
    one, zero, b, *rest = polynomial(w, k).all_coeffs()
    assert (one, sp.simplify(zero), [sp.simplify(e) for e in rest]) == (1, 0, [0, 0])
    assert sp.solve(sp.numer(sp.together(b)), w) == [sp.solve(2 * (2 * k + 1) * w**2 - 1, w)[0]]


# --------------------------------------------------------------------------- random states


@dataclass(frozen=True)
class Sample:
    """States inside the stated domain, with six columns for the oracles, and a yaw for each."""

    x: Array
    p: Array
    phi: Array

    def of(self, system: System) -> tuple[Array, Array]:
        """States and parameters as the package takes them."""
        return self.x[..., : len(system.states)], self.p[..., : len(system.parameters)]


def within(law: str, x: Array) -> Array:
    """Six columns that suit the law: no slip when rough; when smooth, the centre at rest."""
    full = x.copy()
    if law == "rough":
        full[..., 4:] = 0.0
    if law == "smooth":
        full[..., 4], full[..., 5] = -x[..., 1] * np.sin(x[..., 0]), x[..., 3]
    return full


@lru_cache
def sample(law: str, size: int = 1000, seed: int = 20160204) -> Sample:
    """Random states with sin theta > 0.05 and, for the viscous law, D > 0.1."""
    rng = np.random.default_rng([seed, LAWS.index(law)])
    x = np.stack(
        [
            rng.uniform(0.0505, np.pi - 0.0505, size),
            *rng.uniform(-3, 3, (3, size)),
            *rng.uniform(-1.5, 1.5, (2, size)),
        ],
        axis=-1,
    )
    x[::20, 0] = np.pi / 2
    p = np.stack([rng.uniform(0.05, 0.5, size), 10 ** rng.uniform(-3, 1.5, size)], axis=-1)
    sine, cosine = np.sin(x[:, 0]), np.cos(x[:, 0])
    margin = p[:, 0] + cosine**2 - p[:, 1] * x[:, 4] * sine * cosine
    keep = (sine > 0.05) & ((margin > 0.1) | (law != "viscous"))
    x, p = within(law, x[keep]), p[keep]
    return Sample(x, p, rng.uniform(-np.pi, np.pi, len(x)))


def scale_of(oracle: str, found: Solution) -> Array:
    """Divide deviations by max(1, |N|); for fixed axes by the largest rate where that is more.

    Near the plane the rates grow as 1/sin theta while N does not, and the fixed-axes oracle's own
    last steps subtract terms of the size of the rates (divided by sin^2 theta), so its round-off
    is proportional to them.  Kane's needs no such allowance.
    """
    scale = np.maximum(1.0, np.abs(found.normal_force))
    if oracle == "fixed axes":
        scale = np.maximum(scale, np.abs(found.rates).max(axis=-1))
    return scale


def deviations(law: str, oracle: str, stretch_k: float = 0.0) -> dict[str, float]:
    """Largest scaled deviation of each output; the package is given k (1 + stretch_k)."""
    system, where = disk_system(law), sample(law)
    x, p = where.of(system)
    p = p * np.array([1 + stretch_k, 1.0][: p.shape[-1]])
    rates, seen = system.rates(x, p), system.observe(x, p)
    found = ORACLES[oracle](law, where.x, where.p, where.phi)
    scale = scale_of(oracle, found)
    gaps = {
        "rates": np.abs(rates - found.rates[:, : rates.shape[-1]]).max(axis=-1),
        "normal_force": np.abs(seen["normal_force"] - found.normal_force),
        "contact_force": np.abs(seen["contact_force"] - found.contact_force).max(axis=-1),
        "energy": np.abs(seen["energy"] - found.energy),
        "power": np.abs(seen["power"] - found.power),
    }
    return {name: float((gap / scale).max()) for name, gap in gaps.items()}


BOUND = 1e-12


@pytest.mark.parametrize(("law", "oracle"), PAIRS)
def test_rates_forces_and_energy_agree_with_the_oracle(law: str, oracle: str) -> None:
    """To 1e-12 of `scale_of`, at some 1000 random states and yaws."""
    assert len(sample(law).x) >= 200
    found = deviations(law, oracle)
    assert max(found.values()) < BOUND, found


@pytest.mark.parametrize(("law", "oracle"), PAIRS)
def test_six_rates_of_the_oracles_keep_the_law(law: str, oracle: str) -> None:
    """The oracle itself: a rough contact stays at rest, and the smooth slip form agrees."""
    where = sample(law)
    found = ORACLES[oracle](law, where.x, where.p, where.phi)
    if law == "rough":
        assert np.abs(found.rates[:, 4:]).max() < BOUND
    if law == "smooth":
        x = where.x.copy()
        x[:, 4:] += where.x[:, 1:3]
        rates = disk_system(law, slip_states=True).rates(x, where.p[:, :1])
        free = ORACLES[oracle](law, x, where.p, where.phi)
        gap = np.abs(rates - free.rates).max(axis=-1) / scale_of(oracle, free)
        assert gap.max() < BOUND


UNIT = st.floats(-3.0, 3.0, allow_subnormal=False)


@pytest.mark.parametrize("law", ["rough", pytest.param("viscous", marks=pytest.mark.long), *LONG])
@settings(derandomize=True, max_examples=40, deadline=None)
@given(
    theta=st.one_of(st.just(np.pi / 2), st.floats(0.06, np.pi - 0.06)),
    speeds=st.tuples(UNIT, UNIT, UNIT, UNIT, UNIT),
    k=st.floats(0.01, 0.5),
    mu=st.floats(0.0009765625, 40.0),
)
def test_rates_agree_with_kane_at_states_that_hypothesis_chooses(
    law: str, theta: float, speeds: tuple[float, ...], k: float, mu: float
) -> None:
    """Zeros, equal speeds and the upright disk among them; sin theta > 0.05 and D > 0.1."""
    x, p = np.array([theta, *speeds]), np.array([k, mu])
    x = within(law, x)
    drag = mu * x[4] * np.sin(theta) if law == "viscous" else 0.0
    strength = k + np.cos(theta) ** 2 - drag * np.cos(theta)
    assume(law == "rough" or strength > 0.1)
    system = disk_system(law)
    rates = system.rates(x[: len(system.states)], p[: len(system.parameters)])
    found = ORACLES["kane"](law, x, p)
    gap = np.abs(rates - found.rates[: len(rates)]).max()
    assert gap <= BOUND * scale_of("kane", found)


@pytest.mark.parametrize("law", LAWS)
def test_states_outside_the_domain_are_refused(law: str) -> None:
    """Theta at or beyond 0 and pi for every law, and D <= 0 for the viscous one alone."""
    system = disk_system(law)
    p = np.array([0.25, 0.3])[: len(system.parameters)]
    rest = np.zeros(len(system.states) - 1)
    for theta in (-1e-3, 0.0, np.nextafter(np.pi, 4.0), np.pi + 1e-3):
        with pytest.raises(DomainError):
            system.rates(np.array([theta, *rest]), p)
    for theta in (1e-3, np.pi - 1e-3):
        assert np.isfinite(system.rates(np.array([theta, *rest]), p)).all()
    if len(system.states) == 6:
        k, theta = 0.25, np.pi / 4  # D = 3/4 - mu slip_x / 2
        for slip_x, inside in ((1.499, True), (1.501, False)):
            x, p = np.array([theta, 0, 0, 0, slip_x, 0]), np.array([k, 1.0])
            if inside or law != "viscous":
                assert np.isfinite(system.rates(x, p)).all()
            else:
                with pytest.raises(DomainError):
                    system.rates(x, p)


# --------------------------------------------------------------------------- Jacobians


def complex_step(law: str, oracle: Callable[..., Solution], where: Sample, size: int) -> Array:
    """Jacobian of an oracle's rates: imaginary part at x + 1e-30 i, no subtraction at all.

    The slip states of the four-state laws are held fixed: they enter none of the four rates.
    """
    columns = []
    for j in range(size):
        x = where.x.astype(complex)
        x[:, j] += 1e-30j
        columns.append(oracle(law, x, where.p, where.phi).rates[:, :size].imag / 1e-30)
    return np.stack(columns, axis=-1)


def jacobian_gap(law: str, oracle: str, where: Sample, stretch_k: float = 0.0) -> float:
    """Largest deviation of `linearise`, over max(1, largest entry of the Jacobian)."""
    system = disk_system(law)
    x, p = where.of(system)
    found = complex_step(law, ORACLES[oracle], where, len(system.states))
    p = p * np.array([1 + stretch_k, 1.0][: p.shape[-1]])
    scale = np.maximum(1.0, np.abs(found).max(axis=(-1, -2)))
    return float((np.abs(system.linearise(x, p) - found).max(axis=(-1, -2)) / scale).max())


def upright(law: str) -> Sample:
    """States at the double nearest pi/2: rolling, spinning and anything else."""
    where = sample(law)
    x, p = where.x[:60].copy(), where.p[:60]
    x[:, 0] = np.pi / 2
    x[:20, 1:3] = 0.0
    x[20:40, [1, 3]] = 0.0
    x[:40, 4:] = 0.0
    return Sample(within(law, x), p, where.phi[:60])


@pytest.mark.parametrize(("law", "oracle"), PAIRS)
def test_jacobian_agrees_with_the_oracles_complex_step(law: str, oracle: str) -> None:
    """To 1e-9 of the largest entry (at least 1), rolling and spinning states included."""
    assert max(jacobian_gap(law, oracle, where) for where in (sample(law), upright(law))) < 1e-9


# --------------------------------------------------------------------------- motions

MOTIONS = json.loads(TRAJECTORIES.read_text(encoding="utf-8"))["motions"]
BEGUN = MOTIONS[0] | {key: MOTIONS[0][key][:2] for key in ("times", "states")}
"""One of them up to its second time."""


def meet(motion: dict[str, Any], stretch_k: float = 0.0) -> float:
    """Largest absolute deviation from a stored motion."""
    system = disk_system("viscous")
    p = np.array([motion["k"] * (1 + stretch_k), motion["mu"]])
    times = [0.0, *motion["times"]]
    found = solve_ivp(
        lambda _, x: system.rates(x, p),
        (0.0, times[-1]),
        np.array(motion["start"], dtype=float),
        method="DOP853",
        t_eval=times,
        rtol=1e-12,
        atol=1e-13,
    )
    assert found.success
    return float(np.abs(found.y.T[1:] - np.array(motion["states"])).max())


@pytest.mark.parametrize(
    "motion", [BEGUN, *[pytest.param(m, marks=pytest.mark.long) for m in MOTIONS]]
)
def test_viscous_motion_meets_the_inertial_frame_trajectory(motion: dict[str, Any]) -> None:
    """To 1e-9 absolute in all six states at every stored time."""
    assert meet(motion) < 1e-9


# --------------------------------------------------------------------------- the checks can fail


@pytest.mark.few(1)
@pytest.mark.parametrize("law", EXACT)
def test_identity_check_sees_a_ninth_digit_of_k(law: str) -> None:
    """Kane's equations with k (1 + 1e-9) leave a remainder."""
    assert any(value != 0 for value in remainders(law, K * (1 + sp.QQ(1, 10**9))))


@pytest.mark.parametrize(("law", "oracle"), PAIRS)
def test_rate_check_sees_a_ninth_digit_of_k(law: str, oracle: str) -> None:
    """The package with k (1 + 1e-9) is caught, in the rates and in the normal force."""
    found = deviations(law, oracle, stretch_k=1e-9)
    assert found["rates"] > 10 * BOUND
    assert found["normal_force"] > 10 * BOUND


@pytest.mark.parametrize("law", EXACT)
def test_jacobian_check_sees_an_eighth_digit_of_k(law: str) -> None:
    """The package with k (1 + 1e-7) is caught at the bound of 1e-9."""
    assert jacobian_gap(law, "kane", sample(law), stretch_k=1e-7) > 1e-9


def test_motion_check_sees_an_eighth_digit_of_k() -> None:
    """A stored motion with k (1 + 1e-8) is missed by more than 1e-9."""
    assert meet(BEGUN, stretch_k=1e-8) > 1e-9


@pytest.mark.parametrize("oracle", [pytest.param("kane", marks=pytest.mark.long), "fixed axes"])
def test_oracles_of_different_laws_are_told_apart(oracle: str) -> None:
    """The viscous law is not the linear one with the same coefficient (N = 1 aside)."""
    where = sample("viscous")
    one, other = (ORACLES[oracle](law, where.x, where.p) for law in ("viscous", "linear-viscous"))
    assert np.abs(one.rates - other.rates).max(axis=-1).min() > 10 * BOUND
