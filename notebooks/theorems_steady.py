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
# # Theorems: which motions are steady
#
# A body of revolution rolls, slides or spins on a plane.  Its shape enters by one function, the
# height $h(\theta)$ of its centre of mass at the inclination $\theta$ of its axis.  This page
# states which of its motions are steady, and proves it, for every height at once.
#
# Each proof is a list of steps.  A step is an identity, a sign or a count that SymPy computes from
# the package's own equations of motion, with $h$, $h'$ and $h''$ as symbols.  Nothing is typed in
# by hand.  `shown` prints a theorem with its steps and stops the page at a step that fails.  The
# proofs are in the folder `notebooks/proofs`; tests that try to refute each statement are named
# below it.
#
# Units: $m = g = 1$.  In what is printed s = sinθ and c = cosθ; h, h′ and h′′ are the height and
# its derivatives, ρ = h + h′′ is the radius of curvature; r = h s + h′ c and z = h c - h′ s say
# where the contact point lies; I1 and I3 are the transverse and the axial moment; F is the contact
# force, gn the normal force, vA the slip, Ẑ the vertical.

# %%
import math

import matplotlib.pyplot as plt
import numpy as np
from proofs.pole.steady import steady_at_poles
from proofs.proof import shown
from proofs.search import search
from proofs.steady_motions import branches, rough_and_smooth, steady_motions
from proofs.tumbling import energy_decides, surfaces_neutral

import stability as st

# %% [markdown]
# ## Under any friction
#
# The law of friction may be any law that takes energy from every slip.  The power of the contact
# force is then the rate of the energy, which a steady motion keeps constant.  So the body does not
# slip, and no horizontal force acts.  What is left are three families, and a fourth for a body of
# equal moments: rolling, spinning, tumbling, and leaning spin.

# %%
shown(steady_motions())

# %% [markdown]
# At a pole, where the axis is vertical, the angles of the equations above lose their meaning.  A
# chart around the pole has the same answer: vertical spin, and nothing else.

# %%
shown(steady_at_poles())

# %% [markdown]
# ## Without slip, under dry friction, and without friction
#
# Without slip the plane may push sideways, so there are more steady motions: a surface of them.
# Dry friction keeps those whose force lies inside the cone of friction.  Without friction the
# steady motions are another surface, which has the families too.

# %%
shown(rough_and_smooth())

# %% [markdown]
# ## Where the families meet
#
# Tumbling branches off spinning, and it ends at rest.  The height alone decides whether rest is
# stable.

# %%
shown(branches())

# %% [markdown]
# ## What energy says
#
# Without slip, and without friction, the motion has two more integrals than its energy.  On each
# of their levels the energy is a function of one angle, and its second derivative has the sign of
# $-\lambda^2$.  So a linear verdict *neutral* is stability of the nonlinear motion.

# %%
shown(energy_decides())

# %%
shown(surfaces_neutral())

# %% [markdown]
# ## A search that tries to refute it
#
# For a thin disk under viscous friction, Newton's method runs from random starts over all unknowns.
# A root outside the three families would refute the first theorem.

# %%
for law in ("viscous", "linear-viscous"):
    result = search(2000, law=law)
    print(f"{law}: roots by family {sorted(result.found)}, outside: {result.outside}")
    assert result.outside == 0
    assert min(result.found.values()) > 30
print(f"starts in the box {result.box}")

# %% [markdown]
# ## The families of one body
#
# The closed form of tumbling, drawn for an oblate spheroid.  It leaves spinning at the rate of the
# theorem on branches, and reaches the pole as vertical spin.  Members that the package finds by its
# own solver lie on the curve.


# %%
def squared_rate(body: st.Body, theta: float) -> float:
    """Square of the rate of precession of tumbling, by its closed form."""
    h, slope = (float(body.height_at(theta, order)) for order in (0, 1))
    s, c = math.sin(theta), math.cos(theta)
    axial, transverse = body.moments()
    r, z = h * s + slope * c, h * c - slope * s
    return slope * r / (s * (transverse * r * c - axial * z * s))


plt.rc("font", size=7.5)  # one journal column wide
plt.rc("axes", labelsize=7.5, titlesize=7.5)
body = st.Spheroid(0.5)
axial, transverse = body.moments()
height, bend = (float(body.height_at(math.pi / 2, order)) for order in (0, 2))
meeting = math.sqrt(height * bend / (axial * (height + bend) - transverse * height))
angles = np.linspace(0.02, math.pi / 2 - 1e-3, 200)
rates = [math.sqrt(squared_rate(body, theta)) for theta in angles]
assert abs(rates[-1] - meeting) < 1e-5
family = body.family("tumbling", "rough")
numbers = [body.given[name] for name in family.parameters]
for theta in (0.3, 0.9, 1.4):
    state = dict(zip(family.system.states, family.member([theta], numbers), strict=True))
    assert abs(state["phi_dot"] ** 2 / squared_rate(body, theta) - 1) < 1e-12
figure, ax = plt.subplots(figsize=(3.39, 2.6), layout="constrained")
ax.plot(angles, rates, color="#0072b2", label="tumbling")
ax.axvline(math.pi / 2, color="#d55e00", ls="--", label="spinning")
ax.plot([math.pi / 2], [meeting], "k.", label="where they meet")
ax.set(xlabel=r"inclination $\theta$  [rad]", ylabel=r"precession $\dot\varphi$  [$\sqrt{g/R}$]")
figure.legend(fontsize=6.5, frameon=False, loc="outside lower center", ncols=3)
figure.suptitle("Steady motions of an oblate spheroid, aspect 1/2", fontsize=7.5)
plt.show()
