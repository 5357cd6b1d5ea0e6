"""Systems from functions: a CasADi function with proofs, a Python function without."""

import casadi as ca
import numpy as np

import stability as st

x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
rates = ca.vertcat(x[1], -p[0] * ca.sin(x[0]) - p[1] * x[1])
swing = ca.Function("swing", [x, p], [rates], ["x", "p"], ["rates"])


def by_hand(x, p):
    return np.array([x[1], -p[0] * np.sin(x[0]) - p[1] * x[1]])


names = {"states": ("angle", "rate"), "parameters": ("g", "c")}
for function in (swing, by_hand):
    system = st.System.from_function(function, **names)
    rest = st.Family(system, "rest", at=("c",), held={"angle": 0.0, "rate": 0.0})
    print(st.spectrum(rest, at=0.5, g=9.81).reason)
