"""Hopf bifurcation without parameters, where a line of steady motions loses stability by flutter.

At a flutter boundary of spinning and tumbling under friction one eigenvalue is zero by structure,
for the family is a line of steady motions, and a pair crosses the imaginary axis along that line.
Energy falls while the contact slips, so no limit cycle is born: to leading order the distance y
along the line and the amplitude z of the pair obey

    dy/dt = c |z|²,   d|z|/dt = Re μ' y |z|,   so that  y² - (c / Re μ') |z|²  is constant.

Elliptic (c Re μ' < 0): a motion that starts beside the unstable part of the line swings out and
settles on the stable part, as far from the boundary as it began.  Hyperbolic (c Re μ' > 0): it
leaves; and of the motions that start beside the stable part only those inside a cone settle.

Source: B. Fiedler, S. Liebscher & J. C. Alexander, J. Differential Equations 167 (2000) 16-35;
tests/test_hopf.py compares with an independent derivation and with simulations.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from .algebra import Program
from .boundary import Crossing, along
from .checks import checked
from .contact import Contact
from .disk import Disk
from .errors import ParameterError, shown
from .exact import exact_polynomial
from .families import Family, columns
from .problem import Problem, disk_problem
from .reduction import tangent_vectors

Floats = NDArray[np.float64]

SCAN = {"spinning": (1e-2, 1e3), "tumbling": (1e-4, np.pi / 2)}
"""Where boundaries are looked for along each family, dimensionless."""


class HopfKind(Enum):
    """What a motion beside the boundary does; the value is the sentence a user reads."""

    ELLIPTIC = (
        "elliptic: a motion beside the unstable part of the line swings out and settles on the "
        "stable part, about as far beyond the boundary as it began before it"
    )
    HYPERBOLIC = (
        "hyperbolic: a motion beside the unstable part leaves the line for good; beside the stable "
        "part only motions inside a cone of small amplitude settle"
    )
    DEGENERATE = (
        "degenerate: the pair does not cross with speed, or does not move the motion along the "
        "line, within the error of the computation; higher orders decide"
    )

    @property
    def word(self) -> str:
        """One lower-case word."""
        return self.name.lower()


@dataclass(frozen=True)
class HopfPoint:
    """A flutter boundary along a line of steady motions, with its normal form."""

    at: float
    """Family parameter at the boundary, in the user's unit."""
    kind: HopfKind
    """Elliptic, hyperbolic or degenerate."""
    stable_below: bool
    """Whether the stable part of the line has the smaller family parameter."""
    frequency: float
    """|Im λ| of the pair, in the user's unit of rate."""
    crossing: float
    """Re μ': speed of the pair's real part along the line, dimensionless."""
    push: float
    """c: drift along the line by the pair, for the mode of unit length, dimensionless."""
    mode: Floats
    """The pair's eigenvector, complex, of unit length over the states, dimensionless."""
    unit: float
    """One dimensionless unit of the family parameter in the user's unit."""

    def landing(self, distance: float, amplitude: float = 0.0) -> float | None:
        """Where on the line a motion settles, to leading order.

        Parameters
        ----------
        distance
            Of the start from the boundary along the line, in the user's unit, signed.
        amplitude
            |z| of the start: the disturbance is 2 Re(z mode).

        Returns
        -------
        float or None
            Signed distance of the end from the boundary; None if the motion leaves the line.

        Examples
        --------
        >>> from stability.contact import Viscous
        >>> [point] = hopf("spinning", contact=Viscous(0.8))
        >>> round(point.landing(0.01), 12)  # unstable side, vanishing amplitude
        -0.01
        """
        if self.kind is HopfKind.DEGENERATE:
            raise ParameterError("the boundary is degenerate there; no landing can be told.")
        far, size = checked("distance", distance), checked("amplitude", amplitude)
        if not isinstance(far, float) or not isinstance(size, float):
            raise ParameterError("distance and amplitude must be one number each.")
        y = far / self.unit
        square = y * y - self.push / self.crossing * size * size
        stable_side = -1.0 if self.stable_below else 1.0
        if square < 0 or (self.kind is HopfKind.HYPERBOLIC and y * stable_side <= 0):
            return None
        return float(stable_side * np.sqrt(square) * self.unit)


def hopf(
    family: str, *, contact: Contact, disk: Disk | None = None, points: int = 400
) -> list[HopfPoint]:
    """Every flutter boundary along a line of steady motions, with its type.

    Parameters
    ----------
    family
        spinning or tumbling.
    contact
        A law with friction; one number.
    disk
        The body, one number each; the uniform disk with m = R = g = 1 when left out.
    points
        Of the scan along the line; two boundaries between neighbours go unseen.

    Returns
    -------
    list of HopfPoint
        In increasing order of the family parameter; empty where there is none.

    Raises
    ------
    ParameterError
        If the family is no such line (rolling's boundary has two zeros beside its pair and is
        passed slowly instead: see `stability.drift`), or the law has no friction.

    Source: tests/test_hopf.py.

    Examples
    --------
    >>> from stability.contact import Viscous
    >>> [(p.kind.word, p.stable_below) for p in hopf("tumbling", contact=Viscous(0.9),
    ...                                              disk=Disk(k=0.375))]
    [('elliptic', True), ('hyperbolic', False)]
    """
    if not isinstance(family, str) or family not in SCAN:
        raise ParameterError(
            f"family is {shown(family)}; spinning and tumbling have such boundaries (rolling "
            "passes its own slowly, see drift)."
        )
    if not isinstance(contact, Contact) or type(contact).coefficient is None:
        raise ParameterError(f"contact is {shown(contact)}; a law with friction is needed.")
    if isinstance(points, bool) or not isinstance(points, (int, np.integer)) or points < 2:
        raise ParameterError(f"points is {shown(points)}; a whole number of at least 2 is needed.")
    body = Disk() if disk is None else disk
    question = disk_problem(family, body, contact, 1.0)
    for name, value in question.values.items():
        if np.ndim(value):
            raise ParameterError(f"{name} is an array; give one number.")
    unit = 1.0 if family == "tumbling" else float(np.asarray(body.rate))
    low, high = (v * unit if family == "spinning" else v for v in SCAN[family])
    found = along(question, "at", low, high, points=points, log=True)
    return [
        _point(question, float(p.value), p.frequency, p.stable_below, unit)
        for p in found
        if p.crossing is Crossing.FLUTTER
    ]


def _point(
    question: Problem, at: float, frequency: float, stable_below: bool, unit: float
) -> HopfPoint:
    values = dict(question.values) | {"at": at}
    a, q, _, _ = question.arrays(values)
    crossing, push, mode, error = normal_form(question.family, a[0], q[0])
    clear = abs(crossing) > error[0] and abs(push) > error[1]
    kind = HopfKind.ELLIPTIC if crossing * push < 0 else HopfKind.HYPERBOLIC
    return HopfPoint(
        at, kind if clear else HopfKind.DEGENERATE, stable_below, frequency, crossing, push, mode,
        unit,
    )  # fmt: skip


@lru_cache(maxsize=16)
def _second(family: Family) -> Program:
    """D²f[u, v] of a family's system, by automatic differentiation."""
    system = family.system
    u, v = ca.SX.sym("u", len(system.states)), ca.SX.sym("v", len(system.states))
    once = ca.jtimes(system.rhs, system.x, u)
    twice = ca.densify(ca.jtimes(once, system.x, v))
    return Program(ca.Function("second", [system.x, system.p, u, v], [twice]))


def normal_form(family: Family, a: Floats, q: Floats) -> tuple[float, float, Any, Floats]:
    """Coefficients of the Hopf bifurcation without parameters at a member.

    Parameters
    ----------
    family
        One of the disk's families, with one tangent.
    a, q
        Family parameter and parameters, dimensionless, shapes (1,) and (m,).

    Returns
    -------
    crossing, push, mode, error
        Re μ' per unit of the family parameter, c for the mode of unit length, the mode, and
        estimates of the rounding error of the two.
    """
    program = _second(family)
    state = family.member(a, q)
    matrix = family.system.linearise(state, q)

    def second(u: Any, v: Any) -> Any:
        parts = [
            program.arrays([list(state), list(q), list(x), list(y)], ())[0][:, 0]
            for x, y in ((u.real, v.real), (u.imag, v.imag), (u.real, v.imag), (u.imag, v.real))
        ]
        return parts[0] - parts[1] + 1j * (parts[2] + parts[3])

    u = family.solve(a[None, :], q[None, :])
    inputs = [columns(a[None, :]), columns(u), columns(q[None, :])]
    tangent = tangent_vectors(family, inputs, (1,))[0][0, :, 0].astype(complex)
    values, right = np.linalg.eig(matrix)
    left = np.linalg.inv(right)  # rows are left eigenvectors, scaled to the right ones
    zero = int(np.abs(values).argmin())
    pair = int(np.where(values.imag > 0, np.abs(values.real), np.inf).argmin())
    mode = right[:, pair] / np.linalg.norm(right[:, pair])
    along_line = left[zero] / (left[zero] @ tangent)
    moved = second(mode, mode.conj())
    push = complex(along_line @ moved)
    turned = second(tangent, right[:, pair])
    speed = complex(left[pair] @ turned)
    condition = np.linalg.cond(right) * np.finfo(float).eps * 64
    error = condition * np.array(
        [np.abs(left[pair]) @ np.abs(turned), np.abs(along_line) @ np.abs(moved)]
    )
    return speed.real, push.real, mode, error


def exact_side(family: str, law: str) -> Any:
    """The flutter polynomial and its derivative along the line, by which the type is exact.

    Energy rises with the family parameter along both lines and falls while the contact slips, so c
    is negative; the sign of Re μ' is minus that of the derivative of the condition.

    Parameters
    ----------
    family, law
        Names.

    Returns
    -------
    polynomial, derivative
        In the variables of `stability.exact`.
    """
    known = exact_polynomial(family, law)
    [flutter] = [p for kind, p in known.conditions if kind == "flutter"]
    return flutter, flutter.derivative(known.variables[-1])
