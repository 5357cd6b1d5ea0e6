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
# # Theorems: which steady motions are stable
#
# For every body of revolution the characteristic polynomials of its steady motions follow from the
# height $h(\theta)$ at one inclination: from $h$, $h'$ and $h''$ and the two moments.  This page
# proves where rolling, spinning, vertical spin and tumbling are stable, and prints the polynomials.
# [Which motions are steady](theorems_steady.ipynb) explains the symbols and how a proof is read:
# each step is computed here, and a step that fails stops the page.
#
# *Stable* means that every eigenvalue but those that are zero by structure has a negative real
# part.  Without slip and without friction nothing decays, and the word is *neutral*: all of them
# are on the imaginary axis.

# %%
import matplotlib.pyplot as plt
import numpy as np
import sympy
from proofs import spinning
from proofs.body_polynomials import I1, I3, RHO
from proofs.entry import listed
from proofs.known_results import known_results
from proofs.pole.vertical import vertical_conservative, vertical_viscous
from proofs.printed_polynomials import polynomial, polynomials
from proofs.proof import shown
from proofs.rim import INCLINED, shifts
from proofs.rolling import rolling_conservative, rolling_viscous
from proofs.rounded_rim import shifted, tumbling
from proofs.tumbling import tumbling_static

import stability as st
from stability.derivation.characteristic import M

# %% [markdown]
# ## Rolling
#
# Rolling needs $h' = 0$.  Without slip and without friction a body that is highest there
# ($h'' < 0$) rolls neutrally above a speed.  Under viscous friction the speed does not depend on
# the coefficient, and a body with $I_3 \le I_1$ never rolls stably.

# %%
shown(rolling_conservative())

# %%
shown(rolling_viscous())

# %% [markdown]
# ## Spinning
#
# Spinning upright about a diameter.  Under viscous friction there are two limits of the
# coefficient, M1 and M2: below M1 every fast spin is stable, between them only slow ones, above M2
# none.

# %%
shown(spinning.spinning_conservative())

# %%
shown(spinning.spinning_viscous())

# %% [markdown]
# A body that is *lowest* upright, such as an egg that lies on its side, loses its stability when it
# spins fast: it rises.

# %%
shown(spinning.spinning_low())

# %% [markdown]
# ## The axis vertical
#
# Under viscous friction one number decides for every coefficient: the tippe top's thresholds,
# and those of an egg on its end, are cases.

# %%
shown(vertical_conservative())

# %%
shown(vertical_viscous())

# %% [markdown]
# ## Tumbling
#
# For every height the theorem is about the static boundary.  For the thin disk the whole answer is
# known: [theorems about the disk](theorems_disk.ipynb).

# %%
shown(tumbling_static())

# %% [markdown]
# ## The polynomials
#
# Rolling, spinning and tumbling under three laws, the two families that two numbers name, and
# vertical spin.

# %%
for names in polynomials():
    listed(polynomial(*names))
    print()

# %% [markdown]
# ## Results of others
#
# Values that are known from elsewhere, recovered as identities.  Each says what of its source was
# at hand: a source that was not is not claimed to be reproduced.

# %%
for make in known_results():
    listed(make())
    print()

# %% [markdown]
# ## A coin with a rounded rim
#
# How the thresholds of a thin coin move at first order when its rim has a radius $\varepsilon$.
# The rim is added outside, or the outer radius is kept.

# %%
for shift in shifts():
    listed(shifted(shift))
    print()

# %%
for rounded in INCLINED:
    listed(tumbling(rounded))
    print()

# %% [markdown]
# ## The region of stable spinning
#
# The boundary of the theorem for the thin disk and for two bodies with a round rim.  A body with
# $I_3 > I_1$ has the second limit M2, at which the boundary comes down to the static one.

# %%
BODIES = (
    ("coin: I3 = 2 I1, ρ = 0", {I1: 0.25, I3: 0.5, RHO: 0.0}, "#0072b2", "-"),
    ("rounder: I3 = 2 I1, ρ = 0.3", {I1: 0.25, I3: 0.5, RHO: 0.3}, "#d55e00", "--"),
    ("long: I3 = 0.8 I1, ρ = 0.3", {I1: 0.25, I3: 0.2, RHO: 0.3}, "#000000", ":"),
)
plt.rc("font", size=7.5)  # one journal column wide
plt.rc("axes", labelsize=7.5, titlesize=7.5)
figure, ax = plt.subplots(figsize=(3.39, 2.9), layout="constrained")
boundary = sympy.lambdify((I1, I3, RHO, M), spinning.flutter())
for name, numbers, colour, dashes in BODIES:
    first, last, edge = (
        float(sympy.sympify(e).subs(numbers)) for e in (spinning.M1, spinning.M2, spinning.EDGE)
    )
    end = last if numbers[I3] > numbers[I1] else 4 * first
    places, roots = np.linspace(first, end, 402)[1:-1], []
    for m in places:
        [excess] = [v for v in np.roots(boundary(*numbers.values(), m)) if v > 0]
        roots.append(edge + excess)
    ax.semilogy(places, roots, dashes, color=colour, label=name)
ax.set(xlabel=r"friction $M = \mu^2 g h$", ylabel=r"$q = \dot\varphi^2 h/g$", ylim=(1, 300))
figure.legend(fontsize=6.5, frameon=False, loc="outside lower center", ncols=1)
figure.suptitle("Spinning is stable below its curve", fontsize=7.5)
plt.show()

# %% [markdown]
# The package's own boundary of a spinning coin lies on the curve.

# %%
[found] = st.boundaries("spinning", at=2.5, axis=("mu", 0.6, 1.2, 12), disk=st.Disk(k=0.25),
                        contact="viscous")  # fmt: skip
excess = np.roots(boundary(0.25, 0.5, 0.0, found.value**2))
print(f"mu = {found.value:.6f} at 2.5 √(g/R)")
assert min(abs(excess - (2.5**2 - 4))) < 1e-6
