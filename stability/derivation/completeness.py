"""The viscous disk has only rolling, spinning and tumbling as steady motions: proof and search.

A steady motion has θ̇ = 0 and constant θ, φ̇, ω₃ and slip.  The proof eliminates the unknowns from
the implicit equations in the graph.  SymPy checks that each step is an identity of the graph.  The
search tries to refute the proof: CasADi's root-finder from random starts in a box.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from ..algebra.number_types import sympy_algebra
from ..algebra.program import Program
from ..base.errors import ParameterError, shown
from ..bodies.thin_disk.disk_equations import disk_system

NEAR = 1e-4
"""Largest distance of a root from its member.  Rolling has two zero eigenvalues but one tangent,
so its roots are double, and Newton's error there is the square root of its residual."""


@dataclass(frozen=True)
class Step:
    """One step of the proof."""

    claim: str
    """Consequence of the identity."""
    identity: str
    """The identity of the graph from which the claim follows."""
    holds: bool
    """Whether SymPy confirms the identity."""


@lru_cache(maxsize=4)
def prove(law: str = "viscous") -> tuple[Step, ...]:
    """The proof by elimination, each step checked against the graph.

    Parameters
    ----------
    law
        `viscous` or `linear-viscous`.

    Returns
    -------
    tuple of Step

    Raises
    ------
    ParameterError
        For another law.

    Examples
    --------
    >>> all(step.holds for step in prove())
    True
    """
    import sympy

    if law not in ("viscous", "linear-viscous"):
        raise ParameterError(
            f"completeness is proved for the viscous and linear-viscous laws, not for {shown(law)}."
        )
    system = disk_system(law)
    assert system.mass is not None and system.forcing is not None
    function = ca.Function("implicit", [system.x, system.p], [system.mass, system.forcing])
    program = Program(function)
    s, c, phi, w, u, v, k, mu, gn = sympy.symbols("s c phi_dot omega3 slip_x slip_y k mu g_n")

    class Angle:
        def sin(self) -> Any:
            return s

        def cos(self) -> Any:
            return c

    algebra = sympy_algebra()
    functions = dict(algebra.functions) | {"sin": lambda _: s, "cos": lambda _: c}
    algebra = type(algebra)(algebra.name, algebra.constant, functions)
    arguments = [[Angle(), sympy.Integer(0), phi, w, u, v], [k, mu]]
    mass = sympy.Matrix(program.dense(algebra, arguments, 0))
    forcing = sympy.Matrix(program.dense(algebra, arguments, 1))
    unknowns = sympy.Matrix([gn if name == "normal" else 0 for name in system.unknowns])
    # rows: Newton along x̂, ŷ, ẑ, Euler along 1̂, 2̂, 3̂, with every acceleration zero
    nx, ny, nz, _, e2, e3 = (sympy.expand(r) for r in mass * unknowns - forcing)
    friction = mu * gn if law == "viscous" else mu

    def same(left: Any, right: Any) -> bool:
        difference = sympy.expand(left - right).subs(s**2, 1 - c**2)
        return bool(sympy.expand(difference) == 0)

    on_plane = {gn: 1}
    settled = {gn: 1, v: 0, u: 0}
    no_spin = settled | {w: 0}
    return (
        Step("gn = 1: the normal force is the weight", "Newton along ẑ: 1 - gn = 0",
             same(nz, 1 - gn)),
        Step("slip_y = 0, as mu > 0", "Euler along 3̂: friction · slip_y = 0",
             same(e3, friction * v)),
        Step("phi_dot · slip_x = 0", "Newton along ŷ with slip_y = 0: phi_dot · slip_x = 0",
             same(ny.subs(v, 0), phi * u)),
        Step("slip_x = 0 and phi_dot · omega3 = 0: if phi_dot = 0 the next equation gives "
             "slip_x = 0, if slip_x = 0 it gives phi_dot · omega3 = 0",
             "Newton along x̂ with slip_y = 0: phi_dot · omega3 + friction · slip_x = 0",
             same(nx.subs(v, 0), phi * w + friction * u)),
        Step("phi_dot = 0: then cosθ = 0, so θ = π/2 with omega3 free: rolling",
             "Euler along 2̂ with slip = 0, phi_dot = 0: cosθ = 0",
             same(e2.subs(settled).subs(phi, 0), c)),
        Step("phi_dot ≠ 0: then omega3 = 0 and cosθ = 0 (θ = π/2: spinning) or "
             "k phi_dot² sinθ = 1 (tumbling)",
             "Euler along 2̂ with slip = 0, omega3 = 0: cosθ (1 - k phi_dot² sinθ) = 0",
             same(e2.subs(no_spin), c * (1 - k * phi**2 * s))),
        Step("no other case is left: every steady motion has vA = 0 and is one of the three",
             "every equation but Euler along 1̂, which holds for θ̇ = 0, has been used",
             same((mass * unknowns - forcing)[3].subs(on_plane), sympy.Integer(0))),
    )  # fmt: skip


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

    Parameters
    ----------
    starts
        Number of random starts.
    seed
        Seed of the random numbers.
    law
        `viscous` or `linear-viscous`.

    Returns
    -------
    Search

    Raises
    ------
    ParameterError
        If `starts` is not positive.

    Examples
    --------
    >>> search(60).outside
    0
    """
    if starts < 1:
        raise ParameterError(f"starts is {starts}; at least 1 is needed.")
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
