"""The linear bicycle from its 25 parameters: M, C1, K0, K2, and from which speed it steers itself.

M q̈ + v C1 q̇ + (g K0 + v² K2) q = 0 with q = (lean, steer); J. P. Meijaard, J. M. Papadopoulos,
A. Ruina & A. L. Schwab, Proc. R. Soc. A 463 (2007) 1955-1982, appendix A and Table 1.  Lengths in
m, masses in kg, moments of inertia in kg m²; w wheelbase, c trail, lam tilt of the steering axis.
"""

import math

import casadi as ca

import stability as st

VALUES = {
    "w": 1.02, "c": 0.08, "lam": math.pi / 10, "g": 9.81,
    "rR": 0.3, "mR": 2.0, "IRxx": 0.0603, "IRyy": 0.12,
    "xB": 0.3, "zB": -0.9, "mB": 85.0, "IBxx": 9.2, "IByy": 11.0, "IBzz": 2.8, "IBxz": 2.4,
    "xH": 0.9, "zH": -0.7, "mH": 4.0,
    "IHxx": 0.05892, "IHyy": 0.06, "IHzz": 0.00708, "IHxz": -0.00756,
    "rF": 0.35, "mF": 3.0, "IFxx": 0.1405, "IFyy": 0.28,
}  # fmt: skip


def matrices(P: dict[str, ca.SX]) -> dict[str, ca.SX]:
    """M, C1, K0 and K2 in the parameters: appendix A."""
    w, c, s, k = P["w"], P["c"], ca.sin(P["lam"]), ca.cos(P["lam"])
    rear, body, fork, front = (
        (P["mR"], 0, -P["rR"]), (P["mB"], P["xB"], P["zB"]),
        (P["mH"], P["xH"], P["zH"]), (P["mF"], w, -P["rF"]),
    )  # fmt: skip
    parts = (rear, body, fork, front)
    across = (P["IRxx"], P["IBxx"], P["IHxx"], P["IFxx"])
    mixed = (0, P["IBxz"], P["IHxz"], 0)
    upward = (P["IRxx"], P["IBzz"], P["IHzz"], P["IFxx"])
    first_x, first_z = (sum(part[0] * part[i] for part in parts) for i in (1, 2))
    Txx = sum(i + m * z * z for i, (m, _, z) in zip(across, parts, strict=True))
    Txz = sum(i - m * x * z for i, (m, x, z) in zip(mixed, parts, strict=True))
    Tzz = sum(i + m * x * x for i, (m, x, _) in zip(upward, parts, strict=True))
    mass = fork[0] + front[0]  # the front assembly, which steers
    xA, zA = ((fork[0] * fork[i] + front[0] * front[i]) / mass for i in (1, 2))
    steered = list(zip(parts, across, mixed, upward, strict=True))[2:]
    Axx = sum(i + m * (z - zA) ** 2 for (m, _, z), i, _, _ in steered)
    Axz = sum(i - m * (x - xA) * (z - zA) for (m, x, z), _, i, _ in steered)
    Azz = sum(i + m * (x - xA) ** 2 for (m, x, _), _, _, i in steered)
    off = (xA - w - c) * k - zA * s  # of the front assembly from the steering axis
    Ass = mass * off**2 + Axx * s**2 + 2 * Axz * s * k + Azz * k**2
    Asx = -mass * off * zA + Axx * s + Axz * k
    Asz = mass * off * xA + Axz * s + Azz * k
    trail, SR, SF = c / w * k, P["IRyy"] / P["rR"], P["IFyy"] / P["rF"]
    ST, SA = SR + SF, mass * off + trail * first_x
    M01 = Asx + trail * Txz
    C01 = trail * ST + SF * k + Txz / w * k - trail * first_z
    return {
        "M": ca.vertcat(
            ca.horzcat(Txx, M01), ca.horzcat(M01, Ass + 2 * trail * Asz + trail**2 * Tzz)
        ),
        "C1": ca.vertcat(
            ca.horzcat(0, C01),
            ca.horzcat(-(trail * ST + SF * k), Asz / w * k + trail * (SA + Tzz / w * k)),
        ),
        "K0": ca.vertcat(ca.horzcat(first_z, -SA), ca.horzcat(-SA, -SA * s)),
        "K2": ca.vertcat(
            ca.horzcat(0, (ST - first_z) / w * k), ca.horzcat(0, (SA + SF * s) / w * k)
        ),
    }


P = {n: ca.SX.sym(n) for n in VALUES}
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
upright = st.Family(bicycle, "upright", at=("v",), held=held, typical=VALUES)

if __name__ == "__main__":
    print(st.spectrum(upright, at=5.0, certify=True, **VALUES).verdict.word)
    shown = bicycle.observe([0.0] * 4, [5.0, *VALUES.values()])
    for name, value in shown.items():
        if "_" in name and not name.startswith("d_"):
            print(f"{name} {float(value):.15g}")
    for change in st.boundaries(upright, axis=("v", 0.1, 10, 100), **VALUES):
        print(f"{change.value:.12f} m/s ({change.crossing.word})")
