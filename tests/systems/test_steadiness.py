"""Roots at zero are met, what changes is not steady, and no member of the disk is refused."""

import math
from typing import Any

import casadi as ca
import numpy as np
import pytest

import stability as st
from stability.systems.members import rate_noise

X, P = ca.SX.sym("x", 2), ca.SX.sym("p")
Y = X[0]
AT_ZERO: dict[str, Any] = {
    "linear": -P * Y,
    "cubic": -P * Y + Y**3,
    "sine": -P * ca.sin(Y),
    "tanh": -ca.tanh(Y) * P,
    "one less p": -(Y - (P - 1)),
    "two roots": Y * (Y - 1) * P,
    "exp": 1 - ca.exp(P * Y),
    "slow": -1e-8 * P * Y,
    "fast": -1e8 * ca.sin(Y) * P,
    "differences": (2 + Y) * (2 + Y) - 4 * P,
    "roots": ca.sqrt(4 * P + Y) - 2,
}
SLOPE = {
    "linear": -1,
    "cubic": -1,
    "sine": -1,
    "tanh": -1,
    "one less p": -1,
    "two roots": -1,
    "exp": -1,
    "slow": -1e-8,
    "fast": -1e8,
    "differences": 4,
    "roots": 0.25,
}


def family(rate: Any, guess: float) -> Any:
    system = st.System("s", X, P, ca.vertcat(rate, -X[1]), states=("y", "z"), parameters=("p",))
    return st.Family(
        system, "steady", at=("p",), held={"z": 0.0}, unknown={"y": guess}, equations=("y",)
    )


@pytest.mark.few(4)
@pytest.mark.parametrize("name", AT_ZERO)
@pytest.mark.parametrize("guess", [0.0, 1e-300, 1e-9, 1e-3, 0.1, -0.2])
def test_an_equilibrium_at_zero_is_met_from_a_guess_beside_it(name: str, guess: float) -> None:
    # 0.4 refused it: "no root is proved within 400 bits; the point may be singular"
    for certify in (False, True):
        found = st.spectrum(family(AT_ZERO[name], guess), at=1.0, certify=certify)
        values = sorted(found.eigenvalues.real)
        assert np.allclose(values, sorted([SLOPE[name], -1.0]), rtol=1e-9)
        assert found.verdict is (st.Verdict.UNSTABLE if SLOPE[name] > 0 else st.Verdict.STABLE)


@pytest.mark.parametrize("rate", [5e-11, 1e-13, 1e-15, -3e-12])
def test_a_rate_above_its_rounding_is_not_steady(rate: float) -> None:
    system = st.System(
        "s", X, P, ca.vertcat(rate - P * Y, -X[1]), states=("y", "z"), parameters=("p",)
    )
    held = st.Family(system, "steady", at=("p",), held={"y": 0.0, "z": 0.0})
    for certify in (False, True):
        with pytest.raises(st.StabilityError, match="is not steady: y still changes"):
            st.spectrum(held, at=1.0, certify=certify)


def test_a_rate_within_the_rounding_of_what_is_given_is_steady() -> None:
    pendulum = st.System(
        "pendulum", X, P, ca.vertcat(X[1], -P * ca.sin(Y)), states=("y", "z"), parameters=("p",)
    )
    for angle in (math.pi, -math.pi, 2 * math.pi, 3 * math.pi, 101 * math.pi):
        for g in (1e-6, 9.81, 1e9):
            upright = st.Family(pendulum, "upright", at=("p",), held={"y": angle, "z": 0.0})
            assert st.spectrum(upright, at=g).verdict is not st.Verdict.UNDECIDED
    for angle in (3.14159265, math.pi + 1e-12):
        upright = st.Family(pendulum, "upright", at=("p",), held={"y": angle, "z": 0.0})
        with pytest.raises(st.StabilityError, match="is not steady"):
            st.spectrum(upright, at=9.81)
    tenths = st.System(
        "tenths", X, P, ca.vertcat(0.1 + P - 0.3 - Y, -X[1]), states=("y", "z"), parameters=("p",)
    )
    assert st.spectrum(st.Family(tenths, "s", at=("p",), held={"y": 0.0, "z": 0.0}), at=0.2)


@pytest.mark.parametrize("n", [300, pytest.param(3000, marks=pytest.mark.long)])
def test_no_member_of_the_disk_is_refused_at_any_scale(n: int) -> None:
    rng = np.random.default_rng(17)
    asked = [(name, "viscous") for name in ("rolling", "spinning", "tumbling")]
    for name, law in [*asked, ("tumbling", "rough"), ("circling", "rough"), ("tumbling", "smooth")]:
        found = st.disk_family(name, law)
        size = 10 ** rng.uniform(-7, 7, (n, 1))
        if name == "tumbling":
            at = np.where(
                rng.random((n, 1)) < 0.5, np.minimum(size, 1.0), math.pi - np.minimum(size, 1.0)
            )
        elif name == "circling":
            at = np.hstack([rng.uniform(1e-3, 3.1, (n, 1)), size])
        else:
            at = size * rng.choice([-1, 1], (n, 1))
        q = [rng.uniform(0.01, 0.5, n)] + (
            [10 ** rng.uniform(-8, 8, n)] if law == "viscous" else []
        )
        assert found.member(at, np.column_stack(q)).shape == (n, len(found.system.states))


def test_the_noise_of_rates_bounds_what_long_arithmetic_finds() -> None:
    """At members in doubles the true rates (mpmath) are below the bound, and not far below."""
    import mpmath

    found = st.disk_family("tumbling", "viscous")
    rng = np.random.default_rng(2)
    a = rng.uniform(0.05, 3.0, (50, 1))
    q = np.column_stack([rng.uniform(0.1, 0.5, 50), 10 ** rng.uniform(-2, 2, 50)])
    u = found.solve(a, q)
    bound = rate_noise(found.graph, a, u, q, found.states(a, u, q), found.matrix(a, u, q))
    with mpmath.workdps(40):
        for row in range(50):
            th, p, k = (mpmath.mpf(float(v)) for v in (a[row, 0], u[row, 0], q[row, 0]))
            s, c = mpmath.sin(th), mpmath.cos(th)
            gn = k * (1 + p * p * s * c * c) / (k + c * c)
            true = abs((k * p * p * s * c - gn * c) / k)
            assert true <= bound[row, 1] < 1e-10 * max(1.0, float(p) ** 2)
