"""The disk in momenta moves as the graph of Newton and Euler says, for every law that slips."""

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
import pytest

import stability as st
from stability.bodies.contact_laws import Contact, Parameter, law_class
from stability.bodies.thin_disk import disk_model
from stability.integrators.flow import flow_of
from stability.integrators.lanes import lean_of


@dataclass(frozen=True, eq=False)
class Pulling(Contact):
    """Friction with a part that depends on the normal force and a part that does not."""

    mu: float
    name = "pulling"
    parameters = (Parameter("mu", "s/m", lambda mu, scales: mu * scales.speed),)

    def force(self, slip: Any, normal: Any, mu: Any) -> Any:
        """One part along each way."""
        return [-mu * (normal + 0.7) * slip[0], -mu * (0.2 + normal / (1 + slip[0] ** 2)) * slip[1]]


LAWS = [law_class(n) for n in ("viscous", "linear-viscous", "smooth", "coulomb-regularised")]


@pytest.mark.parametrize("law", [*LAWS, Pulling])
def test_rates_and_guards_are_those_of_the_graph(law: Any) -> None:
    whole = disk_model(law)
    assert whole.short is not None
    short = whole.short(whole)
    theta, turning, phi_dot, omega3, slip_x, slip_y = ca.vertsplit(whole.x[:6])
    sine = ca.sin(theta)
    there = ca.vertcat(
        theta, turning, phi_dot * sine, omega3, slip_x + turning * sine, slip_y - omega3, whole.x[6]
    )
    slow = ca.jtimes(there, whole.x, whole.rhs)
    graph = ca.Function(
        "graph", [whole.x, whole.p], [there, slow, ca.vertcat(*whole.guards.values())]
    )
    own = ca.Function("own", [short.x, short.p], [short.rhs, ca.vertcat(*short.guards.values())])
    rng = np.random.default_rng(3)
    assert list(short.guards) == list(whole.guards)
    for _ in range(100):
        x = rng.uniform(-1.5, 1.5, whole.x.numel())
        x[0] = rng.uniform(0.2, 2.9)
        more = rng.uniform(0.1, 2, whole.p.numel() - 2)
        p = np.concatenate([[rng.uniform(0.25, 0.5)], more, [1e-6]])
        z, rates, guards = (np.array(v).ravel() for v in graph(x, p))
        found = [np.array(v).ravel() for v in own(z, p)]
        for mine, theirs in zip(found, (rates, guards), strict=True):
            assert np.abs(mine - theirs).max() < 1e-12 * max(1.0, np.abs(theirs).max())


def test_states_come_back_from_momenta() -> None:
    lean = lean_of(flow_of(disk_model("viscous")), account=True)
    rng = np.random.default_rng(1)
    y = np.zeros((50, 7))
    y[:, :6] = rng.uniform(-2, 2, (50, 6))
    y[:, 0] = rng.uniform(0.01, 3.1, 50)
    np.testing.assert_allclose(lean.whole(lean.pack(y)), y, rtol=1e-13, atol=1e-13)
    np.testing.assert_allclose(lean.report(lean.pack(y)), y[:, :6], rtol=1e-13, atol=1e-13)


@pytest.mark.parametrize("contact", [st.Rough(), st.Coulomb(0.3)])
def test_a_disk_without_slip_of_its_own_has_no_momenta(contact: Any) -> None:
    assert disk_model(type(contact)).short is None
    assert disk_model("viscous", pose=True).short is None
    assert disk_model("viscous", resistance=(st.RollingResistance,)).short is None
