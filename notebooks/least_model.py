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
# # The least model of a rolled coin
#
# A US quarter is rolled on a table at 30 radians per second, almost upright.  How far does it
# tilt and turn in half a second?  The answer depends on the contact law, on how well the friction
# is known, and on the accuracy that is asked for.  A coarse question needs no equation of motion
# at all.  A fine one needs six.  A scene finds the smallest model that is enough, and says how it
# knows.
#
# Ten minutes to read.  The tests run this notebook; its assertions state the expected output.

# %%
import math

import matplotlib.pyplot as plt

import stability as st

coin = st.Disk.named("quarter")
print(st.REAL_DISKS["quarter"][1])
print(f"unit of angular velocity √(g/R) = {coin.rate:.2f} 1/s, of time {1e3 / coin.rate:.1f} ms")

UPRIGHT, SPIN, HORIZON = math.pi / 2, 30.0, 0.5
start = {"theta": UPRIGHT - 1e-3, "omega3": SPIN}
print(f"the coin rolls at {SPIN * coin.radius:.2f} m/s, {1e-3:g} rad from upright")

# %% [markdown]
# ## Six contact laws
#
# Nobody knows the law of the contact for certain.  Here are six: two with viscous friction, a rough
# plane without slip, a smooth plane without friction, dry friction, and its regularised form.  The
# coefficient mu = 1 s/m of viscous friction means: at a slip of 0.2 m/s the force is a fifth of
# the weight.  `contact` takes all of them by name.

# %%
laws = {
    "viscous": st.Viscous(1.0),
    "linear viscous": st.LinearViscous(mu=1.0),
    "rough": st.Rough(),
    "smooth": st.Smooth(),
    "Coulomb": st.Coulomb(0.2),
    "regularised": st.RegularisedCoulomb(0.2, 1e-3),
}
several = st.Scene(coin, laws, start, HORIZON, tolerance=1e-4).answer()
for name, part in several.parts.items():
    end = part.path.isel(time=-1)
    tilt = math.degrees(float(end.theta) - UPRIGHT)
    turn = math.degrees(float(end.phi_dot))
    print(f"{name:<15} tilt {tilt:+.3f}°, turns {turn:+7.2f}°/s, answered by {part.model}")

# %% [markdown]
# The laws disagree, so the contact law is the first thing to measure.  Under viscous friction
# rolling is unstable at this spin, and the tilt has grown from 0.06° to 1°.  On a rough and on a
# smooth plane no mode grows: the coin sways, further on the smooth plane.  Dry friction sticks
# here, so the coin follows the rough plane.

# %%
verdicts = {}
for name in ("viscous", "rough", "smooth"):
    spectrum = st.spectrum("rolling", at=SPIN, disk=coin, contact=laws[name])
    verdicts[name] = spectrum.verdict.word
    print(f"{name:<8} {spectrum.verdict.word}, largest growth rate {spectrum.abscissa:.2f} 1/s")
assert verdicts == {"viscous": "unstable", "rough": "neutral", "smooth": "neutral"}
tilts = {n: abs(float(p.path.theta[-1]) - UPRIGHT) for n, p in several.parts.items()}
assert tilts["viscous"] > 10 * tilts["rough"]
assert tilts["smooth"] > 10 * tilts["rough"]
assert abs(tilts["Coulomb"] - tilts["rough"]) < 1e-6

# %%
plt.rc("font", size=7.5)  # one journal column wide
plt.rc("axes", labelsize=7.5)
figure, axes = plt.subplots(figsize=(3.39, 2.6), layout="constrained")
for (name, part), style in zip(
    several.parts.items(), ("-", ":", "-", "--", ":", "-."), strict=True
):
    axes.plot(part.path.time, 1e3 * (part.path.theta - UPRIGHT), style, label=name)
axes.set(xlabel="time [s]", ylabel="tilt [mrad]")
figure.legend(fontsize=6.5, frameon=False, loc="outside upper center", ncols=3)
plt.show()

# %% [markdown]
# ## Which model answers?
#
# Now one law: viscous friction.  The tolerance is the error allowed in each state, dimensionless,
# over 1 or the size of the state.  The rungs of the ladder, cheapest first: the steady motion
# itself; the linear motion near it; its second order; creep, in which slow slip follows from the
# motion and is not a state; the law itself.  The first rung whose estimated error is below the
# tolerance gives the answer.

# %%
chosen = {}
for power in range(1, 9):
    scene = st.Scene(coin, st.Viscous(1.0), start, HORIZON, tolerance=10.0**-power)
    answer = chosen[power] = scene.verify()
    print(f"1e-{power}  {answer.model:<13} estimate {answer.estimate:.1e}, "
          f"true error {answer.true_error:.1e}")  # fmt: skip
    assert answer.true_error <= scene.tolerance
names = [answer.model for answer in chosen.values()]
assert names[:3] == ["steady", "linearised", "second-order"]
assert names[-1] == "viscous"

# %% [markdown]
# `verify` holds the answer against the full model at a finer tolerance.  The true errors are below
# the tolerance.  The estimates of the closed forms are close to them.  The estimate of the law
# itself is much larger than its error: it comes from finer and looser runs.
#
# The report gives every rung, and the reason why it was taken or not.

# %%
print(chosen[3].report())

# %% [markdown]
# ## What an uncertain mu makes of it
#
# Suppose that mu is known to 20 percent, and the tilt at the start to 0.1 mrad.  Sensitivities
# along the path say how far each moves the answer.  Where they say too little, because the input is
# too uncertain, the scene is asked again at both ends.

# %%
known = {"mu": 0.2, "theta": 1e-4}
fine = st.Scene(coin, st.Viscous(1.0), start, HORIZON, tolerance=1e-6, uncertain=known).answer()
print(fine.model)
print("\n".join(fine.spread.lines()))
assert fine.spread.wasted
assert fine.spread.moves["final"]["mu"] > fine.spread.moves["final"]["theta"]

# %% [markdown]
# Six digits are wasted here.  The friction alone moves the answer in its second digit.  With the
# tolerance that the inputs deserve, a closed form is enough.

# %%
enough = st.Scene(
    coin, st.Viscous(1.0), start, HORIZON, tolerance=0.1 * fine.spread.size, uncertain=known
).answer()
print(f"tolerance {enough.tolerance:.1e}: {enough.model}")
assert enough.model == "linearised"
assert not enough.spread.wasted

# %% [markdown]
# ## Where creep takes over
#
# The coin now starts 0.1 rad from upright, too far for a closed form.  With growing mu the slip
# decays ever faster, and the equations of the law become stiff.  Creep is not stiff: after a short
# transient the slip follows the other four states.  At first creep needs a high order, then a lower
# one.  In the end the rough disk is enough, which has no slip.

# %%
tilted = {"theta": UPRIGHT - 0.1, "omega3": SPIN}
taken = {}
for mu in (1.0, 10.0, 100.0, 1e3, 1e4, 1e5):
    answer = taken[mu] = st.Scene(coin, st.Viscous(mu), tilted, HORIZON, tolerance=1e-4).verify()
    slip = math.hypot(answer.value["slip_x"], answer.value["slip_y"])
    print(f"mu = {mu:>8.0f} s/m  {answer.model:<8} true error {answer.true_error:.0e}, "
          f"slip {1e3 * slip:.4f} mm/s")  # fmt: skip
    assert answer.true_error <= 1e-4
assert taken[1.0].model == "viscous"
assert taken[1e3].model == "creep-1"
assert taken[1e5].model == "rough"

# %% [markdown]
# The error of order n falls as mu⁻⁽ⁿ⁺¹⁾.  For the rough disk this is 1/mu:

# %%
rates = [taken[mu].true_error for mu in (1e4, 1e5)]
print(f"ten times the friction, {rates[0] / rates[1]:.1f} times less error")
assert 8 < rates[0] / rates[1] < 12
