"""The sleeping top, from its energies: it stands while I3² spin² > 4 I1 m g l.

J. L. Lagrange's symmetric top; the axis leans by two angles, so that upright is a regular point.
"""

import casadi as ca

import stability as st

lean, tilt, turn = (ca.SX.sym(n) for n in ("lean", "tilt", "turn"))
d_lean, d_tilt, spin = (ca.SX.sym(n) for n in ("lean_rate", "tilt_rate", "spin"))
I1, I3, mgl = (ca.SX.sym(n) for n in ("I1", "I3", "mgl"))

across = (d_lean * ca.cos(tilt)) ** 2 + d_tilt**2
along = (spin + d_lean * ca.sin(tilt)) ** 2
top = st.mechanics(
    ca.vertcat(lean, tilt, turn), ca.vertcat(d_lean, d_tilt, spin), ca.vertcat(I1, I3, mgl),
    kinetic=(I1 * across + I3 * along) / 2,
    potential=mgl * ca.cos(lean) * ca.cos(tilt),
    ignorable=("turn",), name="Lagrange top",
)  # fmt: skip
held = dict.fromkeys(("lean", "tilt", "lean_rate", "tilt_rate"), 0.0)
sleeping = st.Family(top, "sleeping", at=("spin",), held=held)

VALUES = {"I1": 1.0, "I3": 0.5, "mgl": 1.0}
for rate in (3.9, 4.1):
    print(rate, st.spectrum(sleeping, at=rate, certify=True, **VALUES).verdict.word)
(edge,) = st.boundaries(sleeping, axis=("spin", 1, 9, 9), **VALUES)
print(f"it stands above {edge.value:.12f} rad/s")
