"""A search for steady motions of the viscous disk other than rolling, spinning and tumbling.

It tries to refute that there is none: CasADi's root-finder from random starts in a box.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from stability.bodies.thin_disk import disk_system

NEAR = 1e-4
"""Largest distance of a root from its member.  Rolling has two zero eigenvalues but one tangent,
so its roots are double, and Newton's error there is the square root of its residual."""


@dataclass(frozen=True)
class Search:
    """Results of a multi-start search for further steady motions."""

    starts: int
    """Number of starts."""
    converged: int
    """Number of starts from which the root-finder reached an isolated or near-isolated root."""
    found: dict[str, int]
    """Number of roots by family."""
    outside: int
    """Number of roots outside all families; any such root refutes completeness."""
    box: str
    """Ranges of the starts and parameters, in words."""


def search(starts: int = 2000, *, seed: int = 1, law: str = "viscous") -> Search:
    """Try to refute completeness: CasADi's Newton from random starts over all five unknowns.

    Examples
    --------
    >>> search(60).outside
    0
    """
    system = disk_system(law)
    steady = ca.SX.sym("steady", 5)  # theta, phi_dot, omega3, slip_x, slip_y
    rates = ca.substitute(
        system.rhs, system.x, ca.vertcat(steady[0], 0, steady[1], steady[2], steady[3], steady[4])
    )
    # φ̈ vanishes with θ̇ = 0, which leaves four rates for five unknowns: a random plane as fifth
    # equation cuts each one-parameter family in points.
    plane = ca.SX.sym("plane", 6)
    cut = ca.dot(plane[:5], steady) - plane[5]
    kept = [system.index(n) for n in ("theta_dot", "omega3", "slip_x", "slip_y")]
    residual = ca.vertcat(*[rates[i] for i in kept], cut)
    problem = ca.Function("steady", [steady, ca.vertcat(system.p, plane)], [residual])
    options = {"error_on_fail": False, "abstol": 1e-13, "max_iter": 80}
    finder = ca.rootfinder("finder", "fast_newton", problem, options).map(starts)
    random = np.random.default_rng(seed)
    low, high = np.array([0.05, -4, -4, -2, -2]), np.array([np.pi - 0.05, 4, 4, 2, 2])
    first = random.uniform(low, high, (starts, 5))
    normal = random.normal(size=(starts, 5))
    offset = (normal * random.uniform(low, high, (starts, 5))).sum(axis=1)
    k, mu = random.uniform(0.05, 0.5, starts), 10 ** random.uniform(-2, 2, starts)
    given = np.column_stack([k, mu, normal, offset])
    roots = np.array(finder(first.T, given.T)).T
    left = np.array(problem.map(starts)(roots.T, given.T)).T
    good = np.isfinite(roots).all(axis=1) & (np.abs(left).max(axis=1) < 1e-9)
    good &= (roots[:, 0] > 0) & (roots[:, 0] < np.pi) & (np.abs(roots) < 1e3).all(axis=1)
    good &= np.sin(roots[:, 0]) > 1e-3
    theta, phi, spin = roots[good, 0], roots[good, 1], roots[good, 2]
    slip = np.abs(roots[good, 3:]).max(axis=1)
    upright = np.abs(np.cos(theta)) < NEAR
    rest = slip < NEAR
    rolling = rest & upright & (np.abs(phi) < NEAR)
    spinning = rest & upright & (np.abs(spin) < NEAR) & ~rolling
    tumbling = rest & (np.abs(spin) < NEAR) & ~upright
    tumbling &= np.abs(k[good] * phi**2 * np.sin(theta) - 1) < NEAR
    found = {
        "rolling": int(rolling.sum()),
        "spinning": int(spinning.sum()),
        "tumbling": int(tumbling.sum()),
    }
    box = "theta 0.05…π-0.05, phi_dot and omega3 ±4, slip ±2, k 0.05…0.5, mu 0.01…100"
    return Search(starts, int(good.sum()), found, int(good.sum()) - sum(found.values()), box)
