"""`spectrum`: from a family's name, a disk and a contact law to eigenvalues and a verdict."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..algebra.eigensolver import chosen
from ..algebra.running_error import UNIT
from ..base.checks import flag
from ..base.errors import DomainError, NoMemberError, ParameterError
from ..base.verdict import CODES, Verdict
from ..bodies.contact import Contact
from ..bodies.disk import Disk
from ..bodies.families import FAMILIES, SteadyFamily
from ..bodies.quantities import QUANTITIES
from ..bodies.round_body.body import Body
from ..bodies.subject import of_body
from ..systems.family import Family
from ..systems.sources.numeric import NumericSystem
from .arguments import opened, problem_of
from .problem import Problem
from .result import NOT_ASKED, Proof, Spectrum
from .routes.numeric import numeric_spectrum
from .rows import Rows

if TYPE_CHECKING:
    from .certificate import Certificate


def spectrum(
    family: str | Family,
    *,
    at: ArrayLike | None = None,
    lean: ArrayLike | None = None,
    disk: Disk | None = None,
    body: Body | Disk | None = None,
    contact: Contact | type[Contact] | str | None = None,
    certify: bool = False,
    escalate: bool = True,
    **parameters: ArrayLike,
) -> Spectrum:
    """Eigenvalues, modes and verdict of the linearisation at members of a family.

    Parameters
    ----------
    family
        `rolling`, `spinning`, `tumbling`, for the rough disk `circling`, for the smooth one
        `precession`; or a `Family`.
    at
        Number that names the member: omega3 (rolling), phi_dot (spinning) [rad/s], theta (tumbling)
        [rad], the pair (theta, phi_dot) along the last axis (circling, precession).  Arrays
        broadcast with the fields of disk and contact.  Its own name does as well:
        `spectrum("rolling", omega3=1.2, …)`.
    lean
        Angle π/2 - theta [rad] instead of `at`, for tumbling.  0 is exactly upright; no double
        theta is.
    disk
        The disk; the uniform one with m = R = g = 1 when left out.
    body
        Any other body of revolution in place of the disk: a `Body`.  Its families are `rolling`,
        `spinning`, `tumbling`, `circling` and `precession`, with the same `at`, and `vertical`,
        named by omega_Z.  `theta=` and `pole=` choose one of several inclinations.
    contact
        The contact law; or its name or class, with its parameters by name: `contact="viscous",
        mu=0.3`.
    certify
        Whether to prove every verdict and eigenvalue, in rational arithmetic or balls.  A verdict
        is then undecided only where the budget of precision ends.
    escalate
        Whether to certify only the points that double precision leaves undecided; other points
        keep their error discs.  If False, these points stay undecided.
    **parameters
        Parameters by name, of a user's system, or of a contact law that is named.  Parameters that
        have the name of an argument, such as `at` or `contact`, go in a mapping:
        `parameters={"at": 2.0}`.

    Returns
    -------
    Spectrum
        Leading axes as broadcast; the last axis is the mode.

    Raises
    ------
    ParameterError, NameUnknownError, NoMemberError
        If an argument is not accepted; the message says what is accepted.

    Source: linearisation of the equations of Przybylska & Rauch-Wojciechowski 2016, recomputed.

    Examples
    --------
    >>> import stability as st
    >>> s = st.spectrum("rolling", at=1.2, contact=st.Viscous(0.3))
    >>> s.verdict.word
    'unstable'
    >>> s.eigenvalues.round(4).tolist()[0]
    (-1.7739+0j)
    """
    if at is None and lean is None:
        _check_named(family, parameters)
    certify, escalate = flag("certify", certify), flag("escalate", escalate)
    family, disk, contact, given = of_body(family, body, disk, contact, parameters)
    problem = problem_of(family, at, disk, contact, given, lean)
    if isinstance(problem.family.system, NumericSystem):
        return numeric_spectrum(problem, problem.family.system, certify=certify)
    rows = Rows(problem, exact=certify or escalate)
    resolved, shape, rate = problem.family, rows.shape, rows.place.rate
    last = 0.0 if problem.dimensionless else 4 * UNIT  # rounding of the product with the unit
    names = resolved.system.states
    scale = np.ones((len(rate), len(names)))
    if problem.law is not None:
        units = problem.units(problem.values)
        for index, name in enumerate(names):
            size = units.size(QUANTITIES[name].kind)
            scale[:, index] = np.broadcast_to(size, shape).reshape(-1)
    values, radius, codes, pairs = rows.spectra()
    with np.errstate(all="ignore"):  # a radius may overflow to infinity
        values, radius = values * rate[:, None], (radius + last * np.abs(values)) * rate[:, None]
    if not np.isfinite(values).all():
        raise DomainError("the eigenvalues overflow double precision; give values nearer to 1.")
    found = Spectrum(
        resolved,
        _shaped(np.array(_given(problem)).reshape(len(resolved.at), len(rate)).T, shape),
        _shaped(values, shape),
        _shaped(radius, shape),
        rows.zeros,
        codes.reshape(shape),
        _shaped(rows.states, shape),
        rows.place,
        rate.reshape(shape),
        _shaped(scale, shape),
        power=None if rows.powers is None else rows.powers.reshape(shape),
        note=rows.note,
        symmetric=rows.symmetric,
        pairs=pairs,
        solver=chosen(),
        values=dict(problem.values),
        law=problem.law,
        dimensionless=problem.dimensionless,
    )
    asked = np.full(len(rate), certify)
    if escalate:
        asked |= codes == CODES[Verdict.UNDECIDED]
    return proved(found, rows, asked, shape, escalated=not certify) if asked.any() else found


def _check_named(family: Any, parameters: Mapping[str, Any]) -> None:
    """Refuse a member without `at` that its own names do not give either."""
    known = FAMILIES.get(family) if isinstance(family, str) else family
    names = known.at if isinstance(known, (Family, SteadyFamily)) else ()
    if isinstance(known, Family) and not names:
        return  # a system without parameters: the member stands alone
    given = opened(known, parameters) if isinstance(known, Family) else parameters
    if names and set(names) <= set(given):
        return
    own = f", here {' and '.join(names)}" if names else ""
    raise ParameterError(f"at is missing; it names the member of the family{own}.")


def proved(
    found: Spectrum,
    rows: Rows,
    asked: NDArray[np.bool_],
    shape: tuple[int, ...],
    *,
    escalated: bool,
) -> Spectrum:
    """A spectrum with proved verdicts and eigenvalues at selected members.

    Parameters
    ----------
    found
        Spectrum from double precision; its modes stay.
    rows
        The members.
    asked
        Whether to certify each member, shape (N,).
    shape
        Leading shape of the spectrum.
    escalated
        Whether the proof is automatic: a member whose root is not proved to exist then stays
        undecided; otherwise such a member is an error.

    Returns
    -------
    Spectrum
    """
    flat = found.eigenvalues.reshape(-1, found.eigenvalues.shape[-1]).copy()
    radius = found.radius.reshape(flat.shape).copy()
    error = np.asarray(found.abscissa_error, dtype=float).reshape(-1).copy()
    codes, bits = found.codes.reshape(-1).copy(), np.full(len(flat), NOT_ASKED, dtype=np.int64)
    powers = None if found.power is None else found.power.reshape(-1).copy()
    seen: dict[int, Certificate | None] = {}
    where = np.flatnonzero(asked)
    for row, first in zip(where, rows.firsts(where), strict=True):
        if first not in seen:
            seen[first] = _certificate(rows, int(first), escalated=escalated)
        certificate = seen[first]
        if certificate is None:
            continue
        codes[row], bits[row] = certificate.verdict.code, certificate.bits
        if powers is not None and certificate.verdict is not Verdict.NEUTRAL:
            powers[row] = certificate.power
        if certificate.eigenvalues:
            error[row] = certificate.abscissa_error
            flat[row], radius[row] = certificate.eigenvalues, certificate.radius
    return replace(
        found,
        eigenvalues=flat.reshape(found.eigenvalues.shape),
        radius=radius.reshape(found.radius.shape),
        codes=codes.reshape(shape),
        power=None if powers is None else powers.reshape(shape),
        proof=Proof(
            error.reshape(shape), bits.reshape(shape), escalated, found.family.exact is not None
        ),
    )


def _certificate(rows: Rows, row: int, *, escalated: bool) -> Certificate | None:
    """The proof of one member; None where the proof is automatic and the root is not proved."""
    from .certificate import certify as one

    member = rows.member(row) if rows.problem.exact is None else None
    try:
        return one(rows.problem, rows.values(row), zeros=rows.zeros, member=member)
    except NoMemberError:
        if not escalated:
            raise
        return None


def _given(problem: Problem) -> list[Any]:
    shape = np.broadcast_shapes(*(np.shape(v) for v in problem.values.values()))
    values = dict(problem.values)
    if "lean" in values:
        values["at"] = np.pi / 2 - np.asarray(values["lean"])
    # a user's system may have a parameter called at
    keys = ["at"] if problem.law is not None and "at" in values else problem.family.at
    return [np.broadcast_to(values[k], shape).reshape(-1) for k in keys]


def _shaped(rows: Any, shape: tuple[int, ...]) -> Any:
    return rows.reshape(*shape, *rows.shape[1:])
