"""Settling of the disk: closed forms of its members, and their surroundings.

Near a family member the deviation e is five numbers that vanish on the family.  A state counts as
settled if its distance is within the limit and `stability.settling.attraction` proves, in ball
arithmetic, that the motion from there on converges to one member.  A slow passage near an unstable
member is not settling: nothing attracts there.  Stable rolling of a slipping disk drifts
(`stability.drift`), so no motion settles on it.  tests/settling/test_settling.py continues launches
from the state that counts as settled.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np

from ..algebra.kernels.tape import Tape, recorded
from ..algebra.number_types import Algebra, balls
from ..algebra.upright import UPRIGHT, Upright
from ..base.types import Floats
from ..bodies.contact import Contact
from ..bodies.families import AT_REST, FAMILIES, SteadyFamily, lines_under
from ..bodies.thin_disk.disk_equations import STATES, disk_system
from .attraction import Attraction, Surroundings
from .lines import line_surroundings
from .nearest import Nearest
from .proof import settles
from .together.kernel import Balls
from .together.many import RIGHT_ANGLE, NearestMany, nearest_many

TURNING = STATES.index("phi_dot")


@dataclass(frozen=True)
class DiskSettling:
    """Settling of the disk under a contact law."""

    law: type[Contact]
    """The law."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the families."""
        return tuple(family.name for family in lines_under(self.law.name))

    def nearest(self, state: Floats, p: Floats, within: float) -> Nearest:
        """As `nearest`."""
        return nearest(state, self.law, p, within)

    def closest(self, state: Floats, p: Floats) -> Nearest:
        """The steady motion nearest to a state, with its six states; settling is not tested."""
        family, at, distance = _closest(state, self.law, float(p[0]))
        where = f"nearest is {family} at {at:.6g}, {distance:.3g} away"
        if not math.isfinite(distance):
            return Nearest(family, 0.0, distance, False, 0.0, "no steady motion is near")
        sign = math.copysign(1.0, state[TURNING])
        member = FAMILIES[family].member(math, at, float(p[0]), sign)
        six = [math.pi / 2 if member[n] is UPRIGHT else float(member[n]) for n in STATES]
        return Nearest(family, at, distance, False, 0.0, where, np.array(six))

    def many(
        self, states: Floats, p: Floats, within: float | Floats, *, plain: bool = False
    ) -> NearestMany:
        """The nearest family of many states, and which have settled, as `nearest_many`."""
        places = [_Line(self.law, family) for family in lines_under(self.law.name)]
        return nearest_many(places, states, p, within, plain=plain)

    def distances(self, states: Floats, p: Floats, near: Nearest) -> Floats:
        """Distances of states, shape (t, 6), from the family of a nearest member, shape (t,)."""
        found: Floats = np.linalg.norm(deviation(states, float(p[0]), near.family)[1], axis=-1)
        return found


@dataclass(frozen=True)
class _Line:
    """A family of the disk, for many states."""

    law: type[Contact]
    family: SteadyFamily

    @property
    def name(self) -> str:
        """Name of the family."""
        return self.family.name

    @property
    def attracting(self) -> Surroundings | None:
        """Surroundings of the family; None where no motion settles on it."""
        if self.law.conservative or self.law.sticks or self.family.drifts:
            return None
        return surroundings(self.law, self.name)

    def near(self, states: Floats, p: Floats) -> tuple[Floats, Floats]:
        """As `Quick.near`."""
        at, parts = _parts(self.family, states.T, p[:, 0], np)
        return at[:, None], np.sqrt(sum(np.square(e) for e in parts))

    def place(self, states: Floats, p: Floats, *, plain: bool) -> tuple[Balls, Balls, Floats]:
        """As `Place.place`."""
        sign = np.copysign(1.0, states[:, TURNING])
        right = np.broadcast_to(RIGHT_ANGLE, (2, len(states)))
        mid = np.vstack([states.T, p[:, 0], sign, right[0]])
        rad = np.vstack([np.zeros_like(mid[:-1]), right[1]])
        m, r = _deviations(self.family).run(mid, rad, plain=plain)
        return Balls(m[:1].T, r[:1].T), Balls(m[1:].T, r[1:].T), np.column_stack([sign, p])


@lru_cache(maxsize=16)
def _deviations(family: SteadyFamily) -> Tape:
    """(six states, k, sign of φ̇, π/2) → at, then the five deviations."""

    def parts(a: list[Any], number: Algebra) -> list[Any]:
        six, (k, sign, right) = a[:6], a[6:]
        at, e = _parts(family, six, k, SimpleNamespace(**number.functions), sign, right)
        return [at, *e]

    return recorded(parts, 9)


def deviation(six: Floats, k: float | Floats, family: str) -> tuple[Floats, Floats]:
    """The member of a family that belongs to a state, and the deviation from it.

    Parameters
    ----------
    six
        States, shape (…, 6), dimensionless.
    k
        Inertia factor, shape () or (…).
    family
        Name of a family of the disk whose members one number names.

    Returns
    -------
    at, deviation
        Shapes (…) and (…, 5).

    Examples
    --------
    >>> at, e = deviation(np.array([math.pi / 2, 0, 2.5, 0, 0, 0]), 0.25, "spinning")
    >>> float(at), float(abs(e).max())
    (2.5, 0.0)
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        at, parts = _parts(FAMILIES[family], np.moveaxis(six, -1, 0), k, np)
    e = np.stack(parts, axis=-1)
    return at, np.where(np.isnan(e), np.inf, e)  # the distance of a missing member is infinite


def _parts(
    family: SteadyFamily, six: Any, k: Any, functions: Any, sign: Any = None,
    right_angle: Any = None,
) -> tuple[Any, list[Any]]:  # fmt: skip
    """The family's parameter and the five deviations, over any number type."""
    own, others, solved, upright = _places(family)
    at = six[own]
    e = [six[i] - value for i, value in others]
    if right_angle is not None and upright >= 0:
        e[upright] = six[others[upright][0]] - right_angle
    if family.solution is not None:
        sign = functions.copysign(1.0, six[TURNING]) if sign is None else sign
        e[solved] = six[others[solved][0]] - family.solution(functions, at, k, sign)
    return at, e


@lru_cache(maxsize=32)
def _places(family: SteadyFamily) -> tuple[int, list[tuple[int, float]], int, int]:
    """Index of the parameter among the states, and of the others with their values.

    Then the places among the others of the solved state and of the upright one, or -1.  Cached,
    because each launch needs them several times.
    """
    known = AT_REST | family.disk_held | family.disk_unknown
    own = STATES.index(family.at[0])
    names = [n for n in STATES if n != family.at[0]]
    values = [math.pi / 2 if isinstance(v := known[n], Upright) else float(v) for n in names]
    upright = next((j for j, n in enumerate(names) if isinstance(known[n], Upright)), -1)
    solved = next((j for j, n in enumerate(names) if n in family.disk_unknown), -1)
    return own, list(zip(map(STATES.index, names), values, strict=True)), solved, upright


def _closest(six: Floats, law: type[Contact], k: float) -> tuple[str, float, float]:
    """Family, parameter and distance of the nearest member, for one state."""
    found, states = [], six.tolist()
    for family in lines_under(law.name):
        try:
            at, e = _parts(family, states, k, math)
            found.append((math.hypot(*e), family.name, at))
        except (ValueError, ArithmeticError):  # the distance of a missing member is infinite
            found.append((math.inf, family.name, math.nan))
    distance, name, at = min(found)
    return name, at, distance


def nearest(six: Floats, law: type[Contact], p: Floats, within: float) -> Nearest:
    """The steady motion nearest to a state and whether the state counts as settled.

    Parameters
    ----------
    six
        The state, shape (6,), dimensionless.
    law
        Class of the contact law.
    p
        Parameters of the law's system.
    within
        Largest distance that counts as settled.

    Returns
    -------
    Nearest
    """
    family, at, distance = _closest(six, law, float(p[0]))
    where = f"nearest is {family} at {at:.6g}, {distance:.3g} away"
    if law.conservative:
        where += "; energy is kept, so nothing is settled on"
        return Nearest(family, at, distance, False, 0.0, where)
    if law.sticks:
        where += "; dry friction ends in sticking, which keeps energy and settles on nothing"
        return Nearest(family, at, distance, False, 0.0, where)
    if distance > within:
        return Nearest(family, at, distance, False, 0.0, where)
    if FAMILIES[family].drifts:
        why = f"{family} with slip drifts on its centre manifold (stability.drift): not settled"
        return Nearest(family, at, distance, False, 0.0, why)
    sign = math.copysign(1.0, six[2])
    y, e = _balls(six, float(p[0]), family, sign)
    found = settled(law, family, p, sign, y, e)
    if found is None:
        why = (
            f"{distance:.3g} from {family} at {at:.6g}; convergence to it is not proved from there"
        )
        return Nearest(family, at, distance, False, 0.0, why)
    why = (
        f"{distance:.3g} from {family} at {at:.6g}; proved in ball arithmetic: from there on the "
        f"motion converges to {family} at {found.limit[0]:.6g} within {found.error:.2g}, its "
        f"deviation falling at the rate {found.rate:.3g} at least"
    )
    return Nearest(family, at, distance, True, found.reach, why)


def _balls(six: Floats, k: float, family: str, sign: float) -> tuple[Any, list[Any]]:
    """The family's parameter and the deviation, as balls; the doubles are taken as exact."""
    from flint import arb

    exact, functions = [arb(v) for v in six.tolist()], SimpleNamespace(**balls().functions)
    at, e = _parts(FAMILIES[family], exact, k, functions, sign, arb.pi() / 2)
    return at, e


def settled(
    law: type[Contact], family: str, p: Floats, sign: float, y: Any, e: list[Any]
) -> Attraction | None:
    """A proof that a motion converges to one steady motion of the disk.

    Parameters
    ----------
    law, family
        As for `surroundings`.
    p
        Parameters of the law's system.
    sign
        Sign of φ̇.
    y, e
        Parameter of the nearest member and deviation, as balls that contain the true values.

    Returns
    -------
    Attraction or None
        None where the test fails.
    """
    around = surroundings(law, family)
    return settles(around, [sign, *p.tolist()], [y], e)


def surroundings(law: type[Contact], family: str) -> Surroundings:
    """Programs of (y, (sign, p), e) → ∂G/∂e and ∂g/∂e, and → gn, D and sinθ.

    Parameters
    ----------
    law
        A contact law with the slip in its state.
    family
        Name of a family whose members one number names.

    Returns
    -------
    Surroundings
    """
    return _surroundings(law, FAMILIES[family])  # type: ignore[arg-type]  # a class is hashable


@lru_cache(maxsize=16)
def _surroundings(law: type[Contact], family: SteadyFamily) -> Surroundings:
    system = disk_system(law)
    y, sign = ca.SX.sym("y"), ca.SX.sym("sign")
    member = family.member(ca, y, system.p[0], sign)
    seen = system.observables
    positive = ca.vertcat(seen["normal_force"], seen["determinant"], ca.sin(system.x[0]))
    given = ca.vertcat(sign, system.p)
    return line_surroundings(system, positive, family.at[0], member, y, given)
