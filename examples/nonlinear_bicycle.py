"""The bicycle from its energies and its two rolling wheels: weave, capsize, self-stable speeds.

Four bodies, nine coordinates, six rolling constraints.  Parameters of J. P. Meijaard,
J. M. Papadopoulos, A. Ruina & A. L. Schwab, Proc. R. Soc. A 463 (2007) 1955-1982; axes x forward,
y right, z down.  The wheels turn about their axles towards the front.
"""

import casadi as ca

import stability as st
from stability.tables.benchmarks.bicycle import BENCHMARK as VALUES

P = {n: ca.SX.sym(n) for n in VALUES}
Q = {n: ca.SX.sym(n) for n in ("x", "y", "z", "yaw", "lean", "pitch", "steer", "rear", "front")}
U = {n: ca.SX.sym(f"{n}_rate") for n in Q}
q, u, p = (ca.vertcat(*table.values()) for table in (Q, U, P))
DOWN = ca.SX([0, 0, 1])


def turn(axis: int, angle: ca.SX) -> ca.SX:
    """Matrix of the rotation about a coordinate axis."""
    c, s, i, j = ca.cos(angle), ca.sin(angle), (axis + 1) % 3, (axis + 2) % 3
    matrix = ca.SX.eye(3)
    matrix[i, i], matrix[i, j], matrix[j, i], matrix[j, j] = c, -s, s, c
    return matrix


def inertia(xx: ca.SX, yy: ca.SX, zz: ca.SX, xz: ca.SX | float = 0.0) -> ca.SX:
    """Inertia matrix of a body that is symmetric about its xz plane."""
    return ca.vertcat(ca.horzcat(xx, 0, xz), ca.horzcat(0, yy, 0), ca.horzcat(xz, 0, zz))


def velocity(place: ca.SX) -> ca.SX:
    """Velocity of a point."""
    return ca.jtimes(place, q, u)


def contact(centre: ca.SX, axle: ca.SX, radius: ca.SX, spin: ca.SX) -> ca.SX:
    """Velocity of the lowest point of a wheel, as a point of its rim."""
    across = DOWN - ca.dot(DOWN, axle) * axle
    return velocity(centre) + ca.cross(spin, radius * across / ca.sqrt(ca.dot(across, across)))


def model() -> dict[str, ca.SX]:
    """Kinetic and potential energy, and the velocities of both contact points."""
    heading = turn(2, Q["yaw"])
    rolled = heading @ turn(0, Q["lean"])
    frame = rolled @ turn(1, Q["pitch"])
    tilt = turn(1, P["lam"])
    fork = frame @ tilt @ turn(2, Q["steer"]) @ tilt.T
    spin = U["yaw"] * DOWN + U["lean"] * heading[:, 0] + U["pitch"] * rolled[:, 1]
    fork_spin = spin + U["steer"] * (frame @ tilt)[:, 2]
    rear_spin = spin - U["rear"] * frame[:, 1]
    front_spin = fork_spin - U["front"] * fork[:, 1]
    rear = ca.vertcat(Q["x"], Q["y"], Q["z"])
    hub = ca.vertcat(0, 0, -P["rR"])  # the rear hub; the origin of the figures is below it
    body = rear + frame @ (ca.vertcat(P["xB"], 0, P["zB"]) - hub)
    pin = ca.vertcat(P["w"] + P["c"], 0, 0)  # where the steering axis meets the ground
    front, handle = (
        rear + frame @ (pin - hub) + fork @ (ca.vertcat(x, 0, z) - pin)
        for x, z in ((P["w"], -P["rF"]), (P["xH"], P["zH"]))
    )
    parts = (
        (P["mR"], rear, frame, rear_spin, inertia(P["IRxx"], P["IRyy"], P["IRxx"])),
        (P["mB"], body, frame, spin, inertia(P["IBxx"], P["IByy"], P["IBzz"], P["IBxz"])),
        (P["mH"], handle, fork, fork_spin, inertia(P["IHxx"], P["IHyy"], P["IHzz"], P["IHxz"])),
        (P["mF"], front, fork, front_spin, inertia(P["IFxx"], P["IFyy"], P["IFxx"])),
    )
    kinetic = potential = ca.SX(0)
    for mass, place, axes, omega, moments in parts:
        local = axes.T @ omega
        kinetic += (mass * ca.sumsqr(velocity(place)) + ca.dot(local, moments @ local)) / 2
        potential -= mass * P["g"] * place[2]
    rear_slip = contact(rear, frame[:, 1], P["rR"], rear_spin)
    front_slip = contact(front, fork[:, 1], P["rF"], front_spin)
    return {
        "kinetic": kinetic, "potential": potential,
        "velocity_constraints": ca.vertcat(rear_slip, front_slip),
    }  # fmt: skip


def riding() -> st.System:
    """The bicycle in lean, steer and speed; where it is, and where it goes, is ignorable."""
    return st.mechanics(
        q, u, p, **model(), independent=("lean_rate", "steer_rate", "rear_rate"),
        ignorable=("x", "y", "yaw", "rear", "front"), name="nonlinear bicycle",
    )  # fmt: skip


def straight(system: st.System) -> st.Family:
    """Straight running, named by the rate of the rear wheel: speed / radius."""
    held = dict.fromkeys(system.states, 0.0) | {"z": -VALUES["rR"]}
    del held["rear_rate"]
    return st.Family(system, "straight", at=("rear_rate",), held=held, typical=VALUES)


if __name__ == "__main__":
    family = straight(riding())
    found = st.spectrum(family, at=5.0 / VALUES["rR"], **VALUES)
    for value in found.eigenvalues:
        print(f"{value:+.10f}")
    print(found.verdict.word)
    for change in st.boundaries(family, axis=("rear_rate", 1, 30, 60), **VALUES):
        print(f"{change.value * VALUES['rR']:.12f} m/s ({change.crossing.word})")
