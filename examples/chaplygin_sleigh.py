"""Chaplygin's sleigh, from its kinetic energy and its knife edge: it turns round and runs on.

S. A. Chaplygin (1911).  The centre of mass lies a in front of the blade; the blade does not move
across.
"""

import casadi as ca

import stability as st

x, y, heading = (ca.SX.sym(n) for n in ("x", "y", "heading"))
v, across, w = (ca.SX.sym(n) for n in ("v", "across", "w"))
m, a, inertia = (ca.SX.sym(n) for n in ("m", "a", "I"))
c, s = ca.cos(heading), ca.sin(heading)
sleigh = st.mechanics(
    ca.vertcat(x, y, heading), ca.vertcat(v, across, w), ca.vertcat(m, a, inertia),
    q_dot=ca.vertcat(c * v - s * across, s * v + c * across, w),
    kinetic=(m * (v**2 + (across + a * w) ** 2) + inertia * w**2) / 2,
    velocity_constraints={"blade": across}, independent=("v", "w"),
    ignorable=("x", "y", "heading"), name="sleigh",
)  # fmt: skip
straight = st.Family(sleigh, "straight", at=("v",), held={"w": 0.0})
VALUES = {"m": 1.0, "a": 0.3, "I": 0.2}
print(st.spectrum(straight, at=1.0, **VALUES).eigenvalues)  # attraction: -m a v / (I + m a²)

run = st.simulate(sleigh, VALUES, {"v": -1.0, "w": 0.05}, 30.0, families=straight)
print(run.attrs["outcome"], f"at v = {float(run.v[-1]):.10f}")
print(f"the blade's force at the start: {float(run.multiplier_blade[0]):.6f}")
