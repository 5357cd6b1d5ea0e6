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
# # From a coin to its stability diagram
#
# A coin can roll, spin on its edge, or tumble on its rim.  Which of these can be seen?  This
# notebook answers for a US quarter on a table with viscous friction.
#
# `make notebooks` opens this page in Jupyter, to run and to change.  It is kept twice: as
# `quickstart.ipynb` with its output and pictures, and as `quickstart.py`, a script with the same
# cells.  The tests run it; its assertions state the expected output.

# %%
from pathlib import Path

import numpy as np

import stability as st
from stability.figures.canvas import save

coin = st.Disk.named("quarter")
print(st.REAL_DISKS["quarter"][1])
print(f"mass {coin.mass} kg, radius {coin.radius} m, k = {coin.k}")
print(
    f"unit of angular velocity √(g/R) = {coin.rate:.2f} 1/s, of speed √(gR) = {coin.speed:.3f} m/s"
)

# %% [markdown]
# ## One steady motion
#
# The coin spins on its edge at 10 turns per second.  The friction coefficient is mu = 1 s/m: the
# force is mu × normal force × slip velocity.

# %%
law = st.Viscous(1.0)
turning = st.spectrum("spinning", at=2 * np.pi * 10, disk=coin, contact=law)
print(turning.verdict.value)
print(turning.nonlinear.value)
for value, label in zip(turning.eigenvalues, turning.modes.labels, strict=True):
    print(f"{value:+.4f} 1/s   {label}")
assert turning.verdict is st.Verdict.STABLE
assert turning.nonlinear is st.results.Nonlinear.ASYMPTOTIC

# %% [markdown]
# ## Where does it become unstable?
#
# Below phi_dot² = g/(kR) the coin falls over, for every friction, and starts to tumble.
# The threshold comes with a proved bracket.

# %%
[threshold] = st.boundaries("spinning", axis=("at", 10, 100, 100), disk=coin, contact=law)
print(f"{threshold.value:.12f} ± {threshold.error:.0e} rad/s, {threshold.crossing.value}")
print(f"that is {threshold.value / (2 * np.pi):.3f} turns per second")
assert abs(threshold.value - np.sqrt(coin.gravity / (coin.k * coin.radius))) < 1e-12
assert threshold.crossing is st.results.Crossing.STATIC

# %% [markdown]
# ## Its diagram
#
# The diagram varies spin and friction together.  On a rough table every spin is unstable by a
# growing wobble: above the dashed curve a pair of eigenvalues has crossed the imaginary axis.

# %%
found = st.stability_map(
    "spinning", x=("at", 20, 120, 160), y=("mu", 0.02, 50, 120, "log"), disk=coin
)
print(found)
figure = st.plot_map(found, title="a quarter spinning on its edge")
save(figure, Path("quarter"))
st.write_map(found, "quarter.nc", overwrite=True)
assert set(found.verdict.values.ravel().tolist()) == {1, 2}
assert st.read_map("quarter.nc").identical(found)
figure

# %% [markdown]
# The flutter curve starts on the static curve where mu √(gR) = 1, and falls to a limit for fast
# spins.  Below that limit every spin beyond the threshold is stable.

# %%
flutter = found.boundary_kind == 1
start = float(found.boundary_mu[flutter].max()) * coin.speed
end = float(found.boundary_mu[flutter].min()) * coin.speed
print(f"flutter from mu* = {start:.3f} down to {end:.3f}")
assert 0.95 < start < 1.0
assert 0.6 < end < 0.8
