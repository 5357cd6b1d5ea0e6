"""`spectrum`: from a family's name, a disk and a contact law to eigenvalues and a verdict."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .contact import Contact
from .disk import Disk
from .errors import DomainError, ParameterError, shown
from .families import Family
from .polynomial import structure
from .problem import Problem, disk_problem, system_problem
from .reduction import reduce
from .spectra import Proof, Spectrum, decide, eigenvalues
from .tracked import UNIT

SPEEDS = ("slip_x", "slip_y")


def problem(
    family: str | Family,
    at: ArrayLike | None,
    disk: Disk | None,
    contact: Contact | None,
    parameters: dict[str, Any],
    lean: ArrayLike | None = None,
) -> Problem:
    """The question that the arguments of `spectrum` and `stability_map` ask.

    Parameters
    ----------
    family
        Name of a disk's family, or a family of a user's own system.
    at
        Family parameter, or None where it is an axis.
    disk, contact
        For the disk's families.
    parameters
        For a user's family.
    lean
        In place of `at` for tumbling.

    Returns
    -------
    Problem

    Raises
    ------
    StabilityError
        If they do not fit together.
    """
    if isinstance(family, Family):
        if lean is not None:
            raise ParameterError(f"lean belongs to the disk's tumbling; {family.name} takes at.")
        if disk is not None or contact is not None:
            raise ParameterError(
                f"disk and contact belong to the disk's families; {family.name} takes "
                f"{', '.join(family.parameters) or 'no parameters'}."
            )
        return system_problem(family, at, parameters)
    if parameters:
        raise ParameterError(
            f"{shown(next(iter(parameters)))} is not an argument here; the disk's numbers go in "
            "disk=Disk(...) and contact=Viscous(mu)."
        )
    if contact is None:
        raise ParameterError(
            "contact is missing; give Smooth(), Viscous(mu), LinearViscous(c) or Rough()."
        )
    return disk_problem(family, Disk() if disk is None else disk, contact, at, lean)


def spectrum(
    family: str | Family,
    *,
    at: ArrayLike | None = None,
    lean: ArrayLike | None = None,
    disk: Disk | None = None,
    contact: Contact | None = None,
    certify: bool = False,
    **parameters: ArrayLike,
) -> Spectrum:
    """Eigenvalues, modes and verdict of the linearisation at members of a family.

    Parameters
    ----------
    family
        `rolling`, `spinning`, `tumbling`, for the rough disk `circling`; or a `Family`.
    at
        What names the member: omega3 (rolling), phi_dot (spinning) [rad/s], theta (tumbling)
        [rad], the pair (theta, phi_dot) along the last axis (circling).  Arrays broadcast with the
        fields of disk and contact.
    lean
        In place of `at` for tumbling: π/2 - theta [rad], which is exactly upright at 0; no double
        theta is.
    disk
        The body; the uniform disk with m = R = g = 1 when left out.
    contact
        The law.
    certify
        Whether every verdict and eigenvalue is proved, in rational arithmetic or balls, so that a
        verdict is undecided only where the budget of precision ends.
    **parameters
        For a family of a user's system: its parameters by name.

    Returns
    -------
    Spectrum
        Leading axes as broadcast; the last axis is the mode.

    Raises
    ------
    ParameterError, NameUnknownError, NoMemberError
        One sentence that says what is wrong and what is accepted.

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
        raise ParameterError("at is missing; it names the member of the family.")
    if not isinstance(certify, bool):
        raise ParameterError(f"certify is {shown(certify)}; give True or False.")
    question = problem(family, at, disk, contact, dict(parameters), lean)
    a, q, rate, shape = question.arrays(question.values)
    resolved = question.family
    u = resolved.solve(a, q)
    states = resolved.checked_states(a, u, q)
    reduced = reduce(resolved, a, q, u, question.roundings)
    values, radius = eigenvalues(reduced, even=resolved.conservative)
    codes = decide(values, radius, even=resolved.conservative)
    last = 0.0 if question.dimensionless else 4 * UNIT  # of the product with the unit
    names = resolved.system.states
    scale = np.ones((len(a), len(names)))
    if question.law is not None:
        speed = np.broadcast_to(question.speed(question.values), shape).reshape(-1)
        for index, name in enumerate(names):
            unit = speed if name in SPEEDS else rate
            scale[:, index] = 1.0 if name == "theta" else unit
    with np.errstate(all="ignore"):  # a radius may overflow to one without bound
        values, radius = values * rate[:, None], (radius + last * np.abs(values)) * rate[:, None]
    if not np.isfinite(values).all():
        raise DomainError("the eigenvalues overflow double precision; give values nearer to 1.")
    found = Spectrum(
        resolved,
        _shaped(np.column_stack(_given(question)).reshape(-1, len(resolved.at)), shape),
        _shaped(values, shape),
        _shaped(radius, shape),
        structure(resolved).zeros,
        codes.reshape(shape),
        _shaped(states, shape),
        reduced,
        rate.reshape(shape),
        _shaped(scale, shape),
    )
    return proved(found, question, shape) if certify else found


def proved(found: Spectrum, question: Problem, shape: tuple[int, ...]) -> Spectrum:
    """A spectrum with every verdict and eigenvalue replaced by a proved one.

    Parameters
    ----------
    found
        From double precision; its modes are kept.
    question
        The question.
    shape
        Leading shape.

    Returns
    -------
    Spectrum
    """
    from .certify import certify as one

    values = {n: np.broadcast_to(v, shape).reshape(-1) for n, v in question.values.items()}
    flat = found.eigenvalues.reshape(-1, found.eigenvalues.shape[-1]).copy()
    radius, error = found.radius.reshape(flat.shape).copy(), np.empty(len(flat))
    codes, bits = np.empty(len(flat), dtype=np.int8), np.zeros(len(flat), dtype=np.int64)
    for row in range(len(flat)):
        certificate = one(question, {n: float(v[row]) for n, v in values.items()})
        codes[row], bits[row] = certificate.verdict.code, certificate.bits
        error[row] = certificate.abscissa_error
        if certificate.eigenvalues:
            flat[row], radius[row] = certificate.eigenvalues, certificate.radius
        else:  # the budget ended: the discs of double precision stand
            error[row] = (radius[row] + (flat[row].real - flat[row].real.max())).max()
    return replace(
        found, eigenvalues=flat.reshape(found.eigenvalues.shape),
        radius=radius.reshape(found.radius.shape), codes=codes.reshape(shape),
        proof=Proof(error.reshape(shape), bits.reshape(shape)),
    )  # fmt: skip


def _given(question: Problem) -> list[Any]:
    shape = np.broadcast_shapes(*(np.shape(v) for v in question.values.values()))
    values = dict(question.values)
    if "lean" in values:
        values["at"] = np.pi / 2 - np.asarray(values["lean"])
    keys = ["at"] if "at" in values else question.family.at
    return [np.broadcast_to(values[k], shape).reshape(-1) for k in keys]


def _shaped(rows: Any, shape: tuple[int, ...]) -> Any:
    return rows.reshape(*shape, *rows.shape[1:])
