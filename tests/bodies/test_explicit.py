"""The equations that are solved by hand are those that an elimination leaves."""

import casadi as ca
import numpy as np
import pytest

import stability as st
from stability.bodies.contact_laws import Contact
from stability.bodies.model import Model
from stability.bodies.round_body.models.angle_model import round_model
from stability.bodies.thin_disk import disk_model

LAWS: list[tuple[type[Contact], tuple[str, ...]]] = [
    (st.Smooth, ()),
    (st.Viscous, ("mu",)),
    (st.LinearViscous, ("c",)),
    (st.LinearViscous, ("mu",)),
    (st.Coulomb, ("mu",)),
    (st.RegularisedCoulomb, ("mu", "epsilon")),
]
RESISTANCES = (st.RollingResistance, st.PivotingResistance, st.AirTorque)


def furthest(model: Model, rng: np.random.Generator) -> float:
    """Largest difference of rates, power, N D and D at random states, over 1 or their size."""
    system = model.system
    seen = [system.observables[n] for n in ("power", "normal_force", "determinant")]
    force = ca.vertcat(system.rhs, seen[0], seen[1] * seen[2], seen[2])
    mine = [model.rhs, model.guards["lift-off"], model.guards.get("no-contact", seen[2])]
    one = ca.Function("graph", [system.x, system.p], [force])
    other = ca.Function("mine", [model.x, model.p], [ca.vertcat(*mine)])
    worst = 0.0
    for _ in range(20):
        x = np.array([rng.uniform(0.3, 1.4), *rng.normal(size=5)])
        p = rng.uniform(0.1, 0.5, system.p.numel())
        y, given = np.append(x, 0.0), np.append(p, 1e-6)
        known, found = one(x, p).full(), other(y, given).full()
        worst = max(worst, (np.abs(found - known) / (1 + np.abs(known))).max())
    return float(worst)


@pytest.mark.parametrize(("law", "given"), LAWS)
@pytest.mark.parametrize("resistance", [(), RESISTANCES], ids=["alone", "resisted"])
@pytest.mark.parametrize("body", [st.Torus(0.2), st.ThickDisk(0.1)], ids=["torus", "thick disk"])
def test_rates_are_those_of_the_elimination(
    body: st.Body,
    resistance: tuple[type[st.Resistance], ...],
    law: type[Contact],
    given: tuple[str, ...],
) -> None:
    model = round_model(body, law, given, pose=False, resistance=resistance)
    assert furthest(model, np.random.default_rng(1)) < 1e-13


@pytest.mark.parametrize("law", ["smooth", "viscous", "linear-viscous", "coulomb-regularised"])
def test_rates_of_the_disk_are_those_of_the_elimination(law: str) -> None:
    assert furthest(disk_model(law), np.random.default_rng(2)) < 1e-13
