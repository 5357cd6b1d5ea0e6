"""A railway wheelset hunts: two conical wheels on one axle, from which speed they swing.

Equations and numbers of J. K. Moore's course EME 134 (University of California, Davis), lab 1:
linear creep of both wheels, gravity at the cones, and springs to the bogie.
"""

import casadi as ca

import stability as st

VALUES = {
    "m": 1000.0, "d": 0.72, "I": 1000 * 0.72**2, "N": 20e3, "R": 0.23, "Rr": 0.2, "d1": 0.36,
    "cone": ca.pi / 180, "f": 1e6, "k1": 13e3, "k2": 13e3, "r0": 0.46,
}  # fmt: skip
y, yaw, dy, dyaw, v = (ca.SX.sym(n) for n in ("y", "yaw", "dy", "dyaw", "v"))
m, d, inertia, N, R, Rr, d1, cone, f, k1, k2, r0 = (ca.SX.sym(n) for n in VALUES)
lam = R * cone / (R - Rr)  # conicity of a worn wheel of radius R on a rail of radius Rr
side = -(2 * k1 + 2 * N / (R - Rr)) * y + 2 * f * yaw - 2 * f / v * dy
turn = -2 * f * lam * d / r0 * y - 2 * k2 * d1**2 * yaw - 2 * f * d**2 / v * dyaw
wheelset = st.System(
    "wheelset", ca.vertcat(y, yaw, dy, dyaw),
    ca.vertcat(v, m, d, inertia, N, R, Rr, d1, cone, f, k1, k2, r0),
    ca.vertcat(dy, dyaw, side / m, turn / inertia),
    states=("y", "yaw", "dy", "dyaw"), parameters=("v", *VALUES),
    units={"v": "m/s", "k2": "N/m", "y": "m", "yaw": "rad", "dy": "m/s", "dyaw": "rad/s"},
)  # fmt: skip
centred = st.Family(wheelset, "centred", at=("v",), held=dict.fromkeys(wheelset.states, 0.0))
print(st.spectrum(centred, at=20.0, certify=True, **VALUES).eigenvalues)

(hunting,) = st.boundaries(centred, axis=("v", 1, 100, 100), **VALUES)
print(f"it hunts above {hunting.value:.12f} m/s, with {hunting.frequency:.12f} rad/s")
