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
# # From coin to tippe top
#
# A thin coin, a coin with a rounded rim, a tyre, an egg and a tippe top obey the same equations.
# One function distinguishes them: the height $h(\theta)$ of the centre of mass over the plane when
# the symmetry axis is inclined by $\theta$.  This notebook goes from the coin to the tippe top, and
# asks for the same things each time: which steady motions are stable, and where a launch ends.
#
# Ten minutes to read.  The tests run this notebook; its assertions state the expected output.

# %%
import math

import casadi as ca
import matplotlib.pyplot as plt
import numpy as np

import stability as st

plt.rc("font", size=7.5)  # one journal column wide
plt.rc("axes", labelsize=7.5, titlesize=7.5)

# %% [markdown]
# ## The coin
#
# The thin disk has $h = \sin\theta$.  It rolls stably on a rough plane above
# $\omega_3^2 = g/(2(2k+1)R)$, so at $\omega_3 = 1/\sqrt 3$ for a uniform disk.  The general graph
# says the same as the disk's own.

# %%
coin = st.Body(lambda theta: ca.sin(theta), axial=0.5, transverse=0.25, name="coin")
[edge] = st.boundaries("rolling", axis=("omega3", 0.1, 3, 9), body=coin, contact=st.Rough())
print(f"a thin coin rolls stably above {edge.value:.12f} sqrt(g/R)")
assert math.isclose(edge.value, 3**-0.5, rel_tol=1e-14)

# %% [markdown]
# ## A rounded rim
#
# The rim of a real coin is round, with a small radius $\varepsilon$.  With outer radius, mass and
# moments kept, $h = (1-\varepsilon)\sin\theta + \varepsilon$.  Upright $h = 1$ as before, and only
# $h'' = -(1-\varepsilon)$ changes.  The threshold falls exactly in proportion:
# $\omega_3^2 = (1-\varepsilon)\,g/(3R)$.

# %%
for rim in (0.0, 0.01, 0.05, 0.2):
    body = st.Body(lambda t, e: (1 - e) * ca.sin(t) + e, axial=0.5, transverse=0.25,
                   shape={"e": rim}, name="rounded coin")  # fmt: skip
    [at] = st.boundaries("rolling", axis=("omega3", 0.1, 3, 9), body=body, contact=st.Rough())
    print(f"rim {rim:4.2f}: {at.value:.12f}, formula {math.sqrt((1 - rim) / 3):.12f}")
    assert math.isclose(at.value, math.sqrt((1 - rim) / 3), rel_tol=1e-13)

# %% [markdown]
# ## A tyre
#
# A torus has $h = \sin\theta + b$.  Its moments follow from the shape, so $b$ may be an axis of a
# map, like the friction coefficient.

# %%
tyre = st.Torus(0.2)
chart = st.stability_map("rolling", x=("omega3", 0.05, 1.6, 60), y=("tube", 0.02, 0.6, 50),
                         body=tyre, contact=st.Viscous(0.5))  # fmt: skip
figure = st.plot_map(chart, width=3.39)
figure

# %% [markdown]
# ## A ring that turns back
#
# A ring that is spun on a table turns its path back before it lies flat; a coin does not.  The mean
# path of the centre turns at $\dot\varphi - \Omega$, with the nutation frequency $\Omega$: it turns
# back where $\Omega > \dot\varphi$.  Resistance moves the ring along its circling motions, and the
# map follows it for every inner radius and every mixture of rolling resistance and air torque.
# Rolling resistance alone tells rings from coins.  Air torque turns the coin back too.
#
# ![A ring of inner radius 0.97 R under rolling resistance](../docs/films/ring.gif)

# %%
rings = st.retrograde_map(np.linspace(0, 1, 17), np.linspace(0, 1, 17))
first = rings.largest_ratio.isel(start=0)
rolling, air = first.isel(share=0), first.isel(share=-1)
edge = float(np.interp(1.0, rolling, rings.inner))
print(f"rolling resistance alone: rings with an inner radius above {edge:.2f} R turn back")
print(f"air alone: {int((air > 1).sum())} of {air.size} turn back, the coin among them")
assert 0.77 < edge < 0.79 and bool((air > 1).all())
st.plot_retrograde(rings)

# %% [markdown]
# ## An egg that rises
#
# A prolate spheroid that lies on its side and turns fast is unstable.  With friction it rises on
# its end: the energy of the spin pays for the height.  Vertical spin is stable above
# $\omega^2 = 5a^3 g/R$ for the aspect $a$ and every friction coefficient.

# %%
egg = st.Spheroid(1.4)
law = st.Viscous(0.3)
[rise] = st.boundaries("vertical", axis=("at", 0.1, 20, 9), body=egg, contact=law)
lying = st.spectrum("spinning", at=5.0, body=egg, contact=law, certify=True)
print(f"vertical spin is stable above {rise.value:.6f} sqrt(g/R); lying at 5: {lying.verdict.word}")
assert lying.verdict.word == "unstable" and math.isclose(rise.value**2, 5 * 1.4**3, rel_tol=1e-13)

times = np.linspace(0, 150, 1501)
rising = st.simulate(egg, law, {"theta": math.pi / 2 - 0.05, "phi_dot": 5.0}, times)
assert float(rising.normal_force.min()) > 0 and abs(float(rising.axis_z[-1])) > 0.999

# %% [markdown]
# ## A tippe top that turns over
#
# A ball whose centre of mass lies below its centre stands upright at rest.  Spun fast, it turns
# over *through* its pole, and ends upside down.  Upright spin is unstable above
# $\omega^2 = m g e (R-e)^2/(R(A - C(1-e/R)))$, and inverted spin is stable above
# $m g e (R+e)^2/(R(C(1+e/R) - A))$, for every friction coefficient: a theorem, which
# [a page of proofs](theorems_stability.ipynb) proves for every height.

# %%
top = st.EccentricSphere(0.15, axial=0.4, transverse=0.4)
edges = [st.boundaries("vertical", axis=("at", 0.1, 20, 9), body=top, contact=law, pole=pole)[0]
         for pole in (0, "pi")]  # fmt: skip
known = [math.sqrt(0.15 * (1 - s * 0.15) ** 2 / (0.4 * s * (1 - (1 - s * 0.15)))) for s in (1, -1)]
for place, found, formula in zip(("upright", "inverted"), edges, known, strict=True):
    print(f"{place}: {found.value:.12f}, formula {formula:.12f}")
    assert math.isclose(found.value, formula, rel_tol=1e-13)

turning = st.simulate(top, law, {"theta": 0.1, "omega3": 4.0}, np.linspace(0, 3000, 6001))
print(turning.attrs["outcome"], turning.attrs["evidence"][:80])
assert turning.attrs["outcome"] == "settled" and float(turning.axis_z[-1]) < -0.999

# %%
figure, axes = plt.subplots(2, 1, figsize=(3.39, 3.6), layout="constrained")
for panel, run, name in zip(axes, (rising, turning), ("egg", "tippe top"), strict=True):
    early = run.sel(time=run.time < 300)
    panel.plot(early.time, np.degrees(early.theta), color="#0072b2", lw=0.8)
    panel.set(ylabel="axis from vertical [°]", title=name, ylim=(-5, 185), yticks=(0, 90, 180))
axes[1].set_xlabel(r"time [$\sqrt{R/g}$]")
plt.show()

# %% [markdown]
# ![The tippe top as a film](../docs/films/tippe-top.gif)
#
# `st.animate(run, "top.html", body=top)` writes a page to turn and play, for a run with `pose=True`
# and close times.  Energy only falls on the way.

# %%
energy = turning.energy.values
assert np.all(np.diff(energy) < 1e-9)
print(f"energy falls from {energy[0]:.4f} to {energy[-1]:.4f} m g R")
