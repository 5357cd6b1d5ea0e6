"""The linear bicycle from its 25 parameters: M, C1, K0, K2, and from which speed it steers itself.

M q̈ + v C1 q̇ + (g K0 + v² K2) q = 0 with q = (lean, steer); J. P. Meijaard, J. M. Papadopoulos,
A. Ruina & A. L. Schwab, Proc. R. Soc. A 463 (2007) 1955-1982, appendix A and Table 1.  Lengths in
m, masses in kg, moments of inertia in kg m²; w wheelbase, c trail, lam tilt of the steering axis.
`table benchmarks` has the formulas of the appendix; here is what makes a system of them.
"""

import casadi as ca

import stability as st
from stability.tables.benchmarks.bicycle import BENCHMARK, matrices

P = {n: ca.SX.sym(n) for n in BENCHMARK}
x, v = ca.SX.sym("x", 4), ca.SX.sym("v")
found = matrices(P)
stiffness = P["g"] * found["K0"] + v**2 * found["K2"]
bicycle = st.System.from_mass_matrix(
    "linear bicycle", x, ca.vertcat(v, *P.values()), mass=found["M"],
    forcing=-(v * found["C1"] @ x[2:] + stiffness @ x[:2]),
    unknowns=("d_lean_rate", "d_steer_rate"), rates={"lean": x[2], "steer": x[3]},
    states=("lean", "steer", "lean_rate", "steer_rate"), parameters=("v", *P),
    observables=lambda *_: {
        f"{n}_{i}{j}": found[n][i, j] for n in found for i in (0, 1) for j in (0, 1)
    },
)  # fmt: skip
held = dict.fromkeys(bicycle.states, 0.0)
upright = st.Family(bicycle, "upright", at=("v",), held=held, typical=BENCHMARK)

if __name__ == "__main__":
    print(st.spectrum(upright, at=5.0, certify=True, **BENCHMARK).verdict.word)
    shown = bicycle.observe([0.0] * 4, [5.0, *BENCHMARK.values()])
    for name, value in shown.items():
        if "_" in name and not name.startswith("d_"):
            print(f"{name} {float(value):.15g}")
    for change in st.boundaries(upright, axis=("v", 0.1, 10, 100), **BENCHMARK):
        print(f"{change.value:.12f} m/s ({change.crossing.word})")
