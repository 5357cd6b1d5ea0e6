# ---
# jupyter:
#   jupytext:
#     formats: ipynb,py:percent
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # Does straight rolling last?
#
# Under viscous friction straight rolling with $\omega_3^2 > g/(2kR)$ is spectrally stable: every
# mode whose eigenvalue is not zero by structure decays.  But rolling has *two* structural zeros,
# and only one of them is the tangent of its family.  The other is a tilt
# $\alpha = \theta - \pi/2$ with a slow precession and a lateral slip, so linear theory leaves the
# motion open.
# This notebook reduces the equations to the centre manifold.  CasADi takes the derivatives, and
# SymPy does the algebra.  The notebook then follows the slow flow to the linear threshold.
# All values are dimensionless: $m = R = g = 1$, $w = \omega_3$.

# %%
import casadi as ca
import matplotlib.pyplot as plt
import numpy as np
import sympy
from proofs.centre_manifold import W, derive_slow_flow

import stability as st

K, MU = sympy.symbols("k mu", positive=True)

# %% [markdown]
# ## The centre manifold
#
# The manifold is a graph over $(\alpha, w)$.  Its Taylor coefficients in $\alpha$ follow order by
# order from the invariance equation.

# %%
flow = derive_slow_flow("viscous")
for state, coefficients in flow.manifold.items():
    print(f"{state:10}", [str(c) for c in coefficients[:2]])
print("d(tilt)/dt = a tilt^3, a =", flow.tilt)
print("dw/dt      = b tilt^2, b =", flow.spin)

# %% [markdown]
# Both rates are of higher order: the tilt changes with $\alpha^3$, the spin with $\alpha^2$.
# Beyond the threshold $a > 0 > b$, so the tilt grows and the spin falls: straight rolling does
# not last.
#
# ## A first integral, and the time
#
# The quotient of the two equations is $d\ln\alpha/dw = a/b$, which integrates in closed form.

# %%
a = flow.tilt.subs({sympy.Symbol("k"): K, sympy.Symbol("mu"): MU})
b = flow.spin.subs({sympy.Symbol("k"): K, sympy.Symbol("mu"): MU})
slope = sympy.simplify(a / b)
print("d ln(tilt)/dw =", sympy.factor(slope))
square = W**2 / (2 * (2 * K + 1) * W**2 - 1)  # tilt² up to a constant
assert sympy.simplify(sympy.diff(sympy.log(square) / 2, W) - slope) == 0

# %% [markdown]
# So $I = \alpha^2\,(2(2k+1)w^2 - 1)/w^2$ is constant, and $dt = dw/(b\,\alpha^2)$ gives the time
# from $w_0$ to the threshold $w_c = 1/\sqrt{2k}$.

# %%
w0, tilt = sympy.symbols("w0 tilt", positive=True)
constant = tilt**2 * (2 * (2 * K + 1) * w0**2 - 1) / w0**2
rate = sympy.simplify(1 / (-b * constant * square))
primitive = sympy.integrate(sympy.expand(rate), W)
assert sympy.simplify(sympy.diff(primitive, W) - rate) == 0
threshold = 1 / sympy.sqrt(2 * K)
time = sympy.simplify(primitive.subs(W, w0) - primitive.subs(W, threshold))
stated = (
    MU * (2 * K + 1) ** 3 * w0**2 / ((2 * (2 * K + 1) * w0**2 - 1) * tilt**2)
    * ((2 * K + 1) * (w0**2 - 1 / (2 * K)) - sympy.log(w0 * sympy.sqrt(2 * K)))
)  # fmt: skip
difference = sympy.lambdify((K, MU, w0, tilt), time / stated - 1)
assert all(
    abs(difference(k, m, w, 0.01)) < 1e-12
    for k, m, w in ((0.25, 0.3, 2.0), (0.5, 5.0, 1.7), (0.1, 1.0, 9.0))
)
print("T =", stated)

# %% [markdown]
# ## A launch
#
# A disk that is launched with a tilt $\alpha_0$, no precession and no slip is not on the manifold.
# A fast transient along the stable directions takes the disk there.  By the left null vectors, the
# transient changes the tilt at first order, by a factor that does not depend on friction.

# %%
print("tilt on the slow manifold / tilt of the launch =", sympy.factor(flow.launch))

# %% [markdown]
# ## The full equations over the long time
#
# CVODES integrates all six equations from launches at three tilts.  The time at which each crosses
# the threshold is compared with the formula.  The relative difference falls with the square of the
# tilt.

# %%
k, mu, start = 0.25, 0.3, 1.5 * np.sqrt(2)
system = st.disk_system("viscous")
problem = {"x": system.x, "p": system.p, "ode": system.rhs}
options = {"reltol": 1e-11, "abstol": 1e-14, "max_num_steps": 10**9}
runs, differences = [], []
for lean in (0.08, 0.04, 0.02):
    told = st.drift(at=start, tilt=lean, contact=st.Viscous(mu))
    times = np.linspace(0, 1.02 * told.time, 600)[1:]
    integrator = ca.integrator("flow", "cvodes", problem, 0.0, list(times), options)
    path = np.array(integrator(x0=[np.pi / 2 + lean, 0, 0, start, 0, 0], p=[k, mu])["xf"])
    first = int(np.argmax(path[3] < told.threshold))
    near = slice(first - 3, first + 3)
    crossed = np.polyfit(path[3, near] - told.threshold, times[near], 3)[-1]
    differences.append(crossed / told.time - 1)
    print(f"tilt {lean}: crossed at {crossed:.1f}, formula {told.time:.1f}")
    runs.append((lean, times / told.time, path))
orders = np.diff(np.log(np.abs(differences))) / np.log(0.5)
print("observed order in the tilt:", orders.round(2))
assert abs(differences[-1]) < 0.003
assert np.all(np.abs(orders - 2) < 0.3)

# %%
plt.rc("font", size=7.5)  # one journal column wide
plt.rc("axes", labelsize=7.5, titlesize=7.5)
figure, axes = plt.subplots(2, 1, figsize=(3.39, 4.4), layout="constrained", sharex=True)
looks = (("#d55e00", "-"), ("#0072b2", "--"), ("#000000", ":"))
for (lean, times, path), (colour, dashes) in zip(runs, looks, strict=True):
    axes[0].plot(times, path[3], dashes, color=colour, label=f"tilt {lean}")
    axes[1].plot(times, (path[0] - np.pi / 2) / lean, dashes, color=colour, lw=0.8)
axes[0].axhline(np.sqrt(2), color="0.4", lw=0.8, label="linear threshold")
axes[0].set(ylabel=r"spin $\omega_3$  [$\sqrt{g/R}$]")
figure.legend(fontsize=6.5, frameon=False, loc="outside lower center", ncols=2)
axes[1].set(xlabel="time / formula", ylabel="tilt / tilt of the launch")
figure.suptitle("Straight rolling drifts to its threshold (k = 1/4, mu = 0.3)", fontsize=7.5)
plt.show()
