"""`spectrum`: from a family's name, a disk and a contact law to eigenvalues and a verdict."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .contact import Contact
from .disk import Disk
from .errors import ParameterError
from .families import Family
from .polynomial import structure
from .problem import Problem, disk_problem, system_problem
from .reduction import reduce
from .spectra import Spectrum, decide, eigenvalues
from .tracked import UNIT

SPEEDS = ("slip_x", "slip_y")


def problem(
    family: str | Family,
    at: ArrayLike | None,
    disk: Disk | None,
    contact: Contact | None,
    parameters: dict[str, Any],
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

    Returns
    -------
    Problem

    Raises
    ------
    StabilityError
        If they do not fit together.
    """
    if isinstance(family, Family):
        if disk is not None or contact is not None:
            raise ParameterError(
                f"disk and contact belong to the disk's families; {family.name} takes "
                f"{', '.join(family.parameters) or 'no parameters'}."
            )
        return system_problem(family, at, parameters)
    if parameters:
        raise ParameterError(
            f"{next(iter(parameters))!r} is not an argument here; the disk's numbers go in "
            "disk=Disk(...) and contact=Viscous(mu)."
        )
    if contact is None:
        raise ParameterError(
            "contact is missing; give Smooth(), Viscous(mu), LinearViscous(c) or Rough()."
        )
    return disk_problem(family, disk or Disk(), contact, at)


def spectrum(
    family: str | Family,
    *,
    at: ArrayLike,
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
    disk
        The body; the uniform disk with m = R = g = 1 when left out.
    contact
        The law.
    certify
        Not in this version: verdicts come from double precision with proved error discs.
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
    if certify:
        raise ParameterError(
            "certify is True, which this version does not offer for spectra; leave it out and read "
            "the error discs in .radius (boundaries are proved already)."
        )
    if at is None:
        raise ParameterError("at is missing; it names the member of the family.")
    question = problem(family, at, disk, contact, dict(parameters))
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
    return Spectrum(
        resolved,
        _shaped(np.column_stack(_given(question)).reshape(-1, len(resolved.at)), shape),
        _shaped(values * rate[:, None], shape),
        _shaped((radius + last * np.abs(values)) * rate[:, None], shape),
        structure(resolved).zeros,
        codes.reshape(shape),
        _shaped(states, shape),
        reduced,
        rate.reshape(shape),
        _shaped(scale, shape),
    )


def _given(question: Problem) -> list[Any]:
    keys = [n for n in ("at",) if n in question.values] or list(question.family.at)
    shape = np.broadcast_shapes(*(np.shape(v) for v in question.values.values()))
    return [np.broadcast_to(question.values[k], shape).reshape(-1) for k in keys]


def _shaped(rows: Any, shape: tuple[int, ...]) -> Any:
    return rows.reshape(*shape, *rows.shape[1:])
