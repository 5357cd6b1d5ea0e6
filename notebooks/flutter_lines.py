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
# # Flutter on a line of steady motions
#
# Spinning and tumbling under friction are *lines* of steady motions.  Where such a line loses
# stability by flutter, energy falls strictly while the rim slips, so no limit cycle can form.
# The boundary is a Hopf bifurcation without parameters (Fiedler, Liebscher & Alexander,
# J. Differential Equations 167, 2000, 16-35).  Let $y$ be the distance along the line and $z$ the
# amplitude of the pair.  To leading order $\dot y = c\,|z|^2$ and
# $\frac{d}{dt}|z| = \mathrm{Re}\,\mu'\,y\,|z|$.  So $y^2 - (c/\mathrm{Re}\,\mu')\,|z|^2$ is
# constant: an ellipse or a hyperbola.

# %%
import casadi as ca
import matplotlib.pyplot as plt
import numpy as np

import stability as st

# %% [markdown]
# ## Both types occur
#
# Spinning is elliptic wherever it flutters.  Tumbling is elliptic for a uniform disk and hyperbolic
# for a hoop.  For inertia factors in between, both types occur, one at each end of an unstable
# stretch.  The stretch begins at a fold, where the pair crosses with zero speed.

# %%
for family, k, mu in (("spinning", 0.25, 0.8), ("tumbling", 0.25, 1.5), ("tumbling", 0.375, 0.9),
                      ("tumbling", 0.5, 1.0)):  # fmt: skip
    for point in st.hopf(family, disk=st.Disk(k=k), contact=st.Viscous(mu)):
        side = "below" if point.stable_below else "above"
        print(f"{family} k={k} mu={mu}: at {point.at:.6f}, stable {side}, {point.kind.word}")

# %% [markdown]
# ## Motions that start near the unstable part
#
# Each motion starts at a member beyond the boundary, with a small disturbance along the pair.  In
# the elliptic case the motion swings out and settles at the same distance on the other side.  In
# the hyperbolic case it leaves, here towards flat.


# %%
def path(family: str, k: float, mu: float, y: float, z: float, time: float):
    [point] = st.hopf(family, disk=st.Disk(k=k), contact=st.Viscous(mu))
    start = st.disk_family(family, "viscous").member([point.at + y], [k, mu])
    system = st.disk_system("viscous")
    times = np.linspace(0, time, 12000)[1:]
    flow = ca.integrator(
        "flow", "cvodes", {"x": system.x, "p": system.p, "ode": system.rhs}, 0.0, list(times),
        {"reltol": 1e-10, "abstol": 1e-13, "max_num_steps": 10**9},
    )  # fmt: skip
    states = np.array(flow(x0=start + 2 * z * point.mode.real, p=[k, mu])["xf"])
    along = states[2 if family == "spinning" else 0] - point.at
    return point, times, along, np.hypot(states[4], states[5])


plt.rc("font", size=7.5)  # one journal column wide
plt.rc("axes", labelsize=7.5, titlesize=7.5)
figure, axes = plt.subplots(2, 1, figsize=(3.39, 4.4), layout="constrained")
for y, colour in ((0.1, "#d55e00"), (0.05, "#0b3c5d")):
    point, times, along, slip = path("spinning", 0.25, 0.8, y, 0.05 * y, 1500 / y)
    told = point.landing(y, 0.05 * y)
    print(f"spinning from {y}: ends at {along[-1]:.5f}, leading order {told:.5f}")
    assert abs(along[-1] / told - 1) < 1.2 * y
    axes[0].plot(along, slip, color=colour, lw=0.4, label=f"start {y} beyond")
    axes[0].plot([y, along[-1]], [0, 0], "o", color=colour, ms=4)
_, times, along, slip = path("tumbling", 0.5, 1.0, -0.1, 0.05, 500)
assert along[-5:].max() < -0.9
axes[1].plot(along, slip, color="#d55e00", lw=0.5)
titles = "elliptic: spinning disk, mu = 0.8", "hyperbolic: tumbling hoop, mu = 1"
for axis, title in zip(axes, titles, strict=True):
    axis.axvline(0, color="black", lw=0.8, ls="--")
    axis.set_title(title)
    axis.set_ylabel(r"slip  [$\sqrt{gR}$]")
figure.legend(fontsize=6.5, frameon=False, loc="outside lower center", ncols=2)
axes[0].set_xlabel(r"$\dot\varphi$ from the boundary  [$\sqrt{g/R}$]")
axes[1].set_xlabel(r"$\theta$ from the boundary  [rad]")
plt.show()
