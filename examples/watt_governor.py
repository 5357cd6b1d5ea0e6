"""Watt's governor: the engine begins to swing where the friction of the balls is too small.

J. Sotomayor, L. F. Mello & D. C. Braga, arXiv math/0606230: x is the angle of the arms, y its rate,
z the speed of the balls, all without unit; Hopf at e = 2 a b^(3/2).
"""

import casadi as ca

import stability as st

x, y, z = (ca.SX.sym(n) for n in "xyz")
e, a, b = (ca.SX.sym(n) for n in "eab")
governor = st.System(
    "Watt governor", ca.vertcat(x, y, z), ca.vertcat(e, a, b),
    ca.vertcat(y, z**2 * ca.sin(x) * ca.cos(x) - ca.sin(x) - e * y, a * (ca.cos(x) - b)),
    states=("x", "y", "z"), parameters=("e", "a", "b"),
)  # fmt: skip
near = {"x": 1.0, "z": 1.4, "e": 0.4, "a": 0.5, "b": 0.5}
running = governor.steady("e", held={"y": 0.0}, guess=near, equations=("y", "z"), name="running")
for friction in (0.3, 0.4):
    print(friction, st.spectrum(running, at=friction, a=0.5, b=0.5, certify=True).verdict.word)

(edge,) = st.boundaries(running, axis=("e", 0.1, 1, 10), a=0.5, b=0.5)
print(f"it runs evenly above e = {edge.value:.12f}, and swings there with {edge.frequency:.12f}")
