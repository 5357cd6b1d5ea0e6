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
# # Theorems about the thin disk
#
# A thin disk, an annulus or a hoop is the body of height $h = \sin\theta$ with $I_1 = k$ and
# $I_3 = 2k$, $0 < k \le 1/2$.  The theorems on every height hold for it; this page puts the height
# in.  Then it proves what is known of the disk alone, for every $k$: which tumbling disks are
# stable, the shape of their boundary, where every motion ends under viscous friction, and what dry
# friction does.  [Which motions are steady](theorems_steady.ipynb) explains how a proof is read:
# each step is computed here, and a step that fails stops the page.
#
# Units: $m = R = g = 1$.  In what is printed s = sinθ and c = cosθ; M = mu*² with mu* = mu √(gR);
# vA is the slip, gn the normal force, F the horizontal contact force.

# %%
import math

import matplotlib.pyplot as plt
import numpy as np
import sympy
from proofs.disk.boundary_shape import boundary_shape
from proofs.disk.case import M2, disk_case
from proofs.disk.dry_friction import dry_friction
from proofs.disk.flutter import spinning_elliptic
from proofs.disk.settling import settling
from proofs.disk.tumbling import X, coefficients, tumbling
from proofs.painleve import painleve
from proofs.proof import shown

import stability as st
from stability.derivation.characteristic import K

# %% [markdown]
# ## The general theorems at h = sinθ
#
# The rows of the disk's own graph, its families, its characteristic polynomials and its limits
# must come out of the general ones.  That is checked here, so the proofs for every height are
# proofs for the disk.

# %%
shown(disk_case())

# %% [markdown]
# ## Spinning: on which side the disk stays
#
# At a flutter boundary a small oscillation loses energy, so the disk drifts along the family of
# steady motions.  The boundary is *elliptic* if the drift leads back to stable members and
# *hyperbolic* if it leads away from them.

# %%
shown(spinning_elliptic())

# %% [markdown]
# ## Tumbling, for every k and θ

# %%
shown(tumbling())

# %% [markdown]
# The boundary $M_b(\theta)$ has one of three shapes.  A count of real roots by Sturm's theorem at
# one $k$ between any two critical ones proves which.

# %%
shown(boundary_shape())

# %% [markdown]
# ## The end of every motion
#
# Under viscous friction LaSalle's principle applies: a motion that stays away from lying flat, from
# lift-off and from Painlevé's limit ends in one steady motion.  There are no cycles and no chaos in
# the end.

# %%
shown(settling())

# %% [markdown]
# ## Dry friction
#
# Coulomb's law leaves the start of a slip open.  Below a coefficient of friction exactly one
# continuation exists, and the end of slip at D = 0 is known.

# %%
shown(dry_friction())

# %% [markdown]
# ## Painlevé's limit
#
# Above a product of slip and friction coefficient no contact force can hold the body.  For disks
# the limit has a closed form; for other bodies `stability.painleve_limit` encloses it.

# %%
shown(painleve())

# %%
limits = st.table("painleve")
print(limits.to_text())
for row, k in zip(limits, (0.25, 0.5), strict=False):
    closed = 2 * math.sqrt(k * (k + 1))
    assert row["limit"] <= closed * (1 + 1e-15) and closed * (1 - 1e-15) <= row["at_most"]

# %% [markdown]
# ## The three shapes of tumbling's boundary
#
# Tumbling is stable below the curve.  Where the curve falls the boundary is elliptic, where it
# rises hyperbolic.

# %%
a, b, c = coefficients()
root = 2 * c / (sympy.sqrt(b**2 - 4 * a * c) - b)
boundary = sympy.lambdify((K, X), root / sympy.sqrt(1 - X))
leading = sympy.lambdify((K, X), a)
plt.rc("font", size=7.5)  # one journal column wide
plt.rc("axes", labelsize=7.5, titlesize=7.5)
figure, ax = plt.subplots(figsize=(3.39, 2.9), layout="constrained")
looks = ((0.25, "#0072b2", "-"), (0.4, "#d55e00", "--"), (0.5, "#000000", ":"))
for k, colour, dashes in looks:
    angles = np.linspace(0.01, math.pi / 2 - 1e-3, 400)
    x = np.cos(angles) ** 2
    kept = leading(k, x) < 0
    ax.plot(angles[kept], boundary(k, x[kept]), dashes, color=colour, label=f"k = {k}")
    limit = float(M2.subs(K, k))
    assert abs(boundary(k, x[-1]) - limit) < 1e-4
ax.set(xlabel=r"inclination $\theta$  [rad]", ylabel=r"$M_b = \mu_b^2\, g R$", ylim=(0, 4))
figure.legend(fontsize=6.5, frameon=False, loc="outside lower center", ncols=3)
figure.suptitle("Tumbling is stable below its curve", fontsize=7.5)
plt.show()

# %% [markdown]
# The package finds the same boundary by its own search.

# %%
for k, _, _ in looks:
    [found] = st.boundaries("tumbling", at=1.0, axis=("mu", 0.2, 3, 30), disk=st.Disk(k=k),
                            contact="viscous")  # fmt: skip
    print(f"k = {k}: mu = {found.value:.6f} at theta = 1")
    assert abs(found.value**2 / boundary(k, math.cos(1.0) ** 2) - 1) < 1e-9
