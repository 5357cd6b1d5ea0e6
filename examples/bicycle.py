"""A system of your own: the bicycle benchmark, its eigenvalues and its self-stable speeds.

M q̈ + v C₁ q̇ + (g K₀ + v² K₂) q = 0 with q = (lean, steer); J. P. Meijaard, J. M. Papadopoulos,
A. Ruina & A. L. Schwab, Proc. R. Soc. A 463 (2007) 1955-1982.
"""

import casadi as ca

import stability as st

M = ca.DM([[80.81722, 2.31941332208709], [2.31941332208709, 0.29784188199686]])
C1 = ca.DM([[0, 33.86641391492494], [-0.85035641456978, 1.68540397397560]])
K0 = ca.DM([[-80.95, -2.59951685249872], [-2.59951685249872, -0.80329488458618]])
K2 = ca.DM([[0, 76.59734589573222], [0, 2.65431523794604]])

x, v, g = ca.SX.sym("x", 4), ca.SX.sym("v"), ca.SX.sym("g")
angles, rates = x[:2], x[2:]
bicycle = st.System.from_mass_matrix(
    "bicycle",
    x,
    ca.vertcat(v, g),
    mass=ca.SX(M),
    forcing=-(v * ca.mtimes(C1, rates) + ca.mtimes(g * K0 + v**2 * K2, angles)),
    unknowns=("d_lean_rate", "d_steer_rate"),
    rates={"lean": x[2], "steer": x[3]},
    states=("lean", "steer", "lean_rate", "steer_rate"),
    parameters=("v", "g"),
    units={"v": "m/s", "g": "m/s²"},
)
upright = st.Family(bicycle, "upright", at=("v",), held=dict.fromkeys(bicycle.states, 0.0))

spectrum = st.spectrum(upright, at=5.0, g=9.81)
for value, label in zip(spectrum.eigenvalues, spectrum.modes.labels, strict=True):
    print(f"{value:+.10f}   {label}")

weave, capsize = st.boundaries(upright, axis=("v", 0.1, 10, 100), g=9.81)
print(f"self-stable from {weave.value:.12f} ({weave.crossing.word}, {weave.frequency:.6f} rad/s)")
print(f"            to   {capsize.value:.12f} m/s ({capsize.crossing.word})")
