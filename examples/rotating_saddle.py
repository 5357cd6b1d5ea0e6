"""A ball on a rotating saddle: unstable at rest, held by the rotation where W² > k.

The saddle has the curvatures ±k times g, and turns with W; the frame turns with it.  L. E. J.
Brouwer (1918); O. N. Kirillov & M. Levi, Am. J. Phys. 84 (2016) 26.  L² = -W² ± k.
"""

import casadi as ca

import stability as st

x, y, u, v, W, k = (ca.SX.sym(n) for n in ("x", "y", "u", "v", "W", "k"))
saddle = st.System(
    "rotating saddle", ca.vertcat(x, y, u, v), ca.vertcat(W, k),
    ca.vertcat(u, v, (W**2 - k) * x + 2 * W * v, (W**2 + k) * y - 2 * W * u),
    states=("x", "y", "u", "v"), parameters=("W", "k"),
    units={"x": "m", "y": "m", "u": "m/s", "v": "m/s", "W": "rad/s", "k": "1/s²"},
)  # fmt: skip
centre = st.Family(
    saddle, "centre", at=("W",), held=dict.fromkeys(saddle.states, 0.0),
)  # fmt: skip
for rate in (1.7, 1.8):
    print(rate, st.spectrum(centre, at=rate, k=3.0, certify=True).verdict.word)

(edge,) = st.boundaries(centre, axis=("W", 0.1, 5, 50), k=3.0)
print(f"the ball stays above {edge.value:.12f} rad/s")
