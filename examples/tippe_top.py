"""The tippe top: which spin keeps it upright, and which inverted, for every friction.

A sphere of radius R slides on a plane under viscous friction; its centre of mass lies a R away from
its centre; SI units.  S. Rauch-Wojciechowski & N. Rutstam, SIGMA 10 (2014) 017: inverted spinning
is stable where Jellett's integral is above sqrt(m g R³ I3 a) (1 + a)² / sqrt(1 + a - I1/I3).
"""

import casadi as ca

import stability as st

axis, spin, slide = ca.SX.sym("axis", 3), ca.SX.sym("spin", 3), ca.SX.sym("slide", 2)
m, R, a, I1, I3, g, mu = (ca.SX.sym(n) for n in ("m", "R", "a", "I1", "I3", "g", "mu"))
d_spin, d_slide, load = ca.SX.sym("d_spin", 3), ca.SX.sym("d_slide", 2), ca.SX.sym("load")

turned = ca.cross(spin, axis)  # the rate of the axis
arm = R * (a * axis - ca.SX([0, 0, 1]))  # from the centre of mass to the contact
rise = -R * a * (ca.cross(d_spin, axis) + ca.cross(spin, turned))[2]
force = ca.vertcat(-mu * load * (slide + ca.cross(spin, arm)[:2]), load)
moment = I1 * d_spin + (I3 - I1) * (ca.dot(d_spin, axis) * axis + ca.dot(spin, axis) * turned)
newton = ca.vertcat(m * d_slide - force[:2], m * (rise + g) - load)
balance, unknowns = ca.vertcat(moment - ca.cross(arm, force), newton), (d_spin, d_slide, load)
names = [*(f"axis_{i}" for i in "xyz"), *(f"spin_{i}" for i in "xyz"), "slide_x", "slide_y"]
top = st.System.from_mass_matrix(
    "tippe top", ca.vertcat(axis, spin, slide), ca.vertcat(m, R, a, I1, I3, g, mu),
    mass=ca.jacobian(balance, ca.vertcat(*unknowns)),
    forcing=-ca.substitute(balance, ca.vertcat(*unknowns), ca.SX.zeros(6)),
    unknowns=(*(f"d_{n}" for n in names[3:]), "load"),
    rates=dict(zip(names, ca.vertsplit(turned), strict=False)), states=names,
    parameters=("m", "R", "a", "I1", "I3", "g", "mu"),
)  # fmt: skip
rest = dict.fromkeys((n for n in names if n != "spin_z"), 0.0)
inverted = st.Family(top, "inverted", at=("spin_z",), held=rest | {"axis_z": -1.0})
BODY = {"m": 0.02, "R": 0.02, "a": 0.3, "g": 9.82, "I3": 8e-6 * 2 / 5, "I1": 8e-6 * 131 / 350}
print(st.spectrum(inverted, at=45.0, mu=0.3, certify=True, **BODY).verdict.word)

upright = st.Family(top, "upright", at=("spin_z",), held=rest | {"axis_z": 1.0})
for friction in (0.3, 3.0, 30.0):
    (fast,) = st.boundaries(inverted, axis=("spin_z", 1, 99, 50), mu=friction, **BODY)
    (slow,) = st.boundaries(upright, axis=("spin_z", 1, 99, 50), mu=friction, **BODY)
    print(
        f"mu = {friction}: upright below {slow.value:.12f}, inverted above {fast.value:.12f} rad/s"
    )
print(
    f"Jellett's integral there: {BODY['I3'] * BODY['R'] * (1 + BODY['a']) * fast.value:.9e} J s m"
)

for family, low, high in ((upright, 0, 27.7), (inverted, 41.29, ca.inf)):
    (near,) = st.conditions(
        family, positive=("mu",), between={"spin_z": (low, high)}, **BODY
    ).deciding  # one condition in this interval, for every mu > 0
    (square, (two, no_mu)), (constant, _) = near.polynomial.terms
    edge = ca.sqrt(-constant / square)
    print(f"{family.name}, every mu: {edge:.12f} rad/s, mu to the power {no_mu}, spin to {two}")
for family, low, high in ((upright, 27.69, ca.inf), (inverted, 0, 22.95), (inverted, 22.9, 41.3)):
    beyond = st.conditions(family, positive=("mu",), between={"spin_z": (low, high)}, **BODY)
    print(f"{family.name}, {low} to {high} rad/s, every mu: {beyond.rule}"[:80])
