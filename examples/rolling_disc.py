"""SymPy's own rolling disc (sympy/physics/mechanics/tests/test_kane.py), brought in as it is."""

from sympy import symbols
from sympy.physics import mechanics as me

import stability as st

(q1, q2, q3), (u1, u2, u3) = me.dynamicsymbols("q1:4"), me.dynamicsymbols("u1:4")
(m, r, g), n, contact = symbols("m r g"), me.ReferenceFrame("N"), me.Point("C")
yaw = n.orientnew("Y", "Axis", [q1, n.z])
lean = yaw.orientnew("L", "Axis", [q2, yaw.x])
disc = lean.orientnew("R", "Axis", [q3, lean.y])
spin, turn = disc.ang_vel_in(n), u1 * lean.x + u2 * lean.y + u3 * lean.z
disc.set_ang_vel(n, turn)
contact.set_vel(n, 0)
centre = contact.locatenew("Dmc", r * lean.z)
centre.v2pt_theory(contact, n, disc)
inertia = me.inertia(lean, m * r**2 / 4, m * r**2 / 2, m * r**2 / 4)
kane = me.KanesMethod(n, [q1, q2, q3], [u1, u2, u3], [me.dot(turn - spin, e) for e in lean])
load, body = (centre, -m * g * yaw.z), me.RigidBody("B", centre, disc, m, (inertia, centre))
kane.kanes_equations([body], [load])
system = st.System.from_sympy(kane, name="disc", parameters=[m, r, g], cyclic=[q1, q3])
straight = st.Family(system, "straight", at=("u2",), held=dict.fromkeys(("q2", "u1", "u3"), 0.0))
for speed in (1.0, 2.0):  # the threshold is u2² = g/(3 r)
    print(speed, st.spectrum(straight, at=speed, m=1.0, r=1.0, g=9.81, certify=True).verdict.word)
