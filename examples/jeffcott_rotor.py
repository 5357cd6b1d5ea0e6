"""A rotor with damping in its shaft: beyond W = w0 (1 + de/di) its own damping makes it whirl.

H. H. Jeffcott's rotor (1919) with internal damping di (A. L. Kimball, 1924) and external damping
de, in the frame at rest: z'' + (de + di) z' + (w0² - i W di) z = 0 with z = x + i y.
"""

import casadi as ca

import stability as st

x, y, u, v = (ca.SX.sym(n) for n in ("x", "y", "u", "v"))
W, w0, de, di = (ca.SX.sym(n) for n in ("W", "w0", "de", "di"))
rotor = st.System(
    "Jeffcott rotor", ca.vertcat(x, y, u, v), ca.vertcat(W, w0, de, di),
    ca.vertcat(
        u, v,
        -(de + di) * u - w0**2 * x - W * di * y,
        -(de + di) * v - w0**2 * y + W * di * x,
    ),
    states=("x", "y", "u", "v"), parameters=("W", "w0", "de", "di"),
    units={"x": "m", "y": "m", "u": "m/s", "v": "m/s", "W": "rad/s", "w0": "rad/s",
           "de": "1/s", "di": "1/s"},
)  # fmt: skip
centred = st.Family(rotor, "centred", at=("W",), held=dict.fromkeys(rotor.states, 0.0))
VALUES = {"w0": 100.0, "de": 3.0, "di": 2.0}
for rate in (240.0, 260.0):
    print(rate, st.spectrum(centred, at=rate, certify=True, **VALUES).verdict.word)

(edge,) = st.boundaries(centred, axis=("W", 10, 1000, 100), **VALUES)
print(f"it whirls above {edge.value:.12f} rad/s, with {edge.frequency:.12f} rad/s")
print(st.conditions(centred, positive=("w0", "de", "di")).rule)
