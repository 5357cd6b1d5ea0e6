"""Ranges in which a printed root of a condition is real and admissible, so that it is a boundary.

A condition that is quadratic in at² or mu² has two roots; one of these may be no boundary of the
family.  The ranges hold for every k in (0, 1/2].  tests/derivation/test_branches.py proves them
from the polynomials and tries to refute them.
"""

from __future__ import annotations

NOWHERE = "no member: the root is complex, negative or outside the family"
_CIRCLING = (
    "sin(theta)**2 >= (2*k + 3 + sqrt(6*(k + 1)*(2*k + 1)**3))/(2*(4*k**2 + 6*k + 3)); "
    "unstable between the two, neutral for every phi_dot where they are not real"
)
_PRECESSION = (
    "sin(theta)**4 >= 3/4; unstable between the two, neutral for every phi_dot where they are not "
    "real"
)
WHERE = {
    ("spinning", "phi_dot**2"): (
        NOWHERE,
        "4*k/(2*k + 1)**2 < mu**2 < 24*k/((2*k + 1)*(4*k + 3))",
    ),
    ("spinning", "mu**2"): (NOWHERE, "phi_dot**2 > 1/k"),
    ("tumbling", "mu**2"): (
        NOWHERE,
        "(1 - 3*k)*(2*k + 1)*cos(theta)**2 < k; elsewhere tumbling is stable for every mu",
    ),
    ("circling", "phi_dot**2"): (_CIRCLING, _CIRCLING),
    ("precession", "phi_dot**2"): (_PRECESSION, _PRECESSION),
}
"""Ranges of the root with +√ and of the root with -√, by family and solved quantity."""
LIMITS = "limits in mu hold at each member, not uniformly along the family"
"""Meaning of the limits."""


def where(family: str, of: str, roots: int) -> tuple[str, ...]:
    """The range of each root, in the order in which they are printed.

    Parameters
    ----------
    family
        Name of the family.
    of
        Solved quantity, such as `mu**2`.
    roots
        Number of roots.

    Returns
    -------
    tuple of str
        Empty strings for roots that are boundaries everywhere.

    Examples
    --------
    >>> where("spinning", "mu**2", 2)[1]
    'phi_dot**2 > 1/k'
    """
    known = WHERE.get((family, of), ())
    return known if len(known) == roots else ("",) * roots
