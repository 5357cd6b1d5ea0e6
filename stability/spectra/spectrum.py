"""`spectrum`: from a family's name, a disk and a contact law to eigenvalues and a verdict."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..algebra.eigensolver import chosen
from ..algebra.running_error import UNIT
from ..base.checks import flag
from ..base.errors import DomainError, NoMemberError, ParameterError, StabilityError
from ..base.types import Complexes, Floats
from ..base.verdict import CODES, Verdict
from ..bodies.contact_laws import Contact
from ..bodies.disk import Disk
from ..bodies.round_body.body import Body
from ..bodies.subject import subject_of
from ..polynomials.zero_blocks import semisimple
from ..systems.family import Family
from ..systems.graph.sides import on_sides, switches_at
from ..systems.sources.numeric import NumericSystem
from ..systems.structure.structural_zeros import structure
from .deflation import MemberNumbers, Reduced, drift_powers, drifting
from .eigenvalues import Eigenpairs, decide, eigenvalues
from .numeric import numeric_spectrum
from .problem import Problem, broadcast_shape, known_numbers, problem_of, through_switches
from .result import NOT_ASKED, Spectrum, SpectrumProof

if TYPE_CHECKING:
    from ..polynomials.member import Member
    from .certificate import Certificate


UNDECIDED = CODES[Verdict.UNDECIDED]
"""Flag value of that verdict."""
PIECE = 2**20
"""Largest number of linearisation entries in one piece, so that 80 MB are enough."""
MOST_VALUES = 10**8
"""Largest number of eigenvalues of one call, a result of 7 GB."""


class Rows:
    """The members of one call, and the number of zero eigenvalues left out of all their spectra.

    Parameters
    ----------
    problem
        Family with values in the user's units.
    exact
        Whether to prove the number of zeros at each member if it is not proved for the whole
        family.  If False, the eigenvalues left out are zero within their rounding.
    """

    def __init__(self, problem: Problem, *, exact: bool) -> None:
        from ..polynomials.identities import certain, symmetric

        self.problem, self.exact = problem, exact
        family = problem.family
        count = math.prod(broadcast_shape(problem.values))
        size = len(family.system.states)
        if count * size > MOST_VALUES:
            raise ParameterError(
                f"{count} spectra of {size} states are asked for; at most {MOST_VALUES:.0e} "
                "eigenvalues are kept in memory at once. Ask in pieces, or take stability_map or "
                "stream_map, which keep less of each."
            )
        a, q, rate, self.shape = problem.arrays(problem.values)
        self._step = max(1, PIECE // size**2)
        u = self._joined(len(a), lambda piece: (family.solve(a[piece], q[piece]),))[0]
        self.place = MemberNumbers(a, q, u, rate, tuple(problem.roundings))
        self.states: Floats = self._joined(
            len(a), lambda p: (family.checked_states(a[p], u[p], q[p]),)
        )[0]
        self.trimmed = {
            name: column.reshape(self.shape)
            for name, column in zip(family.unknown, u.T, strict=True)
            if name in family.trimmed
        }
        """Parameters that are solved for."""
        self.zeros = structure(family).zeros
        self.certain = problem.derived or certain(family)
        """Whether the number of zeros is proved at every member of the family."""
        declared = family.conservative and self.certain
        self.symmetric = declared or (not problem.derived and symmetric(family))
        """Whether the spectrum is proved symmetric under λ → -λ at every member."""
        self._members: dict[int, Member] = {}
        if not self.certain:
            self.zeros = min(self._proved_zeros() if exact else self._supported())

    def _joined(
        self, count: int, work: Callable[[slice], tuple[NDArray[Any], ...]]
    ) -> list[NDArray[Any]]:
        """Results of all pieces, joined array by array."""
        pieces = [work(slice(i, i + self._step)) for i in range(0, max(count, 1), self._step)]
        if len(pieces) == 1:
            return list(pieces[0])
        return [np.concatenate(parts) for parts in zip(*pieces, strict=True)]

    def _proved_zeros(self) -> Iterator[int]:
        from .verdict_routes import structural_zeros

        return (
            structural_zeros(self.member(row))
            for row in map(int, np.unique(self.firsts(np.arange(len(self.place.a)))))
        )

    def _supported(self) -> NDArray[np.intp]:
        """Number of eigenvalues of each member that are zero within their rounding."""

        def piece(rows: slice) -> tuple[NDArray[np.intp]]:
            return (self._reduced(rows, watch=True).supported,)

        return self._joined(len(self.place.a), piece)[0]

    def _reduced(self, rows: slice, *, watch: bool) -> Reduced:
        return self.place[rows].reduced(self.problem.family, self.zeros, watch=watch)

    def spectra(self) -> tuple[Complexes, Floats, NDArray[np.int8], Eigenpairs | None]:
        """Eigenvalues, error discs and flag values of the verdicts, dimensionless.

        Returns
        -------
        values, radius, codes
            Shapes (N, m), (N, m), (N,).
        pairs
            Eigenvectors; None where the values came from a formula, or for members in several
            pieces, to save memory.
        """
        even = self.symmetric
        pairs = None

        def piece(rows: slice) -> tuple[NDArray[Any], ...]:
            nonlocal pairs
            watch = self.exact and not self.certain
            reduced = self._reduced(rows, watch=watch)
            if watch:  # the zeros are proved; with wrong null vectors nothing is known of the rest
                reduced.error[reduced.supported < self.zeros] = np.inf
            values, radius, pairs = eigenvalues(reduced, even=even)
            return values, radius, decide(values, radius, even=even)

        values, radius, codes = self._joined(len(self.place.a), piece)
        if self.powers is not None:
            drifting(codes, self.powers)
        return values, radius, codes, pairs if len(self.place.a) <= self._step else None

    @cached_property
    def powers(self) -> NDArray[np.int8] | None:
        """Proved powers of time with which zeros let a disturbance grow; None if semisimple."""
        family, place = self.problem.family, self.place
        if self.problem.derived or semisimple(family, self.zeros):
            return None

        def piece(rows: slice) -> tuple[NDArray[np.int8]]:
            a, q, u = place.a[rows], place.q[rows], place.u[rows]
            return (drift_powers(family, a, q, u, self.zeros, place.roundings),)

        return self._joined(len(place.a), piece)[0]

    @property
    def note(self) -> str:
        """A sentence if these members have fewer structural zeros than typical ones, or empty."""
        usual = structure(self.problem.family).zeros
        if self.zeros >= usual:
            return ""
        return (
            f"{usual} eigenvalue{'s are' if usual != 1 else ' is'} 0 at all typical members of "
            f"{self.problem.family.name}, and left out; this member lies on another branch or is a "
            f"special one: {self.zeros or 'none'} is so here by structure, all others count"
        )

    @cached_property
    def _columns(self) -> dict[str, Floats]:
        """Each number of the members by name, shape (N,)."""
        arrays = np.broadcast_arrays(*self.problem.values.values())
        return dict(zip(self.problem.values, (v.reshape(-1) for v in arrays), strict=True))

    def values(self, row: int) -> dict[str, float]:
        """The numbers of one member by name."""
        return {n: float(column[row]) for n, column in self._columns.items()}

    def firsts(self, rows: NDArray[np.intp]) -> NDArray[np.intp]:
        """First row with the same numbers, bit for bit, for each given row: one proof for all."""
        columns = [column[rows] for column in self._columns.values()]
        bits = np.column_stack([*columns, self.place.u[rows]]).view(np.int64)
        _, first, inverse = np.unique(bits, axis=0, return_index=True, return_inverse=True)
        return rows[first][inverse.reshape(-1)]

    def member(self, row: int) -> Member:
        """A member of a user's family in exact numbers, built once."""
        from .verdict_routes import member_at

        if row not in self._members:
            values = self.values(row)
            self._members[row] = member_at(self.problem, values, self.place.u[row])
        return self._members[row]


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
    certify, escalate = flag("certify", certify), flag("escalate", escalate)
    subject = subject_of(
        family,
        at=at,
        lean=lean,
        disk=disk,
        body=body,
        contact=contact,
        parameters=parameters,
        whole=True,
    )
    problem = problem_of(subject)
    if isinstance(problem.family.system, NumericSystem):
        return numeric_spectrum(problem, certify=certify)
    try:
        return _of_problem(problem, certify=certify, escalate=escalate)
    except DomainError as error:
        if (smooth := through_switches(subject)) is not subject:
            return _of_problem(problem_of(smooth), certify=certify, escalate=escalate)
        raise DomainError(f"{str(error).removesuffix('.')}{_beside(problem)}.") from None


def _beside(problem: Problem) -> str:
    """The proved verdicts on the two sides of the switch on which a member lies, in words."""
    system = problem.family.system
    here = switches_at(system, known_numbers(problem.family, problem.values))
    if len(here) != 1:
        return ""
    from .certificate import verdict

    words = []
    for way in (-1, 1):
        sided = on_sides(system, dict(here), {here[0]: way})
        side = replace(problem, family=replace(problem.family, system=sided), exact=None)
        words.append(Verdict.UNDECIDED.word)
        with suppress(StabilityError, TypeError):
            words[-1] = verdict(side, problem.values).word
    name, place = here[0]
    return f"; next to {name} = {place:.12g} the verdict is {words[0]} below and {words[1]} above"


def _of_problem(problem: Problem, *, certify: bool, escalate: bool) -> Spectrum:
    """The spectrum of a problem with a graph."""
    rows = Rows(problem, exact=certify or escalate)
    resolved, shape, rate = problem.family, rows.shape, rows.place.rate
    # rounding of the product with the unit
    last = 0.0 if problem.plain or problem.dimensionless else 4 * UNIT
    names = resolved.system.states
    scale = np.ones((len(rate), len(names)))
    if not problem.plain:
        units = problem.units(problem.values)
        for index, name in enumerate(names):
            size = units.size(resolved.system.quantities[name].kind)
            scale[:, index] = np.broadcast_to(size, shape).reshape(-1)
    values, radius, codes, pairs = rows.spectra()
    with np.errstate(all="ignore"):  # a radius may overflow to infinity
        values, radius = values * rate[:, None], (radius + last * np.abs(values)) * rate[:, None]
    if not np.isfinite(values).all():
        raise DomainError("the eigenvalues overflow double precision; give values nearer to 1.")
    result = Spectrum(
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
        values=dict(problem.values) | rows.trimmed,
        law=problem.law,
        dimensionless=problem.dimensionless,
    )
    asked = np.full(len(rate), certify)
    if escalate:
        asked |= codes == UNDECIDED
    return proved(result, rows, asked, shape, escalated=not certify) if asked.any() else result


def proved(
    spectrum: Spectrum,
    rows: Rows,
    asked: NDArray[np.bool_],
    shape: tuple[int, ...],
    *,
    escalated: bool,
) -> Spectrum:
    """A spectrum with proved verdicts and eigenvalues at selected members.

    Parameters
    ----------
    spectrum
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
    flat = spectrum.eigenvalues.reshape(-1, spectrum.eigenvalues.shape[-1]).copy()
    radius = spectrum.radius.reshape(flat.shape).copy()
    error = np.asarray(spectrum.abscissa_error, dtype=float).reshape(-1).copy()
    codes, bits = spectrum.codes.reshape(-1).copy(), np.full(len(flat), NOT_ASKED, dtype=np.int64)
    powers = None if spectrum.power is None else spectrum.power.reshape(-1).copy()
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
        spectrum,
        eigenvalues=flat.reshape(spectrum.eigenvalues.shape),
        radius=radius.reshape(spectrum.radius.shape),
        codes=codes.reshape(shape),
        power=None if powers is None else powers.reshape(shape),
        proof=SpectrumProof(
            error.reshape(shape), bits.reshape(shape), escalated, spectrum.family.exact is not None
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
    named = {problem.family.meaning(n): v for n, v in values.items()}
    return [np.broadcast_to(named[k], shape).reshape(-1) for k in problem.family.at]


def _shaped(rows: Any, shape: tuple[int, ...]) -> Any:
    return rows.reshape(*shape, *rows.shape[1:])
