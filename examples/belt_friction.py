"""A mass on a belt sticks and slips: the period of its cycle, from one run of each phase.

Mass and spring are 1.  Sliding friction is smaller than friction at rest.  The mass slips until the
belt catches it, and sticks until the spring is stronger than friction at rest.  Each phase is a
system; its run ends where its condition reaches zero.
"""

import casadi as ca

import stability as st

x, u = ca.SX.sym("x"), ca.SX.sym("u")
belt, rest, sliding = (ca.SX.sym(n) for n in ("belt", "rest", "sliding"))
pull = x - sliding
ahead = belt - u  # of the belt against the mass
VALUES = {"belt": 0.2, "rest": 1.0, "sliding": 0.5}


def phase(name: str, rates: ca.SX, positive: ca.SX, end: str) -> st.System:
    """The mass in one phase, which ends where a quantity is no longer positive."""
    return st.System(
        name, ca.vertcat(x, u), ca.vertcat(belt, rest, sliding), rates, states=("x", "u"),
        parameters=tuple(VALUES), conditions=(st.Condition(positive, end),),
    )  # fmt: skip


# positive where the belt is ahead or the spring pulls forwards: a + b + sqrt(a² + b²), smooth
slips = phase("slip", ca.vertcat(u, -pull), pull + ahead + ca.sqrt(pull**2 + ahead**2), "caught")
sticks = phase("stick", ca.vertcat(belt, 0), rest - x, "the spring wins")

slip = st.simulate(slips, VALUES, {"x": 1.0, "u": 0.2}, 20.0, tolerance=1e-13)
caught = {"x": float(slip.x[-1]), "u": float(slip.u[-1])}
stick = st.simulate(sticks, VALUES, caught, 20.0, tolerance=1e-13)
print(f"slips for {float(slip.end_time):.12f}, sticks for {float(stick.end_time):.12f}")
print(f"period {float(slip.end_time + stick.end_time):.12f}")
