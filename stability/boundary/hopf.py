"""Hopf bifurcation without parameters, where a line of steady motions loses stability by flutter.

At a flutter boundary of spinning and tumbling under friction one eigenvalue is zero by structure,
because the family is a line of steady motions.  A pair crosses the imaginary axis along that line.
Energy falls while the contact slips, so no limit cycle is born.  To leading order the distance y
along the line and the amplitude z of the pair obey

    dy/dt = c |z|²,   d|z|/dt = Re μ' y |z|,   so that  y² - (c / Re μ') |z|²  is constant.

Elliptic (c Re μ' < 0): a motion that starts next to the unstable part of the line swings out and
settles on the stable part, as far from the boundary as its start.  Hyperbolic (c Re μ' > 0): such a
motion leaves, and of the motions that start next to the stable part only those inside a cone
settle.

Source: B. Fiedler, S. Liebscher & J. C. Alexander, J. Differential Equations 167 (2000) 16-35;
tests/boundary/test_hopf.py compares with an independent derivation and with simulations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple, overload

import casadi as ca
import numpy as np
from flint import acb, acb_mat, arb, arb_mat

from ..algebra.balls import precision
from ..algebra.exact.number_fields import NotExact
from ..algebra.exact.real_roots import UnclearError
from ..algebra.number_types import balls
from ..algebra.program import Program
from ..algebra.upright import Upright
from ..base.axis import AxisLike
from ..base.checks import instance, whole_number
from ..base.citation import cited
from ..base.errors import ParameterError, StabilityError, listed, shown, warned
from ..bodies.contact import Contact
from ..bodies.contact_laws import LAWS, law_missing
from ..bodies.disk import Disk
from ..bodies.disk_polynomials import exact_polynomial
from ..bodies.families import FAMILIES, SteadyFamily
from ..bodies.law_names import law_only
from ..bodies.round_body.body import Body
from ..bodies.subject import of_body
from ..spectra.disk_problem import disk_problem
from ..spectra.problem import Problem
from ..systems.family import Family
from ..systems.structure.enclosure import ball_unknowns
from ..systems.system import refuse_system
from .beyond_linear.births import births
from .beyond_linear.records import CycleBirth
from .beyond_linear.records import HopfKind as HopfKind
from .beyond_linear.records import HopfPoint as HopfPoint
from .changes import along
from .crossings import Crossing
from .search import Mark, search

Balls = list[Any]

BITS = 256
"""Working precision of the first attempt."""
MOST_BITS = 4096
"""Highest precision; a sign that is still open there makes the point degenerate."""
MOST_POINTS = 100_000
"""Most points of the search."""


@overload
def hopf(
    family: str,
    *,
    contact: Contact | type[Contact] | str | None = None,
    disk: Disk | None = None,
    points: int = 400,
    **parameters: float,
) -> list[HopfPoint]: ...
@overload
def hopf(
    family: str, *, body: Body, contact: Contact | str, axis: AxisLike, **parameters: float
) -> list[CycleBirth] | list[HopfPoint]: ...
@overload
def hopf(
    family: Family, *, axis: AxisLike, **parameters: float
) -> list[CycleBirth] | list[HopfPoint]: ...
def hopf(
    family: str | Family,
    *,
    contact: Any = None,
    disk: Any = None,
    body: Any = None,
    points: Any = 400,
    axis: Any = None,
    **parameters: Any,
) -> list[CycleBirth] | list[HopfPoint]:
    """Every flutter boundary, with what begins there: soft or hard, elliptic or hyperbolic.

    For a user's family: the boundaries of `boundaries` along an axis.  Where its steady motions are
    isolated, each has its first Lyapunov coefficient with a proved bound.  Where the axis is a
    state in `at`, so that they are a line, each has the normal form of a line.  States on which
    nothing depends are left out first.

    For the disk the search is complete: every real root of the conditions over Q is isolated, along
    all of the line (phi_dot > 0; theta between 0 and upright, beyond which it is mirrored).  A
    user's law has no stored conditions.  Where its graph is not rational, part of the line is
    scanned, and a `StabilityWarning` says which part.

    Parameters
    ----------
    family
        A family of a user's system; or `spinning`, `tumbling`, or another family of the disk with
        `SteadyFamily.flutter`.
    contact
        For the disk: a law with friction, or the name or class of one with its parameters by name,
        such as `contact="viscous", mu=0.3`; each parameter is one number.
    disk
        The body, one number each; the uniform disk with m = R = g = 1 when left out.
    body
        A `Body` in place of the disk; its families by name need an axis.
    points
        For the disk: number of points of the scan, where one is needed.
    axis
        For a body and a user's family: (name, low, high, n) or (name, low, high, n, "log"), as for
        `boundaries`.
    **parameters
        For a user's family: every other quantity, one number each, or `at` as for `boundaries`; for
        the disk: the parameters of a law that is named.

    Returns
    -------
    list of CycleBirth or HopfPoint
        In increasing order of the axis; empty where there is none.

    Raises
    ------
    ParameterError
        If the family is conservative, or has structural zeros for another reason; for the disk if
        the family is no line, or the law has no friction.  (Rolling's boundary has two zeros and a
        pair, and is passed slowly instead: see `stability.drift`.)

    Warns
    -----
    StabilityWarning
        If the search for boundaries was not complete.

    Source: tests/boundary/test_hopf.py, test_hopf_any.py.

    Examples
    --------
    >>> import stability as st
    >>> [(p.kind.word, p.stable_below) for p in st.hopf("tumbling", contact=st.Viscous(0.9),
    ...                                                 disk=st.Disk(k=0.375))]
    [('elliptic', True), ('hyperbolic', False)]

    >>> import casadi as ca, stability as st
    >>> x, c = ca.SX.sym("x", 2), ca.SX.sym("c")
    >>> rates = ca.vertcat(x[1], -x[0] + (c - x[0] ** 2) * x[1])
    >>> oscillator = st.System("van der Pol", x, c, rates, states=("q", "v"), parameters=("c",))
    >>> rest = st.Family(oscillator, "rest", at=("c",), held={"q": 0, "v": 0})
    >>> [point] = st.hopf(rest, axis=("c", -1, 1, 9))
    >>> point.kind.word, point.coefficient, point.crossing
    ('soft', -0.25, 0.5)
    """
    refuse_system(family)
    if body is not None:
        family, disk, contact, parameters = of_body(family, body, disk, contact, parameters, [axis])
    if isinstance(family, Family):
        given = {"contact": contact, "disk": disk}
        for name, value in given.items():
            if value is not None:
                raise ParameterError(
                    f"{name} belongs to the disk; {family.name} takes axis and its parameters."
                )
        if axis is None:
            raise ParameterError(
                f"axis is missing; {family.name} needs (name, low, high, n), as for boundaries."
            )
        return births(family, axis, dict(parameters))
    if axis is not None or "at" in parameters:
        raise ParameterError(
            f"{'axis' if axis is not None else 'at'} belongs to a user's family; the disk's lines "
            "are searched throughout, with disk=Disk(...) and contact=Viscous(mu)."
        )
    record = FAMILIES.get(family) if isinstance(family, str) else None
    if record is None or record.flutter is None:
        lines = listed([name for name, one in FAMILIES.items() if one.flutter])
        raise ParameterError(
            f"family is {shown(family)}; {lines} have such boundaries (rolling passes its own "
            "slowly, see drift)."
        )
    contact = law_only(contact, dict(parameters))
    if contact is None:
        raise law_missing({n: law for n, law in LAWS.items() if law.parameters})
    if not isinstance(contact, Contact) or not contact.parameters:
        raise ParameterError(f"contact is {shown(contact)}; a law with friction is needed.")
    points = whole_number("points", points, 2, MOST_POINTS, "the search takes time for each")
    body = Disk() if disk is None else instance("disk", disk, Disk, "give a stability.Disk")
    problem = disk_problem(family, body, contact, 1.0)
    for name, value in problem.values.items():
        if np.ndim(value):
            raise ParameterError(f"{name} is an array; give one number.")
    works = cited(contact.name, model=True, proofs=True, theory=["fiedler2000"])
    unit = record.unit(float(np.asarray(body.rate)))
    bits = BITS
    while True:  # until the signs that decide the type are proved
        last = bits >= MOST_BITS
        try:
            with precision(bits):
                marks = _flutter(problem, record, bits, unit, points)
                found = [_point(problem, mark, unit) for mark in marks]
        except (StabilityError, UnclearError) as error:
            if last:
                raise StabilityError(str(error) or "the search needs too many digits.") from None
            found = None
        if last or (found is not None and all(p.kind is not HopfKind.DEGENERATE for p in found)):
            return [replace(point, citation=works) for point in found or []]
        bits *= 2


def _flutter(
    problem: Problem, record: SteadyFamily, bits: int, unit: float, points: int
) -> list[Mark]:
    """The flutter boundaries along the whole line, in balls."""
    try:
        marks = search(problem, "at", None, None, bits).marks
    except NotExact:
        return _scanned(problem, record, unit, points)
    except UnclearError:
        raise ParameterError(
            f"the boundaries of {problem.family.name} cannot be separated at these numbers; give "
            "values nearer to 1."
        ) from None
    end = arb.pi() / 2 if record.by_angle else arb("inf")
    return [m for m in marks if m.kind == "flutter" and m.below != m.above and 0 < m.value < end]


@lru_cache(maxsize=1)
def _scanned(problem: Problem, record: SteadyFamily, unit: float, points: int) -> list[Mark]:
    """The flutter boundaries along part of the line, bracketed between the points of a scan."""
    low, high = (v * unit for v in record.flutter or ())
    found = along(problem, "at", low, high, points=points)
    name = problem.family.name
    warned(
        f"{name} under this law has no stored conditions: it was scanned from {low:.6g} to "
        f"{high:.6g} at {points} points; two boundaries between two points are not excluded."
    )
    return [
        Mark(
            arb(b.value, b.error),
            "flutter",
            1 if b.stable_below else -1,
            -1 if b.stable_below else 1,
            arb(b.value, b.error),
        )
        for b in found
        if b.crossing is Crossing.FLUTTER
    ]


def _point(problem: Problem, mark: Mark, unit: float) -> HopfPoint:
    given = {n: arb(float(v)) for n, v in problem.values.items()} | {"at": mark.value}
    a, q, rate = problem.reduce(given, lambda v: v.sqrt())
    form = normal_form(problem.family, a, q)
    crossing, push = (float(v.mid()) for v in (form.crossing, form.push))
    clear = not form.crossing.contains(0) and not form.push.contains(0)
    kind = HopfKind.ELLIPTIC if crossing * push < 0 else HopfKind.HYPERBOLIC
    return HopfPoint(
        float(mark.value.mid()),
        kind if clear else HopfKind.DEGENERATE,
        mark.below > 0,
        float((form.frequency * rate).mid()),
        crossing,
        push,
        form.mode,
        unit,
    )


@lru_cache(maxsize=16)
def _second(family: Family) -> Program:
    """D²f[u, v] of a family's system, by automatic differentiation."""
    system = family.system
    u, v = ca.SX.sym("u", len(system.states)), ca.SX.sym("v", len(system.states))
    once = ca.jtimes(system.rhs, system.x, u)
    twice = ca.densify(ca.jtimes(once, system.x, v))
    return Program(ca.Function("second", [system.x, system.p, u, v], [twice]))


class NormalForm(NamedTuple):
    """Coefficients of a Hopf bifurcation without parameters, in balls around the exact ones."""

    crossing: Any
    """Re μ' per unit of the family parameter."""
    push: Any
    """c for the mode of unit length."""
    frequency: Any
    """|Im λ| of the pair."""
    mode: Any
    """The mode, complex, of unit length, its largest entry real; doubles."""


def normal_form(family: Family, a: Sequence[Any], q: Sequence[Any]) -> NormalForm:
    """Coefficients of the Hopf bifurcation without parameters at a member.

    Parameters
    ----------
    family
        One of the disk's families, with one tangent.
    a, q
        Family parameter and parameters, dimensionless: doubles, taken as exact, or balls.

    Returns
    -------
    NormalForm
        At the working precision.

    Raises
    ------
    StabilityError
        If two eigenvalues there coincide at the working precision.
    """
    program = _second(family)
    a, q = ([arb(v) for v in values] for values in (a, q))
    u = ball_unknowns(family, a, q)
    known = dict(zip((*family.at, *family.unknown), (*a, *u), strict=True))
    held = {n: arb.pi() / 2 if isinstance(v, Upright) else arb(v) for n, v in family.fixed.items()}
    state = [(known | held)[n] for n in family.system.states]
    matrix = acb_mat(arb_mat(family.graph.matrix.dense(balls(), [a, u, q])))
    try:
        values, left, right = matrix.eig(left=True, right=True)
    except ValueError:
        raise StabilityError(
            f"two eigenvalues of {family.name} at {float(a[0]):.10g} coincide; no normal form."
        ) from None
    size = len(values)
    zero = min(range(size), key=lambda i: float(abs(values[i]).mid()))
    upper = [i for i in range(size) if values[i].imag > 0]
    pair = min(upper, key=lambda i: abs(float(values[i].real.mid())))

    def second(x: Balls, y: Balls) -> Balls:
        out = []
        for p, r in ((x, y), (x, [-acb(0, 1) * v for v in y])):  # real, then imaginary part
            parts = [
                program.run(balls(), [state, q, [v.real for v in s], [v.real for v in t]])[0]
                for s, t in ((p, r), ([acb(0, 1) * v for v in p], [acb(0, 1) * v for v in r]))
            ]
            out.append([s - t for s, t in zip(*parts, strict=True)])
        return [acb(s, t) for s, t in zip(*out, strict=True)]

    tangent = [acb(v) for v in _tangent(family, a, u, q)]
    mode = [right[i, pair] for i in range(size)]
    biggest = max(mode, key=lambda v: float(abs(v).mid()))
    length = sum((abs(v) ** 2 for v in mode), arb(0)).sqrt()
    mode = [v / length * abs(biggest) / biggest for v in mode]
    across, along = ([left[i, j] for j in range(size)] for i in (zero, pair))
    push = _dot(across, second(mode, [v.conjugate() for v in mode])) / _dot(across, tangent)
    speed = _dot(along, second(tangent, mode)) / _dot(along, mode)
    plain = np.array([complex(float(v.real.mid()), float(v.imag.mid())) for v in mode])
    return NormalForm(speed.real, push.real, values[pair].imag, plain)


def _dot(x: Balls, y: Balls) -> Any:
    return sum((s * t for s, t in zip(x, y, strict=True)), acb(0))


def _tangent(family: Family, a: Balls, u: Balls, q: Balls) -> Balls:
    """The line's direction in the state, by the implicit function theorem."""
    by_a, by_u, _, r_u, r_a = (
        family.graph.tangent.dense(balls(), [a, u, q], output) for output in range(5)
    )
    if not u or family.closed:
        return [row[0] for row in by_a]
    turn = arb_mat(r_u).solve(arb_mat(r_a))
    return [
        row[0] - sum((c * turn[j, 0] for j, c in enumerate(by)), arb(0))
        for row, by in zip(by_a, by_u, strict=True)
    ]


def exact_side(family: str, law: str) -> Any:
    """The flutter polynomial and its derivative along the line, which decide the type exactly.

    Energy rises with the family parameter along both lines and falls while the contact slips, so c
    is negative.  The sign of Re μ' is minus that of the derivative of the condition.

    Parameters
    ----------
    family, law
        Names of the family and of the contact law.

    Returns
    -------
    polynomial, derivative
        In the variables of `stability.bodies.disk_polynomials`.
    """
    known = exact_polynomial(family, law)
    [flutter] = [p for kind, p in known.conditions if kind == "flutter"]
    return flutter, flutter.derivative(known.variables[-1])
