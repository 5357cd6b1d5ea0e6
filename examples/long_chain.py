"""A chain of thirty masses with hardening springs: sixty states, and a proved spectrum."""

import casadi as ca

import stability as st

n = 30
x, p = ca.SX.sym("x", 2 * n), ca.SX.sym("p", 2)
place, speed = x[:n], x[n:]
stretch = ca.diff(ca.vertcat(0, place, 0))
force = p[0] * (stretch + stretch**3) + p[1] * ca.diff(ca.vertcat(0, speed, 0))
chain = st.System(
    "chain", x, p, ca.vertcat(speed, ca.diff(force)), parameters=("k", "c"),
    states=[f"q{i}" for i in range(n)] + [f"v{i}" for i in range(n)],
)  # fmt: skip
rest = st.Family(chain, "rest", at=("k",), held=dict.fromkeys(chain.states, 0.0))
spectrum = st.spectrum(rest, at=1.0, c=0.1, certify=True)
print(spectrum.verdict.word, spectrum.abscissa, spectrum.reason)
