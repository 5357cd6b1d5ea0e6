"""Ziegler's column under a follower force: damping lowers the load at which it flutters.

Masses 2m and m on two rods, joints of stiffness and damping; O. N. Kirillov & F. Verhulst, Z.
angew. Math. Mech. 90 (2010) 462.  P is force · length / stiffness, b the damping of both joints.
Without damping it flutters above 7/2 - sqrt(2); with any damping above 41/28 + b²/2.
"""

import casadi as ca

import stability as st

x, P, b = ca.SX.sym("x", 4), ca.SX.sym("P"), ca.SX.sym("b")
angles, rates = x[:2], x[2:]
K = ca.vertcat(ca.horzcat(2 - P, P - 1), ca.horzcat(-1, 1))
C, M = b * ca.SX([[2, -1], [-1, 1]]), ca.SX([[3, 1], [1, 1]])


def column(friction: ca.SX, parameters: dict[str, ca.SX]) -> st.Family:
    """The straight column, by its load."""
    names = ("lower", "upper", "lower_rate", "upper_rate")
    system = st.System.from_mass_matrix(
        "Ziegler column", x, ca.vertcat(*parameters.values()), mass=M,
        forcing=-K @ angles - friction, unknowns=("d_lower_rate", "d_upper_rate"),
        rates={"lower": x[2], "upper": x[3]}, states=names, parameters=tuple(parameters),
    )  # fmt: skip
    held = dict.fromkeys(names, 0.0)
    return st.Family(system, "straight", at=("P",), held=held)


damped = column(C @ rates, {"P": P, "b": b})
print(st.spectrum(damped, at=1.4, b=0.1, certify=True).verdict.word)
# without damping the spectrum is symmetric
undamped = column(ca.SX.zeros(2), {"P": P})
for share in (1.0, 0.1, 0.001):
    (edge,) = st.boundaries(damped, axis=("P", 0.5, 3, 50), b=share)
    print(f"b = {share:g}: flutter above {edge.value:.12f}")
(edge,) = st.boundaries(undamped, axis=("P", 0.5, 3, 50))
print(f"b = 0: flutter above {edge.value:.12f}")
