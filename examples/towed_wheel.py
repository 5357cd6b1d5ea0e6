"""A towed wheel shimmies: a caster, from its energies and the constraint that it rolls.

It is towed at the speed v.  Its king pin sways against a spring and a damper.  The wheel lies a
trail behind the pin and does not slip sideways.
"""

import casadi as ca

import stability as st

GIVEN = {"trail": 0.1, "centre": 0.07, "m": 2.0, "J": 0.02, "k": 1e4, "c": 5.0}
q = ca.vertcat(ca.SX.sym("sway"), ca.SX.sym("angle"))
u = ca.vertcat(ca.SX.sym("sway_rate"), ca.SX.sym("turn_rate"))
p = ca.vertcat(*[ca.SX.sym(n) for n in ("v", *GIVEN)])
v, trail, centre, m, inertia, k, c = ca.vertsplit(p)
sine, cosine = ca.sin(q[1]), ca.cos(q[1])
along, across = v + centre * u[1] * sine, u[0] - centre * u[1] * cosine  # velocity of the mass

wheel = st.mechanics(
    q, u, p,
    kinetic=m * (along**2 + across**2) / 2 + inertia * u[1] ** 2 / 2,
    potential=k * q[0] ** 2 / 2,
    forces=ca.vertcat(-c * u[0], 0),
    velocity_constraints={"no_slip": u[0] * cosine - v * sine - trail * u[1]},
    independent=("sway_rate",), name="towed wheel",
    units={"sway": "m", "sway_rate": "m/s", "angle": "rad", "v": "m/s", "trail": "m", "centre": "m",
           "m": "kg", "J": "kg m2", "k": "N/m", "c": "N s/m"},
)  # fmt: skip
straight = st.Family(wheel, "straight", at=("v",), held=dict.fromkeys(wheel.states, 0.0))
