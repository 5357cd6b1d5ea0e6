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
# # Launch a disk: linear theory and outcome
#
# Two launches of Przybylska & Rauch-Wojciechowski (2016), Section 5, recomputed: rolling and
# spinning, each with its axis tilted by 0.1 rad.  Units are dimensionless: $m = R = g = 1$.

# %%
import math

import numpy as np

import stability as st
from stability.figures.motion import caption

disk, friction = st.Disk(), st.Viscous(0.3)

# %% [markdown]
# ## Rolling too slowly
#
# At $\omega_3 = 1.2$ rolling is unstable (stability needs $\omega_3^2 > 1/(2k) = 2$).  The disk
# leaves this motion, topples to the other side, and oscillates with falling amplitude towards
# tumbling: the centre is at rest, the contact point runs round a circle.

# %%
start = st.launch("rolling", at=1.2, tilt=0.1)
run = st.simulate(disk, friction, start, np.linspace(0, 100, 2001), pose=True)
print(st.spectrum("rolling", at=1.2, contact=friction).verdict.value)
print(caption(run))
figure = st.plot_motion(run, width=3.39)  # one journal column, the parts one below the other
figure

# %% [markdown]
# Kinetic and potential energy plus the work of friction stay constant to the tolerance:

# %%
print(f"audit {float(run.energy_error):.1e} with {run.attrs['method']}, {int(run.steps)} steps")
assert float(run.energy_error) < 1e-9

# %% [markdown]
# ## A whole range of launches at once
#
# `start`, `k` and `mu` may be arrays.  Spinning is stable for $\dot\varphi^2 > 1/k = 4$ at this
# friction.  Above this threshold the disk returns to spinning, below it settles on tumbling.

# %%
speeds = np.linspace(0.5, 4.0, 36)
many = st.simulate(disk, friction, st.launch("spinning", at=speeds, tilt=0.1), [500.0, 1000.0])
for name in ("spinning", "tumbling"):
    mine = speeds[(many.nearest_family.values == name) & (many.outcome.values == 1)]
    print(f"settles on {name}: phi_dot from {mine.min():.1f} to {mine.max():.1f}")
linear = st.spectrum("spinning", at=speeds, contact=friction)
stable = np.array([v is st.Verdict.STABLE for v in linear.verdict])
back = (many.nearest_family.values == "spinning") & (many.outcome.values == 1)
assert (stable == back).all()

# %% [markdown]
# ## Dry friction
#
# With set-valued friction the disk slides, sticks, and slips again, and each event has a sharp
# time.  Regularised friction tends to this law as its slip speed falls, slowly after a slip begins.

# %%
launch = [1.12, -0.31, 1.18, -1.45, -0.49, 0.46]
body = st.Disk(k=0.3)
dry = st.simulate(body, st.Coulomb(0.15), launch, np.linspace(0, 10, 501), tolerance=1e-12)
for kind, time in zip(dry.event_kind.values, dry.event_time.values, strict=True):
    print(f"{kind:<6} at {time:.9f}")
for epsilon in (1e-2, 1e-3, 1e-4):
    smeared = st.simulate(body, st.RegularisedCoulomb(0.15, epsilon), launch, [10.0])
    print(f"epsilon {epsilon:g}: theta off by {abs(float(smeared.theta[-1] - dry.theta[-1])):.1e}")

# %% [markdown]
# ## Where motions end
#
# A run never continues past the end of contact.

# %%
thrown = st.simulate(disk, st.Viscous(3.0), [1.0, 0, 5.0, -5.0, 0, 0], 3.0)
print(thrown.attrs["outcome_sentence"], "; ", thrown.attrs["evidence"])
fallen = st.simulate(disk, st.Smooth(), {"theta": math.radians(60)}, 10.0)
print(fallen.attrs["outcome_sentence"], "; ", fallen.attrs["evidence"])
