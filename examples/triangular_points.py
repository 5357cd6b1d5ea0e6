"""The triangular points of three bodies, neutral below the mass ratio of E. J. Routh (1875).

The frame turns with the two heavy bodies, at (-m, 0) and (1 - m, 0); distances, masses and rates
are ratios.  V. Szebehely, Theory of Orbits (1967), ch. 5: m = (1 - sqrt(69)/9)/2.
"""

import casadi as ca

import stability as st

x, y, u, v, m = (ca.SX.sym(n) for n in ("x", "y", "u", "v", "m"))
far = ca.sqrt((x + m) ** 2 + y**2), ca.sqrt((x + m - 1) ** 2 + y**2)
potential = (x**2 + y**2) / 2 + (1 - m) / far[0] + m / far[1]
pull = ca.gradient(potential, ca.vertcat(x, y))
bodies = st.System(
    "three bodies", ca.vertcat(x, y, u, v), m, ca.vertcat(u, v, pull + 2 * ca.vertcat(v, -u)),
    states=("x", "y", "u", "v"), parameters=("m",),
)  # fmt: skip
triangle = st.Family(
    bodies, "L4", at=("m",), held={"u": 0.0, "v": 0.0}, unknown={"x": 0.49, "y": 0.87},
    equations=("u", "v"), typical={"m": 0.02},
)  # fmt: skip
for ratio in (0.0121505856, 0.04):  # the Moon's share of Earth and Moon; too large a share
    print(ratio, st.spectrum(triangle, at=ratio, certify=True).verdict.word)

(edge,) = st.boundaries(triangle, axis=("m", 0.03, 0.05, 3))
print(f"neutral below m = {edge.value:.15f}")
